// A Bullet world with qcBroadphase: ten towers of boxes, a sensor and a ray. Returns 0 if the towers stand, the ray
// hits the topmost box and the sensor overlaps something.
#include <quickcullide/bullet_broadphase.h>
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <btBulletDynamicsCommon.h>
#include <memory>
#include <vector>

int main()
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase; // instead of btDbvtBroadphase
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);

    btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
    btRigidBody ground(0, nullptr, &plane);
    world.addRigidBody(&ground);
    btBoxShape box(btVector3(1, 1, 1) / 2);
    btVector3 inertia;
    box.calculateLocalInertia(1, inertia);
    std::vector<std::unique_ptr<btRigidBody>> boxes;
    for (int i = 0; i < 100; i++) // ten towers
    {
        boxes.push_back(std::make_unique<btRigidBody>(btScalar(1), nullptr, &box, inertia));
        boxes.back()->setWorldTransform(btTransform(
            btQuaternion::getIdentity(), btVector3(btScalar(3 * (i % 10)), btScalar(i / 10) + btScalar(0.5), 0)));
        world.addRigidBody(boxes.back().get());
    }
    btGhostPairCallback ghostPairs; // sensors work as before
    world.getPairCache()->setInternalGhostPairCallback(&ghostPairs);
    btPairCachingGhostObject sensor;
    sensor.setCollisionShape(&box);
    sensor.setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
    sensor.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 5, 0)));
    world.addCollisionObject(&sensor, btBroadphaseProxy::SensorTrigger,
                             btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter);
    for (int i = 0; i < 120; i++)
        world.stepSimulation(btScalar(1.0 / 60));

    btVector3 from(27, 20, 0), to(27, 0, 0);
    btCollisionWorld::ClosestRayResultCallback ray(from, to);
    world.rayTest(from, to, ray); // hits the topmost box
    bool stands = ray.hasHit() && ray.m_hitPointWorld.y() > btScalar(9.9);
    int sensed = sensor.getNumOverlappingObjects();
    world.removeCollisionObject(&sensor);
    for (auto& body : boxes)
        world.removeRigidBody(body.get());
    world.removeRigidBody(&ground);
    return stands && sensed > 0 ? 0 : 1;
}
