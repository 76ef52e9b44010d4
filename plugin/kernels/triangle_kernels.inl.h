// What the kernels have in common: boxes here and, of another surface, in kernels/lattice_transform.inl.h, triangles in
// kernels/separating_axis.inl.h, flat discs in kernels/flat_patch_test.inl.h. The file of an instruction set defines,
// before it includes this one:
//
//   QC_LANES                   floats in a vector
//   Shorts                     eight int16_t
//   LeastShorts, LeastFloats, MostFloats
//   Transpose                  eight rows to eight columns
//   MapVertex                  one vertex
//   CompareGroups              as compare
//
// and after it:
//
//   LoadPoints                 QC_LANES points to three vectors
//   SignBits                   a bit for each lane that is true
#ifndef QC_KERNELS_TRIANGLE_KERNELS_INL_H
#define QC_KERNELS_TRIANGLE_KERNELS_INL_H

#include "kernels/triangle_kernels.h"

#include <math.h>
#include <string.h>

#define QC_INLINE static inline __attribute__((always_inline))

static void Map(const qcLatticeTransform* map, const qcVertexRange* range, qcPoint* points, qcBoxRow* rows)
{
    for (size_t i = range->first; i < range->end; i++)
        MapVertex(map, range->positions + 3 * (size_t)range->vertexOf[i], &points[i], &rows[i]);
}

/// Eight rows side by side; returns the row around them.
QC_INLINE Shorts StoreGroup(const Shorts row[qc_groupSize], qcBox8* group)
{
    Shorts column[8];
    Transpose(row, column);
    for (int axis = 0; axis < 3; axis++)
    {
        memcpy(group->ends[axis], &column[axis], sizeof(Shorts));
        memcpy(group->ends[axis] + qc_groupSize, &column[axis + 4], sizeof(Shorts));
    }
    return LeastShorts(LeastShorts(LeastShorts(row[0], row[1]), LeastShorts(row[2], row[3])),
                       LeastShorts(LeastShorts(row[4], row[5]), LeastShorts(row[6], row[7])));
}

QC_INLINE Shorts LoadRow(const qcBoxRow* row)
{
    Shorts ends;
    memcpy(&ends, row, sizeof ends);
    return ends;
}

static void FitTriangles(const qcCorners* corners, const qcBoxRow* vertices, size_t first, size_t end, qcBox8* groups,
                         qcBoxRow* rows)
{
    for (size_t g = first; g < end; g++)
    {
        Shorts row[qc_groupSize];
        const qcCorners* c = corners + g * qc_groupSize;
        for (int i = 0; i < qc_groupSize; i++)
            row[i] = LeastShorts(LeastShorts(LoadRow(&vertices[c[i].vertex[0]]), LoadRow(&vertices[c[i].vertex[1]])),
                                 LoadRow(&vertices[c[i].vertex[2]]));
        Shorts around = StoreGroup(row, &groups[g]);
        memcpy(&rows[g], &around, sizeof around);
    }
}

static void FitGroups(const qcBoxRow* children, size_t first, size_t end, qcBox8* groups, qcBoxRow* rows)
{
    for (size_t g = first; g < end; g++)
    {
        Shorts row[qc_groupSize];
        for (int i = 0; i < qc_groupSize; i++)
            row[i] = LoadRow(&children[g * qc_groupSize + i]);
        Shorts around = StoreGroup(row, &groups[g]);
        memcpy(&rows[g], &around, sizeof around);
    }
}

static uint64_t Compare(const qcBox8* a, const qcBox8* b)
{
    return CompareGroups(a, b);
}

/// Adds the triangles of two clusters that meet and whose bits are set.
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

/// The pairs of a word that a skip of these two clusters leaves.
QC_INLINE uint64_t Leave(uint64_t word, const qcPairExclusion* skip, uint32_t i, uint32_t j)
{
    return word & ~qcPairMask_Product(qcPairMask_OfCluster(skip->a, i), qcPairMask_OfCluster(skip->b, j));
}

static qcSlotPair* Collect(const qcSurfaceBoxes* a, uint32_t nodeA, const qcSurfaceBoxes* b, uint32_t nodeB,
                           const uint64_t* table, const qcPairExclusion* skips, int skipCount, qcSlotPair* pairs)
{
    static const uint64_t all[] = {0, 0, 0};
    table = table != NULL ? table : all;
    uint64_t clusters = CompareGroups(&a->nodes[nodeA], &b->nodes[nodeB]) & ~table[1];
    for (; clusters != 0; clusters &= clusters - 1)
    {
        uint32_t bit = (uint32_t)__builtin_ctzll(clusters);
        uint64_t word = qcPairMask_Word(table, bit);
        for (int i = 0; i < skipCount; i++)
            word = Leave(word, &skips[i], bit % qc_groupSize, bit / qc_groupSize);
        if (skipCount != 0 && word == 0)
            continue;
        size_t clusterA = (size_t)nodeA * qc_groupSize + bit % qc_groupSize;
        size_t clusterB = (size_t)nodeB * qc_groupSize + bit / qc_groupSize;
        pairs =
            AddPairs(CompareGroups(&a->clusters[clusterA], &b->clusters[clusterB]) & word, clusterA, clusterB, pairs);
    }
    return pairs;
}

#include "kernels/separating_axis.inl.h"

#include "kernels/feature_distance.inl.h"
#include "kernels/flat_patch_test.inl.h"
#include "kernels/lattice_transform.inl.h"
#include "kernels/triangle_distance.inl.h"
#include "kernels/adjacent_pairs.inl.h"
#include "kernels/vertex_fan_test.inl.h"

#define QC_KERNELS(title)                                                                                              \
    {                                                                                                                  \
        .name = title, .map = Map, .fitTriangles = FitTriangles, .fitGroups = FitGroups, .compare = Compare,           \
        .collect = Collect, .isFlat = IsFlat, .mapGroup = MapGroup, .mapTriangles = MapTriangles,                      \
        .collectMapped = CollectMapped, .filter = Filter, .part = Part, .keepNearNeighbours = KeepNearNeighbours,      \
        .findQuietStars = FindQuietStars, .findPiercing = FindPiercing, .findNearFeatures = FindNearFeatures           \
    }

#endif
