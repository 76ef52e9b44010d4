// A deforming body's positions as floats, the caller's, for steps that read no others: doubles are made of those
// vertices alone that a stage reads. Kept for bodies whose pairs a device finds, and in the sweep where no Verlet list
// follows them.
#ifndef QC_SCENE_FLOAT_POSITIONS_H
#define QC_SCENE_FLOAT_POSITIONS_H

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

/// The body's next floats are kept. Nothing changes for rigid bodies and for positions in double.
qcStatus qcFloatPositions_Keep(qcBody* body);
/// Brings qcBody::world up to date; the body's next positions are read into doubles. O(vertices) if it was older.
void qcFloatPositions_Leave(const qcBody* body);
/// Brings qcBody::world up to date for all vertices, or for those of a triangle.
void qcFloatPositions_Convert(const qcBody* body);
void qcFloatPositions_ConvertTriangle(const qcBody* body, uint32_t triangle);
/// Fetches into the caches what ConvertTriangle needs.
void qcFloatPositions_FetchTriangle(const qcBody* body, uint32_t triangle);
/// The spare positions become the present ones.
void qcFloatPositions_Replace(qcBody* body);
/// Before the body is freed.
void qcFloatPositions_Free(qcBody* body);

#endif
