// Stiffness and damping of Bullet's forces on bodies of tetrahedra and on sheets that carry, in the deformable world.
//
// Bullet solves elasticity before contacts are found here, and these move a node by its own mass: what surrounds it
// bears on the other side from the next step on only. In stiff bodies the nodes' masses are next to nothing, so one
// that carried several times its mass was crushed.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_DEFORMABLE_ELASTICITY_H
#define QC_GLUE_SOFT_BODY_RESPONSE_DEFORMABLE_ELASTICITY_H

#include "common/object_key.h"
#include "soft_body/response/node_elasticity.h"

#include <BulletSoftBody/btDeformableBackwardEulerObjective.h>

class btDeformableBodySolver;

class qcDeformableElasticity : public qcNodeElasticity
{
  public:
    /// The solver of the world; it must outlive this.
    explicit qcDeformableElasticity(const btDeformableBodySolver* solver) : m_solver(solver)
    {
    }
    bool KeepsEnergy() const override
    {
        return true;
    }
    bool AlwaysResists() const override
    {
        return false;
    }
    int MaxIterations(int) const override
    {
        return 100;
    }
    btScalar SpringStiffness() const override
    {
        return 20;
    }
    bool Covers(const qcSceneSoftBody& soft) const override;
    bool CoversUnderLoad(const qcSceneSoftBody& soft) const override;
    bool IsStrainedByRigidsOnly() const override
    {
        return false;
    }
    bool MayLie(const btRigidBody&, const btVector3&) const override
    {
        return true;
    }
    bool IsStrain(const qcSceneSoftBody&, btScalar) const override
    {
        return true;
    }
    bool Begin(const std::vector<LoadedBody>& bodies, btScalar timeStep) override;
    void End() override;
    int FirstNodeOf(size_t body) const override
    {
        return m_bodies[body].soft->body->m_nodes[0].index;
    }
    int NodeCount() const override;
    bool IsHeld(int) const override
    {
        return false;
    }
    void Update(const Vector&) override
    {
    }
    void AddForces(const Vector& x, Vector* to) const override;
    void AddDiagonal(const std::vector<bool>& isNode, std::vector<btMatrix3x3>* to) override;
    void Move(size_t body, btSoftBody::Node* node, const btVector3& by) const override;

  private:
    struct PressedLink
    {
        btSoftBody::Link* link;
        btScalar restLength;
    };

    void RelaxPressedLinks();
    void FindDiagonal(const std::vector<bool>& isNode);

    const btDeformableBodySolver* m_solver;
    btScalar m_timeStep = 0;
    std::vector<LoadedBody> m_bodies;
    std::vector<btDeformableLagrangianForce*> m_forces;
    /// Links shorter than at rest. For a step they are at rest as they are: Bullet's stiffness of a pressed link is
    /// negative across it, and a body of such links has displacements that nothing resists.
    std::vector<PressedLink> m_pressed;
    /// A third of the trace of each node's diagonal block, which rotations don't change. It is found for these bodies
    /// and forces, and again after a while.
    std::vector<btScalar> m_diagonal;
    std::vector<qcObjectKey> m_bodiesOfDiagonal;
    std::vector<btDeformableLagrangianForce*> m_forcesOfDiagonal;
    btScalar m_stepOfDiagonal = 0;
    int m_ageOfDiagonal = 0;
};

#endif
