// The bodies of a scene: triangles in double, transforms, boxes.
#ifndef QC_SCENE_BODIES_H
#define QC_SCENE_BODIES_H

#include "base/memory.h"
#include "quickcullide/scene.h"

/// The corners and edges whose contacts a triangle reports (scene/feature_owners.h). Bit c: corner c; bit 3 + c: the
/// edge from corner c to the next.
typedef uint8_t qcOwnedFeatures;

/// What is known of a body's surface. Meshes that face inwards, as rooms do, count as open.
typedef enum qcSurface
{
    qc_surfaceUnknown,
    qc_surfaceOpen,
    qc_surfaceClosed
} qcSurface;

/// Where a body was at the last qcScene_MarkStart.
typedef struct qcBodyStart
{
    bool isMarked; ///< false: the body was added since, and has no motion
    /// The body has been moved since the mark; the fields below are valid. Otherwise the start is the present.
    bool differs;
    double* world; ///< like qcBody::world; null before the first mark
    qcTransform transform;
    bool isIdentity;
    double lower[3], upper[3];
    uint64_t moved; ///< qcBody::moved of these positions
} qcBodyStart;

typedef struct qcBody
{
    /// Odd while the slot is taken, so that ids of removed bodies never match. 0: all 2^31 ids of the slot have been
    /// used, and it stays empty.
    uint32_t generation;
    bool deforming;
    bool hasFloats; ///< of deforming bodies: the caller gave the present positions as floats
    bool selfCollision;
    qcActivity activity;
    uint32_t group, mask, owner;
    double margin; ///< see qcBodyDef
    uint32_t vertexCount, triangleCount;
    double* local; ///< three a vertex, of rigid bodies; null for deforming ones
    double* world; ///< three a vertex, of deforming bodies; null for rigid ones: see qcBody_GetVertex
    /// Positions of deforming bodies that may be newer than `world`: see scene/float_positions.h. Null: none.
    struct qcFloatPositions* floats;
    uint32_t* indices;
    qcOwnedFeatures* owned;                ///< one a triangle; null until the first step with contacts
    uint8_t* used;                         ///< by vertex: 1 if a triangle has it, else 0; null: all vertices have one
    qcSurface surface;                     ///< see scene/closed_surface.h
    uint64_t moved;                        ///< qcBodies::revision when positions last changed
    qcTransform transform;                 ///< of rigid bodies
    bool isIdentity;                       ///< the transform
    double lower[3], upper[3];             ///< world AABB of all triangles; lower > upper if there are none
    double localLower[3], localUpper[3];   ///< their AABB in `local`
    double vertexLower[3], vertexUpper[3]; ///< AABB of all vertices in `local`
    qcBodyStart start;
    /// Positions on the device, which may be newer than `world`: see pipeline/vertex_buffers.h. Null: none. Released
    /// there.
    struct qcVertexSnapshot* snapshot;
} qcBody;

typedef struct qcBodies
{
    qcArray slots; ///< of qcBody
    uint32_t count;
    uint32_t lowestFree; ///< no slot below is free
    uint64_t revision;   ///< grows with each change
    uint64_t added;      ///< the revision in which a body was last added or removed
    uint32_t threads;    ///< that read new vertices: those of the last step, 1 if it was small; 0 before the first
} qcBodies;

qcStatus qcBodies_Add(qcBodies* bodies, const qcBodyDef* def, qcBodyId* id);
/// The body of an id; null, and a message that names the function `caller`, if there is none.
qcBody* qcBodies_Find(const qcBodies* bodies, qcBodyId id, const char* caller);
void qcBodies_Remove(qcBodies* bodies, qcBodyId id);
qcStatus qcBodies_SetTransform(qcBodies* bodies, uint32_t slot, const qcTransform* transform);
qcStatus qcBodies_SetVertices(qcBodies* bodies, uint32_t slot, const void* positions, qcPositionType type,
                              size_t stride);
/// New positions of a deforming body lie on the device, in these bounds; `world` keeps its content.
void qcBodies_MoveOnDevice(qcBodies* bodies, uint32_t slot, const float lower[3], const float upper[3]);
/// The present positions become the start of the motion. O(bodies); the first call allocates O(vertices). On failure
/// nothing has changed.
qcStatus qcBodies_MarkStart(qcBodies* bodies);
void qcBodies_Free(qcBodies* bodies);

static inline bool qcBody_IsUsed(const qcBody* body)
{
    return (body->generation & 1) != 0;
}

/// The slot may take a new body.
static inline bool qcBody_IsFree(const qcBody* body)
{
    return (body->generation & 1) == 0 && body->generation != 0;
}

/// Whether triangles of the body are tested with each other.
static inline bool qcBody_HasSelfCollision(const qcBody* body)
{
    return body->selfCollision && body->activity == qc_activityMoving && body->triangleCount > 1;
}

/// A step's margin for triangles of two bodies, or of one: no more than the sum of both bodies' margins.
static inline double qcBody_PairMargin(const qcBody* a, const qcBody* b, double margin)
{
    double sum = a->margin + b->margin;
    return sum < margin ? sum : margin;
}

/// The query distance for boxes of triangles that finds all contacts within the margin, roundings included.
static inline double qcContactDistance(double margin)
{
    return margin * (1.0 + 2e-9);
}

static inline void qcTransform_Apply(const qcTransform* transform, bool isIdentity, const double p[3],
                                     double position[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        const double* row = transform->linear + 3 * axis;
        // Identity is copied: 0 * x would lose the sign of a zero.
        position[axis] =
            isIdentity ? p[axis] : row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + transform->translation[axis];
    }
}

/// World position. A rigid body's vertices are transformed on each call: a new transform costs O(1).
static inline void qcBody_GetVertex(const qcBody* body, uint32_t vertex, double position[3])
{
    const double* p = (body->world != NULL ? body->world : body->local) + 3 * (size_t)vertex;
    qcTransform_Apply(&body->transform, body->isIdentity, p, position);
}

/// World position at the start of the motion.
static inline void qcBody_GetStartVertex(const qcBody* body, uint32_t vertex, double position[3])
{
    if (!body->start.differs)
        qcBody_GetVertex(body, vertex, position);
    else
        qcTransform_Apply(&body->start.transform, body->start.isIdentity,
                          (body->deforming ? body->start.world : body->local) + 3 * (size_t)vertex, position);
}

static inline void qcBody_GetTriangle(const qcBody* body, uint32_t triangle, double corners[3][3])
{
    const uint32_t* index = body->indices + 3 * (size_t)triangle;
    for (int c = 0; c < 3; c++)
        qcBody_GetVertex(body, index[c], corners[c]);
}

static inline void qcBody_GetStartTriangle(const qcBody* body, uint32_t triangle, double corners[3][3])
{
    const uint32_t* index = body->indices + 3 * (size_t)triangle;
    for (int c = 0; c < 3; c++)
        qcBody_GetStartVertex(body, index[c], corners[c]);
}

/// Whether the triangles share a vertex index.
static inline bool qcBody_AreNeighbours(const qcBody* body, uint32_t a, uint32_t b)
{
    const uint32_t* p = body->indices + 3 * (size_t)a;
    const uint32_t* q = body->indices + 3 * (size_t)b;
    return (p[0] == q[0]) | (p[0] == q[1]) | (p[0] == q[2]) | (p[1] == q[0]) | (p[1] == q[1]) | (p[1] == q[2]) |
           (p[2] == q[0]) | (p[2] == q[1]) | (p[2] == q[2]);
}

#endif
