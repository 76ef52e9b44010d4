// BVHs that are limited to the region where others may come: each step has the pairs of brute force, while bodies
// deform in their places, drift, jump, and come and go; and the cells of a region, against boxes in doubles.
#include "scene/float_positions.h"
#include "support/scenes.h"
#include "support/suite.h"
#include "sweep/bvh/bvh_region.h"
#include "sweep/failing_steps.h"
#include "sweep/sample_bodies.h"

#include <math.h>

enum
{
    qc_sheetSide = 24, ///< 1152 triangles
    qc_sheetCount = 4
};

//  ---- scenes --------------------------------------------------------------------------------------

/// A row of upright crumpled sheets, each of which meets the next one in a strip. Each begins with another triangle:
/// copies would be put in order as a whole.
typedef struct Row
{
    qcScene* scene;
    qcBodyId ids[qc_sheetCount];
    qcSoup sheets[qc_sheetCount];
    bool asFloats;
} Row;

static void SetSheet(const Row* row, uint32_t i, const qcSoup* soup)
{
    float* floats = malloc((size_t)soup->vertexCount * 3 * sizeof(float));
    for (size_t k = 0; k < 3 * (size_t)soup->vertexCount; k++)
        floats[k] = (float)soup->positions[k];
    CHECK_OK(row->asFloats ? qcScene_SetVertices(row->scene, row->ids[i], floats, qc_positionF32, 0)
                           : qcScene_SetVertices(row->scene, row->ids[i], soup->positions, qc_positionF64, 0));
    free(floats);
}

static Row MakeRow(bool asFloats)
{
    Row row = {.scene = qcMakeScene(NULL), .asFloats = asFloats};
    for (uint32_t i = 0; i < qc_sheetCount; i++)
    {
        row.sheets[i] = qcSoup_MakeFoldedCloth(1 + i, qc_sheetSide, 0.02, 0.05);
        double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (size_t k = 0; k < 3 * (size_t)row.sheets[i].vertexCount; k++)
        {
            lower[k % 3] = fmin(lower[k % 3], row.sheets[i].positions[k]);
            upper[k % 3] = fmax(upper[k % 3], row.sheets[i].positions[k]);
        }
        qcSoup_RotateTriangles(&row.sheets[i], i);
        qcSoup_Translate(&row.sheets[i], i * 0.8 * (upper[0] - lower[0]), 0.0, 0.0);
        qcBodyDef def = qcBodyDefOf(&row.sheets[i]);
        def.deforming = true;
        def.selfCollision = false;
        CHECK_OK(qcScene_AddBody(row.scene, &def, &row.ids[i]));
    }
    return row;
}

static void FreeSheets(Row* row)
{
    for (uint32_t i = 0; i < qc_sheetCount; i++)
        qcSoup_Free(&row->sheets[i]);
}

static void FreeRow(Row* row)
{
    qcScene_Destroy(row->scene);
    FreeSheets(row);
}

/// Each vertex moves by up to `amount` from its place, all by the same offset along the row besides.
static void MoveSheet(const Row* row, uint32_t i, qcRandom* random, double amount, double offset)
{
    qcSoup moved = qcSoup_MakeFoldedCloth(1 + i, qc_sheetSide, 0.02, 0.05);
    for (size_t k = 0; k < 3 * (size_t)moved.vertexCount; k++)
        moved.positions[k] =
            row->sheets[i].positions[k] + qcRandom_Uniform(random, -amount, amount) + (k % 3 == 0 ? offset : 0.0);
    SetSheet(row, i, &moved);
    qcSoup_Free(&moved);
}

/// Checks the pairs of a step. Returns how many triangles were refitted.
static uint64_t CheckStep(const Row* row, qcDetectDef def, uint32_t threads)
{
    def.threads = threads;
    def.method = qc_methodBrute;
    qcPairList expected = qcDetectPairs(row->scene, &def);
    const qcResult* result;
    def.method = qc_methodSweep;
    CHECK_OK(qcScene_Detect(row->scene, &def, &result));
    qcPairList found = qcListOf(result);
    qcCheckSamePairs(&expected, &found, "sweep");
    free(expected.pairs);
    return result->profile.fittedTriangles;
}

static const uint64_t s_allTriangles = (uint64_t)qc_sheetCount * 2 * qc_sheetSide * qc_sheetSide;

START_TEST(sheets_that_deform_in_their_places_keep_their_limited_bvhs)
{
    for (int way = 0; way < 4; way++)
    {
        qcRandom random = {5};
        Row row = MakeRow(way % 2 == 0);
        qcDetectDef def = qcDefaultDetectDef();
        def.margin = way / 2 == 0 ? 0.0 : 0.01;
        for (int step = 0; step < 12; step++)
        {
            for (uint32_t i = 0; i < qc_sheetCount; i++)
                MoveSheet(&row, i, &random, 0.003, 0.0);
            uint64_t fitted = CheckStep(&row, def, 1 + (uint32_t)step % 3);
            ck_assert_uint_gt(fitted, 0);
            ck_assert_uint_lt(fitted, s_allTriangles * 9 / 10);
        }
        FreeRow(&row);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(sheets_that_drift_and_jump_miss_no_pair)
{
    uint64_t limited = 0, grown = 0, first = 0;
    for (uint64_t seed = 0; seed < 12; seed++)
    {
        qcRandom random = {seed};
        Row row = MakeRow(seed % 2 == 0);
        for (int step = 0; step < 14; step++)
        {
            // Towards the others: the first sheet, the last one, or one between them.
            double drift = qcRandom_Below(&random, 4) == 0 ? 0.4 : 0.02 * step;
            bool isUp = seed % 4 < 2;
            uint32_t drifting = seed % 6 > 3 ? 1 : isUp ? 0 : qc_sheetCount - 1;
            for (uint32_t i = 0; i < qc_sheetCount; i++)
                MoveSheet(&row, i, &random, 0.01, i == drifting ? (isUp ? drift : -drift) : 0.0);
            uint64_t fitted = CheckStep(&row, qcDefaultDetectDef(), 1 + (uint32_t)step % 2);
            first = step == 0 ? fitted : first;
            limited += fitted <= first;
            grown += fitted > first;
        }
        FreeRow(&row);
    }
    ck_assert_uint_gt(limited, 20);
    ck_assert_uint_gt(grown, 20);
}
END_TEST

START_TEST(a_larger_distance_a_new_body_and_a_motion_have_all_pairs)
{
    for (int change = 0; change < 3; change++)
    {
        Row row = MakeRow(true);
        qcRandom random = {1};
        qcDetectDef def = qcDefaultDetectDef();
        uint64_t first = CheckStep(&row, def, 1);
        CHECK_OK(qcScene_MarkStart(row.scene));
        for (uint32_t i = 0; i < qc_sheetCount; i++)
            MoveSheet(&row, i, &random, 0.001, 0.0);
        def.margin = change == 0 ? 0.3 : 0.0;
        def.motion = change == 2;
        if (change == 1)
            (void)qcAddSoup(row.scene, &row.sheets[1]);
        ck_assert_uint_gt(CheckStep(&row, def, 2), first);
        FreeRow(&row);
    }
}
END_TEST

static qcScene* MakeRowOfFloats(void)
{
    Row row = MakeRow(true);
    FreeSheets(&row);
    return row.scene;
}

static uint64_t CheckScene(qcScene* scene, uint32_t threads)
{
    return CheckStep(&(Row){.scene = scene}, qcDefaultDetectDef(), threads);
}

START_TEST(after_a_failed_allocation_the_same_step_has_all_pairs)
{
    qcFailEachAllocation(MakeRowOfFloats, CheckScene);
}
END_TEST

//  ---- displacement --------------------------------------------------------------------------------

/// New positions, kept as floats or as doubles.
static void SetVertices(qcBodies* bodies, uint32_t slot, const qcSoup* soup, bool asFloats)
{
    float* floats = malloc((size_t)soup->vertexCount * 3 * sizeof(float));
    for (size_t k = 0; k < 3 * (size_t)soup->vertexCount; k++)
        floats[k] = (float)soup->positions[k];
    if (!asFloats)
        CHECK_OK(qcBodies_SetVertices(bodies, slot, soup->positions, qc_positionF64, 0));
    for (int i = 0; i < 2 && asFloats; i++)
    {
        CHECK_OK(qcBodies_SetVertices(bodies, slot, floats, qc_positionF32, 0));
        CHECK_OK(qcFloatPositions_Keep(&QC_AT(qcBody, bodies->slots, slot)));
    }
    ck_assert(qcBody_IsInFloats(&QC_AT(qcBody, bodies->slots, slot)) == asFloats);
    free(floats);
}

START_TEST(the_displacement_is_the_greatest_change_of_any_coordinate)
{
    // Coordinates are left over by vectors: they are no multiple of 16.
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 20, 0.02, 0.03);
    qcRandom random = {3};
    for (size_t k = 0; k < 3 * (size_t)soup.vertexCount; k++)
        soup.positions[k] = (double)(float)soup.positions[k];
    qcBodies bodies = {0};
    uint32_t slot = qcAddToBodies(&bodies, &soup);
    const qcBody* body = qcBodyAt(&bodies, slot);
    qcBvhRegion region;
    ck_assert(qcBvhRegion_Begin(&region, body));
    CHECK_OK(qcBvhRegion_SetReference(&region, body));
    for (int i = 0; i < 400; i++)
    {
        // A large change of one coordinate, the last ones among them, and smaller ones of the others.
        size_t at =
            i < 40 ? 3 * (size_t)soup.vertexCount - 1 - (size_t)i / 2 : qcRandom_Below(&random, 3 * soup.vertexCount);
        double change = i % 2 == 0 ? 0.25 : -0.25;
        qcSoup moved = qcSoup_MakeFoldedCloth(3, 20, 0.02, 0.03);
        for (size_t k = 0; k < 3 * (size_t)soup.vertexCount; k++)
            moved.positions[k] = soup.positions[k] + (k == at ? change : qcRandom_Uniform(&random, -0.2, 0.2));
        SetVertices(&bodies, slot, &moved, i % 4 < 2);
        qcBvhRegion_Follow(&region, qcBodyAt(&bodies, slot));
        ck_assert_double_ge(region.displacement + region.rounding, 0.25);
        ck_assert_double_lt(region.displacement, 0.25 + 1e-6);
        qcSoup_Free(&moved);
    }
    qcArray_Free(&region.reference);
    qcBodies_Free(&bodies);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(distance_displacement_and_rounding_reach_together)
{
    // Cells of 1. Any two of three lengths of 0.55 stay within the next cell, all three leave it.
    const double lower[3] = {0.0, 0.0, 0.0}, upper[3] = {qc_cellsAlong, qc_cellsAlong, qc_cellsAlong};
    const qcBody other = {.lower = {5.5, 5.5, 5.5}, .upper = {5.5, 5.5, 5.5}};
    for (int without = 0; without < 4; without++)
    {
        qcBvhRegion region = {.displacement = without == 1 ? 0.0 : 0.55, .rounding = without == 2 ? 0.0 : 0.55};
        ck_assert(qcRegionCells_Begin(&region.cells, lower, upper));
        qcBvhRegion_Include(&region, &other, 0.2);
        ck_assert_int_eq(qcBvhRegion_Covers(&region, &other, without == 3 ? 0.0 : 0.55), without != 0);
    }
}
END_TEST

//  ---- cells ---------------------------------------------------------------------------------------

static bool Overlap(const double lowerA[3], const double upperA[3], const double lowerB[3], const double upperB[3],
                    double reach)
{
    for (int axis = 0; axis < 3; axis++)
        if (lowerA[axis] > upperB[axis] + reach || lowerB[axis] > upperA[axis] + reach)
            return false;
    return true;
}

static void MakeBox(qcRandom* random, double size, double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = qcRandom_Uniform(random, -1.5, 1.5);
        upper[axis] = lower[axis] + qcRandom_Uniform(random, 0.0, size);
        // On the borders of cells, too.
        if (qcRandom_Below(random, 2) == 0)
            lower[axis] = floor(lower[axis] * 8.0) / 8.0;
        upper[axis] = fmax(upper[axis], lower[axis]);
    }
}

START_TEST(a_box_near_a_covered_one_meets_a_marked_cell)
{
    qcRandom random = {7};
    int overlaps = 0, apart = 0;
    for (int i = 0; i < 200000; i++)
    {
        qcRegionCells cells;
        const double lower[3] = {-1.0, -0.75, -0.5}, upper[3] = {1.0, 0.75, 0.25};
        double at[2][3], other[2][3];
        ck_assert(qcRegionCells_Begin(&cells, lower, upper));
        for (int k = 0; k < 3; k++)
        {
            MakeBox(&random, 0.4, other[0], other[1]);
            qcRegionCells_Mark(&cells, other[0], other[1], 0.1);
        }
        double reach = qcRandom_Uniform(&random, 0.0, 0.2);
        MakeBox(&random, qcRandom_Below(&random, 4) == 0 ? 1.0 : 0.1, at[0], at[1]);
        qcFourFloats corners[2] = {{0.0f}, {0.0f}};
        for (int k = 0; k < 6; k++)
            corners[k / 3][k % 3] = (float)((at[k / 3][k % 3] - cells.lower[k % 3]) * cells.scale);
        bool meets = qcRegionCells_Meet(&cells, corners[0], corners[1]);
        bool covered = qcRegionCells_AreMarked(&cells, other[0], other[1], reach);
        bool overlap = Overlap(at[0], at[1], other[0], other[1], reach);
        ck_assert(meets || !covered || !overlap);
        overlaps += covered && overlap;
        apart += !meets;
    }
    ck_assert_int_gt(overlaps, 500);
    ck_assert_int_gt(apart, 1000);
}
END_TEST

/// A coordinate in cells, in the steps in which the cluster order maps the corners of triangles.
static float InCells(const qcRegionCells* cells, double x)
{
    return (float)((x - cells->lower[0]) * (cells->scale / (3.0 * qc_cellsAlong))) * (3.0f * qc_cellsAlong);
}

START_TEST(triangles_that_rounding_moves_into_the_next_cell_meet_a_marked_one)
{
    qcRandom random = {9};
    int moved = 0;
    for (int i = 0; i < 20000; i++)
    {
        // A box ends next to the border of two cells, where a triangle begins.
        qcRegionCells cells;
        const double lower[3] = {-1.0, 0.0, 0.0}, upper[3] = {2.0 + qcRandom_Uniform(&random, 0.0, 1.0), 1.0, 1.0};
        ck_assert(qcRegionCells_Begin(&cells, lower, upper));
        uint32_t border = 1 + qcRandom_Below(&random, qc_cellsAlong - 1);
        double sign = i % 2 == 0 ? 1.0 : -1.0, aside = pow(10.0, qcRandom_Uniform(&random, -12.0, -7.0)),
               end = -1.0 + border / cells.scale - sign * aside, far = end - sign * 0.1;
        const double from[3] = {fmin(end, far), 0.5, 0.5}, to[3] = {fmax(end, far), 0.5, 0.5};
        qcRegionCells_Mark(&cells, from, to, 0.0);
        ck_assert(qcRegionCells_AreMarked(&cells, from, to, 0.0));
        float at = InCells(&cells, end), row = (float)(0.5 * cells.scale);
        const qcFourFloats corner = {at, row, row, 0.0f};
        ck_assert(qcRegionCells_Meet(&cells, corner, corner));
        moved += (uint32_t)at != (sign > 0.0 ? border - 1 : border);
    }
    ck_assert_int_gt(moved, 1000);
}
END_TEST

START_TEST(boxes_without_extent_or_beyond_single_precision_have_no_cells)
{
    const double ends[] = {0.0, 0x1p-101, 0x1p-99, 1.0, 0x1p99, 0x1p101, INFINITY};
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
    {
        qcRegionCells cells;
        const double lower[3] = {0.0, 0.0, 0.0}, upper[3] = {0.0, ends[i], 0.0};
        ck_assert_int_eq(qcRegionCells_Begin(&cells, lower, upper), i > 1 && i < 5);
    }
}
END_TEST

QC_RUN_TESTS("bvh_region", sheets_that_deform_in_their_places_keep_their_limited_bvhs,
             sheets_that_drift_and_jump_miss_no_pair, a_larger_distance_a_new_body_and_a_motion_have_all_pairs,
             after_a_failed_allocation_the_same_step_has_all_pairs,
             the_displacement_is_the_greatest_change_of_any_coordinate,
             distance_displacement_and_rounding_reach_together, a_box_near_a_covered_one_meets_a_marked_cell,
             triangles_that_rounding_moves_into_the_next_cell_meet_a_marked_one,
             boxes_without_extent_or_beyond_single_precision_have_no_cells)
