// Bullet's convex shapes that are fast pass no qcMeshShape: the limits stop their cores.
#include "mesh_contact/limits/convex_cores.h"

#include "bullet/mesh/core_model.h"
#include "bullet/mesh/mesh_world.h"
#include "bullet/mesh/motion_oracle.h"

#include "bullet/random_numbers.h"

namespace
{
constexpr int s_starts = 6, s_crowds = 60, s_heaps = 120;
const btVector3 s_z(0, 0, 1);

enum ConvexKind
{
    convex_sphere,
    convex_box,
    convex_plate,
    convex_capsule,
    convex_cylinder,
    convex_cone,
    convex_hull,
    convex_scaled,
    convex_compound,
    convex_kinds
};

std::unique_ptr<btCollisionShape> MakeHull()
{
    std::unique_ptr<btConvexHullShape> hull(new btConvexHullShape);
    qcRandomNumbers random(3);
    for (int i = 0; i < 20; i++)
        hull->addPoint(random.Vector(0.25));
    return hull;
}

/// What the shapes of compounds and scaled shapes refer to.
btConvexShape& Inner()
{
    static btBoxShape box(btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.1)));
    return box;
}

std::unique_ptr<btCollisionShape> MakeConvex(int kind)
{
    const btVector3 half(btScalar(0.2), btScalar(0.1), btScalar(0.3));
    switch (kind)
    {
        case convex_sphere: return std::make_unique<btSphereShape>(btScalar(0.2));
        case convex_box: return std::make_unique<btBoxShape>(half);
        case convex_plate: return std::make_unique<btBoxShape>(btVector3(btScalar(0.3), btScalar(0.01), btScalar(0.3)));
        case convex_capsule: return std::make_unique<btCapsuleShape>(btScalar(0.1), btScalar(0.4));
        case convex_cylinder: return std::make_unique<btCylinderShape>(half);
        case convex_cone: return std::make_unique<btConeShape>(btScalar(0.2), btScalar(0.5));
        case convex_hull: return MakeHull();
        case convex_scaled: return std::make_unique<btUniformScalingShape>(&Inner(), btScalar(1.5));
        default: break;
    }
    auto compound = std::make_unique<btCompoundShape>();
    for (int side = -1; side <= 1; side += 2)
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.3 * side), 0, 0)),
                                &Inner());
    return compound;
}

qcModel WallModel()
{
    return qcBoxModel(btVector3(5, 5, btScalar(0.005)), 6);
}

qcModel SmallBoxModel()
{
    return qcBoxModel(btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.3)), 2);
}

START_TEST(a_core_is_inside_its_shape)
{
    std::unique_ptr<btCollisionShape> shape = MakeConvex(_i);
    if (shape->isCompound())
        return;
    const auto& convex = static_cast<const btConvexShape&>(*shape);
    const qcModel core = qcCoreModel(shape.get());
    qcRandomNumbers random(1);
    for (int i = 0; i < 500; i++)
    {
        const btVector3 direction = random.Vector(1).normalized();
        btScalar largest = -BT_LARGE_FLOAT;
        for (size_t k = 0; k < core.positions.size(); k += 3)
            largest = std::max(
                largest, direction.dot(btVector3(core.positions[k], core.positions[k + 1], core.positions[k + 2])));
        ck_assert_double_lt(double(largest), double(direction.dot(convex.localGetSupportingVertex(direction))));
    }
    // Closed: each edge twice.
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (size_t i = 0; i < core.indices.size(); i++)
        edges[std::minmax(core.indices[i], core.indices[i % 3 == 2 ? i - 2 : i + 1])]++;
    for (const auto& edge : edges)
        ck_assert_int_eq(edge.second, 2);
}
END_TEST

START_TEST(balls_bounce_off_a_mesh_at_any_speed)
{
    for (double radius : {0.2, 0.5})
        for (double speed : {5.0, 10.0, 20.0, 40.0, 80.0})
            for (int start = 0; start < 12; start++)
            {
                qcMeshWorld made;
                made.world.setGravity(btVector3(0, 0, 0));
                made.Add(made.Keep(qcFloorModel(5, 4).MakeShape()), 0, btTransform::getIdentity())->setRestitution(1);
                const double height = radius + 0.03 * speed + speed / 60 * start / 12;
                std::unique_ptr<btCollisionShape> shape;
                if (_i == 0)
                    shape = std::make_unique<btSphereShape>(btScalar(radius));
                else
                    shape = std::make_unique<btCapsuleShapeX>(btScalar(radius), btScalar(_i == 1 ? 0.2 : radius));
                btRigidBody* ball =
                    made.Add(made.Keep(std::move(shape)), 1,
                             btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.1), btScalar(height), 0)));
                ball->setRestitution(btScalar(0.8));
                ball->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
                for (int step = 0; step < 20; step++)
                    made.world.stepSimulation(btScalar(1.0 / 60), 0);
                const double rebound = double(ball->getLinearVelocity().y()) / speed;
                // A capsule that lies has contact on one side first, and begins to turn.
                ck_assert_msg(rebound > (_i == 0 ? 0.7 : 0.3) && rebound < 1, "radius %g at %g m/s: %g", radius, speed,
                              rebound);
            }
}
END_TEST

START_TEST(balls_without_restitution_do_not_bounce_off_a_mesh)
{
    for (double speed : {20.0, 40.0, 80.0})
        for (int start = 0; start < 40; start++)
        {
            qcRandomNumbers random(unsigned(start) + 1);
            qcMeshWorld made;
            made.Add(made.Keep(qcFloorModel(5, 20).MakeShape()), 0, btTransform::getIdentity());
            btRigidBody* ball = made.Add(made.Keep(std::make_unique<btSphereShape>(btScalar(0.2))), 1,
                                         btVector3(0, random.Number(1 + 0.03 * speed, 1 + 0.05 * speed), 0));
            ball->setLinearVelocity(btVector3(0, btScalar(-speed), 0));
            btScalar lowest = BT_LARGE_FLOAT, highest = 0;
            for (int step = 0; step < 60; step++)
            {
                made.Step();
                const btScalar height = ball->getWorldTransform().getOrigin().y();
                lowest = std::min(lowest, height);
                highest = lowest < btScalar(0.5) ? std::max(highest, height) : highest;
            }
            ck_assert_double_lt(double(highest), 0.7);
        }
}
END_TEST

START_TEST(a_core_follows_changes_of_its_shape)
{
    qcConvexCores cores(qcCoreSize);
    btBoxShape box(btVector3(1, 1, 1));
    ck_assert_double_eq_tol(double(cores.Find(&box).halfWidth), 0.9, 1e-5);
    box.setLocalScaling(btVector3(1, btScalar(0.5), 1));
    cores.BeginStep();
    ck_assert_double_eq_tol(double(cores.Find(&box).halfWidth), 0.45, 1e-5);
    btConvexHullShape flat;
    for (int i = 0; i < 4; i++)
        flat.addPoint(btVector3(btScalar(i % 2), btScalar(i / 2), 0));
    flat.setMargin(0);
    ck_assert_ptr_null(cores.Find(&flat).mesh.get());
}
END_TEST

START_TEST(a_hull_at_the_address_of_a_deleted_one_has_a_core_of_its_own)
{
    qcConvexCores cores(qcCoreSize);
    alignas(16) unsigned char room[sizeof(btConvexHullShape)];
    // A cube and an octahedron with the same box.
    for (bool isCube : {true, false})
    {
        auto* hull = new (room) btConvexHullShape;
        for (int i = 0; isCube && i < 8; i++)
            hull->addPoint(btVector3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1));
        for (int i = 0; !isCube && i < 6; i++)
        {
            btVector3 corner(0, 0, 0);
            corner[i / 2] = i % 2 == 0 ? 1 : -1;
            hull->addPoint(corner);
        }
        hull->setMargin(0);
        cores.BeginStep();
        ck_assert_double_eq_tol(double(cores.Find(hull).halfWidth), isCube ? 0.9 : 0.9 / std::sqrt(3.0), 1e-5);
        hull->~btConvexHullShape();
    }
}
END_TEST

/// One step, in which what the oracle follows stays apart. Returns the number of limited objects.
int StepApart(qcMeshWorld* world, qcMotionOracle* oracle)
{
    world->Step();
    ck_assert_int_eq(world->contact.getStatistics().unproven, 0);
    ck_assert_uint_eq(oracle->Count(), 0);
    return world->contact.getStatistics().limited;
}

/// Steps in which slow bodies gain no energy, either.
int StepApart(qcMeshWorld* world, qcMotionOracle* oracle, int steps, btScalar speed)
{
    const double energy = world->Energy();
    int limited = 0;
    for (int step = 0; step < steps; step++)
    {
        limited += StepApart(world, oracle);
        // Bullet's integration of bodies that spin at a thousand radians a second gains energy.
        ck_assert(speed > 10 || world->Energy() <= energy * 1.01);
    }
    return limited;
}

START_TEST(fast_convex_shapes_pass_no_mesh)
{
    std::unique_ptr<btCollisionShape> shape = MakeConvex(_i);
    const qcModel core = qcCoreModel(shape.get()), wall = WallModel(), floor = qcFloorModel(30, 10);
    int limited = 0;
    for (unsigned start = 1; start <= s_starts; start++)
        for (btScalar speed : {btScalar(10), btScalar(60), btScalar(300)})
        {
            qcRandomNumbers random(start);
            qcMeshWorld world;
            qcMotionOracle oracle;
            constexpr uint32_t fixed = 1;
            oracle.Add(floor, world.Add(world.Keep(floor.MakeShape()), 0, btVector3(0, 0, 0)), fixed);
            // Every other wall gives way.
            btRigidBody* target = world.Add(world.Keep(wall.MakeShape()), start % 2 == 0 ? btScalar(0) : btScalar(20),
                                            btVector3(0, 6, -3));
            oracle.Add(wall, target, fixed);
            const btQuaternion turn(random.Vector(1).normalized(), random.Number(0, 3));
            btRigidBody* thrown = world.Add(shape.get(), 1, btTransform(turn, btVector3(0, 3, 1) + random.Vector(0.5)));
            oracle.Add(core, thrown);
            thrown->setLinearVelocity(-speed * s_z + random.Vector(1));
            thrown->setAngularVelocity(random.Vector(15));
            limited += StepApart(&world, &oracle, 60, speed);
        }
    ck_assert_int_gt(limited, 0);
}
END_TEST

START_TEST(a_convex_shape_with_bullets_continuous_collision_that_is_kicked_passes_no_mesh)
{
    std::unique_ptr<btCollisionShape> shape = MakeConvex(_i);
    const qcModel core = qcCoreModel(shape.get()), wall = WallModel();
    for (unsigned start = 1; start <= 4 * s_starts; start++)
        for (btScalar speed : {btScalar(10), btScalar(30), btScalar(80)})
        {
            // At rest it is no object of the limits yet. Its sphere is small, and stops it after a part of the step.
            qcRandomNumbers random(start);
            qcMeshWorld world;
            qcMotionOracle oracle;
            constexpr uint32_t fixed = 1;
            world.world.setGravity(btVector3(0, 0, 0));
            oracle.Add(wall, world.Add(world.Keep(wall.MakeShape()), 0, btVector3(0, 0, 0)), fixed);
            const btQuaternion turn(random.Vector(1).normalized(), random.Number(0, 3));
            btRigidBody* kicked =
                world.Add(shape.get(), 1, btTransform(turn, btScalar(0.6) * s_z + random.Vector(0.1)));
            oracle.Add(core, kicked);
            kicked->setCcdMotionThreshold(btScalar(0.05));
            kicked->setCcdSweptSphereRadius(btScalar(0.01));
            StepApart(&world, &oracle);
            kicked->setLinearVelocity(-speed * s_z + random.Vector(3));
            kicked->setAngularVelocity(random.Vector(60));
            for (int step = 0; step < 20; step++)
                StepApart(&world, &oracle);
        }
}
END_TEST

START_TEST(fast_meshes_pass_no_static_convex_shape)
{
    std::unique_ptr<btCollisionShape> shape = MakeConvex(_i);
    const qcModel core = qcCoreModel(shape.get()), box = SmallBoxModel();
    int limited = 0;
    for (unsigned start = 1; start <= s_starts; start++)
        for (btScalar speed : {btScalar(10), btScalar(60), btScalar(300)})
        {
            qcRandomNumbers random(start);
            qcMeshWorld world;
            world.world.setGravity(btVector3(0, 0, 0));
            qcMotionOracle oracle;
            const btQuaternion turn(random.Vector(1).normalized(), random.Number(0, 3));
            oracle.Add(core, world.Add(shape.get(), 0, btTransform(turn, btVector3(0, 0, -3))));
            btRigidBody* thrown = world.Add(world.Keep(box.MakeShape()), 1, random.Vector(0.1));
            oracle.Add(box, thrown);
            thrown->setLinearVelocity(-speed * s_z);
            thrown->setAngularVelocity(random.Vector(5));
            limited += StepApart(&world, &oracle, 40, speed);
        }
    ck_assert_int_gt(limited, 0);
}
END_TEST

/// True if a segment passes through a rectangle at right angles to z.
bool Passes(const btVector3& from, const btVector3& to, const btVector3& centre, btScalar half)
{
    if ((from.z() > centre.z()) == (to.z() > centre.z()))
        return false;
    const btVector3 at = from.lerp(to, (centre.z() - from.z()) / (to.z() - from.z())) - centre;
    return btFabs(at.x()) < half && btFabs(at.y()) < half;
}

START_TEST(fast_convex_shapes_that_push_each_other_pass_no_mesh)
{
    // What others push at a wall spins by more than half a turn in a step.
    const qcModel wall = WallModel();
    int limited = 0;
    for (unsigned start = 1; start <= s_crowds; start++)
    {
        qcRandomNumbers random(start);
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        world.Add(world.Keep(wall.MakeShape()), 0, btVector3(0, 0, -3));
        const btScalar speed = random.Number(20, 150);
        for (int i = 0; i < 14; i++)
        {
            const btQuaternion turn(random.Vector(1).normalized(), random.Number(0, 3));
            btRigidBody* thrown =
                world.Add(world.Keep(MakeConvex(i % convex_kinds)), random.Number(0.2, 5),
                          btTransform(turn, random.Vector(0.6) + btVector3(0, 0, btScalar(0.25) * btScalar(i))));
            thrown->setLinearVelocity(-speed * s_z + random.Vector(1));
            thrown->setAngularVelocity(random.Vector(9));
        }
        std::vector<btVector3> last;
        for (const auto& body : world.bodies)
            last.push_back(body->getWorldTransform().getOrigin());
        for (int step = 0; step < 40; step++)
        {
            world.Step();
            limited += world.contact.getStatistics().limited;
            for (size_t i = 1; i < world.bodies.size(); i++)
            {
                const btVector3& now = world.bodies[i]->getWorldTransform().getOrigin();
                ck_assert(!Passes(last[i], now, btVector3(0, 0, -3), btScalar(4.5)));
                last[i] = now;
            }
        }
    }
    printf("crowds at a wall: %d bodies limited\n", limited);
}
END_TEST

btRigidBody* AddKinematic(qcMeshWorld* world, btCollisionShape* shape, const btTransform& place)
{
    btRigidBody* body = world->Add(shape, 0, place);
    body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    body->setActivationState(DISABLE_DEACTIVATION);
    return body;
}

START_TEST(a_fast_kinematic_mesh_takes_along_a_convex_shape)
{
    std::unique_ptr<btCollisionShape> shape = MakeConvex(_i);
    const qcModel core = qcCoreModel(shape.get()), wall = WallModel();
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    btRigidBody *swept = world.Add(shape.get(), 1, btVector3(0, 0, 0)),
                *mover = AddKinematic(&world, world.Keep(wall.MakeShape()),
                                      btTransform(btQuaternion::getIdentity(), btVector3(0, 0, 3)));
    qcMotionOracle oracle;
    oracle.Add(core, swept);
    oracle.Add(wall, mover);
    for (int step = 1; step <= 10; step++)
    {
        mover->setWorldTransform(
            btTransform(btQuaternion::getIdentity(), btVector3(0, 0, btScalar(3) - btScalar(0.7) * btScalar(step))));
        world.Step();
        ck_assert_uint_eq(oracle.Count(), 0);
    }
    ck_assert_double_lt(double(swept->getWorldTransform().getOrigin().z()), -3.9);
}
END_TEST

START_TEST(fast_kinematic_convex_shapes_pass_no_mesh)
{
    std::unique_ptr<btCollisionShape> shape = MakeConvex(_i);
    const qcModel core = qcCoreModel(shape.get()), box = SmallBoxModel();
    int limited = 0;
    for (unsigned start = 1; start <= s_starts; start++)
        // At 47 m/s none stops in the mesh.
        for (btScalar speed : {btScalar(3), btScalar(10), btScalar(47), btScalar(60)})
        {
            qcRandomNumbers random(start);
            qcMeshWorld world;
            world.world.setGravity(btVector3(0, 0, 0));
            qcMotionOracle oracle;
            const btQuaternion turn(random.Vector(1).normalized(), random.Number(0, 3));
            btTransform place(turn, btVector3(0, 0, 3));
            btRigidBody* mover = AddKinematic(&world, shape.get(), place);
            oracle.Add(core, mover);
            oracle.Add(box, world.Add(world.Keep(box.MakeShape()), 1, random.Vector(0.1)));
            const btVector3 spin = random.Vector(btScalar(0.1));
            for (int step = 0; step < 60; step++)
            {
                place.setOrigin(place.getOrigin() - speed / 60 * s_z);
                place.setRotation(btQuaternion(spin.normalized(), spin.length()) * place.getRotation());
                mover->setWorldTransform(place);
                limited += StepApart(&world, &oracle);
            }
        }
    ck_assert_int_gt(limited, 0);
}
END_TEST

START_TEST(a_mesh_at_rest_that_is_pushed_passes_no_convex_shape)
{
    // A plate strikes one end of a long rod, whose other end is at a static shape that is far from the plate.
    for (int speed = 20; speed <= 100; speed += 10)
    {
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        btCollisionShape* shape = world.Keep(MakeConvex(_i));
        btRigidBody* fixed = world.Add(shape, 0, btVector3(btScalar(2.55), 0, 0));
        const qcModel rodModel = qcBoxModel(btVector3(2, btScalar(0.08), btScalar(0.08)), 1), core = qcCoreModel(shape);
        btRigidBody* rod = world.Add(world.Keep(rodModel.MakeShape()), 1, btVector3(0, 0, 0));
        rod->setActivationState(DISABLE_DEACTIVATION);
        btTransform place(btQuaternion::getIdentity(), btVector3(btScalar(-2.5), 0, 0));
        btRigidBody* plate = AddKinematic(
            &world, world.Keep(qcBoxModel(btVector3(btScalar(0.1), btScalar(0.5), btScalar(0.5)), 1).MakeShape()),
            place);
        plate->setInterpolationWorldTransform(place);
        world.Step();
        qcMotionOracle oracle;
        oracle.Add(rodModel, rod);
        oracle.Add(core, fixed);
        place.getOrigin() += btVector3(btScalar(speed) * qcStep, 0, 0);
        plate->setWorldTransform(place);
        world.Step();
        ck_assert_msg(oracle.Count() == 0 || world.contact.getStatistics().unproven > 0, "speed %d", speed);
    }
}
END_TEST

START_TEST(a_kinematic_convex_shape_that_is_put_elsewhere_takes_nothing_along)
{
    // With notice, or by a jump of more than eight sizes.
    for (bool isTold : {true, false})
    {
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        const qcModel box = SmallBoxModel();
        btRigidBody* body = world.Add(world.Keep(box.MakeShape()), 1, btVector3(0, 0, 0));
        btTransform place(btQuaternion::getIdentity(), (isTold ? 3 : 10) * s_z);
        btRigidBody* mover = AddKinematic(&world, world.Keep(MakeConvex(convex_box)), place);
        for (int step = 0; step < 20; step++)
        {
            if (step == 10)
            {
                place.setOrigin(-place.getOrigin());
                mover->setWorldTransform(place);
                if (isTold)
                    mover->setInterpolationWorldTransform(place);
            }
            world.Step();
            ck_assert_int_eq(world.contact.getStatistics().limited, 0);
        }
        ck_assert_double_eq(double(body->getWorldTransform().getOrigin().length()), 0);
    }
}
END_TEST

START_TEST(debris_that_sinks_into_a_box_comes_out_again)
{
    // In one step it gets wholly inside of the core, whose surface it then doesn't meet.
    for (unsigned start = 1; start <= s_starts; start++)
        for (btScalar half : {btScalar(0.03), btScalar(0.05)})
            for (btScalar speed : {btScalar(6), btScalar(9), btScalar(12)})
            {
                qcRandomNumbers random(start);
                qcMeshWorld world;
                auto box = std::make_unique<btBoxShape>(btVector3(10, btScalar(0.5), 10));
                btCollisionShape* ground = world.Keep(std::move(box));
                if (_i == 1)
                {
                    auto compound = std::make_unique<btCompoundShape>();
                    compound->addChildShape(btTransform::getIdentity(), ground);
                    ground = world.Keep(std::move(compound));
                }
                world.Add(ground, 0, btVector3(0, btScalar(-0.5), 0));
                const qcModel cube = qcBoxModel(btVector3(half, half, half), 2);
                btRigidBody* body = world.Add(world.Keep(cube.MakeShape()), 1, btVector3(0, random.Number(1, 1.3), 0));
                body->setLinearVelocity(btVector3(0, -speed, 0));
                world.Step(240);
                ck_assert_double_gt(double(body->getWorldTransform().getOrigin().y()), 0);
            }
}
END_TEST

/// What is pressed on a mesh: a convex shape, or a compound of one, up to 25 cm in half.
std::unique_ptr<btCollisionShape> MakePressed(qcMeshWorld* world, qcRandomNumbers* random, btScalar* height)
{
    const btVector3 half(random->Number(0.05, 0.25), random->Number(0.02, 0.25), random->Number(0.05, 0.25));
    *height = half.y();
    switch (int(random->Number(0, 4.99)))
    {
        case 0: return std::make_unique<btBoxShape>(half);
        case 1: *height = half.x(); return std::make_unique<btSphereShape>(half.x());
        case 2: return std::make_unique<btCylinderShape>(btVector3(half.x(), half.y(), half.x()));
        case 3: *height = half.x(); return std::make_unique<btCapsuleShapeX>(half.x(), 2 * half.z());
        default: break;
    }
    auto compound = std::make_unique<btCompoundShape>();
    compound->addChildShape(btTransform::getIdentity(), world->Keep(std::make_unique<btBoxShape>(half)));
    return compound;
}

/// Convex bodies above each other on a mesh. Inner cores are followed: they are apart from the mesh at the start.
struct PressedHeap
{
    qcMeshWorld world;
    qcMotionOracle oracle;
    std::vector<std::unique_ptr<qcModel>> cores;
    btScalar top = btScalar(0.06);

    PressedHeap(unsigned start, int count, btScalar exponent)
    {
        qcRandomNumbers random(start);
        for (int i = 0; i < count; i++)
        {
            btScalar height = 0;
            btCollisionShape* shape = world.Keep(MakePressed(&world, &random, &height));
            cores.emplace_back(new qcModel(qcCoreModel(shape, qcInnerCoreSize)));
            const btVector3 at(random.Number(-0.3, 0.3), top + height + btScalar(0.01), random.Number(-0.3, 0.3));
            const btScalar mass = btPow(10, random.Number(0, exponent));
            oracle.Add(*cores.back(), world.Add(shape, mass, at), pressed);
            top += 2 * height + btScalar(0.01);
        }
    }

    /// Cores may be in each other.
    static constexpr uint32_t pressed = 1;
};

START_TEST(heavy_heaps_press_nothing_through_a_mesh)
{
    const qcModel floor = qcFloorModel(4, 8);
    for (unsigned start = 1; start <= s_heaps; start++)
    {
        PressedHeap heap(start, 2 + int(start % 8), 3);
        heap.oracle.Add(floor, heap.world.Add(heap.world.Keep(floor.MakeShape()), 0, btVector3(0, 0, 0)));
        for (int step = 0; step < 240; step++)
            StepApart(&heap.world, &heap.oracle);
    }
}
END_TEST

START_TEST(a_piston_presses_nothing_through_a_mesh)
{
    const qcModel floor = qcFloorModel(4, 40);
    for (unsigned start = 1; start <= s_heaps; start++)
    {
        PressedHeap heap(start, 1 + int(start % 5), 1);
        heap.oracle.Add(floor, heap.world.Add(heap.world.Keep(floor.MakeShape()), 0, btVector3(0, 0, 0)));
        btTransform place(btQuaternion::getIdentity(), btVector3(0, heap.top + btScalar(0.3), 0));
        btRigidBody* piston = AddKinematic(
            &heap.world, heap.world.Keep(std::make_unique<btBoxShape>(btVector3(2, btScalar(0.2), 2))), place);
        const btScalar speed = btScalar(0.1) + btScalar(start % 7) / 5;
        for (int step = 0; step < 240; step++)
        {
            // It stops next to the floor.
            place.getOrigin().setY(std::max(place.getOrigin().y() - speed * qcStep, btScalar(0.3)));
            piston->setWorldTransform(place);
            StepApart(&heap.world, &heap.oracle);
        }
    }
}
END_TEST

enum Exemption
{
    exemption_none,
    exemption_trigger,
    exemption_filter,
    exemption_ignored,
    exemption_callback,
    exemption_kinds
};

START_TEST(a_convex_shape_passes_only_what_it_does_not_collide_with)
{
    // From afar, slow enough for the boxes to overlap in some step, and from so near that it would pass in the first
    // one.
    for (bool isNear : {false, true})
    {
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        if (_i == exemption_callback)
            world.dispatcher.setNearCallback([](btBroadphasePair&, btCollisionDispatcher&, const btDispatcherInfo&) {});
        btRigidBody* target = world.Add(world.Keep(WallModel().MakeShape()), 0, btVector3(0, 0, -1));
        // With contact of meshes in the step, starts of bodies are marked.
        world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(3, 0, btScalar(-0.47)));
        btRigidBody* thrown = world.Add(world.Keep(MakeConvex(convex_sphere)), 1,
                                        btVector3(0, 0, isNear ? btScalar(-0.77) : btScalar(1)));
        if (_i == exemption_trigger)
            thrown->setCollisionFlags(btCollisionObject::CF_NO_CONTACT_RESPONSE);
        if (_i == exemption_ignored)
            thrown->setIgnoreCollisionCheck(target, true);
        if (_i == exemption_filter)
        {
            world.world.removeRigidBody(thrown);
            world.world.addRigidBody(thrown, 2, 2);
        }
        thrown->setLinearVelocity((isNear ? -60 : -10) * s_z);
        int limited = 0;
        for (int step = 0; step < 60; step++)
        {
            world.Step();
            limited += world.contact.getStatistics().limited;
        }
        const double z = double(thrown->getWorldTransform().getOrigin().z());
        if (_i == exemption_none)
            ck_assert_double_gt(z, -1);
        else
        {
            ck_assert_double_lt(z, -5);
            ck_assert_int_eq(limited, 0);
        }
    }
}
END_TEST

/// Throws a shape at a wall of a mesh, or the wall at the shape. `radius`: of the shape; `part`: of the radius, by
/// which it moves in a step.
void ThrowSmall(btCollisionShape* shape, btScalar radius, btScalar part, bool movesWall, int start)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    btCollisionShape* wall = world.Keep(qcBoxModel(btVector3(20, 20, btScalar(0.01)) * radius, 2).MakeShape());
    wall->setMargin(radius / 20);
    const btScalar step = part * radius, away = 10 * radius + step * btScalar(start) / 10;
    btRigidBody* target = world.Add(wall, movesWall ? btScalar(100) : btScalar(0), btVector3(0, 0, 0));
    btRigidBody* thrown = world.Add(shape, 1, btTransform(btQuaternion(s_z, btScalar(0.3)), btVector3(0, 0, away)));
    btRigidBody* moving = movesWall ? target : thrown;
    moving->setLinearVelocity((movesWall ? step : -step) / qcStep * s_z);
    moving->setActivationState(DISABLE_DEACTIVATION);
    world.Step(60);
    ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
    // The wall turns where it is hit beside its centre.
    ck_assert_double_gt(double((target->getWorldTransform().inverse() * thrown->getWorldTransform().getOrigin()).z()),
                        0);
}

START_TEST(small_convex_shapes_pass_no_mesh)
{
    for (btScalar radius : {btScalar(0.02), btScalar(0.005), btScalar(0.0015), btScalar(0.0003)})
        for (btScalar part : {btScalar(0.6), btScalar(1.2), btScalar(2.5), btScalar(20)})
            for (int start = 0; start < 10; start += 2)
            {
                btSphereShape ball(radius);
                btBoxShape box(btVector3(1, 1, 1) * radius);
                ThrowSmall(&ball, radius, part, false, start);
                ThrowSmall(&box, radius, part, false, start);
                ThrowSmall(&ball, radius, part, true, start);
            }
}
END_TEST

START_TEST(slow_convex_shapes_are_left_to_bullet)
{
    qcMeshWorld world;
    world.Add(world.Keep(qcFloorModel(4, 8).MakeShape()), 0, btVector3(0, 0, 0));
    btCollisionShape* box = world.Keep(MakeConvex(convex_box));
    for (int i = 0; i < 4; i++)
        world.Add(box, 1, btVector3(0, btScalar(0.12) + btScalar(0.22) * btScalar(i), 0));
    for (int step = 0; step < 120; step++)
    {
        world.Step();
        ck_assert_int_eq(world.contact.getStatistics().limited, 0);
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("convex_through");
    tcase_add_loop_test(tests, a_core_is_inside_its_shape, 0, convex_kinds);
    tcase_add_test(tests, a_core_follows_changes_of_its_shape);
    tcase_add_test(tests, a_hull_at_the_address_of_a_deleted_one_has_a_core_of_its_own);
    tcase_add_loop_test(tests, fast_convex_shapes_pass_no_mesh, 0, convex_kinds);
    tcase_add_loop_test(tests, a_convex_shape_with_bullets_continuous_collision_that_is_kicked_passes_no_mesh, 0,
                        convex_kinds);
    tcase_add_loop_test(tests, fast_meshes_pass_no_static_convex_shape, 0, convex_kinds);
    tcase_add_test(tests, fast_convex_shapes_that_push_each_other_pass_no_mesh);
    tcase_add_loop_test(tests, balls_bounce_off_a_mesh_at_any_speed, 0, 3);
    tcase_add_test(tests, balls_without_restitution_do_not_bounce_off_a_mesh);
    tcase_add_loop_test(tests, a_fast_kinematic_mesh_takes_along_a_convex_shape, 0, convex_kinds);
    tcase_add_loop_test(tests, fast_kinematic_convex_shapes_pass_no_mesh, 0, convex_kinds);
    tcase_add_test(tests, a_kinematic_convex_shape_that_is_put_elsewhere_takes_nothing_along);
    tcase_add_loop_test(tests, a_mesh_at_rest_that_is_pushed_passes_no_convex_shape, 0, convex_kinds);
    tcase_add_loop_test(tests, debris_that_sinks_into_a_box_comes_out_again, 0, 2);
    tcase_add_test(tests, heavy_heaps_press_nothing_through_a_mesh);
    tcase_add_test(tests, a_piston_presses_nothing_through_a_mesh);
    tcase_add_loop_test(tests, a_convex_shape_passes_only_what_it_does_not_collide_with, 0, exemption_kinds);
    tcase_add_test(tests, small_convex_shapes_pass_no_mesh);
    tcase_add_test(tests, slow_convex_shapes_are_left_to_bullet);
    return qcRunCase("convex_through", tests);
}
