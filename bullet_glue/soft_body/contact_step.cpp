// The stages of contact in a step: continuous collision of nodes and links, untangling, contacts in rounds, then
// separating planes and rigid zones for pairs that are not proven apart over the step.
#include "soft_body/contact_step.h"

#include "common/object_key.h"
#include "common/stopwatch.h"
#include "soft_body/response/lying_starts.h"
#include "soft_body/response/node_ccd.h"
#include "soft_body/response/untangle.h"

#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <iterator>

namespace
{
// Sweeps over all contacts in a round. On the falling cloth of the main demo, 4 leave penetrating pairs for the next
// round in most steps with deep folds, 8 seldom.
constexpr int s_iterations = 8;
// Further sweeps that restore gaps.
constexpr int s_recoveryIterations = 4;
// One round would cost least, but leaves tangles and crumpled folds to planes alone.
constexpr int s_contactRounds = 4;
// Rounds of planes, and sweeps over all planes in each; more where these push guided objects. With 6 a gripper that
// presses cloth against a board jams in 11 of 24 runs like fingers_lift_a_cloth_that_they_press_against_a_board, with
// 16 in one, with 32 in none.
constexpr int s_planeRounds = 6, s_planeSweeps = 6, s_guidedSweeps = 32;
// By which guided meshes widen their gaps to nodes that stay, as a share of the thickness: gaps as small as the
// rounding of positions have no certificate.
constexpr btScalar s_widening = btScalar(0.05);
// Steps after untangling in which links bring back most of what they can: with few iterations they need several.
constexpr int s_strainedSteps = 8;
// Displacement of coordinates against exact contact, as a share of the contact distance.
constexpr btScalar s_perturbation = btScalar(1e-4);
} // namespace

void qcSoftBodyContact::Implementation::BeginStep(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    manifolds.Release();
    scene.liveObjects.clear();
    // A body whose world info has no dispatcher has Bullet's contact; it takes that of this library from no other.
    for (int i = 0; i < bodies.size(); i++)
        if (bodies[i]->getWorldInfo()->m_dispatcher != nullptr)
            algorithmOverride.Register(bodies[i]->getWorldInfo()->m_dispatcher);
}

void qcSoftBodyContact::Implementation::ReadStart(const btAlignedObjectArray<btSoftBody*>& bodies,
                                                  btVector3 btSoftBody::Node::*start)
{
    BT_PROFILE("qcSoftBodyContact gather");
    double begin = qcNowMs();
    m_candidates.Clear();
    m_clearance.Clear();
    m_planes.Clear();
    m_zones.Clear();
    statistics = qcSoftBodyStatistics();
    statistics.status = scene.Sync(bodies, start);
    statistics.gatherMs = qcNowMs() - begin;
}

/// Projects positions and meshes onto m_constraints.
void qcSoftBodyContact::Implementation::SolveConstraints()
{
    if (m_constraints.empty())
        return;
    BT_PROFILE("qcSoftBodyContact respond");
    double begin = qcNowMs();
    if (solvesLinks)
    {
        m_links.Collect(scene);
        anchorPulls.Move(m_constraints);
    }
    // Links pull against what is restored in each step: without its velocity nodes at rest would have that of the pull.
    qcAddRecovery(&m_constraints, qcGapRecoveryOf(m_timeStep), !solvesLinks);
    if (m_isShifted)
        qcSolveWithoutVelocity(scene, &m_constraints, &m_chains, m_links, &m_rigidNodeContacts, s_iterations);
    else
    {
        qcSolveSoftConstraints(&m_constraints, &m_chains, m_links, &m_rigidNodeContacts, s_iterations);
        m_links.LimitVelocities();
    }
    if (!solvesLinks)
        qcRestoreGaps(scene, &m_constraints, &m_chains, &m_rigidNodeContacts, qcGapRecovery, s_recoveryIterations);
    scene.meshes.Commit();
    m_isCertified = m_isDetected = false;
    statistics.respondMs += qcNowMs() - begin;
}

/// Starts soft bodies that were put exactly on a rigid surface just off it.
qcStatus qcSoftBodyContact::Implementation::LiftStarts()
{
    const btScalar distance = qcLyingDistance(scene);
    if (distance <= 0)
        return qc_statusOk;
    qcStatus status = scene.DetectWithin(distance, &m_result);
    return status == qc_statusOk && qcLiftStarts(scene, *m_result) ? scene.SyncStartPositions() : status;
}

/// Finds the tangles: pairs that penetrate at the start of the step. If the step starts where the previous one ended,
/// its last result has them already.
qcStatus qcSoftBodyContact::Implementation::FindTangles()
{
    bool areFound = m_tanglesAreOfEnd && scene.StartsWhereStepEnded();
    m_tanglesAreOfEnd = false;
    if (areFound)
        return qc_statusOk;
    double begin = qcNowMs();
    qcStatus status = scene.SyncStartPositions();
    if (status == qc_statusOk)
        status = LiftStarts();
    if (status == qc_statusOk)
        status = scene.Detect(0, &m_result);
    if (status == qc_statusOk)
    {
        m_tangles.Read(scene, *m_result);
        scene.LimitThickness([this](uint32_t slot) { return m_tangles.Contains(slot, slot); });
    }
    statistics.detectMs += qcNowMs() - begin;
    return status;
}

/// Brings back nodes and rope links that went through a mesh.
void qcSoftBodyContact::Implementation::SolveCcd()
{
    m_chains.Clear();
    qcMakeNodeCcdConstraints(scene, &m_constraints);
    qcAddLinkCcdConstraints(scene, &m_constraints);
    statistics.sweptNodes = int(m_constraints.size());
    SolveConstraints();
}

/// True if this pair of a tangle is worked apart. What is anchored to an object may pass through its surface.
bool qcSoftBodyContact::Implementation::IsUntangled(const qcPair& pair)
{
    const qcSceneSoftBody *a = scene.Find(pair.bodyA), *b = scene.Find(pair.bodyB);
    return (a == nullptr || a->settings.untangle) && (b == nullptr || b->settings.untangle) &&
           m_tangles.Contains(pair.bodyA, pair.bodyB) && qcHasResponse(scene, pair);
}

/// Moves tangled surfaces towards separation.
qcStatus qcSoftBodyContact::Implementation::Untangle()
{
    if (m_tangles.IsEmpty())
        return qc_statusOk;
    BT_PROFILE("qcSoftBodyContact untangle");
    double begin = qcNowMs();
    // The scene has the positions of the start.
    btScalar perturbation = s_perturbation * scene.ContactDistance();
    qcStatus status = scene.DetectWithin(4 * perturbation, &m_result);
    double detected = qcNowMs();
    statistics.detectMs += detected - begin;
    if (status != qc_statusOk)
        return status;
    std::vector<qcPair> pairs;
    std::copy_if(m_result->pairs, m_result->pairs + m_result->pairCount, std::back_inserter(pairs),
                 [this](const qcPair& pair) { return IsUntangled(pair); });
    m_curves.Find(scene, pairs, perturbation);
    std::vector<qcUntanglement> untanglements = qcFindUntanglements(m_curves);
    m_tangles.MarkParts(untanglements);
    qcNodeShifts shifts = qcUntangle(untanglements);
    scene.meshes.Commit();
    m_isCertified = m_isDetected = false;
    statistics.respondMs += qcNowMs() - detected;
    return shifts.empty() ? qc_statusOk : Shift(std::move(shifts));
}

/// Moves nodes of tangled bodies, without velocity. Contacts of the motion that gives velocities come before; where
/// nodes are moved against something, contacts only take that back.
qcStatus qcSoftBodyContact::Implementation::Shift(qcNodeShifts shifts)
{
    for (const auto& [soft, by] : shifts)
        soft->strainedSteps = s_strainedSteps;
    for (qcSceneSoftBody& soft : scene.Bodies())
        if (!soft.shifts.empty())
        {
            std::vector<btVector3>& by = shifts[&soft];
            by.resize(soft.positions.size(), btVector3(0, 0, 0));
            for (size_t i = 0; i < by.size(); i++)
            {
                by[i] += soft.shifts[i];
                soft.positions[i] -= soft.shifts[i];
            }
            soft.shifts.clear();
        }
    qcStatus status = FindContacts(true);
    if (status != qc_statusOk)
        return status;
    SolveConstraints();
    for (const auto& [soft, by] : shifts)
        soft->Shift(by);
    m_isShifted = true;
    m_isCertified = m_isDetected = false;
    return status;
}

/// Detects and makes constraints of the contacts. Those of the first round are published.
qcStatus qcSoftBodyContact::Implementation::FindContacts(bool isFirst)
{
    qcStatus status = Detect(scene.ContactDistance());
    if (status != qc_statusOk)
        return status;
    m_clearance.Clear();
    for (const qcSceneSoftBody& soft : scene.Bodies())
        if (!soft.isAlone)
            m_clearance.Record(soft.id.slot, soft.thickness, soft.start, soft.positions);
    m_clearance.RecordNear(*m_result);
    qcMakeSoftConstraints(scene, m_tangles, *m_result, &m_constraints, &m_contactOfConstraint);
    if (isFirst)
    {
        statistics.contacts = int(m_constraints.size());
        statistics.penetrating = statistics.remaining;
        m_candidates.Record(*m_result);
        manifolds.Publish(scene, *m_result, m_contactOfConstraint);
    }
    qcAddLinkCcdConstraints(scene, &m_constraints);
    m_chains.Find(&m_constraints);
    return qc_statusOk;
}

/// Pushes unproven pairs apart along the directions in which they were separated at the start of the step.
void qcSoftBodyContact::Implementation::PushApart()
{
    double begin = qcNowMs();
    for (const qcUnprovenPair& pair : m_unproven)
        m_planes.Add(scene, pair);
    m_planes.Solve(m_planes.HasGuided() ? s_guidedSweeps : s_planeSweeps);
    scene.meshes.Commit();
    m_isCertified = m_isDetected = false;
    statistics.respondMs += qcNowMs() - begin;
}

/// Projects positions onto contacts until the motion is proven, for a limited number of rounds.
qcStatus qcSoftBodyContact::Implementation::SolveContacts()
{
    for (int round = 0; round < s_contactRounds; round++)
    {
        BT_PROFILE("qcSoftBodyContact round");
        // Contacts of the first round hold for the whole step, except where surfaces pass each other. Finding them
        // again costs more than all else in a round.
        bool finds = round == 0 || !m_tangles.IsEmpty() || m_exemptMotions > 0;
        qcStatus status = finds ? FindContacts(round == 0 && !m_isShifted) : qc_statusOk;
        if (status != qc_statusOk || m_constraints.empty())
            return status;
        SolveConstraints();
        if (!finds)
            PushApart();
        statistics.rounds++;
        status = Certify();
        if (status != qc_statusOk || m_unproven.empty())
            return status;
    }
    return qc_statusOk;
}

/// Pushes unproven pairs apart, without contacts, which may hold them together.
qcStatus qcSoftBodyContact::Implementation::SolvePlanes()
{
    BT_PROFILE("qcSoftBodyContact push apart");
    m_movesZones = false;
    qcStatus status = m_isCertified ? qc_statusOk : Certify();
    for (int round = 0; status == qc_statusOk && round < s_planeRounds && !m_unproven.empty(); round++)
    {
        PushApart();
        statistics.rounds++;
        status = Certify();
    }
    statistics.planes += int(m_planes.Count());
    return status;
}

/// Moves nodes and meshes that planes could not separate in zones, as one rigid body each, from the start of the step.
/// Each round unites zones or restricts the motion of one, so the loop ends.
qcStatus qcSoftBodyContact::Implementation::MoveZones()
{
    if (m_unproven.empty())
        return qc_statusOk;
    BT_PROFILE("qcSoftBodyContact move zones");
    m_movesZones = true;
    for (bool changed = true; changed && !m_unproven.empty();)
    {
        changed = false;
        for (const qcUnprovenPair& unproven : m_unproven)
            changed = m_zones.Add(unproven.pair) || changed;
        m_zones.Move();
        m_isDetected = false;
        qcStatus status = Certify();
        if (status != qc_statusOk)
            return status;
    }
    statistics.zoneNodes = statistics.frozenNodes = std::max(statistics.zoneNodes, m_zones.NodeCount());
    return qc_statusOk;
}

/// Calls function(rigid) for the objects in the zone of each unproven pair.
template <typename Function>
void qcSoftBodyContact::Implementation::ForEachUnprovenObject(const Function& function) const
{
    for (const qcUnprovenPair& unproven : m_unproven)
        m_zones.ForEachObjectWith(unproven.pair, function);
}

/// Pushes guided meshes out of the nodes of their zones, which stay. False: no unproven pair has a mesh that gives way.
bool qcSoftBodyContact::Implementation::PushGuided()
{
    qcSeparatingPlanes planes;
    for (const qcUnprovenPair& unproven : m_unproven)
        planes.Add(scene, unproven, s_widening);
    planes.Solve(s_guidedSweeps, false);
    return scene.meshes.Commit();
}

/// Returns one guided mesh of the zones of unproven pairs to the start of the step, with its multibody. False: none
/// can.
bool qcSoftBodyContact::Implementation::ReturnGuided()
{
    std::vector<qcSceneRigid*> rigids;
    ForEachUnprovenObject([&rigids](qcSceneRigid& rigid) { rigids.push_back(&rigid); });
    return scene.meshes.ReturnToStart(rigids);
}

/// Moves guided meshes out of zones that they leave no room, as fingers of a robot do that press cloth against a wall.
/// The last resort is that such a mesh, with its multibody, returns to the start of the step.
qcStatus qcSoftBodyContact::Implementation::MoveGuided()
{
    if (m_unproven.empty())
        return qc_statusOk;
    BT_PROFILE("qcSoftBodyContact move guided");
    qcStatus status = qc_statusOk;
    for (int round = 0; status == qc_statusOk && !m_unproven.empty(); round++)
    {
        if (!(round < s_planeRounds && PushGuided()) && !ReturnGuided())
            return qc_statusOk;
        statistics.rounds++;
        m_zones.Renew();
        status = Certify();
        if (status == qc_statusOk)
            status = MoveZones();
    }
    return status;
}

/// Moves apart what contacts have not.
qcStatus qcSoftBodyContact::Implementation::MoveApart()
{
    qcStatus status = SolvePlanes();
    if (status == qc_statusOk)
        status = MoveZones();
    return status == qc_statusOk ? MoveGuided() : status;
}

/// The certificates of the world's rigid meshes, or null.
qcRigidLimits* qcSoftBodyContact::Implementation::FindLimits()
{
    return scene.Bodies().empty() ? nullptr : qcFindRigidLimits(scene.Bodies()[0].body->getWorldInfo()->m_dispatcher);
}

/// The bodies in zones with pairs that are not proven apart, but for those at their starts.
std::vector<const btCollisionObject*> qcSoftBodyContact::Implementation::UnprovenRigids()
{
    std::vector<const btCollisionObject*> objects;
    ForEachUnprovenObject(
        [&objects](const qcSceneRigid& rigid)
        {
            if (rigid.CanMove() && !qcAreSame(rigid.object->getWorldTransform(), rigid.start))
                objects.push_back(rigid.object);
        });
    return objects;
}

/// Certifies the meshes that contacts have moved against other meshes. What that stops is fixed for contacts of soft
/// bodies, which are moved apart from it; what then is unproven returns to the start of the step. Each round fixes
/// further objects.
qcStatus qcSoftBodyContact::Implementation::LimitRigids(btScalar timeStep)
{
    qcRigidLimits* limits = FindLimits();
    std::vector<const btCollisionObject*> held, moved;
    auto startOf = [this](const btCollisionObject* object)
    {
        const auto& rigids = scene.meshes.Rigids();
        auto found =
            std::find_if(rigids.begin(), rigids.end(),
                         [object](const std::unique_ptr<qcSceneRigid>& rigid) { return rigid->object == object; });
        return found != rigids.end() ? &(*found)->start : nullptr;
    };
    const size_t maxRounds = limits != nullptr ? 2 * scene.meshes.Rigids().size() + 1 : 0;
    for (size_t round = 0; round < maxRounds; round++)
    {
        scene.meshes.UpdateVelocities(timeStep);
        moved.clear();
        limits->LimitAgain(timeStep, held, startOf, &moved);
        scene.meshes.MoveTied(moved);
        if (!scene.meshes.Fix(moved))
            return qc_statusOk;
        m_zones.Renew();
        qcStatus status = Certify();
        if (status == qc_statusOk)
            status = MoveApart();
        if (status != qc_statusOk)
            return status;
        held = UnprovenRigids();
    }
    return qc_statusOk;
}

qcStatus qcSoftBodyContact::Implementation::RunStages(btScalar timeStep)
{
    double begin = qcNowMs();
    m_timeStep = timeStep;
    // The deformable world runs actions, which limit rigid meshes, after the soft bodies.
    qcRigidLimits* limits = FindLimits();
    if (!solvesLinks && limits != nullptr)
        limits->LimitFirst(timeStep);
    qcStatus status = scene.ReadSolved(timeStep, limits);
    statistics.meshes = scene.meshes.CountWith(false);
    statistics.surfaces = scene.meshes.CountWith(true);
    m_isShifted = false;
    if (status == qc_statusOk)
    {
        if (solvesLinks)
            tangledLinks.LimitVelocities(scene);
        qcCollectRigidNodeContacts(scene, &m_rigidNodeContacts);
    }
    statistics.gatherMs += qcNowMs() - begin;
    if (status == qc_statusOk)
        status = FindTangles();
    if (status == qc_statusOk)
        status = MarkStart();
    if (status == qc_statusOk)
    {
        SolveCcd();
        status = Untangle();
    }
    if (status == qc_statusOk)
        status = SolveContacts();
    if (status == qc_statusOk)
        status = MoveApart();
    if (status == qc_statusOk)
        status = LimitRigids(timeStep);
    return status == qc_statusOk ? ReadEnd() : status;
}

bool qcSoftBodyContact::Implementation::Resolve(btScalar timeStep)
{
    scene.hasFailed = statistics.status != qc_statusOk;
    if (scene.hasFailed)
        return false;
    BT_PROFILE("qcSoftBodyContact resolve");
    statistics.status = RunStages(timeStep);
    scene.hasFailed = statistics.status != qc_statusOk;
    statistics.notFinite = scene.notFinite;
    if (!scene.hasFailed && scene.notFinite != nullptr)
        statistics.status = qc_statusBadInput;
    scene.EndStep(scene.hasFailed);
    if (scene.hasFailed)
    {
        scene.meshes.Restore();
        return false;
    }
    if (solvesLinks)
        qcHeldContacts::Keep(scene, m_tangles, m_constraints);
    elasticContacts.Keep(scene, m_tangles, m_constraints);
    scene.meshes.UpdateVelocities(timeStep);
    qcApplyRigidNodeImpulses(m_rigidNodeContacts, timeStep);
    return true;
}

void qcSoftBodyContact::Implementation::DispatchCallbacks()
{
    BT_PROFILE("qcSoftBodyContact callbacks");
    manifolds.DispatchCallbacks();
}
