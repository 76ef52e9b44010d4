// A direction that separates two small meshes as a whole.
//
// Gilbert, Johnson, Keerthi: A fast procedure for computing the distance between complex objects in three-dimensional
// space, 1988; the separating axis test for the normals of faces.
#ifndef QC_GLUE_MESH_CONTACT_PLANES_SEPARATING_AXIS_H
#define QC_GLUE_MESH_CONTACT_PLANES_SEPARATING_AXIS_H

#include "common/support_mesh.h"

/// Two meshes, projected onto a direction.
struct qcSeparation
{
    btVector3 axis{0, 0, 0};        ///< of length 1, from A to B
    btScalar gap = -BT_LARGE_FLOAT; ///< smallest product of B's vertices with the axis, minus the largest of A's
    /// The closest points of the hulls are combinations of these vertices, up to three on each side. 0: not known. If
    /// the axis is the normal of a face, they may be a little nearer to each other along another direction.
    int cornerCount = 0;
    uint32_t cornersA[3], cornersB[3];
    btVector3 onA, onB; ///< the closest points
};

/// The gap of two meshes along a direction. O(vertices).
btScalar qcGapAlong(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& axis);
/// Upper bound of the rounding error of qcGapAlong.
btScalar qcGapError(const qcPlacedSupport& a, const qcPlacedSupport& b);

/// Finds a direction with a large gap: the largest, up to rounding, if it is above 0; below, the largest among the
/// normals of faces, the guess and the axes of the hulls moved a little apart. Stops at the first one with a gap above
/// `enough`. Normals of faces are preferred where their gap is less by at most `slack`. `guess`: of any length, for
/// example the axis of the previous step.
qcSeparation qcFindSeparation(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& guess,
                              btScalar enough, btScalar slack);
/// Likewise, without normals of faces. A gap that is not above 0 may be less than the largest.
qcSeparation qcSeparateHulls(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& guess,
                             btScalar enough);
/// Likewise for a hull and a triangle, from the hull to the triangle.
qcSeparation qcSeparateFromTriangle(const qcPlacedSupport& hull, const btVector3 corners[3], const btVector3& guess);

/// Two meshes at the start and at the end of a motion.
struct qcMovedHulls
{
    qcPlacedSupport startA, startB, endA, endB;
    /// Upper bound of the rounding of gaps.
    btScalar error = qcGapError(startA, startB) + qcGapError(endA, endB);

    /// True if the direction separates the hulls at both times, beyond rounding.
    bool AreSeparatedAlong(const btVector3& axis) const
    {
        return qcGapAlong(endA, endB, axis) > error && qcGapAlong(startA, startB, axis) > error;
    }
    /// Tries the direction of the largest gap at the start, that at the end, and the one between. False proves nothing.
    bool AreSeparated(const qcSeparation& atStart) const;
};

#endif
