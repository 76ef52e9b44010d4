// The bodies of a scene: their triangles in world space, always in double, and their boxes.
#ifndef QC_SCENE_BODIES_H
#define QC_SCENE_BODIES_H

#include "base/memory.h"
#include "quickcullide/scene.h"

/// Which corners and edges a triangle stands for, so that a feature that several triangles share is met once:
/// bit c: corner c, bit 3 + c: the edge from corner c to the next. The idea of representative triangles:
/// Curtis, Tamstorf, Manocha: Fast Collision Detection for Deformable Models using Representative-Triangles, 2008.
typedef uint8_t qcOwnedFeatures;

typedef struct qcBody
{
    uint32_t generation; ///< odd while the slot is taken, so that ids of removed bodies never match
    bool deforming;
    bool selfCollision;
    qcActivity activity;
    uint32_t group, mask, owner;
    double margin; ///< see qcBodyDef
    uint32_t vertexCount, triangleCount;
    double* local; ///< three a vertex, of rigid bodies; null for deforming ones
    double* world; ///< three a vertex, of deforming bodies; null for rigid ones: see qcBody_GetVertex
    uint32_t* indices;
    qcOwnedFeatures* owned;                ///< one a triangle; null until contacts are asked for
    uint8_t* used;                         ///< by vertex: is it a corner of some triangle? Null: all are
    uint64_t moved;                        ///< qcBodies::revision when positions last changed
    qcTransform transform;                 ///< of rigid bodies
    bool isIdentity;                       ///< the transform: positions are taken as they are
    double lower[3], upper[3];             ///< around all triangles; lower > upper when there are none
    double localLower[3], localUpper[3];   ///< the same of `local`
    double vertexLower[3], vertexUpper[3]; ///< of `local`, around all vertices
} qcBody;

typedef struct qcBodies
{
    qcArray slots; ///< of qcBody
    uint32_t count;
    uint32_t lowestFree; ///< no free slot lies below it
    uint64_t revision;   ///< grows with every change
    uint64_t added;      ///< the revision in which a body last came or went
} qcBodies;

qcStatus qcBodies_Add(qcBodies* bodies, const qcBodyDef* def, qcBodyId* id);
/// The body of an id, or null with a message that names the caller's function.
qcBody* qcBodies_Find(const qcBodies* bodies, qcBodyId id, const char* caller);
void qcBodies_Remove(qcBodies* bodies, qcBodyId id);
qcStatus qcBodies_SetTransform(qcBodies* bodies, uint32_t slot, const qcTransform* transform);
qcStatus qcBodies_SetVertices(qcBodies* bodies, uint32_t slot, const void* positions, qcPositionType type,
                              size_t stride);
/// Makes body->owned. O(triangles).
qcStatus qcBody_FindOwners(qcBody* body, qcArray* scratch);
void qcBodies_Free(qcBodies* bodies);

static inline bool qcBody_IsUsed(const qcBody* body)
{
    return (body->generation & 1) != 0;
}

/// Is it tested with itself?
static inline bool qcBody_HasSelfCollision(const qcBody* body)
{
    return body->selfCollision && body->activity == qc_activityMoving && body->triangleCount > 1;
}

/// How far apart triangles of two bodies, or of one, count where a step has this margin.
static inline double qcBody_PairMargin(const qcBody* a, const qcBody* b, double margin)
{
    double sum = a->margin + b->margin;
    return sum < margin ? sum : margin;
}

/// How far apart the boxes of two triangles may be whose contacts within the margin are wanted.
static inline double qcContactDistance(double margin)
{
    return margin * (1.0 + 2e-9);
}

/// In the world. A rigid body's is computed whenever it is asked for, in the same way: it moves without a look at its
/// vertices.
static inline void qcBody_GetVertex(const qcBody* body, uint32_t vertex, double position[3])
{
    const double* p = (body->world != NULL ? body->world : body->local) + 3 * (size_t)vertex;
    for (int axis = 0; axis < 3; axis++)
    {
        const double* row = body->transform.linear + 3 * axis;
        // Not by multiplication where nothing changes: 0 * x would lose the sign of a zero.
        position[axis] = body->isIdentity
                             ? p[axis]
                             : row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + body->transform.translation[axis];
    }
}

static inline void qcBody_GetTriangle(const qcBody* body, uint32_t triangle, double corners[3][3])
{
    const uint32_t* index = body->indices + 3 * (size_t)triangle;
    for (int c = 0; c < 3; c++)
        qcBody_GetVertex(body, index[c], corners[c]);
}

static inline void qcBody_GetTriangleBox(const qcBody* body, uint32_t triangle, double lower[3], double upper[3])
{
    double corners[3][3];
    qcBody_GetTriangle(body, triangle, corners);
    for (int axis = 0; axis < 3; axis++)
    {
        double x = corners[0][axis], y = corners[1][axis], z = corners[2][axis];
        double low = x < y ? x : y, high = x < y ? y : x;
        lower[axis] = z < low ? z : low;
        upper[axis] = z > high ? z : high;
    }
}

/// Do the triangles share a vertex index?
static inline bool qcBody_AreNeighbours(const qcBody* body, uint32_t a, uint32_t b)
{
    const uint32_t* p = body->indices + 3 * (size_t)a;
    const uint32_t* q = body->indices + 3 * (size_t)b;
    return (p[0] == q[0]) | (p[0] == q[1]) | (p[0] == q[2]) | (p[1] == q[0]) | (p[1] == q[1]) | (p[1] == q[2]) |
           (p[2] == q[0]) | (p[2] == q[1]) | (p[2] == q[2]);
}

#endif
