// The displacements of elastic soft bodies and of rigid ones under the springs between them, as one linear system.
//
// Over a step, nodes resist by their masses and by elasticity; rigid bodies by mass and inertia. Whatever the springs
// do, momentum stays as it is.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_SYSTEM_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_SYSTEM_H

#include "common/rigid_displacement.h"
#include "soft_body/response/node_elasticity.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

/// A spring between a weighted sum of nodes and a point of a rigid body, or of something fixed, or only among nodes.
struct qcElasticSpring
{
    int nodeCount = 0;
    int nodes[6] = {0, 0, 0, 0, 0, 0};        ///< numbers of qcNodeElasticity
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
    using Vector = qcNodeElasticity::Vector;

    /// Empties the system; the solution of the last step stays, as the first guess of the next.
    void Begin();
    /// The index of a dynamic body, for springs. Its factors guide it.
    int AddRigid(btRigidBody* body);
    /// Finds the displacements, and which springs are closed: those that push. `bodies`: all that have nodes in
    /// springs, which `elasticity` has read for this step. False: there is no finite solution.
    bool Solve(qcNodeElasticity* elasticity, const std::vector<qcNodeElasticity::LoadedBody>& bodies,
               std::vector<qcElasticSpring>* springs);
    /// The solution for a rigid body.
    qcRigidDisplacement DisplacementOf(int rigid) const;
    /// Gives a rigid body this share of the velocity that its displacement would.
    void SetVelocityShare(int rigid, btScalar share)
    {
        m_rigids[size_t(rigid)].velocityShare = share;
    }
    /// Adds the displacements to the bodies' positions, and the velocities that lead there.
    void Apply(btScalar timeStep) const;

  private:
    struct Rigid
    {
        btRigidBody* body;
        btMatrix3x3 mass, inertia;
        btScalar velocityShare;
    };

    struct Momentum
    {
        btVector3 sum;
        btScalar mass;
    };

    /// The element of a rigid body's translation; that of its rotation follows.
    int At(int rigid) const
    {
        return int(m_nodes.size()) + 2 * rigid;
    }
    void FindNodes(const std::vector<qcNodeElasticity::LoadedBody>& bodies);
    void FindInertia();
    void FindGroups();
    void RemoveMomentum(Vector* x) const;
    void MultiplyNodes(const Vector& x, Vector* result) const;
    void SetStiffness();
    btVector3 Relative(const qcElasticSpring& spring, const Vector& x) const;
    void AddForce(const qcElasticSpring& spring, const btVector3& force, Vector* to) const;
    void Multiply(const Vector& x, Vector* result) const;
    void FindBlocks();
    void Precondition(const Vector& r, Vector* result) const;
    double SquareOfForces();
    void SolveClosed(int round);
    bool UpdateSprings();
    void LimitFriction(int rigid);

    qcNodeElasticity* m_elasticity = nullptr;
    std::vector<qcElasticSpring>* m_springs = nullptr;
    std::vector<btSoftBody::Node*> m_nodes; ///< by number; null: it doesn't move
    std::vector<btScalar> m_masses;         ///< by number; zero: the node doesn't move
    std::vector<int> m_bodyOfNode;          ///< by number
    std::vector<bool> m_isFree;             ///< by soft body: none of its nodes is pinned
    std::vector<Rigid> m_rigids;
    std::vector<int> m_groups; ///< by soft body, then by rigid body; -1: something fixed takes its momentum
    mutable std::vector<Momentum> m_momenta; ///< scratch of RemoveMomentum, by group
    /// What resists the displacement of each node alone, its mass included.
    std::vector<btMatrix3x3> m_inertia;
    std::vector<btMatrix3x3> m_inverses;     ///< of the diagonal blocks
    std::vector<btMatrix3x3> m_bodyInverses; ///< by soft body, of what resists its translation
    mutable std::vector<btVector3> m_sums;   ///< scratch of Precondition, by soft body
    Vector m_x;                              ///< by node its displacement, by rigid body translation and rotation
    Vector m_forcesOfSprings, m_right, m_residual, m_preconditioned, m_direction, m_image;
};

#endif
