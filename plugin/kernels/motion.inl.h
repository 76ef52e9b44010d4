// The kernels for a linear motion, which leave out what one direction separates at the start and at the end, in the
// same order. Proof: plugin/docs/proofs/motion_sweep.md.
#ifndef QC_KERNELS_MOTION_INL_H
#define QC_KERNELS_MOTION_INL_H

#include "kernels/lattice_transform.inl.h"

static uint64_t FindMotionOverlaps(const qcBox8* const a[2], const qcBox8* const b[2])
{
    return FindMotionBoxOverlaps(a, b);
}

/// The boxes of the node's clusters at both ends, in the reference lattices; transformed ones are put into `own`.
QC_INLINE void GetNodeBoxes(const qcMotionBvh* bvh, uint32_t node, qcBox8 own[2], const qcBox8* boxes[2])
{
    for (int t = 0; t < 2; t++)
    {
        boxes[t] = &bvh->at[t].boxes.nodes[node];
        if (!bvh->isTransformed)
            continue;
        TransformBoxes(boxes[t], &bvh->at[t].levels, &own[t]);
        boxes[t] = &own[t];
    }
}

/// Likewise the boxes of a cluster's triangles.
QC_INLINE void GetClusterBoxes(const qcMotionBvh* bvh, uint32_t cluster, qcBox8 own[2], const qcBox8* boxes[2])
{
    for (int t = 0; t < 2; t++)
    {
        boxes[t] = &bvh->at[t].boxes.clusters[cluster];
        if (!bvh->isTransformed)
            continue;
        TransformTriangles(&bvh->at[t], cluster, &own[t]);
        boxes[t] = &own[t];
    }
}

/// The clusters of a node, bit by bit, with a triangle's box that one of the other boxes overlaps around both ends.
/// `nodes`: the boxes of the clusters.
QC_INLINE uint32_t FindNearClusters(const qcBox8* const nodes[2], const qcBox8* const triangles[2])
{
    return qcPairMask_FirstOfWord(FindUnitedOverlaps(nodes, triangles));
}

/// One in twenty pairs of clusters whose boxes overlap has triangles whose boxes around both ends overlap.
/// Where these don't, an axis separates in the same order at both ends.
static qcSlotPair* CollectMotionPairs(const qcMotionBvh* a, uint32_t nodeA, const qcMotionBvh* b, uint32_t nodeB,
                                      const uint64_t* pairMasks, const qcPairExclusion* exclusions, int exclusionCount,
                                      qcSlotPair* pairs)
{
    static const uint64_t all[] = {0, 0, 0};
    pairMasks = pairMasks != NULL ? pairMasks : all;
    qcBox8 ownA[qc_boxLanes][2], ownB[2], ownNodeA[2], ownNodeB[2];
    const qcBox8 *boxesA[qc_boxLanes][2], *boxesB[2], *nodesA[2], *nodesB[2];
    GetNodeBoxes(a, nodeA, ownNodeA, nodesA);
    GetNodeBoxes(b, nodeB, ownNodeB, nodesB);
    uint64_t clusters = FindUnitedOverlaps(nodesA, nodesB) & ~pairMasks[1];
    uint32_t known = 0; // clusters of a whose boxes are here
    for (uint32_t j = 0; j < qc_boxLanes; j++)
    {
        uint32_t row = (uint32_t)(clusters >> qc_boxLanes * j) & 0xffu, clusterB = nodeB * qc_boxLanes + j;
        if (row == 0)
            continue;
        GetClusterBoxes(b, clusterB, ownB, boxesB);
        for (row &= FindNearClusters(nodesA, boxesB); row != 0; row &= row - 1)
        {
            uint32_t i = (uint32_t)__builtin_ctz(row), clusterA = nodeA * qc_boxLanes + i;
            uint64_t word = qcPairMask_Word(pairMasks, i + qc_boxLanes * j);
            for (int k = 0; k < exclusionCount; k++)
                word = RemoveExcluded(word, &exclusions[k], i, j);
            if (exclusionCount != 0 && word == 0)
                continue;
            if ((known >> i & 1u) == 0)
                GetClusterBoxes(a, clusterA, ownA[i], boxesA[i]);
            known |= 1u << i;
            word &= FindUnitedOverlaps(boxesA[i], boxesB);
            if (word != 0)
                pairs = AddPairs(FindMotionBoxOverlaps(boxesA[i], boxesB) & word, clusterA, clusterB, pairs);
        }
    }
    return pairs;
}

//  ---- pairs of triangles ------------------------------------------------------------------------------

/// Pairs at the start and at the end.
typedef struct MotionLanes
{
    PairLanes at[2];
} MotionLanes;

/// All bits of a lane where the axis separates, with A above B at [0], below at [1].
QC_INLINE void FindOrders(const PairLanes* l, Vectors axis, Ints order[2])
{
    const Floats zero = {0};
    Floats u = Dot(axis, l->b), v = Dot(axis, l->c), p = Dot(axis, l->d), q = Dot(axis, l->e), r = Dot(axis, l->f);
    Floats minGap = MaxFloats(SumOfAbsolutes(axis) * l->gap, zero + 1e-20f);
    order[0] = MinFloats(zero, MinFloats(u, v)) - MaxFloats(p, MaxFloats(q, r)) > minGap;
    order[1] = MinFloats(p, MinFloats(q, r)) - MaxFloats(zero, MaxFloats(u, v)) > minGap;
}

QC_INLINE Ints SeparatesMotion(const MotionLanes* l, Vectors axis)
{
    Ints start[2], end[2];
    FindOrders(&l->at[0], axis, start);
    FindOrders(&l->at[1], axis, end);
    return (start[0] & end[0]) | (start[1] & end[1]);
}

QC_INLINE Vectors Add(Vectors a, Vectors b)
{
    return (Vectors){a.x + b.x, a.y + b.y, a.z + b.z};
}

/// Three times the difference of the centroids.
QC_INLINE Vectors CentroidDifference(const PairLanes* l)
{
    return Subtract(Add(Add(l->d, l->e), l->f), Add(l->b, l->c));
}

/// Differences of centroids separate most pairs of one smooth surface, normals most pairs of two layers.
QC_INLINE Ints SeparatedByCentroidsOrNormals(const MotionLanes* l)
{
    Vectors start = CentroidDifference(&l->at[0]), end = CentroidDifference(&l->at[1]);
    Ints separated = SeparatesMotion(l, Add(start, end));
    for (int t = 0; t < 2; t++)
    {
        const PairLanes* at = &l->at[t];
        separated |= SeparatesMotion(l, Cross(at->b, at->c));
        separated |= SeparatesMotion(l, Cross(Subtract(at->e, at->d), Subtract(at->f, at->d)));
    }
    return separated;
}

/// Cross products of edges, and for triangles in one plane normals of edges within it, of one end.
QC_INLINE Ints SeparatedByEdgesAt(const MotionLanes* l, int t)
{
    const PairLanes* at = &l->at[t];
    Vectors bc = Subtract(at->c, at->b), de = Subtract(at->e, at->d), df = Subtract(at->f, at->d),
            ef = Subtract(at->f, at->e), n = Cross(at->b, at->c), m = Cross(de, df);
    Vectors edgeA[3] = {at->b, at->c, bc}, edgeB[3] = {de, df, ef};
    Ints separated = {0};
    for (int i = 0; i < 3; i++)
    {
        separated |= SeparatesMotion(l, Cross(n, edgeA[i])) | SeparatesMotion(l, Cross(m, edgeB[i]));
        for (int j = 0; j < 3; j++)
            separated |= SeparatesMotion(l, Cross(edgeA[i], edgeB[j]));
    }
    return separated;
}

QC_INLINE Ints SeparatedByMotionEdges(const MotionLanes* l)
{
    return SeparatedByEdgesAt(l, 0) | SeparatedByEdgesAt(l, 1);
}

typedef Ints SeparatedInMotion(const MotionLanes* l);

QC_INLINE size_t KeepUnseparatedInMotion(const qcMotionBvh* a, const qcMotionBvh* b, qcSlotPair* pairs, size_t count,
                                         SeparatedInMotion* separated)
{
    size_t kept = 0;
    for (size_t at = 0; at < count; at += QC_LANES)
    {
        size_t left = count - at < QC_LANES ? count - at : QC_LANES;
        MotionLanes lanes;
        for (int t = 0; t < 2; t++)
            lanes.at[t] = LoadFramedPairs(&a->at[t].triangles, &a->frames[t], &b->at[t].triangles, &b->frames[t],
                                          pairs + at, left);
        uint32_t stay = ~SignBits(separated(&lanes)) & (uint32_t)((UINT64_C(1) << left) - 1);
        for (; stay != 0; stay &= stay - 1)
            pairs[kept++] = pairs[at + (size_t)__builtin_ctz(stay)];
    }
    return kept;
}

static size_t FilterMotion(const qcMotionBvh* a, const qcMotionBvh* b, qcSlotPair* pairs, size_t count)
{
    count = KeepUnseparatedInMotion(a, b, pairs, count, SeparatedByCentroidsOrNormals);
    return KeepUnseparatedInMotion(a, b, pairs, count, SeparatedByMotionEdges);
}

#endif
