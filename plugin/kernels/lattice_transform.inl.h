// The kernels that bring boxes of one surface to the lattice of another, and compare them there.
//
// Boxes of clusters go there as boxes: cheap, and larger than need be. Boxes of triangles are made there from the
// corners: of bunnies turned in every way barely half as many pairs of triangles then come to the filter.
//
// Rounding is in `grow` (sweep/bvh/bvh_pairs.c). Where it is infinite, a map isn't to be trusted, whatever else it has:
// ends are then infinite or not a number, and both are clamped to the ends of the lattice.
#ifndef QC_KERNELS_LATTICE_TRANSFORM_INL_H
#define QC_KERNELS_LATTICE_TRANSFORM_INL_H

#include "kernels/separating_axis.inl.h"

// As many as a group has boxes, whatever the instruction set: the compiler makes of it what there is.
typedef float EightFloats __attribute__((vector_size(32)));
typedef int32_t EightInts __attribute__((vector_size(32)));
typedef int16_t EightShorts __attribute__((vector_size(16)));

QC_INLINE EightFloats SelectEight(EightInts mask, EightFloats yes, EightFloats no)
{
    return (EightFloats)((mask & (EightInts)yes) | (~mask & (EightInts)no));
}

/// Levels from 0 to 65533; not a number is 0.
QC_INLINE EightFloats ClampLower(EightFloats level)
{
    const EightFloats zero = {0}, most = zero + 65533.0f;
    level = SelectEight(level > zero, level, zero);
    return SelectEight(level < most, level, most);
}

/// As ClampLower, but not a number is 65533.
QC_INLINE EightFloats ClampUpper(EightFloats level)
{
    const EightFloats zero = {0}, most = zero + 65533.0f;
    level = SelectEight(level < most, level, most);
    return SelectEight(level > zero, level, zero);
}

QC_INLINE EightShorts LoadEnds(const int16_t* ends)
{
    EightShorts loaded;
    memcpy(&loaded, ends, sizeof loaded);
    return loaded;
}

/// Ends of boxes along an axis; those that are empty in `group` stay so.
QC_INLINE void StoreEnds(EightFloats lower, EightFloats upper, const qcBox8* group, int axis, qcBox8* mapped)
{
    EightInts ends[2] = {__builtin_convertvector(ClampLower(lower), EightInts) - 32768,
                         ~(__builtin_convertvector(ClampUpper(upper), EightInts) - 32768)};
    EightShorts first = LoadEnds(group->ends[0]), empty = first == qc_emptyEnd;
    for (int k = 0; k < 2; k++)
    {
        EightShorts stored = __builtin_convertvector(ends[k], EightShorts);
        stored = (stored & ~empty) | (first & empty);
        memcpy(mapped->ends[axis] + k * qc_boxLanes, &stored, sizeof stored);
    }
}

/// A box with centre c and half extents e goes to one around linear c + shift, with |linear| e.
static void TransformBoxes(const qcBox8* group, const qcBoxTransform* map, qcBox8* mapped)
{
    EightFloats centre[3], half[3];
    for (int axis = 0; axis < 3; axis++)
    {
        // A level is an interval: up to where the next begins.
        EightInts lower = __builtin_convertvector(LoadEnds(group->ends[axis]), EightInts),
                  end = ~__builtin_convertvector(LoadEnds(group->ends[axis] + qc_boxLanes), EightInts) + 1;
        centre[axis] = 0.5f * __builtin_convertvector(lower + end, EightFloats);
        half[axis] = 0.5f * __builtin_convertvector(end - lower, EightFloats);
    }
    for (int axis = 0; axis < 3; axis++)
    {
        const float* row = map->linear[axis];
        float size[3] = {__builtin_fabsf(row[0]), __builtin_fabsf(row[1]), __builtin_fabsf(row[2])};
        EightFloats at = row[0] * centre[0] + row[1] * centre[1] + row[2] * centre[2] + map->shift[axis];
        EightFloats around = size[0] * half[0] + size[1] * half[1] + size[2] * half[2] + map->grow[axis];
        StoreEnds(at - around, at + around, group, axis, mapped);
    }
}

/// Where corner c of the triangles of a cluster is, along an axis, before the shift.
typedef struct TransformedCorners
{
    float x[3][(int)QC_LANES > (int)qc_boxLanes ? (int)QC_LANES : (int)qc_boxLanes];
} TransformedCorners;

QC_INLINE TransformedCorners TransformCorners(const qcTransformedBvh* surface, uint32_t cluster, int c)
{
    TransformedCorners mapped;
    const qcCorners* corners = surface->triangles.corners + (size_t)cluster * qc_clusterSize;
    for (int at = 0; at < qc_boxLanes; at += QC_LANES)
    {
        uint32_t vertex[QC_LANES];
        for (int lane = 0; lane < QC_LANES; lane++)
            vertex[lane] = corners[(at + lane) % qc_clusterSize].vertex[c];
        Vectors p = LoadPoints(surface->triangles.points, vertex);
        for (int axis = 0; axis < 3; axis++)
        {
            const float* row = surface->points.linear[axis];
            Floats x = p.x * row[0] + p.y * row[1] + p.z * row[2];
            memcpy(mapped.x[axis] + at, &x, sizeof x);
        }
    }
    return mapped;
}

static void TransformTriangles(const qcTransformedBvh* surface, uint32_t cluster, qcBox8* mapped)
{
    const qcBoxTransform* map = &surface->points;
    TransformedCorners corners[3];
    for (int c = 0; c < 3; c++)
        corners[c] = TransformCorners(surface, cluster, c);
    for (int axis = 0; axis < 3; axis++)
    {
        EightFloats x[3];
        for (int c = 0; c < 3; c++)
            memcpy(&x[c], corners[c].x[axis], sizeof x[c]);
        EightFloats lower = SelectEight(x[0] < x[1], x[0], x[1]), upper = SelectEight(x[0] > x[1], x[0], x[1]);
        lower = SelectEight(lower < x[2], lower, x[2]);
        upper = SelectEight(upper > x[2], upper, x[2]);
        StoreEnds(lower + map->shift[axis] - map->grow[axis], upper + map->shift[axis] + map->grow[axis],
                  &surface->boxes.clusters[cluster], axis, mapped);
    }
}

static qcSlotPair* CollectTransformedPairs(const qcBvhBoxes* a, uint32_t nodeA, const qcTransformedBvh* b,
                                           uint32_t nodeB, qcSlotPair* pairs)
{
    qcBox8 mapped;
    TransformBoxes(&b->boxes.nodes[nodeB], &b->levels, &mapped);
    uint64_t clusters = FindBoxOverlaps(&a->nodes[nodeA], &mapped);
    for (uint32_t j = 0; j < qc_boxLanes; j++)
    {
        uint32_t row = (uint32_t)(clusters >> qc_boxLanes * j) & 0xffu;
        if (row == 0)
            continue;
        uint32_t clusterB = nodeB * qc_boxLanes + j;
        TransformTriangles(b, clusterB, &mapped);
        for (; row != 0; row &= row - 1)
        {
            size_t clusterA = (size_t)nodeA * qc_boxLanes + (uint32_t)__builtin_ctz(row);
            pairs = AddPairs(FindBoxOverlaps(&a->clusters[clusterA], &mapped), clusterA, clusterB, pairs);
        }
    }
    return pairs;
}

#endif
