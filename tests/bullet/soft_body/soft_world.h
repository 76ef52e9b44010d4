// Bullet's soft-rigid world with our broadphase and our solver of soft bodies.
#ifndef QC_TESTS_BULLET_SOFT_BODY_SOFT_WORLD_H
#define QC_TESTS_BULLET_SOFT_BODY_SOFT_WORLD_H

#include "quickcullide/bullet.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <vector>

/// Whoever adds to it takes off again.
struct qcSoftWorld
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver;
    btSoftRigidDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration, &softSolver};
    std::vector<btSoftBody*> cloths;

    explicit qcSoftWorld(qcDevice* device = nullptr) : softSolver(device)
    {
        world.getWorldInfo().m_gravity = world.getGravity();
        softSolver.setThreadCount(1);
    }
};

#endif
