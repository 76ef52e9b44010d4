// Coplanar point reduction: of a flat patch of contact between rigid bodies only the corners are kept. A box on a floor
// has four points, however many tiles the floor has. Deforming bodies need every point, since each vertex moves alone.
//
// A point is redundant if the patch extends to both sides of it along some line, with the distance linear along that
// line: its position and distance are then means of those of other points, and so is any force at it. The corners of
// the patch's convex hull have no such line. Proof: plugin/docs/proofs/coplanar_reduction.md.
#include "manifold/points.h"

#include <math.h>

enum
{
    // Max pairs visited for one point: more than share any point of triangles that aren't degenerate. If further pairs
    // share it, the point may be kept.
    qc_maxCones = 48
};

static const double s_pi = 3.14159265358979323846;
// Max angle in radians, or difference of slopes, of directions along one line. A regular polygon of half a million
// sides keeps its corners.
static const double s_straight = 1e-5;
// Faces within this cosine are one plane: 0.03 degrees.
static const double s_onePlane = 1.0 - 1e-7;
// Pairs whose normals are within this cosine share a projection: 2.5 degrees.
static const double s_oneProjection = 0.999;
// Ends within this share of the merge tolerance are one position: the error of one feature found from two triangles
// with corners in single precision.
static const double s_onePosition = 1e-3;

/// The directions from a point into the overlap of one pair, as angles around the normal.
typedef struct Cone
{
    double middle, half;
    double slope; ///< of the distance, if the cone is a ray
    qcVector face[2];
} Cone;

typedef struct Basis
{
    qcVector u, v, normal;
} Basis;

typedef struct Input
{
    const qcContactTopology* topology;
    const qcContactNormals* normals;
    const qcContactPoints* points;
} Input;

static qcVector Unit(qcVector v)
{
    double length = sqrt(qcDot(v, v));
    return (qcVector){v.x / length, v.y / length, v.z / length};
}

static Basis BasisOf(qcVector normal)
{
    // Any direction that is not near the normal.
    qcVector other = fabs(normal.x) < 0.6 ? (qcVector){1.0, 0.0, 0.0} : (qcVector){0.0, 1.0, 0.0};
    qcVector u = Unit(qcCross(normal, other));
    return (Basis){u, qcCross(normal, u), normal};
}

static double Wrapped(double angle)
{
    if (fabs(angle) < 3.0)
        return angle;
    return angle - 2.0 * s_pi * qcFloor(angle / (2.0 * s_pi) + 0.5);
}

/// Finds the cone of a raw point towards the other points of its pair. False: there are none, or the pair's normal
/// differs.
static bool FindCone(const Input* input, const Basis* basis, uint32_t raw, Cone* cone)
{
    const qcContactPoints* points = input->points;
    const qcRawPoint* point = qcContactPoints_Raw(points, raw);
    const qcManifoldPair* pair = qcContactTopology_Pair(input->topology, point->pair);
    if (qcDot(qcContactNormals_Pair(input->normals, point->pair)->normal, basis->normal) < s_oneProjection)
        return false;
    size_t first = QC_AT(size_t, points->firstOfPair, point->pair);
    size_t end = QC_AT(size_t, points->firstOfPair, point->pair + 1);
    double reference = 0.0, lower = 0.0, upper = 0.0;
    bool any = false;
    for (size_t i = first; i < end; i++)
    {
        if (i == raw)
            continue;
        const qcRawPoint* other = qcContactPoints_Raw(points, i);
        qcVector d = qcPlusScaled(qcMinus(other->end[0], point->end[0]), qcMinus(other->end[1], point->end[1]), 1.0);
        double x = 0.5 * qcDot(d, basis->u), y = 0.5 * qcDot(d, basis->v);
        double angle = atan2(y, x);
        if (!any)
        {
            reference = angle;
            cone->slope = (other->distance - point->distance) / sqrt(x * x + y * y);
        }
        any = true;
        lower = fmin(lower, Wrapped(angle - reference));
        upper = fmax(upper, Wrapped(angle - reference));
    }
    cone->middle = reference + 0.5 * (lower + upper);
    cone->half = 0.5 * (upper - lower);
    for (int side = 0; side < 2; side++)
        cone->face[side] = pair->side[side]->normal;
    return any;
}

/// True if a line through the point leads from the one cone to the other, along which the distance is linear.
static bool AreOpposite(const Cone* a, const Cone* b)
{
    for (int side = 0; side < 2; side++)
        if (!(fabs(qcDot(a->face[side], b->face[side])) >= s_onePlane))
            return false;
    if (!(fabs(Wrapped(a->middle - b->middle - s_pi)) <= a->half + b->half + s_straight))
        return false;
    // Two rays may belong to different edges of one face that is seen edge-on.
    return a->half > s_straight || b->half > s_straight || fabs(a->slope + b->slope) <= s_straight;
}

static bool AreAtOnePosition(const qcRawPoint* p, const qcRawPoint* q, double tolerance)
{
    qcVector d = qcMinus(p->end[0], q->end[0]), e = qcMinus(p->end[1], q->end[1]);
    double limit = s_onePosition * tolerance;
    return fmax(qcDot(d, d), qcDot(e, e)) <= limit * limit;
}

static bool IsRedundant(const Input* input, uint32_t representative, double tolerance)
{
    const qcContactPoints* points = input->points;
    Cone cones[qc_maxCones];
    int count = 0;
    const qcRawPoint* point = qcContactPoints_Raw(points, representative);
    Basis basis = BasisOf(qcContactNormals_Pair(input->normals, point->pair)->normal);
    for (uint32_t raw = representative; raw != UINT32_MAX && count < qc_maxCones;
         raw = QC_AT(uint32_t, points->nextMembers, raw))
    {
        if (!AreAtOnePosition(point, qcContactPoints_Raw(points, raw), tolerance) ||
            !FindCone(input, &basis, raw, &cones[count]))
            continue;
        for (int i = 0; i <= count; i++)
            if (AreOpposite(&cones[i], &cones[count]))
                return true;
        count++;
    }
    return false;
}

void qcContactPoints_Reduce(const qcContactTopology* topology, const qcContactNormals* normals, qcContactPoints* points)
{
    const qcManifoldPair* any = qcContactTopology_Pair(topology, 0);
    if (any->side[0]->body->deforming || any->side[1]->body->deforming)
        return;
    const Input input = {topology, normals, points};
    const qcSortItem* items = points->order.data;
    uint32_t* representatives = points->representatives.data;
    for (size_t first = 0, end; first < points->order.count; first = end)
    {
        uint64_t region = items[first].key;
        double tolerance = qcContactPoints_Tolerance(points, region);
        size_t kept = 0;
        for (end = first; end < points->order.count && items[end].key == region; end++)
        {
            uint32_t raw = (uint32_t)items[end].value;
            if (representatives[raw] != raw)
                continue;
            // The points represented by a dropped one are dropped with it.
            if (IsRedundant(&input, raw, tolerance))
                representatives[raw] = UINT32_MAX;
            else
                kept++;
        }
        // All points of a region of the size of rounding errors can be redundant: the deepest is kept.
        if (kept == 0)
            representatives[items[first].value] = (uint32_t)items[first].value;
    }
}
