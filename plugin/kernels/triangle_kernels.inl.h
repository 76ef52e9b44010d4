// The kernels, written once for all instruction sets: boxes here, the rest in the headers that this one includes. The
// source of an instruction set defines before it includes this header: QC_LANES (floats in a vector), Shorts (eight
// int16_t), MinShorts, MinFloats, MaxFloats, SquareRoot, Transpose (eight rows to eight columns), Position (a vertex in
// doubles; StorePoint, StoreRow and the like), FindBoxOverlaps, FindRowOverlaps (with one box), FindMotionBoxOverlaps,
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

/// Products with larger coordinates of outliers, in their own frames, could overflow.
#define QC_MAX_COORDINATE 0x1p24f

/// Vertex i of the source.
QC_INLINE Position LoadPosition(const qcVertexSource* source, bool isFloat, size_t i)
{
    size_t at = 3 * (size_t)source->vertexOf[i];
    return isFloat ? LoadFloatPosition(source->floats + at) : LoadDoublePosition(source->doubles + at);
}

QC_INLINE void FetchPosition(const qcVertexSource* source, bool isFloat, size_t i)
{
    size_t at = 3 * (size_t)source->vertexOf[i];
    __builtin_prefetch(isFloat ? (const void*)(source->floats + at) : (const void*)(source->doubles + at));
}

/// Without a margin both ends are computed once.
static bool HasMargin(const qcLatticeTransform* lattice)
{
    return lattice->margin[0] != 0.0 || lattice->margin[1] != 0.0 || lattice->margin[2] != 0.0;
}

QC_INLINE void TransformRange(const qcLatticeTransform* lattice, const qcVertexRange* range, bool isFloat,
                              bool hasMargin, bool hasOutliers, qcPoint* points, qcBoxRow* rows)
{
    for (size_t i = range->first; i < range->end; i++)
    {
        if (i + qc_verticesAhead < range->end)
            FetchPosition(&range->source, isFloat, i + qc_verticesAhead);
        Position x = LoadPosition(&range->source, isFloat, i);
        StorePoint(lattice, x, &points[i]);
        StoreRow(lattice, x, x, hasMargin, hasOutliers, &rows[i]);
    }
}

static void TransformVertices(const qcLatticeTransform* lattice, const qcVertexRange* range, qcPoint* points,
                              qcBoxRow* rows)
{
    bool hasMargin = HasMargin(lattice), isFloat = range->source.floats != NULL;
    if (lattice->hasOutliers)
        isFloat ? TransformRange(lattice, range, true, true, true, points, rows)
                : TransformRange(lattice, range, false, true, true, points, rows);
    else if (isFloat)
        hasMargin ? TransformRange(lattice, range, true, true, false, points, rows)
                  : TransformRange(lattice, range, true, false, false, points, rows);
    else
        hasMargin ? TransformRange(lattice, range, false, true, false, points, rows)
                  : TransformRange(lattice, range, false, false, false, points, rows);
}

/// Roundings are monotone: the levels of the smallest and the largest coordinates are those of the box around all rows.
QC_INLINE void BoundRange(const qcLatticeTransform* lattice, const qcVertexSource* source, bool isFloat,
                          const qcNodeVertices* vertices, size_t first, size_t end, qcBoxRow* rows)
{
    const uint32_t *firstOwn = vertices->firstOwn.data, *firstShared = vertices->firstShared.data;
    const uint32_t* shared = vertices->shared.data;
    bool hasMargin = HasMargin(lattice);
    for (size_t node = first; node < end; node++)
    {
        uint32_t i = firstOwn[node], j = firstShared[node];
        if (i == firstOwn[node + 1] && j == firstShared[node + 1])
        {
            for (int k = 0; k < 8; k++)
                rows[node].ends[k] = qc_emptyEnd;
            continue;
        }
        Position lower = LoadPosition(source, isFloat, i < firstOwn[node + 1] ? i : shared[j]), upper = lower;
        for (; i < firstOwn[node + 1]; i++)
        {
            if (i + qc_verticesAhead < firstOwn[end])
                FetchPosition(source, isFloat, i + qc_verticesAhead);
            Position x = LoadPosition(source, isFloat, i);
            lower = MinPositions(lower, x);
            upper = MaxPositions(upper, x);
        }
        for (; j < firstShared[node + 1]; j++)
        {
            Position x = LoadPosition(source, isFloat, shared[j]);
            lower = MinPositions(lower, x);
            upper = MaxPositions(upper, x);
        }
        StoreRow(lattice, lower, upper, hasMargin, lattice->hasOutliers, &rows[node]);
    }
}

static void BoundNodes(const qcLatticeTransform* lattice, const qcVertexSource* source, const qcNodeVertices* vertices,
                       size_t first, size_t end, qcBoxRow* rows)
{
    if (source->floats != NULL)
        BoundRange(lattice, source, true, vertices, first, end, rows);
    else
        BoundRange(lattice, source, false, vertices, first, end, rows);
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
        .name = title, .transformVertices = TransformVertices, .boundNodes = BoundNodes, .fitTriangles = FitTriangles, \
        .fitBoxes = FitBoxes, .findOverlaps = FindOverlaps, .collectPairs = CollectPairs, .isPatchFlat = IsPatchFlat,  \
        .transformBoxes = TransformBoxes, .transformTriangles = TransformTriangles,                                    \
        .collectTransformedPairs = CollectTransformedPairs, .filter = Filter, .relate = Relate, .classify = Classify,  \
        .filterNeighbours = FilterNeighbours, .findSeparatedFans = FindSeparatedFans,                                  \
        .findIntersecting = FindIntersecting, .findMotionOverlaps = FindMotionOverlaps,                                \
        .collectMotionPairs = CollectMotionPairs, .filterMotion = FilterMotion,                                        \
        .isPatchFlatInMotion = IsPatchFlatInMotion, .findNearFeatures = FindNearFeatures, .findPairMask = FindPairMask \
    }

#endif
