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
#include "manifold_parts.h"
#include "parallel.h"
#include "status.h"

#include <math.h>

enum
{
    // A block takes some 100 microseconds.
    qc_normalBlock = 128,
    qc_leastNormalBlocks = 4
};

// Another direction must be cheaper by this factor, so that rounding never decides.
static const double s_cheaper = 0.9;
// The weight of the pair itself: its own six vertices.
static const double s_self = 6.0;
// And another pair nearer by this, for the same reason.
static const double s_nearer = 1.0 - 1e-6;

typedef struct Neighbourhood
{
    const qcManifolds* manifolds;
    const qcManifoldPair* pair;
    qcRing ring[2];  ///< by the side whose triangle is the common one
    double rounding; ///< of a cost
} Neighbourhood;

/// What a pair's triangles have in common, seen along a direction.
typedef struct Look
{
    int count; ///< below 0: not looked
    double low, high;
    qcRawPoint corners[qc_maxCommonCorners];
} Look;

/// The best direction so far.
typedef struct Best
{
    qcVector normal;
    double cost;
    bool own;      ///< nothing else was better
    bool opposite; ///< the look is along the opposite direction
    Look *look, *spare;
} Best;

typedef struct Choice
{
    qcVector normal;
    bool apart; ///< as qcManifoldPair's
} Choice;

/// A direction to try.
typedef struct Trial
{
    qcVector normal;
    int face; ///< the side whose face's normal it is, or -1
    double along, against;
    qcWaysOut ways; ///< of the pair itself
    Look* look;
} Trial;

static double Positive(double x)
{
    return x > 0.0 ? x : 0.0;
}

static void AddWays(Trial* trial, qcWaysOut ways, double weight)
{
    trial->along += weight * Positive(ways.along);
    trial->against += weight * Positive(ways.against);
}

/// A cost must be below this to be cheaper than the best.
static double LimitOf(const Neighbourhood* n, double best)
{
    return s_cheaper * best - n->rounding;
}

/// The pairs beside this one whose common triangle, at these heights, is that of a side.
static void AddRing(const Neighbourhood* n, int side, qcHeights common, qcVector origin, Trial* trial)
{
    qcRing ring = n->ring[side];
    qcVector direction = trial->normal;
    for (uint32_t i = 0; i < ring.count; i++)
    {
        const qcManifoldPlace* place = qcManifolds_Beside(n->manifolds, ring.entries[i]);
        qcHeights h =
            side == trial->face ? place->heights : qcManifoldTriangle_Heights(place->moved, origin, direction);
        AddWays(trial, side == 0 ? qcWaysOut_Of(common, h) : qcWaysOut_Of(h, common),
                (double)(ring.entries[i] & qc_ringShared));
    }
}

/// False: neither way costs less than `limit`, however much is still to be added.
static bool FindCost(const Neighbourhood* n, double limit, Trial* trial)
{
    const qcManifoldPair* pair = n->pair;
    qcVector origin = pair->side[trial->face == 0 ? 0 : 1]->corner[0];
    const qcHeights heights[2] = {qcManifoldTriangle_Heights(pair->side[0], origin, trial->normal),
                                  qcManifoldTriangle_Heights(pair->side[1], origin, trial->normal)};
    trial->along = trial->against = 0.0;
    trial->ways = qcWaysOut_Of(heights[0], heights[1]);
    AddWays(trial, trial->ways, s_self);
    // What the places know already comes first.
    int first = trial->face == 1 ? 1 : 0;
    for (int k = 0; k < 2 && (trial->along < limit || trial->against < limit); k++)
        AddRing(n, k == 0 ? first : 1 - first, heights[k == 0 ? first : 1 - first], origin, trial);
    return trial->along < limit || trial->against < limit;
}

static void LookAlong(const qcManifoldPair* pair, qcVector normal, Look* look)
{
    if (look->count >= 0)
        return;
    look->count = qcManifoldPair_FindCommonPart(pair, normal, look->corners);
    look->low = INFINITY;
    look->high = -INFINITY;
    for (int i = 0; i < look->count; i++)
    {
        double distance = look->corners[i].distance;
        look->low = distance < look->low ? distance : look->low;
        look->high = distance > look->high ? distance : look->high;
    }
}

/// Does the direction, or its opposite, make no contact where there is none? What can be said of a pair that is apart:
/// seen along it, its triangles lie beside each other, or side 0 above side 1.
static bool Agrees(const Neighbourhood* n, const Trial* trial, bool opposite)
{
    if (!n->pair->apart || (opposite ? trial->ways.against : trial->ways.along) <= 0.0)
        return true;
    LookAlong(n->pair, trial->normal, trial->look);
    double rounding = qcManifoldPair_Rounding(n->pair);
    return opposite ? trial->look->high <= rounding : trial->look->low >= -rounding;
}

static void ConsiderWay(const Neighbourhood* n, const Trial* trial, bool opposite, Best* best)
{
    double cost = opposite ? trial->against : trial->along;
    if (!(cost < LimitOf(n, best->cost)) || !Agrees(n, trial, opposite))
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
static void Consider(const Neighbourhood* n, qcVector normal, int face, Best* best)
{
    Trial trial = {.normal = normal, .face = face, .look = best->spare};
    double limit = LimitOf(n, best->cost);
    if (!(limit > 0.0) || !FindCost(n, limit, &trial))
        return;
    trial.look->count = -1;
    ConsiderWay(n, &trial, false, best);
    ConsiderWay(n, &trial, true, best);
}

/// The two faces, that more along the pair's own direction first, so that the order of the sides decides nothing.
static void ConsiderFaces(const Neighbourhood* n, Best* best)
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
static bool IsSurpassed(const Neighbourhood* n, const qcFeet* feet)
{
    double nearer = s_nearer * n->pair->gap;
    for (int side = 0; side < 2; side++)
    {
        const qcManifoldTriangle* mine = n->pair->side[1 - side];
        unsigned corners = feet->corners[(side == 0) != n->pair->swapped ? 1 : 0];
        for (uint32_t i = 0; i < n->ring[side].count; i++)
        {
            const qcManifoldPlace* place = qcManifolds_Beside(n->manifolds, n->ring[side].entries[i]);
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
    qcManifolds* manifolds;
    const qcManifoldInput* input;
    Choice* choices;
} Job;

static Neighbourhood NeighbourhoodOf(const qcManifolds* m, uint32_t index)
{
    const qcManifoldPair* pair = qcManifolds_Pair(m, index);
    Neighbourhood n = {m, pair, {qcManifolds_Ring(m, pair, 0), qcManifolds_Ring(m, pair, 1)}, 0.0};
    n.rounding = qcManifoldPair_Rounding(pair) * (s_self + n.ring[0].count + n.ring[1].count);
    return n;
}

/// The pair that says most of those around, and that this one can follow; or the pair itself. Of pairs that are apart
/// the others that are no local minimum are no leaders, and those that penetrate may just have found a way out.
static const qcManifoldPair* LeaderOf(const Neighbourhood* n)
{
    const qcManifoldPair* leader = n->pair;
    for (int side = 0; side < 2; side++)
        for (uint32_t i = 0; i < n->ring[side].count; i++)
        {
            const qcManifoldPlace* place = qcManifolds_Beside(n->manifolds, n->ring[side].entries[i]);
            if (place->gap > leader->gap)
                continue;
            const qcManifoldPair* other = qcManifolds_Pair(n->manifolds, place->pair);
            bool nearer = place->gap < leader->gap || other < leader;
            if (nearer && !other->surpassed && (other->apart || !n->pair->apart))
                leader = other;
        }
    return leader;
}

static void Choose(const Job* job, uint32_t index, Best* best)
{
    Neighbourhood n = NeighbourhoodOf(job->manifolds, index);
    const qcManifoldPair* pair = n.pair;
    best->normal = pair->normal;
    best->cost = INFINITY;
    best->own = true;
    best->opposite = false;
    best->look->count = -1;
    if (!pair->surpassed)
    {
        Trial own = {.normal = pair->normal, .face = -1, .look = best->look};
        FindCost(&n, INFINITY, &own);
        if (own.along <= n.rounding)
            return;
        best->cost = own.along;
        ConsiderWay(&n, &own, true, best);
    }
    ConsiderFaces(&n, best);
    const qcManifoldPair* leader = LimitOf(&n, best->cost) > 0.0 ? LeaderOf(&n) : pair;
    if (leader != pair)
        Consider(&n, leader->normal, -1, best);
}

/// Corners that can become points; there is room for them. If the normal may be turned around still, all of them.
static void KeepCorners(const Job* job, uint32_t index, uint32_t worker, const Best* best)
{
    const Look* look = best->look;
    qcManifolds* m = job->manifolds;
    const qcManifoldPair* pair = qcManifolds_Pair(m, index);
    qcArray* points = &QC_AT(qcManifoldWorker, m->workers, worker).points;
    double limit = qcManifoldPair_Limit(pair, job->input->margin);
    if (qcManifolds_SignRegion(m, pair)->unsettled)
        limit = INFINITY;
    qcPairCorners* kept = &QC_AT(qcPairCorners, m->corners, index);
    *kept = (qcPairCorners){points->count, (uint16_t)worker, 0};
    for (int i = 0; i < look->count; i++)
    {
        double distance = best->opposite ? -look->corners[i].distance : look->corners[i].distance;
        if (!(distance <= limit))
            continue;
        qcRawPoint* point = &QC_AT(qcRawPoint, *points, points->count++);
        *point = look->corners[i];
        point->normal = best->normal;
        point->distance = distance;
        point->pair = index;
        kept->count++;
    }
}

static size_t EndOf(const Job* job, size_t block)
{
    size_t end = (block + 1) * qc_normalBlock, count = job->manifolds->work.count;
    return end < count ? end : count;
}

static void CompareBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    for (size_t p = block * qc_normalBlock; p < EndOf(job, block); p++)
    {
        qcManifoldPair* pair = qcManifolds_Pair(job->manifolds, (uint32_t)p);
        if (!pair->apart)
            continue;
        Neighbourhood n = NeighbourhoodOf(job->manifolds, (uint32_t)p);
        pair->surpassed = IsSurpassed(&n, &job->input->feet[pair->source]);
    }
}

static void ChooseBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    qcManifolds* m = job->manifolds;
    qcStatus* status = &QC_AT(qcManifoldWorker, m->workers, worker).status;
    Look looks[2];
    Best best = {.look = &looks[0], .spare = &looks[1]};
    qcArray* points = &QC_AT(qcManifoldWorker, m->workers, worker).points;
    if (*status == qc_statusOk)
        *status = qcArray_Reserve(points, points->count + qc_normalBlock * qc_maxCommonCorners, sizeof(qcRawPoint),
                                  "contact points");
    for (size_t p = block * qc_normalBlock; p < EndOf(job, block) && *status == qc_statusOk; p++)
    {
        const qcManifoldPair* pair = qcManifolds_Pair(m, (uint32_t)p);
        Choose(job, (uint32_t)p, &best);
        LookAlong(pair, best.opposite ? qcNegated(best.normal) : best.normal, best.look);
        job->choices[p] = (Choice){best.normal, pair->apart && (best.own || best.look->count != 0)};
        KeepCorners(job, (uint32_t)p, worker, &best);
    }
}

static bool AreEqual(qcVector a, qcVector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

qcStatus qcManifolds_ChooseNormals(qcManifolds* m, const qcManifoldInput* input, uint32_t threads)
{
    size_t count = m->work.count;
    // All look at what the pairs themselves say, none at what another has chosen: the order does not matter.
    QC_TRY(qcArray_Resize(&m->choices, count, sizeof(Choice), "normals of manifolds"));
    QC_TRY(qcArray_Resize(&m->corners, count, sizeof(qcPairCorners), "normals of manifolds"));
    Job job = {m, input, m->choices.data};
    size_t blocks = (count + qc_normalBlock - 1) / qc_normalBlock;
    qcParallel_For(threads, blocks, qc_leastNormalBlocks, CompareBlock, &job);
    qcParallel_For(threads, blocks, qc_leastNormalBlocks, ChooseBlock, &job);
    QC_TRY(qcManifolds_LoopStatus(m));
    for (size_t p = 0; p < count; p++)
    {
        qcManifoldPair* pair = &QC_AT(qcManifoldPair, m->work, p);
        pair->own = AreEqual(pair->normal, job.choices[p].normal);
        pair->normal = job.choices[p].normal;
        pair->apart = job.choices[p].apart;
    }
    return qc_statusOk;
}
