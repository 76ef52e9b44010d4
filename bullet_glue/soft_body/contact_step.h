// Contact of the soft bodies of a world in one step: what qcSoftBodySolver and qcDeformableWorld have in common.
#ifndef QC_GLUE_SOFT_BODY_CONTACT_STEP_H
#define QC_GLUE_SOFT_BODY_CONTACT_STEP_H

#include "soft_body/contact_manifolds.h"
#include "soft_body/draw_contacts.h"
#include "soft_body/response/position_constraints.h"
#include "soft_body/response/separating_planes.h"
#include "soft_body/algorithm_override.h"
#include "soft_body/response/rigid_zones.h"

/// The step of the world calls Begin first, then Start where node positions still are those of the start of the step,
/// then Resolve where Bullet has moved everything, and Tell when all is done.
struct qcSoftBodyContact::Implementation
{
    explicit Implementation(qcDevice* device) : scene(device), m_zones(scene)
    {
    }

    /// Nothing of the last step may be seen by collision detection.
    void Begin(const btAlignedObjectArray<btSoftBody*>& bodies);
    /// `start`: the member of their nodes that holds these positions.
    void Start(const btAlignedObjectArray<btSoftBody*>& bodies, btVector3 btSoftBody::Node::*start);
    /// Moves places and meshes apart; the caller moves nodes to their places. False: a query failed, and everything is
    /// where Bullet left it.
    bool Resolve(btScalar timeStep);
    /// Draws the candidate triangles of the step's first query.
    void Draw(btIDebugDraw* drawer);
    /// Bullet's contact callbacks learn of the step. Last of all: they may remove bodies.
    void Tell();

    qcSoftBodyScene scene;
    qcManifolds manifolds;
    qcSoftMeshTakeOver takeOver;
    qcSoftBodyStatistics statistics;
    /// Links are constraints on positions, as in the classic world; not forces, as in the deformable one.
    bool solvesLinks = false;

  private:
    void NoteProfile();
    qcStatus Detect(btScalar contactMargin, bool segments = false);
    void Solve();
    qcStatus SolveContacts();
    bool AreLinksThrough();
    qcStatus FindTangles();
    qcStatus Untangle();
    qcStatus PushApart();
    qcStatus MoveZones();
    qcStatus TryResolve(btScalar timeStep);

    std::vector<qcSoftConstraint> m_constraints;
    std::vector<size_t> m_contactOf;
    std::vector<qcSoftLink> m_links;
    std::vector<qcSoftSupport> m_supports;
    const qcResult* m_result = nullptr; ///< of the last detection
    qcSoftCandidates m_candidates;      ///< of the first detection of the step
    //  Numbers of its penetrating pairs: those that have to be apart, and those that are tangled.
    std::vector<size_t> m_held, m_exempt;
    qcSoftTangles m_tangles; ///< of the start of the step; after it, of its end
    bool m_tanglesAreOfEnd = false;
    qcSeparationPlanes m_planes;
    qcSoftZones m_zones;
};

#endif
