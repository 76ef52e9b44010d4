// The kernel that classifies pairs by distance, in single precision: proven near, proven separate, proven farther apart
// than the query distance. Proof: plugin/docs/proofs/triangle_distance.md.
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

/// Takes w if it is shorter. NaN is never shorter.
QC_INLINE void KeepShorter(Difference* best, Vectors w, Ints allowed)
{
    Floats length2 = Dot(w, w);
    Ints shorter = (length2 < best->length2) & allowed;
    best->w.x = Select(shorter, w.x, best->w.x);
    best->w.y = Select(shorter, w.y, best->w.y);
    best->w.z = Select(shorter, w.z, best->w.z);
    best->length2 = Select(shorter, length2, best->length2);
}

/// The shortest difference of two segments, p + s along and q + t across. (Ericson: Real-Time Collision Detection,
/// 2005, 5.1.9.)
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

/// From a point to its foot on a face, if the foot is inside. `sign`: 1 for a point of A, -1 for one of B.
QC_INLINE void TestFoot(Difference* best, Vectors point, Vectors u, Vectors v, Vectors normal, Floats normal2,
                        float sign)
{
    const Floats zero = {0};
    Floats s = Dot(Cross(point, v), normal), t = Dot(Cross(u, point), normal);
    Ints inside = (s >= zero) & (t >= zero) & (s + t <= normal2) & (normal2 > 1e-20f);
    Vectors w = AddScaled(AddScaled(point, u, -s / normal2), v, -t / normal2);
    KeepShorter(best, Times(w, zero + sign), inside);
}

QC_INLINE Vectors FindShortest(const PairLanes* l, Floats* length2)
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

/// The proven classes of pairs, by lane: near, separate, beyond the query distance.
typedef struct Classes
{
    Ints near, separate, dropped;
} Classes;

/// A gap along a vector of squared length `length2` proves a distance above `distance`.
QC_INLINE Ints IsGapAbove(Floats gap, Floats distance, Floats length2)
{
    const Floats zero = {0};
    // Below 1e-30 products may have underflowed.
    return (gap * gap > distance * distance * length2 * 1.0001f) & (gap * gap > zero + 1e-30f);
}

QC_INLINE Classes ClassifyLanes(const PairLanes* l, const qcDistanceThresholds* thresholds)
{
    const Floats zero = {0};
    Floats length2;
    Vectors w = FindShortest(l, &length2);
    Floats scale = l->scale, rounding = 4.0f * 1.0001f * l->error;
    Floats projected = FindGap(l, w), gap = projected - SumOfAbsolutes(w) * (rounding + 4e-6f);
    Ints disjoint = (gap > zero) & (projected > 1e-20f);
    Floats maxLength = thresholds->near * scale * 0.9999f - 2.0f * (rounding + 8e-6f);
    return (Classes){disjoint & (maxLength > zero) & (length2 < maxLength * maxLength),
                     disjoint & (zero + thresholds->near >= zero) &
                         IsGapAbove(gap, thresholds->far * scale * 1.0002f, length2),
                     disjoint & IsGapAbove(gap, thresholds->query * scale * 1.0001f, length2)};
}

/// Appends a pair to its class. The first pair of each later class moves to the end of that class.
QC_INLINE void Insert(qcSlotPair* pairs, qcSlotPair pair, bool isNear, bool isSeparate, qcClassifiedCounts* counts)
{
    size_t firstUndecided = counts->nearCount + counts->separateCount;
    if (isNear || isSeparate)
        pairs[counts->count] = pairs[firstUndecided];
    if (isNear)
        pairs[firstUndecided] = pairs[counts->nearCount];
    pairs[isNear ? counts->nearCount : isSeparate ? firstUndecided : counts->count] = pair;
    counts->nearCount += isNear;
    counts->separateCount += !isNear && isSeparate;
    counts->count++;
}

static qcClassifiedCounts Classify(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                                   const qcDistanceThresholds* thresholds, qcSlotPair* pairs, size_t count)
{
    qcClassifiedCounts counts = {0, 0, 0};
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        PairLanes lanes = LoadPairs(a, b, thresholds, pairs + at, left);
        Classes classes = ClassifyLanes(&lanes, thresholds);
        uint32_t isNear = SignBits(classes.near), isSeparate = SignBits(classes.separate);
        uint32_t stay = ~SignBits(classes.dropped) & (uint32_t)((UINT64_C(1) << left) - 1);
        for (; stay != 0; stay &= stay - 1)
        {
            uint32_t lane = (uint32_t)__builtin_ctz(stay);
            Insert(pairs, pairs[at + lane], (isNear >> lane & 1u) != 0, (isSeparate >> lane & 1u) != 0, &counts);
        }
    }
    return counts;
}

#endif
