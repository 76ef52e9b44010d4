// Vertices of a mesh that lie at the same position.
#ifndef QC_GLUE_COMMON_WELD_VERTICES_H
#define QC_GLUE_COMMON_WELD_VERTICES_H

#include <LinearMath/btVector3.h>

#include <cstdint>
#include <vector>

/// For each vertex the first one at the same position. O(n).
std::vector<uint32_t> qcFirstAtPosition(const btVector3* vertices, uint32_t count);

#endif
