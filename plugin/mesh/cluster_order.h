// The cluster order: a permutation of a body's triangles in which each 64, and each 8 of these, lie close together.
#ifndef QC_MESH_CLUSTER_ORDER_H
#define QC_MESH_CLUSTER_ORDER_H

#include "base/memory.h"

#include <stdbool.h>

/// Fills `slots` (of uint32_t): qc_nodeSize a node, each triangle once, QC_NO_TRIANGLE elsewhere. `hasHub`: see
/// qcClusters. `indices`: three a triangle; `positions`: three doubles a vertex. O(triangles log triangles). On failure
/// the array is left to the caller, its contents undefined.
qcStatus qcClusterOrder_Make(qcArray* slots, const uint32_t* indices, uint32_t triangleCount, const double* positions,
                             uint32_t vertexCount, uint32_t threads, bool* hasHub);

#endif
