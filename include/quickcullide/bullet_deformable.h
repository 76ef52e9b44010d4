/// @file
/// Self-collision of deformable bodies, and contact among them and with rigid bodies, in place of VF_DD:
///
///     qcDeformableWorld world(&dispatcher, &broadphase, &solver, &configuration, &deformableSolver);
///
/// Bullet's own self-collision of deformable bodies (VF_DD with setSelfCollision) tests vertices against faces but not
/// edges against edges, excludes patches by their normals alone, and applies impulses after its implicit solve.
#ifndef QUICKCULLIDE_BULLET_DEFORMABLE_H
#define QUICKCULLIDE_BULLET_DEFORMABLE_H

#include "bullet_soft_body.h"

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>

/// A drop-in for btDeformableMultiBodyDynamicsWorld. Only contact among soft bodies and with rigid ones differs:
/// Bullet moves the bodies, then nodes are moved apart and their velocities adapted, as qcSoftBodySolver does.
/// qcSoftBodySettings::selfCollision replaces VF_DD and btSoftBody::setSelfCollision, which are ignored; Bullet's
/// repulsion and its geometric collisions don't run.
///
/// Bodies of tetrahedra, pinned and anchored sheets, and free ones under rigid bodies of at least half their mass,
/// carry loads with their elasticity: a linear system for those that touch each other or rigid bodies, about as much
/// work as Bullet's implicit solver. Contacts that are a step old take part.
///
/// Contacts move nodes that are anchored to a dynamic rigid body together with it. They don't move nodes on other
/// anchors and bodies of the reduced model; other bodies are kept away from these.
///
/// Destroy it before the dispatcher and the device. Thread-safety: as Bullet's world.
class QC_API qcDeformableWorld : public btDeformableMultiBodyDynamicsWorld, public qcSoftBodyContact
{
  public:
    /// Parameters of btDeformableMultiBodyDynamicsWorld, and a device: it runs the methods that need GL; null is the
    /// same as a device of kind none.
    qcDeformableWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                      btDeformableMultiBodyConstraintSolver* constraintSolver,
                      btCollisionConfiguration* collisionConfiguration, btDeformableBodySolver* deformableSolver,
                      qcDevice* device = nullptr);
    ~qcDeformableWorld() override;

  protected:
    /// One step of Bullet's, then manifolds and callbacks.
    void internalSingleStepSimulation(btScalar timeStep) override;
    /// Bullet's integration, then the contacts of this class.
    void integrateTransforms(btScalar timeStep) override;
};

#endif
