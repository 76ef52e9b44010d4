// Minimum-translation fallback. If the normal of one pair separates the whole region for less than half of its deepest
// contact, pairs more than twice as deep adopt that normal; where pairs only touch, all that are as deep. The minimum
// translational distance of two bodies (Cameron, Culley, 1986), for the region alone and along normals of its own
// pairs.
//
// Propagated normals and signs are local: at a corner sunk into a concave edge some pairs can get a normal along which
// the bodies overlap ten times deeper than necessary. Their depths are correct for that normal, but the normal is not
// the one to resolve. Limits: plugin/docs/manifolds.md.
#include "manifold/normal_cost.h"
#include "base/status.h"

#include <math.h>

enum
{
    // Normals that are evaluated for one region; most have fewer than ten.
    qc_maxCandidates = 32
};

// A pair is too deep if the whole region is separated by this share of its depth. Where surfaces are flush all pairs
// may touch only, and none need have the way out as its normal: a normal of a face that is no longer is taken, too.
static const double s_muchShorter = 0.5, s_noLonger = 1.0 + 0x1p-20;

typedef struct Job
{
    const qcContactInput* input;
    qcPairOverlaps* overlaps;
    qcContactNormals* normals;
} Job;

/// The pairs of a region.
typedef struct Members
{
    const qcSortItem* items; ///< their values are pairs
    size_t count;
    bool penetrating; ///< a pair penetrates: those that touch are no candidates
    double deepest;
    uint32_t last; ///< the pair that ruled out the last candidate; tested first, as it often rules out the next
} Members;

/// A normal that separates the region, and the distance by which side 0 moves along it.
typedef struct Translation
{
    qcVector normal;
    double length;
} Translation;

static double ShareOf(const Members* members)
{
    return members->penetrating ? s_muchShorter : s_noLonger;
}

static uint32_t PairOf(const Members* members, size_t i)
{
    return (uint32_t)members->items[i].value;
}

static double DepthOf(const Job* job, uint32_t pair)
{
    bool flipped = qcContactNormals_Pair(job->normals, pair)->flipped;
    const qcRawPoint* corners = qcPairOverlaps_Corners(job->overlaps, pair);
    double depth = 0.0;
    for (int i = 0; i < qcPairOverlaps_Count(job->overlaps, pair); i++)
        depth = fmax(depth, flipped ? corners[i].distance : -corners[i].distance);
    return depth;
}

static double LengthAlong(const Job* job, uint32_t index, qcVector normal)
{
    return qcManifoldPair_LengthAlong(qcContactTopology_Pair(job->input->topology, index), normal);
}

/// Replaces the best translation if that along the normal is shorter.
static void Evaluate(const Job* job, qcVector normal, Members* members, Translation* best)
{
    double length = fmax(LengthAlong(job, members->last, normal), 0.0);
    for (size_t i = 0; i < members->count && length < best->length; i++)
    {
        double own = LengthAlong(job, PairOf(members, i), normal);
        if (own >= best->length)
            members->last = PairOf(members, i);
        length = fmax(length, own);
    }
    if (length < best->length)
        *best = (Translation){normal, length};
}

/// Normals that have been evaluated for a region.
typedef struct Candidates
{
    qcVector normals[qc_maxCandidates];
    int count;
} Candidates;

/// Evaluates a normal, unless it is zero or has been evaluated.
static void Try(const Job* job, qcVector normal, Candidates* candidates, Members* members, Translation* best)
{
    int known = 0;
    while (known < candidates->count && qcDot(candidates->normals[known], normal) < QC_MANIFOLD_FLAT)
        known++;
    bool isUnit = qcDot(normal, normal) > 0.5;
    if (!isUnit || known < candidates->count || candidates->count == qc_maxCandidates)
        return;
    candidates->normals[candidates->count++] = normal;
    Evaluate(job, normal, members, best);
}

/// The shortest translation that is shorter than the share of the deepest contact. If there is none, the length of the
/// result is that share, and its normal is unused.
static Translation FindTranslation(const Job* job, Members* members)
{
    Candidates candidates = {.count = 0};
    Translation best = {.length = ShareOf(members) * members->deepest};
    for (size_t i = 0; i < members->count && best.length > 0.0; i++)
    {
        uint32_t p = PairOf(members, i);
        const qcPairProximity* proximity = qcContactProximity_Pair(job->input->proximity, p);
        if (members->penetrating ? !proximity->penetrating : proximity->separated)
            continue;
        Try(job, qcContactNormals_Pair(job->normals, p)->normal, &candidates, members, &best);
        for (int side = 0; side < 2 && !members->penetrating; side++)
        {
            qcVector face = qcContactTopology_Pair(job->input->topology, p)->side[side]->normal;
            Try(job, face, &candidates, members, &best);
            Try(job, qcNegated(face), &candidates, members, &best);
        }
    }
    return best;
}

static qcStatus ShortenRegion(const Job* job, Members* members)
{
    for (size_t i = 0; i < members->count; i++)
    {
        double depth = DepthOf(job, PairOf(members, i));
        if (depth > members->deepest)
            members->last = PairOf(members, i);
        members->deepest = fmax(members->deepest, depth);
    }
    Translation best = FindTranslation(job, members);
    if (!(best.length < ShareOf(members) * members->deepest))
        return qc_statusOk;
    for (size_t i = 0; i < members->count; i++)
        if (ShareOf(members) * DepthOf(job, PairOf(members, i)) > best.length)
            QC_TRY(qcContactNormals_Set(job->input, PairOf(members, i), best.normal, job->overlaps, job->normals));
    return qc_statusOk;
}

static const qcRegionProximity* RegionOf(const qcContactInput* input, uint32_t pair)
{
    return qcContactProximity_Region(input->proximity, qcContactTopology_Pair(input->topology, pair));
}

/// The pairs of regions that intersect, by region; within one in their order.
static qcStatus ListMembers(const qcContactInput* input, qcContactNormals* normals)
{
    size_t unsettled = input->regions->unsettledPairs.count;
    QC_TRY(qcArray_Reserve(&normals->items, unsettled, sizeof(qcSortItem), "pairs of regions"));
    normals->items.count = 0;
    for (size_t i = 0; i < unsettled; i++)
    {
        uint32_t p = qcContactRegions_UnsettledPair(input->regions, i);
        if (RegionOf(input, p)->ambiguous)
            QC_AT(qcSortItem, normals->items, normals->items.count++) =
                (qcSortItem){qcContactTopology_Pair(input->topology, p)->region, p};
    }
    return qcSort_Items(normals->items.data, normals->items.count, &normals->sortScratch);
}

qcStatus qcContactNormals_Shorten(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals)
{
    Job job = {input, overlaps, normals};
    QC_TRY(ListMembers(input, normals));
    const qcSortItem* items = normals->items.data;
    for (size_t first = 0, end = 0; first < normals->items.count; first = end)
    {
        while (end < normals->items.count && items[end].key == items[first].key)
            end++;
        uint32_t pair = (uint32_t)items[first].value;
        Members members = {.items = items + first,
                           .count = end - first,
                           .penetrating = RegionOf(input, pair)->penetrating,
                           .last = pair};
        QC_TRY(ShortenRegion(&job, &members));
    }
    return qc_statusOk;
}
