// Contact response of soft bodies: projections on positions, as Bullet's own soft-body constraints are.
// The side of a contact is the one on which its points were at the start of the step, when nothing penetrated: Bridson,
// Fedkiw, Anderson: Robust Treatment of Collisions, Contact and Friction for Cloth Animation, 2002, section 6.
#include "soft_body_response.h"

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
    for (int i = 0; i < 3; i++)
    {
        if (weights[i] == 0.0)
            continue;
        btSoftBody::Node* node = &body.body->m_nodes[int(vertices[i])];
        btScalar weight = sign * btScalar(weights[i]);
        btScalar inverseMass = body.moves ? node->m_im : btScalar(0);
        constraint->node[constraint->nodeCount] = node;
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
        offset += constraint.weight[i] * constraint.node[i]->m_x;
    return offset;
}

/// What the constraint lacks, shared out by weight and mass so that it then holds; but no node moves further than is
/// lacking: where only one with a small weight can move, it would be thrown away.
void Push(const qcSoftConstraint& constraint, const btVector3& lack)
{
    btScalar largest = constraint.inverseEffectiveMass;
    for (int i = 0; i < constraint.nodeCount; i++)
        largest = std::max(largest, btFabs(constraint.weight[i]) * constraint.inverseMass[i]);
    for (int i = 0; i < constraint.nodeCount; i++)
        constraint.node[i]->m_x += lack * (constraint.weight[i] * constraint.inverseMass[i] / largest);
}

void Solve(const qcSoftConstraint& constraint)
{
    btVector3 offset = Offset(constraint);
    btScalar missing = constraint.distance - constraint.normal.dot(offset);
    if (missing <= 0)
        return;
    Push(constraint, constraint.normal * missing);
    // Coulomb: what the normal push was, times the coefficient, may take back of the sliding since the start.
    btVector3 motion = offset - constraint.startOffset;
    btVector3 sliding = motion - constraint.normal * constraint.normal.dot(motion);
    btScalar length = sliding.length();
    if (length <= SIMD_EPSILON)
        return;
    btScalar taken = std::min(length, constraint.friction * missing);
    Push(constraint, sliding * (-taken / length));
}

/// The corners at the start of the step.
void StartOf(const qcSceneSoftBody& body, uint32_t triangle, double corners[9])
{
    for (int i = 0; i < 9; i++)
        corners[i] = double(body.start[body.indices[3 * size_t(triangle) + size_t(i / 3)]][i % 3]);
}

int PutNodeBack(qcSceneSoftBody& body, uint32_t node)
{
    btVector3& x = body.body->m_nodes[int(node)].m_x;
    if (x == body.start[node])
        return 0;
    x = body.start[node];
    return 1;
}

int PutBack(qcSceneSoftBody& body, uint32_t triangle, bool wholeBody)
{
    int moved = 0;
    if (wholeBody)
        for (int i = 0; i < body.NodeCount(); i++)
            moved += PutNodeBack(body, uint32_t(i));
    else
        for (size_t c = 0; c < 3; c++)
            moved += PutNodeBack(body, body.indices[3 * size_t(triangle) + c]);
    return moved;
}
} // namespace

bool qcMayPush(const qcSceneSoftBody& a, const qcSceneSoftBody& b)
{
    if (a.body == b.body)
        return true; // the scene reports only what has self-collision on
    // Asked here and not gathered from processCollision: Bullet overlaps boxes of predicted positions, and its own
    // constraints may bring together what was apart there.
    const btSoftBodyWorldInfo* info = a.body->getWorldInfo();
    btBroadphaseProxy *proxyA = a.body->getBroadphaseHandle(), *proxyB = b.body->getBroadphaseHandle();
    if (info->m_dispatcher == nullptr || info->m_broadphase == nullptr || proxyA == nullptr || proxyB == nullptr)
        return false;
    return info->m_dispatcher->needsCollision(a.body, b.body) &&
           info->m_broadphase->getOverlappingPairCache()->needsBroadphaseCollision(proxyA, proxyB);
}

void qcMakeSoftConstraints(qcSoftBodyScene& scene, const qcResult& result, std::vector<qcSoftConstraint>* constraints,
                           std::vector<size_t>* contactOf)
{
    constraints->clear();
    contactOf->clear();
    for (size_t i = 0; i < result.contactCount; i++)
    {
        const qcContact& contact = result.contacts[i];
        qcSceneSoftBody *a = scene.Find(contact.bodyA), *b = scene.Find(contact.bodyB);
        btScalar thickness = (a->thickness + b->thickness) / 2;
        if (btScalar(contact.distance) > thickness || !qcMayPush(*a, *b))
            continue;
        qcSoftConstraint constraint{};
        constraint.startOffset.setZero();
        AddNodes(*a, contact.verticesA, contact.weightsA, 1, &constraint);
        AddNodes(*b, contact.verticesB, contact.weightsB, -1, &constraint);
        if (constraint.inverseEffectiveMass <= 0)
            continue;
        constraint.normal.setValue(btScalar(contact.normal[0]), btScalar(contact.normal[1]),
                                   btScalar(contact.normal[2]));
        btScalar startDistance = constraint.normal.dot(constraint.startOffset);
        if (startDistance < 0)
        {
            // They have passed each other since: back to the side from which they came.
            constraint.normal = -constraint.normal;
            startDistance = -startDistance;
        }
        constraint.distance =
            startDistance >= thickness ? thickness : startDistance + s_recovery * (thickness - startDistance);
        constraint.friction = (a->settings.friction + b->settings.friction) / 2;
        constraints->push_back(constraint);
        contactOf->push_back(i);
    }
}

void qcSolveSoftConstraints(const std::vector<qcSoftConstraint>& constraints, int iterations)
{
    for (int i = 0; i < iterations; i++)
        for (const qcSoftConstraint& constraint : constraints)
            Solve(constraint);
}

int qcFreezePenetrating(qcSoftBodyScene& scene, const qcResult& result, bool wholeBodies)
{
    int moved = 0;
    for (size_t i = 0; i < result.pairCount; i++)
    {
        const qcPair& pair = result.pairs[i];
        qcSceneSoftBody *a = scene.Find(pair.bodyA), *b = scene.Find(pair.bodyB);
        if (!qcMayPush(*a, *b))
            continue;
        double before[2][9];
        StartOf(*a, pair.triangleA, before[0]);
        StartOf(*b, pair.triangleB, before[1]);
        if (qcRelateTriangles(before[0], before[1]) == qc_relationPenetrating)
            continue;
        moved += PutBack(*a, pair.triangleA, wholeBodies);
        moved += PutBack(*b, pair.triangleB, wholeBodies);
    }
    return moved;
}

void qcUpdateVelocities(qcSoftBodyScene& scene, const std::vector<std::vector<btVector3>>& solved)
{
    for (size_t b = 0; b < scene.Bodies().size(); b++)
    {
        const qcSceneSoftBody& known = scene.Bodies()[b];
        const btScalar perDistance = known.body->m_sst.isdt * (1 - known.body->m_cfg.kDP);
        for (int i = 0; i < known.NodeCount(); i++)
        {
            btSoftBody::Node& node = known.body->m_nodes[i];
            if (node.m_x != solved[b][size_t(i)])
                node.m_v = (node.m_x - known.start[size_t(i)]) * perDistance;
        }
    }
}
