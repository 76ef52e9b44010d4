// Reading the triangles of Bullet's concave shapes, and their revisions.
#include "common/shape_triangles.h"

#include "common/hash_table.h"
#include "quickcullide/bullet_positions.h"

#include <BulletCollision/CollisionShapes/btPolyhedralConvexShape.h>
#include <BulletCollision/CollisionShapes/btScaledBvhTriangleMeshShape.h>
#include <BulletCollision/Gimpact/btGImpactShape.h>

#include <cstring>

namespace
{
class Reader : public btTriangleCallback
{
  public:
    Reader(std::vector<btVector3>* points, std::vector<uint32_t>* indices, std::vector<qcTriangleSource>* sources)
        : m_points(points), m_indices(indices), m_sources(sources)
    {
    }

    void processTriangle(btVector3* triangle, int part, int index) override
    {
        for (int c = 0; c < 3; c++)
        {
            m_indices->push_back(uint32_t(m_points->size()));
            m_points->push_back(triangle[c]);
        }
        m_sources->push_back({part, index});
    }

  private:
    std::vector<btVector3>* m_points;
    std::vector<uint32_t>* m_indices;
    std::vector<qcTriangleSource>* m_sources;
};

class Counter : public btTriangleCallback
{
  public:
    void processTriangle(btVector3*, int, int) override
    {
        count++;
    }

    size_t count = 0;
};

/// The mesh that a shape reports all of; null: there is none, or it is not known.
const btStridingMeshInterface* MeshOf(const btCollisionShape* shape)
{
    switch (shape->getShapeType())
    {
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
            return static_cast<const btTriangleMeshShape*>(shape)->getMeshInterface();
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
            return static_cast<const btScaledBvhTriangleMeshShape*>(shape)->getChildShape()->getMeshInterface();
        default: return nullptr;
    }
}

size_t CountIn(const btStridingMeshInterface& mesh)
{
    size_t count = 0;
    for (int part = 0; part < mesh.getNumSubParts(); part++)
    {
        const unsigned char *vertices, *indices;
        int vertexCount, stride, indexStride, faces;
        PHY_ScalarType type, indexType;
        mesh.getLockedReadOnlyVertexIndexBase(&vertices, vertexCount, type, stride, &indices, indexStride, faces,
                                              indexType, part);
        mesh.unLockReadOnlyVertexBase(part);
        count += size_t(faces);
    }
    return count;
}

/// A box that all triangles of one of Bullet's own shapes are in, larger than rounding errors at its faces.
void FindWholeBox(const btCollisionShape* shape, btVector3 box[2])
{
    shape->getAabb(btTransform::getIdentity(), box[0], box[1]);
    const btVector3 slack = (box[1] - box[0]) * btScalar(0.01) + btVector3(1, 1, 1);
    box[0] -= slack;
    box[1] += slack;
}
} // namespace

bool qcIsGImpactMesh(const btCollisionShape* shape)
{
    return shape->getShapeType() == GIMPACT_SHAPE_PROXYTYPE &&
           static_cast<const btGImpactShapeInterface*>(shape)->getGImpactShapeType() != CONST_GIMPACT_COMPOUND_SHAPE;
}

bool qcIsMesh(const btCollisionShape* shape)
{
    int type = shape->getShapeType();
    if (type == GIMPACT_SHAPE_PROXYTYPE)
        return qcIsGImpactMesh(shape);
    return shape->isConcave() && type != STATIC_PLANE_PROXYTYPE && type != EMPTY_SHAPE_PROXYTYPE;
}

const qcMeshShape* qcAsMeshShape(const btCollisionShape* shape)
{
    // Other classes may use the type, too.
    return shape->getShapeType() == FAST_CONCAVE_MESH_PROXYTYPE ? dynamic_cast<const qcMeshShape*>(shape) : nullptr;
}

uint64_t qcMeshRevision(const btCollisionShape* shape)
{
    if (const qcMeshShape* ours = qcAsMeshShape(shape))
        return ours->getRevision();
    btVector3 lower, upper;
    shape->getAabb(btTransform::getIdentity(), lower, upper);
    return qcMixVector(qcMixVector(qcMixVector(1, shape->getLocalScaling()), lower), upper);
}

uint64_t qcMixScalar(uint64_t hash, btScalar value)
{
    double wide = double(value) + 0.0;
    uint64_t bits;
    std::memcpy(&bits, &wide, sizeof bits);
    return qcMixHash(hash, bits);
}

uint64_t qcMixVector(uint64_t hash, const btVector3& vector)
{
    return qcMixScalar(qcMixScalar(qcMixScalar(hash, vector.x()), vector.y()), vector.z());
}

uint64_t qcConvexRevision(const btConvexShape* shape)
{
    uint64_t hash = qcMixHash(qcMeshRevision(shape), uint64_t(shape->getShapeType()));
    if (const auto* polyhedron = dynamic_cast<const btPolyhedralConvexShape*>(shape))
        for (int i = 0; i < polyhedron->getNumVertices(); i++)
        {
            btVector3 vertex;
            polyhedron->getVertex(i, vertex);
            hash = qcMixVector(hash, vertex);
        }
    // The corners of a cube tell capsules and cones of different axes apart, too.
    for (int i = 0; i < 8; i++)
    {
        const btVector3 corner((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
        hash = qcMixVector(hash, shape->localGetSupportingVertex(corner));
    }
    return hash;
}

size_t qcCountTriangles(const btCollisionShape* shape)
{
    if (const qcMeshShape* ours = qcAsMeshShape(shape))
        return ours->getTriangleCount();
    if (const btStridingMeshInterface* mesh = MeshOf(shape); mesh != nullptr)
        return CountIn(*mesh);
    btVector3 box[2];
    FindWholeBox(shape, box);
    Counter counter;
    static_cast<const btConcaveShape*>(shape)->processAllTriangles(&counter, box[0], box[1]);
    return counter.count;
}

qcMeshTriangles::qcMeshTriangles(const btCollisionShape* shape, const btVector3* box)
{
    if (const qcMeshShape* ours = qcAsMeshShape(shape))
    {
        points = ours->getVertices();
        pointCount = ours->getVertexCount();
        indices = ours->getIndices();
        count = ours->getTriangleCount();
        return;
    }
    btVector3 wholeBox[2];
    if (box == nullptr || shape->getShapeType() == GIMPACT_SHAPE_PROXYTYPE)
    {
        FindWholeBox(shape, wholeBox);
        box = wholeBox;
        if (const btStridingMeshInterface* mesh = MeshOf(shape); mesh != nullptr)
            Reserve(CountIn(*mesh));
    }
    Reader reader(&m_points, &m_indices, &sources);
    static_cast<const btConcaveShape*>(shape)->processAllTriangles(&reader, box[0], box[1]);
    points = m_points.data();
    pointCount = uint32_t(m_points.size());
    indices = m_indices.data();
    count = uint32_t(sources.size());
}

void qcMeshTriangles::Reserve(size_t triangleCount)
{
    m_points.reserve(3 * triangleCount);
    m_indices.reserve(3 * triangleCount);
    sources.reserve(triangleCount);
}

qcBodyDef qcMeshBodyDef(const btVector3* points, uint32_t pointCount, const uint32_t* indices, uint32_t triangleCount,
                        const btTransform& transform, qcActivity activity)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = points;
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btVector3);
    def.vertexCount = pointCount;
    def.indices = indices;
    def.triangleCount = triangleCount;
    def.transform = qcTransformOf(transform);
    def.activity = activity;
    def.selfCollision = false;
    return def;
}

qcStatus qcAddMesh(qcScene* scene, const qcMeshDef& mesh, qcBodyId* id, std::vector<qcTriangleSource>* sources)
{
    qcMeshTriangles triangles(mesh.shape, mesh.box);
    *sources = std::move(triangles.sources);
    qcBodyDef def = qcMeshBodyDef(triangles.points, triangles.pointCount, triangles.indices, triangles.count,
                                  mesh.transform, mesh.activity);
    def.owner = mesh.owner;
    return qcScene_AddBody(scene, &def, id);
}

bool qcExplainNotFinite(const qcBodyDef& def)
{
    const qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    qcBodyId id;
    qcStatus status = qcScene_Create(&sceneDef, &scene);
    if (status == qc_statusOk)
        status = qcScene_AddBody(scene, &def, &id);
    qcScene_Destroy(scene);
    return status == qc_statusOk;
}

void qcExplainNotFinite(const btCollisionObject& object)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.transform = qcTransformOf(object.getWorldTransform());
    if (qcExplainNotFinite(def))
        (void)qcFail(qc_statusBadInput, "the velocity of an object is not finite");
}

qcTransform qcTransformOf(const btTransform& transform)
{
    qcTransform result;
    for (int row = 0; row < 3; row++)
    {
        for (int column = 0; column < 3; column++)
            result.linear[3 * row + column] = double(transform.getBasis()[row][column]);
        result.translation[row] = double(transform.getOrigin()[row]);
    }
    return result;
}
