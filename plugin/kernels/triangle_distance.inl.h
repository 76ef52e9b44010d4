// The kernel that measures how far apart triangles are, in single precision: what is surely near, and what surely
// farther than the reach.
//
// The shortest of fifteen differences w of points, one of A and one of B, is looked for: between each two edges, and
// between corners and the insides of faces. However badly it was chosen, it tells two things.
// - Its points are in A and in B: weights are clamped, or checked, before they are used. So A and B are no further
//   apart than w is long. Each of its coordinates is wrong by at most 4 e s + 8e-6: corners, relative to the first, are
//   wrong by 2 e s + 2^-22 each (kernels/separating_axis.inl.h); a dozen roundings of numbers below 8 are the rest, and
//   weights that add up to a little more than 1. The kernel asks for |w| below 0.9999 m s less twice that, for a margin
//   m.
// - It is a direction: where the projections of A and B on it leave a gap, they are apart by the gap over |w|. The
//   rounding of the gap is that of the filter: |w|_1 (4 e s + 2.9e-6).
// What is apart and within the margin is near; what is apart by more than the reach is dropped.
#ifndef QC_KERNELS_TRIANGLE_DISTANCE_INL_H
#define QC_KERNELS_TRIANGLE_DISTANCE_INL_H

#include "kernels/separating_axis.inl.h"

/// The shortest difference so far, of a point of A and one of B.
typedef struct Difference
{
    Vectors w;
    Floats length2;
} Difference;

QC_INLINE Floats Select(Ints mask, Floats yes, Floats no)
{
    return (Floats)(((Ints)yes & mask) | ((Ints)no & ~mask));
}

QC_INLINE Floats ClampToUnit(Floats x)
{
    const Floats zero = {0}, one = zero + 1.0f;
    return MaxFloats(zero, MinFloats(one, x));
}

QC_INLINE Vectors AddScaled(Vectors a, Vectors b, Floats s)
{
    return (Vectors){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

/// What is no number is never chosen.
QC_INLINE void KeepShorter(Difference* best, Vectors w, Ints allowed)
{
    Floats length2 = Dot(w, w);
    Ints shorter = (length2 < best->length2) & allowed;
    best->w.x = Select(shorter, w.x, best->w.x);
    best->w.y = Select(shorter, w.y, best->w.y);
    best->w.z = Select(shorter, w.z, best->w.z);
    best->length2 = Select(shorter, length2, best->length2);
}

/// Segments p + s along and q + t across. (Ericson: Real-Time Collision Detection, 2005, 5.1.9.)
QC_INLINE void TestSegments(Difference* best, Vectors p, Vectors along, Floats along2, Vectors q, Vectors across,
                            Floats across2)
{
    const Floats zero = {0};
    Vectors r = Subtract(p, q);
    Floats b = Dot(along, across), c = Dot(along, r), f = Dot(across, r);
    Floats s = ClampToUnit((b * f - c * across2) / MaxFloats(along2 * across2 - b * b, zero + 1e-30f));
    Floats t = ClampToUnit((b * s + f) / across2);
    s = ClampToUnit((b * t - c) / along2);
    KeepShorter(best, AddScaled(AddScaled(r, along, s), across, -t), (Ints)zero == 0);
}

/// The foot of a point on a face, where it is inside. `sign`: 1, the point is of A; -1, of B.
QC_INLINE void TestFoot(Difference* best, Vectors point, Vectors u, Vectors v, Vectors normal, Floats normal2,
                        float sign)
{
    const Floats zero = {0};
    Floats s = Dot(Cross(point, v), normal), t = Dot(Cross(u, point), normal);
    Ints inside = (s >= zero) & (t >= zero) & (s + t <= normal2) & (normal2 > 1e-20f);
    Vectors w = AddScaled(AddScaled(point, u, -s / normal2), v, -t / normal2);
    KeepShorter(best, Times(w, zero + sign), inside);
}

QC_INLINE Vectors FindShortest(const Lanes* l, Floats* length2)
{
    const Floats zero = {0};
    const Vectors origin = {zero, zero, zero};
    Vectors p[3] = {origin, l->b, l->c}, q[3] = {l->d, l->e, l->f}, along[3], across[3];
    Floats along2[3], across2[3];
    for (int i = 0; i < 3; i++)
    {
        along[i] = Subtract(p[(i + 1) % 3], p[i]);
        across[i] = Subtract(q[(i + 1) % 3], q[i]);
        along2[i] = Dot(along[i], along[i]);
        across2[i] = Dot(across[i], across[i]);
    }
    Difference best = {origin, zero + INFINITY};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            TestSegments(&best, p[i], along[i], along2[i], q[k], across[k], across2[k]);
    Vectors df = Subtract(l->f, l->d), n = Cross(l->b, l->c), m = Cross(across[0], df);
    Floats n2 = Dot(n, n), m2 = Dot(m, m);
    for (int i = 0; i < 3; i++)
    {
        TestFoot(&best, q[i], l->b, l->c, n, n2, -1.0f);
        TestFoot(&best, Subtract(p[i], l->d), across[0], df, m, m2, 1.0f);
    }
    *length2 = best.length2;
    return best.w;
}

/// Where they are surely disjoint and no further apart than the margin, where surely further, where further than the
/// reach.
typedef struct Classes
{
    Ints near, apart, far;
} Classes;

/// Are things apart by more than a distance that leave a gap along a vector?
QC_INLINE Ints IsGapAbove(Floats gap, Floats distance, Floats length2)
{
    const Floats zero = {0};
    // Below 1e-30 products may have vanished.
    return (gap * gap > distance * distance * length2 * 1.0001f) & (gap * gap > zero + 1e-30f);
}

QC_INLINE Classes ClassifyLanes(const Lanes* l, const qcDistanceThresholds* bound)
{
    const Floats zero = {0};
    Floats length2;
    Vectors w = FindShortest(l, &length2);
    // s is error / e.
    Floats up = l->up, rounding = 4.0f * 1.0001f * l->error;
    Floats u = Dot(w, l->b), v = Dot(w, l->c), p = Dot(w, l->d), q = Dot(w, l->e), r = Dot(w, l->f);
    Floats above = MinFloats(p, MinFloats(q, r)) - MaxFloats(zero, MaxFloats(u, v));
    Floats below = MinFloats(zero, MinFloats(u, v)) - MaxFloats(p, MaxFloats(q, r));
    Floats gap = MaxFloats(above, below) - SumOfAbsolutes(w) * (rounding + 4e-6f);
    Ints disjoint = (gap > zero) & (MaxFloats(above, below) > 1e-20f);
    Floats most = bound->near * up * 0.9999f - 2.0f * (rounding + 8e-6f);
    return (Classes){disjoint & (most > zero) & (length2 < most * most),
                     disjoint & (zero + bound->near >= zero) & IsGapAbove(gap, bound->far * up * 1.0002f, length2),
                     disjoint & IsGapAbove(gap, bound->query * up * 1.0001f, length2)};
}

/// Behind those of its kind. The first of each kind that follows moves to that one's end.
QC_INLINE void Insert(qcSlotPair* pairs, qcSlotPair pair, bool isNear, bool isApart, qcClassifiedCounts* counts)
{
    size_t beforeRest = counts->nearCount + counts->separateCount;
    if (isNear || isApart)
        pairs[counts->count] = pairs[beforeRest];
    if (isNear)
        pairs[beforeRest] = pairs[counts->nearCount];
    pairs[isNear ? counts->nearCount : isApart ? beforeRest : counts->count] = pair;
    counts->nearCount += isNear;
    counts->separateCount += !isNear && isApart;
    counts->count++;
}

static qcClassifiedCounts Classify(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                                   const qcDistanceThresholds* bound, qcSlotPair* pairs, size_t count)
{
    qcClassifiedCounts counts = {0, 0, 0};
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        Lanes lanes = LoadLanes(a, b, bound, pairs + at, left);
        Classes apart = ClassifyLanes(&lanes, bound);
        uint32_t isNear = SignBits(apart.near), isApart = SignBits(apart.apart);
        uint32_t stay = ~SignBits(apart.far) & (uint32_t)((UINT64_C(1) << left) - 1);
        for (; stay != 0; stay &= stay - 1)
        {
            uint32_t lane = (uint32_t)__builtin_ctz(stay);
            Insert(pairs, pairs[at + lane], (isNear >> lane & 1u) != 0, (isApart >> lane & 1u) != 0, &counts);
        }
    }
    return counts;
}

#endif
