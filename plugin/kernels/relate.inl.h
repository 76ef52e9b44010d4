// The kernel that decides most pairs: proven disjoint, proven to intersect. Both follow from the sides on which corners
// lie of the other triangle's plane, and lines of edges of the other's edges. All 15 signs are those of sums of ten
// determinants of the five corners relative to the sixth. Proof: plugin/docs/proofs/pair_signs.md.
#ifndef QC_KERNELS_RELATE_INL_H
#define QC_KERNELS_RELATE_INL_H

#include "kernels/separating_axis.inl.h"

/// Proven signs, by lane.
typedef struct LaneSigns
{
    LaneMask above, below;
} LaneSigns;

/// The 15 signs of a pair.
typedef struct PairSigns
{
    LaneSigns ofA[3], ofB[3]; ///< of each corner: its side of the other triangle's plane
    LaneSigns side[3][3];     ///< [i][k]: on which side the line of edge i of A passes edge k of B
} PairSigns;

typedef struct Decided
{
    LaneMask disjoint, intersecting;
} Decided;

QC_INLINE LaneSigns SignsOf(Floats x, Floats maxError)
{
    return (LaneSigns){IsAbove(x, maxError), IsAbove(-maxError, x)};
}

QC_INLINE PairSigns FindSigns(const PairLanes* l)
{
    const Vectors b[3] = {l->d, l->e, l->f};
    Floats error = 2.0f * l->error + 0x1p-22f;
    Floats sizeA = 1.001f * MaxFloats(SumOfAbsolutes(l->b), SumOfAbsolutes(l->c));
    Floats sizeB = 1.001f * MaxFloats(SumOfAbsolutes(l->d), MaxFloats(SumOfAbsolutes(l->e), SumOfAbsolutes(l->f)));
    Floats aa = error * sizeA * sizeA, ab = error * sizeA * sizeB, bb = error * sizeB * sizeB;
    Floats constant = 48.0f * error * error + 250.0f * 0x1p-24f, several = 4.0f * constant + 600.0f * 0x1p-24f;
    Vectors n = Cross(l->b, l->c);
    Floats x[3], y[3], ofB[3];
    for (int k = 0; k < 3; k++)
    {
        Vectors moment = Cross(b[k], b[(k + 1) % 3]);
        x[k] = Dot(l->b, moment);
        y[k] = Dot(l->c, moment);
        ofB[k] = Dot(n, b[k]);
    }
    Floats volume = Dot(l->d, Cross(l->e, l->f));
    PairSigns signs;
    Floats sideError = bb + 2.0f * ab + constant, lastError = 2.0f * (aa + bb) + 8.0f * ab + several;
    for (int k = 0; k < 3; k++)
    {
        signs.ofB[k] = SignsOf(ofB[k], aa + 2.0f * ab + constant);
        signs.side[0][k] = SignsOf(x[k], sideError);
        signs.side[1][k] = SignsOf(y[k] - x[k] + ofB[(k + 1) % 3] - ofB[k], lastError);
        signs.side[2][k] = SignsOf(-y[k], sideError);
    }
    Floats cornerError = 6.0f * (bb + ab) + several;
    signs.ofA[0] = SignsOf(-volume, 3.0f * bb + constant);
    signs.ofA[1] = SignsOf(x[0] + x[1] + x[2] - volume, cornerError);
    signs.ofA[2] = SignsOf(y[0] + y[1] + y[2] - volume, cornerError);
    return signs;
}

/// An edge against a triangle: the sides of its ends, and the sides on which its line passes the triangle's edges.
QC_INLINE void AddEdge(Decided* decided, LaneSigns p, LaneSigns q, LaneSigns r, LaneSigns s, LaneSigns t)
{
    LaneMask outside = (LaneMask)((r.above | s.above | t.above) & (r.below | s.below | t.below));
    LaneMask inside = (LaneMask)((r.above & s.above & t.above) | (r.below & s.below & t.below));
    decided->disjoint &= (LaneMask)(outside | (p.above & q.above) | (p.below & q.below));
    decided->intersecting |= (LaneMask)(inside & ((p.above & q.below) | (p.below & q.above)));
}

/// Triangles are disjoint if no edge meets the other triangle, and intersect in their interiors if one passes through
/// the other's interior.
QC_INLINE Decided Decide(const PairSigns* s)
{
    Decided decided = {AllLanes(), (LaneMask)~AllLanes()};
    for (int i = 0; i < 3; i++)
    {
        int next = (i + 1) % 3;
        AddEdge(&decided, s->ofA[i], s->ofA[next], s->side[i][0], s->side[i][1], s->side[i][2]);
        AddEdge(&decided, s->ofB[i], s->ofB[next], s->side[0][i], s->side[1][i], s->side[2][i]);
    }
    return decided;
}

QC_INLINE Ints AreEqual(Vectors a, Vectors b)
{
    return (a.x == b.x) & (a.y == b.y) & (a.z == b.z);
}

/// Each corner of B coincides with one of A: no bound of these kernels decides such a pair.
QC_INLINE Ints Coincide(const PairLanes* l)
{
    const Vectors corner[3] = {l->d, l->e, l->f}, first = {{0}, {0}, {0}};
    Ints all = ~(Ints){0};
    for (int i = 0; i < 3; i++)
        all &= AreEqual(corner[i], first) | AreEqual(corner[i], l->b) | AreEqual(corner[i], l->c);
    return all;
}

/// The lanes whose signs were not all proven: more directions, and tighter bounds.
static __attribute__((noinline)) void DecideRest(const PairLanes* lanes, uint32_t* disjoint, uint32_t* intersecting)
{
    if ((~(*disjoint | *intersecting | SignBits(Coincide(lanes))) & SignBits(~(Ints){0})) == 0)
        return;
    uint32_t apart = SignBits(SeparatedByPlane(lanes) | SeparatedByEdges(lanes));
    *intersecting |= SignBits(Intersects(lanes)) & ~*disjoint;
    *disjoint |= apart & ~*intersecting;
}

/// Pairs that are kept lie in this order.
typedef enum RelatedClass
{
    related_intersecting,
    related_undecided,
    related_deferred, ///< not yet given to DecideRest
    related_classes
} RelatedClass;

enum
{
    // Undecided lanes that are decided with their vector. Fewer wait until they fill one.
    qc_minUndecided = QC_LANES / 4
};

/// Adds a pair to its class; `ends` has the end of each. The first pair of each later class moves to its end.
QC_INLINE void KeepRelated(qcSlotPair* pairs, qcSlotPair pair, RelatedClass to, size_t ends[related_classes])
{
    for (int c = related_classes - 1; c > (int)to; c--)
        pairs[ends[c]++] = pairs[ends[c - 1]];
    pairs[ends[to]++] = pair;
}

/// The pairs from the end of the undecided ones on.
static void RelateDeferred(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                           const qcDistanceThresholds* thresholds, qcSlotPair* pairs, size_t ends[related_classes])
{
    size_t at = ends[related_undecided], end = ends[related_deferred];
    ends[related_deferred] = at;
    for (; at < end; at += QC_LANES)
    {
        size_t left = end - at < QC_LANES ? end - at : QC_LANES;
        PairLanes lanes = LoadPairs(a, b, thresholds, pairs + at, left);
        uint32_t disjoint = 0, intersecting = 0;
        DecideRest(&lanes, &disjoint, &intersecting);
        for (uint32_t stay = ~disjoint & (uint32_t)((UINT64_C(1) << left) - 1); stay != 0; stay &= stay - 1)
        {
            uint32_t lane = (uint32_t)__builtin_ctz(stay);
            KeepRelated(pairs, pairs[at + lane],
                        (intersecting >> lane & 1u) != 0 ? related_intersecting : related_undecided, ends);
        }
    }
}

static qcRelatedCounts Relate(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                              const qcDistanceThresholds* thresholds, qcSlotPair* pairs, size_t count)
{
    size_t ends[related_classes] = {0};
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        uint32_t used = (uint32_t)((UINT64_C(1) << left) - 1);
        PairLanes lanes = LoadPairs(a, b, thresholds, pairs + at, left);
        PairSigns signs = FindSigns(&lanes);
        Decided decided = Decide(&signs);
        uint32_t disjoint = LaneBits(decided.disjoint), intersecting = LaneBits(decided.intersecting);
        RelatedClass rest = related_deferred;
        if (__builtin_popcount(~(disjoint | intersecting) & used) >= qc_minUndecided)
        {
            DecideRest(&lanes, &disjoint, &intersecting);
            rest = related_undecided;
        }
        for (uint32_t stay = ~disjoint & used; stay != 0; stay &= stay - 1)
        {
            uint32_t lane = (uint32_t)__builtin_ctz(stay);
            KeepRelated(pairs, pairs[at + lane], (intersecting >> lane & 1u) != 0 ? related_intersecting : rest, ends);
        }
    }
    RelateDeferred(a, b, thresholds, pairs, ends);
    return (qcRelatedCounts){ends[related_intersecting], ends[related_undecided]};
}

#endif
