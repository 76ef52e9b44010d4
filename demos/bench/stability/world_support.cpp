// Bodies that hang in the air or lie under the ground.
#include "bench/stability/world_support.h"

#include "quickcullide/bullet_mesh.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>

#include <algorithm>
#include <vector>

namespace
{
constexpr btScalar s_rigidReach = btScalar(0.02), s_softReach = btScalar(0.05);

/// A body's index by btCollisionObject::getWorldArrayIndex; bodies of a group touch each other.
class Groups
{
  public:
    explicit Groups(int count) : m_parents(size_t(count))
    {
        for (size_t i = 0; i < m_parents.size(); i++)
            m_parents[i] = i;
    }
    size_t Find(size_t body) const
    {
        while (m_parents[body] != body)
            body = m_parents[body];
        return body;
    }
    void Unite(const btCollisionObject& a, const btCollisionObject& b)
    {
        size_t rootA = Find(size_t(a.getWorldArrayIndex())), rootB = Find(size_t(b.getWorldArrayIndex()));
        m_parents[std::max(rootA, rootB)] = std::min(rootA, rootB);
    }

  private:
    std::vector<size_t> m_parents;
};

const btStaticPlaneShape* PlaneOf(const btCollisionObject& object)
{
    return dynamic_cast<const btStaticPlaneShape*>(object.getCollisionShape());
}

btScalar HeightAbove(const btCollisionObject& object, const btStaticPlaneShape& plane, const btVector3& point)
{
    return plane.getPlaneNormal().dot(object.getWorldTransform().invXform(point)) - plane.getPlaneConstant();
}

bool IsNear(const btSoftBody& soft, const btCollisionObject& other)
{
    btVector3 lower, upper, reach(s_softReach, s_softReach, s_softReach);
    const btStaticPlaneShape* plane = PlaneOf(other);
    if (const btSoftBody* otherSoft = btSoftBody::upcast(&other))
        otherSoft->getAabb(lower, upper);
    else
        other.getCollisionShape()->getAabb(other.getWorldTransform(), lower, upper);
    lower -= reach;
    upper += reach;
    for (int i = 0; i < soft.m_nodes.size(); i++)
    {
        const btVector3& x = soft.m_nodes[i].m_x;
        if (plane != nullptr ? HeightAbove(other, *plane, x) <= s_softReach
                             : x.x() >= lower.x() && x.y() >= lower.y() && x.z() >= lower.z() && x.x() <= upper.x() &&
                                   x.y() <= upper.y() && x.z() <= upper.z())
            return true;
    }
    return false;
}

void UniteTouching(const btDiscreteDynamicsWorld& world, Groups* groups)
{
    // Bullet's getter is const on the array only.
    auto dispatcher = const_cast<btDispatcher*>(world.getDispatcher());
    for (int m = 0; m < dispatcher->getNumManifolds(); m++)
    {
        const btPersistentManifold& manifold = *dispatcher->getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold.getNumContacts(); i++)
            if (manifold.getContactPoint(i).getDistance() <= s_rigidReach)
                groups->Unite(*manifold.getBody0(), *manifold.getBody1());
    }
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
        if (const btSoftBody* soft = btSoftBody::upcast(objects[i]))
            for (int other = 0; other < objects.size(); other++)
                if (other != i && IsNear(*soft, *objects[other]))
                    groups->Unite(*soft, *objects[other]);
}

/// The least height of a shape's meshes above a plane; `height` if that is less.
void FindLowest(const btCollisionShape& shape, const btTransform& place, const btCollisionObject& ground,
                const btStaticPlaneShape& plane, btScalar* height)
{
    if (auto mesh = dynamic_cast<const qcMeshShape*>(&shape))
        for (uint32_t v = 0; v < mesh->getVertexCount(); v++)
            *height = std::min(*height, HeightAbove(ground, plane, place * mesh->getVertices()[v]));
    if (!shape.isCompound())
        return;
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); i++)
        FindLowest(*compound.getChildShape(i), place * compound.getChildTransform(i), ground, plane, height);
}

double DepthBelow(const btCollisionObjectArray& objects, const btCollisionObject& ground,
                  const btStaticPlaneShape& plane)
{
    btScalar height = 0;
    for (int i = 0; i < objects.size(); i++)
    {
        if (!qcMoves(*objects[i]))
            continue;
        const btSoftBody* soft = btSoftBody::upcast(objects[i]);
        for (int node = 0; soft != nullptr && node < soft->m_nodes.size(); node++)
            height = std::min(height, HeightAbove(ground, plane, soft->m_nodes[node].m_x));
        if (soft == nullptr)
            FindLowest(*objects[i]->getCollisionShape(), objects[i]->getWorldTransform(), ground, plane, &height);
    }
    return double(-height);
}
} // namespace

bool qcMoves(const btCollisionObject& object)
{
    return btSoftBody::upcast(&object) != nullptr || !object.isStaticOrKinematicObject();
}

bool qcIsHeld(const btSoftBody& soft)
{
    bool isHeld = soft.m_anchors.size() > 0;
    for (int i = 0; i < soft.m_nodes.size(); i++)
        isHeld |= soft.m_nodes[i].m_im <= 0;
    return isHeld;
}

qcWorldSupport qcMeasureSupport(const btDiscreteDynamicsWorld& world)
{
    qcWorldSupport support;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    Groups groups(objects.size());
    UniteTouching(world, &groups);
    std::vector<char> isFixed(size_t(objects.size()), 0);
    for (int i = 0; i < objects.size(); i++)
    {
        const btSoftBody* soft = btSoftBody::upcast(objects[i]);
        if (soft != nullptr ? qcIsHeld(*soft) : !qcMoves(*objects[i]))
            isFixed[groups.Find(size_t(i))] = 1;
        if (const btStaticPlaneShape* plane = PlaneOf(*objects[i]))
            support.below = std::max(support.below, DepthBelow(objects, *objects[i], *plane));
    }
    for (int i = 0; i < objects.size(); i++)
        support.hanging += qcMoves(*objects[i]) && !isFixed[groups.Find(size_t(i))];
    return support;
}
