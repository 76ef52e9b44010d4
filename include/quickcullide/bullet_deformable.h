// Self-collision of deformable bodies, contact among them and with qcMeshShape, in place of VF_DD:
//
//     btDeformableBodySolver deformableSolver;
//     btDeformableMultiBodyConstraintSolver solver;
//     solver.setDeformableSolver(&deformableSolver);
//     qcDeformableWorld world(&dispatcher, &broadphase, &solver, &configuration, &deformableSolver);
//
// Bullet's own self-collision of deformable bodies (VF_DD with setSelfCollision) looks at vertices and faces only, not
// at pairs of edges, leaves patches out by their normals alone, and answers with impulses after its implicit solve.
#ifndef QUICKCULLIDE_BULLET_DEFORMABLE_H
#define QUICKCULLIDE_BULLET_DEFORMABLE_H

#include "bullet_soft_body.h"

#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>

/// A drop-in for btDeformableMultiBodyDynamicsWorld, which differs in contact among soft bodies and with qcMeshShape
/// only: bodies move as Bullet has it, then nodes are moved apart and their velocities with them, as qcSoftBodySolver
/// does. VF_DD and btSoftBody::setSelfCollision are not asked, qcSoftBodySettings::selfCollision is; Bullet's repulsion
/// and its geometric collisions don't run.
///
/// Nodes with an anchor and bodies of the reduced model are not moved by contacts; others are kept off them.
///
/// Destroy it before the dispatcher and the device.
class QC_API qcDeformableWorld : public btDeformableMultiBodyDynamicsWorld, public qcSoftBodyContact
{
  public:
    qcDeformableWorld(btDispatcher* dispatcher, btBroadphaseInterface* broadphase,
                      btDeformableMultiBodyConstraintSolver* constraintSolver,
                      btCollisionConfiguration* collisionConfiguration, btDeformableBodySolver* deformableSolver,
                      qcDevice* device = nullptr);
    ~qcDeformableWorld() override;

  protected:
    void internalSingleStepSimulation(btScalar timeStep) override;
    void integrateTransforms(btScalar timeStep) override;
};

#endif
