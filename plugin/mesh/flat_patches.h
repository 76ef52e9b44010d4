// Patches of a mesh that may be proven free of self-collision when they are nearly flat: one around each leaf node, and
// a large one around each eight nodes in order. They depend on indices alone and are made once per topology; a kernel
// tests whether a patch is flat at the present positions (kernels/triangle_kernels.h).
#ifndef QC_MESH_FLAT_PATCHES_H
#define QC_MESH_FLAT_PATCHES_H

#include "mesh/adjacency.h"
#include "mesh/clusters.h"

enum
{
    qc_patchNodes = 8, ///< of a large patch
    qc_patchSizes = 2  ///< small, large
};

/// Triangles that form a topological disc: each inner edge belongs to two of them, in opposite directions, and the
/// outer edges form one loop that visits no vertex twice.
typedef struct qcFlatPatch
{
    uint32_t firstSlot, slotCount; ///< no slots: there is no patch here
    uint32_t firstLoop, loopCount;
} qcFlatPatch;

/// Two nodes that share a vertex, by size of patches: a bit for each triangle of one node that is in the patch of the
/// other.
typedef struct qcPatchLink
{
    uint64_t ofNode[qc_patchSizes];  ///< of the link's other node, in the patch around the node that has the link
    uint64_t ofOther[qc_patchSizes]; ///< of the node, in the patch around the other
} qcPatchLink;

typedef struct qcFlatPatches
{
    uint32_t nodeCount;
    qcArray patches; ///< of qcFlatPatch: one a node, then one for each qc_patchNodes
    qcArray slots;   ///< uint32_t: the triangles of patches
    qcArray loops;   ///< uint32_t: vertices
    qcArray own;     ///< uint64_t, qc_patchSizes a node: a bit for each of its triangles that is in the patch around it
    qcArray links;   ///< of qcPatchLink, one a link
} qcFlatPatches;

/// Index of the large patch around a node.
static inline uint32_t qcFlatPatches_Large(const qcFlatPatches* patches, uint32_t node)
{
    return patches->nodeCount + node / qc_patchNodes;
}

/// What patches are made from.
typedef struct qcPatchSource
{
    const qcClusters* clusters; ///< with links
    const qcAdjacency* adjacency;
    const qcCorners* corners; ///< by slot
    uint32_t vertexCount;
} qcPatchSource;

/// Patches in the making, in parts, so that no step has to wait for all of them. All zero: none.
typedef struct qcPatchGrowth
{
    struct qcPatchBuilder* builders; ///< qc_patchSizes of them, or null
    uint32_t nextNode;               ///< patches of the nodes before it are made
} qcPatchGrowth;

/// Begins. O(triangles). Free both on failure.
qcStatus qcFlatPatches_Begin(qcFlatPatches* patches, qcPatchGrowth* growth, const qcPatchSource* source);
/// Makes the patches of the next nodes: at least so many, or those that are left; all are made once growth->nextNode is
/// the number of nodes. O(nodes).
qcStatus qcFlatPatches_Grow(qcFlatPatches* patches, qcPatchGrowth* growth, const qcPatchSource* source,
                            uint32_t nodeCount, uint32_t threads);
/// Frees the memory of the making; the patches stay.
void qcPatchGrowth_Free(qcPatchGrowth* growth);
void qcFlatPatches_Free(qcFlatPatches* patches);

#endif
