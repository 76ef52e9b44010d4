// Manifolds where the geometry is known: a box on a floor, balls, linked rings, a folded cloth, a sheet in a slit.
#include "manifold/manifold_scenes.h"
#include "support/suite.h"

//  ---- a box on a floor ----------------------------------------------------------------------------

typedef struct Resting
{
    uint32_t boxSide, floorSide;
    double gap, margin;
} Resting;

/// Four points, one at each lower corner of the box, all with the same normal and distance. A is the box or the floor.
static void CheckFourCorners(const Resting* r, bool boxFirst, bool turned, double offset)
{
    qcSoup box = qcMakeBox(r->boxSide), floor = qcMakeFloor(r->floorSide, -2.03, -1.97, 5.0);
    double up[3] = {0.0, 0.0, boxFirst ? 1.0 : -1.0}, tolerance = offset == 0.0 ? 1e-12 : 1e-7;
    qcSoup_Translate(&box, 0.0, 0.0, r->gap);
    if (turned)
    {
        qcTurnSoup(&box);
        qcTurnSoup(&floor);
        qcTurn(up);
    }
    qcSoup_Translate(&box, offset, offset, offset);
    qcSoup_Translate(&floor, offset, offset, offset);
    qcManifoldScene m = qcFindManifolds(boxFirst ? &box : &floor, boxFirst ? &floor : &box, qc_bodyRigid, r->margin, 1);
    const qcResult* result = m.result;
    ck_assert_uint_eq(result->manifoldCount, 1);
    ck_assert_uint_eq(result->manifolds[0].bodyA, 0);
    ck_assert_uint_eq(result->manifolds[0].bodyB, 1);
    ck_assert_msg(result->manifoldPointCount == 4, "box %u, floor %u, gap %g, margin %g: %zu points", r->boxSide,
                  r->floorSide, r->gap, r->margin, result->manifoldPointCount);
    for (int corner = 0; corner < 4; corner++)
    {
        double place[3] = {corner & 1, corner >> 1, boxFirst ? r->gap : 0.0};
        if (turned)
            qcTurn(place);
        for (int axis = 0; axis < 3; axis++)
            place[axis] += offset;
        ck_assert_uint_eq(qcCountPointsAt(result, place, tolerance), 1);
    }
    for (size_t i = 0; i < 4; i++)
    {
        ck_assert_double_eq_tol(result->manifoldPoints[i].distance, r->gap, tolerance);
        ck_assert_double_le(qcDistance3(result->manifoldPoints[i].normal, up), tolerance);
    }
    qcManifoldScene_Free(&m);
    qcSoup_Free(&box);
    qcSoup_Free(&floor);
}

// Coarse on fine, fine on coarse; above, on, in, and so deep that the bottom is beyond the margin.
static const Resting s_resting[] = {{1, 1, 0.01, 0.02}, {1, 7, 0.01, 0.02},  {1, 40, 0.01, 0.02},  {3, 40, 0.01, 0.02},
                                    {8, 1, 0.01, 0.02}, {5, 5, 0.01, 0.3},   {1, 7, 0.0, 0.0},     {4, 40, 0.0, 0.0},
                                    {6, 9, 0.0, 0.02},  {1, 7, -0.01, 0.02}, {1, 40, -0.01, 0.02}, {4, 40, -0.01, 0.02},
                                    {1, 7, -0.01, 0.0}, {4, 40, -0.01, 0.0}, {2, 3, -0.05, 0.02}};

enum
{
    qc_restingCount = sizeof s_resting / sizeof s_resting[0]
};

START_TEST(a_box_on_any_floor_stands_on_its_four_corners)
{
    CheckFourCorners(&s_resting[_i], true, false, 0.0);
}
END_TEST

START_TEST(a_floor_under_a_box_has_the_opposite_normals)
{
    CheckFourCorners(&s_resting[_i], false, false, 0.0);
}
END_TEST

START_TEST(a_box_on_a_tilted_floor_stands_on_its_four_corners)
{
    // Resting exactly on a floor needs coordinates without rounding.
    if (s_resting[_i].gap != 0.0)
        CheckFourCorners(&s_resting[_i], true, true, 0.0);
}
END_TEST

START_TEST(a_box_far_from_the_origin_stands_on_its_four_corners)
{
    if (s_resting[_i].gap != 0.0)
        CheckFourCorners(&s_resting[_i], true, true, 1e7);
}
END_TEST

START_TEST(a_deforming_box_touches_the_floor_at_every_vertex)
{
    qcSoup box = qcMakeBox(4), floor = qcMakeFloor(10, -0.53, -0.47, 2.0);
    qcSoup_Translate(&box, 0.0, 0.0, 0.01);
    qcManifoldScene m = qcFindManifolds(&box, &floor, qc_bodyDeforming, 0.03, 1);
    ck_assert_uint_eq(m.result->manifoldCount, 1);
    for (size_t i = 0; i < m.result->manifoldPointCount; i++)
    {
        ck_assert_double_eq_tol(m.result->manifoldPoints[i].normal[2], 1.0, 1e-12);
        ck_assert_double_eq_tol(m.result->manifoldPoints[i].distance, 0.01, 1e-12);
    }
    for (uint32_t v = 0; v < box.vertexCount; v++)
        if (box.positions[3 * v + 2] == 0.01)
            ck_assert_uint_eq(qcCountPointsAt(m.result, box.positions + 3 * v, 1e-12), 1);
    for (uint32_t v = 0; v < floor.vertexCount; v++)
    {
        double over[3] = {floor.positions[3 * v], floor.positions[3 * v + 1], 0.01};
        bool under = over[0] > 0.0 && over[0] < 1.0 && over[1] > 0.0 && over[1] < 1.0;
        ck_assert_uint_eq(qcCountPointsAt(m.result, over, 1e-12), under);
    }
    qcManifoldScene_Free(&m);
    qcSoup_Free(&box);
    qcSoup_Free(&floor);
}
END_TEST

START_TEST(a_box_in_a_corner_touches_the_floor_and_the_wall)
{
    // One body: a floor, and a wall that stands on its edge x = -0.01; they share vertices.
    qcSoup box = qcMakeBox(3), room = qcMakeEmptySoup(6, 4);
    const double positions[18] = {-0.01, -2, 0, -0.01, 3, 0, 4, -2, 0, 4, 3, 0, -0.01, -2, 5, -0.01, 3, 5};
    const uint32_t indices[12] = {0, 1, 2, 1, 3, 2, 0, 1, 4, 1, 5, 4};
    memcpy(room.positions, positions, sizeof positions);
    memcpy(room.indices, indices, sizeof indices);
    qcSoup_Translate(&box, 0.0, 0.0, 0.01);
    qcManifoldScene m = qcFindManifolds(&box, &room, qc_bodyRigid, 0.02, 1);
    size_t floorPoints = 0, wallPoints = 0;
    for (size_t i = 0; i < m.result->manifoldPointCount; i++)
    {
        const qcManifoldPoint* point = &m.result->manifoldPoints[i];
        ck_assert_double_eq_tol(point->distance, 0.01, 1e-12);
        floorPoints += fabs(point->normal[2] - 1.0) < 1e-12;
        wallPoints += fabs(point->normal[0] - 1.0) < 1e-12;
    }
    ck_assert_uint_eq(floorPoints, 4);
    ck_assert_uint_eq(wallPoints, 4);
    ck_assert_uint_eq(m.result->manifoldPointCount, 8);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&box);
    qcSoup_Free(&room);
}
END_TEST

START_TEST(tiles_beside_a_box_are_no_contact)
{
    // Six rows of tiles beside the box are within the margin of its edges.
    qcSoup box = qcMakeBox(1), floor = qcMakeFloor(60, -1.03, -0.97, 3.0);
    qcSoup_Translate(&box, 0.0, 0.0, 0.01);
    qcManifoldScene m = qcFindManifolds(&box, &floor, qc_bodyRigid, 0.3, 1);
    ck_assert_uint_eq(m.result->manifoldPointCount, 4);
    for (size_t i = 0; i < m.result->manifoldPointCount; i++)
        ck_assert_double_eq_tol(m.result->manifoldPoints[i].normal[2], 1.0, 1e-12);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&box);
    qcSoup_Free(&floor);
}
END_TEST

START_TEST(a_plate_on_the_edge_of_another_one_has_a_point)
{
    // Both in the plane y = 0: seen along the normal both are edge-on, and no edge crosses another.
    qcSoup upper = qcMakeEmptySoup(4, 2), lower = qcMakeEmptySoup(4, 2);
    const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    const double positions[12] = {0, 0, 0.01, 1, 0, 0.01, 1, 0, 1, 0, 0, 1};
    memcpy(upper.indices, indices, sizeof indices);
    memcpy(lower.indices, indices, sizeof indices);
    memcpy(upper.positions, positions, sizeof positions);
    memcpy(lower.positions, positions, sizeof positions);
    qcSoup_Translate(&lower, 0.3, 0.0, -1.0);
    qcManifoldScene m = qcFindManifolds(&upper, &lower, qc_bodyRigid, 0.02, 1);
    ck_assert_uint_eq(m.result->manifoldCount, 1);
    ck_assert_uint_ge(m.result->manifoldPointCount, 1);
    for (size_t i = 0; i < m.result->manifoldPointCount; i++)
    {
        ck_assert_double_eq_tol(m.result->manifoldPoints[i].normal[2], 1.0, 1e-12);
        ck_assert_double_eq_tol(m.result->manifoldPoints[i].distance, 0.01, 1e-12);
    }
    qcManifoldScene_Free(&m);
    qcSoup_Free(&upper);
    qcSoup_Free(&lower);
}
END_TEST

START_TEST(coincident_edges_of_one_body_are_no_contact)
{
    qcSoup box = qcMakeBox(3);
    qcManifoldScene m = qcFindManifolds(&box, NULL, qc_bodyWithItself, 0.0, 1);
    ck_assert_uint_gt(m.result->pairCount, 100); // the faces do touch along their edges
    ck_assert_uint_eq(m.result->manifoldCount, 0);
    ck_assert_uint_eq(m.result->manifoldPointCount, 0);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&box);
}
END_TEST

//  ---- round things --------------------------------------------------------------------------------

static void CheckNormals(const qcResult* result, const double direction[3], double least)
{
    for (size_t i = 0; i < result->manifoldPointCount; i++)
        ck_assert_msg(qcDot3(result->manifoldPoints[i].normal, direction) >= least,
                      "point %zu of %zu at distance %g: normal %g %g %g", i, result->manifoldPointCount,
                      result->manifoldPoints[i].distance, result->manifoldPoints[i].normal[0],
                      result->manifoldPoints[i].normal[1], result->manifoldPoints[i].normal[2]);
}

START_TEST(balls_touch_along_the_line_of_their_centres)
{
    static const double gaps[] = {0.01, 0.002, -0.005, -0.02, -0.05};
    // The last is wider than the triangles: there are hundreds of separated pairs for each that intersects.
    static const double margins[] = {0.03, 0.0, 0.12};
    const double gap = gaps[_i % 5], margin = margins[_i / 5];
    if (gap > margin)
        return;
    // A chord of the mesh lies at most this below the ball: edges of 0.08 on a radius of 1.
    const double sagitta = 0.08 * 0.08 / 8.0 * 4.0 / 3.0;
    double axis[3] = {0.3, 0.2, 1.0}, length = sqrt(qcDot3(axis, axis));
    qcSoup ball = qcSoup_MakeSphere(4, 1.0), other = qcSoup_MakeSphere(4, 1.0);
    for (int i = 0; i < 3; i++)
        axis[i] /= length;
    qcSoup_Translate(&other, (2.0 + gap) * axis[0], (2.0 + gap) * axis[1], (2.0 + gap) * axis[2]);
    qcManifoldScene m = qcFindManifolds(&ball, &other, qc_bodyRigid, margin, 1);
    double down[3] = {-axis[0], -axis[1], -axis[2]};
    ck_assert_uint_eq(m.result->manifoldCount, 1);
    // The normal of a point within the margin is off by half the angle of the lens of twice its distance.
    CheckNormals(m.result, down, 0.9);
    double deepest = m.result->manifoldPoints[0].distance;
    ck_assert_double_ge(deepest, gap - 1e-9);
    // The result has pairs that intersect or are within the margin, below and above.
    if (margin > -gap)
        ck_assert_double_le(deepest, gap + 2.0 * sagitta);
    else
        ck_assert_double_lt(deepest, -margin);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&ball);
    qcSoup_Free(&other);
}
END_TEST

START_TEST(linked_rings_push_each_other_back_into_the_link)
{
    // Each ring's tube lies in the other's hole: by their centres A is to the left of B, at the contact to the right.
    static const double gaps[] = {0.02, 0.002, -0.005, -0.01, -0.02};
    qcSoup ring = qcMakeTorus(64, 24, 0.25), other = qcMakeTorus(60, 26, 0.25);
    for (uint32_t v = 0; v < other.vertexCount; v++)
    {
        double *p = other.positions + 3 * (size_t)v, y = p[1];
        p[1] = p[2];
        p[2] = y;
    }
    qcSoup_Translate(&other, 1.5 - gaps[_i], 0.0, 0.0);
    const double right[3] = {1.0, 0.0, 0.0};
    qcManifoldScene m = qcFindManifolds(&ring, &other, qc_bodyRigid, 0.03, 1);
    ck_assert_uint_eq(m.result->manifoldCount, 1);
    CheckNormals(m.result, right, 0.6);
    ck_assert_double_eq_tol(m.result->manifoldPoints[0].distance, gaps[_i], 0.003);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&ring);
    qcSoup_Free(&other);
}
END_TEST

START_TEST(a_ring_sunk_into_the_floor_of_a_deep_bin_is_pushed_back_in)
{
    // The centre of the bin is above the ring: the centres alone would push the ring down.
    static const double depths[] = {0.02, 0.05, 0.1, 0.15, 0.2};
    const double depth = depths[_i];
    qcRandom random = {7};
    qcSoup bin = qcMakeBox(4);
    bin.triangleCount -= bin.triangleCount / 6; // the lid
    qcScaleSoup(&bin, 4.5, 4.5, 10.0);
    for (int k = 0; k < 20; k++)
    {
        qcSoup ring = qcMakeTorus(16, 8, 0.375);
        double tiltX = qcRandom_Uniform(&random, -0.1, 0.1), tiltY = qcRandom_Uniform(&random, -0.1, 0.1);
        double lowest = INFINITY;
        for (uint32_t v = 0; v < ring.vertexCount; v++)
        {
            double* p = ring.positions + 3 * (size_t)v;
            p[2] += tiltX * p[0] + tiltY * p[1];
            lowest = fmin(lowest, p[2]);
        }
        qcSoup_Translate(&ring, 2.25, 2.25, -lowest - depth);
        qcManifoldScene m = qcFindManifolds(&bin, &ring, qc_bodyRigid, 0.065, 1);
        ck_assert_uint_ge(m.result->manifoldCount, 1);
        const qcManifoldPoint* deepest = &m.result->manifoldPoints[0];
        for (size_t i = 1; i < m.result->manifoldPointCount; i++)
            if (m.result->manifoldPoints[i].distance < deepest->distance)
                deepest = &m.result->manifoldPoints[i];
        ck_assert_double_lt(deepest->normal[2], -0.9); // towards the bin
        ck_assert_double_eq_tol(deepest->distance, -depth, 0.25 * depth);
        qcManifoldScene_Free(&m);
        qcSoup_Free(&ring);
    }
    qcSoup_Free(&bin);
}
END_TEST

START_TEST(a_ball_in_a_socket_is_pushed_inwards_from_all_sides)
{
    // Radii 1 and 1.05 around one centre: 0.05 of air everywhere, and all of it within the margin.
    qcSoup ball = qcSoup_MakeSphere(3, 1.0), socket = qcSoup_MakeSphere(3, 1.05);
    qcTurnSoup(&ball);
    qcManifoldScene m = qcFindManifolds(&ball, &socket, qc_bodyRigid, 0.1, 1);
    ck_assert_uint_eq(m.result->manifoldCount, 1);
    ck_assert_uint_gt(m.result->manifoldPointCount, 1000);
    for (size_t i = 0; i < m.result->manifoldPointCount; i++)
    {
        const qcManifoldPoint* point = &m.result->manifoldPoints[i];
        double inwards[3] = {-point->pointA[0], -point->pointA[1], -point->pointA[2]};
        ck_assert_double_gt(qcDot3(point->normal, inwards), 0.9 * sqrt(qcDot3(inwards, inwards)));
        ck_assert_double_gt(point->distance, 0.03);
    }
    qcManifoldScene_Free(&m);
    qcSoup_Free(&ball);
    qcSoup_Free(&socket);
}
END_TEST

START_TEST(a_fan_of_any_size_is_one_contact)
{
    // A flat cone whose tip reaches through a floor of two triangles: each intersects hundreds that share the tip.
    static const uint32_t sizes[] = {7, 17, 40, 400};
    const uint32_t size = sizes[_i];
    const double turn = 2.0 * 3.14159265358979323846, deep = 0.01;
    qcSoup cone = qcMakeEmptySoup(size + 1, size), floor = qcMakeFloor(1, -2.0, -2.0, 4.0);
    memset(cone.positions, 0, 3 * sizeof(double));
    cone.positions[2] = -deep;
    for (uint32_t i = 0; i < size; i++)
    {
        const double rim[3] = {cos(turn * i / size), sin(turn * i / size), 0.05};
        const uint32_t triangle[3] = {0, i + 1, (i + 1) % size + 1};
        memcpy(cone.positions + 3 * (size_t)(i + 1), rim, sizeof rim);
        memcpy(cone.indices + 3 * (size_t)i, triangle, sizeof triangle);
    }
    qcShuffle(&cone, 7);
    qcManifoldScene m = qcFindManifolds(&cone, &floor, qc_bodyRigid, 0.1, 1);
    ck_assert_uint_ge(m.result->pairCount, size);
    ck_assert_uint_eq(m.result->manifoldCount, 1);
    const double up[3] = {0.0, 0.0, 1.0};
    CheckNormals(m.result, up, 0.99);
    ck_assert_double_eq_tol(m.result->manifoldPoints[0].distance, -deep, 1e-4);
    ck_assert_uint_eq(qcCountPointsAt(m.result, cone.positions, 1e-12), 1);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&cone);
    qcSoup_Free(&floor);
}
END_TEST

//  ---- sheets --------------------------------------------------------------------------------------

START_TEST(a_sheet_in_a_slit_is_held_from_both_sides)
{
    // One body of two parallel walls with a floor between them: their normals at the sheet are opposite, and right.
    qcSoup slit = qcMakeEmptySoup(8, 6), sheet = qcMakeFloor(2, 0.1, 0.1, 0.8);
    const double positions[24] = {0, 0, -0.01, 1, 0, -0.01, 1, 1, -0.01, 0, 1, -0.01,
                                  0, 0, 0.01,  1, 0, 0.01,  1, 1, 0.01,  0, 1, 0.01};
    const uint32_t indices[18] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4};
    memcpy(slit.positions, positions, sizeof positions);
    memcpy(slit.indices, indices, sizeof indices);
    qcManifoldScene m = qcFindManifolds(&sheet, &slit, qc_bodyRigid, 0.02, 1);
    size_t below = 0, above = 0;
    for (size_t i = 0; i < m.result->manifoldPointCount; i++)
    {
        const qcManifoldPoint* point = &m.result->manifoldPoints[i];
        ck_assert_double_eq_tol(point->distance, 0.01, 1e-12);
        below += point->normal[2] == 1.0;
        above += point->normal[2] == -1.0;
    }
    ck_assert_uint_eq(below, 4);
    ck_assert_uint_eq(above, 4);
    ck_assert_uint_eq(m.result->manifoldPointCount, 8);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&slit);
    qcSoup_Free(&sheet);
}
END_TEST

/// Unit cubes above and below z = 0 at the given gaps, as one body.
static qcSoup MakeTwoBoxes(double gapAbove, double gapBelow)
{
    qcSoup box = qcMakeBox(2), two = qcMakeEmptySoup(2 * box.vertexCount, 2 * box.triangleCount);
    for (uint32_t v = 0; v < two.vertexCount; v++)
    {
        bool above = v < box.vertexCount;
        memcpy(two.positions + 3 * (size_t)v, box.positions + 3 * (size_t)(v % box.vertexCount), 3 * sizeof(double));
        two.positions[3 * (size_t)v + 2] += above ? gapAbove : -1.0 - gapBelow;
    }
    for (uint32_t i = 0; i < 3 * two.triangleCount; i++)
        two.indices[i] = box.indices[i % (3 * box.triangleCount)] + (i < 3 * box.triangleCount ? 0 : box.vertexCount);
    qcSoup_Free(&box);
    return two;
}

START_TEST(a_sheet_between_two_boxes_of_one_body_has_the_corners_of_each)
{
    // Each triangle of the sheet is in both regions, with opposite normals. A plane separates each region.
    qcSoup two = MakeTwoBoxes(0.004, 0.006), sheet = qcMakeFloor(_i == 0 ? 1 : 7, -2.03, -1.97, 5.0);
    qcManifoldScene m = qcFindManifolds(&two, &sheet, qc_bodyRigid, 0.02, 1);
    ck_assert_uint_eq(m.result->manifoldCount, 2);
    for (int box = 0; box < 2; box++)
    {
        const qcManifold* manifold = &m.result->manifolds[box];
        ck_assert_uint_eq(manifold->pointCount, 4);
        for (uint32_t i = 0; i < 4; i++)
        {
            const qcManifoldPoint* point = &m.result->manifoldPoints[manifold->firstPoint + i];
            ck_assert_double_eq(point->normal[2], box == 0 ? 1.0 : -1.0);
            ck_assert_double_eq_tol(point->distance, box == 0 ? 0.004 : 0.006, 1e-12);
        }
    }
    qcManifoldScene_Free(&m);
    qcSoup_Free(&two);
    qcSoup_Free(&sheet);
}
END_TEST

START_TEST(a_sheet_that_touches_the_bottom_of_a_groove_is_held_from_both_sides)
{
    // Two walls of tiles that meet at x = 0 at an angle of 20 degrees, and a sheet between them down to the bottom.
    // Touching pairs there could be separated either way; the separated pairs further up decide.
    const uint32_t side = 10;
    const double slope = 0.176;
    qcSoup sheet = qcMakeFloor(side, 0.0, 0.0, 1.0), groove = qcMakeFloor(2 * side, -1.0, 0.0, 2.0);
    qcScaleSoup(&groove, 1.0, 0.5, 1.0);
    for (uint32_t v = 0; v < groove.vertexCount; v++)
    {
        double* p = groove.positions + 3 * (size_t)v;
        p[2] = slope * p[0];
        p[0] = fabs(p[0]);
    }
    qcManifoldScene m = qcFindManifolds(&sheet, &groove, qc_bodyRigid, 0.08, 1);
    size_t below = 0, above = 0;
    for (size_t i = 0; i < m.result->manifoldPointCount; i++)
    {
        const qcManifoldPoint* point = &m.result->manifoldPoints[i];
        if (point->pointA[0] < 0.11)
            continue; // at the touching row
        ck_assert_double_gt(point->distance, 0.01);
        ck_assert_double_gt(point->normal[2] * (point->pointA[2] - point->pointB[2]), 0.0);
        below += point->normal[2] > 0.9;
        above += point->normal[2] < -0.9;
    }
    ck_assert_uint_gt(below, 3);
    ck_assert_uint_gt(above, 3);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&sheet);
    qcSoup_Free(&groove);
}
END_TEST

/// The layer of a triangle of the folded cloth, by its vertices' places along the fold.
static int LayerOf(const qcSoup* cloth, uint32_t triangle, uint32_t side)
{
    double along = 0.0;
    for (int c = 0; c < 3; c++)
        along += cloth->indices[3 * (size_t)triangle + (unsigned)c] % (side + 1);
    return (int)(along / side);
}

/// Checks that A is above B in all points of a manifold, or below in all, and that normals agree.
static void CheckLayers(const qcSoup* cloth, uint32_t side, const qcResult* result, double least)
{
    size_t pointsBetween[4] = {0, 0, 0, 0};
    for (size_t i = 0; i < result->manifoldCount; i++)
    {
        const qcManifold* manifold = &result->manifolds[i];
        const qcManifoldPoint* points = result->manifoldPoints + manifold->firstPoint;
        bool isAbove = LayerOf(cloth, points[0].triangleA, side) > LayerOf(cloth, points[0].triangleB, side);
        const double up[3] = {0.0, 0.0, isAbove ? 1.0 : -1.0};
        for (uint32_t p = 0; p < manifold->pointCount; p++)
        {
            int a = LayerOf(cloth, points[p].triangleA, side), b = LayerOf(cloth, points[p].triangleB, side);
            ck_assert_int_ne(a, b);
            ck_assert_int_eq(a > b, isAbove);
            ck_assert_double_ge(qcDot3(points[p].normal, up), least);
            pointsBetween[a + b]++;
        }
    }
    ck_assert_uint_gt(pointsBetween[1], 500); // the lower two
    ck_assert_uint_gt(pointsBetween[3], 500); // the upper two
}

START_TEST(layers_of_a_folded_cloth_have_one_orientation)
{
    // For any numbering and winding of the triangles. The layers are separated, or cross each other in many places.
    const uint32_t side = 60;
    qcSoup cloth = qcSoup_MakeFoldedCloth(3, side, 0.004, _i % 2 == 0 ? 0.0004 : 0.003);
    if (_i >= 2)
    {
        qcShuffle(&cloth, 5);
        qcFlipSome(&cloth, 6);
    }
    qcManifoldScene m = qcFindManifolds(&cloth, NULL, qc_bodyWithItself, 0.006, 1);
    size_t penetrating = 0;
    for (size_t i = 0; i < m.result->pairCount; i++)
        penetrating += m.result->pairs[i].relation == qc_relationPenetrating;
    ck_assert(_i % 2 == 0 || penetrating > 100);
    CheckLayers(&cloth, side, m.result, _i % 2 == 0 ? 0.95 : -0.1);
    qcManifoldScene_Free(&m);
    qcSoup_Free(&cloth);
}
END_TEST

#define LOOP(test, count) tcase_add_loop_test(testCase, test, 0, count)

int main(void)
{
    TCase* testCase = qcMakeCase("manifolds");
    LOOP(a_box_on_any_floor_stands_on_its_four_corners, qc_restingCount);
    LOOP(a_floor_under_a_box_has_the_opposite_normals, qc_restingCount);
    LOOP(a_box_on_a_tilted_floor_stands_on_its_four_corners, qc_restingCount);
    LOOP(a_box_far_from_the_origin_stands_on_its_four_corners, qc_restingCount);
    tcase_add_test(testCase, a_deforming_box_touches_the_floor_at_every_vertex);
    tcase_add_test(testCase, a_box_in_a_corner_touches_the_floor_and_the_wall);
    tcase_add_test(testCase, tiles_beside_a_box_are_no_contact);
    tcase_add_test(testCase, a_plate_on_the_edge_of_another_one_has_a_point);
    tcase_add_test(testCase, coincident_edges_of_one_body_are_no_contact);
    LOOP(balls_touch_along_the_line_of_their_centres, 15);
    LOOP(linked_rings_push_each_other_back_into_the_link, 5);
    LOOP(a_ring_sunk_into_the_floor_of_a_deep_bin_is_pushed_back_in, 5);
    tcase_add_test(testCase, a_ball_in_a_socket_is_pushed_inwards_from_all_sides);
    LOOP(a_fan_of_any_size_is_one_contact, 4);
    tcase_add_test(testCase, a_sheet_in_a_slit_is_held_from_both_sides);
    LOOP(a_sheet_between_two_boxes_of_one_body_has_the_corners_of_each, 2);
    tcase_add_test(testCase, a_sheet_that_touches_the_bottom_of_a_groove_is_held_from_both_sides);
    LOOP(layers_of_a_folded_cloth_have_one_orientation, 4);
    return qcRunCase("manifolds", testCase);
}
