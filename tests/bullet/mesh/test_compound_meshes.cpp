// Compounds of many meshes: their contact and their limits against tests of all pairs of meshes.
#include "bullet/mesh/mesh_world.h"
#include "bullet/mesh/motion_oracle.h"
#include "bullet/random_numbers.h"

namespace
{
constexpr int s_detections = 80, s_throws = 24, s_throwSteps = 20;

btTransform ScatteredPlace(qcRandomNumbers* random, double size)
{
    const btVector3 axis = random->Vector(1) + btVector3(0, 0, btScalar(1.1));
    return btTransform(btQuaternion(axis, random->Number(-3, 3)), random->Vector(size));
}

/// A compound and its triangles, in its frame.
struct Compound
{
    std::unique_ptr<btCompoundShape> shape;
    qcModel model;
};

/// Adds meshes that do not meet, on a grid of cubes, every third one in a compound of its own.
Compound MakeCompound(qcMeshWorld* world, qcRandomNumbers* random, int side, bool hasTree)
{
    Compound made{std::make_unique<btCompoundShape>(hasTree), {}};
    for (int i = 0; i < side * side * side; i++)
    {
        if (random->Number(0, 1) < btScalar(0.4))
            continue;
        const btVector3 half(random->Number(0.02, 0.12), random->Number(0.02, 0.12), random->Number(0.02, 0.12));
        qcModel model = i % 4 == 0 ? qcSphereModel(half.x(), 1) : qcBoxModel(half, 1 + i % 2);
        btCollisionShape* child = world->Keep(model.MakeShape(i % 3 == 0 ? btScalar(0.02) : btScalar(0.005)));
        btTransform place = ScatteredPlace(random, 0);
        place.setOrigin((btVector3(btScalar(i % side), btScalar(i / side % side), btScalar(i / side / side)) -
                         btVector3(1, 1, 1) * btScalar(side - 1) / 2) /
                        2);
        if (i % 3 == 2)
        {
            auto inner = std::make_unique<btCompoundShape>();
            const btTransform innerPlace = ScatteredPlace(random, 0.01);
            inner->addChildShape(innerPlace, child);
            child = world->Keep(std::move(inner));
            model.Move(innerPlace);
        }
        made.shape->addChildShape(place, child);
        model.Move(place);
        made.model.Append(model);
    }
    return made;
}

/// Points of two objects, from a dispatcher's manifolds, or from a query for the two alone.
struct Points : btCollisionWorld::ContactResultCallback
{
    int count = 0;
    btScalar deepest = BT_LARGE_FLOAT;

    void Add(const btManifoldPoint& point)
    {
        count++;
        deepest = std::min(deepest, point.getDistance());
    }
    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override
    {
        Add(point);
        return 0;
    }
};

START_TEST(compounds_have_the_contact_that_a_query_of_all_their_meshes_has)
{
    qcRandomNumbers random(1);
    int touching = 0;
    for (int run = 0; run < s_detections; run++)
    {
        qcMeshWorld world;
        btRigidBody* bodies[3];
        for (int i = 0; i < 3; i++)
        {
            Compound made = MakeCompound(&world, &random, 2 + (run + i) % 4, run % 3 != 0);
            bodies[i] = world.Add(world.Keep(std::move(made.shape)), i == 0 ? 0 : 1, ScatteredPlace(&random, 0.7));
        }
        world.world.performDiscreteCollisionDetection();
        // Each mesh is found among those of its object: none is queried alone.
        ck_assert_uint_eq(world.contact.getStatistics().queries, 0);
        for (const auto& [a, b] : {std::make_pair(0, 1), std::make_pair(0, 2), std::make_pair(1, 2)})
        {
            Points found, all;
            for (int m = 0; m < world.dispatcher.getNumManifolds(); m++)
            {
                const btPersistentManifold& manifold = *world.dispatcher.getManifoldByIndexInternal(m);
                if (std::minmax(manifold.getBody0(), manifold.getBody1()) ==
                    std::minmax<const btCollisionObject*>(bodies[a], bodies[b]))
                    for (int i = 0; i < manifold.getNumContacts(); i++)
                        found.Add(manifold.getContactPoint(i));
            }
            world.world.contactPairTest(bodies[a], bodies[b], all);
            ck_assert_msg((all.count == 0) == (found.count == 0), "run %d: %d points, %d found", run, all.count,
                          found.count);
            if (all.count == 0)
                continue;
            touching++;
            ck_assert_double_eq_tol(double(found.deepest), double(all.deepest), 1e-4);
        }
    }
    ck_assert_int_gt(touching, s_detections);
}
END_TEST

/// Throws two compounds at a third one, which may be static or moved by the application.
void CheckThrow(int run, qcRandomNumbers* random, int* limited)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, btScalar(-10), 0));
    const double speed = run % 3 == 0 ? 2 : run % 3 == 1 ? 20 : 100;
    const bool isKinematic = run % 4 == 1;
    Compound made[3];
    btRigidBody* bodies[3];
    for (int i = 0; i < 3; i++)
    {
        made[i] = MakeCompound(&world, random, 2 + (run + i) % 3, run % 5 != 0);
        // Their spheres of radius 1.8 are apart.
        btTransform place = ScatteredPlace(random, 0);
        place.setOrigin(btVector3(btScalar(3.7 * (i - 1)), random->Number(-1, 1), random->Number(-1, 1)));
        bodies[i] = world.Add(made[i].shape.get(), i == 1 && run % 2 == 1 ? 0 : 1, place);
        bodies[i]->setActivationState(DISABLE_DEACTIVATION);
        if (i == 1)
            continue;
        bodies[i]->setLinearVelocity(btVector3(btScalar(speed * (1 - i)), 0, 0));
        bodies[i]->setAngularVelocity(random->Vector(run % 2 == 0 ? 1 : 20));
    }
    if (isKinematic)
        bodies[1]->setCollisionFlags(bodies[1]->getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    qcMotionOracle oracle;
    for (int i = 0; i < 3; i++)
        oracle.Add(made[i].model, bodies[i], uint32_t(i) + 1);
    ck_assert_uint_eq(oracle.CountNow(), 0);
    for (int step = 0; step < s_throwSteps; step++)
    {
        if (isKinematic)
        {
            btTransform place = bodies[1]->getWorldTransform();
            place.getOrigin() += btVector3(0, btScalar(0.03), 0);
            place.setRotation(btQuaternion(btVector3(0, 1, 0), btScalar(0.02)) * place.getRotation());
            bodies[1]->setWorldTransform(place);
        }
        world.Step();
        ck_assert_msg(oracle.Count() == 0, "run %d, step %d", run, step);
        ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
        ck_assert_uint_eq(world.contact.getStatistics().queries, 0);
        *limited += world.contact.getStatistics().limited;
    }
}

START_TEST(meshes_of_compounds_do_not_pass_each_other_at_any_speed)
{
    qcRandomNumbers random(2);
    int limited = 0;
    for (int run = 0; run < s_throws; run++)
        CheckThrow(run, &random, &limited);
    ck_assert_int_gt(limited, 0);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("compound_meshes");
    tcase_add_test(tests, compounds_have_the_contact_that_a_query_of_all_their_meshes_has);
    tcase_add_test(tests, meshes_of_compounds_do_not_pass_each_other_at_any_speed);
    return qcRunCase("compound_meshes", tests);
}
