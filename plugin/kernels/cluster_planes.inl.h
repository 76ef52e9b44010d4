// The planes of two clusters' triangles against each other's, several pairs at a time: corners side by side are cached
// by cluster, and lanes picked from them. Planes separate most pairs whose boxes overlap. Proof:
// plugin/docs/proofs/cluster_planes.md.
// The source of an instruction set defines before: PlaneFloats and PlaneInts (qc_planeLanes of them, 4 or 8),
// LoadPlanePoints (a corner of each of qc_planeLanes triangles to four vectors), FindApart (a bit for each lane whose
// three products are above the upper end or below the lower one), MinPlane, MaxPlane, PickLanes (of eight floats),
// StoreShorts, LoadNumbers (bytes to lanes), and AddListed (the listed pairs whose bits are set, as i + 8 j from the
// first on; may write qc_planeLanes pairs).
#ifndef QC_KERNELS_CLUSTER_PLANES_INL_H
#define QC_KERNELS_CLUSTER_PLANES_INL_H

#include "kernels/triangle_kernels.h"

typedef struct PlaneVectors
{
    PlaneFloats x, y, z;
} PlaneVectors;

QC_INLINE PlaneFloats LoadLanes(const float* lanes)
{
    PlaneFloats loaded;
    memcpy(&loaded, lanes, sizeof loaded);
    return loaded;
}

QC_INLINE void StoreLanes(PlaneFloats x, float* lanes)
{
    memcpy(lanes, &x, sizeof x);
}

QC_INLINE PlaneFloats DotPlanes(PlaneVectors a, PlaneVectors b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Corner c of triangles, in the frame of the first BVH.
QC_INLINE PlaneVectors LoadCorner(const qcPlaneTest* test, int side, const qcCorners* corners, int c)
{
    PlaneFloats p[4], x[3];
    LoadPlanePoints(test->sides[side].points, corners, c, p);
    if (side == 0 || !test->thresholds->isTransformed)
        return (PlaneVectors){p[0], p[1], p[2]};
    for (int i = 0; i < 3; i++)
    {
        const float* row = test->thresholds->linear[i];
        x[i] = p[0] * row[0] + p[1] * row[1] + p[2] * row[2] + test->thresholds->shift[i];
    }
    return (PlaneVectors){x[0], x[1], x[2]};
}

QC_INLINE PlaneFloats AbsoluteLanes(PlaneFloats x)
{
    return (PlaneFloats)((PlaneInts)x & 0x7fffffff);
}

/// An upper bound of the length of a vector, at most 5 % larger: (s + x^2 / s) / 2 is at least |x| for any s.
/// `sum`: of its absolute coordinates, 1 to 1.73 times its length.
QC_INLINE PlaneFloats MaxLength(PlaneVectors x, PlaneFloats sum)
{
    PlaneFloats estimate = 0.77f * sum;
    return 0.5f * (estimate + DotPlanes(x, x) / estimate);
}

/// NaN for triangles with a coordinate above 1: added to a corner, it keeps planes from separating them. 0 for others.
QC_INLINE PlaneFloats FindOutliers(const qcPlaneTest* test, int side, const qcCorners* corners)
{
    PlaneFloats size = {0};
    for (int c = 0; c < 3; c++)
    {
        PlaneFloats p[4];
        LoadPlanePoints(test->sides[side].points, corners, c, p);
        for (int axis = 0; axis < 3; axis++)
            size = MaxPlane(size, AbsoluteLanes(p[axis]));
    }
    return (PlaneFloats)(PlaneInts)(size > 1.0f);
}

/// Triangles at .. at + qc_planeLanes - 1 of a cluster.
QC_INLINE void FillLanes(const qcPlaneTest* test, int side, const qcCorners* corners, int at, qcClusterPlanes* planes)
{
    PlaneVectors p[3];
    PlaneFloats outlier = {0};
    if (test->thresholds->hasOutliers)
        outlier = FindOutliers(test, side, corners + at);
    for (int c = 0; c < 3; c++)
    {
        p[c] = LoadCorner(test, side, corners + at, c);
        p[c] = (PlaneVectors){p[c].x + outlier, p[c].y + outlier, p[c].z + outlier};
        StoreLanes(p[c].x, planes->corner[c][0] + at);
        StoreLanes(p[c].y, planes->corner[c][1] + at);
        StoreLanes(p[c].z, planes->corner[c][2] + at);
    }
    PlaneVectors u = {p[1].x - p[0].x, p[1].y - p[0].y, p[1].z - p[0].z};
    PlaneVectors v = {p[2].x - p[0].x, p[2].y - p[0].y, p[2].z - p[0].z};
    PlaneVectors n = {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    PlaneFloats x[3] = {DotPlanes(n, p[0]), DotPlanes(n, p[1]), DotPlanes(n, p[2])};
    PlaneFloats size = AbsoluteLanes(n.x) + AbsoluteLanes(n.y) + AbsoluteLanes(n.z);
    const qcDistanceThresholds* thresholds = test->thresholds;
    PlaneFloats margin = size * (4.0f * thresholds->pointError * 1.0001f + 12.0f * 0x1p-24f) +
                         MaxLength(n, size) * (thresholds->query * 1.0001f);
    // Normals so short that products may underflow separate nothing.
    const PlaneFloats infinite = (PlaneFloats){0} + INFINITY;
    PlaneInts isShort = ~(size > 1e-15f);
    margin = (PlaneFloats)(((PlaneInts)margin & ~isShort) | ((PlaneInts)infinite & isShort));
    StoreLanes(n.x, planes->normal[0] + at);
    StoreLanes(n.y, planes->normal[1] + at);
    StoreLanes(n.z, planes->normal[2] + at);
    StoreLanes(MinPlane(x[0], MinPlane(x[1], x[2])) - margin, planes->lower + at);
    StoreLanes(MaxPlane(x[0], MaxPlane(x[1], x[2])) + margin, planes->upper + at);
}

static __attribute__((noinline)) void FillPlanes(const qcPlaneTest* test, int side, uint32_t cluster,
                                                 qcClusterPlanes* planes)
{
    for (int at = 0; at < qc_boxLanes; at += qc_planeLanes)
        FillLanes(test, side, test->sides[side].corners + (size_t)cluster * qc_clusterSize, at, planes);
}

static const qcClusterPlanes* FindPlanes(const qcPlaneTest* test, int side, uint32_t cluster)
{
    uint32_t entry = cluster % qc_planeCacheSize;
    uint64_t key = test->key | cluster;
    if (test->cache->keys[side][entry] != key)
    {
        test->cache->keys[side][entry] = key;
        FillPlanes(test, side, cluster, &test->cache->planes[side][entry]);
    }
    return &test->cache->planes[side][entry];
}

/// A bit for each of qc_planeLanes pairs, triangles i of a and j of b, that neither triangle's plane separates.
QC_INLINE uint32_t FindUnseparated(const qcClusterPlanes* a, const qcClusterPlanes* b, PlaneInts i, PlaneInts j)
{
    PlaneFloats x[3], y[3];
    PlaneVectors n = {PickLanes(b->normal[0], j), PickLanes(b->normal[1], j), PickLanes(b->normal[2], j)};
    PlaneVectors m = {PickLanes(a->normal[0], i), PickLanes(a->normal[1], i), PickLanes(a->normal[2], i)};
    for (int c = 0; c < 3; c++)
    {
        PlaneVectors p = {PickLanes(a->corner[c][0], i), PickLanes(a->corner[c][1], i), PickLanes(a->corner[c][2], i)};
        PlaneVectors q = {PickLanes(b->corner[c][0], j), PickLanes(b->corner[c][1], j), PickLanes(b->corner[c][2], j)};
        x[c] = DotPlanes(n, p);
        y[c] = DotPlanes(m, q);
    }
    return ~(FindApart(x, PickLanes(b->lower, j), PickLanes(b->upper, j)) |
             FindApart(y, PickLanes(a->lower, i), PickLanes(a->upper, i)));
}

/// Pairs of triangles of two clusters: bit i + 8 j.
typedef struct ClusterPair
{
    uint64_t pairs;
    uint32_t a, b;
} ClusterPair;

/// Removes the lowest bits, qc_planeLanes of them if there are so many, and lists their numbers. Returns a bit for
/// each.
QC_INLINE uint32_t ListPairs(uint64_t* pairs, uint8_t listed[qc_planeLanes])
{
    uint32_t used = (uint32_t)__builtin_popcountll(*pairs);
    // No branch: how many there are follows no pattern.
    for (int lane = 0; lane < qc_planeLanes; lane++)
    {
        listed[lane] = (uint8_t)__builtin_ctzll(*pairs | UINT64_C(1) << 63);
        *pairs &= *pairs - 1;
    }
    return used < qc_planeLanes ? (1u << used) - 1 : (1u << qc_planeLanes) - 1;
}

/// Adds the pairs of triangles that neither's plane separates. There is a pair of clusters at least. The clusters are
/// those of one leaf node of each side: no two of a side share a cache entry.
static qcSlotPair* AddUnseparatedPairs(const qcPlaneTest* test, const ClusterPair* clusters, uint32_t count,
                                       qcSlotPair* pairs)
{
    // Within one BVH both sides share entries, unless those of the two nodes are the same.
    uint32_t apart = (clusters[0].a ^ clusters[0].b) / qc_boxLanes;
    int sideB = test->isOne && (apart == 0 || apart % (qc_planeCacheSize / qc_boxLanes) != 0) ? 0 : 1;
    for (uint32_t k = 0; k < count; k++)
    {
        const qcClusterPlanes *a = FindPlanes(test, 0, clusters[k].a), *b = FindPlanes(test, sideB, clusters[k].b);
        const qcSlotPair first = {clusters[k].a * qc_clusterSize, clusters[k].b * qc_clusterSize};
        for (uint64_t left = clusters[k].pairs; left != 0;)
        {
            uint8_t listed[qc_planeLanes];
            uint32_t used = ListPairs(&left, listed);
            PlaneInts at = LoadNumbers(listed);
            pairs = AddListed(used & FindUnseparated(a, b, at & (qc_clusterSize - 1), at / qc_clusterSize), listed,
                              first, pairs);
        }
    }
    return pairs;
}

/// Adds the pairs of triangles of the clusters of two leaf nodes.
QC_INLINE qcSlotPair* AddClusterPairs(const qcPlaneTest* planes, const ClusterPair* clusters, uint32_t count,
                                      qcSlotPair* pairs)
{
    if (planes != NULL && count != 0)
        return AddUnseparatedPairs(planes, clusters, count, pairs);
    for (uint32_t i = 0; i < count; i++)
        pairs = AddPairs(clusters[i].pairs, clusters[i].a, clusters[i].b, pairs);
    return pairs;
}

#endif
