// A program for Bullet alone: boxes fall on a floor, once on each of two of Bullet's broadphases. It is built twice, as
// it is and with swapped_broadphase.h included first, and both print the same.
#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <memory>
#include <vector>

static void Simulate(btBroadphaseInterface* broadphase)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, broadphase, &solver, &configuration);
    world.getDispatchInfo().m_deterministicOverlappingPairs = true;
    btBoxShape floor(btVector3(20, 1, 20)), box(btVector3(btScalar(0.5), btScalar(0.4), btScalar(0.3)));
    btVector3 inertia;
    box.calculateLocalInertia(1, inertia);
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    bodies.push_back(std::make_unique<btRigidBody>(btScalar(0), nullptr, &floor));
    for (int i = 0; i < 30; i++)
    {
        bodies.push_back(std::make_unique<btRigidBody>(btScalar(1), nullptr, &box, inertia));
        const btVector3 place(btScalar(i * 7 % 5) * btScalar(0.8), btScalar(i) * btScalar(0.4) + 2,
                              btScalar(i * 3 % 4) * btScalar(0.7));
        bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
        bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    }
    for (const auto& body : bodies)
        world.addRigidBody(body.get());
    for (int step = 0; step < 120; step++)
        world.stepSimulation(btScalar(1) / 60, 0);
    for (const auto& body : bodies)
    {
        const btVector3& place = body->getWorldTransform().getOrigin();
        const btVector3 from(place.x(), 30, place.z()), to(place.x(), -3, place.z());
        btCollisionWorld::ClosestRayResultCallback ray(from, to);
        world.rayTest(from, to, ray);
        std::printf("%a %a %a, a ray at %.5f\n", double(place.x()), double(place.y()), double(place.z()),
                    double(ray.m_closestHitFraction));
    }
    for (const auto& body : bodies)
        world.removeRigidBody(body.get());
}

int main()
{
    std::unique_ptr<btBroadphaseInterface> tree(new btDbvtBroadphase());
    Simulate(tree.get());
    btAxisSweep3 sweep(btVector3(-50, -50, -50), btVector3(50, 50, 50));
    Simulate(&sweep);
    return 0;
}
