/// @file
/// Self-collision of soft bodies, and contact among them and with rigid bodies, for btSoftRigidDynamicsWorld; Bullet is
/// not patched. For the deformable world see bullet_deformable.h.
///
///     qcSoftBodySolver softSolver;
///     btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &softSolver);
#ifndef QUICKCULLIDE_BULLET_SOFT_BODY_H
#define QUICKCULLIDE_BULLET_SOFT_BODY_H

#include "scene.h"

#include <BulletSoftBody/btDefaultSoftBodySolver.h>
#include <BulletSoftBody/btSoftBody.h>

#include <memory>

class btIDebugDraw;

/// How one soft body collides with itself, other soft bodies and rigid bodies.
struct qcSoftBodySettings
{
    bool selfCollision = true; ///< contacts of the body with itself; bodies of the reduced model have none
    /// Distance at which surfaces are kept apart, in world units. 0: half the mean edge of the body's faces when it was
    /// added to the world, at most the collision shape's margin and, unless the body started tangled in itself, nine
    /// tenths of the height that all faces but a hundredth exceed (without faces: an eighth of the mean rope link, or
    /// 0). More than half the shortest edge makes cloth stiff, and more than all edges may throw it. Two bodies use the
    /// mean of both; a body and a rigid one use half the body's thickness plus the margin of the mesh or surface (see
    /// qcSoftBodyContact; of a surface's margin at most the thickness).
    btScalar thickness = 0;
    /// No triangle of the body that is apart from another one (its own, another soft body's, a rigid one's) passes it
    /// in a step, whatever the speed. false: only contacts at the end of a step hold it, and only against bodies whose
    /// setting is false, too.
    bool continuous = true;
    /// Triangles that penetrate at the start of a step are worked apart over the next steps: a body may start tangled.
    /// false: the body's tangles stay as they are; they may move along the surfaces but don't grow. Two bodies are
    /// worked apart if both settings are true.
    bool untangle = true;
    /// Coulomb friction. Two bodies use the mean of both; a rigid body has btRigidBody's own. -1: 0.3, unless the
    /// application has set Bullet's m_cfg.kDF to another value than Bullet's default, 0.2. Then it is kDF, and against
    /// a rigid body kDF times that body's friction, as in Bullet.
    btScalar friction = -1;
    /// Contact with the shapes of rigid bodies is left to Bullet, but for qcMeshShape: nodes are tested by themselves,
    /// at the end of a step. Edges and faces then have no contact with these shapes, and fast cloth passes them.
    bool bulletNodeContacts = false;
};

/// The work of the last fixed time step; stepSimulation may make several, or none. plugin/docs/troubleshooting.md
/// explains what to do about unusual values.
struct qcSoftBodyStatistics
{
    /// Anything but qc_statusOk: something is not finite (see notFinite), or a query failed, for example because
    /// memory ran out, and the step kept Bullet's own positions.
    qcStatus status = qc_statusOk;
    int contacts = 0;    ///< contacts within the thickness after Bullet's own constraints
    int penetrating = 0; ///< pairs of triangles that penetrated then
    int rounds = 0;      ///< rounds in which contacts or planes were solved
    /// Pairs of triangles that contacts could not keep apart, and that were pushed apart along the direction that
    /// separated them at the start of the step.
    int planes = 0;
    /// Nodes for which that did not suffice either: together with everything they touch they moved through the step as
    /// one rigid body. Many in each step: cloth is squeezed between meshes, or too thin for the step.
    int zoneNodes = 0;
    int frozenNodes = 0; ///< deprecated: equal to zoneNodes
    int remaining = 0;   ///< pairs that penetrate at the end of the step: some of the exempt and unproven ones
    int exempt = 0;      ///< pairs tangled since the start of the step, which are untangled over several steps
    /// Pairs that are not proven apart over the step, though they were apart at its start: kinematic meshes or links or
    /// pinned nodes left no room, or the application moved triangles next to each other by different amounts
    /// (plugin/docs/never_through.md).
    int unproven = 0;
    int meshes = 0;     ///< bodies with a qcMeshShape near a soft body
    int surfaces = 0;   ///< bodies near a soft body with other shapes that collide as triangles
    int sweptNodes = 0; ///< nodes and rope links that passed through a mesh or surface and were held back
    /// The method of the step's last query for contacts; never qc_methodAuto: `layers` if the device answered for a
    /// part.
    qcMethod method = qc_methodSweep;
    const char* device = "none";    ///< name of the device that was used; "none" if the CPU answered alone
    const char* fallback = nullptr; ///< why another method than the requested one ran, or null; valid for one step
    double gatherMs = 0;            ///< milliseconds of reading from Bullet, bookkeeping included
    double detectMs = 0;            ///< milliseconds of all queries; the following five are parts of it
    double cullMs = 0;              ///< milliseconds of culling
    double sweepMs = 0;             ///< milliseconds of finding candidates
    double exactMs = 0;             ///< milliseconds of exact tests
    double contactMs = 0;           ///< milliseconds of feature contacts
    double respondMs = 0;           ///< milliseconds of moving nodes apart
    /// One of the soft bodies with a node, or of the objects with a transform or velocity, that is not finite; null:
    /// there is none. They have no contact with soft bodies; all others do. (A soft body that ceases to be finite in
    /// Bullet's solver stays at its start for the others in that step.) Valid until it leaves the world.
    const btCollisionObject* notFinite = nullptr;
};

/// Contact of a world's soft bodies: settings and statistics. Base class of qcSoftBodySolver and qcDeformableWorld.
///
/// Response: Bullet's own constraints run first. Then nodes are moved apart by contacts of vertices with faces and
/// edges with edges within the thickness, on the side from which they came. Last, every pair of triangles without a
/// common node that was apart at the start of the step is proven to be apart over the whole of it
/// (qcSoftBodySettings::continuous): nothing passes anything at any speed. What can't be proven is pushed apart, moved
/// as one, or returned to its start. Pairs that are left are counted: qcSoftBodyStatistics::unproven. Momentum is
/// conserved, unless links or bodies with locked axes press soft bodies against something: then these may stop. The
/// theorem and its limits: plugin/docs/never_through.md.
///
/// Tangled starts: triangles that penetrate at the start of a step are exempt, so a scene may start tangled. Each step
/// works them apart (qcSoftBodySettings::untangle), over half the thickness and without a velocity for that:
/// - Where an intersection curve cuts off a part of a surface, the part goes back through the other surface. The
///   smaller part moves: the body returns to the side on which most of it is.
/// - Where a curve ends inside of both surfaces, it is shortened from its ends.
/// Motion that tangles further ends as in an inelastic contact. In the classic world links that untangling strains
/// give nodes velocities, but a body no kinetic energy. Away from the curve nothing passes. A body that is inside of a
/// closed one as a whole has no curve and stays. Triangles that touch at the start, without penetration, are kept
/// apart; surfaces that cross exactly in common positions are worked apart as soon as they penetrate. A body that is
/// put into the plane of a rigid triangle, up to rounding, starts on the side from which the triangle's corners run
/// counter-clockwise.
///
/// Time: a step starts where the previous one ended. A node, an object or its triangles that the application moves in
/// between move within the step; what is put elsewhere, by more than half its size, starts there. Nodes get no velocity
/// from it.
///
/// Rigid bodies: a soft body collides with each qcMeshShape, and with the surfaces of Bullet's own shapes as triangles;
/// static, kinematic or moving, also in compounds; unless its collision flags have none of fCollision::RVSmask. Both
/// move, by mass. Links of multibodies count as rigid bodies, in worlds of either kind (btSoftMultiBodyDynamicsWorld,
/// qcDeformableWorld): contact moves the joints by their inertia alone, and Bullet solves their limits, motors and all
/// other constraints in the next step. Triangles with an anchored node don't collide with the body of the anchor nor,
/// if that can move, those next to them; and a part that starts inside of it with an anchored node stays inside.
/// - Boxes and polyhedra have their own faces. Spheres, capsules, cylinders, cones and any other convex shape have
///   triangles around them that are at most half the surface's margin away or, at the limit of 4096 triangles, a 400th
///   of the radius (round shapes) or a 100th of the half extent (others). Static triangle meshes, btGImpactMeshShape
///   and terrains have theirs; of planes, and of meshes with more than a million triangles, what lies near soft bodies.
///   Triangles are made when a soft body first comes near and kept; see updateShape.
/// - The margin of a surface: Bullet's, where the shape proper lies inside of it (polyhedra, cones, meshes), but at
///   least that of a qcMeshShape; otherwise 1 cm, at most an eighth of the smallest half extent.
/// - Bullet's own tests, of nodes or clusters, stay for bodies with qcSoftBodySettings::bulletNodeContacts or
///   fCollision::CL_RS or of the reduced model, for objects without contact response, btSdfCollisionShape and compounds
///   of GImpact, and for the step after a failed query.
/// In the classic world, contacts with fixed bodies are in Bullet's solver too, as soft contacts while it runs: links
/// don't pull cloth that hangs over an edge into the body.
///
/// Ropes: a link with an end that no face has collides as a segment with the body's thickness, with meshes, faces of
/// soft bodies, other ropes and itself; links with a common node are neighbours and don't collide. Three kinds of links
/// don't collide: those of a body with tetrahedra; those that resist bending only (Link::m_bbending, set by
/// generateBendingConstraints); and those whose ends are connected by two shorter links (a diagonal of a net, a link
/// over two others of a rope). Links may be added and removed between steps. In the classic world rope contacts and
/// links are solved in turns, so that a rope under tension lies still as long as friction holds it. Friction is
/// Coulomb's: a rope thrown along itself may slide off where Bullet's own solver, which slows sliding by a share in
/// each iteration, stops it. Other nodes without a face (of tetrahedra in a body without faces, or cut off) collide
/// with meshes and faces of soft bodies as points.
///
/// Bodies that Bullet doesn't simulate at present (isActive() is false) don't move; others are kept away from them.
/// One that sleeps wakes in the step in which an object that the application moves comes to its box.
///
/// Manifolds: after a step its contacts, as they were before the response, are in manifolds of the world's dispatcher,
/// four points each, until the next step begins. Body 0 is soft; body 1 is another soft body, the same one
/// (self-collision), or a rigid one. If both are soft, body 0 was added first. A manifold may name a body
/// that was removed after the step.
///
/// Callbacks run at the end of the step. Starts and ends are reported once for two bodies (or for one with itself),
/// whatever the number of their manifolds:
/// - gContactStartedCallback with one of their manifolds.
/// - gContactProcessedCallback for each point in each step; its changes have no effect on the response.
/// - gContactEndedCallback with a manifold without points; not if one of the two left the world. Two sleeping bodies
///   stay in contact until one wakes.
/// - gContactDestroyedCallback for each point with user data, when its manifold is released.
/// The first and the third may add and remove bodies, the others must not.
///
/// Profile zones (BT_PROFILE): "qcSoftBodyContact elastic contacts", in the deformable world within Bullet's solver;
/// "qcSoftBodyContact gather", then "qcSoftBodyContact resolve" and in it "qcSoftBodyContact sweep" of nodes,
/// "qcSoftBodyContact untangle", "qcSoftBodyContact round" for each round, "qcSoftBodyContact push apart",
/// "qcSoftBodyContact move zones" and "qcSoftBodyContact move guided" if rounds did not suffice, and in these
/// "qcSoftBodyContact detect", "qcSoftBodyContact certify", "qcSoftBodyContact manifolds" and "qcSoftBodyContact
/// respond"; last "qcSoftBodyContact callbacks". Within "detect" and "certify" are the stages of the query: see
/// qcDetectDef::enterStage.
///
/// Cost: one run of qcScene_Detect in a step without contacts where no node moves by half the thickness, two else, a
/// few more if these don't suffice. A body with `continuous` off has no second one. Thread-safety: as the world's.
class QC_API qcSoftBodyContact
{
  public:
    /// Sets how a body collides, from the next step until it is removed from the world. It may be called before the
    /// body is added; then don't delete the body without adding it. qc_statusBadInput: the body is null, or thickness
    /// or friction is negative (but for a friction of -1) or not finite; the body's settings stay as they were.
    qcStatus setSettings(const btSoftBody* body, const qcSoftBodySettings& settings);
    /// The settings of a body; the defaults if none were set.
    qcSoftBodySettings getSettings(const btSoftBody* body) const;
    /// The work of the last step. Valid until this object is destroyed; changes with each step.
    const qcSoftBodyStatistics& getStatistics() const;

    /// Reports that the triangles of one of Bullet's shapes (static triangle mesh, terrain, btGImpactMeshShape) have
    /// moved: call it where Bullet requires refitTree or postUpdate. They are copied when a soft body first comes near,
    /// and again only after this call. Scaling and margins are detected without it. In the next step each vertex moves
    /// from where it was, and soft bodies go with it; see plugin/docs/never_through.md. O(triangles) in that step.
    ///
    /// A new shape at the address of a deleted one is read anew if the objects that had the old one have left the
    /// world. In an object that stays, by setCollisionShape or as a child of a compound, it needs this call.
    void updateShape(const btCollisionShape* shape);

    /// Threads of the queries; 0, the default: one per core, or the number given to qcSetParallelFor. Queries that take
    /// less than 0.3 milliseconds run on one.
    void setThreadCount(unsigned threads);
    /// The method of the queries; qc_methodAuto by default. It changes the cost, not the simulation. `cullide` and
    /// `quick` have no contacts: each step then keeps Bullet's own positions, with status qc_statusBadInput.
    void setMethod(qcMethod method);

    /// Draws in red the potentially colliding set of the first query of the last step, at the bodies' present places:
    /// the triangles in a candidate pair or with a contact, and a cross for each such node without a face. In yellow
    /// the separating planes of the last step (qcSoftBodyStatistics::planes): a square of the thickness between the
    /// closest points of both triangles, with its normal. In magenta a cross at each node of a zone (zoneNodes). Bodies
    /// that have left the world since, and meshes that an object no longer has, are left out. Call it between steps,
    /// after debugDrawWorld. The drawer's debug mode is ignored. Changes nothing. O(triangles log contacts).
    void debugDraw(btIDebugDraw* drawer) const;
    /// Draws only what the bits of qcDebugDrawMode select.
    void debugDraw(btIDebugDraw* drawer, int modes) const;
    /// true: candidate pairs are kept for debugDraw with qc_drawCandidates, from the next query on, at the cost of a
    /// sort of them. false, the default: they are not. qcDebugDraw calls it.
    void setReportCandidates(bool report);

  protected:
    /// `device` runs the methods that need GL; null is the same as a device of kind none. It must outlive this object
    /// and may be shared.
    explicit qcSoftBodyContact(qcDevice* device);
    ~qcSoftBodyContact();
    qcSoftBodyContact(const qcSoftBodyContact&) = delete;
    qcSoftBodyContact& operator=(const qcSoftBodyContact&) = delete;

    /// @cond
    struct Implementation;
    std::unique_ptr<Implementation> m_implementation;
    /// @endcond
};

/// A drop-in for btDefaultSoftBodySolver. Bullet's classic soft bodies have no self-collision (VF_SS skips a body with
/// itself, CL_SELF has had no effect since 2.89), and VF_SS between two bodies tests vertices against faces only.
///
/// Destroy it after the world and before the dispatcher.
class QC_API qcSoftBodySolver : public btDefaultSoftBodySolver, public qcSoftBodyContact
{
  public:
    /// See qcSoftBodyContact for `device`.
    explicit qcSoftBodySolver(qcDevice* device = nullptr);
    ~qcSoftBodySolver() override;

    /// Receives the world's soft bodies at the beginning of a step.
    void optimize(btAlignedObjectArray<btSoftBody*>& softBodies, bool forceUpdate = false) override;
    /// Reads where rigid bodies start: the pre-tick callback may have put them elsewhere.
    void predictMotion(btScalar timeStep) override;
    /// Runs Bullet's constraints, then moves nodes apart.
    void solveConstraints(btScalar timeStep) override;
    /// Updates normals and bounds, then calls contact callbacks.
    void updateSoftBodies() override;
    /// Two soft bodies: nothing; solveConstraints handles them if the filters of broadphase and dispatcher agree.
    void processCollision(btSoftBody* body, btSoftBody* other) override;
    using btDefaultSoftBodySolver::processCollision;
};

#endif
