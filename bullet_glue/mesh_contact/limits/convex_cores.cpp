// Cores of convex shapes.
#include "mesh_contact/limits/convex_cores.h"

#include "common/finite.h"
#include "common/hash_table.h"
#include "common/hull_faces.h"
#include "common/shape_triangles.h"
#include "quickcullide/bullet_positions.h"

#include <algorithm>

namespace
{
// Cores are kept for this many steps after their last use.
constexpr uint64_t s_keptCores = 64;

btConvexHullComputer HullOf(const btConvexShape* shape)
{
    const std::vector<btVector3> points =
        qcOutermostPoints([shape](const btVector3& direction) { return shape->localGetSupportingVertex(direction); });
    btConvexHullComputer hull;
    if (std::all_of(points.begin(), points.end(), [](const btVector3& point) { return qcIsFinite(point); }))
        hull.compute(&points[0].x(), sizeof(btVector3), int(points.size()), 0, 0);
    return hull;
}
} // namespace

qcConvexCore qcConvexCores::MakeCore(const btConvexShape* shape, btScalar size)
{
    qcConvexCore core;
    core.shape = shape;
    const btConvexHullComputer hull = HullOf(shape);
    std::vector<uint32_t> indices;
    for (int face = 0; face < hull.faces.size(); face++)
        qcAddTriangles(qcCornersOfFace(hull, face), &indices);
    if (hull.vertices.size() < 4 || indices.empty())
        return core;
    btVector3 centre(0, 0, 0);
    for (int i = 0; i < hull.vertices.size(); i++)
        centre += hull.vertices[i] / btScalar(hull.vertices.size());
    std::vector<btVector3> points;
    for (int i = 0; i < hull.vertices.size(); i++)
        points.push_back(centre + size * (hull.vertices[i] - centre));
    core.halfWidth = BT_LARGE_FLOAT;
    for (size_t i = 0; i < indices.size(); i += 3)
    {
        const btVector3 &a = points[indices[i]], &b = points[indices[i + 1]], &c = points[indices[i + 2]];
        const btVector3 normal = (b - a).cross(c - a);
        if (normal.length2() > 0)
            core.halfWidth = std::min(core.halfWidth, btFabs(normal.normalized().dot(a - centre)));
    }
    if (!(core.halfWidth > SIMD_EPSILON * centre.distance(points[0])))
        return core;
    core.mesh.reset(new qcMeshShape(points.data(), qcBulletPositions, sizeof(btVector3), uint32_t(points.size()),
                                    indices.data(), uint32_t(indices.size() / 3)));
    core.mesh->setMargin(0);
    core.hull = core.mesh->GetSupport();
    return core;
}

void qcConvexCores::BeginStep()
{
    m_step++;
    for (auto entry = m_entries.begin(); m_step % s_keptCores == 0 && entry != m_entries.end();)
        entry = m_step - entry->second.step > s_keptCores ? m_entries.erase(entry) : std::next(entry);
}

const qcConvexCore& qcConvexCores::Find(const btConvexShape* shape)
{
    Entry& entry = m_entries[shape];
    if (entry.step == m_step)
        return entry.core;
    const uint64_t revision = qcConvexRevision(shape);
    if (entry.revision != revision)
    {
        entry.core = MakeCore(shape, m_size);
        entry.revision = revision;
    }
    entry.step = m_step;
    return entry.core;
}
