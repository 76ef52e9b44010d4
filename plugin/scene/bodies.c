// Input is checked first, then copied: a refused call changes nothing.
#include "scene/bodies.h"

#include "base/aabb.h"
#include "base/parallel_for.h"
#include "base/status.h"
#include "scene/float_positions.h"
#include "scene/vertex_input.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>
#include <string.h>

static bool IsFinite(const double p[3])
{
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

static qcStatus CheckTransform(uint32_t slot, const qcTransform* transform)
{
    for (int i = 0; i < 9; i++)
        if (!isfinite(transform->linear[i]))
            return qcFail(qc_statusBadInput, "transform of body %u: linear[%d] is not finite", slot, i);
    for (int i = 0; i < 3; i++)
        if (!isfinite(transform->translation[i]))
            return qcFail(qc_statusBadInput, "transform of body %u: translation[%d] is not finite", slot, i);
    return qc_statusOk;
}

static bool IsIdentity(const qcTransform* t)
{
    qcTransform identity = qcIdentityTransform();
    for (int i = 0; i < 9; i++)
        if (t->linear[i] != identity.linear[i])
            return false;
    return t->translation[0] == 0.0 && t->translation[1] == 0.0 && t->translation[2] == 0.0;
}

/// Positions of all vertices of a body: one of them, the other is null.
typedef struct Positions
{
    const double* doubles;
    const float* floats;
} Positions;

/// Extends a box by triangles at these positions, from vertex `first` on. Vertices without a triangle are left out:
/// they would enlarge the box and the image. They are few: between them lie runs of the others.
static void IncludeVertices(const qcBody* body, Positions positions, size_t first, size_t count, double lower[3],
                            double upper[3])
{
    const uint8_t* used = body->used;
    for (size_t v = first, end = first + count; v < end;)
    {
        if (used != NULL && !used[v])
        {
            v++;
            continue;
        }
        const uint8_t* unused = used != NULL ? memchr(used + v, 0, end - v) : NULL;
        size_t runEnd = unused != NULL ? (size_t)(unused - used) : end;
        if (positions.floats != NULL)
            qcBounds_IncludeFloats(positions.floats + 3 * v, runEnd - v, lower, upper);
        else
            qcBounds_Include(positions.doubles + 3 * v, runEnd - v, lower, upper);
        v = runEnd;
    }
}

/// A box around a transformed box. Each operation is monotone in each operand: the same operations on the matching ends
/// bound what qcBody_GetVertex returns, roundings included. False: an end overflows.
static bool TransformBox(const double lower[3], const double upper[3], const qcTransform* t, double lowerOut[3],
                         double upperOut[3])
{
    bool finite = true;
    for (int axis = 0; axis < 3; axis++)
    {
        double low[3], high[3];
        for (int k = 0; k < 3; k++)
        {
            double a = t->linear[3 * axis + k] * lower[k], b = t->linear[3 * axis + k] * upper[k];
            low[k] = a < b ? a : b;
            high[k] = a < b ? b : a;
        }
        lowerOut[axis] = low[0] + low[1] + low[2] + t->translation[axis];
        upperOut[axis] = high[0] + high[1] + high[2] + t->translation[axis];
        finite = finite && isfinite(lowerOut[axis]) && isfinite(upperOut[axis]);
    }
    return finite;
}

/// Before the first move since the mark: the present becomes the start.
static void DepartFromStart(qcBody* body)
{
    qcBodyStart* start = &body->start;
    if (!start->isMarked || start->differs)
        return;
    start->differs = true;
    start->transform = body->transform;
    start->isIdentity = body->isIdentity;
    memcpy(start->lower, body->lower, sizeof start->lower);
    memcpy(start->upper, body->upper, sizeof start->upper);
    start->moved = body->moved;
    if (body->deforming)
    {
        double* world = body->world;
        body->world = start->world;
        start->world = world;
    }
}

/// Sets the body's transform and its box; a refused transform changes nothing. O(1); O(vertices) where the transformed
/// box overflows.
static qcStatus Place(qcBody* body, uint32_t slot, const qcTransform* transform)
{
    qcBody placed = *body;
    placed.transform = *transform;
    placed.isIdentity = IsIdentity(transform);
    memcpy(placed.lower, body->localLower, sizeof placed.lower);
    memcpy(placed.upper, body->localUpper, sizeof placed.upper);
    bool hasBox = placed.lower[0] <= placed.upper[0], isBounded = placed.isIdentity || placed.vertexCount == 0;
    double lower[3], upper[3];
    if (!isBounded)
        isBounded =
            TransformBox(body->vertexLower, body->vertexUpper, transform, lower, upper) &&
            (!hasBox || TransformBox(body->localLower, body->localUpper, transform, placed.lower, placed.upper));
    if (!isBounded && hasBox)
        qcBounds_Clear(placed.lower, placed.upper);
    for (uint32_t v = 0; v < placed.vertexCount && !isBounded; v++)
    {
        double p[3];
        qcBody_GetVertex(&placed, v, p);
        if (!IsFinite(p))
            return qcFail(qc_statusBadInput, "the transform of body %u takes vertex %u beyond all finite numbers", slot,
                          v);
        if (placed.used == NULL || placed.used[v])
            qcBounds_IncludePoint(p, placed.lower, placed.upper);
    }
    DepartFromStart(body);
    placed.start = body->start;
    *body = placed;
    return qc_statusOk;
}

static qcStatus FindUsed(qcBody* body)
{
    uint8_t* used = qcAllocateZeroed(body->vertexCount);
    if (used == NULL && body->vertexCount != 0)
        return qcFailMemory(body->vertexCount, "marking vertices");
    assert(used != NULL || body->triangleCount == 0);
    size_t count = 0;
    for (size_t i = 0; i < 3 * (size_t)body->triangleCount; i++)
    {
        count += !used[body->indices[i]];
        used[body->indices[i]] = 1;
    }
    if (count != body->vertexCount)
        body->used = used;
    else
        qcFree(used, body->vertexCount);
    return qc_statusOk;
}

static void FreeBody(qcBody* body)
{
    qcFloatPositions_Free(body);
    qcFree(body->local, 3 * sizeof(double) * body->vertexCount);
    qcFree(body->world, 3 * sizeof(double) * body->vertexCount);
    qcFree(body->start.world, 3 * sizeof(double) * body->vertexCount);
    qcFree(body->indices, 3 * sizeof(uint32_t) * body->triangleCount);
    qcFree(body->used, body->vertexCount);
    qcFree(body->owned, sizeof(qcOwnedFeatures) * body->triangleCount);
    uint32_t generation = body->generation;
    *body = (qcBody){.generation = generation};
}

static qcStatus CheckDef(const qcBodyDef* def, uint32_t slot)
{
    if (def->indices == NULL && def->triangleCount != 0)
        return qcFail(qc_statusBadInput, "body %u: indices is null", slot);
    if (def->activity != qc_activityMoving && def->activity != qc_activitySleeping &&
        def->activity != qc_activityStatic)
        return qcFail(qc_statusBadInput, "body %u: unknown activity %d", slot, (int)def->activity);
    if (!(def->margin >= 0.0))
        return qcFail(qc_statusBadInput, "body %u: the margin is %g; it must be 0 or more", slot, def->margin);
    for (uint32_t t = 0; t < def->triangleCount; t++)
        for (size_t c = 0; c < 3; c++)
            if (def->indices[3 * (size_t)t + c] >= def->vertexCount)
                return qcFail(qc_statusBadInput,
                              "triangle %u of body %u: corner %zu has index %u, but there are %u vertices", t, slot, c,
                              def->indices[3 * (size_t)t + c], def->vertexCount);
    return CheckTransform(slot, &def->transform);
}

/// Allocates the new body's arrays, all or none.
static qcStatus AllocateBody(qcBody* body)
{
    const uint64_t needed = UINT64_C(3) * sizeof(double) * body->vertexCount;
    const uint64_t neededIndices = UINT64_C(3) * sizeof(uint32_t) * body->triangleCount;
    // Where addresses have 32 bits sizes would wrap around.
    if (needed > SIZE_MAX / 2 || neededIndices > SIZE_MAX / 2)
        return qcFailMemory(SIZE_MAX, "a body");
    const size_t positionBytes = (size_t)needed, indexBytes = (size_t)neededIndices;
    double** positions = body->deforming ? &body->world : &body->local;
    *positions = qcAllocate(positionBytes);
    body->indices = qcAllocate(indexBytes);
    bool missing =
        (body->vertexCount != 0 && *positions == NULL) || (body->triangleCount != 0 && body->indices == NULL);
    if (!missing)
        return qc_statusOk;
    FreeBody(body);
    return qcFailMemory(positionBytes + indexBytes, "a body");
}

/// Fills the new body from the definition, which has been checked; on failure nothing is left.
static qcStatus MakeBody(const qcBodyDef* def, const qcVertexInput* source, uint32_t slot, qcBody* body)
{
    *body = (qcBody){.deforming = def->deforming,
                     .hasFloats = def->positionType == qc_positionF32,
                     .selfCollision = def->selfCollision,
                     .activity = def->activity,
                     .group = def->group,
                     .mask = def->mask,
                     .owner = def->owner,
                     .margin = def->margin,
                     .transform = def->deforming ? qcIdentityTransform() : def->transform,
                     .vertexCount = def->vertexCount,
                     .triangleCount = def->triangleCount};
    QC_TRY(AllocateBody(body));
    double* positions = body->deforming ? body->world : body->local;
    qcVertexInput_Read(source, positions);
    if (body->triangleCount != 0)
        memcpy(body->indices, def->indices, 3 * sizeof(uint32_t) * body->triangleCount);
    qcStatus status = FindUsed(body);
    if (status == qc_statusOk)
    {
        qcBounds_Clear(body->localLower, body->localUpper);
        IncludeVertices(body, (Positions){positions, NULL}, 0, body->vertexCount, body->localLower, body->localUpper);
        qcBounds_Clear(body->vertexLower, body->vertexUpper);
        qcBounds_Include(positions, body->vertexCount, body->vertexLower, body->vertexUpper);
        status = Place(body, slot, &body->transform);
    }
    if (status != qc_statusOk)
        FreeBody(body);
    return status;
}

qcStatus qcBodies_Add(qcBodies* bodies, const qcBodyDef* def, qcBodyId* id)
{
    uint32_t slot = bodies->lowestFree;
    while (slot < bodies->slots.count && !qcBody_IsFree(&QC_AT(qcBody, bodies->slots, slot)))
        slot++;
    QC_TRY(CheckDef(def, slot));
    const qcVertexInput source = {def->positions, def->positionType, def->positionStride, def->vertexCount};
    QC_TRY(qcVertexInput_Check(&source, slot, 1));
    qcBody body;
    QC_TRY(MakeBody(def, &source, slot, &body));
    // Last: a body that is refused takes no memory.
    qcStatus status = qcArray_Reserve(&bodies->slots, slot + 1, sizeof(qcBody), "the list of bodies");
    if (status != qc_statusOk)
    {
        FreeBody(&body);
        return status;
    }
    if (slot == bodies->slots.count)
    {
        bodies->slots.count++;
        QC_AT(qcBody, bodies->slots, slot).generation = 0;
    }
    body.generation = QC_AT(qcBody, bodies->slots, slot).generation + 1;
    body.moved = bodies->added = ++bodies->revision;
    QC_AT(qcBody, bodies->slots, slot) = body;
    bodies->lowestFree = slot + 1;
    bodies->count++;
    *id = (qcBodyId){slot, body.generation};
    return qc_statusOk;
}

qcBody* qcBodies_Find(const qcBodies* bodies, qcBodyId id, const char* caller)
{
    if (id.slot < bodies->slots.count && (id.generation & 1) != 0)
    {
        qcBody* body = &QC_AT(qcBody, bodies->slots, id.slot);
        if (body->generation == id.generation)
            return body;
    }
    qcFail(qc_statusBadInput, "%s: there is no body with slot %u and generation %u", caller, id.slot, id.generation);
    return NULL;
}

void qcBodies_Remove(qcBodies* bodies, qcBodyId id)
{
    qcBody* body = &QC_AT(qcBody, bodies->slots, id.slot);
    FreeBody(body);
    body->generation++;
    bodies->count--;
    if (id.slot < bodies->lowestFree)
        bodies->lowestFree = id.slot;
    bodies->added = ++bodies->revision;
}

qcStatus qcBodies_SetTransform(qcBodies* bodies, uint32_t slot, const qcTransform* transform)
{
    qcBody* body = &QC_AT(qcBody, bodies->slots, slot);
    QC_TRY(CheckTransform(slot, transform));
    QC_TRY(Place(body, slot, transform));
    body->moved = ++bodies->revision;
    return qc_statusOk;
}

/// The box of the vertices that a worker has read; workers share no cache line.
typedef struct WorkerBox
{
    _Alignas(64) double lower[3];
    double upper[3];
} WorkerBox;

typedef struct Reading
{
    const qcBody* body;
    const qcVertexInput* source;
    float* floats; ///< null: positions become doubles, and have been checked
    atomic_bool failed;
    WorkerBox boxes[qc_maxWorkers];
} Reading;

static void ReadBlock(void* context, size_t block, uint32_t worker)
{
    Reading* reading = context;
    const qcBody* body = reading->body;
    const qcVertexInput part = qcVertexInput_Block(reading->source, block);
    const size_t first = block * qc_inputBlock;
    WorkerBox *box = &reading->boxes[worker], unused;
    qcBounds_Clear(unused.lower, unused.upper);
    if (reading->floats == NULL)
        qcVertexInput_Read(&part, body->world + 3 * first);
    else
    {
        WorkerBox* ofAll = body->used == NULL ? box : &unused;
        if (!qcVertexInput_ReadFloats(&part, reading->floats + 3 * first, ofAll->lower, ofAll->upper))
            atomic_store(&reading->failed, true);
    }
    if (reading->floats == NULL || body->used != NULL)
        IncludeVertices(body, (Positions){body->world, reading->floats}, first, part.count, box->lower, box->upper);
}

/// Reads positions as floats or, where `floats` is null, checked ones into body->world, and finds their box. False: a
/// float isn't finite.
static bool ReadVertices(const qcBody* body, const qcVertexInput* source, uint32_t threads, float* floats,
                         double lower[3], double upper[3])
{
    Reading reading;
    reading.body = body;
    reading.source = source;
    reading.floats = floats;
    atomic_init(&reading.failed, false);
    for (uint32_t i = 0; i < threads; i++)
        qcBounds_Clear(reading.boxes[i].lower, reading.boxes[i].upper);
    qcParallel_For(threads, qcVertexInput_BlockCount(source), qc_minInputBlocks, ReadBlock, &reading);
    qcBounds_Clear(lower, upper);
    for (uint32_t i = 0; i < threads; i++)
        qcBounds_IncludeBox(reading.boxes[i].lower, reading.boxes[i].upper, lower, upper);
    return !atomic_load(&reading.failed);
}

/// Reads positions into doubles: they are checked first, since they overwrite the present ones.
static qcStatus SetDoubles(qcBody* body, uint32_t slot, const qcVertexInput* source, uint32_t threads)
{
    QC_TRY(qcVertexInput_Check(source, slot, threads));
    DepartFromStart(body);
    if (body->floats != NULL)
        body->floats->newest = false;
    (void)ReadVertices(body, source, threads, NULL, body->lower, body->upper);
    return qc_statusOk;
}

/// Reads positions as floats, in one pass.
static qcStatus SetFloats(qcBody* body, uint32_t slot, const qcVertexInput* source, uint32_t threads)
{
    double lower[3], upper[3];
    QC_TRY(qcVertexInput_CheckLayout(source, slot));
    if (!ReadVertices(body, source, threads, body->floats->spare, lower, upper))
        return qcVertexInput_FailNotFinite(source, slot);
    DepartFromStart(body);
    qcFloatPositions_Replace(body);
    memcpy(body->lower, lower, sizeof body->lower);
    memcpy(body->upper, upper, sizeof body->upper);
    return qc_statusOk;
}

qcStatus qcBodies_SetVertices(qcBodies* bodies, uint32_t slot, const void* positions, qcPositionType type,
                              size_t stride)
{
    qcBody* body = &QC_AT(qcBody, bodies->slots, slot);
    uint32_t threads = bodies->threads != 0 ? qcParallel_Threads(bodies->threads) : 1;
    qcVertexInput source = {positions, type, stride, body->vertexCount};
    bool keepsFloats = type == qc_positionF32 && body->floats != NULL && body->floats->kept;
    qcParallel_Wake(threads);
    QC_TRY((keepsFloats ? SetFloats : SetDoubles)(body, slot, &source, threads));
    body->hasFloats = type == qc_positionF32;
    body->moved = ++bodies->revision;
    return qc_statusOk;
}

void qcBodies_MoveOnDevice(qcBodies* bodies, uint32_t slot, const float lower[3], const float upper[3])
{
    qcBody* body = &QC_AT(qcBody, bodies->slots, slot);
    bool departs = body->start.isMarked && !body->start.differs;
    DepartFromStart(body);
    // The buffer that took the place of `world` may hold no numbers at all.
    if (departs && body->vertexCount != 0)
        memcpy(body->world, body->start.world, 3 * sizeof(double) * body->vertexCount);
    qcBounds_Clear(body->lower, body->upper);
    for (int axis = 0; axis < 3 && lower[0] <= upper[0]; axis++)
    {
        body->lower[axis] = (double)lower[axis];
        body->upper[axis] = (double)upper[axis];
    }
    body->hasFloats = true;
    if (body->floats != NULL)
        body->floats->newest = false;
    body->moved = ++bodies->revision;
}

qcStatus qcBodies_MarkStart(qcBodies* bodies)
{
    for (size_t i = 0; i < bodies->slots.count; i++)
    {
        qcBody* body = &QC_AT(qcBody, bodies->slots, i);
        size_t bytes = 3 * sizeof(double) * body->vertexCount;
        if (!qcBody_IsUsed(body) || !body->deforming || bytes == 0 || body->start.world != NULL)
            continue;
        body->start.world = qcAllocate(bytes);
        if (body->start.world == NULL)
            return qcFailMemory(bytes, "positions at the start");
    }
    for (size_t i = 0; i < bodies->slots.count; i++)
    {
        qcBody* body = &QC_AT(qcBody, bodies->slots, i);
        body->start.isMarked = qcBody_IsUsed(body);
        body->start.differs = false;
    }
    bodies->revision++;
    return qc_statusOk;
}

void qcBodies_Free(qcBodies* bodies)
{
    for (size_t i = 0; i < bodies->slots.count; i++)
        FreeBody(&QC_AT(qcBody, bodies->slots, i));
    qcArray_Free(&bodies->slots);
}
