// Disjoint, touching or penetrating: the relation of two closed triangles, degenerate ones included. Only signs of
// exact predicates and comparisons of given coordinates are used: nothing is rounded. The idea of Guigue and Devillers,
// Fast and Robust Triangle-Triangle Overlap Test, 2003, without permutations. Proof:
// plugin/docs/proofs/intersection_test.md.
#include "triangle/exact.h"

#include "base/float_mode.h"

#include <assert.h>
#include <stddef.h>

/// How an axis separates: not at all, weakly (only borders meet), strictly.
typedef enum Separation
{
    separation_none = 0,
    separation_weak = 1,
    separation_strict = 2
} Separation;

static qcRelation FromSeparation(Separation separation)
{
    return separation == separation_strict ? qc_relationDisjoint
           : separation == separation_weak ? qc_relationTouching
                                           : qc_relationPenetrating;
}

static Separation Larger(Separation a, Separation b)
{
    return a > b ? a : b;
}

static bool BoxesMeet(const double a[3][3], const double b[3][3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        double a0 = a[0][axis], a1 = a[1][axis], a2 = a[2][axis];
        double b0 = b[0][axis], b1 = b[1][axis], b2 = b[2][axis];
        double aLow = a0 < a1 ? a0 : a1, aHigh = a0 < a1 ? a1 : a0;
        double bLow = b0 < b1 ? b0 : b1, bHigh = b0 < b1 ? b1 : b0;
        aLow = a2 < aLow ? a2 : aLow;
        aHigh = a2 > aHigh ? a2 : aHigh;
        bLow = b2 < bLow ? b2 : bLow;
        bHigh = b2 > bHigh ? b2 : bHigh;
        if (aLow > bHigh || bLow > aHigh)
            return false;
    }
    return true;
}

static bool IsCornerOf(const double point[3], const double t[3][3])
{
    for (int i = 0; i < 3; i++)
        if (point[0] == t[i][0] && point[1] == t[i][1] && point[2] == t[i][2])
            return true;
    return false;
}

/// True if each corner of one is a corner of the other: both are the same triangle, segment or point.
static bool AreSame(const double a[3][3], const double b[3][3])
{
    return IsCornerOf(a[0], b) && IsCornerOf(a[1], b) && IsCornerOf(a[2], b) && IsCornerOf(b[0], a) &&
           IsCornerOf(b[1], a) && IsCornerOf(b[2], a);
}

//  ---- general position --------------------------------------------------------------------------------------

static bool SameStrictSide(const int side[3])
{
    return side[0] != 0 && side[0] == side[1] && side[1] == side[2];
}

static bool AllZero(const int side[3])
{
    return side[0] == 0 && side[1] == 0 && side[2] == 0;
}

/// True if corners lie strictly on both sides. This holds if and only if the relative interior intersects the plane.
static bool Straddles(const int side[3])
{
    bool positive = side[0] > 0 || side[1] > 0 || side[2] > 0;
    bool negative = side[0] < 0 || side[1] < 0 || side[2] < 0;
    return positive && negative;
}

/// The corner whose two edges cross (or end on) the other plane, at the two ends of the interval: its side differs from
/// that of both others. For sides (0, +, -) it is a corner off the plane, since both edges of the corner on the plane
/// end there.
static int Apex(const int side[3])
{
    int apex = -1;
    for (int i = 0; i < 3; i++)
        if (side[i] != side[(i + 1) % 3] && side[i] != side[(i + 2) % 3] && (apex < 0 || side[i] != 0))
            apex = i;
    return apex;
}

/// The relation of triangles whose planes intersect in a line that both triangles touch or cross.
static qcRelation OnLine(const double a[3][3], const double b[3][3], const int sideA[3], const int sideB[3],
                         uint64_t* undecided)
{
    int apexA = Apex(sideA), apexB = Apex(sideB);
    bool below = false, above = false, level = false;
    for (int i = 1; i < 3; i++)
    {
        int endA = (apexA + i) % 3;
        int crossingA = sideA[endA] > sideA[apexA] ? 1 : -1;
        for (int j = 1; j < 3; j++)
        {
            int endB = (apexB + j) % 3;
            int crossingB = sideB[endB] > sideB[apexB] ? 1 : -1;
            int order = qcOrient3d(a[apexA], a[endA], b[apexB], b[endB], undecided) * crossingA * crossingB;
            below = below || order < 0;
            above = above || order > 0;
            level = level || order == 0;
        }
    }
    // The four orders compare each end of one interval with each end of the other. All equal and strict: the intervals
    // are disjoint. Both strict orders: the open intervals overlap.
    if (!level && below != above)
        return qc_relationDisjoint;
    if (below && above && Straddles(sideA) && Straddles(sideB))
        return qc_relationPenetrating;
    return qc_relationTouching;
}

//  ---- in a plane, on a line -----------------------------------------------------------------------------------

/// The separation of the points from the triangle t by its edges. All in one plane, in t's coordinates (u, v).
static Separation ByEdges(const qcSimplex* t, const qcSimplex* points, uint64_t* undecided)
{
    Separation separation = separation_none;
    for (int e = 0; e < 3; e++)
    {
        bool inside = false, on = false;
        for (int i = 0; i <= points->dimension; i++)
        {
            int side =
                t->sign * qcOrient2d(t->point[e], t->point[(e + 1) % 3], points->point[i], t->u, t->v, undecided);
            inside = inside || side > 0;
            on = on || side == 0;
        }
        if (!inside)
            separation = Larger(separation, on ? separation_weak : separation_strict);
    }
    return separation;
}

/// The separation of the points from the segment s by its line.
static Separation ByLine(const qcSimplex* s, const qcSimplex* points, int u, int v, uint64_t* undecided)
{
    bool left = false, right = false, on = false;
    for (int i = 0; i <= points->dimension; i++)
    {
        int side = qcOrient2d(s->point[0], s->point[1], points->point[i], u, v, undecided);
        left = left || side > 0;
        right = right || side < 0;
        on = on || side == 0;
    }
    if (left && right)
        return separation_none;
    return on ? separation_weak : separation_strict;
}

static qcRelation SegmentTriangle(const qcSimplex* s, const qcSimplex* t, uint64_t* undecided)
{
    int side[2];
    for (int i = 0; i < 2; i++)
        side[i] = qcOrient3d(t->point[0], t->point[1], t->point[2], s->point[i], undecided);
    if (side[0] == 0 && side[1] == 0)
        return FromSeparation(Larger(ByEdges(t, s, undecided), ByLine(s, t, t->u, t->v, undecided)));
    if (side[0] == side[1])
        return qc_relationDisjoint;
    // The segment's line crosses the plane in one point: compute on which side of each edge.
    bool left = false, right = false, on = false;
    for (int e = 0; e < 3; e++)
    {
        int pass = qcOrient3d(s->point[0], s->point[1], t->point[e], t->point[(e + 1) % 3], undecided);
        left = left || pass > 0;
        right = right || pass < 0;
        on = on || pass == 0;
    }
    if (left && right)
        return qc_relationDisjoint;
    return on || side[0] == 0 || side[1] == 0 ? qc_relationTouching : qc_relationPenetrating;
}

static qcRelation PointTriangle(const qcSimplex* p, const qcSimplex* t, uint64_t* undecided)
{
    if (qcOrient3d(t->point[0], t->point[1], t->point[2], p->point[0], undecided) != 0)
        return qc_relationDisjoint;
    return FromSeparation(ByEdges(t, p, undecided));
}

/// Intervals on a common line, compared in a coordinate in which b is not a point.
static qcRelation OnCommonLine(const qcSimplex* a, const qcSimplex* b)
{
    double aLow = a->point[0][b->u], aHigh = a->point[a->dimension][b->u];
    if (aLow > aHigh)
    {
        double swap = aLow;
        aLow = aHigh;
        aHigh = swap;
    }
    double bLow = b->point[0][b->u], bHigh = b->point[1][b->u];
    if (aHigh < bLow || bHigh < aLow)
        return qc_relationDisjoint;
    return aHigh > bLow && bHigh > aLow ? qc_relationPenetrating : qc_relationTouching;
}

static qcRelation SegmentSegment(const qcSimplex* a, const qcSimplex* b, uint64_t* undecided)
{
    const double* p[4] = {a->point[0], a->point[1], b->point[0], b->point[1]};
    if (qcOrient3d(p[0], p[1], p[2], p[3], undecided) != 0)
        return qc_relationDisjoint;
    // All in one plane. If three of the four are not collinear in (u, v), the projection is one to one.
    for (int axis = 0; axis < 3; axis++)
    {
        int u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (int omit = 0; omit < 4; omit++)
            if (qcOrient2d(p[(omit + 1) % 4], p[(omit + 2) % 4], p[(omit + 3) % 4], u, v, undecided) != 0)
                return FromSeparation(Larger(ByLine(a, b, u, v, undecided), ByLine(b, a, u, v, undecided)));
    }
    return OnCommonLine(a, b);
}

static qcRelation PointSegment(const qcSimplex* p, const qcSimplex* s, uint64_t* undecided)
{
    for (int axis = 0; axis < 3; axis++)
        if (qcOrient2d(s->point[0], s->point[1], p->point[0], (axis + 1) % 3, (axis + 2) % 3, undecided) != 0)
            return qc_relationDisjoint;
    return OnCommonLine(p, s);
}

static qcRelation RelateFlat(const double a[3][3], const double b[3][3], uint64_t* undecided)
{
    qcSimplex first = qcSimplex_Of(a, undecided), second = qcSimplex_Of(b, undecided);
    const qcSimplex* small = first.dimension <= second.dimension ? &first : &second;
    const qcSimplex* large = first.dimension <= second.dimension ? &second : &first;
    switch (large->dimension * 3 + small->dimension)
    {
        case 2 * 3 + 2:
            return FromSeparation(Larger(ByEdges(large, small, undecided), ByEdges(small, large, undecided)));
        case 2 * 3 + 1: return SegmentTriangle(small, large, undecided);
        case 2 * 3 + 0: return PointTriangle(small, large, undecided);
        case 1 * 3 + 1: return SegmentSegment(small, large, undecided);
        default:
            // Two points whose boxes meet are the same triangle.
            assert(large->dimension == 1);
            return PointSegment(small, large, undecided);
    }
}

qcRelation qcExact_Relate(const double a[3][3], const double b[3][3], uint64_t* undecided)
{
    if (AreSame(a, b))
        return qc_relationPenetrating;
    if (!BoxesMeet(a, b))
        return qc_relationDisjoint;
    int sideB[3], sideA[3];
    qcOrient3dSides(a, b, sideB, undecided);
    if (SameStrictSide(sideB))
        return qc_relationDisjoint;
    if (AllZero(sideB))
        return RelateFlat(a, b, undecided);
    qcOrient3dSides(b, a, sideA, undecided);
    if (SameStrictSide(sideA))
        return qc_relationDisjoint;
    if (AllZero(sideA))
        return RelateFlat(a, b, undecided);
    return OnLine(a, b, sideA, sideB, undecided);
}

__attribute__((noinline)) static qcRelation Relate(const double* a, const double* b)
{
    double corners[2][3][3];
    for (int i = 0; i < 9; i++)
    {
        corners[0][i / 3][i % 3] = a[i];
        corners[1][i / 3][i % 3] = b[i];
    }
    return qcExact_Relate(corners[0], corners[1], NULL);
}

qcRelation qcRelateTriangles(const double* a, const double* b)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcRelation relation = Relate(a, b);
    qcFloatMode_End(mode);
    return relation;
}

const char* qcRelation_Name(qcRelation relation)
{
    static const char* const s_names[] = {"disjoint", "touching", "penetrating", "near"};
    return (unsigned)relation < 4 ? s_names[relation] : "unknown relation";
}
