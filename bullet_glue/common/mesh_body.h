// A mesh of an object as a body of a scene. Where the application moves its vertices between two steps, it deforms over
// the step.
#ifndef QC_GLUE_COMMON_MESH_BODY_H
#define QC_GLUE_COMMON_MESH_BODY_H

#include "quickcullide/scene.h"

#include <LinearMath/btTransform.h>

#include <cstddef>
#include <cstdint>
#include <vector>

struct qcMeshBody
{
    btTransform local = btTransform::getIdentity();          ///< from the mesh's frame to the object's
    qcBodyId id{};                                           ///< generation 0: it is not in the scene
    btTransform sceneTransform = btTransform::getIdentity(); ///< of the mesh in the scene
    uint64_t trianglesHash = 0; ///< of its indices and the triangles' numbers in Bullet; 0: the mesh can't deform
    /// At the start of the step, in the mesh's frame; empty: the mesh does not deform.
    std::vector<btVector3> startVertices;
    btVector3 startBox[2]; ///< around these: lower and upper corner

    bool Deforms() const
    {
        return !startVertices.empty();
    }
    /// Deforms over the step from the vertices `from` of `last`, the mesh in the previous step, to `to`. Does nothing
    /// if the mesh has other triangles, or was put elsewhere: a vertex has moved by more than half the diagonal of the
    /// box.
    void DeformFrom(const qcMeshBody& last, const btVector3* from, const btVector3* to, size_t count);

  protected:
    /// Adds it to a scene, as a body that deforms or is rigid. `def`: of the rigid one, with btVector3 positions.
    qcStatus AddBody(qcScene* scene, qcBodyDef def, const btTransform& transform, bool isDeforming);
    /// Moves a rigid body. Does nothing if it is there.
    qcStatus MoveBody(qcScene* scene, const btTransform& transform);
    /// Sets all vertices of a body that deforms to these, transformed.
    qcStatus SetVertices(qcScene* scene, const btTransform& transform, const btVector3* vertices, size_t count);
};

#endif
