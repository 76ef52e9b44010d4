// Of a flat patch of contact between rigid bodies only the corners stay: a box on a floor stands on four points, into
// however many tiles the floor is cut.
//
// A point is between others if some line through it runs on to both sides within the patch, with the gap linear along
// it: then its place and its gap are means of others', and forces at these do all that a force at it could do. Which
// ways lead on from a point is known from the pairs that found it: each has a convex common part, and the point sees
// it under the cone of the directions to its other points. The two ways, there and back, must lie on the same planes:
// the gap over one pair is linear, over two pairs it is if the faces of each side lie in one plane. A corner of the
// convex hull of a flat patch has no line through it, so the hull stays whole.
//
// Deforming bodies need every point, since each vertex falls alone.
#include "manifold/manifold_builder.h"
#include "base/radix_sort.h"

#include <math.h>

enum
{
    // More pairs than meet at any but a degenerate point; those beyond are not asked, and the point may stay.
    qc_maxCones = 48
};

static const double s_pi = 3.14159265358979323846;
// A disc of half a million sides keeps its outline.
static const double s_straight = 1e-5;
// Faces that differ by less are one plane: 0.03 degrees.
static const double s_onePlane = 1.0 - 1e-7;
// Normals that differ by less see the same ways: 2.5 degrees.
static const double s_oneSight = 0.999;
// Ends that differ by less than this share of what is merged are one place: what one feature is off by, found from two
// triangles of corners in single precision.
static const double s_onePlace = 1e-3;

/// The directions from a point into the common part of one pair, as angles around the normal.
typedef struct Cone
{
    double middle, half;
    double slope; ///< of the gap, if the cone is a ray
    qcVector face[2];
} Cone;

typedef struct Basis
{
    qcVector u, v, normal;
} Basis;

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

static bool ConeOf(const qcManifoldBuilder* m, const Basis* basis, uint32_t raw, Cone* cone)
{
    const qcRawPoint* point = &QC_AT(qcRawPoint, m->raw, raw);
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, point->pair);
    if (qcDot(pair->normal, basis->normal) < s_oneSight)
        return false;
    size_t first = QC_AT(size_t, m->firstRaw, point->pair), end = QC_AT(size_t, m->firstRaw, point->pair + 1);
    double reference = 0.0, lower = 0.0, upper = 0.0;
    bool any = false;
    for (size_t i = first; i < end; i++)
    {
        if (i == raw)
            continue;
        const qcRawPoint* other = &QC_AT(qcRawPoint, m->raw, i);
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

/// Does a line through the point lead from the one cone to the other?
static bool LeadThrough(const Cone* a, const Cone* b)
{
    for (int side = 0; side < 2; side++)
        if (!(fabs(qcDot(a->face[side], b->face[side])) >= s_onePlane))
            return false;
    if (!(fabs(Wrapped(a->middle - b->middle - s_pi)) <= a->half + b->half + s_straight))
        return false;
    // Two rays may belong to different edges of one face that is seen edge-on.
    return a->half > s_straight || b->half > s_straight || fabs(a->slope + b->slope) <= s_straight;
}

static bool AreAtOnePlace(const qcRawPoint* p, const qcRawPoint* q, double tolerance)
{
    qcVector d = qcMinus(p->end[0], q->end[0]), e = qcMinus(p->end[1], q->end[1]);
    double limit = s_onePlace * tolerance;
    return fmax(qcDot(d, d), qcDot(e, e)) <= limit * limit;
}

static bool IsBetween(const qcManifoldBuilder* m, uint32_t keeper, double tolerance)
{
    Cone cones[qc_maxCones];
    int count = 0;
    const qcRawPoint* point = &QC_AT(qcRawPoint, m->raw, keeper);
    Basis basis = BasisOf(qcManifoldBuilder_Pair(m, point->pair)->normal);
    for (uint32_t raw = keeper; raw != UINT32_MAX && count < qc_maxCones; raw = QC_AT(uint32_t, m->members, raw))
    {
        if (!AreAtOnePlace(point, &QC_AT(qcRawPoint, m->raw, raw), tolerance) || !ConeOf(m, &basis, raw, &cones[count]))
            continue;
        for (int i = 0; i <= count; i++)
            if (LeadThrough(&cones[i], &cones[count]))
                return true;
        count++;
    }
    return false;
}

void qcManifoldBuilder_DropBetween(qcManifoldBuilder* m)
{
    const qcManifoldPair* any = qcManifoldBuilder_Pair(m, 0);
    if (any->side[0]->body->deforming || any->side[1]->body->deforming)
        return;
    const qcSortItem* items = m->order.data;
    for (size_t first = 0, end; first < m->order.count; first = end)
    {
        uint64_t region = items[first].key;
        double tolerance = QC_AT(qcContactRegion, m->measured, region).tolerance;
        size_t stay = 0;
        for (end = first; end < m->order.count && items[end].key == region; end++)
        {
            uint32_t raw = (uint32_t)items[end].value;
            if (QC_AT(uint32_t, m->keepers, raw) != raw)
                continue;
            // What was merged into it goes with it: nobody asks for a keeper's keeper.
            if (IsBetween(m, raw, tolerance))
                QC_AT(uint32_t, m->keepers, raw) = UINT32_MAX;
            else
                stay++;
        }
        // A region of rounding alone could lose all its points: its deepest stays.
        if (stay == 0)
            QC_AT(uint32_t, m->keepers, items[first].value) = (uint32_t)items[first].value;
    }
}
