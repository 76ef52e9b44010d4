// The points of each pair: the corners of what the two triangles have in common, seen along the pair's normal. In
// parallel.
//
// They are what a resting box stands on, where the closest points of the pair would be just one point somewhere in
// between. A corner farther apart than the margin is no contact.
//
// A pair without corners (all beyond the margin, seen edge-on, or one that took its normal from its faces or a
// neighbour and lies beside it rather than over it) leaves its place to the pairs around it, or to the one that
// surpassed it, which comes nearer. If these have no point either, what it said itself is the point. So every pair is
// heard: by a point of its own, or of a pair beside it, or of one that says the same; or something comes nearer. Where
// one plane parts a whole region its points are enough: there the pairs themselves were never asked.
#include "manifold/overlap_kernels.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // A block takes some 30 microseconds.
    qc_pointBlock = 256,
    qc_leastPointBlocks = 8,
    // Views that are kept of either side; a block's pairs have fewer triangles, mostly.
    qc_keptViews = 128
};

typedef struct Job
{
    qcManifoldBuilder* manifolds;
    const qcMeetingInput* input;
} Job;

/// The deepest first; those that differ by rounding only in the order in which they were found.
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

/// What the pair said itself, turned if that is how the pairs around a crossing agreed.
static qcRawPoint Witness(const Job* job, uint32_t index)
{
    const qcManifoldBuilder* m = job->manifolds;
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    const qcProximity* proximity = &job->input->proximities[pair->source];
    qcRawPoint point = {.end = {qcVector_Load(proximity->pointA), qcVector_Load(proximity->pointB)},
                        .normal = pair->reported,
                        .pair = index,
                        .feature = {{UINT32_MAX, UINT32_MAX}, {UINT32_MAX, UINT32_MAX}}};
    if (pair->swapped)
    {
        qcVector swap = point.end[0];
        point.end[0] = point.end[1];
        point.end[1] = swap;
    }
    bool isFree = !pair->parted || QC_AT(qcContactRegion, m->measured, pair->region).crossing;
    if (isFree && qcDot(pair->reported, pair->normal) < 0.0)
        point.normal = qcNegated(point.normal);
    point.distance = qcDot(qcMinus(point.end[0], point.end[1]), point.normal);
    return point;
}

/// Of points over the same place the first stays.
static bool IsAnyAsGood(const qcRawPoint* points, int count, const qcRawPoint* point, double tolerance)
{
    for (int i = 0; i < count; i++)
        if (qcRawPoint_AreSame(point, &points[i], tolerance))
            return true;
    return false;
}

/// A triangle seen along the normal of the pair's region. Neighbours in the list have it too, and ask soon.
static qcTriangleView* ViewOf(qcTriangleView* kept, const qcManifoldPair* pair, int side)
{
    const qcManifoldTriangle* triangle = pair->side[side];
    qcTriangleView* view = &kept[(unsigned)side * qc_keptViews + triangle->index % qc_keptViews];
    if (view->triangle != triangle || view->region != pair->region)
        qcTriangleView_Begin(view, triangle);
    view->region = pair->region;
    return view;
}

static qcStatus EmptyViews(qcManifoldWorker* worker)
{
    QC_TRY(qcArray_Resize(&worker->views, 2 * qc_keptViews, sizeof(qcTriangleView), "contact points"));
    for (size_t i = 0; i < worker->views.count; i++)
        QC_AT(qcTriangleView, worker->views, i).triangle = NULL;
    return qc_statusOk;
}

/// Corners of a pair whose region a plane parts, into the worker's list, which has room.
static void FindCorners(qcManifoldBuilder* m, uint32_t index, uint32_t worker, double limit)
{
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    qcArray* points = &QC_AT(qcManifoldWorker, m->workers, worker).points;
    qcVector origin = pair->side[1]->corner[0];
    qcWaysOut ways = qcWaysOut_Of(qcManifoldTriangle_Heights(pair->side[0], origin, pair->normal),
                                  qcManifoldTriangle_Heights(pair->side[1], origin, pair->normal));
    int count = 0;
    qcRawPoint* found = &QC_AT(qcRawPoint, *points, points->count);
    if (ways.along >= -limit)
    {
        qcTriangleView* kept = QC_AT(qcManifoldWorker, m->workers, worker).views.data;
        qcTriangleView* views[2] = {ViewOf(kept, pair, 0), ViewOf(kept, pair, 1)};
        count = m->sight->findCommonPart(pair, pair->normal, views, found);
    }
    for (int i = 0; i < count; i++)
        found[i].pair = index;
    QC_AT(qcPairCorners, m->corners, index) = (qcPairCorners){points->count, (uint16_t)worker, (uint8_t)count};
}

/// Of the corners of what the triangles have in common those that are points stay.
static void FindPoints(const Job* job, uint32_t index)
{
    qcManifoldBuilder* m = job->manifolds;
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    qcPairCorners* corners = &QC_AT(qcPairCorners, m->corners, index);
    double a = pair->side[0]->longestEdge, b = pair->side[1]->longestEdge;
    double rounding = QC_MANIFOLD_ROUNDING * (a > b ? a : b), limit = qcManifoldPair_Limit(pair, job->input->margin);
    qcRawPoint* points = qcManifoldBuilder_Corners(m, index);
    double tolerance = QC_AT(qcContactRegion, m->measured, pair->region).tolerance;
    for (int i = 0; i < corners->count && pair->turned; i++)
    {
        points[i].normal = pair->normal;
        points[i].distance = -points[i].distance;
    }
    SortByDepth(points, corners->count, rounding);
    uint8_t kept = 0;
    for (int i = 0; i < corners->count; i++)
        if (points[i].distance <= limit && !IsAnyAsGood(points, kept, &points[i], tolerance))
            points[kept++] = points[i];
    corners->count = kept;
    // Nothing comes nearer than the closest points, which are over each other along their own normal: some corner is
    // as near, unless rounding or a face seen edge-on has hidden it.
    bool hidden = kept != 0 && points[0].distance > pair->gap + 1e3 * rounding;
    QC_AT(bool, m->witnessed, index) = pair->apart && pair->own && !pair->turned && hidden;
}

static void TakeFreeBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    size_t end = (block + 1) * qc_pointBlock, count = job->manifolds->freePairs.count;
    for (size_t i = block * qc_pointBlock; i < (end < count ? end : count); i++)
        FindPoints(job, qcManifoldBuilder_FreePair(job->manifolds, i));
}

static void TakeSettledBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    qcManifoldWorker* self = &QC_AT(qcManifoldWorker, job->manifolds->workers, worker);
    size_t end = (block + 1) * qc_pointBlock, count = job->manifolds->work.count;
    if (!qcManifoldWorker_ReservePoints(self, qc_pointBlock) || !qcWorkerResult_Add(&self->result, EmptyViews(self)))
        return;
    for (uint32_t p = (uint32_t)(block * qc_pointBlock); p < (end < count ? end : count); p++)
    {
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(job->manifolds, p);
        if (!pair->settled)
            continue;
        FindCorners(job->manifolds, p, worker, qcManifoldPair_Limit(pair, job->input->margin));
        FindPoints(job, p);
        self->points.count += QC_AT(qcPairCorners, job->manifolds->corners, p).count;
    }
}

/// Neither the pair nor one beside it has a point, and none comes nearer.
static bool IsUnheard(const qcManifoldBuilder* m, uint32_t index)
{
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    if (QC_AT(qcPairCorners, m->corners, index).count != 0 || pair->surpassed || pair->settled)
        return false;
    for (int side = 0; side < 2; side++)
    {
        qcRing ring = qcManifoldBuilder_Ring(m, pair, side);
        for (uint32_t i = 0; i < ring.count; i++)
            if (QC_AT(qcPairCorners, m->corners, qcManifoldBuilder_Beside(m, ring.entries[i])->pair).count != 0)
                return false;
    }
    return true;
}

/// All points in the order of their pairs; in firstRaw, where those of each pair begin.
static qcStatus Gather(const Job* job)
{
    qcManifoldBuilder* m = job->manifolds;
    size_t total = 0;
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        bool* witnessed = &QC_AT(bool, m->witnessed, p);
        *witnessed = *witnessed || IsUnheard(m, p);
        total += QC_AT(qcPairCorners, m->corners, p).count + (size_t)*witnessed;
    }
    QC_TRY(qcArray_Reserve(&m->raw, total, sizeof(qcRawPoint), "contact points"));
    m->raw.count = 0;
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        size_t count = QC_AT(qcPairCorners, m->corners, p).count;
        QC_AT(size_t, m->firstRaw, p) = m->raw.count;
        if (count != 0)
            memcpy(&QC_AT(qcRawPoint, m->raw, m->raw.count), qcManifoldBuilder_Corners(m, p),
                   count * sizeof(qcRawPoint));
        m->raw.count += count;
        if (QC_AT(bool, m->witnessed, p))
            QC_AT(qcRawPoint, m->raw, m->raw.count++) = Witness(job, p);
    }
    QC_AT(size_t, m->firstRaw, m->work.count) = m->raw.count;
    return qc_statusOk;
}

qcStatus qcManifoldBuilder_FindPoints(qcManifoldBuilder* m, const qcMeetingInput* input, uint32_t threads)
{
    QC_TRY(qcArray_Resize(&m->corners, m->work.count, sizeof(qcPairCorners), "contact points"));
    QC_TRY(qcArray_Resize(&m->witnessed, m->work.count, sizeof(bool), "contact points"));
    QC_TRY(qcArray_Resize(&m->firstRaw, m->work.count + 1, sizeof(size_t), "contact points"));
    Job job = {m, input};
    // The workers' lists grow with the points of settled pairs: nobody may read what another one holds.
    size_t blocks = (m->freePairs.count + qc_pointBlock - 1) / qc_pointBlock;
    qcParallel_For(threads, blocks, qc_leastPointBlocks, TakeFreeBlock, &job);
    blocks = (m->work.count + qc_pointBlock - 1) / qc_pointBlock;
    if (m->freePairs.count != m->work.count)
        qcParallel_For(threads, blocks, qc_leastPointBlocks, TakeSettledBlock, &job);
    QC_TRY(qcManifoldBuilder_LoopStatus(m));
    return Gather(&job);
}
