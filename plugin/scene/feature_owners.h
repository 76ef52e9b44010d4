// Owners of shared features: of the triangles that share a vertex or an edge, one reports its contacts. The idea of
// representative triangles: Curtis, Tamstorf, Manocha: Fast Collision Detection for Deformable Models using
// Representative-Triangles, 2008.
#ifndef QC_SCENE_FEATURE_OWNERS_H
#define QC_SCENE_FEATURE_OWNERS_H

#include "scene/bodies.h"

/// Fills body->owned, unless that was done before. O(triangles).
qcStatus qcBody_FindFeatureOwners(qcBody* body);

#endif
