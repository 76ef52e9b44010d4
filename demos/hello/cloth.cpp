// Cloth with self-collision in btSoftRigidDynamicsWorld. Returns 0 if no two triangles penetrate.
#include <quickcullide/bullet.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>

int main()
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase; // instead of btDbvtBroadphase
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver; // self-collision of soft bodies
    btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &softSolver);

    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 2, -1), btVector3(1, 2, -1),
                                                       btVector3(-1, 2, 1), btVector3(1, 2, 1), 40, 40, 0, true);
    cloth->m_cfg.piterations = 4; // at Bullet's default of 1 cloth may tremble
    world.addSoftBody(cloth);
    for (int i = 0; i < 10; i++)
        world.stepSimulation(btScalar(1.0 / 60));
    int status = softSolver.getStatistics().remaining == 0 ? 0 : 1; // pairs that penetrate
    world.removeSoftBody(cloth);
    delete cloth;
    return status;
}
