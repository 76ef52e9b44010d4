// Which rigid objects are still there.
#include "soft_body/response/present_objects.h"

#include "soft_body/response/position_constraints.h"

#include <algorithm>
#include <functional>

namespace
{
bool IsLess(const qcObjectKey& a, const qcObjectKey& b)
{
    return a.object != b.object ? std::less<const void*>()(a.object, b.object) : a.uniqueId < b.uniqueId;
}
} // namespace

qcPresentObjects::qcPresentObjects(qcSoftBodyScene& scene)
{
    m_dispatched.swap(scene.liveObjects);
    std::sort(m_dispatched.begin(), m_dispatched.end(), IsLess);
}

bool qcPresentObjects::Contains(const qcSceneSoftBody& soft, const qcObjectKey& object)
{
    btBroadphaseInterface* broadphase = soft.body->getWorldInfo()->m_broadphase;
    const btBroadphaseProxy* proxy = soft.body->getBroadphaseHandle();
    if (broadphase == nullptr || proxy == nullptr ||
        !std::binary_search(m_dispatched.begin(), m_dispatched.end(), object, IsLess))
        return false;
    if (m_soft != &soft)
        // A tick callback may have removed objects since collision detection.
        m_near = qcLiveObjects(broadphase, proxy->m_aabbMin, proxy->m_aabbMax);
    m_soft = &soft;
    return m_near.Contains(object.object, object.uniqueId) && qcHasResponse(soft, object.object);
}
