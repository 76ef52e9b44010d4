// Assigns ranges of the device's buffers, stages data and plans uploads.
// Proof of the bounds on vertex errors (pointError): plugin/docs/proofs/layers_vertices.md.
#include "cull/layers/gpu_residency.h"

#include "base/aabb.h"
#include "base/parallel_for.h"
#include "base/status.h"
#include "cull/layers/grid_resolution.h"
#include "gl/buffers/vertex_snapshot.h"
#include "scene/float_positions.h"

#include <math.h>
#include <string.h>

enum
{
    // The smallest float is 2^-126. A device may flush smaller ones to zero: in a frame whose unit is no smaller than
    // this exponent of two, that is below 2^-26.
    qc_minWorldExponent = -100,
    // 65536 vertices take about 50 microseconds.
    qc_vertexBlock = 4096,
    qc_minBlocks = 16
};

typedef struct Vertex
{
    float x[3];
    uint32_t body;
} Vertex;

typedef struct Prepare
{
    qcGpuResidency* residency;
    const qcResidencyJob* job;
} Prepare;

static qcBodyResidency* BodyAt(const qcGpuResidency* residency, uint32_t slot)
{
    return &QC_AT(qcBodyResidency, residency->bodies, slot);
}

static size_t PaddedVertices(const qcBody* body)
{
    return ((size_t)body->vertexCount + qc_layersChunkSize - 1) / qc_layersChunkSize * qc_layersChunkSize;
}

/// The number of elements of each input buffer that a body needs.
static void FindNeeds(const qcGpuResidency* residency, const qcBody* body, const qcClusters* clusters,
                      size_t needs[qc_layersInputCount])
{
    memset(needs, 0, qc_layersInputCount * sizeof needs[0]);
    needs[qc_layersVertices] = needs[qc_layersLocals] = PaddedVertices(body);
    needs[qc_layersTriangles] = (size_t)clusters->nodeCount * qc_nodeSize;
    needs[qc_layersNodes] = clusters->nodeCount;
    needs[qc_layersLinks] = residency->imageOnly ? 0 : clusters->links.count;
    needs[qc_layersTables] = residency->imageOnly ? 0 : clusters->pairMasks.count;
}

static void AssignRanges(qcGpuResidency* residency, qcBodyResidency* resident, const qcBody* body)
{
    size_t needs[qc_layersInputCount];
    FindNeeds(residency, body, &resident->clusters, needs);
    resident->firstVertex = (uint32_t)residency->used[qc_layersVertices];
    resident->firstNode = (uint32_t)residency->used[qc_layersNodes];
    resident->firstLink = (uint32_t)residency->used[qc_layersLinks];
    resident->firstTable = (uint32_t)residency->used[qc_layersTables];
    resident->assigned = true;
    resident->frame = 0;
    for (int i = 0; i < qc_layersInputCount; i++)
        residency->used[i] += needs[i];
}

static void Release(qcGpuResidency* residency, qcBodyResidency* resident)
{
    residency->freedNodes += resident->assigned ? resident->clusters.nodeCount : 0;
    qcClusters_Free(&resident->clusters);
    *resident = (qcBodyResidency){0};
}

/// Entries for all slots; empties those of removed bodies.
static qcStatus SyncSlots(const Prepare* p)
{
    qcGpuResidency* residency = p->residency;
    const qcArray* slots = &p->job->triangles->bodies->slots;
    size_t old = residency->bodies.count;
    if (slots->count > old)
    {
        QC_TRY(qcArray_Resize(&residency->bodies, slots->count, sizeof(qcBodyResidency), "bodies on the device"));
        memset(BodyAt(residency, (uint32_t)old), 0, (slots->count - old) * sizeof(qcBodyResidency));
    }
    for (uint32_t slot = 0; slot < old; slot++)
    {
        qcBodyResidency* resident = BodyAt(residency, slot);
        if (resident->generation != 0 && resident->generation != QC_AT(qcBody, *slots, slot).generation)
            Release(residency, resident);
    }
    return qc_statusOk;
}

/// Assigns ranges to each body that takes part and has none. If removed bodies have most of the nodes, all bodies are
/// assigned anew.
static qcStatus AssignBodies(const Prepare* p)
{
    qcGpuResidency* residency = p->residency;
    if (2 * (uint64_t)residency->freedNodes > residency->used[qc_layersNodes])
        qcGpuResidency_Forget(residency);
    for (uint32_t body = 0; body < p->job->triangles->bodyCount; body++)
    {
        qcBodyResidency* resident = BodyAt(residency, qcStepTriangles_Slot(p->job->triangles, body));
        const qcBody* b = qcStepTriangles_Body(p->job->triangles, body);
        if (!p->job->takesPart[body] || resident->assigned)
            continue;
        if (resident->generation == 0)
        {
            qcFloatPositions_Convert(b);
            QC_TRY(qcClusters_Build(&resident->clusters, b->indices, b->triangleCount,
                                    b->deforming ? b->world : b->local, b->vertexCount, p->job->threads));
            resident->nodeExtent = qcGridResolution_FindNodeExtent(b, &resident->clusters);
        }
        resident->generation = b->generation;
        AssignRanges(residency, resident, b);
    }
    if (residency->used[qc_layersTriangles] > UINT32_MAX - 1 || residency->used[qc_layersVertices] > UINT32_MAX - 1)
        return qcFail(qc_statusDevice, "layers: more than 2^32 - 2 triangles or vertices on the device");
    bool grown = false;
    for (int i = 0; i < qc_layersInputCount; i++)
        if (residency->used[i] > residency->capacity[i])
        {
            residency->capacity[i] = residency->used[i] + residency->used[i] / 4;
            grown = true;
        }
    // A buffer that grows loses its contents.
    for (uint32_t slot = 0; grown && slot < residency->bodies.count; slot++)
        BodyAt(residency, slot)->frame = 0;
    return qc_statusOk;
}

static qcStatus AddUpload(qcGpuResidency* residency, qcLayersBuffer buffer, size_t first, size_t count,
                          const void* data)
{
    size_t at = residency->uploads.count;
    QC_TRY(qcArray_Reserve(&residency->uploads, at + 1, sizeof(qcLayersUpload), "uploads"));
    QC_AT(qcLayersUpload, residency->uploads, residency->uploads.count++) =
        (qcLayersUpload){buffer, first, count, data};
    return qc_statusOk;
}

/// Room at the end of a staging array. Its final size has been reserved: uploads point into it.
static void* Stage(qcArray* array, size_t count, size_t elementSize)
{
    size_t at = array->count;
    array->count += count;
    return (char*)array->data + at * elementSize;
}

typedef struct StagingNeeds
{
    size_t locals, triangles, nodes, links;
} StagingNeeds;

static bool HasMoved(const Prepare* p, const qcBodyResidency* resident, const qcBody* body)
{
    return resident->moved != body->moved || resident->frame != p->job->frame->number;
}

static qcStatus ReserveStaging(const Prepare* p)
{
    qcGpuResidency* residency = p->residency;
    StagingNeeds needs = {0};
    for (uint32_t body = 0; body < p->job->triangles->bodyCount; body++)
    {
        const qcBodyResidency* resident = BodyAt(residency, qcStepTriangles_Slot(p->job->triangles, body));
        const qcBody* b = qcStepTriangles_Body(p->job->triangles, body);
        if (!p->job->takesPart[body] || resident->frame != 0)
            continue;
        needs.locals += b->deforming ? 0 : b->vertexCount;
        needs.triangles += (size_t)resident->clusters.nodeCount * qc_nodeSize;
        needs.nodes += resident->clusters.nodeCount;
        needs.links += resident->clusters.links.count;
    }
    if (needs.triangles == 0)
    {
        // Topology is uploaded once: its staging memory is given back.
        qcArray_Free(&residency->triangles);
        qcArray_Free(&residency->nodes);
        qcArray_Free(&residency->links);
        qcArray_Free(&residency->locals);
    }
    residency->locals.count = residency->triangles.count = 0;
    residency->nodes.count = residency->links.count = residency->uploads.count = 0;
    QC_TRY(qcArray_Reserve(&residency->locals, needs.locals, sizeof(Vertex), "vertices for the device"));
    QC_TRY(qcArray_Reserve(&residency->triangles, needs.triangles, 4 * sizeof(uint32_t), "triangles for the device"));
    QC_TRY(qcArray_Reserve(&residency->nodes, needs.nodes, 4 * sizeof(uint32_t), "nodes for the device"));
    QC_TRY(qcArray_Reserve(&residency->links, needs.links, 2 * sizeof(uint32_t), "links for the device"));
    if (residency->imageOnly)
        QC_TRY(qcArray_Resize(&residency->corners, residency->used[qc_layersTriangles], sizeof(qcCorners),
                              "triangles for the device"));
    return qcArray_Resize(&residency->nodeSlot, residency->used[qc_layersNodes], sizeof(uint32_t),
                          "nodes for the device");
}

/// A rigid body's vertices relative to its centre, in units of 2^exponent: those of triangles lie within [-1, 1].
static qcStatus UploadLocals(qcGpuResidency* residency, qcBodyResidency* resident, uint32_t slot, const qcBody* body)
{
    double lower[3], upper[3], half = 0.0;
    qcBounds_Clear(lower, upper);
    for (size_t i = 0; i < 3 * (size_t)body->triangleCount; i++)
        qcBounds_IncludePoint(body->local + 3 * (size_t)body->indices[i], lower, upper);
    for (int axis = 0; axis < 3; axis++)
    {
        resident->center[axis] = 0.5 * lower[axis] + 0.5 * upper[axis];
        half = fmax(half, fmax(upper[axis] - resident->center[axis], resident->center[axis] - lower[axis]));
    }
    resident->exponent = 0;
    if (half > 0.0)
        frexp(half, &resident->exponent);
    // The inverse must be finite, too.
    resident->exponent = resident->exponent < -960 ? -960 : resident->exponent;
    double unit = ldexp(1.0, -resident->exponent);
    Vertex* staged = Stage(&residency->locals, body->vertexCount, sizeof(Vertex));
    for (uint32_t v = 0; v < body->vertexCount; v++)
    {
        for (size_t axis = 0; axis < 3; axis++)
            staged[v].x[axis] = (float)((body->local[3 * (size_t)v + axis] - resident->center[axis]) * unit);
        staged[v].body = slot;
    }
    return AddUpload(residency, qc_layersLocals, resident->firstVertex, body->vertexCount, staged);
}

/// The adjacency of a body's leaf nodes.
static qcStatus UploadTables(qcGpuResidency* residency, const qcBodyResidency* resident)
{
    const qcClusters* clusters = &resident->clusters;
    uint32_t(*links)[2] = Stage(&residency->links, clusters->links.count, sizeof *links);
    for (size_t i = 0; i < clusters->links.count; i++)
    {
        qcLeafLink link = QC_AT(qcLeafLink, clusters->links, i);
        links[i][0] = resident->firstNode + link.other;
        links[i][1] = resident->firstTable + link.mask;
    }
    QC_TRY(AddUpload(residency, qc_layersLinks, resident->firstLink, clusters->links.count, links));
    return AddUpload(residency, qc_layersTables, resident->firstTable, clusters->pairMasks.count,
                     clusters->pairMasks.data);
}

static qcStatus UploadTopology(qcGpuResidency* residency, qcBodyResidency* resident, uint32_t slot, const qcBody* body)
{
    const qcClusters* clusters = &resident->clusters;
    uint32_t nodeCount = clusters->nodeCount;
    uint32_t(*triangles)[4] = Stage(&residency->triangles, (size_t)nodeCount * qc_nodeSize, sizeof *triangles);
    for (size_t i = 0; i < (size_t)nodeCount * qc_nodeSize; i++)
    {
        uint32_t t = QC_AT(uint32_t, clusters->triangles, i);
        for (size_t c = 0; c < 3; c++)
            triangles[i][c] =
                t == QC_NO_TRIANGLE ? QC_NO_TRIANGLE : resident->firstVertex + body->indices[3 * (size_t)t + c];
        triangles[i][3] = t;
        if (residency->imageOnly)
            memcpy(&QC_AT(qcCorners, residency->corners, (size_t)resident->firstNode * qc_nodeSize + i), triangles[i],
                   sizeof(qcCorners));
    }
    uint32_t(*nodes)[4] = Stage(&residency->nodes, nodeCount, sizeof *nodes);
    for (uint32_t n = 0; n < nodeCount; n++)
    {
        nodes[n][0] = slot;
        nodes[n][1] = resident->firstLink + QC_AT(uint32_t, clusters->firstLink, n);
        nodes[n][2] = resident->firstLink + QC_AT(uint32_t, clusters->firstLink, n + 1);
        nodes[n][3] = 0;
        QC_AT(uint32_t, residency->nodeSlot, resident->firstNode + n) = slot;
    }
    QC_TRY(AddUpload(residency, qc_layersTriangles, (size_t)resident->firstNode * qc_nodeSize,
                     (size_t)nodeCount * qc_nodeSize, triangles));
    QC_TRY(AddUpload(residency, qc_layersNodes, resident->firstNode, nodeCount, nodes));
    if (!residency->imageOnly)
        QC_TRY(UploadTables(residency, resident));
    return body->deforming ? qc_statusOk : UploadLocals(residency, resident, slot, body);
}

/// The transform from qc_layersLocals into the frame, in single precision; false: its error could exceed pointError.
static bool FindTransform(const qcBodyResidency* resident, const qcBody* body, const qcGridFrame* frame,
                          float transform[3][4])
{
    double size = ldexp(1.0, resident->exponent);
    for (int i = 0; i < 3; i++)
    {
        const double* row = body->transform.linear + 3 * (size_t)frame->axes[i];
        double shift = body->transform.translation[frame->axes[i]], world = fabs(shift), rho = 0.0;
        double at = shift - frame->origin[i];
        for (int j = 0; j < 3; j++)
        {
            transform[i][j] = (float)(row[j] * size * frame->unit);
            rho += fabs(row[j]) * size * frame->unit;
            world += fabs(row[j]) * (fabs(resident->center[j]) + size);
            at += row[j] * resident->center[j];
        }
        transform[i][3] = (float)(at * frame->unit);
        // `at` is summed in double: as exact as world positions.
        double error = (10.0 * rho + 5.0 * fabs(at * frame->unit)) * 0x1p-24 +
                       0x1p-49 * (world + fabs(frame->origin[i])) * frame->unit;
        // NaN after an overflow. 2^-60: products below the smallest float are lost.
        if (!(error + 0x1p-60 <= frame->pointError))
            return false;
    }
    return true;
}

/// The chunks of a body's new vertices. `at`: of their floats; `stride`: 0 for rigid bodies.
static qcStatus AddChunks(qcArray* chunks, const qcBodyResidency* resident, const qcBody* body, qcLayersChunkKind kind,
                          size_t at, uint32_t stride)
{
    uint32_t chunkCount = (uint32_t)(PaddedVertices(body) / qc_layersChunkSize);
    QC_TRY(qcArray_Reserve(chunks, chunks->count + chunkCount, sizeof(qcLayersChunk), "chunks of vertices"));
    for (uint32_t first = 0; first < body->vertexCount; first += qc_layersChunkSize)
    {
        uint32_t left = body->vertexCount - first;
        QC_AT(qcLayersChunk, *chunks, chunks->count++) =
            (qcLayersChunk){resident->firstVertex + first, left < qc_layersChunkSize ? left : qc_layersChunkSize,
                            (uint32_t)(at + (size_t)first * stride), (uint32_t)kind | stride << 8};
    }
    return qc_statusOk;
}

/// Plans the new vertices of a body that the device doesn't transform.
static qcStatus AddVertices(const Prepare* p, const qcBodyResidency* resident, uint32_t body, const qcBody* b)
{
    qcGpuResidency* residency = p->residency;
    qcArray* jobs = &residency->vertexJobs;
    qcVertexJob job = {.body = body,
                       .firstVertex = resident->firstVertex,
                       .at = residency->floatCount,
                       .inWorld = b->hasFloats && p->job->frame->exponent >= qc_minWorldExponent};
    QC_TRY(qcArray_Reserve(jobs, jobs->count + 1, sizeof job, "new vertices"));
    QC_AT(qcVertexJob, *jobs, jobs->count++) = job;
    if (residency->sharesVertices)
    {
        residency->vertexCount += b->vertexCount;
        return qc_statusOk;
    }
    residency->floatCount += 3 * (size_t)b->vertexCount;
    return AddChunks(&residency->chunks, resident, b, job.inWorld ? qc_chunkWorld : qc_chunkInFrame, job.at, 3);
}

/// Plans the new vertices of a body whose floats are on the device.
static qcStatus AddSource(qcGpuResidency* residency, const qcBodyResidency* resident, const qcBody* body)
{
    qcArray *sources = &residency->sources, *chunks = &residency->sourceChunks;
    size_t first = chunks->count;
    QC_TRY(AddChunks(chunks, resident, body, qc_chunkWorld, 0, 3));
    QC_TRY(qcArray_Reserve(sources, sources->count + 1, sizeof(qcLayersSource), "bodies on the device"));
    QC_AT(qcLayersSource, *sources, sources->count++) =
        (qcLayersSource){body->snapshot->buffers[0], (uint32_t)(chunks->count - first)};
    return qc_statusOk;
}

static qcStatus AddRange(qcArray* array, uint32_t first, uint32_t count)
{
    QC_TRY(qcArray_Reserve(array, array->count + count, sizeof(uint32_t), "nodes"));
    for (uint32_t i = 0; i < count; i++)
        QC_AT(uint32_t, *array, array->count++) = first + i;
    return qc_statusOk;
}

static qcStatus UploadBody(const Prepare* p, uint32_t body)
{
    qcGpuResidency* residency = p->residency;
    uint32_t slot = qcStepTriangles_Slot(p->job->triangles, body);
    const qcBody* b = qcStepTriangles_Body(p->job->triangles, body);
    qcBodyResidency* resident = BodyAt(residency, slot);
    qcLayersBody* entry = &QC_AT(qcLayersBody, residency->table, slot);
    *entry = (qcLayersBody){.group = b->group,
                            .mask = b->mask,
                            .flags = (b->activity == qc_activityMoving ? qc_layersIsMoving : 0u) |
                                     (p->job->hasSelfPairs[body] ? qc_layersMeetsItself : 0u),
                            .owner = b->owner,
                            .firstTriangle = qcStepTriangles_First(p->job->triangles, body)};
    memcpy(entry->interest, p->job->partnerBoxes + 4 * (size_t)body, sizeof entry->interest);
    if (resident->frame == 0)
        QC_TRY(UploadTopology(residency, resident, slot, b));
    resident->transformed = !b->deforming && FindTransform(resident, b, p->job->frame, entry->transform);
    resident->changed = HasMoved(p, resident, b);
    if (resident->changed && resident->transformed)
        QC_TRY(AddChunks(&residency->chunks, resident, b, qc_chunkRigid, 0, 0));
    else if (resident->changed && qcVertexSnapshot_IsOnDevice(b->snapshot))
        QC_TRY(AddSource(residency, resident, b));
    else if (resident->changed)
        QC_TRY(AddVertices(p, resident, body, b));
    resident->moved = b->moved;
    resident->frame = p->job->frame->number;
    return qc_statusOk;
}

/// Lists the leaf nodes of bodies that take part, changed bodies first.
static qcStatus ListNodes(const Prepare* p)
{
    qcGpuResidency* residency = p->residency;
    residency->activeNodes.count = 0;
    for (int changed = 1; changed >= 0; changed--)
    {
        for (uint32_t body = 0; body < p->job->triangles->bodyCount; body++)
        {
            const qcBodyResidency* resident = BodyAt(residency, qcStepTriangles_Slot(p->job->triangles, body));
            if (p->job->takesPart[body] && resident->changed == (changed != 0))
                QC_TRY(AddRange(&residency->activeNodes, resident->firstNode, resident->clusters.nodeCount));
        }
        if (changed)
            residency->changedNodes = (uint32_t)residency->activeNodes.count;
    }
    return qc_statusOk;
}

qcStatus qcGpuResidency_Prepare(const qcResidencyJob* job, qcGpuResidency* residency)
{
    const Prepare p = {residency, job};
    QC_TRY(SyncSlots(&p));
    QC_TRY(AssignBodies(&p));
    QC_TRY(ReserveStaging(&p));
    const qcStepTriangles* triangles = job->triangles;
    size_t slots = triangles->bodies->slots.count;
    QC_TRY(qcArray_Resize(&residency->table, slots, sizeof(qcLayersBody), "bodies for the device"));
    memset(residency->table.data, 0, slots * sizeof(qcLayersBody));
    residency->chunks.count = residency->sourceChunks.count = residency->sources.count = 0;
    residency->vertexJobs.count = 0;
    residency->floatCount = residency->vertexCount = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (job->takesPart[body])
            QC_TRY(UploadBody(&p, body));
    QC_TRY(qcArray_Append(&residency->chunks, &residency->sourceChunks, sizeof(qcLayersChunk), "chunks of vertices"));
    return ListNodes(&p);
}

void qcGpuResidency_FillStep(const qcGpuResidency* residency, const qcGridFrame* frame, qcLayersStep* step)
{
    memcpy(step->capacity, residency->capacity, sizeof step->capacity);
    step->uploads = residency->uploads.data;
    step->uploadCount = residency->uploads.count;
    step->bodies = residency->table.data;
    step->bodyCount = (uint32_t)residency->table.count;
    step->chunks = residency->chunks.data;
    step->chunkCount = (uint32_t)residency->chunks.count;
    step->sources = residency->sources.data;
    step->sourceCount = (uint32_t)residency->sources.count;
    step->floatCount = residency->floatCount;
    step->vertexCount = residency->vertexCount;
    step->activeNodes = residency->activeNodes.data;
    step->changedNodes = residency->changedNodes;
    step->activeCount = (uint32_t)residency->activeNodes.count;
    memcpy(step->frame.axes, frame->axes, sizeof step->frame.axes);
    memcpy(step->frame.origin, frame->origin, sizeof step->frame.origin);
    step->frame.unit = frame->unit;
    memcpy(step->scale, frame->scale, sizeof step->scale);
    memcpy(step->slack, frame->slack, sizeof step->slack);
    step->pointError = frame->pointError;
    step->queryDistance = frame->queryDistance;
}

typedef struct Writing
{
    const qcBody* body;
    qcGridFrame frame;
    bool inWorld;
    float* floats;     ///< three a vertex; null: `vertices`
    qcPoint* vertices; ///< in the frame
} Writing;

static void WriteInWorld(const Writing* w, uint32_t first, uint32_t end)
{
    const size_t at = 3 * (size_t)first, count = 3 * (size_t)(end - first);
    if (qcBody_IsInFloats(w->body))
        memcpy(w->floats + at, w->body->floats->at + at, count * sizeof(float));
    else
        // Exact: the caller gave floats.
        for (size_t i = at; i < at + count; i++)
            w->floats[i] = (float)w->body->world[i];
}

static void WriteInFrame(const Writing* w, uint32_t first, uint32_t end)
{
    // Copies: nothing that is written overlaps them.
    const qcGridFrame frame = w->frame;
    const qcBody* body = w->body;
    float* floats = w->floats;
    qcPoint* vertices = w->vertices;
    for (uint32_t v = first; v < end; v++)
    {
        double world[3], x[3];
        qcBody_GetNewestVertex(body, v, world);
        qcGridFrame_Map(&frame, world, x);
        if (floats == NULL)
            vertices[v] = (qcPoint){{(float)x[0], (float)x[1], (float)x[2], 0.0f}};
        else
            for (int i = 0; i < 3; i++)
                floats[3 * (size_t)v + (size_t)i] = (float)x[i];
    }
}

static void WriteBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Writing* w = context;
    uint32_t first = (uint32_t)block * qc_vertexBlock, count = w->body->vertexCount;
    uint32_t end = count - first < qc_vertexBlock ? count : first + qc_vertexBlock;
    if (w->floats != NULL && w->inWorld)
        WriteInWorld(w, first, end);
    else
        WriteInFrame(w, first, end);
}

void qcGpuResidency_WriteVertices(const qcResidencyJob* job, const qcGpuResidency* residency,
                                  const qcLayersMemory* memory)
{
    for (size_t i = 0; i < residency->vertexJobs.count; i++)
    {
        const qcVertexJob* vertexJob = &QC_AT(qcVertexJob, residency->vertexJobs, i);
        Writing w = {.body = qcStepTriangles_Body(job->triangles, vertexJob->body),
                     .frame = *job->frame,
                     .inWorld = vertexJob->inWorld};
        if (memory->vertices != NULL)
            w.vertices = memory->vertices + vertexJob->firstVertex;
        else
            w.floats = memory->floats + vertexJob->at;
        qcParallel_For(job->threads, (w.body->vertexCount + (size_t)qc_vertexBlock - 1) / qc_vertexBlock, qc_minBlocks,
                       WriteBlock, &w);
    }
}

void qcGpuResidency_Forget(qcGpuResidency* residency)
{
    for (uint32_t slot = 0; slot < residency->bodies.count; slot++)
        BodyAt(residency, slot)->assigned = false;
    memset(residency->used, 0, sizeof residency->used);
    memset(residency->capacity, 0, sizeof residency->capacity);
    residency->freedNodes = 0;
}

void qcGpuResidency_Free(qcGpuResidency* residency)
{
    for (uint32_t slot = 0; slot < residency->bodies.count; slot++)
        Release(residency, BodyAt(residency, slot));
    qcArray* arrays[] = {&residency->bodies,      &residency->nodeSlot, &residency->corners,      &residency->locals,
                         &residency->triangles,   &residency->nodes,    &residency->links,        &residency->table,
                         &residency->activeNodes, &residency->chunks,   &residency->sourceChunks, &residency->sources,
                         &residency->vertexJobs,  &residency->uploads};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
