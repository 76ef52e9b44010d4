// The velocities of bodies whose motion in a step was limited.
#include "mesh_contact/limits/limited_velocities.h"

#include <LinearMath/btTransformUtil.h>

namespace
{
/// The part of the step's motion along gravity that a body does not make.
btScalar LostPart(const qcSweptObject& swept)
{
    const btVector3 &from = swept.start.getOrigin(), &gravity = swept.body->getGravity();
    btScalar all = gravity.dot(swept.body->getWorldTransform().getOrigin() - from);
    btScalar made = gravity.dot(swept.end.getOrigin() - from);
    return all > 0 ? btClamped(1 - made / all, btScalar(0), btScalar(1)) : 1 - swept.fraction;
}

/// Takes back what gravity has done to a body's velocity for the motion that it does not make, as far as it still has
/// that: contact takes it from what rests. Other forces may be those of two bodies on each other, whose momentum is
/// kept.
void TakeBackGravity(qcSweptObject* swept, btScalar timeStep)
{
    btRigidBody* body = swept->body;
    const btVector3 gain = body->getGravity() * body->getLinearFactor() * timeStep;
    if (!(gain.length2() > 0))
        return;
    const btScalar lost = LostPart(*swept), left = 1 - swept->lost;
    const btVector3 &velocity = body->getLinearVelocity(), change = swept->before ? velocity - *swept->before : gain;
    body->setLinearVelocity(velocity - gain * (lost * btClamped(gain.dot(change) / gain.length2(), btScalar(0), left)));
    swept->lost += left * lost;
}

/// The angular velocity turns with the body from where Bullet has moved it: a slender one that spins about its axis
/// would gain energy if it were tilted only.
void TurnSpin(const qcSweptObject& swept)
{
    const btMatrix3x3 &from = swept.body->getWorldTransform().getBasis(), &to = swept.end.getBasis();
    if (!(from == to))
        swept.body->setAngularVelocity(to * (from.transpose() * swept.body->getAngularVelocity()) *
                                       swept.body->getAngularFactor());
}
} // namespace

void qcMoveLimited(qcSweptObject* swept, const qcSweptObject* carrier, btScalar timeStep)
{
    btRigidBody* body = swept->body;
    if (carrier != nullptr && carrier->moves && swept->fraction <= 0)
    {
        btVector3 linear, angular;
        btTransformUtil::calculateVelocity(swept->start, swept->end, timeStep, linear, angular);
        body->setLinearVelocity(linear * body->getLinearFactor());
        body->setAngularVelocity(angular * body->getAngularFactor());
        swept->lost = 1;
    }
    else
    {
        TakeBackGravity(swept, timeStep);
        TurnSpin(*swept);
    }
    swept->isLimited = true;
    body->proceedToTransform(swept->end);
    body->activate();
}
