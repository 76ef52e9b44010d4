// Bodies come in here: checked first, then copied, so that a refused call leaves everything as it was.
#include "scene/bodies.h"

#include "base/aabb.h"
#include "scene/vertex_input.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <float.h>
#include <math.h>
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

static void Include(const double p[3], double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = p[axis] < lower[axis] ? p[axis] : lower[axis];
        upper[axis] = p[axis] > upper[axis] ? p[axis] : upper[axis];
    }
}

static void EmptyBox(double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = DBL_MAX;
        upper[axis] = -DBL_MAX;
    }
}

/// Around all triangles as `positions` has them. A vertex that no triangle has would spoil the box, and the image with
/// it.
static void FindBounds(const qcBody* body, const double* positions, double lower[3], double upper[3])
{
    EmptyBox(lower, upper);
    if (body->used == NULL)
        qcBounds_Include(positions, body->vertexCount, lower, upper);
    for (uint32_t v = 0; v < body->vertexCount && body->used != NULL; v++)
        if (body->used[v])
            Include(positions + 3 * (size_t)v, lower, upper);
}

/// The box that holds what a box goes to. Each operation is monotone in each operand, so that the same operations on
/// the right ends bound what qcBody_GetVertex returns, roundings included. False: something overflows.
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

/// Sets the body's transform and its box; refused transforms leave the body as it was. O(1), but for those near the
/// end of all numbers.
static qcStatus Place(qcBody* body, uint32_t slot, const qcTransform* transform)
{
    qcBody placed = *body;
    placed.transform = *transform;
    placed.isIdentity = IsIdentity(transform);
    memcpy(placed.lower, body->localLower, sizeof placed.lower);
    memcpy(placed.upper, body->localUpper, sizeof placed.upper);
    bool hasBox = placed.lower[0] <= placed.upper[0], known = placed.isIdentity || placed.vertexCount == 0;
    double lower[3], upper[3];
    if (!known)
        known = TransformBox(body->vertexLower, body->vertexUpper, transform, lower, upper) &&
                (!hasBox || TransformBox(body->localLower, body->localUpper, transform, placed.lower, placed.upper));
    if (!known && hasBox)
        EmptyBox(placed.lower, placed.upper);
    for (uint32_t v = 0; v < placed.vertexCount && !known; v++)
    {
        double p[3];
        qcBody_GetVertex(&placed, v, p);
        if (!IsFinite(p))
            return qcFail(qc_statusBadInput, "the transform of body %u takes vertex %u beyond all finite numbers", slot,
                          v);
        if (placed.used == NULL || placed.used[v])
            Include(p, placed.lower, placed.upper);
    }
    *body = placed;
    return qc_statusOk;
}

static qcStatus FindUsed(qcBody* body)
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
    if (count != body->vertexCount)
        body->used = used;
    else
        qcFree(used, body->vertexCount);
    return qc_statusOk;
}

static void FreeBody(qcBody* body)
{
    qcFree(body->local, 3 * sizeof(double) * body->vertexCount);
    qcFree(body->world, 3 * sizeof(double) * body->vertexCount);
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

qcStatus qcBodies_Add(qcBodies* bodies, const qcBodyDef* def, qcBodyId* id)
{
    uint32_t slot = bodies->lowestFree;
    while (slot < bodies->slots.count && qcBody_IsUsed(&QC_AT(qcBody, bodies->slots, slot)))
        slot++;
    QC_TRY(CheckDef(def, slot));
    qcVertexInput source = {def->positions, def->positionType, def->positionStride, def->vertexCount};
    QC_TRY(qcVertexInput_Check(&source, slot));
    QC_TRY(qcArray_Reserve(&bodies->slots, slot + 1, sizeof(qcBody), "the list of bodies"));

    qcBody body = {.deforming = def->deforming,
                   .selfCollision = def->selfCollision,
                   .activity = def->activity,
                   .group = def->group,
                   .mask = def->mask,
                   .owner = def->owner,
                   .margin = def->margin,
                   .transform = def->deforming ? qcIdentityTransform() : def->transform,
                   .vertexCount = def->vertexCount,
                   .triangleCount = def->triangleCount};
    QC_TRY(AllocateBody(&body));
    double* positions = body.deforming ? body.world : body.local;
    qcVertexInput_Read(&source, positions);
    if (body.triangleCount != 0)
        memcpy(body.indices, def->indices, 3 * sizeof(uint32_t) * body.triangleCount);
    qcStatus status = FindUsed(&body);
    if (status == qc_statusOk)
    {
        FindBounds(&body, positions, body.localLower, body.localUpper);
        EmptyBox(body.vertexLower, body.vertexUpper);
        qcBounds_Include(positions, body.vertexCount, body.vertexLower, body.vertexUpper);
        status = Place(&body, slot, &body.transform);
    }
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

qcStatus qcBodies_SetVertices(qcBodies* bodies, uint32_t slot, const void* positions, qcPositionType type,
                              size_t stride)
{
    qcBody* body = &QC_AT(qcBody, bodies->slots, slot);
    qcVertexInput source = {positions, type, stride, body->vertexCount};
    QC_TRY(qcVertexInput_Check(&source, slot));
    qcVertexInput_Read(&source, body->world);
    FindBounds(body, body->world, body->lower, body->upper);
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
}
