// A program for Bullet alone: it creates btDbvtBroadphases in all possible ways, and prints their results.
#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <memory>
#include <vector>

namespace
{
/// A derived class, as some programs have: it overrides a function.
struct Derived : btDbvtBroadphase
{
    int boxes = 0;

    void setAabb(btBroadphaseProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                 btDispatcher* dispatcher) override
    {
        boxes++;
        btDbvtBroadphase::setAabb(proxy, aabbMin, aabbMax, dispatcher);
    }
};

/// Balls and boxes fall on a floor; contacts and hits of rays, to the last bit.
void Simulate(const char* name, btBroadphaseInterface& broadphase)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    world.getDispatchInfo().m_deterministicOverlappingPairs = true;
    btBoxShape floor(btVector3(20, 1, 20)), box(btVector3(btScalar(0.5), btScalar(0.4), btScalar(0.3)));
    btSphereShape ball(btScalar(0.4));
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    for (int i = 0; i < 40; i++)
    {
        btCollisionShape* shape = i == 0 ? static_cast<btCollisionShape*>(&floor) : &box;
        if (i % 2 == 1)
            shape = &ball;
        btVector3 inertia(0, 0, 0);
        const btScalar mass = i == 0 ? btScalar(0) : btScalar(1);
        if (i > 0)
            shape->calculateLocalInertia(mass, inertia);
        bodies.push_back(std::make_unique<btRigidBody>(mass, nullptr, shape, inertia));
        const btVector3 place(btScalar(i * 7 % 5) * btScalar(0.8), btScalar(i) * btScalar(0.4) - 1,
                              btScalar(i * 3 % 4) * btScalar(0.7));
        bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
        // Bullet's trees keep more pairs, so bodies sleep later there.
        bodies.back()->setActivationState(DISABLE_DEACTIVATION);
        world.addRigidBody(bodies.back().get());
    }
    for (int step = 1; step <= 150; step++)
    {
        world.stepSimulation(btScalar(1) / 60, 0);
        if (step == 100)
        {
            world.removeRigidBody(bodies.back().get());
            bodies.pop_back();
        }
        if (step % 10 != 0)
            continue;
        int contacts = 0;
        for (int i = 0; i < dispatcher.getNumManifolds(); i++)
            contacts += dispatcher.getManifoldByIndexInternal(i)->getNumContacts();
        const btVector3 place = bodies[size_t(step / 10)]->getWorldTransform().getOrigin();
        const btVector3 from(-9, btScalar(0.2), 1), to(9, btScalar(0.6), 1);
        btCollisionWorld::ClosestRayResultCallback ray(from, to);
        world.rayTest(from, to, ray);
        std::printf("%s %d: %d contacts, body at %a %a %a, ray at %.5f\n", name, step, contacts, double(place.x()),
                    double(place.y()), double(place.z()), double(ray.m_closestHitFraction));
    }
    while (!bodies.empty())
    {
        world.removeRigidBody(bodies.back().get());
        bodies.pop_back();
    }
}
} // namespace

int main()
{
    std::unique_ptr<btBroadphaseInterface> heap(new btDbvtBroadphase);
    Simulate("on the heap", *heap);
    auto* seen = dynamic_cast<btDbvtBroadphase*>(heap.get());
    std::printf("its type is %s\n", seen != nullptr ? "known" : "unknown");
    heap.reset();

    btDbvtBroadphase stack;
    stack.setVelocityPrediction(0);
    stack.optimize();
    Simulate("on the stack", stack);
    btVector3 aabbMin(1, 1, 1), aabbMax(1, 1, 1);
    stack.getBroadphaseAabb(aabbMin, aabbMax);
    stack.resetPool(nullptr);
    std::printf("%d pairs are left, prediction %g\n", stack.getOverlappingPairCache()->getNumOverlappingPairs(),
                double(stack.getVelocityPrediction()));

    btHashedOverlappingPairCache cache;
    {
        btDbvtBroadphase withCache(&cache);
        std::printf("the cache is %s\n", withCache.getOverlappingPairCache() == &cache ? "the given one" : "another");
        btBroadphaseProxy* proxies[2];
        for (btBroadphaseProxy*& proxy : proxies)
            proxy = withCache.createProxy(btVector3(0, 0, 0), btVector3(1, 1, 1), 0, nullptr, 1, -1, nullptr);
        withCache.collide(nullptr);
        std::printf("%d pair\n", cache.getNumOverlappingPairs());
        for (btBroadphaseProxy* proxy : proxies)
        {
            withCache.setAabbForceUpdate(proxy, btVector3(2, 2, 2), btVector3(3, 3, 3), nullptr);
            withCache.destroyProxy(proxy, nullptr);
        }
        std::printf("%d pairs\n", cache.getNumOverlappingPairs());
    }

    Derived derived;
    Simulate("derived", derived);
    std::printf("derived: %d boxes\n", derived.boxes);

    // btAxisSweep3 creates a btDbvtBroadphase for its rays.
    bt32BitAxisSweep3 sweep(btVector3(-50, -50, -50), btVector3(50, 50, 50));
    Simulate("axis sweep", sweep);
    return 0;
}
