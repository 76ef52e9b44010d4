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
struct CharacterWorld
{
    qcMeshContact contact;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
    btGhostPairCallback ghostPairs;
    btPairCachingGhostObject ghost;
    btCapsuleShape capsule{btScalar(0.4), 1};
    std::unique_ptr<btKinematicCharacterController> character;
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    const qcModel floor = qcFloorModel(4, 8), wall = qcBoxModel(btVector3(btScalar(0.005), 3, 3), 4),
                  box = qcBoxModel(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 2);

    explicit CharacterWorld(int order)
    {
        world.getPairCache()->setInternalGhostPairCallback(&ghostPairs);
        ghost.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 1, 0)));
        ghost.setCollisionShape(&capsule);
        ghost.setCollisionFlags(btCollisionObject::CF_CHARACTER_OBJECT);
        character = std::make_unique<btKinematicCharacterController>(&ghost, &capsule, btScalar(0.35));
        character->setMaxPenetrationDepth(0);
        character->setGravity(btVector3(0, -10, 0));
        if (order == order_characterFirst)
            world.addAction(character.get());
        contact.addTo(&world);
        contact.setThreadCount(1);
        if (order == order_limitsFirst)
            world.addAction(character.get());
        Add(floor.MakeShape(), 0, btVector3(0, 0, 0));
        Add(wall.MakeShape(), 0, btVector3(s_wallAt, 10, 0));
        world.addCollisionObject(&ghost, btBroadphaseProxy::CharacterFilter,
                                 btBroadphaseProxy::StaticFilter | btBroadphaseProxy::DefaultFilter);
    }
    ~CharacterWorld()
    {
        world.removeAction(character.get());
        world.removeCollisionObject(&ghost);
        for (const auto& body : bodies)
            world.removeRigidBody(body.get());
    }
    CharacterWorld(const CharacterWorld&) = delete;
    CharacterWorld& operator=(const CharacterWorld&) = delete;

    /// A body that no gravity moves.
    btRigidBody* Add(std::unique_ptr<btCollisionShape> shape, btScalar mass, const btVector3& at)
    {
        shapes.push_back(std::move(shape));
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            shapes.back()->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shapes.back().get(), inertia);
        info.m_startWorldTransform.setOrigin(at);
        bodies.emplace_back(new btRigidBody(info));
        world.addRigidBody(bodies.back().get());
        bodies.back()->setGravity(btVector3(0, 0, 0));
        bodies.back()->setActivationState(DISABLE_DEACTIVATION);
        return bodies.back().get();
    }

    void Step(int count)
    {
        for (int i = 0; i < count; i++)
        {
            world.stepSimulation(qcStep, 0);
            ck_assert_int_eq(contact.getStatistics().status, qc_statusOk);
            ck_assert_int_eq(contact.getStatistics().unproven, 0);
        }
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
    btRigidBody* body = made.Add(made.box.MakeShape(), 1, btVector3(s_wallAt - 2, 10, 0));
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
        btRigidBody* ball = made.Add(std::make_unique<btSphereShape>(btScalar(0.2)), 1,
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
    btRigidBody* body = made.Add(made.box.MakeShape(), 1, btVector3(s_wallAt - 2, 10, 0));
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
} // namespace

QC_TEST_MAIN()
{
    Suite* suite = suite_create("mesh_starts");
    TCase* tests = tcase_create("mesh_starts");
    tcase_add_loop_test(tests, what_is_put_behind_a_wall_is_there_where_a_character_walks, 0, order_kinds);
    tcase_add_loop_test(tests, fast_convex_shapes_pass_no_mesh_where_a_character_walks, 0, order_kinds);
    tcase_add_test(tests, what_is_put_behind_a_wall_is_there_after_a_query_with_a_compound);
    suite_add_tcase(suite, tests);
    return qcRunSuite(suite);
}
