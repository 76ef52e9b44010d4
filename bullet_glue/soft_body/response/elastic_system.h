// The displacements of elastic soft bodies and of rigid ones under the springs between them, as one linear system.
//
// Over a step, nodes resist by their masses and by elasticity; rigid bodies by mass and inertia, multibodies by those
// of their joints. Nodes that are anchored to a body move with it. Whatever the springs do, momentum stays as it is.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_SYSTEM_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ELASTIC_SYSTEM_H

#include "common/rigid_displacement.h"
#include "soft_body/response/elastic_links.h"
#include "soft_body/response/node_elasticity.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

/// A point that moves with a rigid body or with a link of a multibody, or one that doesn't move.
struct qcElasticPoint
{
    int rigid = -1;         ///< index of the rigid body; -1: none
    btVector3 arm{0, 0, 0}; ///< from its centre
    int link = -1;          ///< number in qcElasticLinks; -1: none

    bool Moves() const
    {
        return rigid >= 0 || link >= 0;
    }
};

/// A spring between a weighted sum of nodes and a point, or only among nodes.
struct qcElasticSpring
{
    int nodeCount = 0;
    int nodes[6] = {0, 0, 0, 0, 0, 0};        ///< numbers of qcNodeElasticity
    btScalar weights[6] = {0, 0, 0, 0, 0, 0}; ///< negative on the other side
    qcElasticPoint point;
    btVector3 normal{0, 0, 0};
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
    /// A point at `arm` from the centre of an object. It moves if the object is a dynamic rigid body, guided by its
    /// factors, or a link.
    qcElasticPoint AddPoint(const btCollisionObject& object, const btVector3& arm);
    /// Rigid bodies that points have been added for.
    size_t RigidCount() const
    {
        return m_rigids.size();
    }
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
    void Apply(btScalar timeStep);

  private:
    struct Rigid
    {
        btRigidBody* body;
        btMatrix3x3 mass, inertia;
        btScalar velocityShare;
    };

    /// A node that is anchored.
    struct Tied
    {
        int node;
        qcElasticPoint point;
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
    int AddRigid(btRigidBody* body);
    bool Tie(const btSoftBody& body, int node, int number);
    void FindNodes(const std::vector<qcNodeElasticity::LoadedBody>& bodies);
    btVector3 MotionAt(const qcElasticPoint& point, const Vector& x) const;
    void AddForceAt(const qcElasticPoint& point, const btVector3& force, Vector* to) const;
    void AddBlocksAt(const qcElasticPoint& point, const btMatrix3x3& stiffness);
    void MoveTied(Vector* x) const;
    void PassTiedForces(Vector* forces) const;
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
    bool IsWithinReach(const Vector& x, btScalar step, const Vector& direction) const;
    void SolveClosed(int round);
    bool UpdateSprings();
    void LimitFriction(int rigid);

    qcNodeElasticity* m_elasticity = nullptr;
    std::vector<qcElasticSpring>* m_springs = nullptr;
    std::vector<btSoftBody::Node*> m_nodes; ///< by number; null: it doesn't move
    std::vector<btScalar> m_masses;         ///< by number; zero: the node doesn't move
    std::vector<int> m_bodyOfNode;          ///< by number
    std::vector<bool> m_isFree;             ///< by soft body: none of its nodes is pinned or anchored
    std::vector<Tied> m_tied;
    std::vector<Rigid> m_rigids;
    qcElasticLinks m_links;
    std::vector<int> m_groups; ///< by soft body, then by rigid body; -1: something fixed takes its momentum
    mutable std::vector<Momentum> m_momenta; ///< scratch of RemoveMomentum, by group
    /// Resistance of each node alone to its displacement: its mass, and elasticity.
    std::vector<btMatrix3x3> m_inertia;
    std::vector<btMatrix3x3> m_inverses;     ///< of the diagonal blocks
    std::vector<btMatrix3x3> m_bodyInverses; ///< by soft body, of what resists its translation
    mutable std::vector<btVector3> m_sums;   ///< scratch of Precondition, by soft body
    /// By node its displacement, by rigid body translation and rotation, by multibody its unknowns.
    Vector m_x;
    btScalar m_reach2 = 0; ///< square of how far nodes may be displaced
    Vector m_forcesOfSprings, m_right, m_residual, m_preconditioned, m_direction, m_image;
};

#endif
