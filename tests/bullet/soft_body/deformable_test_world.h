// Bullet's worlds of deformable bodies with this library's broadphase.
#ifndef QC_TESTS_BULLET_SOFT_BODY_DEFORMABLE_TEST_WORLD_H
#define QC_TESTS_BULLET_SOFT_BODY_DEFORMABLE_TEST_WORLD_H

#include "quickcullide/bullet.h"
#include "quickcullide/bullet_deformable.h"

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>

#include <memory>
#include <vector>

/// A deformable world: qcDeformableWorld, or Bullet's own. It removes and deletes the soft bodies in its list.
template <class DeformableWorld, class Dispatcher = btCollisionDispatcher> struct qcDeformableTestWorld
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    Dispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btDeformableBodySolver deformableSolver;
    btDeformableMultiBodyConstraintSolver solver;
    std::unique_ptr<DeformableWorld> world;
    std::vector<btSoftBody*> cloths;

    qcDeformableTestWorld()
    {
        solver.setDeformableSolver(&deformableSolver);
        world.reset(new DeformableWorld(&dispatcher, &broadphase, &solver, &configuration, &deformableSolver));
    }

    ~qcDeformableTestWorld()
    {
        for (btSoftBody* cloth : cloths)
        {
            world->removeSoftBody(cloth);
            delete cloth;
        }
    }
    qcDeformableTestWorld(const qcDeformableTestWorld&) = delete;
    qcDeformableTestWorld& operator=(const qcDeformableTestWorld&) = delete;
};

#endif
