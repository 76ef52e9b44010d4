// The kernel that drops pairs of neighbours whose other features (those without a common vertex) are proven farther
// apart than the query distance, in single precision. Proof: plugin/docs/proofs/neighbour_pairs.md.
#ifndef QC_KERNELS_NEIGHBOUR_PAIRS_INL_H
#define QC_KERNELS_NEIGHBOUR_PAIRS_INL_H

#include "kernels/triangle_distance.inl.h"

/// QC_LANES pairs, corners by vertex: the common ones first, in the same order in both triangles.
typedef struct NeighbourLanes
{
    uint32_t a[3][QC_LANES], b[3][QC_LANES];
    uint32_t index[QC_LANES]; ///< of the pair
    size_t count;
} NeighbourLanes;

/// A gap along w proves a distance above the query distance if it exceeds this.
QC_INLINE Floats MinGap(const qcDistanceThresholds* thresholds, Vectors w)
{
    const Floats zero = {0};
    Floats length2 = Dot(w, w), rounding = zero + (4.01f * thresholds->pointError + 20.0f * 0x1p-24f);
    return Select(length2 > 1e-30f, 1.001f * thresholds->query * SquareRoot(length2) + SumOfAbsolutes(w) * rounding,
                  zero + INFINITY);
}

/// p and q are on one side of 0 along w, r and s on the other, all by more than the query distance.
QC_INLINE Ints AreSeparated(const qcDistanceThresholds* thresholds, Vectors w, Vectors p, Vectors q, Vectors r,
                            Vectors s)
{
    Floats minGap = MinGap(thresholds, w);
    return (MinFloats(Dot(w, p), Dot(w, q)) > minGap) & (MaxFloats(Dot(w, r), Dot(w, s)) < -minGap);
}

QC_INLINE Vectors Normalize(Vectors a)
{
    const Floats zero = {0};
    return Times(a, 1.0f / SquareRoot(Dot(a, a) + (zero + 1e-30f)));
}

QC_INLINE Ints AreSeparatedAtVertex(const qcDistanceThresholds* thresholds, const qcPoint* points,
                                    const NeighbourLanes* lanes)
{
    Vectors at = LoadPoints(points, lanes->a[0]);
    Vectors a[2] = {Subtract(LoadPoints(points, lanes->a[1]), at), Subtract(LoadPoints(points, lanes->a[2]), at)};
    Vectors b[2] = {Subtract(LoadPoints(points, lanes->b[1]), at), Subtract(LoadPoints(points, lanes->b[2]), at)};
    Vectors unitA[2] = {Normalize(a[0]), Normalize(a[1])}, unitB[2] = {Normalize(b[0]), Normalize(b[1])};
    Ints separated = {0};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            separated |= AreSeparated(thresholds, Subtract(unitA[i], unitB[k]), a[0], a[1], b[0], b[1]);
    return separated;
}

/// The rejection of a from b: its part perpendicular to b.
QC_INLINE Vectors Reject(Vectors a, Vectors b)
{
    const Floats zero = {0};
    return AddScaled(a, b, -Dot(a, b) / (Dot(b, b) + (zero + 1e-30f)));
}

/// The segments p q and r s are proven farther apart than the query distance along w, in either direction.
QC_INLINE Ints AreSegmentsSeparated(const qcDistanceThresholds* thresholds, Vectors w, Vectors p, Vectors q, Vectors r,
                                    Vectors s)
{
    Floats wp = Dot(w, p), wq = Dot(w, q), wr = Dot(w, r), ws = Dot(w, s);
    Floats above = MinFloats(wp, wq) - MaxFloats(wr, ws), below = MinFloats(wr, ws) - MaxFloats(wp, wq);
    return MaxFloats(above, below) > MinGap(thresholds, w);
}

/// Segments from 0 to a and from v to b.
QC_INLINE Ints AreOppositeEdgesSeparated(const qcDistanceThresholds* thresholds, Vectors v, Vectors a, Vectors b)
{
    const Floats zero = {0};
    const Vectors u = {zero, zero, zero};
    return AreSegmentsSeparated(thresholds, Reject(v, a), u, a, v, b) |
           AreSegmentsSeparated(thresholds, Reject(v, Subtract(b, v)), u, a, v, b) |
           AreSegmentsSeparated(thresholds, v, u, a, v, b);
}

QC_INLINE Ints AreSeparatedAtEdge(const qcDistanceThresholds* thresholds, const qcPoint* points,
                                  const NeighbourLanes* lanes)
{
    const Floats zero = {0};
    const Vectors u = {zero, zero, zero};
    Vectors at = LoadPoints(points, lanes->a[0]);
    Vectors v = Subtract(LoadPoints(points, lanes->a[1]), at), a = Subtract(LoadPoints(points, lanes->a[2]), at),
            b = Subtract(LoadPoints(points, lanes->b[2]), at);
    Vectors w = Reject(Subtract(a, b), v);
    Floats minGap = MinGap(thresholds, w), wa = Dot(w, a), wb = Dot(w, b), wv = Dot(w, v);
    Ints separated =
        (wa - MaxFloats(zero, MaxFloats(wv, wb)) > minGap) & (MinFloats(zero, MinFloats(wv, wa)) - wb > minGap);
    // Relative to v the roles of u and v are exchanged.
    Vectors back = Subtract(u, v);
    return separated & AreOppositeEdgesSeparated(thresholds, v, a, b) &
           AreOppositeEdgesSeparated(thresholds, back, Subtract(a, v), Subtract(b, v));
}

/// Adds a pair to the lanes for its number of common vertices, which it returns.
QC_INLINE int AddToLanes(const uint32_t* p, const uint32_t* q, uint32_t index, NeighbourLanes lanes[4])
{
    uint32_t a[3], b[3];
    int common = 0, restA = 2, restB = 2;
    bool taken[3] = {false, false, false};
    for (int i = 0; i < 3; i++)
    {
        int k = q[0] == p[i] ? 0 : q[1] == p[i] ? 1 : q[2] == p[i] ? 2 : 3;
        if (k == 3 || taken[k])
        {
            a[restA--] = p[i];
            continue;
        }
        taken[k] = true;
        a[common] = b[common] = p[i];
        common++;
    }
    for (int k = 0; k < 3; k++)
        if (!taken[k])
            b[restB--] = q[k];
    NeighbourLanes* to = &lanes[common];
    for (int c = 0; c < 3; c++)
    {
        to->a[c][to->count] = a[c];
        to->b[c][to->count] = b[c];
    }
    to->index[to->count++] = index;
    return common;
}

QC_INLINE void TestLanes(const qcDistanceThresholds* thresholds, const qcPoint* points, int common,
                         NeighbourLanes* lanes, uint8_t* keep)
{
    // Empty lanes repeat the first.
    for (size_t lane = lanes->count; lane < QC_LANES; lane++)
        for (int c = 0; c < 3; c++)
        {
            lanes->a[c][lane] = lanes->a[c][0];
            lanes->b[c][lane] = lanes->b[c][0];
        }
    uint32_t separated = 0;
    if (common == 1)
        separated = SignBits(AreSeparatedAtVertex(thresholds, points, lanes));
    else if (common == 2)
        separated = SignBits(AreSeparatedAtEdge(thresholds, points, lanes));
    for (size_t lane = 0; lane < lanes->count; lane++)
        keep[lanes->index[lane]] = (separated >> lane & 1u) == 0;
    lanes->count = 0;
}

static size_t FilterNeighbours(const qcIndexedTriangles* side, const qcDistanceThresholds* thresholds,
                               qcSlotPair* pairs, size_t count)
{
    uint8_t keep[qc_nodeSize * qc_nodeSize];
    NeighbourLanes lanes[4];
    for (int i = 0; i < 4; i++)
        lanes[i].count = 0;
    for (size_t i = 0; i < count; i++)
    {
        const uint32_t *p = side->corners[pairs[i].a].vertex, *q = side->corners[pairs[i].b].vertex;
        int common = AddToLanes(p, q, (uint32_t)i, lanes);
        if (lanes[common].count == QC_LANES)
            TestLanes(thresholds, side->points, common, &lanes[common], keep);
    }
    for (int i = 0; i < 4; i++)
        if (lanes[i].count != 0)
            TestLanes(thresholds, side->points, i, &lanes[i], keep);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
    {
        pairs[kept] = pairs[i];
        kept += keep[i];
    }
    return kept;
}

#endif
