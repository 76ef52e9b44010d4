// The elasticity that resists displacements of the nodes of soft bodies over a step; masses resist them besides.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_NODE_ELASTICITY_H
#define QC_GLUE_SOFT_BODY_RESPONSE_NODE_ELASTICITY_H

#include "soft_body/scene/scene_soft_body.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btAlignedObjectArray.h>
#include <LinearMath/btMatrix3x3.h>

#include <vector>

class qcNodeElasticity
{
  public:
    using Vector = btAlignedObjectArray<btVector3>;

    /// A soft body, and the mass of what presses on it.
    struct LoadedBody
    {
        qcSceneSoftBody* soft;
        btScalar load;
    };

    virtual ~qcNodeElasticity() = default;
    /// False: Bullet moves nodes by positions. A body that followed them would gain energy.
    virtual bool KeepsEnergy() const = 0;
    /// False: elasticity may help displacements of bodies that are far from their shape at rest.
    virtual bool AlwaysResists() const = 0;
    /// The most iterations that a solution of the system is worth in a round, from 0. Later rounds go on from the one
    /// before, with a few springs changed.
    virtual int MaxIterations(int round) const = 0;
    /// Stiffness of a contact's spring, in units of that of its nodes with all others fixed. Softer ones leave more of
    /// a load to the contacts that follow, which know no elasticity; stiffer ones take more iterations.
    virtual btScalar SpringStiffness() const = 0;
    /// True if contacts of the body count.
    virtual bool Covers(const qcSceneSoftBody& soft) const = 0;
    /// True if they count while rigid bodies lie on it that weigh more than a share of what it does.
    virtual bool CoversUnderLoad(const qcSceneSoftBody&) const
    {
        return false;
    }
    /// True if only rigid bodies that can move strain the bodies. Otherwise all that touches them does.
    virtual bool IsStrainedByRigidsOnly() const = 0;
    /// True if a rigid body that touches a soft one, which is on the side of the normal, may need to be borne.
    virtual bool MayLie(const btRigidBody& rigid, const btVector3& normal) const = 0;
    /// True if a body needs its elasticity to bear a rigid body that contacts have pushed it out of by this much in a
    /// step.
    virtual bool IsStrain(const qcSceneSoftBody& soft, btScalar pushed) const = 0;
    /// Reads the bodies of this step, and numbers their nodes. False: there are no numbers, or nothing resists.
    virtual bool Begin(const std::vector<LoadedBody>& bodies, btScalar timeStep) = 0;
    /// Ends what a Begin that returned true has begun, before nodes are moved.
    virtual void End()
    {
    }
    /// The number of the first node of one of the bodies; the others follow in their order.
    virtual int FirstNodeOf(size_t body) const = 0;
    /// One more than the largest number.
    virtual int NodeCount() const = 0;
    /// True if something that Bullet doesn't move holds a node where it is, though it has a mass.
    virtual bool IsHeld(int number) const = 0;
    /// Reads what a solution does to the forces: displacements by node.
    virtual void Update(const Vector& x) = 0;
    /// Adds the forces against displacements by node, times the square of the time step.
    virtual void AddForces(const Vector& x, Vector* to) const = 0;
    /// Adds what resists the displacement of each node while the others stay, in these units. `isNode`: by number.
    virtual void AddDiagonal(const std::vector<bool>& isNode, std::vector<btMatrix3x3>* to) = 0;
    /// Displaces a node of one of the bodies, and gives it the velocity that leads there.
    virtual void Move(size_t body, btSoftBody::Node* node, const btVector3& by) const = 0;
};

inline void qcSetZero(qcNodeElasticity::Vector* x)
{
    for (int i = 0; i < x->size(); i++)
        (*x)[i].setZero();
}

/// Adds a multiple of x to y, which is as long. Over scalars, the fourth of each vector too: such loops become vector
/// instructions.
inline void qcAddScaled(btScalar factor, const qcNodeElasticity::Vector& x, qcNodeElasticity::Vector* y)
{
    if (x.size() == 0)
        return;
    const btScalar* from = x[0];
    btScalar* to = (*y)[0];
    for (int i = 0; i < 4 * x.size(); i++)
        to[i] += factor * from[i];
}

#endif
