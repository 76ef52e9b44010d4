// The kernel that proves patches free of collisions with themselves, and of all that comes within a reach: normals and
// contour together.
//
// Flat discs. The disc is a triangulation D of a closed disc (mesh/flat_patches.h); f projects it along a direction d.
// If every triangle's image has the same orientation and the image of the loop is a simple curve, then f is injective:
// - The images of the oriented triangles add up to a chain whose boundary is the image of the loop, since inner edges
//   cancel. So a point off all edges lies in as many images as the loop winds around it: for a simple curve 0 or 1.
// - Suppose f(p) = f(q) with p != q. On the loop f is injective; so p, say, is inside. There f is open. In a triangle
//   and on an edge between two that is plain; around a vertex the images go round it once, as going round more often
//   would cover points nearby more than once. So f of a neighbourhood of p holds a neighbourhood of f(q); and each
//   neighbourhood of q has a part of a triangle whose image is near f(q): points there are covered twice. A
//   contradiction.
// Where two triangles of D have a common point in space, that is one point of D by this, in both triangles: they share
// a vertex. The normals alone don't do: a spiral ramp faces one way everywhere, and its contour crosses itself.
// (Volino, Magnenat-Thalmann: Efficient Self-Collision Detection on Smoothly Discretized Surface Animations, 1994.)
//
// Reach. Let D be flat as above, and let its image be the one at right angles to d. Two features of D (vertices, edges,
// triangles) without a common vertex are further than r apart there, and so in space, if each altitude of each
// triangle's image is above r, and each two edges of the loop without a common vertex are further than r apart. The
// images of such features don't meet, so their distance is that of a vertex v of one from an edge e of the other, which
// doesn't end in v. Let x be a point of e, no further than r from v.
// - Around v its triangles hold all points up to r away, in the angles that they span: the edges opposite to v are
//   further away. e meets none of them but in such an opposite edge. So x is in no such angle, and v is on the loop.
// - So the way from v straight to x begins outside of D. Let y be the first point of D on it: on an edge g of the loop,
//   no further than r from v. g doesn't end in v, as the way leaves the lines of v's own edges at v. If the loop has
//   more than three vertices, one of v's two edges there has no vertex in common with g: they are further than r apart.
//   If it has three, D's image is a triangle, and no way leaves it and comes back. A contradiction.
// With K = |d| = sqrt(1 + p^2 + q^2): along (u, v) things look at most K times as long as at right angles to d, so
// edges of the loop have to be K r apart there. An altitude at right angles to d is normal . d / K, through the length
// of an edge, which is no longer there than in space: the kernel asks for normal . d > K r length. Bounds that hold
// relatively are 1.001 times as large, which covers their rounding.
//
// Rounding there. Points are wrong by e, and d = (p, q, 1) with |p|, |q| <= 1 is exact: whatever it is will do. With
// edges up to m in any coordinate, a triangle's normal is wrong by 8 e m + 8 m^2 2^-24 + 8 e^2, and times d, rounded,
// by 24 e m + 38 m^2 2^-24 + 24 e^2. The kernel asks for 32 e m + 44 m^2 2^-24: no less where m >= 3 e, and below that
// more than there can be, 6 m^2. The loop is taken relative to one point, in coordinates up to 1: u and v are wrong by
// D = 2 e + 4 * 2^-24. With M twice the greatest of them, products of two differences of them, and what is made of two
// such products, are wrong by 8 M D + 8 M^2 2^-24 + 8 D^2. For M <= 4 the bound of IsSimple is no less where M >= 6 D,
// and below that more than there can be. Triangles without area never pass.
#ifndef QC_KERNELS_FLAT_PATCH_TEST_INL_H
#define QC_KERNELS_FLAT_PATCH_TEST_INL_H

#include "kernels/separating_axis.inl.h"

enum
{
    qc_arcEdges = 4
};

/// The loop around a disc from its centre, seen along d = (p, q, 1) in some order of the axes.
typedef struct Loop
{
    float u[qc_maxLoop + 2 * QC_LANES], v[qc_maxLoop + 2 * QC_LANES];
    float x[3][qc_maxLoop + 2 * QC_LANES];
    int axes[3]; ///< which axis is which of d's; the last is 1 there
    float p, q;
    float sign;  ///< of d's last axis in the direction that the disc faces
    float size;  ///< of the greatest coordinate u or v
    float query; ///< the query distance in the image
    //  What comparisons have to exceed for their rounding.
    float least; ///< of products of two lengths
    float gap;   ///< of coordinates
} Loop;

QC_INLINE Floats LoadFloats(const float* from)
{
    Floats f;
    memcpy(&f, from, sizeof f);
    return f;
}

QC_INLINE void StoreFloats(float* to, Floats f)
{
    memcpy(to, &f, sizeof f);
}

QC_INLINE float Sum(Floats f)
{
    float sum = 0.0f;
    for (int i = 0; i < QC_LANES; i++)
        sum += f[i];
    return sum;
}

/// Past the end the loop goes on from its beginning.
static void LoadLoop(const qcPatchGeometry* patch, Loop* loop)
{
    size_t count = patch->loopCount;
    uint32_t id[qc_maxLoop + 2 * QC_LANES];
    memcpy(id, patch->loop, count * sizeof id[0]);
    for (size_t i = count; i < count + 2 * QC_LANES; i++)
        id[i] = id[i - count];
    const float* centre = patch->points[id[0]].x;
    const float* opposite = patch->points[id[count / 2]].x;
    Floats at[3] = {{0}};
    for (int axis = 0; axis < 3; axis++)
        at[axis] += 0.5f * (centre[axis] + opposite[axis]);
    for (size_t i = 0; i < count + QC_LANES; i += QC_LANES)
    {
        Vectors point = LoadPoints(patch->points, id + i);
        StoreFloats(loop->x[0] + i, point.x - at[0]);
        StoreFloats(loop->x[1] + i, point.y - at[1]);
        StoreFloats(loop->x[2] + i, point.z - at[2]);
    }
}

/// Twice the area that the loop spans, as a vector: its direction is where the disc faces. False: there is none.
static bool ChooseDirection(size_t count, Loop* loop)
{
    float area[3];
    for (int axis = 0; axis < 3; axis++)
    {
        const float *y = loop->x[(axis + 1) % 3], *z = loop->x[(axis + 2) % 3];
        Floats sum = {0};
        for (size_t i = 0; i < count; i += QC_LANES)
        {
            Floats part = LoadFloats(y + i) * LoadFloats(z + i + 1) - LoadFloats(z + i) * LoadFloats(y + i + 1);
            for (size_t lane = count - i; lane < QC_LANES; lane++)
                part[lane] = 0.0f;
            sum += part;
        }
        area[axis] = Sum(sum);
    }
    int last = 0;
    for (int axis = 1; axis < 3; axis++)
        if (__builtin_fabsf(area[axis]) > __builtin_fabsf(area[last]))
            last = axis;
    if (!(__builtin_fabsf(area[last]) > 0.0f))
        return false;
    loop->axes[0] = (last + 1) % 3;
    loop->axes[1] = (last + 2) % 3;
    loop->axes[2] = last;
    loop->p = area[loop->axes[0]] / area[last];
    loop->q = area[loop->axes[1]] / area[last];
    loop->sign = area[last] > 0.0f ? 1.0f : -1.0f;
    return true;
}

/// The loop as it is seen along d.
static void Project(size_t count, Loop* loop)
{
    const float *x = loop->x[loop->axes[0]], *y = loop->x[loop->axes[1]], *z = loop->x[loop->axes[2]];
    Floats largest = {0};
    for (size_t i = 0; i < count + QC_LANES; i += QC_LANES)
    {
        Floats depth = LoadFloats(z + i), u = LoadFloats(x + i) - loop->p * depth,
               v = LoadFloats(y + i) - loop->q * depth;
        largest = MaxFloats(largest, MaxFloats(Absolute(u), Absolute(v)));
        StoreFloats(loop->u + i, u);
        StoreFloats(loop->v + i, v);
    }
    loop->size = 0.0f;
    for (int lane = 0; lane < QC_LANES; lane++)
        loop->size = largest[lane] > loop->size ? largest[lane] : loop->size;
}

/// What a product of a length along (u, v) and a distance has to exceed for the distance to exceed the reach.
static float MinProductAlong(const Loop* loop, float u, float v)
{
    // Without a reach no root is taken.
    return loop->query > 0.0f ? loop->least + loop->query * (__builtin_sqrtf(u * u + v * v) + loop->gap) : loop->least;
}

/// Are both ends of edge k surely beyond the reach on the same side of edge i: of the line through it, or of one of the
/// two across it at its ends?
static bool IsOneSided(const Loop* loop, size_t i, size_t k)
{
    float u = loop->u[i], v = loop->v[i], endU = loop->u[i + 1], endV = loop->v[i + 1];
    float alongU = endU - u, alongV = endV - v, left[2], beyond[2], before[2];
    float least = MinProductAlong(loop, alongU, alongV);
    for (size_t end = 0; end < 2; end++)
    {
        float otherU = loop->u[k + end], otherV = loop->v[k + end];
        left[end] = alongU * (otherV - v) - alongV * (otherU - u);
        beyond[end] = alongU * (otherU - endU) + alongV * (otherV - endV);
        before[end] = alongU * (u - otherU) + alongV * (v - otherV);
    }
    return (left[0] > least && left[1] > least) || (left[0] < -least && left[1] < -least) ||
           (beyond[0] > least && beyond[1] > least) || (before[0] > least && before[1] > least);
}

/// Do edges i and k meet at most where they join, or are they further apart than the reach?
static bool AreEdgesSeparated(const Loop* loop, size_t count, size_t i, size_t k)
{
    if (k == (i + 1) % count || i == (k + 1) % count)
    {
        // An edge that turns back could lie on the one before.
        size_t first = k == (i + 1) % count ? i : k;
        float u = loop->u[first + 1] - loop->u[first], v = loop->v[first + 1] - loop->v[first];
        float nextU = loop->u[first + 2] - loop->u[first + 1], nextV = loop->v[first + 2] - loop->v[first + 1];
        float turn = u * nextV - v * nextU, ahead = u * nextU + v * nextV;
        return turn > loop->least || turn < -loop->least || ahead > loop->least;
    }
    return IsOneSided(loop, i, k) || IsOneSided(loop, k, i);
}

/// Some edges that follow each other, and a box around them.
typedef struct Arc
{
    size_t first, end; ///< edges; the last vertex is `end`
    float lower[2], upper[2];
} Arc;

static bool AreArcsSeparated(const Loop* loop, size_t count, const Arc* a, const Arc* b)
{
    for (size_t i = a->first; i < a->end; i++)
        for (size_t k = b->first; k < b->end; k++)
            if (i != k && !AreEdgesSeparated(loop, count, i, k))
                return false;
    return true;
}

/// Do all edges of two arcs, the one behind the other, go forward in one direction by more than the reach? Then none
/// meets another, and those that don't follow each other are further apart.
static bool AreMonotone(const Loop* loop, const Arc* a, const Arc* b)
{
    float u = loop->u[b->end] - loop->u[a->first], v = loop->v[b->end] - loop->v[a->first];
    float slowest = INFINITY;
    const Arc* arcs[2] = {a, b};
    for (int k = 0; k < 2; k++)
        for (size_t i = arcs[k]->first; i < arcs[k]->end; i++)
        {
            float step = u * (loop->u[i + 1] - loop->u[i]) + v * (loop->v[i + 1] - loop->v[i]);
            slowest = step < slowest ? step : slowest;
        }
    return slowest > MinProductAlong(loop, u, v);
}

static Arc MakeArc(const Loop* loop, size_t first, size_t end)
{
    Arc arc = {first, end, {loop->u[first], loop->v[first]}, {loop->u[first], loop->v[first]}};
    for (size_t i = first + 1; i <= end; i++)
    {
        float at[2] = {loop->u[i], loop->v[i]};
        for (int axis = 0; axis < 2; axis++)
        {
            arc.lower[axis] = at[axis] < arc.lower[axis] ? at[axis] : arc.lower[axis];
            arc.upper[axis] = at[axis] > arc.upper[axis] ? at[axis] : arc.upper[axis];
        }
    }
    return arc;
}

/// Does no edge of the loop meet another but where they join? By arcs of a few edges.
static bool IsSimple(const qcPatchGeometry* patch, const Loop* loop)
{
    size_t count = patch->loopCount, arcCount = (count + qc_arcEdges - 1) / qc_arcEdges;
    float gap = loop->gap + loop->query;
    Arc arcs[qc_maxLoop / qc_arcEdges];
    for (size_t a = 0; a < arcCount; a++)
    {
        size_t first = a * qc_arcEdges, end = first + qc_arcEdges < count ? first + qc_arcEdges : count;
        arcs[a] = MakeArc(loop, first, end);
    }
    for (size_t a = 0; a < arcCount; a++)
    {
        const Arc *arc = &arcs[a], *next = &arcs[(a + 1) % arcCount];
        if (!AreMonotone(loop, arc, next) &&
            !(AreArcsSeparated(loop, count, arc, arc) && AreArcsSeparated(loop, count, arc, next)))
            return false;
        for (size_t b = a + 2; b < arcCount; b++)
        {
            const Arc* other = &arcs[b];
            bool apart = arc->lower[0] > other->upper[0] + gap || other->lower[0] > arc->upper[0] + gap ||
                         arc->lower[1] > other->upper[1] + gap || other->lower[1] > arc->upper[1] + gap;
            if (!apart && (a != 0 || b != arcCount - 1) && !AreArcsSeparated(loop, count, arc, other))
                return false;
        }
    }
    return true;
}

/// Do all triangles face d's way, with altitudes above the reach? Lengths of edges are wrong by up to 4 e.
static bool FacesOneWay(const qcPatchGeometry* patch, const Loop* loop)
{
    for (size_t at = 0; at < patch->slotCount; at += QC_LANES)
    {
        size_t count = patch->slotCount - at < QC_LANES ? patch->slotCount - at : QC_LANES;
        uint32_t id[3][QC_LANES];
        for (size_t lane = 0; lane < QC_LANES; lane++)
        {
            const uint32_t* vertex = patch->corners[patch->slots[at + (lane < count ? lane : 0)]].vertex;
            for (int c = 0; c < 3; c++)
                id[c][lane] = vertex[c];
        }
        Vectors first = LoadPoints(patch->points, id[0]);
        Vectors e = Subtract(LoadPoints(patch->points, id[1]), first);
        Vectors f = Subtract(LoadPoints(patch->points, id[2]), first);
        Vectors cross = Cross(e, f);
        Floats normal[3] = {cross.x, cross.y, cross.z}, size = MaxFloats(MaxAbsolute(e), MaxAbsolute(f));
        Floats facing =
            (normal[loop->axes[0]] * loop->p + normal[loop->axes[1]] * loop->q + normal[loop->axes[2]]) * loop->sign;
        Floats least = size * (32.0f * patch->pointError + 44.0f * 0x1p-24f * size);
        if (SignBits(~(facing > least)) != 0)
            return false;
        if (patch->query > 0.0f)
        {
            Vectors g = Subtract(e, f);
            Floats longest2 = MaxFloats(MaxFloats(Dot(e, e), Dot(f, f)), Dot(g, g));
            Floats more = facing - least - 4.0f * patch->pointError * loop->query;
            if (SignBits(~((more > 1e-15f) & (more * more > loop->query * loop->query * longest2))) != 0)
                return false;
        }
    }
    return true;
}

static bool IsPatchFlat(const qcPatchGeometry* patch)
{
    Loop loop;
    LoadLoop(patch, &loop);
    if (!ChooseDirection(patch->loopCount, &loop))
        return false;
    Project(patch->loopCount, &loop);
    loop.query =
        patch->query > 0.0f ? 1.001f * patch->query * __builtin_sqrtf(1.0f + loop.p * loop.p + loop.q * loop.q) : 0.0f;
    loop.least = (48.0f * patch->pointError + 160.0f * 0x1p-24f) * loop.size;
    loop.gap = 6.0f * patch->pointError + 12.0f * 0x1p-24f;
    return FacesOneWay(patch, &loop) && IsSimple(patch, &loop);
}

#endif
