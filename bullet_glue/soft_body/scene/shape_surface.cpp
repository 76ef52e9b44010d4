// Triangles of convex shapes, of Bullet's meshes and of planes near soft bodies.
#include "soft_body/scene/shape_surface.h"

#include "common/hash_table.h"
#include "common/shape_triangles.h"
#include "common/weld_vertices.h"
#include "quickcullide/bullet_positions.h"
#include "quickcullide/hash.h"
#include "soft_body/scene/convex_triangles.h"

#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/CollisionShapes/btTriangleMeshShape.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>

namespace
{
// Meshes with more triangles are read by region.
constexpr size_t s_maxTriangles = 1000000;
// Squares along each side of a plane's patch. A patch of few triangles has a box that contains all of a cloth on a
// slope.
constexpr int s_planeSquares = 16;
// Steps for which an unused surface is kept.
constexpr unsigned s_unusedSteps = 600;

std::unique_ptr<qcMeshShape> MakeMesh(const std::vector<btVector3>& points, const std::vector<uint32_t>& indices)
{
    return std::unique_ptr<qcMeshShape>(new qcMeshShape(points.data(), qcBulletPositions, sizeof(btVector3),
                                                        uint32_t(points.size()), indices.data(),
                                                        uint32_t(indices.size() / 3)));
}

std::unique_ptr<qcMeshShape> MakeConvexMesh(const btConvexShape* shape)
{
    qcConvexTriangles triangles;
    if (!qcMakeConvexTriangles(shape, &triangles))
        return nullptr;
    std::unique_ptr<qcMeshShape> mesh = MakeMesh(triangles.points, triangles.indices);
    mesh->setMargin(triangles.margin);
    return mesh;
}

/// The part of a plane in a rectangle around the box, as a grid.
std::unique_ptr<qcMeshShape> MakePlaneMesh(const btStaticPlaneShape* plane, const btVector3 box[2])
{
    btVector3 axes[2];
    btPlaneSpace1(plane->getPlaneNormal(), axes[0], axes[1]);
    btScalar lower[2], upper[2];
    const btVector3 center = (box[0] + box[1]) / 2, half = (box[1] - box[0]) / 2;
    for (int a = 0; a < 2; a++)
    {
        btScalar extent = half.dot(axes[a].absolute()), middle = center.dot(axes[a]);
        lower[a] = middle - extent;
        upper[a] = middle + extent;
    }
    std::vector<btVector3> points;
    std::vector<uint32_t> indices;
    for (int i = 0; i <= s_planeSquares; i++)
        for (int j = 0; j <= s_planeSquares; j++)
        {
            btScalar s = btScalar(i) / s_planeSquares, t = btScalar(j) / s_planeSquares;
            points.push_back(plane->getPlaneNormal() * plane->getPlaneConstant() +
                             axes[0] * (lower[0] + (upper[0] - lower[0]) * s) +
                             axes[1] * (lower[1] + (upper[1] - lower[1]) * t));
            if (i == s_planeSquares || j == s_planeSquares)
                continue;
            uint32_t a = uint32_t(i * (s_planeSquares + 1) + j), b = a + s_planeSquares + 1;
            indices.insert(indices.end(), {a, b, b + 1, a, b + 1, a + 1});
        }
    std::unique_ptr<qcMeshShape> mesh = MakeMesh(points, indices);
    mesh->setMargin(std::max(plane->getMargin(), mesh->getMargin()));
    return mesh;
}

/// Makes the mesh of a concave shape, or of its part in the region.
void ReadConcave(const btConcaveShape* shape, qcShapeSurface* surface)
{
    const qcMeshTriangles triangles(shape, surface->isWhole ? nullptr : surface->region);
    std::vector<uint32_t> first = qcFirstAtPosition(triangles.points, triangles.pointCount), welded(first.size());
    std::vector<btVector3> points;
    for (uint32_t i = 0; i < triangles.pointCount; i++)
    {
        if (first[i] == i)
        {
            welded[i] = uint32_t(points.size());
            points.push_back(triangles.points[i]);
        }
        else
            welded[i] = welded[first[i]];
    }
    std::vector<uint32_t> indices(triangles.indices, triangles.indices + 3 * size_t(triangles.count));
    for (uint32_t& index : indices)
        index = welded[index];
    surface->mesh = MakeMesh(points, indices);
    surface->mesh->setMargin(std::max(shape->getMargin(), surface->mesh->getMargin()));
    if (surface->isWhole)
        surface->sourcesHash =
            qcXxh64(triangles.sources.data(), triangles.sources.size() * sizeof(qcTriangleSource), 0);
}

/// The surface, with a region twice as large as the box where it has one.
std::shared_ptr<const qcShapeSurface> MakeSurface(const btCollisionShape* shape, const btVector3 box[2])
{
    std::shared_ptr<qcShapeSurface> surface(new qcShapeSurface);
    const btVector3 enlargement = (box[1] - box[0]) / 2;
    surface->region[0] = box[0] - enlargement;
    surface->region[1] = box[1] + enlargement;
    if (shape->isConvex())
    {
        surface->isConvex = true;
        surface->mesh = MakeConvexMesh(static_cast<const btConvexShape*>(shape));
        for (uint32_t i = 0; surface->mesh != nullptr && i < surface->mesh->getVertexCount(); i++)
            surface->inside += surface->mesh->getVertices()[i] / btScalar(surface->mesh->getVertexCount());
    }
    else if (shape->getShapeType() == STATIC_PLANE_PROXYTYPE)
    {
        surface->isWhole = false;
        surface->mesh = MakePlaneMesh(static_cast<const btStaticPlaneShape*>(shape), surface->region);
    }
    else
    {
        const auto* concave = static_cast<const btConcaveShape*>(shape);
        surface->isWhole = qcIsGImpactMesh(shape) || qcCountTriangles(shape) <= s_maxTriangles;
        ReadConcave(concave, surface.get());
    }
    if (surface->mesh != nullptr && surface->mesh->getTriangleCount() == 0)
        surface->mesh.reset();
    return surface;
}
} // namespace

bool qcHasSurface(const btCollisionShape* shape)
{
    switch (shape->getShapeType())
    {
        case STATIC_PLANE_PROXYTYPE:
        case TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case SCALED_TRIANGLE_MESH_SHAPE_PROXYTYPE:
        case MULTIMATERIAL_TRIANGLE_MESH_PROXYTYPE:
        case TERRAIN_SHAPE_PROXYTYPE: return true;
        case FAST_CONCAVE_MESH_PROXYTYPE: return qcAsMeshShape(shape) == nullptr;
        case GIMPACT_SHAPE_PROXYTYPE: return qcIsGImpactMesh(shape);
        default: return shape->isConvex();
    }
}

bool qcShapeSurface::Covers(const btVector3 box[2]) const
{
    if (isWhole)
        return true;
    for (int axis = 0; axis < 3; axis++)
        if (box[0][axis] < region[0][axis] || box[1][axis] > region[1][axis])
            return false;
    return true;
}

uint64_t qcSurfaceCache::RevisionOf(const btCollisionShape* shape)
{
    if (const qcMeshShape* mesh = qcAsMeshShape(shape))
        return mesh->getRevision();
    uint64_t hash = qcMixHash(0, uint64_t(shape->getShapeType()));
    hash = qcMixScalar(hash, shape->getMargin());
    if (shape->getShapeType() == STATIC_PLANE_PROXYTYPE)
    {
        const auto* plane = static_cast<const btStaticPlaneShape*>(shape);
        return qcMixScalar(qcMixVector(hash, plane->getPlaneNormal()), plane->getPlaneConstant());
    }
    if (shape->isConvex())
        return qcMixHash(hash, qcConvexRevision(static_cast<const btConvexShape*>(shape)));
    hash = qcMixHash(hash, qcMeshRevision(shape));
    if (const auto* mesh = dynamic_cast<const btTriangleMeshShape*>(shape))
        hash = qcMixHash(hash, reinterpret_cast<uintptr_t>(mesh->getMeshInterface()));
    return hash;
}

std::shared_ptr<const qcShapeSurface> qcSurfaceCache::Find(const btCollisionShape* shape, uint64_t revision,
                                                           const btCollisionObject* object, const btVector3 box[2],
                                                           const std::function<bool(const qcObjectKey&)>& isLive)
{
    for (const btCollisionObject* of : {static_cast<const btCollisionObject*>(nullptr), object})
    {
        auto found = m_entries.find(std::make_tuple(shape, of));
        if (found == m_entries.end())
            continue;
        Entry& entry = found->second;
        if (!entry.owners.Add(object, shape, m_step, isLive))
            m_entries.erase(found);
        else if (entry.revision == revision && entry.surface->Covers(box))
        {
            entry.lastStep = m_step;
            return entry.surface;
        }
    }
    std::shared_ptr<const qcShapeSurface> surface = MakeSurface(shape, box);
    Entry& entry = m_entries[std::make_tuple(shape, surface->isWhole ? nullptr : object)];
    entry.revision = revision;
    entry.surface = surface;
    entry.lastStep = m_step;
    entry.owners.Add(object, shape, m_step, isLive);
    return surface;
}

void qcSurfaceCache::Forget(const btCollisionShape* shape)
{
    auto first = m_entries.lower_bound(std::make_tuple(shape, nullptr)), last = first;
    while (last != m_entries.end() && std::get<0>(last->first) == shape)
        ++last;
    m_entries.erase(first, last);
}

void qcSurfaceCache::EndStep()
{
    m_step++;
    for (auto entry = m_entries.begin(); entry != m_entries.end();)
    {
        // Objects near soft bodies hold their surfaces.
        if (entry->second.surface.use_count() > 1)
            entry->second.lastStep = m_step;
        if (m_step > s_unusedSteps)
            entry->second.owners.ForgetBefore(m_step - s_unusedSteps);
        if (m_step - entry->second.lastStep > s_unusedSteps)
            entry = m_entries.erase(entry);
        else
            ++entry;
    }
}
