// Regions that one plane parts: all triangles of side 0 lie above it, all of side 1 below. The separating axis of
// convex bodies (Gottschalk, Lin, Manocha: OBBTree, 1996), for what is near of any two.
//
// So lie the fresh pieces of a broken body, a box on a floor, whatever stands flat. Most pairs of such a region touch
// along an edge or in a corner, say little themselves, and would have to hear it from others: a face has a few pairs
// that cover each other, its rim has dozens. But as long as the plane's points hold the two sides apart along its
// normal nothing else in the region can meet, so that all pairs have this one direction: nobody has to be asked what
// it says itself, nor those around.
//
// The plane lies along a face of the largest pair that stands flat: parallel, near, over each other. A region without
// one is not settled. Of its two faces that one counts along which the region overlaps less: a box that is tilted on
// the floor has the floor's.
//
// What rounding does to corners may let the sides overlap, and so may a box that has sunk into the floor. Where
// triangles meet, twice the overlap of the flat pair itself is allowed, no more than what still counts as flat; and the
// other way out must be four times as far, so that there is no doubt which side is which. Thin sheets in each other are
// not settled. Where nothing meets only rounding is allowed: that a pair is apart is a fact.
#include "manifold/manifold_builder.h"
#include "base/status.h"

#include <math.h>

// Corners given in single precision, and turned, are off by less than this share of the size of a triangle, unless they
// are far from the origin.
static const double s_rounding = 0x1p-20;
// The shorter way out is surely the way out if it is no longer than this share of the other one.
static const double s_shorter = 0.25;

/// What is known of a region.
typedef struct Plane
{
    double area;           ///< twice that of the smaller triangle of the flat pair; 0: there is none
    uint32_t flat;         ///< the pair
    qcHeights sides[2][2]; ///< along the face of a side of the flat pair, of a side of the region
} Plane;

/// Do the triangles lie on each other, or a little above or below?
static bool LieFlat(const qcManifoldBuilder* m, const qcManifoldPair* pair)
{
    qcRawPoint corners[qc_maxCommonCorners];
    int count = qcManifoldBuilder_FindCommonPart(m, pair, pair->side[1]->normal, corners);
    double nearest = INFINITY;
    for (int i = 0; i < count; i++)
        nearest = fmin(nearest, fabs(corners[i].distance));
    return nearest <= QC_MANIFOLD_AREA * qcManifoldPair_SmallerSize(pair) &&
           qcManifoldPair_CoversArea(pair, corners, count);
}

/// Of each region the flat pair whose smaller triangle is the largest.
static void FindFlatPairs(qcManifoldBuilder* m)
{
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        Plane* plane = &QC_AT(Plane, m->planes, pair->region);
        if (!(fabs(qcDot(pair->side[0]->normal, pair->side[1]->normal)) >= QC_MANIFOLD_FLAT))
            continue;
        double area = fmin(pair->side[0]->doubleArea, pair->side[1]->doubleArea);
        if (!(area > plane->area) || !LieFlat(m, pair))
            continue;
        plane->area = area;
        plane->flat = p;
    }
}

static void Widen(qcHeights* all, qcHeights heights)
{
    all->low = heights.low < all->low ? heights.low : all->low;
    all->high = heights.high > all->high ? heights.high : all->high;
}

/// How high the sides of the regions reach, as seen from the flat pairs. Each triangle is asked once, mostly.
static void FindHeights(qcManifoldBuilder* m)
{
    for (size_t i = 0; i < m->triangles.count; i++)
        QC_AT(qcManifoldTriangle, m->triangles, i).heardBy = UINT32_MAX;
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        Plane* plane = &QC_AT(Plane, m->planes, pair->region);
        if (plane->area == 0.0)
            continue;
        const qcManifoldPair* flat = qcManifoldBuilder_Pair(m, plane->flat);
        for (uint32_t side = 0; side < 2; side++)
        {
            qcManifoldTriangle* triangle = qcManifoldBuilder_Triangle(m, pair, side);
            uint32_t asked = pair->region << 1 | side;
            if (triangle->heardBy == asked)
                continue;
            triangle->heardBy = asked;
            for (int face = 0; face < 2; face++)
                Widen(&plane->sides[face][side],
                      qcManifoldTriangle_Heights(triangle, flat->side[face]->corner[0], flat->side[face]->normal));
        }
    }
}

/// The overlap along a face of the flat pair, the shorter way out of both; infinity if it is too large.
static double FindOverlap(const qcManifoldBuilder* m, const qcPairRegion* region, const Plane* plane, int face,
                          bool* against)
{
    const qcManifoldPair* flat = qcManifoldBuilder_Pair(m, plane->flat);
    const qcManifoldTriangle* triangle = flat->side[face];
    qcWaysOut all = qcWaysOut_Of(plane->sides[face][0], plane->sides[face][1]);
    qcWaysOut own = qcWaysOut_Of(qcManifoldTriangle_Heights(flat->side[0], triangle->corner[0], triangle->normal),
                                 qcManifoldTriangle_Heights(flat->side[1], triangle->corner[0], triangle->normal));
    *against = all.against < all.along;
    double shorter = *against ? all.against : all.along, longer = *against ? all.along : all.against;
    double size = qcManifoldPair_SmallerSize(flat), allowed = s_rounding * size;
    if (region->meets)
        allowed = fmin(fmax(allowed, 2.0 * (*against ? own.against : own.along)), QC_MANIFOLD_AREA * size);
    return shorter <= allowed && shorter <= s_shorter * longer ? shorter : INFINITY;
}

/// Has the pair a contact point along a normal?
static bool HasPoint(const qcManifoldBuilder* m, const qcManifoldPair* pair, qcVector normal, double margin)
{
    qcRawPoint corners[qc_maxCommonCorners];
    int count = qcManifoldBuilder_FindCommonPart(m, pair, normal, corners);
    bool found = false;
    for (int i = 0; i < count; i++)
        found = found || corners[i].distance <= qcManifoldPair_Limit(pair, margin);
    return found;
}

/// Returns whether a plane parts the region and has a point there, and its normal from side 1 towards side 0.
static bool FindNormal(const qcManifoldBuilder* m, uint32_t r, double margin, qcVector* normal)
{
    const qcPairRegion* region = &QC_AT(qcPairRegion, m->regions, r);
    const Plane* plane = &QC_AT(Plane, m->planes, r);
    if (plane->area == 0.0)
        return false;
    bool against[2];
    double overlap[2];
    for (int face = 0; face < 2; face++)
        overlap[face] = FindOverlap(m, region, plane, face, &against[face]);
    int face = overlap[1] < overlap[0] ? 1 : 0;
    const qcManifoldPair* flat = qcManifoldBuilder_Pair(m, plane->flat);
    qcVector n = flat->side[face]->normal;
    *normal = against[face] ? qcNegated(n) : n;
    return overlap[face] < INFINITY && HasPoint(m, flat, *normal, margin);
}

qcStatus qcManifoldBuilder_FindPlanes(qcManifoldBuilder* m, double margin)
{
    static const qcHeights nothing = {INFINITY, -INFINITY};
    QC_TRY(qcArray_Resize(&m->planes, m->regions.count, sizeof(Plane), "planes of contact"));
    for (size_t r = 0; r < m->regions.count; r++)
        QC_AT(Plane, m->planes, r) = (Plane){.sides = {{nothing, nothing}, {nothing, nothing}}};
    FindFlatPairs(m);
    FindHeights(m);
    for (uint32_t r = 0; r < m->regions.count; r++)
    {
        qcPairRegion* region = &QC_AT(qcPairRegion, m->regions, r);
        region->settled = FindNormal(m, r, margin, &region->normal);
    }
    QC_TRY(qcArray_Reserve(&m->freePairs, m->work.count, sizeof(uint32_t), "planes of contact"));
    m->freePairs.count = 0;
    for (uint32_t p = 0; p < m->work.count; p++)
    {
        qcManifoldPair* pair = qcManifoldBuilder_Pair(m, p);
        const qcPairRegion* region = qcManifoldBuilder_PairRegion(m, pair);
        pair->settled = region->settled;
        if (region->settled)
            pair->normal = region->normal;
        else
            QC_AT(uint32_t, m->freePairs, m->freePairs.count++) = p;
    }
    return qc_statusOk;
}
