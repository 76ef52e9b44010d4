// A separating direction exists if and only if the origin is not in the convex hull of all differences a - b of corners
// at the start and at the end. GJK looks for the hull's point closest to the origin and stops at the first direction
// that is proven. Gilbert, Johnson, Keerthi: A Fast Procedure for Computing the Distance Between Complex Objects, 1988.
#include "triangle/motion_certificate.h"

#include "base/aabb.h"
#include "base/float_mode.h"
#include "base/scalar.h"
#include "base/vec3.h"
#include "quickcullide/scene.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum
{
    // Among 4.4 million certificates of test_motion_certificate and 160 thousand of cloth, none took more than 12 and
    // 10 rounds; half of them take 3 or 4. Pairs that touch may go round for ever.
    qc_maxRounds = 16
};

/// Corners relative to the first corner of A at the start and at the end, scaled so that no coordinate exceeds 1.
typedef struct RelativeCorners
{
    qcVector a[2][3], b[2][3];
} RelativeCorners;

static inline double LargestCoordinate(qcVector v)
{
    return qcMax(fabs(v.z), qcMax(fabs(v.y), fabs(v.x)));
}

/// The relative corners of one end. False: differences overflow, or all corners coincide.
static bool MakeRelative(const double a[3][3], const double b[3][3], qcVector relativeA[3], qcVector relativeB[3])
{
    double size = 0.0;
    qcVector origin = qcVector_Load(a[0]);
    for (int c = 0; c < 3; c++)
    {
        relativeA[c] = qcMinus(qcVector_Load(a[c]), origin);
        relativeB[c] = qcMinus(qcVector_Load(b[c]), origin);
        size = qcMax(LargestCoordinate(relativeA[c]), size);
        size = qcMax(LargestCoordinate(relativeB[c]), size);
        // qcMax returns `size` for NaN, which is infinity minus infinity here.
        if (!(relativeB[c].x + relativeB[c].y + relativeB[c].z - relativeA[c].x - relativeA[c].y - relativeA[c].z <
              INFINITY))
            return false;
    }
    if (!(size >= DBL_MIN && size <= DBL_MAX))
        return false;
    int exponent;
    frexp(size, &exponent);
    // Two factors: one alone may overflow.
    double first = ldexp(1.0, -(exponent / 2)), second = ldexp(1.0, exponent / 2 - exponent);
    const qcVector zero = {0.0, 0.0, 0.0};
    for (int c = 0; c < 3; c++)
    {
        relativeA[c] = qcPlusScaled(zero, qcPlusScaled(zero, relativeA[c], first), second);
        relativeB[c] = qcPlusScaled(zero, qcPlusScaled(zero, relativeB[c], first), second);
    }
    return true;
}

/// The smallest product of a difference with `v`; `support` receives that difference.
static double FindSupport(const RelativeCorners* r, qcVector v, qcVector* support)
{
    double min = DBL_MAX;
    for (int t = 0; t < 2; t++)
    {
        int low = 0, high = 0;
        double minA = qcDot(v, r->a[t][0]), maxB = qcDot(v, r->b[t][0]);
        for (int c = 1; c < 3; c++)
        {
            double onA = qcDot(v, r->a[t][c]), onB = qcDot(v, r->b[t][c]);
            low = onA < minA ? c : low;
            high = onB > maxB ? c : high;
            minA = onA < minA ? onA : minA;
            maxB = onB > maxB ? onB : maxB;
        }
        if (minA - maxB < min)
        {
            min = minA - maxB;
            *support = qcMinus(r->a[t][low], r->b[t][high]);
        }
    }
    return min;
}

//  ---- the point of a simplex closest to the origin ------------------------------------------------------------------

/// Differences, and the weights of the point closest to the origin: 0 or more.
typedef struct Simplex
{
    int count;
    qcVector point[4];
    double weight[4];
} Simplex;

static double LengthSquared(qcVector v)
{
    return qcDot(v, v);
}

/// Returns the squared distance, as the functions below.
static double SolveSegment(qcVector p, qcVector q, double weight[2])
{
    qcVector along = qcMinus(q, p);
    double length2 = LengthSquared(along), t = length2 > 0.0 ? -qcDot(p, along) / length2 : 0.0;
    t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    weight[0] = 1.0 - t;
    weight[1] = t;
    return LengthSquared(qcPlusScaled(p, along, t));
}

static double SolveTriangle(qcVector p, qcVector q, qcVector r, double weight[3])
{
    qcVector normal = qcCross(qcMinus(q, p), qcMinus(r, p));
    double inside[3] = {qcDot(normal, qcCross(q, r)), qcDot(normal, qcCross(r, p)), qcDot(normal, qcCross(p, q))};
    if (LengthSquared(normal) > 0.0 && inside[0] >= 0.0 && inside[1] >= 0.0 && inside[2] >= 0.0)
    {
        double sum = inside[0] + inside[1] + inside[2];
        for (int i = 0; i < 3; i++)
            weight[i] = inside[i] / sum;
        double height = qcDot(normal, p);
        return height * height / LengthSquared(normal);
    }
    const qcVector corner[3] = {p, q, r};
    double best = DBL_MAX;
    for (int i = 0; i < 3; i++)
    {
        double w[2], distance2 = SolveSegment(corner[i], corner[(i + 1) % 3], w);
        if (distance2 >= best)
            continue;
        best = distance2;
        weight[i] = w[0];
        weight[(i + 1) % 3] = w[1];
        weight[(i + 2) % 3] = 0.0;
    }
    return best;
}

/// Solves the face of a tetrahedron that is closest to the origin, which lies outside.
static void SolveFaces(const qcVector point[4], double weight[4])
{
    static const int faces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
    double best = DBL_MAX;
    for (int f = 0; f < 4; f++)
    {
        double w[3] = {0.0, 0.0, 0.0};
        double distance2 = SolveTriangle(point[faces[f][0]], point[faces[f][1]], point[faces[f][2]], w);
        if (distance2 >= best)
            continue;
        best = distance2;
        memset(weight, 0, 4 * sizeof weight[0]);
        for (int i = 0; i < 3; i++)
            weight[faces[f][i]] = w[i];
    }
}

/// The origin is on the inner side of each face.
static bool ContainsOrigin(const qcVector point[4])
{
    static const int faces[4][4] = {{0, 1, 2, 3}, {0, 3, 1, 2}, {0, 2, 3, 1}, {1, 3, 2, 0}};
    for (int f = 0; f < 4; f++)
    {
        qcVector p = point[faces[f][0]];
        qcVector normal = qcCross(qcMinus(point[faces[f][1]], p), qcMinus(point[faces[f][2]], p));
        if (!(qcDot(normal, qcMinus(point[faces[f][3]], p)) * -qcDot(normal, p) > 0.0))
            return false;
    }
    return true;
}

/// A vector in the direction of the closest point. With two corners or three that point is a small sum of large terms,
/// whose rounding errors would hide gaps below 1e-8 of the triangles' size.
static qcVector DirectionOf(const Simplex* s)
{
    qcVector sum = {0.0, 0.0, 0.0}, along = qcMinus(s->point[1], s->point[0]);
    for (int i = 0; i < s->count; i++)
        sum = qcPlusScaled(sum, s->point[i], s->weight[i]);
    double length2 = LengthSquared(along);
    if (s->count == 2 && length2 > 0.0)
        return qcPlusScaled(sum, along, -qcDot(sum, along) / length2);
    if (s->count == 3)
    {
        qcVector normal = qcCross(along, qcMinus(s->point[2], s->point[0]));
        double height = qcDot(normal, s->point[0]);
        return height > 0.0 ? normal : height < 0.0 ? qcNegated(normal) : sum;
    }
    return sum;
}

/// Drops the corners that the closest point doesn't depend on, and finds its direction. False: the origin is inside.
static bool Reduce(Simplex* s, qcVector* direction)
{
    switch (s->count)
    {
        case 1: s->weight[0] = 1.0; break;
        case 2: SolveSegment(s->point[0], s->point[1], s->weight); break;
        case 3: SolveTriangle(s->point[0], s->point[1], s->point[2], s->weight); break;
        default:
            if (ContainsOrigin(s->point))
                return false;
            SolveFaces(s->point, s->weight);
    }
    int kept = 0;
    for (int i = 0; i < s->count; i++)
    {
        if (!(s->weight[i] > 0.0))
            continue;
        s->weight[kept] = s->weight[i];
        s->point[kept++] = s->point[i];
    }
    s->count = kept;
    *direction = DirectionOf(s);
    return kept > 0;
}

//  ---- certificates --------------------------------------------------------------------------------------------------

/// The sum of all differences: a first direction that often separates.
static qcVector SumDifferences(const RelativeCorners* r)
{
    qcVector sum = {0.0, 0.0, 0.0};
    for (int t = 0; t < 2; t++)
        for (int c = 0; c < 3; c++)
            sum = qcPlusScaled(sum, qcMinus(r->a[t][c], r->b[t][c]), 1.0);
    return sum;
}

static bool IsEqual(qcVector a, qcVector b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

bool qcMotion_BoxesSeparate(const qcMovingTriangle* a, const qcMovingTriangle* b, double direction[3])
{
    double lowerA[2][3], upperA[2][3], lowerB[2][3], upperB[2][3];
    qcBounds_OfTriangle(a->start, lowerA[0], upperA[0]);
    qcBounds_OfTriangle(a->end, lowerA[1], upperA[1]);
    qcBounds_OfTriangle(b->start, lowerB[0], upperB[0]);
    qcBounds_OfTriangle(b->end, lowerB[1], upperB[1]);
    for (int k = 0; k < 3; k++)
    {
        bool above = lowerA[0][k] > upperB[0][k] && lowerA[1][k] > upperB[1][k];
        bool below = upperA[0][k] < lowerB[0][k] && upperA[1][k] < lowerB[1][k];
        if (!above && !below)
            continue;
        for (int i = 0; i < 3 && direction != NULL; i++)
            direction[i] = i != k ? 0.0 : above ? 1.0 : -1.0;
        return true;
    }
    return false;
}

bool qcMotion_Separates(const qcMovingTriangle* a, const qcMovingTriangle* b, double direction[3])
{
    return qcMotion_BoxesSeparate(a, b, direction) || qcMotion_FindDirection(a, b, direction);
}

bool qcMotion_FindDirection(const qcMovingTriangle* a, const qcMovingTriangle* b, double direction[3])
{
    RelativeCorners r;
    if (!MakeRelative(a->start, b->start, r.a[0], r.b[0]) || !MakeRelative(a->end, b->end, r.a[1], r.b[1]))
        return false;
    qcVector v = SumDifferences(&r);
    Simplex simplex = {.count = 0};
    for (int round = 0; round < qc_maxRounds; round++)
    {
        double size = fabs(v.x) + fabs(v.y) + fabs(v.z);
        qcVector support;
        if (!(size > 1e-100))
            return false;
        double min = FindSupport(&r, v, &support);
        if (min > 0x1p-48 * size)
        {
            if (direction != NULL)
                memcpy(direction, (double[3]){v.x, v.y, v.z}, 3 * sizeof(double));
            return true;
        }
        for (int i = 0; i < simplex.count; i++)
            if (IsEqual(simplex.point[i], support))
                return false;
        simplex.point[simplex.count++] = support;
        if (!Reduce(&simplex, &v))
            return false;
    }
    return false;
}

/// The segment, or the point, of these corners.
static qcMovingTriangle PartOf(const qcMovingTriangle* triangle, int first, int second)
{
    qcMovingTriangle part;
    const int corners[3] = {first, second, second};
    for (int c = 0; c < 3; c++)
    {
        memcpy(part.start[c], triangle->start[corners[c]], sizeof part.start[c]);
        memcpy(part.end[c], triangle->end[corners[c]], sizeof part.end[c]);
    }
    return part;
}

/// Puts common corners first, in the same order for both. Returns their number.
static int OrderCorners(const uint32_t indicesA[3], const uint32_t indicesB[3], int orderA[3], int orderB[3])
{
    int common = 0;
    bool usedA[3] = {false, false, false}, usedB[3] = {false, false, false};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            if (!usedA[i] && !usedB[k] && indicesA[i] == indicesB[k])
            {
                orderA[common] = i;
                orderB[common++] = k;
                usedA[i] = usedB[k] = true;
            }
    for (int c = 0, i = common, k = common; c < 3; c++)
    {
        if (!usedA[c])
            orderA[i++] = c;
        if (!usedB[c])
            orderB[k++] = c;
    }
    return common;
}

bool qcTrianglesStayApart(const double* startA, const double* endA, const double* startB, const double* endB,
                          double direction[3])
{
    qcMovingTriangle a, b;
    memcpy(a.start, startA, sizeof a.start);
    memcpy(a.end, endA, sizeof a.end);
    memcpy(b.start, startB, sizeof b.start);
    memcpy(b.end, endB, sizeof b.end);
    qcFloatMode mode = qcFloatMode_Begin();
    bool apart = qcMotion_Separates(&a, &b, direction);
    qcFloatMode_End(mode);
    return apart;
}

bool qcMotion_SeparatesNeighbours(const qcMovingTriangle* a, const uint32_t indicesA[3], const qcMovingTriangle* b,
                                  const uint32_t indicesB[3])
{
    int p[3], q[3], common = OrderCorners(indicesA, indicesB, p, q);
    if (common != 1 && common != 2)
        return common == 0 && qcMotion_Separates(a, b, NULL);
    // What lies opposite to the common corners.
    qcMovingTriangle oppositeA = PartOf(a, p[common], p[2]), oppositeB = PartOf(b, q[common], q[2]);
    if (!qcMotion_Separates(&oppositeA, b, NULL) || !qcMotion_Separates(&oppositeB, a, NULL))
        return false;
    for (int i = 0; i < 2 && common == 2; i++)
    {
        qcMovingTriangle edgeA = PartOf(a, p[i], p[2]), edgeB = PartOf(b, q[1 - i], q[2]);
        if (!qcMotion_Separates(&edgeA, &edgeB, NULL))
            return false;
    }
    return true;
}
