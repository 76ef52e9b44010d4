// The kernel that looks at triangles which share vertices: are their other features (those without a common vertex)
// surely further apart than the reach? In single precision, by directions: whatever a direction w is, what the
// projections of two sets of points on it leave between them is at most |w| times their distance.
//
// One common vertex: seen from it, if w . p > r |w| for both other corners of A, and w . q < -r |w| for both of B, then
// every corner of A but the common one is further than r from B, and every such edge; and the other way round: all
// features without a common vertex are pairs of such a one and some other.
// Two common vertices u and v, the other corners a and b: the features are a and B, b and A, the edges u a and v b, and
// u b and v a. For the first two, w across the edge u v in the middle of a and b. For two edges, w across one of them
// (from the other's end), or along u v.
//
// Rounding. Coordinates are wrong by e; relative to another corner by 2 e + 3 * 2^-24, as they are below 1 and are
// subtracted twice at most. A dot product with w is then wrong by |w|_1 (2 e + 6 * 2^-24), the difference of two by
// twice that and |w|_1 2^-23: the kernel asks for a gap of 1.001 r |w| + |w|_1 (4.01 e + 20 * 2^-24). A w that is
// shorter than 1e-15, whose square may vanish, doesn't count.
#ifndef QC_KERNELS_NEIGHBOUR_PAIRS_INL_H
#define QC_KERNELS_NEIGHBOUR_PAIRS_INL_H

#include "kernels/triangle_distance.inl.h"

/// QC_LANES pairs, corners by name: first the common ones, in the same order in both.
typedef struct NeighbourLanes
{
    uint32_t a[3][QC_LANES], b[3][QC_LANES];
    uint32_t index[QC_LANES]; ///< of the pair
    size_t count;
} NeighbourLanes;

/// What a gap along w has to exceed.
QC_INLINE Floats MinGap(const qcDistanceThresholds* bound, Vectors w)
{
    const Floats zero = {0};
    Floats length2 = Dot(w, w), rounding = zero + (4.01f * bound->pointError + 20.0f * 0x1p-24f);
    return Select(length2 > 1e-30f, 1.001f * bound->query * SquareRoot(length2) + SumOfAbsolutes(w) * rounding,
                  zero + INFINITY);
}

/// Are p and q, and r and s, on different sides of 0 along w, by more than the reach?
QC_INLINE Ints AreSeparated(const qcDistanceThresholds* bound, Vectors w, Vectors p, Vectors q, Vectors r, Vectors s)
{
    Floats least = MinGap(bound, w);
    return (MinFloats(Dot(w, p), Dot(w, q)) > least) & (MaxFloats(Dot(w, r), Dot(w, s)) < -least);
}

QC_INLINE Vectors Normalize(Vectors a)
{
    const Floats zero = {0};
    return Times(a, 1.0f / SquareRoot(Dot(a, a) + (zero + 1e-30f)));
}

QC_INLINE Ints AreSeparatedAtVertex(const qcDistanceThresholds* bound, const qcPoint* points,
                                    const NeighbourLanes* lanes)
{
    Vectors at = LoadPoints(points, lanes->a[0]);
    Vectors a[2] = {Subtract(LoadPoints(points, lanes->a[1]), at), Subtract(LoadPoints(points, lanes->a[2]), at)};
    Vectors b[2] = {Subtract(LoadPoints(points, lanes->b[1]), at), Subtract(LoadPoints(points, lanes->b[2]), at)};
    Vectors unitA[2] = {Normalize(a[0]), Normalize(a[1])}, unitB[2] = {Normalize(b[0]), Normalize(b[1])};
    Ints quiet = {0};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            quiet |= AreSeparated(bound, Subtract(unitA[i], unitB[k]), a[0], a[1], b[0], b[1]);
    return quiet;
}

/// The part of a that is across b.
QC_INLINE Vectors Across(Vectors a, Vectors b)
{
    const Floats zero = {0};
    return AddScaled(a, b, -Dot(a, b) / (Dot(b, b) + (zero + 1e-30f)));
}

/// Are the segments p q and r s surely further apart than the reach along w, in either direction?
QC_INLINE Ints AreSegmentsSeparated(const qcDistanceThresholds* bound, Vectors w, Vectors p, Vectors q, Vectors r,
                                    Vectors s)
{
    Floats wp = Dot(w, p), wq = Dot(w, q), wr = Dot(w, r), ws = Dot(w, s);
    Floats above = MinFloats(wp, wq) - MaxFloats(wr, ws), below = MinFloats(wr, ws) - MaxFloats(wp, wq);
    return MaxFloats(above, below) > MinGap(bound, w);
}

/// Segments from 0 to a and from v to b.
QC_INLINE Ints AreOppositeEdgesSeparated(const qcDistanceThresholds* bound, Vectors v, Vectors a, Vectors b)
{
    const Floats zero = {0};
    const Vectors u = {zero, zero, zero};
    return AreSegmentsSeparated(bound, Across(v, a), u, a, v, b) |
           AreSegmentsSeparated(bound, Across(v, Subtract(b, v)), u, a, v, b) |
           AreSegmentsSeparated(bound, v, u, a, v, b);
}

QC_INLINE Ints AreSeparatedAtEdge(const qcDistanceThresholds* bound, const qcPoint* points, const NeighbourLanes* lanes)
{
    const Floats zero = {0};
    const Vectors u = {zero, zero, zero};
    Vectors at = LoadPoints(points, lanes->a[0]);
    Vectors v = Subtract(LoadPoints(points, lanes->a[1]), at), a = Subtract(LoadPoints(points, lanes->a[2]), at),
            b = Subtract(LoadPoints(points, lanes->b[2]), at);
    Vectors w = Across(Subtract(a, b), v);
    Floats least = MinGap(bound, w), wa = Dot(w, a), wb = Dot(w, b), wv = Dot(w, v);
    Ints parted = (wa - MaxFloats(zero, MaxFloats(wv, wb)) > least) & (MinFloats(zero, MinFloats(wv, wa)) - wb > least);
    // From v's side the roles of u and v change.
    Vectors back = Subtract(u, v);
    return parted & AreOppositeEdgesSeparated(bound, v, a, b) &
           AreOppositeEdgesSeparated(bound, back, Subtract(a, v), Subtract(b, v));
}

/// Adds a pair to the lanes of its kind: corners that both have first. Which kind: how many those are.
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

QC_INLINE void TestLanes(const qcDistanceThresholds* bound, const qcPoint* points, int common, NeighbourLanes* lanes,
                         uint8_t* keep)
{
    // Lanes that are empty stand for the first again.
    for (size_t lane = lanes->count; lane < QC_LANES; lane++)
        for (int c = 0; c < 3; c++)
        {
            lanes->a[c][lane] = lanes->a[c][0];
            lanes->b[c][lane] = lanes->b[c][0];
        }
    uint32_t quiet = 0;
    if (common == 1)
        quiet = SignBits(AreSeparatedAtVertex(bound, points, lanes));
    else if (common == 2)
        quiet = SignBits(AreSeparatedAtEdge(bound, points, lanes));
    for (size_t lane = 0; lane < lanes->count; lane++)
        keep[lanes->index[lane]] = (quiet >> lane & 1u) == 0;
    lanes->count = 0;
}

static size_t FilterNeighbours(const qcIndexedTriangles* side, const qcDistanceThresholds* bound, qcSlotPair* pairs,
                               size_t count)
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
            TestLanes(bound, side->points, common, &lanes[common], keep);
    }
    for (int i = 0; i < 4; i++)
        if (lanes[i].count != 0)
            TestLanes(bound, side->points, i, &lanes[i], keep);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
    {
        pairs[kept] = pairs[i];
        kept += keep[i];
    }
    return kept;
}

#endif
