// Triangle meshes that move and touch each other, in any Bullet world:
//
//     qcMeshContact meshContact;
//     btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
//     meshContact.addTo(&world);
//     qcMeshShape shape(positions, qc_positionF32, 0, vertexCount, indices, triangleCount);
//
// Bullet has no contact among btConcaveShapes, but for btGImpactMeshShape, pair of triangles by pair of triangles. Here
// all pairs of meshes of a step are found in one run of qcScene_Detect, and their contact points are those of whole
// regions of contact: a mesh slides over the inner edges of another one without a bump.
#ifndef QUICKCULLIDE_BULLET_MESH_H
#define QUICKCULLIDE_BULLET_MESH_H

#include "scene.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>
#include <BulletCollision/CollisionShapes/btConcaveShape.h>

#include <memory>
#include <vector>

class btIDebugDraw;
class btStridingMeshInterface;

/// What a mesh of homogeneous material weighs, and where.
struct qcMassProperties
{
    /// qc_statusBadInput: the area or volume leaves the range of double, or the inertia that of btScalar (in float: of
    /// meshes longer than 1e19, or shorter than 1e-19). What does so is 0, the rest holds.
    qcStatus status = qc_statusOk;
    /// Each edge, of vertices at the same positions, is passed as often one way as the other, and there is an inside.
    /// Otherwise the mesh counts as a thin shell.
    bool closed = false;
    double area = 0;
    double volume = 0; ///< 0 unless closed
    btVector3 center{0, 0, 0};
    /// Of a body of mass 1, about its centre of mass, in the mesh's axes. Multiply by the mass.
    btMatrix3x3 inertia = btMatrix3x3::getIdentity();
    /// The centre and the principal axes: a mesh moved by the inverse of this has a diagonal tensor about its origin.
    btTransform principalFrame = btTransform::getIdentity();
    /// That diagonal, of a body of mass 1. Multiplied by the mass: the inertia of a btRigidBody.
    btVector3 principalInertia{0, 0, 0};
};

/// A triangle soup, moving or static. Positions and indices are copied. Any soup will do: it need not be closed, its
/// triangles may cross, lie on top of each other, or be degenerate. O(n), no preprocessing: a tree over the triangles
/// is built when something first asks for one (convex shapes, rays, soft bodies), in O(n log n).
///
/// Convex shapes, rays and swept shapes meet it through Bullet's own algorithms; meshes and planes, once a
/// qcMeshContact was added to the world; soft bodies through qcSoftBodySolver and qcDeformableWorld, else Bullet's own.
/// The shape type is FAST_CONCAVE_MESH_PROXYTYPE: CUSTOM_CONCAVE_SHAPE_TYPE is the same number as SDF_SHAPE_PROXYTYPE,
/// and Bullet's convex-concave algorithm casts what bears it to btSdfCollisionShape.
///
/// The margin is a shell on both sides of each triangle; unless setMargin says otherwise 0.01, or a quarter of the mean
/// edge where that is less. Two meshes rest with their shells touching: their triangles then don't, which is what makes
/// their contact points dependable. Thick shells around small triangles cost time.
///
/// Dynamic bodies: the centre of mass must be the shape's origin, and the principal axes those of the shape. Bullet
/// turns a body about its origin and keeps the diagonal of its tensor only; a mesh that lies otherwise wobbles and
/// falls wrongly. makeRecentered makes a copy that lies so; getMassProperties gives the centre and the axes.
///
/// Serialization (btSerializer): the mesh is saved as a btCompoundShape with one btBvhTriangleMeshShape at its origin.
/// Bullet's importers read that as it is, with the mass of the body: they drop btGImpactMeshShape unless built with
/// USE_GIMPACT, and a body with a bare triangle mesh comes back static. qcRestoreMeshes makes a qcMeshShape of it
/// again. Vertices, indices, scaling and margin are kept; Bullet's format has scaling and margin in single precision.
/// Until they are restored, loaded meshes touch convex shapes only. Of bodies Bullet's importers drop velocities,
/// filters and collision flags, whatever the shape: a kinematic body comes back static.
///
/// Thread-safety: the const functions may be called from several threads at once while no other function runs.
ATTRIBUTE_ALIGNED16(class) QC_API qcMeshShape : public btConcaveShape
{
  public:
    BT_DECLARE_ALIGNED_ALLOCATOR();

    /// `vertexCount` positions, `stride` bytes apart (0: tightly packed); 3 * `triangleCount` indices.
    qcMeshShape(const void* positions, qcPositionType type, size_t stride, uint32_t vertexCount,
                const uint32_t* indices, uint32_t triangleCount);
    /// All parts of a mesh interface of Bullet's, with its scaling. Nothing is kept of it.
    explicit qcMeshShape(const btStridingMeshInterface* mesh);
    ~qcMeshShape() override;
    qcMeshShape(const qcMeshShape&) = delete;
    qcMeshShape& operator=(const qcMeshShape&) = delete;

    /// qc_statusBadInput: an index was out of range, or a position not finite; the mesh is empty. qcLastMessage does
    /// not tell more.
    qcStatus getStatus() const;

    uint32_t getVertexCount() const;
    uint32_t getTriangleCount() const;
    /// In the shape's frame, scaled. Valid until the next scaling.
    const btVector3* getVertices() const;
    const uint32_t* getIndices() const;
    /// Differs between any two shapes, and before and after a scaling.
    uint64_t getRevision() const;

    /// O(n log n).
    qcMassProperties getMassProperties() const;
    /// A copy whose origin is the centre of mass and whose axes are the principal axes, with the same margin and its
    /// scaling applied. `frame` (may be null) receives where the copy lies in this shape, principalFrame of the mass
    /// properties: a body of the copy at T * frame has its triangles where a body of this shape has them at T.
    /// O(n log n).
    std::unique_ptr<qcMeshShape> makeRecentered(btTransform* frame = nullptr) const;
    /// The diagonal of the tensor about the shape's origin, which Bullet takes for the centre of mass, in its axes. For
    /// a mesh whose centre of mass lies elsewhere, see makeRecentered. A moment is 0 where btScalar can't hold it or
    /// its inverse: Bullet doesn't turn the body about that axis. O(n log n).
    void calculateLocalInertia(btScalar mass, btVector3 & inertia) const override;

    void getAabb(const btTransform& transform, btVector3& aabbMin, btVector3& aabbMax) const override;
    void setLocalScaling(const btVector3& scaling) override;
    const btVector3& getLocalScaling() const override;
    const char* getName() const override;

    /// Every triangle whose box meets the closed box. A btTriangleRaycastCallback gets only those that its ray may
    /// still hit, nearer ones first as far as the tree can tell.
    void processAllTriangles(btTriangleCallback * callback, const btVector3& aabbMin, const btVector3& aabbMax)
        const override;
    /// Every triangle that reaches below the plane normal . x = distance, and a few others.
    void processTrianglesBelow(btTriangleCallback * callback, const btVector3& normal, btScalar distance) const;

    int calculateSerializeBufferSize() const override;
    const char* serialize(void* dataBuffer, btSerializer* serializer) const override;
    void serializeSingleShape(btSerializer * serializer) const override;

  private:
    struct Implementation;
    std::unique_ptr<Implementation> m_implementation;
};

/// Puts qcMeshShapes back where a world was loaded with Bullet's importer: in the place of each btCompoundShape that
/// holds a single btBvhTriangleMeshShape at its origin, as the shape of an object or as a child of its compounds.
/// Shapes that were shared are shared again, but for children of compounds, of which the importer makes copies. Dynamic
/// bodies whose root shape is replaced get the inertia of the mesh. Returns the shapes made, which must outlive the
/// objects and compounds that use them; the replaced ones stay with the importer. Call it between steps. O(objects +
/// triangles).
QC_API std::vector<std::unique_ptr<qcMeshShape>> qcRestoreMeshes(btCollisionWorld* world);

/// What the last batch did.
struct qcMeshContactStatistics
{
    /// Anything but qc_statusOk: a query failed (say, a transform is not finite); the pairs concerned have no contact.
    qcStatus status = qc_statusOk;
    uint64_t batches = 0; ///< runs for all pairs, since the beginning: at most one a step
    uint64_t queries = 0; ///< runs for one pair alone, since the beginning: contactTest, contactPairTest
    int bodies = 0;       ///< meshes that the scene holds; a compound has one for each mesh in it
    int manifolds = 0;    ///< regions of contact
    int points = 0;       ///< contact points of these
    /// What answered: never qc_methodAuto, `layers` as soon as the device had a share.
    qcMethod method = qc_methodSweep;
    const char* device = "none";
    const char* fallback = nullptr; ///< why another method than the one asked for ran, or null
    int moments = 0;                ///< within the step that were looked at, for bodies that move fast
    double gatherMs = 0;            ///< milliseconds of reading from Bullet
    double aheadMs = 0;             ///< milliseconds of looking at these moments
    /// Milliseconds of the query, and what its stages took of it.
    double detectMs = 0, cullMs = 0, sweepMs = 0, exactMs = 0, manifoldMs = 0;
};

/// Contact of the meshes of a world: qcMeshShape with qcMeshShape, btGImpactMeshShape, static triangle meshes, terrains
/// and planes, also as children of compounds.
///
/// The first pair of meshes that a step asks for starts one query for all pairs in the world's pair cache; all others
/// read its result. So it works with any broadphase and any dispatcher, and which pair comes first, or on which thread,
/// makes no difference. A pair that is asked for elsewhere (contactTest, contactPairTest, or with a transform of its
/// own) is computed alone.
///
/// Contact points: those that the bodies' motion in the step may bring into touch, within Bullet's contact breaking
/// threshold and, for fine meshes, half an edge, of each body, beyond both margins; on planes however fast a body
/// comes. What the step brings within the threshold is in a manifold before: not met deep inside. Points are grouped by
/// normal, and each group, up to four of them, has a manifold of its own with the four points that span it, the deepest
/// among them, or one of the step before that is no more than 5 % of the threshold less deep. A point near one of the
/// step before keeps its impulses.
///
/// Rigid bodies that pass each other by more than the threshold and 5 % of the smaller one in a step are looked at in
/// up to sixteen moments of it, carried along by the velocities of its beginning, and stop where they touch; so do
/// those that follow them. What else the solver changes in the step is not foreseen. Nor are children of compounds, for
/// which Bullet asks when boxes overlap and not before.
///
/// While no point of a body has moved by 3 % of that threshold, its contact points move with it and nothing is
/// searched: meshes at rest cost next to nothing.
///
/// debugDrawWorld shows qcMeshShapes as any concave shape (DBG_DrawWireframe, DBG_DrawAabb) and their contact points
/// (DBG_DrawContactPoints); debugDraw the triangles that the culling left.
///
/// Profile zones (BT_PROFILE), where the first pair of a step is read: "qcMeshContact batch", and in it "qcMeshContact
/// gather", "qcMeshContact look ahead" and "qcMeshContact detect"; of each pair "qcMeshContact manifolds"; of a pair
/// computed alone "qcMeshContact query".
///
/// Must outlive the world. Thread-safety: the algorithms may run on several threads at once.
class QC_API qcMeshContact
{
  public:
    /// `device` draws for the methods that need GL; null is the same as a device of kind none. It must outlive this.
    explicit qcMeshContact(qcDevice* device = nullptr);
    ~qcMeshContact();
    qcMeshContact(const qcMeshContact&) = delete;
    qcMeshContact& operator=(const qcMeshContact&) = delete;

    /// Registers with the world's dispatcher, which must be a btCollisionDispatcher. One world; before it has objects.
    /// After btGImpactCollisionAlgorithm::registerAlgorithm, which would take the pairs with btGImpactMeshShape back.
    void addTo(btCollisionWorld* world);
    /// From the next pairs on, btGImpactMeshShape with itself and with static triangle meshes is contact of this kind
    /// too. Compounds of GImpact, and its contact with convex shapes and planes, stay as they are. After addTo.
    void takeOverGImpact();

    /// The triangles of a shape of Bullet's (static triangle mesh, terrain, btGImpactMeshShape; not a compound of such)
    /// are no longer where they were: to be called where Bullet wants refitTree or postUpdate. They are copied when a
    /// pair first needs them, and are not looked at again without this call. Scaling is noticed.
    void updateShape(const btCollisionShape* shape);

    /// Threads of the queries; 0: one per core.
    void setThreadCount(unsigned threads);
    /// The method of the queries; qc_methodAuto if this is never called. `cullide` and `quick` are refused, since they
    /// miss: qc_statusBadInput.
    qcStatus setMethod(qcMethod method);
    const qcMeshContactStatistics& getStatistics() const;

    /// Draws in red the potentially colliding set of the last batch: the triangles that are in a candidate pair, where
    /// their objects are now. A step in which nothing moved keeps the batch before. Nothing if there was none, or its
    /// query failed; objects that have left the world or changed their shape since are left out. For any debug mode:
    /// call it between steps, after debugDrawWorld. Changes nothing. O(candidates + triangles of Bullet's own shapes).
    void debugDraw(btIDebugDraw* drawer) const;

  private:
    struct Implementation;
    std::unique_ptr<Implementation> m_implementation;
};

#endif
