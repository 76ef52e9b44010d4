// A world with soft bodies, by this library or by Bullet alone: what the scenes of `qc-bench soft` share.
#ifndef QC_DEMOS_BENCH_SOFT_SOFT_SCENE_H
#define QC_DEMOS_BENCH_SOFT_SOFT_SCENE_H

#include "quickcullide/bullet.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <memory>

/// Members are in the order in which Bullet requires them to be made; they are destroyed in the opposite order, after
/// those of the scene that derives from this one.
class qcSoftScene
{
  public:
    /// `ours`: soft bodies are solved by qcSoftBodySolver; otherwise by btDefaultSoftBodySolver.
    explicit qcSoftScene(bool ours)
    {
        btSoftBodySolver* softSolver = ours ? static_cast<btSoftBodySolver*>(&quick) : &bullets;
        world.reset(new btSoftRigidDynamicsWorld(&dispatcher, &broadphase, &solver, &configuration, softSolver));
        world->getWorldInfo().m_gravity = world->getGravity();
    }
    qcSoftScene(const qcSoftScene&) = delete;
    qcSoftScene& operator=(const qcSoftScene&) = delete;

    void Step(btScalar timeStep = btScalar(1.0 / 60))
    {
        world->stepSimulation(timeStep, 0);
    }

    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver quick;
    btDefaultSoftBodySolver bullets;
    qcMeshContact contact; ///< for scenes that add it to the world
    std::unique_ptr<btSoftRigidDynamicsWorld> world;
};

#endif
