// Sizes that meshes, kernels and layers agree on.
#ifndef QC_MESH_LIMITS_H
#define QC_MESH_LIMITS_H

#include <stdint.h>

enum
{
    qc_clusterSize = 8, ///< triangles
    qc_nodeSize = 64,   ///< triangles of a leaf node: 8 clusters
    qc_maxLoop = 256    ///< vertices around a flat patch
};

/// A slot of a cluster without a triangle.
#define QC_NO_TRIANGLE UINT32_MAX

#endif
