// Regions that one short push would free: what is told of much longer ways takes that push's direction. The least
// translation that parts two bodies (Cameron, Culley: Determining the minimum translational distance, 1986), for what
// is near of them and along directions that their own pairs know.
//
// Pairs look one neighbour far, and the signs of their normals go along links that may lead around an edge. Where a
// corner has sunk into a cut, both can end in a part of the region that is told to go sideways, or right through a
// body, by ten times what would do: its depths are true along its normals, but nobody has to go that way. Which part
// that is, and whether, changes with the margin, as pairs that are apart join in.
//
// What a direction costs a region is an upper bound of what anybody in it has to go: so far side 0 has to move along it
// until a plane lies between the triangles of each pair. If the cheapest of the normals of pairs that cross costs less
// than half of the deepest point, then the pairs that are more than twice as deep as that take it. The others, which
// may well lie against another wall, keep their own.
//
// Limits: only directions that some pair has chosen are known, of many only the first; and what is hooked into each
// other has no such direction.
#include "manifold/normal_cost.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <math.h>

enum
{
    // Directions that a region tries; most have fewer than ten.
    qc_mostEscapes = 32
};

// A way out is too long if the whole region has one of this share of it.
static const double s_muchShorter = 0.5;

/// The pairs of a region.
typedef struct Members
{
    const qcManifoldBuilder* manifolds;
    const qcSortItem* items; ///< their values are pairs
    size_t count;
    double deepest;
    uint32_t last; ///< what cost too much last will do so again: asked first
} Members;

/// A direction that frees a region, and how far along it.
typedef struct Escape
{
    qcVector normal;
    double depth;
} Escape;

static uint32_t PairOf(const Members* members, size_t i)
{
    return (uint32_t)members->items[i].value;
}

static double DepthOf(const qcManifoldBuilder* m, uint32_t index)
{
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    const qcRawPoint* corners = qcManifoldBuilder_Corners(m, index);
    double depth = 0.0;
    for (int i = 0; i < QC_AT(qcPairCorners, m->corners, index).count; i++)
        depth = fmax(depth, pair->turned ? corners[i].distance : -corners[i].distance);
    return depth;
}

static double WayOut(const qcManifoldBuilder* m, uint32_t index, qcVector normal)
{
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    qcVector origin = pair->side[1]->corner[0];
    return qcWaysOut_Of(qcManifoldTriangle_Heights(pair->side[0], origin, normal),
                        qcManifoldTriangle_Heights(pair->side[1], origin, normal))
        .along;
}

/// Is a direction cheaper than the best? Then it is that.
static void Consider(Members* members, qcVector normal, Escape* best)
{
    double depth = fmax(WayOut(members->manifolds, members->last, normal), 0.0);
    for (size_t i = 0; i < members->count && depth < best->depth; i++)
    {
        double way = WayOut(members->manifolds, PairOf(members, i), normal);
        if (way >= best->depth)
            members->last = PairOf(members, i);
        depth = fmax(depth, way);
    }
    if (depth < best->depth)
        *best = (Escape){normal, depth};
}

/// The cheapest direction, if it is much shorter than the deepest point; otherwise its depth is what it began with.
static Escape FindEscape(Members* members)
{
    qcVector tried[qc_mostEscapes];
    int count = 0;
    Escape best = {.depth = s_muchShorter * members->deepest};
    for (size_t i = 0; i < members->count && count < qc_mostEscapes; i++)
    {
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(members->manifolds, PairOf(members, i));
        int known = 0;
        while (known < count && qcDot(tried[known], pair->normal) < QC_MANIFOLD_FLAT)
            known++;
        if (!pair->crossing || known < count)
            continue;
        tried[count++] = pair->normal;
        Consider(members, pair->normal, &best);
    }
    return best;
}

/// Gives a pair a direction, and its corners along it.
static qcStatus Send(qcManifoldBuilder* m, uint32_t index, qcVector normal, double margin)
{
    qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    qcArray* points = &QC_AT(qcManifoldWorker, m->workers, 0).points;
    QC_TRY(qcArray_Reserve(points, points->count + qc_maxCommonCorners, sizeof(qcRawPoint), "contact points"));
    pair->normal = normal;
    pair->own = pair->turned = pair->apart = false;
    qcLook look = {.count = -1};
    qcLook_Along(m, pair, normal, &look);
    qcManifoldBuilder_KeepCorners(m, index, 0, &look, normal, false, margin);
    return qc_statusOk;
}

static qcStatus SendDeep(qcManifoldBuilder* m, Members* members, double margin)
{
    for (size_t i = 0; i < members->count; i++)
    {
        double depth = DepthOf(m, PairOf(members, i));
        if (depth > members->deepest)
            members->last = PairOf(members, i);
        members->deepest = fmax(members->deepest, depth);
    }
    Escape best = FindEscape(members);
    if (!(best.depth < s_muchShorter * members->deepest))
        return qc_statusOk;
    for (size_t i = 0; i < members->count; i++)
        if (s_muchShorter * DepthOf(m, PairOf(members, i)) > best.depth)
            QC_TRY(Send(m, PairOf(members, i), best.normal, margin));
    return qc_statusOk;
}

/// Of regions that something crosses, by region; of each they stay in their order.
static qcStatus ListMembers(qcManifoldBuilder* m)
{
    QC_TRY(qcArray_Reserve(&m->order, m->freePairs.count, sizeof(qcSortItem), "ways out of regions"));
    m->order.count = 0;
    for (size_t i = 0; i < m->freePairs.count; i++)
    {
        uint32_t p = qcManifoldBuilder_FreePair(m, i);
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        if (qcManifoldBuilder_PairRegion(m, pair)->crossing)
            QC_AT(qcSortItem, m->order, m->order.count++) = (qcSortItem){pair->region, p};
    }
    return qcSort_Items(m->order.data, m->order.count, &m->scratch);
}

qcStatus qcManifoldBuilder_FindEscapes(qcManifoldBuilder* m, double margin)
{
    QC_TRY(ListMembers(m));
    const qcSortItem* items = m->order.data;
    for (size_t first = 0, end = 0; first < m->order.count; first = end)
    {
        while (end < m->order.count && items[end].key == items[first].key)
            end++;
        Members members = {
            .manifolds = m, .items = items + first, .count = end - first, .last = (uint32_t)items[first].value};
        QC_TRY(SendDeep(m, &members, margin));
    }
    return qc_statusOk;
}
