// Places, staging and uploads.
//
// Rounding, in units of the frame (gl/layers.c calls the bound on a vertex pointError):
// - An uploaded vertex is (world - origin) * 2^-exponent in double, wrong by at most 2^-52, then rounded to float: for
//   values up to 1 by at most 2^-25. Together below 2^-23.
// - A transformed one is R l + u in floats. Each coordinate of l (at most 1) and each entry of R is rounded once
//   (2^-24 relative), u too; three products and three sums round once more each, to a unit in the last place (2^-23).
//   With rho the greatest sum over a row of |R|: wrong by at most (10 rho + 5 |u|) 2^-24. What is exact, the world
//   position in double, is itself wrong by 2^-50 (|linear| |local| + |translation|) beside the real product.
#include "cull/layers/gpu_residency.h"

#include "base/parallel_for.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    qc_chunkSize = 64,
    // 16384 vertices take about 60 microseconds.
    qc_vertexBlock = 4096,
    qc_leastBlocks = 4
};

typedef struct Vertex
{
    float x[3];
    uint32_t body;
} Vertex;

typedef struct Prepare
{
    qcLayersBodies* bodies;
    const qcStepTriangles* triangles;
    const qcLayersFrame* frame;
    const uint8_t *takesPart, *meetsItself;
    const uint32_t* interests;
    uint32_t threads;
} Prepare;

static qcLayersPlace* PlaceAt(const qcLayersBodies* bodies, uint32_t slot)
{
    return &QC_AT(qcLayersPlace, bodies->places, slot);
}

static size_t PaddedVertices(const qcBody* body)
{
    return ((size_t)body->vertexCount + qc_chunkSize - 1) / qc_chunkSize * qc_chunkSize;
}

/// What a body takes of each input buffer.
static void FindNeeds(const qcLayersBodies* bodies, const qcBody* body, const qcClusters* clusters,
                      size_t needs[qc_layersInputCount])
{
    memset(needs, 0, qc_layersInputCount * sizeof needs[0]);
    needs[qc_layersVertices] = needs[qc_layersLocals] = PaddedVertices(body);
    needs[qc_layersTriangles] = (size_t)clusters->nodeCount * qc_nodeSize;
    needs[qc_layersNodes] = needs[qc_layersActiveNodes] = clusters->nodeCount;
    needs[qc_layersLinks] = bodies->imageOnly ? 0 : clusters->links.count;
    needs[qc_layersTables] = bodies->imageOnly ? 0 : clusters->pairMasks.count;
    needs[qc_layersChunks] = needs[qc_layersVertices] / qc_chunkSize;
}

static void Assign(qcLayersBodies* bodies, qcLayersPlace* place, const qcBody* body)
{
    size_t needs[qc_layersInputCount];
    FindNeeds(bodies, body, &place->clusters, needs);
    place->firstVertex = (uint32_t)bodies->used[qc_layersVertices];
    place->firstNode = (uint32_t)bodies->used[qc_layersNodes];
    place->firstLink = (uint32_t)bodies->used[qc_layersLinks];
    place->firstTable = (uint32_t)bodies->used[qc_layersTables];
    place->placed = true;
    place->frame = 0;
    for (int i = 0; i < qc_layersInputCount; i++)
        bodies->used[i] += needs[i];
}

static void Release(qcLayersBodies* bodies, qcLayersPlace* place)
{
    bodies->goneNodes += place->placed ? place->clusters.nodeCount : 0;
    qcClusters_Free(&place->clusters);
    *place = (qcLayersPlace){0};
}

/// Places for all slots, empty ones for bodies that are gone.
static qcStatus SyncSlots(const Prepare* p)
{
    qcLayersBodies* bodies = p->bodies;
    const qcArray* slots = &p->triangles->bodies->slots;
    size_t old = bodies->places.count;
    if (slots->count > old)
    {
        QC_TRY(qcArray_Resize(&bodies->places, slots->count, sizeof(qcLayersPlace), "bodies on the device"));
        memset(PlaceAt(bodies, (uint32_t)old), 0, (slots->count - old) * sizeof(qcLayersPlace));
    }
    for (uint32_t slot = 0; slot < old; slot++)
    {
        qcLayersPlace* place = PlaceAt(bodies, slot);
        if (place->generation != 0 && place->generation != QC_AT(qcBody, *slots, slot).generation)
            Release(bodies, place);
    }
    return qc_statusOk;
}

/// A place of its own for each body that takes part and has none; all anew where much is given to bodies that are gone.
static qcStatus AssignPlaces(const Prepare* p)
{
    qcLayersBodies* bodies = p->bodies;
    if (2 * bodies->goneNodes > bodies->used[qc_layersNodes])
        qcLayersBodies_Forget(bodies);
    for (uint32_t body = 0; body < p->triangles->bodyCount; body++)
    {
        qcLayersPlace* place = PlaceAt(bodies, qcStepTriangles_Slot(p->triangles, body));
        const qcBody* b = qcStepTriangles_Body(p->triangles, body);
        if (!p->takesPart[body] || place->placed)
            continue;
        if (place->generation == 0)
            QC_TRY(qcClusters_Build(&place->clusters, b->indices, b->triangleCount, b->deforming ? b->world : b->local,
                                    b->vertexCount, p->threads));
        place->generation = b->generation;
        Assign(bodies, place, b);
    }
    if (bodies->used[qc_layersTriangles] > UINT32_MAX - 1 || bodies->used[qc_layersVertices] > UINT32_MAX - 1)
        return qcFail(qc_statusDevice, "layers: more than 2^32 - 2 places on the device");
    bodies->used[qc_layersBodies] = p->triangles->bodies->slots.count * qc_layersBodyTexels;
    bool grown = false;
    for (int i = 0; i < qc_layersInputCount; i++)
        if (bodies->used[i] > bodies->capacity[i])
        {
            bodies->capacity[i] = bodies->used[i] + bodies->used[i] / 4;
            grown = true;
        }
    // A buffer that grows loses what it held. (The bodies' own grows with their number, and then they are sent anyway.)
    for (uint32_t slot = 0; grown && slot < bodies->places.count; slot++)
        PlaceAt(bodies, slot)->frame = 0;
    return qc_statusOk;
}

static qcStatus AddUpload(qcLayersBodies* bodies, qcLayersBuffer buffer, size_t first, size_t count, const void* data)
{
    size_t at = bodies->uploads.count;
    QC_TRY(qcArray_Reserve(&bodies->uploads, at + 1, sizeof(qcLayersUpload), "uploads"));
    QC_AT(qcLayersUpload, bodies->uploads, bodies->uploads.count++) = (qcLayersUpload){buffer, first, count, data};
    return qc_statusOk;
}

/// Room at the end of a staging array, whose final size was reserved before: uploads point into it.
static void* Stage(qcArray* array, size_t count, size_t elementSize)
{
    size_t at = array->count;
    array->count += count;
    return (char*)array->data + at * elementSize;
}

typedef struct StagingNeeds
{
    size_t vertices, locals, triangles, nodes, links;
} StagingNeeds;

static bool HasMoved(const Prepare* p, const qcLayersPlace* place, const qcBody* body)
{
    return place->moved != body->moved || place->frame != p->frame->number;
}

static qcStatus ReserveStaging(const Prepare* p)
{
    qcLayersBodies* bodies = p->bodies;
    StagingNeeds needs = {0};
    for (uint32_t body = 0; body < p->triangles->bodyCount; body++)
    {
        const qcLayersPlace* place = PlaceAt(bodies, qcStepTriangles_Slot(p->triangles, body));
        const qcBody* b = qcStepTriangles_Body(p->triangles, body);
        if (!p->takesPart[body])
            continue;
        needs.vertices += HasMoved(p, place, b) ? b->vertexCount : 0;
        if (place->frame != 0)
            continue;
        needs.locals += b->deforming ? 0 : b->vertexCount;
        needs.triangles += (size_t)place->clusters.nodeCount * qc_nodeSize;
        needs.nodes += place->clusters.nodeCount;
        needs.links += place->clusters.links.count;
    }
    if (needs.triangles == 0)
    {
        // Topology comes once: what its upload took is given back.
        qcArray_Free(&bodies->triangles);
        qcArray_Free(&bodies->nodes);
        qcArray_Free(&bodies->links);
        qcArray_Free(&bodies->locals);
    }
    bodies->vertices.count = bodies->locals.count = bodies->triangles.count = 0;
    bodies->nodes.count = bodies->links.count = bodies->uploads.count = 0;
    QC_TRY(qcArray_Reserve(&bodies->vertices, needs.vertices, sizeof(Vertex), "vertices for the device"));
    QC_TRY(qcArray_Reserve(&bodies->locals, needs.locals, sizeof(Vertex), "vertices for the device"));
    QC_TRY(qcArray_Reserve(&bodies->triangles, needs.triangles, 4 * sizeof(uint32_t), "triangles for the device"));
    QC_TRY(qcArray_Reserve(&bodies->nodes, needs.nodes, 4 * sizeof(uint32_t), "nodes for the device"));
    QC_TRY(qcArray_Reserve(&bodies->links, needs.links, 2 * sizeof(uint32_t), "links for the device"));
    if (bodies->imageOnly)
        QC_TRY(qcArray_Resize(&bodies->corners, bodies->used[qc_layersTriangles], sizeof(qcCorners),
                              "triangles for the device"));
    return qcArray_Resize(&bodies->nodeSlot, bodies->used[qc_layersNodes], sizeof(uint32_t), "nodes for the device");
}

/// A rigid body's vertices about its centre, in units of 2^exponent: within [-1, 1] if a triangle has them.
static qcStatus UploadLocals(qcLayersBodies* bodies, qcLayersPlace* place, uint32_t slot, const qcBody* body)
{
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY}, half = 0.0;
    for (size_t i = 0; i < 3 * (size_t)body->triangleCount; i++)
        for (int axis = 0; axis < 3; axis++)
        {
            double x = body->local[3 * (size_t)body->indices[i] + axis];
            lower[axis] = fmin(lower[axis], x);
            upper[axis] = fmax(upper[axis], x);
        }
    for (int axis = 0; axis < 3; axis++)
    {
        place->center[axis] = 0.5 * lower[axis] + 0.5 * upper[axis];
        half = fmax(half, fmax(upper[axis] - place->center[axis], place->center[axis] - lower[axis]));
    }
    place->exponent = 0;
    if (half > 0.0)
        frexp(half, &place->exponent);
    // So that the inverse is finite too.
    place->exponent = place->exponent < -960 ? -960 : place->exponent;
    double unit = ldexp(1.0, -place->exponent);
    Vertex* staged = Stage(&bodies->locals, body->vertexCount, sizeof(Vertex));
    for (uint32_t v = 0; v < body->vertexCount; v++)
    {
        for (int axis = 0; axis < 3; axis++)
            staged[v].x[axis] = (float)((body->local[3 * (size_t)v + axis] - place->center[axis]) * unit);
        staged[v].body = slot;
    }
    return AddUpload(bodies, qc_layersLocals, place->firstVertex, body->vertexCount, staged);
}

/// Who of a body's nodes are neighbours.
static qcStatus UploadTables(qcLayersBodies* bodies, const qcLayersPlace* place)
{
    const qcClusters* clusters = &place->clusters;
    uint32_t(*links)[2] = Stage(&bodies->links, clusters->links.count, sizeof *links);
    for (size_t i = 0; i < clusters->links.count; i++)
    {
        qcLeafLink link = QC_AT(qcLeafLink, clusters->links, i);
        links[i][0] = place->firstNode + link.other;
        links[i][1] = place->firstTable + link.mask;
    }
    QC_TRY(AddUpload(bodies, qc_layersLinks, place->firstLink, clusters->links.count, links));
    return AddUpload(bodies, qc_layersTables, place->firstTable, clusters->pairMasks.count, clusters->pairMasks.data);
}

static qcStatus UploadTopology(qcLayersBodies* bodies, qcLayersPlace* place, uint32_t slot, const qcBody* body)
{
    const qcClusters* clusters = &place->clusters;
    uint32_t nodeCount = clusters->nodeCount;
    uint32_t(*triangles)[4] = Stage(&bodies->triangles, (size_t)nodeCount * qc_nodeSize, sizeof *triangles);
    for (size_t i = 0; i < (size_t)nodeCount * qc_nodeSize; i++)
    {
        uint32_t t = QC_AT(uint32_t, clusters->triangles, i);
        for (int c = 0; c < 3; c++)
            triangles[i][c] =
                t == QC_NO_TRIANGLE ? QC_NO_TRIANGLE : place->firstVertex + body->indices[3 * (size_t)t + c];
        triangles[i][3] = 0;
        if (bodies->imageOnly)
            memcpy(&QC_AT(qcCorners, bodies->corners, (size_t)place->firstNode * qc_nodeSize + i), triangles[i],
                   sizeof(qcCorners));
    }
    uint32_t(*nodes)[4] = Stage(&bodies->nodes, nodeCount, sizeof *nodes);
    for (uint32_t n = 0; n < nodeCount; n++)
    {
        nodes[n][0] = slot;
        nodes[n][1] = place->firstLink + QC_AT(uint32_t, clusters->firstLink, n);
        nodes[n][2] = place->firstLink + QC_AT(uint32_t, clusters->firstLink, n + 1);
        nodes[n][3] = 0;
        QC_AT(uint32_t, bodies->nodeSlot, place->firstNode + n) = slot;
    }
    QC_TRY(AddUpload(bodies, qc_layersTriangles, (size_t)place->firstNode * qc_nodeSize,
                     (size_t)nodeCount * qc_nodeSize, triangles));
    QC_TRY(AddUpload(bodies, qc_layersNodes, place->firstNode, nodeCount, nodes));
    if (!bodies->imageOnly)
        QC_TRY(UploadTables(bodies, place));
    return body->deforming ? qc_statusOk : UploadLocals(bodies, place, slot, body);
}

/// The transform from qc_layersLocals into the frame, in floats; false: it would be less exact than the frame demands.
static bool FindTransform(const qcLayersPlace* place, const qcBody* body, const qcLayersFrame* frame,
                          float transform[3][4])
{
    double size = ldexp(1.0, place->exponent);
    for (int i = 0; i < 3; i++)
    {
        const double* row = body->transform.linear + 3 * frame->axes[i];
        double shift = body->transform.translation[frame->axes[i]], world = fabs(shift), rho = 0.0;
        double at = shift - frame->origin[i];
        for (int j = 0; j < 3; j++)
        {
            transform[i][j] = (float)(row[j] * size * frame->unit);
            rho += fabs(row[j]) * size * frame->unit;
            world += fabs(row[j]) * (fabs(place->center[j]) + size);
            at += row[j] * place->center[j];
        }
        transform[i][3] = (float)(at * frame->unit);
        // The sums that make `at` are in double: as exact as world positions are.
        double error = (10.0 * rho + 5.0 * fabs(at * frame->unit)) * 0x1p-24 +
                       0x1p-49 * (world + fabs(frame->origin[i])) * frame->unit;
        // Not a number when something overflowed on the way. Below the smallest float, products would be lost.
        if (!(error + 0x1p-60 <= frame->pointError))
            return false;
    }
    return true;
}

typedef struct Conversion
{
    const qcBody* body;
    const qcLayersFrame* frame;
    Vertex* staged;
} Conversion;

static void Convert(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Conversion* c = context;
    const qcLayersFrame frame = *c->frame;
    uint32_t first = (uint32_t)block * qc_vertexBlock;
    uint32_t count = c->body->vertexCount, end = count - first < qc_vertexBlock ? count : first + qc_vertexBlock;
    for (uint32_t v = first; v < end; v++)
    {
        double world[3], x[3];
        qcBody_GetVertex(c->body, v, world);
        qcLayersFrame_Map(&frame, world, x);
        c->staged[v] = (Vertex){{(float)x[0], (float)x[1], (float)x[2]}, 0};
    }
}

static qcStatus UploadVertices(const Prepare* p, const qcLayersPlace* place, const qcBody* body)
{
    Conversion c = {body, p->frame, NULL};
    c.staged = Stage(&p->bodies->vertices, body->vertexCount, sizeof(Vertex));
    qcParallel_For(p->threads, (body->vertexCount + (size_t)qc_vertexBlock - 1) / qc_vertexBlock, qc_leastBlocks,
                   Convert, &c);
    return AddUpload(p->bodies, qc_layersVertices, place->firstVertex, body->vertexCount, c.staged);
}

static qcStatus AddRange(qcArray* array, uint32_t first, uint32_t count)
{
    QC_TRY(qcArray_Reserve(array, array->count + count, sizeof(uint32_t), "nodes and chunks"));
    for (uint32_t i = 0; i < count; i++)
        QC_AT(uint32_t, *array, array->count++) = first + i;
    return qc_statusOk;
}

static qcStatus UploadBody(const Prepare* p, uint32_t body)
{
    qcLayersBodies* bodies = p->bodies;
    uint32_t slot = qcStepTriangles_Slot(p->triangles, body);
    const qcBody* b = qcStepTriangles_Body(p->triangles, body);
    qcLayersPlace* place = PlaceAt(bodies, slot);
    qcLayersBody* entry = &QC_AT(qcLayersBody, bodies->bodies, slot);
    *entry = (qcLayersBody){.group = b->group,
                            .mask = b->mask,
                            .flags = (b->activity == qc_activityMoving ? qc_layersIsMoving : 0u) |
                                     (p->meetsItself[body] ? qc_layersMeetsItself : 0u),
                            .owner = b->owner};
    memcpy(entry->interest, p->interests + 4 * (size_t)body, sizeof entry->interest);
    if (place->frame == 0)
        QC_TRY(UploadTopology(bodies, place, slot, b));
    place->transformed = !b->deforming && FindTransform(place, b, p->frame, entry->transform);
    place->changed = HasMoved(p, place, b);
    if (place->changed && place->transformed)
        QC_TRY(
            AddRange(&bodies->chunks, place->firstVertex / qc_chunkSize, (uint32_t)(PaddedVertices(b) / qc_chunkSize)));
    else if (place->changed)
        QC_TRY(UploadVertices(p, place, b));
    place->moved = b->moved;
    place->frame = p->frame->number;
    return qc_statusOk;
}

/// Nodes of bodies that take part; those whose boxes change first.
static qcStatus ListNodes(const Prepare* p)
{
    qcLayersBodies* bodies = p->bodies;
    bodies->activeNodes.count = 0;
    for (int changed = 1; changed >= 0; changed--)
    {
        for (uint32_t body = 0; body < p->triangles->bodyCount; body++)
        {
            const qcLayersPlace* place = PlaceAt(bodies, qcStepTriangles_Slot(p->triangles, body));
            if (p->takesPart[body] && place->changed == (changed != 0))
                QC_TRY(AddRange(&bodies->activeNodes, place->firstNode, place->clusters.nodeCount));
        }
        if (changed)
            bodies->changedNodes = (uint32_t)bodies->activeNodes.count;
    }
    return AddUpload(bodies, qc_layersActiveNodes, 0, bodies->activeNodes.count, bodies->activeNodes.data);
}

/// The table of bodies, if it is another than the device has.
static qcStatus UploadTable(qcLayersBodies* bodies)
{
    size_t count = bodies->bodies.count, bytes = count * sizeof(qcLayersBody);
    if (bodies->sentBodies.count == count && memcmp(bodies->sentBodies.data, bodies->bodies.data, bytes) == 0)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&bodies->sentBodies, count, sizeof(qcLayersBody), "bodies for the device"));
    memcpy(bodies->sentBodies.data, bodies->bodies.data, bytes);
    return AddUpload(bodies, qc_layersBodies, 0, count * qc_layersBodyTexels, bodies->sentBodies.data);
}

qcStatus qcLayersBodies_Prepare(qcLayersBodies* bodies, const qcStepTriangles* triangles, const qcLayersFrame* frame,
                                const uint8_t* takesPart, const uint32_t* interests, const uint8_t* meetsItself,
                                uint32_t threads)
{
    const Prepare p = {bodies, triangles, frame, takesPart, meetsItself, interests, threads};
    QC_TRY(SyncSlots(&p));
    QC_TRY(AssignPlaces(&p));
    QC_TRY(ReserveStaging(&p));
    size_t slots = triangles->bodies->slots.count;
    QC_TRY(qcArray_Resize(&bodies->bodies, slots, sizeof(qcLayersBody), "bodies for the device"));
    memset(bodies->bodies.data, 0, slots * sizeof(qcLayersBody));
    bodies->chunks.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (takesPart[body])
            QC_TRY(UploadBody(&p, body));
    QC_TRY(ListNodes(&p));
    QC_TRY(AddUpload(bodies, qc_layersChunks, 0, bodies->chunks.count, bodies->chunks.data));
    return UploadTable(bodies);
}

void qcLayersBodies_FillStep(const qcLayersBodies* bodies, qcLayersStep* step)
{
    memcpy(step->capacity, bodies->capacity, sizeof step->capacity);
    step->uploads = bodies->uploads.data;
    step->uploadCount = bodies->uploads.count;
    step->chunkCount = (uint32_t)bodies->chunks.count;
    step->changedNodes = bodies->changedNodes;
    step->activeNodes = (uint32_t)bodies->activeNodes.count;
}

void qcLayersBodies_Forget(qcLayersBodies* bodies)
{
    for (uint32_t slot = 0; slot < bodies->places.count; slot++)
        PlaceAt(bodies, slot)->placed = false;
    memset(bodies->used, 0, sizeof bodies->used);
    memset(bodies->capacity, 0, sizeof bodies->capacity);
    bodies->goneNodes = 0;
    bodies->sentBodies.count = 0;
}

void qcLayersBodies_Free(qcLayersBodies* bodies)
{
    for (uint32_t slot = 0; slot < bodies->places.count; slot++)
        Release(bodies, PlaceAt(bodies, slot));
    qcArray* arrays[] = {&bodies->places, &bodies->nodeSlot,   &bodies->corners,     &bodies->vertices,
                         &bodies->locals, &bodies->triangles,  &bodies->nodes,       &bodies->links,
                         &bodies->bodies, &bodies->sentBodies, &bodies->activeNodes, &bodies->chunks,
                         &bodies->uploads};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
