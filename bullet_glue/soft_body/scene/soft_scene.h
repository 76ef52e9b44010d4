// Soft bodies, and the meshes near them, as bodies of a qcScene: it reads node positions in Bullet's own precision.
#ifndef QC_GLUE_SOFT_BODY_SCENE_SOFT_SCENE_H
#define QC_GLUE_SOFT_BODY_SCENE_SOFT_SCENE_H

#include "common/object_key.h"
#include "soft_body/scene/rigid_meshes.h"
#include "soft_body/scene/topology.h"

#include "quickcullide/bullet_soft_body.h"

#include <cfloat>
#include <cstring>
#include <functional>
#include <map>
#include <utility>
#include <vector>

/// True if the body collides with the surfaces of Bullet's own shapes, and not by Bullet's tests of nodes or clusters.
bool qcCollidesWithSurfaces(const btSoftBody* body, const qcSoftBodySettings& settings);

/// A contact of a soft body with a rigid object that it can't move, at the end of a step.
struct qcHeldContact
{
    qcObjectKey object{nullptr, -1};
    int count = 0; ///< of nodes
    uint32_t nodes[3] = {0, 0, 0};
    btScalar weights[3] = {0, 0, 0}; ///< their sum is 1
    btVector3 point;                 ///< on the object
    btVector3 localPoint, localNormal;
    btScalar thickness = 0, friction = 0;
};

/// A soft body of the scene.
struct qcSceneSoftBody
{
    btSoftBody* body = nullptr;
    int uniqueId = 0; ///< see qcUniqueIdOf
    qcBodyId id{};
    qcSoftTopology topology; ///< of the body in the scene
    qcSoftBodySettings settings;
    btScalar thickness = 0;          ///< settings.thickness, or the default where that is 0
    bool isNew = true;               ///< not yet tested for tangles at its start
    bool moves = true;               ///< false: Bullet does not simulate it at present, and contacts don't move it
    bool startsWhereItEnded = false; ///< its state is that of the end of the previous step
    bool hasEnd = false;             ///< `positions` are those of the end of the previous step
    bool startsElsewhere = true;     ///< it is new, or was put elsewhere since
    /// Node positions at the start of the step: where the previous step left them, so that nodes that the application
    /// moves between two steps don't jump through anything. A body that it moves by more than half its size is put
    /// elsewhere, and starts there.
    std::vector<btVector3> start;
    /// How far the application has moved the nodes since the previous step; empty: none, or the body starts elsewhere.
    std::vector<btVector3> applied;
    std::vector<btVector3> solved;    ///< after Bullet's own solvers
    btVector3 solvedBox[2];           ///< around `start` and `solved`
    bool hasSolvedBox = false;        ///< there are nodes, and all are finite
    btVector3 collectedBox[2];        ///< the scene has the meshes in it
    bool isSolvedStretched = false;   ///< qcIsStretchedChain from `start` to `solved`
    std::vector<btVector3> positions; ///< after contacts so far; copied to Bullet's nodes at the end of the step
    /// The parts of the positions that untangling added in this step; they give no velocity. Empty: none.
    std::vector<btVector3> shifts;
    std::vector<bool> pinned; ///< nodes that contacts don't move; empty: none
    /// Nodes that are anchored to a rigid object: their triangles don't collide with that, since an anchor may lie
    /// inside.
    std::vector<std::pair<uint32_t, const btCollisionObject*>> anchors;
    std::vector<qcHeldContact> heldContacts; ///< of the previous step
    bool inContact = false;                  ///< it is in a constraint of this step
    bool hasPartner = true;                  ///< its motion may come near that of another soft body or a mesh
    bool isApart = false;                    ///< it can't touch itself in this step: queries don't test it with itself
    /// Nothing comes near it in this step, itself included: queries leave it out.
    bool isAlone = false;
    bool isInScene = false; ///< the scene has its positions

    int NodeCount() const
    {
        return body->m_nodes.size();
    }
    size_t IndexOf(const btSoftBody::Node* node) const
    {
        return size_t(node - &body->m_nodes[0]);
    }
    /// The motion of a node in the step, without the shift.
    btVector3 MotionOf(size_t node, const btVector3& from) const
    {
        return positions[node] - from - (shifts.empty() ? btVector3(0, 0, 0) : shifts[node]);
    }
    /// The motion that gives a node its velocity: without the shift, and without what contacts have taken back of the
    /// application's motion.
    btVector3 VelocityMotionOf(size_t node, const btVector3& from) const;
    /// Calls function(node index) for each node that contacts moved.
    template <typename Function> void ForEachMoved(Function function) const
    {
        for (size_t i = 0; i < positions.size(); i++)
            if (positions[i] != solved[i])
                function(int(i));
    }
    /// True if contacts have moved no node so far.
    bool IsSolved() const
    {
        return positions.empty() ||
               std::memcmp(positions.data(), solved.data(), positions.size() * sizeof(btVector3)) == 0;
    }
    /// The box of the motion to the present positions, enlarged by `reach`. False: a node is not finite, or there is
    /// none.
    bool FindMotionBox(btScalar reach, btVector3 box[2]) const;
    /// 0: contacts don't move the node.
    btScalar InverseMass(uint32_t node) const
    {
        bool isFixed = !moves || (!pinned.empty() && pinned[node]);
        return isFixed ? btScalar(0) : body->m_nodes[int(node)].m_im;
    }
    bool CollidesWithRigidBodies() const
    {
        return (body->m_cfg.collisions & btSoftBody::fCollision::RVSmask) != 0;
    }
    /// True if one of the three nodes is anchored to the object.
    bool IsAnchored(const uint32_t nodes[3], const btCollisionObject* object) const
    {
        for (const auto& anchor : anchors)
            if (anchor.second == object &&
                (anchor.first == nodes[0] || anchor.first == nodes[1] || anchor.first == nodes[2]))
                return true;
        return false;
    }
    bool CollidesWithSurfaces() const
    {
        return qcCollidesWithSurfaces(body, settings);
    }
};

class qcSoftBodyScene
{
  public:
    using BodyPairTest = std::function<bool(uint32_t, uint32_t)>; ///< of the slots of two bodies, or twice of one

    /// `device` may be null; it must outlive the scene.
    explicit qcSoftBodyScene(qcDevice* device);
    ~qcSoftBodyScene();
    qcSoftBodyScene(const qcSoftBodyScene&) = delete;
    qcSoftBodyScene& operator=(const qcSoftBodyScene&) = delete;

    /// The step starts: Bullet has moved nothing yet.
    void BeginStep(const btAlignedObjectArray<btSoftBody*>& bodies);
    /// Makes the scene's soft bodies those of the array, and reads their positions at the start of the step from this
    /// member of their nodes.
    qcStatus Sync(const btAlignedObjectArray<btSoftBody*>& bodies, btVector3 btSoftBody::Node::*start);
    /// Reads the positions after Bullet's own solvers, and makes the scene's meshes those near the motions from the
    /// start of the step to there.
    qcStatus ReadSolved(btScalar timeStep);
    /// Sets the present positions of nodes and transforms of meshes in the scene.
    qcStatus SyncPositions();
    /// Sets the positions of the start of the step in the scene.
    qcStatus SyncStartPositions();
    /// Sets the positions of the start of the step, and marks them as the start of the motion. Call it after
    /// ReadSolved.
    qcStatus MarkStart();
    /// Ends the step: the next one starts from the present positions (`solved`: from those after Bullet's own solvers),
    /// unless bodies are put elsewhere in between.
    void EndStep(bool solved);
    /// Limits the default thickness of new bodies to the heights of their faces, unless isTangled(slot) is true: a body
    /// that starts tangled in itself has no shape yet that could be at rest.
    void LimitThickness(const std::function<bool(uint32_t)>& isTangled);
    /// True if the motion of each soft body is certified.
    bool IsContinuous() const;
    /// True if the motion of none is.
    bool IsDiscrete() const;
    /// True if all bodies and meshes start where the previous step ended, and the settings that decide which triangles
    /// are tested are unchanged. Call it after ReadSolved.
    bool StartsWhereStepEnded() const;
    qcStatus Detect(btScalar contactMargin, const qcResult** result);
    /// Finds the pairs that penetrate, touch or are no further apart than the margin, in the positions last set.
    qcStatus DetectWithin(btScalar margin, const qcResult** result);
    /// Finds the pairs that are not proven apart from the start of the step to the present positions, with proximities
    /// of the start. Pairs of bodies (or of one with itself) for which isProven(slot, slot) is true are left out; it
    /// may be called on several threads.
    qcStatus DetectMotion(const BodyPairTest& isProven, const qcResult** result);
    /// Finds the pairs that penetrate in the present positions. Pairs of bodies for which isApart(slot, slot) is true
    /// are left out, as for DetectMotion.
    qcStatus DetectPenetrating(const BodyPairTest& isApart, const qcResult** result);

    /// The soft body of a slot, or null.
    qcSceneSoftBody* Find(uint32_t slot);
    std::vector<qcSceneSoftBody>& Bodies()
    {
        return m_bodies;
    }

    void SetSettings(const btSoftBody* body, const qcSoftBodySettings& settings);
    qcSoftBodySettings GetSettings(const btSoftBody* body) const;
    /// The largest distance at which two of the bodies push each other.
    btScalar ContactDistance() const;

    qcSoftBodyMeshes meshes;
    unsigned threads = 0;
    qcMethod method = qc_methodAuto;
    bool reportsCandidates = false; ///< Detect reports candidate pairs
    /// Rigid objects whose pairs with soft bodies Bullet has dispatched in this step.
    std::vector<qcObjectKey> liveObjects;
    bool hasFailed = false; ///< a query of the previous step failed: Bullet holds rigid bodies off in the next one

  private:
    struct Setting
    {
        int uniqueId; ///< -1: given before the body was added
        qcSoftBodySettings settings;
    };

    void WakeSwept(const btAlignedObjectArray<btSoftBody*>& bodies,
                   const std::set<btBroadphaseInterface*>& broadphases);
    qcStatus CreateScene();
    qcStatus Track(btSoftBody* body);
    void UntrackRemoved(const btAlignedObjectArray<btSoftBody*>& bodies);
    void ReadStart(qcSceneSoftBody& tracked, btVector3 btSoftBody::Node::*start);
    qcSoftBodySettings TakeSettings(const qcSceneSoftBody& tracked);
    void ApplySettings(qcSceneSoftBody& tracked);
    void ApplyFilters(const qcSceneSoftBody& tracked);
    void ApplyThickness(qcSceneSoftBody& tracked);
    void CollectMeshes(qcSceneSoftBody& tracked, const btVector3 box[2]);
    qcStatus FollowMotions(bool* added);
    void AddMotionBox(qcSceneSoftBody& tracked, btScalar reach);
    void FindPartners(bool mayLeaveOut);
    bool FindLone(bool starts);
    bool AreAllAlone() const;
    qcStatus MarkStarts(bool areThere);
    qcStatus SetVertices(qcSceneSoftBody& tracked, const std::vector<btVector3>& positions);
    qcStatus RunWithout(const BodyPairTest& isLeftOut, qcDetectDef* def, double* ms, const qcResult** result);
    qcStatus Run(qcDetectDef* def, double* ms, const qcResult** result);
    qcStatus SetSelfCollision(const std::vector<qcBodyId>& bodies, bool selfCollision);

    qcDevice* m_device;
    qcScene* m_scene = nullptr;
    std::vector<qcSceneSoftBody> m_bodies;
    std::vector<size_t> m_bodyOfSlot;
    std::map<const btSoftBody*, Setting> m_settings;
    std::vector<qcBodyId> m_leftOutWithin; ///< scratch of RunWithout
    qcMotionBoxes m_boxes;                 ///< scratch of FindPartners
    qcResult m_noPairs{};
    /// Milliseconds of the last query for contacts, for pairs within a margin, and over a motion; at most twice those
    /// of the one before.
    double m_contactMs = DBL_MAX, m_pairMs = DBL_MAX, m_motionMs = DBL_MAX;
};

#endif
