// Points inside a closed mesh.
#ifndef QC_DEMOS_COMMON_BULLET_POINTS_INSIDE_H
#define QC_DEMOS_COMMON_BULLET_POINTS_INSIDE_H

#include "quickcullide/bullet_mesh.h"

#include <vector>

/// The first `maxCount` of the candidates that are inside.
std::vector<btVector3> qcPointsInside(const qcMeshShape& shape, const std::vector<btVector3>& candidates,
                                      size_t maxCount);

#endif
