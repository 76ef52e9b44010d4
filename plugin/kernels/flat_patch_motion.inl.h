// The kernel that proves flat patches free of self-contact over a linear motion: seen along one direction d, at every
// time all triangles face one way and the loop is a simple curve. Areas are quadratic in time: their Bernstein
// coefficients are positive. Proof: plugin/docs/proofs/motion_sweep.md.
#ifndef QC_KERNELS_FLAT_PATCH_MOTION_INL_H
#define QC_KERNELS_FLAT_PATCH_MOTION_INL_H

#include "kernels/flat_patch_test.inl.h"

/// The loop at the start and at the end, projected along one direction.
typedef struct MovingLoop
{
    const Loop* at[2];
    size_t count;
} MovingLoop;

QC_INLINE float Greater(float a, float b)
{
    return a > b ? a : b;
}

QC_INLINE float Less(float a, float b)
{
    return a < b ? a : b;
}

/// Products of (u, v) with two vertices, or with a difference of vertices, are wrong by their errors, by rounding, and
/// where they underflow.
QC_INLINE float MinProjectedGap(const Loop* loop, float u, float v)
{
    return (__builtin_fabsf(u) + __builtin_fabsf(v)) * (2.0f * loop->coordinateError + 0x1p-20f * loop->size) + 1e-30f;
}

/// The vertices from a to endA and those from b to endB leave a gap along (u, v), in the same order at both ends.
QC_INLINE bool DirectionSeparates(const MovingLoop* loop, float u, float v, size_t a, size_t endA, size_t b,
                                  size_t endB)
{
    bool above = true, below = true;
    for (int t = 0; t < 2; t++)
    {
        const Loop* l = loop->at[t];
        float lowA = INFINITY, highA = -INFINITY, lowB = INFINITY, highB = -INFINITY;
        for (size_t i = a; i <= endA; i++)
        {
            float at = u * l->u[i] + v * l->v[i];
            lowA = Less(at, lowA), highA = Greater(at, highA);
        }
        for (size_t i = b; i <= endB; i++)
        {
            float at = u * l->u[i] + v * l->v[i];
            lowB = Less(at, lowB), highB = Greater(at, highB);
        }
        float gap = MinProjectedGap(l, u, v);
        above = above && lowA - highB > gap;
        below = below && lowB - highA > gap;
    }
    return above || below;
}

/// The turn from edge i to the next keeps its sign over the motion, or the next edge always goes ahead.
static bool KeepsTurning(const MovingLoop* loop, size_t i)
{
    float u[2], v[2], nextU[2], nextV[2];
    for (int t = 0; t < 2; t++)
    {
        const Loop* l = loop->at[t];
        u[t] = l->u[i + 1] - l->u[i], v[t] = l->v[i + 1] - l->v[i];
        nextU[t] = l->u[i + 2] - l->u[i + 1], nextV[t] = l->v[i + 2] - l->v[i + 1];
    }
    float error = Greater(loop->at[0]->productError, loop->at[1]->productError) +
                  Greater(loop->at[0]->size, loop->at[1]->size) *
                      (16.0f * Greater(loop->at[0]->coordinateError, loop->at[1]->coordinateError));
    bool left = true, right = true, ahead = true;
    const int first[3] = {0, 0, 1}, second[3] = {0, 1, 1};
    for (int c = 0; c < 3; c++)
    {
        int s = first[c], t = second[c];
        // The middle coefficient is the mean of both mixed products.
        float turn = 0.5f * (u[s] * nextV[t] - v[s] * nextU[t] + u[t] * nextV[s] - v[t] * nextU[s]);
        float forward = 0.5f * (u[s] * nextU[t] + v[s] * nextV[t] + u[t] * nextU[s] + v[t] * nextV[s]);
        left = left && turn > error;
        right = right && turn < -error;
        ahead = ahead && forward > error;
    }
    return left || right || ahead;
}

/// Edges i and k share a vertex and no other point at any time, or have no common point.
static bool AreEdgesApart(const MovingLoop* loop, size_t i, size_t k)
{
    if (k == (i + 1) % loop->count)
        return KeepsTurning(loop, i);
    if (i == (k + 1) % loop->count)
        return KeepsTurning(loop, k);
    for (int t = 0; t < 2; t++)
        for (int side = 0; side < 2; side++)
        {
            const Loop* l = loop->at[t];
            size_t e = side == 0 ? i : k;
            float u = l->u[e + 1] - l->u[e], v = l->v[e + 1] - l->v[e];
            if (DirectionSeparates(loop, -v, u, i, i + 1, k, k + 1) ||
                DirectionSeparates(loop, u, v, i, i + 1, k, k + 1))
                return true;
        }
    return false;
}

static bool AreMovingArcsApart(const MovingLoop* loop, const Arc* a, const Arc* b)
{
    for (size_t i = a->first; i < a->end; i++)
        for (size_t k = b->first; k < b->end; k++)
            if (i != k && !AreEdgesApart(loop, i, k))
                return false;
    return true;
}

/// All edges of two consecutive arcs advance in one direction at both ends, and so at every time.
static bool StayMonotone(const MovingLoop* loop, const Arc* a, const Arc* b)
{
    const Arc* arcs[2] = {a, b};
    const Loop *start = loop->at[0], *end = loop->at[1];
    float u = start->u[b->end] - start->u[a->first] + end->u[b->end] - end->u[a->first];
    float v = start->v[b->end] - start->v[a->first] + end->v[b->end] - end->v[a->first];
    for (int t = 0; t < 2; t++)
    {
        const Loop* l = loop->at[t];
        float minStep = MinProjectedGap(l, u, v);
        for (int n = 0; n < 2; n++)
            for (size_t i = arcs[n]->first; i < arcs[n]->end; i++)
                if (!(u * (l->u[i + 1] - l->u[i]) + v * (l->v[i + 1] - l->v[i]) > minStep))
                    return false;
    }
    return true;
}

/// The direction between the middles of two arcs separates them.
static bool DoMiddlesSeparate(const MovingLoop* loop, const Arc* a, const Arc* b)
{
    float u = 0.0f, v = 0.0f;
    for (int t = 0; t < 2; t++)
    {
        const Loop* l = loop->at[t];
        u += l->u[a->first] + l->u[a->end] - l->u[b->first] - l->u[b->end];
        v += l->v[a->first] + l->v[a->end] - l->v[b->first] - l->v[b->end];
    }
    return DirectionSeparates(loop, u, v, a->first, a->end, b->first, b->end);
}

/// The boxes of two arcs are apart along one axis in the same order at both ends.
static bool AreArcBoxesApart(const MovingLoop* loop, const Arc* const a[2], const Arc* const b[2])
{
    for (int axis = 0; axis < 2; axis++)
    {
        bool above = true, below = true;
        for (int t = 0; t < 2; t++)
        {
            float gap = loop->at[t]->coordinateError;
            above = above && a[t]->lower[axis] > b[t]->upper[axis] + gap;
            below = below && b[t]->lower[axis] > a[t]->upper[axis] + gap;
        }
        if (above || below)
            return true;
    }
    return false;
}

static bool StaysSimple(const MovingLoop* loop)
{
    size_t count = loop->count, arcCount = (count + qc_arcEdges - 1) / qc_arcEdges;
    Arc arcs[2][qc_maxLoop / qc_arcEdges];
    for (int t = 0; t < 2; t++)
        for (size_t a = 0; a < arcCount; a++)
        {
            size_t first = a * qc_arcEdges, end = first + qc_arcEdges < count ? first + qc_arcEdges : count;
            arcs[t][a] = MakeArc(loop->at[t], first, end);
        }
    for (size_t a = 0; a < arcCount; a++)
    {
        const Arc *arc = &arcs[0][a], *next = &arcs[0][(a + 1) % arcCount];
        if (!StayMonotone(loop, arc, next) &&
            !(AreMovingArcsApart(loop, arc, arc) && AreMovingArcsApart(loop, arc, next)))
            return false;
        for (size_t b = a + 2; b < arcCount; b++)
        {
            if (a == 0 && b == arcCount - 1)
                continue;
            const Arc *const ofA[2] = {&arcs[0][a], &arcs[1][a]}, *const ofB[2] = {&arcs[0][b], &arcs[1][b]};
            if (!AreArcBoxesApart(loop, ofA, ofB) && !DoMiddlesSeparate(loop, arc, &arcs[0][b]) &&
                !AreMovingArcsApart(loop, arc, &arcs[0][b]))
                return false;
        }
    }
    return true;
}

/// Two edges of QC_LANES triangles, projected along the direction of the loop.
typedef struct ProjectedEdges
{
    Floats u[2], v[2];
    Floats size; ///< the largest coordinate of the edges in space
} ProjectedEdges;

QC_INLINE ProjectedEdges ProjectEdges(const qcPoint* points, uint32_t id[3][QC_LANES], float scale, const Loop* loop)
{
    Vectors corner = LoadPoints(points, id[0]);
    const Floats zero = {0};
    ProjectedEdges made = {.size = zero};
    for (int k = 0; k < 2; k++)
    {
        Vectors e = Times(Subtract(LoadPoints(points, id[k + 1]), corner), zero + scale);
        const Floats of[3] = {e.x, e.y, e.z};
        made.u[k] = of[loop->axes[0]] - loop->p * of[loop->axes[2]];
        made.v[k] = of[loop->axes[1]] - loop->q * of[loop->axes[2]];
        made.size = MaxFloats(made.size, MaxAbsolute(e));
    }
    return made;
}

/// The Bernstein coefficients of the areas, seen along the direction, are positive.
QC_INLINE Ints FacesForward(const ProjectedEdges* a, const ProjectedEdges* b, float sign, float pointError)
{
    Floats size = MaxFloats(a->size, b->size), rounding = size * (64.0f * pointError + 96.0f * 0x1p-24f * size);
    Floats start = a->u[0] * a->v[1] - a->v[0] * a->u[1], end = b->u[0] * b->v[1] - b->v[0] * b->u[1];
    Floats middle = 0.5f * ((a->u[0] * b->v[1] - a->v[0] * b->u[1]) + (b->u[0] * a->v[1] - b->v[0] * a->u[1]));
    return (start * sign > rounding) & (middle * sign > rounding) & (end * sign > rounding);
}

static bool FacesOneWayInMotion(const qcPatchGeometry patches[2], const float scales[2], const Loop* loop)
{
    float pointError = Greater(patches[0].pointError * scales[0], patches[1].pointError * scales[1]);
    for (size_t at = 0; at < patches[0].slotCount; at += QC_LANES)
    {
        uint32_t id[3][QC_LANES];
        ListCorners(&patches[0], at, id);
        ProjectedEdges a = ProjectEdges(patches[0].points, id, scales[0], loop),
                       b = ProjectEdges(patches[1].points, id, scales[1], loop);
        if (SignBits(~FacesForward(&a, &b, loop->sign, pointError)) != 0)
            return false;
    }
    return true;
}

/// Gives the loop the direction of another one.
static void TakeDirection(const Loop* from, Loop* loop)
{
    memcpy(loop->axes, from->axes, sizeof loop->axes);
    loop->p = from->p;
    loop->q = from->q;
    loop->sign = from->sign;
}

static void ScaleLoop(size_t count, float scale, Loop* loop)
{
    for (int axis = 0; axis < 3; axis++)
        for (size_t i = 0; i < count + QC_LANES; i++)
            loop->x[axis][i] *= scale;
}

static bool IsPatchFlatInMotion(const qcPatchGeometry patches[2], const float scales[2])
{
    Loop loops[2];
    size_t count = patches[0].loopCount;
    for (int t = 0; t < 2; t++)
    {
        LoadLoop(&patches[t], &loops[t]);
        if (scales[t] != 1.0f)
            ScaleLoop(count, scales[t], &loops[t]);
    }
    if (!ChooseDirection(count, &loops[0]))
        return false;
    TakeDirection(&loops[0], &loops[1]);
    for (int t = 0; t < 2; t++)
    {
        float pointError = patches[t].pointError * scales[t];
        Project(count, &loops[t]);
        loops[t].query = 0.0f;
        loops[t].productError = (48.0f * pointError + 160.0f * 0x1p-24f) * loops[t].size;
        loops[t].coordinateError = 6.0f * pointError + 12.0f * 0x1p-24f;
    }
    const MovingLoop loop = {{&loops[0], &loops[1]}, count};
    return FacesOneWayInMotion(patches, scales, &loops[0]) && StaysSimple(&loop);
}

#endif
