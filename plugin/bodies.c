// Bodies come in here: checked first, then copied, so that a refused call leaves everything as it was.
#include "bodies.h"

#include "sort.h"
#include "status.h"

#include <float.h>
#include <math.h>
#include <string.h>

static size_t PositionSize(qcPositionType type)
{
    return type == qc_positionF64 ? 3 * sizeof(double) : 3 * sizeof(float);
}

static bool IsFinite(const double p[3])
{
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

/// Positions as doubles. Returns 0, or something that is not a number if one isn't finite: 0 * x, added up.
static double ReadFloats(const void* positions, size_t stride, size_t vertexCount, double* out)
{
    double check[3] = {0.0, 0.0, 0.0};
    for (size_t v = 0; v < vertexCount; v++)
    {
        float x[3];
        memcpy(x, (const char*)positions + stride * v, sizeof x);
        for (int axis = 0; axis < 3; axis++)
        {
            out[3 * v + axis] = (double)x[axis];
            check[axis] += 0.0 * (double)x[axis];
        }
    }
    return check[0] + check[1] + check[2];
}

static double ReadDoubles(const void* positions, size_t stride, size_t vertexCount, double* out)
{
    double check[3] = {0.0, 0.0, 0.0};
    for (size_t v = 0; v < vertexCount; v++)
    {
        double x[3];
        memcpy(x, (const char*)positions + stride * v, sizeof x);
        for (int axis = 0; axis < 3; axis++)
        {
            out[3 * v + axis] = x[axis];
            check[axis] += 0.0 * x[axis];
        }
    }
    return check[0] + check[1] + check[2];
}

/// Reads positions into scratch. Nothing else is changed.
static qcStatus ReadPositions(qcBodies* bodies, uint32_t slot, const void* positions, qcPositionType type,
                              size_t stride, uint32_t vertexCount)
{
    if (type != qc_positionF32 && type != qc_positionF64)
        return qcFail(qc_statusBadInput, "body %u: unknown position type %d", slot, (int)type);
    if (positions == NULL && vertexCount != 0)
        return qcFail(qc_statusBadInput, "body %u: positions is null", slot);
    if (stride == 0)
        stride = PositionSize(type);
    if (stride < PositionSize(type))
        return qcFail(qc_statusBadInput, "body %u: a stride of %zu bytes is less than a position's %zu", slot, stride,
                      PositionSize(type));
    QC_TRY(qcArray_Resize(&bodies->scratch, 3 * (size_t)vertexCount, sizeof(double), "new positions"));
    double* out = bodies->scratch.data;
    double check = type == qc_positionF64 ? ReadDoubles(positions, stride, vertexCount, out)
                                          : ReadFloats(positions, stride, vertexCount, out);
    for (uint32_t v = 0; v < vertexCount && check != 0.0; v++)
        if (!IsFinite(out + 3 * (size_t)v))
            return qcFail(qc_statusBadInput, "vertex %u of body %u is not finite", v, slot);
    return qc_statusOk;
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

/// Local positions to world positions; the two may be the same memory.
static qcStatus Transform(uint32_t slot, const double* local, uint32_t vertexCount, const qcTransform* t, double* world)
{
    if (IsIdentity(t))
    {
        // Not by multiplication: 0 * x would lose the sign of a zero, and time. Null is no array, not even an empty
        // one.
        if (vertexCount != 0)
            memmove(world, local, 3 * sizeof(double) * vertexCount);
        return qc_statusOk;
    }
    for (uint32_t v = 0; v < vertexCount; v++)
    {
        const double* p = local + 3 * (size_t)v;
        double q[3];
        for (int axis = 0; axis < 3; axis++)
        {
            const double* row = t->linear + 3 * axis;
            q[axis] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + t->translation[axis];
        }
        if (!IsFinite(q))
            return qcFail(qc_statusBadInput, "the transform of body %u takes vertex %u beyond all finite numbers", slot,
                          v);
        memcpy(world + 3 * (size_t)v, q, sizeof q);
    }
    return qc_statusOk;
}

enum
{
    qc_boundsRun = 12 ///< numbers: four vertices
};

/// Least and greatest of each coordinate, four vertices side by side.
static void FindBoundsOfVertices(const double* x, size_t vertexCount, double lower[3], double upper[3])
{
    double least[qc_boundsRun], most[qc_boundsRun];
    size_t count = 3 * vertexCount, i = 0;
    for (int k = 0; k < qc_boundsRun; k++)
    {
        least[k] = DBL_MAX;
        most[k] = -DBL_MAX;
    }
    for (; i + qc_boundsRun <= count; i += qc_boundsRun)
        for (int k = 0; k < qc_boundsRun; k++)
        {
            least[k] = x[i + k] < least[k] ? x[i + k] : least[k];
            most[k] = x[i + k] > most[k] ? x[i + k] : most[k];
        }
    for (int k = 0; i < count; i++, k++)
    {
        least[k] = x[i] < least[k] ? x[i] : least[k];
        most[k] = x[i] > most[k] ? x[i] : most[k];
    }
    for (int k = 0; k < qc_boundsRun; k++)
    {
        lower[k % 3] = least[k] < lower[k % 3] ? least[k] : lower[k % 3];
        upper[k % 3] = most[k] > upper[k % 3] ? most[k] : upper[k % 3];
    }
}

static void FindBounds(qcBody* body)
{
    for (int axis = 0; axis < 3; axis++)
    {
        body->lower[axis] = DBL_MAX;
        body->upper[axis] = -DBL_MAX;
    }
    // Vertices are fewer than corners, but one that no triangle has would spoil the box, and the image with it.
    if (body->allUsed)
        FindBoundsOfVertices(body->world, body->vertexCount, body->lower, body->upper);
    for (size_t i = 0; i < 3 * (size_t)body->triangleCount && !body->allUsed; i++)
        FindBoundsOfVertices(body->world + 3 * (size_t)body->indices[i], 1, body->lower, body->upper);
}

static qcStatus FindUnused(qcBody* body)
{
    uint8_t* used = qcAllocateZeroed(body->vertexCount);
    if (used == NULL && body->vertexCount != 0)
        return qcFailMemory(body->vertexCount, "marking vertices");
    size_t count = 0;
    for (size_t i = 0; i < 3 * (size_t)body->triangleCount; i++)
    {
        count += !used[body->indices[i]];
        used[body->indices[i]] = 1;
    }
    body->allUsed = count == body->vertexCount;
    qcFree(used, body->vertexCount);
    return qc_statusOk;
}

static void FreeBody(qcBody* body)
{
    qcFree(body->local, 3 * sizeof(double) * body->vertexCount);
    qcFree(body->world, 3 * sizeof(double) * body->vertexCount);
    qcFree(body->indices, 3 * sizeof(uint32_t) * body->triangleCount);
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
    for (uint32_t t = 0; t < def->triangleCount; t++)
        for (int c = 0; c < 3; c++)
            if (def->indices[3 * (size_t)t + c] >= def->vertexCount)
                return qcFail(qc_statusBadInput,
                              "triangle %u of body %u: corner %d has index %u, but there are %u vertices", t, slot, c,
                              def->indices[3 * (size_t)t + c], def->vertexCount);
    return CheckTransform(slot, &def->transform);
}

/// The new body's own memory, all or nothing.
static qcStatus AllocateBody(qcBody* body)
{
    size_t positionBytes = 3 * sizeof(double) * body->vertexCount,
           indexBytes = 3 * sizeof(uint32_t) * body->triangleCount;
    body->world = qcAllocate(positionBytes);
    body->indices = qcAllocate(indexBytes);
    if (!body->deforming)
        body->local = qcAllocate(positionBytes);
    bool missing = (body->vertexCount != 0 && (body->world == NULL || (!body->deforming && body->local == NULL))) ||
                   (body->triangleCount != 0 && body->indices == NULL);
    if (!missing)
        return qc_statusOk;
    FreeBody(body);
    return qcFailMemory(2 * positionBytes + indexBytes, "a body");
}

qcStatus qcBodies_Add(qcBodies* bodies, const qcBodyDef* def, qcBodyId* id)
{
    uint32_t slot = bodies->lowestFree;
    while (slot < bodies->slots.count && qcBody_IsUsed(&QC_AT(qcBody, bodies->slots, slot)))
        slot++;
    QC_TRY(CheckDef(def, slot));
    QC_TRY(ReadPositions(bodies, slot, def->positions, def->positionType, def->positionStride, def->vertexCount));
    QC_TRY(qcArray_Reserve(&bodies->slots, slot + 1, sizeof(qcBody), "the list of bodies"));

    qcBody body = {.deforming = def->deforming,
                   .selfCollision = def->selfCollision,
                   .activity = def->activity,
                   .group = def->group,
                   .mask = def->mask,
                   .transform = def->deforming ? qcIdentityTransform() : def->transform,
                   .vertexCount = def->vertexCount,
                   .triangleCount = def->triangleCount};
    QC_TRY(AllocateBody(&body));
    const double* read = bodies->scratch.data;
    size_t positionBytes = 3 * sizeof(double) * body.vertexCount;
    if (body.vertexCount != 0 && !body.deforming)
        memcpy(body.local, read, positionBytes);
    qcTransform identity = qcIdentityTransform();
    qcStatus status = Transform(slot, read, body.vertexCount, body.deforming ? &identity : &def->transform, body.world);
    if (body.triangleCount != 0)
        memcpy(body.indices, def->indices, 3 * sizeof(uint32_t) * body.triangleCount);
    if (status == qc_statusOk)
        status = FindUnused(&body);
    if (status != qc_statusOk)
    {
        FreeBody(&body);
        return status;
    }
    FindBounds(&body);

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
    QC_TRY(qcArray_Resize(&bodies->scratch, 3 * (size_t)body->vertexCount, sizeof(double), "new positions"));
    QC_TRY(Transform(slot, body->local, body->vertexCount, transform, bodies->scratch.data));
    if (body->vertexCount != 0)
        memcpy(body->world, bodies->scratch.data, 3 * sizeof(double) * body->vertexCount);
    body->transform = *transform;
    FindBounds(body);
    body->moved = ++bodies->revision;
    return qc_statusOk;
}

qcStatus qcBodies_SetVertices(qcBodies* bodies, uint32_t slot, const void* positions, qcPositionType type,
                              size_t stride)
{
    qcBody* body = &QC_AT(qcBody, bodies->slots, slot);
    QC_TRY(ReadPositions(bodies, slot, positions, type, stride, body->vertexCount));
    if (body->vertexCount != 0)
        memcpy(body->world, bodies->scratch.data, 3 * sizeof(double) * body->vertexCount);
    FindBounds(body);
    body->moved = ++bodies->revision;
    return qc_statusOk;
}

qcStatus qcBody_FindOwners(qcBody* body, qcArray* scratch)
{
    size_t edgeCount = 3 * (size_t)body->triangleCount;
    if (body->owned != NULL || edgeCount == 0)
        return qc_statusOk;
    qcArray items = {0};
    qcOwnedFeatures* owned = qcAllocateZeroed(body->triangleCount);
    uint8_t* seen = qcAllocateZeroed(body->vertexCount);
    qcStatus status = owned == NULL || seen == NULL ? qcFailMemory(body->triangleCount, "owners of features")
                                                    : qcArray_Resize(&items, edgeCount, sizeof(qcSortItem), "edges");
    if (status == qc_statusOk)
    {
        qcSortItem* edges = items.data;
        for (size_t i = 0; i < edgeCount; i++)
        {
            uint32_t a = body->indices[i], b = body->indices[i % 3 == 2 ? i - 2 : i + 1];
            edges[i] = (qcSortItem){a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a, i};
            if (!seen[a])
                owned[i / 3] |= (qcOwnedFeatures)(1u << i % 3);
            seen[a] = 1;
        }
        status = qcSort_Items(edges, edgeCount, scratch);
        if (status == qc_statusOk)
            for (size_t i = 0; i < edgeCount; i++)
            {
                bool first = i == 0 || edges[i].key != edges[i - 1].key;
                bool isEdge = (uint32_t)edges[i].key != (uint32_t)(edges[i].key >> 32);
                if (first && isEdge)
                    owned[edges[i].value / 3] |= (qcOwnedFeatures)(8u << edges[i].value % 3);
            }
    }
    if (status == qc_statusOk)
        body->owned = owned;
    else
        qcFree(owned, body->triangleCount);
    qcFree(seen, body->vertexCount);
    qcArray_Free(&items);
    return status;
}

void qcBodies_Free(qcBodies* bodies)
{
    for (size_t i = 0; i < bodies->slots.count; i++)
        FreeBody(&QC_AT(qcBody, bodies->slots, i));
    qcArray_Free(&bodies->slots);
    qcArray_Free(&bodies->scratch);
}
