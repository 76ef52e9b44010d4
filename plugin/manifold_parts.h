// What the parts of the manifold stage share: pairs with their sides named, who lies beside whom, raw points.
#ifndef QC_PLUGIN_MANIFOLD_PARTS_H
#define QC_PLUGIN_MANIFOLD_PARTS_H

#include "manifold.h"
#include "vector.h"

enum
{
    /// Keys of a pair: each triangle with each corner of the other.
    qc_besideKeys = 6,
    /// Pairs looked at before and after in a list of pairs that have a key in common: enough for a fan of seventeen
    /// triangles, and a bound for one of a hundred thousand.
    qc_besideReach = 8,
    qc_maxRing = qc_besideKeys * 2 * qc_besideReach,
    /// Six corners over a face, nine crossings of edges.
    qc_maxCommonCorners = 15,
    /// Far above the memory of any machine; pairs are numbered in 32 bits with room for their keys.
    qc_maxManifoldPairs = 1 << 28
};

/// What rounding may do to a length, beside the size of the triangles.
#define QC_MANIFOLD_ROUNDING 1e-9

/// A vertex of one body, or several at one position.
typedef struct qcManifoldVertex
{
    uint32_t slot;
    qcVector position;
} qcManifoldVertex;

/// One reported pair. Side 0 is A, side 1 is B; in a pair of one body with itself the sides may be named the other way
/// round than in the report.
typedef struct qcManifoldPair
{
    const qcBody* body[2];
    uint32_t slot[2], triangle[2];
    uint32_t vertex[2][3];            ///< corners: the numbers of their positions among those of all pairs
    const qcManifoldVertex* vertices; ///< of these numbers; null: not numbered yet
    qcVector normal;                  ///< unit, from side 1 towards side 0
    qcVector reported;                ///< the pair's own, as it came
    double gap;                       ///< the pair's own distance, or minus its depth
    uint32_t region;                  ///< its first pair; later its number
    uint32_t source;                  ///< the reported pair
    bool swapped;                     ///< side 0 is the report's B
    bool own;                         ///< the normal is the one of the report, up to its sign
    bool turned;                      ///< the normal was turned around to agree with its region
    bool apart;                       ///< before that, side 0 lies above side 1 along it: a fact, not a choice
    bool parted;                      ///< the reported normal parts the two triangles
    bool surpassed;                   ///< parted, and a pair beside it comes nearer from the same feet
    bool crossing;                    ///< penetrating, other than in one plane
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

static inline void qcManifoldPair_GetCorners(const qcManifoldPair* pair, int side, qcVector corner[3])
{
    double position[3][3];
    // Rigid bodies would have to be transformed again and again.
    if (pair->vertices == NULL)
        qcBody_GetTriangle(pair->body[side], pair->triangle[side], position);
    for (int c = 0; c < 3; c++)
        corner[c] =
            pair->vertices == NULL ? qcVector_Load(position[c]) : pair->vertices[pair->vertex[side][c]].position;
}

/// Of the triangle of one side.
double qcManifoldPair_LongestEdge(const qcManifoldPair* pair, int side);

static inline uint32_t qcManifoldPair_Vertex(const qcManifoldPair* pair, int side, int corner)
{
    return pair->body[side]->indices[3 * (size_t)pair->triangle[side] + (unsigned)corner];
}

static inline qcVector qcNegated(qcVector v)
{
    return (qcVector){-v.x, -v.y, -v.z};
}

/// How far side 0 has to move along a direction, and how far against it, until a plane perpendicular to it lies between
/// the two triangles. Below 0: it does already, with so much room.
typedef struct qcWaysOut
{
    double along, against;
} qcWaysOut;

qcWaysOut qcManifoldPair_WaysOut(const qcManifoldPair* pair, qcVector direction);

/// Corners of what the two triangles have in common seen along a direction, with their gaps; none where they lie beside
/// each other. Returns their number.
int qcManifoldPair_FindCommonPart(const qcManifoldPair* pair, qcVector normal, qcRawPoint corners[qc_maxCommonCorners]);

/// A region in the order of the result.
typedef struct qcContactRegion
{
    uint32_t slot[2];
    double tolerance; ///< points no farther apart than this are one
    uint32_t pairs;
    bool rigid;    ///< neither side deforms
    bool crossing; ///< some pair is
} qcContactRegion;

//  ---- trees with a sign at every branch -------------------------------------------------------------------

/// Disjoint sets whose members are equal or opposite to each other: a node is twice its parent, plus 1 if it is
/// opposite to it.
static inline uint32_t qcSigned_Find(uint32_t* nodes, uint32_t i)
{
    uint32_t opposite = 0;
    while (nodes[i] >> 1 != i)
    {
        uint32_t up = nodes[nodes[i] >> 1];
        nodes[i] = (up & ~1u) | ((nodes[i] ^ up) & 1u);
        opposite ^= nodes[i] & 1u;
        i = nodes[i] >> 1;
    }
    return i << 1 | opposite;
}

/// The lower root stays. If the two are in one set already, what it says of them stands.
static inline void qcSigned_Unite(uint32_t* nodes, uint32_t i, uint32_t j, uint32_t opposite)
{
    uint32_t a = qcSigned_Find(nodes, i), b = qcSigned_Find(nodes, j);
    uint32_t relation = (a ^ b ^ opposite) & 1u;
    if (a >> 1 < b >> 1)
        nodes[b >> 1] = (a & ~1u) | relation;
    else if (b >> 1 < a >> 1)
        nodes[a >> 1] = (b & ~1u) | relation;
}

//  ---- the parts, in the order in which they run ------------------------------------------------------------

/// Takes the pairs in, lists who lies beside whom, and joins neighbours to regions.
qcStatus qcManifolds_FindRegions(qcManifolds* manifolds, const qcTriangles* triangles, const qcPair* pairs,
                                 const qcProximity* proximities, size_t count);
/// A pair beside another one: they have one triangle in common, and the other two share a vertex.
typedef struct qcBeside
{
    uint32_t pair;
    uint32_t shared; ///< number of these vertices
} qcBeside;

/// Each once. In a list too long for qc_besideReach some are left out.
uint32_t qcManifolds_CollectRing(const qcManifolds* manifolds, uint32_t pair, qcBeside ring[qc_maxRing]);
/// The direction of each pair, looked at with its neighbourhood.
qcStatus qcManifolds_ChooseNormals(qcManifolds* manifolds, const qcProximity* proximities, uint32_t threads);
/// Their signs, looked at in each region.
qcStatus qcManifolds_ChooseSigns(qcManifolds* manifolds, const qcProximity* proximities, double margin);
/// Needs numbered regions.
qcStatus qcManifolds_FindPoints(qcManifolds* manifolds, const qcProximity* proximities, double margin,
                                uint32_t threads);
qcStatus qcManifolds_MergePoints(qcManifolds* manifolds);
/// Of flat patches between rigid bodies only the corners stay.
void qcManifolds_DropBetween(qcManifolds* manifolds);
void qcManifolds_FreeSinks(qcManifolds* manifolds);

/// Do two points say the same of the same place: one end of theirs nearly the same, and their normals too? Then only
/// the deeper one counts; the other is the same feature found from another triangle, or lies behind it.
static inline bool qcRawPoint_AreSame(const qcRawPoint* p, const qcRawPoint* q, double tolerance)
{
    qcVector d = qcMinus(p->end[0], q->end[0]), e = qcMinus(p->end[1], q->end[1]);
    double limit = tolerance * tolerance;
    // 30 degrees: a corner on a floor and against a wall is two contacts.
    return (qcDot(d, d) <= limit || qcDot(e, e) <= limit) && qcDot(p->normal, q->normal) >= 0.866;
}

static inline qcManifoldPair* qcManifolds_Pair(const qcManifolds* manifolds, uint32_t pair)
{
    return &QC_AT(qcManifoldPair, manifolds->work, pair);
}

#endif
