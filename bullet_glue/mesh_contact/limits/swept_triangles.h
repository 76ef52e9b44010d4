// Pairs of triangles that the detection of a step has not proven apart: apart at its start, or meeting there.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_TRIANGLES_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_TRIANGLES_H

#include "mesh_contact/limits/motion_planes.h"

/// A triangle of an object that moves.
struct qcSweptTriangle
{
    qcSweptObject* swept;
    const qcSweptMesh* mesh;
    uint32_t number; ///< in the mesh

    /// The corners where the object has this transform; `atStart`: before it deforms.
    void CornersAt(const btTransform& transform, bool atStart, double corners[9]) const;
    qcMotionPlaneSide PlaneSide() const;
};

struct qcSweptTriangles
{
    const qcPair* pair;
    const qcProximity* atStart;
    qcSweptTriangle a, b;
    bool meet = false;            ///< at the start, up to rounding
    btScalar maxDepth = 0;        ///< at the end, of triangles that meet
    btVector3 facing = {0, 0, 0}; ///< from B to A, if they meet and lie in one plane, facing each other; otherwise 0

    qcSweptPair Objects() const
    {
        return std::minmax(a.swept, b.swept,
                           [](const qcSweptObject* x, const qcSweptObject* y) { return x->number < y->number; });
    }
    /// True if they penetrate at the start by more than this, or lie in one plane, face the same way and overlap there
    /// by more: their bodies are in each other, with sides flush.
    bool ArePenetrating(btScalar touchingDepth) const;
    /// If they are no further apart at the start than this, they may come as deep into each other, or as deep as they
    /// start. Planes push those apart that face each other, as the two sides of a cut do.
    void MeetWithin(btScalar touchingDepth);
    bool FaceEachOther() const
    {
        return !facing.isZero();
    }
    /// False: nothing has to be done in this round. `pushes`: planes are added in it.
    bool IsUnproven(bool pushes) const;
    /// The largest part of the motions, up to `limit` and bisection, over which they stay apart, or after which they
    /// are not too deep; below 0: none.
    btScalar FindPart(btScalar limit) const;
    /// A plane that keeps them as they start, or that pushes them apart.
    void AddPlane(qcMotionPlanes* planes) const;
};

#endif
