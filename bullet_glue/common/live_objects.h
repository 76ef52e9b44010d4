// Which objects are in a world, by what its broadphase holds.
#ifndef QC_GLUE_COMMON_LIVE_OBJECTS_H
#define QC_GLUE_COMMON_LIVE_OBJECTS_H

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>

#include <algorithm>
#include <utility>
#include <vector>

/// Reads nothing of the objects, which may be gone.
class qcObjectCensus : public btBroadphaseAabbCallback
{
  public:
    explicit qcObjectCensus(btBroadphaseInterface* broadphase) : m_broadphase(broadphase)
    {
    }

    bool process(const btBroadphaseProxy* proxy) override
    {
        m_objects.emplace_back(proxy->m_clientObject, proxy->m_uniqueId);
        return true;
    }

    /// Is the object of this address, added to the world under this number, still there?
    bool Has(const void* object, int addition)
    {
        if (m_objects.empty())
        {
            const btVector3 far(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
            m_broadphase->aabbTest(-far, far, *this);
            std::sort(m_objects.begin(), m_objects.end());
        }
        return std::binary_search(m_objects.begin(), m_objects.end(), std::make_pair(object, addition));
    }

    /// Objects may have been added or removed.
    void Forget()
    {
        m_objects.clear();
    }

  private:
    btBroadphaseInterface* m_broadphase;
    std::vector<std::pair<const void*, int>> m_objects;
};

#endif
