// The corners of a projected overlap, with the signed distance there. The file of an instruction set includes this one,
// then defines MaskBits.
//
// Over the overlap the distance of the two planes is linear, so its smallest and its largest value are at corners: a
// vertex of one triangle over the other's face, or two edges that cross. A face seen edge-on has several heights over
// one position; the crossings with its three edges give them all.
//
// Three corners, or three edges, lie in lanes side by side: each is computed as it would be alone.
#ifndef QC_MANIFOLD_OVERLAP_KERNELS_INL_H
#define QC_MANIFOLD_OVERLAP_KERNELS_INL_H

#include "manifold/overlap_kernels.h"

#include <math.h>
#include <string.h>

#define QC_INLINE static inline __attribute__((always_inline))

typedef double Lanes __attribute__((vector_size(8 * qc_overlapLanes)));
typedef int64_t Mask __attribute__((vector_size(8 * qc_overlapLanes)));

/// Bit i is set if lane i of the mask is, i < 3.
QC_INLINE unsigned MaskBits(Mask mask);

/// Three vectors, one a lane.
typedef struct Vectors
{
    Lanes x, y, z;
} Vectors;

// A face steeper than this along the direction (89.9 degrees) is edge-on: no vertex lies over it.
static const double s_edgeOn = 1e-3;

/// Two triangles and the corners found so far.
typedef struct Overlap
{
    const qcManifoldPair* pair;
    qcTriangleView* view[2];
    /// Heights along edgeNormal of a side's edges, from the edge, of the other side's corners. [0]: by edge of triangle
    /// 0, a corner of triangle 1 a lane; [1]: by corner of triangle 0, an edge of triangle 1 a lane.
    Lanes edgeHeight[2][3];
    qcVector direction;
    qcRawPoint* corners;
    int count;
} Overlap;

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
    return (Vectors){LoadLanes(triangle->cornerLanes[0] + c), LoadLanes(triangle->cornerLanes[1] + c),
                     LoadLanes(triangle->cornerLanes[2] + c)};
}

QC_INLINE Vectors VectorsMinus(Vectors a, Vectors b)
{
    return (Vectors){a.x - b.x, a.y - b.y, a.z - b.z};
}

QC_INLINE Lanes VectorsDot(Vectors a, Vectors b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

QC_INLINE Lanes Broadcast(double x)
{
    return (Lanes){x, x, x, x};
}

QC_INLINE Vectors BroadcastVector(qcVector v)
{
    return (Vectors){Broadcast(v.x), Broadcast(v.y), Broadcast(v.z)};
}

static void Add(Overlap* overlap, const qcRawPoint* point)
{
    if (isfinite(point->distance))
        overlap->corners[overlap->count++] = *point;
}

static uint32_t VertexName(const Overlap* overlap, int side, int corner)
{
    return overlap->pair->side[side]->bodyVertex[corner];
}

/// A bit for each corner of a side that is proven outside of the other's face, seen along the direction: most corners.
QC_INLINE unsigned OutsideFaceBits(const Overlap* overlap, int side)
{
    double facing = overlap->view[1 - side]->facing;
    Lanes border = Broadcast(2.0 * QC_MANIFOLD_ROUNDING * fabs(facing));
    unsigned outside = 0;
    for (int i = 0; i < 3; i++)
    {
        Lanes height = overlap->edgeHeight[1 - side][i];
        unsigned bits = MaskBits((facing > 0.0 ? height : -height) > border);
        outside |= side == 1 ? bits : (unsigned)(bits != 0) << i;
    }
    return outside;
}

static qcVector EdgeOf(const qcTriangleView* view, int e)
{
    return (qcVector){view->edge[0][e], view->edge[1][e], view->edge[2][e]};
}

/// True if a point in the plane of a side's face is within the face. A vertex over the common edge of two faces is
/// found over at least one of them, in spite of rounding.
static bool IsInside(const Overlap* overlap, int side, qcVector foot)
{
    const qcTriangleView* view = overlap->view[side];
    qcVector m = view->face;
    double border = -QC_MANIFOLD_ROUNDING * qcDot(m, m);
    for (int e = 0; e < 3; e++)
        if (!(qcDot(m, qcCross(EdgeOf(view, e), qcMinus(foot, view->triangle->corner[e]))) >= border))
            return false;
    return true;
}

static void AddVerticesOverFace(Overlap* overlap, int side)
{
    const qcTriangleView* under = overlap->view[1 - side];
    qcVector n = overlap->direction, m = under->face;
    double facing = under->facing;
    if (!(facing * facing > s_edgeOn * s_edgeOn * qcDot(m, m)))
        return;
    unsigned outside = OutsideFaceBits(overlap, side);
    for (int c = 0; c < 3; c++)
    {
        if (outside >> c & 1u)
            continue;
        qcVector x = overlap->view[side]->triangle->corner[c];
        double height = qcDot(m, qcMinus(x, under->triangle->corner[0])) / facing;
        qcVector foot = qcPlusScaled(x, n, -height);
        if (!IsInside(overlap, 1 - side, foot))
            continue;
        uint32_t vertex = VertexName(overlap, side, c);
        qcRawPoint point = {.normal = n, .distance = side == 0 ? height : -height};
        point.end[side] = x;
        point.end[1 - side] = foot;
        point.feature[side][0] = point.feature[side][1] = vertex;
        point.feature[1 - side][0] = point.feature[1 - side][1] = UINT32_MAX;
        Add(overlap, &point);
    }
}

static void NameEdge(const Overlap* overlap, int side, int e, uint32_t feature[2])
{
    uint32_t v = VertexName(overlap, side, e), w = VertexName(overlap, side, (e + 1) % 3);
    feature[0] = v < w ? v : w;
    feature[1] = v < w ? w : v;
}

/// Lanes whose quotient is proven to be outside of 0..1: most lanes, which saves a division.
QC_INLINE Mask IsOutsideEdge(Lanes numerator, Lanes denominator)
{
    Lanes zero = Broadcast(0.0);
    Mask negative = denominator < zero;
    Lanes n = (Lanes)((negative & (Mask)-numerator) | (~negative & (Mask)numerator));
    Lanes d = (Lanes)((Mask)denominator & ~(Mask)Broadcast(-0.0));
    Lanes beside = Broadcast(2.0 * QC_MANIFOLD_ROUNDING) * d;
    return (n < -beside) | (n > d + beside);
}

static bool ClampToEdge(double* t)
{
    if (!(*t >= -QC_MANIFOLD_ROUNDING && *t <= 1.0 + QC_MANIFOLD_ROUNDING))
        return false;
    *t = *t < 0.0 ? 0.0 : *t > 1.0 ? 1.0 : *t;
    return true;
}

/// The crossing of edges e and f, whose parameters are along[0] / cross and along[1] / cross.
static void AddCrossing(Overlap* overlap, int e, int f, double cross, const double along[2])
{
    qcVector u = EdgeOf(overlap->view[0], e), v = EdgeOf(overlap->view[1], f);
    double parallel = QC_MANIFOLD_ROUNDING * QC_MANIFOLD_ROUNDING * qcDot(u, u) * qcDot(v, v);
    if (!(cross * cross > parallel))
        return;
    double s = along[0] / cross, t = along[1] / cross;
    if (!ClampToEdge(&s) || !ClampToEdge(&t))
        return;
    qcRawPoint point = {.end = {qcPlusScaled(overlap->view[0]->triangle->corner[e], u, s),
                                qcPlusScaled(overlap->view[1]->triangle->corner[f], v, t)},
                        .normal = overlap->direction};
    point.distance = qcDot(qcMinus(point.end[0], point.end[1]), overlap->direction);
    NameEdge(overlap, 0, e, point.feature[0]);
    NameEdge(overlap, 1, f, point.feature[1]);
    Add(overlap, &point);
}

static void AddEdgeCrossings(Overlap* overlap)
{
    Vectors across = LoadVectors(overlap->view[1]->edgeNormal);
    for (int e = 0; e < 3; e++)
    {
        Lanes cross = VectorsDot(BroadcastVector(EdgeOf(overlap->view[0], e)), across);
        Lanes s = -overlap->edgeHeight[1][e], t = overlap->edgeHeight[0][e];
        unsigned outside = MaskBits(IsOutsideEdge(s, cross) | IsOutsideEdge(t, cross));
        for (unsigned left = 7u & ~outside; left != 0; left &= left - 1)
        {
            int f = __builtin_ctz(left);
            AddCrossing(overlap, e, f, cross[f], (const double[2]){s[f], t[f]});
        }
    }
}

QC_INLINE void ComputeEdges(qcTriangleView* view, qcVector direction)
{
    if (view->hasEdges)
        return;
    Vectors corner = LoadCorners(view->triangle, 0), n = BroadcastVector(direction);
    Vectors edge = VectorsMinus(LoadCorners(view->triangle, 1), corner);
    Vectors across = {edge.y * n.z - edge.z * n.y, edge.z * n.x - edge.x * n.z, edge.x * n.y - edge.y * n.x};
    Lanes inner = VectorsDot(across, VectorsMinus(LoadCorners(view->triangle, 2), corner));
    const Lanes *edges = (const Lanes*)&edge, *acrosses = (const Lanes*)&across;
    for (int axis = 0; axis < 3; axis++)
    {
        StoreLanes(edges[axis], view->edge[axis]);
        StoreLanes(acrosses[axis], view->edgeNormal[axis]);
    }
    StoreLanes(inner, view->oppositeHeight);
    view->hasEdges = true;
}

static void ComputeFace(qcTriangleView* view, qcVector direction)
{
    if (view->hasFace)
        return;
    view->face = qcCross(EdgeOf(view, 0), EdgeOf(view, 1));
    view->facing = qcDot(view->face, direction);
    view->hasFace = true;
}

/// True if triangle 1, seen along the direction, is beyond the line through an edge of triangle 0.
QC_INLINE bool AreDisjointAtSide0(Overlap* overlap)
{
    qcTriangleView* view = overlap->view[0];
    ComputeEdges(view, overlap->direction);
    Vectors other = LoadCorners(overlap->view[1]->triangle, 0);
    for (int e = 0; e < 3; e++)
    {
        qcVector across = {view->edgeNormal[0][e], view->edgeNormal[1][e], view->edgeNormal[2][e]};
        Lanes height =
            VectorsDot(BroadcastVector(across), VectorsMinus(other, BroadcastVector(view->triangle->corner[e])));
        overlap->edgeHeight[0][e] = height;
        double inner = view->oppositeHeight[e];
        Lanes border = Broadcast(QC_MANIFOLD_ROUNDING * fabs(inner));
        if ((inner > 0.0 && MaskBits(height < -border) == 7u) || (inner < 0.0 && MaskBits(height > border) == 7u))
            return true;
    }
    return false;
}

/// True if triangle 0 is beyond the line through an edge of triangle 1.
QC_INLINE bool AreDisjointAtSide1(Overlap* overlap)
{
    qcTriangleView* view = overlap->view[1];
    ComputeEdges(view, overlap->direction);
    Vectors corner = LoadCorners(view->triangle, 0), across = LoadVectors(view->edgeNormal);
    Lanes inner = LoadLanes(view->oppositeHeight), zero = Broadcast(0.0);
    Lanes border = Broadcast(QC_MANIFOLD_ROUNDING) * (Lanes)((Mask)inner & ~(Mask)Broadcast(-0.0));
    Mask below = inner > zero, above = inner < zero;
    for (int c = 0; c < 3; c++)
    {
        Lanes height = VectorsDot(across, VectorsMinus(BroadcastVector(overlap->view[0]->triangle->corner[c]), corner));
        overlap->edgeHeight[1][c] = height;
        below &= height < -border;
        above &= height > border;
    }
    return MaskBits(below | above) != 0;
}

static int FindOverlap(const qcManifoldPair* pair, qcVector direction, qcTriangleView* views[2],
                       qcRawPoint corners[qc_maxOverlapCorners])
{
    Overlap overlap;
    overlap.pair = pair;
    overlap.direction = direction;
    overlap.corners = corners;
    overlap.count = 0;
    overlap.view[0] = views[0];
    overlap.view[1] = views[1];
    if (AreDisjointAtSide0(&overlap) || AreDisjointAtSide1(&overlap))
        return 0;
    ComputeFace(views[0], direction);
    ComputeFace(views[1], direction);
    // Vertices first: where a vertex lies on an edge of the other triangle, its feature id is more persistent than that
    // of a crossing.
    AddVerticesOverFace(&overlap, 0);
    AddVerticesOverFace(&overlap, 1);
    AddEdgeCrossings(&overlap);
    return overlap.count;
}

#endif
