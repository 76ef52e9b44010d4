// A coarser mesh of the same shape.
#ifndef QC_DEMOS_COMMON_MESH_IO_DECIMATE_H
#define QC_DEMOS_COMMON_MESH_IO_DECIMATE_H

#include "common/mesh_io/mesh_file.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Makes a mesh of floats with about `triangleCount` triangles: the vertices in each cell of a grid become their mean,
/// and triangles that collapse are left out. Keeps the shape; the surface may intersect itself. A grid that makes no
/// triangle twice is preferred. Deterministic to the bit. False: out of memory.
bool qcMesh_Decimate(const qcMesh* mesh, uint32_t triangleCount, qcMesh* coarse);

#ifdef __cplusplus
}
#endif

#endif
