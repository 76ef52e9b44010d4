// The objects of broadphases, and those in a box.
#ifndef QC_GLUE_SOFT_BODY_SCENE_OBJECTS_IN_BOX_H
#define QC_GLUE_SOFT_BODY_SCENE_OBJECTS_IN_BOX_H

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

#include <algorithm>
#include <vector>

using qcBroadphases = std::vector<btBroadphaseInterface*>; ///< of the bodies of a step, each once

/// Adds a broadphase, unless it is null or there.
inline void qcAddBroadphase(btBroadphaseInterface* broadphase, qcBroadphases* broadphases)
{
    if (broadphase != nullptr && std::find(broadphases->begin(), broadphases->end(), broadphase) == broadphases->end())
        broadphases->push_back(broadphase);
}

/// Calls function(object) for each object whose box in the broadphase overlaps a box.
template <typename Function>
void qcForEachObjectIn(btBroadphaseInterface* broadphase, const btVector3& lower, const btVector3& upper,
                       const Function& function)
{
    struct Callback : btBroadphaseAabbCallback
    {
        explicit Callback(const Function& called) : function(called)
        {
        }

        bool process(const btBroadphaseProxy* proxy) override
        {
            function(static_cast<btCollisionObject*>(proxy->m_clientObject));
            return true;
        }

        const Function& function;
    };
    Callback callback(function);
    broadphase->aabbTest(lower, upper, callback);
}

/// Calls function(object, broadphase) for each object of the broadphases that is not a soft body.
template <typename Function> void qcForEachObject(const qcBroadphases& broadphases, const Function& function)
{
    const btVector3 far(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
    for (btBroadphaseInterface* broadphase : broadphases)
        qcForEachObjectIn(broadphase, -far, far,
                          [&](btCollisionObject* object)
                          {
                              if (object->getInternalType() != btCollisionObject::CO_SOFT_BODY)
                                  function(object, broadphase);
                          });
}

#endif
