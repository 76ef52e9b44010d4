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
    const void* key; ///< address that identifies the triangles in the file; not that of the shape
};

/// Size of the buffer for qcSaveMesh, in bytes.
int qcSavedMeshSize();

/// Fills the buffer, whose leading btCollisionShapeData is set, with a compound of one static triangle mesh, and adds
/// the compound's chunks to the serializer. Returns the name of the buffer's structure.
const char* qcSaveMesh(const qcSavedMesh& mesh, void* buffer, btSerializer* serializer);

#endif
