// The segment in which two triangles meet, rounded to double. Callers have decided exactly that they penetrate; here
// only places are computed, from determinants that are right to 20 bits more than their signs.
#include "exact.h"

#include <math.h>
#include <string.h>

typedef struct Point
{
    double x[3];
} Point;

enum
{
    // A triangle clipped by three lines gains at most one corner for each.
    qc_maxCorners = 6
};

typedef struct Polygon
{
    int count;
    Point corner[qc_maxCorners + 1];
} Polygon;

static Point At(const double* p)
{
    Point point;
    memcpy(point.x, p, sizeof point.x);
    return point;
}

/// p + s (q - p) for s in 0..1, from the nearer end, so that an end is met without rounding.
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

/// Where a segment whose ends have these heights over a plane, of opposite signs, crosses it: |p| / (|p| + |q|).
static double Crossing(qcScaled p, qcScaled q)
{
    if (p.mantissa == 0.0)
        return 0.0;
    if (q.mantissa == 0.0)
        return 1.0;
    return 1.0 / (1.0 + ldexp(fabs(q.mantissa / p.mantissa), q.exponent - p.exponent));
}

static double Distance(const Point* a, const Point* b)
{
    return hypot(hypot(a->x[0] - b->x[0], a->x[1] - b->x[1]), a->x[2] - b->x[2]);
}

/// The two points farthest from each other.
static void Farthest(const Polygon* polygon, qcSegment* segment)
{
    int first = 0, second = 0;
    double largest = -1.0;
    for (int i = 0; i < polygon->count; i++)
        for (int j = i; j < polygon->count; j++)
        {
            double distance = Distance(&polygon->corner[i], &polygon->corner[j]);
            if (distance > largest)
            {
                largest = distance;
                first = i;
                second = j;
            }
        }
    memcpy(segment->p, polygon->corner[first].x, sizeof segment->p);
    memcpy(segment->q, polygon->corner[second].x, sizeof segment->q);
}

/// The part of `polygon` on one side of the line a-b in (u, v): Sutherland and Hodgman's step.
static void Clip(Polygon* polygon, const double* a, const double* b, int u, int v, int sign)
{
    Polygon kept = {0};
    for (int i = 0; i < polygon->count; i++)
    {
        const Point* p = &polygon->corner[i];
        const Point* q = &polygon->corner[(i + 1) % polygon->count];
        double heightP = sign * ((b[u] - a[u]) * (p->x[v] - a[v]) - (b[v] - a[v]) * (p->x[u] - a[u]));
        double heightQ = sign * ((b[u] - a[u]) * (q->x[v] - a[v]) - (b[v] - a[v]) * (q->x[u] - a[u]));
        if (heightP >= 0.0 && kept.count < qc_maxCorners)
            kept.corner[kept.count++] = *p;
        if ((heightP > 0.0) != (heightQ > 0.0) && heightP != 0.0 && heightQ != 0.0 && kept.count < qc_maxCorners)
            kept.corner[kept.count++] = Blend(p->x, q->x, fabs(heightP) / (fabs(heightP) + fabs(heightQ)));
    }
    // Rounding may clip away what exact arithmetic has found to be there: then the last polygon stands for it.
    if (kept.count > 0)
        *polygon = kept;
}

static void InPlane(const qcSimplex* triangle, const qcSimplex* other, qcSegment* segment)
{
    Polygon polygon = {.count = other->dimension + 1};
    for (int i = 0; i <= other->dimension; i++)
        polygon.corner[i] = At(other->point[i]);
    for (int e = 0; e < 3; e++)
        Clip(&polygon, triangle->point[e], triangle->point[(e + 1) % 3], triangle->u, triangle->v, triangle->sign);
    Farthest(&polygon, segment);
}

static void SegmentTriangle(const qcSimplex* s, const qcSimplex* t, qcSegment* segment)
{
    qcScaled p = qcOrient3dValue(t->point[0], t->point[1], t->point[2], s->point[0]);
    qcScaled q = qcOrient3dValue(t->point[0], t->point[1], t->point[2], s->point[1]);
    if (p.mantissa == 0.0 && q.mantissa == 0.0)
    {
        InPlane(t, s, segment);
        return;
    }
    Point crossing = Blend(s->point[0], s->point[1], Crossing(p, q));
    memcpy(segment->p, crossing.x, sizeof segment->p);
    memcpy(segment->q, crossing.x, sizeof segment->q);
}

/// Two segments that cross in a point, or overlap on a line.
static void SegmentSegment(const qcSimplex* a, const qcSimplex* b, qcSegment* segment)
{
    // The plane in which they are seen largest.
    int u = 0, v = 0;
    double largest = 0.0, left = 0.0, right = 0.0;
    for (int axis = 0; axis < 3; axis++)
    {
        int i = (axis + 1) % 3, j = (axis + 2) % 3;
        const double *p = b->point[0], *q = b->point[1];
        double heights[2];
        for (int end = 0; end < 2; end++)
        {
            const double* x = a->point[end];
            heights[end] = (q[i] - p[i]) * (x[j] - p[j]) - (q[j] - p[j]) * (x[i] - p[i]);
        }
        if (fabs(heights[0] - heights[1]) > largest)
        {
            largest = fabs(heights[0] - heights[1]);
            left = fabs(heights[0]);
            right = fabs(heights[1]);
            u = i;
            v = j;
        }
    }
    if (u != v && qcOrient2d(a->point[0], a->point[1], b->point[0], u, v, NULL) *
                          qcOrient2d(a->point[0], a->point[1], b->point[1], u, v, NULL) < 0)
    {
        Point crossing = Blend(a->point[0], a->point[1], left / (left + right));
        memcpy(segment->p, crossing.x, sizeof segment->p);
        memcpy(segment->q, crossing.x, sizeof segment->q);
        return;
    }
    // On one line: the higher of the lower ends and the lower of the higher ends.
    int axis = a->u;
    const double* ends[2][2];
    const qcSimplex* sides[2] = {a, b};
    for (int i = 0; i < 2; i++)
    {
        bool rising = sides[i]->point[0][axis] <= sides[i]->point[1][axis];
        ends[i][0] = sides[i]->point[rising ? 0 : 1];
        ends[i][1] = sides[i]->point[rising ? 1 : 0];
    }
    memcpy(segment->p, ends[ends[0][0][axis] < ends[1][0][axis]][0], sizeof segment->p);
    memcpy(segment->q, ends[ends[0][1][axis] > ends[1][1][axis]][1], sizeof segment->q);
}

/// Where the edges of a cross the plane of b: the ends of a's interval.
static int Crossings(const double a[3][3], const double b[3][3], Point* points)
{
    qcScaled height[3];
    for (int i = 0; i < 3; i++)
        height[i] = qcOrient3dValue(b[0], b[1], b[2], a[i]);
    int count = 0;
    for (int i = 0; i < 3; i++)
    {
        int j = (i + 1) % 3;
        if (height[i].mantissa == 0.0)
            points[count++] = At(a[i]);
        else if (height[i].mantissa * height[j].mantissa < 0.0)
            points[count++] = Blend(a[i], a[j], Crossing(height[i], height[j]));
    }
    return count;
}

/// The middle two of the four ends on the common line.
static bool OnLine(const double a[3][3], const double b[3][3], qcSegment* segment)
{
    Point ends[6];
    int countA = Crossings(a, b, ends);
    int count = countA == 2 ? countA + Crossings(b, a, ends + 2) : 0;
    if (count != 4)
        return false;
    int longer = Distance(&ends[0], &ends[1]) >= Distance(&ends[2], &ends[3]) ? 0 : 2;
    double direction[3], place[4];
    for (int axis = 0; axis < 3; axis++)
        direction[axis] = ends[longer + 1].x[axis] - ends[longer].x[axis];
    int order[4] = {0, 1, 2, 3};
    for (int i = 0; i < 4; i++)
    {
        place[i] = 0.0;
        for (int axis = 0; axis < 3; axis++)
            place[i] += (ends[i].x[axis] - ends[longer].x[axis]) * direction[axis];
    }
    for (int i = 1; i < 4; i++)
        for (int j = i; j > 0 && place[order[j]] < place[order[j - 1]]; j--)
        {
            int swap = order[j];
            order[j] = order[j - 1];
            order[j - 1] = swap;
        }
    memcpy(segment->p, ends[order[1]].x, sizeof segment->p);
    memcpy(segment->q, ends[order[2]].x, sizeof segment->q);
    return true;
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
        if (!OnLine(a, b, segment))
            InPlane(large, small, segment);
    }
    else if (large->dimension == 2)
        SegmentTriangle(small, large, segment);
    else
        SegmentSegment(large, small, segment);
}
