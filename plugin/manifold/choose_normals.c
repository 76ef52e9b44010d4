// The direction of each pair, looked at with its neighbourhood, and what its triangles have in common along it. In
// parallel.
//
// What a pair of triangles says alone may be wrong for the surfaces that they are part of, in two ways:
//
// - Apart: where the closest point lies on an edge or a corner whose other triangles come nearer, the pair is no local
//   minimum of the distance of the surfaces (Johnson, Cohen: Spatialized normal cone hierarchies, 2001), and the line
//   between the closest points leans. A box on a tiled floor has such a pair with each tile beside it: the ghost
//   contacts at inner edges. Such a pair follows others.
// - Penetrating: the least way out of one triangle may lead through its neighbours. A tile of which only a tip reaches
//   through the box's wall parts soonest sideways.
//
// Directions are judged by their cost: going along one until this pair is free (it may be already), how far do the
// pairs around it still overlap? It is the sum of the ways out along it, in which a pair around counts by the vertices
// that it shares, and the pair itself six times. The pair's own direction stays if it costs nothing
// or as little as others. Otherwise the pair takes the cheapest of these: its own turned around, the normals of its two
// faces, which know the surface best where it is flat, and the direction of the pair around it that says most (the
// closest, or the deepest). Windings say nothing: faces are lines without a sign. A pair that is apart takes only
// directions along which its triangles lie beside each other, or above each other as the direction says.
//
// Limits: this looks one neighbour far. Where a surface has sunk in deeper than about half a triangle, all pairs may
// agree on a way out that is no way out. Along the rim of such a neighbourhood a direction may jump by the angle
// between the faces there.
#include "manifold/normal_cost.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <math.h>

// Another pair must be nearer by this, so that rounding never decides.
static const double s_nearer = 1.0 - 1e-6;

/// The best direction so far.
typedef struct Best
{
    qcVector normal;
    double cost;
    bool own;      ///< nothing else was better
    bool opposite; ///< the look is along the opposite direction
    qcLook *look, *spare;
} Best;

/// Does the direction, or its opposite, make no contact where there is none? What can be said of a pair that is apart:
/// seen along it, its triangles lie beside each other, or side 0 above side 1.
static bool Agrees(const qcNeighbourhood* n, const qcTrial* trial, bool opposite)
{
    if (!n->pair->apart || (opposite ? trial->ways.against : trial->ways.along) <= 0.0)
        return true;
    qcLook_Along(n->manifolds, n->pair, trial->normal, trial->look);
    double rounding = qcManifoldPair_Rounding(n->pair);
    return opposite ? trial->look->high <= rounding : trial->look->low >= -rounding;
}

static void ConsiderWay(const qcNeighbourhood* n, const qcTrial* trial, bool opposite, Best* best)
{
    double cost = opposite ? trial->against : trial->along;
    if (!(cost < qcNeighbourhood_Limit(n, best->cost)) || !Agrees(n, trial, opposite))
        return;
    best->normal = opposite ? qcNegated(trial->normal) : trial->normal;
    best->cost = cost;
    best->own = false;
    best->opposite = opposite;
    if (best->look != trial->look)
    {
        best->spare = best->look;
        best->look = trial->look;
    }
}

/// Tries a direction and its opposite.
static void Consider(const qcNeighbourhood* n, qcVector normal, int face, Best* best)
{
    qcTrial trial = {.normal = normal, .face = face, .look = best->spare};
    double limit = qcNeighbourhood_Limit(n, best->cost);
    if (!(limit > 0.0) || !qcNeighbourhood_FindCost(n, limit, &trial))
        return;
    trial.look->count = -1;
    ConsiderWay(n, &trial, false, best);
    ConsiderWay(n, &trial, true, best);
}

/// The two faces, that more along the pair's own direction first, so that the order of the sides decides nothing.
static void ConsiderFaces(const qcNeighbourhood* n, Best* best)
{
    const qcManifoldPair* pair = n->pair;
    qcVector faces[2];
    bool known[2];
    for (int side = 0; side < 2; side++)
    {
        faces[side] = pair->side[side]->normal;
        known[side] = qcDot(faces[side], faces[side]) > 0.0;
        if (!known[side])
            faces[side] = pair->normal;
    }
    int first = fabs(qcDot(faces[1], pair->normal)) > fabs(qcDot(faces[0], pair->normal)), second = 1 - first;
    Consider(n, faces[first], known[first] ? first : -1, best);
    Consider(n, faces[second], known[second] ? second : -1, best);
}

static bool HasVertex(const qcManifoldTriangle* triangle, uint32_t v)
{
    return triangle->vertex[0] == v || triangle->vertex[1] == v || triangle->vertex[2] == v;
}

/// Does a pair beside this one, that both its feet stand on too, come nearer? One foot stands on the common triangle.
static bool IsSurpassed(const qcNeighbourhood* n, const qcClosestFeatures* feet)
{
    double nearer = s_nearer * n->pair->gap;
    for (int side = 0; side < 2; side++)
    {
        const qcManifoldTriangle* mine = n->pair->side[1 - side];
        unsigned corners = feet->corners[(side == 0) != n->pair->swapped ? 1 : 0];
        for (uint32_t i = 0; i < n->ring[side].count; i++)
        {
            const qcManifoldPlace* place = qcManifoldBuilder_Beside(n->manifolds, n->ring[side].entries[i]);
            bool stands = place->gap < nearer;
            for (unsigned c = 0; c < 3 && stands; c++)
                stands = !(corners >> c & 1u) || HasVertex(place->moved, mine->vertex[c]);
            if (stands)
                return true;
        }
    }
    return false;
}

typedef struct Job
{
    qcManifoldBuilder* manifolds;
    const qcMeetingInput* input;
    qcNormalChoice* choices;
} Job;

/// The pair that says most of those around, and that this one can follow; or the pair itself. Of pairs that are apart
/// the others that are no local minimum are no leaders, and those that penetrate may just have found a way out.
static const qcManifoldPair* LeaderOf(const qcNeighbourhood* n)
{
    const qcManifoldPair* leader = n->pair;
    for (int side = 0; side < 2; side++)
        for (uint32_t i = 0; i < n->ring[side].count; i++)
        {
            const qcManifoldPlace* place = qcManifoldBuilder_Beside(n->manifolds, n->ring[side].entries[i]);
            if (place->gap > leader->gap)
                continue;
            const qcManifoldPair* other = qcManifoldBuilder_Pair(n->manifolds, place->pair);
            bool nearer = place->gap < leader->gap || other < leader;
            if (nearer && !other->surpassed && (other->apart || !n->pair->apart))
                leader = other;
        }
    return leader;
}

static void Choose(const Job* job, uint32_t index, Best* best)
{
    qcNeighbourhood n = qcNeighbourhood_Of(job->manifolds, index);
    const qcManifoldPair* pair = n.pair;
    best->normal = pair->normal;
    best->cost = INFINITY;
    best->own = true;
    best->opposite = false;
    best->look->count = -1;
    if (!pair->surpassed)
    {
        qcTrial own = {.normal = pair->normal, .face = -1, .look = best->look};
        qcNeighbourhood_FindCost(&n, INFINITY, &own);
        best->cost = own.along;
        if (own.along <= n.rounding)
            return;
        ConsiderWay(&n, &own, true, best);
    }
    ConsiderFaces(&n, best);
    const qcManifoldPair* leader = qcNeighbourhood_Limit(&n, best->cost) > 0.0 ? LeaderOf(&n) : pair;
    if (leader != pair)
        Consider(&n, leader->normal, -1, best);
}

static void CompareBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    for (size_t i = block * qc_normalBlock; i < qcNormalBlocks_End(job->manifolds, block); i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(job->manifolds, i);
        qcManifoldPair* pair = qcManifoldBuilder_Pair(job->manifolds, p);
        if (!pair->apart)
            continue;
        qcNeighbourhood n = qcNeighbourhood_Of(job->manifolds, p);
        pair->surpassed = IsSurpassed(&n, &job->input->feet[pair->source]);
    }
}

static void ChooseBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    qcManifoldBuilder* m = job->manifolds;
    qcLook looks[2];
    Best best = {.look = &looks[0], .spare = &looks[1]};
    if (!qcManifoldWorker_ReservePoints(&QC_AT(qcManifoldWorker, m->workers, worker), qc_normalBlock))
        return;
    for (size_t i = block * qc_normalBlock; i < qcNormalBlocks_End(job->manifolds, block); i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        Choose(job, p, &best);
        qcLook_Along(m, pair, best.opposite ? qcNegated(best.normal) : best.normal, best.look);
        job->choices[p] = (qcNormalChoice){
            .normal = best.normal, .cost = best.cost, .apart = pair->apart && (best.own || best.look->count != 0)};
        qcManifoldBuilder_KeepCorners(m, p, worker, best.look, best.normal, best.opposite, job->input->margin);
    }
}

static bool AreEqual(qcVector a, qcVector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

qcStatus qcManifoldBuilder_ChooseNormals(qcManifoldBuilder* m, const qcMeetingInput* input, uint32_t threads)
{
    size_t count = m->work.count;
    // All look at what the pairs themselves say, none at what another has chosen: the order does not matter.
    QC_TRY(qcArray_Resize(&m->choices, count, sizeof(qcNormalChoice), "normals of manifolds"));
    QC_TRY(qcArray_Resize(&m->corners, count, sizeof(qcPairCorners), "normals of manifolds"));
    Job job = {m, input, m->choices.data};
    size_t blocks = qcNormalBlocks_Count(m);
    qcParallel_For(threads, blocks, qc_leastNormalBlocks, CompareBlock, &job);
    qcParallel_For(threads, blocks, qc_leastNormalBlocks, ChooseBlock, &job);
    QC_TRY(qcManifoldBuilder_LoopStatus(m));
    QC_TRY(qcManifoldBuilder_FollowNeighbours(m, input->margin, threads));
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        const qcNormalChoice* choice = &QC_AT(qcNormalChoice, m->choices, p);
        pair->own = AreEqual(pair->normal, choice->normal);
        pair->normal = choice->normal;
        pair->apart = choice->apart;
    }
    return qc_statusOk;
}
