// The displacements of elastic soft bodies and of rigid ones under the springs between them, as one linear system.
//
// Over a step, nodes resist by their masses and by the stiffness and damping of Bullet's forces, as in Bullet's
// implicit solver; rigid bodies by mass and inertia. Whatever the springs do, momentum stays as it is.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_SYSTEM_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_SYSTEM_H

#include "common/object_key.h"
#include "soft_body/scene/scene_soft_body.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btDeformableBackwardEulerObjective.h>

/// A spring between a weighted sum of nodes and a point of a rigid body, or of something fixed, or only among nodes.
struct qcElasticSpring
{
    int nodeCount = 0;
    int nodes[6] = {0, 0, 0, 0, 0, 0};        ///< btSoftBody::Node::index
    btScalar weights[6] = {0, 0, 0, 0, 0, 0}; ///< negative on the other side
    int rigid = -1;                           ///< from qcElasticSystem::AddRigid; -1: none
    btVector3 normal{0, 0, 0};
    btVector3 arm{0, 0, 0};     ///< from the rigid body's centre
    btVector3 missing{0, 0, 0}; ///< relative displacement by which the spring is at rest
    btScalar friction = 0;
    bool isClosed = true; ///< open ones don't act
    btScalar held = 1;    ///< stiffness along the surface, as a share of that along the normal: what friction holds
    btScalar stiffness = 0;
};

class qcElasticSystem
{
  public:
    using Vector = btAlignedObjectArray<btVector3>;

    /// Empties the system; the solution of the last step stays, as the first guess of the next.
    void Begin();
    /// The index of a dynamic body, for springs. Its factors guide it.
    int AddRigid(btRigidBody* body);
    /// Finds the displacements, and which springs are closed: those that push. `bodies`: all that have nodes in
    /// springs. False: there is no finite solution, or Bullet's numbers of nodes are those of other bodies.
    bool Solve(const btDeformableBackwardEulerObjective& objective, const std::vector<qcSceneSoftBody*>& bodies,
               btScalar timeStep, std::vector<qcElasticSpring>* springs);
    /// Adds the displacements to the bodies' positions, and the velocities that lead there.
    void Apply() const;

  private:
    struct Rigid
    {
        btRigidBody* body;
        btMatrix3x3 mass, inertia;
    };

    /// The element of a rigid body's translation; that of its rotation follows.
    int At(int rigid) const
    {
        return int(m_nodes.size()) + 2 * rigid;
    }
    bool FindNodes(const btDeformableBackwardEulerObjective& objective, const std::vector<qcSceneSoftBody*>& bodies);
    void FindInertia(const std::vector<qcSceneSoftBody*>& bodies);
    void MultiplyNodes(const Vector& x, Vector* result) const;
    void SetStiffness();
    btVector3 Relative(const qcElasticSpring& spring, const Vector& x) const;
    void AddForce(const qcElasticSpring& spring, const btVector3& force, Vector* to) const;
    void Multiply(const Vector& x, Vector* result) const;
    void FindBlocks();
    void Precondition(const Vector& r, Vector* result) const;
    double SquareOfForces();
    void SolveClosed();
    bool UpdateSprings();

    btScalar m_timeStep = 0;
    std::vector<qcElasticSpring>* m_springs = nullptr;
    std::vector<btDeformableLagrangianForce*> m_forces;
    std::vector<btSoftBody::Node*> m_nodes; ///< by index; null: it doesn't move
    std::vector<int> m_bodyOfNode;          ///< by index
    std::vector<Rigid> m_rigids;
    /// What resists the displacement of each node alone, its mass included: a third of the trace of its diagonal block,
    /// which rotations don't change. It is found for these bodies and forces, and again after a while.
    std::vector<btScalar> m_inertia;
    std::vector<qcObjectKey> m_bodiesOfInertia;
    std::vector<btDeformableLagrangianForce*> m_forcesOfInertia;
    btScalar m_stepOfInertia = 0;
    int m_ageOfInertia = 0;
    std::vector<btMatrix3x3> m_inverses;     ///< of the diagonal blocks
    std::vector<btMatrix3x3> m_bodyInverses; ///< by soft body, of what resists its translation
    mutable std::vector<btVector3> m_sums;   ///< scratch of Precondition, by soft body
    Vector m_x;                              ///< by node its displacement, by rigid body translation and rotation
    Vector m_forcesOfSprings, m_right, m_residual, m_preconditioned, m_direction, m_image;
};

#endif
