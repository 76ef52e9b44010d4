// Normals where triangles intersect, propagated from pair to pair. In parallel.
//
// An intersecting pair alone may not determine a normal: two triangles that touch at an edge or a vertex are separated
// by a half circle of directions at no cost. So normals propagate from pairs with a reliable (coplanar, overlapping)
// contact to their neighbours; other pairs take the cheapest normal of an adjacent one if it is cheaper than their own.
// A round reads the normals of the previous one, so that the order does not matter, and each new normal is offered to
// the neighbours once. The rules, and why they are so: plugin/docs/manifolds.md.
#include "manifold/normal_cost.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum
{
    // Max propagation distance, in pairs: from a coplanar pair around the fan at a corner of a cut. In most scenes
    // nothing changes after 3 rounds.
    qc_maxRounds = 4,
    // Max evaluated candidates stored for one pair.
    qc_maxEvaluated = 8
};

// Normals that differ by rounding only.
static const double s_same = 1.0 - 1e-12;

typedef struct Job
{
    const qcContactInput* input;
    qcPairOverlaps* overlaps;
    const qcPairNormal* now;
    qcPairNormal* next;
    uint16_t* rounds; ///< of qcContactNormals
    uint16_t round;
} Job;

static uint16_t* RoundOf(const Job* job, const qcManifoldTriangle* triangle)
{
    return &job->rounds[triangle - (const qcManifoldTriangle*)job->input->topology->triangles.data];
}

/// Whether a pair of one of the triangles may have changed in the previous round: adjacent pairs have one in common.
/// Other threads set the present round meanwhile.
static bool MayHaveChanged(const Job* job, const qcManifoldPair* pair)
{
    return __atomic_load_n(RoundOf(job, pair->side[0]), __ATOMIC_RELAXED) + 1 >= job->round ||
           __atomic_load_n(RoundOf(job, pair->side[1]), __ATOMIC_RELAXED) + 1 >= job->round;
}

static void MarkChanged(const Job* job, const qcManifoldPair* pair)
{
    for (int side = 0; side < 2; side++)
        __atomic_store_n(RoundOf(job, pair->side[side]), job->round, __ATOMIC_RELAXED);
}

/// A propagated normal.
typedef struct Propagated
{
    qcVector normal;
    double cost, likeness; ///< cosine of the angle to the pair's own normal
} Propagated;

/// True if the pair's two triangles lie in the plane across its normal, on either side of each other, and overlap in an
/// area: no other normal separates them.
static bool IsCoplanar(const Job* job, uint32_t index, qcVector normal)
{
    const qcManifoldPair* pair = qcContactTopology_Pair(job->input->topology, index);
    return qcContactProximity_Pair(job->input->proximity, index)->gap <=
               QC_MANIFOLD_AREA * qcManifoldPair_SmallerSize(pair) &&
           fabs(qcDot(normal, pair->side[0]->normal)) >= QC_MANIFOLD_FLAT &&
           fabs(qcDot(normal, pair->side[1]->normal)) >= QC_MANIFOLD_FLAT &&
           qcProjectedOverlap_IsArea(pair, qcPairOverlaps_Corners(job->overlaps, index),
                                     qcPairOverlaps_Count(job->overlaps, index));
}

/// True if cheaper than the best, or as cheap and closer to the pair's own normal: the order of the adjacent pairs does
/// not matter.
static bool IsBetter(const Propagated* propagated, const Propagated* best, double rounding)
{
    if (fabs(propagated->cost - best->cost) > rounding)
        return propagated->cost < best->cost;
    return propagated->likeness > best->likeness;
}

/// True if the pair is no deeper along the candidate than the pair that it is taken from.
static bool IsNoDeeper(const qcManifoldPair* pair, const qcNormalCandidate* candidate, const qcManifoldPair* source)
{
    double depth = qcManifoldPair_Separation(source, source->side[0]->corner[0], candidate->normal).along;
    return candidate->separation.along <= qcPositive(depth) + qcManifoldPair_Rounding(pair);
}

/// A normal of adjacent pairs.
typedef struct Evaluated
{
    qcNormalCandidate candidate;
    bool isCheap, isConsidered;
} Evaluated;

/// Finds the normal among the evaluated ones, or the entry for a new one: most pairs beside a cut have one normal. For
/// a pair that is not disjoint a normal stands for its opposite too.
static Evaluated* FindEvaluated(Evaluated* evaluated, int count, const qcPairNormal* own, qcVector normal)
{
    int i = 0;
    while (i < count)
    {
        double likeness = qcDot(evaluated[i].candidate.normal, normal);
        if ((own->disjoint ? likeness : fabs(likeness)) >= s_same)
            break;
        i++;
    }
    return &evaluated[i];
}

/// The normal and, for a pair that is not disjoint, its opposite.
static void Consider(const qcNeighbourhood* n, const qcPairNormal* own, const qcNormalCandidate* candidate,
                     double limit, Propagated* best)
{
    for (int way = 0; way < (own->disjoint ? 1 : 2); way++)
    {
        Propagated propagated = {.normal = way == 0 ? candidate->normal : qcNegated(candidate->normal),
                                 .cost = way == 0 ? candidate->along : candidate->against};
        propagated.likeness = qcDot(propagated.normal, own->normal);
        if (propagated.cost < limit && IsBetter(&propagated, best, n->rounding))
            *best = propagated;
    }
}

/// Adjacent pairs that changed in the previous round.
typedef struct ChangedPairs
{
    uint32_t pairs[2 * qc_maxAdjacentPairs];
    uint32_t count;
} ChangedPairs;

/// Those whose normals may help.
static void ListChanged(const Job* job, const qcNeighbourhood* n, const qcPairNormal* own, ChangedPairs* changed)
{
    changed->count = 0;
    for (int side = 0; side < 2; side++)
        for (uint32_t i = 0; i < n->adjacent[side].count; i++)
        {
            uint32_t pair = qcPairAdjacency_Side(n->adjacency, n->adjacent[side].entries[i])->pair;
            const qcPairNormal* other = &job->now[pair];
            bool isListed =
                other->round + 1 == job->round && (other->intersecting || (other->reliable && own->intersecting));
            changed->pairs[changed->count] = pair;
            changed->count += isListed;
        }
}

/// The best normal among those of changed pairs that are reliable, or are not. Its cost is infinity if there is none.
static Propagated FindPropagated(const Job* job, const qcNeighbourhood* n, const qcPairNormal* own,
                                 const ChangedPairs* changed, bool reliable)
{
    Propagated best = {.normal = own->normal, .cost = INFINITY};
    double limit = reliable ? own->cost + n->rounding : qcNeighbourhood_Limit(n, own->cost);
    Evaluated evaluated[qc_maxEvaluated + 1];
    int count = 0;
    for (uint32_t i = 0; i < changed->count; i++)
    {
        const qcPairNormal* other = &job->now[changed->pairs[i]];
        if (other->reliable != reliable)
            continue;
        Evaluated* known = FindEvaluated(evaluated, count, own, other->normal);
        if (known == &evaluated[count])
        {
            *known = (Evaluated){.candidate = {.normal = other->normal, .face = -1}};
            known->isCheap = qcNeighbourhood_FindCost(n, limit, &known->candidate);
            count += count < qc_maxEvaluated; // those beyond are evaluated again
        }
        // For a disjoint pair it matters whose normal it is.
        if (!known->isCheap || known->isConsidered ||
            (own->disjoint &&
             !IsNoDeeper(n->pair, &known->candidate, qcContactTopology_Pair(job->input->topology, changed->pairs[i]))))
            continue;
        known->isConsidered = true;
        Consider(n, own, &known->candidate, limit, &best);
    }
    return best;
}

static bool PropagateTo(const Job* job, uint32_t index)
{
    qcNeighbourhood n = qcNeighbourhood_Of(job->input, index);
    const qcPairNormal* own = &job->now[index];
    ChangedPairs changed;
    ListChanged(job, &n, own, &changed);
    if (changed.count == 0)
        return false;
    Propagated propagated = FindPropagated(job, &n, own, &changed, true);
    bool reliable = propagated.cost < INFINITY;
    if (!reliable && own->cost > n.rounding)
        propagated = FindPropagated(job, &n, own, &changed, false);
    if (propagated.cost == INFINITY)
        return false;
    job->next[index] = (qcPairNormal){.normal = propagated.normal,
                                      .cost = propagated.cost,
                                      .round = job->round,
                                      .isNoLocalMinimum = own->isNoLocalMinimum,
                                      .changed = true,
                                      .intersecting = true,
                                      .reliable = reliable};
    MarkChanged(job, n.pair);
    return true;
}

static bool IsAmbiguous(const Job* job, uint32_t pair)
{
    return qcContactProximity_Region(job->input->proximity, qcContactTopology_Pair(job->input->topology, pair))
        ->ambiguous;
}

static void BeginBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    for (size_t i = block * qc_normalBlock; i < qcNormalBlocks_End(job->input, block); i++)
    {
        uint32_t p = qcContactRegions_UnsettledPair(job->input->regions, i);
        qcPairNormal* normal = &job->next[p];
        normal->intersecting = IsAmbiguous(job, p) && !normal->disjoint;
        normal->reliable = IsCoplanar(job, p, normal->normal);
    }
}

static void PropagateBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    bool* changed = &qcPairOverlaps_Worker(job->overlaps, worker)->changed;
    for (size_t i = block * qc_normalBlock; i < qcNormalBlocks_End(job->input, block); i++)
    {
        uint32_t p = qcContactRegions_UnsettledPair(job->input->regions, i);
        job->next[p] = job->now[p];
        if (!job->now[p].reliable && MayHaveChanged(job, qcContactTopology_Pair(job->input->topology, p)) &&
            IsAmbiguous(job, p))
            *changed = PropagateTo(job, p) || *changed;
    }
}

/// Overlaps along the normals that have changed.
static void OverlapBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    const qcContactInput* input = job->input;
    size_t end = qcNormalBlocks_End(input, block), changed = 0;
    for (size_t i = block * qc_normalBlock; i < end; i++)
        changed += job->now[qcContactRegions_UnsettledPair(input->regions, i)].changed;
    if (!qcPairOverlaps_Reserve(job->overlaps, worker, changed * qc_maxOverlapCorners))
        return;
    for (size_t i = block * qc_normalBlock; i < end; i++)
    {
        uint32_t p = qcContactRegions_UnsettledPair(input->regions, i);
        const qcManifoldPair* pair = qcContactTopology_Pair(input->topology, p);
        const qcPairNormal* normal = &job->now[p];
        if (!normal->changed)
            continue;
        qcProjectedOverlap overlap = {.count = -1};
        qcProjectedOverlap_Compute(input->kernels, pair, normal->normal, &overlap);
        qcPairOverlaps_Set(job->overlaps, p, worker, &overlap, normal->normal, false,
                           qcContactInput_CornerLimit(input, pair));
    }
}

static bool HaveWorkersChanged(qcPairOverlaps* overlaps)
{
    bool changed = false;
    for (uint32_t i = 0; i < overlaps->workers.count; i++)
    {
        bool* own = &qcPairOverlaps_Worker(overlaps, i)->changed;
        changed = changed || *own;
        *own = false;
    }
    return changed;
}

qcStatus qcContactNormals_Propagate(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals)
{
    size_t blocks = qcNormalBlocks_Count(input);
    bool any = false;
    for (size_t i = 0; i < input->regions->unsettledPairs.count && !any; i++)
        any = !qcContactProximity_Pair(input->proximity, qcContactRegions_UnsettledPair(input->regions, i))->separated;
    if (!any)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&normals->next, input->topology->pairs.count, sizeof(qcPairNormal), "normals of manifolds"));
    size_t triangles = input->topology->triangles.count;
    QC_TRY(qcArray_Resize(&normals->rounds, triangles, sizeof(uint16_t), "normals of manifolds"));
    memset(normals->rounds.data, 0, triangles * sizeof(uint16_t));
    Job job = {.input = input, .overlaps = overlaps, .next = normals->pairs.data, .rounds = normals->rounds.data};
    qcParallel_For(input->threads, blocks, qc_minNormalBlocks, BeginBlock, &job);
    bool changed = true;
    for (job.round = 1; job.round <= qc_maxRounds && changed; job.round++)
    {
        job.now = normals->pairs.data;
        job.next = normals->next.data;
        qcParallel_For(input->threads, blocks, qc_minNormalBlocks, PropagateBlock, &job);
        changed = HaveWorkersChanged(overlaps);
        qcArray swap = normals->pairs;
        normals->pairs = normals->next;
        normals->next = swap;
    }
    job.now = normals->pairs.data;
    qcParallel_For(input->threads, blocks, qc_minNormalBlocks, OverlapBlock, &job);
    return qcPairOverlaps_Status(overlaps);
}
