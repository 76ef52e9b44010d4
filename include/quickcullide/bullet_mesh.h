/// @file
/// Triangle meshes that move and collide with each other, in any Bullet world:
///
///     qcMeshContact meshContact;
///     btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
///     meshContact.addTo(&world);
///     qcMeshShape shape(positions, qc_positionF32, 0, vertexCount, indices, triangleCount);
#ifndef QUICKCULLIDE_BULLET_MESH_H
#define QUICKCULLIDE_BULLET_MESH_H

#include "scene.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <memory>
#include <vector>

class btIDebugDraw;
class btStridingMeshInterface;
class qcAxisCache;
class qcConvexCores;
class qcSupportMesh;

/// Mass properties of a mesh of homogeneous material.
struct qcMassProperties
{
    /// qc_statusBadInput: the area or volume is outside the range of double, or the inertia outside that of btScalar
    /// (in float: meshes longer than 1e19 or shorter than 1e-19). Values out of range are 0, the others hold.
    qcStatus status = qc_statusOk;
    /// Each edge (vertices at equal positions count as one) is used equally often in both directions, and the mesh has
    /// an inside. A sheet with two sides has none, nor has a mesh with parts inside out so large that moments of
    /// inertia would be negative. Otherwise the mesh counts as a thin shell.
    bool closed = false;
    double area = 0;           ///< in squared units of length
    double volume = 0;         ///< in cubed units of length; 0 unless closed
    btVector3 center{0, 0, 0}; ///< centre of mass, in the mesh's frame
    /// Inertia tensor for mass 1, about the centre of mass, along the mesh's axes. Multiply by the mass.
    btMatrix3x3 inertia = btMatrix3x3::getIdentity();
    /// Centre and principal axes: moved by the inverse of this, the mesh has a diagonal tensor about its origin.
    btTransform principalFrame = btTransform::getIdentity();
    /// The diagonal of that tensor, for mass 1. Multiplied by the mass: the inertia of a btRigidBody.
    btVector3 principalInertia{0, 0, 0};
};

/// A triangle soup, moving or static. Positions and indices are copied, and don't change: a mesh that deforms is given
/// to its body as a new shape. It need not be closed; triangles may intersect, overlap or be degenerate. Creation is
/// O(n), and for up to 16 384 triangles O(n * faces of similar direction), since it finds the faces for contact then; a
/// tree over the triangles is built in O(n log n) when it is first needed (convex shapes, rays, soft bodies).
///
/// Contact: with convex shapes, rays and swept shapes by Bullet's own algorithms; with meshes and planes by a
/// qcMeshContact of the world; with soft bodies by qcSoftBodySolver or qcDeformableWorld, otherwise by Bullet's own
/// algorithm. The shape type is FAST_CONCAVE_MESH_PROXYTYPE, since CUSTOM_CONCAVE_SHAPE_TYPE equals
/// SDF_SHAPE_PROXYTYPE, which Bullet casts to btSdfCollisionShape.
///
/// Margin: a shell on both sides of each triangle. Default: 0.01, or a quarter of the mean edge if that is less. Two
/// resting meshes touch with their shells, not with their triangles, which keeps contact points reliable. Thick shells
/// around small triangles cost time.
///
/// Dynamic bodies: the shape's origin must be the centre of mass, and its axes the principal axes, since Bullet rotates
/// a body about its origin and stores the diagonal of its tensor only. Otherwise the body wobbles and falls wrongly.
/// makeRecentered makes a copy that lies so; getMassProperties gives centre and axes.
///
/// Serialization (btSerializer): the mesh is saved as a btCompoundShape with one btBvhTriangleMeshShape at its origin,
/// which Bullet's importers load together with the body's mass. (They drop btGImpactMeshShape unless built with
/// USE_GIMPACT, and load a body with a bare triangle mesh as static.) qcRestoreMeshes then makes a qcMeshShape of it;
/// until then loaded meshes touch convex shapes only. Vertices, indices, scaling and margin are kept, the latter two in
/// single precision. For all shapes Bullet's importers drop velocities, filters and collision flags: a kinematic body
/// comes back static.
///
/// Thread-safety: const functions may run on several threads at once while no other function runs.
ATTRIBUTE_ALIGNED16(class) QC_API qcMeshShape : public btConcaveShape
{
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    /// A mesh of `vertexCount` positions, `stride` bytes apart (0: tightly packed), and 3 * `triangleCount` indices.
    /// See getStatus.
    qcMeshShape(const void* positions, qcPositionType type, size_t stride, uint32_t vertexCount,
                const uint32_t* indices, uint32_t triangleCount);
    /// A copy of all parts of one of Bullet's mesh interfaces, with its scaling. See getStatus.
    explicit qcMeshShape(const btStridingMeshInterface* mesh);
    ~qcMeshShape() override;
    qcMeshShape(const qcMeshShape&) = delete;
    qcMeshShape& operator=(const qcMeshShape&) = delete;

    /// qc_statusBadInput, and the mesh is empty: an index was out of range, a position not finite, a pointer null
    /// although its count is not 0, or the stride less than a position. Also, and the mesh stays as it is: a scaling or
    /// a margin was refused. qcLastMessage then names it.
    qcStatus getStatus() const;

    uint32_t getVertexCount() const;   ///< the number of vertices
    uint32_t getTriangleCount() const; ///< the number of triangles
    /// Positions in the shape's frame, scaled. Valid until the next setLocalScaling.
    const btVector3* getVertices() const;
    /// Three for each triangle. Valid as long as the shape.
    const uint32_t* getIndices() const;
    /// A number that differs between any two shapes, and changes with each scaling.
    uint64_t getRevision() const;

    /// The mass properties of the scaled mesh. O(n log n).
    qcMassProperties getMassProperties() const;
    /// A copy whose origin is the centre of mass and whose axes are the principal axes, with the same margin; scaling
    /// is applied. `frame` (may be null) receives principalFrame of the mass properties: a body of the copy at T *
    /// frame has its triangles where a body of this shape has them at T. O(n log n).
    std::unique_ptr<qcMeshShape> makeRecentered(btTransform* frame = nullptr) const;
    /// The diagonal of the tensor about the shape's origin, which Bullet takes for the centre of mass. If the centre of
    /// mass lies elsewhere, use makeRecentered. A moment is 0 if btScalar can't hold it or its inverse: Bullet then
    /// doesn't rotate the body about that axis. O(n log n).
    void calculateLocalInertia(btScalar mass, btVector3 & inertia) const override;

    /// The box around the transformed mesh, margin included.
    void getAabb(const btTransform& transform, btVector3& aabbMin, btVector3& aabbMax) const override;
    /// Scales the mesh, O(n). Nothing changes but the status (qc_statusBadInput) if a position would not be finite.
    void setLocalScaling(const btVector3& scaling) override;
    const btVector3& getLocalScaling() const override; ///< (1, 1, 1) by default
    /// Likewise if the margin is negative or not finite.
    void setMargin(btScalar margin) override;
    const char* getName() const override; ///< "QCMESH"

    /// Reports every triangle whose box overlaps the closed box. A btTriangleRaycastCallback or
    /// btTriangleConvexcastCallback receives only triangles that its ray or shape may still hit, nearer ones first, as
    /// far as the tree can order them.
    ///
    /// btCollisionWorld's convex sweeps end at a hit whose fraction the ConvexResultCallback returns, as Bullet's
    /// closest-hit callbacks do: triangles behind it are not tested. A callback that collects all hits must return
    /// another number, 1 for example.
    void processAllTriangles(btTriangleCallback * callback, const btVector3& aabbMin, const btVector3& aabbMax)
        const override;
    /// Reports every triangle with a point below the plane normal . x = distance, and a few others.
    void processTrianglesBelow(btTriangleCallback * callback, const btVector3& normal, btScalar distance) const;

    int calculateSerializeBufferSize() const override; ///< of the data that serialize writes
    /// Writes the shape as Bullet's data; see the class.
    const char* serialize(void* dataBuffer, btSerializer* serializer) const override;
    void serializeSingleShape(btSerializer * serializer) const override; ///< writes the shape as a chunk

  private:
    friend qcAxisCache;
    friend qcConvexCores;
    struct Implementation;

    /// What contact needs of a small mesh, built with the shape; null if the mesh is not small. Thread-safe.
    std::shared_ptr<const qcSupportMesh> GetSupport() const;

    std::unique_ptr<Implementation> m_implementation;
};

/// Makes qcMeshShapes again in a world that Bullet's importer loaded: replaces each btCompoundShape that holds a single
/// btBvhTriangleMeshShape at its origin, as the shape of an object or as a child of a compound. Shared shapes are
/// shared again, except for children of compounds, which the importer copies. Dynamic bodies whose root shape is
/// replaced get the mesh's inertia. Call it between steps. O(objects + triangles).
///
/// Returns the new shapes, which must outlive the objects and compounds that use them. The importer keeps the old ones.
QC_API std::vector<std::unique_ptr<qcMeshShape>> qcRestoreMeshes(btCollisionWorld* world);

/// The work of the last fixed time step; stepSimulation may make several, or none. A step in which what was known of
/// all pairs still holds does no work.
struct qcMeshContactStatistics
{
    /// Anything but qc_statusOk: an object is not finite (see notFinite), or a query failed, for example because
    /// memory ran out; its pairs then have no contact.
    qcStatus status = qc_statusOk;
    uint64_t batches = 0; ///< queries for all pairs, since the beginning: at most one in each step
    uint64_t queries = 0; ///< queries for a single pair, since the beginning: contactTest, contactPairTest
    int bodies = 0;       ///< meshes in the scene; a compound has one for each mesh in it
    int pairs = 0;        ///< pairs of objects that were queried; of the others what was known still held
    int manifolds = 0;    ///< regions of contact, of all pairs
    int points = 0;       ///< contact points of these
    /// The method that ran; never qc_methodAuto: `layers` if the device answered for a part.
    qcMethod method = qc_methodSweep;
    const char* device = "none";    ///< name of the device that was used; "none" if the CPU answered alone
    const char* fallback = nullptr; ///< why another method than the requested one ran, or null
    int planes = 0;                 ///< pairs of small meshes, near and far, whose contact is found by a plane between
    int moments = 0;                ///< times within the step at which fast bodies were sampled
    int limited = 0;                ///< bodies, and links near meshes, that the limits of the last step have moved
    int unproven = 0;               ///< pairs of objects that could not be kept apart in the last step
    double limitMs = 0;             ///< milliseconds of certifying the last step's motions
    double gatherMs = 0;            ///< milliseconds of reading from Bullet
    double aheadMs = 0;             ///< milliseconds of sampling fast bodies
    double detectMs = 0;            ///< milliseconds of the query; the following are parts of it
    double cullMs = 0;              ///< milliseconds of culling
    double sweepMs = 0;             ///< milliseconds of finding candidates
    double exactMs = 0;             ///< milliseconds of exact tests
    double manifoldMs = 0;          ///< milliseconds of making manifolds
    /// One of the objects that may hold meshes, or of those near one, with a transform or velocity that is not finite;
    /// null: there is none. They have no contact with meshes, and no limits; all others do. Valid until it leaves the
    /// world.
    const btCollisionObject* notFinite = nullptr;
};

/// Contact of the meshes of a world: qcMeshShape with qcMeshShape, btGImpactMeshShape, static triangle meshes, terrains
/// and planes, also as children of compounds. Bullet itself has contact between concave shapes for btGImpactMeshShape
/// only, triangle pair by triangle pair. Here contact points belong to whole regions of contact, so that a mesh slides
/// over inner edges of another one without bumps.
///
/// Batches: the first pair of meshes in a step starts one query for all pairs in the world's pair cache; the others
/// read its result. Any broadphase and any dispatcher will do; the order of pairs and their threads make no difference.
/// A pair outside a step (contactTest, contactPairTest) or with another transform is computed alone.
///
/// Contact points: all that the bodies' motion in the step may bring into contact, as far as Bullet's contact breaking
/// threshold reaches and, for fine meshes, a fifth of an edge of each body, beyond both margins; on planes at any
/// speed, but for links of multibodies. Contacts that will come within the threshold during the step are created at its
/// beginning, before the bodies penetrate. Points are grouped by normal. Each of up to four groups has a manifold of
/// its own with the four points that span it, among them the deepest, or one of the previous step that is at most 5 %
/// of the threshold less deep. A point near one of the previous step keeps its impulses.
///
/// Margins that overlap from the beginning, such as those of bodies that are stacked without a gap, or of the pieces of
/// a body that breaks: they give way within a second, so that the bodies are not thrown apart. Bodies that pass each
/// other by more than their margins in their first step get Bullet's whole push. The distances of contact points in
/// manifolds leave out what has not given way yet; without a step of the world (btCollisionWorld, ghosts, contactTest)
/// they are the real ones.
///
/// Turning bodies: a point that a body approaches by turning lies where the arc of its vertex gets nearest to a face of
/// the other one within the step, so that round meshes roll on as they do in small steps.
///
/// Restitution: bodies bounce at the end of the step in which they reach each other. Until then
/// btManifoldPoint::m_combinedRestitution of these points is 0. In worlds that run no actions (btSimpleDynamicsWorld,
/// btCollisionWorld) there are no limits, and restitution is left to the solver.
///
/// Fast bodies: rigid bodies that pass each other by more than the threshold and 5 % of the smaller one are sampled at
/// up to sixteen times in the step, along their initial velocities, and stop where they touch, together with bodies
/// that follow them. Changes of velocity by the solver within the step are not foreseen, nor are children of compounds.
///
/// Limits: no two meshes that don't touch at the start of a step pass each other in it, whatever their speed, children
/// of compounds included. Those that touch, up to rounding, as the pieces of a cut do, come no deeper into each other;
/// those that penetrate are exempt. After Bullet has integrated the transforms, in an action of the world, bodies whose
/// motions are not proven apart are pushed apart or cut back. Static and kinematic objects are not; `unproven` counts
/// pairs that they press together. A kinematic body moves to where the application sets its transform, and takes along
/// what is between; one that is put elsewhere needs setInterpolationWorldTransform, too. One that is removed and added
/// again starts where it is, if its proxy has a new unique id, as with qcBroadphase. Bullet's btDbvtBroadphase uses ids
/// again after resetPool, its other broadphases at once: let a step run in between. The triangles of a static or
/// kinematic mesh that the application moves, by updateShape or by another qcMeshShape of the same triangles, likewise
/// take along what is between; a mesh with a vertex that moves further than half of its diagonal is put elsewhere.
/// Convex shapes, in compounds too, and qcMeshShapes don't pass each other either: where they move against each other
/// in a step by more than half of the shape's half width, or are pressed into each other by more than a tenth of it, a
/// polyhedron inside of each shape, of nine tenths of its size, is limited like a mesh; one of four tenths where the
/// larger one is in the mesh already. All have Bullet's contact, without points at inner edges of the mesh on which
/// what slides would trip. Links of a btMultiBody that the world steps are limited with meshes and with convex shapes,
/// against all but other links of the same one: the motion of its joints is cut back. On a btStaticPlaneShape contact
/// alone holds meshes: those that land fast, spin fast or lie under a heap may sink in before it pushes them out.
///
/// Rest: as long as no two points of a pair have moved against each other by 3 % of both thresholds, its contact points
/// move with the bodies and nothing is searched.
///
/// debugDrawWorld draws qcMeshShapes like any concave shape (DBG_DrawWireframe, DBG_DrawAabb) and their contact points
/// (DBG_DrawContactPoints); debugDraw draws the triangles that the culling left.
///
/// Profile zones (BT_PROFILE), at the first pair of a step: "qcMeshContact batch", and in it "qcMeshContact planes"
/// between small meshes, "qcMeshContact gather", "qcMeshContact look ahead" and, where no plane separates a pair,
/// "qcMeshContact detect"; at each pair "qcMeshContact manifolds"; at a pair computed alone "qcMeshContact query"; at
/// the end of a step in which a mesh has moved "qcMeshContact limit". Within are the stages of each query: see
/// qcDetectDef::enterStage.
///
/// Must outlive the world. Destroy it before another world's dispatcher is created, which may get the address of the
/// old one. Thread-safety: the algorithms may run on several threads at once; the functions below belong to the world's
/// thread.
class QC_API qcMeshContact
{
  public:
    /// `device` runs the methods that need GL; null is the same as a device of kind none. It must outlive this object.
    explicit qcMeshContact(qcDevice* device = nullptr);
    ~qcMeshContact();
    qcMeshContact(const qcMeshContact&) = delete;
    qcMeshContact& operator=(const qcMeshContact&) = delete;

    /// Registers with the world's dispatcher, which must be a btCollisionDispatcher. For one world, before it has
    /// objects, and after btGImpactCollisionAlgorithm::registerAlgorithm, which would replace the pairs with
    /// btGImpactMeshShape. Pairs of convex shapes with qcMeshShapes, and those of compounds, get the algorithms of the
    /// dispatcher's configuration, in place of ones that were registered with the dispatcher: register yours afterwards.
    /// qc_statusBadInput, and nothing changes: the world is null, its dispatcher is another one, or this object has a
    /// world.
    qcStatus addTo(btCollisionWorld* world);
    /// From the next pairs on, contact of btGImpactMeshShape with itself and with static triangle meshes is computed
    /// here too. Compounds of GImpact, and its contact with convex shapes and planes, stay Bullet's. Call it after
    /// addTo: qc_statusBadInput otherwise.
    qcStatus takeOverGImpact();

    /// Reports that the triangles of one of Bullet's shapes (static triangle mesh, terrain, btGImpactMeshShape; not a
    /// compound of such) have moved: call it where Bullet requires refitTree or postUpdate. They are copied when a pair
    /// first needs them, and again only after this call. Scaling is detected without it. In the next step each vertex
    /// of a static or kinematic object moves from where it was: what lies between goes with it. O(triangles) in that
    /// step.
    ///
    /// A new shape at the address of a deleted one is read anew if the objects that had the old one have left the
    /// world. In an object that stays, by setCollisionShape or as a child of a compound, it needs this call.
    void updateShape(const btCollisionShape* shape);

    /// Threads of queries, and of contact and limits of many small meshes; 0, the default: one per core, or the number
    /// given to qcSetParallelFor.
    void setThreadCount(unsigned threads);
    /// The method of the queries; qc_methodAuto by default. qc_statusBadInput: `cullide` and `quick`, which miss pairs,
    /// and what is no method; the method stays as it was.
    qcStatus setMethod(qcMethod method);
    /// The work of the last step. Valid until this object is destroyed; changes with each step.
    const qcMeshContactStatistics& getStatistics() const;

    /// Draws in red the potentially colliding set of the last batch: the triangles in candidate pairs, at their
    /// objects' present places. After a step in which nothing moved it is that of the batch before. Nothing is drawn if
    /// there was no batch or its query failed; objects that have left the world or changed their shape since are left
    /// out. Call it between steps, after debugDrawWorld. The drawer's debug mode is ignored. Changes nothing.
    /// O(candidates + triangles of Bullet's own shapes).
    void debugDraw(btIDebugDraw* drawer) const;
    /// Draws only what the bits of qcDebugDrawMode select.
    void debugDraw(btIDebugDraw* drawer, int modes) const;
    /// true: candidate pairs are kept for debugDraw with qc_drawCandidates, from the next query on, at the cost of a
    /// sort of them. false, the default: they are not. qcDebugDraw calls it.
    void setReportCandidates(bool report);

  private:
    struct Implementation;
    std::unique_ptr<Implementation> m_implementation;
};

#endif
