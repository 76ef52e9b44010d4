// Soft bodies, and the meshes near them, as bodies of a qcScene.
#include "soft_body/scene/soft_scene.h"

#include "common/first_error.h"
#include "common/object_key.h"
#include "common/object_motion.h"
#include "common/profiled_detect.h"
#include "common/shape_triangles.h"
#include "quickcullide/bullet_positions.h"

#include <LinearMath/btAabbUtil2.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
// A query that takes less stays on one thread. Waking another one costs 10 to 50 microseconds, twice in a step and
// where the core is busy with something else more (qc-bench soft --demos: five tori take a tenth longer at 1 ms,
// bunnies a little longer at 0.1).
constexpr double s_threadedMs = 0.3;
} // namespace

qcSoftBodyScene::qcSoftBodyScene(qcDevice* device) : m_device(device)
{
    m_noPairs.profile.method = qc_methodSweep;
    m_noPairs.profile.device = "none";
}

qcSoftBodyScene::~qcSoftBodyScene()
{
    qcScene_Destroy(m_scene);
}

void qcSoftBodyScene::ApplyThickness(qcSceneSoftBody& tracked)
{
    tracked.thickness = tracked.settings.thickness > 0 ? tracked.settings.thickness
                                                       : std::min(tracked.topology.defaultThickness,
                                                                  tracked.body->getCollisionShape()->getMargin());
    qcScene_SetMargin(m_scene, tracked.id, double(tracked.thickness) / 2);
}

/// The settings of a body in the world; those that were given before it was added are its own from now on.
qcSoftBodySettings qcSoftBodyScene::TakeSettings(const qcSceneSoftBody& tracked)
{
    auto found = m_settings.find(tracked.body);
    if (found == m_settings.end())
        return qcSoftBodySettings();
    Setting& setting = found->second;
    if (setting.uniqueId == -1)
        setting.uniqueId = tracked.uniqueId;
    return setting.uniqueId == tracked.uniqueId ? setting.settings : qcSoftBodySettings();
}

void qcSoftBodyScene::ApplySettings(qcSceneSoftBody& tracked)
{
    qcSoftBodySettings settings = TakeSettings(tracked);
    // Contacts move no node of a reduced model.
    settings.selfCollision = settings.selfCollision && !tracked.body->m_reducedModel;
    // The previous result has no pairs of sleeping bodies, nor of kinds that were off.
    tracked.startsWhereItEnded = tracked.startsWhereItEnded && tracked.moves == tracked.body->isActive() &&
                                 tracked.settings.selfCollision == settings.selfCollision &&
                                 tracked.settings.bulletNodeContacts == settings.bulletNodeContacts;
    tracked.settings = settings;
    ApplyThickness(tracked);
    tracked.moves = tracked.body->isActive();
    qcScene_SetActivity(m_scene, tracked.id, tracked.moves ? qc_activityMoving : qc_activitySleeping);
    ApplyFilters(tracked);
}

void qcSoftBodyScene::ApplyFilters(const qcSceneSoftBody& tracked)
{
    const uint32_t mask = qcSoftGroup | qcMeshGroup | (tracked.CollidesWithSurfaces() ? qcSurfaceGroup : 0u);
    qcScene_SetSelfCollision(m_scene, tracked.id, tracked.settings.selfCollision && !tracked.isApart);
    qcScene_SetFilter(m_scene, tracked.id, qcSoftGroup, tracked.isAlone ? 0 : mask);
}

qcStatus qcSoftBodyScene::ReadSolved(btScalar timeStep, const qcRigidLimits* limits)
{
    BT_PROFILE("qcSoftBodyContact gather");
    qcBroadphases broadphases;
    for (const qcSceneSoftBody& tracked : m_bodies)
        if (tracked.CollidesWithRigidBodies())
            qcAddBroadphase(tracked.body->getWorldInfo()->m_broadphase, &broadphases);
    meshes.ReadMotions(broadphases, timeStep, limits);
    if (meshes.NotFinite() != nullptr)
    {
        notFinite = meshes.NotFinite();
        qcExplainNotFinite(*notFinite);
    }
    for (qcSceneSoftBody& tracked : m_bodies)
    {
        if (!tracked.ReadSolved())
            LeaveOut(tracked.body);
        tracked.positions = tracked.solved;
        tracked.shifts.clear();
        tracked.inContact = false;
        if (tracked.hasSolvedBox)
            CollectMeshes(tracked, tracked.solvedBox);
    }
    IndexPositions();
    const qcStatus status = meshes.Sync(m_scene);
    for (qcSceneSoftBody& tracked : m_bodies)
        TieAnchored(tracked);
    return status;
}

/// Ties the nodes that deformable anchors fix to rigid bodies near by that contacts move. A node with several anchors
/// stays where Bullet places it.
void qcSoftBodyScene::TieAnchored(qcSceneSoftBody& tracked)
{
    if (!tracked.moves || tracked.body->m_deformableAnchors.size() == 0 || tracked.body->m_reducedModel)
        return;
    std::vector<int> counts(tracked.positions.size(), 0);
    for (const qcSoftAnchor& anchor : tracked.anchors)
        counts[anchor.node]++;
    for (qcSoftAnchor& anchor : tracked.anchors)
        for (const std::unique_ptr<qcSceneRigid>& rigid : meshes.Rigids())
            if (rigid->object == anchor.object && rigid->body != nullptr && counts[anchor.node] == 1 &&
                tracked.pinned[anchor.node] && tracked.body->m_nodes[int(anchor.node)].m_im > 0)
            {
                anchor.tiedTo = rigid.get();
                rigid->Tie(&tracked, anchor.node);
            }
}

/// Collects the objects near a box around the motion of a body.
void qcSoftBodyScene::CollectMeshes(qcSceneSoftBody& tracked, const btVector3 box[2])
{
    btBroadphaseInterface* broadphase = tracked.body->getWorldInfo()->m_broadphase;
    const btVector3 around(tracked.thickness, tracked.thickness, tracked.thickness);
    tracked.collectedBox[0] = box[0] - around;
    tracked.collectedBox[1] = box[1] + around;
    if (tracked.CollidesWithRigidBodies() && broadphase != nullptr)
        meshes.CollectOverlapping(broadphase, tracked.collectedBox[0], tracked.collectedBox[1],
                                  tracked.CollidesWithSurfaces());
}

/// Contacts may move bodies out of the boxes in which meshes were collected, and into further ones: adds these.
qcStatus qcSoftBodyScene::FollowMotions(bool* added)
{
    if (!meshes.MayMiss())
        return qc_statusOk;
    for (qcSceneSoftBody& tracked : m_bodies)
    {
        auto isIn = [&tracked](const btVector3& position)
        { return TestPointAgainstAabb2(tracked.collectedBox[0], tracked.collectedBox[1], position); };
        // The scene's query refuses positions that contacts have made infinite.
        btVector3 box[2];
        if (tracked.hasSolvedBox && !std::all_of(tracked.positions.begin(), tracked.positions.end(), isIn) &&
            qcFindMotionBox(tracked.start, tracked.positions, 0, box))
            CollectMeshes(tracked, box);
    }
    return meshes.Extend(m_scene, added);
}

bool qcSoftBodyScene::AreAllAlone() const
{
    auto isAlone = [](const qcSceneSoftBody& tracked) { return tracked.isAlone; };
    return !m_bodies.empty() && std::all_of(m_bodies.begin(), m_bodies.end(), isAlone);
}

/// Adds the box of a body's motion up to the present positions; one that contacts have made infinite has a partner.
void qcSoftBodyScene::AddMotionBox(qcSceneSoftBody& tracked, btScalar reach)
{
    btVector3 box[2];
    tracked.hasPartner = !tracked.FindMotionBox(reach, box);
    if (tracked.hasPartner)
        box[1] = -(box[0] = btVector3(-BT_LARGE_FLOAT, -BT_LARGE_FLOAT, -BT_LARGE_FLOAT));
    m_boxes.Add(box[0], box[1], false);
}

/// Finds which bodies may come near another soft body or a mesh over the step. Where none can be left out of queries,
/// the boxes are not worth their time: all count as having partners.
void qcSoftBodyScene::FindPartners(bool mayLeaveOut)
{
    auto mayBeAlone = [](const qcSceneSoftBody& tracked)
    { return tracked.topology.isChain || !tracked.settings.selfCollision; };
    if (!mayLeaveOut || std::none_of(m_bodies.begin(), m_bodies.end(), mayBeAlone))
    {
        for (qcSceneSoftBody& tracked : m_bodies)
            tracked.hasPartner = true;
        return;
    }
    const btScalar reach = ContactDistance() / 2;
    m_boxes.Clear();
    for (qcSceneSoftBody& tracked : m_bodies)
        AddMotionBox(tracked, reach);
    meshes.AddMotionBoxes(reach, &m_boxes);
    m_boxes.Find();
    for (size_t i = 0; i < m_bodies.size(); i++)
        m_bodies[i].hasPartner = m_bodies[i].hasPartner || m_boxes.Overlaps(i);
}

/// Finds the bodies that are alone: at the start of the step (`starts`), or those that still are. True: one that was
/// is no longer.
bool qcSoftBodyScene::FindLone(bool starts)
{
    // `cullide` and `quick` find no contacts: their queries fail.
    const bool mayLeaveOut = !reportsCandidates && method != qc_methodCullide && method != qc_methodQuick;
    bool isFound = false;
    FindPartners(mayLeaveOut);
    for (qcSceneSoftBody& tracked : m_bodies)
    {
        const bool wasAlone = tracked.isAlone, wasApart = tracked.isApart;
        tracked.isApart =
            mayLeaveOut && tracked.topology.isChain && tracked.settings.selfCollision && tracked.IsStretched(starts);
        tracked.isAlone = mayLeaveOut && !tracked.hasPartner && (starts || wasAlone) &&
                          (tracked.isApart || !tracked.settings.selfCollision);
        isFound = isFound || (wasAlone && !tracked.isAlone);
        if (tracked.isAlone != wasAlone || tracked.isApart != wasApart)
            ApplyFilters(tracked);
    }
    return isFound;
}

qcStatus qcSoftBodyScene::SetVertices(qcSceneSoftBody& tracked, const std::vector<btVector3>& positions)
{
    tracked.isInScene = !tracked.isAlone;
    if (tracked.positions.empty() || tracked.isAlone)
        return qc_statusOk;
    return qcScene_SetVertices(m_scene, tracked.id, positions.data(), qcBulletPositions, sizeof(btVector3));
}

qcStatus qcSoftBodyScene::SyncPositions()
{
    if (AreAllAlone())
        return qc_statusOk;
    bool isFurther = false;
    qcStatus status = FollowMotions(&isFurther);
    // Contacts may have moved something near a body that was alone.
    if (status == qc_statusOk && (FindLone(false) || isFurther))
        status = MarkStarts(false);
    for (size_t i = 0; i < m_bodies.size() && status == qc_statusOk; i++)
        status = SetVertices(m_bodies[i], m_bodies[i].positions);
    return status == qc_statusOk ? meshes.SyncTransforms(m_scene) : status;
}

qcStatus qcSoftBodyScene::SyncStartPositions()
{
    qcStatus status = qc_statusOk;
    for (qcSceneSoftBody& tracked : m_bodies)
    {
        tracked.isAlone = tracked.isApart = false;
        ApplyFilters(tracked);
        status = qcFirstError(status, SetVertices(tracked, tracked.start));
    }
    return status == qc_statusOk ? meshes.SyncTransforms(m_scene, true) : status;
}

/// `areThere`: bodies in the scene have their positions of the start there.
qcStatus qcSoftBodyScene::MarkStarts(bool areThere)
{
    qcStatus status = qc_statusOk;
    for (qcSceneSoftBody& tracked : m_bodies)
        if (!areThere || !tracked.isInScene || tracked.isAlone)
            status = qcFirstError(status, SetVertices(tracked, tracked.start));
    if (status == qc_statusOk)
        status = meshes.SyncTransforms(m_scene, true);
    return status == qc_statusOk ? qcScene_MarkStart(m_scene) : status;
}

qcStatus qcSoftBodyScene::MarkStart()
{
    FindLone(true);
    // Bodies of the previous step are where it left them.
    return MarkStarts(StartsWhereStepEnded());
}

void qcSoftBodyScene::EndStep(bool solved)
{
    for (qcSceneSoftBody& tracked : m_bodies)
    {
        tracked.hasEnd = true;
        if (solved)
            tracked.positions = tracked.solved;
        tracked.startsWhereItEnded = !solved;
    }
}

bool qcSoftBodyScene::IsContinuous() const
{
    return std::all_of(m_bodies.begin(), m_bodies.end(),
                       [](const qcSceneSoftBody& tracked) { return tracked.settings.continuous; });
}

bool qcSoftBodyScene::IsDiscrete() const
{
    return std::none_of(m_bodies.begin(), m_bodies.end(),
                        [](const qcSceneSoftBody& tracked) { return tracked.settings.continuous; });
}

bool qcSoftBodyScene::StartsWhereStepEnded() const
{
    auto startsThere = [](const qcSceneSoftBody& tracked) { return tracked.startsWhereItEnded; };
    return std::all_of(m_bodies.begin(), m_bodies.end(), startsThere) && meshes.StartWhereTheyEnded();
}

/// Runs a query. `ms`: about how long those of its kind take; it learns of this one, too.
qcStatus qcSoftBodyScene::Run(qcDetectDef* def, double* ms, const qcResult** result)
{
    def->threads = *ms < s_threadedMs ? 1 : threads;
    const qcStatus status = qcScene_Detect(m_scene, def, result);
    // A single query that the system interrupts does not decide about the next.
    if (status == qc_statusOk)
        *ms = std::min((*result)->profile.totalMs, 2 * *ms);
    return status;
}

qcStatus qcSoftBodyScene::Detect(btScalar contactMargin, const qcResult** result)
{
    if (AreAllAlone())
    {
        *result = &m_noPairs;
        return qc_statusOk;
    }
    qcDetectDef def = qcProfiledDetectDef();
    def.method = method;
    def.contactMargin = double(contactMargin);
    def.nearestContacts = true;
    def.candidates = reportsCandidates;
    return Run(&def, contactMargin > 0 ? &m_contactMs : &m_pairMs, result);
}

qcStatus qcSoftBodyScene::DetectWithin(btScalar margin, const qcResult** result)
{
    qcDetectDef def = qcProfiledDetectDef();
    def.method = method;
    def.margin = double(margin);
    def.touching = true;
    return Run(&def, &m_pairMs, result);
}

qcStatus qcSoftBodyScene::SetSelfCollision(const std::vector<qcBodyId>& bodies, bool selfCollision)
{
    qcStatus status = qc_statusOk;
    for (const qcBodyId& id : bodies)
        status = qcFirstError(status, qcScene_SetSelfCollision(m_scene, id, selfCollision));
    return status;
}

/// Runs a query without the bodies, and pairs of bodies, for which a function is true. Bodies without a partner have no
/// pairs with others.
qcStatus qcSoftBodyScene::RunWithout(const BodyPairTest& isLeftOut, qcDetectDef* def, double* ms,
                                     const qcResult** result)
{
    m_leftOutWithin.clear();
    bool hasPartners = false, isLeftOutWithin = true;
    for (const qcSceneSoftBody& tracked : m_bodies)
    {
        hasPartners = hasPartners || tracked.hasPartner;
        if (tracked.moves && tracked.settings.selfCollision && !tracked.isApart)
        {
            bool leftOut = isLeftOut(tracked.id.slot, tracked.id.slot);
            isLeftOutWithin = isLeftOutWithin && leftOut;
            if (leftOut)
                m_leftOutWithin.push_back(tracked.id);
        }
    }
    if (!hasPartners && isLeftOutWithin)
    {
        *result = &m_noPairs;
        return qc_statusOk;
    }
    def->pairFilterContext = const_cast<void*>(static_cast<const void*>(&isLeftOut));
    if (m_bodies.size() > 1)
        def->pairFilter = [](void* context, uint32_t slotA, uint32_t slotB)
        { return !(*static_cast<const BodyPairTest*>(context))(slotA, slotB); };
    qcStatus status = SetSelfCollision(m_leftOutWithin, false);
    if (status == qc_statusOk)
        status = Run(def, ms, result);
    return qcFirstError(status, SetSelfCollision(m_leftOutWithin, true));
}

qcStatus qcSoftBodyScene::DetectMotion(const BodyPairTest& isProven, const qcResult** result)
{
    if (IsDiscrete())
    {
        *result = &m_noPairs;
        return qc_statusOk;
    }
    qcDetectDef def = qcProfiledDetectDef();
    def.method = method;
    def.motion = true;
    def.proximities = true;
    return RunWithout(isProven, &def, &m_motionMs, result);
}

qcStatus qcSoftBodyScene::DetectPenetrating(const BodyPairTest& isApart, const qcResult** result)
{
    qcDetectDef def = qcProfiledDetectDef();
    def.method = method;
    return RunWithout(isApart, &def, &m_pairMs, result);
}

qcSceneSoftBody* qcSoftBodyScene::OwnerOf(const btVector3* position, uint32_t* node)
{
    auto isBefore = [](const btVector3* at, const FirstPosition& first)
    { return std::less<const btVector3*>()(at, first.position); };
    const auto next = std::upper_bound(m_firstPositions.begin(), m_firstPositions.end(), position, isBefore);
    if (next == m_firstPositions.begin())
        return nullptr;
    qcSceneSoftBody& soft = m_bodies[std::prev(next)->body];
    const ptrdiff_t index = position - soft.positions.data();
    if (index >= ptrdiff_t(soft.positions.size()))
        return nullptr;
    *node = uint32_t(index);
    return &soft;
}

void qcSoftBodyScene::IndexPositions()
{
    m_firstPositions.clear();
    for (size_t i = 0; i < m_bodies.size(); i++)
        if (!m_bodies[i].positions.empty())
            m_firstPositions.push_back({m_bodies[i].positions.data(), i});
    std::sort(m_firstPositions.begin(), m_firstPositions.end(),
              [](const FirstPosition& a, const FirstPosition& b)
              { return std::less<const btVector3*>()(a.position, b.position); });
}

qcSceneSoftBody* qcSoftBodyScene::Find(uint32_t slot)
{
    return slot < m_bodyOfSlot.size() && m_bodyOfSlot[slot] != SIZE_MAX ? &m_bodies[m_bodyOfSlot[slot]] : nullptr;
}

void qcSoftBodyScene::SetSettings(const btSoftBody* body, const qcSoftBodySettings& settings)
{
    m_settings[body] = {qcUniqueIdOf(body), settings};
}

qcSoftBodySettings qcSoftBodyScene::GetSettings(const btSoftBody* body) const
{
    auto found = m_settings.find(body);
    bool isIts = found != m_settings.end() && found->second.uniqueId == qcUniqueIdOf(body);
    return isIts ? found->second.settings : qcSoftBodySettings();
}

btScalar qcSoftBodyScene::ContactDistance() const
{
    btScalar soft = 0, distance = 0;
    for (const qcSceneSoftBody& tracked : m_bodies)
        soft = std::max(soft, tracked.thickness);
    for (const std::unique_ptr<qcSceneRigid>& tracked : meshes.Rigids())
        for (const qcSceneMesh& mesh : tracked->meshes)
            distance = std::max(distance, mesh.ContactDistance(soft));
    return std::max(soft, distance);
}
