// Contact of the soft bodies of a world in one step, shared by qcSoftBodySolver and qcDeformableWorld. The stages and
// their terms: plugin/docs/soft_bodies.md.
#ifndef QC_GLUE_SOFT_BODY_CONTACT_STEP_H
#define QC_GLUE_SOFT_BODY_CONTACT_STEP_H

#include "common/live_objects.h"
#include "common/rigid_limits.h"
#include "soft_body/algorithm_override.h"
#include "soft_body/contact_manifolds.h"
#include "soft_body/draw_contacts.h"
#include "soft_body/response/anchor_pulls.h"
#include "soft_body/response/clearance.h"
#include "soft_body/response/elastic_contacts.h"
#include "soft_body/response/force_chains.h"
#include "soft_body/response/held_contacts.h"
#include "soft_body/response/position_constraints.h"
#include "soft_body/response/rigid_zones.h"
#include "soft_body/response/separating_planes.h"
#include "soft_body/response/tangled_links.h"
#include "soft_body/response/untangle.h"

#include <unordered_set>

/// A world's step calls, in this order, BeginStep before collision detection, the scene's BeginStep between the
/// pre-tick callback and Bullet's integration, ReadStart while nodes have the positions of the start of the step,
/// Resolve after Bullet's own solvers, and DispatchCallbacks at its end.
struct qcSoftBodyContact::Implementation
{
    explicit Implementation(qcDevice* device) : scene(device), algorithmOverride(scene), m_zones(scene)
    {
    }

    /// Releases the manifolds of the previous step: collision detection must not see them.
    void BeginStep(const btAlignedObjectArray<btSoftBody*>& bodies);
    /// `start`: the member of the nodes that holds the positions of the start of the step.
    void ReadStart(const btAlignedObjectArray<btSoftBody*>& bodies, btVector3 btSoftBody::Node::*start);
    /// Moves the scene's positions and the meshes apart; the caller then writes the positions to Bullet's nodes. False:
    /// a query failed, and everything is as Bullet's solvers left it.
    bool Resolve(btScalar timeStep);
    /// Draws the candidates of the step's first query, its planes and its zones. `modes`: bits of qcDebugDrawMode.
    void Draw(int modes, btIDebugDraw* drawer);
    /// Calls Bullet's contact callbacks. The last call of a step: they may remove bodies.
    void DispatchCallbacks();

    qcSoftBodyScene scene;
    qcHeldContacts heldContacts; ///< of the classic world
    qcAnchorPulls anchorPulls;   ///< of the classic world
    qcTangledLinks tangledLinks; ///< of the classic world
    qcElasticContacts elasticContacts;
    qcContactManifolds manifolds;
    qcAlgorithmOverride algorithmOverride;
    qcSoftBodyStatistics statistics;
    /// Soft bodies whose nodes Bullet has moved in this step ahead of its constraints, as the classic world does.
    std::unordered_set<const btSoftBody*> predicted;
    /// Links are constraints on positions, as in the classic world; in the deformable one they are forces.
    bool solvesLinks = false;

  private:
    void DrawPcs(qcLiveObjects& liveObjects, btIDebugDraw* drawer);
    void DrawCandidatePairs(qcLiveObjects& liveObjects, btIDebugDraw* drawer);
    void DrawPlanes(qcLiveObjects& liveObjects, btIDebugDraw* drawer);
    bool FindTriangle(uint32_t slot, uint32_t triangle, qcLiveObjects& liveObjects, btVector3 corners[3]);
    template <typename Function> qcStatus Query(const Function& detect);
    qcStatus Detect(btScalar contactMargin);
    qcStatus DetectEnd();
    void AddProfile();
    void SolveConstraints();
    qcStatus LiftStarts();
    qcStatus FindTangles();
    qcStatus MarkStart();
    bool IsContinuous(const qcPair& pair);
    void SortMotionPairs();
    qcStatus ExemptKeptTangles();
    qcStatus Certify();
    qcStatus ReadEnd();
    void SolveCcd();
    bool IsUntangled(const qcPair& pair);
    qcStatus Untangle();
    qcStatus Shift(qcNodeShifts shifts);
    qcStatus FindContacts(bool isFirst);
    void PushApart();
    qcStatus SolveContacts();
    qcStatus SolvePlanes();
    qcStatus MoveZones();
    template <typename Function> void ForEachUnprovenObject(const Function& function) const;
    bool PushGuided();
    bool ReturnGuided();
    qcStatus MoveGuided();
    qcStatus MoveApart();
    qcRigidLimits* FindLimits();
    std::vector<const btCollisionObject*> UnprovenRigids();
    qcStatus LimitRigids(btScalar timeStep);
    qcStatus RunStages(btScalar timeStep);

    btScalar m_timeStep = 0;
    std::vector<qcSoftConstraint> m_constraints;
    qcForceChains m_chains;                    ///< of the constraints
    std::vector<size_t> m_contactOfConstraint; ///< index in the result
    qcRopeLinks m_links;
    std::vector<qcRigidNodeContact> m_rigidNodeContacts;
    const qcResult* m_result = nullptr; ///< of the last detection
    qcSoftCandidates m_candidates;      ///< of the first detection of the step
    qcSoftClearance m_clearance;        ///< of the last query for contacts
    bool m_isShifted = false;   ///< untangling has moved nodes, and what contacts move from here on gives no velocity
    bool m_isDetected = false;  ///< m_result has the penetrating pairs of the present positions
    bool m_isCertified = false; ///< m_unproven are those of the present positions
    std::vector<qcUnprovenPair> m_unproven;
    std::vector<qcUnprovenPair> m_keptTangles; ///< not proven apart, but allowed if their tangle doesn't grow
    size_t m_exemptMotions = 0;                ///< pairs that penetrate at the start, or can't be separated there
    qcSoftTangles m_tangles;                   ///< of the start of the step; after the step, of its end
    qcIntersectionCurves m_curves;             ///< of the tangles that are worked apart
    bool m_tanglesAreOfEnd = false;            ///< m_tangles are those of the end of the previous step
    qcSeparatingPlanes m_planes;
    qcRigidZones m_zones;
    bool m_movesZones = false; ///< the step has come to its zones
};

#endif
