// Inverses of rigid transforms, and the transform from one body's coordinates to another's.
// Error bounds: plugin/docs/proofs/rigid_transform.md.
#ifndef QC_BASE_RIGID_TRANSFORM_H
#define QC_BASE_RIGID_TRANSFORM_H

#include "quickcullide/scene.h"

#include <stdbool.h>

/// True if the linear part is so far from singular that the inverse is accurate.
bool qcTransform_IsInvertible(const qcTransform* transform);

/// A body's transform, and the bounding box of its local coordinates.
typedef struct qcRigidTransform
{
    qcTransform transform;
    double lower[3], upper[3];
} qcRigidTransform;

/// The transform from coordinates of `b` to coordinates of `a`: x -> linear x + shift.
typedef struct qcRelativeTransform
{
    double linear[3][3], shift[3];
    /// Error bound by axis, in coordinates of `a`. If qcBody_GetVertex maps a point of `a` and a point of `b` to the
    /// same world position, the transform maps the point of `b` to within this of the point of `a`.
    double error[3];
    /// By axis: the maximum coordinate in `a` of a world vector whose coordinates are at most 1.
    double reach[3];
    double stretch; ///< maximum ratio of a vector's length in coordinates of `a` to that in the world
    double growth;  ///< maximum ratio of a vector's length in the world to that in coordinates of `a`
} qcRelativeTransform;

/// `a` is invertible (qcTransform_IsInvertible).
qcRelativeTransform qcRelativeTransform_Find(const qcRigidTransform* a, const qcRigidTransform* b);

#endif
