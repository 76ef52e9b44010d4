// Vertices and bounding boxes of meshes.
#ifndef QC_DEMOS_COMMON_MESH_IO_BOUNDS_H
#define QC_DEMOS_COMMON_MESH_IO_BOUNDS_H

#include "common/mesh_io/mesh_file.h"

#ifdef __cplusplus
extern "C" {
#endif

void qcMesh_GetVertex(const qcMesh* mesh, size_t vertex, double p[3]);

/// The box around all vertices; returns its longest edge.
double qcMesh_FindBox(const qcMesh* meshes, uint32_t count, double lower[3], double upper[3]);

#ifdef __cplusplus
}
#endif

#endif
