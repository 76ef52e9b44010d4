// Builds the topology once, fits boxes and points to new positions. Levels are rounded so that boxes within the margin
// overlap.
// Proof: plugin/docs/proofs/triangle_bvh.md.
#include "sweep/bvh/triangle_bvh.h"

#include "base/parallel_for.h"
#include "base/rigid_transform.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    // Vertices, and clusters: a block takes some 10 microseconds.
    qc_vertexBlock = 2048,
    qc_clusterBlock = 256,
    qc_minBlocks = 4,
    // Beyond these a power of two, or its inverse, or a product with one, may leave the range of double.
    qc_maxExponent = 960
};

//  ---- topology ------------------------------------------------------------------------------------

/// Lays out the boxes of each level, up to the level with one qcBox8.
static qcStatus LayLevels(qcTriangleBvh* bvh)
{
    size_t count = (size_t)bvh->clusters.nodeCount * qc_boxLanes, total = 0;
    do
    {
        bvh->firstBox8[bvh->levels] = total;
        bvh->box8Count[bvh->levels++] = count;
        total += count;
        count = (count + qc_boxLanes - 1) / qc_boxLanes;
    } while (bvh->box8Count[bvh->levels - 1] > 1);
    return qcArray_Resize(&bvh->boxes, total, sizeof(qcBox8), "boxes of a BVH");
}

static qcStatus Build(qcTriangleBvh* bvh, const qcBody* body, uint32_t threads)
{
    QC_TRY(qcClusters_Arrange(&bvh->clusters, body->indices, body->triangleCount,
                              body->deforming ? body->world : body->local, body->vertexCount, threads));
    QC_TRY(qcClusters_NumberVertices(&bvh->clusters, body->indices, body->vertexCount, &bvh->corners, &bvh->vertexOf));
    bvh->vertexCount = (uint32_t)bvh->vertexOf.count;
    QC_TRY(LayLevels(bvh));
    QC_TRY(qcArray_Resize(&bvh->points, (size_t)bvh->vertexCount + 1, sizeof(qcPoint), "points of a BVH"));
    QC_AT(qcPoint, bvh->points, bvh->vertexCount) = (qcPoint){{0}};
    bvh->generation = body->generation;
    return qc_statusOk;
}

qcStatus qcTriangleBvh_Build(qcTriangleBvh* bvh, const qcBody* body, uint32_t threads)
{
    *bvh = (qcTriangleBvh){0};
    qcStatus status = Build(bvh, body, threads);
    if (status != qc_statusOk)
        qcTriangleBvh_Free(bvh);
    return status;
}

//  ---- fit -----------------------------------------------------------------------------------------

/// False: the box is too large for a lattice.
static bool ChooseLattice(qcLatticeTransform* lattice, const double lower[3], const double upper[3], double margin,
                          double extent[3])
{
    double widest = 0.0;
    *lattice = (qcLatticeTransform){.origin = {0.0}};
    for (int axis = 0; axis < 3; axis++)
    {
        lattice->origin[axis] = lower[axis] - margin;
        lattice->margin[axis] = margin;
        // In the order of the kernels, so that it rounds like them.
        extent[axis] = upper[axis] + margin + margin - lattice->origin[axis];
        widest = fmax(widest, extent[axis]);
    }
    int exponent = 0;
    if (widest > 0.0)
        frexp(widest, &exponent);
    if (!isfinite(widest) || exponent > qc_maxExponent)
        return false;
    exponent = exponent < -qc_maxExponent ? -qc_maxExponent : exponent;
    for (int axis = 0; axis < 3; axis++)
    {
        lattice->unit[axis] = ldexp(1.0, -exponent);
        // Along the thin axis of a flat body levels are no finer than the precision of coordinates.
        double levels = 65533.0 * (1.0 - 0x1p-50) / fmax(extent[axis], widest * 0x1p-30);
        lattice->scale[axis] = widest > 0.0 ? fmin(levels, 0x1p1000) : 1.0;
    }
    return true;
}

typedef struct Fitting
{
    qcTriangleBvh* bvh;
    const qcTriangleKernels* kernels;
    qcVertexRange range;
    qcBoxRow *vertices, *rows;
} Fitting;

static void TransformBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    qcVertexRange range = f->range;
    range.first = block * qc_vertexBlock;
    range.end = range.end - range.first < qc_vertexBlock ? range.end : range.first + qc_vertexBlock;
    f->kernels->transformVertices(&f->bvh->lattice, &range, f->bvh->points.data, f->vertices);
}

/// Clusters, and their leaf nodes.
static void FitBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    const qcTriangleBvh* bvh = f->bvh;
    size_t first = block * qc_clusterBlock, end = first + qc_clusterBlock;
    end = end < bvh->box8Count[0] ? end : bvh->box8Count[0];
    qcBox8* boxes = bvh->boxes.data;
    f->kernels->fitTriangles(bvh->corners.data, f->vertices, first, end, boxes, f->rows);
    f->kernels->fitBoxes(f->rows, first / qc_boxLanes, end / qc_boxLanes, boxes + bvh->firstBox8[1],
                         f->rows + bvh->box8Count[0]);
}

static size_t BlockCount(size_t count, size_t size)
{
    return (count + size - 1) / size;
}

/// The rows of a level begin at a multiple of eight; empty rows follow up to the next multiple.
static void PadWithEmptyRows(qcBoxRow* rows, size_t count)
{
    for (; count % qc_boxLanes != 0; count++)
        for (int k = 0; k < 8; k++)
            rows[count].ends[k] = qc_emptyEnd;
}

static void FitUpperLevels(const Fitting* f)
{
    qcTriangleBvh* bvh = f->bvh;
    qcBoxRow* rows = f->rows + bvh->box8Count[0];
    size_t count = bvh->box8Count[1];
    for (uint32_t level = 2; level < bvh->levels; level++)
    {
        PadWithEmptyRows(rows, count);
        qcBoxRow* next = rows + BlockCount(count, qc_boxLanes) * qc_boxLanes;
        count = bvh->box8Count[level];
        f->kernels->fitBoxes(rows, 0, count, (qcBox8*)bvh->boxes.data + bvh->firstBox8[level], next);
        rows = next;
    }
    qcBoxRow around;
    PadWithEmptyRows(rows, 1);
    f->kernels->fitBoxes(rows, 0, 1, &bvh->root, &around);
}

static bool FitsLocally(const qcBody* body)
{
    return !body->deforming && !qcBody_HasSelfCollision(body) && qcTransform_IsInvertible(&body->transform);
}

bool qcTriangleBvh_IsUpToDate(const qcTriangleBvh* bvh, const qcBody* body, double margin)
{
    bool isLocal = FitsLocally(body);
    return bvh->fitted && bvh->isLocal == isLocal &&
           (isLocal || (bvh->revision == body->moved && bvh->margin == margin));
}

/// The positions to fit: the body's own, or those of a rigid body in the world, which are computed into the scratch.
static qcStatus GetPositions(const qcBody* body, bool isLocal, qcBvhScratch* scratch, const double** positions)
{
    *positions = isLocal ? body->local : body->world;
    if (*positions != NULL || body->vertexCount == 0)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&scratch->positions, 3 * (size_t)body->vertexCount, sizeof(double), "fitting a BVH"));
    for (uint32_t v = 0; v < body->vertexCount; v++)
        qcBody_GetVertex(body, v, &QC_AT(double, scratch->positions, 3 * (size_t)v));
    *positions = scratch->positions.data;
    return qc_statusOk;
}

static qcStatus ReserveRows(const qcTriangleBvh* bvh, qcBvhScratch* scratch)
{
    size_t rowCount = 2 * qc_boxLanes;
    for (uint32_t level = 0; level < bvh->levels; level++)
        rowCount += bvh->box8Count[level] + qc_boxLanes;
    QC_TRY(qcArray_Resize(&scratch->vertices, (size_t)bvh->vertexCount + 1, sizeof(qcBoxRow), "fitting a BVH"));
    return qcArray_Resize(&scratch->rows, rowCount, sizeof(qcBoxRow), "fitting a BVH");
}

static void FitTo(qcTriangleBvh* bvh, const double* positions, const qcTriangleKernels* kernels, uint32_t threads,
                  qcBvhScratch* scratch)
{
    Fitting fitting = {.bvh = bvh,
                       .kernels = kernels,
                       .range = {positions, bvh->vertexOf.data, 0, bvh->vertexCount},
                       .vertices = scratch->vertices.data,
                       .rows = scratch->rows.data};
    for (int k = 0; k < 8; k++)
        fitting.vertices[bvh->vertexCount].ends[k] = qc_emptyEnd;
    qcParallel_For(threads, BlockCount(bvh->vertexCount, qc_vertexBlock), qc_minBlocks, TransformBlock, &fitting);
    qcParallel_For(threads, BlockCount(bvh->box8Count[0], qc_clusterBlock), qc_minBlocks, FitBlock, &fitting);
    FitUpperLevels(&fitting);
}

qcStatus qcTriangleBvh_Fit(qcTriangleBvh* bvh, const qcBody* body, double margin, const qcTriangleKernels* kernels,
                           uint32_t threads, qcBvhScratch* scratch, bool* fits)
{
    *fits = true;
    if (qcTriangleBvh_IsUpToDate(bvh, body, margin))
        return qc_statusOk;
    bool isLocal = FitsLocally(body);
    bvh->fitted = false;
    bvh->isLocal = isLocal;
    margin = isLocal ? 0.0 : margin;
    *fits = ChooseLattice(&bvh->lattice, isLocal ? body->localLower : body->lower,
                          isLocal ? body->localUpper : body->upper, margin, bvh->latticeExtent);
    if (!*fits)
        return qc_statusOk;
    const double* positions;
    QC_TRY(GetPositions(body, isLocal, scratch, &positions));
    QC_TRY(ReserveRows(bvh, scratch));
    FitTo(bvh, positions, kernels, threads, scratch);
    bvh->pointError = 0x1p-24f;
    bvh->revision = body->moved;
    bvh->margin = margin;
    bvh->fitted = true;
    bvh->fitCount++;
    return qc_statusOk;
}

float qcTriangleBvh_DistanceInFrame(const qcTriangleBvh* bvh, double distance)
{
    double scaled = distance * bvh->lattice.unit[0];
    return scaled > 0.0 ? nextafterf((float)scaled, INFINITY) : 0.0f;
}

void qcTriangleBvh_Free(qcTriangleBvh* bvh)
{
    qcClusters_Free(&bvh->clusters);
    qcArray_Free(&bvh->vertexOf);
    qcArray_Free(&bvh->corners);
    qcArray_Free(&bvh->points);
    qcArray_Free(&bvh->boxes);
    *bvh = (qcTriangleBvh){0};
}

void qcBvhScratch_Free(qcBvhScratch* scratch)
{
    qcArray_Free(&scratch->positions);
    qcArray_Free(&scratch->vertices);
    qcArray_Free(&scratch->rows);
}
