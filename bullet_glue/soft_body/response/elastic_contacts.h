// Contacts of the previous step of tetrahedral bodies, with their elasticity.
//
// Bullet solves elasticity before contacts are found here, and these move a node by its own mass: what surrounds it
// bears on the other side from the next step on only. In stiff bodies the nodes' masses are next to nothing, so one
// that carried several times its mass was crushed.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_CONTACTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_CONTACTS_H

#include "soft_body/response/elastic_system.h"
#include "soft_body/response/position_constraints.h"
#include "soft_body/response/present_objects.h"

class btDeformableBodySolver;

class qcElasticContacts
{
  public:
    /// Keeps the contacts of tetrahedral bodies with each other and with rigid ones, at the end of a step, but for
    /// those of tangled bodies: parts of them are on the wrong side.
    void Keep(qcSoftBodyScene& scene, const qcSoftTangles& tangles, const std::vector<qcSoftConstraint>& constraints);
    /// Moves bodies that carry or press something, and what they carry, as the kept contacts require; velocities
    /// follow. Bullet has moved all bodies in this step.
    void Solve(qcSoftBodyScene& scene, const btDeformableBodySolver& solver, btScalar timeStep);

  private:
    /// A contact at the end of a step. Side A is a soft body; side B another one, or a rigid object.
    struct Kept
    {
        qcObjectKey soft[2]{{nullptr, -1}, {nullptr, -1}}; ///< by side; null: side B is rigid
        int nodeCount = 0;
        int sides[6] = {0, 0, 0, 0, 0, 0};
        uint32_t nodes[6] = {0, 0, 0, 0, 0, 0};
        btScalar weights[6] = {0, 0, 0, 0, 0, 0}; ///< negative on side B
        qcHeldPoint rigid;                        ///< without an object: side B is a soft body
        btVector3 normal{0, 0, 0};                ///< between soft bodies: towards side A
        btScalar thickness = 0, friction = 0;
    };
    /// A spring and the soft bodies on its sides.
    struct Sides
    {
        qcSceneSoftBody* soft[2];
    };

    bool MakeKept(qcSoftBodyScene& scene, const qcSoftTangles& tangles, const qcSoftConstraint& constraint,
                  Kept* kept) const;
    bool AddRigidSide(const Kept& kept, qcPresentObjects* present, const qcSceneSoftBody& soft, btVector3* start,
                      btVector3* end, qcElasticSpring* spring);
    void AddSpring(qcSoftBodyScene& scene, const Kept& kept, qcPresentObjects* present);
    bool IsSqueezed(const qcSceneSoftBody& soft) const;
    void LeaveUnloaded();

    std::vector<Kept> m_kept;
    std::vector<qcElasticSpring> m_springs;
    std::vector<Sides> m_sides; ///< by spring
    std::vector<qcSceneSoftBody*> m_loaded;
    qcElasticSystem m_system;
};

#endif
