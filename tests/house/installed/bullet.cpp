// A ball falls to the ground in a Bullet world with our broadphase and soft-body solver, through the installed headers.
#include <quickcullide/bullet.h>

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstdio>

int main()
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver;
    btScalar height;
    {
        btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &softSolver);
        btBoxShape box(btVector3(10, 1, 10));
        btSphereShape sphere(1);
        btRigidBody ground(0, nullptr, &box);
        btRigidBody ball(1, nullptr, &sphere, btVector3(1, 1, 1));
        btTransform start = btTransform::getIdentity();
        start.setOrigin(btVector3(0, 5, 0));
        ball.setWorldTransform(start);
        world.addRigidBody(&ground);
        world.addRigidBody(&ball);
        for (int i = 0; i < 240; ++i)
            world.stepSimulation(btScalar(1) / 60, 0);
        height = ball.getWorldTransform().getOrigin().y();
        world.removeRigidBody(&ball);
        world.removeRigidBody(&ground);
    }
    std::printf("rests at %g\n", double(height));
    return std::fabs(double(height) - 2) < 0.1 ? 0 : 1;
}
