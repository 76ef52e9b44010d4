// Vertices of a mesh that the application moves between two steps.
#include "common/moved_vertices.h"

#include "common/shape_triangles.h"
#include "quickcullide/bullet_positions.h"

#include <algorithm>
#include <vector>

namespace
{
std::vector<btVector3> Transformed(const btTransform& transform, const btVector3* vertices, size_t count)
{
    std::vector<btVector3> transformed(vertices, vertices + count);
    for (btVector3& vertex : transformed)
        vertex = transform * vertex;
    return transformed;
}
} // namespace

bool qcHaveMoved(const btVector3* last, const btVector3* vertices, size_t count, const btVector3 box[2])
{
    const btScalar maxSquared = (box[1] - box[0]).length2() / 4;
    return std::equal(vertices, vertices + count, last,
                      [maxSquared](const btVector3& to, const btVector3& from)
                      { return to.distance2(from) <= maxSquared; });
}

qcStatus qcAddDeforming(qcScene* scene, qcBodyDef def, const btTransform& transform, qcBodyId* id)
{
    const std::vector<btVector3> world =
        Transformed(transform, static_cast<const btVector3*>(def.positions), def.vertexCount);
    def.positions = world.data();
    def.transform = qcTransformOf(btTransform::getIdentity());
    def.deforming = true;
    return qcScene_AddBody(scene, &def, id);
}

qcStatus qcSetDeforming(qcScene* scene, qcBodyId id, const btTransform& transform, const btVector3* vertices,
                        size_t count)
{
    const std::vector<btVector3> world = Transformed(transform, vertices, count);
    return qcScene_SetVertices(scene, id, world.data(), qcBulletPositions, sizeof(btVector3));
}
