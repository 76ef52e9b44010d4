// The kernels, written once for all instruction sets: boxes here, the rest in the headers that this one includes. The
// source of an instruction set defines before it includes this header: QC_LANES (floats in a vector), Shorts (eight
// int16_t), MinShorts, MinFloats, MaxFloats, SquareRoot, Transpose (eight rows to eight columns), TransformVertex (one
// vertex), FindBoxOverlaps, FindRowOverlaps (with one box), FindMotionBoxOverlaps (see findMotionOverlaps),
// EightFloats, LoadEnds (eight ends to floats), StoreEnds (clamped ends of eight boxes along an axis; NaN is unbounded,
// and boxes that are empty in `source` stay empty), and what kernels/cluster_planes.inl.h needs; and after it:
// LoadPoints (QC_LANES points to three vectors) and SignBits (a bit for each lane that is true). LaneMask is the
// instruction set's own form of comparisons, with AllLanes, IsAbove and LaneBits.
#ifndef QC_KERNELS_TRIANGLE_KERNELS_INL_H
#define QC_KERNELS_TRIANGLE_KERNELS_INL_H

#include "kernels/triangle_kernels.h"

#include <math.h>
#include <string.h>

#define QC_INLINE static inline __attribute__((always_inline))

enum
{
    // Positions that are fetched before they are read: the order of the BVH is not that of the body.
    qc_verticesAhead = 24
};

QC_INLINE void TransformRange(const qcLatticeTransform* lattice, const qcVertexRange* range, bool hasMargin,
                              qcPoint* points, qcBoxRow* rows)
{
    for (size_t i = range->first; i < range->end; i++)
    {
        if (i + qc_verticesAhead < range->end)
            __builtin_prefetch(range->positions + 3 * (size_t)range->vertexOf[i + qc_verticesAhead]);
        TransformVertex(lattice, range->positions + 3 * (size_t)range->vertexOf[i], hasMargin, &points[i], &rows[i]);
    }
}

static void TransformVertices(const qcLatticeTransform* lattice, const qcVertexRange* range, qcPoint* points,
                              qcBoxRow* rows)
{
    // Without a margin both ends are computed once.
    if (lattice->margin[0] != 0.0 || lattice->margin[1] != 0.0 || lattice->margin[2] != 0.0)
        TransformRange(lattice, range, true, points, rows);
    else
        TransformRange(lattice, range, false, points, rows);
}

/// The row around eight.
QC_INLINE Shorts FindLeast(const Shorts row[qc_boxLanes])
{
    return MinShorts(MinShorts(MinShorts(row[0], row[1]), MinShorts(row[2], row[3])),
                     MinShorts(MinShorts(row[4], row[5]), MinShorts(row[6], row[7])));
}

/// Stores eight rows side by side; returns the row around them.
QC_INLINE Shorts StoreBox8(const Shorts row[qc_boxLanes], qcBox8* box8)
{
    Shorts column[8];
    Transpose(row, column);
    for (int axis = 0; axis < 3; axis++)
    {
        memcpy(box8->ends[axis], &column[axis], sizeof(Shorts));
        memcpy(box8->ends[axis] + qc_boxLanes, &column[axis + 4], sizeof(Shorts));
    }
    return FindLeast(row);
}

QC_INLINE Shorts LoadRow(const qcBoxRow* row)
{
    Shorts ends;
    memcpy(&ends, row, sizeof ends);
    return ends;
}

static void FitTriangles(const qcCorners* corners, const qcBoxRow* vertices, size_t first, size_t end, qcBox8* boxes,
                         qcBoxRow* rows)
{
    for (size_t g = first; g < end; g++)
    {
        Shorts row[qc_boxLanes];
        const qcCorners* c = corners + g * qc_boxLanes;
        for (int i = 0; i < qc_boxLanes; i++)
            row[i] = MinShorts(MinShorts(LoadRow(&vertices[c[i].vertex[0]]), LoadRow(&vertices[c[i].vertex[1]])),
                               LoadRow(&vertices[c[i].vertex[2]]));
        Shorts around = StoreBox8(row, &boxes[g]);
        memcpy(&rows[g], &around, sizeof around);
    }
}

static void FitBoxes(const qcBoxRow* children, size_t first, size_t end, qcBox8* boxes, qcBoxRow* rows)
{
    for (size_t g = first; g < end; g++)
    {
        Shorts row[qc_boxLanes];
        for (size_t i = 0; i < qc_boxLanes; i++)
            row[i] = LoadRow(&children[g * qc_boxLanes + i]);
        Shorts around = StoreBox8(row, &boxes[g]);
        memcpy(&rows[g], &around, sizeof around);
    }
}

static uint64_t FindOverlaps(const qcBox8* a, const qcBox8* b)
{
    return FindBoxOverlaps(a, b);
}

/// Adds the pairs of triangles of two clusters whose bits are set.
QC_INLINE qcSlotPair* AddPairs(uint64_t triangles, size_t clusterA, size_t clusterB, qcSlotPair* pairs)
{
    uint32_t firstA = (uint32_t)clusterA * qc_clusterSize, firstB = (uint32_t)clusterB * qc_clusterSize;
    for (; triangles != 0; triangles &= triangles - 1)
    {
        uint32_t t = (uint32_t)__builtin_ctzll(triangles);
        *pairs++ = (qcSlotPair){firstA + t % qc_clusterSize, firstB + t / qc_clusterSize};
    }
    return pairs;
}

#include "kernels/cluster_planes.inl.h"

/// Clears the bits of excluded pairs of two clusters.
QC_INLINE uint64_t RemoveExcluded(uint64_t word, const qcPairExclusion* exclusion, uint32_t i, uint32_t j)
{
    return word & ~qcPairMask_Product(qcPairMask_OfCluster(exclusion->a, i), qcPairMask_OfCluster(exclusion->b, j));
}

static qcSlotPair* CollectPairs(const qcBvhBoxes* a, uint32_t nodeA, const qcBvhBoxes* b, uint32_t nodeB,
                                const uint64_t* pairMasks, const qcPairExclusion* exclusions, int exclusionCount,
                                const qcPlaneTest* planes, qcSlotPair* pairs)
{
    static const uint64_t all[] = {0, 0, 0};
    pairMasks = pairMasks != NULL ? pairMasks : all;
    ClusterPair found[qc_pairMaskWords + 1];
    uint32_t count = 0;
    uint64_t clusters = FindBoxOverlaps(&a->nodes[nodeA], &b->nodes[nodeB]) & ~pairMasks[1];
    for (; clusters != 0; clusters &= clusters - 1)
    {
        uint32_t bit = (uint32_t)__builtin_ctzll(clusters);
        uint64_t word = qcPairMask_Word(pairMasks, bit);
        for (int i = 0; i < exclusionCount; i++)
            word = RemoveExcluded(word, &exclusions[i], bit % qc_boxLanes, bit / qc_boxLanes);
        if (exclusionCount != 0 && word == 0)
            continue;
        uint32_t clusterA = nodeA * qc_boxLanes + bit % qc_boxLanes, clusterB = nodeB * qc_boxLanes + bit / qc_boxLanes;
        word &= FindBoxOverlaps(&a->clusters[clusterA], &b->clusters[clusterB]);
        found[count] = (ClusterPair){word, clusterA, clusterB};
        count += word != 0;
    }
    return AddClusterPairs(planes, found, count, pairs);
}

#include "kernels/separating_axis.inl.h"

#include "kernels/feature_distance.inl.h"
#include "kernels/relate.inl.h"
#include "kernels/flat_patch_test.inl.h"
#include "kernels/flat_patch_motion.inl.h"
#include "kernels/lattice_transform.inl.h"
#include "kernels/motion.inl.h"
#include "kernels/triangle_distance.inl.h"
#include "kernels/neighbour_pairs.inl.h"
#include "kernels/vertex_fan_test.inl.h"
#include "kernels/common_vertices.inl.h"

#define QC_KERNELS(title)                                                                                              \
    {                                                                                                                  \
        .name = title, .transformVertices = TransformVertices, .fitTriangles = FitTriangles, .fitBoxes = FitBoxes,     \
        .findOverlaps = FindOverlaps, .collectPairs = CollectPairs, .isPatchFlat = IsPatchFlat,                        \
        .transformBoxes = TransformBoxes, .transformTriangles = TransformTriangles,                                    \
        .collectTransformedPairs = CollectTransformedPairs, .filter = Filter, .relate = Relate, .classify = Classify,  \
        .filterNeighbours = FilterNeighbours, .findSeparatedFans = FindSeparatedFans,                                  \
        .findIntersecting = FindIntersecting, .findMotionOverlaps = FindMotionOverlaps,                                \
        .collectMotionPairs = CollectMotionPairs, .filterMotion = FilterMotion,                                        \
        .isPatchFlatInMotion = IsPatchFlatInMotion, .findNearFeatures = FindNearFeatures, .findPairMask = FindPairMask \
    }

#endif
