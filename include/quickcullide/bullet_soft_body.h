// Self-collision of soft bodies, and contact among them and with qcMeshShape, for btSoftRigidDynamicsWorld, without a
// patch to Bullet. For the deformable world see bullet_deformable.h.
//
//     qcSoftBodySolver softSolver;
//     btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &softSolver);
//
// Bullet's classic soft bodies have no self-collision (VF_SS skips a body with itself, CL_SELF is dead since 2.89), and
// VF_SS between two bodies is vertex against face only. This solver runs Bullet's own constraints first, then moves the
// nodes apart: vertex-face and edge-edge contacts within the thickness, decided on the side from which they came. At
// the end of a step no two triangles without a common node penetrate that did not at its start, by the exact test; only
// kinematic meshes may leave no room for that. Momentum is kept meanwhile: nothing is stopped to hold it apart.
//
// What penetrates at the start of a step (tangled) is let go: contacts don't hold its triangles against each other, and
// the curve in which they meet is made shorter in each step, by a quarter of the thickness at most and without adding
// velocity. A tangle may move along the surfaces, but not grow. A cloth that pokes straight through another one or
// through a mesh may stay so: the curve then has nowhere to shrink to.
//
// Of positions between the start and the end of a step only nodes and rope links that go through meshes are noticed:
// what else moves by more than the thickness, relative to what it meets, may pass it.
#ifndef QUICKCULLIDE_BULLET_SOFT_BODY_H
#define QUICKCULLIDE_BULLET_SOFT_BODY_H

#include "scene.h"

#include <BulletSoftBody/btDefaultSoftBodySolver.h>
#include <BulletSoftBody/btSoftBody.h>

#include <memory>

class btIDebugDraw;

/// How one soft body meets itself, other soft bodies and meshes.
struct qcSoftBodySettings
{
    bool selfCollision = true;
    /// Surfaces are kept this far apart, in world units. 0: half the mean length of the edges of its faces when it came
    /// into the world, of a body without faces an eighth of the mean length of its rope links (0 without such), or the
    /// collision shape's margin where that is less. More than half the shortest edge makes cloth stiff. Between two
    /// bodies it is the mean; from a mesh, half of it and the mesh's margin.
    btScalar thickness = 0;
    /// Coulomb friction between two surfaces: the mean of both bodies'. Of a rigid body it is btRigidBody's own.
    btScalar friction = btScalar(0.3);
};

/// What the last step did.
struct qcSoftBodyStatistics
{
    /// Anything but qc_statusOk: a query failed (say, a node is not finite), and the step kept Bullet's own positions.
    qcStatus status = qc_statusOk;
    int contacts = 0;    ///< contacts within the thickness after Bullet's own constraints
    int penetrating = 0; ///< pairs of triangles that penetrated then
    int rounds = 0;      ///< times that contacts were solved
    /// Pairs of triangles that contacts did not keep apart, and that were pushed apart along the direction in which
    /// they were apart at the start of the step.
    int planes = 0;
    /// Nodes for which that was not enough: with what they touch they moved through the step as one rigid body. Many in
    /// each step: cloth is squeezed between meshes, or thinner than the step needs.
    int zoneNodes = 0;
    int frozenNodes = 0; ///< deprecated: the same as zoneNodes
    int remaining = 0;   ///< pairs that penetrate at the end of the step
    int exempt = 0;      ///< of these, pairs that are tangled since the start of the step, and free to come apart
    int unproven = 0;    ///< and pairs that were apart: only kinematic meshes that leave no room bring these about
    int meshes = 0;      ///< bodies with a qcMeshShape that a soft body may have met in the step
    int sweptNodes = 0;  ///< nodes and rope links that went through one of these, and were held back
    /// What answered the last query of the step: never qc_methodAuto, `layers` as soon as the device had a share.
    qcMethod method = qc_methodSweep;
    const char* device = "none"; ///< name of the device that had a share, "none" where the CPU answered alone
    /// Why another method than the one asked for ran in this step, or null. Valid until the next step.
    const char* fallback = nullptr;
    double gatherMs = 0; ///< milliseconds of reading bodies and positions from Bullet, bookkeeping included
    /// Milliseconds of all queries of the step, and what their stages took of it.
    double detectMs = 0, cullMs = 0, sweepMs = 0, exactMs = 0, contactMs = 0;
    double respondMs = 0; ///< moving nodes apart
};

/// What a world's soft bodies do when they touch: settings, and what came of them.
///
/// After a step the contacts found in it, as they were before the response, also stand in manifolds of the world's
/// dispatcher, four points each: body 0 is soft, body 1 another soft one, the same (self-collision), or one with a
/// qcMeshShape; of two soft ones body 0 was added first. They are released when the next step begins: until then they
/// may name a body that was removed in between.
///
/// Bullet's contact callbacks learn of them at the end of the step, those of starts and ends once for two bodies (or
/// one and itself), however many manifolds they have:
/// - gContactStartedCallback when they come into contact, with one of their manifolds.
/// - gContactProcessedCallback of each point, in each step; what it changes there has no effect on the response.
/// - gContactEndedCallback when they are no longer in contact, with a manifold of the two that has no points. Nobody is
///   told if one of them left the world meanwhile. Two that sleep stay in contact until one wakes.
/// - gContactDestroyedCallback of each point that was given user data, when its manifold is released.
/// Those of starts and ends may add and remove bodies, the others must not.
///
/// Bodies that Bullet does not simulate at present (isActive() is false) stay where they are; others are kept off them.
///
/// Meshes: a soft body meets each qcMeshShape, static, kinematic or moving, also in compounds, unless its collision
/// flags have none of fCollision::RVSmask. Both move, by mass; the links of a multibody don't. What has passed the mesh
/// within the step is brought back, as far as nodes of the soft body went through triangles, or rope links through
/// edges.
///
/// Ropes: a link with an end that no face has collides as a segment, with the body's thickness. Three kinds of links
/// don't: those of a body with tetrahedra; those that only resist bending (Link::m_bbending, set by
/// generateBendingConstraints); and those whose ends are connected by two shorter links (a diagonal of a net, a link
/// over two others of a rope). Ropes collide with meshes, faces of soft bodies, each other and themselves; links with a
/// common node are neighbours, which don't collide. Links may be added and removed between two steps. In the classic
/// world contacts of ropes are solved in turns with their links, so that a rope under tension lies still as long as
/// friction holds it. Friction is Coulomb's: a rope that is thrown along itself may slide off where Bullet's own, which
/// slows sliding by a share in each iteration, stops it.
///
/// Other nodes that no face has (of tetrahedra in a body without faces, or cut off) collide with meshes and faces of
/// soft bodies as points.
///
/// Profile zones (BT_PROFILE): "qcSoftBodyContact gather" of bodies and positions, then "qcSoftBodyContact resolve" and
/// in it "qcSoftBodyContact sweep" of nodes, "qcSoftBodyContact untangle" where something is tangled,
/// "qcSoftBodyContact round" for each round, "qcSoftBodyContact push apart" and "qcSoftBodyContact move zones" where
/// rounds did not suffice, and in these "qcSoftBodyContact detect", "qcSoftBodyContact manifolds" and
/// "qcSoftBodyContact respond"; last "qcSoftBodyContact callbacks".
///
/// Cost: one run of qcScene_Detect a step without contacts, two with, and a few more in steps in which they don't
/// suffice. Thread-safety: as the world's.
class QC_API qcSoftBodyContact
{
  public:
    /// Applies from the next step on, until the body is removed from the world. It may be called before it is added; a
    /// body that is never added should not be deleted while its settings wait.
    void setSettings(const btSoftBody* body, const qcSoftBodySettings& settings);
    qcSoftBodySettings getSettings(const btSoftBody* body) const;
    const qcSoftBodyStatistics& getStatistics() const;

    /// Threads of the queries; 0: one per core.
    void setThreadCount(unsigned threads);
    /// The method of the queries, from the next one on; qc_methodAuto if this is never called. The simulation does not
    /// depend on it, its cost does. `cullide` and `quick` know no contacts: with them each step keeps Bullet's own
    /// positions, status qc_statusBadInput.
    void setMethod(qcMethod method);

    /// Draws in red the potentially colliding set of the first query of the last step: the triangles that are in a
    /// candidate pair or have a vertex, an edge or themselves in a contact, where their bodies are now, and a cross for
    /// each such node that no face has. Bodies that have left the world since, and meshes that an object no longer has,
    /// are left out. For any debug mode: call it between steps, after debugDrawWorld. Changes nothing.
    /// O(triangles log contacts).
    void debugDraw(btIDebugDraw* drawer) const;

  protected:
    /// `device` draws for the methods that need GL; null is the same as a device of kind none. It must outlive this,
    /// and may serve others meanwhile.
    explicit qcSoftBodyContact(qcDevice* device);
    ~qcSoftBodyContact();
    qcSoftBodyContact(const qcSoftBodyContact&) = delete;
    qcSoftBodyContact& operator=(const qcSoftBodyContact&) = delete;

    struct Implementation;
    std::unique_ptr<Implementation> m_implementation;
};

/// A drop-in for btDefaultSoftBodySolver. Destroy it after the world and before the dispatcher.
class QC_API qcSoftBodySolver : public btDefaultSoftBodySolver, public qcSoftBodyContact
{
  public:
    explicit qcSoftBodySolver(qcDevice* device = nullptr);
    ~qcSoftBodySolver() override;

    void optimize(btAlignedObjectArray<btSoftBody*>& softBodies, bool forceUpdate = false) override;
    void solveConstraints(btScalar timeStep) override;
    void updateSoftBodies() override;
    /// Two soft bodies: nothing yet, solveConstraints sees to them if the filters of broadphase and dispatcher agree. A
    /// soft body and a rigid one: as Bullet does it.
    void processCollision(btSoftBody* body, btSoftBody* other) override;
    using btDefaultSoftBodySolver::processCollision;
};

#endif
