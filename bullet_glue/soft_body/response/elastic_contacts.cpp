// Which contacts are springs of the elastic system, and what these have to restore.
#include "soft_body/response/elastic_contacts.h"

#include "soft_body/response/held_contacts.h"

#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace
{
// Loads of this share of a sheet's mass raise its energy by contacts alone.
constexpr btScalar s_loadShare = btScalar(0.5);

/// The soft body of a key, if the scene still has it.
qcSceneSoftBody* FindSoft(qcSoftBodyScene& scene, const qcObjectKey& key)
{
    for (qcSceneSoftBody& soft : scene.Bodies())
        if (soft.body == key.object && soft.uniqueId == key.uniqueId)
            return &soft;
    return nullptr;
}
} // namespace

void qcElasticContacts::FindCovered(qcSoftBodyScene& scene)
{
    m_isCovered.clear();
    for (const qcSceneSoftBody& soft : scene.Bodies())
        m_isCovered.push_back(m_elasticity->Covers(soft) || (IsUnderLoad(soft) && m_elasticity->CoversUnderLoad(soft)));
}

bool qcElasticContacts::IsUnderLoad(const qcSceneSoftBody& soft) const
{
    return std::any_of(m_underLoad.begin(), m_underLoad.end(),
                       [&soft](const qcObjectKey& key)
                       { return key.object == soft.body && key.uniqueId == soft.uniqueId; });
}

/// Finds the soft bodies that count only for what lies on them: rigid bodies whose contacts push them down in sum, and
/// which together weigh more than a share of what the soft body does. Those that touch it pass the load on.
void qcElasticContacts::FindUnderLoad(qcSoftBodyScene& scene, const std::vector<qcSoftConstraint>& constraints)
{
    struct Load
    {
        const qcSceneSoftBody* soft;
        const btRigidBody* body;
        btVector3 normals;
    };
    m_underLoad.clear();
    btScalar all = 0;
    for (const std::unique_ptr<qcSceneRigid>& rigid : scene.meshes.Rigids())
        all += rigid->body != nullptr && rigid->body->getInvMass() > 0 ? 1 / rigid->body->getInvMass() : btScalar(0);
    auto mayBe = [&](const qcSceneSoftBody& soft)
    { return all > s_loadShare * soft.body->getTotalMass() && m_elasticity->CoversUnderLoad(soft); };
    if (!(all > 0) || std::none_of(scene.Bodies().begin(), scene.Bodies().end(), mayBe))
        return;
    uint32_t node;
    std::vector<Load> loads;
    for (const qcSoftConstraint& constraint : constraints)
    {
        const btRigidBody* body = constraint.rigid != nullptr ? constraint.rigid->body : nullptr;
        const qcSceneSoftBody* soft = body != nullptr ? scene.OwnerOf(constraint.position[0], &node) : nullptr;
        if (soft == nullptr)
            continue;
        auto load = std::find_if(loads.begin(), loads.end(),
                                 [&](const Load& other) { return other.soft == soft && other.body == body; });
        if (load == loads.end())
            load = loads.insert(load, {soft, body, btVector3(0, 0, 0)});
        load->normals += constraint.normal;
    }
    for (const qcSceneSoftBody& soft : scene.Bodies())
    {
        btScalar mass = 0;
        for (const Load& load : loads)
            if (load.soft == &soft && load.normals.dot(load.body->getGravity()) > 0)
                mass += 1 / load.body->getInvMass();
        if (mass > 0 && mass > s_loadShare * soft.body->getTotalMass() && m_elasticity->CoversUnderLoad(soft))
            m_underLoad.emplace_back(soft.body, soft.uniqueId);
    }
    for (bool changed = !m_underLoad.empty(); changed;)
    {
        changed = false;
        for (const qcSoftConstraint& constraint : constraints)
        {
            const int last = constraint.nodeCount - 1;
            const qcSceneSoftBody* softs[2] = {scene.OwnerOf(constraint.position[0], &node),
                                               scene.OwnerOf(constraint.position[last], &node)};
            if (constraint.rigid != nullptr || softs[0] == softs[1] || softs[0] == nullptr || softs[1] == nullptr)
                continue;
            for (int side = 0; side < 2; side++)
                if (IsUnderLoad(*softs[side]) && !IsUnderLoad(*softs[1 - side]) &&
                    m_elasticity->CoversUnderLoad(*softs[1 - side]))
                {
                    m_underLoad.emplace_back(softs[1 - side]->body, softs[1 - side]->uniqueId);
                    changed = true;
                }
        }
    }
}

/// True if the rigid body already presses on the soft body: what is borne strains it no more.
bool qcElasticContacts::IsLoad(const Kept& kept) const
{
    return std::find(m_loads.begin(), m_loads.end(), std::make_pair(kept.soft[0], kept.rigid.object)) != m_loads.end();
}

/// False: the contact is none of this class.
bool qcElasticContacts::MakeKept(qcSoftBodyScene& scene, const qcSoftTangles& tangles,
                                 const qcSoftConstraint& constraint, Kept* kept) const
{
    const qcSceneSoftBody* softs[2] = {nullptr, nullptr};
    btScalar pushed = 0;
    kept->nodeCount = constraint.nodeCount;
    for (int i = 0; i < constraint.nodeCount; i++)
    {
        const qcSceneSoftBody* soft = scene.OwnerOf(constraint.position[i], &kept->nodes[i]);
        const int side = constraint.weight[i] < 0;
        if (soft == nullptr || !IsCovered(scene, *soft))
            return false;
        softs[side] = soft;
        kept->soft[side] = {soft->body, soft->uniqueId};
        kept->sides[i] = side;
        kept->weights[i] = constraint.weight[i];
        if (side == 0)
            pushed +=
                constraint.weight[i] * constraint.normal.dot(*constraint.position[i] - soft->solved[kept->nodes[i]]);
    }
    kept->thickness = constraint.thickness;
    kept->friction = constraint.friction;
    kept->normal = constraint.normal;
    if (constraint.rigid == nullptr)
        return softs[0] != softs[1] && !tangles.AreTangled(softs[0]->id.slot, softs[1]->id.slot);
    kept->rigid = qcHeldPointOf(constraint);
    const btRigidBody* body = constraint.rigid->body;
    kept->isStrain = body != nullptr ? m_elasticity->MayLie(*body, constraint.normal) &&
                                           (m_elasticity->IsStrain(*softs[0], pushed) || IsLoad(*kept))
                                     : !m_elasticity->IsStrainedByRigidsOnly();
    // Links whose nodes Bullet moves by positions are pushed elsewhere.
    const bool isTaken = body != nullptr || m_elasticity->KeepsEnergy();
    return (!constraint.rigid->CanMove() || (isTaken && !constraint.rigid->isFixed)) &&
           !tangles.AreTangled(*softs[0], *constraint.rigid);
}

void qcElasticContacts::ReadPredicted(qcSoftBodyScene& scene)
{
    for (Kept& kept : m_kept)
    {
        const qcSceneSoftBody* softs[2] = {FindSoft(scene, kept.soft[0]), FindSoft(scene, kept.soft[1])};
        kept.predicted.setZero();
        for (int i = 0; i < kept.nodeCount; i++)
        {
            const qcSceneSoftBody* soft = softs[kept.sides[i]];
            if (soft != nullptr && int(kept.nodes[i]) < soft->NodeCount())
                kept.predicted += kept.weights[i] * soft->body->m_nodes[int(kept.nodes[i])].m_x;
        }
    }
}

void qcElasticContacts::Keep(qcSoftBodyScene& scene, const qcSoftTangles& tangles,
                             const std::vector<qcSoftConstraint>& constraints)
{
    m_kept.clear();
    const bool byRigidsOnly = m_elasticity->IsStrainedByRigidsOnly();
    if (byRigidsOnly && std::none_of(constraints.begin(), constraints.end(),
                                     [](const qcSoftConstraint& constraint)
                                     { return constraint.rigid != nullptr && constraint.rigid->CanMove(); }))
        return;
    FindUnderLoad(scene, constraints);
    FindCovered(scene);
    std::set<const btCollisionObject*> inChains;
    for (const qcSoftConstraint& constraint : constraints)
    {
        Kept kept;
        if (MakeKept(scene, tangles, constraint, &kept))
            m_kept.push_back(kept);
        if (constraint.isInChain && constraint.rigid != nullptr)
            inChains.insert(constraint.rigid->object);
    }
    // What lies behind the nodes bears these, by force chains.
    for (Kept& kept : m_kept)
        kept.isStrain = kept.isStrain && inChains.count(kept.rigid.object.object) == 0;
    if (byRigidsOnly && std::none_of(m_kept.begin(), m_kept.end(), [](const Kept& kept) { return kept.isStrain; }))
        m_kept.clear();
}

/// False: the object holds nothing any more.
bool qcElasticContacts::AddRigidSide(const Kept& kept, qcPresentObjects* present, const qcSceneSoftBody& soft,
                                     btVector3* start, btVector3* end, qcElasticSpring* spring)
{
    if (!present->Contains(soft, kept.rigid.object))
        return false;
    const btCollisionObject& object = *kept.rigid.object.object;
    const btVector3 point = kept.rigid.Point();
    *start -= kept.rigid.point;
    *end -= point;
    spring->normal = kept.rigid.Normal();
    // Bullet has not moved what sleeps.
    const bool sleeps = !object.isActive();
    if (sleeps && !object.isStaticOrKinematicObject() && btRigidBody::upcast(&object) != nullptr)
        return false;
    btVector3 arm = point - object.getWorldTransform().getOrigin();
    // The polyhedron around a sphere would turn it without friction.
    if (object.getCollisionShape()->getShapeType() == SPHERE_SHAPE_PROXYTYPE && qcAsLink(&object) == nullptr)
        arm = spring->normal * spring->normal.dot(arm);
    spring->point = m_system.AddPoint(object, arm);
    return !(sleeps && spring->point.Moves());
}

/// Adds the contact's spring, if it still holds.
void qcElasticContacts::AddSpring(qcSoftBodyScene& scene, const Kept& kept, qcPresentObjects* present)
{
    qcSceneSoftBody* softs[2] = {FindSoft(scene, kept.soft[0]), FindSoft(scene, kept.soft[1])};
    const bool isRigid = kept.rigid.object.object != nullptr;
    if (softs[0] == nullptr || !IsCovered(scene, *softs[0]) ||
        (!isRigid && (softs[1] == nullptr || !IsCovered(scene, *softs[1]) ||
                      !qcHasResponse(scene, softs[0]->id.slot, softs[1]->id.slot))))
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
        if (int(kept.nodes[i]) >= soft.NodeCount() || soft.IsApplied(kept.nodes[i]))
            return;
        spring.nodes[i] = int(kept.nodes[i]);
        spring.weights[i] = kept.weights[i];
        start += kept.weights[i] * soft.start[kept.nodes[i]];
        end += kept.weights[i] * soft.body->m_nodes[int(kept.nodes[i])].m_x;
    }
    const btVector3 ofNodes = end;
    if (isRigid && !AddRigidSide(kept, present, *softs[0], &start, &end, &spring))
        return;
    const btScalar gap = spring.normal.dot(start);
    // What was stopped on the way presses from a distance: fast nodes stop there.
    if (!(gap > 0) || !std::isfinite(end.length2()))
        return;
    // Sticks, until friction is known. Gaps that are too small are restored later, without this system's stiffness:
    // that would give bodies the energy to fly apart.
    const btScalar along = std::min(gap, qcHeldShare * kept.thickness) - spring.normal.dot(end);
    const btVector3 motion = end - start;
    spring.missing = spring.normal * (along + spring.normal.dot(motion)) - motion;
    spring.isClosed = along > 0;
    if (!m_elasticity->KeepsEnergy())
        spring.held = std::min(kept.friction, btScalar(1));
    const btVector3 rigidMotion = isRigid ? kept.rigid.Point() - kept.rigid.point : btVector3(0, 0, 0);
    m_springs.push_back(spring);
    m_sides.push_back({&kept, {softs[0], softs[1]}, rigidMotion, ofNodes - kept.predicted});
}

/// The entry of a body that is loaded, or null.
qcNodeElasticity::LoadedBody* qcElasticContacts::FindLoaded(const qcSceneSoftBody* soft)
{
    for (qcNodeElasticity::LoadedBody& loaded : m_loaded)
        if (loaded.soft == soft)
            return &loaded;
    return nullptr;
}

void qcElasticContacts::AddLoaded(qcSceneSoftBody* soft, btScalar load)
{
    if (qcNodeElasticity::LoadedBody* loaded = FindLoaded(soft))
        loaded->load += load;
    else
        m_loaded.push_back({soft, load});
}

/// True if soft bodies of the spring need their elasticity to bear the other side. What lies on something fixed needs
/// it, too, unless only rigid bodies strain it. The contacts that follow stop single nodes, after Bullet's solver has
/// had them fall: its damping would draw the others down, and what trembles would not come to rest.
bool qcElasticContacts::IsStrained(size_t spring) const
{
    if (!m_springs[spring].isClosed)
        return false;
    return m_springs[spring].point.Moves() ? m_sides[spring].kept->isStrain : !m_elasticity->IsStrainedByRigidsOnly();
}

/// Finds the bodies that are strained, and what loads them.
void qcElasticContacts::FindLoads()
{
    m_loaded.clear();
    std::vector<std::pair<qcObjectKey, qcObjectKey>> loads;
    for (size_t i = 0; i < m_springs.size(); i++)
    {
        if (!IsStrained(i))
            continue;
        const Sides& sides = m_sides[i];
        AddLoaded(sides.soft[0], 0);
        if (sides.soft[1] != nullptr)
            AddLoaded(sides.soft[1], 0);
        if (!m_springs[i].point.Moves())
            continue;
        const auto load = std::make_pair(sides.kept->soft[0], sides.kept->rigid.object);
        if (std::find(loads.begin(), loads.end(), load) != loads.end())
            continue;
        loads.push_back(load);
        const btRigidBody* body = btRigidBody::upcast(load.second.object);
        AddLoaded(sides.soft[0], body != nullptr ? 1 / body->getInvMass() : btScalar(0));
    }
    m_loads.swap(loads);
}

/// Adds the bodies that pass the loads on.
void qcElasticContacts::SpreadLoads()
{
    for (bool changed = !m_loaded.empty(); changed;)
    {
        changed = false;
        for (size_t i = 0; i < m_springs.size(); i++)
            for (int side = 0; side < 2 && m_springs[i].isClosed && m_sides[i].soft[1] != nullptr; side++)
            {
                const qcNodeElasticity::LoadedBody* from = FindLoaded(m_sides[i].soft[side]);
                if (from == nullptr || FindLoaded(m_sides[i].soft[1 - side]) != nullptr)
                    continue;
                AddLoaded(m_sides[i].soft[1 - side], from->load);
                changed = true;
            }
    }
}

/// Leaves only the springs of loaded bodies.
void qcElasticContacts::LeaveUnloaded()
{
    size_t count = 0;
    for (size_t i = 0; i < m_springs.size(); i++)
        if (FindLoaded(m_sides[i].soft[0]) != nullptr &&
            (m_sides[i].soft[1] == nullptr || FindLoaded(m_sides[i].soft[1]) != nullptr))
        {
            m_springs[count] = m_springs[i];
            m_sides[count++] = m_sides[i];
        }
    m_springs.resize(count);
    m_sides.resize(count);
}

/// Replaces the indices of nodes in their bodies by the numbers of all.
void qcElasticContacts::NumberNodes()
{
    for (size_t i = 0; i < m_springs.size(); i++)
        for (int k = 0; k < m_springs[i].nodeCount; k++)
        {
            const auto body = size_t(FindLoaded(m_sides[i].soft[m_sides[i].kept->sides[k]]) - m_loaded.data());
            m_springs[i].nodes[k] += m_elasticity->FirstNodeOf(body);
        }
}

/// Limits what springs stop of rigid bodies' motion, and what these get back. Springs have the normals of the last
/// step: those in front of a body that slides would be a wall, so that only its motion along their sum counts.
void qcElasticContacts::LimitRebounds()
{
    std::vector<btVector3> sums(m_system.RigidCount(), btVector3(0, 0, 0)); // by rigid body
    for (const qcElasticSpring& spring : m_springs)
        if (spring.point.rigid >= 0 && spring.isClosed)
            sums[size_t(spring.point.rigid)] += spring.normal;
    for (size_t i = 0; i < m_springs.size(); i++)
    {
        qcElasticSpring& spring = m_springs[i];
        if (spring.point.rigid < 0)
            continue;
        btVector3 motion = m_sides[i].rigidMotion;
        const btVector3& sum = sums[size_t(spring.point.rigid)];
        if (sum.length2() > 0)
        {
            const btScalar along = spring.normal.dot(motion - sum * (sum.dot(motion) / sum.length2()));
            const btVector3 sliding = spring.normal * std::max(along, btScalar(0));
            spring.missing -= sliding;
            motion -= sliding;
        }
        m_rebounds.Limit(*m_sides[i].soft[0], m_sides[i].kept->rigid.object, motion, m_sides[i].sprung, &spring);
    }
}

void qcElasticContacts::Solve(qcSoftBodyScene& scene, qcPresentObjects* present, btScalar timeStep)
{
    m_rebounds.Begin(timeStep);
    if (m_kept.empty())
    {
        m_loads.clear();
        return;
    }
    FindCovered(scene);
    m_springs.clear();
    m_sides.clear();
    m_system.Begin();
    for (const Kept& kept : m_kept)
        AddSpring(scene, kept, present);
    FindLoads();
    SpreadLoads();
    LeaveUnloaded();
    if (m_loaded.empty() || !m_elasticity->Begin(m_loaded, timeStep))
        return;
    BT_PROFILE("qcSoftBodyContact elastic contacts");
    NumberNodes();
    if (!m_elasticity->KeepsEnergy())
        LimitRebounds();
    const bool isSolved = m_system.Solve(m_elasticity.get(), m_loaded, &m_springs);
    m_elasticity->End();
    if (!isSolved)
        return;
    m_rebounds.End(&m_system);
    m_system.Apply(timeStep);
}
