// A triangle soup as a Bullet shape.
#include "quickcullide/bullet_mesh.h"

#include "common/finite.h"
#include "common/loop_mutex.h"
#include "common/mass_properties.h"
#include "common/parallel_loop.h"
#include "common/support_mesh.h"
#include "mesh_shape/convex_cast.h"
#include "mesh_shape/serialize.h"
#include "mesh_shape/triangle_tree.h"
#include "quickcullide/bullet_positions.h"

#include <BulletCollision/CollisionShapes/btStridingMeshInterface.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btSerializer.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <vector>

namespace
{
std::atomic<uint64_t> s_lastRevision{0};

/// In double, since squares of lengths can leave the range of float.
btScalar MeanEdge(const std::vector<btVector3>& points, const std::vector<uint32_t>& indices)
{
    double sum = 0;
    for (size_t i = 0; i < indices.size(); i++)
    {
        btVector3 edge = points[indices[i % 3 == 2 ? i - 2 : i + 1]] - points[indices[i]];
        double x = double(edge.x()), y = double(edge.y()), z = double(edge.z());
        sum += std::sqrt(x * x + y * y + z * z);
    }
    return indices.empty() ? btScalar(0) : btScalar(sum / double(indices.size()));
}

class TriangleReader : public btInternalTriangleIndexCallback
{
  public:
    TriangleReader(std::vector<btVector3>* vertices, std::vector<uint32_t>* indices)
        : m_vertices(vertices), m_indices(indices)
    {
    }

    void internalProcessTriangleIndex(btVector3* triangle, int, int) override
    {
        for (int c = 0; c < 3; c++)
        {
            m_indices->push_back(uint32_t(m_vertices->size()));
            m_vertices->push_back(triangle[c]);
        }
    }

  private:
    std::vector<btVector3>* m_vertices;
    std::vector<uint32_t>* m_indices;
};

size_t SizeOf(qcPositionType type)
{
    return 3 * (type == qc_positionF64 ? sizeof(double) : sizeof(float));
}

/// Fails, with a message, for arguments of the constructor that can't be read.
qcStatus CheckArrays(const void* positions, qcPositionType type, size_t stride, uint32_t vertexCount,
                     const uint32_t* indices, uint32_t triangleCount)
{
    if (positions == nullptr && vertexCount > 0)
        return qcFail(qc_statusBadInput, "qcMeshShape: positions is null for %u vertices", vertexCount);
    if (indices == nullptr && triangleCount > 0)
        return qcFail(qc_statusBadInput, "qcMeshShape: indices is null for %u triangles", triangleCount);
    if (stride != 0 && stride < SizeOf(type))
        return qcFail(qc_statusBadInput, "qcMeshShape: stride is %zu, a position has %zu bytes", stride, SizeOf(type));
    return qc_statusOk;
}
} // namespace

struct qcMeshShape::Implementation
{
    qcStatus status = qc_statusOk;
    std::vector<btVector3> unscaled; ///< empty while the scaling is 1
    std::vector<btVector3> points;   ///< scaled
    std::vector<uint32_t> indices;
    btVector3 scaling{1, 1, 1};
    btVector3 lower{0, 0, 0}, upper{0, 0, 0}; ///< of the points
    uint64_t revision = 0;
    mutable std::mutex supportMutex;
    mutable std::shared_ptr<const qcSupportMesh> support; ///< null: not built since the last change
    mutable qcLoopMutex treeMutex;
    mutable std::atomic<const qcTriangleTree*> tree{nullptr}; ///< owned; null: not built since the last change

    Implementation() = default;
    ~Implementation()
    {
        delete tree.load();
    }
    Implementation(const Implementation&) = delete;
    Implementation& operator=(const Implementation&) = delete;

    void ReadPositions(const void* positions, qcPositionType type, size_t stride, uint32_t count);
    /// Empties the mesh and sets the status if an index is out of range or a position not finite.
    void Validate();
    /// Call it after each change of points or indices.
    void Update();
    btScalar DefaultMargin() const;
    /// The BVH, built by the first call. Thread-safe.
    const qcTriangleTree& GetTree() const;
    void Report(btTriangleCallback* callback, uint32_t triangle) const;
};

void qcMeshShape::Implementation::ReadPositions(const void* positions, qcPositionType type, size_t stride,
                                                uint32_t count)
{
    if (stride == 0)
        stride = SizeOf(type);
    points.resize(count);
    for (size_t v = 0; v < count; v++)
    {
        // Copied, since with any stride they need not be aligned.
        const char* at = static_cast<const char*>(positions) + v * stride;
        double wide[3];
        float narrow[3];
        std::memcpy(type == qc_positionF64 ? static_cast<void*>(wide) : narrow, at, SizeOf(type));
        if (type == qc_positionF64)
            points[v].setValue(btScalar(wide[0]), btScalar(wide[1]), btScalar(wide[2]));
        else
            points[v].setValue(btScalar(narrow[0]), btScalar(narrow[1]), btScalar(narrow[2]));
    }
}

void qcMeshShape::Implementation::Validate()
{
    for (size_t i = 0; i < indices.size() && status == qc_statusOk; i++)
        if (indices[i] >= points.size())
            status = qcFail(qc_statusBadInput, "qcMeshShape: index %zu of triangle %zu is %u; there are %zu vertices",
                            i % 3, i / 3, indices[i], points.size());
    for (size_t v = 0; v < points.size() && status == qc_statusOk; v++)
        if (!qcIsFinite(points[v]))
            status = qcFail(qc_statusBadInput, "qcMeshShape: the position of vertex %zu is not finite", v);
    if (status == qc_statusOk)
        return;
    points.clear();
    indices.clear();
}

void qcMeshShape::Implementation::Update()
{
    revision = ++s_lastRevision;
    delete tree.exchange(nullptr);
    support.reset();
    lower = upper = indices.empty() ? btVector3(0, 0, 0) : points[indices[0]];
    for (uint32_t index : indices)
    {
        lower.setMin(points[index]);
        upper.setMax(points[index]);
    }
}

/// With margins much wider than the triangles are long, each triangle is near many others.
btScalar qcMeshShape::Implementation::DefaultMargin() const
{
    return std::min(btScalar(0.01), MeanEdge(points, indices) / 4);
}

const qcTriangleTree& qcMeshShape::Implementation::GetTree() const
{
    const qcTriangleTree* built = tree.load(std::memory_order_acquire);
    if (built != nullptr)
        return *built;
    // While this thread waits for the loops of a build, its scheduler has it run a task that needs the tree, too.
    const bool isHeldHere = treeMutex.IsHeldHere();
    std::unique_lock<qcLoopMutex> lock(treeMutex, std::defer_lock);
    if (!isHeldHere)
        lock.lock();
    built = tree.load(std::memory_order_acquire);
    if (built != nullptr)
        return *built;
    std::unique_ptr<const qcTriangleTree> made(new qcTriangleTree(
        points.data(), indices.data(), uint32_t(indices.size() / 3), isHeldHere ? 1 : qcWorkersOf(0)));
    if (tree.compare_exchange_strong(built, made.get(), std::memory_order_acq_rel))
        return *made.release();
    return *built;
}

void qcMeshShape::Implementation::Report(btTriangleCallback* callback, uint32_t triangle) const
{
    const uint32_t* index = &indices[3 * size_t(triangle)];
    btVector3 corners[3] = {points[index[0]], points[index[1]], points[index[2]]};
    callback->processTriangle(corners, 0, int(triangle));
}

qcMeshShape::qcMeshShape(const void* positions, qcPositionType type, size_t stride, uint32_t vertexCount,
                         const uint32_t* indices, uint32_t triangleCount)
    : m_implementation(new Implementation)
{
    m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;
    m_implementation->status = CheckArrays(positions, type, stride, vertexCount, indices, triangleCount);
    if (m_implementation->status == qc_statusOk)
    {
        m_implementation->ReadPositions(positions, type, stride, vertexCount);
        m_implementation->indices.assign(indices, indices + 3 * size_t(triangleCount));
    }
    m_implementation->Validate();
    m_implementation->Update();
    m_collisionMargin = m_implementation->DefaultMargin();
    GetSupport(); // the first step of new bodies has enough to do
}

qcMeshShape::qcMeshShape(const btStridingMeshInterface* mesh) : m_implementation(new Implementation)
{
    m_shapeType = FAST_CONCAVE_MESH_PROXYTYPE;
    if (mesh != nullptr)
    {
        TriangleReader reader(&m_implementation->points, &m_implementation->indices);
        btVector3 far(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
        mesh->InternalProcessAllTriangles(&reader, -far, far);
    }
    else
        m_implementation->status = qcFail(qc_statusBadInput, "qcMeshShape: mesh is null");
    m_implementation->Validate();
    m_implementation->Update();
    m_collisionMargin = m_implementation->DefaultMargin();
    GetSupport(); // the first step of new bodies has enough to do
}

qcMeshShape::~qcMeshShape() = default;

qcStatus qcMeshShape::getStatus() const
{
    return m_implementation->status;
}

uint32_t qcMeshShape::getVertexCount() const
{
    return uint32_t(m_implementation->points.size());
}

uint32_t qcMeshShape::getTriangleCount() const
{
    return uint32_t(m_implementation->indices.size() / 3);
}

const btVector3* qcMeshShape::getVertices() const
{
    return m_implementation->points.data();
}

const uint32_t* qcMeshShape::getIndices() const
{
    return m_implementation->indices.data();
}

uint64_t qcMeshShape::getRevision() const
{
    return m_implementation->revision;
}

std::shared_ptr<const qcSupportMesh> qcMeshShape::GetSupport() const
{
    const Implementation& my = *m_implementation;
    std::lock_guard<std::mutex> lock(my.supportMutex);
    if (my.support == nullptr && qcSupportMesh::IsSmall(getTriangleCount()))
        my.support = std::make_shared<const qcSupportMesh>(this);
    return my.support;
}

qcMassProperties qcMeshShape::getMassProperties() const
{
    return qcMassPropertiesOf(qcMeasureMesh(getVertices(), getVertexCount(), getIndices(), getTriangleCount()));
}

std::unique_ptr<qcMeshShape> qcMeshShape::makeRecentered(btTransform* frame) const
{
    const Implementation& my = *m_implementation;
    btTransform principal = getMassProperties().principalFrame;
    std::vector<btVector3> points(my.points);
    for (btVector3& point : points)
        point = principal.invXform(point);
    std::unique_ptr<qcMeshShape> copy(new qcMeshShape(points.data(), qcBulletPositions, sizeof(btVector3),
                                                      getVertexCount(), getIndices(), getTriangleCount()));
    copy->m_implementation->status = my.status;
    copy->m_collisionMargin = m_collisionMargin;
    if (frame != nullptr)
        *frame = principal;
    return copy;
}

void qcMeshShape::calculateLocalInertia(btScalar mass, btVector3& inertia) const
{
    qcMoments moments = qcMeasureMesh(getVertices(), getVertexCount(), getIndices(), getTriangleCount());
    inertia = qcInertiaAboutOrigin(moments, double(mass));
}

void qcMeshShape::getAabb(const btTransform& transform, btVector3& aabbMin, btVector3& aabbMax) const
{
    btTransformAabb(m_implementation->lower, m_implementation->upper, getMargin(), transform, aabbMin, aabbMax);
}

void qcMeshShape::setLocalScaling(const btVector3& scaling)
{
    Implementation& my = *m_implementation;
    if (scaling == my.scaling)
        return;
    if (!qcIsFinite(scaling))
    {
        my.status = qcFail(qc_statusBadInput, "qcMeshShape::setLocalScaling: the scaling is not finite");
        return;
    }
    const std::vector<btVector3>& unscaled = my.unscaled.empty() ? my.points : my.unscaled;
    std::vector<btVector3> scaled;
    scaled.reserve(unscaled.size());
    for (const btVector3& point : unscaled)
    {
        scaled.push_back(point * scaling);
        if (!qcIsFinite(scaled.back()))
        {
            my.status = qcFail(qc_statusBadInput, "qcMeshShape::setLocalScaling: vertex %zu would not be finite",
                               scaled.size() - 1);
            return;
        }
    }
    if (my.unscaled.empty())
        my.unscaled.swap(my.points);
    my.points.swap(scaled);
    my.scaling = scaling;
    my.Update();
}

void qcMeshShape::setMargin(btScalar margin)
{
    if (margin >= 0 && std::isfinite(margin))
        m_collisionMargin = margin;
    else
        m_implementation->status =
            qcFail(qc_statusBadInput, "qcMeshShape::setMargin: %g is negative or not finite", double(margin));
}

const btVector3& qcMeshShape::getLocalScaling() const
{
    return m_implementation->scaling;
}

const char* qcMeshShape::getName() const
{
    return "QCMESH";
}

void qcMeshShape::processAllTriangles(btTriangleCallback* callback, const btVector3& aabbMin,
                                      const btVector3& aabbMax) const
{
    const Implementation& my = *m_implementation;
    if (!TestAabbAgainstAabb2(my.lower, my.upper, aabbMin, aabbMax) || my.indices.empty())
        return;
    auto report = [&](uint32_t triangle) { my.Report(callback, triangle); };
    // The box around a long ray or sweep overlaps most of a mesh.
    if (const auto* ray = dynamic_cast<const btTriangleRaycastCallback*>(callback))
    {
        const btVector3 point(0, 0, 0);
        my.GetTree().VisitSweep({ray->m_from, ray->m_to, point, point}, ray->m_hitFraction, report);
    }
    else if (auto* cast = dynamic_cast<btTriangleConvexcastCallback*>(callback))
        qcCastThroughMesh(my.GetTree(), my.points.data(), my.indices.data(), cast);
    else
        my.GetTree().VisitBox(aabbMin, aabbMax, report);
}

void qcMeshShape::processTrianglesBelow(btTriangleCallback* callback, const btVector3& normal, btScalar distance) const
{
    const Implementation& my = *m_implementation;
    btVector3 lowest;
    for (int axis = 0; axis < 3; axis++)
        lowest[axis] = normal[axis] >= 0 ? my.lower[axis] : my.upper[axis];
    // A mesh above all planes never builds its tree.
    if (normal.x() * lowest.x() + normal.y() * lowest.y() + normal.z() * lowest.z() > distance)
        return;
    my.GetTree().VisitBelow(normal, distance, [&](uint32_t triangle) { my.Report(callback, triangle); });
}

int qcMeshShape::calculateSerializeBufferSize() const
{
    return qcSavedMeshSize();
}

void qcMeshShape::serializeSingleShape(btSerializer* serializer) const
{
    // A compound that was saved before may contain it: one chunk only, since Bullet's importer resolves pointers
    // wrongly if a shape has two.
    if (serializer->findPointer(const_cast<qcMeshShape*>(this)) == nullptr)
        btConcaveShape::serializeSingleShape(serializer);
}

const char* qcMeshShape::serialize(void* dataBuffer, btSerializer* serializer) const
{
    const Implementation& my = *m_implementation;
    btCollisionShape::serialize(dataBuffer, serializer); // the name
    qcSavedMesh mesh{my.unscaled.empty() ? my.points : my.unscaled, my.indices, my.scaling, m_collisionMargin, &my};
    return qcSaveMesh(mesh, dataBuffer, serializer);
}
