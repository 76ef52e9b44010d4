// Which objects have one of Bullet's own shapes. Such a shape has no number of its own: a new one may lie at the
// address of a deleted one, and look alike from outside.
#ifndef QC_GLUE_COMMON_SHAPE_OWNERS_H
#define QC_GLUE_COMMON_SHAPE_OWNERS_H

#include "common/compound_children.h"
#include "common/object_key.h"

#include <algorithm>
#include <unordered_map>

class qcShapeOwners
{
  public:
    /// Adds an object that has the shape. True if what is known of the shape still holds: this object has had it
    /// before, or another one that is still in its world, isLive(key). False: the object is its first owner. O(1), for
    /// a new object O(owners).
    template <typename IsLive>
    bool Add(const btCollisionObject* object, const btCollisionShape* shape, uint64_t step, const IsLive& isLive)
    {
        const qcObjectKey key(object);
        auto found = m_steps.find(key);
        if (found != m_steps.end())
        {
            found->second = step;
            return true;
        }
        auto hasShape = [shape, &isLive](const auto& owner)
        { return isLive(owner.first) && Has(owner.first.object->getCollisionShape(), shape); };
        const bool isKnown = std::any_of(m_steps.begin(), m_steps.end(), hasShape);
        if (!isKnown)
            m_steps.clear();
        m_steps.emplace(key, step);
        return isKnown;
    }
    /// Forgets the objects that were last added before this step.
    void ForgetBefore(uint64_t step)
    {
        for (auto owner = m_steps.begin(); owner != m_steps.end();)
            owner = owner->second < step ? m_steps.erase(owner) : std::next(owner);
    }

  private:
    static bool Has(const btCollisionShape* root, const btCollisionShape* shape)
    {
        bool has = false;
        qcForEachSimpleShape(root, btTransform::getIdentity(),
                             [&has, shape](const btCollisionShape* simple, const btTransform&)
                             { has = has || simple == shape; });
        return has;
    }

    std::unordered_map<qcObjectKey, uint64_t, qcObjectKeyHash> m_steps; ///< the last one that has added the object
};

#endif
