// Which triangle goes where: an order of a body's triangles in which 64 at a time, and 8 at a time, lie together.
#ifndef QC_MESH_CLUSTER_ORDER_H
#define QC_MESH_CLUSTER_ORDER_H

#include "base/memory.h"

/// Fills `places` (of uint32_t, zeroed or in use): qc_nodeSize a node, each triangle once, QC_NO_TRIANGLE elsewhere. On
/// failure the array is left to the caller, its contents undefined.
qcStatus qcClusterOrder_Make(qcArray* places, const uint32_t* indices, uint32_t triangleCount, const double* positions,
                             uint32_t vertexCount, uint32_t threads);

#endif
