// Which contacts are springs of the elastic system, and what these have to restore.
#include "soft_body/response/elastic_contacts.h"

#include "soft_body/response/held_contacts.h"

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>

namespace
{
// Cosines: normals of one side of a body, and of opposite ones.
constexpr btScalar s_sameSide = btScalar(0.9), s_oppositeSide = btScalar(0.5);

bool IsElastic(const qcSceneSoftBody& soft)
{
    return soft.moves && soft.body->isActive() && soft.body->m_tetras.size() > 0;
}

/// The soft body of a key, if the scene still has it.
qcSceneSoftBody* FindSoft(qcSoftBodyScene& scene, const qcObjectKey& key)
{
    for (qcSceneSoftBody& soft : scene.Bodies())
        if (soft.body == key.object && soft.uniqueId == key.uniqueId)
            return &soft;
    return nullptr;
}
} // namespace

/// False: the contact is none of this class.
bool qcElasticContacts::MakeKept(qcSoftBodyScene& scene, const qcSoftTangles& tangles,
                                 const qcSoftConstraint& constraint, Kept* kept) const
{
    const qcSceneSoftBody* softs[2] = {nullptr, nullptr};
    kept->nodeCount = constraint.nodeCount;
    for (int i = 0; i < constraint.nodeCount; i++)
    {
        const qcSceneSoftBody* soft = scene.OwnerOf(constraint.position[i], &kept->nodes[i]);
        const int side = constraint.weight[i] < 0;
        if (soft == nullptr || !IsElastic(*soft))
            return false;
        softs[side] = soft;
        kept->soft[side] = {soft->body, soft->uniqueId};
        kept->sides[i] = side;
        kept->weights[i] = constraint.weight[i];
    }
    kept->thickness = constraint.thickness;
    kept->friction = constraint.friction;
    kept->normal = constraint.normal;
    if (constraint.rigid == nullptr)
        return softs[0] != softs[1] && !tangles.AreTangled(softs[0]->id.slot, softs[1]->id.slot);
    kept->rigid = qcHeldPointOf(constraint);
    // The joints of links carry their load, and are solved elsewhere.
    return (!constraint.rigid->CanMove() || (constraint.rigid->body != nullptr && !constraint.rigid->isFixed)) &&
           !tangles.AreTangled(*softs[0], *constraint.rigid);
}

void qcElasticContacts::Keep(qcSoftBodyScene& scene, const qcSoftTangles& tangles,
                             const std::vector<qcSoftConstraint>& constraints)
{
    m_kept.clear();
    for (const qcSoftConstraint& constraint : constraints)
    {
        Kept kept;
        if (MakeKept(scene, tangles, constraint, &kept))
            m_kept.push_back(kept);
    }
}

/// False: the object holds nothing any more.
bool qcElasticContacts::AddRigidSide(const Kept& kept, qcPresentObjects* present, const qcSceneSoftBody& soft,
                                     btVector3* start, btVector3* end, qcElasticSpring* spring)
{
    if (!present->Contains(soft, kept.rigid.object))
        return false;
    auto* object = const_cast<btCollisionObject*>(kept.rigid.object.object);
    const btVector3 point = kept.rigid.Point();
    *start -= kept.rigid.point;
    *end -= point;
    spring->normal = kept.rigid.Normal();
    spring->arm = point - object->getWorldTransform().getOrigin();
    btRigidBody* body = btRigidBody::upcast(object);
    if (body == nullptr || body->isStaticOrKinematicObject())
        return true;
    // Bullet has not moved what sleeps.
    if (!body->isActive())
        return false;
    spring->rigid = m_system.AddRigid(body);
    return true;
}

/// Adds the contact's spring, if it still holds.
void qcElasticContacts::AddSpring(qcSoftBodyScene& scene, const Kept& kept, qcPresentObjects* present)
{
    qcSceneSoftBody* softs[2] = {FindSoft(scene, kept.soft[0]), FindSoft(scene, kept.soft[1])};
    const bool isRigid = kept.rigid.object.object != nullptr;
    if (softs[0] == nullptr || !IsElastic(*softs[0]) ||
        (!isRigid &&
         (softs[1] == nullptr || !IsElastic(*softs[1]) || !qcHasResponse(scene, softs[0]->id.slot, softs[1]->id.slot))))
        return;
    qcElasticSpring spring;
    btVector3 start(0, 0, 0), end(0, 0, 0);
    spring.nodeCount = kept.nodeCount;
    spring.friction = kept.friction;
    spring.normal = kept.normal;
    for (int i = 0; i < kept.nodeCount; i++)
    {
        const qcSceneSoftBody& soft = *softs[kept.sides[i]];
        // What the application moves is no motion to be held.
        if (int(kept.nodes[i]) >= soft.NodeCount() || (!soft.applied.empty() && !soft.applied[kept.nodes[i]].isZero()))
            return;
        const btSoftBody::Node& node = soft.body->m_nodes[int(kept.nodes[i])];
        spring.nodes[i] = node.index;
        spring.weights[i] = kept.weights[i];
        start += kept.weights[i] * soft.start[kept.nodes[i]];
        end += kept.weights[i] * node.m_x;
    }
    if (isRigid && !AddRigidSide(kept, present, *softs[0], &start, &end, &spring))
        return;
    const btScalar gap = spring.normal.dot(start);
    if (!qcMayHold(gap, kept.thickness) || !std::isfinite(end.length2()))
        return;
    // Sticks, until friction is known. Gaps that are too small are restored later, without this system's stiffness:
    // that would give bodies the energy to fly apart.
    const btScalar along = std::min(gap, qcHeldShare * kept.thickness) - spring.normal.dot(end);
    const btVector3 motion = end - start;
    spring.missing = spring.normal * (along + spring.normal.dot(motion)) - motion;
    spring.isClosed = along > 0;
    m_springs.push_back(spring);
    m_sides.push_back({{softs[0], softs[1]}});
}

/// True if what is fixed presses a body from opposite sides.
bool qcElasticContacts::IsSqueezed(const qcSceneSoftBody& soft) const
{
    std::vector<btVector3> normals; // different ones
    for (size_t i = 0; i < m_springs.size(); i++)
    {
        const btVector3& normal = m_springs[i].normal;
        if (m_sides[i].soft[0] != &soft || !m_springs[i].isClosed ||
            std::any_of(normals.begin(), normals.end(),
                        [&normal](const btVector3& other) { return normal.dot(other) > s_sameSide; }))
            continue;
        if (std::any_of(normals.begin(), normals.end(),
                        [&normal](const btVector3& other) { return normal.dot(other) < -s_oppositeSide; }))
            return true;
        normals.push_back(normal);
    }
    return false;
}

/// Leaves only the springs of bodies that carry or press another body that can move, or are squeezed. Others rest on
/// what is fixed: the contacts that follow stop these as well.
void qcElasticContacts::LeaveUnloaded()
{
    m_loaded.clear();
    auto isLoaded = [this](const qcSceneSoftBody* soft)
    { return std::find(m_loaded.begin(), m_loaded.end(), soft) != m_loaded.end(); };
    std::vector<qcSceneSoftBody*> resting;
    for (size_t i = 0; i < m_springs.size(); i++)
        if (m_springs[i].isClosed && (m_springs[i].rigid >= 0 || m_sides[i].soft[1] != nullptr))
        {
            for (qcSceneSoftBody* soft : m_sides[i].soft)
                if (soft != nullptr && !isLoaded(soft))
                    m_loaded.push_back(soft);
        }
        else if (resting.empty() || resting.back() != m_sides[i].soft[0])
            resting.push_back(m_sides[i].soft[0]);
    for (qcSceneSoftBody* soft : resting)
        if (!isLoaded(soft) && IsSqueezed(*soft))
            m_loaded.push_back(soft);
    size_t count = 0;
    for (size_t i = 0; i < m_springs.size(); i++)
        if (isLoaded(m_sides[i].soft[0]))
            m_springs[count++] = m_springs[i];
    m_springs.resize(count);
}

void qcElasticContacts::Solve(qcSoftBodyScene& scene, const btDeformableBodySolver& solver, btScalar timeStep)
{
    const btDeformableBackwardEulerObjective& objective = *solver.m_objective;
    // Bullet 3.24's implicit solver without projection doesn't move what is at rest: loads have no counterpart there.
    if (m_kept.empty() || (objective.m_implicit && !solver.m_useProjection))
        return;
    m_springs.clear();
    m_sides.clear();
    m_system.Begin();
    qcPresentObjects present(scene);
    for (const Kept& kept : m_kept)
        AddSpring(scene, kept, &present);
    LeaveUnloaded();
    if (m_loaded.empty())
        return;
    BT_PROFILE("qcSoftBodyContact elastic contacts");
    if (m_system.Solve(objective, m_loaded, timeStep, &m_springs))
        m_system.Apply();
}
