// Vertices of a mesh that the application moves between two steps.
#ifndef QC_GLUE_COMMON_MOVED_VERTICES_H
#define QC_GLUE_COMMON_MOVED_VERTICES_H

#include "quickcullide/scene.h"

#include <LinearMath/btTransform.h>

#include <cstddef>

/// True if the vertices are where a mesh with this box may have moved them from `last`: none by more than half the
/// box's diagonal. A mesh that was put elsewhere doesn't pass what lies between.
bool qcHaveMoved(const btVector3* last, const btVector3* vertices, size_t count, const btVector3 box[2]);

/// Adds a mesh as a deforming body. `def`: of the rigid one, with btVector3 positions; `transform`: its transform.
qcStatus qcAddDeforming(qcScene* scene, qcBodyDef def, const btTransform& transform, qcBodyId* id);
/// Sets all vertices of a deforming body to these, transformed.
qcStatus qcSetDeforming(qcScene* scene, qcBodyId id, const btTransform& transform, const btVector3* vertices,
                        size_t count);

#endif
