// Positions on the device: set from a buffer, and read back as far as the CPU needs them.
#include "pipeline/vertex_buffers.h"

#include "base/definition.h"
#include "base/status.h"
#include "gl/buffers/vertex_snapshot.h"
#include "scene/float_positions.h"

#include <assert.h>
#include <string.h>

enum
{
    qc_positionBytes = 3 * sizeof(float)
};

static qcStatus CheckDef(const qcVertexBufferDef* def, uint32_t stride)
{
    const char* function = "qcScene_SetVertexBuffer";
    if (stride < qc_positionBytes || stride % 4 != 0)
        return qcFail(qc_statusBadInput, "%s: def->stride is %u; it must be a multiple of 4, at least 12", function,
                      stride);
    if (def->offset % 4 != 0)
        return qcFail(qc_statusBadInput, "%s: def->offset is %llu; it must be a multiple of 4", function,
                      (unsigned long long)def->offset);
    return qc_statusOk;
}

qcStatus qcVertexBuffers_Set(qcBodies* bodies, uint32_t slot, qcDevice* device, const qcVertexBufferDef* given)
{
    qcBody* body = &QC_AT(qcBody, bodies->slots, slot);
    qcVertexBufferDef def = qcDefaultVertexBufferDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT("qcScene_SetVertexBuffer", qcVertexBufferDef, stride), &def));
    uint32_t stride = def.stride != 0 ? def.stride : qc_positionBytes;
    QC_TRY(qcDeviceBuffer_Check(def.buffer, device, "qcScene_SetVertexBuffer"));
    QC_TRY(CheckDef(&def, stride));
    if (body->snapshot == NULL)
        QC_TRY(qcVertexSnapshot_Create(device, body->vertexCount, &body->snapshot));
    uint64_t bytes = body->vertexCount == 0 ? 0 : (uint64_t)(body->vertexCount - 1) * stride + qc_positionBytes;
    const qcSnapshotSource source = {.range = {def.buffer, def.offset, bytes},
                                     .stride = stride,
                                     .fence = def.fence,
                                     .used = body->used,
                                     .slot = slot};
    float lower[3], upper[3];
    QC_TRY(qcVertexSnapshot_Copy(body->snapshot, &source, lower, upper));
    qcBodies_MoveOnDevice(bodies, slot, lower, upper);
    return qc_statusOk;
}

void qcVertexBuffers_Leave(qcBody* body)
{
    if (body->snapshot != NULL)
        body->snapshot->active = false;
}

void qcVertexBuffers_Release(qcBody* body)
{
    qcVertexSnapshot_Destroy(body->snapshot);
    body->snapshot = NULL;
}

bool qcVertexBuffers_SufficeFor(const qcStep* step)
{
    qcMethod method = step->plan.method;
    bool readsNoOthers = method == qc_methodAuto || method == qc_methodLayers || method == qc_methodSweep;
    return readsNoOthers && step->def->contactMargin == 0.0 && !step->def->manifolds && !step->def->motion;
}

//  ---- whole bodies ------------------------------------------------------------------------------------------------

/// Reads positions back that are on the device alone.
static qcStatus ReadBack(const qcBody* body, uint32_t slot, uint64_t* bytes)
{
    qcVertexSnapshot* snapshot = body->snapshot;
    if (!qcVertexSnapshot_IsOnlyCopy(snapshot))
        return qc_statusOk;
    QC_TRY(qcVertexSnapshot_CheckAlive(snapshot, slot));
    size_t size = (size_t)body->vertexCount * qc_positionBytes;
    float* positions = qcAllocate(size);
    if (positions == NULL && size != 0)
        return qcFailMemory(size, "positions from the device");
    assert(positions != NULL || body->vertexCount == 0);
    qcStatus status = qcVertexSnapshot_Read(snapshot, positions);
    for (size_t i = 0; i < 3 * (size_t)body->vertexCount && status == qc_statusOk; i++)
        body->world[i] = (double)positions[i];
    qcFree(positions, size);
    QC_TRY(status);
    snapshot->complete = true;
    *bytes += size;
    return qc_statusOk;
}

qcStatus qcVertexBuffers_Complete(const qcBody* body, uint32_t slot, uint64_t* bytes)
{
    qcFloatPositions_Leave(body);
    return ReadBack(body, slot, bytes);
}

qcStatus qcVertexBuffers_CompleteAll(const qcBodies* bodies, uint64_t* bytes)
{
    for (uint32_t slot = 0; slot < bodies->slots.count; slot++)
        QC_TRY(qcVertexBuffers_Complete(&QC_AT(qcBody, bodies->slots, slot), slot, bytes));
    return qc_statusOk;
}

/// Whether the sweep of a body reads floats. Verlet lists don't, which distances above 0 make.
static bool ReadsFloats(const qcStep* step, const qcBody* body)
{
    return qcVertexBuffers_SufficeFor(step) && (step->queryDistance == 0.0 || !qcBody_HasSelfCollision(body));
}

qcStatus qcVertexBuffers_CompleteOthers(const qcStep* step, const qcStepTriangles* triangles, const uint8_t* onDevice,
                                        uint64_t* bytes)
{
    for (uint32_t i = 0; i < triangles->bodyCount; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, i);
        if (onDevice[i])
            continue;
        QC_TRY((ReadsFloats(step, body) ? ReadBack : qcVertexBuffers_Complete)(body, qcStepTriangles_Slot(triangles, i),
                                                                               bytes));
    }
    return qc_statusOk;
}

//  ---- floats ------------------------------------------------------------------------------------------------------

void qcVertexBuffers_LeaveFloats(const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                                 const uint8_t* handledElsewhere)
{
    for (uint32_t i = 0; i < triangles->bodyCount; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, i);
        if (!handledElsewhere[i] && (QC_AT(uint32_t, pairs->partnerCounts, i) != 0 || qcBody_HasSelfCollision(body)))
            qcFloatPositions_Leave(body);
    }
}

qcStatus qcVertexBuffers_KeepFloats(const qcStep* step, const qcStepTriangles* triangles,
                                    const qcIslandRouting* routing, bool follows, qcBodies* bodies)
{
    for (uint32_t i = 0; i < triangles->bodyCount; i++)
    {
        qcBody* body = &QC_AT(qcBody, bodies->slots, qcStepTriangles_Slot(triangles, i));
        bool sweeps = QC_AT(uint8_t, routing->handledElsewhere, i) && ReadsFloats(step, body);
        bool mayFollow = follows && qcBody_HasSelfCollision(body);
        if (QC_AT(uint8_t, routing->onDevice, i) || (sweeps && !mayFollow))
            QC_TRY(qcFloatPositions_Keep(body));
    }
    return qc_statusOk;
}

//  ---- triangles of candidates -------------------------------------------------------------------------------------

typedef struct Listing
{
    const qcStepTriangles* triangles;
    qcVertexBuffers* buffers;
} Listing;

/// Lists the triangle's vertices that are not listed yet, if they are on the device alone.
static qcStatus ListTriangle(const Listing* l, uint32_t global)
{
    uint32_t index = qcStepTriangles_BodyOf(l->triangles, global);
    const qcBody* body = qcStepTriangles_Body(l->triangles, index);
    qcVertexSnapshot* snapshot = body->snapshot;
    if (!qcVertexSnapshot_IsOnlyCopy(snapshot))
        return qc_statusOk;
    const uint32_t* corners = body->indices + 3 * (size_t)(global - qcStepTriangles_First(l->triangles, index));
    qcArray* items = &l->buffers->items;
    QC_TRY(qcArray_Reserve(items, items->count + 3, sizeof(qcSortItem), "vertices to read"));
    for (int c = 0; c < 3; c++)
    {
        uint32_t* mark = &QC_AT(uint32_t, snapshot->marks, corners[c]);
        if (*mark != snapshot->listNumber)
            QC_AT(qcSortItem, *items, items->count++) = (qcSortItem){(uint64_t)index << 32 | corners[c], 0};
        *mark = snapshot->listNumber;
    }
    return qc_statusOk;
}

static qcStatus ListPair(const Listing* l, uint64_t key)
{
    QC_TRY(ListTriangle(l, (uint32_t)(key >> 32)));
    return ListTriangle(l, (uint32_t)key);
}

/// Prepares the bodies with positions on the device alone. `*any`: there are some.
static qcStatus BeginLists(const qcStepTriangles* triangles, bool* any)
{
    *any = false;
    for (uint32_t i = 0; i < triangles->bodyCount; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, i);
        qcVertexSnapshot* snapshot = body->snapshot;
        if (!qcVertexSnapshot_IsOnlyCopy(snapshot))
            continue;
        QC_TRY(qcArray_GrowZeroed(&snapshot->marks, body->vertexCount, sizeof(uint32_t), "marks of vertices"));
        snapshot->listNumber++;
        *any = true;
    }
    return qc_statusOk;
}

/// The list, sorted, as vertices and parts.
static qcStatus MakeParts(const qcStepTriangles* triangles, qcVertexBuffers* b)
{
    const qcSortItem* items = b->items.data;
    size_t count = b->items.count;
    QC_TRY(qcArray_Resize(&b->vertices, count, sizeof(uint32_t), "vertices to read"));
    QC_TRY(qcArray_Resize(&b->positions, count, qc_positionBytes, "positions from the device"));
    b->parts.count = 0;
    for (size_t i = 0; i < count; i++)
    {
        QC_AT(uint32_t, b->vertices, i) = (uint32_t)items[i].key;
        if (i == 0 || items[i].key >> 32 != items[i - 1].key >> 32)
        {
            const qcBody* body = qcStepTriangles_Body(triangles, (uint32_t)(items[i].key >> 32));
            QC_TRY(qcArray_Reserve(&b->parts, b->parts.count + 1, sizeof(qcSnapshotPart), "bodies to read"));
            QC_AT(qcSnapshotPart, b->parts, b->parts.count++) = (qcSnapshotPart){body->snapshot, i, 0};
        }
        QC_AT(qcSnapshotPart, b->parts, b->parts.count - 1).count++;
    }
    return qc_statusOk;
}

qcStatus qcVertexBuffers_Gather(const qcStep* step, const qcStepTriangles* triangles, const qcCandidates* candidates,
                                qcVertexBuffers* b, qcProfile* profile)
{
    const Listing listing = {triangles, b};
    bool any, listsClassified = step->def->segments || step->def->proximities;
    b->items.count = 0;
    QC_TRY(BeginLists(triangles, &any));
    for (size_t i = 0; any && i < candidates->keys.count; i++)
        QC_TRY(ListPair(&listing, QC_AT(uint64_t, candidates->keys, i)));
    for (size_t i = 0; any && listsClassified && i < candidates->classified.count; i++)
        QC_TRY(ListPair(&listing, qcRelatedPair_Key(QC_AT(uint64_t, candidates->classified, i))));
    if (b->items.count == 0)
        return qc_statusOk;
    QC_TRY(qcSort_Items(b->items.data, b->items.count, &b->scratch));
    QC_TRY(MakeParts(triangles, b));
    QC_TRY(qcVertexSnapshots_Gather(step->device, b->parts.data, b->parts.count, b->vertices.data, b->vertices.count,
                                    b->positions.data));
    for (size_t i = 0; i < b->items.count; i++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, (uint32_t)(QC_AT(qcSortItem, b->items, i).key >> 32));
        double* world = body->world + 3 * (size_t)QC_AT(uint32_t, b->vertices, i);
        for (int axis = 0; axis < 3; axis++)
            world[axis] = (double)QC_AT(float, b->positions, 3 * i + (size_t)axis);
    }
    profile->readBackBytes += b->items.count * qc_positionBytes;
    profile->uploadedBytes += b->items.count * sizeof(uint32_t);
    return qc_statusOk;
}

void qcVertexBuffers_Free(qcVertexBuffers* b)
{
    qcArray* arrays[] = {&b->items, &b->scratch, &b->vertices, &b->parts, &b->positions};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
