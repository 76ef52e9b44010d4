// The inner loops of collision detection between triangles, compiled once for each instruction set and chosen at run
// time. Results don't depend on the instruction set, with one exception: rounding differs, so a filter may keep a
// separated pair with one set and drop it with another.
//
// Boxes lie on the lattice of their BVH (sweep/bvh/triangle_bvh.h), in 16-bit levels. The upper end of an interval is
// stored as its complement, ~upper. So the box around boxes is one minimum, and two boxes overlap unless some lower end
// is greater than the other box's upper end.
#ifndef QC_KERNELS_TRIANGLE_KERNELS_H
#define QC_KERNELS_TRIANGLE_KERNELS_H

#include "mesh/clusters.h"
#include "mesh/node_vertices.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum
{
    qc_boxLanes = 8,
    qc_emptyEnd = INT16_MAX ///< above all levels: both ends of an empty box, which overlaps nothing
};

/// Eight boxes side by side. For each axis the lower ends, then the complements of the upper ends.
typedef struct qcBox8
{
    int16_t ends[3][2 * qc_boxLanes];
} qcBox8;

/// One box, or one vertex: three lower ends, one unused, three complements of upper ends, one unused.
typedef struct qcBoxRow
{
    int16_t ends[8];
} qcBoxRow;

/// A vertex in the frame of its BVH: coordinates from 0 to 1, except those of outliers, which may be infinite.
typedef struct qcPoint
{
    float x[4]; ///< the last is 0; qc_emptyEnd in the point of slots without a triangle
} qcPoint;

enum
{
    qc_lastLevel = 65533 ///< of a lattice; the first is 0
};

/// From world positions to the frame and the lattice of a BVH.
typedef struct qcLatticeTransform
{
    double origin[4]; ///< the last of each four is 0
    double unit[4];   ///< to the frame: (x - origin) * unit
    double scale[4];  ///< to the lattice: (x - origin) * scale, from 0 to qc_lastLevel
    double margin[4]; ///< upper ends are those of x + margin
    /// Few vertices may lie outside: levels are clamped, and ends at the first and the last one stand for all beyond.
    bool hasOutliers;
} qcLatticeTransform;

/// Positions of a body's vertices, three numbers each: one of the two is null. vertexOf[i] is the index of vertex i.
typedef struct qcVertexSource
{
    const double* doubles;
    const float* floats; ///< one more float lies behind the last vertex
    const uint32_t* vertexOf;
} qcVertexSource;

/// The vertices to transform.
typedef struct qcVertexRange
{
    qcVertexSource source;
    size_t first, end;
} qcVertexRange;

/// The two lowest levels of a BVH: the boxes of each cluster's triangles, and of each leaf node's clusters.
typedef struct qcBvhBoxes
{
    const qcBox8 *clusters, *nodes;
} qcBvhBoxes;

/// Triangles of one BVH: corners by slot, points by vertex.
typedef struct qcIndexedTriangles
{
    const qcCorners* corners;
    const qcPoint* points;
} qcIndexedTriangles;

/// Distances that pairs are classified by, in the frame of the first triangles. A point p of the second ones is at
/// linear p + shift there.
typedef struct qcDistanceThresholds
{
    float pointError;   ///< max error of a coordinate in that frame
    bool hasOutliers;   ///< of coordinates above 1 in a triangle's own frame: its errors are as many times larger
    float query;        ///< pairs proven farther apart are dropped
    float near;         ///< pairs proven no farther apart are near. Below 0: no classification by distance
    float far;          ///< pairs proven farther apart are separate; at least `near`
    bool isTransformed; ///< false: both have one frame, and linear and shift are unused
    float linear[3][3], shift[3];
} qcDistanceThresholds;

/// From the lattice of one BVH (levels begin at -32768), or from its points, to the lattice of another (levels begin at
/// 0): the image of x is within `grow` of linear x + shift.
typedef struct qcBoxTransform
{
    float linear[3][3], shift[3], grow[3];
    bool isDiagonal;  ///< both lattices have the same axes: `linear` is 0 off its diagonal, and positive on it
    bool hasOutliers; ///< of the first one, see qcLatticeTransform
} qcBoxTransform;

/// The triangles of a cluster side by side, in the frame of a search, and their planes: a triangle lies apart from
/// triangle i, by more than the query distance, if the products of its corners with normal i are all below lower[i] or
/// all above upper[i].
typedef struct qcClusterPlanes
{
    float corner[3][3][qc_boxLanes]; ///< by corner, axis, triangle
    float normal[3][qc_boxLanes];
    float lower[qc_boxLanes], upper[qc_boxLanes];
} qcClusterPlanes;

enum
{
    // 115 KB a side, and 28 KB of boxes: a pair of nodes finds the clusters of the pairs before it.
    qc_planeCacheSize = 256,
    qc_maxCollected = qc_nodeSize * qc_nodeSize + qc_boxLanes ///< the last are written, but not used
};

/// Planes of clusters, by side and cluster number modulo the size, and boxes of triangles that were transformed. A
/// worker's own.
typedef struct qcPlaneCache
{
    uint64_t keys[2][qc_planeCacheSize]; ///< qcPlaneTest::key | cluster; UINT64_MAX: none
    uint64_t boxKeys[qc_planeCacheSize]; ///< likewise, of the second side
    qcClusterPlanes planes[2][qc_planeCacheSize];
    qcBox8 boxes[qc_planeCacheSize];
    qcBoxRow around[qc_planeCacheSize]; ///< around each eight of them
} qcPlaneCache;

/// The triangles of two BVHs whose planes are tested.
typedef struct qcPlaneTest
{
    qcIndexedTriangles sides[2];
    const qcDistanceThresholds* thresholds;
    bool isOne;   ///< both are the same
    uint64_t key; ///< the number of the search, times 2^32
    qcPlaneCache* cache;
} qcPlaneTest;

/// The second of two BVHs, and its transforms to the first.
typedef struct qcTransformedBvh
{
    qcBvhBoxes boxes;
    qcIndexedTriangles triangles;
    qcBoxTransform levels; ///< from its lattice to that of the first
    qcBoxTransform points; ///< from its points to the lattice of the first
} qcTransformedBvh;

/// One of two BVHs of a motion, at the start and at the end. Lattices and frames have world axes: those of a BVH in
/// world coordinates, or those that the other one is transformed to.
typedef struct qcMotionBvh
{
    qcTransformedBvh at[2];         ///< the transforms are unused unless isTransformed
    qcDistanceThresholds frames[2]; ///< query distance 0; the point errors are those of the pair of BVHs
    bool isTransformed;
} qcMotionBvh;

/// A patch of triangles (mesh/flat_patches.h), and the vertices of its boundary loop in order.
typedef struct qcPatchGeometry
{
    const qcCorners* corners;
    const qcPoint* points;
    const uint32_t *slots, *loop;
    size_t slotCount, loopCount; ///< the latter is 3 to qc_maxLoop
    float pointError, query;     ///< as in qcDistanceThresholds
} qcPatchGeometry;

/// Sizes of the classes of pairs, in the order in which the pairs lie: near, separate, undecided.
typedef struct qcClassifiedCounts
{
    size_t nearCount, separateCount;
    size_t count; ///< of all pairs that are kept
} qcClassifiedCounts;

/// Sizes of the classes of pairs, in the order in which the pairs lie: intersecting, undecided.
typedef struct qcRelatedCounts
{
    size_t intersectingCount;
    size_t count; ///< of all pairs that are kept
} qcRelatedCounts;

enum
{
    qc_featurePairs = 16
};

/// Pairs of triangles A and B by their corners, relative to the first corner of A.
typedef struct qcFeaturePairs
{
    float corner[5][3][qc_featurePairs]; ///< the second and the third of A, then those of B
    float margin[qc_featurePairs];       ///< max distance of features
} qcFeaturePairs;

/// The pairs of features of two triangles that may be within the margin: a bit for each corner of A with B's face, each
/// corner of B with A's face, and each two edges.
typedef uint16_t qcFeatureMask;

enum
{
    qc_nearCornersOfB = 3,
    qc_nearEdges = 6 ///< bit 6 + 3 i + k: edge i of A, from its corner i to the next, and edge k of B
};

typedef struct qcTriangleKernels
{
    const char* name;

    //  Boxes.

    /// Vertices to points and rows.
    void (*transformVertices)(const qcLatticeTransform* lattice, const qcVertexRange* range, qcPoint* points,
                              qcBoxRow* rows);
    /// Writes the rows around the vertices of leaf nodes first .. end - 1: those around the rows of transformVertices.
    void (*boundNodes)(const qcLatticeTransform* lattice, const qcVertexSource* source, const qcNodeVertices* vertices,
                       size_t first, size_t end, qcBoxRow* rows);
    /// Fits boxes first .. end - 1 around eight triangles each, and writes the row around each of them. `vertices`: the
    /// rows of transformVertices.
    void (*fitTriangles)(const qcCorners* corners, const qcBoxRow* vertices, size_t first, size_t end, qcBox8* boxes,
                         qcBoxRow* rows);
    /// Packs eight rows each into boxes first .. end - 1, and writes the row around each of them.
    void (*fitBoxes)(const qcBoxRow* children, size_t first, size_t end, qcBox8* boxes, qcBoxRow* rows);
    /// Bit i + 8 j: box i of a and box j of b overlap.
    uint64_t (*findOverlaps)(const qcBox8* a, const qcBox8* b);
    /// Adds the pairs of triangles of two leaf nodes whose boxes overlap, whose bit is set in `pairMasks` (packed, see
    /// qcClusters; null: all bits are set), which no exclusion contains, and which neither triangle's plane separates
    /// (`planes` null: not tested). Returns the new end of `pairs`, which has room for qc_maxCollected more.
    qcSlotPair* (*collectPairs)(const qcBvhBoxes* a, uint32_t nodeA, const qcBvhBoxes* b, uint32_t nodeB,
                                const uint64_t* pairMasks, const qcPairExclusion* exclusions, int exclusionCount,
                                const qcPlaneTest* planes, qcSlotPair* pairs);
    /// Transforms boxes to another lattice, rounded outward. A box that the transform can't bound becomes unbounded.
    void (*transformBoxes)(const qcBox8* boxes, const qcBoxTransform* transform, qcBox8* transformed);
    /// Boxes of a cluster's triangles in another lattice, from their corners, rounded outward: tighter than those of
    /// transformBoxes.
    void (*transformTriangles)(const qcTransformedBvh* bvh, uint32_t cluster, qcBox8* transformed);
    /// Like collectPairs, for two BVHs. `clusters`: the pairs of the nodes' clusters whose boxes overlap, as
    /// findOverlaps gives them.
    qcSlotPair* (*collectTransformedPairs)(const qcBvhBoxes* a, uint32_t nodeA, const qcTransformedBvh* b,
                                           uint32_t nodeB, uint64_t clusters, const qcPlaneTest* planes,
                                           qcSlotPair* pairs);

    //  Pairs of triangles.

    /// Drops pairs that planes, or with a query distance centroids, prove farther apart than it, and keeps the others
    /// in their order. Returns their number.
    size_t (*filter)(const qcIndexedTriangles* a, const qcIndexedTriangles* b, const qcDistanceThresholds* thresholds,
                     qcSlotPair* pairs, size_t count);
    /// Drops pairs that are proven disjoint, and moves to the front the pairs that are proven to intersect in their
    /// interiors. The query distance is 0.
    qcRelatedCounts (*relate)(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                              const qcDistanceThresholds* thresholds, qcSlotPair* pairs, size_t count);
    /// Drops pairs that are proven farther apart than the query distance. Moves to the front the pairs that are proven
    /// disjoint and near, then those proven farther apart than `far`.
    qcClassifiedCounts (*classify)(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                                   const qcDistanceThresholds* thresholds, qcSlotPair* pairs, size_t count);
    /// Moves to the front the pairs that are proven to intersect in their interiors. Returns their number.
    size_t (*findIntersecting)(const qcIndexedTriangles* a, const qcIndexedTriangles* b,
                               const qcDistanceThresholds* thresholds, qcSlotPair* pairs, size_t count);

    //  Self-collision near common vertices.

    /// Keeps those pairs of triangles sharing a vertex whose other features (vertices, edges and faces without a common
    /// vertex) may be within the query distance. At most qc_nodeSize^2 pairs. Returns the number kept.
    size_t (*filterNeighbours)(const qcIndexedTriangles* triangles, const qcDistanceThresholds* thresholds,
                               qcSlotPair* pairs, size_t count);
    /// A bit for each vertex fan of a batch (mesh/vertex_fans.h), set if no two of its features without a common vertex
    /// are within the query distance.
    uint32_t (*findSeparatedFans)(const qcPoint* points, const uint32_t* vertices, uint32_t valence,
                                  const qcDistanceThresholds* thresholds);
    /// True: no two features of the patch without a common vertex are within the query distance. With distance 0, no
    /// two triangles without a common vertex intersect.
    bool (*isPatchFlat)(const qcPatchGeometry* patch);

    /// The pair mask of two leaf nodes of one body (the same or in order), packed, from the vertices of their clusters
    /// and one word more; only words of `clusters` (bit i + 8 j: cluster i of a, cluster j of b) are valid. Returns the
    /// number of pairs of neighbours in these.
    uint32_t (*findPairMask)(const qcClusterVertices* a, const qcClusterVertices* b, uint64_t clusters,
                             uint64_t packed[qc_maxPairMaskSize + 1]);

    //  Motions: pairs that no tested direction separates at both ends, in the same order.

    /// Like findOverlaps; boxes at the start and at the end.
    uint64_t (*findMotionOverlaps)(const qcBox8* const a[2], const qcBox8* const b[2]);
    /// Like collectPairs.
    qcSlotPair* (*collectMotionPairs)(const qcMotionBvh* a, uint32_t nodeA, const qcMotionBvh* b, uint32_t nodeB,
                                      const uint64_t* pairMasks, const qcPairExclusion* exclusions, int exclusionCount,
                                      qcSlotPair* pairs);
    /// Like filter.
    size_t (*filterMotion)(const qcMotionBvh* a, const qcMotionBvh* b, qcSlotPair* pairs, size_t count);
    /// True: no two triangles of the patch without a common vertex meet during the motion. `patches`: at the start and
    /// at the end; times the scales, 1 or smaller powers of two, lengths of both are comparable.
    bool (*isPatchFlatInMotion)(const qcPatchGeometry patches[2], const float scales[2]);

    //  Contacts.

    /// A clear bit proves a corner and a face farther apart than the margin, by more than the rounding error of their
    /// distance in double. For two edges it proves that, or that an end of one is among the closest points.
    void (*findNearFeatures)(const qcFeaturePairs* pairs, qcFeatureMask near[qc_featurePairs]);
} qcTriangleKernels;

extern const qcTriangleKernels qcTriangleKernels_scalar;
#ifdef QC_KERNELS_X86
extern const qcTriangleKernels qcTriangleKernels_avx2, qcTriangleKernels_avx512;
#endif

/// The best that this CPU runs, or the lesser one that the environment's QC_KERNELS names (plain, avx2, avx512).
const qcTriangleKernels* qcTriangleKernels_Get(void);

/// All that this CPU runs, for tests: the i-th, or null.
const qcTriangleKernels* qcTriangleKernels_Nth(size_t i);

#endif
