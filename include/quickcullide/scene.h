/// @file
/// A scene holds bodies, each a triangle soup, and finds the pairs of their triangles that intersect or come near. One
/// thread at a time may use a scene. Two scenes are independent, even if they share a device.
///
///     qcScene* scene;                              qcSceneDef sceneDef = qcDefaultSceneDef();
///     qcScene_Create(&sceneDef, &scene);           qcBodyDef bodyDef = qcDefaultBodyDef();
///     bodyDef.positions = ...;                     qcScene_AddBody(scene, &bodyDef, &id);
///     qcDetectDef def = qcDefaultDetectDef();      qcScene_Detect(scene, &def, &result);
#ifndef QUICKCULLIDE_SCENE_H
#define QUICKCULLIDE_SCENE_H

#include "device.h"

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A set of bodies, and the results of its last step.
typedef struct qcScene qcScene;

/// How to make a scene. Make it with qcDefaultSceneDef.
typedef struct qcSceneDef
{
    uint32_t structSize; ///< sizeof(qcSceneDef)
    /// Runs the methods that need GL. Null, the default, is the same as a device of kind none. Must outlive the scene.
    qcDevice* device;
} qcSceneDef;

/// The default definition: no device.
static inline qcSceneDef qcDefaultSceneDef(void)
{
    qcSceneDef def;
    def.structSize = (uint32_t)sizeof(qcSceneDef);
    def.device = NULL;
    return def;
}

/// Makes an empty scene. qc_statusBadInput: structSize is wrong. qc_statusOutOfMemory.
QC_API qcStatus qcScene_Create(const qcSceneDef* def, qcScene** scene);
/// Frees a scene, its bodies and its last result. Null is allowed.
QC_API void qcScene_Destroy(qcScene* scene);

//  ---- geometry in ---------------------------------------------------------------------------------

/// Names a body during its life. The id of a removed body is refused, even if its slot was reused: each slot has 2^31
/// ids, and stays empty once they are used up. {0, 0} is no body.
typedef struct qcBodyId
{
    uint32_t slot;       ///< a small number from 0, reused after a removal; results name bodies by it
    uint32_t generation; ///< 1 or more
} qcBodyId;

/// The type of coordinates.
typedef enum qcPositionType
{
    qc_positionF32 = 0, ///< three floats
    qc_positionF64 = 1  ///< three doubles
} qcPositionType;

/// Which pairs of bodies can be skipped because neither moves.
typedef enum qcActivity
{
    qc_activityMoving = 0,   ///< tested with every body
    qc_activitySleeping = 1, ///< not tested with itself and with sleeping or static bodies
    qc_activityStatic = 2    ///< treated as sleeping; the two names are for the caller's use
} qcActivity;

/// A map from local to world space: world = linear * local + translation, computed in double, in this order, without
/// fused multiply-add. All exact tests refer to the rounded result.
typedef struct qcTransform
{
    double linear[9];      ///< row by row
    double translation[3]; ///< in scene units
} qcTransform;

/// The transform that changes nothing.
static inline qcTransform qcIdentityTransform(void)
{
    qcTransform t = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    return t;
}

/// A triangle soup. All data is copied; the caller may free it after the call. Make it with qcDefaultBodyDef.
typedef struct qcBodyDef
{
    uint32_t structSize;         ///< sizeof(qcBodyDef)
    const void* positions;       ///< `vertexCount` positions of type `positionType`, in scene units
    qcPositionType positionType; ///< floats by default
    size_t positionStride;       ///< bytes from one position to the next; 0, the default: tightly packed
    uint32_t vertexCount;        ///< number of vertices
    const uint32_t* indices;     ///< 3 * `triangleCount` vertex indices, each below `vertexCount`
    uint32_t triangleCount;      ///< number of triangles
    /// true: positions are in world space and change by qcScene_SetVertices. false, the default: a rigid body,
    /// positions are in local space, and qcScene_SetTransform moves it.
    bool deforming;
    /// Rigid bodies: from local to world space; the identity by default. Ignored for deforming bodies, but must be
    /// finite.
    qcTransform transform;
    qcActivity activity; ///< moving by default
    /// Bits. Two bodies are tested if (a.group & b.mask) and (b.group & a.mask) are both nonzero. Default 1.
    uint32_t group;
    uint32_t mask; ///< see group; all bits by default
    /// Bodies with the same nonzero owner aren't tested with each other, for example the parts of one rigid compound.
    /// Self-collision is not affected. 0, the default: none.
    uint32_t owner;
    bool selfCollision; ///< report pairs of triangles within this body; true by default
    /// Caps qcDetectDef::margin and contactMargin, in scene units: a pair is reported if its distance is at most
    /// min(def.margin, A.margin + B.margin); within one body, twice its margin. 0 or more; infinity by default.
    double margin;
} qcBodyDef;

/// The default body: empty, rigid, moving, in group 1, with self-collision.
static inline qcBodyDef qcDefaultBodyDef(void)
{
    qcBodyDef def;
    def.structSize = (uint32_t)sizeof(qcBodyDef);
    def.positions = NULL;
    def.positionType = qc_positionF32;
    def.positionStride = 0;
    def.vertexCount = 0;
    def.indices = NULL;
    def.triangleCount = 0;
    def.deforming = false;
    def.transform = qcIdentityTransform();
    def.activity = qc_activityMoving;
    def.group = 1u;
    def.mask = 0xffffffffu;
    def.owner = 0;
    def.selfCollision = true;
    def.margin = (double)INFINITY;
    return def;
}

/// Adds a body and fills `id`. O(n). qc_statusBadInput: an index is out of range, a position is not finite, or a field
/// of the definition is invalid; the message names the body and the element. qc_statusOutOfMemory.
QC_API qcStatus qcScene_AddBody(qcScene* scene, const qcBodyDef* def, qcBodyId* id);
/// Removes a body and invalidates its id. The other ids stay. O(1). qc_statusBadInput: the id is not valid, here and
/// below.
QC_API qcStatus qcScene_RemoveBody(qcScene* scene, qcBodyId id);
/// Moves a rigid body. O(1); O(vertices) where their box overflows. qc_statusBadInput: also if the body deforms, the
/// transform is not finite, or it takes a vertex beyond all finite numbers.
QC_API qcStatus qcScene_SetTransform(qcScene* scene, qcBodyId id, const qcTransform* transform);
/// Gives a deforming body new positions in world space, as many as it has vertices, `stride` bytes apart (0: tightly
/// packed). They are copied, in large scenes on the threads of the last qcScene_Detect. O(n).
/// qc_statusBadInput: also if the body is rigid or a position is not finite.
QC_API qcStatus qcScene_SetVertices(qcScene* scene, qcBodyId id, const void* positions, qcPositionType type,
                                    size_t stride);
/// The present positions of all bodies become the start of their motion: see qcDetectDef::motion. A body that is added
/// later has no motion until the next mark. O(bodies); the first mark of a deforming body allocates O(vertices).
/// qc_statusOutOfMemory: nothing has changed. qc_statusDevice and qc_statusDeviceLost likewise: the device had the only
/// copy of positions (qcScene_SetVertexBuffer) and failed.
QC_API qcStatus qcScene_MarkStart(qcScene* scene);
/// See qcBodyDef::activity. O(1), like the three below. qc_statusBadInput: also if the activity is unknown.
QC_API qcStatus qcScene_SetActivity(qcScene* scene, qcBodyId id, qcActivity activity);
/// See qcBodyDef::group.
QC_API qcStatus qcScene_SetFilter(qcScene* scene, qcBodyId id, uint32_t group, uint32_t mask);
/// See qcBodyDef::selfCollision.
QC_API qcStatus qcScene_SetSelfCollision(qcScene* scene, qcBodyId id, bool selfCollision);
/// See qcBodyDef::margin. qc_statusBadInput: also if the margin is negative or NaN.
QC_API qcStatus qcScene_SetMargin(qcScene* scene, qcBodyId id, double margin);
/// The id names a body of the scene that was not removed. O(1).
QC_API bool qcScene_IsValid(const qcScene* scene, qcBodyId id);
/// The number of bodies. O(1).
QC_API uint32_t qcScene_GetBodyCount(const qcScene* scene);

//  ---- pairs and contacts out ----------------------------------------------------------------------

/// How candidates are found. auto, brute, sweep and layers never miss a pair and give the same result.
typedef enum qcMethod
{
    /// For each part of the scene the faster of `layers` and `sweep`, as measured on this machine.
    qc_methodAuto = 0,
    /// Every pair of triangles, O(n^2). The reference of the tests.
    qc_methodBrute = 1,
    /// CULLIDE (Govindaraju et al., Graphics Hardware 2003). Image precision: misses pairs between samples. Needs GL.
    qc_methodCullide = 2,
    /// Quick-CULLIDE (Govindaraju, Lin, Manocha, IEEE VR 2005), with four visibility sets. Image precision. Needs GL.
    qc_methodQuick = 3,
    /// Bounding volume hierarchies on the CPU.
    qc_methodSweep = 4,
    /// Image space without misses: conservative coverage, depth intervals, a list per pixel and slice. Needs GL with
    /// compute shaders.
    qc_methodLayers = 5
} qcMethod;

/// "auto", "brute", "cullide", "quick", "sweep", "layers"; "unknown method" for other values. Static. O(1). Any thread.
QC_API const char* qcMethod_Name(qcMethod method);

/// How two closed triangles lie. Degenerate triangles are segments or points.
typedef enum qcRelation
{
    qc_relationDisjoint = 0,    ///< they have no point in common
    qc_relationTouching = 1,    ///< they intersect, but only in boundary points of one of them
    qc_relationPenetrating = 2, ///< their relative interiors intersect
    qc_relationNear = 3         ///< they don't intersect; their distance is at most the margin
} qcRelation;

/// "disjoint", "touching", "penetrating", "near"; "unknown relation" for other values. Static. O(1). Any thread.
QC_API const char* qcRelation_Name(qcRelation relation);

/// The relation of two triangles, nine doubles each (corner by corner): disjoint, touching or penetrating. Exact for
/// all finite coordinates, degenerate triangles included. O(1). Any thread.
QC_API qcRelation qcRelateTriangles(const double* a, const double* b);

/// Closest points of two triangles, and how to separate them if they intersect.
typedef struct qcProximity
{
    double pointA[3]; ///< closest point of A; if they intersect, a common point
    double pointB[3]; ///< closest point of B; equal to pointA if they intersect
    /// Unit vector from B towards A. Separate triangles: from pointB to pointA. Intersecting ones: the direction of the
    /// smallest translation that separates them; of equal ones a face's normal rather than one of edges.
    double normal[3];
    double distance; ///< 0 if they intersect; infinity beyond the largest double
    /// Penetration depth: the length of the smallest translation of A along a separating axis (the normals of both
    /// faces, the cross products of nine pairs of edges) after which A only touches B. 0 unless the triangles
    /// penetrate, and for coplanar ones.
    double depth;
} qcProximity;

/// Is the distance of two triangles at most `margin`? Exact for all finite coordinates and margin >= 0; false for a
/// negative margin or NaN. O(1). Any thread.
///
/// `proximity` (may be null) is filled if the answer is yes. It is rounded in double: distance and depth to 1e-12 of
/// the triangles' extent, however far from the origin they lie. Points whose distances differ by rounding only count as
/// equally near: those of separate triangles are off by up to some 1e-8 of their distance, and 1e-12 of the extent; the
/// normal by 1e-8, and 1e-15 * extent / distance.
/// Swapping A and B gives the mirror image to the last bit, with the opposite normal; if A and B are equal corner by
/// corner, both orders have the same normal.
QC_API bool qcTrianglesWithin(const double* a, const double* b, double margin, qcProximity* proximity);

/// Does one direction separate two triangles at the start and at the end of a motion? Then it separates them at every
/// time between, if all corners move along straight lines with constant speed. Nine doubles each, corner by corner;
/// equal corners make a segment or a point. Sufficient, not necessary: false proves nothing. True is exact for the
/// given coordinates, in spite of rounding. Fills `direction` (may be null) if true, from B towards A, of any length.
/// O(1). Any thread.
QC_API bool qcTrianglesStayApart(const double* startA, const double* endA, const double* startB, const double* endB,
                                 double direction[3]);

/// Should the triangles of two different bodies, named by their slots, be tested? The slots may come in either order,
/// and the answer must be the same for both. It must not change during a step. The function may be called several times
/// for a pair and on several threads at once, and must not throw, nor call functions of the scene.
typedef bool (*qcPairFilter)(void* context, uint32_t slotA, uint32_t slotB);

/// What a step computes, and how. Make it with qcDefaultDetectDef, which sets all fields to 0, false or null unless
/// stated otherwise.
typedef struct qcDetectDef
{
    uint32_t structSize; ///< sizeof(qcDetectDef)
    qcMethod method;     ///< qc_methodAuto by default
    /// Report all pairs at this distance or nearer, finite, in scene units, decided exactly; touching pairs are then
    /// reported too. 0: pairs that penetrate; see `touching`. `cullide` and `quick` refuse a margin unless `reliable`
    /// is set.
    double margin;
    bool touching;    ///< report touching pairs too
    bool neighbours;  ///< test pairs of triangles within a body that share a vertex index, too
    bool segments;    ///< compute the intersection segment of each penetrating pair
    bool proximities; ///< compute closest points, distance and depth of each reported pair
    /// Merge the reported pairs of two bodies, or of one with itself, into contact points. More than 2^28 pairs are
    /// refused: qc_statusOutOfMemory.
    bool manifolds;
    /// Report contacts between features (vertex and face, edge and edge) at this distance or nearer, finite, in scene
    /// units. 0: no contacts. Not available with `cullide` and `quick`.
    double contactMargin;
    /// Between a deforming and a rigid body report only contacts that are local minima of distance on the rigid surface
    /// (Voronoi-region filter).
    bool nearestContacts;
    /// Excludes pairs of bodies, in addition to groups and owners. Null: none. With a filter each step is computed,
    /// even if nothing moved.
    qcPairFilter pairFilter;
    void* pairFilterContext; ///< passed to pairFilter
    /// Threads to use; more than 256 count as 256. 0: one per core, or the number given to qcSetParallelFor. The result
    /// does not depend on it. Each thread has memory of its own: some KB in small scenes, about 300 KB from 2 000
    /// triangles of a body on.
    uint32_t threads;
    //  For `layers` only; these change the cost, not the result.
    /// Pixels on a side of the image, rounded down to a power of two, up to 4096. 0: chosen from the triangles' sizes.
    /// GPUs need no image.
    uint32_t layerColumns;
    /// 'x', 'y' or 'z': the viewing axis. 0: the axis along which the scene is thinnest. One view suffices, since
    /// intervals are compared along all three axes.
    char layerDepthAxis;
    bool layerTimes; ///< measure the parts of a step, at a cost of some microseconds: see qcProfile::layerTimes
    //  For `cullide` and `quick` only.
    /// Viewing axes, in this order: 1 to 3 different letters of "xyz", ended by a zero. "xyz" by default.
    char views[4];
    /// Pixels on a side of the image, 1..4096 and at most the device's limit. 4096 by default.
    uint32_t resolution;
    uint32_t iterations; ///< rounds over the views; 0: until nothing changes
    //  Switches that go beyond the paper; all off is the paper.
    /// Draw back to front along the view: front primitives are drawn last and are more often fully visible. Each view
    /// has its own order and its own sets.
    bool backToFront;
    /// Reverse the depth comparison in the second pass: a primitive fully behind the others is separated as well as one
    /// fully in front. Use it with backToFront; in another order it prunes less than without.
    bool secondPassFromBack;
    /// Grow each primitive by half a pixel and half the margin in x, y and z before it is drawn and tested: nothing is
    /// missed at any resolution. Applies to bodies and to triangles of different bodies. Self-collision is left to
    /// `sweep`, since grown neighbours overlap in every view.
    bool reliable;
    uint8_t reserved[5]; ///< 0: padding of definitions in older headers
    /// Report the pairs that are not proven apart over the motion from the last qcScene_MarkStart to the present, in
    /// which all vertices, also those of rigid bodies, move along straight lines: pairs that no direction separates at
    /// both ends (qcTrianglesStayApart). A pair that isn't reported has no common point at any time of the motion.
    /// Without a mark no body has moved. `sweep` proves more pairs than `brute` where a surface turns by more than some
    /// 40 degrees: those of parts that stay flat.
    /// Relations and proximities of pairs are those of the start, where reported pairs may be disjoint. With
    /// `neighbours`: also pairs that share a vertex and aren't proven to meet there only. `touching` has no effect.
    /// Pairs without a common vertex are left out, too, if each half, quarter, eighth or sixteenth of the motion has a
    /// direction of its own, as where two surfaces turn as one body.
    /// Margins, segments and manifolds are refused; so are `cullide` and `quick`. `layers` leaves it to `sweep`.
    bool motion;
    /// For a profiler: called on the thread that runs the step where a stage of the step begins, with its name
    /// (static: "qcScene cull bodies", "qcScene sweep bodies", "qcScene cull triangles", "qcScene sweep triangles",
    /// "qcScene exact", "qcScene manifolds"), and where it ends. Stages don't nest. Both or none; they must not throw,
    /// nor call functions of the scene.
    void (*enterStage)(const char* name);
    void (*leaveStage)(void); ///< see enterStage
    bool candidates;          ///< report qcResult::candidates
    bool sets;                ///< report qcResult::pcsSets
    /// With `spacing`, also for two fine meshes that intersect: only their near pairs then have points, with normals
    /// along the shortest differences, so that a point behind a surface has the opposite normal. For callers who know
    /// from the motion of the bodies which side is which.
    bool unoriented;
    uint8_t reserved2[5]; ///< 0: padding of definitions in older headers
    /// For contact of fine meshes: manifolds of two bodies that don't touch need no points closer to each other than
    /// this, in scene units. Near pairs whose smaller triangle is no longer than this are left out of them where a
    /// nearer one covers them (plugin/docs/proofs/sparse_contact.md), so that the cost follows the area of the contact
    /// rather than its triangles. A region of contact may then have several manifolds. Pairs are reported as ever; with
    /// `proximities` it has no effect. 0: all pairs count.
    double spacing;
    /// The largest number of triangle pairs that the step may hold at any stage: candidates, pairs listed for contacts,
    /// results. A bound for memory: a pair takes at most some 68 bytes until it is reported, without contacts,
    /// segments, proximities and manifolds. With more pairs qcScene_Detect returns qc_statusTooManyPairs. 0: no limit.
    uint64_t maxPairs;
} qcDetectDef;

/// The default step: method auto, penetrating pairs only.
static inline qcDetectDef qcDefaultDetectDef(void)
{
    qcDetectDef def;
    def.structSize = (uint32_t)sizeof(qcDetectDef);
    def.method = qc_methodAuto;
    def.margin = 0.0;
    def.touching = false;
    def.neighbours = false;
    def.segments = false;
    def.proximities = false;
    def.manifolds = false;
    def.contactMargin = 0.0;
    def.nearestContacts = false;
    def.pairFilter = NULL;
    def.pairFilterContext = NULL;
    def.threads = 0;
    def.layerColumns = 0;
    def.layerDepthAxis = 0;
    def.layerTimes = false;
    def.views[0] = 'x';
    def.views[1] = 'y';
    def.views[2] = 'z';
    def.views[3] = 0;
    def.resolution = 4096;
    def.iterations = 0;
    def.backToFront = false;
    def.secondPassFromBack = false;
    def.reliable = false;
    for (int i = 0; i < 5; i++)
        def.reserved[i] = 0;
    def.motion = false;
    def.enterStage = NULL;
    def.leaveStage = NULL;
    def.candidates = false;
    def.sets = false;
    def.unoriented = false;
    for (int i = 0; i < 5; i++)
        def.reserved2[i] = 0;
    def.spacing = 0.0;
    def.maxPairs = 0;
    return def;
}

/// A pair of triangles, ordered so that (bodyA, triangleA) < (bodyB, triangleB).
typedef struct qcPair
{
    uint32_t bodyA;      ///< slot of A's body
    uint32_t triangleA;  ///< index of A in its body
    uint32_t bodyB;      ///< slot of B's body
    uint32_t triangleB;  ///< index of B in its body
    qcRelation relation; ///< touching, penetrating or near; of a motion also disjoint
} qcPair;

/// The intersection of two penetrating triangles, in world space, rounded. For coplanar triangles: the two corners of
/// the common area that lie farthest apart. Zeros for pairs that only touch.
typedef struct qcSegment
{
    double p[3]; ///< one end
    double q[3]; ///< the other end
} qcSegment;

/// A triangle of a scene.
typedef struct qcTriangleRef
{
    uint32_t body;     ///< slot
    uint32_t triangle; ///< index in the body
} qcTriangleRef;

/// Two features (vertex and face, edge and edge) within the contact margin that share no vertex. The closest points are
/// the weighted sums of the named vertices. Vertex and face: weightsA = {1, 0, 0}. Edge and edge: both third weights
/// are 0. Each pair of features is reported once, however many triangles share it. Rounded in double; valid for lengths
/// from 1e-70 to 1e70.
typedef struct qcContact
{
    uint32_t bodyA;        ///< slot of A's body
    uint32_t bodyB;        ///< slot of B's body
    uint32_t verticesA[3]; ///< vertex indices in A's body
    uint32_t verticesB[3]; ///< vertex indices in B's body
    double weightsA[3];    ///< sum 1, each 0 or more
    double weightsB[3];    ///< sum 1, each 0 or more
    double normal[3];      ///< unit vector from B's point to A's; of the face or edges if the points coincide
    double distance;       ///< 0 or more, scene units
} qcContact;

/// One contact point of a manifold: a corner of the common area of two triangles, projected along the normal (a vertex
/// over a face, or two crossing edges). Several pairs of triangles that yield the same point report it once.
typedef struct qcManifoldPoint
{
    double pointA[3]; ///< on A, world space; pointA = pointB + distance * normal, rounded
    double pointB[3]; ///< on B, world space
    /// Unit vector from B towards A. Normals of neighbouring points agree: none points into a body that another one
    /// separates, unless both triangles are separate and really lie so, like a sheet in a slit. Where a sharp edge has
    /// passed through a triangle, some may: one in a thousand shallow overlaps of convex bodies has such a point.
    double normal[3];
    /// At most the margin; negative: penetration depth at this point. Where bodies touch, it is rounding error. Where
    /// they overlap within the margin by a small part of their triangles, the depth is at most a small multiple of the
    /// overlap. Larger overlaps may give larger depths. -infinity: a depth beyond the largest double.
    double distance;
    uint32_t triangleA; ///< triangle of A that the point was computed from
    uint32_t triangleB; ///< triangle of B that the point was computed from
    /// The feature of A by vertex index: {v, v} a vertex, {v, w} with v < w an edge, {UINT32_MAX, UINT32_MAX} the face.
    /// A point with the same two features as one of the previous step is the same contact.
    uint32_t featureA[2];
    uint32_t featureB[2]; ///< the feature of B, likewise
} qcManifoldPoint;

/// The contact points of one connected region of contact between two bodies, or of a body with itself. Pairs of
/// triangles are connected if they have one triangle in common and the other two share a vertex; vertices at equal
/// positions count as shared.
///
/// Each pair in contact has a point, or a pair has one whose triangles are the same or adjacent, or a point lies at one
/// of its triangles, no further than 1/64 of the size of the region's triangles. There are two exceptions: pairs in a
/// flat patch between two rigid bodies, where only corners are reported, and those whose closest point is that of a
/// nearer pair, too. Two triangles of one body that only touch at a common vertex, by index or at equal positions, are
/// no contact. If both bodies are flat there and a plane separates the whole region, all points have the plane's
/// normal. Two points at the same place (nearer than 1/64 of the triangles' size) have different normals. Within one
/// body, A and B are the two sides of the region, whatever the order of their indices.
///
/// Coordinates may have any size, but triangles in contact must not be smaller than 1e-50 of the largest coordinate
/// among the triangles in contact of these two bodies: below that, rounding may turn normals and drop points.
typedef struct qcManifold
{
    uint32_t bodyA;      ///< slot, at most bodyB
    uint32_t bodyB;      ///< slot
    uint32_t firstPoint; ///< index in qcResult::manifoldPoints; points are sorted by distance, the deepest first
    uint32_t pointCount; ///< 1 or more
} qcManifold;

/// A candidate: a pair of triangles that the culling left, also one that is tested for contacts alone; ordered as in
/// qcPair. Neighbours that are tested for contacts alone are left out.
typedef struct qcCandidate
{
    uint32_t bodyA;     ///< slot of A's body
    uint32_t triangleA; ///< index of A in its body
    uint32_t bodyB;     ///< slot of B's body
    uint32_t triangleB; ///< index of B in its body
} qcCandidate;

/// The sets of Quick-CULLIDE (section 4.1). BFV is pruned; the other three make up the PCS.
typedef enum qcVisibilitySet
{
    qc_setBfv = 0, ///< fully visible in both passes
    qc_setFfv = 1, ///< fully visible in the first pass only; collision-free
    qc_setSfv = 2, ///< fully visible in the second pass only; collision-free
    qc_setNfv = 3  ///< fully visible in neither
} qcVisibilitySet;

/// The sets of a triangle of the PCS after the last pass, as values of qcVisibilitySet. At least one of them isn't BFV.
typedef struct qcTriangleSets
{
    uint8_t others; ///< against triangles of other bodies
    uint8_t self;   ///< against triangles of its own body
} qcTriangleSets;

/// What a pass of the visibility culling tests.
typedef enum qcCullLevel
{
    qc_levelObjects = 0,   ///< bodies against bodies
    qc_levelTriangles = 1, ///< triangles against triangles of other bodies
    qc_levelSelf = 2       ///< triangles of one body against each other
} qcCullLevel;

/// One pass of one view of the visibility culling (Quick-CULLIDE, section 4.1): its cost, and the sets after it.
typedef struct qcPassRecord
{
    qcCullLevel level;  ///< what is tested
    uint32_t body;      ///< slot; for qc_levelSelf only
    char axis;          ///< of the view: 'x', 'y' or 'z'
    uint32_t iteration; ///< from 1
    uint32_t pass;      ///< 1 or 2
    uint32_t queries;   ///< primitives tested
    uint32_t rendered;  ///< primitives drawn into the depth buffer
    uint32_t bfv;       ///< size of BFV: fully visible in both passes, and so removed, since the start of the level
    uint32_t ffv;       ///< size of FFV: fully visible in the first pass only
    uint32_t sfv;       ///< size of SFV: fully visible in the second pass only
    uint32_t nfv;       ///< size of NFV: fully visible in neither
    uint32_t pcs;       ///< size of the potentially colliding set, ffv + sfv + nfv
} qcPassRecord;

/// The time of one part of a step of `layers`.
typedef struct qcLayerTime
{
    const char* name; ///< for example "upload" or "boxes"; static
    /// Wall-clock milliseconds on the calling thread or the device's; for a kernel, the time to start it. Negative: the
    /// part did not run.
    double threadMs;
    /// Milliseconds between the device's timestamps (GL_TIMESTAMP). Negative: the part did not run on the device, or
    /// the device has no timestamps. That of "wait" is from the previous measured step: no step waits for its own
    /// timestamps.
    double deviceMs;
} qcLayerTime;

/// The work of a step, in the order in which data travels. Times are wall-clock milliseconds.
typedef struct qcProfile
{
    qcMethod method;    ///< the method that ran; never qc_methodAuto: `layers` if the device answered for a part
    const char* device; ///< name of the device that was used; "none" if the CPU answered alone
    /// Why another method than the requested one ran, or null. After failures in several successive steps a device is
    /// tried again after 2, 4, 8 and at most 128 steps only, or at once in a scene of half or double the size.
    const char* fallback;
    /// Nothing changed since the last step: its result is returned again, and the counters are those of that step.
    bool reused;

    double planMs;           ///< planning
    double cullObjectsMs;    ///< culling of bodies
    double sweepObjectsMs;   ///< pairs of bodies
    double cullTrianglesMs;  ///< culling of triangles
    double sweepTrianglesMs; ///< pairs of triangles
    double exactMs;          ///< exact tests, segments and proximities
    double contactMs;        ///< feature contacts
    double manifoldMs;       ///< manifolds
    double totalMs;          ///< the whole step

    uint32_t bodies;         ///< bodies in the scene
    uint32_t triangles;      ///< their triangles
    uint32_t parts;          ///< islands of bodies that may collide; counted only if the device may take some
    uint32_t partsOnDevice;  ///< islands computed by `layers`; `sweep` computed the others
    uint32_t objectPcs;      ///< bodies left after culling of bodies
    uint64_t bodyPairs;      ///< pairs of bodies to test: their boxes overlap and filters agree
    uint32_t selfBodies;     ///< bodies tested with themselves
    uint32_t trianglePcs;    ///< triangles left before the search for pairs of triangles
    uint64_t candidates;     ///< candidate pairs of triangles
    uint64_t filterHits;     ///< candidates that single precision proved near or penetrating
    uint64_t exactFallbacks; ///< candidates that double precision could not decide
    uint64_t pairs;          ///< pairs reported
    uint64_t contacts;       ///< feature contacts reported
    uint32_t resolution;     ///< pixels on a side of the image; 0: no image
    uint64_t queries;        ///< primitives tested, all passes
    uint64_t rendered;       ///< primitives drawn, all passes
    uint32_t columns;        ///< of the image of `layers`; 0: none, as on a GPU
    uint32_t rows;           ///< of the image of `layers`
    uint32_t slices;         ///< of depth, in each pixel of `layers`
    uint64_t fragments;      ///< entries in the lists of `layers`
    uint64_t listPairs;      ///< pairs of triangles whose intervals overlap along all axes, without neighbours
    uint32_t reruns;         ///< reruns of the step because a device buffer was too small and had to grow
    uint64_t uploadedBytes;  ///< to the device, in this step
    uint64_t deviceBytes;    ///< held on the device
    uint32_t deviceCalls;    ///< calls of GL in a step of `layers`
    uint32_t deviceWaits;    ///< waits for the device in a step of `layers`: one a run
    /// All parts of the step of `layers`, in order, also those that did not run: prepare (with new vertices), hand-over
    /// (to the device's thread), upload, vertices (and empty lists), boxes, nodes, node pairs, triangle pairs, pair
    /// tests, order (of the pairs), wait (for the device), timers (reading their times), hand-back, refine (on the
    /// CPU). All belong to cullTrianglesMs. Empty unless qcDetectDef::layerTimes is set and something has changed since
    /// the last step. Valid as long as the result.
    const qcLayerTime* layerTimes;
    size_t layerTimeCount;      ///< number of layerTimes
    bool softwareDevice;        ///< the device draws on the CPU
    const qcPassRecord* passes; ///< of `cullide` and `quick`; valid as long as the result
    size_t passCount;           ///< number of passes

    //  Work that was skipped.
    uint64_t skippedStaticPairs;   ///< overlapping pairs of bodies that both rest
    uint64_t skippedFilteredPairs; ///< overlapping pairs excluded by groups, owners or qcDetectDef::pairFilter
    uint64_t skippedSetPairs;      ///< overlapping pairs of bodies within one collision-free set (lemma 2)
    uint32_t skippedBodies;        ///< bodies that overlap no other and have no self-collision
    uint32_t skippedTriangles;     ///< triangles outside the overlaps of their body's box with others
    uint64_t skippedSetCandidates; ///< pairs of triangles within one collision-free set
    uint64_t skippedNeighbours;    ///< pairs of triangles that share a vertex index
    uint64_t fittedTriangles;      ///< triangles of bodies whose hierarchies `sweep` built or refitted
    uint64_t followedTriangles;    ///< triangles of bodies of which `sweep` updated moved vertices only
    uint64_t flatTriangles;        ///< triangles in flat patches, proven to have no self-contact
    /// Bytes of positions read back from the device in this step: of bodies with a vertex buffer
    /// (qcScene_SetVertexBuffer), 12 a vertex.
    uint64_t readBackBytes;
} qcProfile;

/// The result of a step. Owned by the scene; valid until the next call that changes the scene or detects again.
/// Pointers are null or arrays of the count that follows.
typedef struct qcResult
{
    const qcPair* pairs;            ///< sorted by bodyA, triangleA, bodyB, triangleB
    size_t pairCount;               ///< number of pairs
    const qcSegment* segments;      ///< one for each pair; null unless qcDetectDef::segments is set
    const qcProximity* proximities; ///< one for each pair; null unless qcDetectDef::proximities is set
    /// The potentially colliding set, sorted: triangles left before the search for pairs (`cullide`, `quick`) or in a
    /// candidate pair (other methods; pairs for contacts alone don't count).
    const qcTriangleRef* pcs;
    size_t pcsCount;                       ///< number of triangles in it
    const qcTriangleSets* pcsSets;         ///< one for each triangle of the PCS; null unless qcDetectDef::sets is set,
                                           ///< and for methods other than `cullide` and `quick`
    const qcCandidate* candidates;         ///< sorted as pairs are; null unless qcDetectDef::candidates is set
    size_t candidateCount;                 ///< number of candidates
    const qcContact* contacts;             ///< see qcDetectDef::contactMargin
    size_t contactCount;                   ///< number of contacts
    const qcManifold* manifolds;           ///< sorted by bodies; empty unless qcDetectDef::manifolds is set
    size_t manifoldCount;                  ///< number of manifolds
    const qcManifoldPoint* manifoldPoints; ///< of all manifolds
    size_t manifoldPointCount;             ///< number of points
    qcProfile profile;                     ///< the work of the step
} qcResult;

/// Runs a step: finds the pairs, and what else `def` requests. The result does not depend on the number of threads, nor
/// on the method among those that never miss. O(n log n + candidates + pairs of triangles that share a vertex) for
/// `sweep`.
///
/// A method that needs GL where there is none falls back to `sweep`, which gives qcProfile::fallback.
///
/// qc_statusBadInput: `def` is invalid, its method can't compute what it requests, or the scene has more than 2^29
/// (536 870 912) triangles. qc_statusDevice and qc_statusDeviceLost: the device failed during `cullide` or `quick`, where auto and `layers` fall back, or while it
/// had the only copy of a body's positions (qcScene_SetVertexBuffer). qc_statusTooManyPairs: see qcDetectDef::maxPairs.
/// qc_statusOutOfMemory.
QC_API qcStatus qcScene_Detect(qcScene* scene, const qcDetectDef* def, const qcResult** result);

/// Begins a step in the background and returns: qcScene_DetectEnd gives its result, the same to the last bit as that of
/// qcScene_Detect. In between the caller's thread is free for other work. The step runs on a thread that belongs to the
/// scene, started by its first call, and on the threads of qcDetectDef::threads; what a device does, on the device's.
///
///     qcScene_SetVertices(scene, id, positions, ...); // and all other input of the step
///     qcScene_DetectBegin(scene, &def);
///     ...                                             // positions may be changed: they were copied
///     qcScene_DetectEnd(scene, &result);
///
/// With one step of latency, a detection runs beside all work of the caller's step. Each result is then that of the
/// previous input, which suits displays, sounds and statistics. It can't keep surfaces apart: contacts come a step
/// after the positions that they belong to.
///
///     if (step != 0)
///         qcScene_DetectEnd(scene, &result);          // pairs of the previous input; used here
///     qcScene_SetVertices(scene, id, positions, ...); // from here on the result is no longer valid
///     qcScene_DetectBegin(scene, &def);
///     ...                                             // the rest of the step, up to the next positions
///
/// - The input is what the scene holds when this function is called. `def` and all arrays given to the scene before
///   have been copied; the caller may change or free them.
/// - The previous result is no longer valid.
/// - Until the end, only these calls may use the scene: qcScene_DetectEnd, qcScene_IsValid, qcScene_GetBodyCount,
///   qcScene_Destroy, which waits for the step and drops its result. All others return qc_statusBadInput, with a
///   message that names the pending step, and change nothing. Other scenes may be used, also with the same device; the
///   device must not be reopened or destroyed.
/// - qcDetectDef::pairFilter, enterStage and leaveStage, the functions of qcSetParallelFor and qcSetLog are called on
///   the scene's thread, or on the one that calls qcScene_DetectEnd: a step that has not started by then runs there.
/// - fork() waits for steps that run; the child process may end them. A callback of the step must not wait for a
///   fork() in another thread.
/// - A recorded scene records a step as if by qcScene_Detect: a replay computes it at once.
///
/// If no thread can be started, the step runs in qcScene_DetectEnd. qc_statusBadInput: as qcScene_Detect, or a step is
/// pending. qc_statusOutOfMemory: nothing has begun.
QC_API qcStatus qcScene_DetectBegin(qcScene* scene, const qcDetectDef* def);
/// Waits for the step that qcScene_DetectBegin began, and gives its status and result. After any failure of the step
/// none is pending, and the scene is as before. qc_statusBadInput: no step is pending, or an argument is null; a
/// pending step then stays pending.
QC_API qcStatus qcScene_DetectEnd(qcScene* scene, const qcResult** result);

#ifdef __cplusplus
}
#endif

#endif
