// The kernel that proves flat patches free of self-contact within the query distance, by their normals and their
// contour (the boundary loop) together: seen along one direction d, all triangles face one way and the loop is a simple
// curve. Proof: plugin/docs/proofs/flat_patch_test.md.
#ifndef QC_KERNELS_FLAT_PATCH_TEST_INL_H
#define QC_KERNELS_FLAT_PATCH_TEST_INL_H

#include "kernels/separating_axis.inl.h"

enum
{
    qc_arcEdges = 4
};

/// The boundary loop of a patch, relative to its centre, projected along d = (p, q, 1) in some order of the axes.
typedef struct Loop
{
    float u[qc_maxLoop + 2 * QC_LANES], v[qc_maxLoop + 2 * QC_LANES];
    float x[3][qc_maxLoop + 2 * QC_LANES];
    int axes[3]; ///< the axes of p, q and 1
    float p, q;
    float sign;  ///< of the last axis in the direction that the patch faces
    float size;  ///< the largest |u| or |v|
    float query; ///< the query distance in the image
    //  Max rounding errors in comparisons.
    float productError; ///< of products of two lengths
    float coordinateError;
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

/// Loads the loop. Past its end it is repeated from the beginning.
static void LoadLoop(const qcPatchGeometry* patch, Loop* loop)
{
    size_t count = patch->loopCount;
    uint32_t id[qc_maxLoop + 2 * QC_LANES];
    memcpy(id, patch->loop, count * sizeof id[0]);
    for (size_t i = count; i < count + 2 * QC_LANES; i++)
        id[i] = id[i - count];
    const float* first = patch->points[id[0]].x;
    const float* opposite = patch->points[id[count / 2]].x;
    Floats at[3] = {{0}};
    for (int axis = 0; axis < 3; axis++)
        at[axis] += 0.5f * (first[axis] + opposite[axis]);
    for (size_t i = 0; i < count + QC_LANES; i += QC_LANES)
    {
        Vectors point = LoadPoints(patch->points, id + i);
        StoreFloats(loop->x[0] + i, point.x - at[0]);
        StoreFloats(loop->x[1] + i, point.y - at[1]);
        StoreFloats(loop->x[2] + i, point.z - at[2]);
    }
}

/// The patch faces along the area vector of its loop. False: the area is 0.
static bool ChooseDirection(size_t count, Loop* loop)
{
    float area[3];
    Ints lanes;
    for (int lane = 0; lane < QC_LANES; lane++)
        lanes[lane] = lane;
    for (int axis = 0; axis < 3; axis++)
    {
        const float *y = loop->x[(axis + 1) % 3], *z = loop->x[(axis + 2) % 3];
        Floats sum = {0};
        for (size_t i = 0; i < count; i += QC_LANES)
        {
            Floats products = LoadFloats(y + i) * LoadFloats(z + i + 1) - LoadFloats(z + i) * LoadFloats(y + i + 1);
            sum += (Floats)((Ints)products & (lanes < (int32_t)(count - i)));
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

/// Projects the loop along d.
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

/// A product of a length along (u, v) and a distance proves the distance above the query distance if it exceeds this.
static float MinProductAlong(const Loop* loop, float u, float v)
{
    // Without a query distance no root is computed.
    return loop->query > 0.0f
               ? loop->productError + loop->query * (__builtin_sqrtf(u * u + v * v) + loop->coordinateError)
               : loop->productError;
}

/// Both ends of edge k are proven farther than the query distance from edge i, on the same side: of the line through
/// it, or of one of the two lines perpendicular to it at its ends.
static bool IsOneSided(const Loop* loop, size_t i, size_t k)
{
    float u = loop->u[i], v = loop->v[i], endU = loop->u[i + 1], endV = loop->v[i + 1];
    float alongU = endU - u, alongV = endV - v, left[2], ahead[2], behind[2];
    float minProduct = MinProductAlong(loop, alongU, alongV);
    for (size_t end = 0; end < 2; end++)
    {
        float otherU = loop->u[k + end], otherV = loop->v[k + end];
        left[end] = alongU * (otherV - v) - alongV * (otherU - u);
        ahead[end] = alongU * (otherU - endU) + alongV * (otherV - endV);
        behind[end] = alongU * (u - otherU) + alongV * (v - otherV);
    }
    return (left[0] > minProduct && left[1] > minProduct) || (left[0] < -minProduct && left[1] < -minProduct) ||
           (ahead[0] > minProduct && ahead[1] > minProduct) || (behind[0] > minProduct && behind[1] > minProduct);
}

/// Edges i and k share a vertex and no other point, or are farther apart than the query distance.
static bool AreEdgesSeparated(const Loop* loop, size_t count, size_t i, size_t k)
{
    if (k == (i + 1) % count || i == (k + 1) % count)
    {
        // An edge that turns back could lie on the previous one.
        size_t first = k == (i + 1) % count ? i : k;
        float u = loop->u[first + 1] - loop->u[first], v = loop->v[first + 1] - loop->v[first];
        float nextU = loop->u[first + 2] - loop->u[first + 1], nextV = loop->v[first + 2] - loop->v[first + 1];
        float turn = u * nextV - v * nextU, ahead = u * nextU + v * nextV;
        return turn > loop->productError || turn < -loop->productError || ahead > loop->productError;
    }
    return IsOneSided(loop, i, k) || IsOneSided(loop, k, i);
}

/// Consecutive edges, and the box around them.
typedef struct Arc
{
    size_t first, end; ///< edges; the last vertex has index `end`
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

/// Two consecutive arcs form a monotone chain: all edges advance in one direction by more than the query distance. Then
/// they meet only at common vertices, and edges without one are farther apart.
static bool AreMonotone(const Loop* loop, const Arc* a, const Arc* b)
{
    float u = loop->u[b->end] - loop->u[a->first], v = loop->v[b->end] - loop->v[a->first];
    float minStep = INFINITY;
    const Arc* arcs[2] = {a, b};
    for (int k = 0; k < 2; k++)
        for (size_t i = arcs[k]->first; i < arcs[k]->end; i++)
        {
            float step = u * (loop->u[i + 1] - loop->u[i]) + v * (loop->v[i + 1] - loop->v[i]);
            minStep = step < minStep ? step : minStep;
        }
    return minStep > MinProductAlong(loop, u, v);
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

/// No two edges of the loop meet except at a common vertex. Tested by arcs of a few edges.
static bool IsSimple(const qcPatchGeometry* patch, const Loop* loop)
{
    size_t count = patch->loopCount, arcCount = (count + qc_arcEdges - 1) / qc_arcEdges;
    float gap = loop->coordinateError + loop->query;
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
            bool separated = arc->lower[0] > other->upper[0] + gap || other->lower[0] > arc->upper[0] + gap ||
                             arc->lower[1] > other->upper[1] + gap || other->lower[1] > arc->upper[1] + gap;
            if (!separated && (a != 0 || b != arcCount - 1) && !AreArcsSeparated(loop, count, arc, other))
                return false;
        }
    }
    return true;
}

/// Lists the vertices of QC_LANES triangles of a patch from number `at` on, by corner; behind the last one the first of
/// them again.
QC_INLINE void ListCorners(const qcPatchGeometry* patch, size_t at, uint32_t id[3][QC_LANES])
{
    size_t count = patch->slotCount - at < QC_LANES ? patch->slotCount - at : QC_LANES;
    for (size_t lane = 0; lane < QC_LANES; lane++)
    {
        const uint32_t* vertex = patch->corners[patch->slots[at + (lane < count ? lane : 0)]].vertex;
        for (int c = 0; c < 3; c++)
            id[c][lane] = vertex[c];
    }
}

/// All triangles face along d, with altitudes above the query distance. Lengths of edges are wrong by up to 4 e.
static bool FacesOneWay(const qcPatchGeometry* patch, const Loop* loop)
{
    for (size_t at = 0; at < patch->slotCount; at += QC_LANES)
    {
        uint32_t id[3][QC_LANES];
        ListCorners(patch, at, id);
        Vectors first = LoadPoints(patch->points, id[0]);
        Vectors e = Subtract(LoadPoints(patch->points, id[1]), first);
        Vectors f = Subtract(LoadPoints(patch->points, id[2]), first);
        Vectors cross = Cross(e, f);
        Floats normal[3] = {cross.x, cross.y, cross.z}, size = MaxFloats(MaxAbsolute(e), MaxAbsolute(f));
        Floats facing =
            (normal[loop->axes[0]] * loop->p + normal[loop->axes[1]] * loop->q + normal[loop->axes[2]]) * loop->sign;
        Floats rounding = size * (32.0f * patch->pointError + 44.0f * 0x1p-24f * size);
        if (SignBits(~(facing > rounding)) != 0)
            return false;
        if (patch->query > 0.0f)
        {
            Vectors g = Subtract(e, f);
            Floats longest2 = MaxFloats(MaxFloats(Dot(e, e), Dot(f, f)), Dot(g, g));
            Floats more = facing - rounding - 4.0f * patch->pointError * loop->query;
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
    loop.productError = (48.0f * patch->pointError + 160.0f * 0x1p-24f) * loop.size;
    loop.coordinateError = 6.0f * patch->pointError + 12.0f * 0x1p-24f;
    return FacesOneWay(patch, &loop) && IsSimple(patch, &loop);
}

#endif
