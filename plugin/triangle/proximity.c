// Distance, depth, normal and closest points of two triangles: closest points by features (triangle/closest_points.c),
// directions by the separating axis theorem (Gottschalk, Lin, Manocha: OBBTree, 1996). Exchanging A and B gives the
// mirror image to the last bit. Accuracy: plugin/docs/proofs/closest_points.md.
#include "triangle/proximity.h"

#include "triangle/closest_points.h"
#include "triangle/exact.h"
#include "base/float_mode.h"

#include <math.h>
#include <string.h>

// In the frame of the pair, where the extent is about 1. An axis must win by more than this, so that of equal axes the
// first wins: a face before edges.
static const double s_rounding = 0x1p-44;
// If the gap along a direction is smaller than the distance by more than this, more axes are tried.
static const double s_loss = 0x1p-42;

static double Length(qcVector v)
{
    return sqrt(qcDot(v, v));
}

typedef struct Axis
{
    qcVector direction; ///< unit
    double gap;
} Axis;

/// The lowest and the highest corner along a direction.
static void FindRange(const qcVector corner[3], qcVector n, double range[2])
{
    double x = qcDot(corner[0], n), y = qcDot(corner[1], n), z = qcDot(corner[2], n);
    double low = x < y ? x : y, high = x < y ? y : x;
    range[0] = z < low ? z : low;
    range[1] = z > high ? z : high;
}

/// Tries a direction of any length, both ways.
static void TryAxis(const qcPairFrame* frame, qcVector v, Axis* best)
{
    double length = Length(v);
    if (length < 0x1p-500)
        return;
    double scale = 1.0 / length, a[2], b[2];
    qcVector n = {v.x * scale, v.y * scale, v.z * scale};
    FindRange(frame->a, n, a);
    FindRange(frame->b, n, b);
    if (a[0] - b[1] > best->gap + s_rounding)
        *best = (Axis){n, a[0] - b[1]};
    if (b[0] - a[1] > best->gap + s_rounding)
        *best = (Axis){{-n.x, -n.y, -n.z}, b[0] - a[1]};
}

/// The part of n perpendicular to a vector.
static qcVector Reject(qcVector n, qcVector along)
{
    return qcPlusScaled(n, along, -qcDot(n, along) / qcDot(along, along));
}

/// Tries the cross product of two edges, unless they are parallel or zero within rounding.
static void TryCross(const qcPairFrame* frame, qcVector d, qcVector e, Axis* best)
{
    qcVector n = qcCross(d, e);
    double d2 = qcDot(d, d), e2 = qcDot(e, e);
    if (!(d2 > 0x1p-200 && e2 > 0x1p-200 && qcDot(n, n) > s_rounding * s_rounding * d2 * e2))
        return;
    // For nearly parallel edges the cross product is not accurately perpendicular, and slivers are long.
    n = d2 < e2 ? Reject(Reject(n, d), e) : Reject(Reject(n, e), d);
    TryAxis(frame, n, best);
}

static void TryFace(const qcPairFrame* frame, const qcVector corner[3], Axis* best)
{
    TryCross(frame, qcMinus(corner[1], corner[0]), qcMinus(corner[2], corner[1]), best);
}

static void TryFaces(const qcPairFrame* frame, Axis* best)
{
    TryFace(frame, frame->a, best);
    TryFace(frame, frame->b, best);
}

static void TryEdges(const qcPairFrame* frame, Axis* best)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            TryCross(frame, qcMinus(frame->a[(i + 1) % 3], frame->a[i]), qcMinus(frame->b[(j + 1) % 3], frame->b[j]),
                     best);
}

/// For disjoint triangles: tries the directions between closest points of all pairs of features, of which several may
/// be closest within rounding.
static void TryFeatures(const qcPairFrame* frame, Axis* best)
{
    for (int i = 0; i < 3; i++)
    {
        TryAxis(frame, qcClosest_FromTriangle(frame->b, frame->a[i]), best);
        TryAxis(frame, qcClosest_FromTriangle(frame->a, frame->b[i]), best);
        for (int j = 0; j < 3; j++)
            TryAxis(frame,
                    qcClosest_FromSegment(frame->a[i], frame->a[(i + 1) % 3], frame->b[j], frame->b[(j + 1) % 3]),
                    best);
    }
}

/// For triangles on one line, which meet there: tries a direction perpendicular to it.
static void TryAcrossLine(const qcPairFrame* frame, Axis* best)
{
    qcVector along = {0.0, 0.0, 0.0};
    for (int i = 0; i < 6; i++)
    {
        qcVector d = i < 3 ? frame->a[i] : frame->b[i - 3]; // from the origin
        along = qcDot(d, d) > qcDot(along, along) ? d : along;
    }
    double x = fabs(along.x), y = fabs(along.y), z = fabs(along.z);
    qcVector shortest = {x <= y && x <= z, 0.0, 0.0};
    if (shortest.x == 0.0)
        shortest = (qcVector){0.0, y <= z, y > z};
    qcVector across = qcCross(along, shortest);
    TryAxis(frame, qcDot(across, across) > 0.0 ? across : shortest, best);
}

static Axis FindAxis(const qcPairFrame* frame, const qcClosestPoints* closest, double distance)
{
    Axis best = {{0.0, 0.0, 0.0}, -INFINITY};
    bool disjoint = distance > s_rounding;
    if (disjoint)
        TryAxis(frame, closest->difference, &best);
    // Faces first: close triangles usually lie flat on each other, which two axes decide.
    if (!disjoint || best.gap < distance - s_loss)
        TryFaces(frame, &best);
    if (disjoint && best.gap < distance - s_loss)
        TryFeatures(frame, &best);
    if (!disjoint || best.gap < distance - s_loss)
        TryEdges(frame, &best);
    if (best.gap == -INFINITY)
        TryAcrossLine(frame, &best);
    return best;
}

/// True if all six corners lie in one plane.
static bool AreCoplanar(const double a[3][3], const double b[3][3])
{
    for (int i = 0; i < 3; i++)
        if (qcOrient3d(a[0], a[1], a[2], b[i], NULL) != 0 || qcOrient3d(b[0], b[1], b[2], a[i], NULL) != 0)
            return false;
    return true;
}

/// ldexp without a library call in the usual range.
static double TimesPowerOfTwo(double x, int exponent)
{
    return exponent < -1022 || exponent > 1023 ? ldexp(x, exponent) : x * qcPowerOfTwo(exponent);
}

/// The weighted mean of the corners in world space, computed from the heaviest corner: exact at the corners.
static void SetPoint(const double corners[3][3], const qcVector local[3], const double weights[3], int exponent,
                     double point[3])
{
    int h = weights[1] > weights[0] ? 1 : 0;
    h = weights[2] > weights[h] ? 2 : h;
    int i = (h + 1) % 3, j = (h + 2) % 3;
    qcVector step = {0.0, 0.0, 0.0};
    step = qcPlusScaled(step, qcMinus(local[i], local[h]), weights[i]);
    step = qcPlusScaled(step, qcMinus(local[j], local[h]), weights[j]);
    const double steps[3] = {step.x, step.y, step.z};
    for (int axis = 0; axis < 3; axis++)
    {
        point[axis] = corners[h][axis] + TimesPowerOfTwo(steps[axis], exponent);
        if (!isfinite(point[axis])) // the step overflows, between corners of opposite extreme coordinates
            point[axis] = 2.0 * (0.5 * corners[h][axis] + ldexp(steps[axis], exponent - 1));
    }
}

static void SetMiddle(const double p[3], const double q[3], double middle[3])
{
    for (int axis = 0; axis < 3; axis++)
        middle[axis] = p[axis] == q[axis] ? p[axis] : 0.5 * p[axis] + 0.5 * q[axis];
}

/// The larger of a world point's distances to the two triangles, in the frame.
static double DistanceToBoth(const qcPairFrame* frame, const double point[3])
{
    double local[3];
    for (int axis = 0; axis < 3; axis++)
        local[axis] = qcPairFrame_Length(frame, point[axis] - frame->origin[axis]);
    qcVector x = qcVector_Load(local);
    return fmax(Length(qcClosest_FromTriangle(frame->a, x)), Length(qcClosest_FromTriangle(frame->b, x)));
}

/// The midpoint of the segment in which the two meet. If they are nearly parallel, its ends are right to 20 bits only
/// and it may lie outside: then an end, or the point between the closest points of features (`between`), is nearer.
static void SetCommonPoint(const qcPairFrame* frame, const double a[3][3], const double b[3][3],
                           const double between[3], double point[3])
{
    qcSegment segment;
    qcExact_Segment(a, b, &segment);
    double middle[3];
    SetMiddle(segment.p, segment.q, middle);
    const double* candidates[4] = {middle, segment.p, segment.q, between};
    // Points of world space are rounded to an ulp.
    double size = fmax(fmax(fabs(middle[0]), fabs(middle[1])), fabs(middle[2]));
    double enough = s_rounding + 0x1p-50 * qcPairFrame_Length(frame, size), nearest = INFINITY;
    for (int i = 0; i < 4 && nearest > enough; i++)
    {
        double far = DistanceToBoth(frame, candidates[i]);
        if (i == 0 || far < nearest)
        {
            nearest = far;
            memcpy(point, candidates[i], 3 * sizeof(double));
        }
    }
}

// Smaller weights are rounding errors.
static const double s_minWeight = 1e-9;

/// The corners that span the feature of a point.
static uint8_t CornersOf(const double weights[3])
{
    uint8_t corners = 0;
    for (int c = 0; c < 3; c++)
        corners |= (uint8_t)((weights[c] > s_minWeight) << c);
    return corners;
}

/// qcProximity_Of for triangles in the order of IsBefore.
static void Compute(const double a[3][3], const double b[3][3], qcRelation relation, qcProximity* proximity,
                    qcClosestFeatures* features)
{
    bool meet = relation == qc_relationTouching || relation == qc_relationPenetrating;
    qcPairFrame frame;
    qcPairFrame_Set(&frame, a, b);
    qcClosestPoints closest;
    qcClosest_OfTriangles(frame.a, frame.b, &closest);
    *features = (qcClosestFeatures){{CornersOf(closest.weightsA), CornersOf(closest.weightsB)}};
    double distance = meet ? 0.0 : Length(closest.difference);
    SetPoint(a, frame.a, closest.weightsA, frame.exponent, proximity->pointA);
    SetPoint(b, frame.b, closest.weightsB, frame.exponent, proximity->pointB);
    if (meet)
    {
        double between[3];
        SetMiddle(proximity->pointA, proximity->pointB, between);
        memcpy(proximity->pointA, between, sizeof between);
        if (relation == qc_relationPenetrating)
            SetCommonPoint(&frame, a, b, between, proximity->pointA);
        memcpy(proximity->pointB, proximity->pointA, sizeof proximity->pointB);
    }
    Axis axis = FindAxis(&frame, &closest, distance);
    memcpy(proximity->normal, (double[]){axis.direction.x, axis.direction.y, axis.direction.z},
           sizeof proximity->normal);
    proximity->distance = TimesPowerOfTwo(distance, frame.exponent);
    proximity->depth = 0.0;
    bool deep = relation == qc_relationPenetrating && axis.gap < 0.0;
    if (deep && !(-axis.gap < s_loss && AreCoplanar(a, b)))
        proximity->depth = ldexp(-axis.gap, frame.exponent);
}

/// True if b is smaller than a in the first coordinate in which they differ.
static bool IsBefore(const double b[3][3], const double a[3][3])
{
    for (int i = 0; i < 9; i++)
        if (b[i / 3][i % 3] != a[i / 3][i % 3])
            return b[i / 3][i % 3] < a[i / 3][i % 3];
    return false;
}

void qcProximity_Of(const double a[3][3], const double b[3][3], qcRelation relation, qcProximity* proximity,
                    qcClosestFeatures* features)
{
    if (!IsBefore(b, a))
    {
        Compute(a, b, relation, proximity, features);
        return;
    }
    qcProximity mirror;
    qcClosestFeatures mirrorFeatures;
    Compute(b, a, relation, &mirror, &mirrorFeatures);
    *features = (qcClosestFeatures){{mirrorFeatures.corners[1], mirrorFeatures.corners[0]}};
    *proximity = mirror;
    memcpy(proximity->pointA, mirror.pointB, sizeof mirror.pointB);
    memcpy(proximity->pointB, mirror.pointA, sizeof mirror.pointA);
    for (int axis = 0; axis < 3; axis++)
        proximity->normal[axis] = 0.0 - mirror.normal[axis];
}

__attribute__((noinline)) static bool AreWithin(const double* a, const double* b, double margin, qcProximity* proximity)
{
    if (!(margin >= 0.0))
        return false;
    double corners[2][3][3];
    memcpy(corners[0], a, sizeof corners[0]);
    memcpy(corners[1], b, sizeof corners[1]);
    const double(*p)[3] = (const double(*)[3])corners[0];
    const double(*q)[3] = (const double(*)[3])corners[1];
    qcRelation relation = qcExact_Within(p, q, margin, NULL);
    if (relation == qc_relationDisjoint)
        return false;
    qcClosestFeatures features;
    if (proximity != NULL)
        qcProximity_Of(p, q, relation, proximity, &features);
    return true;
}

bool qcTrianglesWithin(const double* a, const double* b, double margin, qcProximity* proximity)
{
    qcFloatMode mode = qcFloatMode_Begin();
    bool within = AreWithin(a, b, margin, proximity);
    qcFloatMode_End(mode);
    return within;
}
