// What the parts of the manifold stage share: pairs with their sides named, who lies beside whom, raw points.
#ifndef QC_MANIFOLD_MANIFOLD_BUILDER_H
#define QC_MANIFOLD_MANIFOLD_BUILDER_H

#include "manifold/manifold.h"
#include "base/radix_sort.h"
#include "base/union_find.h"
#include "base/vec3.h"
#include "base/worker_results.h"

enum
{
    /// Pairs looked at before and after in a list of pairs that have a triangle and a vertex of the other in common:
    /// enough for a fan of seventeen triangles, and a bound for one of a hundred thousand.
    qc_besideReach = 8,
    /// Pairs beside one that have one of its triangles in common: through each corner of the other.
    qc_maxRing = 3 * 2 * qc_besideReach,
    /// Six corners over a face, nine crossings of edges.
    qc_maxCommonCorners = 15,
    /// Far above the memory of any machine; their places are numbered in 32 bits with room for two more.
    qc_maxManifoldPairs = 1 << 28
};

/// What rounding may do to a length, beside the size of the triangles.
#define QC_MANIFOLD_ROUNDING 1e-9
/// The cosine of 3 degrees: a face lies across a direction. Rounding turns small triangles by more than large ones, but
/// not by more than this.
#define QC_MANIFOLD_FLAT 0.9986
/// What two triangles cover of each other is an area if it is wider than this share of the smaller one's size.
#define QC_MANIFOLD_AREA (1.0 / 64.0)

/// A vertex of some triangle.
typedef struct qcManifoldVertex
{
    uint32_t slot;
    size_t place; ///< among the vertices of both bodies
    qcVector position;
} qcManifoldVertex;

/// The heights of a triangle along a direction.
typedef struct qcHeights
{
    double low, high;
} qcHeights;

/// A triangle that is in some pair. What many pairs ask of it is computed once.
typedef struct qcManifoldTriangle
{
    qcVector corner[3];
    double around[3][6]; ///< the same by axis, twice around: three from anywhere, for lanes
    qcVector normal;     ///< unit; of no length if the triangle is a line or a point
    double longestEdge, doubleArea;
    const qcBody* body;
    uint32_t slot, index;          ///< of the body; in the body
    uint32_t name[3];              ///< vertices of the body
    uint32_t vertex[3];            ///< corners: of those at the same position the number of the first
    uint32_t firstPair, pairCount; ///< its entries in pairsOf
    uint32_t first, count;         ///< its places
    uint32_t heardBy;              ///< the side of a region that knows its heights, while planes are looked for
} qcManifoldTriangle;

/// A pair, as one of its triangles sees it.
typedef struct qcPairSide
{
    uint32_t pair, side;
} qcPairSide;

/// Seen from a point: far from the origin of the world the products would round away what lies between.
static inline qcHeights qcManifoldTriangle_Heights(const qcManifoldTriangle* t, qcVector origin, qcVector direction)
{
    double x = qcDot(qcMinus(t->corner[0], origin), direction);
    double y = qcDot(qcMinus(t->corner[1], origin), direction);
    double z = qcDot(qcMinus(t->corner[2], origin), direction);
    double low = x < y ? x : y, high = x < y ? y : x;
    return (qcHeights){z < low ? z : low, z > high ? z : high};
}

/// The same of a free pair: with what the pairs beside it ask of it, and with those beside it that have this triangle
/// too.
typedef struct qcManifoldPlace
{
    const qcManifoldTriangle* moved; ///< the other triangle
    qcHeights heights;               ///< its, along the normal of this one, from the first corner of this one
    double gap;                      ///< the pair's
    uint32_t pair;
    uint16_t worker;    ///< who found the ring
    uint8_t ringCount;  ///< see qcRing
    uint64_t ringFirst; ///< in the worker's list
} qcManifoldPlace;

/// One reported pair. Side 0 is A, side 1 is B; in a pair of one body with itself the sides may be named the other way
/// round than in the report.
typedef struct qcManifoldPair
{
    const qcManifoldTriangle* side[2];
    uint32_t place[2];
    qcVector normal;   ///< unit, from side 1 towards side 0
    qcVector reported; ///< the pair's own, as it came
    double gap;        ///< the pair's own distance, or minus its depth
    uint32_t region;
    uint32_t source;     ///< of its proximity: the reported pair, or its own number if none was reported
    qcRelation relation; ///< as reported
    bool meets;          ///< touching or penetrating
    bool settled;        ///< a plane parts its region and gives the normal; what follows is false, but for `swapped`
    bool swapped;        ///< side 0 is the report's B
    bool own;            ///< the normal is the one of the report, up to its sign
    bool turned;         ///< the normal was turned around to agree with its region
    bool apart;          ///< before that, side 0 lies above side 1 along it: a fact, not a choice
    bool parted;         ///< the reported normal parts the two triangles
    bool surpassed;      ///< parted, and a pair beside it comes nearer from the same feet
    bool crossing;       ///< penetrating, other than in one plane
} qcManifoldPair;

/// A possible contact point, as one pair sees it.
typedef struct qcRawPoint
{
    qcVector end[2];
    qcVector normal;
    double distance;
    uint32_t pair;
    uint32_t feature[2][2]; ///< see qcManifoldPoint
} qcRawPoint;

/// Where the corners of what a pair's triangles have in common are, and later its points: a worker's.
typedef struct qcPairCorners
{
    uint64_t first;
    uint16_t worker;
    uint8_t count;
} qcPairCorners;

/// What one worker found, and its tables.
typedef struct qcManifoldWorker
{
    qcWorkerResult result;
    qcArray rings;                     ///< of qcRing entries
    qcArray points;                    ///< of qcRawPoint
    qcArray views;                     ///< of qcTriangleView, while points of settled pairs are looked for
    qcArray listOf, lists, fans, seen; ///< while rings are looked for
    bool changed;                      ///< some direction, in this round
} qcManifoldWorker;

/// Room for the points of `pairCount` more pairs. False: this worker has failed, now or before.
static inline bool qcManifoldWorker_ReservePoints(qcManifoldWorker* worker, size_t pairCount)
{
    if (!qcWorkerResult_IsOk(&worker->result))
        return false;
    size_t count = worker->points.count + pairCount * qc_maxCommonCorners;
    return qcWorkerResult_Add(&worker->result,
                              qcArray_Reserve(&worker->points, count, sizeof(qcRawPoint), "contact points"));
}

/// How far side 0 has to move along a direction, and how far against it, until a plane perpendicular to it lies between
/// the two triangles. Below 0: it does already, with so much room.
typedef struct qcWaysOut
{
    double along, against;
} qcWaysOut;

static inline qcWaysOut qcWaysOut_Of(qcHeights side0, qcHeights side1)
{
    return (qcWaysOut){side1.high - side0.low, side0.high - side1.low};
}

/// What rounding may do to the heights of a pair's triangles.
static inline double qcManifoldPair_Rounding(const qcManifoldPair* pair)
{
    return QC_MANIFOLD_ROUNDING * pair->side[0]->longestEdge + QC_MANIFOLD_ROUNDING * pair->side[1]->longestEdge;
}

/// The longest edge of its smaller triangle.
static inline double qcManifoldPair_SmallerSize(const qcManifoldPair* pair)
{
    double a = pair->side[0]->longestEdge, b = pair->side[1]->longestEdge;
    return a < b ? a : b;
}

/// Points farther apart than this are beyond the margin, whatever rounding does.
static inline double qcManifoldPair_Limit(const qcManifoldPair* pair, double margin)
{
    double a = pair->side[0]->longestEdge, b = pair->side[1]->longestEdge;
    return margin * (1.0 + QC_MANIFOLD_ROUNDING) + QC_MANIFOLD_ROUNDING * (a > b ? a : b);
}

/// Do the corners of what a pair's triangles have in common span an area?
bool qcManifoldPair_CoversArea(const qcManifoldPair* pair, const qcRawPoint* corners, int count);

/// What points ask of a region.
typedef struct qcContactRegion
{
    double tolerance; ///< points no farther apart than this are one
    uint32_t pairs;
    bool crossing; ///< some pair is
} qcContactRegion;

/// A region. They are in the order of first pairs.
typedef struct qcPairRegion
{
    uint32_t first; ///< its first pair
    bool meets;     ///< some pair does
    bool settled;   ///< a plane parts it, with this normal
    qcVector normal;
    //  Of those that no plane parts:
    bool unsettled; ///< some pair meets, as far as rounding lets us see
    bool crossing;
    uint32_t fact; ///< its first pair that is apart, or UINT32_MAX
} qcPairRegion;

//  ---- of two bodies ---------------------------------------------------------------------------------------

/// See manifold/overlap_kernels.h.
typedef struct qcOverlapKernels qcOverlapKernels;

/// The manifolds of two bodies, or of one with itself, and what is needed on the way: a thread's.
typedef struct qcManifoldBuilder
{
    qcWorkerResult result;
    qcArray work;      ///< of qcManifoldPair, in the order of the reported pairs
    qcArray triangles; ///< of qcManifoldTriangle: those of the pairs
    qcArray numbers;   ///< of each triangle of both bodies: one more than its place among these; all 0 between builds
    qcArray vertexNumbers;     ///< the same of each vertex
    qcArray vertices, table;   ///< vertices of these triangles, and a hash table by position
    qcArray last;              ///< of a vertex, while regions are joined: one more than an entry of pairsOf
    qcArray freePairs;         ///< of uint32_t: those that no plane settles
    qcArray pairsOf;           ///< of qcPairSide: by triangle, the pairs that it is in
    qcArray places;            ///< of qcManifoldPlace: the same of pairs that are free
    qcArray proximities, feet; ///< of pairs, if the input has none: of those that are free
    qcArray choices, heard;    ///< a normal for each pair, and what it is in the next round
    qcArray nodes;             ///< trees of regions, later of signs
    qcArray regions;           ///< of qcPairRegion
    qcArray planes;            ///< one a region, while planes are looked for
    qcArray parts;             ///< while signs are looked for
    qcArray measured;          ///< of qcContactRegion
    qcArray workers;           ///< of qcManifoldWorker
    qcArray corners;           ///< of qcPairCorners, one a pair
    qcArray raw;               ///< points as the pairs see them, in the order of the pairs
    qcArray firstRaw;          ///< of each pair, and one more
    qcArray witnessed;         ///< bool: what the pair said itself is a point
    qcArray order, scratch;
    qcArray heads, links; ///< a hash table of the points that stay, by place
    qcArray keepers;      ///< of each raw point: the one that stands for it
    qcArray members;      ///< of each keeper: the raw points that it stands for, linked
    //  results of all builds of this step, one after the other; first points count from 0 in each
    qcArray manifolds, points; ///< of qcManifold, of qcManifoldPoint
    int exponent;              ///< of this build: its lengths times 2^exponent are those of the scene
    const qcOverlapKernels* sight;
} qcManifoldBuilder;

/// Where two bodies meet, or one meets itself.
typedef struct qcBodyPairRange
{
    uint32_t firstRun, runCount;
    uint32_t pairCount;
    uint32_t maker;                   ///< who has its manifolds
    size_t firstManifold, firstPoint; ///< there
    size_t manifoldCount, pointCount;
} qcBodyPairRange;

/// What a build looks at.
typedef struct qcMeetingInput
{
    const qcManifoldInput* reported;
    const qcSortItem* runs; ///< see qcAllManifolds
    uint32_t runCount;
    size_t count;                   ///< of pairs
    const qcProximity* proximities; ///< by qcManifoldPair::source
    const qcClosestFeatures* feet;
    double margin;
} qcMeetingInput;

//  ---- the parts, in the order in which they run ------------------------------------------------------------

/// The first failure among the workers of a loop.
qcStatus qcManifoldBuilder_LoopStatus(const qcManifoldBuilder* manifolds);

/// Adds the manifolds of a meeting to the result. On `threads` threads, whose first is the calling one.
qcStatus qcManifoldBuilder_Build(qcManifoldBuilder* manifolds, const qcStepTriangles* triangles,
                                 const qcMeetingInput* input, uint32_t threads);
void qcManifoldBuilder_Free(qcManifoldBuilder* manifolds);

/// Takes the pairs in, with their triangles, and chooses the unit of length: the input's margin follows, and its
/// proximities are dropped where that isn't the scene's.
qcStatus qcManifoldBuilder_TakePairs(qcManifoldBuilder* manifolds, const qcStepTriangles* triangles,
                                     qcMeetingInput* input);
/// Joins neighbours to regions.
qcStatus qcManifoldBuilder_JoinRegions(qcManifoldBuilder* manifolds);
/// Settles the regions that one plane parts. Lists the pairs of the others: they are free.
qcStatus qcManifoldBuilder_FindPlanes(qcManifoldBuilder* manifolds, double margin);
/// What the free pairs say themselves. Fills what the input lacks.
qcStatus qcManifoldBuilder_AskPairs(qcManifoldBuilder* manifolds, qcMeetingInput* input, uint32_t threads);
/// Lists which free pairs lie beside which.
qcStatus qcManifoldBuilder_FindRings(qcManifoldBuilder* manifolds, uint32_t threads);
/// The direction of each free pair, looked at with its neighbourhood, and the corners of what its triangles have in
/// common along it.
qcStatus qcManifoldBuilder_ChooseNormals(qcManifoldBuilder* manifolds, const qcMeetingInput* input, uint32_t threads);
/// Their signs, looked at in each region.
qcStatus qcManifoldBuilder_ChooseSigns(qcManifoldBuilder* manifolds, const qcMeetingInput* input);
/// Regions that one short push would free: no pair is told of a much longer way.
qcStatus qcManifoldBuilder_FindEscapes(qcManifoldBuilder* manifolds, double margin);
/// From corners to points.
qcStatus qcManifoldBuilder_FindPoints(qcManifoldBuilder* manifolds, const qcMeetingInput* input, uint32_t threads);
qcStatus qcManifoldBuilder_MergePoints(qcManifoldBuilder* manifolds);
/// Of flat patches between rigid bodies only the corners stay.
void qcManifoldBuilder_DropBetween(qcManifoldBuilder* manifolds);
/// Reduces the order to the points that stay: by region, in each by the distance that is reported; points of equal
/// distance stay in the order in which they were merged.
qcStatus qcManifoldBuilder_OrderKept(qcManifoldBuilder* manifolds);

/// Do two points say the same of the same place: one end of theirs nearly the same, and their normals too? Then only
/// the deeper one counts; the other is the same feature found from another triangle, or lies behind it.
static inline bool qcRawPoint_AreSame(const qcRawPoint* p, const qcRawPoint* q, double tolerance)
{
    qcVector d = qcMinus(p->end[0], q->end[0]), e = qcMinus(p->end[1], q->end[1]);
    double limit = tolerance * tolerance;
    // 30 degrees: a corner on a floor and against a wall is two contacts.
    return (qcDot(d, d) <= limit || qcDot(e, e) <= limit) && qcDot(p->normal, q->normal) >= 0.866;
}

static inline qcManifoldPair* qcManifoldBuilder_Pair(const qcManifoldBuilder* manifolds, uint32_t pair)
{
    return &QC_AT(qcManifoldPair, manifolds->work, pair);
}

/// A triangle of a pair. The pairs see their triangles as constant; these are the stage's own.
static inline qcManifoldTriangle* qcManifoldBuilder_Triangle(const qcManifoldBuilder* manifolds,
                                                             const qcManifoldPair* pair, uint32_t side)
{
    const qcManifoldTriangle* first = manifolds->triangles.data;
    return &QC_AT(qcManifoldTriangle, manifolds->triangles, pair->side[side] - first);
}

/// The number of a free pair.
static inline uint32_t qcManifoldBuilder_FreePair(const qcManifoldBuilder* manifolds, size_t i)
{
    return QC_AT(uint32_t, manifolds->freePairs, i);
}

static inline qcPairRegion* qcManifoldBuilder_PairRegion(const qcManifoldBuilder* manifolds, const qcManifoldPair* pair)
{
    return &QC_AT(qcPairRegion, manifolds->regions, pair->region);
}

/// The raw points of a pair that a worker holds.
static inline qcRawPoint* qcManifoldBuilder_Corners(const qcManifoldBuilder* manifolds, uint32_t pair)
{
    const qcPairCorners* corners = &QC_AT(qcPairCorners, manifolds->corners, pair);
    return &QC_AT(qcRawPoint, QC_AT(qcManifoldWorker, manifolds->workers, corners->worker).points, corners->first);
}

/// Corners of what the two triangles of a pair have in common seen along a direction: see qcOverlapKernels.
int qcManifoldBuilder_FindCommonPart(const qcManifoldBuilder* manifolds, const qcManifoldPair* pair, qcVector normal,
                                     qcRawPoint corners[qc_maxCommonCorners]);

//  ---- who lies beside whom --------------------------------------------------------------------------------

/// The pairs beside a pair that have its triangle of one side too, and whose other triangles share a vertex. Each once.
/// Of fans too large for qc_besideReach some are left out.
typedef struct qcRing
{
    const uint32_t* entries;
    uint32_t count;
} qcRing;

static inline qcRing qcManifoldBuilder_Ring(const qcManifoldBuilder* manifolds, const qcManifoldPair* pair, int side)
{
    const qcManifoldPlace* place = &QC_AT(qcManifoldPlace, manifolds->places, pair->place[side]);
    const qcArray* rings = &QC_AT(qcManifoldWorker, manifolds->workers, place->worker).rings;
    return (qcRing){(const uint32_t*)rings->data + place->ringFirst, place->ringCount};
}

enum
{
    qc_ringOne = 1 << 2, ///< of a place's number
    qc_ringShared = 3    ///< the number of shared vertices
};

/// A pair in a ring, as the common triangle sees it.
static inline const qcManifoldPlace* qcManifoldBuilder_Beside(const qcManifoldBuilder* manifolds, uint32_t entry)
{
    return &QC_AT(qcManifoldPlace, manifolds->places, entry / qc_ringOne);
}

#endif
