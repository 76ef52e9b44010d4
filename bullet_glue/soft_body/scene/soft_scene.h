// Soft bodies, and the meshes near them, as bodies of a qcScene: it reads node positions in Bullet's own precision.
#ifndef QC_GLUE_SOFT_BODY_SCENE_SOFT_SCENE_H
#define QC_GLUE_SOFT_BODY_SCENE_SOFT_SCENE_H

#include "soft_body/scene/rigid_meshes.h"
#include "soft_body/scene/scene_soft_body.h"

#include <cfloat>
#include <functional>
#include <map>
#include <vector>

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
    /// Callbacks of the application have run since BeginStep; Bullet has moved nothing yet.
    void ReadBegin(const btAlignedObjectArray<btSoftBody*>& bodies);
    /// Makes the scene's soft bodies those of the array that are finite, and reads their positions at the start of the
    /// step from this member of their nodes.
    qcStatus Sync(const btAlignedObjectArray<btSoftBody*>& bodies, btVector3 btSoftBody::Node::*start);
    /// Reads the positions after Bullet's own solvers, and makes the scene's meshes those near the motions from the
    /// start of the step to there.
    qcStatus ReadSolved(btScalar timeStep, const qcRigidLimits* limits);
    /// Sets the present positions of nodes and transforms of meshes in the scene.
    qcStatus SyncPositions();
    /// Sets the positions of the start of the step in the scene.
    qcStatus SyncStartPositions();
    /// Sets the positions of the start of the step, and marks them as the start of the motion. Call it after
    /// ReadSolved.
    qcStatus MarkStart();
    /// Reads the velocities of the nodes at the end of the step, for qcSceneSoftBody::FindRestored.
    void ReadVelocities();
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
    /// The soft body that has a position among its `positions`, and the index of its node. Null: none. Call it after
    /// ReadSolved. O(log bodies).
    qcSceneSoftBody* OwnerOf(const btVector3* position, uint32_t* node);
    std::vector<qcSceneSoftBody>& Bodies()
    {
        return m_bodies;
    }

    void SetSettings(const btSoftBody* body, const qcSoftBodySettings& settings);
    qcSoftBodySettings GetSettings(const btSoftBody* body) const;
    /// The largest distance at which two of the bodies push each other.
    btScalar ContactDistance() const;

    qcRigidMeshes meshes;
    unsigned threads = 0;
    qcMethod method = qc_methodAuto;
    bool reportsCandidates = false; ///< Detect reports candidate pairs
    /// Rigid objects whose pairs with soft bodies Bullet has dispatched in this step.
    std::vector<qcObjectKey> liveObjects;
    /// An object or soft body that the step leaves out, since it is not finite; null: there is none.
    const btCollisionObject* notFinite = nullptr;
    bool hasFailed = false; ///< a query of the previous step failed: Bullet holds rigid bodies off in the next one

  private:
    struct Setting
    {
        int uniqueId; ///< -1: given before the body was added
        qcSoftBodySettings settings;
    };

    /// Where the `positions` of a body begin.
    struct FirstPosition
    {
        const btVector3* position;
        size_t body; ///< its index
    };

    void WakeSwept(const btAlignedObjectArray<btSoftBody*>& bodies, const qcBroadphases& broadphases);
    qcStatus CreateScene();
    qcBodyDef DefOf(const btSoftBody* body) const;
    qcStatus Track(btSoftBody* body);
    static bool IsThere(const btAlignedObjectArray<btSoftBody*>& bodies, const qcSceneSoftBody& tracked, int* next);
    std::vector<const btSoftBody*> UntrackRemoved(const btAlignedObjectArray<btSoftBody*>& bodies,
                                                  btVector3 btSoftBody::Node::*start);
    void LeaveOut(const btSoftBody* body);
    qcTranslation FindShift(const qcBroadphases& broadphases, btVector3 btSoftBody::Node::*start) const;
    void FindRestored(const btAlignedObjectArray<btSoftBody*>& bodies);
    void ReadStart(qcSceneSoftBody& tracked, btVector3 btSoftBody::Node::*start, bool isShifted);
    qcSoftBodySettings TakeSettings(const qcSceneSoftBody& tracked);
    void ApplySettings(qcSceneSoftBody& tracked);
    void ApplyFilters(const qcSceneSoftBody& tracked);
    void ApplyThickness(qcSceneSoftBody& tracked);
    void CollectMeshes(qcSceneSoftBody& tracked, const btVector3 box[2]);
    void TieAnchored(qcSceneSoftBody& tracked);
    qcStatus FollowMotions(bool* added);
    void AddMotionBox(qcSceneSoftBody& tracked, btScalar reach);
    void FindPartners(bool mayLeaveOut);
    void IndexPositions();
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
    std::vector<FirstPosition> m_firstPositions; ///< sorted, by address
    std::map<const btSoftBody*, Setting> m_settings;
    std::vector<qcBodyId> m_leftOutWithin; ///< scratch of RunWithout
    qcMotionBoxes m_boxes;                 ///< scratch of FindPartners
    qcResult m_noPairs{};
    /// Milliseconds of the last query for contacts, for pairs within a margin, and over a motion; at most twice those
    /// of the one before.
    double m_contactMs = DBL_MAX, m_pairMs = DBL_MAX, m_motionMs = DBL_MAX;
};

#endif
