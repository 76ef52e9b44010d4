// The kernels that compare triangles by separating axes, in single precision: pairs that are proven separate, and pairs
// that are proven to intersect. Proof: plugin/docs/proofs/separating_axis.md.
#ifndef QC_KERNELS_SEPARATING_AXIS_INL_H
#define QC_KERNELS_SEPARATING_AXIS_INL_H

#include "kernels/triangle_kernels.h"

typedef float Floats __attribute__((vector_size(4 * QC_LANES)));
typedef int32_t Ints __attribute__((vector_size(4 * QC_LANES)));

typedef struct Vectors
{
    Floats x, y, z;
} Vectors;

/// QC_LANES pairs: corners relative to the first of A, scaled so that the largest coordinate is in [1, 2).
typedef struct PairLanes
{
    Vectors b, c, d, e, f;
    Floats scale; ///< that of the pair
    Floats error; ///< of a scaled coordinate, before the first corner was subtracted
    Floats gap;   ///< a gap of projections on an axis w proves triangles apart if it exceeds gap |w|_1
    Floats query; ///< the query distance, scaled; such a gap proves more than it if it exceeds gap |w|_1 + query |w|
} PairLanes;

QC_INLINE Vectors LoadPoints(const qcPoint* points, const uint32_t vertex[QC_LANES]);
QC_INLINE uint32_t SignBits(Ints lanes);

QC_INLINE Floats Absolute(Floats a)
{
    return (Floats)((Ints)a & 0x7fffffff);
}

QC_INLINE Vectors Subtract(Vectors a, Vectors b)
{
    return (Vectors){a.x - b.x, a.y - b.y, a.z - b.z};
}

QC_INLINE Vectors Times(Vectors a, Floats s)
{
    return (Vectors){a.x * s, a.y * s, a.z * s};
}

QC_INLINE Vectors Cross(Vectors a, Vectors b)
{
    return (Vectors){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

QC_INLINE Floats Dot(Vectors a, Vectors b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

QC_INLINE Floats MaxAbsolute(Vectors a)
{
    return MaxFloats(MaxFloats(Absolute(a.x), Absolute(a.y)), Absolute(a.z));
}

/// The gap between the projections of the triangles on an axis; not above 0 if they overlap.
QC_INLINE Floats FindGap(const PairLanes* l, Vectors axis)
{
    const Floats zero = {0};
    Floats u = Dot(axis, l->b), v = Dot(axis, l->c), p = Dot(axis, l->d), q = Dot(axis, l->e), r = Dot(axis, l->f);
    return MaxFloats(MinFloats(p, MinFloats(q, r)) - MaxFloats(zero, MaxFloats(u, v)),
                     MinFloats(zero, MinFloats(u, v)) - MaxFloats(p, MaxFloats(q, r)));
}

QC_INLINE Floats SumOfAbsolutes(Vectors a)
{
    return Absolute(a.x) + Absolute(a.y) + Absolute(a.z);
}

/// All bits of a lane where the axis separates.
QC_INLINE Ints Separates(const PairLanes* l, Vectors axis)
{
    Floats gap = FindGap(l, axis);
    return (gap > SumOfAbsolutes(axis) * l->gap) & (gap > 1e-20f);
}

/// All bits of a lane where the axis proves the triangles farther apart than the query distance.
QC_INLINE Ints SeparatesByQuery(const PairLanes* l, Vectors axis)
{
    Floats gap = FindGap(l, axis), length2 = Dot(axis, axis);
    return (gap > SumOfAbsolutes(axis) * l->gap + SquareRoot(length2) * l->query) & (length2 > 1e-30f);
}

QC_INLINE Vectors TransformPoints(const qcDistanceThresholds* thresholds, Vectors p)
{
    if (!thresholds->isTransformed)
        return p;
    Floats x[3];
    for (int i = 0; i < 3; i++)
    {
        const float* row = thresholds->linear[i];
        x[i] = p.x * row[0] + p.y * row[1] + p.z * row[2] + thresholds->shift[i];
    }
    return (Vectors){x[0], x[1], x[2]};
}

/// How many times as large errors are if a coordinate of the six corners exceeds 1, in its own frame.
QC_INLINE Floats FindErrorFactors(const qcIndexedTriangles* a, const qcIndexedTriangles* b, uint32_t id[6][QC_LANES])
{
    Floats size = (Floats){0} + 1.0f;
    for (int c = 0; c < 3; c++)
        size = MaxFloats(
            size, MaxFloats(MaxAbsolute(LoadPoints(a->points, id[c])), MaxAbsolute(LoadPoints(b->points, id[3 + c]))));
    return size * 1.0001f;
}

/// The first QC_LANES pairs; past the end the last one is repeated. `frameA` transforms the points of a; null: they are
/// in the frame already.
QC_INLINE PairLanes LoadFramedPairs(const qcIndexedTriangles* a, const qcDistanceThresholds* frameA,
                                    const qcIndexedTriangles* b, const qcDistanceThresholds* thresholds,
                                    const qcSlotPair* pairs, size_t count)
{
    uint32_t id[6][QC_LANES];
    for (size_t lane = 0; lane < QC_LANES; lane++)
    {
        qcSlotPair pair = pairs[lane < count ? lane : count - 1];
        const uint32_t *p = a->corners[pair.a].vertex, *q = b->corners[pair.b].vertex;
        for (int c = 0; c < 3; c++)
        {
            id[c][lane] = p[c];
            id[3 + c][lane] = q[c];
        }
    }
    Vectors corner[3];
    for (int c = 0; c < 3; c++)
    {
        corner[c] = LoadPoints(a->points, id[c]);
        if (frameA != NULL)
            corner[c] = TransformPoints(frameA, corner[c]);
    }
    Vectors first = corner[0];
    PairLanes l = {.b = Subtract(corner[1], first),
                   .c = Subtract(corner[2], first),
                   .d = Subtract(TransformPoints(thresholds, LoadPoints(b->points, id[3])), first),
                   .e = Subtract(TransformPoints(thresholds, LoadPoints(b->points, id[4])), first),
                   .f = Subtract(TransformPoints(thresholds, LoadPoints(b->points, id[5])), first)};
    Floats size = MaxFloats(MaxFloats(MaxAbsolute(l.b), MaxAbsolute(l.c)),
                            MaxFloats(MaxFloats(MaxAbsolute(l.d), MaxAbsolute(l.e)), MaxAbsolute(l.f)));
    // 2^-k for a size in [2^k, 2^(k+1)), by exponents: exact.
    Floats scale = (Floats)(0x7f000000 - ((Ints)size & 0x7f800000));
    l.b = Times(l.b, scale), l.c = Times(l.c, scale), l.d = Times(l.d, scale), l.e = Times(l.e, scale),
    l.f = Times(l.f, scale);
    l.scale = scale;
    l.error = thresholds->pointError * scale;
    if (thresholds->hasOutliers)
    {
        Floats factor = FindErrorFactors(a, b, id);
        // Beyond, products could overflow: nothing is proven.
        Ints isLarge = factor > QC_MAX_COORDINATE;
        l.error = (Floats)((isLarge & (Ints)((Floats){0} + INFINITY)) | (~isLarge & (Ints)(l.error * factor)));
    }
    l.gap = 4.0f * l.error * 1.0001f + 4e-6f;
    l.query = thresholds->query * scale * 1.0001f;
    return l;
}

QC_INLINE PairLanes LoadPairs(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                              const qcDistanceThresholds* thresholds, const qcSlotPair* pairs, size_t count)
{
    return LoadFramedPairs(a, NULL, b, thresholds, pairs, count);
}

/// The planes of both triangles: they separate most pairs.
QC_INLINE Ints SeparatedByPlane(const PairLanes* l)
{
    return Separates(l, Cross(l->b, l->c)) | Separates(l, Cross(Subtract(l->e, l->d), Subtract(l->f, l->d)));
}

/// Three times the difference of the centroids.
QC_INLINE Vectors FindCentroidDifference(const PairLanes* l)
{
    // The first corner of A is 0.
    Vectors a = {l->b.x + l->c.x, l->b.y + l->c.y, l->b.z + l->c.z};
    Vectors b = {l->d.x + l->e.x + l->f.x, l->d.y + l->e.y + l->f.y, l->d.z + l->e.z + l->f.z};
    return Subtract(b, a);
}

/// The difference of the centroids separates most triangles of one smooth surface that share no vertex, planes most of
/// two layers.
QC_INLINE Ints SeparatedByDistance(const PairLanes* l)
{
    return SeparatesByQuery(l, FindCentroidDifference(l)) | SeparatesByQuery(l, Cross(l->b, l->c)) |
           SeparatesByQuery(l, Cross(Subtract(l->e, l->d), Subtract(l->f, l->d)));
}

/// Normals of edges within the planes: they separate triangles that lie in one plane.
QC_INLINE Ints SeparatedWithinPlane(const PairLanes* l)
{
    Vectors bc = Subtract(l->c, l->b), de = Subtract(l->e, l->d), df = Subtract(l->f, l->d), ef = Subtract(l->f, l->e);
    Vectors n = Cross(l->b, l->c), m = Cross(de, df);
    return Separates(l, Cross(n, l->b)) | Separates(l, Cross(n, l->c)) | Separates(l, Cross(n, bc)) |
           Separates(l, Cross(m, de)) | Separates(l, Cross(m, df)) | Separates(l, Cross(m, ef));
}

/// Cross products of edges; for triangles in one plane also normals of edges within it.
QC_INLINE Ints SeparatedByEdges(const PairLanes* l)
{
    Vectors bc = Subtract(l->c, l->b), de = Subtract(l->e, l->d), df = Subtract(l->f, l->d), ef = Subtract(l->f, l->e);
    Vectors edgeA[3] = {l->b, l->c, bc}, edgeB[3] = {de, df, ef};
    Ints separated = SeparatedWithinPlane(l);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            separated |= Separates(l, Cross(edgeA[i], edgeB[j]));
    return separated;
}

typedef Ints Separated(const PairLanes* l);

QC_INLINE size_t KeepUnseparated(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                                 const qcDistanceThresholds* thresholds, qcSlotPair* pairs, size_t count,
                                 Separated* separated)
{
    size_t kept = 0;
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        PairLanes lanes = LoadPairs(a, b, thresholds, pairs + at, left);
        uint32_t stay = ~SignBits(separated(&lanes)) & (uint32_t)((UINT64_C(1) << left) - 1);
        for (; stay != 0; stay &= stay - 1)
            pairs[kept++] = pairs[at + (size_t)__builtin_ctz(stay)];
    }
    return kept;
}

static size_t Filter(const qcIndexedTriangles* a, const qcIndexedTriangles* b, const qcDistanceThresholds* thresholds,
                     qcSlotPair* pairs, size_t count)
{
    // The distance of the rest is computed (kernels/triangle_distance.inl.h), which takes no longer than more axes
    // would.
    if (thresholds->query > 0.0f)
        return KeepUnseparated(a, b, thresholds, pairs, count, SeparatedByDistance);
    return KeepUnseparated(a, b, thresholds, pairs, count, SeparatedByPlane);
}

//  ---- proven intersections ------------------------------------------------------------------------

/// The proven sign of a determinant, by lane.
typedef struct Signs
{
    Ints above, below;
} Signs;

/// The sign of u . (v x w). Each vector is wrong by at most `error` in each coordinate.
QC_INLINE Signs SignOf(Vectors u, Vectors v, Vectors w, Floats error)
{
    Vectors vw = Cross(v, w);
    Floats x = Dot(u, vw);
    Floats size = SumOfAbsolutes(vw) + SumOfAbsolutes(Cross(w, u)) + SumOfAbsolutes(Cross(u, v));
    Floats maxError = error * (1.001f * size + 100.0f * error) + 1.2e-4f;
    return (Signs){x > maxError, x < -maxError};
}

QC_INLINE Ints HaveSameSign(Signs a, Signs b, Signs c)
{
    return (a.above & b.above & c.above) | (a.below & b.below & c.below);
}

QC_INLINE Ints HaveOppositeSigns(Signs a, Signs b)
{
    return (a.above & b.below) | (a.below & b.above);
}

/// An edge of one triangle passes through the interior of the other: from one side of its plane to the other, on the
/// same side of all three edges.
QC_INLINE Ints Intersects(const PairLanes* l)
{
    const Floats zero = {0};
    const Vectors origin = {zero, zero, zero};
    Floats error = 4.0f * l->error + 3.0f * 0x1p-22f;
    Vectors a[3] = {origin, l->b, l->c}, b[3] = {l->d, l->e, l->f};
    Vectors de = Subtract(l->e, l->d), df = Subtract(l->f, l->d);
    Signs ofA[3], ofB[3], side[3][3];
    for (int i = 0; i < 3; i++)
    {
        ofA[i] = SignOf(Subtract(a[i], l->d), de, df, error);
        ofB[i] = SignOf(b[i], l->b, l->c, error);
        // On which side an edge's line passes an edge of the other triangle.
        for (int k = 0; k < 3; k++)
            side[i][k] =
                SignOf(Subtract(a[(i + 1) % 3], a[i]), Subtract(b[k], a[i]), Subtract(b[(k + 1) % 3], a[i]), error);
    }
    Ints pierces = {0};
    for (int i = 0; i < 3; i++)
    {
        pierces |= HaveSameSign(side[0][i], side[1][i], side[2][i]) & HaveOppositeSigns(ofB[i], ofB[(i + 1) % 3]);
        pierces |= HaveSameSign(side[i][0], side[i][1], side[i][2]) & HaveOppositeSigns(ofA[i], ofA[(i + 1) % 3]);
    }
    return pierces;
}

static size_t FindIntersecting(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                               const qcDistanceThresholds* thresholds, qcSlotPair* pairs, size_t count)
{
    size_t found = 0;
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        PairLanes lanes = LoadPairs(a, b, thresholds, pairs + at, left);
        uint32_t hits = SignBits(Intersects(&lanes)) & (uint32_t)((UINT64_C(1) << left) - 1);
        for (; hits != 0; hits &= hits - 1)
        {
            size_t i = at + (size_t)__builtin_ctz(hits);
            qcSlotPair pair = pairs[i];
            pairs[i] = pairs[found];
            pairs[found++] = pair;
        }
    }
    return found;
}

#endif
