// Contact response of soft bodies: projections on positions, as Bullet's own soft-body constraints are.
// The side of a contact is the one on which its points were at the start of the step, when nothing penetrated: Bridson,
// Fedkiw, Anderson: Robust Treatment of Collisions, Contact and Friction for Cloth Animation, 2002, section 6.
#include "soft_body/response/position_constraints.h"

#include "common/shape_triangles.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>

#include <algorithm>

namespace
{
// Of a gap that is too small at the start of the step, the part made up for in one step: all at once would throw the
// surfaces apart, since positions become velocities.
constexpr btScalar s_recovery = btScalar(0.2);

void AddNodes(qcSceneSoftBody& body, const uint32_t vertices[3], const double weights[3], btScalar sign,
              qcSoftConstraint* constraint)
{
    body.inContact = true;
    constraint->accumulates |= body.topology.ropeCount > 0;
    for (int i = 0; i < 3; i++)
    {
        if (weights[i] == 0.0)
            continue;
        btScalar weight = sign * btScalar(weights[i]);
        btScalar inverseMass = body.InverseMass(vertices[i]);
        constraint->place[constraint->nodeCount] = &body.places[vertices[i]];
        constraint->inverseMass[constraint->nodeCount] = inverseMass;
        constraint->weight[constraint->nodeCount++] = weight;
        constraint->inverseEffectiveMass += weight * weight * inverseMass;
        constraint->startOffset += weight * body.start[vertices[i]];
    }
}

btVector3 Offset(const qcSoftConstraint& constraint)
{
    btVector3 offset(0, 0, 0);
    for (int i = 0; i < constraint.nodeCount; i++)
        offset += constraint.weight[i] * *constraint.place[i];
    if (const qcSceneRigid* rigid = constraint.rigid)
        offset -= constraint.point + rigid->linear + rigid->angular.cross(constraint.arm);
    return offset;
}

/// What the constraint lacks, shared out by weight and mass so that it then holds; but no node moves further than is
/// lacking: where only one with a small weight can move, it would be thrown away.
void Push(const qcSoftConstraint& constraint, const btVector3& lack)
{
    btScalar largest = constraint.inverseEffectiveMass;
    if (constraint.rigid != nullptr && lack.length2() > 0)
        largest += constraint.rigid->Yield(constraint.arm, lack).dot(lack) / lack.length2();
    for (int i = 0; i < constraint.nodeCount; i++)
        largest = std::max(largest, btFabs(constraint.weight[i]) * constraint.inverseMass[i]);
    if (largest <= 0)
        return;
    for (int i = 0; i < constraint.nodeCount; i++)
        *constraint.place[i] += lack * (constraint.weight[i] * constraint.inverseMass[i] / largest);
    if (constraint.rigid != nullptr)
        constraint.rigid->Push(constraint.arm, -lack / largest);
}

void Solve(qcSoftConstraint& constraint)
{
    btVector3 offset = Offset(constraint);
    btScalar missing = constraint.distance - constraint.normal.dot(offset);
    const btScalar before = constraint.accumulates ? constraint.pushed : btScalar(0);
    const btVector3 takenBefore = constraint.accumulates ? constraint.taken : btVector3(0, 0, 0);
    constraint.pushed = before + missing;
    if (constraint.pushed <= 0)
        constraint.pushed = 0;
    if (constraint.pushed == before)
        return;
    Push(constraint, constraint.normal * (constraint.pushed - before));
    // Coulomb: what the normal push was, times the coefficient, may take back of the sliding since the start.
    btVector3 motion = offset - constraint.startOffset;
    btVector3 sliding = motion - constraint.normal * constraint.normal.dot(motion);
    if (sliding.length() <= SIMD_EPSILON)
        return;
    btVector3 taken = takenBefore + sliding;
    btScalar length = taken.length(), largest = constraint.friction * constraint.pushed;
    if (length > largest)
        taken *= largest / length;
    Push(constraint, takenBefore - taken);
    constraint.taken = taken;
}

/// Which way, and how far: what was apart at the start of the step stays on the side on which it was.
void Orient(btScalar thickness, const btVector3& normal, qcSoftConstraint* constraint)
{
    constraint->normal = normal;
    btScalar startDistance = normal.dot(constraint->startOffset);
    if (startDistance < 0)
    {
        // They have passed each other since.
        constraint->normal = -normal;
        startDistance = -startDistance;
    }
    constraint->distance =
        startDistance >= thickness ? thickness : startDistance + s_recovery * (thickness - startDistance);
}

btVector3 PointOf(const qcSceneSoftBody& soft, const uint32_t vertices[3], const double weights[3])
{
    btVector3 point(0, 0, 0);
    for (int i = 0; i < 3; i++)
        point += btScalar(weights[i]) * soft.places[vertices[i]];
    return point;
}

btVector3 PointOf(const qcSceneMesh& mesh, const uint32_t vertices[3], const double weights[3])
{
    btVector3 point(0, 0, 0);
    for (int i = 0; i < 3; i++)
        point += btScalar(weights[i]) * mesh.shape->getVertices()[vertices[i]];
    return mesh.placed * point;
}

/// Do Bullet's filters let them meet?
bool AreFiltered(const btSoftBody* soft, const btCollisionObject* other)
{
    const btSoftBodyWorldInfo* info = const_cast<btSoftBody*>(soft)->getWorldInfo();
    auto* proxyA = const_cast<btBroadphaseProxy*>(soft->getBroadphaseHandle());
    auto* proxyB = const_cast<btBroadphaseProxy*>(other->getBroadphaseHandle());
    if (info->m_dispatcher == nullptr || info->m_broadphase == nullptr || proxyA == nullptr || proxyB == nullptr)
        return true;
    return !info->m_dispatcher->needsCollision(soft, other) ||
           !info->m_broadphase->getOverlappingPairCache()->needsBroadphaseCollision(proxyA, proxyB);
}
} // namespace

bool qcMayPush(const qcSceneSoftBody& soft, const qcSceneRigid& rigid)
{
    const auto& disabled = soft.body->m_collisionDisabledObjects;
    return soft.MeetsRigidBodies() && rigid.object->hasContactResponse() && !AreFiltered(soft.body, rigid.object) &&
           disabled.findLinearSearch(rigid.object) == disabled.size();
}

bool qcMayPush(qcSoftBodyScene& scene, uint32_t slotA, uint32_t slotB)
{
    const qcSceneSoftBody *a = scene.Find(slotA), *b = scene.Find(slotB);
    qcSceneRigid* rigid = nullptr;
    if (a == nullptr || b == nullptr)
    {
        scene.meshes.Find(a == nullptr ? slotA : slotB, &rigid);
        return qcMayPush(a == nullptr ? *b : *a, *rigid);
    }
    // With itself: the scene reports only what has self-collision on.
    // Asked here and not gathered from processCollision: Bullet overlaps boxes of predicted positions, and its own
    // constraints may bring together what was apart there.
    return a == b || !AreFiltered(a->body, b->body);
}

bool qcReadTouch(qcSoftBodyScene& scene, const qcContact& contact, qcSoftTouch* touch)
{
    bool swapped = scene.Find(contact.bodyA) == nullptr;
    uint32_t slotA = swapped ? contact.bodyB : contact.bodyA, slotB = swapped ? contact.bodyA : contact.bodyB;
    touch->a = scene.Find(slotA);
    touch->b = scene.Find(slotB);
    touch->verticesA = swapped ? contact.verticesB : contact.verticesA;
    touch->verticesB = swapped ? contact.verticesA : contact.verticesB;
    touch->weightsA = swapped ? contact.weightsB : contact.weightsA;
    touch->weightsB = swapped ? contact.weightsA : contact.weightsB;
    touch->normal = swapped ? -qcVectorOf(contact.normal) : qcVectorOf(contact.normal);
    touch->distance = btScalar(contact.distance);
    touch->onA = PointOf(*touch->a, touch->verticesA, touch->weightsA);
    if (touch->b != nullptr)
    {
        touch->thickness = (touch->a->thickness + touch->b->thickness) / 2;
        touch->friction = (touch->a->settings.friction + touch->b->settings.friction) / 2;
        touch->onB = PointOf(*touch->b, touch->verticesB, touch->weightsB);
    }
    else
    {
        const qcSceneMesh& mesh = *scene.meshes.Find(slotB, &touch->rigid);
        touch->thickness = touch->a->thickness / 2 + mesh.shape->getMargin();
        touch->friction = (touch->a->settings.friction + touch->rigid->object->getFriction()) / 2;
        touch->onB = PointOf(mesh, touch->verticesB, touch->weightsB);
    }
    return touch->distance <= touch->thickness && qcMayPush(scene, slotA, slotB);
}

bool qcMakeMeshConstraint(qcSceneSoftBody& soft, const uint32_t vertices[3], const double weights[3],
                          qcSceneRigid& rigid, const btVector3& point, const btVector3& normal, btScalar thickness,
                          qcSoftConstraint* constraint)
{
    *constraint = qcSoftConstraint();
    AddNodes(soft, vertices, weights, 1, constraint);
    const btTransform& now = rigid.object->getWorldTransform();
    constraint->rigid = &rigid;
    constraint->point = now * point;
    constraint->arm = constraint->point - now.getOrigin();
    constraint->startOffset -= rigid.start * point;
    constraint->friction = (soft.settings.friction + rigid.object->getFriction()) / 2;
    Orient(thickness, normal, constraint);
    // As Bullet's own contact of soft bodies wakes what it touches; it is moved from the next step on.
    if (soft.moves && !rigid.object->isActive() && !rigid.object->isStaticOrKinematicObject())
        rigid.object->activate();
    return constraint->inverseEffectiveMass > 0 || rigid.body != nullptr;
}

void qcMakeSoftConstraints(qcSoftBodyScene& scene, const qcSoftTangles& tangles, const qcResult& result,
                           std::vector<qcSoftConstraint>* constraints, std::vector<size_t>* contactOf)
{
    constraints->clear();
    contactOf->clear();
    for (size_t i = 0; i < result.contactCount; i++)
    {
        qcSoftTouch touch;
        if (!qcReadTouch(scene, result.contacts[i], &touch) || tangles.IsExempt(result.contacts[i]))
            continue;
        qcSoftConstraint constraint;
        if (touch.rigid != nullptr)
        {
            btVector3 point = touch.rigid->object->getWorldTransform().invXform(touch.onB);
            if (!qcMakeMeshConstraint(*touch.a, touch.verticesA, touch.weightsA, *touch.rigid, point, touch.normal,
                                      touch.thickness, &constraint))
                continue;
        }
        else
        {
            AddNodes(*touch.a, touch.verticesA, touch.weightsA, 1, &constraint);
            AddNodes(*touch.b, touch.verticesB, touch.weightsB, -1, &constraint);
            if (constraint.inverseEffectiveMass <= 0)
                continue;
            constraint.friction = touch.friction;
            Orient(touch.thickness, touch.normal, &constraint);
        }
        constraints->push_back(constraint);
        contactOf->push_back(i);
    }
}

void qcSolveSoftConstraints(std::vector<qcSoftConstraint>* constraints, const std::vector<qcSoftLink>& links,
                            std::vector<qcSoftSupport>* supports, int iterations)
{
    size_t held = 0;
    for (int i = 0; i < iterations; i++)
    {
        // Before the first sweep links are as Bullet solved them.
        if (i > 0)
            qcSolveLinks(links);
        for (qcSoftConstraint& constraint : *constraints)
            Solve(constraint);
        // Few of all nodes that lie on something are in a contact: they show in the first sweep, or in the last one.
        if (i == 0)
            held = qcMovedSupports(supports);
        qcHoldSupports(supports, i + 1 < iterations ? held : supports->size());
    }
}
