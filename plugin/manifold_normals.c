// The direction of each pair, looked at with its neighbourhood, in parallel.
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
#include "closest.h"
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
    qcBeside ring[qc_maxRing];
    uint32_t count;
} Neighbourhood;

typedef struct Choice
{
    qcVector normal;
    double cost;
    bool apart; ///< as qcManifoldPair's
} Choice;

typedef struct Cost
{
    double along, against, rounding;
} Cost;

static double Positive(double x)
{
    return x > 0.0 ? x : 0.0;
}

static Cost CostOf(const Neighbourhood* n, qcVector direction)
{
    qcWaysOut own = qcManifoldPair_WaysOut(n->pair, direction);
    Cost cost = {s_self * Positive(own.along), s_self * Positive(own.against), 0.0};
    double extent = s_self * (own.along + own.against);
    for (uint32_t i = 0; i < n->count; i++)
    {
        qcWaysOut ways = qcManifoldPair_WaysOut(qcManifolds_Pair(n->manifolds, n->ring[i].pair), direction);
        double shared = n->ring[i].shared;
        cost.along += shared * Positive(ways.along);
        cost.against += shared * Positive(ways.against);
        extent += shared * (ways.along + ways.against);
    }
    cost.rounding = QC_MANIFOLD_ROUNDING * extent;
    return cost;
}

/// Does the direction make no contact where there is none? What can be said of a pair that is apart: seen along it,
/// its triangles lie beside each other, or side 0 above side 1.
static bool Agrees(const Neighbourhood* n, qcVector normal, bool* above)
{
    qcRawPoint corners[qc_maxCommonCorners];
    int count = qcManifoldPair_FindCommonPart(n->pair, normal, corners);
    double rounding = QC_MANIFOLD_ROUNDING * qcManifoldPair_LongestEdge(n->pair, 0);
    rounding += QC_MANIFOLD_ROUNDING * qcManifoldPair_LongestEdge(n->pair, 1);
    for (int i = 0; i < count; i++)
        if (!(corners[i].distance >= -rounding))
            return false;
    *above = count != 0;
    return true;
}

static void ConsiderWay(const Neighbourhood* n, qcVector normal, double cost, double rounding, Choice* best)
{
    bool above = false;
    if (cost < s_cheaper * best->cost - rounding && (!n->pair->apart || Agrees(n, normal, &above)))
        *best = (Choice){normal, cost, above};
}

static void Consider(const Neighbourhood* n, qcVector normal, Choice* best)
{
    Cost cost = CostOf(n, normal);
    ConsiderWay(n, normal, cost.along, cost.rounding, best);
    ConsiderWay(n, qcNegated(normal), cost.against, cost.rounding, best);
}

static qcVector FaceNormal(const qcManifoldPair* pair, int side)
{
    qcVector corner[3];
    qcManifoldPair_GetCorners(pair, side, corner);
    qcVector normal = qcCross(qcMinus(corner[1], corner[0]), qcMinus(corner[2], corner[0]));
    double length = sqrt(qcDot(normal, normal));
    if (!(length > 0.0) || !isfinite(length))
        return pair->normal;
    return (qcVector){normal.x / length, normal.y / length, normal.z / length};
}

/// The two faces, that more along the pair's own direction first, so that the order of the sides decides nothing.
static void ConsiderFaces(const Neighbourhood* n, Choice* best)
{
    const qcManifoldPair* pair = n->pair;
    qcVector faces[2] = {FaceNormal(pair, 0), FaceNormal(pair, 1)};
    int first = fabs(qcDot(faces[1], pair->normal)) > fabs(qcDot(faces[0], pair->normal));
    Consider(n, faces[first], best);
    Consider(n, faces[1 - first], best);
}

/// The feet of a pair's closest points: of each side the corners between which it lies, as bits.
typedef struct Feet
{
    unsigned corners[2];
} Feet;

static Feet FeetOf(const qcManifoldPair* pair, const qcProximity* proximity)
{
    Feet feet = {{0, 0}};
    for (int side = 0; side < 2; side++)
    {
        qcVector corner[3];
        qcManifoldPair_GetCorners(pair, side, corner);
        bool isA = (side == 0) != pair->swapped;
        double weights[3];
        qcClosest_OnTriangle(corner, qcVector_Load(isA ? proximity->pointA : proximity->pointB), weights);
        for (unsigned c = 0; c < 3; c++)
            feet.corners[side] |= (unsigned)(weights[c] > QC_MANIFOLD_ROUNDING) << c;
    }
    return feet;
}

static bool HasVertex(const uint32_t vertex[3], uint32_t v)
{
    return vertex[0] == v || vertex[1] == v || vertex[2] == v;
}

/// Do both feet of a pair stand on one beside it too?
static bool StandOn(const qcManifoldPair* pair, Feet feet, const qcManifoldPair* other)
{
    int moved = other->triangle[0] == pair->triangle[0] ? 1 : 0;
    for (unsigned c = 0; c < 3; c++)
        if ((feet.corners[moved] >> c & 1u) && !HasVertex(other->vertex[moved], pair->vertex[moved][c]))
            return false;
    return true;
}

/// Does a pair beside this one, that both its feet stand on too, come nearer?
static bool IsSurpassed(const Neighbourhood* n, const qcProximity* proximity)
{
    Feet feet = FeetOf(n->pair, proximity);
    for (uint32_t i = 0; i < n->count; i++)
    {
        const qcManifoldPair* other = qcManifolds_Pair(n->manifolds, n->ring[i].pair);
        if (other->gap < s_nearer * n->pair->gap && StandOn(n->pair, feet, other))
            return true;
    }
    return false;
}

typedef struct Job
{
    qcManifolds* manifolds;
    const qcProximity* proximities;
    Choice* choices;
} Job;

static Neighbourhood NeighbourhoodOf(const qcManifolds* m, uint32_t index)
{
    Neighbourhood n = {.manifolds = m, .pair = qcManifolds_Pair(m, index)};
    n.count = qcManifolds_CollectRing(m, index, n.ring);
    return n;
}

/// The pair that says most of those around, and that this one can follow; or the pair itself. Of pairs that are apart
/// the others that are no local minimum are no leaders, and those that penetrate may just have found a way out.
static const qcManifoldPair* LeaderOf(const Neighbourhood* n)
{
    const qcManifoldPair* leader = n->pair;
    for (uint32_t i = 0; i < n->count; i++)
    {
        const qcManifoldPair* other = qcManifolds_Pair(n->manifolds, n->ring[i].pair);
        bool nearer = other->gap < leader->gap || (other->gap == leader->gap && other < leader);
        if (nearer && !other->surpassed && (other->apart || !n->pair->apart))
            leader = other;
    }
    return leader;
}

static void Choose(const Job* job, uint32_t index, Choice* choice)
{
    Neighbourhood n = NeighbourhoodOf(job->manifolds, index);
    const qcManifoldPair* pair = n.pair;
    *choice = (Choice){pair->normal, INFINITY, pair->apart};
    if (!pair->surpassed)
    {
        Cost own = CostOf(&n, pair->normal);
        if (own.along <= own.rounding)
            return;
        choice->cost = own.along;
        ConsiderWay(&n, qcNegated(pair->normal), own.against, own.rounding, choice);
    }
    ConsiderFaces(&n, choice);
    const qcManifoldPair* leader = LeaderOf(&n);
    if (leader != pair)
        Consider(&n, leader->normal, choice);
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
        pair->surpassed = IsSurpassed(&n, &job->proximities[pair->source]);
    }
}

static void ChooseBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    for (size_t p = block * qc_normalBlock; p < EndOf(job, block); p++)
        Choose(job, (uint32_t)p, &job->choices[p]);
}

static bool AreEqual(qcVector a, qcVector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

qcStatus qcManifolds_ChooseNormals(qcManifolds* m, const qcProximity* proximities, uint32_t threads)
{
    size_t count = m->work.count;
    // All look at what the pairs themselves say, none at what another has chosen: the order does not matter.
    QC_TRY(qcArray_Resize(&m->choices, count, sizeof(Choice), "normals of manifolds"));
    Job job = {m, proximities, m->choices.data};
    size_t blocks = (count + qc_normalBlock - 1) / qc_normalBlock;
    qcParallel_For(threads, blocks, qc_leastNormalBlocks, CompareBlock, &job);
    qcParallel_For(threads, blocks, qc_leastNormalBlocks, ChooseBlock, &job);
    for (size_t p = 0; p < count; p++)
    {
        qcManifoldPair* pair = &QC_AT(qcManifoldPair, m->work, p);
        pair->own = AreEqual(pair->normal, job.choices[p].normal);
        pair->normal = job.choices[p].normal;
        pair->apart = job.choices[p].apart;
    }
    return qc_statusOk;
}
