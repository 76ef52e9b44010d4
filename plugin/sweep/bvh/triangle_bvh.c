// Topology once, boxes and points for each new position.
//
// Rounding. A level is trunc((x - origin) * scale): a subtraction, a product and a truncation, all monotone; an upper
// end is that of x + margin, rounded. So lower(A) <= upper(B) + margin in real numbers, where lower(A) is a double,
// stays true in levels. Boxes around boxes are least and greatest levels. The origin is below the body's lower end, so
// that no product is negative, and the scale takes what is above its upper end to 65533 at most, below qc_emptyEnd: on
// both sides there is room for what moves by the margin.
//
// A point is (x - origin) * 2^-k with the greatest extent in (1/2, 1]: wrong by at most 2^-53 in double and 2^-25 by
// rounding to float, together below 2^-24.
#include "sweep/bvh/triangle_bvh.h"

#include "base/parallel_for.h"
#include "base/rigid_transform.h"
#include "base/status.h"
#include "base/worker_results.h"

#include <math.h>
#include <string.h>

enum
{
    // Vertices, and clusters: a block takes some 10 microseconds.
    qc_vertexBlock = 2048,
    qc_clusterBlock = 256,
    qc_leastBlocks = 4,
    // Large discs, and the small ones in them.
    qc_discBlock = 4,
    // A disc that is not flat is asked again after so many fits.
    qc_restFits = 7,
    // Beyond these a power of two, or its inverse, or a product with one, may leave the range of double.
    qc_largestExponent = 960
};

//  ---- topology ------------------------------------------------------------------------------------

/// Groups of eight on each level, up to one.
static qcStatus LayLevels(qcTriangleBvh* surface)
{
    size_t count = (size_t)surface->clusters.nodeCount * qc_groupSize, total = 0;
    do
    {
        surface->firstGroup[surface->levels] = total;
        surface->groupCount[surface->levels++] = count;
        total += count;
        count = (count + qc_groupSize - 1) / qc_groupSize;
    } while (surface->groupCount[surface->levels - 1] > 1);
    return qcArray_Resize(&surface->groups, total, sizeof(qcBox8), "boxes of a surface");
}

/// Two things that don't wait for each other.
typedef struct Relating
{
    qcTriangleBvh* surface;
    const qcBody* body;
    qcAdjacency adjacency;
    qcWorkerResult results[2];
} Relating;

static void RelatePart(void* context, size_t part, uint32_t worker)
{
    (void)worker;
    Relating* r = context;
    qcTriangleBvh* s = r->surface;
    qcStatus status = part == 0 ? qcClusters_Link(&s->clusters, r->body->indices, r->body->vertexCount)
                                : qcAdjacency_Build(&r->adjacency, s->corners.data, s->corners.count, s->vertexCount);
    (void)qcWorkerResult_Add(&r->results[part], status);
}

static qcStatus Relate(Relating* r, uint32_t threads)
{
    qcTriangleBvh* surface = r->surface;
    qcParallel_For(threads, 2, 2, RelatePart, r);
    for (int i = 0; i < 2; i++)
        QC_TRY(qcWorkerResult_Check(&r->results[i]));
    QC_TRY(qcFlatPatches_Build(&surface->discs, &surface->clusters, &r->adjacency, surface->corners.data,
                               surface->vertexCount, threads));
    QC_TRY(qcArray_Resize(&surface->flat, surface->discs.patches.count, 1, "discs of a surface"));
    surface->rest.count = 0;
    return qcArray_GrowZeroed(&surface->rest, surface->discs.patches.count, 1, "discs of a surface");
}

qcStatus qcTriangleBvh_Relate(qcTriangleBvh* surface, const qcBody* body, uint32_t threads)
{
    if (surface->related)
        return qc_statusOk;
    Relating relating = {.surface = surface, .body = body};
    qcStatus status = Relate(&relating, threads);
    qcAdjacency_Free(&relating.adjacency);
    if (status != qc_statusOk)
        qcClusters_Unlink(&surface->clusters);
    surface->related = status == qc_statusOk;
    return status;
}

static qcStatus Build(qcTriangleBvh* surface, const qcBody* body, uint32_t threads)
{
    QC_TRY(qcClusters_Arrange(&surface->clusters, body->indices, body->triangleCount,
                              body->deforming ? body->world : body->local, body->vertexCount, threads));
    QC_TRY(qcClusters_NumberVertices(&surface->clusters, body->indices, body->vertexCount, &surface->corners,
                                     &surface->vertexOf));
    surface->vertexCount = (uint32_t)surface->vertexOf.count;
    QC_TRY(LayLevels(surface));
    QC_TRY(qcArray_Resize(&surface->points, (size_t)surface->vertexCount + 1, sizeof(qcPoint), "points of a surface"));
    QC_AT(qcPoint, surface->points, surface->vertexCount) = (qcPoint){{0}};
    if (qcBody_HasSelfCollision(body))
        QC_TRY(qcTriangleBvh_Relate(surface, body, threads));
    surface->generation = body->generation;
    return qc_statusOk;
}

qcStatus qcTriangleBvh_Build(qcTriangleBvh* surface, const qcBody* body, uint32_t threads)
{
    *surface = (qcTriangleBvh){0};
    qcStatus status = Build(surface, body, threads);
    if (status != qc_statusOk)
        qcTriangleBvh_Free(surface);
    return status;
}

//  ---- positions -----------------------------------------------------------------------------------

static bool FindMap(qcLatticeTransform* map, const double lower[3], const double upper[3], double margin,
                    double extent[3])
{
    double widest = 0.0;
    *map = (qcLatticeTransform){.origin = {0.0}};
    for (int axis = 0; axis < 3; axis++)
    {
        map->origin[axis] = lower[axis] - margin;
        map->margin[axis] = margin;
        // As the kernels compute it.
        extent[axis] = upper[axis] + margin + margin - map->origin[axis];
        widest = fmax(widest, extent[axis]);
    }
    int exponent = 0;
    if (widest > 0.0)
        frexp(widest, &exponent);
    if (!isfinite(widest) || exponent > qc_largestExponent)
        return false;
    exponent = exponent < -qc_largestExponent ? -qc_largestExponent : exponent;
    for (int axis = 0; axis < 3; axis++)
    {
        map->unit[axis] = ldexp(1.0, -exponent);
        // A flat body's thin axis doesn't get levels finer than coordinates are.
        double levels = 65533.0 * (1.0 - 0x1p-50) / fmax(extent[axis], widest * 0x1p-30);
        map->scale[axis] = widest > 0.0 ? fmin(levels, 0x1p1000) : 1.0;
    }
    return true;
}

typedef struct Fitting
{
    qcTriangleBvh* surface;
    const qcTriangleKernels* kernels;
    qcVertexRange range;
    qcBoxRow *vertices, *rows;
} Fitting;

static void MapBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    qcVertexRange range = f->range;
    range.first = block * qc_vertexBlock;
    range.end = range.end - range.first < qc_vertexBlock ? range.end : range.first + qc_vertexBlock;
    f->kernels->map(&f->surface->map, &range, f->surface->points.data, f->vertices);
}

/// Clusters, and the nodes that have them.
static void FitBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    const qcTriangleBvh* s = f->surface;
    size_t first = block * qc_clusterBlock, end = first + qc_clusterBlock;
    end = end < s->groupCount[0] ? end : s->groupCount[0];
    qcBox8* groups = s->groups.data;
    f->kernels->fitTriangles(s->corners.data, f->vertices, first, end, groups, f->rows);
    f->kernels->fitGroups(f->rows, first / qc_groupSize, end / qc_groupSize, groups + s->firstGroup[1],
                          f->rows + s->groupCount[0]);
}

static size_t BlockCount(size_t count, size_t size)
{
    return (count + size - 1) / size;
}

/// Rows of a level begin at a multiple of eight and are followed by empty ones up to the next.
static void FillUp(qcBoxRow* rows, size_t count)
{
    for (; count % qc_groupSize != 0; count++)
        for (int k = 0; k < 8; k++)
            rows[count].ends[k] = qc_emptyEnd;
}

static void FitUpperLevels(const Fitting* f)
{
    qcTriangleBvh* s = f->surface;
    qcBoxRow* rows = f->rows + s->groupCount[0];
    size_t count = s->groupCount[1];
    for (uint32_t level = 2; level < s->levels; level++)
    {
        FillUp(rows, count);
        qcBoxRow* next = rows + BlockCount(count, qc_groupSize) * qc_groupSize;
        count = s->groupCount[level];
        f->kernels->fitGroups(rows, 0, count, (qcBox8*)s->groups.data + s->firstGroup[level], next);
        rows = next;
    }
    qcBoxRow around;
    FillUp(rows, 1);
    f->kernels->fitGroups(rows, 0, 1, &s->whole, &around);
}

static bool FitsLocally(const qcBody* body)
{
    return !body->deforming && !qcBody_HasSelfCollision(body) && qcTransform_IsInvertible(&body->transform);
}

bool qcTriangleBvh_IsFitted(const qcTriangleBvh* surface, const qcBody* body, double margin)
{
    bool isLocal = FitsLocally(body);
    return surface->fitted && surface->isLocal == isLocal &&
           (isLocal || (surface->moved == body->moved && surface->margin == margin));
}

qcStatus qcTriangleBvh_Fit(qcTriangleBvh* surface, const qcBody* body, double margin, const qcTriangleKernels* kernels,
                           uint32_t threads, qcBvhScratch* scratch, bool* fits)
{
    *fits = true;
    if (qcTriangleBvh_IsFitted(surface, body, margin))
        return qc_statusOk;
    bool isLocal = FitsLocally(body);
    surface->fitted = false;
    surface->noted.count = 0;
    surface->isLocal = isLocal;
    margin = isLocal ? 0.0 : margin;
    *fits = FindMap(&surface->map, isLocal ? body->localLower : body->lower, isLocal ? body->localUpper : body->upper,
                    margin, surface->limit);
    if (!*fits)
        return qc_statusOk;
    const double* positions = isLocal ? body->local : body->world;
    if (positions == NULL && body->vertexCount != 0)
    {
        QC_TRY(qcArray_Resize(&scratch->positions, 3 * (size_t)body->vertexCount, sizeof(double), "fitting a surface"));
        for (uint32_t v = 0; v < body->vertexCount; v++)
            qcBody_GetVertex(body, v, &QC_AT(double, scratch->positions, 3 * (size_t)v));
        positions = scratch->positions.data;
    }
    size_t rowCount = 2 * qc_groupSize;
    for (uint32_t level = 0; level < surface->levels; level++)
        rowCount += surface->groupCount[level] + qc_groupSize;
    QC_TRY(qcArray_Resize(&scratch->vertices, (size_t)surface->vertexCount + 1, sizeof(qcBoxRow), "fitting a surface"));
    QC_TRY(qcArray_Resize(&scratch->rows, rowCount, sizeof(qcBoxRow), "fitting a surface"));
    Fitting fitting = {.surface = surface,
                       .kernels = kernels,
                       .range = {positions, surface->vertexOf.data, 0, surface->vertexCount},
                       .vertices = scratch->vertices.data,
                       .rows = scratch->rows.data};
    for (int k = 0; k < 8; k++)
        fitting.vertices[surface->vertexCount].ends[k] = qc_emptyEnd;
    qcParallel_For(threads, BlockCount(surface->vertexCount, qc_vertexBlock), qc_leastBlocks, MapBlock, &fitting);
    qcParallel_For(threads, BlockCount(surface->groupCount[0], qc_clusterBlock), qc_leastBlocks, FitBlock, &fitting);
    FitUpperLevels(&fitting);
    surface->pointError = 0x1p-24f;
    surface->moved = body->moved;
    surface->margin = margin;
    surface->fitted = true;
    surface->fits++;
    surface->flatKnown = false;
    return qc_statusOk;
}

//  ---- flat discs ----------------------------------------------------------------------------------

float qcTriangleBvh_Reach(const qcTriangleBvh* surface, double margin)
{
    double reach = margin * surface->map.unit[0];
    return reach > 0.0 ? nextafterf((float)reach, INFINITY) : 0.0f;
}

static bool AskDisc(const Fitting* f, uint32_t disc)
{
    qcTriangleBvh* s = f->surface;
    const qcFlatPatch* d = &QC_AT(qcFlatPatch, s->discs.patches, disc);
    uint8_t *flat = &QC_AT(uint8_t, s->flat, disc), *rest = &QC_AT(uint8_t, s->rest, disc);
    *flat = 0;
    if (d->slotCount == 0)
        return false;
    if (*rest > 0)
    {
        (*rest)--;
        return false;
    }
    qcPatchGeometry what = {.corners = s->corners.data,
                            .points = s->points.data,
                            .places = &QC_AT(uint32_t, s->discs.slots, d->firstSlot),
                            .loop = &QC_AT(uint32_t, s->discs.loops, d->firstLoop),
                            .placeCount = d->slotCount,
                            .loopCount = d->loopCount,
                            .pointError = s->pointError,
                            .reach = qcTriangleBvh_Reach(s, s->margin)};
    *flat = f->kernels->isFlat(&what);
    *rest = *flat ? 0 : qc_restFits;
    return *flat;
}

/// Large discs first: where one is flat, the small ones around its nodes have little to add.
static void AskBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    const qcTriangleBvh* s = f->surface;
    uint32_t nodes = s->discs.nodeCount, first = (uint32_t)block * qc_discBlock * qc_patchNodes;
    uint32_t end = nodes - first < qc_discBlock * qc_patchNodes ? nodes : first + qc_discBlock * qc_patchNodes;
    for (uint32_t node = first; node < end; node++)
    {
        uint32_t large = qcFlatPatches_Large(&s->discs, node);
        if (node % qc_patchNodes == 0)
            (void)AskDisc(f, large);
        if (!qcTriangleBvh_IsFlat(s, large))
            (void)AskDisc(f, node);
        else
            QC_AT(uint8_t, s->flat, node) = 0;
    }
}

void qcTriangleBvh_FindFlat(qcTriangleBvh* surface, const qcTriangleKernels* kernels, uint32_t threads)
{
    if (surface->flatKnown)
        return;
    Fitting fitting = {.surface = surface, .kernels = kernels};
    size_t blocks = BlockCount(surface->discs.nodeCount, (size_t)qc_discBlock * qc_patchNodes);
    qcParallel_For(threads, blocks, qc_leastBlocks, AskBlock, &fitting);
    surface->flatKnown = true;
}

uint64_t qcTriangleBvh_CountFlat(const qcTriangleBvh* surface)
{
    const qcFlatPatches* discs = &surface->discs;
    uint64_t count = 0;
    for (uint32_t node = 0; node < discs->nodeCount; node++)
    {
        const uint64_t* own = &QC_AT(uint64_t, discs->own, qc_patchSizes * (size_t)node);
        uint64_t flat = (qcTriangleBvh_IsFlat(surface, node) ? own[0] : 0) |
                        (qcTriangleBvh_IsFlat(surface, qcFlatPatches_Large(discs, node)) ? own[1] : 0);
        count += (uint64_t)__builtin_popcountll(flat);
    }
    return count;
}

int qcTriangleBvh_FindSkips(const qcTriangleBvh* surface, uint32_t node, uint32_t link,
                            qcPairExclusion skips[qc_maxExclusions])
{
    const qcFlatPatches* discs = &surface->discs;
    const qcPatchLink* ring = &QC_AT(qcPatchLink, discs->links, link);
    const uint64_t* own = discs->own.data;
    uint32_t other = QC_AT(qcLeafLink, surface->clusters.links, link).other;
    int count = 0;
    for (int size = 0; size < qc_patchSizes; size++)
    {
        uint32_t disc = size == 0 ? node : qcFlatPatches_Large(discs, node),
                 discOfOther = size == 0 ? other : qcFlatPatches_Large(discs, other);
        if (qcTriangleBvh_IsFlat(surface, disc) && ring->ofNode[size] != 0)
            skips[count++] = (qcPairExclusion){own[qc_patchSizes * (size_t)node + size], ring->ofNode[size]};
        if (disc != discOfOther && qcTriangleBvh_IsFlat(surface, discOfOther) && ring->ofOther[size] != 0)
            skips[count++] = (qcPairExclusion){ring->ofOther[size], own[qc_patchSizes * (size_t)other + size]};
    }
    return count;
}

void qcTriangleBvh_Free(qcTriangleBvh* surface)
{
    qcClusters_Free(&surface->clusters);
    qcFlatPatches_Free(&surface->discs);
    qcVertexFans_Free(&surface->stars);
    qcArray_Free(&surface->quiet);
    qcArray_Free(&surface->flat);
    qcArray_Free(&surface->rest);
    qcArray_Free(&surface->vertexOf);
    qcArray_Free(&surface->corners);
    qcArray_Free(&surface->points);
    qcArray_Free(&surface->groups);
    qcArray_Free(&surface->noted);
    qcArray_Free(&surface->nameOf);
    qcArray_Free(&surface->strayed);
    qcArray_Free(&surface->placeMarks);
    *surface = (qcTriangleBvh){0};
}

void qcBvhScratch_Free(qcBvhScratch* scratch)
{
    qcArray_Free(&scratch->positions);
    qcArray_Free(&scratch->vertices);
    qcArray_Free(&scratch->rows);
}
