// Compounds of many meshes: their contact and their limits against tests of all pairs of meshes.
#include "bullet/mesh/mesh_world.h"
#include "bullet/mesh/motion_oracle.h"
#include "bullet/random_numbers.h"

namespace
{
constexpr int s_detections = 80, s_throws = 24, s_throwSteps = 20;
// Tiles along a side of a wall.
constexpr int s_wallTiles = 12, s_wallThrows = 30;
// Points that are nearer are contact, whichever margin a mesh has.
constexpr btScalar s_maxDistance = btScalar(0.005);
constexpr btScalar s_meshSize = btScalar(0.3);
// Distances are exact to this depth. Deeper ones are of regions, which depend on how far a query searches.
constexpr btScalar s_exactDepth = btScalar(0.01);

bool AreSame(btScalar distance, btScalar expected)
{
    const btScalar tolerance = expected > -s_exactDepth ? btScalar(1e-5) : -expected / 2;
    return btFabs(distance - expected) <= tolerance;
}

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

/// A contact point of two objects.
struct Point
{
    btVector3 onB;
    btScalar distance;
};

/// The deepest point of a query.
struct Deepest : btCollisionWorld::ContactResultCallback
{
    Point point{{0, 0, 0}, BT_LARGE_FLOAT};

    btScalar addSingleResult(btManifoldPoint& found, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override
    {
        if (found.getDistance() < point.distance)
            point = {found.getPositionWorldOnB(), found.getDistance()};
        return 0;
    }
};

/// The contact points of two objects in a world.
std::vector<Point> PointsOf(btDispatcher& dispatcher, const btCollisionObject* a, const btCollisionObject* b)
{
    std::vector<Point> points;
    for (int m = 0; m < dispatcher.getNumManifolds(); m++)
    {
        const btPersistentManifold& manifold = *dispatcher.getManifoldByIndexInternal(m);
        if (std::minmax(manifold.getBody0(), manifold.getBody1()) != std::minmax(a, b))
            continue;
        for (int i = 0; i < manifold.getNumContacts(); i++)
        {
            const btManifoldPoint& point = manifold.getContactPoint(i);
            points.push_back({point.getPositionWorldOnB(), point.getDistance()});
        }
    }
    return points;
}

/// The meshes of an object, as objects of their own.
void AppendMeshes(const btCollisionShape* shape, const btTransform& place,
                  std::vector<std::unique_ptr<btCollisionObject>>* meshes)
{
    if (shape->isCompound())
    {
        const auto* compound = static_cast<const btCompoundShape*>(shape);
        for (int i = 0; i < compound->getNumChildShapes(); i++)
            AppendMeshes(compound->getChildShape(i), place * compound->getChildTransform(i), meshes);
        return;
    }
    meshes->push_back(std::make_unique<btCollisionObject>());
    meshes->back()->setCollisionShape(const_cast<btCollisionShape*>(shape));
    meshes->back()->setWorldTransform(place);
}

START_TEST(each_two_meshes_of_compounds_have_the_contact_that_a_query_for_them_alone_has)
{
    qcRandomNumbers random(1);
    int touching = 0;
    for (int run = 0; run < s_detections; run++)
    {
        qcMeshWorld world;
        btRigidBody* bodies[3];
        std::vector<std::unique_ptr<btCollisionObject>> meshes[3];
        for (int i = 0; i < 3; i++)
        {
            Compound made = MakeCompound(&world, &random, 2 + (run + i) % 3, run % 3 != 0);
            bodies[i] = world.Add(world.Keep(std::move(made.shape)), i == 0 ? 0 : 1, ScatteredPlace(&random, 0.5));
            AppendMeshes(bodies[i]->getCollisionShape(), bodies[i]->getWorldTransform(), &meshes[i]);
        }
        world.world.performDiscreteCollisionDetection();
        // Each mesh is found among those of its object: none is queried alone.
        ck_assert_uint_eq(world.contact.getStatistics().queries, 0);
        for (const auto& [a, b] : {std::make_pair(0, 1), std::make_pair(0, 2), std::make_pair(1, 2)})
        {
            const std::vector<Point> points = PointsOf(world.dispatcher, bodies[a], bodies[b]);
            for (const auto& meshA : meshes[a])
                for (const auto& meshB : meshes[b])
                {
                    Deepest alone;
                    world.world.contactPairTest(meshA.get(), meshB.get(), alone);
                    if (alone.point.distance > s_maxDistance)
                        continue;
                    touching++;
                    // It may be another corner of the same face.
                    auto isSame = [&](const Point& point) {
                        return AreSame(point.distance, alone.point.distance) &&
                               point.onB.distance(alone.point.onB) < s_meshSize;
                    };
                    ck_assert_msg(std::any_of(points.begin(), points.end(), isSame), "run %d: depth %g of %zu points",
                                  run, double(alone.point.distance), points.size());
                }
        }
    }
    ck_assert_int_gt(touching, 2 * s_detections);
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

/// A static wall of thin tiles, boxes of Bullet or meshes of the same size, and its triangles.
Compound MakeWall(qcMeshWorld* world, bool hasMeshes, bool hasBoxes)
{
    Compound made{std::make_unique<btCompoundShape>(), {}};
    const btVector3 half(btScalar(0.02), btScalar(0.25), btScalar(0.25));
    for (int i = 0; i < s_wallTiles * s_wallTiles; i++)
    {
        qcModel model = qcBoxModel(half, 1);
        const bool isMesh = hasMeshes && (!hasBoxes || i % 2 == 0);
        const btTransform place(
            btQuaternion::getIdentity(),
            btVector3(0, btScalar(i % s_wallTiles - s_wallTiles / 2), btScalar(i / s_wallTiles - s_wallTiles / 2)) / 2);
        made.shape->addChildShape(place, isMesh ? world->Keep(model.MakeShape(btScalar(0.005)))
                                                : world->Keep(std::make_unique<btBoxShape>(half)));
        // Boxes may be touched; nothing passes their cores.
        model = isMesh ? model : qcBoxModel(btScalar(0.9) * half, 1);
        model.Move(place);
        made.model.Append(model);
    }
    return made;
}

/// Throws meshes at places of a large wall, of which only what is near is looked at.
START_TEST(nothing_passes_a_tile_of_a_large_wall)
{
    qcRandomNumbers random(3);
    for (int run = 0; run < s_wallThrows; run++)
    {
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        Compound wall = MakeWall(&world, run % 3 != 0, run % 3 != 1);
        btRigidBody* still = world.Add(wall.shape.get(), 0, ScatteredPlace(&random, 3));
        qcMotionOracle oracle;
        oracle.Add(wall.model, still, 1);
        std::vector<btRigidBody*> thrown;
        std::vector<qcModel> models;
        for (int i = 0; i < 6; i++)
            models.push_back(qcBoxModel(btVector3(1, 1, 1) * random.Number(0.05, 0.2), 1));
        for (int i = 0; i < 6; i++)
        {
            const btVector3 target(0, random.Number(-2.5, 2.5), btScalar(i - 3) * btScalar(0.9));
            const btTransform place(btQuaternion(random.Vector(1) + btVector3(2, 0, 0), random.Number(0, 3)),
                                    target + btVector3(random.Number(1, 2), 0, 0));
            btRigidBody* body = world.Add(world.Keep(models[size_t(i)].MakeShape(btScalar(0.005))), 1,
                                          still->getWorldTransform() * place);
            body->setActivationState(DISABLE_DEACTIVATION);
            body->setLinearVelocity(still->getWorldTransform().getBasis() *
                                    btVector3(-random.Number(2, 150), random.Number(-2, 2), 0));
            body->setAngularVelocity(random.Vector(10));
            thrown.push_back(body);
            oracle.Add(models[size_t(i)], body, uint32_t(i) + 2);
        }
        for (int step = 0; step < 30; step++)
        {
            world.Step();
            ck_assert_msg(oracle.Count() == 0, "run %d, step %d", run, step);
            ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
        }
        for (const btRigidBody* body : thrown)
        {
            const btVector3 end = still->getWorldTransform().inverse() * body->getWorldTransform().getOrigin();
            const bool isBeside = std::max(btFabs(end.y()), btFabs(end.z())) > btScalar(s_wallTiles) / 4;
            ck_assert_msg(end.x() > 0 || isBeside, "run %d: %g, %g, %g", run, double(end.x()), double(end.y()),
                          double(end.z()));
        }
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("compound_meshes");
    tcase_add_test(tests, each_two_meshes_of_compounds_have_the_contact_that_a_query_for_them_alone_has);
    tcase_add_test(tests, meshes_of_compounds_do_not_pass_each_other_at_any_speed);
    tcase_add_test(tests, nothing_passes_a_tile_of_a_large_wall);
    return qcRunCase("compound_meshes", tests);
}
