// The method `layers` from step to step: lists grow once, only changed bodies are uploaded, the sweep runs where the
// device can't, and scenes that share a device are independent. (Random steps: test_layers_steps.c.)
#define _POSIX_C_SOURCE 200809L
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>

//  ---- comparison ------------------------------------------------------------------------------------------------

/// Compares `layers` with another method on this scene. Returns the result of `layers`.
static const qcResult* CheckAgainst(qcMethod method, qcScene* scene, const qcDetectDef* given, const char* what)
{
    qcDetectDef def = *given;
    def.method = method;
    qcPairList expected = qcDetectPairs(scene, &def);
    def.method = qc_methodLayers;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert(!result->profile.reused);
    qcPairList found = qcListOf(result);
    qcCheckSamePairs(&expected, &found, what);
    free(expected.pairs);
    return result;
}

static void CheckOnDevice(const qcResult* result)
{
    ck_assert_msg(result->profile.fallback == NULL, "%s", result->profile.fallback);
    ck_assert_int_eq(result->profile.method, qc_methodLayers);
}

/// Compares `layers` with the sweep, and checks that the device found the pairs.
static const qcResult* CheckLayers(qcScene* scene, const qcDetectDef* def, const char* what)
{
    const qcResult* result = CheckAgainst(qc_methodSweep, scene, def, what);
    CheckOnDevice(result);
    return result;
}

static void SetVertices(qcScene* scene, qcBodyId id, const qcSoup* soup)
{
    CHECK_OK(qcScene_SetVertices(scene, id, soup->positions, qc_positionF64, 0));
}

//  ---- lists that grow, uploads ------------------------------------------------------------------------------------

/// Lists of pairs grow on the device; if the processor reads the image, the image grows instead: with more columns than
/// by default, large triangles cover many cells.
static void CheckCollapse(const char* refinedBy, uint32_t columns)
{
    enum
    {
        qc_count = 1200
    };
    setenv("QC_LAYERS_REFINE", refinedBy, 1);
    // Equal centres: disjoint triangles, and ones larger than most distances.
    qcSoup apart = qcSoup_MakeRandom(5, qc_count, 0.005), crowded = qcSoup_MakeRandom(5, qc_count, 0.25);
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcBodyId id = qcAddDeformingSoup(scene, &apart);
        qcDetectDef def = qcDefaultDetectDef();
        def.layerColumns = columns;
        uint64_t few = CheckLayers(scene, &def, "apart")->pairCount;
        SetVertices(scene, id, &crowded);
        const qcResult* result = CheckLayers(scene, &def, "collapsed");
        ck_assert_uint_gt(result->pairCount, 20 * few + qc_count);
        ck_assert_uint_gt(result->profile.reruns, 0);
        for (int round = 0; round < 3; round++)
        {
            SetVertices(scene, id, &crowded);
            ck_assert_uint_eq(CheckLayers(scene, &def, "collapsed again")->profile.reruns, 0);
            SetVertices(scene, id, &apart);
            result = CheckLayers(scene, &def, "apart again");
            ck_assert_uint_eq(result->profile.reruns, 0);
            ck_assert_uint_eq(result->pairCount, few);
        }
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&apart);
    qcSoup_Free(&crowded);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

START_TEST(a_collapsing_scene_reruns_its_step_once)
{
    CheckCollapse("device", 0);
    CheckCollapse("processor", 32);
}
END_TEST

/// Balls in a row, each in the next, every other one deforming.
typedef struct Row
{
    qcScene* scene;
    qcSoup ball;
    qcBodyId ids[7];
    double vertexBytes; ///< of one of them, on the device
    double leastBytes;  ///< of one of them, as the caller gave them in floats
    double tableBytes;  ///< upper bound for the tables of all bodies and of all numbers of nodes
} Row;

static void MoveBall(const Row* row, uint32_t number, double by)
{
    if (number % 2 == 0)
    {
        qcSoup moved = qcSoup_MakeSphere(3, 0.5);
        qcSoup_Translate(&moved, 0.7 * number, by, 0);
        SetVertices(row->scene, row->ids[number], &moved);
        qcSoup_Free(&moved);
        return;
    }
    qcTransform transform = qcIdentityTransform();
    transform.translation[0] = 0.7 * number;
    transform.translation[1] = by;
    CHECK_OK(qcScene_SetTransform(row->scene, row->ids[number], &transform));
}

static double CheckUpload(const Row* row, const char* what)
{
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result = CheckLayers(row->scene, &def, what);
    ck_assert_uint_gt(result->pairCount, 100);
    return (double)result->profile.uploadedBytes;
}

/// Adds deforming bodies first and runs a step with them.
static Row MakeRow(qcDevice* device)
{
    Row row = {.scene = qcMakeScene(device), .ball = qcSoup_MakeSphere(3, 0.5)};
    row.vertexBytes = 16.0 * row.ball.vertexCount;
    row.leastBytes = 12.0 * row.ball.vertexCount;
    // 80 bytes a body, 4 a node of 64 triangles, which is at least a quarter full.
    row.tableBytes = 7 * 80.0 + 7 * (4.0 / 16) * row.ball.triangleCount;
    for (uint32_t k = 0; k < 7; k++)
    {
        uint32_t i = k < 4 ? 2 * k : 2 * (k - 4) + 1;
        qcBodyDef def = qcBodyDefOf(&row.ball);
        def.deforming = k < 4;
        CHECK_OK(qcScene_AddBody(row.scene, &def, &row.ids[i]));
        MoveBall(&row, i, 0);
        qcDetectDef detect = qcDefaultDetectDef();
        if (k == 3)
            CheckLayers(row.scene, &detect, "no rigid bodies yet");
    }
    return row;
}

START_TEST(only_changed_bodies_are_uploaded)
{
    QC_FOR_EACH_DEVICE(device)
    {
        Row row = MakeRow(device);
        ck_assert_double_lt(row.tableBytes, 0.5 * row.vertexBytes); // or the test would show little
        ck_assert_double_gt(CheckUpload(&row, "the first step"), 7 * row.vertexBytes);
        ck_assert_double_le(CheckUpload(&row, "nothing moved"), row.tableBytes - 7 * 80.0);
        MoveBall(&row, 3, 0.01);
        ck_assert_double_le(CheckUpload(&row, "a rigid body moved"), row.tableBytes);
        for (uint32_t i = 1; i < 7; i += 2)
            MoveBall(&row, i, -0.01);
        ck_assert_double_le(CheckUpload(&row, "all rigid bodies moved"), row.tableBytes);
        MoveBall(&row, 4, 0.01);
        double bytes = CheckUpload(&row, "a deforming body moved");
        ck_assert_double_ge(bytes, row.leastBytes);
        ck_assert_double_le(bytes, row.vertexBytes + row.tableBytes);
        CHECK_OK(qcScene_SetFilter(row.scene, row.ids[2], 2, 5));
        CHECK_OK(qcScene_SetActivity(row.scene, row.ids[6], qc_activitySleeping));
        ck_assert_double_le(CheckUpload(&row, "rules changed"), row.tableBytes);
        CHECK_OK(qcScene_RemoveBody(row.scene, row.ids[3]));
        ck_assert_double_le(CheckUpload(&row, "a body went"), row.tableBytes);
        CHECK_OK(qcScene_SetActivity(row.scene, row.ids[6], qc_activityMoving));
        // Far enough for another frame, and back: vertices in the frame anew, topology not.
        for (int far = 1; far >= 0; far--)
        {
            MoveBall(&row, 5, 100 * far);
            bytes = CheckUpload(&row, "another frame");
            ck_assert_double_ge(bytes, 4 * row.leastBytes);
            ck_assert_double_le(bytes, 4 * row.vertexBytes + row.tableBytes);
        }
        qcScene_Destroy(row.scene);
        qcSoup_Free(&row.ball);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- limits of the device -----------------------------------------------------------------------------------------

static void CheckFallback(const qcResult* result, const char* reason)
{
    ck_assert_int_eq(result->profile.method, qc_methodSweep);
    ck_assert_ptr_nonnull(result->profile.fallback);
    ck_assert_msg(strstr(result->profile.fallback, reason) != NULL &&
                      strstr(result->profile.fallback, "sweep answered on the CPU") != NULL,
                  "'%s' does not say '%s'", result->profile.fallback, reason);
    ck_assert_uint_gt(result->pairCount, 10);
}

START_TEST(without_compute_shaders_the_sweep_runs_and_the_profile_names_it)
{
    qcDevice* none = qcOpenOrSkip(qc_deviceNone);
    qcSoup soup = qcSoup_MakeRandom(3, 200, 0.2);
    for (int i = 0; i < 2; i++)
    {
        qcScene* scene = qcMakeScene(i == 0 ? NULL : none);
        qcAddSoup(scene, &soup);
        qcDetectDef def = qcDefaultDetectDef();
        CheckFallback(CheckAgainst(qc_methodBrute, scene, &def, "no device"), "no GL device");
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&soup);
    qcDevice_Destroy(none);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_scene_beyond_the_frame_or_the_loops_is_swept_and_the_next_step_uses_the_device_again)
{
    qcSoup soup = qcSoup_MakeRandom(3, 200, 0.2), huge = qcSoup_MakeRandom(3, 200, 0.2);
    for (uint32_t i = 0; i < 3 * huge.vertexCount; i++)
        huge.positions[i] *= 0x1p962;
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcBodyId id = qcAddDeformingSoup(scene, &soup);
        qcDetectDef def = qcDefaultDetectDef();
        CheckLayers(scene, &def, "the first step");
        SetVertices(scene, id, &huge);
        CheckFallback(CheckAgainst(qc_methodBrute, scene, &def, "huge"), "too large for a frame");
        SetVertices(scene, id, &soup);
        CheckLayers(scene, &def, "after a huge scene");
        def.margin = 1e8;
        CheckFallback(CheckAgainst(qc_methodBrute, scene, &def, "wide margin"), "too large for a frame");
        def.margin = 0;
        CheckLayers(scene, &def, "after a wide margin");
        // The larger triangles alone cover more pixels than software renderers let loops run.
        def.layerColumns = 1024;
        const qcResult* result = CheckAgainst(qc_methodBrute, scene, &def, "many pixels");
        if (result->profile.method != qc_methodLayers)
            CheckFallback(result, "more than the device's loops do");
        else
            printf("many pixels: the device's loops run on\n");
        def.layerColumns = 0;
        CheckLayers(scene, &def, "after many pixels");
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&soup);
    qcSoup_Free(&huge);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- almost nothing ----------------------------------------------------------------------------------------------

static void CheckSmall(qcScene* scene, const char* what)
{
    for (int options = 0; options < 8; options++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = (options & 1) != 0;
        def.neighbours = (options & 2) != 0;
        def.margin = (options & 4) != 0 ? 0.25 : 0;
        ck_assert_ptr_null(CheckAgainst(qc_methodBrute, scene, &def, what)->profile.fallback);
    }
}

START_TEST(empty_scenes_points_and_degenerate_triangles_have_the_pairs_of_the_sweep)
{
    qcSoup degenerate = qcSoup_MakeDegenerate(8, 100, 0.3, 1), point = qcSoup_MakeRandom(8, 66, 0.3),
           same = qcSoup_MakeRandom(8, 66, 0.3);
    for (uint32_t i = 0; i < 3 * point.vertexCount; i++)
        point.positions[i] = 0.1 * (1 + i % 3);
    for (uint32_t i = 9; i < 3 * same.vertexCount; i++)
        same.positions[i] = same.positions[i - 9];
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        CheckSmall(scene, "no body");
        qcSoup part = point;
        part.triangleCount = 0;
        qcBodyId id = qcAddSoup(scene, &part);
        CheckSmall(scene, "a body without triangles");
        CHECK_OK(qcScene_RemoveBody(scene, id));
        part = same;
        part.triangleCount = 1;
        qcAddSoup(scene, &part);
        CheckSmall(scene, "one triangle");
        qcAddSoup(scene, &part);
        CheckSmall(scene, "one triangle twice");
        const qcSoup* soups[] = {&degenerate, &point, &same};
        for (int i = 0; i < 3; i++)
        {
            qcScene* other = qcMakeScene(device);
            id = qcAddDeformingSoup(other, soups[i]);
            CheckSmall(other, "all alike");
            qcDetectDef def = qcDefaultDetectDef();
            def.touching = true;
            size_t pairs = CheckLayers(other, &def, "all alike")->pairCount;
            ck_assert(i == 0 || pairs > 10);
            qcAddSoup(other, soups[(i + 1) % 3]);
            CheckSmall(other, "all alike, twice");
            qcScene_Destroy(other);
        }
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&degenerate);
    qcSoup_Free(&point);
    qcSoup_Free(&same);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_margin_as_wide_as_the_scene_finds_all_pairs_and_no_padding)
{
    // Clusters and nodes that are full and not; boxes that are all of the image.
    static const uint32_t s_counts[] = {1, 3, 20, 64, 70};
    static const double s_margins[] = {0.03, 0.1, 0.25, 0.5, 1, 20, 3e5};
    QC_FOR_EACH_DEVICE(device)
    for (int i = 0; i < 5; i++)
    {
        qcScene* scene = qcMakeScene(device);
        for (uint64_t body = 0; body < 2; body++)
        {
            qcSoup soup = qcSoup_MakeRandom(10 * body + (uint64_t)i, s_counts[i], 0.5);
            for (uint32_t v = 0; v < 9; v++)
                soup.positions[v] = 2.0 * (v >= 3 && (v < 6 || v % 3 == 0)) - 0.5; // along the diagonal
            qcAddSoup(scene, &soup);
            qcSoup_Free(&soup);
        }
        for (int k = 0; k < 7; k++)
        {
            qcDetectDef def = qcDefaultDetectDef();
            def.margin = s_margins[k];
            def.neighbours = k % 2 == 0;
            CheckOnDevice(CheckAgainst(qc_methodBrute, scene, &def, "wide margin"));
        }
        qcScene_Destroy(scene);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(few_and_many_bodies_that_cross_each_other_have_the_pairs_of_the_sweep)
{
    // 3 200, 11 000 and 37 600 pairs of nodes, of one triangle each: a workgroup takes 4, 8 or 16 at a time.
    static const uint32_t s_counts[] = {100, 180, 340};
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcDetectDef def = qcDefaultDetectDef();
        for (uint32_t i = 0, body = 0; i < 3; i++)
        {
            for (; body < s_counts[i]; body++)
            {
                qcSoup soup = qcSoup_MakeRandom(body, 1, 2.0);
                qcAddSoup(scene, &soup);
                qcSoup_Free(&soup);
            }
            // The second step expects as many pairs as the first has found.
            for (int step = 0; step < 2; step++)
                ck_assert_uint_gt(CheckLayers(scene, &def, "bodies that cross each other")->pairCount, s_counts[i]);
        }
        qcScene_Destroy(scene);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- sharing a device ---------------------------------------------------------------------------------------------

/// A scene that changes and grows, on a device shared with other scenes.
typedef struct User
{
    qcScene* scene;
    qcBodyId cloth;
    uint64_t seed;
    uint32_t side;
    int wrong, pairs;
} User;

static bool AreSame(const qcPairList* a, const qcPairList* b)
{
    bool same = a->count == b->count;
    for (size_t i = 0; same && i < a->count; i++)
        same = qcComparePairs(&a->pairs[i], &b->pairs[i]) == 0 && a->pairs[i].relation == b->pairs[i].relation;
    return same;
}

/// Counts differences: assertions belong to the main thread.
static void TakeStep(User* user, int step)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(user->seed + (uint64_t)step, user->side, 0.02, 0.03);
    if (step == 0)
        user->cloth = qcAddDeformingSoup(user->scene, &soup);
    else
        SetVertices(user->scene, user->cloth, &soup);
    if (step % 3 == 2)
        qcAddSoup(user->scene, &soup);
    qcSoup_Free(&soup);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.threads = 1;
    qcPairList expected = qcDetectPairs(user->scene, &def);
    def.method = qc_methodLayers;
    const qcResult* result = NULL;
    qcStatus status = qcScene_Detect(user->scene, &def, &result);
    qcPairList found = status == qc_statusOk ? qcListOf(result) : (qcPairList){0};
    user->wrong += status != qc_statusOk || result->profile.fallback != NULL || !AreSame(&expected, &found);
    user->pairs += (int)expected.count;
    free(expected.pairs);
}

static void* TakeSteps(void* user)
{
    for (int step = 0; step < 7; step++)
        TakeStep(user, step);
    return NULL;
}

START_TEST(two_scenes_share_a_device_in_turn_and_on_two_threads)
{
    QC_FOR_EACH_DEVICE(device)
    for (int threaded = 0; threaded < 2; threaded++)
    {
        User users[2] = {{.seed = 10, .side = 14}, {.seed = 60, .side = 9}};
        pthread_t threads[2];
        for (int i = 0; i < 2; i++)
            users[i].scene = qcMakeScene(device);
        for (int step = 0; step < 7 && !threaded; step++)
            for (int i = 0; i < 2; i++)
                TakeStep(&users[i], step);
        for (int i = 0; i < 2 && threaded; i++)
            ck_assert_int_eq(pthread_create(&threads[i], NULL, TakeSteps, &users[i]), 0);
        for (int i = 0; i < 2; i++)
        {
            if (threaded)
                ck_assert_int_eq(pthread_join(threads[i], NULL), 0);
            ck_assert_int_eq(users[i].wrong, 0);
            ck_assert_int_gt(users[i].pairs, 100);
            qcScene_Destroy(users[i].scene);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(the_pairs_do_not_depend_on_device_columns_or_depth_axis)
{
    qcSoup cloth = qcSoup_MakeFoldedCloth(9, 56, 0.004, 0.004);
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcAddSoup(scene, &cloth);
        qcDetectDef def = qcDefaultDetectDef();
        for (uint32_t columns = 0; columns <= 64; columns = 4 * columns + (columns == 0))
            for (int axis = 0; axis < 4; axis++)
            {
                def.layerColumns = columns;
                def.layerDepthAxis = "\0xyz"[axis];
                char what[80];
                snprintf(what, sizeof what, "%u columns, axis %d", columns, axis);
                const qcResult* result = CheckLayers(scene, &def, what);
                ck_assert_uint_gt(result->pairCount, 1000);
                ck_assert(columns == 0 || result->profile.columns == (qcHasImage(device) ? columns : 0));
            }
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&cloth);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// Checks the number of cells of the image along each axis. 0: more than one.
static void CheckCells(const qcResult* result, uint32_t columns, uint32_t rows, uint32_t slices, const char* what)
{
    const uint32_t cells[3] = {result->profile.columns, result->profile.rows, result->profile.slices},
                   expected[3] = {columns, rows, slices};
    for (int i = 0; i < 3; i++)
        ck_assert_msg(expected[i] == 0 ? cells[i] > 1 : cells[i] == expected[i],
                      "%s: %" PRIu32 " x %" PRIu32 " x %" PRIu32 " cells", what, cells[0], cells[1], cells[2]);
}

START_TEST(cells_are_about_as_large_as_the_nodes_in_them)
{
    qcSoup small = qcSoup_MakeRandom(3, 20000, 0.01), large = qcSoup_MakeRandom(3, 300, 2.0),
           flat = qcSoup_MakeRandom(3, 20000, 0.01);
    for (uint32_t i = 0; i < flat.vertexCount; i++)
        flat.positions[3 * i + 2] *= 1e-3;
    QC_FOR_EACH_DEVICE(device)
    {
        struct
        {
            const char* what;
            const qcSoup* soup;
            uint32_t columns, expected[3];
        } cases[] = {{"small in all axes", &small, 0, {0, 0, 0}},
                     {"small, image given", &small, 16, {16, 16, 0}},
                     {"large", &large, 0, {1, 1, 1}},
                     {"flat", &flat, 0, {0, 0, 1}}};
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        {
            qcScene* scene = qcMakeScene(device);
            qcAddSoup(scene, cases[i].soup);
            qcDetectDef def = qcDefaultDetectDef();
            def.layerColumns = cases[i].columns;
            const uint32_t* expected = cases[i].expected;
            const qcResult* result = CheckLayers(scene, &def, cases[i].what);
            if (qcHasImage(device))
                CheckCells(result, expected[0], expected[1], expected[2], cases[i].what);
            qcScene_Destroy(scene);
        }
    }
    qcSoup_Free(&small);
    qcSoup_Free(&large);
    qcSoup_Free(&flat);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("layers", a_collapsing_scene_reruns_its_step_once, only_changed_bodies_are_uploaded,
                        without_compute_shaders_the_sweep_runs_and_the_profile_names_it,
                        a_scene_beyond_the_frame_or_the_loops_is_swept_and_the_next_step_uses_the_device_again,
                        empty_scenes_points_and_degenerate_triangles_have_the_pairs_of_the_sweep,
                        a_margin_as_wide_as_the_scene_finds_all_pairs_and_no_padding,
                        few_and_many_bodies_that_cross_each_other_have_the_pairs_of_the_sweep,
                        two_scenes_share_a_device_in_turn_and_on_two_threads,
                        the_pairs_do_not_depend_on_device_columns_or_depth_axis,
                        cells_are_about_as_large_as_the_nodes_in_them)
