// A world with soft bodies, by this library or by Bullet alone: what the scenes of `qc-bench soft` share.
#ifndef QC_DEMOS_BENCH_SOFT_SOFT_SCENE_H
#define QC_DEMOS_BENCH_SOFT_SOFT_SCENE_H

#include "quickcullide/bullet.h"

#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include <memory>
#include <vector>

/// A torus around the z axis: three numbers a point, three indices a triangle.
struct qcTorus
{
    std::vector<btScalar> points;
    std::vector<int> indices;

    /// `radius`: of the circle of the tube's centres; `tube`: of the tube; `around`, `across`: points along both
    /// circles.
    qcTorus(btScalar radius, btScalar tube, int around, int across)
    {
        for (int i = 0; i < around; i++)
            for (int j = 0; j < across; j++)
            {
                btScalar a = SIMD_2_PI * btScalar(i) / btScalar(around), b = SIMD_2_PI * btScalar(j) / btScalar(across);
                btScalar far = radius + tube * btCos(b);
                points.insert(points.end(), {far * btCos(a), far * btSin(a), tube * btSin(b)});
                int here = i * across, right = (i + 1) % around * across, up = (j + 1) % across;
                indices.insert(indices.end(), {here + j, right + j, right + up, here + j, right + up, here + up});
            }
    }
};

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
