// Debug drawing of a world: its manifolds and boxes, and what the contact classes draw of themselves.
#include "quickcullide/bullet_debug_draw.h"

#include "common/debug_draw.h"
#include "common/finite.h"
#include "quickcullide/bullet_mesh.h"
#include "quickcullide/bullet_soft_body.h"

#include <algorithm>

namespace
{
bool IsDrawn(const btVector3& v)
{
    return qcIsFinite(v) && v.length2() < BT_LARGE_FLOAT * BT_LARGE_FLOAT;
}

void DrawPoints(const btPersistentManifold& manifold, btIDebugDraw* drawer)
{
    for (int i = 0; i < manifold.getNumContacts(); i++)
    {
        const btManifoldPoint& point = manifold.getContactPoint(i);
        drawer->drawContactPoint(point.m_positionWorldOnB, point.m_normalWorldOnB, point.getDistance(),
                                 point.getLifeTime(), drawer->getDefaultColors().m_contactPoint);
    }
}

/// Draws the points as a polygon, in their order around its middle.
void DrawOutline(const btPersistentManifold& manifold, btIDebugDraw* drawer)
{
    int count = manifold.getNumContacts();
    if (count < 2)
        return;
    btVector3 middle(0, 0, 0), u, v;
    for (int i = 0; i < count; i++)
        middle += manifold.getContactPoint(i).m_positionWorldOnB / btScalar(count);
    btPlaneSpace1(manifold.getContactPoint(0).m_normalWorldOnB, u, v);
    std::vector<std::pair<btScalar, btVector3>> corners;
    for (int i = 0; i < count; i++)
    {
        btVector3 corner = manifold.getContactPoint(i).m_positionWorldOnB, arm = corner - middle;
        corners.emplace_back(btAtan2(arm.dot(v), arm.dot(u)), corner);
    }
    std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (int i = 0; i < (count == 2 ? 1 : count); i++)
        drawer->drawLine(corners[size_t(i)].second, corners[size_t((i + 1) % count)].second, qcManifoldColor());
}

void DrawManifolds(const btCollisionWorld& world, int modes, btIDebugDraw* drawer)
{
    const btDispatcher* dispatcher = world.getDispatcher();
    for (int m = 0; m < dispatcher->getNumManifolds(); m++)
    {
        const btPersistentManifold& manifold = *const_cast<btDispatcher*>(dispatcher)->getManifoldByIndexInternal(m);
        if ((modes & qc_drawContacts) != 0)
            DrawPoints(manifold, drawer);
        if ((modes & qc_drawManifolds) != 0)
            DrawOutline(manifold, drawer);
    }
}

void DrawBoxes(const btCollisionWorld& world, btIDebugDraw* drawer)
{
    btIDebugDraw::DefaultColors colors = drawer->getDefaultColors();
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        const btBroadphaseProxy* proxy = objects[i]->getBroadphaseHandle();
        if (proxy != nullptr && IsDrawn(proxy->m_aabbMin) && IsDrawn(proxy->m_aabbMax))
            drawer->drawAabb(proxy->m_aabbMin, proxy->m_aabbMax, colors.m_aabb);
    }
    auto middleOf = [](const btBroadphaseProxy* proxy) { return (proxy->m_aabbMin + proxy->m_aabbMax) / 2; };
    btOverlappingPairCache* cache = const_cast<btCollisionWorld&>(world).getPairCache();
    const btBroadphasePair* pairs = cache->getOverlappingPairArrayPtr();
    for (int i = 0; i < cache->getNumOverlappingPairs(); i++)
    {
        btVector3 from = middleOf(pairs[i].m_pProxy0), to = middleOf(pairs[i].m_pProxy1);
        if (IsDrawn(from) && IsDrawn(to))
            drawer->drawLine(from, to, colors.m_contactPoint);
    }
}
} // namespace

qcDebugDraw::qcDebugDraw(btCollisionWorld* world, int modes) : m_world(world), m_modes(modes)
{
}

qcDebugDraw::~qcDebugDraw()
{
    setModes(0);
}

void qcDebugDraw::add(qcSoftBodyContact* contact)
{
    if (contact == nullptr)
        return;
    m_softContacts.push_back(contact);
    setModes(m_modes);
}

void qcDebugDraw::add(qcMeshContact* contact)
{
    if (contact == nullptr)
        return;
    m_meshContacts.push_back(contact);
    setModes(m_modes);
}

void qcDebugDraw::setModes(int modes)
{
    m_modes = modes;
    for (qcSoftBodyContact* contact : m_softContacts)
        contact->setReportCandidates((modes & qc_drawCandidates) != 0);
    for (qcMeshContact* contact : m_meshContacts)
        contact->setReportCandidates((modes & qc_drawCandidates) != 0);
}

int qcDebugDraw::getModes() const
{
    return m_modes;
}

void qcDebugDraw::debugDraw(btIDebugDraw* drawer)
{
    for (const qcSoftBodyContact* contact : m_softContacts)
        contact->debugDraw(drawer, m_modes);
    for (const qcMeshContact* contact : m_meshContacts)
        contact->debugDraw(drawer, m_modes);
    if ((m_modes & (qc_drawContacts | qc_drawManifolds)) != 0)
        DrawManifolds(*m_world, m_modes, drawer);
    if ((m_modes & qc_drawBoxes) != 0)
        DrawBoxes(*m_world, drawer);
    drawer->flushLines();
}

void qcDebugDraw::updateAction(btCollisionWorld*, btScalar)
{
}
