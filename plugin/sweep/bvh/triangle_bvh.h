// What the sweep over triangles keeps of a body: its triangles laid together (clusters.h), boxes around them on several
// levels, and its vertices in single precision. Made once per topology, fitted whenever the body has moved.
#ifndef QC_SWEEP_BVH_TRIANGLE_BVH_H
#define QC_SWEEP_BVH_TRIANGLE_BVH_H

#include "scene/bodies.h"
#include "mesh/clusters.h"
#include "mesh/flat_patches.h"
#include "mesh/vertex_fans.h"
#include "kernels/triangle_kernels.h"

enum
{
    // 2^32 triangles by 8 a level, and one level more for nodes that are not full.
    qc_maxLevels = 12
};

typedef struct qcTriangleBvh
{
    uint32_t generation; ///< of the body that this is; 0: none
    qcClusters clusters;
    uint32_t vertexCount; ///< that triangles have
    qcArray vertexOf;     ///< uint32_t: the body's number of each, in the order in which clusters have them
    qcArray corners;      ///< of qcCorners by place; where there is no triangle, the vertex vertexCount
    qcArray points;       ///< of qcPoint by vertex; one more, at 0
    qcFlatPatches discs;
    qcVertexFans stars; ///< made when neighbours are first asked for
    qcArray quiet;   ///< uint8_t by vertex: no features of its star without a common vertex are near, as it is fitted
    qcArray flat;    ///< uint8_t by disc: whether it is known to be flat where the body is
    qcArray rest;    ///< uint8_t by disc: how many more times it need not be asked
    qcArray groups;  ///< of qcBox8: triangles of clusters, clusters of nodes, and so on
    uint32_t levels; ///< of groups; the last has one group
    size_t firstGroup[qc_maxLevels];
    size_t groupCount[qc_maxLevels];
    qcBox8 whole; ///< one box, around all
    bool related; ///< clusters have links, and there are discs: what pairs within the surface take
    bool fitted;
    uint64_t fits;  ///< how many times
    bool isLocal;   ///< fitted to the local positions of a rigid body, without a margin: valid wherever it goes
    bool flatKnown; ///< of this fit
    uint64_t moved; ///< what was fitted, and with which margin
    double margin;
    qcLatticeTransform map;
    double limit[3];    ///< of the lattice: x + margin - origin may be as much
    float pointError;   ///< of coordinates of points
    qcArray noted;      ///< double, three a vertex of the body: where it was noted (sweep/bvh/partial_refit.h), or none
    qcArray nameOf;     ///< uint32_t by vertex of the body: its number here, or vertexCount
    qcArray strayed;    ///< uint32_t: vertices that are not where they were noted
    qcArray placeMarks; ///< uint8_t by place: qcMotionMark since then
    double keptMargin;  ///< up to which its pairs with itself are kept from there (sweep/bvh/verlet_list.h)
} qcTriangleBvh;

/// Memory that fitting takes, for surfaces one after another.
typedef struct qcBvhScratch
{
    qcArray positions; ///< double, three a vertex: of a rigid body in the world
    qcArray vertices;  ///< of qcBoxRow
    qcArray rows;      ///< of qcBoxRow: of the groups of all levels
} qcBvhScratch;

/// For a body with triangles, related if the body meets itself. O(triangles log triangles). On failure nothing is left.
qcStatus qcTriangleBvh_Build(qcTriangleBvh* surface, const qcBody* body, uint32_t threads);

/// Makes ready for pairs within the surface, once for all; the body is the one that it was built for. O(pairs of
/// neighbours).
qcStatus qcTriangleBvh_Relate(qcTriangleBvh* surface, const qcBody* body, uint32_t threads);

/// Boxes and points of where the body is now; nothing is done where they are that already. Boxes are larger by the
/// margin at their upper ends. A rigid body that isn't tested with itself is fitted once, in local coordinates, unless
/// its transform nearly flattens it. `fits` is false where no lattice can hold the body (it is too large for doubles).
/// O(triangles).
qcStatus qcTriangleBvh_Fit(qcTriangleBvh* surface, const qcBody* body, double margin, const qcTriangleKernels* kernels,
                           uint32_t threads, qcBvhScratch* scratch, bool* fits);

/// Whether qcTriangleBvh_Fit has nothing to do.
bool qcTriangleBvh_IsFitted(const qcTriangleBvh* surface, const qcBody* body, double margin);

/// A margin in the surface's frame, rounded up.
float qcTriangleBvh_Reach(const qcTriangleBvh* surface, double margin);

/// Finds out which discs are flat, once for each fit. O(triangles).
void qcTriangleBvh_FindFlat(qcTriangleBvh* surface, const qcTriangleKernels* kernels, uint32_t threads);

/// Triangles in discs that are known to be flat.
uint64_t qcTriangleBvh_CountFlat(const qcTriangleBvh* surface);

/// What flat discs prove of a node and the other of its link: the pairs of their triangles that both lie in one disc.
/// Returns how many skips there are.
int qcTriangleBvh_FindSkips(const qcTriangleBvh* surface, uint32_t node, uint32_t link,
                            qcPairExclusion skips[qc_maxExclusions]);

static inline bool qcTriangleBvh_IsFlat(const qcTriangleBvh* surface, uint32_t disc)
{
    return QC_AT(uint8_t, surface->flat, disc) != 0;
}

/// The group at a level. Above the last level is one box alone.
static inline const qcBox8* qcTriangleBvh_Group(const qcTriangleBvh* surface, uint32_t level, uint32_t i)
{
    if (level >= surface->levels)
        return &surface->whole;
    return &QC_AT(qcBox8, surface->groups, surface->firstGroup[level] + i);
}

void qcTriangleBvh_Free(qcTriangleBvh* surface);
void qcBvhScratch_Free(qcBvhScratch* scratch);

#endif
