// The segment in which two penetrating triangles meet, rounded to double. Signs are exact, so that every end is a true
// corner of the intersection; its position along an edge comes from determinants that are right to 20 bits. Values are
// scaled before they are squared: no overflow.
#include "triangle/exact.h"

#include <math.h>
#include <string.h>

typedef struct Point
{
    double x[3];
} Point;

enum
{
    // An upper bound: three corners of each triangle and the crossings of nine pairs of edges.
    qc_maxPoints = 15
};

typedef struct Points
{
    int count;
    Point point[qc_maxPoints];
} Points;

static void Push(Points* points, const double* p)
{
    memcpy(points->point[points->count++].x, p, sizeof points->point[0].x);
}

/// p + s (q - p) for s in 0..1, from the nearer end: exact at the ends.
static Point Blend(const double* p, const double* q, double s)
{
    const double* from = s <= 0.5 ? p : q;
    const double* to = s <= 0.5 ? q : p;
    double t = s <= 0.5 ? s : 1.0 - s;
    Point point;
    for (int axis = 0; axis < 3; axis++)
        // Not from + t (to - from): the difference of two large coordinates may overflow.
        point.x[axis] = t == 0.0 ? from[axis] : from[axis] * (1.0 - t) + to[axis] * t;
    return point;
}

/// The parameter at which a segment crosses a plane, |p| / (|p| + |q|), from the heights of its ends, of opposite
/// signs.
static double Crossing(qcScaled p, qcScaled q)
{
    if (p.mantissa == 0.0)
        return 0.0;
    if (q.mantissa == 0.0)
        return 1.0;
    return 1.0 / (1.0 + ldexp(fabs(q.mantissa / p.mantissa), q.exponent - p.exponent));
}

/// det(b - a, c - a) in (u, v): the volume over it of height one.
static qcScaled Height2d(const double* a, const double* b, const double* c, int u, int v)
{
    const double p[4][3] = {{a[u], a[v], 0}, {b[u], b[v], 0}, {c[u], c[v], 0}, {a[u], a[v], 1}};
    return qcOrient3dValue(p[0], p[1], p[2], p[3]);
}

/// The difference of two coordinates, over 2^exponent.
static double Difference(const Point* a, const Point* b, int axis, int exponent)
{
    return ldexp(a->x[axis], -exponent) - ldexp(b->x[axis], -exponent);
}

/// Squared, over 2^(exponent + spread): basic operations alone, which break ties alike on every machine. hypot doesn't.
static double ScaledDistance2(const Point* a, const Point* b, int exponent, int spread)
{
    double sum = 0.0;
    for (int axis = 0; axis < 3; axis++)
    {
        double difference = ldexp(Difference(a, b, axis, exponent), -spread);
        sum += difference * difference;
    }
    return sum;
}

/// The two points farthest from each other.
static void Farthest(const Points* points, qcSegment* segment)
{
    double size = 0.0, largestDifference = 0.0;
    for (int i = 0; i < points->count; i++)
        for (int axis = 0; axis < 3; axis++)
            size = fmax(size, fabs(points->point[i].x[axis]));
    int exponent, spread;
    frexp(size, &exponent);
    for (int i = 0; i < points->count; i++)
        for (int axis = 0; axis < 3; axis++)
            largestDifference =
                fmax(largestDifference, fabs(Difference(&points->point[i], &points->point[0], axis, exponent)));
    // The square of the largest distance neither overflows nor underflows.
    frexp(largestDifference, &spread);
    int first = 0, second = 0;
    double largest = -1.0;
    for (int i = 0; i < points->count; i++)
        for (int j = i; j < points->count; j++)
        {
            double distance = ScaledDistance2(&points->point[i], &points->point[j], exponent, spread);
            if (distance > largest)
            {
                largest = distance;
                first = i;
                second = j;
            }
        }
    memcpy(segment->p, points->point[first].x, sizeof segment->p);
    memcpy(segment->q, points->point[second].x, sizeof segment->q);
}

//  ---- in a plane, on a line -----------------------------------------------------------------------------------

static int EdgeCount(const qcSimplex* s)
{
    return s->dimension == 2 ? 3 : s->dimension;
}

/// True if p lies in the closed triangle or segment, in (u, v), in which a triangle is not flat.
static bool Contains(const qcSimplex* s, const double* p, int u, int v)
{
    int signs[3] = {0, 0, 0};
    for (int e = 0; e < EdgeCount(s); e++)
        signs[e] = qcOrient2d(s->point[e], s->point[(e + 1) % 3], p, u, v, NULL);
    if (s->dimension == 2)
    {
        bool left = signs[0] > 0 || signs[1] > 0 || signs[2] > 0;
        bool right = signs[0] < 0 || signs[1] < 0 || signs[2] < 0;
        return !left || !right;
    }
    double low = fmin(s->point[0][s->u], s->point[1][s->u]), high = fmax(s->point[0][s->u], s->point[1][s->u]);
    return signs[0] == 0 && low <= p[s->u] && p[s->u] <= high;
}

static void PushEdgeCrossing(Points* points, const double* const a[2], const double* const b[2], int u, int v)
{
    int side[4];
    for (int i = 0; i < 2; i++)
    {
        side[i] = qcOrient2d(b[0], b[1], a[i], u, v, NULL);
        side[2 + i] = qcOrient2d(a[0], a[1], b[i], u, v, NULL);
    }
    if (side[0] * side[1] >= 0 || side[2] * side[3] >= 0)
        return;
    double s = Crossing(Height2d(b[0], b[1], a[0], u, v), Height2d(b[0], b[1], a[1], u, v));
    Point crossing = Blend(a[0], a[1], s);
    Push(points, crossing.x);
}

/// Two simplices in one plane or line, which the projection to (u, v) maps one to one. Candidates: corners of each that
/// lie in the other, and crossings of edges.
static void InPlane(const qcSimplex* a, const qcSimplex* b, int u, int v, qcSegment* segment)
{
    Points points = {.count = 0};
    for (int i = 0; i <= a->dimension; i++)
        if (Contains(b, a->point[i], u, v))
            Push(&points, a->point[i]);
    for (int i = 0; i <= b->dimension; i++)
        if (Contains(a, b->point[i], u, v))
            Push(&points, b->point[i]);
    for (int i = 0; i < EdgeCount(a); i++)
        for (int j = 0; j < EdgeCount(b); j++)
            PushEdgeCrossing(&points, (const double* const[]){a->point[i], a->point[(i + 1) % 3]},
                             (const double* const[]){b->point[j], b->point[(j + 1) % 3]}, u, v);
    Farthest(&points, segment);
}

static void SegmentTriangle(const qcSimplex* s, const qcSimplex* t, qcSegment* segment)
{
    qcScaled p = qcOrient3dValue(t->point[0], t->point[1], t->point[2], s->point[0]);
    qcScaled q = qcOrient3dValue(t->point[0], t->point[1], t->point[2], s->point[1]);
    if (p.mantissa == 0.0 && q.mantissa == 0.0)
    {
        InPlane(s, t, t->u, t->v, segment);
        return;
    }
    Point crossing = Blend(s->point[0], s->point[1], Crossing(p, q));
    memcpy(segment->p, crossing.x, sizeof segment->p);
    memcpy(segment->q, crossing.x, sizeof segment->q);
}

/// Two segments that cross in a point, or overlap on a line.
static void SegmentSegment(const qcSimplex* a, const qcSimplex* b, qcSegment* segment)
{
    for (int axis = 0; axis < 3; axis++)
    {
        int u = (axis + 1) % 3, v = (axis + 2) % 3;
        if (qcOrient2d(b->point[0], b->point[1], a->point[0], u, v, NULL) != 0)
        {
            InPlane(a, b, u, v, segment);
            return;
        }
    }
    InPlane(a, b, a->u, a->u, segment);
}

//  ---- general position --------------------------------------------------------------------------------------

/// The points in which the edges of a cross the plane of b: the ends of a's interval.
static void PushCrossings(Points* points, const double a[3][3], const double b[3][3])
{
    qcScaled height[3];
    for (int i = 0; i < 3; i++)
        height[i] = qcOrient3dValue(b[0], b[1], b[2], a[i]);
    for (int i = 0; i < 3; i++)
    {
        int j = (i + 1) % 3;
        if (height[i].mantissa == 0.0)
            Push(points, a[i]);
        else if (height[i].mantissa * height[j].mantissa < 0.0)
        {
            Point crossing = Blend(a[i], a[j], Crossing(height[i], height[j]));
            Push(points, crossing.x);
        }
    }
}

/// The middle two of the four ends on the common line, in the coordinate in which they lie farthest apart.
static void MiddleTwo(Points* ends, qcSegment* segment)
{
    int longest = 0;
    double largest = -1.0;
    for (int axis = 0; axis < 3; axis++)
    {
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < 4; i++)
        {
            low = fmin(low, ends->point[i].x[axis]);
            high = fmax(high, ends->point[i].x[axis]);
        }
        // Halves: the difference of two large coordinates may overflow.
        if (0.5 * high - 0.5 * low > largest)
        {
            largest = 0.5 * high - 0.5 * low;
            longest = axis;
        }
    }
    for (int i = 1; i < 4; i++)
        for (int j = i; j > 0 && ends->point[j].x[longest] < ends->point[j - 1].x[longest]; j--)
        {
            Point swap = ends->point[j];
            ends->point[j] = ends->point[j - 1];
            ends->point[j - 1] = swap;
        }
    memcpy(segment->p, ends->point[1].x, sizeof segment->p);
    memcpy(segment->q, ends->point[2].x, sizeof segment->q);
}

void qcExact_Segment(const double a[3][3], const double b[3][3], qcSegment* segment)
{
    qcSimplex first = qcSimplex_Of(a, NULL), second = qcSimplex_Of(b, NULL);
    const qcSimplex* small = first.dimension <= second.dimension ? &first : &second;
    const qcSimplex* large = first.dimension <= second.dimension ? &second : &first;
    if (small->dimension == 0)
    {
        memcpy(segment->p, small->point[0], sizeof segment->p);
        memcpy(segment->q, small->point[0], sizeof segment->q);
    }
    else if (small->dimension == 2)
    {
        Points ends = {.count = 0};
        PushCrossings(&ends, a, b);
        if (ends.count == 2)
        {
            PushCrossings(&ends, b, a);
            MiddleTwo(&ends, segment);
        }
        else
            InPlane(small, large, large->u, large->v, segment);
    }
    else if (large->dimension == 2)
        SegmentTriangle(small, large, segment);
    else
        SegmentSegment(large, small, segment);
}
