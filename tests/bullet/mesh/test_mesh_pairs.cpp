// What is known of a pair of meshes is used as long as it holds, and no longer: plugin/docs/proofs/pair_reuse.md.
#include "bullet/mesh/mesh_world.h"

#include "mesh_contact/points/pair_contacts.h"
#include "mesh_contact/scene/box_gap.h"

#include <random>

namespace
{
using Random = std::minstd_rand;

btScalar Draw(Random* random, btScalar size)
{
    return size * btScalar(std::uniform_real_distribution<double>(-1, 1)(*random));
}

btVector3 DrawVector(Random* random, btScalar size)
{
    btScalar x = Draw(random, size), y = Draw(random, size), z = Draw(random, size);
    return btVector3(x, y, z);
}

btTransform DrawMotion(Random* random, btScalar shift, btScalar turn)
{
    btVector3 axis = DrawVector(random, 1);
    btQuaternion rotation = axis.length2() > 0 ? btQuaternion(axis, Draw(random, turn)) : btQuaternion::getIdentity();
    return btTransform(rotation, DrawVector(random, shift));
}

/// A triangle in the frame of its object.
struct Triangle
{
    btVector3 corners[3];

    btScalar Radius() const
    {
        return std::max({corners[0].length(), corners[1].length(), corners[2].length()});
    }
    /// Its corners on the way from one transform to another.
    void At(const btTransform& from, const btTransform& to, double time, double out[9]) const
    {
        for (int c = 0; c < 3; c++)
        {
            btVector3 start = from * corners[c], end = to * corners[c];
            for (int axis = 0; axis < 3; axis++)
                out[3 * c + axis] = (1 - time) * double(start[axis]) + time * double(end[axis]);
        }
    }
};

double DistanceOf(const double a[9], const double b[9])
{
    qcProximity proximity;
    ck_assert(qcTrianglesWithin(a, b, 1e9, &proximity));
    return proximity.distance;
}

/// Two triangles, what is known of them, and a step that they make.
struct MovedPair
{
    // Sizes from 0.1 to 10, places up to 50 away.
    Triangle triangles[2];
    qcPairContact pair;
    btTransform motions[2][2]; ///< start and end of each

    explicit MovedPair(Random* random)
    {
        btScalar sizes[2];
        for (int k = 0; k < 2; k++)
        {
            sizes[k] = btPow(btScalar(10), Draw(random, 1));
            for (btVector3& corner : triangles[k].corners)
                corner = DrawVector(random, sizes[k]);
        }
        btTransform place = DrawMotion(random, 50, 3);
        btScalar near = 2 * (sizes[0] + sizes[1]);
        btTransform known[2] = {place, place * DrawMotion(random, near, 3)};
        pair.isKnown = true;
        pair.a = known[0];
        pair.b = known[1];
        pair.gap = Distance(known[0], known[0], known[1], known[1], 0);
        // Both move as one, then against each other within the step.
        btTransform common = DrawMotion(random, 5, 1);
        btScalar part = btScalar(pair.gap) * btPow(btScalar(10), Draw(random, 1));
        for (int k = 0; k < 2; k++)
        {
            btScalar turn = part / (sizes[0] + sizes[1]);
            motions[k][0] = common * known[k];
            motions[k][0].getOrigin() += DrawVector(random, part / 4);
            motions[k][1] = motions[k][0] * DrawMotion(random, 0, turn);
            motions[k][1].getOrigin() += DrawVector(random, part);
        }
    }

    double Distance(const btTransform& fromA, const btTransform& toA, const btTransform& fromB, const btTransform& toB,
                    double time) const
    {
        double a[9], b[9];
        triangles[0].At(fromA, toA, time, a);
        triangles[1].At(fromB, toB, time, b);
        return DistanceOf(a, b);
    }
    double DistanceAt(double time) const
    {
        return Distance(motions[0][0], motions[0][1], motions[1][0], motions[1][1], time);
    }
    qcObjectMotion Motion(int k) const
    {
        return {motions[k][0], motions[k][1], triangles[k].Radius()};
    }
    /// From where it is known to an end of the step.
    qcObjectMotion MotionSince(int k, int end) const
    {
        return {k == 0 ? pair.a : pair.b, motions[k][end], triangles[k].Radius()};
    }
};

START_TEST(no_pair_that_stays_apart_meets_on_the_way)
{
    Random random(1);
    int proven = 0, met = 0;
    for (int i = 0; i < 20000; i++)
    {
        MovedPair moved(&random);
        bool apart = qcPairContacts::StayApart(moved.pair, moved.Motion(0), moved.Motion(1));
        bool meets = false;
        for (int sample = 0; sample <= 16 && !meets; sample++)
            meets = moved.DistanceAt(sample / 16.0) <= 0;
        ck_assert(!apart || !meets);
        proven += apart;
        met += meets;
    }
    ck_assert_int_gt(proven, 2000);
    ck_assert_int_gt(met, 100);
}
END_TEST

START_TEST(no_pair_is_nearer_than_the_gap_that_its_motion_leaves)
{
    Random random(3);
    int left = 0;
    for (int i = 0; i < 20000; i++)
    {
        MovedPair moved(&random);
        for (int end = 0; end < 2; end++)
        {
            btScalar gap = qcGapAfter(moved.pair, moved.MotionSince(0, end), moved.MotionSince(1, end));
            ck_assert_double_le(double(gap), moved.DistanceAt(end));
            left += double(gap) > moved.pair.gap / 10;
        }
        moved.pair.isKnown = false;
        ck_assert_double_eq(double(qcGapAfter(moved.pair, moved.MotionSince(0, 0), moved.MotionSince(1, 0))), 0);
    }
    ck_assert_int_gt(left, 5000);
}
END_TEST

START_TEST(no_points_of_two_boxes_are_nearer_than_their_gap)
{
    Random random(2);
    int apart = 0;
    double largest = 0;
    for (int i = 0; i < 4000; i++)
    {
        qcPlacedBox boxes[2];
        for (qcPlacedBox& box : boxes)
        {
            btVector3 p = DrawVector(&random, 1), q = DrawVector(&random, 1);
            box = {p, p, DrawMotion(&random, 3, 3)};
            box.lower.setMin(q);
            box.upper.setMax(q);
        }
        // Parallel edges, too.
        if (i % 4 == 0)
            boxes[1].transform.setBasis(boxes[0].transform.getBasis());
        btScalar gap = qcBoxGap(boxes[0], boxes[1]);
        apart += gap > 0;
        btScalar nearest = BT_LARGE_FLOAT;
        for (int k = 0; k < 64 * 64; k++)
        {
            // Points of a grid on each box, its corners among them.
            btVector3 points[2];
            for (int side = 0; side < 2; side++)
            {
                int index = side == 0 ? k % 64 : k / 64;
                btVector3 part(btScalar(index % 4) / 3, btScalar(index / 4 % 4) / 3, btScalar(index / 16) / 3);
                const qcPlacedBox& box = boxes[side];
                points[side] = box.transform * (box.lower + (box.upper - box.lower) * part);
            }
            nearest = std::min(nearest, points[0].distance(points[1]));
        }
        ck_assert_double_le(double(gap), double(nearest));
        largest = std::max(largest, double(gap / nearest));
    }
    ck_assert_int_gt(apart, 1000);
    // It is no weak bound either.
    ck_assert_double_gt(largest, 0.99);
}
END_TEST

START_TEST(meshes_whose_boxes_are_apart_are_not_queried_until_they_come_near)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    // Long thin bars, side by side along a diagonal: their axis-aligned boxes overlap.
    btCollisionShape* shape = world.Keep(qcBoxModel(btVector3(2, btScalar(0.1), btScalar(0.1)), 2).MakeShape());
    btQuaternion turn(btVector3(0, 0, 1), SIMD_PI / 4);
    world.Add(shape, 1, btTransform(turn, btVector3(0, 0, 0)));
    btRigidBody* other = world.Add(shape, 1, btTransform(turn, btVector3(btScalar(0.6), btScalar(-0.6), 0)));
    world.Step(3);
    ck_assert_int_eq(world.world.getPairCache()->getNumOverlappingPairs(), 1);
    ck_assert_uint_eq(world.contact.getStatistics().batches, 0);
    // 0.65 between their faces, and margins.
    other->setLinearVelocity(btVector3(btScalar(-1), 1, 0));
    for (int step = 0; step < 120 && qcContactsOf(world.dispatcher).points == 0; step++)
        world.Step();
    ck_assert_uint_gt(world.contact.getStatistics().batches, 0);
    world.Step(30);
    ck_assert_double_lt(double(other->getLinearVelocity().length()), 1.2);
    btVector3 between = world.bodies[0]->getWorldTransform().getOrigin() - other->getWorldTransform().getOrigin();
    ck_assert_double_gt(double(between.dot(btVector3(-1, 1, 0).normalized())), 0.2);
}
END_TEST

/// The floor, and a cube that lies on it and never sleeps.
struct RestingCube : qcMeshWorld
{
    explicit RestingCube(btScalar x = 0)
    {
        btScalar margin = qcAddFloor(*this, qc_floorStatic);
        shape = Keep(qcCubeModel().MakeShape());
        cube = Add(shape, 1, btVector3(x, btScalar(0.5) + shape->getMargin() + margin, 0));
        cube->setActivationState(DISABLE_DEACTIVATION);
        Step(60);
    }

    btCollisionShape* shape;
    btRigidBody* cube;
};

START_TEST(a_pair_at_rest_is_not_queried_while_another_moves)
{
    RestingCube world;
    btRigidBody* other = world.Add(world.shape, 1, btVector3(3, btScalar(0.6), 0));
    other->setActivationState(DISABLE_DEACTIVATION);
    int queried = 0;
    for (int step = 0; step < 60; step++)
    {
        other->setLinearVelocity(btVector3(btScalar(0.5), other->getLinearVelocity().y(), 0));
        world.Step();
        queried += world.contact.getStatistics().pairs;
        ck_assert_int_le(world.contact.getStatistics().pairs, 1);
        // Known regions count as well.
        ck_assert_int_ge(world.contact.getStatistics().manifolds, 1);
    }
    ck_assert_int_gt(queried, 30);
    ck_assert_double_lt(double(world.cube->getLinearVelocity().length()), 1e-3);
}
END_TEST

START_TEST(bodies_that_move_as_one_are_queried_once)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btVector3 velocity(btScalar(0.1), btScalar(0.15), 0);
    for (int i = 0; i < 2; i++)
        world.Add(shape, 1, btVector3(btScalar(1.02) * btScalar(i), 0, 0))->setLinearVelocity(velocity);
    world.Step();
    ck_assert_int_eq(world.contact.getStatistics().pairs, 1);
    for (int step = 0; step < 60; step++)
    {
        world.Step();
        ck_assert_int_eq(world.contact.getStatistics().pairs, 0);
        ck_assert_int_gt(qcContactsOf(world.dispatcher).points, 0);
    }
    // One that leaves is queried.
    world.bodies[1]->setLinearVelocity(velocity + btVector3(btScalar(0.1), 0, 0));
    world.Step(2);
    ck_assert_int_eq(world.contact.getStatistics().pairs, 1);
}
END_TEST

START_TEST(a_shape_that_changes_while_its_pair_is_apart_is_queried_when_they_meet_again)
{
    RestingCube world;
    btVector3 place = world.cube->getWorldTransform().getOrigin();
    btRigidBody* other = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, place + btVector3(0, 20, 0));
    other->setGravity(btVector3(0, 0, 0));
    world.Step(2);
    // Known, then away, where the shape grows while another pair has its mesh read anew.
    btVector3 away = place + btVector3(4, 20, 0);
    world.cube->setWorldTransform(btTransform(btQuaternion::getIdentity(), away));
    other->setWorldTransform(btTransform(btQuaternion::getIdentity(), away + btVector3(btScalar(1.03), 0, 0)));
    world.Step();
    world.shape->setLocalScaling(btVector3(btScalar(1.04), btScalar(1.04), btScalar(1.04)));
    world.Step();
    world.cube->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
    world.cube->setLinearVelocity(btVector3(0, 0, 0));
    world.cube->setAngularVelocity(btVector3(0, 0, 0));
    world.Step(120);
    // It has grown into the floor, and rises.
    ck_assert_double_eq_tol(double(world.cube->getWorldTransform().getOrigin().y()), double(place.y()) + 0.02, 2e-3);
}
END_TEST

START_TEST(ends_of_a_known_point_move_with_their_meshes_and_ahead_of_contact_lie_along_the_normal)
{
    Random random(5);
    for (int run = 0; run < 1000; run++)
    {
        qcKnownPoint known = {0, 0, false, {}};
        known.point.onA = DrawVector(&random, 1);
        known.point.onB = DrawVector(&random, 1);
        known.point.normal = DrawVector(&random, 1).normalized();
        btTransform a = DrawMotion(&random, 1, 3), b = DrawMotion(&random, 1, 3);
        btVector3 onA = a * known.point.onA, onB = b * known.point.onB;
        qcMeshPoint carried = known.At(a, b);
        ck_assert_double_lt(double((carried.onA - onA).length() + (carried.onB - onB).length()), 1e-5);
        known.isAhead = true;
        qcMeshPoint aligned = known.At(a, b);
        ck_assert_double_eq_tol(double(aligned.distance), double(carried.distance), 1e-5);
        ck_assert_double_lt(double((aligned.onA - aligned.onB - aligned.distance * aligned.normal).length()), 1e-5);
        ck_assert_double_lt(double((aligned.onA + aligned.onB - onA - onB).length()), 1e-5);
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("mesh pairs", no_pair_that_stays_apart_meets_on_the_way,
             no_pair_is_nearer_than_the_gap_that_its_motion_leaves, no_points_of_two_boxes_are_nearer_than_their_gap,
             meshes_whose_boxes_are_apart_are_not_queried_until_they_come_near,
             a_pair_at_rest_is_not_queried_while_another_moves, bodies_that_move_as_one_are_queried_once,
             a_shape_that_changes_while_its_pair_is_apart_is_queried_when_they_meet_again,
             ends_of_a_known_point_move_with_their_meshes_and_ahead_of_contact_lie_along_the_normal)
