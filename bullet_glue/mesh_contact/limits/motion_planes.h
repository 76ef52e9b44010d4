// Separating planes between triangles of two meshes that are not proven apart over a step, or between two meshes that
// touch at its start. Bodies are pushed apart along the normal of the closest points at the start, by equal and
// opposite impulses on their transforms at the end.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_MOTION_PLANES_H
#define QC_GLUE_MESH_CONTACT_LIMITS_MOTION_PLANES_H

#include "mesh_contact/limits/swept_object.h"

#include <array>
#include <set>

/// A stopped pair keeps this part of the sum of its margins, or the distance that it had if that is less. There contact
/// of the next step finds it with a reliable normal.
constexpr btScalar qcMotionFloor = btScalar(0.25);

/// Upper bound of the rounding of the corners of two objects at their ends: of rotations, products and sums.
btScalar qcCornerRounding(const qcSweptObject& a, const qcSweptObject& b);

/// Triangles of two objects that come no deeper into each other than this only touch: their corners are rounded.
btScalar qcTouchingDepth(const qcSweptObject& a, const qcSweptObject& b);

/// Triangles that are no further apart at the start can't be proven apart, and count as touching, too. Far below the
/// rounding of btScalar unless it is double.
btScalar qcCertifiableGap(const qcSweptObject& a, const qcSweptObject& b);

struct qcMotionPlaneSide
{
    qcSweptObject* swept;
    btVector3 corners[3]; ///< of the triangle, in the object's frame
    bool isWhole = false; ///< the object's hull takes the place of a triangle
};

struct qcMotionPlane
{
    qcMotionPlaneSide above, below;
    btVector3 normal;         ///< unit, from below to above
    btScalar gap;             ///< required distance along the normal, of the two triangles or hulls
    btScalar pushed;          ///< sum of impulses so far, times the time step
    btVector3 arms[2];        ///< of where the sides meet, from the centres of above and below
    btScalar approach = 0;    ///< speed along the normal before impulses
    btScalar restitution = 0; ///< 0 if it was too slow to bounce
    btScalar stopping = 0;    ///< impulse that removes the approach, so far
    btVector3 along{0, 0, 0}; ///< unit, in which below slides on above; 0: it does not
    btScalar rubbing = 0;     ///< impulse of friction, so far
    btScalar mostRubbing = 0;
    btScalar parting = 0; ///< impulse of the bounce
    /// The pushes of above and below when no push was needed; a plane that has not been solved has others.
    uint32_t held[2] = {UINT32_MAX, UINT32_MAX};
};

class qcMotionPlanes
{
  public:
    void Clear();
    /// Adds a plane for a pair of triangles, unless it has one.
    void Add(const qcPair& pair, const qcMotionPlaneSide& a, const qcMotionPlaneSide& b, const qcProximity& nearest);
    /// Adds a plane between the hulls of two objects, unless there is one. `normal`: from `below` to `above`.
    void AddHulls(qcSweptObject* below, qcSweptObject* above, const btVector3& normal, btScalar gap);
    /// One Gauss-Seidel sweep over all planes. Moves the ends of free objects.
    void SolveOnce();
    /// Impulses where planes have pushed pairs that `isStopped` names: they stop them, with friction, and bodies with
    /// restitution that were not slower than this bounce. Kinetic energy doesn't grow.
    template <class IsStopped> void RemoveApproaches(int sweeps, btScalar slowest, const IsStopped& isStopped)
    {
        m_stopped.clear();
        for (qcMotionPlane& plane : m_planes)
            if (plane.pushed > 0 && isStopped(*plane.above.swept, *plane.below.swept))
                m_stopped.push_back(&plane);
        StopAll(sweeps, slowest);
        RubAll(sweeps);
        BounceAll(sweeps);
    }

  private:
    void StopAll(int sweeps, btScalar slowest);
    void RubAll(int sweeps);
    void BounceAll(int sweeps);

    std::vector<qcMotionPlane> m_planes;
    std::vector<qcMotionPlane*> m_stopped;     ///< those of RemoveApproaches
    std::set<std::array<uint32_t, 4>> m_pairs; ///< those that have a plane
};

#endif
