// Where the objects of a world start a step.
#include "mesh_contact/limits/swept_starts.h"

#include "common/rigid_motion.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <LinearMath/btTransformUtil.h>

namespace
{
// A kinematic convex shape that jumps further than this, in halves of its size, and than this many times of its motion
// in the step before, is put elsewhere.
constexpr btScalar s_longJump = 16, s_suddenJump = 4;

/// True if Bullet has moved the body in this step, by its present velocities.
bool IsIntegrated(const btRigidBody& body)
{
    return body.isActive() && qcAreSame(body.getInterpolationLinearVelocity(), body.getLinearVelocity()) &&
           qcAreSame(body.getInterpolationAngularVelocity(), body.getAngularVelocity());
}

/// True if Bullet's continuous collision has stopped the body in this step.
bool IsStoppedByBullet(const btCollisionObject& object)
{
    return object.getCcdSquareMotionThreshold() > 0 && object.getHitFraction() < 1;
}

/// True if the application has put an object of convex shapes elsewhere without notice, as platforms are that begin
/// their way anew.
bool HasJumped(const qcSweptObject& swept)
{
    const btScalar moved = swept.start.getOrigin().distance(swept.target.getOrigin());
    return swept.cores != nullptr && moved > s_longJump * qcHalfSize(swept.object->getCollisionShape()) &&
           moved > s_suddenJump * swept.motion.length();
}
} // namespace

void qcSweptStarts::FindByVelocities(btScalar timeStep, qcSweptObject* swept)
{
    const btVector3 &linear = swept->body->getLinearVelocity(), &angular = swept->body->getAngularVelocity();
    if (swept->isNew)
    {
        if (IsIntegrated(*swept->body))
            btTransformUtil::integrateTransform(swept->target, linear, angular, -timeStep, swept->start);
        return;
    }
    btTransform expected;
    btTransformUtil::integrateTransform(swept->start, linear, angular, timeStep, expected);
    const btScalar radius = swept->radius;
    // Split impulses move bodies by more than their velocities do, and turn them most. Where a convex shape has contact
    // with others only, its start is not marked: it counts as put elsewhere only if its origin is.
    const bool isExplained =
        swept->cores != nullptr
            ? expected.getOrigin().distance(swept->target.getOrigin()) <= gContactBreakingThreshold + radius / 2
            : qcDisplacementBound(expected, swept->target, radius) <= gContactBreakingThreshold;
    if (isExplained)
        return;
    if (swept->body->isActive())
        btTransformUtil::integrateTransform(swept->target, linear, angular, -timeStep, swept->start);
    else
        swept->start = swept->target;
}

void qcSweptStarts::Find(btScalar timeStep, qcSweptObject* swept) const
{
    // One that the application has given finite values within the step starts there.
    if (!swept->wasFinite)
        swept->start = swept->target;
    // A convex shape was not there to be marked before it was fast. If Bullet's continuous collision has stopped it,
    // its velocity does not give the start.
    bool isMarked = m_areMarked;
    if (swept->isNew && swept->cores != nullptr)
    {
        isMarked = IsStoppedByBullet(*swept->object);
        const auto start = m_continuous.find(qcObjectKey(swept->object));
        if (isMarked && start != m_continuous.end())
            swept->start = start->second;
    }
    if (!isMarked && swept->body != nullptr && (swept->isNew || !qcAreSame(swept->start, swept->target)))
        FindByVelocities(timeStep, swept);
}

void qcSweptStarts::StartWherePut(const qcTranslation& shift, btScalar timeStep, qcSweptObject* swept)
{
    const btVector3 motion = swept->target.getOrigin() - swept->start.getOrigin();
    if (!swept->IsFree() && !qcAreSame(swept->start, swept->target) &&
        (shift.IsOf(swept->start, swept->target) || HasJumped(*swept) ||
         !qcIsMotion(swept->object, swept->start, swept->target, swept->motion, timeStep)))
        swept->start = swept->target;
    swept->motion = motion;
}
