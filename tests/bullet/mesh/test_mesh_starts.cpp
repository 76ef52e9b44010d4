// Where limits have a step start, in worlds in which Bullet also searches contact outside of its own search: for
// character controllers, and for queries.
#include "bullet/mesh/mesh_world.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Character/btKinematicCharacterController.h>

namespace
{
const btVector3 s_x(1, 0, 0);
constexpr btScalar s_wallAt = 20;

enum Order
{
    order_limitsFirst,
    order_characterFirst,
    order_kinds
};

/// A character on a floor that is a qcMeshShape, and a wall of 1 cm far from it.
struct CharacterWorld : qcMeshWorld
{
    btGhostPairCallback ghostPairs;
    btPairCachingGhostObject ghost;
    btCapsuleShape capsule{btScalar(0.4), 1};
    btKinematicCharacterController character{&ghost, &capsule, btScalar(0.35)};

    explicit CharacterWorld(int order) : qcMeshWorld(false)
    {
        world.getPairCache()->setInternalGhostPairCallback(&ghostPairs);
        ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 1, 0)));
        ghost.setCollisionShape(&capsule);
        ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
        character.setMaxPenetrationDepth(0);
        character.setGravity(btVector3(0, -10, 0));
        if (order == order_characterFirst)
            world.addAction(&character);
        contact.addTo(&world);
        if (order == order_limitsFirst)
            world.addAction(&character);
        Add(Keep(qcFloorModel(4, 8).MakeShape()), 0, btVector3(0, 0, 0));
        Add(Keep(qcBoxModel(btVector3(btScalar(0.005), 3, 3), 4).MakeShape()), 0, btVector3(s_wallAt, 10, 0));
        world.addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter,
                                 btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
    }
    ~CharacterWorld()
    {
        world.removeAction(&character);
        world.removeCollisionObject(&ghost);
        world.getPairCache()->setInternalGhostPairCallback(nullptr);
    }

    /// A body that no gravity moves.
    btRigidBody* AddFree(std::unique_ptr<btCollisionShape> shape, const btVector3& at)
    {
        btRigidBody* body = Add(Keep(std::move(shape)), 1, at);
        body->setGravity(btVector3(0, 0, 0));
        body->setActivationState(DISABLE_DEACTIVATION);
        return body;
    }
    btRigidBody* AddBox()
    {
        const btVector3 half(btScalar(0.2), btScalar(0.2), btScalar(0.2));
        return AddFree(qcBoxModel(half, 2).MakeShape(), btVector3(s_wallAt - 2, 10, 0));
    }
};

/// Puts a body behind the wall, and steps.
double PutBehind(CharacterWorld* made, btRigidBody* body)
{
    const btTransform place(btQuaternion::getIdentity(), btVector3(s_wallAt + 2, 10, 0));
    body->setWorldTransform(place);
    body->setInterpolationWorldTransform(place);
    made->Step(20);
    return double(body->getWorldTransform().getOrigin().x());
}

START_TEST(what_is_put_behind_a_wall_is_there_where_a_character_walks)
{
    CharacterWorld made(_i);
    btRigidBody* body = made.AddBox();
    made.Step(60);
    ck_assert_double_gt(double(made.ghost.getWorldTransform().getOrigin().y()), 0); // the floor carries it
    ck_assert_double_eq_tol(PutBehind(&made, body), double(s_wallAt + 2), 1e-5);
}
END_TEST

START_TEST(fast_convex_shapes_pass_no_mesh_where_a_character_walks)
{
    for (int start = 0; start < 20; start++)
    {
        CharacterWorld made(_i);
        made.Step(10);
        btRigidBody* ball = made.AddFree(std::make_unique<btSphereShape>(btScalar(0.2)),
                                         btVector3(s_wallAt - 2 + btScalar(0.04) * btScalar(start), 9, 0));
        ball->setLinearVelocity(100 * s_x);
        made.Step(20);
        ck_assert_double_lt(double(ball->getWorldTransform().getOrigin().x()), double(s_wallAt));
    }
}
END_TEST

struct CountPoints : btCollisionWorld::ContactResultCallback
{
    int points = 0;

    btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override
    {
        points++;
        return 0;
    }
};

START_TEST(what_is_put_behind_a_wall_is_there_after_a_query_with_a_compound)
{
    CharacterWorld made(order_limitsFirst);
    btRigidBody* body = made.AddBox();
    made.Step(10);
    btBoxShape box(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3)));
    btCompoundShape compound;
    compound.addChildShape(btTransform::getIdentity(), &box);
    btCollisionObject query;
    query.setCollisionShape(&compound);
    query.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(2, btScalar(0.2), 2)));
    CountPoints count;
    made.world.contactTest(&query, count);
    ck_assert_int_gt(count.points, 0);
    ck_assert_double_eq_tol(PutBehind(&made, body), double(s_wallAt + 2), 1e-5);
}
END_TEST

void MoveBy(btCollisionObject* object, const btVector3& by)
{
    btTransform place = object->getWorldTransform(), interpolated = object->getInterpolationWorldTransform();
    place.getOrigin() += by;
    interpolated.getOrigin() += by;
    object->setWorldTransform(place);
    object->setInterpolationWorldTransform(interpolated);
}

/// Boxes on hills, awake or asleep: the application moves all objects there and back.
START_TEST(a_new_origin_of_the_world_moves_nothing_in_it)
{
    const bool areMeshes = _i % 2 != 0, areLong = _i / 2 != 0;
    const btVector3 half(btScalar(0.3), btScalar(0.3), btScalar(0.3)), shift(btScalar(areLong ? 40 : 5), 0, 1);
    for (int wait = 30; wait < 330; wait += 20)
    {
        qcMeshWorld world;
        const qcModel hills = qcHillsModel(20, 20);
        world.Add(world.Keep(hills.MakeShape()), 0, btVector3(0, 0, 0));
        for (int i = 0; i < 3; i++)
            world.Add(areMeshes ? world.Keep(qcBoxModel(half, 1).MakeShape())
                                : world.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(half))),
                      1, btVector3(btScalar(2 * i), btScalar(0.8), 0));
        world.Step(wait);
        for (const btVector3& by : {shift, -shift})
        {
            for (auto& body : world.bodies)
                MoveBy(body.get(), by);
            std::vector<btVector3> before;
            for (auto& body : world.bodies)
                before.push_back(body->getWorldTransform().getOrigin());
            world.Step();
            for (size_t i = 0; i < before.size(); i++)
                ck_assert_double_lt(double(world.bodies[i]->getWorldTransform().getOrigin().distance(before[i])), 0.05);
            world.Step(30);
        }
    }
}
END_TEST

/// Static and kinematic plates. An application may reset the broadphase between two levels of a game.
START_TEST(what_is_added_again_elsewhere_after_a_reset_sweeps_over_nothing)
{
    const btVector3 plateHalf(btScalar(0.05), 2, 2), boxHalf(btScalar(0.2), btScalar(0.2), btScalar(0.2));
    qcMeshWorld world;
    world.Add(world.Keep(qcBoxModel(btVector3(5, btScalar(0.5), 5), 1).MakeShape()), 0,
              btVector3(0, btScalar(-0.5), 0));
    btRigidBody* plate =
        world.Add(world.Keep(qcBoxModel(plateHalf, 1).MakeShape()), 0, btVector3(-1, btScalar(2.1), 0));
    if (_i > 0)
    {
        plate->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        plate->setActivationState(DISABLE_DEACTIVATION);
    }
    btRigidBody* box = world.Add(world.Keep(qcBoxModel(boxHalf, 1).MakeShape()), 1, btVector3(0, btScalar(0.22), 0));
    world.Step(30);
    for (auto& body : world.bodies)
        world.world.removeRigidBody(body.get());
    world.broadphase.resetPool(&world.dispatcher);
    MoveBy(plate, btVector3(2, 0, 0));
    for (auto& body : world.bodies)
        world.world.addRigidBody(body.get());
    world.Step(10);
    ck_assert_double_eq_tol(double(box->getWorldTransform().getOrigin().x()), 0, 1e-3);
    MoveBy(plate, btVector3(-2, 0, 0));
    world.Step(10);
    ck_assert_double_lt(double(box->getWorldTransform().getOrigin().x()), -1);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mesh_starts");
    tcase_add_loop_test(tests, what_is_put_behind_a_wall_is_there_where_a_character_walks, 0, order_kinds);
    tcase_add_loop_test(tests, fast_convex_shapes_pass_no_mesh_where_a_character_walks, 0, order_kinds);
    tcase_add_test(tests, what_is_put_behind_a_wall_is_there_after_a_query_with_a_compound);
    tcase_add_loop_test(tests, a_new_origin_of_the_world_moves_nothing_in_it, 0, 4);
    tcase_add_loop_test(tests, what_is_added_again_elsewhere_after_a_reset_sweeps_over_nothing, 0, 2);
    return qcRunCase("mesh_starts", tests);
}
