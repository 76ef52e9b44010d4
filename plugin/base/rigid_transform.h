// Rigid transforms backwards, and from one body's coordinates to another's.
#ifndef QC_BASE_RIGID_TRANSFORM_H
#define QC_BASE_RIGID_TRANSFORM_H

#include "quickcullide/scene.h"

#include <stdbool.h>

/// Is it far enough from flattening things that its inverse is of use?
bool qcTransform_IsInvertible(const qcTransform* transform);

/// Where a body is: its transform, and the box around its own coordinates.
typedef struct qcRigidTransform
{
    qcTransform transform;
    double lower[3], upper[3];
} qcRigidTransform;

/// From coordinates of `b` to coordinates of `a`: x -> linear x + shift.
typedef struct qcRelativeTransform
{
    double linear[3][3], shift[3];
    /// How far, in coordinates of `a`, the images of points that qcBody_GetVertex takes to one point of the world may
    /// be apart, by the roundings there and here.
    double error[3];
    /// Vectors of the world, up to 1 in each coordinate, are up to so much in each of a's.
    double reach[3];
    double stretch; ///< a vector of the world is at most so many times as long in coordinates of `a`
    double growth;  ///< and one in coordinates of `a` so many times in the world
} qcRelativeTransform;

/// `a` is invertible.
qcRelativeTransform qcRelativeTransform_Find(const qcRigidTransform* a, const qcRigidTransform* b);

#endif
