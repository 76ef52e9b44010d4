// How contacts move the rigid objects near soft bodies, and what velocities that gives these.
#include "soft_body/scene/rigid_meshes.h"

#include "common/object_key.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>

bool qcRigidMeshes::Commit()
{
    bool any = false;
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        const qcRigidDisplacement pushed = rigid->pushed;
        if (pushed.linear.isZero() && pushed.angular.isZero())
            continue;
        btTransform moved;
        btTransformUtil::integrateTransform(rigid->object->getWorldTransform(), pushed.linear, pushed.angular, 1,
                                            moved);
        rigid->object->setWorldTransform(moved);
        rigid->moved.linear += pushed.linear;
        rigid->moved.angular += pushed.angular;
        rigid->pushed = qcRigidDisplacement();
        rigid->MoveTied();
        any = true;
    }
    for (const std::unique_ptr<qcMultiBodyMotion>& multibody : m_multibodies)
        any = multibody->Commit() || any;
    return any;
}

void qcRigidMeshes::MoveFromStart(qcSceneRigid& rigid, const btTransform& motion)
{
    if (!rigid.IsFree())
        return;
    rigid.fromStart = true;
    rigid.object->setWorldTransform(qcAreSame(motion, btTransform::getIdentity()) ? rigid.start : motion * rigid.start);
}

void qcRigidMeshes::UpdateVelocities(btScalar timeStep)
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        btRigidBody* body = rigid->body;
        bool moved = rigid->fromStart || !rigid->moved.linear.isZero() || !rigid->moved.angular.isZero();
        if (body == nullptr || !moved)
            continue;
        if (rigid->fromStart)
        {
            btVector3 linear, angular;
            btTransformUtil::calculateVelocity(rigid->start, rigid->object->getWorldTransform(), timeStep, linear,
                                               angular);
            body->setLinearVelocity(linear);
            body->setAngularVelocity(angular);
        }
        else
        {
            const btVector3 linear = rigid->moved.linear - rigid->recovered.linear,
                            angular = rigid->moved.angular - rigid->recovered.angular;
            body->setLinearVelocity(body->getLinearVelocity() + linear / timeStep);
            body->setAngularVelocity(body->getAngularVelocity() + angular / timeStep);
        }
        // Also sets Bullet's interpolation transform and the inertia tensor in world space.
        body->setCenterOfMassTransform(btTransform(rigid->object->getWorldTransform()));
        rigid->fromStart = false;
        rigid->moved = rigid->recovered = qcRigidDisplacement();
    }
    for (const std::unique_ptr<qcMultiBodyMotion>& multibody : m_multibodies)
        multibody->UpdateVelocities(timeStep);
    RecordEnds();
}

bool qcRigidMeshes::Fix(const std::vector<const btCollisionObject*>& objects)
{
    bool any = false;
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        if (std::find(objects.begin(), objects.end(), rigid->object) != objects.end())
            rigid->isFixed = any = true;
    return any;
}

void qcRigidMeshes::MoveTied(const std::vector<const btCollisionObject*>& objects) const
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        if (std::find(objects.begin(), objects.end(), rigid->object) != objects.end())
            rigid->MoveTied();
}

bool qcRigidMeshes::ReturnToStart(const std::vector<qcSceneRigid*>& rigids)
{
    for (qcSceneRigid* returned : rigids)
    {
        qcMultiBodyMotion* multibody = returned->multibody;
        if (!returned->isGuided || returned->isFixed || (multibody != nullptr && !multibody->ReturnToStart()))
            continue;
        if (multibody == nullptr)
        {
            returned->isFixed = returned->fromStart = true;
            returned->object->setWorldTransform(returned->start);
            returned->MoveTied();
        }
        else
            for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
                rigid->isFixed = rigid->isFixed || rigid->multibody == multibody;
        return true;
    }
    return false;
}

void qcRigidMeshes::RecordEnds()
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        rigid->hasEnd = true;
        rigid->end = rigid->object->getWorldTransform();
        m_starts.RecordEnd(rigid->object);
    }
    // Links that are not in the scene, since soft bodies leave their shapes to Bullet, have moved, too.
    for (const std::unique_ptr<qcMultiBodyMotion>& multibody : m_multibodies)
        multibody->ForEachMovedCollider([this](const btCollisionObject* link) { m_starts.RecordEnd(link); });
}

void qcRigidMeshes::Restore()
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        rigid->pushed = qcRigidDisplacement();
        if (rigid->body != nullptr)
            rigid->object->setWorldTransform(rigid->solved);
    }
    for (const std::unique_ptr<qcMultiBodyMotion>& multibody : m_multibodies)
        multibody->Restore();
    RecordEnds();
}
