// Patches of a surface that a flat view may prove free of collisions with themselves: discs of triangles around each
// node, and around each four nodes in order. Depends on indices alone: made once per topology. Whether a disc is flat
// where it is now, the kernels tell (kernels/triangle_kernels.h).
#ifndef QC_MESH_FLAT_PATCHES_H
#define QC_MESH_FLAT_PATCHES_H

#include "mesh/adjacency.h"
#include "mesh/clusters.h"

enum
{
    qc_patchNodes = 8, ///< of a large disc
    qc_patchSizes = 2  ///< small, large
};

/// Triangles that make a disc: each inner edge is of two of them, in opposite directions, and the outer edges are one
/// loop that meets no vertex twice.
typedef struct qcFlatPatch
{
    uint32_t firstPlace, placeCount; ///< none: there is no disc
    uint32_t firstLoop, loopCount;
} qcFlatPatch;

/// For two nodes that share a vertex, by size: which triangles of the one are in the disc of the other.
typedef struct qcPatchLoop
{
    uint64_t ofNode[qc_patchSizes];  ///< of the link's other node, in the disc around the node that has the link
    uint64_t ofOther[qc_patchSizes]; ///< of the node, in the disc around the other
} qcPatchLoop;

typedef struct qcFlatPatches
{
    uint32_t nodeCount;
    qcArray discs;  ///< of qcFlatPatch: one a node, then one for each four
    qcArray places; ///< uint32_t
    qcArray loops;  ///< uint32_t: vertices
    qcArray own;    ///< uint64_t, qc_patchSizes a node: which of its triangles are in the disc around it
    qcArray rings;  ///< of qcPatchLoop, one a link
} qcFlatPatches;

/// The large disc around a node.
static inline uint32_t qcFlatPatches_Large(const qcFlatPatches* discs, uint32_t node)
{
    return discs->nodeCount + node / qc_patchNodes;
}

/// `corners` by place, `adjacency` of them; clusters are linked. O(triangles). On failure nothing is left.
qcStatus qcFlatPatches_Build(qcFlatPatches* discs, const qcClusters* clusters, const qcAdjacency* adjacency,
                             const qcCorners* corners, uint32_t vertexCount, uint32_t threads);
void qcFlatPatches_Free(qcFlatPatches* discs);

#endif
