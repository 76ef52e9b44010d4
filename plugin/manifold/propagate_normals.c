// Directions where triangles meet. In parallel.
//
// What a pair that meets knows of its direction may be little. Two triangles that touch along an edge or in a corner
// are parted by half a circle of directions, or more, all at no cost, and if they have sunk into each other a little,
// the shortest way out is any of these: sideways along the rim of a cut that two pieces share. Seen one neighbour far
// it may still be free. But the pairs around know more, and so the pairs look at what those beside them have chosen:
//
// - A pair stands flat if its two triangles lie in the plane across its direction, and cover an area of each other: no
//   other direction parts them. Flat pairs are firm. One beside a firm pair takes its direction if that costs no more
//   than its own, and is firm then too.
// - Other pairs take the cheapest direction of those beside them, if it is cheaper than their own.
// - A pair that is apart follows those that meet, on a further condition: it may not come to lie deeper than the one
//   that it follows. Beside a shallow crossing there are pairs of triangles that are apart, but only because one of
//   them has passed the other's rim: their directions lead sideways, and their opposites into the whole of a body.
//
// All look at what the others had chosen in the round before, so that the order does not matter; and of a round's
// choices each is looked at once.
#include "manifold/normal_cost.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <math.h>

enum
{
    // As far from a flat pair as the fan around a corner of a cut reaches. Nothing changes in most scenes after three.
    qc_mostRounds = 4,
    // Directions that are remembered while the best is looked for.
    qc_mostTried = 8
};

// Normals that differ by rounding only.
static const double s_same = 1.0 - 1e-12;

typedef struct Job
{
    qcManifoldBuilder* manifolds;
    double margin;
    const qcNormalChoice* now;
    qcNormalChoice* next;
    uint16_t round;
} Job;

/// A direction to follow.
typedef struct Lead
{
    qcVector normal;
    double cost, likeness; ///< to the pair's own direction
} Lead;

/// Also on the other side of what it has just passed, or a little above it: the line is known, if not the sign.
static bool StandsFlat(const qcManifoldBuilder* m, uint32_t index, qcVector normal)
{
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    return pair->gap <= QC_MANIFOLD_AREA * qcManifoldPair_SmallerSize(pair) &&
           fabs(qcDot(normal, pair->side[0]->normal)) >= QC_MANIFOLD_FLAT &&
           fabs(qcDot(normal, pair->side[1]->normal)) >= QC_MANIFOLD_FLAT &&
           qcManifoldPair_CoversArea(pair, qcManifoldBuilder_Corners(m, index),
                                     QC_AT(qcPairCorners, m->corners, index).count);
}

/// Is a direction cheaper than the best, or as cheap and nearer to the pair's own? So that the order of those around
/// decides nothing.
static bool IsBetter(const Lead* lead, const Lead* best, double rounding)
{
    if (fabs(lead->cost - best->cost) > rounding)
        return lead->cost < best->cost;
    return lead->likeness > best->likeness;
}

/// Does the pair, which is apart, come to lie no deeper along a direction than the one that it is taken from?
static bool IsNoDeeper(const qcManifoldPair* pair, const qcTrial* trial, const qcManifoldPair* leader)
{
    qcVector origin = leader->side[0]->corner[0];
    double depth = qcWaysOut_Of(qcManifoldTriangle_Heights(leader->side[0], origin, trial->normal),
                                qcManifoldTriangle_Heights(leader->side[1], origin, trial->normal))
                       .along;
    return trial->ways.along <= qcPositive(depth) + qcManifoldPair_Rounding(pair);
}

/// A direction that pairs beside this one have chosen: what it costs, and whether it was offered.
typedef struct Tried
{
    qcTrial trial;
    bool isCheap, isOffered;
} Tried;

/// A cut has one normal, and most pairs beside it say the same: the place of that direction, or of a new one. For pairs
/// that meet it stands for its opposite too.
static Tried* FindTried(Tried* tried, int count, const qcNormalChoice* own, qcVector normal)
{
    int i = 0;
    while (i < count)
    {
        double likeness = qcDot(tried[i].trial.normal, normal);
        if ((own->apart ? likeness : fabs(likeness)) >= s_same)
            break;
        i++;
    }
    return &tried[i];
}

/// The direction, and for pairs that meet its opposite.
static void OfferLeads(const qcNeighbourhood* n, const qcNormalChoice* own, const qcTrial* trial, double limit,
                       Lead* best)
{
    for (int way = 0; way < (own->apart ? 1 : 2); way++)
    {
        Lead lead = {.normal = way == 0 ? trial->normal : qcNegated(trial->normal),
                     .cost = way == 0 ? trial->along : trial->against};
        lead.likeness = qcDot(lead.normal, own->normal);
        if (lead.cost < limit && IsBetter(&lead, best, n->rounding))
            *best = lead;
    }
}

/// The best direction of those around that have news, and are firm, or are not; its cost is infinity if there is none.
static Lead FindLead(const Job* job, const qcNeighbourhood* n, const qcNormalChoice* own, bool firm)
{
    Lead best = {.normal = own->normal, .cost = INFINITY};
    double limit = firm ? own->cost + n->rounding : qcNeighbourhood_Limit(n, own->cost);
    Tried tried[qc_mostTried + 1];
    int count = 0;
    for (int side = 0; side < 2; side++)
        for (uint32_t i = 0; i < n->ring[side].count; i++)
        {
            uint32_t pair = qcManifoldBuilder_Beside(n->manifolds, n->ring[side].entries[i])->pair;
            const qcNormalChoice* other = &job->now[pair];
            bool helps = other->meets || (firm && own->meets);
            if (other->news + 1 != job->round || other->firm != firm || !helps)
                continue;
            Tried* known = FindTried(tried, count, own, other->normal);
            if (known == &tried[count])
            {
                *known = (Tried){.trial = {.normal = other->normal, .face = -1}};
                known->isCheap = qcNeighbourhood_FindCost(n, limit, &known->trial);
                count += count < qc_mostTried; // those beyond are forgotten, and tried again
            }
            // Whom a pair that is apart follows matters too.
            if (!known->isCheap || known->isOffered ||
                (own->apart && !IsNoDeeper(n->pair, &known->trial, qcManifoldBuilder_Pair(n->manifolds, pair))))
                continue;
            known->isOffered = true;
            OfferLeads(n, own, &known->trial, limit, &best);
        }
    return best;
}

static bool Follow(const Job* job, uint32_t index)
{
    qcNeighbourhood n = qcNeighbourhood_Of(job->manifolds, index);
    const qcNormalChoice* own = &job->now[index];
    Lead lead = FindLead(job, &n, own, true);
    bool firm = lead.cost < INFINITY;
    if (!firm && own->cost > n.rounding)
        lead = FindLead(job, &n, own, false);
    if (lead.cost == INFINITY)
        return false;
    job->next[index] = (qcNormalChoice){
        .normal = lead.normal, .cost = lead.cost, .news = job->round, .moved = true, .meets = true, .firm = firm};
    return true;
}

static bool HasChoice(const Job* job, uint32_t p)
{
    return qcManifoldBuilder_PairRegion(job->manifolds, qcManifoldBuilder_Pair(job->manifolds, p))->unsettled;
}

static void FindFlatBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    for (size_t i = block * qc_normalBlock; i < qcNormalBlocks_End(job->manifolds, block); i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(job->manifolds, i);
        qcNormalChoice* choice = &job->next[p];
        choice->meets = HasChoice(job, p) && !choice->apart;
        choice->firm = StandsFlat(job->manifolds, p, choice->normal);
    }
}

static void FollowBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    bool* changed = &QC_AT(qcManifoldWorker, job->manifolds->workers, worker).changed;
    for (size_t i = block * qc_normalBlock; i < qcNormalBlocks_End(job->manifolds, block); i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(job->manifolds, i);
        job->next[p] = job->now[p];
        if (!job->now[p].firm && HasChoice(job, p))
            *changed = Follow(job, p) || *changed;
    }
}

static void LookBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    qcManifoldBuilder* m = job->manifolds;
    size_t end = qcNormalBlocks_End(job->manifolds, block), moved = 0;
    for (size_t i = block * qc_normalBlock; i < end; i++)
        moved += job->now[qcManifoldBuilder_FreePair(m, i)].moved;
    if (!qcManifoldWorker_ReservePoints(&QC_AT(qcManifoldWorker, m->workers, worker), moved))
        return;
    for (size_t i = block * qc_normalBlock; i < end; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        if (!job->now[p].moved)
            continue;
        qcLook look = {.count = -1};
        qcLook_Along(m, qcManifoldBuilder_Pair(m, p), job->now[p].normal, &look);
        qcManifoldBuilder_KeepCorners(m, p, worker, &look, job->now[p].normal, false, job->margin);
    }
}

static bool HaveWorkersChanged(const qcManifoldBuilder* m)
{
    bool changed = false;
    for (size_t i = 0; i < m->workers.count; i++)
    {
        bool* mine = &QC_AT(qcManifoldWorker, m->workers, i).changed;
        changed = changed || *mine;
        *mine = false;
    }
    return changed;
}

qcStatus qcManifoldBuilder_FollowNeighbours(qcManifoldBuilder* m, double margin, uint32_t threads)
{
    size_t blocks = qcNormalBlocks_Count(m);
    bool any = false;
    for (size_t i = 0; i < m->freePairs.count && !any; i++)
        any = !qcManifoldBuilder_Pair(m, qcManifoldBuilder_FreePair(m, i))->parted;
    if (!any)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(&m->heard, m->work.count, sizeof(qcNormalChoice), "normals of manifolds"));
    Job job = {m, margin, NULL, m->choices.data, 0};
    qcParallel_For(threads, blocks, qc_leastNormalBlocks, FindFlatBlock, &job);
    bool changed = true;
    for (job.round = 1; job.round <= qc_mostRounds && changed; job.round++)
    {
        job.now = m->choices.data;
        job.next = m->heard.data;
        qcParallel_For(threads, blocks, qc_leastNormalBlocks, FollowBlock, &job);
        changed = HaveWorkersChanged(m);
        qcArray swap = m->choices;
        m->choices = m->heard;
        m->heard = swap;
    }
    job.now = m->choices.data;
    qcParallel_For(threads, blocks, qc_leastNormalBlocks, LookBlock, &job);
    return qcManifoldBuilder_LoopStatus(m);
}
