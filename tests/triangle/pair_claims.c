// The claims about a pair of triangles: see pair_claims.h.
#include "triangle/pair_claims.h"

#include "support/oracle.h"
#include "triangle/exact.h"
#include "triangle/proximity.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void qcTrianglePair_Fail(const qcTrianglePair* pair, const char* what, double got, double expected)
{
    char text[1024];
    fprintf(stderr, "%s: %.17g, expected %.17g, extent %g, for %s\n", what, got, expected,
            qcTrianglePair_GetExtent(pair), qcTrianglePair_Print(pair, text));
    abort();
}

double qcTrianglePair_GetExtent(const qcTrianglePair* pair)
{
    double extent = 0;
    for (int i = 0; i < 9; ++i)
    {
        extent = fmax(extent, fabs(pair->a[i / 3][i % 3] - pair->a[0][i % 3]));
        extent = fmax(extent, fabs(pair->b[i / 3][i % 3] - pair->a[0][i % 3]));
    }
    return extent;
}

//  ---- segment -----------------------------------------------------------------------------------------------------

// The position of an end along an edge is a ratio of two determinants that are right to 20 bits. An error of 2^-19 of
// the ratio moves the end by at most a quarter of that, times an edge of up to twice the largest coordinate.
static const double s_tolerance = 0x1p-20;
// The rounding of subnormal coordinates.
static const double s_smallestDouble = 0x1p-1074;

// In units of `largest`, in which nothing overflows or underflows.
static double GetLength(const double p[3], const double q[3], double largest)
{
    double difference[3];
    for (int axis = 0; axis < 3; ++axis)
        difference[axis] = p[axis] / largest - q[axis] / largest;
    return sqrt(difference[0] * difference[0] + difference[1] * difference[1] + difference[2] * difference[2]);
}

static double GetMaxLength(const qcOracleAnswer* exact, double largest)
{
    double length = 0;
    for (int i = 0; i < exact->pointCount; ++i)
        for (int j = 0; j < i; ++j)
            length = fmax(length, GetLength(exact->points[i], exact->points[j], largest));
    return length;
}

void qcClaim_Segment(const qcTrianglePair* pair, const qcOracleAnswer* exact)
{
    qcSegment s;
    qcExact_Segment(pair->a, pair->b, &s);
    const double largest = qcTrianglePair_GetLargest(pair);
    const double tolerance = s_tolerance * largest + 4 * s_smallestDouble;
    bool nearP = false, nearQ = false;
    for (int i = 0; i < exact->pointCount; ++i)
    {
        nearP = nearP || qcAreNear(s.p, exact->points[i], tolerance);
        nearQ = nearQ || qcAreNear(s.q, exact->points[i], tolerance);
    }
    QC_CLAIM(pair, nearP && nearQ, nearP ? "the second end is no corner" : "the first end is no corner", s.p[0],
             s.q[0]);
    if (largest == 0)
        return;
    double got = GetLength(s.p, s.q, largest), expected = GetMaxLength(exact, largest);
    QC_CLAIM(pair, fabs(got - expected) <= 4 * tolerance / largest, "the ends are not the farthest corners", got,
             expected);
}

//  ---- proximity ---------------------------------------------------------------------------------------------------

// Accuracy relative to the extent, as documented in scene.h.
static const double s_relative = 1e-12;

/// The error of rounding to world coordinates, of any algorithm.
static double GetWorldRounding(const qcTrianglePair* pair)
{
    return 4 * DBL_EPSILON * qcTrianglePair_GetLargest(pair) + 4 * 0x1p-1074;
}

static double GetDistanceTo(const double point[3], const double triangle[3][3])
{
    double corners[3][3];
    for (int i = 0; i < 3; ++i)
        memcpy(corners[i], point, sizeof corners[i]);
    qcOracleDistance* exact = qcOracleDistance_Create((const double(*)[3])corners, triangle);
    double distance = qcOracleDistance_Get(exact);
    qcOracleDistance_Destroy(exact);
    return distance;
}

/// The gap of A and B along the normal.
static double GetGap(const qcTrianglePair* pair, const double normal[3])
{
    long double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < 3; ++i)
    {
        long double a = 0, b = 0;
        for (int axis = 0; axis < 3; ++axis)
        {
            a += (long double)normal[axis] * ((long double)pair->a[i][axis] - pair->a[0][axis]);
            b += (long double)normal[axis] * ((long double)pair->b[i][axis] - pair->a[0][axis]);
        }
        low = fminl(low, a);
        high = fmaxl(high, b);
    }
    return (double)(low - high);
}

static void CheckPoints(const qcTrianglePair* pair, const qcProximity* p)
{
    double tolerance = s_relative * qcTrianglePair_GetExtent(pair) + GetWorldRounding(pair);
    double offA = GetDistanceTo(p->pointA, pair->a), offB = GetDistanceTo(p->pointB, pair->b);
    QC_CLAIM(pair, offA <= tolerance, "the point of A is off A", offA, 0.0);
    QC_CLAIM(pair, offB <= tolerance, "the point of B is off B", offB, 0.0);
}

static void CheckDisjoint(const qcTrianglePair* pair, const qcProximity* p)
{
    const double extent = qcTrianglePair_GetExtent(pair), rounding = 4 * 0x1p-1074;
    qcOracleDistance* exact = qcOracleDistance_Create(pair->a, pair->b);
    double distance = qcOracleDistance_Get(exact);
    qcOracleDistance_Destroy(exact);
    double off = fabs(p->distance - distance);
    QC_CLAIM(pair, off <= s_relative * extent + rounding, "distance", p->distance, distance);
    QC_CLAIM(pair, p->depth == 0, "depth", p->depth, 0.0);
    CheckPoints(pair, p);
    double between =
        sqrt(pow((p->pointA[0] - p->pointB[0]) / extent, 2) + pow((p->pointA[1] - p->pointB[1]) / extent, 2) +
             pow((p->pointA[2] - p->pointB[2]) / extent, 2));
    double tolerance = 2 * s_relative + 2 * GetWorldRounding(pair) / extent;
    QC_CLAIM(pair, fabs(between - distance / extent) <= tolerance, "distance of the points", between * extent,
             distance);
    // The points are right to about 1e-15 of the extent; the direction between them to that over their distance.
    double angle = distance > 0 ? 1e-15 * (extent / distance) : 1;
    double gap = GetGap(pair, p->normal);
    QC_CLAIM(pair, gap >= distance - (s_relative + angle) * extent - rounding, "gap along the normal", gap, distance);
}

static qcRelation RelateMoved(const qcTrianglePair* pair, const qcProximity* p, double length)
{
    double moved[3][3];
    for (int i = 0; i < 9; ++i)
        moved[i / 3][i % 3] = pair->a[i / 3][i % 3] + length * p->normal[i % 3];
    return qcRelateTriangles(&moved[0][0], &pair->b[0][0]);
}

static bool AreCoplanar(const qcTrianglePair* pair)
{
    const double(*a)[3] = pair->a;
    const double(*b)[3] = pair->b;
    bool coplanar = true;
    for (int i = 0; i < 3; ++i)
        coplanar = coplanar && qcOracle_Orient3d(a[0], a[1], a[2], b[i]) == 0 &&
                   qcOracle_Orient3d(b[0], b[1], b[2], a[i]) == 0;
    return coplanar;
}

static void CheckMeeting(const qcTrianglePair* pair, const qcProximity* p, qcRelation relation)
{
    const double extent = qcTrianglePair_GetExtent(pair);
    QC_CLAIM(pair, p->distance == 0, "distance", p->distance, 0.0);
    QC_CLAIM(pair, memcmp(p->pointA, p->pointB, sizeof p->pointA) == 0, "points differ", p->pointA[0], p->pointB[0]);
    CheckPoints(pair, p);
    double depth = relation == qc_relationPenetrating ? qcOracle_Depth(pair->a, pair->b) : 0;
    double tolerance = s_relative * extent + 4 * 0x1p-1074;
    QC_CLAIM(pair, fabs(p->depth - depth) <= tolerance, "depth", p->depth, depth);
    if (AreCoplanar(pair))
        QC_CLAIM(pair, p->depth == 0, "depth in one plane", p->depth, depth);
    // Moved by the depth they touch; the rounding of the moved corners is below the tolerance.
    tolerance += 2 * GetWorldRounding(pair);
    qcRelation beyond = RelateMoved(pair, p, p->depth + tolerance), within = RelateMoved(pair, p, p->depth - tolerance);
    QC_CLAIM(pair, beyond != qc_relationPenetrating, "moved beyond the depth", p->depth, depth);
    QC_CLAIM(pair, within != qc_relationDisjoint || p->depth <= tolerance, "moved by less than the depth", p->depth,
             depth);
}

/// The point lies on the feature that these corners span.
static void CheckFeature(const qcTrianglePair* pair, const double triangle[3][3], const double point[3],
                         unsigned corners)
{
    QC_CLAIM(pair, corners > 0 && corners < 8, "corners of a feature", (double)corners, 7.0);
    double feature[3][3];
    int first = corners & 1u ? 0 : corners & 2u ? 1 : 2;
    for (int c = 0; c < 3; c++)
        memcpy(feature[c], triangle[corners >> c & 1u ? c : first], sizeof feature[c]);
    // Corners of a weight below 1e-9 are not part of the feature.
    double away = GetDistanceTo(point, (const double(*)[3])feature);
    double tolerance = 4e-9 * qcTrianglePair_GetExtent(pair) + 2 * GetWorldRounding(pair);
    QC_CLAIM(pair, away <= tolerance, "distance from the feature", away, 0.0);
}

void qcClaim_Proximity(const qcTrianglePair* pair)
{
    qcRelation relation = qcExact_Relate(pair->a, pair->b, NULL);
    qcProximity p;
    qcClosestFeatures features;
    qcProximity_Of(pair->a, pair->b, relation, &p, &features);
    if (relation == qc_relationDisjoint)
    {
        CheckFeature(pair, pair->a, p.pointA, features.corners[0]);
        CheckFeature(pair, pair->b, p.pointB, features.corners[1]);
    }
    double length = sqrt(p.normal[0] * p.normal[0] + p.normal[1] * p.normal[1] + p.normal[2] * p.normal[2]);
    QC_CLAIM(pair, fabs(length - 1) <= 1e-15, "length of the normal", length, 1.0);
    if (relation == qc_relationDisjoint)
        CheckDisjoint(pair, &p);
    else
        CheckMeeting(pair, &p, relation);
}
