// Depths: no point is deeper than the two bodies overlap. The oracle is the bisector of two Voronoi cells: it separates
// them, so that they overlap by as much as both were pushed over it.
#include "manifold/solid_cells.h"
#include "support/suite.h"

enum
{
    qc_cellCount = 9,
    qc_splits = 5,
    qc_sunkSplits = 40
};

typedef enum Rounding
{
    qc_exact,  ///< both sides of a cut have the same corners, in double precision
    qc_local,  ///< corners in single precision, relative to the mean of the cell
    qc_placed, ///< like qc_local, with the mean in single precision too
    qc_roundings
} Rounding;

/// Margins relative to the cube's size: none, smaller than a cell's edge, and larger.
static const double s_margins[] = {0.0, 0.002, 0.05, 1.0};

enum
{
    qc_marginCount = sizeof s_margins / sizeof s_margins[0]
};

/// The cells of a cube, turned and placed at random, as bodies of a scene.
typedef struct Split
{
    qcCells cells;
    double turn[9], place[3];
    qcScene* scene;
} Split;

static void MakeTurn(qcRandom* random, double turn[9])
{
    // A rotation from a unit quaternion.
    double q[4], length2 = 0.0;
    for (int i = 0; i < 4; i++)
    {
        q[i] = qcRandom_Uniform(random, 0.1, 1.0);
        length2 += q[i] * q[i];
    }
    for (int i = 0; i < 4; i++)
        q[i] /= sqrt(length2);
    double w = q[0], x = q[1], y = q[2], z = q[3];
    const double made[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                            2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                            2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    memcpy(turn, made, sizeof made);
}

/// Moves the corners of a cell to around its mean.
static void Centre(qcSoup* soup, double mean[3])
{
    mean[0] = mean[1] = mean[2] = 0.0;
    for (uint32_t i = 0; i < 3 * soup->vertexCount; i++)
        mean[i % 3] += soup->positions[i] / soup->vertexCount;
    qcSoup_Translate(soup, -mean[0], -mean[1], -mean[2]);
}

static void AddCell(Split* split, int i, Rounding rounding, double push, qcRandom* random)
{
    qcSoup soup = qcCell_Soup(&split->cells.cell[i], random);
    double mean[3];
    Centre(&soup, mean);
    if (rounding != qc_exact)
        qcSoup_RoundToFloat(&soup);
    qcBodyDef def = qcBodyDefOf(&soup);
    memcpy(def.transform.linear, split->turn, sizeof split->turn);
    for (int axis = 0; axis < 3; axis++)
    {
        double moved = split->place[axis];
        for (int k = 0; k < 3; k++)
            moved += split->turn[3 * axis + k] * (mean[k] + push * (0.5 - split->cells.site[i][k]));
        def.transform.translation[axis] = rounding == qc_placed ? (double)(float)moved : moved;
    }
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(split->scene, &def, &id));
    qcSoup_Free(&soup);
}

/// Two cells are pushed over their bisector by `push` times the distance of their sites.
static Split MakeSplit(uint64_t seed, Rounding rounding, double push)
{
    qcRandom random = {seed};
    Split split = {.cells = qcCells_Make(seed, qc_cellCount), .scene = qcMakeScene(NULL)};
    MakeTurn(&random, split.turn);
    for (int axis = 0; axis < 3; axis++)
        split.place[axis] = qcRandom_Uniform(&random, -4.0, 4.0);
    for (int i = 0; i < qc_cellCount; i++)
        AddCell(&split, i, rounding, push, &random);
    return split;
}

static void FreeSplit(Split* split)
{
    qcScene_Destroy(split->scene);
    qcCells_Free(&split->cells);
}

static const qcResult* Detect(const Split* split, double margin)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.margin = margin;
    def.touching = def.manifolds = true;
    def.threads = 1;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(split->scene, &def, &result));
    return result;
}

/// The largest coordinate is below 6.
static double NoiseOf(Rounding rounding)
{
    return rounding == qc_exact ? 1e-12 : rounding == qc_local ? 2e-7 : 2e-6;
}

static double DeepestOf(const qcResult* result, const qcManifold* manifold)
{
    // Deepest first.
    return -result->manifoldPoints[manifold->firstPoint].distance;
}

static const qcCellFace* SharedFace(const qcCells* cells, uint32_t a, uint32_t b)
{
    for (int f = 0; f < cells->cell[a].count; f++)
        if (cells->cell[a].face[f].neighbour == (int)b)
            return &cells->cell[a].face[f];
    return NULL;
}

/// In world space, from cell b towards cell a.
static void NormalBetween(const Split* split, uint32_t a, uint32_t b, double normal[3])
{
    double local[3];
    qcCells_Bisector(&split->cells, (int)b, (int)a, local);
    for (int axis = 0; axis < 3; axis++)
        normal[axis] = qcDot3(split->turn + 3 * (size_t)axis, local);
}

//  ---- the oracle itself ---------------------------------------------------------------------------

static double VolumeOf(const qcSoup* soup)
{
    double volume = 0.0;
    for (uint32_t t = 0; t < soup->triangleCount; t++)
    {
        double c[3][3];
        qcSoup_GetTriangle(soup, t, c);
        for (int i = 0; i < 3; i++)
            volume += c[0][i] * (c[1][(i + 1) % 3] * c[2][(i + 2) % 3] - c[1][(i + 2) % 3] * c[2][(i + 1) % 3]) / 6.0;
    }
    return volume;
}

START_TEST(cells_fill_the_cube_and_lie_on_their_side_of_each_bisector)
{
    qcCells cells = qcCells_Make((uint64_t)_i, qc_cellCount);
    qcRandom random = {1};
    double volume = 0.0;
    for (int i = 0; i < cells.count; i++)
    {
        qcSoup soup = qcCell_Soup(&cells.cell[i], &random);
        volume += VolumeOf(&soup);
        for (int j = 0; j < cells.count; j++)
            for (uint32_t v = 0; v < soup.vertexCount && j != i; v++)
            {
                double normal[3], offset = qcCells_Bisector(&cells, i, j, normal);
                ck_assert_double_le(qcDot3(normal, soup.positions + 3 * (size_t)v), offset + 1e-8);
            }
        qcSoup_Free(&soup);
    }
    ck_assert_double_eq_tol(volume, 1.0, 1e-9);
    qcCells_Free(&cells);
}
END_TEST

//  ---- depths --------------------------------------------------------------------------------------

/// The overlap is measured along the bisector's normal; along an oblique one the separation distance is longer.
static void CheckDepths(const Split* split, double push, double noise, double margin)
{
    const qcResult* result = Detect(split, margin);
    for (size_t m = 0; m < result->manifoldCount; m++)
    {
        const qcManifold* manifold = &result->manifolds[m];
        double overlap = push * qcDistance3(split->cells.site[manifold->bodyA], split->cells.site[manifold->bodyB]);
        double deepest = DeepestOf(result, manifold);
        ck_assert_msg(deepest <= 3.0 * overlap + noise, "cells %u and %u, margin %g: %g deep, overlap %g",
                      manifold->bodyA, manifold->bodyB, margin, deepest, overlap);
    }
}

START_TEST(cells_that_touch_are_not_deep_in_each_other)
{
    for (Rounding rounding = qc_exact; rounding < qc_roundings; rounding++)
    {
        Split split = MakeSplit((uint64_t)_i, rounding, 0.0);
        for (int m = 0; m < qc_marginCount; m++)
            CheckDepths(&split, 0.0, NoiseOf(rounding), s_margins[m]);
        FreeSplit(&split);
    }
}
END_TEST

START_TEST(cells_pushed_into_each_other_are_as_deep_as_they_overlap)
{
    for (Rounding rounding = qc_exact; rounding < qc_roundings; rounding++)
    {
        Split split = MakeSplit((uint64_t)_i, rounding, 1e-3);
        // Without the margin the cuts are in no pair, and the rim alone determines the normals.
        for (int m = 1; m < qc_marginCount; m++)
            CheckDepths(&split, 1e-3, NoiseOf(rounding), s_margins[m]);
        FreeSplit(&split);
    }
}
END_TEST

START_TEST(cells_sunk_into_each_other_within_the_margin_are_as_deep_as_they_overlap)
{
    // A dozen of a thousand pairs of cells have a component whose orientation leads around an edge, or through a cell.
    static const struct
    {
        double push, margin;
    } cases[] = {{0.01, 0.05}, {0.01, 0.2}, {0.03, 0.2}};
    const size_t count = sizeof cases / sizeof cases[0];
    for (uint64_t seed = 0; seed < qc_sunkSplits; seed++)
        for (size_t c = 0; c < count; c++)
        {
            Split split = MakeSplit(seed, qc_exact, cases[c].push);
            CheckDepths(&split, cases[c].push, NoiseOf(qc_exact), cases[c].margin);
            FreeSplit(&split);
        }
}
END_TEST

START_TEST(cells_moved_away_from_each_other_are_not_in_each_other)
{
    Split split = MakeSplit((uint64_t)_i, qc_placed, -1e-3);
    for (int m = 0; m < qc_marginCount; m++)
        CheckDepths(&split, 0.0, 1e-9, s_margins[m]);
    FreeSplit(&split);
}
END_TEST

//  ---- points of a cut -----------------------------------------------------------------------------

/// From a corner of a cut to the nearest point of a manifold.
static double NearestPoint(const Split* split, const qcResult* result, const qcManifold* manifold,
                           const double corner[3])
{
    double nearest = INFINITY, world[3];
    for (int axis = 0; axis < 3; axis++)
        world[axis] = split->place[axis] + qcDot3(split->turn + 3 * (size_t)axis, corner);
    for (uint32_t p = 0; p < manifold->pointCount; p++)
        nearest = fmin(nearest, qcDistance3(world, result->manifoldPoints[manifold->firstPoint + p].pointA));
    return nearest;
}

/// Where corners are closer than the tolerance of merged points, one or two points may represent all.
static void CheckCuts(const Split* split, double margin)
{
    const double merged = 1.0 / 16.0;
    const qcResult* result = Detect(split, margin);
    size_t cuts = 0;
    for (size_t m = 0; m < result->manifoldCount; m++)
    {
        const qcManifold* manifold = &result->manifolds[m];
        const qcCellFace* face = SharedFace(&split->cells, manifold->bodyA, manifold->bodyB);
        double normal[3];
        if (face == NULL)
            continue;
        cuts++;
        NormalBetween(split, manifold->bodyA, manifold->bodyB, normal);
        for (uint32_t p = 0; p < manifold->pointCount; p++)
            ck_assert_double_ge(qcDot3(result->manifoldPoints[manifold->firstPoint + p].normal, normal), 1.0 - 1e-6);
        for (int c = 0; c < face->count; c++)
            ck_assert_double_le(NearestPoint(split, result, manifold, face->corner[c]), merged);
    }
    ck_assert_uint_gt(cuts, qc_cellCount);
}

START_TEST(a_cut_is_held_at_its_corners_along_its_normal)
{
    Split split = MakeSplit((uint64_t)_i, qc_exact, 0.0);
    CheckCuts(&split, 0.002);
    FreeSplit(&split);
}
END_TEST

START_TEST(a_cut_is_held_along_its_normal_as_far_as_the_margin_reaches)
{
    Split split = MakeSplit((uint64_t)_i, qc_placed, 0.0);
    CheckCuts(&split, 0.05);
    FreeSplit(&split);
}
END_TEST

//  ---- a box that stands on a corner ---------------------------------------------------------------

static void TurnAbout(int axis, double angle, double p[3])
{
    double c = cos(angle), s = sin(angle), *x = &p[(axis + 1) % 3], *y = &p[(axis + 2) % 3];
    double turned = c * *x - s * *y;
    *y = s * *x + c * *y;
    *x = turned;
}

/// A box, tilted, with its lowest corner `depth` below the floor, which is cut into tiles somewhere.
static void SinkACorner(qcRandom* random, double depth, qcSoup* box, qcSoup* floor)
{
    *box = qcMakeBox(1 + qcRandom_Below(random, 2));
    double x = qcRandom_Uniform(random, -3.0, -2.0), y = qcRandom_Uniform(random, -3.0, -2.0);
    *floor = qcMakeFloor(1 + qcRandom_Below(random, 8), x, y, 6.0);
    double angles[3] = {qcRandom_Uniform(random, -0.6, 0.6), qcRandom_Uniform(random, -0.6, 0.6),
                        qcRandom_Uniform(random, 0.0, 6.0)};
    double lowest = INFINITY;
    for (uint32_t v = 0; v < box->vertexCount; v++)
    {
        for (int axis = 0; axis < 3; axis++)
            TurnAbout(axis, angles[axis], box->positions + 3 * (size_t)v);
        lowest = fmin(lowest, box->positions[3 * (size_t)v + 2]);
    }
    qcSoup_Translate(box, 0.0, 0.0, -lowest - depth);
}

START_TEST(a_box_sunk_by_a_corner_is_as_deep_as_the_corner_at_any_margin)
{
    // With margins beyond the first, edges of the box that cross a tile's edge, far above the corner, have points too.
    static const double margins[] = {0.01, 0.02, 0.05, 0.1};
    for (uint64_t seed = 0; seed < 600; seed++)
    {
        qcRandom random = {seed};
        double depth = qcRandom_Uniform(&random, 0.001, 0.01);
        qcSoup box, floor;
        SinkACorner(&random, depth, &box, &floor);
        for (size_t m = 0; m < sizeof margins / sizeof margins[0]; m++)
        {
            qcManifoldScene scene = qcFindManifolds(&box, &floor, qc_bodyRigid, margins[m], 1);
            const qcResult* result = scene.result;
            double deepest = result->manifoldCount == 0 ? 0.0 : DeepestOf(result, &result->manifolds[0]);
            if (!(fabs(deepest - depth) <= 1e-9))
                ck_abort_msg("seed %d, margin %g: %g deep, not %g", (int)seed, margins[m], deepest, depth);
            qcManifoldScene_Free(&scene);
        }
        qcSoup_Free(&box);
        qcSoup_Free(&floor);
    }
}
END_TEST

/// Adds a triangle that is an edge.
static void AddLine(qcSoup* soup)
{
    uint32_t count = 3 * soup->triangleCount++;
    soup->indices = realloc(soup->indices, (count + 3) * sizeof *soup->indices);
    soup->indices[count] = soup->indices[count + 1] = soup->indices[0];
    soup->indices[count + 2] = soup->indices[1];
}

START_TEST(boxes_with_flush_sides_are_as_deep_as_they_overlap)
{
    // All triangles of such boxes touch or lie in one plane: none penetrates.
    static const double overlaps[] = {0.03125, 0.125, 0.25, 0.375}, margins[] = {0.01, 0.02, 0.05};
    for (uint32_t i = 0; i < 2 * 4 * 3 * 6 * 9; i++)
    {
        double overlap = overlaps[i % 4], margin = margins[i / 4 % 3], offset[3] = {0.0, 0.0, 0.0};
        uint32_t axis = i / 12 % 3;
        qcSoup a = qcMakeBox(1 + i / 72 % 3), b = qcMakeBox(1 + i / 216 % 3);
        bool tiled = a.triangleCount > 12 || b.triangleCount > 12;
        if (i / 648 == 1)
            AddLine(&a);
        offset[axis] = (i / 36 % 2 == 0 ? 1.0 : -1.0) * (1.0 - overlap);
        qcSoup_Translate(&b, offset[0], offset[1], offset[2]);
        qcManifoldScene scene = qcFindManifolds(&a, &b, qc_bodyRigid, margin, 1);
        uint32_t deep = 0;
        // Some tiles that are smaller than the overlap see another way out, but none a longer one.
        for (size_t p = 0; p < scene.result->manifoldPointCount; p++)
        {
            const qcManifoldPoint* point = &scene.result->manifoldPoints[p];
            double depth = -point->distance;
            bool isAlong = fabs(depth - overlap) <= 1e-9 && fabs(fabs(point->normal[axis]) - 1.0) <= 1e-9;
            deep += isAlong;
            if (depth > (tiled ? overlap + 1e-9 : 1e-9) && !isAlong)
                ck_abort_msg("boxes %d: %g deep along %g %g %g, not %g along axis %d", (int)i, depth, point->normal[0],
                             point->normal[1], point->normal[2], overlap, (int)axis);
        }
        ck_assert_msg(tiled || deep >= 4, "boxes %d: %d points", (int)i, (int)deep);
        qcManifoldScene_Free(&scene);
        qcSoup_Free(&a);
        qcSoup_Free(&b);
    }
}
END_TEST

int main(void)
{
    TCase* cells = qcMakeCase("manifold depth");
    tcase_add_loop_test(cells, cells_fill_the_cube_and_lie_on_their_side_of_each_bisector, 0, qc_splits);
    tcase_add_loop_test(cells, cells_that_touch_are_not_deep_in_each_other, 0, qc_splits);
    tcase_add_loop_test(cells, cells_pushed_into_each_other_are_as_deep_as_they_overlap, 0, qc_splits);
    tcase_add_test(cells, cells_sunk_into_each_other_within_the_margin_are_as_deep_as_they_overlap);
    tcase_add_loop_test(cells, cells_moved_away_from_each_other_are_not_in_each_other, 0, qc_splits);
    tcase_add_loop_test(cells, a_cut_is_held_at_its_corners_along_its_normal, 0, qc_splits);
    tcase_add_loop_test(cells, a_cut_is_held_along_its_normal_as_far_as_the_margin_reaches, 0, qc_splits);
    tcase_add_test(cells, a_box_sunk_by_a_corner_is_as_deep_as_the_corner_at_any_margin);
    tcase_add_test(cells, boxes_with_flush_sides_are_as_deep_as_they_overlap);
    return qcRunCase("manifold depth", cells);
}
