// A scene holds bodies, each a triangle soup, and answers which of their triangles meet.
//
//     qcScene* scene;                              qcSceneDef sceneDef = qcDefaultSceneDef();
//     qcScene_Create(&sceneDef, &scene);           qcBodyDef bodyDef = qcDefaultBodyDef();
//     bodyDef.positions = ...;                     qcScene_AddBody(scene, &bodyDef, &id);
//     qcDetectDef def = qcDefaultDetectDef();      qcScene_Detect(scene, &def, &result);
//
// Thread-safety: a scene belongs to one thread at a time; two scenes are independent, also when they
// share a device.
#ifndef QUICKCULLIDE_SCENE_H
#define QUICKCULLIDE_SCENE_H

#include "device.h"

#include <math.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct qcScene qcScene;

typedef struct qcSceneDef
{
    uint32_t structSize;
    /// Draws for the methods that need GL; null is the same as a device of kind none.
    /// Must outlive the scene.
    qcDevice* device;
} qcSceneDef;

static inline qcSceneDef qcDefaultSceneDef(void)
{
    qcSceneDef def;
    def.structSize = (uint32_t)sizeof(qcSceneDef);
    def.device = NULL;
    return def;
}

QC_API qcStatus qcScene_Create(const qcSceneDef* def, qcScene** scene);
/// Null is allowed.
QC_API void qcScene_Destroy(qcScene* scene);

//  ---- geometry in ---------------------------------------------------------------------------------

/// Names a body for as long as it lives: an id of a removed body is refused, also after its slot is
/// taken again. All zero is no body.
typedef struct qcBodyId
{
    /// A small number, reused after a removal; results name bodies by it. First body: 0.
    uint32_t slot;
    /// 1 or more.
    uint32_t generation;
} qcBodyId;

typedef enum qcPositionType
{
    qc_positionF32 = 0, ///< three floats
    qc_positionF64 = 1  ///< three doubles
} qcPositionType;

typedef enum qcActivity
{
    qc_activityMoving = 0,
    /// A pair of two sleeping bodies is skipped, and so are both with themselves.
    qc_activitySleeping = 1,
    /// As sleeping; and a static body is skipped with a sleeping one too.
    qc_activityStatic = 2
} qcActivity;

/// World position = linear * local position + translation, computed in double, in this order, without
/// contraction. The result is what "exact" refers to.
typedef struct qcTransform
{
    double linear[9]; ///< row by row
    double translation[3];
} qcTransform;

static inline qcTransform qcIdentityTransform(void)
{
    qcTransform t = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    return t;
}

/// A triangle soup. Everything is copied; nothing is kept of the caller's memory.
typedef struct qcBodyDef
{
    uint32_t structSize;
    /// `vertexCount` positions, `positionStride` bytes apart (0: tightly packed).
    const void* positions;
    qcPositionType positionType;
    size_t positionStride;
    uint32_t vertexCount;
    /// 3 * `triangleCount` vertex indices, each below `vertexCount`.
    const uint32_t* indices;
    uint32_t triangleCount;
    /// Deforming bodies get new vertices (world space) each step; rigid ones a new transform.
    bool deforming;
    /// Rigid bodies: from local to world space.
    qcTransform transform;
    qcActivity activity;
    /// Two bodies meet if (a.group & b.mask) and (b.group & a.mask) are both other than 0.
    uint32_t group;
    uint32_t mask;
    /// Bodies of one owner never meet each other: parts of one rigid thing, say. A body meets itself as ever. 0: none.
    uint32_t owner;
    /// Report triangles of this body that meet each other.
    bool selfCollision;
    /// What this body has use for of a step's margins (qcDetectDef): of two bodies, or of one with itself, pairs and
    /// contacts count that are no further apart than the sum of both margins. 0 or more, infinite by default.
    double margin;
} qcBodyDef;

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

/// Adds a body. qc_statusBadInput names the index out of range or the vertex that is not finite.
QC_API qcStatus qcScene_AddBody(qcScene* scene, const qcBodyDef* def, qcBodyId* id);
QC_API qcStatus qcScene_RemoveBody(qcScene* scene, qcBodyId id);
/// Moves a rigid body.
QC_API qcStatus qcScene_SetTransform(qcScene* scene, qcBodyId id, const qcTransform* transform);
/// Gives a deforming body new positions, as many as it has vertices.
QC_API qcStatus qcScene_SetVertices(qcScene* scene, qcBodyId id, const void* positions, qcPositionType type,
                                    size_t stride);
QC_API qcStatus qcScene_SetActivity(qcScene* scene, qcBodyId id, qcActivity activity);
QC_API qcStatus qcScene_SetFilter(qcScene* scene, qcBodyId id, uint32_t group, uint32_t mask);
QC_API qcStatus qcScene_SetSelfCollision(qcScene* scene, qcBodyId id, bool selfCollision);
/// See qcBodyDef::margin.
QC_API qcStatus qcScene_SetMargin(qcScene* scene, qcBodyId id, double margin);
QC_API bool qcScene_IsValid(const qcScene* scene, qcBodyId id);
QC_API uint32_t qcScene_GetBodyCount(const qcScene* scene);

//  ---- pairs and contacts out ----------------------------------------------------------------------

typedef enum qcMethod
{
    /// The planner chooses among the methods that never miss: `layers` on the device where that is measured to be
    /// quicker, `sweep` for the rest. The answer is the same.
    qc_methodAuto = 0,
    /// Every pair of triangles through the exact test: O(n^2).
    qc_methodBrute = 1,
    /// CULLIDE, 2003: image precision, misses what falls between samples. Needs GL.
    qc_methodCullide = 2,
    /// Quick-CULLIDE, VR 2005: as above with its four sets. Needs GL.
    qc_methodQuick = 3,
    /// Object space on the CPU.
    qc_methodSweep = 4,
    /// Image space made exact: conservative coverage, depth intervals, a list per pixel and slice. Needs GL with
    /// compute shaders.
    qc_methodLayers = 5
} qcMethod;

/// "auto", "brute", "cullide", "quick", "sweep", "layers".
QC_API const char* qcMethod_Name(qcMethod method);

typedef enum qcRelation
{
    qc_relationDisjoint = 0,
    /// The closed triangles meet, but only in boundary points of one of them.
    qc_relationTouching = 1,
    /// Their relative interiors meet.
    qc_relationPenetrating = 2,
    /// They don't meet, but are no further apart than the margin that was asked for.
    qc_relationNear = 3
} qcRelation;

/// "disjoint", "touching", "penetrating", "near".
QC_API const char* qcRelation_Name(qcRelation relation);

/// The exact relation of two triangles, nine doubles each (corner by corner), degenerate ones included.
/// Exact for any finite coordinates; O(1). Any thread.
QC_API qcRelation qcRelateTriangles(const double* a, const double* b);

/// Where two triangles come nearest, and how to part them where they meet.
typedef struct qcProximity
{
    /// In A and in B; the same point, of A ∩ B, where they meet.
    double pointA[3], pointB[3];
    /// Unit vector, from B towards A: along it A moves away from B. Pairs that are apart: from pointB to pointA. Pairs
    /// that meet: the direction in which the least move parts them, of a face rather than of edges where both do.
    double normal[3];
    /// 0 where they meet; infinity beyond the largest double.
    double distance;
    /// How far A has to move along the normal until it only touches B: the least such move over the directions of the
    /// separating axes (both faces, nine edge pairs). 0 unless they penetrate, and for coplanar triangles.
    double depth;
} qcProximity;

/// Is the distance of two triangles at most `margin`? Exact for any finite coordinates and margin >= 0; O(1). False for
/// a margin below 0 or NaN. `proximity` (may be null) is filled when the answer is yes: rounded in double, distance,
/// depth and points to 1e-12 of the triangles' extent, however far from the origin they lie, the normal to 1e-15 times
/// extent / distance. Exchanging A and B gives the mirror image to the last bit, opposite normals too. If A and B are
/// equal corner by corner there is nothing to exchange: both orders have the same normal. Any thread.
QC_API bool qcTrianglesWithin(const double* a, const double* b, double margin, qcProximity* proximity);

/// Are the triangles of two different bodies, named by their slots, of interest? Has to say the same of a pair for as
/// long as the call takes that asks, and not to call the scene; may be asked on several threads, and more than once.
typedef bool (*qcPairFilter)(void* context, uint32_t slotA, uint32_t slotB);

typedef struct qcDetectDef
{
    uint32_t structSize;
    qcMethod method;
    /// Report all pairs no further apart than this, in scene units, touching ones too: decided exactly. 0: pairs that
    /// meet. `cullide` and `quick` refuse it unless `reliable` is set.
    double margin;
    /// Report touching pairs too.
    bool touching;
    /// Test triangles of one body that share a vertex index too.
    bool neighbours;
    /// Compute the intersection segment of each penetrating pair.
    bool segments;
    /// Compute closest points, distance and depth of each reported pair.
    bool proximities;
    /// Merge the reported pairs of two bodies, or of a body with itself, into clean contact points.
    bool manifolds;
    /// 0: no contacts. Otherwise also report contacts between features (vertex and face, edge and edge)
    /// of two triangles no further apart than this, in scene units. Not `cullide` and `quick`.
    double contactMargin;
    /// Of the contacts between a deforming body and a rigid one report only those at points of the rigid body to which
    /// no point around them is nearer: what keeps the deforming body off these keeps it off the others.
    bool nearestContacts;
    /// Leaves pairs of bodies out, beside what the bodies' own groups and owners do. Null: none. With a filter a step
    /// is computed anew even if nothing moved.
    qcPairFilter pairFilter;
    void* pairFilterContext;
    /// Threads to use; 0: one per core, or as many as qcSetParallelFor was given. The result does not depend on it.
    uint32_t threads;
    //  What follows speaks to `layers` only; it changes the cost, never the answer.
    /// Pixels on a side of the image, rounded down to a power of two, up to 4096; 0: from the triangles' sizes.
    uint32_t layerColumns;
    /// 'x', 'y' or 'z': the axis that the image looks along; 0: the one along which the scene is thinnest. One view is
    /// all it takes: intervals are compared along all axes at once, so that a further view has nothing left to cut.
    char layerDepthAxis;
    /// Measure the parts of a step of `layers`: see qcProfile::layerTimes. Costs some microseconds; off, nothing.
    bool layerTimes;
    //  What follows speaks to `cullide` and `quick` only.
    /// Axes to look along, in this order: 1 to 3 different letters of "xyz", ended by a zero.
    char views[4];
    /// Pixels on a side, 1..4096; the device's limit where that is lower.
    uint32_t resolution;
    /// Rounds over the views; 0: until nothing changes.
    uint32_t iterations;
    //  Beyond the paper; all off is the paper.
    /// Draw back to front along the view: what lies in front is drawn last, and is fully visible more often. Each view
    /// has its own order, and so its own sets.
    bool backToFront;
    /// Reverse the depth comparison in the second pass: fully behind is as good a separating surface as fully in front.
    /// Pays back to front; in another order it prunes less than without.
    bool secondPassFromBack;
    /// Grow each primitive by half a pixel and by half the margin in x, y and z before it is drawn and tested: nothing
    /// is missed, at any resolution. For bodies and for triangles of different bodies; self-collision is left to the
    /// sweep, since neighbours, grown, meet in every view.
    bool reliable;
} qcDetectDef;

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
    return def;
}

/// bodyA, triangleA < bodyB, triangleB, in dictionary order; pairs are sorted by the four numbers.
typedef struct qcPair
{
    uint32_t bodyA, triangleA; ///< slot of the body, index of the triangle in it
    uint32_t bodyB, triangleB;
    qcRelation relation;
} qcPair;

/// Ends of A ∩ B in world space, rounded; where coplanar triangles overlap, its two farthest corners.
/// Zeros for pairs that only touch.
typedef struct qcSegment
{
    double p[3], q[3];
} qcSegment;

typedef struct qcTriangleRef
{
    uint32_t body, triangle;
} qcTriangleRef;

/// Two features within the contact margin that share no vertex. The closest points are the sums of the
/// named vertices by weight: vertex-face has weightsA = {1, 0, 0}, edge-edge a zero third weight in both.
/// Each pair of features is reported once, however many triangles share it. Rounded in double; lengths of 1e-70 to
/// 1e70.
typedef struct qcContact
{
    uint32_t bodyA, bodyB; ///< slots
    uint32_t verticesA[3], verticesB[3];
    double weightsA[3], weightsB[3];
    /// Unit vector from B's point to A's; the face's or the edges' normal where they coincide.
    double normal[3];
    double distance; ///< 0 or more, scene units
} qcContact;

/// One clean contact point: what several pairs of triangles say of the same place, once. A corner of what two triangles
/// have in common, seen along the normal: a vertex over a face, or two edges that cross.
typedef struct qcManifoldPoint
{
    /// One over the other: pointA = pointB + distance * normal, rounded.
    double pointA[3], pointB[3];
    /// Unit vector, from B towards A. Neighbouring points agree: none points back into what another one parts, unless
    /// the triangles of both are apart and really lie so, as a sheet in a slit does.
    double normal[3];
    /// At most the margin. Below 0: penetration depth, here. Where bodies touch it is rounding, and where they overlap
    /// by a small share of their triangles, within the margin, a small multiple of the overlap at most; of larger
    /// overlaps it may be more.
    double distance;
    uint32_t triangleA, triangleB; ///< of the pair that it was taken from
    /// What touches, by vertex index: {v, v} a vertex, {v, w} with v < w an edge, {UINT32_MAX, UINT32_MAX} the face of
    /// the triangle. A point with the same features as one of the step before is the same contact.
    uint32_t featureA[2], featureB[2];
} qcManifoldPoint;

/// The contact points of one connected region of contact of two bodies, or of a body with itself: pairs of triangles
/// are connected if they have one triangle in common and the other two share a vertex. Vertices at the same position
/// count as shared. No two points are at the same place with the same normal: nearer than 1/64 of the triangles' size.
/// Each pair has a point, or one beside it has, or lies in a flat patch between two bodies that don't deform: of that
/// only the corners are reported. Where the two stand flat and one plane parts the whole region, all points have its
/// normal, and hold it for every pair. In a body with itself A and B are the two sides of the region, each triangleA
/// connected with the others, whichever has the lower index.
///
/// Coordinates may be of any size. Triangles in contact must not be smaller than 1e-50 of the largest coordinate of the
/// triangles that the two bodies have in contact: below, rounding may turn normals and drop points.
typedef struct qcManifold
{
    uint32_t bodyA, bodyB;           ///< slots, bodyA <= bodyB
    uint32_t firstPoint, pointCount; ///< sorted by distance, the deepest first; at least one
} qcManifold;

typedef enum qcCullLevel
{
    qc_levelObjects = 0,   ///< bodies against bodies
    qc_levelTriangles = 1, ///< triangles against the triangles of other bodies
    qc_levelSelf = 2       ///< triangles of one body against each other
} qcCullLevel;

/// One pass of one view of the visibility culling: what it cost, and the sets after it (section 4.1).
typedef struct qcPassRecord
{
    qcCullLevel level;
    uint32_t body;               ///< slot; qc_levelSelf only
    char axis;                   ///< 'x', 'y' or 'z'
    uint32_t iteration, pass;    ///< from 1; pass 1 or 2
    uint32_t queries, rendered;  ///< primitives tested, primitives drawn into the depth buffer
    uint32_t bfv, ffv, sfv, nfv; ///< set sizes after the pass; bfv counts from the start of the level
    uint32_t pcs;                ///< ffv + sfv + nfv
} qcPassRecord;

/// A part of a step of `layers`.
typedef struct qcLayerTime
{
    const char* name; ///< "upload", "boxes"; static
    /// Wall-clock milliseconds of the threads that run the part in turn, the calling one or the device's; for a kernel,
    /// of starting it. Below 0: the part did not run.
    double threadMs;
    /// Milliseconds between timestamps of the device (GL_TIMESTAMP). Below 0: the part did not run there, or the device
    /// has no timestamps. Of "counters" and "results", which are read back, it is that of the last measured step
    /// before: no step waits for its own last timestamps.
    double deviceMs;
} qcLayerTime;

/// What a step did, in the order of the line of data. Times are wall-clock milliseconds.
typedef struct qcProfile
{
    qcMethod method;    ///< what ran; never qc_methodAuto: `layers` as soon as the device answered for a part
    const char* device; ///< name of the device that was used; "none" when the CPU answered alone
    /// Why another method than the requested one ran, or null. A device that failed in several steps, one after
    /// another, is not tried in each of the following ones, but again after 2, 4, 8 and at most 128 steps.
    const char* fallback;
    /// The last result was still right and is given again; all counters are those of that step.
    bool reused;

    double planMs, cullObjectsMs, sweepObjectsMs, cullTrianglesMs, sweepTrianglesMs, exactMs, contactMs, manifoldMs,
        totalMs;

    uint32_t bodies, triangles;
    uint32_t parts;             ///< groups of bodies that can meet; counted where the device may take some
    uint32_t partsOnDevice;     ///< of these, answered by `layers`; the sweep answered the others
    uint32_t objectPcs;         ///< bodies left after object-level culling
    uint64_t bodyPairs;         ///< pairs of bodies whose boxes overlap and that may meet
    uint32_t selfBodies;        ///< bodies tested with themselves
    uint32_t trianglePcs;       ///< triangles left before the sweep over triangles
    uint64_t candidates;        ///< pairs of triangles that reached the exact test, or were proven before
    uint64_t filterHits;        ///< of these, pairs that single precision has proven to penetrate
    uint64_t exactFallbacks;    ///< and pairs that double precision could not decide
    uint64_t pairs, contacts;   ///< reported
    uint32_t resolution;        ///< used; 0: no image
    uint64_t queries, rendered; ///< sums over the passes
    /// Of the image of `layers`, whose pixels are cut into slices of depth; 0: none.
    uint32_t columns, rows, slices;
    uint64_t fragments;     ///< entries of its lists
    uint64_t listPairs;     ///< pairs of entries whose intervals overlap in all axes, neighbours left out
    uint32_t reruns;        ///< times a device buffer was too small, grew, and the step ran again
    uint64_t uploadedBytes; ///< to the device in this step
    uint64_t deviceBytes;   ///< held on the device
    /// All parts of the step of `layers`, in the order of the work, also those that did not run; valid as long as the
    /// result: prepare, hand-over (to the device's thread), upload, vertices, boxes, clear (lists), nodes, node pairs,
    /// cluster pairs, triangle pairs, filter, counters (the wait for the device, and how much it found), results,
    /// hand-back, refine (on the processor). They are parts of cullTrianglesMs. Empty unless qcDetectDef::layerTimes is
    /// set.
    const qcLayerTime* layerTimes;
    size_t layerTimeCount;
    bool softwareDevice; ///< the device draws on the CPU
    const qcPassRecord* passes;
    size_t passCount;

    //  Skips.
    uint64_t skippedStaticPairs;   ///< overlapping pairs of bodies at rest
    uint64_t skippedFilteredPairs; ///< overlapping pairs whose groups don't meet, or of one owner
    uint64_t skippedSetPairs;      ///< overlapping pairs inside one collision-free set (lemma 2)
    uint32_t skippedBodies;        ///< bodies that overlap nothing and are not tested with themselves
    uint32_t skippedTriangles;     ///< triangles outside the overlaps of their body's box with others
    uint64_t skippedSetCandidates; ///< triangle pairs inside one collision-free set
    uint64_t skippedNeighbours;    ///< triangle pairs that share a vertex index
    uint64_t fittedTriangles;      ///< of bodies whose boxes the sweep had to make anew: not of those that didn't move
    uint64_t followedTriangles;    ///< of bodies of which the sweep looked at what moved a little since, and no more
    uint64_t flatTriangles;        ///< inside patches that were proven not to come near themselves
} qcProfile;

/// Owned by the scene; valid until the next call on this scene that changes it or detects again.
typedef struct qcResult
{
    const qcPair* pairs;
    size_t pairCount;
    /// pairCount segments, or null if they were not asked for.
    const qcSegment* segments;
    /// pairCount proximities, or null if they were not asked for.
    const qcProximity* proximities;
    /// The potentially colliding set: triangles that reach the sweep over triangles (`cullide`, `quick`)
    /// or that are in a candidate pair (the others); sorted.
    const qcTriangleRef* pcs;
    size_t pcsCount;
    const qcContact* contacts;
    size_t contactCount;
    /// Sorted by bodies; empty if they were not asked for.
    const qcManifold* manifolds;
    size_t manifoldCount;
    const qcManifoldPoint* manifoldPoints;
    size_t manifoldPointCount;
    qcProfile profile;
} qcResult;

/// Runs the line of data once. O(n log n + candidates) for `sweep`.
QC_API qcStatus qcScene_Detect(qcScene* scene, const qcDetectDef* def, const qcResult** result);

#ifdef __cplusplus
}
#endif

#endif
