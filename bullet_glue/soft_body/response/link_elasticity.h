// Links of sheets that are held, by pinned nodes or anchors, as springs, for what presses on them in the classic world.
//
// Bullet moves the nodes of a link by their own masses, and contacts move nodes by theirs: a node transmits at most the
// force of its mass times its displacement over the square of the step. So a ball of kilograms drew nodes of grams out
// of a sheet until links pulled them back by decimetres in each step.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_LINK_ELASTICITY_H
#define QC_GLUE_SOFT_BODY_RESPONSE_LINK_ELASTICITY_H

#include "soft_body/response/node_elasticity.h"

class qcLinkElasticity : public qcNodeElasticity
{
  public:
    bool KeepsEnergy() const override
    {
        return false;
    }
    bool AlwaysResists() const override
    {
        return true;
    }
    int MaxIterations(int round) const override
    {
        return round == 0 ? 30 : 15;
    }
    btScalar SpringStiffness() const override
    {
        return btScalar(0.5);
    }
    bool Covers(const qcSceneSoftBody& soft) const override;
    bool IsStrainedByRigidsOnly() const override
    {
        return true;
    }
    bool MayLie(const btRigidBody& rigid, const btVector3& normal) const override;
    bool IsStrain(const qcSceneSoftBody& soft, btScalar pushed) const override;
    bool Begin(const std::vector<LoadedBody>& bodies, btScalar timeStep) override;
    int FirstNodeOf(size_t body) const override
    {
        return m_firstNodes[body];
    }
    int NodeCount() const override
    {
        return m_firstNodes.back();
    }
    bool IsHeld(int number) const override
    {
        return m_isHeld[size_t(number)];
    }
    void Update(const Vector& x) override;
    void AddForces(const Vector& x, Vector* to) const override;
    void AddDiagonal(const std::vector<bool>& isNode, std::vector<btMatrix3x3>* to) override;
    void Move(size_t body, btSoftBody::Node* node, const btVector3& by) const override;

  private:
    struct Spring
    {
        int nodes[2];
        btVector3 direction;
        btScalar length, stiffness;
        btScalar tension; ///< over the length: what resists displacements across the link
    };

    std::vector<btScalar> m_perDistance; ///< by body: velocity of a node for its motion in the step
    std::vector<int> m_firstNodes;       ///< by body; then the number of nodes
    std::vector<bool> m_isHeld;          ///< by number: anchored to what Bullet doesn't move
    std::vector<Spring> m_springs;
};

#endif
