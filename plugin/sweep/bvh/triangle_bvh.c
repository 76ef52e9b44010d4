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
    // Vertices, and clusters (a multiple of the lanes): a block takes about a microsecond.
    qc_vertexBlock = 512,
    qc_clusterBlock = 128,
    qc_minBlocks = 32,
    // From one measured fit to the next.
    qc_measuredFits = 16,
    // Beyond these a power of two, or its inverse, or a product with one, may leave the range of double.
    qc_maxExponent = 960
};

//  ---- topology ------------------------------------------------------------------------------------

/// Lays out the boxes of each level, up to the level with one qcBox8.
static void LayLevels(qcTriangleBvh* bvh)
{
    size_t count = (size_t)bvh->clusters.nodeCount * qc_boxLanes, total = 0;
    do
    {
        bvh->firstBox8[bvh->levels] = total;
        bvh->box8Count[bvh->levels++] = count;
        total += count;
        count = (count + qc_boxLanes - 1) / qc_boxLanes;
    } while (bvh->box8Count[bvh->levels - 1] > 1);
    bvh->totalBox8Count = total;
}

static qcStatus AllocateFit(const qcTriangleBvh* bvh, qcBvhFit* fit)
{
    QC_TRY(qcArray_Resize(&fit->boxes, bvh->totalBox8Count, sizeof(qcBox8), "boxes of a BVH"));
    QC_TRY(qcArray_Resize(&fit->points, (size_t)bvh->vertexCount + 1, sizeof(qcPoint), "points of a BVH"));
    QC_AT(qcPoint, fit->points, bvh->vertexCount) = (qcPoint){{0.0f, 0.0f, 0.0f, (float)qc_emptyEnd}};
    return qc_statusOk;
}

static qcStatus Build(qcTriangleBvh* bvh, const qcBody* body, uint32_t threads)
{
    QC_TRY(qcClusters_Arrange(&bvh->clusters, body->indices, body->triangleCount,
                              body->deforming ? body->world : body->local, body->vertexCount, threads));
    QC_TRY(qcClusters_NumberVertices(&bvh->clusters, body->indices, body->vertexCount, threads, &bvh->corners,
                                     &bvh->vertexOf));
    bvh->vertexCount = (uint32_t)bvh->vertexOf.count;
    LayLevels(bvh);
    QC_TRY(AllocateFit(bvh, &bvh->fit));
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
    const qcTriangleBvh* bvh;
    qcBvhFit* fit;
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
    f->kernels->transformVertices(&f->fit->lattice, &range, f->fit->points.data, f->vertices);
}

/// Clusters, and their leaf nodes.
static void FitBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    const qcTriangleBvh* bvh = f->bvh;
    size_t first = block * qc_clusterBlock, end = first + qc_clusterBlock;
    end = end < bvh->box8Count[0] ? end : bvh->box8Count[0];
    qcBox8* boxes = f->fit->boxes.data;
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
    const qcTriangleBvh* bvh = f->bvh;
    qcBoxRow* rows = f->rows + bvh->box8Count[0];
    size_t count = bvh->box8Count[1];
    for (uint32_t level = 2; level < bvh->levels; level++)
    {
        PadWithEmptyRows(rows, count);
        qcBoxRow* next = rows + BlockCount(count, qc_boxLanes) * qc_boxLanes;
        count = bvh->box8Count[level];
        f->kernels->fitBoxes(rows, 0, count, (qcBox8*)f->fit->boxes.data + bvh->firstBox8[level], next);
        rows = next;
    }
    qcBoxRow around;
    PadWithEmptyRows(rows, 1);
    f->kernels->fitBoxes(rows, 0, 1, &f->fit->root, &around);
}

/// Where a body is at the present, or at the start of a motion.
typedef struct Pose
{
    const double* world; ///< of a deforming body
    const qcTransform* transform;
    bool isIdentity;
    const double *lower, *upper;
    uint64_t moved;
} Pose;

static Pose PresentPose(const qcBody* body)
{
    return (Pose){body->world, &body->transform, body->isIdentity, body->lower, body->upper, body->moved};
}

static Pose StartPose(const qcBody* body)
{
    const qcBodyStart* start = &body->start;
    if (!start->differs)
        return PresentPose(body);
    return (Pose){start->world, &start->transform, start->isIdentity, start->lower, start->upper, start->moved};
}

static bool FitsLocally(const qcBody* body, const Pose* pose)
{
    return !body->deforming && !qcBody_HasSelfCollision(body) && qcTransform_IsInvertible(pose->transform);
}

bool qcTriangleBvh_FitsLocally(const qcBody* body)
{
    const Pose pose = PresentPose(body);
    return FitsLocally(body, &pose);
}

bool qcTriangleBvh_IsUpToDate(const qcTriangleBvh* bvh, const qcBody* body, double margin)
{
    bool isLocal = qcTriangleBvh_FitsLocally(body);
    return bvh->fit.fitted && bvh->fit.isLocal == isLocal &&
           (isLocal || (bvh->fit.revision == body->moved && bvh->fit.margin == margin));
}

/// The positions to fit: the body's own, or those of a rigid body in the world, which are computed into the scratch.
static qcStatus GetPositions(const qcBody* body, const Pose* pose, bool isLocal, qcBvhScratch* scratch,
                             const double** positions)
{
    *positions = isLocal ? body->local : pose->world;
    if (*positions != NULL || body->vertexCount == 0)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&scratch->positions, 3 * (size_t)body->vertexCount, sizeof(double), "fitting a BVH"));
    for (uint32_t v = 0; v < body->vertexCount; v++)
        qcTransform_Apply(pose->transform, pose->isIdentity, body->local + 3 * (size_t)v,
                          &QC_AT(double, scratch->positions, 3 * (size_t)v));
    *positions = scratch->positions.data;
    return qc_statusOk;
}

static qcStatus ReserveRows(const qcTriangleBvh* bvh, qcBvhScratch* scratch)
{
    size_t rowCount = (size_t)2 * qc_boxLanes;
    for (uint32_t level = 0; level < bvh->levels; level++)
        rowCount += bvh->box8Count[level] + qc_boxLanes;
    QC_TRY(qcArray_Resize(&scratch->vertices, (size_t)bvh->vertexCount + 1, sizeof(qcBoxRow), "fitting a BVH"));
    return qcArray_Resize(&scratch->rows, rowCount, sizeof(qcBoxRow), "fitting a BVH");
}

static void FitTo(const qcTriangleBvh* bvh, qcBvhFit* fit, const double* positions, const qcTriangleKernels* kernels,
                  uint32_t threads, qcBvhScratch* scratch)
{
    Fitting fitting = {.bvh = bvh,
                       .fit = fit,
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

/// The sum of the extents of all clusters' boxes along all axes, without the margin.
static double SumExtents(const qcTriangleBvh* bvh, const qcBvhFit* fit)
{
    const qcBox8* nodes = (const qcBox8*)fit->boxes.data + bvh->firstBox8[1];
    double sum = 0.0;
    for (int axis = 0; axis < 3; axis++)
    {
        int64_t levels = 0;
        for (size_t node = 0; node < bvh->box8Count[1]; node++)
            for (int i = 0; i < qc_boxLanes; i++)
            {
                int32_t extent = ~nodes[node].ends[axis][qc_boxLanes + i] - nodes[node].ends[axis][i];
                levels += extent > 0 ? extent : 0;
            }
        sum += (double)levels / fit->lattice.scale[axis] - (double)bvh->box8Count[0] * fit->margin;
    }
    return sum;
}

static void MeasureExtent(qcTriangleBvh* bvh)
{
    if (bvh->fit.isLocal || (bvh->firstExtent > 0.0 && bvh->fitCount < bvh->measuredFit + qc_measuredFits))
        return;
    bvh->measuredFit = bvh->fitCount;
    bvh->lastExtent = SumExtents(bvh, &bvh->fit);
    if (!(bvh->firstExtent > 0.0))
        bvh->firstExtent = bvh->lastExtent;
}

/// What a fit needs besides the BVH and the body.
typedef struct Means
{
    const qcTriangleKernels* kernels;
    uint32_t threads;
    qcBvhScratch* scratch;
} Means;

static qcStatus FitPose(qcTriangleBvh* bvh, qcBvhFit* fit, const qcBody* body, const Pose* pose, bool isLocal,
                        double margin, const Means* means, bool* fits)
{
    fit->fitted = false;
    fit->isLocal = isLocal;
    margin = isLocal ? 0.0 : margin;
    *fits = ChooseLattice(&fit->lattice, isLocal ? body->localLower : pose->lower,
                          isLocal ? body->localUpper : pose->upper, margin, fit->latticeExtent);
    if (!*fits)
        return qc_statusOk;
    const double* positions;
    QC_TRY(GetPositions(body, pose, isLocal, means->scratch, &positions));
    QC_TRY(ReserveRows(bvh, means->scratch));
    FitTo(bvh, fit, positions, means->kernels, means->threads, means->scratch);
    fit->pointError = 0x1p-24f;
    fit->revision = pose->moved;
    fit->margin = margin;
    fit->fitted = true;
    fit->fitCount = ++bvh->fitCount;
    return qc_statusOk;
}

/// Moves the last fit to the start of the motion if it is that of its positions.
static qcStatus KeepStart(qcTriangleBvh* bvh, const qcBody* body)
{
    const qcBodyStart* start = &body->start;
    if (!start->differs || !bvh->fit.fitted || bvh->fit.isLocal || bvh->fit.revision != start->moved ||
        (bvh->startFit.fitted && bvh->startFit.revision == start->moved))
        return qc_statusOk;
    QC_TRY(AllocateFit(bvh, &bvh->startFit));
    qcBvhFit fit = bvh->fit;
    bvh->fit = bvh->startFit;
    bvh->startFit = fit;
    bvh->fit.fitted = false;
    return qc_statusOk;
}

qcStatus qcTriangleBvh_Fit(qcTriangleBvh* bvh, const qcBody* body, double margin, const qcTriangleKernels* kernels,
                           uint32_t threads, qcBvhScratch* scratch, bool* fits)
{
    *fits = true;
    if (qcTriangleBvh_IsUpToDate(bvh, body, margin))
        return qc_statusOk;
    QC_TRY(KeepStart(bvh, body));
    const Pose pose = PresentPose(body);
    const Means means = {kernels, threads, scratch};
    QC_TRY(FitPose(bvh, &bvh->fit, body, &pose, FitsLocally(body, &pose), margin, &means, fits));
    if (*fits)
        MeasureExtent(bvh);
    return qc_statusOk;
}

bool qcTriangleBvh_IsMotionUpToDate(const qcTriangleBvh* bvh, const qcBody* body)
{
    const Pose present = PresentPose(body), start = StartPose(body);
    bool isLocal = FitsLocally(body, &present) && FitsLocally(body, &start);
    if (!bvh->fit.fitted || bvh->fit.isLocal != isLocal)
        return false;
    return isLocal || (bvh->fit.revision == body->moved &&
                       (!body->start.differs ||
                        (bvh->startFit.fitted && !bvh->startFit.isLocal && bvh->startFit.revision == start.moved)));
}

qcStatus qcTriangleBvh_FitMotion(qcTriangleBvh* bvh, const qcBody* body, const qcTriangleKernels* kernels,
                                 uint32_t threads, qcBvhScratch* scratch, bool* fits)
{
    *fits = true;
    if (qcTriangleBvh_IsMotionUpToDate(bvh, body))
        return qc_statusOk;
    const Pose present = PresentPose(body), start = StartPose(body);
    const Means means = {kernels, threads, scratch};
    bool isLocal = FitsLocally(body, &present) && FitsLocally(body, &start);
    QC_TRY(KeepStart(bvh, body));
    if (!bvh->fit.fitted || bvh->fit.isLocal != isLocal || (!isLocal && bvh->fit.revision != body->moved))
        QC_TRY(FitPose(bvh, &bvh->fit, body, &present, isLocal, 0.0, &means, fits));
    if (!*fits || isLocal || !body->start.differs ||
        (bvh->startFit.fitted && !bvh->startFit.isLocal && bvh->startFit.revision == start.moved))
        return qc_statusOk;
    QC_TRY(AllocateFit(bvh, &bvh->startFit));
    return FitPose(bvh, &bvh->startFit, body, &start, false, 0.0, &means, fits);
}

float qcTriangleBvh_DistanceInFrame(const qcTriangleBvh* bvh, double distance)
{
    double scaled = distance * bvh->fit.lattice.unit[0];
    return scaled > 0.0 ? nextafterf((float)scaled, INFINITY) : 0.0f;
}

void qcTriangleBvh_Free(qcTriangleBvh* bvh)
{
    qcClusters_Free(&bvh->clusters);
    qcArray_Free(&bvh->vertexOf);
    qcArray_Free(&bvh->corners);
    qcArray_Free(&bvh->fit.points);
    qcArray_Free(&bvh->fit.boxes);
    qcArray_Free(&bvh->startFit.points);
    qcArray_Free(&bvh->startFit.boxes);
    *bvh = (qcTriangleBvh){0};
}

void qcBvhScratch_Free(qcBvhScratch* scratch)
{
    qcArray_Free(&scratch->positions);
    qcArray_Free(&scratch->vertices);
    qcArray_Free(&scratch->rows);
}
