// Closest points by features: nine pairs of edges, then the vertices over the other's face, as in PQP's TriDist
// (Larsen, Gottschalk, Lin, Manocha: Fast Proximity Queries with Swept Sphere Volumes, 1999). Parameters are clamped,
// so that every answer is a pair of points of the two triangles. Accuracy: plugin/docs/proofs/closest_points.md.
#include "triangle/closest_points.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

static double Clamp01(double x)
{
    return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x;
}

double qcClosest_OnSegment(qcVector p, qcVector q, qcVector x)
{
    qcVector d = qcMinus(q, p);
    double length2 = qcDot(d, d);
    return length2 > 0.0 ? Clamp01(qcDot(qcMinus(x, p), d) / length2) : 0.0;
}

/// The foot b u + c v of w in the plane of u and v, and w's difference to it. False: the foot is outside of the
/// triangle, or the triangle is degenerate.
static bool FindFoot(qcVector w, qcVector u, qcVector v, qcVector n, double* b, double* c, qcVector* difference)
{
    double n2 = qcDot(n, n);
    *b = *c = 0.0;
    *difference = w;
    // Iterative refinement: on a sliver of angle w each step reduces the error by a factor of 2^-53 / w.
    for (int step = 0; step < 3; step++)
    {
        qcVector d = *difference;
        *b += qcDot(qcCross(d, v), n) / n2;
        *c += qcDot(qcCross(u, d), n) / n2;
        // The foot is well outside. Only on a sliver is the error of the first foot larger, and a sliver's border is as
        // near.
        if (!(*b >= -0x1p-10 && *c >= -0x1p-10 && *b + *c <= 1.0 + 0x1p-10))
            return false;
        *difference = qcPlusScaled(qcPlusScaled(w, u, -*b), v, -*c);
    }
    return *b >= 0.0 && *c >= 0.0 && *b + *c <= 1.0;
}

void qcClosest_OnTriangle(const qcVector corner[3], qcVector x, double weights[3])
{
    double best = INFINITY;
    weights[0] = 1.0;
    weights[1] = weights[2] = 0.0;
    for (int e = 0; e < 3; e++)
    {
        int f = (e + 1) % 3;
        double t = qcClosest_OnSegment(corner[e], corner[f], x);
        qcVector d = qcMinus(x, qcPlusScaled(corner[e], qcMinus(corner[f], corner[e]), t));
        if (qcDot(d, d) < best)
        {
            best = qcDot(d, d);
            weights[0] = weights[1] = weights[2] = 0.0;
            weights[e] = 1.0 - t;
            weights[f] = t;
        }
    }
    qcVector u = qcMinus(corner[1], corner[0]), v = qcMinus(corner[2], corner[0]), w = qcMinus(x, corner[0]);
    qcVector difference;
    double b, c;
    // The foot must be nearer than the border: on a sliver the normal may consist of rounding errors.
    if (!FindFoot(w, u, v, qcCross(u, v), &b, &c, &difference) || qcDot(difference, difference) >= best)
        return;
    weights[0] = qcMax(1.0 - b - c, 0.0);
    weights[1] = b;
    weights[2] = c;
}

void qcClosest_OfSegments(qcVector p, qcVector q, qcVector r, qcVector s, double* t, double* u)
{
    qcVector d = qcMinus(q, p), e = qcMinus(s, r), w = qcMinus(r, p);
    qcVector n = qcCross(d, e);
    double n2 = qcDot(n, n), d2 = qcDot(d, d), e2 = qcDot(e, e);
    if (!(e2 > 0.0))
    {
        *u = 0.0;
        *t = qcClosest_OnSegment(p, q, r);
        return;
    }
    double dw = qcDot(d, w), de = qcDot(d, e), ew = qcDot(e, w);
    // Parallel within 1e-14 radians: any parameter gives the distance.
    *t = n2 > 1e-28 * d2 * e2 ? Clamp01(qcDot(qcCross(w, e), n) / n2) : 0.0;
    // Computed from t, not independently: for nearly parallel edges an error of t moves both points alike.
    *u = (*t * de - ew) / e2;
    if (*u >= 0.0 && *u <= 1.0)
        return;
    *u = Clamp01(*u);
    *t = d2 > 0.0 ? Clamp01((*u * de + dw) / d2) : 0.0;
}

qcVector qcClosest_FromTriangle(const qcVector corner[3], qcVector x)
{
    double weights[3];
    qcClosest_OnTriangle(corner, x, weights);
    qcVector d = qcPlusScaled(qcMinus(x, corner[0]), qcMinus(corner[1], corner[0]), -weights[1]);
    return qcPlusScaled(d, qcMinus(corner[2], corner[0]), -weights[2]);
}

qcVector qcClosest_FromSegment(qcVector p, qcVector q, qcVector r, qcVector s)
{
    double t, u;
    qcClosest_OfSegments(p, q, r, s, &t, &u);
    return qcPlusScaled(qcPlusScaled(qcMinus(p, r), qcMinus(q, p), t), qcMinus(s, r), -u);
}

//  ---- triangles -----------------------------------------------------------------------------------------------

/// Differences to the origin, times a power of two. Returns the largest coordinate.
static double Subtract(const double corners[3][3], const double origin[3], double factor, qcVector local[3])
{
    double size = 0.0;
    for (int i = 0; i < 3; i++)
    {
        const double* p = corners[i];
        local[i] = (qcVector){p[0] * factor - origin[0] * factor, p[1] * factor - origin[1] * factor,
                              p[2] * factor - origin[2] * factor};
        double x = fabs(local[i].x), y = fabs(local[i].y), z = fabs(local[i].z);
        double larger = x > y ? x : y;
        larger = z > larger ? z : larger;
        size = larger > size ? larger : size;
    }
    return size;
}

/// floor(log2(size)).
static int ExponentOf(double size)
{
    if (size < DBL_MIN)
        return ilogb(size);
    uint64_t bits;
    memcpy(&bits, &size, sizeof bits);
    return (int)(bits >> 52) - 1023;
}

static void Scale(qcVector local[3], double factor)
{
    for (int i = 0; i < 3; i++)
        local[i] = (qcVector){local[i].x * factor, local[i].y * factor, local[i].z * factor};
}

void qcPairFrame_Set(qcPairFrame* frame, const double a[3][3], const double b[3][3])
{
    frame->origin = a[0];
    frame->exponent = 0;
    double sizeA = Subtract(a, a[0], 1.0, frame->a), sizeB = Subtract(b, a[0], 1.0, frame->b);
    if (!(sizeA <= DBL_MAX && sizeB <= DBL_MAX))
    {
        // The difference overflows. The error of a quarter of a denormal is negligible beside it.
        sizeA = Subtract(a, a[0], 0.25, frame->a);
        sizeB = Subtract(b, a[0], 0.25, frame->b);
        frame->exponent = 2;
    }
    double size = sizeA > sizeB ? sizeA : sizeB;
    int exponent = size > 0.0 ? ExponentOf(size) : 0;
    // In two steps, since 2^1074 is not a double. The second is 1 except for extreme sizes.
    int first = exponent < -1000 ? -1000 : exponent > 1000 ? 1000 : exponent;
    double factor = qcPowerOfTwo(-first), rest = qcPowerOfTwo(first - exponent);
    Scale(frame->a, factor);
    Scale(frame->b, factor);
    if (first != exponent)
    {
        Scale(frame->a, rest);
        Scale(frame->b, rest);
    }
    frame->factors[0] = factor;
    frame->factors[1] = rest * qcPowerOfTwo(-frame->exponent);
    frame->exponent += exponent;
}

// Tolerance of a distance, in the frame. The direction between points at distance D is off by 2^-50 / D, which changes
// distances by that times the extent; smaller differences are ignored.
static const double s_loss = 0x1p-43;

/// The best pair of points so far, and all corners along its difference.
typedef struct Search
{
    const qcVector *a, *b;
    double distance2;
    double alongA[3], alongB[3];
    qcClosestPoints* closest;
} Search;

/// Takes the difference if it is the shortest so far; the caller then sets the weights.
static bool TakeIfBest(Search* s, qcVector difference)
{
    double distance2 = qcDot(difference, difference);
    if (distance2 >= s->distance2)
        return false;
    s->distance2 = distance2;
    *s->closest = (qcClosestPoints){{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, difference};
    for (int i = 0; i < 3; i++)
    {
        s->alongA[i] = qcDot(s->a[i], difference);
        s->alongB[i] = qcDot(s->b[i], difference);
    }
    return true;
}

/// True if points of A and B with this gap along the best difference are not closer than the best by more than s_loss.
static bool IsNoCloser(const Search* s, double gap)
{
    double lost = s->distance2 - gap;
    return lost <= 0.0 || lost * lost <= s_loss * s_loss * s->distance2;
}

/// True if no points of the two are closer than the best.
static bool AreNoneCloser(const Search* s)
{
    double nearestA = qcMin(qcMin(s->alongA[0], s->alongA[1]), s->alongA[2]);
    double nearestB = qcMax(qcMax(s->alongB[0], s->alongB[1]), s->alongB[2]);
    return IsNoCloser(s, nearestA - nearestB);
}

/// Tries the closest points of edge i of A and edge j of B. True: no other points are closer.
static bool TryEdges(Search* s, int i, int j)
{
    const qcVector *a = s->a, *b = s->b;
    int nextA = i < 2 ? i + 1 : 0, nextB = j < 2 ? j + 1 : 0;
    double nearestA = qcMin(s->alongA[i], s->alongA[nextA]), nearestB = qcMax(s->alongB[j], s->alongB[nextB]);
    if (IsNoCloser(s, nearestA - nearestB))
        return false;
    double t, u;
    qcClosest_OfSegments(a[i], a[nextA], b[j], b[nextB], &t, &u);
    if (!TakeIfBest(s, qcPlusScaled(qcPlusScaled(qcMinus(a[i], b[j]), qcMinus(a[nextA], a[i]), t),
                                    qcMinus(b[nextB], b[j]), -u)))
        return false;
    s->closest->weightsA[i] = 1.0 - t;
    s->closest->weightsA[nextA] = t;
    s->closest->weightsB[j] = 1.0 - u;
    s->closest->weightsB[nextB] = u;
    return AreNoneCloser(s);
}

/// Tries the corners of one triangle over the face of the other; `sign` is -1 if the face is A's.
static void TryFace(Search* s, const qcVector points[3], const qcVector face[3], double sign)
{
    qcVector u = qcMinus(face[1], face[0]), v = qcMinus(face[2], face[0]), n = qcCross(u, v);
    double n2 = qcDot(n, n);
    for (int i = 0; i < 3; i++)
    {
        qcVector w = qcMinus(points[i], face[0]);
        double height = qcDot(w, n);
        // Too high by more than the error of the height, 2^-45, since (x + y)^2 <= 2 (x^2 + y^2).
        if (height * height > 2.0 * (s->distance2 * n2 + 0x1p-90))
            continue;
        qcVector d;
        double b, c;
        if (!FindFoot(w, u, v, n, &b, &c, &d) || !TakeIfBest(s, (qcVector){sign * d.x, sign * d.y, sign * d.z}))
            continue;
        double* vertexWeights = sign > 0.0 ? s->closest->weightsA : s->closest->weightsB;
        double* faceWeights = sign > 0.0 ? s->closest->weightsB : s->closest->weightsA;
        vertexWeights[i] = 1.0;
        faceWeights[0] = qcMax(1.0 - b - c, 0.0);
        faceWeights[1] = b;
        faceWeights[2] = c;
    }
}

void qcClosest_OfTriangles(const qcVector a[3], const qcVector b[3], qcClosestPoints* closest)
{
    Search search = {.a = a, .b = b, .distance2 = INFINITY, .closest = closest};
    int nearA = 0, nearB = 0;
    double minDistance2 = INFINITY;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
        {
            qcVector d = qcMinus(a[i], b[j]);
            double distance2 = qcDot(d, d);
            if (distance2 < minDistance2)
            {
                minDistance2 = distance2;
                nearA = i;
                nearB = j;
            }
        }
    TakeIfBest(&search, qcMinus(a[nearA], b[nearB]));
    closest->weightsA[nearA] = closest->weightsB[nearB] = 1.0;
    if (AreNoneCloser(&search))
        return;
    // First the edges of the two nearest corners: usually one of them is the closest.
    static const int s_edgesByCorner[3][3] = {{0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (TryEdges(&search, s_edgesByCorner[nearA][i], s_edgesByCorner[nearB][j]))
                return;
    TryFace(&search, a, b, 1.0);
    TryFace(&search, b, a, -1.0);
}
