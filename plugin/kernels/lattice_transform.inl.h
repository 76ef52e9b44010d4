// The kernels that transform boxes of one BVH to the lattice of another, and compare them there. Boxes of clusters are
// transformed as boxes: cheap, but larger than necessary if they are rotated. Boxes of rotated triangles are computed
// from the corners: between rotated bunnies, half as many pairs of triangles then reach the filter.
//
// The rounding is in `grow`. If it is infinite, the transform is useless: ends are then infinite or NaN, and both are
// clamped to the ends of the lattice. So are those of boxes with outliers. Proof: plugin/docs/proofs/bvh_pairs.md.
#ifndef QC_KERNELS_LATTICE_TRANSFORM_INL_H
#define QC_KERNELS_LATTICE_TRANSFORM_INL_H

#include "kernels/separating_axis.inl.h"

typedef int32_t EightMasks __attribute__((vector_size(32)));

/// Eight ends as floats; with outliers, those at the first level, or the complement of the last, are -infinity.
QC_INLINE EightFloats LoadOpenEnds(const int16_t* ends, bool hasOutliers, int16_t first)
{
    EightFloats loaded = LoadEnds(ends);
    if (!hasOutliers)
        return loaded;
    EightMasks isOpen = (EightMasks)(loaded <= (float)first), infinite = (EightMasks)((EightFloats){0} - INFINITY);
    return (EightFloats)((isOpen & infinite) | (~isOpen & (EightMasks)loaded));
}

/// The lower and the upper ends of eight boxes along an axis.
QC_INLINE void LoadIntervals(const qcBox8* boxes, int axis, bool hasOutliers, EightFloats* lower, EightFloats* upper)
{
    *lower = LoadOpenEnds(boxes->ends[axis], hasOutliers, INT16_MIN);
    *upper = -LoadOpenEnds(boxes->ends[axis] + qc_boxLanes, hasOutliers, (int16_t) ~(qc_lastLevel - 32768));
}

/// Each end by itself: one rounding for each operation of the general case.
QC_INLINE void ScaleBoxes(const qcBox8* boxes, const qcBoxTransform* transform, qcBox8* transformed)
{
    for (int axis = 0; axis < 3; axis++)
    {
        EightFloats lower, end;
        LoadIntervals(boxes, axis, transform->hasOutliers, &lower, &end);
        float scale = transform->linear[axis][axis], shift = transform->shift[axis], grow = transform->grow[axis];
        StoreEnds(lower * scale + (shift - grow), end * scale + (shift + grow), boxes->ends[0], axis, transformed);
    }
}

/// A box with centre c and half extents h goes to one around linear c + shift with half extents |linear| h + grow.
static void TransformBoxes(const qcBox8* boxes, const qcBoxTransform* transform, qcBox8* transformed)
{
    EightFloats centre[3], half[3];
    if (transform->isDiagonal)
    {
        ScaleBoxes(boxes, transform, transformed);
        return;
    }
    for (int axis = 0; axis < 3; axis++)
    {
        EightFloats lower, end;
        LoadIntervals(boxes, axis, transform->hasOutliers, &lower, &end);
        centre[axis] = 0.5f * (lower + end);
        half[axis] = 0.5f * (end - lower);
    }
    for (int axis = 0; axis < 3; axis++)
    {
        const float* row = transform->linear[axis];
        float size[3] = {__builtin_fabsf(row[0]), __builtin_fabsf(row[1]), __builtin_fabsf(row[2])};
        EightFloats at = row[0] * centre[0] + row[1] * centre[1] + row[2] * centre[2] + transform->shift[axis];
        EightFloats around = size[0] * half[0] + size[1] * half[1] + size[2] * half[2] + transform->grow[axis];
        StoreEnds(at - around, at + around, boxes->ends[0], axis, transformed);
    }
}

/// How many times as large errors of triangles are if a coordinate exceeds 1; infinite if products could overflow.
QC_INLINE PlaneFloats FindErrorFactor(PlaneFloats p[3][4])
{
    PlaneFloats size = (PlaneFloats){0} + 1.0f;
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
            size = MaxPlane(size, AbsoluteLanes(p[c][axis]));
    PlaneInts isLarge = size > QC_MAX_COORDINATE;
    const PlaneFloats infinite = (PlaneFloats){0} + INFINITY;
    return (PlaneFloats)((isLarge & (PlaneInts)infinite) | (~isLarge & (PlaneInts)(size * 1.0001f)));
}

static void TransformTriangles(const qcTransformedBvh* bvh, uint32_t cluster, qcBox8* transformed)
{
    const qcBoxTransform* transform = &bvh->points;
    const qcCorners* corners = bvh->triangles.corners + (size_t)cluster * qc_clusterSize;
    float lower[3][qc_boxLanes], upper[3][qc_boxLanes];
    int16_t marks[qc_boxLanes]; // from the points, which are read in any case
    for (int at = 0; at < qc_boxLanes; at += qc_planeLanes)
    {
        PlaneFloats p[3][4];
        for (int c = 0; c < 3; c++)
            LoadPlanePoints(bvh->triangles.points, corners + at, c, p[c]);
        StoreShorts(p[0][3], marks + at);
        PlaneFloats factor = (PlaneFloats){0} + 1.0f;
        if (transform->hasOutliers)
            factor = FindErrorFactor(p);
        for (int axis = 0; axis < 3; axis++)
        {
            const float* row = transform->linear[axis];
            PlaneFloats x[3];
            for (int c = 0; c < 3; c++)
                x[c] = p[c][0] * row[0] + p[c][1] * row[1] + p[c][2] * row[2];
            float shift = transform->shift[axis];
            PlaneFloats grow = transform->grow[axis] * factor;
            StoreLanes(MinPlane(x[0], MinPlane(x[1], x[2])) + shift - grow, lower[axis] + at);
            StoreLanes(MaxPlane(x[0], MaxPlane(x[1], x[2])) + shift + grow, upper[axis] + at);
        }
    }
    for (int axis = 0; axis < 3; axis++)
    {
        EightFloats ends[2];
        memcpy(&ends[0], lower[axis], sizeof ends[0]);
        memcpy(&ends[1], upper[axis], sizeof ends[1]);
        StoreEnds(ends[0], ends[1], marks, axis, transformed);
    }
}

/// The box around eight.
QC_INLINE Shorts FindAround(const qcBox8* boxes)
{
    Shorts column[8], row[qc_boxLanes];
    for (int axis = 0; axis < 3; axis++)
    {
        memcpy(&column[axis], boxes->ends[axis], sizeof(Shorts));
        memcpy(&column[axis + 4], boxes->ends[axis] + qc_boxLanes, sizeof(Shorts));
    }
    column[3] = column[7] = column[0];
    Transpose(column, row);
    return FindLeast(row);
}

/// Boxes of a cluster's triangles in the other lattice, and the box around them.
typedef struct TransformedCluster
{
    const qcBox8* boxes; ///< in the cache, or in `own`
    const qcBoxRow* around;
    qcBox8 own;
    qcBoxRow ownAround;
} TransformedCluster;

QC_INLINE void TransformCluster(const qcTransformedBvh* b, uint32_t cluster, qcBox8* boxes, qcBoxRow* around)
{
    TransformTriangles(b, cluster, boxes);
    Shorts min = FindAround(boxes);
    memcpy(around, &min, sizeof *around);
}

QC_INLINE void FindTransformed(const qcTransformedBvh* b, uint32_t cluster, const qcPlaneTest* planes,
                               TransformedCluster* transformed)
{
    if (planes == NULL)
    {
        TransformCluster(b, cluster, &transformed->own, &transformed->ownAround);
        transformed->boxes = &transformed->own;
        transformed->around = &transformed->ownAround;
        return;
    }
    qcPlaneCache* cache = planes->cache;
    uint32_t entry = cluster % qc_planeCacheSize;
    uint64_t key = planes->key | cluster;
    transformed->boxes = &cache->boxes[entry];
    transformed->around = &cache->around[entry];
    if (cache->boxKeys[entry] == key)
        return;
    cache->boxKeys[entry] = key;
    TransformCluster(b, cluster, &cache->boxes[entry], &cache->around[entry]);
}

static qcSlotPair* CollectTransformedPairs(const qcBvhBoxes* a, uint32_t nodeA, const qcTransformedBvh* b,
                                           uint32_t nodeB, uint64_t clusters, const qcPlaneTest* planes,
                                           qcSlotPair* pairs)
{
    TransformedCluster transformed = {.boxes = &transformed.own};
    ClusterPair found[qc_pairMaskWords + 1];
    uint32_t count = 0;
    for (uint32_t j = 0; j < qc_boxLanes; j++)
    {
        uint32_t row = (uint32_t)(clusters >> qc_boxLanes * j) & 0xffu, clusterB = nodeB * qc_boxLanes + j;
        if (row == 0)
            continue;
        if (b->levels.isDiagonal)
            ScaleBoxes(&b->boxes.clusters[clusterB], &b->levels, &transformed.own);
        else
        {
            FindTransformed(b, clusterB, planes, &transformed);
            // The box that was transformed as a box is larger.
            row &= FindRowOverlaps(&a->nodes[nodeA], transformed.around);
        }
        for (; row != 0; row &= row - 1)
        {
            uint32_t clusterA = nodeA * qc_boxLanes + (uint32_t)__builtin_ctz(row);
            uint64_t word = FindBoxOverlaps(&a->clusters[clusterA], transformed.boxes);
            found[count] = (ClusterPair){word, clusterA, clusterB};
            count += word != 0;
        }
    }
    return AddClusterPairs(planes, found, count, pairs);
}

#endif
