// Random worlds: shapes, changes, and queries beside btDbvtBroadphase.
#include "bullet/broadphase/random_worlds.h"

#include "bullet/broadphase/broadphase_model.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btHeightfieldTerrainShape.h>

#include <cstring>

namespace
{
constexpr uint32_t qc_maxObjects = 70;

/// An object that was hit, and the fraction of the way.
typedef std::pair<int, btScalar> Hit;

struct AllRayHits : btCollisionWorld::RayResultCallback
{
    std::vector<Hit> hits;

    btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool) override
    {
        hits.push_back({result.m_collisionObject->getWorldArrayIndex(), result.m_hitFraction});
        return m_closestHitFraction;
    }
};

struct AllSweepHits : btCollisionWorld::ConvexResultCallback
{
    std::vector<Hit> hits;

    btScalar addSingleResult(btCollisionWorld::LocalConvexResult& result, bool) override
    {
        hits.push_back({result.m_hitCollisionObject->getWorldArrayIndex(), result.m_hitFraction});
        return m_closestHitFraction;
    }
};

/// Hits of a ray and of a sphere between two points.
struct Answers
{
    std::vector<Hit> rayHits, sweepHits;
    btScalar rayFraction, sweepFraction; ///< of the nearest hits

    Answers(const btCollisionWorld& world, const btVector3& from, const btVector3& to)
    {
        const btSphereShape ball(btScalar(0.4));
        const btTransform start(btQuaternion::getIdentity(), from), end(btQuaternion::getIdentity(), to);
        AllRayHits allRay;
        world.rayTest(from, to, allRay);
        AllSweepHits allSweep;
        world.convexSweepTest(&ball, start, end, allSweep);
        btCollisionWorld::ClosestRayResultCallback ray(from, to);
        world.rayTest(from, to, ray);
        btCollisionWorld::ClosestConvexResultCallback sweep(from, to);
        world.convexSweepTest(&ball, start, end, sweep);
        rayHits = std::move(allRay.hits);
        sweepHits = std::move(allSweep.hits);
        std::sort(rayHits.begin(), rayHits.end());
        std::sort(sweepHits.begin(), sweepHits.end());
        rayFraction = ray.m_closestHitFraction;
        sweepFraction = sweep.m_closestHitFraction;
    }
};

void Append(uint64_t* hash, const btVector3& v)
{
    for (int k = 0; k < 3; k++)
    {
        unsigned char bytes[sizeof(btScalar)];
        memcpy(bytes, &v[k], sizeof bytes);
        for (unsigned char byte : bytes)
            *hash = (*hash ^ byte) * 0x100000001b3;
    }
}
} // namespace

btScalar qcRandomWorld::Uniform(double lower, double upper)
{
    return btScalar(qcRandom_Uniform(&m_random, lower, upper));
}

btVector3 qcRandomWorld::Point(double lower, double upper)
{
    btScalar x = Uniform(lower, upper), y = Uniform(lower, upper);
    return btVector3(x, y, Uniform(lower, upper));
}

btTransform qcRandomWorld::Place()
{
    btQuaternion turn(Uniform(-3, 3), Uniform(-3, 3), Uniform(-3, 3));
    return btTransform(turn, Point(-5, 5) + btVector3(0, 6, 0));
}

uint32_t qcRandomWorld::Below(uint32_t bound)
{
    return qcRandom_Below(&m_random, bound);
}

void qcRandomWorld::MakeShapes()
{
    m_movable.push_back(world.Make<btBoxShape>(Point(0.2, 0.8)));
    m_movable.push_back(world.Make<btSphereShape>(Uniform(0.2, 0.7)));
    m_movable.push_back(world.Make<btCapsuleShape>(Uniform(0.2, 0.4), Uniform(0.2, 1)));
    m_movable.push_back(world.Make<btCylinderShape>(Point(0.2, 0.6)));
    m_movable.push_back(world.Make<btConeShape>(Uniform(0.2, 0.6), Uniform(0.4, 1)));
    btConvexHullShape* hull = world.Make<btConvexHullShape>();
    for (uint32_t points = 8 + Below(12); points > 0; points--)
        hull->addPoint(Point(-0.6, 0.6));
    m_movable.push_back(hull);
    btCompoundShape* compound = world.Make<btCompoundShape>();
    for (uint32_t parts = 2 + Below(3); parts > 0; parts--)
        compound->addChildShape(btTransform(btQuaternion(Uniform(-3, 3), 0, 0), Point(-0.7, 0.7)),
                                m_movable[Below(uint32_t(m_movable.size()))]);
    m_movable.push_back(compound);
}

void qcRandomWorld::MakeMesh()
{
    m_hills = std::make_unique<qcHills>(10, btScalar(1), [this](int, int) { return Uniform(0, 1); });
    world.AddBody(0, btVector3(0, 0, 0), world.Make<btBvhTriangleMeshShape>(&m_hills->mesh, true));
}

void qcRandomWorld::MakeScenery()
{
    world.AddBody(0, btVector3(0, -1, 0), world.Make<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
    world.AddBody(0, btVector3(12, 0, 0), world.Make<btStaticPlaneShape>(btVector3(-1, 0, 0), btScalar(0)));
    MakeMesh();
    const int side = 11;
    for (int i = 0; i < side * side; i++)
        m_heights.push_back(float(Uniform(-0.5, 0.5)));
    world.AddBody(
        0, btVector3(5, 0, 0),
        world.Make<btHeightfieldTerrainShape>(side, side, m_heights.data(), btScalar(-1), btScalar(1), 1, false));
    m_sceneryCount = int(world.objects.size());
}

void qcRandomWorld::AddGhost()
{
    std::unique_ptr<btGhostObject> ghost;
    if (Below(2) == 0)
        ghost = std::make_unique<btPairCachingGhostObject>();
    else
        ghost = std::make_unique<btGhostObject>();
    ghost->setCollisionShape(m_movable[Below(uint32_t(m_movable.size() - 1))]);
    ghost->setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
    ghost->setWorldTransform(Place());
    world.AddObject(std::move(ghost), btBroadphaseProxy::SensorTrigger,
                    btBroadphaseProxy::AllFilter & ~btBroadphaseProxy::SensorTrigger);
}

void qcRandomWorld::AddSomething()
{
    btCollisionShape* shape = m_movable[Below(uint32_t(m_movable.size()))];
    switch (Below(12))
    {
        case 0: AddGhost(); return;
        case 1: world.AddBody(0, Place(), shape, btBroadphaseProxy::StaticFilter, btBroadphaseProxy::AllFilter); return;
        case 2:
        {
            btRigidBody* body =
                world.AddBody(0, Place(), shape, btBroadphaseProxy::KinematicFilter, btBroadphaseProxy::AllFilter);
            body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
            body->setActivationState(DISABLE_DEACTIVATION);
            return;
        }
        default:
        {
            // Some are debris, which does not collide with debris.
            const bool debris = Below(5) == 0;
            btRigidBody* body =
                world.AddBody(Uniform(0.5, 2), Place(), shape,
                              debris ? btBroadphaseProxy::DebrisFilter : btBroadphaseProxy::DefaultFilter,
                              debris ? btBroadphaseProxy::AllFilter & ~btBroadphaseProxy::DebrisFilter
                                     : btBroadphaseProxy::AllFilter);
            body->setLinearVelocity(Point(-3, 3));
            body->setAngularVelocity(Point(-3, 3));
            if (Below(8) == 0)
            {
                body->setCcdMotionThreshold(btScalar(0.1));
                body->setCcdSweptSphereRadius(btScalar(0.1));
            }
        }
    }
}

qcRandomWorld::qcRandomWorld(uint64_t randomSeed, qcWorldKind kind, btBroadphaseInterface* broadphase)
    : world(kind, broadphase), m_random{randomSeed}
{
    // With and without boxes set for objects at rest.
    world.world->setForceUpdateAllAabbs(Below(3) != 0);
    MakeShapes();
    MakeScenery();
    for (uint32_t i = 10 + Below(30); i > 0; i--)
        AddSomething();
    world.AddCloth(btVector3(0, 4, 0));
}

void qcRandomWorld::Change()
{
    for (uint32_t changes = Below(4); changes > 0; changes--)
    {
        const uint32_t movable = uint32_t(world.objects.size()) - uint32_t(m_sceneryCount);
        if (movable < 5 || (Below(5) == 0 && world.objects.size() < qc_maxObjects))
        {
            AddSomething();
            continue;
        }
        btCollisionObject* object = world.objects[uint32_t(m_sceneryCount) + Below(movable)].get();
        btRigidBody* body = btRigidBody::upcast(object);
        const uint32_t kind = Below(12);
        if (kind < 2)
            world.Remove(object);
        else if (object->getInternalType() == btCollisionObject::CO_SOFT_BODY)
            static_cast<btSoftBody*>(object)->addVelocity(Point(-1, 1));
        else if (kind < 4)
        {
            // Moved by hand, static ones too: without boxes set for all objects, the world needs a call for these.
            object->setWorldTransform(Place());
            object->setInterpolationWorldTransform(object->getWorldTransform());
            world.world->updateSingleAabb(object);
        }
        else if (kind < 6)
            object->forceActivationState(Below(3) == 0 ? DISABLE_SIMULATION : ISLAND_SLEEPING);
        else if (kind < 8)
        {
            object->forceActivationState(ACTIVE_TAG);
            object->activate(true);
        }
        else if (kind < 9)
            object->getBroadphaseHandle()->m_collisionFilterMask ^= btBroadphaseProxy::DefaultFilter;
        else if (body != nullptr && !body->isStaticOrKinematicObject())
        {
            body->activate();
            body->setLinearVelocity(Point(-6, 6));
        }
        else
            object->setWorldTransform(btTransform(object->getWorldTransform().getRotation(),
                                                  object->getWorldTransform().getOrigin() + Point(-0.1, 0.1)));
    }
}

void qcRandomWorld::Step()
{
    world.Step();
}

size_t qcRandomWorld::CompareQueries()
{
    // The proxies' present boxes.
    const bool all = world.world->getForceUpdateAllAabbs();
    world.world->setForceUpdateAllAabbs(true);
    world.world->updateAabbs();
    world.world->setForceUpdateAllAabbs(all);
    const btVector3 from = Point(-12, 12), to = Point(-12, 12);
    const Answers ours(*world.world, from, to);

    btDbvtBroadphase peer;
    std::vector<btBroadphaseProxy*> proxies;
    for (const auto& object : world.objects)
    {
        const btBroadphaseProxy* proxy = object->getBroadphaseHandle();
        proxies.push_back(peer.createProxy(proxy->m_aabbMin, proxy->m_aabbMax, 0, object.get(), 1, 0, nullptr));
    }
    world.world->setBroadphase(&peer);
    const Answers theirs(*world.world, from, to);
    world.world->setBroadphase(world.broadphase.get());
    for (btBroadphaseProxy* proxy : proxies)
        peer.destroyProxy(proxy, nullptr);

    CHECK_QUICKLY(ours.rayHits == theirs.rayHits);
    CHECK_QUICKLY(ours.sweepHits == theirs.sweepHits);
    // Nearest hits shorten the way in another order, so they are equal up to rounding.
    CHECK_QUICKLY(btFabs(ours.rayFraction - theirs.rayFraction) < btScalar(1e-4));
    CHECK_QUICKLY(btFabs(ours.sweepFraction - theirs.sweepFraction) < btScalar(1e-4));
    return ours.rayHits.size() + ours.sweepHits.size();
}

uint64_t qcRandomWorld::Hash() const
{
    uint64_t hash = 0xcbf29ce484222325;
    for (const auto& object : world.objects)
    {
        const btTransform& place = object->getWorldTransform();
        Append(&hash, place.getOrigin());
        for (int row = 0; row < 3; row++)
            Append(&hash, place.getBasis().getRow(row));
        if (const btRigidBody* body = btRigidBody::upcast(object.get()))
        {
            Append(&hash, body->getLinearVelocity());
            Append(&hash, body->getAngularVelocity());
        }
        if (const btSoftBody* cloth = btSoftBody::upcast(object.get()))
            for (int i = 0; i < cloth->m_nodes.size(); i++)
                Append(&hash, cloth->m_nodes[i].m_x);
    }
    return hash;
}
