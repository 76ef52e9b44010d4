// A bounding volume hierarchy over a body's triangles: clusters of 8, leaf nodes of 8 clusters (mesh/clusters.h), 8
// children a node above. Its boxes lie on a 16-bit lattice; its vertices are also stored in single precision. Built
// once per topology, fitted whenever the body has moved.
#ifndef QC_SWEEP_BVH_TRIANGLE_BVH_H
#define QC_SWEEP_BVH_TRIANGLE_BVH_H

#include "mesh/clusters.h"
#include "sweep/bvh/bvh_region.h"
#include "kernels/triangle_kernels.h"

enum
{
    // 2^32 triangles by 8 a level, and one level more for nodes that are not full.
    qc_maxLevels = 12
};

/// The geometry of a BVH at one set of positions.
typedef struct qcBvhFit
{
    qcArray points; ///< of qcPoint by vertex; one more, at 0, for slots without a triangle
    qcArray boxes;  ///< of qcBox8: triangles of clusters, clusters of leaf nodes, and so on
    qcBox8 root;    ///< one box around all
    bool fitted;
    /// Boxes and points of leaf nodes are fitted on demand: those of the marked nodes are valid, the others are not.
    bool isOutline;
    qcArray fittedNodes;  ///< uint8_t by leaf node, of an outline
    uint32_t fittedCount; ///< of them
    bool isLocal;         ///< in the local coordinates of a rigid body, without a margin: valid wherever it moves
    uint64_t fitCount;    ///< qcTriangleBvh::fitCount at the fit or partial refit
    uint64_t revision;    ///< qcBody::moved of the positions
    double margin;
    qcLatticeTransform lattice;
    double latticeExtent[3]; ///< max of x + margin - origin, without outliers
    bool isCoarse;           ///< many triangles are small beside the levels, or there are outliers
    float pointError;        ///< max error of a coordinate of points; times its absolute value where that is above 1
} qcBvhFit;

/// The sum of the extents of boxes, at the first and the last fit that was measured.
typedef struct qcBvhExtent
{
    double first, last;
    uint64_t measuredFit; ///< qcTriangleBvh::fitCount of the latter
} qcBvhExtent;

typedef struct qcTriangleBvh
{
    //  Topology.
    uint32_t generation; ///< of the body that it was built for; 0: none
    qcClusters clusters;
    uint32_t vertexCount; ///< vertices with a triangle
    qcArray vertexOf;     ///< uint32_t by vertex: its index in the body. Vertices are in the order of the clusters
    qcArray corners;      ///< of qcCorners by slot; vertexCount three times in a slot without a triangle
    uint32_t levels;      ///< of boxes; the last has one qcBox8
    size_t firstBox8[qc_maxLevels];
    size_t box8Count[qc_maxLevels];
    size_t totalBox8Count;
    qcNodeVertices nodeVertices; ///< listed by the first outline
    qcBvhRegion* region;         ///< triangles outside are not in the BVH. Null: all triangles are
    bool leavesRegion;           ///< the BVH needs all triangles
    double triangleSize;         ///< the median at the build. 0: unknown

    uint64_t fitCount;         ///< fits and partial refits so far
    qcBvhExtent clusterExtent; ///< of the boxes of all clusters, at whole fits in the world
    qcBvhExtent nodeExtent;    ///< of the boxes of all leaf nodes, at outlines
    uint32_t wholeFits;        ///< fits until an outline pays again
    qcBvhFit fit;              ///< to the present positions
    qcBvhFit startFit;         ///< to those of the start of a motion; unused where they are equal, and for local fits
} qcTriangleBvh;

/// Memory for fitting, reused for one BVH after another.
typedef struct qcBvhScratch
{
    qcArray positions; ///< double, three a vertex: a rigid body's, in the world
    qcArray vertices;  ///< of qcBoxRow
    qcArray rows;      ///< of qcBoxRow: around each qcBox8 of all levels
    qcArray marks;     ///< uint8_t by block of vertices: they belong to a node that is fitted
} qcBvhScratch;

/// For a body with triangles; options.region, if it is not null, is that of a qcBvhRegion. O(triangles log triangles).
/// On failure nothing is left.
qcStatus qcTriangleBvh_Build(qcTriangleBvh* bvh, const qcBody* body, const qcOrderOptions* options);
/// Like qcTriangleBvh_Build, in the order of another body's BVH, which suits the body (sweep/bvh/bvh_copy.h) and has no
/// region. O(triangles), at the speed of memory.
qcStatus qcTriangleBvh_BuildLike(qcTriangleBvh* bvh, const qcBody* body, const qcTriangleBvh* other);
/// Stores the region that the BVH was built for, at the same positions, if the BVH is limited to it.
qcStatus qcTriangleBvh_KeepRegion(qcTriangleBvh* bvh, const qcBody* body, const qcBvhRegion* region);

/// Adds the triangles that a limited BVH lacks; it has to be fitted anew. options.region is around the body. On failure
/// nothing is left.
qcStatus qcTriangleBvh_Complete(qcTriangleBvh* bvh, const qcBody* body, const qcOrderOptions* options);

/// Fits boxes and points to the body's current positions; does nothing if they are up to date. Each box is enlarged by
/// the margin at its upper end. A rigid body without self-collision is fitted once, in local coordinates, unless its
/// transform nearly flattens it. `fits` is false if no lattice suits the body (too large for doubles). O(triangles).
qcStatus qcTriangleBvh_Fit(qcTriangleBvh* bvh, const qcBody* body, double margin, const qcTriangleKernels* kernels,
                           uint32_t threads, qcBvhScratch* scratch, bool* fits);

/// Like qcTriangleBvh_Fit for a body in world coordinates, but leaves leaf nodes without boxes and points. All boxes
/// above them are equal. O(vertices).
qcStatus qcTriangleBvh_FitOutline(qcTriangleBvh* bvh, const qcBody* body, double margin,
                                  const qcTriangleKernels* kernels, uint32_t threads, qcBvhScratch* scratch,
                                  bool* fits);

/// Fits the flagged leaf nodes of an outline that aren't fitted yet, as qcTriangleBvh_Fit does; the body hasn't moved
/// since. O(leaf nodes + vertices of flagged ones).
qcStatus qcTriangleBvh_FitNodes(qcTriangleBvh* bvh, const qcBody* body, const uint8_t* flags,
                                const qcTriangleKernels* kernels, uint32_t threads, qcBvhScratch* scratch);

/// Fits the BVH for a motion: `startFit` to the start, `fit` to the present with a margin of 0 or more, or both to
/// local coordinates. The last fit becomes the start's if it is that of these positions.
qcStatus qcTriangleBvh_FitMotion(qcTriangleBvh* bvh, const qcBody* body, const qcTriangleKernels* kernels,
                                 uint32_t threads, qcBvhScratch* scratch, bool* fits);

/// True if qcTriangleBvh_FitMotion has nothing to do.
bool qcTriangleBvh_IsMotionUpToDate(const qcTriangleBvh* bvh, const qcBody* body);

/// The fit to the start of a motion, after qcTriangleBvh_FitMotion.
static inline const qcBvhFit* qcTriangleBvh_StartFit(const qcTriangleBvh* bvh, const qcBody* body)
{
    return bvh->fit.isLocal || !body->start.differs ? &bvh->fit : &bvh->startFit;
}

/// True if qcTriangleBvh_Fit fits the body's BVH in local coordinates, without a margin.
bool qcTriangleBvh_FitsLocally(const qcBody* body);

/// True if qcTriangleBvh_Fit has nothing to do.
bool qcTriangleBvh_IsUpToDate(const qcTriangleBvh* bvh, const qcBody* body, double margin);
/// True if qcTriangleBvh_FitOutline has nothing to do.
bool qcTriangleBvh_IsOutlineUpToDate(const qcTriangleBvh* bvh, const qcBody* body, double margin);

static inline bool qcBvhExtent_HasGrown(const qcBvhExtent* extent)
{
    return extent->first > 0.0 && extent->last > 3.0 * extent->first;
}

/// True if clusters have become so long, since triangles that were close have parted, that a new order pays.
static inline bool qcTriangleBvh_HasGrown(const qcTriangleBvh* bvh)
{
    return qcBvhExtent_HasGrown(&bvh->clusterExtent) || qcBvhExtent_HasGrown(&bvh->nodeExtent);
}

/// Triangles in the BVH, or up to 63 more.
static inline uint32_t qcTriangleBvh_TriangleCount(const qcTriangleBvh* bvh, const qcBody* body)
{
    size_t slots = bvh->clusters.triangles.count;
    return slots < body->triangleCount ? (uint32_t)slots : body->triangleCount;
}

/// A distance in the frame of the points, rounded up.
float qcTriangleBvh_DistanceInFrame(const qcTriangleBvh* bvh, double distance);

/// The boxes of the two lowest levels.
static inline qcBvhBoxes qcTriangleBvh_Boxes(const qcTriangleBvh* bvh, const qcBvhFit* fit)
{
    const qcBox8* boxes = fit->boxes.data;
    return (qcBvhBoxes){boxes, boxes + bvh->firstBox8[1]};
}

/// Eight boxes of a level: those of node i's children. Above the last level is the root alone.
static inline const qcBox8* qcTriangleBvh_Box8At(const qcTriangleBvh* bvh, const qcBvhFit* fit, uint32_t level,
                                                 uint32_t i)
{
    if (level >= bvh->levels)
        return &fit->root;
    return &QC_AT(qcBox8, fit->boxes, bvh->firstBox8[level] + i);
}

void qcTriangleBvh_Free(qcTriangleBvh* bvh);
void qcBvhScratch_Free(qcBvhScratch* scratch);

#endif
