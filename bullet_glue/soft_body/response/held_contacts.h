// Contacts of the previous step with rigid objects that soft bodies can't move, for Bullet's own solver.
//
// Bullet solves links before contacts are found here. Where cloth hangs over an edge they would pull it into the shape,
// by more than an edge of the cloth in a step, and contacts that are found there have the wrong direction.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_HELD_CONTACTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_HELD_CONTACTS_H

#include "soft_body/response/position_constraints.h"
#include "soft_body/response/present_objects.h"

/// The share of the thickness at which contacts are held: at the whole thickness, rounding would decide in each step
/// whether they are found again.
constexpr btScalar qcHeldShare = btScalar(0.98);

/// The rigid side of a constraint, for the next step.
qcHeldPoint qcHeldPointOf(const qcSoftConstraint& constraint);

class qcHeldContacts
{
  public:
    /// Keeps the contacts among the constraints, at the end of a step. Tangled bodies have none: parts of them are on
    /// the wrong side. `tangles`: of the end of the step.
    static void Keep(qcSoftBodyScene& scene, const qcSoftTangles& tangles,
                     const std::vector<qcSoftConstraint>& constraints);
    /// Adds the contacts that still hold to Bullet's soft bodies, as contacts of faces with nodes of this object.
    void Insert(qcSoftBodyScene& scene, qcPresentObjects* present);
    /// Removes them after Bullet has solved, and applies their friction.
    void Remove(qcSoftBodyScene& scene);

  private:
    struct Inserted
    {
        qcSceneSoftBody* soft;
        const qcHeldContact* contact;
        btVector3 normal, start, end; ///< of the rigid point, at the start and at the end of the step
    };

    static btScalar DistanceOf(const Inserted& inserted);

    std::vector<btSoftBody::Node> m_nodes; ///< a point of the rigid object each
    std::vector<btSoftBody::Face> m_faces; ///< up to three nodes of the soft body each
    std::vector<Inserted> m_inserted;
    std::vector<int> m_counts; ///< by soft body: of its own contacts
};

#endif
