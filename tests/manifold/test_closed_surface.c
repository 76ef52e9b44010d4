// Which surfaces are closed, and on which side of their triangles is their outside.
#include "manifold/manifold_scenes.h"
#include "scene/closed_surface.h"
#include "support/suite.h"

/// Reverses triangles first..end - 1.
static void Reverse(qcSoup* soup, uint32_t first, uint32_t end)
{
    for (uint32_t t = first; t < end; t++)
    {
        uint32_t* corner = soup->indices + 3 * (size_t)t;
        uint32_t second = corner[1];
        corner[1] = corner[2];
        corner[2] = second;
    }
}

/// The unit cube with normals that point outwards.
static qcSoup MakeCube(uint32_t side)
{
    qcSoup cube = qcMakeBox(side);
    uint32_t face = cube.triangleCount / 6;
    for (uint32_t f = 0; f < 6; f += 2)
        Reverse(&cube, f * face, (f + 1) * face);
    return cube;
}

/// Adds another soup, moved.
static void Append(qcSoup* soup, const qcSoup* other, const double by[3])
{
    qcSoup both = qcMakeEmptySoup(soup->vertexCount + other->vertexCount, soup->triangleCount + other->triangleCount);
    memcpy(both.positions, soup->positions, 3 * sizeof(double) * soup->vertexCount);
    memcpy(both.indices, soup->indices, 3 * sizeof(uint32_t) * soup->triangleCount);
    for (uint32_t i = 0; i < 3 * other->vertexCount; i++)
        both.positions[3 * soup->vertexCount + i] = other->positions[i] + by[i % 3];
    for (uint32_t i = 0; i < 3 * other->triangleCount; i++)
        both.indices[3 * soup->triangleCount + i] = other->indices[i] + soup->vertexCount;
    qcSoup_Free(soup);
    *soup = both;
}

static int SideOf(const qcSoup* soup, bool deforming, const qcTransform* transform)
{
    qcBodies bodies = {0};
    qcBodyDef def = qcBodyDefOf(soup);
    qcBodyId id;
    def.deforming = deforming;
    if (transform != NULL)
        def.transform = *transform;
    CHECK_OK(qcBodies_Add(&bodies, &def, &id));
    qcBody* body = &QC_AT(qcBody, bodies.slots, id.slot);
    int side = qcBody_FindOuterSide(body);
    ck_assert_int_eq(qcBody_FindOuterSide(body), side);
    qcBodies_Free(&bodies);
    return side;
}

static void CheckSide(const qcSoup* soup, int side)
{
    ck_assert_int_eq(SideOf(soup, false, NULL), side);
}

START_TEST(the_outer_side_of_a_closed_surface_follows_its_windings)
{
    const double scales[] = {1.0, 1e-60, 1e60};
    for (int i = 0; i < 3; i++)
    {
        qcSoup soups[] = {MakeCube(2), qcMakeTorus(12, 5, 0.3)};
        for (int s = 0; s < 2; s++)
        {
            qcSoup* soup = &soups[s];
            qcTurnSoup(soup);
            qcSoup_Translate(soup, 10.0, -20.0, 30.0);
            qcScaleSoup(soup, scales[i], scales[i], scales[i]);
            qcShuffle(soup, 1);
            CheckSide(soup, 1);
            if (s == 1)
                qcUnshare(soup);
            CheckSide(soup, 1);
            Reverse(soup, 0, soup->triangleCount);
            CheckSide(soup, 0); // a room
            qcSoup_Free(soup);
        }
    }
}
END_TEST

START_TEST(a_mirrored_body_has_its_outer_side_where_it_was)
{
    qcSoup cube = MakeCube(1);
    qcTransform transform = qcIdentityTransform();
    transform.linear[4] = -2.0; // mirrored normals (b - a) x (c - a) point inwards
    ck_assert_int_eq(SideOf(&cube, false, &transform), -1);
    transform.linear[0] = -0.5;
    ck_assert_int_eq(SideOf(&cube, false, &transform), 1);
    qcSoup_Free(&cube);
}
END_TEST

START_TEST(surfaces_that_are_not_closed_have_no_outer_side)
{
    qcSoup cube = MakeCube(2);
    ck_assert_int_eq(SideOf(&cube, true, NULL), 0); // it deforms
    cube.triangleCount--;
    CheckSide(&cube, 0);
    cube.triangleCount++;
    Reverse(&cube, 3, 4);
    CheckSide(&cube, 0);
    Reverse(&cube, 3, 4);
    CheckSide(&cube, 1);
    cube.positions[0] -= 1e-9; // a crack
    CheckSide(&cube, 0);
    qcSoup_Free(&cube);
    qcSoup none = {0};
    CheckSide(&none, 0);
}
END_TEST

START_TEST(a_sheet_of_two_sides_has_no_outer_side)
{
    const double nowhere[3] = {0.0, 0.0, 0.0};
    qcSoup front = qcMakeRoughFloor(1, 8, 3.0, 0.5), back = qcMakeRoughFloor(1, 8, 3.0, 0.5);
    Reverse(&back, 0, back.triangleCount);
    Append(&front, &back, nowhere);
    CheckSide(&front, 0);
    qcSoup_Free(&front);
    qcSoup_Free(&back);
}
END_TEST

START_TEST(cubes_that_share_an_edge_have_an_outer_side)
{
    // The edge has four triangles.
    const double beside[3] = {1.0, 1.0, 0.0};
    qcSoup two = MakeCube(1), cube = MakeCube(1);
    Append(&two, &cube, beside);
    CheckSide(&two, 1);
    qcSoup_Free(&two);
    qcSoup_Free(&cube);
}
END_TEST

int main(void)
{
    TCase* sides = qcMakeCase("closed surface");
    tcase_add_test(sides, the_outer_side_of_a_closed_surface_follows_its_windings);
    tcase_add_test(sides, a_mirrored_body_has_its_outer_side_where_it_was);
    tcase_add_test(sides, surfaces_that_are_not_closed_have_no_outer_side);
    tcase_add_test(sides, a_sheet_of_two_sides_has_no_outer_side);
    tcase_add_test(sides, cubes_that_share_an_edge_have_an_outer_side);
    return qcRunCase("closed surface", sides);
}
