// A mesh shape of Bullet as a body of a qcScene.
#ifndef QC_DEMOS_COMMON_BULLET_MESH_BODY_H
#define QC_DEMOS_COMMON_BULLET_MESH_BODY_H

#include "common/bullet/body_transform.h"

#include <quickcullide/bullet_mesh.h>
#include <quickcullide/bullet_positions.h>

/// A rigid body without self-collision. The definition is valid while the shape is.
inline qcBodyDef qcMeshBodyDef(const qcMeshShape& mesh, const btTransform& place)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = mesh.getVertices();
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btVector3);
    def.vertexCount = mesh.getVertexCount();
    def.indices = mesh.getIndices();
    def.triangleCount = mesh.getTriangleCount();
    def.selfCollision = false;
    def.transform = qcBodyTransformOf(place);
    return def;
}

#endif
