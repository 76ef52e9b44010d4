// The certificates of a world's rigid meshes (qcMeshContact), for the soft bodies of the same world: each of the two
// moves bodies that the other has proven apart.
#ifndef QC_GLUE_COMMON_RIGID_LIMITS_H
#define QC_GLUE_COMMON_RIGID_LIMITS_H

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

#include <functional>
#include <vector>

class btDispatcher;

/// Where an object that soft bodies may have moved starts the step; null: they have not moved it.
using qcStartFunction = std::function<const btTransform*(const btCollisionObject*)>;

class qcRigidLimits
{
  public:
    virtual ~qcRigidLimits() = default;
    /// Certifies the motions of the step before soft bodies do, in worlds whose actions run after the soft bodies.
    virtual void LimitFirst(btScalar timeStep) = 0;
    /// Certifies them again if bodies have been moved since. Bodies in `held` return to the start of the step. Appends
    /// the objects that it moves to `moved`.
    virtual void LimitAgain(btScalar timeStep, const std::vector<const btCollisionObject*>& held,
                            const qcStartFunction& startOf, std::vector<const btCollisionObject*>* moved) = 0;
    /// True if the last certification has seen or moved the object at its present transform.
    virtual bool HasCertified(const btCollisionObject* object) const = 0;
};

/// Registers the limits of the world with this dispatcher. Thread-safe.
void qcAddRigidLimits(const btDispatcher* dispatcher, qcRigidLimits* limits);

/// Undoes qcAddRigidLimits. Thread-safe.
void qcRemoveRigidLimits(const qcRigidLimits* limits);

/// The limits of the world with this dispatcher, or null. Thread-safe.
qcRigidLimits* qcFindRigidLimits(const btDispatcher* dispatcher);

#endif
