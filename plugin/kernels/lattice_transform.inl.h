// The kernels that transform boxes of one BVH to the lattice of another, and compare them there. Boxes of clusters are
// transformed as boxes: cheap, but larger than necessary. Boxes of triangles are computed from the corners: between
// rotated bunnies, half as many pairs of triangles then reach the filter.
//
// The rounding is in `grow`. If it is infinite, the transform is useless: ends are then infinite or NaN, and both are
// clamped to the ends of the lattice. Proof: plugin/docs/proofs/bvh_pairs.md.
#ifndef QC_KERNELS_LATTICE_TRANSFORM_INL_H
#define QC_KERNELS_LATTICE_TRANSFORM_INL_H

#include "kernels/separating_axis.inl.h"

// Eight lanes for every instruction set: the compiler splits them where necessary.
typedef float EightFloats __attribute__((vector_size(32)));
typedef int32_t EightInts __attribute__((vector_size(32)));
typedef int16_t EightShorts __attribute__((vector_size(16)));

QC_INLINE EightFloats SelectEight(EightInts mask, EightFloats yes, EightFloats no)
{
    return (EightFloats)((mask & (EightInts)yes) | (~mask & (EightInts)no));
}

/// Clamps to levels, 0 to 65533. NaN becomes 0.
QC_INLINE EightFloats ClampLower(EightFloats level)
{
    const EightFloats zero = {0}, largest = zero + 65533.0f;
    level = SelectEight(level > zero, level, zero);
    return SelectEight(level < largest, level, largest);
}

/// Clamps to levels. NaN becomes 65533.
QC_INLINE EightFloats ClampUpper(EightFloats level)
{
    const EightFloats zero = {0}, largest = zero + 65533.0f;
    level = SelectEight(level < largest, level, largest);
    return SelectEight(level > zero, level, zero);
}

QC_INLINE EightShorts LoadEnds(const int16_t* ends)
{
    EightShorts loaded;
    memcpy(&loaded, ends, sizeof loaded);
    return loaded;
}

/// Stores the ends of boxes along an axis. Boxes that are empty in `source` stay empty.
QC_INLINE void StoreEnds(EightFloats lower, EightFloats upper, const qcBox8* source, int axis, qcBox8* transformed)
{
    EightInts ends[2] = {__builtin_convertvector(ClampLower(lower), EightInts) - 32768,
                         ~(__builtin_convertvector(ClampUpper(upper), EightInts) - 32768)};
    EightShorts first = LoadEnds(source->ends[0]), empty = first == qc_emptyEnd;
    for (int k = 0; k < 2; k++)
    {
        EightShorts stored = __builtin_convertvector(ends[k], EightShorts);
        stored = (stored & ~empty) | (first & empty);
        memcpy(transformed->ends[axis] + k * qc_boxLanes, &stored, sizeof stored);
    }
}

/// A box with centre c and half extents h goes to one around linear c + shift with half extents |linear| h + grow.
static void TransformBoxes(const qcBox8* boxes, const qcBoxTransform* transform, qcBox8* transformed)
{
    EightFloats centre[3], half[3];
    for (int axis = 0; axis < 3; axis++)
    {
        // A level is an interval, up to the beginning of the next.
        EightInts lower = __builtin_convertvector(LoadEnds(boxes->ends[axis]), EightInts),
                  end = ~__builtin_convertvector(LoadEnds(boxes->ends[axis] + qc_boxLanes), EightInts) + 1;
        centre[axis] = 0.5f * __builtin_convertvector(lower + end, EightFloats);
        half[axis] = 0.5f * __builtin_convertvector(end - lower, EightFloats);
    }
    for (int axis = 0; axis < 3; axis++)
    {
        const float* row = transform->linear[axis];
        float size[3] = {__builtin_fabsf(row[0]), __builtin_fabsf(row[1]), __builtin_fabsf(row[2])};
        EightFloats at = row[0] * centre[0] + row[1] * centre[1] + row[2] * centre[2] + transform->shift[axis];
        EightFloats around = size[0] * half[0] + size[1] * half[1] + size[2] * half[2] + transform->grow[axis];
        StoreEnds(at - around, at + around, boxes, axis, transformed);
    }
}

/// Corner c of a cluster's triangles in the other lattice, by axis, before the shift.
typedef struct TransformedCorners
{
    float x[3][(int)QC_LANES > (int)qc_boxLanes ? (int)QC_LANES : (int)qc_boxLanes];
} TransformedCorners;

QC_INLINE TransformedCorners TransformCorners(const qcTransformedBvh* bvh, uint32_t cluster, int c)
{
    TransformedCorners transformed;
    const qcCorners* corners = bvh->triangles.corners + (size_t)cluster * qc_clusterSize;
    for (int at = 0; at < qc_boxLanes; at += QC_LANES)
    {
        uint32_t vertex[QC_LANES];
        for (int lane = 0; lane < QC_LANES; lane++)
            vertex[lane] = corners[(at + lane) % qc_clusterSize].vertex[c];
        Vectors p = LoadPoints(bvh->triangles.points, vertex);
        for (int axis = 0; axis < 3; axis++)
        {
            const float* row = bvh->points.linear[axis];
            Floats x = p.x * row[0] + p.y * row[1] + p.z * row[2];
            memcpy(transformed.x[axis] + at, &x, sizeof x);
        }
    }
    return transformed;
}

static void TransformTriangles(const qcTransformedBvh* bvh, uint32_t cluster, qcBox8* transformed)
{
    const qcBoxTransform* transform = &bvh->points;
    TransformedCorners corners[3];
    for (int c = 0; c < 3; c++)
        corners[c] = TransformCorners(bvh, cluster, c);
    for (int axis = 0; axis < 3; axis++)
    {
        EightFloats x[3];
        for (int c = 0; c < 3; c++)
            memcpy(&x[c], corners[c].x[axis], sizeof x[c]);
        EightFloats lower = SelectEight(x[0] < x[1], x[0], x[1]), upper = SelectEight(x[0] > x[1], x[0], x[1]);
        lower = SelectEight(lower < x[2], lower, x[2]);
        upper = SelectEight(upper > x[2], upper, x[2]);
        StoreEnds(lower + transform->shift[axis] - transform->grow[axis],
                  upper + transform->shift[axis] + transform->grow[axis], &bvh->boxes.clusters[cluster], axis,
                  transformed);
    }
}

static qcSlotPair* CollectTransformedPairs(const qcBvhBoxes* a, uint32_t nodeA, const qcTransformedBvh* b,
                                           uint32_t nodeB, const qcPlaneTest* planes, qcSlotPair* pairs)
{
    qcBox8 transformed;
    ClusterPair found[qc_pairMaskWords + 1];
    uint32_t count = 0;
    TransformBoxes(&b->boxes.nodes[nodeB], &b->levels, &transformed);
    uint64_t clusters = FindBoxOverlaps(&a->nodes[nodeA], &transformed);
    for (uint32_t j = 0; j < qc_boxLanes; j++)
    {
        uint32_t row = (uint32_t)(clusters >> qc_boxLanes * j) & 0xffu;
        if (row == 0)
            continue;
        uint32_t clusterB = nodeB * qc_boxLanes + j;
        TransformTriangles(b, clusterB, &transformed);
        for (; row != 0; row &= row - 1)
        {
            uint32_t clusterA = nodeA * qc_boxLanes + (uint32_t)__builtin_ctz(row);
            uint64_t word = FindBoxOverlaps(&a->clusters[clusterA], &transformed);
            found[count] = (ClusterPair){word, clusterA, clusterB};
            count += word != 0;
        }
    }
    return AddClusterPairs(planes, found, count, pairs);
}

#endif
