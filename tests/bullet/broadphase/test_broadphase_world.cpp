// qcBroadphase in worlds: the pairs of each step, and whole simulations, compared with btDbvtBroadphase.
#include "bullet/broadphase/broadphase_model.h"
#include "bullet/broadphase/hills.h"
#include "bullet/broadphase/world_kinds.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>
#include <btBulletDynamicsCommon.h>

#include <functional>
#include <map>

namespace
{
/// A btDiscreteDynamicsWorld on either broadphase.
struct World : qcWorld
{
    std::unique_ptr<qcHills> hills;

    explicit World(btBroadphaseInterface* made) : qcWorld(qcWorldKind::discrete, made)
    {
    }

    btPairCachingGhostObject* AddGhost(const btVector3& place, btCollisionShape* shape)
    {
        auto ghost = std::make_unique<btPairCachingGhostObject>();
        ghost->setCollisionShape(shape);
        ghost->setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
        ghost->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
        btPairCachingGhostObject* added = ghost.get();
        AddObject(std::move(ghost), btBroadphaseProxy::SensorTrigger,
                  btBroadphaseProxy::AllFilter & ~btBroadphaseProxy::SensorTrigger);
        return added;
    }

    btCollisionShape* MakeHills()
    {
        hills =
            std::make_unique<qcHills>(12, btScalar(2), [](int i, int j) { return btScalar((i * 7 + j * 5) % 4) / 4; });
        return Make<btBvhTriangleMeshShape>(&hills->mesh, true);
    }

    /// Adds shapes of all kinds that fall onto hills over a plane, past a sensor.
    void FillWithEverything(bool compounds = true)
    {
        AddBody(0, btVector3(0, -5, 0), Make<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
        AddBody(0, btVector3(0, 0, 0), MakeHills());
        AddGhost(btVector3(0, 3, 0), Make<btBoxShape>(btVector3(3, 1, 3)));
        btCompoundShape* dumbbell = Make<btCompoundShape>();
        btCollisionShape* ball = Make<btSphereShape>(btScalar(0.4));
        for (int side : {-1, 1})
            dumbbell->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(side), 0, 0)), ball);
        btCollisionShape* box = Make<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.3), btScalar(0.4)));
        btCollisionShape* capsule = Make<btCapsuleShape>(btScalar(0.3), btScalar(0.6));
        btCollisionShape* kinds[] = {ball, box, compounds ? dumbbell : box, capsule};
        qcRandom random = {31};
        for (int i = 0; i < 60; i++)
        {
            btVector3 place = qcRandomPoint(&random, 8) + btVector3(-4, 3, -4);
            AddBody(1, place, kinds[i % 4])->setLinearVelocity(qcRandomPoint(&random, 4) - btVector3(2, 2, 2));
        }
    }

    /// Adds and removes bodies between two steps; equal calls in every world.
    void ComeAndGo(int step)
    {
        if (step % 10 == 3)
            AddBody(1, btVector3(btScalar(step % 7) - 3, 9, btScalar(step % 5) - 2),
                    shapes[size_t(4 + step % 2)].get());
        if (step % 15 == 8)
            Remove(objects[5 + size_t(step) % (objects.size() - 5)].get());
    }
};

/// Pairs of the world's cache whose boxes truly overlap: all of them for qcBroadphase, some for Bullet's own.
std::vector<qcIdPair> TruePairs(World& world)
{
    std::vector<qcIdPair> pairs;
    const btBroadphasePairArray& array = world.world->getPairCache()->getOverlappingPairArray();
    for (int i = 0; i < array.size(); i++)
    {
        const btBroadphaseProxy *a = array[i].m_pProxy0, *b = array[i].m_pProxy1;
        if (TestAabbAgainstAabb2(a->m_aabbMin, a->m_aabbMax, b->m_aabbMin, b->m_aabbMax))
            pairs.push_back(qcIdsOf(a, b));
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

/// A btDbvtBroadphase with the boxes of another world's proxies.
struct Shadow
{
    btDbvtBroadphase broadphase;
    std::map<int, btBroadphaseProxy*> proxies; ///< by the other's unique id

    ~Shadow()
    {
        for (const auto& [id, proxy] : proxies)
            broadphase.destroyProxy(proxy, nullptr);
    }

    std::vector<qcIdPair> Follow(World& world)
    {
        std::map<int, btBroadphaseProxy*> gone = proxies;
        for (int i = 0; i < world.world->getNumCollisionObjects(); i++)
        {
            const btBroadphaseProxy* theirs = world.world->getCollisionObjectArray()[i]->getBroadphaseHandle();
            gone.erase(theirs->m_uniqueId);
            btBroadphaseProxy*& mine = proxies[theirs->m_uniqueId];
            if (mine == nullptr)
                mine = broadphase.createProxy(theirs->m_aabbMin, theirs->m_aabbMax, 0, nullptr,
                                              theirs->m_collisionFilterGroup, theirs->m_collisionFilterMask, nullptr);
            mine->m_clientObject = reinterpret_cast<void*>(intptr_t(theirs->m_uniqueId));
            broadphase.setAabb(mine, theirs->m_aabbMin, theirs->m_aabbMax, nullptr);
        }
        for (const auto& [id, proxy] : gone)
        {
            broadphase.destroyProxy(proxy, nullptr);
            proxies.erase(id);
        }
        broadphase.calculateOverlappingPairs(nullptr);
        std::vector<qcIdPair> pairs;
        const btBroadphasePairArray& array = broadphase.getOverlappingPairCache()->getOverlappingPairArray();
        for (int i = 0; i < array.size(); i++)
        {
            const btBroadphaseProxy *a = array[i].m_pProxy0, *b = array[i].m_pProxy1;
            int idA = int(reinterpret_cast<intptr_t>(a->m_clientObject));
            int idB = int(reinterpret_cast<intptr_t>(b->m_clientObject));
            if (TestAabbAgainstAabb2(a->m_aabbMin, a->m_aabbMax, b->m_aabbMin, b->m_aabbMax))
                pairs.push_back({std::min(idA, idB), std::max(idA, idB)});
        }
        std::sort(pairs.begin(), pairs.end());
        return pairs;
    }
};

/// Checks that the sensor's overlaps are those of the pair cache.
void CheckGhost(World& world)
{
    auto* ghost = static_cast<btPairCachingGhostObject*>(world.objects[2].get());
    int id = ghost->getBroadphaseHandle()->m_uniqueId;
    std::vector<int> inside, expected;
    for (int i = 0; i < ghost->getNumOverlappingObjects(); i++)
        inside.push_back(ghost->getOverlappingObject(i)->getBroadphaseHandle()->m_uniqueId);
    for (const qcIdPair& pair : qcPairsIn(world.world->getPairCache()))
        if (pair.first == id || pair.second == id)
            expected.push_back(pair.first == id ? pair.second : pair.first);
    std::sort(inside.begin(), inside.end());
    std::sort(expected.begin(), expected.end());
    CHECK_QUICKLY(inside == expected);
}
} // namespace

START_TEST(in_each_step_of_a_world_the_pairs_are_those_that_bullet_finds)
{
    World world(new qcBroadphase);
    Shadow shadow;
    world.FillWithEverything();
    size_t seen = 0;
    bool slept = false;
    for (int step = 0; step < 200; step++)
    {
        world.Step();
        std::vector<qcIdPair> held = qcPairsIn(world.world->getPairCache());
        CHECK_QUICKLY(held == shadow.Follow(world));
        CheckGhost(world);
        seen += held.size();
        for (const auto& object : world.objects)
            slept = slept || object->getActivationState() == ISLAND_SLEEPING;
        world.ComeAndGo(step);
    }
    ck_assert_uint_gt(seen, 10000);
    ck_assert_int_gt(world.dispatcher->getNumManifolds(), 30);
    ck_assert(slept);
}
END_TEST

START_TEST(a_world_moves_as_it_does_on_btDbvtBroadphase)
{
    World ours(new qcBroadphase), theirs(new btDbvtBroadphase);
    for (World* world : {&ours, &theirs})
    {
        // The several manifolds of a compound's pair stay in the order of their creation, even in Bullet's
        // deterministic order.
        world->FillWithEverything(false);
        // Bullet's tree keeps pairs that no longer overlap. Islands are built from pairs, so bodies sleep later there.
        for (auto& object : world->objects)
            object->setActivationState(DISABLE_DEACTIVATION);
    }
    for (int step = 0; step < 200; step++)
    {
        for (World* world : {&ours, &theirs})
        {
            world->Step();
            world->ComeAndGo(step);
            world->objects.back()->setActivationState(DISABLE_DEACTIVATION);
        }
        CHECK_QUICKLY(TruePairs(ours) == TruePairs(theirs));
        CHECK_QUICKLY(ours.objects.size() == theirs.objects.size());
        for (size_t i = 0; i < ours.objects.size(); i++)
            CHECK_QUICKLY(ours.objects[i]->getWorldTransform() == theirs.objects[i]->getWorldTransform());
    }
}
END_TEST

START_TEST(rays_and_sweeps_hit_what_they_hit_on_btDbvtBroadphase)
{
    World ours(new qcBroadphase), theirs(new btDbvtBroadphase);
    btSphereShape ball(btScalar(0.3));
    int hits = 0;
    for (World* world : {&ours, &theirs})
    {
        world->FillWithEverything();
        for (auto& object : world->objects)
            object->setActivationState(DISABLE_DEACTIVATION);
        for (int step = 0; step < 30; step++)
            world->Step();
    }
    qcRandom random = {37};
    for (int i = 0; i < 300; i++)
    {
        btVector3 from = qcRandomPoint(&random, 14) - btVector3(7, 4, 7);
        btVector3 to = qcRandomPoint(&random, 14) - btVector3(7, 7, 7);
        if (i % 3 == 0)
            to.setValue(from.x(), -20, from.z());
        const btCollisionObject* hit[2][2];
        btScalar fraction[2][2];
        for (int w = 0; w < 2; w++)
        {
            World& world = w ? theirs : ours;
            btCollisionWorld::ClosestRayResultCallback ray(from, to);
            world.world->rayTest(from, to, ray);
            btCollisionWorld::ClosestConvexResultCallback sweep(from, to);
            world.world->convexSweepTest(&ball, btTransform(btQuaternion::getIdentity(), from),
                                         btTransform(btQuaternion::getIdentity(), to), sweep);
            hit[w][0] = ray.m_collisionObject;
            hit[w][1] = sweep.m_hitCollisionObject;
            fraction[w][0] = ray.m_closestHitFraction;
            fraction[w][1] = sweep.m_closestHitFraction;
        }
        for (int kind = 0; kind < 2; kind++)
        {
            // The order of visits differs, so nearest hits are equal up to rounding.
            CHECK_QUICKLY(btFabs(fraction[0][kind] - fraction[1][kind]) < btScalar(1e-4));
            CHECK_QUICKLY((hit[0][kind] == nullptr) == (hit[1][kind] == nullptr));
            if (hit[0][kind] == nullptr)
                continue;
            hits++;
            CHECK_QUICKLY(hit[0][kind]->getWorldArrayIndex() == hit[1][kind]->getWorldArrayIndex() ||
                          fraction[0][kind] == 0);
        }
    }
    ck_assert_int_gt(hits, 200);
}
END_TEST

START_TEST(manifolds_end_when_bodies_separate_and_when_they_are_removed)
{
    World world(new qcBroadphase);
    btCollisionShape* box = world.Make<btBoxShape>(btVector3(1, 1, 1));
    world.AddBody(0, btVector3(0, 0, 0), box);
    btRigidBody* body = world.AddBody(1, btVector3(0, btScalar(1.9), 0), box);
    world.Step();
    ck_assert_int_eq(world.dispatcher->getNumManifolds(), 1);
    body->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 50, 0)));
    world.Step();
    ck_assert_int_eq(world.dispatcher->getNumManifolds(), 0);
    body->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(1.9), 0)));
    world.Step();
    ck_assert_int_eq(world.dispatcher->getNumManifolds(), 1);
    // A mask changed behind Bullet's back.
    body->getBroadphaseHandle()->m_collisionFilterMask = 0;
    world.Step();
    ck_assert_int_eq(world.dispatcher->getNumManifolds(), 0);
    body->getBroadphaseHandle()->m_collisionFilterMask = -1;
    world.Step();
    ck_assert_int_eq(world.dispatcher->getNumManifolds(), 1);
    world.Remove(body);
    ck_assert_int_eq(world.dispatcher->getNumManifolds(), 0);
}
END_TEST

namespace
{
World* s_world;
int s_removed, s_added;

/// Now and then removes one of the two and adds another body, as an application with fracture may.
void NearCallback(btBroadphasePair& pair, btCollisionDispatcher& dispatcher, const btDispatcherInfo& info)
{
    auto* a = static_cast<btCollisionObject*>(pair.m_pProxy0->m_clientObject);
    auto* b = static_cast<btCollisionObject*>(pair.m_pProxy1->m_clientObject);
    btCollisionObject* doomed = !a->isStaticObject() ? a : b;
    if (btRigidBody::upcast(doomed) != nullptr && !doomed->isStaticObject() && doomed->getWorldArrayIndex() % 13 == 5)
    {
        s_world->Remove(doomed);
        s_removed++;
        return;
    }
    btCollisionDispatcher::defaultNearCallback(pair, dispatcher, info);
}

void TickCallback(btDynamicsWorld*, btScalar)
{
    // In mid-step: Bullet's fracture world makes its pieces there.
    s_world->AddBody(1, btVector3(btScalar(s_added % 5), 6, btScalar(s_added % 3)), s_world->shapes[4].get());
    s_added++;
    s_world->Remove(s_world->objects[5 + size_t(s_added * 7) % (s_world->objects.size() - 5)].get());
}
} // namespace

START_TEST(bodies_may_be_destroyed_and_created_in_callbacks_of_the_world)
{
    World world(new qcBroadphase);
    Shadow shadow;
    s_world = &world;
    world.FillWithEverything();
    // Sorted traversal keeps indices of pairs that a removal makes invalid.
    world.world->getDispatchInfo().m_deterministicOverlappingPairs = false;
    world.dispatcher->setNearCallback(NearCallback);
    world.dynamics->setInternalTickCallback(TickCallback);
    for (int step = 0; step < 150; step++)
    {
        if (step % 4 == 0)
            world.AddBody(1, btVector3(btScalar(step % 7) - 3, 5, btScalar(step % 5) - 2), world.shapes[5].get());
        world.Step();
        for (const qcIdPair& pair : qcPairsIn(world.world->getPairCache()))
            for (int id : {pair.first, pair.second})
                CHECK_QUICKLY(std::any_of(world.objects.begin(), world.objects.end(),
                                          [&](const auto& object)
                                          { return object->getBroadphaseHandle()->m_uniqueId == id; }));
        world.world->getBroadphase()->calculateOverlappingPairs(world.dispatcher.get());
        CHECK_QUICKLY(qcPairsIn(world.world->getPairCache()) == shadow.Follow(world));
    }
    ck_assert_int_gt(s_removed, 10);
    ck_assert_int_eq(s_added, 150);
}
END_TEST

START_TEST(a_character_walks_as_on_btAxisSweep3)
{
    btTransform path[2][240];
    for (int w = 0; w < 2; w++)
    {
        // btAxisSweep3 has exact boxes, too. On btDbvtBroadphase a character also overlaps bodies that are only near.
        btBroadphaseInterface* sweep = nullptr;
        if (w == 1)
            sweep = new bt32BitAxisSweep3(btVector3(-60, -60, -60), btVector3(60, 60, 60));
        World world(sweep != nullptr ? sweep : new qcBroadphase);
        btCollisionShape* box = world.Make<btBoxShape>(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5)));
        world.AddBody(0, btVector3(0, -1, 0), world.Make<btBoxShape>(btVector3(50, 1, 50)));
        // Stairs, then a wall.
        for (int i = 0; i < 8; i++)
            world.AddBody(0, btVector3(2 + btScalar(i) / 2, btScalar(i) / 5 - btScalar(0.4), 0), box);
        world.AddBody(0, btVector3(8, 2, 0), world.Make<btBoxShape>(btVector3(1, 3, 3)));
        btPairCachingGhostObject ghost;
        btCapsuleShape capsule(btScalar(0.3), 1);
        ghost.setCollisionShape(&capsule);
        ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
        ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 1, 0)));
        btKinematicCharacterController character(&ghost, &capsule, btScalar(0.35), btVector3(0, 1, 0));
        world.world->addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter, btBroadphaseProxy::AllFilter);
        world.dynamics->addAction(&character);
        for (int step = 0; step < 240; step++)
        {
            // Forward, then aside, and once moved by hand into the stairs.
            character.setWalkDirection(step < 150 ? btVector3(btScalar(0.05), 0, 0) : btVector3(0, 0, btScalar(0.05)));
            if (step == 200)
                character.warp(btVector3(4, btScalar(0.9), 0));
            world.Step();
            path[w][step] = ghost.getWorldTransform();
        }
        world.dynamics->removeAction(&character);
        world.world->removeCollisionObject(&ghost);
    }
    for (int step = 0; step < 240; step++)
        CHECK_QUICKLY(path[0][step].getOrigin().distance(path[1][step].getOrigin()) < btScalar(1e-5));
    ck_assert(path[0][100].getOrigin().x() > 3);
    ck_assert(path[0][100].getOrigin().y() > path[0][20].getOrigin().y() + btScalar(0.5));
}
END_TEST

START_TEST(a_sensor_moved_by_hand_has_its_new_overlaps_at_once)
{
    World world(new qcBroadphase);
    btCollisionShape* box = world.Make<btBoxShape>(btVector3(1, 1, 1));
    for (int i = 0; i < 50; i++)
        world.AddBody(1, btVector3(btScalar(5 * i), 0, 0), box);
    btPairCachingGhostObject* sensor = world.AddGhost(btVector3(0, 50, 0), box);
    world.Step();
    ck_assert_int_eq(sensor->getNumOverlappingObjects(), 0);
    sensor->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(100, 0, 0)));
    world.world->updateSingleAabb(sensor);
    ck_assert_int_eq(sensor->getNumOverlappingObjects(), 1);
    world.dispatcher->dispatchAllCollisionPairs(sensor->getOverlappingPairCache(), world.world->getDispatchInfo(),
                                                world.dispatcher.get());
    btManifoldArray manifolds;
    sensor->getOverlappingPairCache()->getOverlappingPairArray()[0].m_algorithm->getAllContactManifolds(manifolds);
    ck_assert_int_eq(manifolds.size(), 1);
    ck_assert_int_gt(manifolds[0]->getNumContacts(), 0);
}
END_TEST

START_TEST(a_fast_ball_with_continuous_detection_does_not_pass_a_wall)
{
    World world(new qcBroadphase);
    world.dynamics->setGravity(btVector3(0, 0, 0));
    world.AddBody(0, btVector3(0, 0, 0), world.Make<btBoxShape>(btVector3(btScalar(0.05), 5, 5)));
    btRigidBody* ball = world.AddBody(1, btVector3(-10, 0, 0), world.Make<btSphereShape>(btScalar(0.2)));
    ball->setLinearVelocity(btVector3(500, 0, 0));
    ball->setCcdMotionThreshold(btScalar(0.1));
    ball->setCcdSweptSphereRadius(btScalar(0.15));
    for (int step = 0; step < 30; step++)
        world.Step();
    ck_assert(ball->getWorldTransform().getOrigin().x() < 0);
}
END_TEST

START_TEST(a_contact_test_finds_a_body_right_after_it_was_added)
{
    struct Counter : btCollisionWorld::ContactResultCallback
    {
        int count = 0;
        btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                                 const btCollisionObjectWrapper*, int, int) override
        {
            count++;
            return 0;
        }
    };
    World world(new qcBroadphase);
    btCollisionShape* box = world.Make<btBoxShape>(btVector3(1, 1, 1));
    btRigidBody* first = world.AddBody(1, btVector3(0, 0, 0), box);
    Counter none, some;
    world.world->contactTest(first, none);
    ck_assert_int_eq(none.count, 0);
    world.AddBody(1, btVector3(1, 0, 0), box);
    world.world->contactTest(first, some);
    ck_assert_int_gt(some.count, 0);
}
END_TEST

QC_RUN_TESTS("broadphase in worlds", in_each_step_of_a_world_the_pairs_are_those_that_bullet_finds,
             a_world_moves_as_it_does_on_btDbvtBroadphase, rays_and_sweeps_hit_what_they_hit_on_btDbvtBroadphase,
             manifolds_end_when_bodies_separate_and_when_they_are_removed,
             bodies_may_be_destroyed_and_created_in_callbacks_of_the_world, a_character_walks_as_on_btAxisSweep3,
             a_sensor_moved_by_hand_has_its_new_overlaps_at_once,
             a_fast_ball_with_continuous_detection_does_not_pass_a_wall,
             a_contact_test_finds_a_body_right_after_it_was_added)
