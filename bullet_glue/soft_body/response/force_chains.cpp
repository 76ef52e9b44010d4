// A node passes the force on it to a contact on its other side in which it is a side of its own. Where that is a
// contact with a soft body, the nodes of the other side pass it on in turn, each its weight.
//
// Where its two normals are not opposite, as in a wedge, a node yields; it is left to the sweeps over the contacts,
// since a force on heavy bodies would throw it.
//
// Bodies divide their masses among their active chains (Tonge, Benevolenski, Voroshilov: Mass Splitting for Jitter-Free
// Parallel Rigid Body Simulation, 2012): the force is spread evenly, as friction needs it.
#include "soft_body/response/force_chains.h"

#include <algorithm>
#include <functional>

namespace
{
// The push on a node and that of its support are opposite within this cosine.
constexpr btScalar s_minOpposition = btScalar(0.9);
// Longer chains are left to the sweeps over their contacts.
constexpr size_t s_maxChainMembers = 64;
constexpr int s_chainIterations = 4;
// Bodies that yield less than the nodes of their contacts by this factor have chains: with fewer, eight sweeps do.
constexpr btScalar s_heavy = 30;
// Chains that miss less than this share of their distance are satisfied.
constexpr btScalar s_chainTolerance = btScalar(1e-4);

/// True if sweeps over the contact converge slowly: its rigid body yields far less than the nodes.
bool IsHeavy(const qcSoftConstraint& constraint)
{
    return constraint.rigid != nullptr && constraint.rigid->CanMove() && !constraint.isTangled &&
           s_heavy * constraint.rigid->DisplacementAt(constraint.arm, constraint.normal).dot(constraint.normal) <
               constraint.inverseEffectiveMass;
}
} // namespace

//  ---- finding the chains ------------------------------------------------------------------------------------------

void qcForceChains::Clear()
{
    m_chains.clear();
    m_members.clear();
    m_supports.clear();
    m_bodies.clear();
    m_activeCounts.clear();
}

void qcForceChains::FindSupports(const std::vector<qcSoftConstraint>& constraints)
{
    for (size_t c = 0; c < constraints.size(); c++)
        for (int i = 0; i < constraints[c].nodeCount && !constraints[c].isTangled; i++)
            if (btFabs(constraints[c].weight[i]) == 1)
                m_supports.push_back({constraints[c].position[i], c, constraints[c].weight[i]});
    std::sort(m_supports.begin(), m_supports.end(),
              [](const Support& x, const Support& y) {
                  return x.node != y.node ? std::less<const btVector3*>()(x.node, y.node) : x.constraint < y.constraint;
              });
}

/// The contact that pushes the node most directly against the normal, one with a rigid object before others, or null.
const qcForceChains::Support* qcForceChains::SupportOf(const std::vector<qcSoftConstraint>& constraints,
                                                       const btVector3* node, const btVector3& normal) const
{
    const Support* found = nullptr;
    btScalar best = 0;
    auto support =
        std::lower_bound(m_supports.begin(), m_supports.end(), node,
                         [](const Support& s, const btVector3* n) { return std::less<const btVector3*>()(s.node, n); });
    for (; support != m_supports.end() && support->node == node; ++support)
    {
        const qcSoftConstraint& constraint = constraints[support->constraint];
        const btScalar opposition = -support->weight * constraint.normal.dot(normal);
        const btScalar value = opposition + btScalar(constraint.rigid != nullptr ? 1 : 0);
        if (opposition < s_minOpposition || value <= best)
            continue;
        best = value;
        found = &*support;
    }
    return found;
}

size_t qcForceChains::BodyOf(const void* body)
{
    const auto added = m_bodies.emplace(body, m_activeCounts.size());
    if (added.second)
        m_activeCounts.push_back(0);
    return added.first->second;
}

/// Adds the nodes of one side that can move, each with its share of the force on that side.
void qcForceChains::AddLoads(const qcSoftConstraint& constraint, btScalar share, btScalar side)
{
    for (int i = 0; i < constraint.nodeCount; i++)
        if (constraint.weight[i] * side > 0 && constraint.inverseMass[i] > 0)
            m_loads.emplace_back(constraint.position[i], share * btFabs(constraint.weight[i]));
}

/// Adds the member's forces on its nodes to those of the chain.
void qcForceChains::AddForces(const qcSoftConstraint& constraint, btScalar share)
{
    for (int i = 0; i < constraint.nodeCount; i++)
    {
        const btVector3 force = share * constraint.weight[i] * constraint.normal;
        auto found =
            std::find_if(m_forces.begin(), m_forces.end(),
                         [&constraint, i](const NodeForce& other) { return other.node == constraint.position[i]; });
        if (found == m_forces.end())
            m_forces.push_back({constraint.position[i], constraint.inverseMass[i], force});
        else
            found->force += force;
    }
}

void qcForceChains::AddMember(const qcSoftConstraint& constraint, const Member& member)
{
    auto found = std::find_if(m_members.begin() + std::ptrdiff_t(m_chains.back().firstMember), m_members.end(),
                              [&member](const Member& other) { return other.constraint == member.constraint; });
    if (found == m_members.end())
        m_members.push_back(member);
    else
        found->share += member.share;
    AddForces(constraint, member.share);
}

/// Follows the force of the last chain's first constraint through soft bodies. False: a node has no support.
bool qcForceChains::Follow(const std::vector<qcSoftConstraint>& constraints, size_t first)
{
    const qcSoftConstraint& head = constraints[first];
    Chain& chain = m_chains.back();
    m_forces.clear();
    AddMember(head, {first, 1, 1, BodyOf(head.rigid)});
    m_loads.clear();
    AddLoads(head, 1, 1);
    for (size_t i = 0; !m_loads.empty(); i++)
    {
        const auto [node, share] = m_loads.back();
        m_loads.pop_back();
        const Support* support = SupportOf(constraints, node, chain.normal);
        if (support == nullptr || i == s_maxChainMembers)
            return false;
        const qcSoftConstraint& constraint = constraints[support->constraint];
        if (constraint.rigid == head.rigid)
            return false;
        AddMember(constraint, {support->constraint, share, -support->weight, BodyOf(constraint.rigid)});
        AddLoads(constraint, share, -support->weight);
        chain.friction = std::min(chain.friction, constraint.friction);
    }
    return true;
}

void qcForceChains::AddChain(const std::vector<qcSoftConstraint>& constraints, size_t first)
{
    Chain chain;
    chain.firstMember = m_members.size();
    chain.normal = constraints[first].normal;
    chain.friction = constraints[first].friction;
    m_chains.push_back(chain);
    if (!Follow(constraints, first))
    {
        m_chains.pop_back();
        m_members.erase(m_members.begin() + std::ptrdiff_t(chain.firstMember), m_members.end());
        return;
    }
    m_chains.back().memberEnd = m_members.size();
    for (const NodeForce& force : m_forces)
        m_chains.back().nodeYield += force.inverseMass * force.force.length2();
}

void qcForceChains::Find(std::vector<qcSoftConstraint>* constraints)
{
    Clear();
    for (size_t c = 0; c < constraints->size(); c++)
    {
        if (!IsHeavy((*constraints)[c]))
            continue;
        if (m_supports.empty())
            FindSupports(*constraints);
        AddChain(*constraints, c);
    }
    for (const Member& member : m_members)
        (*constraints)[member.constraint].isInChain = true;
}

//  ---- solving -----------------------------------------------------------------------------------------------------

void qcForceChains::Begin()
{
    for (Chain& chain : m_chains)
    {
        chain.pushed = 0;
        chain.rubbed.setZero();
    }
}

void qcForceChains::Measure(const std::vector<qcSoftConstraint>& constraints, Chain* chain) const
{
    btScalar distance = 0;
    chain->missing = 0;
    for (size_t m = chain->firstMember; m < chain->memberEnd; m++)
    {
        const qcSoftConstraint& constraint = constraints[m_members[m].constraint];
        const btVector3 offset = qcOffsetOf(constraint);
        chain->missing += m_members[m].share * (constraint.distance - constraint.normal.dot(offset));
        distance += m_members[m].share * constraint.distance;
        if (m > chain->firstMember)
            continue;
        const btVector3 motion = offset - constraint.startOffset - constraint.conveyed;
        chain->sliding = motion - chain->normal * chain->normal.dot(motion);
    }
    const btScalar tolerance = s_chainTolerance * distance;
    const bool isHeld = chain->sliding.length() <= tolerance ||
                        (chain->rubbed.dot(chain->sliding) > 0 &&
                         chain->rubbed.length() >= (1 - s_chainTolerance) * chain->friction * chain->pushed);
    chain->isActive = chain->missing > tolerance || (chain->pushed > 0 && (chain->missing < -tolerance || !isHeld));
}

/// Measures the chains, and counts the active ones of each body. False: none is active.
bool qcForceChains::MeasureAll(const std::vector<qcSoftConstraint>& constraints)
{
    bool any = false;
    std::fill(m_activeCounts.begin(), m_activeCounts.end(), 0);
    for (Chain& chain : m_chains)
    {
        Measure(constraints, &chain);
        for (size_t m = chain.firstMember; chain.isActive && m < chain.memberEnd; m++)
            m_activeCounts[m_members[m].body]++;
        any = any || chain.isActive;
    }
    return any;
}

/// How far a unit force along a direction moves the rigid bodies apart, times the time step.
btScalar qcForceChains::YieldAlong(const std::vector<qcSoftConstraint>& constraints, const Chain& chain,
                                   const btVector3& direction) const
{
    const btScalar length2 = direction.length2();
    btScalar yield = 0;
    for (size_t m = chain.firstMember; m < chain.memberEnd && length2 > 0; m++)
    {
        const qcSoftConstraint& constraint = constraints[m_members[m].constraint];
        const btVector3 push = direction * m_members[m].share;
        if (constraint.rigid != nullptr)
            yield += btScalar(m_activeCounts[m_members[m].body]) *
                     constraint.rigid->DisplacementAt(constraint.arm, push).dot(push) / length2;
    }
    return yield;
}

/// Finds the next push, and the friction of the first body with its nodes, which they pass on; gives the members the
/// load for the friction of their nodes.
void qcForceChains::Respond(std::vector<qcSoftConstraint>* constraints, Chain* chain) const
{
    const btScalar ofBodies = YieldAlong(*constraints, *chain, chain->normal);
    const btScalar yieldAside = YieldAlong(*constraints, *chain, chain->sliding);
    chain->push = 0;
    chain->rub.setZero();
    // Guided bodies may yield elsewhere only.
    if (ofBodies <= 0)
        return;
    const btScalar yield = ofBodies + chain->nodeYield;
    const btScalar pushed = std::max(btScalar(0), chain->pushed + chain->missing / yield);
    btVector3 rubbed = chain->rubbed;
    if (yieldAside > 0)
        rubbed += chain->sliding / yieldAside;
    const btScalar length = rubbed.length(), largest = chain->friction * pushed;
    if (length > largest)
        rubbed *= largest / length;
    // The friction of the first contact's nodes acts on the first body, too.
    const btScalar more = rubbed.length() - chain->rubbed.length();
    chain->push = pushed - chain->pushed;
    chain->rub = rubbed - chain->rubbed;
    chain->pushed = pushed;
    chain->rubbed = rubbed;
    for (size_t m = chain->firstMember; m < chain->memberEnd; m++)
    {
        qcSoftConstraint& constraint = (*constraints)[m_members[m].constraint];
        const btScalar left =
            m_members[m].share * constraint.friction * chain->push - (m == chain->firstMember ? more : btScalar(0));
        constraint.chainFriction = std::max(btScalar(0), constraint.chainFriction + left);
    }
}

/// All forces are along one line, so that momentum is kept.
void qcForceChains::Push(const std::vector<qcSoftConstraint>& constraints, const Chain& chain) const
{
    const btVector3 push = chain.push * chain.normal - chain.rub;
    for (size_t m = chain.firstMember; m < chain.memberEnd; m++)
    {
        const qcSoftConstraint& constraint = constraints[m_members[m].constraint];
        if (constraint.rigid != nullptr)
            constraint.rigid->Push(constraint.arm, -m_members[m].sign * m_members[m].share * push);
    }
}

bool qcForceChains::Solve(std::vector<qcSoftConstraint>* constraints)
{
    bool moved = false;
    for (int i = 0; i < s_chainIterations && MeasureAll(*constraints); i++)
    {
        for (Chain& chain : m_chains)
            if (chain.isActive)
                Respond(constraints, &chain);
        for (const Chain& chain : m_chains)
            if (chain.isActive)
                Push(*constraints, chain);
        moved = true;
    }
    return moved;
}
