// Minimum-translation fallback. If the normal of one pair separates the whole region for less than half of its deepest
// contact, pairs more than twice as deep adopt that normal. The minimum translational distance of two bodies (Cameron,
// Culley, 1986), for the region alone and along normals of its own pairs.
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

// A pair is too deep if the whole region is separated by this share of its depth.
static const double s_muchShorter = 0.5;

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
    double deepest;
    uint32_t last; ///< the pair that ruled out the last candidate; tested first, as it often rules out the next
} Members;

/// A normal that separates the region, and the distance by which side 0 moves along it.
typedef struct Translation
{
    qcVector normal;
    double length;
} Translation;

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
    const qcManifoldPair* pair = qcContactTopology_Pair(job->input->topology, index);
    return qcManifoldPair_Separation(pair, pair->side[1]->corner[0], normal).along;
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

/// The shortest translation that is shorter than half of the deepest contact. If there is none, the length of the
/// result is half of the deepest contact, and its normal is unused.
static Translation FindTranslation(const Job* job, Members* members)
{
    qcVector evaluated[qc_maxCandidates];
    int count = 0;
    Translation best = {.length = s_muchShorter * members->deepest};
    for (size_t i = 0; i < members->count && count < qc_maxCandidates; i++)
    {
        uint32_t p = PairOf(members, i);
        qcVector normal = qcContactNormals_Pair(job->normals, p)->normal;
        int known = 0;
        while (known < count && qcDot(evaluated[known], normal) < QC_MANIFOLD_FLAT)
            known++;
        if (!qcContactProximity_Pair(job->input->proximity, p)->penetrating || known < count)
            continue;
        evaluated[count++] = normal;
        Evaluate(job, normal, members, &best);
    }
    return best;
}

/// Sets the normal of a pair, and computes its overlap along it.
static qcStatus AdoptNormal(const Job* job, uint32_t index, qcVector normal)
{
    const qcManifoldPair* pair = qcContactTopology_Pair(job->input->topology, index);
    if (!qcPairOverlaps_Reserve(job->overlaps, 0, qc_maxOverlapCorners))
        return qcPairOverlaps_Status(job->overlaps);
    qcPairNormal* own = qcContactNormals_Pair(job->normals, index);
    own->normal = normal;
    own->keepsReported = own->flipped = own->disjoint = false;
    qcProjectedOverlap overlap = {.count = -1};
    qcProjectedOverlap_Compute(job->input->kernels, pair, normal, &overlap);
    qcPairOverlaps_Set(job->overlaps, index, 0, &overlap, normal, false, qcContactInput_CornerLimit(job->input, pair));
    return qc_statusOk;
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
    if (!(best.length < s_muchShorter * members->deepest))
        return qc_statusOk;
    for (size_t i = 0; i < members->count; i++)
        if (s_muchShorter * DepthOf(job, PairOf(members, i)) > best.length)
            QC_TRY(AdoptNormal(job, PairOf(members, i), best.normal));
    return qc_statusOk;
}

/// The pairs of regions that penetrate, by region; within one in their order.
static qcStatus ListMembers(const qcContactInput* input, qcContactNormals* normals)
{
    size_t unsettled = input->regions->unsettledPairs.count;
    QC_TRY(qcArray_Reserve(&normals->items, unsettled, sizeof(qcSortItem), "pairs of regions"));
    normals->items.count = 0;
    for (size_t i = 0; i < unsettled; i++)
    {
        uint32_t p = qcContactRegions_UnsettledPair(input->regions, i);
        const qcManifoldPair* pair = qcContactTopology_Pair(input->topology, p);
        if (qcContactProximity_Region(input->proximity, pair)->penetrating)
            QC_AT(qcSortItem, normals->items, normals->items.count++) = (qcSortItem){pair->region, p};
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
        Members members = {.items = items + first, .count = end - first, .last = (uint32_t)items[first].value};
        QC_TRY(ShortenRegion(&job, &members));
    }
    return qc_statusOk;
}
