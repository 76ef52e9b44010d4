// First stage: the reported pairs of two bodies (or of one with itself), their triangles with welded vertices, and the
// connected regions of contact.
#ifndef QC_MANIFOLD_TOPOLOGY_H
#define QC_MANIFOLD_TOPOLOGY_H

#include "manifold/manifold.h"
#include "base/radix_sort.h"
#include "base/two_doubles.h"
#include "base/vec3.h"

/// Rounding error of a length, as a share of the size of the triangles.
#define QC_MANIFOLD_ROUNDING 1e-9
/// The cosine of 3 degrees: a face is perpendicular to a direction. Rounding turns small triangles by more than large
/// ones, but not by more than this.
#define QC_MANIFOLD_FLAT 0.9986
/// A projected overlap is an area if it is wider than this share of the smaller triangle's size.
#define QC_MANIFOLD_AREA (1.0 / 64.0)

/// Two bodies, or one with itself, and their reported pairs.
typedef struct qcBodyPairInput
{
    const qcManifoldInput* reported;
    const qcSortItem* runs; ///< see qcAllManifolds
    uint32_t runCount;
    size_t pairCount;
} qcBodyPairInput;

/// A vertex of a triangle of the pairs.
typedef struct qcManifoldVertex
{
    uint32_t slot;
    size_t index; ///< among the vertices of both bodies
    qcVector position;
} qcManifoldVertex;

/// A triangle of at least one pair, with the data that all its pairs share.
typedef struct qcManifoldTriangle
{
    qcVector corner[3];
    double cornerLanes[3][6]; ///< by axis, the corners twice in a row: three consecutive ones from any corner on
    qcVector normal;          ///< unit; zero if the triangle is a line or a point
    double longestEdge, doubleArea;
    const qcBody* body;
    uint32_t slot, index;          ///< of the body; in the body
    uint32_t bodyVertex[3];        ///< vertices of the body
    uint32_t vertex[3];            ///< welded: vertices at the same position have one number
    uint32_t firstPair, pairCount; ///< its entries in qcContactTopology::pairsOf
} qcManifoldTriangle;

/// One reported pair. Side 0 is A, side 1 is B; in a pair of one body with itself the sides may be exchanged, so that
/// all pairs of a region name them alike.
typedef struct qcManifoldPair
{
    const qcManifoldTriangle* side[2];
    uint32_t region;
    uint32_t source;     ///< of its proximity: the reported pair, or its own number if none was reported
    qcRelation relation; ///< as reported
    bool intersecting;   ///< touching or penetrating
    bool swapped;        ///< side 0 is the report's B
} qcManifoldPair;

/// A pair in the list of one of its triangles. The side is that before regions are joined.
typedef struct qcPairEntry
{
    uint32_t pair, side;
} qcPairEntry;

typedef struct qcContactTopology
{
    qcArray pairs;        ///< of qcManifoldPair, in the order of the reported pairs
    qcArray triangles;    ///< of qcManifoldTriangle: those of the pairs
    qcArray vertices;     ///< of qcManifoldVertex: those of the triangles
    qcArray pairsOf;      ///< of qcPairEntry: by triangle, its pairs in their order
    uint32_t regionCount; ///< regions are in the order of their first pairs
    int exponent;         ///< lengths of this build times 2^exponent are those of the scene
    //  scratch
    qcArray triangleNumbers; ///< of each triangle of both bodies: its number here plus 1; all 0 between builds
    qcArray vertexNumbers;   ///< likewise of each vertex
    qcArray hashTable;       ///< of vertices by position: their numbers plus 1
    qcArray welded;          ///< of each vertex: the first one at its position
    qcArray nodes;           ///< of each pair: see base/union_find.h
    qcArray lastEntry;       ///< of each vertex: the last pair found there, as an index of pairsOf plus 1
} qcContactTopology;

/// Gathers the pairs, their triangles and vertices, and chooses the unit of length. Neighbours within one body that
/// touch are no contact and are left out: the result may have no pair.
qcStatus qcContactTopology_Gather(const qcStepTriangles* triangles, const qcBodyPairInput* input,
                                  qcContactTopology* topology);
/// Joins pairs to connected regions.
qcStatus qcContactTopology_JoinRegions(qcContactTopology* topology);
void qcContactTopology_Free(qcContactTopology* topology);

static inline const qcManifoldPair* qcContactTopology_Pair(const qcContactTopology* topology, uint32_t pair)
{
    return &QC_AT(const qcManifoldPair, topology->pairs, pair);
}

/// The number of a triangle of a pair.
static inline size_t qcContactTopology_TriangleOf(const qcContactTopology* topology, const qcManifoldTriangle* triangle)
{
    return (size_t)(triangle - (const qcManifoldTriangle*)topology->triangles.data);
}

/// The longest edge of its smaller triangle.
static inline double qcManifoldPair_SmallerSize(const qcManifoldPair* pair)
{
    double a = pair->side[0]->longestEdge, b = pair->side[1]->longestEdge;
    return a < b ? a : b;
}

/// Rounding error of the heights of a pair's triangles.
static inline double qcManifoldPair_Rounding(const qcManifoldPair* pair)
{
    return QC_MANIFOLD_ROUNDING * pair->side[0]->longestEdge + QC_MANIFOLD_ROUNDING * pair->side[1]->longestEdge;
}

/// Points at a larger distance are beyond the margin in spite of rounding.
static inline double qcManifoldPair_Limit(const qcManifoldPair* pair, double margin)
{
    double a = pair->side[0]->longestEdge, b = pair->side[1]->longestEdge;
    return margin * (1.0 + QC_MANIFOLD_ROUNDING) + QC_MANIFOLD_ROUNDING * (a > b ? a : b);
}

//  ---- heights along a direction ---------------------------------------------------------------------------

typedef struct qcHeightRange
{
    double low, high;
} qcHeightRange;

/// The heights of two consecutive corners of a triangle's cornerLanes.
static inline qcTwoDoubles qcTwoHeights(const double lanes[3][6], int first, qcVector origin, qcVector direction)
{
    return (qcTwoDoubles_Load(lanes[0] + first) - qcTwoDoubles_Both(origin.x)) * qcTwoDoubles_Both(direction.x) +
           (qcTwoDoubles_Load(lanes[1] + first) - qcTwoDoubles_Both(origin.y)) * qcTwoDoubles_Both(direction.y) +
           (qcTwoDoubles_Load(lanes[2] + first) - qcTwoDoubles_Both(origin.z)) * qcTwoDoubles_Both(direction.z);
}

/// The heights are relative to `origin`: far from the origin of the world products would round away the differences.
static inline qcHeightRange qcManifoldTriangle_Heights(const qcManifoldTriangle* t, qcVector origin, qcVector direction)
{
    qcTwoDoubles first = qcTwoHeights(t->cornerLanes, 0, origin, direction);
    qcTwoDoubles last = qcTwoHeights(t->cornerLanes, 1, origin, direction);
    qcTwoDoubles low = qcTwoDoubles_Min(first, last), high = qcTwoDoubles_Max(first, last);
    return (qcHeightRange){low[0] < low[1] ? low[0] : low[1], high[0] > high[1] ? high[0] : high[1]};
}

/// Separation distances: how far side 0 has to move along a direction, and against it, until a plane perpendicular to
/// the direction lies between the two triangles. Below 0: minus the room between them.
typedef struct qcSeparation
{
    double along, against;
} qcSeparation;

static inline qcSeparation qcSeparation_Of(qcHeightRange side0, qcHeightRange side1)
{
    return (qcSeparation){side1.high - side0.low, side0.high - side1.low};
}

/// `origin`: see qcManifoldTriangle_Heights.
static inline qcSeparation qcManifoldPair_Separation(const qcManifoldPair* pair, qcVector origin, qcVector direction)
{
    return qcSeparation_Of(qcManifoldTriangle_Heights(pair->side[0], origin, direction),
                           qcManifoldTriangle_Heights(pair->side[1], origin, direction));
}

/// How far side 0 has to move along a direction until the pair is separated.
static inline double qcManifoldPair_LengthAlong(const qcManifoldPair* pair, qcVector direction)
{
    return qcManifoldPair_Separation(pair, pair->side[1]->corner[0], direction).along;
}

#endif
