// A deforming body's positions as floats, the caller's, for steps that read no others: the exact test reads those of
// its candidates here, and no doubles are stored. Kept for bodies whose pairs a device finds, and in the sweep where no
// Verlet list follows them.
#ifndef QC_SCENE_FLOAT_POSITIONS_H
#define QC_SCENE_FLOAT_POSITIONS_H

#include "base/aabb.h"
#include "scene/bodies.h"

struct qcFloatPositions
{
    bool kept;    ///< the body's next positions are read here, if they are floats
    bool newest;  ///< qcBody::world is older
    float* at;    ///< three a vertex, and one more
    float* spare; ///< as many: new positions are read here, and take effect only if all of them are finite
};

/// Whether the present positions are floats, and qcBody::world is older.
static inline bool qcBody_IsInFloats(const qcBody* body)
{
    return body->floats != NULL && body->floats->newest;
}

/// World position, wherever it is.
static inline void qcBody_GetNewestVertex(const qcBody* body, uint32_t vertex, double position[3])
{
    if (!qcBody_IsInFloats(body))
        qcBody_GetVertex(body, vertex, position);
    else
        for (int axis = 0; axis < 3; axis++)
            position[axis] = (double)body->floats->at[3 * (size_t)vertex + (size_t)axis];
}

/// World positions of a triangle's corners, wherever they are.
static inline void qcBody_GetNewestTriangle(const qcBody* body, uint32_t triangle, double corners[3][3])
{
    const uint32_t* index = body->indices + 3 * (size_t)triangle;
    for (int c = 0; c < 3; c++)
        qcBody_GetNewestVertex(body, index[c], corners[c]);
}

/// The box in the world around a triangle.
static inline void qcBody_GetTriangleBox(const qcBody* body, uint32_t triangle, double lower[3], double upper[3])
{
    double corners[3][3];
    qcBody_GetNewestTriangle(body, triangle, corners);
    qcBounds_OfTriangle((const double(*)[3])corners, lower, upper);
}

/// Fetches the positions that qcBody_GetNewestTriangle reads into the caches.
static inline void qcBody_FetchNewestTriangle(const qcBody* body, uint32_t triangle)
{
    const uint32_t* index = body->indices + 3 * (size_t)triangle;
    bool inFloats = qcBody_IsInFloats(body);
    const double* doubles = body->world != NULL ? body->world : body->local;
    for (int c = 0; c < 3; c++)
        if (inFloats)
            __builtin_prefetch(body->floats->at + 3 * (size_t)index[c]);
        else
            __builtin_prefetch(doubles + 3 * (size_t)index[c]);
}

/// The body's next floats are kept. Nothing changes for rigid bodies and for positions in double.
qcStatus qcFloatPositions_Keep(qcBody* body);
/// Brings qcBody::world up to date; the body's next positions are read into doubles. O(vertices) if it was older.
void qcFloatPositions_Leave(const qcBody* body);
/// Brings qcBody::world up to date.
void qcFloatPositions_Convert(const qcBody* body);
/// The spare positions become the present ones.
void qcFloatPositions_Replace(qcBody* body);
/// Before the body is freed.
void qcFloatPositions_Free(qcBody* body);

#endif
