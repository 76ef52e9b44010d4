// The cluster order: a permutation of a body's triangles in which each 64, and each 8 of these, lie close together.
#ifndef QC_MESH_CLUSTER_ORDER_H
#define QC_MESH_CLUSTER_ORDER_H

#include "base/memory.h"
#include "mesh/region_cells.h"

#include <stdbool.h>

typedef struct qcOrderOptions
{
    uint32_t threads;
    const qcRegionCells* region; ///< around the mesh. Null: all triangles are put in order
} qcOrderOptions;

typedef struct qcOrderSummary
{
    bool hasHub; ///< see qcClusters
    /// Triangles outside the region are left out, more than an eighth of all. Hubs are not looked for.
    bool isLimited;
} qcOrderSummary;

/// Fills `slots` (of uint32_t): qc_nodeSize a node, each triangle at most once, QC_NO_TRIANGLE elsewhere. `indices`:
/// three a triangle; `positions`: three doubles a vertex. O(triangles log triangles). On failure the array is left to
/// the caller, its contents undefined.
qcStatus qcClusterOrder_Make(qcArray* slots, const uint32_t* indices, uint32_t triangleCount, const double* positions,
                             uint32_t vertexCount, const qcOrderOptions* options, qcOrderSummary* summary);

/// Appends the nodes of all triangles that the slots lack. `region`: only its place is used.
qcStatus qcClusterOrder_Complete(qcArray* slots, const uint32_t* indices, uint32_t triangleCount,
                                 const double* positions, uint32_t vertexCount, const qcOrderOptions* options);

#endif
