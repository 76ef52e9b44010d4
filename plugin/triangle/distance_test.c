// Whether two triangles are within a margin of each other, decided exactly: a filter with certificates in double
// precision, then all 42 pairs of features in integers. Proof: plugin/docs/proofs/distance_test.md.
#include "triangle/exact.h"

#include "triangle/closest_points.h"
#include "triangle/big_integer.h"

#include <math.h>
#include <string.h>

static const double s_slack = 0x1p-44;

//  ---- certificates ----------------------------------------------------------------------------------------

/// A lower bound for the distance of the hulls of two sets of points: gap / sqrt(length2).
typedef struct Gap
{
    double gap, length2;
} Gap;

static Gap GapAlong(qcVector v, const qcVector* a, int countA, const qcVector* b, int countB)
{
    double lowA = INFINITY, highA = -INFINITY, lowB = INFINITY, highB = -INFINITY;
    for (int i = 0; i < countA; i++)
    {
        double x = qcDot(a[i], v);
        lowA = x < lowA ? x : lowA;
        highA = x > highA ? x : highA;
    }
    for (int i = 0; i < countB; i++)
    {
        double x = qcDot(b[i], v);
        lowB = x < lowB ? x : lowB;
        highB = x > highB ? x : highB;
    }
    double above = lowA - highB, below = lowB - highA;
    return (Gap){above > below ? above : below, qcDot(v, v)};
}

/// True if the bound proves that the distance is larger.
static bool IsFartherThan(Gap g, double distance)
{
    double bound = distance + s_slack;
    return g.gap > 0.0 && g.length2 >= 0x1p-200 && g.gap * g.gap > bound * bound * g.length2;
}

/// True if the sets overlap along the direction by more than rounding.
static bool IsOverlap(Gap g)
{
    return g.gap < 0.0 && g.length2 >= 0x1p-200 && g.gap * g.gap > s_slack * s_slack * g.length2;
}

/// True if two points with this difference are proven to be within the distance.
static bool IsNoFartherThan(double distance, qcVector difference)
{
    double bound = distance - s_slack;
    return bound >= 0.0 && qcDot(difference, difference) <= bound * bound;
}

//  ---- features in integers ----------------------------------------------------------------------------------

typedef qcInteger Point[3];

static void Subtract(const Point p, const Point q, Point difference)
{
    for (int axis = 0; axis < 3; axis++)
        qcInteger_Subtract(&p[axis], &q[axis], &difference[axis]);
}

static void Cross(const Point p, const Point q, Point out)
{
    qcInteger other;
    for (int axis = 0; axis < 3; axis++)
    {
        int u = (axis + 1) % 3, v = (axis + 2) % 3;
        qcInteger_Multiply(&p[u], &q[v], &out[axis]);
        qcInteger_Multiply(&p[v], &q[u], &other);
        qcInteger_Subtract(&out[axis], &other, &out[axis]);
    }
}

static void Dot(const Point p, const Point q, qcInteger* out)
{
    qcInteger term;
    qcInteger_Multiply(&p[0], &q[0], out);
    for (int axis = 1; axis < 3; axis++)
    {
        qcInteger_Multiply(&p[axis], &q[axis], &term);
        qcInteger_Add(out, &term, out);
    }
}

static bool IsAtMost(const qcInteger* x, const qcInteger* y)
{
    qcInteger difference;
    qcInteger_Subtract(x, y, &difference);
    return qcInteger_Sign(&difference) <= 0;
}

/// value^2 <= margin^2 * length^2
static bool IsSquareWithin(const qcInteger* value, const qcInteger* margin2, const qcInteger* length2)
{
    qcInteger left, right;
    qcInteger_Multiply(value, value, &left);
    qcInteger_Multiply(margin2, length2, &right);
    return IsAtMost(&left, &right);
}

static bool IsWithin0And(const qcInteger* x, const qcInteger* max)
{
    return qcInteger_Sign(x) >= 0 && IsAtMost(x, max);
}

static bool VertexVertex(const Point p, const Point q, const qcInteger* margin2)
{
    Point w;
    qcInteger distance2;
    Subtract(p, q, w);
    Dot(w, w, &distance2);
    return IsAtMost(&distance2, margin2);
}

static bool VertexEdge(const Point p, const Point start, const Point end, const qcInteger* margin2)
{
    Point w, e, n;
    qcInteger along, length2, left, right;
    Subtract(p, start, w);
    Subtract(end, start, e);
    Dot(e, e, &length2);
    Dot(w, e, &along);
    if (qcInteger_Sign(&length2) == 0 || !IsWithin0And(&along, &length2))
        return false;
    Cross(w, e, n);
    Dot(n, n, &left);
    qcInteger_Multiply(margin2, &length2, &right);
    return IsAtMost(&left, &right);
}

static bool EdgeEdge(const Point p, const Point q, const Point r, const Point s, const qcInteger* margin2)
{
    Point d, e, w, n, turned;
    qcInteger length2, height, along;
    Subtract(q, p, d);
    Subtract(s, r, e);
    Subtract(r, p, w);
    Cross(d, e, n);
    Dot(n, n, &length2);
    if (qcInteger_Sign(&length2) == 0)
        return false;
    Cross(w, e, turned);
    Dot(turned, n, &along);
    if (!IsWithin0And(&along, &length2))
        return false;
    Cross(w, d, turned);
    Dot(turned, n, &along);
    if (!IsWithin0And(&along, &length2))
        return false;
    Dot(n, w, &height);
    return IsSquareWithin(&height, margin2, &length2);
}

static bool VertexFace(const Point p, const Point face[3], const qcInteger* margin2)
{
    Point u, v, w, n, turned;
    qcInteger length2, height, left, right;
    Subtract(face[1], face[0], u);
    Subtract(face[2], face[0], v);
    Subtract(p, face[0], w);
    Cross(u, v, n);
    Dot(n, n, &length2);
    if (qcInteger_Sign(&length2) == 0)
        return false;
    Cross(w, v, turned);
    Dot(turned, n, &left);
    Cross(u, w, turned);
    Dot(turned, n, &right);
    if (qcInteger_Sign(&left) < 0 || qcInteger_Sign(&right) < 0)
        return false;
    qcInteger_Add(&left, &right, &left);
    if (!IsAtMost(&left, &length2))
        return false;
    Dot(n, w, &height);
    return IsSquareWithin(&height, margin2, &length2);
}

//  ---- all pairs of features -------------------------------------------------------------------------------

typedef struct Pair
{
    const qcPairFrame* frame;
    double margin; ///< in the frame
    Point corner[2][3];
    qcInteger margin2;
} Pair;

static void SetIntegers(Pair* pair, const double a[3][3], const double b[3][3], double margin)
{
    double values[19];
    memcpy(values, a, 9 * sizeof(double));
    memcpy(values + 9, b, 9 * sizeof(double));
    values[18] = margin;
    int common = qcInteger_CommonExponent(values, 19);
    for (int i = 0; i < 18; i++)
        qcInteger_Set(&pair->corner[i / 9][i % 9 / 3][i % 3], values[i], common);
    qcInteger root;
    qcInteger_Set(&root, margin, common);
    qcInteger_Multiply(&root, &root, &pair->margin2);
}

/// Tests the vertices of triangle `one` with the faces, edges and vertices of the other; vertex pairs once.
static bool IsAnyVertexWithin(const Pair* pair, int one)
{
    const qcVector* points = one == 0 ? pair->frame->a : pair->frame->b;
    const qcVector* others = one == 0 ? pair->frame->b : pair->frame->a;
    const Point *corner = pair->corner[one], *other = pair->corner[1 - one];
    for (int i = 0; i < 3; i++)
    {
        qcVector x = points[i];
        qcVector d = qcClosest_FromTriangle(others, x);
        if (IsFartherThan(GapAlong(d, &x, 1, others, 3), pair->margin))
            continue; // farther than the margin from the whole triangle
        if (VertexFace(corner[i], other, &pair->margin2))
            return true;
        for (int j = 0; j < 3; j++)
            if (VertexEdge(corner[i], other[j], other[(j + 1) % 3], &pair->margin2) ||
                (one == 0 && VertexVertex(corner[i], other[j], &pair->margin2)))
                return true;
    }
    return false;
}

static bool AreAnyEdgesWithin(const Pair* pair)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
        {
            int nextA = (i + 1) % 3, nextB = (j + 1) % 3;
            const qcVector p[2] = {pair->frame->a[i], pair->frame->a[nextA]};
            const qcVector q[2] = {pair->frame->b[j], pair->frame->b[nextB]};
            qcVector d = qcClosest_FromSegment(p[0], p[1], q[0], q[1]);
            if (!IsFartherThan(GapAlong(d, p, 2, q, 2), pair->margin) &&
                EdgeEdge(pair->corner[0][i], pair->corner[0][nextA], pair->corner[1][j], pair->corner[1][nextB],
                         &pair->margin2))
                return true;
        }
    return false;
}

static bool IsAnyWithin(const Pair* pair)
{
    return IsAnyVertexWithin(pair, 0) || IsAnyVertexWithin(pair, 1) || AreAnyEdgesWithin(pair);
}

//  ---- the filter ----------------------------------------------------------------------------------------

/// Three times the vector from the centroid of B to that of A.
static qcVector BetweenCentroids(const qcPairFrame* f)
{
    qcVector a = qcPlusScaled(qcPlusScaled(f->a[0], f->a[1], 1.0), f->a[2], 1.0);
    qcVector b = qcPlusScaled(qcPlusScaled(f->b[0], f->b[1], 1.0), f->b[2], 1.0);
    return qcMinus(a, b);
}

static qcVector Normal(const qcVector corner[3])
{
    return qcCross(qcMinus(corner[1], corner[0]), qcMinus(corner[2], corner[0]));
}

/// True if some corner of A is proven to be within the margin of some corner of B.
static bool AreCornersWithin(const qcPairFrame* f, double margin)
{
    bool within = false;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            within = within || IsNoFartherThan(margin, qcMinus(f->a[i], f->b[j]));
    return within;
}

qcRelation qcExact_Within(const double a[3][3], const double b[3][3], double margin, uint64_t* undecided)
{
    if (!(margin > 0.0))
        return qcExact_Relate(a, b, undecided);
    qcPairFrame frame;
    qcPairFrame_Set(&frame, a, b);
    double local = qcPairFrame_Length(&frame, margin);
    // Face normals first: they separate triangles that lie flat on each other.
    const qcVector directions[3] = {Normal(frame.a), Normal(frame.b), BetweenCentroids(&frame)};
    bool disjoint = false, within = AreCornersWithin(&frame, local), across = true;
    for (int i = 0; i < 3; i++)
    {
        Gap gap = GapAlong(directions[i], frame.a, 3, frame.b, 3);
        disjoint = disjoint || IsFartherThan(gap, 0.0);
        if (disjoint && within)
            return qc_relationNear;
        if (disjoint && IsFartherThan(gap, local))
            return qc_relationDisjoint;
        across = across && IsOverlap(gap);
    }
    // Each triangle straddles the other's plane: the intersection test rarely needs exact arithmetic and gives the
    // result.
    if (within && across)
    {
        qcRelation relation = qcExact_Relate(a, b, undecided);
        return relation != qc_relationDisjoint ? relation : qc_relationNear;
    }
    qcClosestPoints closest;
    qcClosest_OfTriangles(frame.a, frame.b, &closest);
    Gap gap = GapAlong(closest.difference, frame.a, 3, frame.b, 3);
    if (IsFartherThan(gap, local))
        return qc_relationDisjoint;
    if (!disjoint && !IsFartherThan(gap, 0.0))
    {
        qcRelation relation = qcExact_Relate(a, b, undecided);
        if (relation != qc_relationDisjoint)
            return relation;
    }
    if (IsNoFartherThan(local, closest.difference))
        return qc_relationNear;
    if (undecided != NULL)
        ++*undecided;
    Pair pair = {.frame = &frame, .margin = local};
    SetIntegers(&pair, a, b, margin);
    return IsAnyWithin(&pair) ? qc_relationNear : qc_relationDisjoint;
}
