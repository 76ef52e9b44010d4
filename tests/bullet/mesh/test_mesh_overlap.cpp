// Closed meshes that are put into each other come apart, and stay on their side of thin ones. The long form prints how
// soon those of btGImpactMeshShape do.
#include "bullet/mesh/mesh_world.h"
#include "support/long_form.h"

#include <random>

namespace
{
constexpr double s_size = 0.3;

/// Five lobes around the y axis: concave, with margins of a fifteenth of its size.
qcModel MakeStar()
{
    qcModel model = qcSphereModel(s_size / 2, 2);
    for (size_t i = 0; i < model.positions.size(); i += 3)
    {
        btScalar &x = model.positions[i], &y = model.positions[i + 1], &z = model.positions[i + 2];
        btScalar lobes = 1 + btScalar(0.25) * btCos(5 * btAtan2(z, x));
        x *= lobes;
        y *= btScalar(0.6);
        z *= lobes;
    }
    return model;
}

btQuaternion TurnAtRandom(std::mt19937* random)
{
    std::normal_distribution<btScalar> part;
    btScalar x = part(*random), y = part(*random), z = part(*random), w = part(*random);
    return btQuaternion(x, y, z, w).normalized();
}

constexpr int s_maxSteps = 600;

/// The steps after which two stars at this distance, in units of their size, are apart; at most s_maxSteps.
int CountSteps(uint32_t seed, double distance, bool gimpact)
{
    std::mt19937 random(seed);
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    qcModel star = MakeStar();
    btCollisionShape* shape = gimpact ? world.GImpact(star, btScalar(0.01)) : world.Keep(star.MakeShape());
    for (int i = 0; i < 2; i++)
        world.Add(shape, 1, btTransform(TurnAtRandom(&random), btVector3(btScalar(distance * s_size * i), 0, 0)));
    int steps = 0;
    do
        world.Step();
    while (++steps < s_maxSteps && qcContactsOf(world.dispatcher).deepest < -2e-3);
    return steps;
}

/// The mean of CountSteps over random turns, no more than `most` in any.
double MeanSteps(double distance, int seeds, bool gimpact, int most)
{
    int all = 0, left = 0;
    for (int seed = 0; seed < seeds; seed++)
    {
        int steps = CountSteps(uint32_t(seed), distance, gimpact);
        ck_assert_msg(steps <= most, "distance %.2f, seed %d: %d steps", distance, seed, steps);
        all += steps;
        left += steps == s_maxSteps;
    }
    printf("stars %.2f apart, %s: apart after %.1f steps, %d never\n", distance, gimpact ? "GImpact" : "qcMeshShape",
           double(all) / seeds, left);
    return double(all) / seeds;
}

START_TEST(stars_that_are_put_into_each_other_come_apart)
{
    const struct
    {
        double distance, mean;
        int seeds, most;
    } cases[] = {{0.9, 8, 40, 60}, {0.75, 12, 40, 120}, {0.5, 60, qcIsLongForm() ? 40 : 8, s_maxSteps - 1}};
    for (const auto& c : cases)
    {
        if (qcIsLongForm())
            MeanSteps(c.distance, c.seeds, true, s_maxSteps);
        ck_assert_double_lt(MeanSteps(c.distance, c.seeds, false, c.most), c.mean);
    }
}
END_TEST

/// Twelve stars that are put into each other, after 8 s. Returns how deep contact leaves them in each other.
double RestHeap(uint32_t seed)
{
    std::mt19937 random(seed);
    qcMeshWorld world;
    world.Add(world.Keep(qcFloorModel(2, 8).MakeShape()), 0, btVector3(0, 0, 0));
    btCollisionShape* shape = world.Keep(MakeStar().MakeShape());
    for (int i = 0; i < 12; i++)
    {
        btVector3 at(btScalar(i % 3 - 1), btScalar(0.8 + i / 9), btScalar(i / 3 % 3 - 1));
        world.Add(shape, 1, btTransform(TurnAtRandom(&random), at * btScalar(0.75 * s_size)));
    }
    double before = world.Energy(), most = before;
    for (int i = 0; i < 480; i++)
    {
        world.Step();
        most = std::max(most, world.Energy());
    }
    double deepest = qcContactsOf(world.dispatcher).deepest;
    printf("twelve stars: %.2g J, deepest %.4f m, most energy %.2f times\n", world.KineticEnergy(), deepest,
           most / before);
    ck_assert_double_lt(world.KineticEnergy(), 1e-3);
    ck_assert_double_lt(most, 1.25 * before);
    return deepest;
}

START_TEST(heaps_of_stars_that_are_put_into_each_other_come_to_rest)
{
    // Heaps end in many ways: one or two of sixteen have a point that is deeper than 1 mm.
    int deep = 0;
    for (uint32_t seed = 1; seed <= 6; seed++)
    {
        const double deepest = RestHeap(seed);
        ck_assert_double_gt(deepest, -2e-3);
        deep += deepest <= -1e-3;
    }
    ck_assert_int_le(deep, 1);
}
END_TEST

START_TEST(bodies_that_reach_through_a_plate_return_to_their_side)
{
    // The outer side of the plate's far face leads on.
    const qcModel models[] = {qcSphereModel(0.5, 2), qcTorusModel(0.35, 0.12, 16, 8)};
    for (const qcModel& model : models)
        for (uint32_t seed = 0; seed < 8; seed++)
        {
            std::mt19937 random(seed);
            const btScalar half = btScalar(0.0025);
            qcMeshWorld world;
            btCollisionShape* plate = world.Keep(qcBoxModel(btVector3(2, half, 2), 4).MakeShape());
            plate->setMargin(btScalar(0.01));
            world.Add(plate, 0, btVector3(0, 0, 0));
            btTransform start(TurnAtRandom(&random), btVector3(0, 0, 0));
            btScalar lowest = 0;
            for (size_t i = 0; i < model.positions.size(); i += 3)
                lowest = std::min(
                    lowest,
                    (start * btVector3(model.positions[i], model.positions[i + 1], model.positions[i + 2])).y());
            start.setOrigin(btVector3(btScalar(0.1), half - lowest - btScalar(0.1), btScalar(0.2)));
            btCollisionShape* shape = world.Keep(model.MakeShape());
            btRigidBody* body = world.Add(shape, 1, start);
            world.Step(120);
            ck_assert_double_gt(double(body->getWorldTransform().getOrigin().y()), 0);
            ck_assert_double_gt(qcContactsOf(world.dispatcher).deepest, -2e-3);
        }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mesh_overlap");
    tcase_add_test(tests, stars_that_are_put_into_each_other_come_apart);
    tcase_add_test(tests, heaps_of_stars_that_are_put_into_each_other_come_to_rest);
    tcase_add_test(tests, bodies_that_reach_through_a_plate_return_to_their_side);
    return qcRunCase("mesh_overlap", tests);
}
