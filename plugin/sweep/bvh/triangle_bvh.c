// Builds the topology once, fits boxes and points to new positions. Levels are rounded so that boxes within the margin
// overlap.
// Proof: plugin/docs/proofs/triangle_bvh.md.
#include "sweep/bvh/triangle_bvh.h"

#include "base/parallel_for.h"
#include "base/rigid_transform.h"
#include "base/status.h"
#include "scene/float_positions.h"
#include "sweep/bvh/bvh_lattice.h"

#include <math.h>
#include <string.h>

enum
{
    // Vertices, and clusters (a multiple of the lanes): a block takes about a microsecond.
    qc_vertexBlock = 512,
    qc_clusterBlock = 128,
    qc_nodeBlock = qc_clusterBlock / qc_boxLanes,
    qc_minBlocks = 32,
    // Vertices that are transformed together on demand: about half as many as a leaf node has.
    qc_markedVertices = 16,
    // An outline pays if no more than one in so many leaf nodes is fitted later. Otherwise the next fits are whole. (27
    // bunnies with 40 to 50 % of them: an outline adds a tenth to the step. 8 bunnies with 10 %: it saves a third.)
    qc_outlineShare = 3,
    qc_wholeFits = 15,
    // From one measured fit to the next.
    qc_measuredFits = 16
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

/// All that follows from the clusters and the numbers of vertices.
static qcStatus LayBoxes(qcTriangleBvh* bvh, const qcBody* body)
{
    bvh->vertexCount = (uint32_t)bvh->vertexOf.count;
    LayLevels(bvh);
    QC_TRY(AllocateFit(bvh, &bvh->fit));
    const qcVertexSource source = {.doubles = body->deforming ? body->world : body->local,
                                   .vertexOf = bvh->vertexOf.data};
    bvh->triangleSize = qcBvhLattice_TriangleSize(bvh, &source);
    bvh->generation = body->generation;
    return qc_statusOk;
}

/// All that follows from the clusters.
static qcStatus LayOut(qcTriangleBvh* bvh, const qcBody* body, uint32_t threads)
{
    QC_TRY(qcClusters_NumberVertices(&bvh->clusters, body->indices, body->vertexCount, threads, &bvh->corners,
                                     &bvh->vertexOf));
    return LayBoxes(bvh, body);
}

static qcStatus Build(qcTriangleBvh* bvh, const qcBody* body, const qcOrderOptions* options)
{
    QC_TRY(qcClusters_Arrange(&bvh->clusters, body->indices, body->triangleCount,
                              body->deforming ? body->world : body->local, body->vertexCount, options));
    return LayOut(bvh, body, options->threads);
}

qcStatus qcTriangleBvh_Build(qcTriangleBvh* bvh, const qcBody* body, const qcOrderOptions* options)
{
    *bvh = (qcTriangleBvh){0};
    qcStatus status = Build(bvh, body, options);
    if (status != qc_statusOk)
        qcTriangleBvh_Free(bvh);
    return status;
}

static qcStatus BuildLike(qcTriangleBvh* bvh, const qcBody* body, const qcTriangleBvh* other)
{
    QC_TRY(qcClusters_CopyOrder(&bvh->clusters, &other->clusters));
    QC_TRY(qcArray_Append(&bvh->corners, &other->corners, sizeof(qcCorners), "vertices of nodes"));
    QC_TRY(qcArray_Append(&bvh->vertexOf, &other->vertexOf, sizeof(uint32_t), "vertices of nodes"));
    return LayBoxes(bvh, body);
}

qcStatus qcTriangleBvh_BuildLike(qcTriangleBvh* bvh, const qcBody* body, const qcTriangleBvh* other)
{
    *bvh = (qcTriangleBvh){0};
    qcStatus status = BuildLike(bvh, body, other);
    if (status != qc_statusOk)
        qcTriangleBvh_Free(bvh);
    return status;
}

qcStatus qcTriangleBvh_Complete(qcTriangleBvh* bvh, const qcBody* body, const qcOrderOptions* options)
{
    qcClusters clusters = bvh->clusters;
    bvh->clusters = (qcClusters){0};
    qcTriangleBvh_Free(bvh);
    bvh->clusters = clusters;
    qcStatus status = qcClusters_Complete(&bvh->clusters, body->indices, body->triangleCount, body->world,
                                          body->vertexCount, options);
    if (status == qc_statusOk)
        status = LayOut(bvh, body, options->threads);
    if (status != qc_statusOk)
        qcTriangleBvh_Free(bvh);
    return status;
}

qcStatus qcTriangleBvh_KeepRegion(qcTriangleBvh* bvh, const qcBody* body, const qcBvhRegion* region)
{
    if (!bvh->clusters.isLimited)
        return qc_statusOk;
    bvh->region = qcAllocate(sizeof *region);
    if (bvh->region == NULL)
        return qcFailMemory(sizeof *region, "the region of a BVH");
    *bvh->region = *region;
    return qcBvhRegion_SetReference(bvh->region, body);
}

//  ---- fit -----------------------------------------------------------------------------------------

typedef struct Fitting
{
    const qcTriangleBvh* bvh;
    qcBvhFit* fit;
    const qcTriangleKernels* kernels;
    qcVertexSource source;
    qcBoxRow *vertices, *rows;
    const uint8_t *nodeFlags, *marks; ///< of FitNodes
} Fitting;

static void TransformBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    size_t first = block * qc_vertexBlock, left = f->bvh->vertexCount - first;
    const qcVertexRange range = {f->source, first, first + (left < qc_vertexBlock ? left : qc_vertexBlock)};
    f->kernels->transformVertices(&f->fit->lattice, &range, f->fit->points.data, f->vertices);
}

/// Clusters first .. end - 1, and their leaf nodes.
static void FitClusters(const Fitting* f, size_t first, size_t end)
{
    const qcTriangleBvh* bvh = f->bvh;
    qcBox8* boxes = f->fit->boxes.data;
    f->kernels->fitTriangles(bvh->corners.data, f->vertices, first, end, boxes, f->rows);
    f->kernels->fitBoxes(f->rows, first / qc_boxLanes, end / qc_boxLanes, boxes + bvh->firstBox8[1],
                         f->rows + bvh->box8Count[0]);
}

static void FitBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    size_t first = block * qc_clusterBlock, left = f->bvh->box8Count[0] - first;
    FitClusters(f, first, first + (left < qc_clusterBlock ? left : qc_clusterBlock));
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

bool qcTriangleBvh_IsOutlineUpToDate(const qcTriangleBvh* bvh, const qcBody* body, double margin)
{
    bool isLocal = qcTriangleBvh_FitsLocally(body);
    return bvh->fit.fitted && bvh->fit.isLocal == isLocal &&
           (isLocal || (bvh->fit.revision == body->moved && bvh->fit.margin == margin));
}

bool qcTriangleBvh_IsUpToDate(const qcTriangleBvh* bvh, const qcBody* body, double margin)
{
    return !bvh->fit.isOutline && qcTriangleBvh_IsOutlineUpToDate(bvh, body, margin);
}

/// The positions to fit: the body's own, or those of a rigid body in the world, which are computed into the scratch.
static qcStatus GetSource(const qcTriangleBvh* bvh, const qcBody* body, const Pose* pose, bool isLocal,
                          qcBvhScratch* scratch, qcVertexSource* source)
{
    *source = (qcVertexSource){.doubles = isLocal ? body->local : pose->world, .vertexOf = bvh->vertexOf.data};
    if (pose->world == body->world && qcBody_IsInFloats(body))
        *source = (qcVertexSource){.floats = body->floats->at, .vertexOf = bvh->vertexOf.data};
    if (source->doubles != NULL || source->floats != NULL || body->vertexCount == 0)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&scratch->positions, 3 * (size_t)body->vertexCount, sizeof(double), "fitting a BVH"));
    for (uint32_t v = 0; v < body->vertexCount; v++)
        qcTransform_Apply(pose->transform, pose->isIdentity, body->local + 3 * (size_t)v,
                          &QC_AT(double, scratch->positions, 3 * (size_t)v));
    source->doubles = scratch->positions.data;
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

static Fitting MakeFitting(const qcTriangleBvh* bvh, qcBvhFit* fit, const qcVertexSource* source,
                           const qcTriangleKernels* kernels, const qcBvhScratch* scratch)
{
    Fitting fitting = {.bvh = bvh,
                       .fit = fit,
                       .kernels = kernels,
                       .source = *source,
                       .vertices = scratch->vertices.data,
                       .rows = scratch->rows.data};
    for (int k = 0; k < 8; k++)
        fitting.vertices[bvh->vertexCount].ends[k] = qc_emptyEnd;
    return fitting;
}

static void FitWhole(Fitting* fitting, uint32_t threads)
{
    const qcTriangleBvh* bvh = fitting->bvh;
    qcParallel_For(threads, BlockCount(bvh->vertexCount, qc_vertexBlock), qc_minBlocks, TransformBlock, fitting);
    qcParallel_For(threads, BlockCount(bvh->box8Count[0], qc_clusterBlock), qc_minBlocks, FitBlock, fitting);
    FitUpperLevels(fitting);
}

//  ---- outline -------------------------------------------------------------------------------------

static void BoundBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    size_t first = block * qc_nodeBlock, left = f->bvh->clusters.nodeCount - first;
    f->kernels->boundNodes(&f->fit->lattice, &f->source, &f->bvh->nodeVertices, first,
                           first + (left < qc_nodeBlock ? left : qc_nodeBlock), f->rows + f->bvh->box8Count[0]);
}

static void FitOutline(Fitting* fitting, uint32_t threads)
{
    qcParallel_For(threads, BlockCount(fitting->bvh->clusters.nodeCount, qc_nodeBlock), qc_minBlocks, BoundBlock,
                   fitting);
    FitUpperLevels(fitting);
}

/// Marks the vertices of a leaf node by blocks.
static void MarkVertices(const qcNodeVertices* vertices, uint32_t node, uint8_t* marks)
{
    const uint32_t *firstOwn = vertices->firstOwn.data, *firstShared = vertices->firstShared.data;
    for (uint32_t i = firstOwn[node]; i < firstOwn[node + 1]; i = (i / qc_markedVertices + 1) * qc_markedVertices)
        marks[i / qc_markedVertices] = 1;
    for (uint32_t j = firstShared[node]; j < firstShared[node + 1]; j++)
        marks[QC_AT(uint32_t, vertices->shared, j) / qc_markedVertices] = 1;
}

static void TransformMarked(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    size_t first = block * qc_vertexBlock, left = f->bvh->vertexCount - first;
    size_t end = first + (left < qc_vertexBlock ? left : qc_vertexBlock);
    for (size_t i = first; i < end; i += qc_markedVertices)
    {
        size_t runEnd = i;
        while (runEnd < end && f->marks[runEnd / qc_markedVertices])
            runEnd += qc_markedVertices;
        const qcVertexRange range = {f->source, i, runEnd < end ? runEnd : end};
        if (runEnd != i)
            f->kernels->transformVertices(&f->fit->lattice, &range, f->fit->points.data, f->vertices);
        i = runEnd;
    }
}

static void FitNodeBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Fitting* f = context;
    size_t first = block * qc_nodeBlock, left = f->bvh->clusters.nodeCount - first;
    for (size_t node = first; node < first + (left < qc_nodeBlock ? left : qc_nodeBlock); node++)
        if (f->nodeFlags[node] && !QC_AT(uint8_t, f->fit->fittedNodes, node))
        {
            FitClusters(f, node * qc_boxLanes, (node + 1) * qc_boxLanes);
            QC_AT(uint8_t, f->fit->fittedNodes, node) = 1;
        }
}

static void FitMarked(Fitting* fitting, uint32_t threads)
{
    const qcTriangleBvh* bvh = fitting->bvh;
    qcParallel_For(threads, BlockCount(bvh->vertexCount, qc_vertexBlock), qc_minBlocks, TransformMarked, fitting);
    qcParallel_For(threads, BlockCount(bvh->clusters.nodeCount, qc_nodeBlock), qc_minBlocks, FitNodeBlock, fitting);
}

/// Lists the vertices of leaf nodes, and marks all nodes as not fitted.
static qcStatus BeginOutline(qcTriangleBvh* bvh, qcBvhFit* fit)
{
    uint32_t nodeCount = bvh->clusters.nodeCount;
    if (!qcNodeVertices_AreListed(&bvh->nodeVertices))
        QC_TRY(qcNodeVertices_List(&bvh->nodeVertices, bvh->corners.data, nodeCount, bvh->vertexCount));
    QC_TRY(qcArray_Resize(&fit->fittedNodes, nodeCount, 1, "fitting a BVH"));
    memset(fit->fittedNodes.data, 0, nodeCount);
    fit->fittedCount = 0;
    return qc_statusOk;
}

//  ---- extent --------------------------------------------------------------------------------------

/// The sum of the extents along all axes, without the margin: of all clusters' boxes, or of all leaf nodes'.
static double SumExtents(const qcTriangleBvh* bvh, const qcBvhFit* fit)
{
    uint32_t level = fit->isOutline ? 2 : 1;
    const qcBox8* nodes = qcTriangleBvh_Box8At(bvh, fit, level, 0);
    size_t nodeCount = level < bvh->levels ? bvh->box8Count[level] : 1;
    double sum = 0.0;
    for (int axis = 0; axis < 3; axis++)
    {
        int64_t levels = 0;
        for (size_t node = 0; node < nodeCount; node++)
            for (int i = 0; i < qc_boxLanes; i++)
            {
                int32_t extent = ~nodes[node].ends[axis][qc_boxLanes + i] - nodes[node].ends[axis][i];
                levels += extent > 0 ? extent : 0;
            }
        sum += (double)levels / fit->lattice.scale[axis] - (double)bvh->box8Count[level - 1] * fit->margin;
    }
    return sum;
}

static void MeasureExtent(qcTriangleBvh* bvh)
{
    qcBvhExtent* extent = bvh->fit.isOutline ? &bvh->nodeExtent : &bvh->clusterExtent;
    bool isFirst = !(extent->first > 0.0);
    if (bvh->fit.isLocal || (!isFirst && bvh->fitCount < extent->measuredFit + qc_measuredFits))
        return;
    extent->measuredFit = bvh->fitCount;
    extent->last = SumExtents(bvh, &bvh->fit);
    if (isFirst)
        extent->first = extent->last;
}

//  ---- poses ---------------------------------------------------------------------------------------

/// How to fit.
typedef struct Means
{
    bool isOutline;
    const qcTriangleKernels* kernels;
    uint32_t threads;
    qcBvhScratch* scratch;
} Means;

static qcStatus FitPose(qcTriangleBvh* bvh, qcBvhFit* fit, const qcBody* body, const Pose* pose, bool isLocal,
                        double margin, const Means* means, bool* fits)
{
    fit->fitted = false;
    fit->isLocal = isLocal;
    fit->isOutline = means->isOutline;
    margin = isLocal ? 0.0 : margin;
    qcVertexSource source;
    QC_TRY(GetSource(bvh, body, pose, isLocal, means->scratch, &source));
    *fits = qcBvhLattice_Choose(bvh, &source, isLocal ? body->localLower : pose->lower,
                                isLocal ? body->localUpper : pose->upper, margin, fit);
    if (!*fits)
        return qc_statusOk;
    QC_TRY(ReserveRows(bvh, means->scratch));
    if (means->isOutline)
        QC_TRY(BeginOutline(bvh, fit));
    Fitting fitting = MakeFitting(bvh, fit, &source, means->kernels, means->scratch);
    (means->isOutline ? FitOutline : FitWhole)(&fitting, means->threads);
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
    if (!start->differs || !bvh->fit.fitted || bvh->fit.isLocal || bvh->fit.isOutline ||
        bvh->fit.revision != start->moved || (bvh->startFit.fitted && bvh->startFit.revision == start->moved))
        return qc_statusOk;
    QC_TRY(AllocateFit(bvh, &bvh->startFit));
    qcBvhFit fit = bvh->fit;
    bvh->fit = bvh->startFit;
    bvh->startFit = fit;
    bvh->fit.fitted = false;
    return qc_statusOk;
}

static qcStatus FitPresent(qcTriangleBvh* bvh, const qcBody* body, double margin, const Means* means, bool* fits)
{
    const Pose pose = PresentPose(body);
    QC_TRY(KeepStart(bvh, body));
    QC_TRY(FitPose(bvh, &bvh->fit, body, &pose, FitsLocally(body, &pose), margin, means, fits));
    if (*fits)
        MeasureExtent(bvh);
    return qc_statusOk;
}

qcStatus qcTriangleBvh_Fit(qcTriangleBvh* bvh, const qcBody* body, double margin, const qcTriangleKernels* kernels,
                           uint32_t threads, qcBvhScratch* scratch, bool* fits)
{
    *fits = true;
    if (qcTriangleBvh_IsUpToDate(bvh, body, margin))
        return qc_statusOk;
    const Means means = {false, kernels, threads, scratch};
    bvh->wholeFits -= bvh->wholeFits != 0;
    return FitPresent(bvh, body, margin, &means, fits);
}

qcStatus qcTriangleBvh_FitOutline(qcTriangleBvh* bvh, const qcBody* body, double margin,
                                  const qcTriangleKernels* kernels, uint32_t threads, qcBvhScratch* scratch, bool* fits)
{
    *fits = true;
    if (qcTriangleBvh_IsOutlineUpToDate(bvh, body, margin))
        return qc_statusOk;
    const Means means = {true, kernels, threads, scratch};
    return FitPresent(bvh, body, margin, &means, fits);
}

qcStatus qcTriangleBvh_FitNodes(qcTriangleBvh* bvh, const qcBody* body, const uint8_t* flags,
                                const qcTriangleKernels* kernels, uint32_t threads, qcBvhScratch* scratch)
{
    const Pose pose = PresentPose(body);
    qcVertexSource source;
    QC_TRY(GetSource(bvh, body, &pose, false, scratch, &source));
    QC_TRY(ReserveRows(bvh, scratch));
    size_t markCount = BlockCount(bvh->vertexCount, qc_markedVertices);
    QC_TRY(qcArray_Resize(&scratch->marks, markCount, 1, "fitting a BVH"));
    memset(scratch->marks.data, 0, markCount);
    for (uint32_t node = 0; node < bvh->clusters.nodeCount; node++)
        if (flags[node] && !QC_AT(uint8_t, bvh->fit.fittedNodes, node))
        {
            MarkVertices(&bvh->nodeVertices, node, scratch->marks.data);
            bvh->fit.fittedCount++;
        }
    if (bvh->fit.fittedCount > bvh->clusters.nodeCount / qc_outlineShare)
        bvh->wholeFits = qc_wholeFits;
    Fitting fitting = MakeFitting(bvh, &bvh->fit, &source, kernels, scratch);
    fitting.nodeFlags = flags;
    fitting.marks = scratch->marks.data;
    FitMarked(&fitting, threads);
    return qc_statusOk;
}

bool qcTriangleBvh_IsMotionUpToDate(const qcTriangleBvh* bvh, const qcBody* body)
{
    const Pose present = PresentPose(body), start = StartPose(body);
    bool isLocal = FitsLocally(body, &present) && FitsLocally(body, &start);
    if (!bvh->fit.fitted || bvh->fit.isOutline || bvh->fit.isLocal != isLocal)
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
    const Means means = {false, kernels, threads, scratch};
    bool isLocal = FitsLocally(body, &present) && FitsLocally(body, &start);
    QC_TRY(KeepStart(bvh, body));
    if (!bvh->fit.fitted || bvh->fit.isOutline || bvh->fit.isLocal != isLocal ||
        (!isLocal && bvh->fit.revision != body->moved))
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
    qcArray_Free(&bvh->fit.fittedNodes);
    qcNodeVertices_Free(&bvh->nodeVertices);
    qcArray_Free(&bvh->startFit.fittedNodes);
    qcArray_Free(&bvh->startFit.points);
    qcArray_Free(&bvh->startFit.boxes);
    qcBvhRegion_Delete(bvh->region);
    *bvh = (qcTriangleBvh){0};
}

void qcBvhScratch_Free(qcBvhScratch* scratch)
{
    qcArray_Free(&scratch->positions);
    qcArray_Free(&scratch->vertices);
    qcArray_Free(&scratch->rows);
    qcArray_Free(&scratch->marks);
}
