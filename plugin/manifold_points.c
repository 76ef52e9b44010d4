// The points of each pair: the corners of what the two triangles have in common, seen along the pair's normal. In
// parallel.
//
// They are what a resting box stands on, where the closest points of the pair would be just one point somewhere in
// between. A corner farther apart than the margin is no contact.
//
// A pair without corners (all beyond the margin, seen edge-on, or one that took its normal from its faces or a
// neighbour and lies beside it rather than over it) leaves its place to the pairs around it, or to the one that
// surpassed it, which comes nearer. If these have no point either, what it said itself is the point. So every pair is
// heard: by a point of its own, or of a pair beside it, or of one that says the same; or something comes nearer.
#include "manifold_parts.h"
#include "parallel.h"
#include "status.h"

#include <math.h>
#include <string.h>

enum
{
    qc_pointBlock = 128,
    // A block takes some 50 microseconds.
    qc_leastPointBlocks = 8
};

typedef struct Sink
{
    qcArray points; ///< of qcRawPoint
    qcStatus status;
    char apart[64]; ///< keeps the counts of two workers off one cache line
} Sink;

/// Where the points of a block of pairs are.
typedef struct Block
{
    uint32_t worker;
    size_t first;
} Block;

typedef struct Job
{
    qcManifolds* manifolds;
    const qcProximity* proximities;
    double margin;
} Job;

/// The points of a pair so far.
typedef struct Found
{
    double tolerance;
    qcRawPoint points[qc_maxCommonCorners + 1];
    int count;
} Found;

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

/// Of points over the same place the first stays.
static void Keep(Found* found, const qcRawPoint* point)
{
    for (int i = 0; i < found->count; i++)
        if (qcRawPoint_AreSame(point, &found->points[i], found->tolerance))
            return;
    found->points[found->count++] = *point;
}

/// What the pair said itself, turned if that is how the pairs around a crossing agreed.
static qcRawPoint Witness(const qcManifolds* m, uint32_t index, const qcProximity* proximities)
{
    const qcManifoldPair* pair = qcManifolds_Pair(m, index);
    const qcProximity* proximity = &proximities[pair->source];
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
    bool isFree = !pair->parted || QC_AT(qcContactRegion, m->numbered, pair->region).crossing;
    if (isFree && qcDot(pair->reported, pair->normal) < 0.0)
        point.normal = qcNegated(point.normal);
    point.distance = qcDot(qcMinus(point.end[0], point.end[1]), point.normal);
    return point;
}

static void FindPoints(const Job* job, uint32_t index, Found* found)
{
    const qcManifoldPair* pair = qcManifolds_Pair(job->manifolds, index);
    found->tolerance = QC_AT(qcContactRegion, job->manifolds->numbered, pair->region).tolerance;
    found->count = 0;
    double size = fmax(qcManifoldPair_LongestEdge(pair, 0), qcManifoldPair_LongestEdge(pair, 1));
    double rounding = QC_MANIFOLD_ROUNDING * size, limit = job->margin * (1.0 + QC_MANIFOLD_ROUNDING) + rounding;
    qcRawPoint corners[qc_maxCommonCorners];
    int count = qcManifoldPair_FindCommonPart(pair, pair->normal, corners);
    SortByDepth(corners, count, rounding);
    for (int i = 0; i < count; i++)
        if (corners[i].distance <= limit)
            Keep(found, &corners[i]);
    // Nothing comes nearer than the closest points, which are over each other along their own normal: some corner is
    // as near, unless rounding or a face seen edge-on has hidden it.
    bool hidden = found->count != 0 && found->points[0].distance > pair->gap + 1e3 * rounding;
    if (pair->apart && pair->own && !pair->turned && hidden)
        found->points[found->count++] = Witness(job->manifolds, index, job->proximities);
}

static void TakeBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    qcManifolds* m = job->manifolds;
    Sink* sink = &QC_AT(Sink, m->sinks, worker);
    size_t end = (block + 1) * qc_pointBlock;
    end = end < m->work.count ? end : m->work.count;
    QC_AT(Block, m->blocks, block) = (Block){worker, sink->points.count};
    for (size_t p = block * qc_pointBlock; p < end && sink->status == qc_statusOk; p++)
    {
        Found found;
        FindPoints(job, (uint32_t)p, &found);
        QC_AT(size_t, m->firstRaw, p) = (size_t)found.count;
        size_t count = sink->points.count + (size_t)found.count;
        sink->status = qcArray_Reserve(&sink->points, count, sizeof(qcRawPoint), "contact points");
        if (sink->status != qc_statusOk)
            return;
        for (int i = 0; i < found.count; i++)
        {
            found.points[i].pair = (uint32_t)p;
            QC_AT(qcRawPoint, sink->points, sink->points.count++) = found.points[i];
        }
    }
}

static qcStatus EmptySinks(qcManifolds* m, uint32_t threads)
{
    size_t old = m->sinks.count;
    if (threads > old)
    {
        QC_TRY(qcArray_Resize(&m->sinks, threads, sizeof(Sink), "contact points"));
        memset(&QC_AT(Sink, m->sinks, old), 0, (threads - old) * sizeof(Sink));
    }
    for (size_t i = 0; i < m->sinks.count; i++)
    {
        QC_AT(Sink, m->sinks, i).points.count = 0;
        QC_AT(Sink, m->sinks, i).status = qc_statusOk;
    }
    return qc_statusOk;
}

/// Neither the pair nor one beside it has a point, and none comes nearer. `counts`: points by pair.
static bool IsUnheard(const qcManifolds* m, uint32_t pair, const size_t* counts)
{
    if (counts[pair] != 0 || qcManifolds_Pair(m, pair)->surpassed)
        return false;
    qcBeside ring[qc_maxRing];
    uint32_t count = qcManifolds_CollectRing(m, pair, ring);
    for (uint32_t i = 0; i < count; i++)
        if (counts[ring[i].pair] != 0)
            return false;
    return true;
}

/// All points in the order of their pairs; in firstRaw, where those of each pair begin.
static qcStatus Gather(const Job* job)
{
    qcManifolds* m = job->manifolds;
    size_t* counts = m->firstRaw.data;
    m->raw.count = 0;
    // Room for all the workers' points, and for one of each pair that has none.
    size_t total = m->work.count;
    for (size_t i = 0; i < m->sinks.count; i++)
        total += QC_AT(Sink, m->sinks, i).points.count;
    QC_TRY(qcArray_Reserve(&m->raw, total, sizeof(qcRawPoint), "contact points"));
    QC_TRY(qcArray_Resize(&m->unheard, m->work.count, 1, "contact points"));
    for (uint32_t p = 0; p < m->work.count; p++)
        QC_AT(bool, m->unheard, p) = IsUnheard(m, p, counts);
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        Block* block = &QC_AT(Block, m->blocks, p / qc_pointBlock);
        size_t count = counts[p];
        QC_AT(size_t, m->firstRaw, p) = m->raw.count;
        if (QC_AT(bool, m->unheard, p))
        {
            QC_AT(qcRawPoint, m->raw, m->raw.count++) = Witness(m, p, job->proximities);
        }
        if (count != 0)
            memcpy(&QC_AT(qcRawPoint, m->raw, m->raw.count),
                   &QC_AT(qcRawPoint, QC_AT(Sink, m->sinks, block->worker).points, block->first),
                   count * sizeof(qcRawPoint));
        m->raw.count += count;
        block->first += count;
    }
    QC_AT(size_t, m->firstRaw, m->work.count) = m->raw.count;
    return qc_statusOk;
}

qcStatus qcManifolds_FindPoints(qcManifolds* m, const qcProximity* proximities, double margin, uint32_t threads)
{
    size_t blocks = (m->work.count + qc_pointBlock - 1) / qc_pointBlock;
    QC_TRY(EmptySinks(m, threads));
    QC_TRY(qcArray_Resize(&m->blocks, blocks, sizeof(Block), "contact points"));
    QC_TRY(qcArray_Resize(&m->firstRaw, m->work.count + 1, sizeof(size_t), "contact points"));
    Job job = {m, proximities, margin};
    qcParallel_For(threads, blocks, qc_leastPointBlocks, TakeBlock, &job);
    for (size_t i = 0; i < m->sinks.count; i++)
        // The message is the worker's own; say it again on this thread.
        if (QC_AT(Sink, m->sinks, i).status != qc_statusOk)
            return qcArray_FailAgain(&QC_AT(Sink, m->sinks, i).points, "contact points");
    return Gather(&job);
}

void qcManifolds_FreeSinks(qcManifolds* m)
{
    for (size_t i = 0; i < m->sinks.count; i++)
        qcArray_Free(&QC_AT(Sink, m->sinks, i).points);
    qcArray_Free(&m->sinks);
}
