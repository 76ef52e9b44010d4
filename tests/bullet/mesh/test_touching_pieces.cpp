// Pieces of a cut that touch when they appear, and thin ones below heavy ones, don't penetrate each other or the floor
// that stops them.
#include "bullet/mesh/mesh_world.h"

#include <random>

namespace
{
constexpr btScalar s_pieceStep = btScalar(1.0 / 240), s_pieceMargin = btScalar(0.001);

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

/// Where the pieces are cut, and how.
struct CutDef
{
    unsigned seed = 1;
    int count = 4;       ///< of pieces along each edge of the cube
    int quads = 1;       ///< along each edge of a piece's sides
    int firstQuads = 0;  ///< as many for the first piece; 0: as for the others
    btScalar offset = 0; ///< of the world from its origin
};

/// Adds the boxes that a cube of 1 m is cut into, turned, its lowest point just above the floor, falling.
void AddPieces(qcMeshWorld* world, const CutDef& def, btScalar speed, Pieces* pieces)
{
    const unsigned seed = def.seed;
    std::minstd_rand random(seed);
    const int count = def.count;
    std::vector<btScalar> cuts[3];
    for (std::vector<btScalar>& axis : cuts)
        axis = Cuts(count, &random);
    btTransform place(btQuaternion(btVector3(btScalar(0.3), btScalar(0.1 * seed), 1).normalized(), btScalar(0.4)));
    btVector3 lower, upper;
    btBoxShape(btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))).getAabb(place, lower, upper);
    place.setOrigin(btVector3(def.offset, btScalar(1e-4) - lower.y(), 0));
    pieces->models.reserve(size_t(count * count * count) + 1);
    for (int i = 0; i < count * count * count; i++)
    {
        btVector3 half, center;
        for (int axis = 0; axis < 3; axis++)
        {
            size_t cell = size_t(axis == 0 ? i / (count * count) : axis == 1 ? i / count % count : i % count);
            half[axis] = (cuts[axis][cell + 1] - cuts[axis][cell]) / 2;
            center[axis] = (cuts[axis][cell + 1] + cuts[axis][cell]) / 2 - btScalar(0.5);
        }
        pieces->models.push_back(qcBoxModel(half, i == 0 && def.firstQuads != 0 ? def.firstQuads : def.quads));
        btCollisionShape* shape = world->Keep(pieces->models.back().MakeShape());
        shape->setMargin(s_pieceMargin);
        btRigidBody* body = world->Add(shape, 2000 * half.x() * half.y() * half.z(),
                                       place * btTransform(btQuaternion::getIdentity(), center));
        body->setLinearVelocity(btVector3(0, -speed, 0));
        pieces->placed.push_back({&pieces->models.back(), body});
    }
}

/// How deep triangles of different bodies are in each other.
double DeepestOf(const std::vector<qcPlacedModel>& all)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.proximities = true;
    double deepest = 0;
    auto measure = [&](const qcResult& result)
    {
        for (size_t i = 0; i < result.pairCount; i++)
            deepest = std::max(deepest, result.proximities[i].depth);
    };
    qcDetectPlaced(all, def, measure);
    return deepest;
}

/// Steps, with the largest depth in each.
double StepsDepth(qcMeshWorld* world, const std::vector<qcPlacedModel>& all, int steps)
{
    double deepest = 0;
    for (int step = 0; step < steps; step++)
    {
        world->world.stepSimulation(s_pieceStep, 0);
        ck_assert_int_eq(world->contact.getStatistics().unproven, 0);
        deepest = std::max(deepest, DeepestOf(all));
    }
    return deepest;
}

/// Pieces that touch at coordinates of this size come no deeper into each other.
double Rounding(btScalar coordinate)
{
    return std::max(16 * double(SIMD_EPSILON), 1e-13) * double(2 + coordinate);
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
            AddPieces(&world, {seed}, 5, &pieces);
            pieces.placed.push_back({&floor, world.bodies.front().get()});
            for (int step = 0; step < 12; step++)
            {
                world.world.stepSimulation(s_pieceStep, 0);
                ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
                ck_assert_double_le(DeepestOf(pieces.placed), Rounding(0));
            }
        }
}
END_TEST

/// Where the pieces of a cut are after some steps on a number of threads.
std::vector<btTransform> PlacesAfter(int steps, unsigned threads)
{
    qcMeshWorld world;
    world.contact.setThreadCount(threads);
    qcAddFloor(world, qc_floorStatic);
    Pieces pieces;
    AddPieces(&world, CutDef(), 5, &pieces);
    int planes = 0, limited = 0;
    for (int step = 0; step < steps; step++)
    {
        world.world.stepSimulation(s_pieceStep, 0);
        planes = std::max(planes, world.contact.getStatistics().planes);
        limited += world.contact.getStatistics().limited;
    }
    // Loops over many pairs, and pieces that the limits move.
    ck_assert_int_gt(planes, 200);
    ck_assert_int_gt(limited, 0);
    std::vector<btTransform> places;
    for (const auto& body : world.bodies)
        places.push_back(body->getWorldTransform());
    return places;
}

START_TEST(pieces_move_in_the_same_way_on_any_number_of_threads)
{
    ck_assert(PlacesAfter(8, 4) == PlacesAfter(8, 1));
}
END_TEST

START_TEST(pieces_that_stood_still_do_not_penetrate_when_they_break_off)
{
    qcModel floor = qcFloorModel(4, 8);
    for (unsigned seed = 1; seed <= 2; seed++)
    {
        qcMeshWorld world;
        world.Add(world.StaticMesh(floor), 0, btVector3(0, 0, 0));
        Pieces pieces;
        AddPieces(&world, {seed}, 0, &pieces);
        // They stand as bodies without motion, and are not new when they move.
        std::vector<btScalar> masses;
        for (const qcPlacedModel& piece : pieces.placed)
            masses.push_back(piece.body->getMass());
        for (size_t i = 1; i < world.bodies.size(); i++)
            world.bodies[i]->setMassProps(0, btVector3(0, 0, 0));
        StepsDepth(&world, pieces.placed, 3);
        for (size_t i = 1; i < world.bodies.size(); i++)
        {
            btVector3 inertia;
            world.bodies[i]->getCollisionShape()->calculateLocalInertia(masses[i - 1], inertia);
            world.bodies[i]->setMassProps(masses[i - 1], inertia);
            world.bodies[i]->setLinearVelocity(btVector3(0, -5, 0));
            world.bodies[i]->activate(true);
        }
        ck_assert_double_lt(StepsDepth(&world, pieces.placed, 12), Rounding(0));
        ck_assert_double_lt(double(world.bodies.back()->getLinearVelocity().length()), 6);
    }
}
END_TEST

START_TEST(pieces_of_many_triangles_do_not_penetrate)
{
    // Few enough to be tested as hulls; one of more among them.
    for (int firstQuads : {8, 38})
    {
        qcModel floor = qcFloorModel(4, 8);
        qcMeshWorld world;
        world.Add(world.StaticMesh(floor), 0, btVector3(0, 0, 0));
        Pieces pieces;
        AddPieces(&world, {1, 2, 8, firstQuads}, 5, &pieces);
        ck_assert_uint_gt(pieces.models.front().TriangleCount(), firstQuads == 8 ? 600 : 16384);
        ck_assert_double_lt(StepsDepth(&world, pieces.placed, 6), Rounding(0));
    }
}
END_TEST

START_TEST(fine_pieces_with_planes_between_them_need_no_triangles)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    Pieces pieces;
    AddPieces(&world, {1, 2, 30}, 0, &pieces);
    int planes = 0, points = 0;
    for (int step = 0; step < 4; step++)
    {
        world.world.stepSimulation(s_pieceStep, 0);
        const qcMeshContactStatistics& statistics = world.contact.getStatistics();
        ck_assert_int_eq(statistics.planes, statistics.pairs);
        // No query at all.
        ck_assert(statistics.cullMs + statistics.sweepMs + statistics.exactMs + statistics.manifoldMs == 0);
        planes = std::max(planes, statistics.planes);
        points = statistics.points;
    }
    ck_assert_int_ge(planes, 12);
    ck_assert_int_gt(points, 0);
}
END_TEST

/// Makes one compound of the pieces that `joins` selects; they leave the world.
template <class Joins> void JoinPieces(qcMeshWorld* world, Pieces* pieces, const Joins& joins)
{
    auto* compound = new btCompoundShape;
    btCollisionShape* kept = world->Keep(std::unique_ptr<btCollisionShape>(compound));
    std::vector<qcPlacedModel> others;
    btTransform place;
    btVector3 velocity;
    btScalar mass = 0;
    qcModel joined;
    for (size_t i = 0; i < pieces->placed.size(); i++)
    {
        const qcPlacedModel& piece = pieces->placed[i];
        btRigidBody* body = world->bodies[i + 1].get();
        if (!joins(i))
        {
            others.push_back(piece);
            continue;
        }
        if (mass == 0)
            place = body->getWorldTransform();
        btTransform local = place.inverse() * body->getWorldTransform();
        compound->addChildShape(local, body->getCollisionShape());
        qcModel moved = *piece.model;
        moved.Move(local);
        joined.Append(moved);
        mass += body->getMass();
        velocity = body->getLinearVelocity();
        world->world.removeRigidBody(body);
    }
    btRigidBody* body = world->Add(kept, mass, place);
    body->setLinearVelocity(velocity);
    pieces->models.push_back(joined);
    others.push_back({&pieces->models.back(), body});
    pieces->placed = others;
}

START_TEST(pieces_that_break_off_a_compound_do_not_penetrate)
{
    qcModel floor = qcFloorModel(4, 8);
    qcMeshWorld world;
    world.Add(world.StaticMesh(floor), 0, btVector3(0, 0, 0));
    Pieces pieces;
    AddPieces(&world, {1}, 5, &pieces);
    // Three quarters of the cube hold together.
    JoinPieces(&world, &pieces, [](size_t i) { return i / 16 < 2 || i / 4 % 4 < 2; });
    ck_assert_uint_eq(pieces.placed.size(), 17);
    ck_assert_double_lt(StepsDepth(&world, pieces.placed, 12), Rounding(0));
}
END_TEST

START_TEST(pieces_far_from_the_origin_do_not_penetrate)
{
    const btScalar offset = 1000;
    qcModel floor = qcFloorModel(4, 8);
    qcMeshWorld world;
    world.Add(world.StaticMesh(floor), 0, btVector3(offset, 0, 0));
    Pieces pieces;
    AddPieces(&world, {1, 4, 1, 0, offset}, 5, &pieces);
    ck_assert_double_lt(StepsDepth(&world, pieces.placed, 12), Rounding(offset));
}
END_TEST

/// Throws a heavy box at 100 m/s on a plate that touches a floor, and checks that the plate stays on its side.
void HitPlate(int quads, bool asHull, btScalar mass, const btVector3& spin)
{
    const btScalar half = btScalar(0.005);
    qcModel floor = qcFloorModel(0.5, quads),
            plate = qcBoxModel(btVector3(btScalar(0.25), half, btScalar(0.25)), quads),
            heavy = qcBoxModel(btVector3(btScalar(0.3), btScalar(0.1), btScalar(0.3)), 2);
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    world.Add(world.Keep(floor.MakeShape()), 0, btVector3(0, 0, 0));
    btCollisionShape* shape = world.Keep(plate.MakeShape());
    if (!asHull)
    {
        auto* compound = new btCompoundShape;
        compound->addChildShape(btTransform::getIdentity(), shape);
        shape = world.Keep(std::unique_ptr<btCollisionShape>(compound));
    }
    btRigidBody* below = world.Add(shape, mass, btVector3(0, half, 0));
    below->setAngularVelocity(spin);
    btRigidBody* above = world.Add(world.Keep(heavy.MakeShape()), 1000, btVector3(0, btScalar(0.4), 0));
    above->setLinearVelocity(btVector3(0, -100, 0));
    above->setAngularVelocity(spin / 2);
    for (int step = 0; step < 12; step++)
    {
        world.Step();
        ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
        ck_assert_double_gt(double(below->getWorldTransform().getOrigin().y()), 0);
    }
}

START_TEST(a_plate_that_touches_a_floor_is_not_driven_through_it)
{
    // A single mesh is tested as its hull, one in a compound by its triangles.
    for (btScalar mass : {btScalar(0.1), btScalar(10)})
        for (const btVector3& spin : {btVector3(0, 0, 0), btVector3(1, 2, -4)})
        {
            HitPlate(1, true, mass, spin);
            HitPlate(10, true, mass, spin);
            HitPlate(10, false, mass, spin);
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
        thin->setMargin(s_pieceMargin);
        cube->setMargin(s_pieceMargin);
        btTransform place(btQuaternion(btVector3(0, 0, 1), btScalar(0.6)), btVector3(0, btScalar(0.72), 0));
        std::vector<qcPlacedModel> placed = {
            {&floor, world.Add(world.StaticMesh(floor), 0, btVector3(0, 0, 0))},
            {&sliver, world.Add(thin, btScalar(0.01), btVector3(0, btScalar(0.004), 0))},
            {&heavy, world.Add(cube, 1000, place)},
        };
        world.bodies.back()->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
        for (int step = 0; step < 140; step++)
        {
            world.world.stepSimulation(s_pieceStep, 0);
            ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
            ck_assert_uint_eq(qcCountPenetrating(placed), 0);
        }
    }
}
END_TEST
/// The least height of a plate of 1 kg above a plane, after a step in which a column of cubes of 1000 kg comes down on
/// it and the solver does nothing.
double LowestUnderColumn(int cubes)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    world.world.getSolverInfo().m_numIterations = 0;
    qcAddFloor(world, qc_floorPlane);
    const qcModel plate = qcBoxModel(btVector3(btScalar(0.5), btScalar(0.05), btScalar(0.5)), 1), cube = qcCubeModel(1);
    btCollisionShape *thin = world.Keep(plate.MakeShape(s_pieceMargin)),
                     *heavy = world.Keep(cube.MakeShape(s_pieceMargin));
    std::vector<qcPlacedModel> placed = {{&plate, world.Add(thin, 1, btVector3(0, btScalar(0.051), 0))}};
    for (int i = 0; i < cubes; i++)
    {
        placed.push_back(
            {&cube, world.Add(heavy, 1000, btVector3(0, btScalar(0.605) + btScalar(1.003) * btScalar(i), 0))});
        world.bodies.back()->setLinearVelocity(btVector3(0, -4 - btScalar(i), 0));
    }
    world.world.stepSimulation(s_pieceStep, 0);
    ck_assert_uint_eq(qcCountPenetrating(placed), 0);
    const double lowest = double(placed[0].body->getWorldTransform().getOrigin().y()) - 0.05;
    printf("%d cubes: lowest %.3f mm\n", cubes, 1000 * lowest);
    return lowest;
}

START_TEST(limits_press_nothing_into_a_plane)
{
    // A column of eight is cut back: all of it would make its common motion.
    for (int cubes : {1, 8, 16, 30})
    {
        const double lowest = LowestUnderColumn(cubes);
        ck_assert_double_gt(lowest, -1e-5);
        ck_assert_double_lt(lowest, 0.0011);
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("touching pieces", pieces_that_a_floor_of_any_mesh_stops_do_not_penetrate,
             pieces_move_in_the_same_way_on_any_number_of_threads,
             pieces_that_stood_still_do_not_penetrate_when_they_break_off, pieces_of_many_triangles_do_not_penetrate,
             fine_pieces_with_planes_between_them_need_no_triangles, pieces_that_break_off_a_compound_do_not_penetrate,
             pieces_far_from_the_origin_do_not_penetrate, a_plate_that_touches_a_floor_is_not_driven_through_it,
             a_sliver_below_a_heavy_body_is_not_pressed_through_the_floor, limits_press_nothing_into_a_plane)
