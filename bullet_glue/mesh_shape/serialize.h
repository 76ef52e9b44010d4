// A mesh in the structures of Bullet's serializer.
#ifndef QC_GLUE_MESH_SHAPE_SERIALIZE_H
#define QC_GLUE_MESH_SHAPE_SERIALIZE_H

#include <LinearMath/btVector3.h>

#include <cstdint>
#include <vector>

class btSerializer;

struct qcSavedMesh
{
    const std::vector<btVector3>& points; ///< before scaling
    const std::vector<uint32_t>& indices;
    btVector3 scaling;
    btScalar margin;
    const void* key; ///< an address that stands for the triangles in the file; not the shape's
};

/// Bytes of the buffer for qcSaveMesh.
int qcSavedMeshSize();

/// Completes the buffer, whose leading btCollisionShapeData is filled, to a compound of one static triangle mesh, and
/// adds the chunks that belong to it. Returns the name of the buffer's structure.
const char* qcSaveMesh(const qcSavedMesh& mesh, void* buffer, btSerializer* serializer);

#endif
