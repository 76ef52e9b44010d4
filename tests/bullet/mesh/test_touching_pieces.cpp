// Pieces of a cut that touch when they appear, and thin ones below heavy ones, don't penetrate each other or the floor
// that stops them.
#include "bullet/mesh/mesh_world.h"

#include <random>

namespace
{
constexpr btScalar s_shortStep = btScalar(1.0 / 240), s_margin = btScalar(0.001);

struct Pieces
{
    std::vector<qcModel> models;
    std::vector<qcPlacedModel> placed;
};

/// The places of random cuts between 0 and 1, and both ends.
std::vector<btScalar> Cuts(int count, std::minstd_rand* random)
{
    std::uniform_real_distribution<double> share(0, 0.8);
    std::vector<btScalar> cuts;
    for (int i = 0; i <= count; i++)
        cuts.push_back(btScalar((i + (i % count != 0 ? share(*random) - 0.4 : 0)) / count));
    return cuts;
}

/// Adds the boxes that a cube of 1 m is cut into, turned, its lowest point just above the floor, falling.
void AddPieces(qcMeshWorld* world, unsigned seed, btScalar speed, Pieces* pieces)
{
    std::minstd_rand random(seed);
    const int count = 4;
    std::vector<btScalar> cuts[3];
    for (std::vector<btScalar>& axis : cuts)
        axis = Cuts(count, &random);
    btTransform place(btQuaternion(btVector3(btScalar(0.3), btScalar(0.1 * seed), 1).normalized(), btScalar(0.4)));
    btVector3 lower, upper;
    btBoxShape(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))).getAabb(place, lower, upper);
    place.setOrigin(btVector3(0, btScalar(1e-4) - lower.y(), 0));
    pieces->models.reserve(count * count * count);
    for (int i = 0; i < count * count * count; i++)
    {
        btVector3 half, center;
        for (int axis = 0; axis < 3; axis++)
        {
            size_t cell = size_t(axis == 0 ? i / (count * count) : axis == 1 ? i / count % count : i % count);
            half[axis] = (cuts[axis][cell + 1] - cuts[axis][cell]) / 2;
            center[axis] = (cuts[axis][cell + 1] + cuts[axis][cell]) / 2 - btScalar(0.5);
        }
        pieces->models.push_back(qcBoxModel(half, 1));
        btCollisionShape* shape = world->Keep(pieces->models.back().MakeShape());
        shape->setMargin(s_margin);
        btRigidBody* body = world->Add(shape, 2000 * half.x() * half.y() * half.z(),
                                       place * btTransform(btQuaternion::getIdentity(), center));
        body->setLinearVelocity(btVector3(0, -speed, 0));
        pieces->placed.push_back({&pieces->models.back(), body});
    }
}

START_TEST(pieces_that_a_floor_of_any_mesh_stops_do_not_penetrate)
{
    qcModel floor = qcFloorModel(4, 8);
    for (qcFloor kind : {qc_floorStatic, qc_floorOurs, qc_floorTerrain, qc_floorScaled})
        for (unsigned seed = 1; seed <= 2; seed++)
        {
            qcMeshWorld world;
            qcAddFloor(world, kind);
            world.shapes.back()->setMargin(0);
            Pieces pieces;
            AddPieces(&world, seed, 5, &pieces);
            pieces.placed.push_back({&floor, world.bodies.front().get()});
            for (int step = 0; step < 12; step++)
            {
                world.world.stepSimulation(s_shortStep, 0);
                ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
                ck_assert_uint_eq(qcCountPenetrating(pieces.placed), 0);
            }
        }
}
END_TEST

START_TEST(a_sliver_below_a_heavy_body_is_not_pressed_through_the_floor)
{
    qcModel floor = qcFloorModel(2, 1), heavy = qcCubeModel(),
            sliver = qcBoxModel(btVector3(btScalar(0.1), btScalar(0.002), btScalar(0.1)), 1);
    for (int speed = 2; speed <= 4; speed++)
    {
        qcMeshWorld world;
        // Too few for bodies of such different masses: the limits alone hold the sliver.
        world.world.getSolverInfo().m_numIterations = 4;
        btCollisionShape *thin = world.Keep(sliver.MakeShape()), *cube = world.Keep(heavy.MakeShape());
        thin->setMargin(s_margin);
        cube->setMargin(s_margin);
        btTransform place(btQuaternion(btVector3(0, 0, 1), btScalar(0.6)), btVector3(0, btScalar(0.72), 0));
        std::vector<qcPlacedModel> placed = {
            {&floor, world.Add(world.StaticMesh(floor), 0, btVector3(0, 0, 0))},
            {&sliver, world.Add(thin, btScalar(0.01), btVector3(0, btScalar(0.004), 0))},
            {&heavy, world.Add(cube, 1000, place)},
        };
        world.bodies.back()->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
        for (int step = 0; step < 140; step++)
        {
            world.world.stepSimulation(s_shortStep, 0);
            ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
            ck_assert_uint_eq(qcCountPenetrating(placed), 0);
        }
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("touching pieces", pieces_that_a_floor_of_any_mesh_stops_do_not_penetrate,
             a_sliver_below_a_heavy_body_is_not_pressed_through_the_floor)
