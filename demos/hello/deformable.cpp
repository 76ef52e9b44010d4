// Cloth over a mesh in the deformable world: qcDeformableWorld in place of btDeformableMultiBodyDynamicsWorld. Returns
// 0 if the cloth touched something and no two triangles penetrate.
#include <quickcullide/bullet.h>
#include <quickcullide/bullet_deformable.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

int main()
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase; // instead of btDbvtBroadphase
    btDeformableBodySolver deformableSolver;
    btDeformableMultiBodyConstraintSolver solver;
    solver.setDeformableSolver(&deformableSolver);
    qcDeformableWorld world(&dispatcher, &broadphase, &solver, &configuration, &deformableSolver);

    const float corners[] = {-5, 0, -5, 5, 0, -5, -5, 0, 5, 5, 0, 5};
    const uint32_t indices[] = {0, 2, 3, 0, 3, 1};
    qcMeshShape ground(corners, qc_positionF32, 0, 4, indices, 2);
    btRigidBody floor(0, nullptr, &ground);
    world.addRigidBody(&floor);
    btDeformableMassSpringForce springs(10, btScalar(0.05), true);
    btDeformableGravityForce gravity(world.getGravity());
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch( // upright: it falls in folds
        world.getWorldInfo(), btVector3(-1, 1, 0) / 2, btVector3(1, 1, 0) / 2, btVector3(-1, 3, btScalar(0.1)) / 2,
        btVector3(1, 3, btScalar(0.1)) / 2, 15, 15, 0, true);
    cloth->setTotalMass(btScalar(0.5));
    world.addSoftBody(cloth);
    world.addForce(cloth, &springs);
    world.addForce(cloth, &gravity);
    int status = 0, contacts = 0;
    for (int i = 0; i < 240; i++)
    {
        world.stepSimulation(btScalar(1.0 / 240), 0);
        contacts += world.getStatistics().contacts;
        status = world.getStatistics().remaining == 0 ? status : 1; // pairs that penetrate
    }
    world.removeSoftBody(cloth);
    delete cloth;
    world.removeRigidBody(&floor);
    return contacts > 0 ? status : 1;
}
