// How contacts move a rigid object.
#include "soft_body/scene/scene_rigid.h"

#include "common/changed_shapes.h"
#include "soft_body/scene/scene_soft_body.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btAabbUtil2.h>

/// The displacement if `push` acts at `arm` from the centre; none if that leads a guided object elsewhere.
qcRigidDisplacement qcSceneRigid::DisplacementBy(const btVector3& arm, const btVector3& push) const
{
    qcRigidDisplacement by;
    if (isFixed)
        return by;
    if (multibody != nullptr)
        by = multibody->DisplacementBy(link, arm, push);
    else if (body != nullptr)
        by = qcDisplacementBy(*body, arm, push * massShare);
    return isGuided && qcIsLedElsewhere(by.At(arm), push) ? qcRigidDisplacement() : by;
}

btVector3 qcSceneRigid::DisplacementAt(const btVector3& arm, const btVector3& push) const
{
    return DisplacementBy(arm, push).At(arm);
}

void qcSceneRigid::Push(const btVector3& arm, const btVector3& push)
{
    const qcRigidDisplacement by = DisplacementBy(arm, push);
    if (multibody == nullptr)
    {
        pushed.linear += by.linear;
        pushed.angular += by.angular;
        if (!tied.empty())
            MoveTied();
    }
    else if (!by.linear.isZero() || !by.angular.isZero())
        multibody->Push(link, arm, push);
}

void qcSceneRigid::Tie(qcSceneSoftBody* soft, uint32_t node)
{
    tied.push_back({soft, node, object->getWorldTransform().invXform(soft->positions[node])});
    // Tied nodes weigh what they did.
    massShare = 1 / (1 / massShare + body->getInvMass() / soft->body->m_nodes[int(node)].m_im);
}

void qcSceneRigid::MoveTied() const
{
    const btTransform& now = object->getWorldTransform();
    for (const qcTiedNode& node : tied)
    {
        const btVector3 place = now * node.local;
        node.soft->positions[node.node] = place + pushed.At(place - now.getOrigin());
    }
}

void qcSceneRigid::Wake() const
{
    // Colliders of a multibody that sleeps may be active. A fixed base has a state of its own.
    const btMultiBodyLinkCollider* asLink = qcAsLink(object);
    if (object->isStaticOrKinematicObject() || object->getActivationState() == FIXED_BASE_MULTI_BODY ||
        (object->isActive() && (asLink == nullptr || asLink->m_multiBody->isAwake())) ||
        (asLink != nullptr && !asLink->m_multiBody->getCanWakeup()))
        return;
    object->activate();
    if (asLink != nullptr)
        asLink->m_multiBody->wakeUp();
}

bool qcSceneRigid::IsFree() const
{
    return body != nullptr && !isFixed && qcIsFree(*body);
}

btTransform qcSceneRigid::MotionTo(const btTransform& transform) const
{
    return qcAreSame(transform, start) ? btTransform::getIdentity() : transform * start.inverse();
}

void qcSceneRigid::Invalidate(const btCollisionShape* shape)
{
    for (qcSceneShape& known : shapes)
        if (known.shape == shape && known.surface != nullptr)
            known.revision = qcStaleRevision;
}

void qcSceneRigid::DeformFrom(const qcSceneRigid& last)
{
    for (qcSceneMesh& mesh : meshes)
        for (const qcSceneMesh& lastMesh : last.meshes)
            mesh.DeformFrom(lastMesh);
}

void qcSceneRigid::TakeBodies(qcSceneRigid* last)
{
    for (qcSceneMesh& mesh : meshes)
        for (qcSceneMesh& lastMesh : last->meshes)
            mesh.TakeBody(&lastMesh);
}

bool qcSceneRigid::Rest()
{
    return std::all_of(meshes.begin(), meshes.end(), [](qcSceneMesh& mesh) { return !mesh.Deforms() || mesh.Rest(); });
}

void qcSceneRigid::FindMotionBox(const qcSceneMesh& mesh, btVector3 box[2]) const
{
    btVector3 present[2];
    mesh.shape->getAabb(start * mesh.local, box[0], box[1]);
    if (mesh.Deforms())
        btTransformAabb(mesh.startBox[0], mesh.startBox[1], mesh.shape->getMargin(), start * mesh.local, box[0],
                        box[1]);
    mesh.shape->getAabb(object->getWorldTransform() * mesh.local, present[0], present[1]);
    box[0].setMin(present[0]);
    box[1].setMax(present[1]);
}
