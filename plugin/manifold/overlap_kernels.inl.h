// The corners of what two triangles have in common, seen along a direction, with the gap there. The file of an
// instruction set includes this one, then defines BitsOf.
//
// Over the common part the gap between the two planes is linear, so its least and its largest values are at corners: a
// corner of one triangle over the other's face, or two edges that cross. A face seen edge-on has several heights over
// one place; the crossings with its three edges name them all.
//
// Three corners, or three edges, lie in lanes side by side: each is computed as it would be alone.
#ifndef QC_MANIFOLD_OVERLAP_KERNELS_INL_H
#define QC_MANIFOLD_OVERLAP_KERNELS_INL_H

#include "manifold/overlap_kernels.h"

#include <math.h>
#include <string.h>

#define QC_INLINE static inline __attribute__((always_inline))

typedef double Lanes __attribute__((vector_size(8 * qc_overlapLanes)));
typedef int64_t Marks __attribute__((vector_size(8 * qc_overlapLanes)));

/// A bit for each of the first three lanes that is marked.
QC_INLINE unsigned BitsOf(Marks marks);

/// Three vectors, one a lane.
typedef struct Vectors
{
    Lanes x, y, z;
} Vectors;

// A face steeper than this along the direction (89.9 degrees) has no inside to stand over.
static const double s_edgeOn = 1e-3;

/// Two triangles and the corners found so far.
typedef struct Sight
{
    const qcManifoldPair* pair;
    qcTriangleView* view[2];
    /// Across an edge of a side, from it: a corner of the other side. Of side 0 by edge, a corner a lane; of side 1 by
    /// corner, an edge a lane: so that both are by triangle 0's, and a lane is one of triangle 1's.
    Lanes beyond[2][3];
    qcVector normal;
    qcRawPoint* found;
    int count;
} Sight;

QC_INLINE Lanes LoadLanes(const double* lanes)
{
    Lanes loaded;
    memcpy(&loaded, lanes, sizeof loaded);
    return loaded;
}

QC_INLINE void StoreLanes(Lanes lanes, double* to)
{
    memcpy(to, &lanes, sizeof lanes);
}

QC_INLINE Vectors LoadVectors(const double vectors[3][qc_overlapLanes])
{
    return (Vectors){LoadLanes(vectors[0]), LoadLanes(vectors[1]), LoadLanes(vectors[2])};
}

/// Corner c of a triangle in lane 0, then the next ones.
QC_INLINE Vectors LoadCorners(const qcManifoldTriangle* triangle, int c)
{
    return (Vectors){LoadLanes(triangle->around[0] + c), LoadLanes(triangle->around[1] + c),
                     LoadLanes(triangle->around[2] + c)};
}

QC_INLINE Vectors LanesMinus(Vectors a, Vectors b)
{
    return (Vectors){a.x - b.x, a.y - b.y, a.z - b.z};
}

QC_INLINE Lanes LanesDot(Vectors a, Vectors b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

QC_INLINE Lanes AllLanes(double x)
{
    return (Lanes){x, x, x, x};
}

QC_INLINE Vectors InAllLanes(qcVector v)
{
    return (Vectors){AllLanes(v.x), AllLanes(v.y), AllLanes(v.z)};
}

static void Keep(Sight* sight, const qcRawPoint* point)
{
    if (isfinite(point->distance))
        sight->found[sight->count++] = *point;
}

static uint32_t VertexOf(const Sight* sight, int side, int corner)
{
    return sight->pair->side[side]->name[corner];
}

/// A bit for each corner of a side that is surely outside of the other's face, as seen along the direction. Settles
/// most.
QC_INLINE unsigned OutsideFace(const Sight* sight, int side)
{
    double facing = sight->view[1 - side]->facing;
    Lanes border = AllLanes(2.0 * QC_MANIFOLD_ROUNDING * fabs(facing));
    unsigned outside = 0;
    for (int i = 0; i < 3; i++)
    {
        Lanes beyond = sight->beyond[1 - side][i];
        unsigned bits = BitsOf((facing > 0.0 ? beyond : -beyond) > border);
        outside |= side == 1 ? bits : (unsigned)(bits != 0) << i;
    }
    return outside;
}

static qcVector EdgeOf(const qcTriangleView* view, int e)
{
    return (qcVector){view->edge[0][e], view->edge[1][e], view->edge[2][e]};
}

/// Is a foot in the plane of a side's face within it? A corner over the common edge of two faces is found over at least
/// one of them, in spite of rounding.
static bool IsInside(const Sight* sight, int side, qcVector foot)
{
    const qcTriangleView* view = sight->view[side];
    qcVector m = view->face;
    double border = -QC_MANIFOLD_ROUNDING * qcDot(m, m);
    for (int e = 0; e < 3; e++)
        if (!(qcDot(m, qcCross(EdgeOf(view, e), qcMinus(foot, view->triangle->corner[e]))) >= border))
            return false;
    return true;
}

static void CornersOverFace(Sight* sight, int side)
{
    const qcTriangleView* under = sight->view[1 - side];
    qcVector n = sight->normal, m = under->face;
    double facing = under->facing;
    if (!(facing * facing > s_edgeOn * s_edgeOn * qcDot(m, m)))
        return;
    unsigned outside = OutsideFace(sight, side);
    for (int c = 0; c < 3; c++)
    {
        if (outside >> c & 1u)
            continue;
        qcVector x = sight->view[side]->triangle->corner[c];
        double height = qcDot(m, qcMinus(x, under->triangle->corner[0])) / facing;
        qcVector foot = qcPlusScaled(x, n, -height);
        if (!IsInside(sight, 1 - side, foot))
            continue;
        uint32_t vertex = VertexOf(sight, side, c);
        qcRawPoint point = {.normal = n, .distance = side == 0 ? height : -height};
        point.end[side] = x;
        point.end[1 - side] = foot;
        point.feature[side][0] = point.feature[side][1] = vertex;
        point.feature[1 - side][0] = point.feature[1 - side][1] = UINT32_MAX;
        Keep(sight, &point);
    }
}

static void NameEdge(const Sight* sight, int side, int e, uint32_t feature[2])
{
    uint32_t v = VertexOf(sight, side, e), w = VertexOf(sight, side, (e + 1) % 3);
    feature[0] = v < w ? v : w;
    feature[1] = v < w ? w : v;
}

/// Surely no parameter of an edge? Settles most without a division.
QC_INLINE Marks IsOutsideEdge(Lanes numerator, Lanes denominator)
{
    Lanes zero = AllLanes(0.0);
    Marks negative = denominator < zero;
    Lanes n = (Lanes)((negative & (Marks)-numerator) | (~negative & (Marks)numerator));
    Lanes d = (Lanes)((Marks)denominator & ~(Marks)AllLanes(-0.0));
    Lanes beside = AllLanes(2.0 * QC_MANIFOLD_ROUNDING) * d;
    return (n < -beside) | (n > d + beside);
}

static bool ClampToEdge(double* t)
{
    if (!(*t >= -QC_MANIFOLD_ROUNDING && *t <= 1.0 + QC_MANIFOLD_ROUNDING))
        return false;
    *t = *t < 0.0 ? 0.0 : *t > 1.0 ? 1.0 : *t;
    return true;
}

/// Where edges e and f cross, at `along` over `cross` of either.
static void CrossEdges(Sight* sight, int e, int f, double cross, const double along[2])
{
    qcVector u = EdgeOf(sight->view[0], e), v = EdgeOf(sight->view[1], f);
    double parallel = QC_MANIFOLD_ROUNDING * QC_MANIFOLD_ROUNDING * qcDot(u, u) * qcDot(v, v);
    if (!(cross * cross > parallel))
        return;
    double s = along[0] / cross, t = along[1] / cross;
    if (!ClampToEdge(&s) || !ClampToEdge(&t))
        return;
    qcRawPoint point = {.end = {qcPlusScaled(sight->view[0]->triangle->corner[e], u, s),
                                qcPlusScaled(sight->view[1]->triangle->corner[f], v, t)},
                        .normal = sight->normal};
    point.distance = qcDot(qcMinus(point.end[0], point.end[1]), sight->normal);
    NameEdge(sight, 0, e, point.feature[0]);
    NameEdge(sight, 1, f, point.feature[1]);
    Keep(sight, &point);
}

static void EdgesOverEdges(Sight* sight)
{
    Vectors across = LoadVectors(sight->view[1]->across);
    for (int e = 0; e < 3; e++)
    {
        Lanes cross = LanesDot(InAllLanes(EdgeOf(sight->view[0], e)), across);
        Lanes s = -sight->beyond[1][e], t = sight->beyond[0][e];
        unsigned outside = BitsOf(IsOutsideEdge(s, cross) | IsOutsideEdge(t, cross));
        for (unsigned left = 7u & ~outside; left != 0; left &= left - 1)
        {
            int f = __builtin_ctz(left);
            CrossEdges(sight, e, f, cross[f], (const double[2]){s[f], t[f]});
        }
    }
}

QC_INLINE void SeeEdges(qcTriangleView* view, qcVector normal)
{
    if (view->hasEdges)
        return;
    Vectors corner = LoadCorners(view->triangle, 0), n = InAllLanes(normal);
    Vectors edge = LanesMinus(LoadCorners(view->triangle, 1), corner);
    Vectors across = {edge.y * n.z - edge.z * n.y, edge.z * n.x - edge.x * n.z, edge.x * n.y - edge.y * n.x};
    Lanes inner = LanesDot(across, LanesMinus(LoadCorners(view->triangle, 2), corner));
    const Lanes *edges = &edge.x, *acrosses = &across.x;
    for (int axis = 0; axis < 3; axis++)
    {
        StoreLanes(edges[axis], view->edge[axis]);
        StoreLanes(acrosses[axis], view->across[axis]);
    }
    StoreLanes(inner, view->inner);
    view->hasEdges = true;
}

static void SeeFace(qcTriangleView* view, qcVector normal)
{
    if (view->hasFace)
        return;
    view->face = qcCross(EdgeOf(view, 0), EdgeOf(view, 1));
    view->facing = qcDot(view->face, normal);
    view->hasFace = true;
}

/// Seen along the direction, is triangle 1 beyond the line through an edge of triangle 0?
QC_INLINE bool IsBeside0(Sight* sight)
{
    qcTriangleView* view = sight->view[0];
    SeeEdges(view, sight->normal);
    Vectors other = LoadCorners(sight->view[1]->triangle, 0);
    for (int e = 0; e < 3; e++)
    {
        qcVector across = {view->across[0][e], view->across[1][e], view->across[2][e]};
        Lanes beyond = LanesDot(InAllLanes(across), LanesMinus(other, InAllLanes(view->triangle->corner[e])));
        sight->beyond[0][e] = beyond;
        double inner = view->inner[e];
        Lanes border = AllLanes(QC_MANIFOLD_ROUNDING * fabs(inner));
        if ((inner > 0.0 && BitsOf(beyond < -border) == 7u) || (inner < 0.0 && BitsOf(beyond > border) == 7u))
            return true;
    }
    return false;
}

/// And triangle 0 beyond that through an edge of triangle 1?
QC_INLINE bool IsBeside1(Sight* sight)
{
    qcTriangleView* view = sight->view[1];
    SeeEdges(view, sight->normal);
    Vectors corner = LoadCorners(view->triangle, 0), across = LoadVectors(view->across);
    Lanes inner = LoadLanes(view->inner), zero = AllLanes(0.0);
    Lanes border = AllLanes(QC_MANIFOLD_ROUNDING) * (Lanes)((Marks)inner & ~(Marks)AllLanes(-0.0));
    Marks below = inner > zero, above = inner < zero;
    for (int c = 0; c < 3; c++)
    {
        Lanes beyond = LanesDot(across, LanesMinus(InAllLanes(sight->view[0]->triangle->corner[c]), corner));
        sight->beyond[1][c] = beyond;
        below &= beyond < -border;
        above &= beyond > border;
    }
    return BitsOf(below | above) != 0;
}

static int FindCommonPart(const qcManifoldPair* pair, qcVector normal, qcTriangleView* views[2],
                          qcRawPoint corners[qc_maxCommonCorners])
{
    Sight sight;
    sight.pair = pair;
    sight.normal = normal;
    sight.found = corners;
    sight.count = 0;
    sight.view[0] = views[0];
    sight.view[1] = views[1];
    if (IsBeside0(&sight) || IsBeside1(&sight))
        return 0;
    SeeFace(views[0], normal);
    SeeFace(views[1], normal);
    // Corners of triangles first: where one also lies on an edge of the other, a vertex is the steadier name.
    CornersOverFace(&sight, 0);
    CornersOverFace(&sight, 1);
    EdgesOverEdges(&sight);
    return sight.count;
}

#endif
