// The objects in a world, by the proxies of its broadphase.
#ifndef QC_GLUE_COMMON_LIVE_OBJECTS_H
#define QC_GLUE_COMMON_LIVE_OBJECTS_H

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>

#include <algorithm>
#include <utility>
#include <vector>

/// A snapshot of the proxies, or of those that overlap a box, taken by the first query. Reads nothing of the objects:
/// they may be deleted already.
class qcLiveObjects : public btBroadphaseAabbCallback
{
  public:
    explicit qcLiveObjects(btBroadphaseInterface* broadphase)
        : qcLiveObjects(broadphase, btVector3(-BT_LARGE_FLOAT, -BT_LARGE_FLOAT, -BT_LARGE_FLOAT),
                        btVector3(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT))
    {
    }

    qcLiveObjects(btBroadphaseInterface* broadphase, const btVector3& lower, const btVector3& upper)
        : m_broadphase(broadphase), m_lower(lower), m_upper(upper)
    {
    }

    bool process(const btBroadphaseProxy* proxy) override
    {
        m_objects.emplace_back(proxy->m_clientObject, proxy->m_uniqueId);
        return true;
    }

    /// True if the object of this address is in the world under this id (qcUniqueIdOf). O(log objects) after the first.
    bool Contains(const void* object, int uniqueId)
    {
        if (m_objects.empty())
        {
            m_broadphase->aabbTest(m_lower, m_upper, *this);
            std::sort(m_objects.begin(), m_objects.end());
        }
        return std::binary_search(m_objects.begin(), m_objects.end(), std::make_pair(object, uniqueId));
    }

    /// The next query takes a new snapshot: objects may have been added or removed.
    void Invalidate()
    {
        m_objects.clear();
    }

  private:
    btBroadphaseInterface* m_broadphase;
    btVector3 m_lower, m_upper;
    std::vector<std::pair<const void*, int>> m_objects;
};

#endif
