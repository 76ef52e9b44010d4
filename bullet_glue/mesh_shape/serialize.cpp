// Converts a mesh to the structures of Bullet's serializer, and back.
//
// The mesh is saved as a compound of a btBvhTriangleMeshShape. Bullet 3.24's importers read btGImpactMeshShape only if
// they were built with USE_GIMPACT, which neither CMake nor Debian does. btWorldImporter::convertRigidBodyFloat sets
// the mass to 0 if the shape isNonMoving(), as a bare triangle mesh is.
#include "mesh_shape/serialize.h"

#include "common/object_key.h"
#include "common/shape_triangles.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btSerializer.h>

#include <cstring>
#include <unordered_map>

namespace
{
/// Adds the triangles as a chunk that the importer converts with the compound, not as a shape of its own.
void SaveTriangles(const qcSavedMesh& mesh, btSerializer* serializer)
{
    btTriangleIndexVertexArray triangles;
    btIndexedMesh part;
    part.m_numTriangles = int(mesh.indices.size() / 3);
    part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(mesh.indices.data());
    part.m_triangleIndexStride = 3 * int(sizeof(uint32_t));
    part.m_numVertices = int(mesh.points.size());
    part.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh.points.data());
    part.m_vertexStride = int(sizeof(btVector3));
    part.m_vertexType = sizeof(btScalar) == sizeof(double) ? PHY_DOUBLE : PHY_FLOAT;
    triangles.addIndexedMesh(part, PHY_INTEGER);
    triangles.setScaling(mesh.scaling);

    btChunk* chunk = serializer->allocate(sizeof(btTriangleMeshShapeData), 1);
    auto* data = static_cast<btTriangleMeshShapeData*>(chunk->m_oldPtr);
    std::memset(data, 0, sizeof *data);
    data->m_collisionShapeData.m_shapeType = TRIANGLE_MESH_SHAPE_PROXYTYPE;
    triangles.serialize(&data->m_meshInterface, serializer);
    data->m_collisionMargin = float(mesh.margin);
    serializer->finalizeChunk(chunk, "btTriangleMeshShapeData", BT_ARRAY_CODE, const_cast<void*>(mesh.key));
}

/// The mesh that a compound was saved from; null if there is none.
std::unique_ptr<qcMeshShape> Restore(const btCompoundShape& compound)
{
    if (compound.getNumChildShapes() != 1 ||
        compound.getChildShape(0)->getShapeType() != TRIANGLE_MESH_SHAPE_PROXYTYPE ||
        !qcAreSame(compound.getChildTransform(0), btTransform::getIdentity()))
        return nullptr;
    const auto* loaded = static_cast<const btTriangleMeshShape*>(compound.getChildShape(0));
    const btStridingMeshInterface* mesh = loaded->getMeshInterface();
    if (mesh->getNumSubParts() != 1)
        return nullptr;
    const unsigned char *vertices, *indices;
    int vertexCount, stride, indexStride, triangleCount;
    PHY_ScalarType type, indexType;
    mesh->getLockedReadOnlyVertexIndexBase(&vertices, vertexCount, type, stride, &indices, indexStride, triangleCount,
                                           indexType, 0);
    std::unique_ptr<qcMeshShape> restored;
    if (indexType == PHY_INTEGER && indexStride == 3 * int(sizeof(uint32_t)))
    {
        restored.reset(new qcMeshShape(vertices, type == PHY_DOUBLE ? qc_positionF64 : qc_positionF32, size_t(stride),
                                       uint32_t(vertexCount), reinterpret_cast<const uint32_t*>(indices),
                                       uint32_t(triangleCount)));
        restored->setLocalScaling(mesh->getScaling());
        restored->setMargin(loaded->getMargin());
    }
    mesh->unLockReadOnlyVertexBase(0);
    return restored;
}

class Restorer
{
  public:
    /// The mesh that a shape was saved from, or the shape itself. Replaces children of compounds.
    btCollisionShape* Replace(btCollisionShape* shape)
    {
        if (!shape->isCompound())
            return shape;
        auto found = m_replaced.find(shape);
        if (found != m_replaced.end())
            return found->second;
        auto* compound = static_cast<btCompoundShape*>(shape);
        btCollisionShape*& replaced = m_replaced[shape] = shape;
        if (std::unique_ptr<qcMeshShape> mesh = Restore(*compound))
        {
            replaced = mesh.get();
            made.push_back(std::move(mesh));
            return replaced;
        }
        for (int i = 0; i < compound->getNumChildShapes(); i++)
        {
            btCompoundShapeChild& child = compound->getChildList()[i];
            child.m_childShape = Replace(child.m_childShape);
            child.m_childShapeType = child.m_childShape->getShapeType();
            child.m_childMargin = child.m_childShape->getMargin();
        }
        return shape;
    }

    std::vector<std::unique_ptr<qcMeshShape>> made;

  private:
    std::unordered_map<const btCollisionShape*, btCollisionShape*> m_replaced;
};
} // namespace

int qcSavedMeshSize()
{
    return int(sizeof(btCompoundShapeData));
}

const char* qcSaveMesh(const qcSavedMesh& mesh, void* buffer, btSerializer* serializer)
{
    auto* compound = static_cast<btCompoundShapeData*>(buffer);
    compound->m_collisionShapeData.m_shapeType = COMPOUND_SHAPE_PROXYTYPE;
    compound->m_collisionMargin = float(mesh.margin);
    compound->m_numChildShapes = 0;
    compound->m_childShapePtr = nullptr;
    if (mesh.indices.empty())
        return "btCompoundShapeData";
    btChunk* chunk = serializer->allocate(sizeof(btCompoundShapeChildData), 1);
    auto* child = static_cast<btCompoundShapeChildData*>(chunk->m_oldPtr);
    compound->m_numChildShapes = 1;
    compound->m_childShapePtr = static_cast<btCompoundShapeChildData*>(serializer->getUniquePointer(child));
    btTransform::getIdentity().serializeFloat(child->m_transform);
    void* key = const_cast<void*>(mesh.key);
    child->m_childShape = static_cast<btCollisionShapeData*>(serializer->getUniquePointer(key));
    child->m_childShapeType = TRIANGLE_MESH_SHAPE_PROXYTYPE;
    child->m_childMargin = float(mesh.margin);
    SaveTriangles(mesh, serializer);
    serializer->finalizeChunk(chunk, "btCompoundShapeChildData", BT_ARRAY_CODE, child);
    return "btCompoundShapeData";
}

std::vector<std::unique_ptr<qcMeshShape>> qcRestoreMeshes(btCollisionWorld* world)
{
    Restorer restorer;
    for (int i = 0; i < world->getNumCollisionObjects(); i++)
    {
        btCollisionObject* object = world->getCollisionObjectArray()[i];
        btCollisionShape* loaded = object->getCollisionShape();
        if (!loaded->isCompound())
            continue;
        // Algorithms of its pairs refer to the old shapes.
        if (btBroadphaseProxy* proxy = object->getBroadphaseHandle())
            world->getPairCache()->cleanProxyFromPairs(proxy, world->getDispatcher());
        btCollisionShape* shape = restorer.Replace(loaded);
        object->setCollisionShape(shape);
        btRigidBody* body = btRigidBody::upcast(object);
        if (shape != loaded && body != nullptr && body->getMass() > 0)
        {
            btVector3 inertia;
            shape->calculateLocalInertia(body->getMass(), inertia);
            body->setMassProps(body->getMass(), inertia);
            body->updateInertiaTensor();
        }
        world->updateSingleAabb(object);
    }
    return std::move(restorer.made);
}
