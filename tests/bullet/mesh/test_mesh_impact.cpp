// Meshes that move by more than the contact distance in a step: they stop where they touch, not deep inside.
// The pile of bunnies is left out where their file is missing.
#include "bullet/add_loop.h"
#include "bullet/mesh/mesh_world.h"
#include "bullet/mesh/motion_oracle.h"
#include "bullet/random_numbers.h"

#include <BulletDynamics/Dynamics/btSimpleDynamicsWorld.h>

#ifdef QC_BUNNY
#include "bullet/mesh/mesh_bunny.h"
#endif

namespace
{
constexpr btScalar s_speed = 5; // 8 cm a step, and a threshold of 1.7
constexpr double s_speeds[] = {10, 20, 40, 80};

btScalar BodyHeight(const btRigidBody* body)
{
    return body->getWorldTransform().getOrigin().y();
}

/// Drops a shape, whose lowest point is 0.5 below its origin, from twenty heights.
void CheckFall(qcFloor floor, bool compound, btScalar turn)
{
    for (int i = 0; i < 20; i++)
    {
        qcMeshWorld world;
        btScalar rest = btScalar(0.51) + qcAddFloor(world, floor);
        btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
        if (compound)
        {
            auto* parent = new btCompoundShape;
            parent->addChildShape(btTransform::getIdentity(), shape);
            shape = world.Keep(std::unique_ptr<btCollisionShape>(parent));
        }
        btRigidBody* cube = world.Add(shape, 1,
                                      btTransform(btQuaternion(btVector3(0, 1, 0), turn),
                                                  btVector3(btScalar(0.1), btScalar(0.62 + 0.013 * i), btScalar(0.2))));
        cube->setLinearVelocity(btVector3(0, -s_speed, 0));
        int moments = 0, planes = 0;
        for (int step = 0; step < 20; step++)
        {
            world.Step();
            moments = std::max(moments, world.contact.getStatistics().moments);
            planes = std::max(planes, world.contact.getStatistics().planes);
            // The velocity at the beginning of the step lacks only the step's gravity.
            ck_assert_double_gt(double(BodyHeight(cube)), double(rest) - 2e-3);
        }
        ck_assert_double_lt(double(BodyHeight(cube)), double(rest) + 0.02);
        // Meshes in compounds are sampled; a single one, as small as this, has contact on both sides of a plane.
        ck_assert_int_ge(compound ? moments : planes, compound ? 2 : 1);
        // At rest.
        ck_assert_int_eq(world.contact.getStatistics().moments, 0);
    }
}

START_TEST(a_fast_cube_is_stopped_on_any_mesh_not_in_it)
{
    CheckFall(qcFloor(_i), false, btScalar(0.3));
}
END_TEST

START_TEST(a_fine_ball_that_falls_straight_is_hardly_thrown_aside)
{
    const btScalar radius = btScalar(0.3), speed = 30;
    constexpr int starts = 20;
    // Triangles few enough for planes between hulls, and more.
    for (int levels : {4, 5})
    {
        qcModel ball = qcSphereModel(0.3, levels), floor = qcFloorModel(5, 16);
        double spin = 0, aside = 0;
        for (int i = 0; i < starts; i++)
        {
            qcMeshWorld world;
            world.world.setGravity(btVector3(0, 0, 0));
            world.Add(world.StaticMesh(floor), 0, btVector3(0, 0, 0));
            btQuaternion turn(btVector3(btScalar(0.3), 1, btScalar(0.2)).normalized(), btScalar(0.37 * i));
            btRigidBody* body = world.Add(world.Keep(ball.MakeShape()), 1,
                                          btTransform(turn, btVector3(0, radius + btScalar(0.08 + 0.037 * i), 0)));
            body->setLinearVelocity(btVector3(0, -speed, 0));
            world.Step(10);
            const btVector3 velocity = body->getLinearVelocity();
            spin += double(body->getAngularVelocity().length() * radius / speed) / starts;
            aside += double(btVector3(velocity.x(), 0, velocity.z()).length() / speed) / starts;
        }
        printf("ball of %u triangles at 30 m/s: spin %.1f %%, aside %.1f %%\n", ball.TriangleCount(), 100 * spin,
               100 * aside);
        ck_assert_double_lt(spin, 0.04);
        ck_assert_double_lt(aside, 0.025);
    }
}
END_TEST

START_TEST(a_ball_is_sampled_until_it_touches_and_no_further)
{
    // 0.5 m in a step, in 16 samples; of too many triangles for a plane between hulls.
    const btScalar radius = btScalar(0.3), speed = 30, interval = speed / 60 / 16;
    qcModel ball = qcSphereModel(double(radius), 5);
    for (int i = 0; i < 20; i++)
    {
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        btScalar margin = qcAddFloor(world, qc_floorOurs);
        btCollisionShape* shape = world.Keep(ball.MakeShape());
        btScalar gap = btScalar(0.05 + 0.021 * i);
        btScalar rest = radius + margin + shape->getMargin();
        btRigidBody* body = world.Add(shape, 1, btVector3(0, rest + gap, 0));
        body->setLinearVelocity(btVector3(0, -speed, 0));
        world.Step();
        ck_assert_double_gt(double(BodyHeight(body)), double(rest) - 2e-3);
        ck_assert_int_ge(world.contact.getStatistics().moments, int(gap / interval));
        ck_assert_int_le(world.contact.getStatistics().moments, int(std::ceil(gap / interval)));
    }
}
END_TEST

START_TEST(a_ball_that_slides_on_the_floor_of_a_bin_is_stopped_by_its_wall)
{
    // Floor and wall are one mesh: contact with the floor ends no sampling.
    const btScalar speed = 30;
    double deepest = 0;
    for (int i = 0; i < 12; i++)
    {
        qcMeshWorld world;
        qcModel bin = qcBinModel(2, 1), ball = qcSphereModel(0.3, 5);
        btCollisionShape *floor = world.Keep(bin.MakeShape()), *shape = world.Keep(ball.MakeShape());
        world.Add(floor, 0, btVector3(0, 0, 0));
        btScalar radius = btScalar(0.3) + shape->getMargin() + floor->getMargin();
        btScalar start = btScalar(0.5 + 0.04 * i), way = 2 - radius - start;
        btRigidBody* body = world.Add(shape, 1, btVector3(start, radius, 0));
        body->setFriction(0);
        body->setLinearVelocity(btVector3(speed, -1, 0));
        int moments = 0;
        for (int step = 0; step < 10; step++)
        {
            world.Step();
            moments += world.contact.getStatistics().moments;
            deepest = std::min(deepest, qcContactsOf(world.dispatcher).deepest);
            ck_assert_double_lt(double(body->getWorldTransform().getOrigin().x()), 2.0 - 0.3);
        }
        ck_assert_int_ge(moments, int(way / (speed / 60 / 16)));
    }
    printf("ball that slides into a wall at 30 m/s: deepest ever %.1f mm\n", -1e3 * deepest);
    ck_assert_double_gt(deepest, -5e-3);
}
END_TEST

START_TEST(bodies_that_fall_side_by_side_are_not_sampled)
{
    qcMeshWorld world;
    btCollisionShape* cube = world.Keep(qcCubeModel().MakeShape());
    for (int i = 0; i < 2; i++)
    {
        btRigidBody* body = world.Add(cube, 1, btVector3(btScalar(1.03 * i), 0, 0));
        body->setLinearVelocity(btVector3(0, -20, 0));
    }
    for (int i = 0; i < 10; i++)
    {
        world.Step();
        ck_assert_uint_gt(world.contact.getStatistics().batches, 0);
        ck_assert_int_eq(world.contact.getStatistics().moments, 0);
    }
}
END_TEST

START_TEST(a_falling_column_is_stopped_from_its_foot_to_its_head)
{
    // 5 cm apart; the first stops while the others move by 10 cm a step, together. Bullet's solver needs more than its
    // ten iterations to propagate an impulse from one end to the other.
    double deepest = 0;
    for (int start = 0; start < 8; start++)
    {
        qcMeshWorld world;
        world.world.getSolverInfo().m_numIterations = 50;
        qcAddFloor(world, qc_floorOurs);
        btCollisionShape* cube = world.Keep(qcCubeModel().MakeShape());
        for (int i = 0; i < 5; i++)
        {
            btVector3 place(btScalar(0.05 * (i % 2)), btScalar(0.7 + 0.012 * start + 1.05 * i), 0);
            world.Add(cube, 1, place)->setLinearVelocity(btVector3(0, -6, 0));
        }
        for (int i = 0; i < 60; i++)
        {
            world.Step();
            deepest = std::min(deepest, qcContactsOf(world.dispatcher).deepest);
        }
    }
    ck_assert_double_gt(deepest, -2e-3); // without sampling -0.16 to -0.55; with sampling of fast pairs only -0.10
}
END_TEST

/// Spins a bar against a post. Returns in how many sampled steps a plane between the two was all that was needed.
int SpinBar(int quads)
{
    qcModel bar = qcBoxModel(btVector3(1, btScalar(0.05), btScalar(0.05)), quads);
    qcModel post = qcBoxModel(btVector3(btScalar(0.05), 1, btScalar(0.05)), quads);
    double deepest = 0;
    int byPlane = 0;
    for (int i = 0; i < 12; i++)
    {
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        btRigidBody* fixed = world.Add(world.Keep(post.MakeShape()), 0, btVector3(btScalar(0.1), 0, btScalar(0.85)));
        btRigidBody* spinning =
            world.Add(world.Keep(bar.MakeShape()), 1,
                      btTransform(btQuaternion(btVector3(0, 1, 0), btScalar(0.023 * i)), btVector3(0, 0, 0)));
        // Its end moves by 0.2 m in a step, twice its width.
        spinning->setAngularVelocity(btVector3(0, -12, 0));
        qcMotionOracle oracle;
        oracle.Add(post, fixed);
        oracle.Add(bar, spinning);
        double slowest = -12;
        for (int step = 0; step < 30; step++)
        {
            world.Step();
            deepest = std::min(deepest, qcContactsOf(world.dispatcher).deepest);
            slowest = std::max(slowest, double(spinning->getAngularVelocity().y()));
            const qcMeshContactStatistics& statistics = world.contact.getStatistics();
            byPlane += statistics.moments > 0 && statistics.planes == statistics.pairs;
            ck_assert_uint_eq(oracle.Count(), 0);
        }
        // The impact takes more than two thirds of the spin. A bar that was hit at a corner wobbles on.
        ck_assert_double_gt(slowest, -4);
    }
    // Its way in a step is curved. Without sampling it penetrates beyond its middle: 95 mm.
    ck_assert_double_gt(deepest, -0.04);
    return byPlane;
}

START_TEST(the_end_of_a_spinning_bar_does_not_pass_through_a_post)
{
    SpinBar(4);
    // More triangles than are quickly sampled.
    ck_assert_int_gt(SpinBar(8), 0);
}
END_TEST

START_TEST(a_rod_that_spins_out_of_reach_of_a_plane_meets_nothing)
{
    // Half a metre long on each side. Its ends would get to the plane within the step along straight lines.
    for (btScalar spin : {btScalar(30), btScalar(60), btScalar(90)})
        for (btScalar height : {btScalar(0.6), btScalar(0.7), btScalar(0.9)})
        {
            qcMeshWorld world;
            world.world.setGravity(btVector3(0, 0, 0));
            qcAddFloor(world, qc_floorPlane);
            const btVector3 half(btScalar(0.5), btScalar(0.05), btScalar(0.05));
            btRigidBody* rod = world.Add(world.Keep(qcBoxModel(half, 1).MakeShape()), 1, btVector3(0, height, 0));
            rod->setAngularVelocity(btVector3(0, 0, spin));
            rod->setActivationState(DISABLE_DEACTIVATION);
            for (int step = 0; step < 30; step++)
            {
                world.Step();
                ck_assert_int_eq(qcContactsOf(world.dispatcher).points, 0);
            }
            ck_assert(rod->getLinearVelocity().isZero());
        }
}
END_TEST

START_TEST(a_body_pushed_after_a_query_is_queried_again)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    btScalar rest = btScalar(0.51) + qcAddFloor(world, qc_floorOurs);
    // Near enough to be a pair, but beyond the contact distance.
    btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, rest + btScalar(0.022), 0));
    cube->setActivationState(DISABLE_DEACTIVATION);
    world.Step(3);
    uint64_t batches = world.contact.getStatistics().batches;
    world.Step(3);
    ck_assert_uint_eq(world.contact.getStatistics().batches, batches); // at rest: no query
    cube->setLinearVelocity(btVector3(0, -20, 0));
    world.Step();
    ck_assert_int_gt(world.contact.getStatistics().planes, 0);
    ck_assert_double_gt(double(BodyHeight(cube)), double(rest) - 1e-4);
    // Pushed the other way, it is free.
    cube->setLinearVelocity(btVector3(0, 20, 0));
    world.Step();
    ck_assert_double_gt(double(BodyHeight(cube)), double(rest) + 0.3);
}
END_TEST

START_TEST(velocities_that_are_not_finite_disturb_no_other_body)
{
    qcMeshWorld world;
    btScalar rest = btScalar(0.51) + qcAddFloor(world, qc_floorOurs);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btRigidBody* cube = world.Add(shape, 1, btVector3(0, rest + btScalar(0.05), 0));
    cube->setLinearVelocity(btVector3(0, -s_speed, 0));
    btRigidBody* odd = world.Add(shape, 1, btVector3(2, rest + btScalar(0.05), 0));
    odd->setLinearVelocity(btVector3(0, btScalar(-1e30), 0));
    // Not Step, which requires status ok: the body without a finite place has an error.
    world.world.stepSimulation(qcStep, 0);
    ck_assert_double_gt(double(BodyHeight(cube)), double(rest) - 2e-3);
}
END_TEST

/// The part of a height of fall that a cube rises to after the first impact.
double RiseAfterFall(qcFloor floor, btScalar height, btScalar restitution, bool warmStarts = true)
{
    qcMeshWorld world;
    if (!warmStarts)
        world.world.getSolverInfo().m_solverMode &= ~SOLVER_USE_WARMSTARTING;
    btScalar margin = qcAddFloor(world, floor);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    const btScalar rest = btScalar(0.5) + shape->getMargin() + margin;
    btRigidBody* cube = world.Add(shape, 1, btVector3(0, rest + height, 0));
    for (auto& body : world.bodies)
        body->setRestitution(btSqrt(restitution));
    for (int i = 0; i < 300 && cube->getLinearVelocity().y() <= 0; i++)
        world.Step();
    for (int i = 0; i < 300 && cube->getLinearVelocity().y() > 0; i++)
        world.Step();
    return double((cube->getWorldTransform().getOrigin().y() - rest) / height);
}

START_TEST(a_falling_cube_bounces_on_any_mesh)
{
    for (double height : {0.5, 1.0, 2.0, 2.1, 2.2, 5.0})
    {
        // The step of the impact adds no gravity to the speed of the bounce, as with Bullet's own contact.
        double full = RiseAfterFall(qcFloor(_i), btScalar(height), 1);
        double half = RiseAfterFall(qcFloor(_i), btScalar(height), btScalar(0.5));
        printf("floor %d, fall of %.1f: a cube bounces to %.0f and %.0f %% of it\n", _i, height, 100 * full,
               100 * half);
        ck_assert_double_gt(full, 0.75);
        ck_assert_double_lt(full, 1.05);
        ck_assert_double_gt(half, 0.15);
        ck_assert_double_lt(half, 0.3);
    }
}
END_TEST

START_TEST(a_falling_cube_bounces_without_warm_starting)
{
    // The solver writes no impulses: it rose to 12 % of its fall.
    for (double height : {0.5, 1.0, 2.0})
        ck_assert_double_eq_tol(RiseAfterFall(qc_floorOurs, btScalar(height), 1, false),
                                RiseAfterFall(qc_floorOurs, btScalar(height), 1, true), 0.02);
}
END_TEST

START_TEST(meshes_that_meet_in_the_air_exchange_their_velocities)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btRigidBody* bodies[2];
    for (int i = 0; i < 2; i++)
    {
        bodies[i] = world.Add(shape, 1, btVector3(btScalar(3 * i), 0, 0));
        bodies[i]->setRestitution(1);
    }
    bodies[0]->setLinearVelocity(btVector3(8, 0, 0));
    world.Step(60);
    ck_assert_double_eq_tol(double(bodies[0]->getLinearVelocity().x()), 0, 0.01);
    ck_assert_double_eq_tol(double(bodies[1]->getLinearVelocity().x()), 8, 0.01);
}
END_TEST

/// The sum over all bodies, about the origin of the world.
btVector3 AngularMomentumOf(const qcMeshWorld& world)
{
    btVector3 sum(0, 0, 0);
    for (const auto& body : world.bodies)
        sum += body->getCenterOfMassPosition().cross(body->getLinearVelocity()) / body->getInvMass() +
               body->getInvInertiaTensorWorld().inverse() * body->getAngularVelocity();
    return sum;
}

START_TEST(meshes_that_hit_each_other_off_centre_keep_their_angular_momentum)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    btCollisionShape* shape = world.Keep(qcSphereModel(0.5, 2).MakeShape());
    for (int i = 0; i < 2; i++)
    {
        btRigidBody* body = world.Add(shape, 1, btVector3(btScalar(2 * i), btScalar(0.4 * i), 0));
        body->setLinearVelocity(btVector3(btScalar(i == 0 ? 4 : 0), 2, 1));
        body->setRestitution(1);
        body->setFriction(0);
    }
    const btVector3 before = AngularMomentumOf(world);
    world.Step(60);
    ck_assert_double_gt(double(world.bodies[1]->getLinearVelocity().x()), 1);
    // It was 0.1 with a point of its own on either body.
    ck_assert_double_lt(double((AngularMomentumOf(world) - before).length()), 1e-4);
}
END_TEST

START_TEST(fast_meshes_that_limits_stop_keep_most_of_their_angular_momentum)
{
    // Where motions are cut short, bodies turn about others than where they were going: a part of it is lost.
    const btScalar half = btScalar(0.4), speed = _i == 0 ? btScalar(8) : btScalar(15);
    qcRandomNumbers random(1);
    double sum = 0, worst = 0;
    const int starts = 60;
    for (int start = 0; start < starts; start++)
    {
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        btCollisionShape* shape = world.Keep(qcBoxModel(btVector3(half, half, half), 1).MakeShape());
        for (int i = 0; i < 2; i++)
        {
            btTransform place(btQuaternion(random.Vector(1).normalized(), random.Number(0, 3)));
            place.setOrigin(btVector3(btScalar(3 * i), random.Number(-0.3, 0.3), random.Number(-0.3, 0.3)));
            btRigidBody* body = world.Add(shape, 1, place);
            body->setLinearVelocity(btVector3(i == 0 ? speed : btScalar(0), 0, 0));
            body->setAngularVelocity(random.Vector(5));
            body->setFriction(0);
        }
        const btVector3 before = AngularMomentumOf(world);
        world.Step(90);
        const double change = double((AngularMomentumOf(world) - before).length() / (speed * half));
        sum += change / starts;
        worst = std::max(worst, change);
    }
    ck_assert_msg(sum < (_i == 0 ? 0.025 : 0.08) && worst < 0.35, "it changes by %g on the average, by %g at most", sum,
                  worst);
}
END_TEST

bool MakeElastic(btManifoldPoint& point, const btCollisionObjectWrapper*, int, int, const btCollisionObjectWrapper*,
                 int, int)
{
    point.m_combinedRestitution = 1;
    return true;
}

START_TEST(the_restitution_that_a_callback_sets_is_that_of_the_bounce)
{
    qcMeshWorld world;
    btScalar rest = btScalar(0.51) + qcAddFloor(world, qc_floorOurs);
    btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, rest + 1, 0));
    cube->setCollisionFlags(cube->getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    gContactAddedCallback = MakeElastic;
    for (int i = 0; i < 60 && !(cube->getLinearVelocity().y() > 0); i++)
        world.Step();
    for (int m = 0; m < world.dispatcher.getNumManifolds(); m++)
        for (int i = 0; i < world.dispatcher.getManifoldByIndexInternal(m)->getNumContacts(); i++)
        {
            const btManifoldPoint& point = world.dispatcher.getManifoldByIndexInternal(m)->getContactPoint(i);
            ck_assert_double_eq(double(point.m_combinedRestitution), 1);
        }
    gContactAddedCallback = nullptr;
    ck_assert_double_gt(double(cube->getLinearVelocity().y()), 4);
}
END_TEST

START_TEST(a_mesh_without_response_throws_no_body_back)
{
    // The points of the impact on it have impulses, as long as it responds.
    for (int steps = 0; steps < 4; steps++)
    {
        qcMeshWorld world;
        btScalar rest = btScalar(0.51) + qcAddFloor(world, qc_floorOurs);
        btRigidBody* floor = world.bodies[0].get();
        btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, rest + btScalar(0.5), 0));
        floor->setRestitution(1);
        cube->setRestitution(1);
        for (int i = 0; i < 60 && qcContactsOf(world.dispatcher).points == 0; i++)
            world.Step();
        world.Step(steps);
        floor->setCollisionFlags(floor->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
        cube->setLinearVelocity(btVector3(0, -3, 0));
        for (int i = 0; i < 10; i++)
        {
            world.Step();
            ck_assert_double_lt(double(cube->getLinearVelocity().y()), -3);
        }
    }
}
END_TEST

START_TEST(a_box_that_lands_flat_bounces_flat_again_and_again)
{
    // Its nine lower vertices reach the floor up to rounding: each has to stop it, or what stops some turns it.
    for (qcFloor floor : {qc_floorPlane, qc_floorOurs})
        for (double restitution : {0.8, 1.0})
        {
            qcMeshWorld world;
            qcAddFloor(world, floor);
            world.bodies[0]->setRestitution(1);
            btRigidBody* box =
                world.Add(world.Keep(qcBoxModel(btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.3)), 2).MakeShape()),
                          2, btVector3(btScalar(0.013), 2, btScalar(0.021)));
            box->setRestitution(btScalar(restitution));
            int bounces = 0;
            double down = 0;
            for (int step = 0; step < 400 && bounces < 5; step++)
            {
                const double before = double(box->getLinearVelocity().y());
                world.Step();
                const double after = double(box->getLinearVelocity().y());
                down = before < 0 ? before : down;
                if (before > 0 || after <= 0)
                    continue;
                ck_assert_double_eq_tol(-after / down, restitution, 0.01);
                bounces++;
            }
            ck_assert_int_eq(bounces, 5);
            ck_assert_double_lt(double(box->getAngularVelocity().length()), 0.01);
        }
}
END_TEST

START_TEST(a_row_that_is_struck_gains_no_energy)
{
    for (int kind = 0; kind < 2; kind++)
        for (btScalar speed : {btScalar(3), btScalar(10), btScalar(30)})
            for (btScalar gap : {btScalar(0.001), btScalar(0.005), btScalar(0.02)})
            {
                qcMeshWorld world;
                world.world.setGravity(btVector3(0, 0, 0));
                const qcModel model = kind == 0 ? qcCubeModel() : qcSphereModel(0.5, 2);
                btCollisionShape* shape = world.Keep(model.MakeShape());
                for (int i = 0; i < 5; i++)
                {
                    btRigidBody* body = world.Add(
                        shape, 1, btVector3(btScalar(i) * (btScalar(1.02) + gap) - (i == 0 ? btScalar(0.3) : 0), 0, 0));
                    body->setRestitution(1);
                    body->setFriction(0);
                    body->setActivationState(DISABLE_DEACTIVATION);
                }
                world.bodies[0]->setLinearVelocity(btVector3(speed, 0, 0));
                const double before = world.KineticEnergy();
                for (int step = 0; step < 60; step++)
                {
                    world.Step();
                    ck_assert_double_lt(world.KineticEnergy(), 1.01 * before);
                }
                btVector3 momentum(0, 0, 0);
                for (const auto& body : world.bodies)
                    momentum += body->getLinearVelocity();
                ck_assert_double_lt(double((momentum - btVector3(speed, 0, 0)).length()), 1e-3 * double(speed));
                ck_assert_double_gt(double(world.bodies[4]->getLinearVelocity().x()), 0.3 * double(speed));
            }
}
END_TEST

/// A ball flies past the edge of a box, in the plane across it. Returns the change of its velocity as a part of it.
static double ChangePastEdge(double speed, double clearance, double angle, double phase)
{
    constexpr double radius = 0.15, half = 0.5;
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    world.Add(world.Keep(qcBoxModel(btVector3(half, half, half), 1).MakeShape()), 0, btVector3(0, 0, 0));
    const btVector3 direction(btScalar(cos(angle)), 0, btScalar(sin(angle))), across(-direction.z(), 0, direction.x());
    const btVector3 edge(half, 0, half), outward = across.dot(edge) > 0 ? across : -across;
    const btScalar margins = btScalar(0.02);
    const btVector3 place =
        edge + outward * (btScalar(radius + clearance) + margins) - direction * btScalar(3 + speed / 60 * phase);
    btRigidBody* ball = world.Add(world.Keep(qcSphereModel(radius, 2).MakeShape()), 1, place);
    ball->setLinearVelocity(direction * btScalar(speed));
    ball->setActivationState(DISABLE_DEACTIVATION);
    world.Step(int(6 / speed * 60) + 2);
    return double((ball->getLinearVelocity() - direction * btScalar(speed)).length()) / speed;
}

START_TEST(what_flies_past_an_edge_is_not_deflected)
{
    const double clearance = 0.0025 * s_speeds[_i];
    for (int phase = 0; phase < 16; phase++)
        for (double turn : {-0.5, 0.0, 0.5})
        {
            ck_assert_double_lt(ChangePastEdge(s_speeds[_i], clearance, turn - 0.785, phase / 16.0), 1e-3);
            // What flies at the edge is.
            ck_assert_double_gt(ChangePastEdge(s_speeds[_i], -0.1, turn - 0.785, phase / 16.0), 0.05);
        }
}
END_TEST

START_TEST(the_end_of_a_plank_that_turns_meets_a_box_in_the_step_in_which_it_reaches_it)
{
    constexpr double turn = 1.5, reach = 2.8, half = 0.171875; // the last in binary
    for (int phase = 0; phase < 16; phase++)
    {
        // It closes in the first or the second step, after a part of it.
        const int step = 1 + phase / 8;
        const double part = 0.1 + 0.1 * (phase % 8), gap = turn * (reach + half) / 60 * (step - 1 + part);
        qcMeshWorld world;
        world.world.setGravity(btVector3(0, 0, 0));
        const btVector3 size(3, btScalar(0.05), btScalar(0.3)), box(half, half, half);
        btRigidBody* plank = world.Add(world.Keep(qcBoxModel(size, 1).MakeShape()), 1000, btVector3(0, 0, 0));
        const btVector3 above(btScalar(reach), size.y() + btScalar(half + 0.02 + gap), 0);
        btRigidBody* small = world.Add(world.Keep(qcBoxModel(box, 1).MakeShape()), 1, above);
        plank->setAngularVelocity(btVector3(0, 0, btScalar(turn)));
        world.Step(step);
        ck_assert_double_gt(double(small->getLinearVelocity().y()), 0.5 * (1 - part) * turn * reach);
        ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
    }
}
END_TEST

START_TEST(what_falls_past_a_ledge_is_not_deflected)
{
    for (int i = 0; i < 8; i++)
    {
        qcMeshWorld world;
        world.Add(world.Keep(qcBoxModel(btVector3(1, btScalar(0.1), 1), 1).MakeShape()), 0, btVector3(0, 0, 0));
        const btVector3 place(btScalar(1 + 0.25 + 0.02 + 0.03), btScalar(1.5 + 0.1 * i), 0);
        btRigidBody* crate = world.Add(
            world.Keep(qcBoxModel(btVector3(btScalar(0.25), btScalar(0.25), btScalar(0.25)), 1).MakeShape()), 1, place);
        world.Step(60);
        ck_assert_double_lt(double(crate->getWorldTransform().getOrigin().y()), -1);
        ck_assert_double_lt(fabs(double(crate->getLinearVelocity().x())), 1e-3);
        ck_assert_double_lt(double(crate->getAngularVelocity().length()), 1e-3);
    }
}
END_TEST

START_TEST(meshes_bounce_in_a_world_that_runs_no_actions)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcMeshContact contact;
    btSimpleDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    ck_assert_int_eq(contact.addTo(&world), qc_statusOk);
    world.setGravity(btVector3(0, -10, 0));
    auto floorShape = qcFloorModel(2, 2).MakeShape(), shape = qcCubeModel().MakeShape();
    btRigidBody floor(0, nullptr, floorShape.get());
    btVector3 inertia;
    shape->calculateLocalInertia(1, inertia);
    btRigidBody cube(1, nullptr, shape.get(), inertia);
    cube.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 2, 0)));
    for (btRigidBody* body : {&floor, &cube})
    {
        body->setRestitution(1);
        world.addRigidBody(body);
    }
    btScalar fastest = 0;
    for (int i = 0; i < 60; i++)
    {
        world.stepSimulation(qcStep, 0);
        fastest = std::max(fastest, cube.getLinearVelocity().y());
    }
    ck_assert_double_gt(double(fastest), 4);
    for (btRigidBody* body : {&floor, &cube})
        world.removeRigidBody(body);
}
END_TEST

START_TEST(bouncing_meshes_gain_no_energy)
{
    qcModel room = qcBoxModel(btVector3(3, 3, 3), 2), cube = qcCubeModel(), ball = qcSphereModel(0.5, 2);
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    world.Add(world.Keep(room.MakeShape()), 0, btVector3(0, 0, 0));
    for (int i = 0; i < 8; i++)
    {
        btVector3 place(btScalar(i & 1 ? 1.2 : -1.2), btScalar(i & 2 ? 1.2 : -1.2), btScalar(i & 4 ? 1.2 : -1.2));
        btTransform turned(btQuaternion(btVector3(1, btScalar(0.2), 0).normalized(), btScalar(i)), place);
        btRigidBody* body = world.Add(world.Keep((i % 3 == 0 ? cube : ball).MakeShape()), 10, turned);
        body->setLinearVelocity(btVector3(btScalar(5 - 1.4 * i), btScalar(3 - i), btScalar(4 - 0.9 * i)));
        body->setActivationState(DISABLE_DEACTIVATION);
    }
    for (auto& body : world.bodies)
    {
        body->setRestitution(1);
        body->setFriction(0);
    }
    const double before = world.KineticEnergy();
    for (int i = 0; i < 300; i++)
    {
        world.Step();
        ck_assert_double_lt(world.KineticEnergy(), before * (1 + 1e-3));
    }
    printf("energy after 300 steps with restitution 1: %.0f %%\n", 100 * world.KineticEnergy() / before);
    ck_assert_double_gt(world.KineticEnergy(), before / 4);
}
END_TEST

#ifdef QC_BUNNY
/// Throws five bunnies into a bin at 6 m/s. Returns their places after two seconds.
std::vector<btTransform> ThrowBunnies(const qcModel& model, btScalar aside, double* deepest)
{
    qcMeshWorld world;
    world.Add(world.StaticMesh(qcBinModel(btScalar(0.9), 4)), 0, btVector3(0, 0, 0));
    btCollisionShape* shape = world.Keep(model.MakeShape());
    std::vector<qcPlacedModel> placed;
    for (int i = 0; i < 5; i++)
    {
        btRigidBody* body = world.Add(
            shape, 1,
            btVector3(btScalar(0.15 * (i % 3) - 0.15) + aside, btScalar(0.7 + 1.05 * i), btScalar(0.1 * (i % 2))));
        body->setLinearVelocity(btVector3(0, -6, 0));
        placed.push_back({&model, body});
    }
    for (int i = 0; i < 120; i++)
    {
        world.Step();
        *deepest = std::min(*deepest, qcContactsOf(world.dispatcher).deepest);
    }
    ck_assert_uint_eq(qcCountPenetrating(placed), 0);
    std::vector<btTransform> places;
    for (const auto& body : world.bodies)
        places.push_back(body->getWorldTransform());
    return places;
}

START_TEST(thrown_bunnies_do_not_hook_into_each_other)
{
    qcModel model = qcBunnyModel(QC_BUNNY);
    double deepest = 0;
    for (int i = 0; i < 4; i++)
        ThrowBunnies(model, btScalar(0.001 * i), &deepest);
    printf("bunnies of 1 m at 6 m/s: deepest ever %.0f mm\n", -1e3 * deepest);
    // Without sampling 100 to 150: half of their way in a step.
    ck_assert_double_gt(deepest, -0.06);
}
END_TEST

START_TEST(the_same_throw_ends_the_same_way)
{
    qcModel model = qcBunnyModel(QC_BUNNY);
    double deepest = 0;
    std::vector<btTransform> first = ThrowBunnies(model, 0, &deepest), second = ThrowBunnies(model, 0, &deepest);
    ck_assert_uint_eq(first.size(), second.size());
    for (size_t i = 0; i < first.size(); i++)
        ck_assert(first[i].getOrigin() == second[i].getOrigin() && first[i].getBasis() == second[i].getBasis());
}
END_TEST
#endif
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mesh_impact");
    qcAddLoop(tests, a_fast_cube_is_stopped_on_any_mesh_not_in_it, qc_floorPlane);
    qcAddLoop(tests, a_falling_cube_bounces_on_any_mesh, qc_floorCount);
    tcase_add_test(tests, a_falling_cube_bounces_without_warm_starting);
    tcase_add_test(tests, meshes_that_meet_in_the_air_exchange_their_velocities);
    tcase_add_test(tests, meshes_that_hit_each_other_off_centre_keep_their_angular_momentum);
    tcase_add_loop_test(tests, fast_meshes_that_limits_stop_keep_most_of_their_angular_momentum, 0, 2);
    tcase_add_test(tests, the_restitution_that_a_callback_sets_is_that_of_the_bounce);
    tcase_add_test(tests, a_mesh_without_response_throws_no_body_back);
    tcase_add_test(tests, a_box_that_lands_flat_bounces_flat_again_and_again);
    tcase_add_test(tests, a_row_that_is_struck_gains_no_energy);
    tcase_add_test(tests, bouncing_meshes_gain_no_energy);
    tcase_add_test(tests, a_fine_ball_that_falls_straight_is_hardly_thrown_aside);
    tcase_add_test(tests, a_ball_is_sampled_until_it_touches_and_no_further);
    tcase_add_test(tests, a_ball_that_slides_on_the_floor_of_a_bin_is_stopped_by_its_wall);
    tcase_add_test(tests, bodies_that_fall_side_by_side_are_not_sampled);
    tcase_add_test(tests, a_falling_column_is_stopped_from_its_foot_to_its_head);
    tcase_add_test(tests, the_end_of_a_spinning_bar_does_not_pass_through_a_post);
    tcase_add_test(tests, a_rod_that_spins_out_of_reach_of_a_plane_meets_nothing);
    tcase_add_loop_test(tests, what_flies_past_an_edge_is_not_deflected, 0, int(std::size(s_speeds)));
    tcase_add_test(tests, what_falls_past_a_ledge_is_not_deflected);
    tcase_add_test(tests, the_end_of_a_plank_that_turns_meets_a_box_in_the_step_in_which_it_reaches_it);
    tcase_add_test(tests, meshes_bounce_in_a_world_that_runs_no_actions);
    tcase_add_test(tests, a_body_pushed_after_a_query_is_queried_again);
    tcase_add_test(tests, velocities_that_are_not_finite_disturb_no_other_body);
#ifdef QC_BUNNY
    tcase_add_test(tests, thrown_bunnies_do_not_hook_into_each_other);
    tcase_add_test(tests, the_same_throw_ends_the_same_way);
#endif
    return qcRunCase("mesh_impact", tests);
}
