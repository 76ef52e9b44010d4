// The points of each pair: the corners of its projected overlap up to the margin. In parallel.
//
// A pair whose overlap is empty within the margin contributes no corners. It is covered if an adjacent pair, or a pair
// that found a closer distance, has a point; otherwise its own closest points are used, the fallback point. In a region
// with a separating plane the corners are enough.
#include "manifold/overlap_kernels.h"
#include "manifold/points.h"
#include "manifold/stage_switches.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // A block takes some 5 to 10 microseconds.
    qc_pointBlock = 64,
    qc_minPointBlocks = 32,
    // Cached views of either side; the pairs of most blocks have fewer triangles.
    qc_cachedViews = 128
};

// Points within this share of the triangles' size are one: in a region, the longest edge of a pair's smaller triangle,
// on average.
static const double s_tolerance = 1.0 / 64.0;

typedef struct Job
{
    const qcContactInput* input;
    const qcContactNormals* normals;
    qcPairOverlaps* overlaps;
    qcContactPoints* points;
} Job;

static const qcManifoldPair* PairOf(const Job* job, uint32_t pair)
{
    return qcContactTopology_Pair(job->input->topology, pair);
}

static qcStatus MeasureRegions(const qcContactTopology* topology, qcContactPoints* points)
{
    uint32_t count = topology->regionCount;
    // The counts of their pairs lie behind the tolerances.
    QC_TRY(qcArray_Resize(&points->tolerances, 2 * (size_t)count, sizeof(double), "regions of contact"));
    double *tolerances = points->tolerances.data, *pairs = tolerances + count;
    for (uint32_t r = 0; r < count; r++)
        tolerances[r] = pairs[r] = 0.0;
    for (uint32_t p = 0; p < topology->pairs.count; p++)
    {
        const qcManifoldPair* pair = qcContactTopology_Pair(topology, p);
        tolerances[pair->region] += s_tolerance * qcManifoldPair_SmallerSize(pair);
        pairs[pair->region]++;
    }
    for (uint32_t r = 0; r < count; r++)
        tolerances[r] /= pairs[r];
    return qc_statusOk;
}

//  ---- corners --------------------------------------------------------------------------------------------

/// A triangle seen along the normal of the pair's region. Adjacent pairs in the list have the same triangle.
static qcTriangleView* ViewOf(qcTriangleView* cached, const qcManifoldPair* pair, int side)
{
    const qcManifoldTriangle* triangle = pair->side[side];
    qcTriangleView* view = &cached[(unsigned)side * qc_cachedViews + triangle->index % qc_cachedViews];
    if (view->triangle != triangle || view->region != pair->region)
        qcTriangleView_Begin(view, triangle);
    view->region = pair->region;
    return view;
}

static qcStatus EmptyViews(qcOverlapWorker* worker)
{
    QC_TRY(qcArray_Resize(&worker->views, (size_t)2 * qc_cachedViews, sizeof(qcTriangleView), "contact points"));
    for (size_t i = 0; i < worker->views.count; i++)
        QC_AT(qcTriangleView, worker->views, i).triangle = NULL;
    return qc_statusOk;
}

/// The overlap of a pair whose region has a separating plane, in the worker's list, which has room.
static void FindSettledCorners(const Job* job, uint32_t index, uint32_t worker)
{
    const qcManifoldPair* pair = PairOf(job, index);
    qcVector normal = qcContactRegions_Of(job->input->regions, pair)->normal;
    qcOverlapWorker* self = qcPairOverlaps_Worker(job->overlaps, worker);
    int count = 0;
    qcRawPoint* found = &QC_AT(qcRawPoint, self->corners, self->corners.count);
    if (qcManifoldPair_Separation(pair, pair->side[1]->corner[0], normal).along >=
        -qcManifoldPair_Limit(pair, job->input->margin))
    {
        qcTriangleView* cached = self->views.data;
        qcTriangleView* views[2] = {ViewOf(cached, pair, 0), ViewOf(cached, pair, 1)};
        count = job->input->kernels->findOverlap(pair, normal, views, found);
    }
    for (int i = 0; i < count; i++)
        found[i].pair = index;
    QC_AT(qcCornerRange, job->overlaps->ranges, index) =
        (qcCornerRange){self->corners.count, (uint16_t)worker, (uint8_t)count};
}

/// Sorts points deepest first. Points whose distances differ by rounding only stay in the order in which they were
/// found.
static void SortByDepth(qcRawPoint* points, int count, double rounding)
{
    for (int i = 1; i < count; i++)
    {
        qcRawPoint point = points[i];
        int at = i;
        for (; at > 0 && points[at - 1].distance > point.distance + rounding; at--)
            points[at] = points[at - 1];
        points[at] = point;
    }
}

static bool IsSameAsAny(const qcRawPoint* points, int count, const qcRawPoint* point, double tolerance)
{
    for (int i = 0; i < count; i++)
        if (qcRawPoint_AreSame(point, &points[i], tolerance))
            return true;
    return false;
}

/// Keeps the corners of the pair's overlap that become points: those within the margin, and of several at one position
/// the deepest.
static void KeepPoints(const Job* job, uint32_t index)
{
    const qcManifoldPair* pair = PairOf(job, index);
    const qcPairNormal* normal = qcContactNormals_Pair(job->normals, index);
    qcCornerRange* range = &QC_AT(qcCornerRange, job->overlaps->ranges, index);
    double a = pair->side[0]->longestEdge, b = pair->side[1]->longestEdge;
    double rounding = QC_MANIFOLD_ROUNDING * (a > b ? a : b);
    double limit = qcManifoldPair_Limit(pair, job->input->margin);
    qcRawPoint* corners = qcPairOverlaps_Corners(job->overlaps, index);
    double tolerance = qcContactPoints_Tolerance(job->points, pair->region);
    for (int i = 0; i < range->count && normal->flipped; i++)
    {
        corners[i].normal = normal->normal;
        corners[i].distance = -corners[i].distance;
    }
    SortByDepth(corners, range->count, rounding);
    uint8_t kept = 0;
    for (int i = 0; i < range->count; i++)
        if (corners[i].distance <= limit && !IsSameAsAny(corners, kept, &corners[i], tolerance))
            corners[kept++] = corners[i];
    range->count = kept;
    // Seen along the reported normal the closest points coincide, so some corner is as close as they are, unless
    // rounding or a face seen edge-on has hidden it.
    bool mayBeHidden = normal->disjoint && normal->keepsReported && !normal->flipped && kept != 0;
    QC_AT(bool, job->points->hasFallback, index) =
        mayBeHidden &&
        corners[0].distance > qcContactProximity_Pair(job->input->proximity, index)->gap + 1e3 * rounding;
}

static void TakeUnsettledBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    size_t end = (block + 1) * qc_pointBlock, count = job->input->regions->unsettledPairs.count;
    for (size_t i = block * qc_pointBlock; i < (end < count ? end : count); i++)
        KeepPoints(job, qcContactRegions_UnsettledPair(job->input->regions, i));
}

static void TakeSettledBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    qcOverlapWorker* self = qcPairOverlaps_Worker(job->overlaps, worker);
    size_t end = (block + 1) * qc_pointBlock, count = job->input->topology->pairs.count;
    if (!qcPairOverlaps_Reserve(job->overlaps, worker, (size_t)qc_pointBlock * qc_maxOverlapCorners) ||
        !qcWorkerResult_Add(&self->result, EmptyViews(self)))
        return;
    for (uint32_t p = (uint32_t)(block * qc_pointBlock); p < (end < count ? end : count); p++)
    {
        if (!qcContactRegions_IsSettled(job->input->regions, PairOf(job, p)))
            continue;
        FindSettledCorners(job, p, worker);
        KeepPoints(job, p);
        self->corners.count += (size_t)qcPairOverlaps_Count(job->overlaps, p);
    }
}

//  ---- fallback points ------------------------------------------------------------------------------------

/// The pair's closest points, or for an intersecting pair the points of its depth. The normal is the reported one. If
/// its sign is undetermined, it gets the sign of the pair's normal.
static qcRawPoint FallbackPoint(const Job* job, uint32_t index)
{
    const qcManifoldPair* pair = PairOf(job, index);
    const qcPairProximity* own = qcContactProximity_Pair(job->input->proximity, index);
    const qcProximity* reported = &job->input->proximity->reported[pair->source];
    qcRawPoint point = {.end = {qcVector_Load(reported->pointA), qcVector_Load(reported->pointB)},
                        .normal = own->normal,
                        .pair = index,
                        .feature = {{UINT32_MAX, UINT32_MAX}, {UINT32_MAX, UINT32_MAX}}};
    if (pair->swapped)
    {
        qcVector swap = point.end[0];
        point.end[0] = point.end[1];
        point.end[1] = swap;
    }
    bool isOpen = !own->separated || qcContactProximity_Region(job->input->proximity, pair)->penetrating;
    if (isOpen && qcDot(own->normal, qcContactNormals_Pair(job->normals, index)->normal) < 0.0)
        point.normal = qcNegated(point.normal);
    point.distance = qcDot(qcMinus(point.end[0], point.end[1]), point.normal);
    return point;
}

/// True if the pair needs a fallback point: it is unsettled, no adjacent pair is closer at its closest features, and
/// neither the pair nor an adjacent one has a point.
static bool IsUncovered(const Job* job, uint32_t index)
{
    const qcPairAdjacency* adjacency = job->input->adjacency;
    if (qcPairOverlaps_Count(job->overlaps, index) != 0 ||
        qcContactNormals_Pair(job->normals, index)->isNoLocalMinimum ||
        qcContactRegions_IsSettled(job->input->regions, PairOf(job, index)))
        return false;
    for (int side = 0; side < 2; side++)
    {
        qcAdjacentPairs adjacent = qcPairAdjacency_Of(adjacency, index, side);
        for (uint32_t i = 0; i < adjacent.count; i++)
            if (qcPairOverlaps_Count(job->overlaps, qcPairAdjacency_Side(adjacency, adjacent.entries[i])->pair) != 0)
                return false;
    }
    return true;
}

//  ---- all points -----------------------------------------------------------------------------------------

/// All points in the order of their pairs.
static qcStatus Gather(const Job* job)
{
    qcContactPoints* points = job->points;
    size_t total = 0, pairs = job->input->topology->pairs.count;
    for (uint32_t p = 0; p < pairs; p++)
    {
        bool* hasFallback = &QC_AT(bool, points->hasFallback, p);
        *hasFallback = QC_STAGE_RUNS(fallbackPoints) && (*hasFallback || IsUncovered(job, p));
        total += (size_t)qcPairOverlaps_Count(job->overlaps, p) + (size_t)*hasFallback;
    }
    QC_TRY(qcArray_Reserve(&points->raw, total, sizeof(qcRawPoint), "contact points"));
    points->raw.count = 0;
    for (uint32_t p = 0; p < pairs; p++)
    {
        size_t count = (size_t)qcPairOverlaps_Count(job->overlaps, p);
        QC_AT(size_t, points->firstOfPair, p) = points->raw.count;
        if (count != 0)
            memcpy(&QC_AT(qcRawPoint, points->raw, points->raw.count), qcPairOverlaps_Corners(job->overlaps, p),
                   count * sizeof(qcRawPoint));
        points->raw.count += count;
        if (QC_AT(bool, points->hasFallback, p))
            QC_AT(qcRawPoint, points->raw, points->raw.count++) = FallbackPoint(job, p);
    }
    QC_AT(size_t, points->firstOfPair, pairs) = points->raw.count;
    return qc_statusOk;
}

qcStatus qcContactPoints_Collect(const qcContactInput* input, const qcContactNormals* normals, qcPairOverlaps* overlaps,
                                 qcContactPoints* points)
{
    size_t pairs = input->topology->pairs.count, unsettled = input->regions->unsettledPairs.count;
    QC_TRY(MeasureRegions(input->topology, points));
    QC_TRY(qcArray_Resize(&points->hasFallback, pairs, sizeof(bool), "contact points"));
    QC_TRY(qcArray_Resize(&points->firstOfPair, pairs + 1, sizeof(size_t), "contact points"));
    Job job = {input, normals, overlaps, points};
    // Settled pairs come second: they add to the workers' lists, which no other thread may read then.
    size_t blocks = (unsettled + qc_pointBlock - 1) / qc_pointBlock;
    qcParallel_For(input->threads, blocks, qc_minPointBlocks, TakeUnsettledBlock, &job);
    blocks = (pairs + qc_pointBlock - 1) / qc_pointBlock;
    if (unsettled != pairs)
        qcParallel_For(input->threads, blocks, qc_minPointBlocks, TakeSettledBlock, &job);
    QC_TRY(qcPairOverlaps_Status(overlaps));
    return Gather(&job);
}

void qcContactPoints_Free(qcContactPoints* points)
{
    qcArray* arrays[] = {
        &points->raw,         &points->firstOfPair, &points->tolerances, &points->order,       &points->representatives,
        &points->nextMembers, &points->heads,       &points->links,      &points->sortScratch, &points->hasFallback};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
