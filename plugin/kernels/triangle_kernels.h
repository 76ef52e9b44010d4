// The inner loops of the sweep over triangles, compiled once for each instruction set and chosen at run time. What each
// computes does not depend on the instruction set, but for the filter, which may keep more pairs or fewer that are
// apart.
//
// Boxes are in a surface's own lattice (sweep/bvh/triangle_bvh.h): 16-bit levels. An upper end is kept as its
// complement, ~upper, so that the box around boxes is one minimum, and two boxes overlap unless one of two such numbers
// is the greater.
#ifndef QC_KERNELS_TRIANGLE_KERNELS_H
#define QC_KERNELS_TRIANGLE_KERNELS_H

#include "mesh/clusters.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum
{
    qc_groupSize = 8,
    // What no level reaches: a box of it alone meets nothing, and adds nothing to a box around it.
    qc_emptyEnd = INT16_MAX
};

/// Eight boxes side by side. By axis: lower ends, then complements of upper ends.
typedef struct qcBox8
{
    int16_t ends[3][2 * qc_groupSize];
} qcBox8;

/// One box, or one vertex: three lower ends, one end that means nothing, three complements of upper ends, another.
typedef struct qcBoxRow
{
    int16_t ends[8];
} qcBoxRow;

/// A vertex in its surface's frame.
typedef struct qcPoint
{
    float x[4]; ///< the last is 0
} qcPoint;

/// From world positions to a surface's frame and lattice.
typedef struct qcLatticeTransform
{
    double origin[4]; ///< the last of each four is 0
    double unit[4];   ///< of points: (x - origin) * unit
    double scale[4];  ///< of levels: (x - origin) * scale, from 0 to 65533
    double margin[4]; ///< upper ends are those of x + margin
} qcLatticeTransform;

/// Which vertices are mapped: vertexOf[i] is the place of vertex i in `positions`, three doubles each.
typedef struct qcVertexRange
{
    const double* positions;
    const uint32_t* vertexOf;
    size_t first, end;
} qcVertexRange;

/// What pairs are found among: groups of triangles, and of the clusters of nodes.
typedef struct qcSurfaceBoxes
{
    const qcBox8 *clusters, *nodes;
} qcSurfaceBoxes;

/// Triangles to be compared: corners by place, points by vertex.
typedef struct qcFilterSide
{
    const qcCorners* corners;
    const qcPoint* points;
} qcFilterSide;

/// In the frame of the first side. Points p of the second are at linear p + shift there.
typedef struct qcDistanceThresholds
{
    float pointError; ///< of a coordinate, of either side, once there
    float reach;      ///< how far apart triangles count
    float margin;     ///< what is no further apart is near. Below 0: neither this nor the next is told
    float beyond;     ///< what is further apart is not near
    bool mapped;      ///< otherwise both sides have one frame
    float linear[3][3], shift[3];
} qcDistanceThresholds;

/// From the lattice of one surface (levels begin at -32768 here), or from its points, to another's lattice (where
/// levels count from 0): what is at x here is within `grow` of linear x + shift there.
typedef struct qcGroupMap
{
    float linear[3][3], shift[3], grow[3];
} qcGroupMap;

/// Another surface than the first, which pairs are found with.
typedef struct qcMappedSurface
{
    qcSurfaceBoxes boxes;
    qcFilterSide triangles;
    qcGroupMap levels; ///< from its lattice to the first's
    qcGroupMap points; ///< from its points to the first's lattice
} qcMappedSurface;

/// Triangles that make a disc, and the vertices of the loop around it, in its direction.
typedef struct qcPatchGeometry
{
    const qcCorners* corners;
    const qcPoint* points;
    const uint32_t *places, *loop;
    size_t placeCount, loopCount; ///< 3 to qc_maxLoop
    float pointError, reach;
} qcPatchGeometry;

/// Of pairs that lie in this order: near ones, those that are farther apart than the margin, and all others.
typedef struct qcApartCounts
{
    size_t near, apart, count; ///< the last: of all that are kept
} qcApartCounts;

enum
{
    qc_featurePairs = 16
};

/// Pairs of triangles A and B, not of one surface's points: their corners, seen from the first of A.
typedef struct qcFeaturePairs
{
    float corner[5][3][qc_featurePairs]; ///< the second and the third of A, those of B
    float margin[qc_featurePairs];
} qcFeaturePairs;

/// Of a pair, what may be within its margin: bits of the corners of A beside B's face, of the corners of B beside A's,
/// and of edges.
typedef uint16_t qcFeatureMask;

enum
{
    qc_nearCornersOfB = 3,
    qc_nearEdges = 6 ///< bit 6 + 3 i + k: edge i of A, from its corner i to the next, and edge k of B
};

typedef struct qcTriangleKernels
{
    const char* name;
    /// Vertices into points and rows.
    void (*map)(const qcLatticeTransform* map, const qcVertexRange* range, qcPoint* points, qcBoxRow* rows);
    /// Groups first .. end of eight triangles each, and a row around each group. `vertices` are rows too.
    void (*fitTriangles)(const qcCorners* corners, const qcBoxRow* vertices, size_t first, size_t end, qcBox8* groups,
                         qcBoxRow* rows);
    /// Groups first .. end of eight rows each, and a row around each group.
    void (*fitGroups)(const qcBoxRow* children, size_t first, size_t end, qcBox8* groups, qcBoxRow* rows);
    /// Bit i + 8 j: box i of a and box j of b overlap.
    uint64_t (*compare)(const qcBox8* a, const qcBox8* b);
    /// Adds the pairs of triangles of two nodes whose boxes overlap, and whose bit is set in `table` (packed, as in
    /// qcClusters; null: all are), and that none of the `skipCount` skips has. Returns the new end of `pairs`, which
    /// has room for qc_nodeSize^2.
    qcSlotPair* (*collect)(const qcSurfaceBoxes* a, uint32_t nodeA, const qcSurfaceBoxes* b, uint32_t nodeB,
                           const uint64_t* table, const qcPairExclusion* skips, int skipCount, qcSlotPair* pairs);
    /// True: no two features (vertices, edges, triangles) of the disc that have no vertex in common come within the
    /// reach of each other; with none, no two triangles that share no vertex have a common point.
    bool (*isFlat)(const qcPatchGeometry* disc);
    /// The boxes of a group in another lattice, rounded outward. What the map can't tell is unbounded.
    void (*mapGroup)(const qcBox8* group, const qcGroupMap* map, qcBox8* mapped);
    /// The boxes of a cluster's triangles in another lattice, from their corners, rounded outward: smaller than those
    /// that mapGroup makes of boxes.
    void (*mapTriangles)(const qcMappedSurface* surface, uint32_t cluster, qcBox8* mapped);
    /// As collect, for two surfaces.
    qcSlotPair* (*collectMapped)(const qcSurfaceBoxes* a, uint32_t nodeA, const qcMappedSurface* b, uint32_t nodeB,
                                 qcSlotPair* pairs);
    /// Keeps of `pairs` those that may be within the reach; their number is returned. The order stays.
    size_t (*filter)(const qcFilterSide* a, const qcFilterSide* b, const qcDistanceThresholds* bound, qcSlotPair* pairs,
                     size_t count);
    /// Puts first those of `pairs` that surely are apart by no more than the margin, next those that surely are by
    /// more, and drops what surely is farther apart than the reach.
    qcApartCounts (*part)(const qcFilterSide* a, const qcFilterSide* b, const qcDistanceThresholds* bound,
                          qcSlotPair* pairs, size_t count);
    /// Keeps of pairs of one side, all of which share vertices, those whose other features (vertices, edges, triangles
    /// without a common vertex) may be within the reach of each other. No more than qc_nodeSize^2 pairs.
    size_t (*keepNearNeighbours)(const qcFilterSide* side, const qcDistanceThresholds* bound, qcSlotPair* pairs,
                                 size_t count);
    /// A bit for each star of a batch (mesh/vertex_fans.h): true where no two features of it (vertices, edges,
    /// triangles) that have no vertex in common are within the reach of each other.
    uint32_t (*findQuietStars)(const qcPoint* points, const uint32_t* vertices, uint32_t valence,
                               const qcDistanceThresholds* bound);
    /// Puts first those of `pairs` that surely penetrate, whatever the reach; their number is returned.
    size_t (*findPiercing)(const qcFilterSide* a, const qcFilterSide* b, const qcDistanceThresholds* bound,
                           qcSlotPair* pairs, size_t count);
    /// A corner and a face whose bit is not set are farther apart than the margin, by more than double arithmetic
    /// rounds their distance; so are two edges, or an end of one is a closest point.
    void (*findNearFeatures)(const qcFeaturePairs* pairs, qcFeatureMask near[qc_featurePairs]);
} qcTriangleKernels;

extern const qcTriangleKernels qcTriangleKernels_scalar;
#ifdef QC_KERNELS_X86
extern const qcTriangleKernels qcTriangleKernels_avx2, qcTriangleKernels_avx512;
#endif

/// The best that this machine runs. The environment's QC_KERNELS (plain, avx2, avx512) names another.
const qcTriangleKernels* qcTriangleKernels_Get(void);

/// All that this machine runs, for tests: the i-th, or null.
const qcTriangleKernels* qcTriangleKernels_Nth(size_t i);

#endif
