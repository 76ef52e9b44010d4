// `qc-bench through` as a user runs it: no pair penetrates in its scenes, pairs are found where nothing prevents them,
// and testing every pair finds the same ones.
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <stdio.h>
#include <string.h>

#define HEADER                                                                                                         \
    "scene,world,precision,hz,runs,failing_runs,steps,ends,inside,tangled,uncertified,unproven,exempt,planes,"         \
    "zone_nodes,momentum,energy,detect_ms,respond_ms,step_ms"

/// Runs a program that `qc-bench through` is, with options, and writes o.csv.
static void RunThrough(const char* program, const char* options)
{
    ck_assert_msg(Run("%s --threads 1 --csv o.csv %s", program, options) == 0, "%s", GetErrors());
}

static void CheckFree(const Row* row, void* context)
{
    static const char* const zeros[] = {"ends", "inside", "tangled", "uncertified", "unproven", "failing_runs"};
    for (size_t i = 0; i < sizeof zeros / sizeof zeros[0]; ++i)
        ck_assert_msg(Is(row, zeros[i], "0"), "%s, %s: %s %s", Get(row, "scene"), Get(row, "world"), Get(row, zeros[i]),
                      zeros[i]);
    ck_assert_double_le(GetNumber(row, "energy"), 1.001);
    *(double*)context += GetNumber(row, "planes");
    if (strncmp(Get(row, "scene"), "throw", 5) != 0)
        return;
    ck_assert_double_le(GetNumber(row, "momentum"), 1.001);
    ck_assert_double_ge(GetNumber(row, "momentum"), 0.999);
}

START_TEST(no_pair_penetrates_in_thrown_cloth_sheets_and_cloth_on_small_meshes)
{
    EnterFolder();
    double planes = 0.0;
    RunThrough(QC_THROUGH_PROGRAM,
               "--runs 2 --hz 60 --scene throw-20,throw-100,soft-sheets,rigid-sheets,drop-tetrahedra");
    ck_assert_int_eq(ForEachRow("o.csv", HEADER, CheckFree, &planes), 9);
    ck_assert_double_gt(planes, 0.0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "\n9 of 9 rows without a penetrating pair; version 0.2.0: "));
    LeaveFolder();
}
END_TEST

static void CheckHeld(const Row* row, void* context)
{
    (void)context;
    ck_assert_msg(Is(row, "failing_runs", "0"), "%s, %s: %s pairs at ends", Get(row, "scene"), Get(row, "world"),
                  Get(row, "ends"));
    ck_assert(Is(row, "ends", "0") && Is(row, "inside", "0"));
}

START_TEST(a_mesh_that_turns_does_not_go_through_the_cloth_around_it)
{
    EnterFolder();
    RunThrough(QC_THROUGH_PROGRAM, "--runs 4 --scene drop-kinematic");
    ck_assert_int_eq(ForEachRow("o.csv", HEADER, CheckHeld, NULL), 2);
    LeaveFolder();
}
END_TEST

static void CheckFound(const Row* row, void* context)
{
    ck_assert_msg(GetNumber(row, "ends") + GetNumber(row, "inside") > 10.0, "%s", Get(row, "world"));
    ck_assert_double_gt(GetNumber(row, "uncertified"), 10.0);
    ck_assert(Is(row, "failing_runs", Get(row, "runs")));
    ++*(int*)context;
}

START_TEST(pairs_are_found_where_contact_is_not_continuous)
{
    EnterFolder();
    int rows = 0;
    RunThrough(QC_THROUGH_PROGRAM, "--quick --hz 60 --scene throw-20 --discrete");
    ForEachRow("o.csv", HEADER, CheckFound, &rows);
    ck_assert_int_eq(rows, 2);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "\n0 of 2 rows"));
    LeaveFolder();
}
END_TEST

static void KeepPairs(const Row* row, void* context)
{
    char* text = context;
    size_t length = strlen(text);
    snprintf(text + length, 4096 - length, "%s %s %s %s %s\n", Get(row, "scene"), Get(row, "ends"), Get(row, "inside"),
             Get(row, "tangled"), Get(row, "uncertified"));
}

START_TEST(testing_every_pair_finds_the_same_ones)
{
    EnterFolder();
    char texts[2][4096] = {"", ""};
    for (int brute = 0; brute < 2; ++brute)
    {
        RunThrough(QC_THROUGH_PROGRAM, brute != 0
                                           ? "--quick --world classic --scene soft-sheets,ropes --discrete --brute"
                                           : "--quick --world classic --scene soft-sheets,ropes --discrete");
        ck_assert_int_eq(ForEachRow("o.csv", HEADER, KeepPairs, texts[brute]), 2);
    }
    ck_assert_str_eq(texts[0], texts[1]);
    ck_assert_ptr_null(strstr(texts[0], "sheets 0 0"));
    LeaveFolder();
}
END_TEST

static void CheckCrushed(const Row* row, void* context)
{
    (void)context;
    ck_assert_double_gt(GetNumber(row, "ends"), 0.0);
    ck_assert_double_gt(GetNumber(row, "unproven"), 0.0);
    ck_assert(Is(row, "failing_runs", "0"));
}

START_TEST(what_is_crushed_is_reported)
{
    EnterFolder();
    RunThrough(QC_THROUGH_PROGRAM, "--quick --scene crush");
    ck_assert_int_eq(ForEachRow("o.csv", HEADER, CheckCrushed, NULL), 2);
    LeaveFolder();
}
END_TEST

START_TEST(each_row_stands_beside_that_of_the_version_before)
{
    EnterFolder();
    RunThrough(QC_THROUGH_PROGRAM, "--runs 1 --scene bin,soft-sheets");
    ck_assert_ptr_null(strstr(GetOutput(), "?"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "10/10 > 0/1"));
    LeaveFolder();
}
END_TEST

START_TEST(the_film_is_drawn_where_there_is_a_device)
{
    EnterFolder();
    int status = Run(QC_THROUGH_PROGRAM " --scene film --quick --frames deep/er --record film.txt");
    ck_assert(status == 0 || status == 4);
    if (status == 0)
        ck_assert_str_eq(GetOutput(), "25 pictures: deep/er\n");
    ck_assert_int_eq(Run("test -s film.txt"), 0);
    if (status == 0)
        ck_assert_int_eq(Run("test -s deep/er/frame_0000.png && test $(ls deep/er | wc -l) -eq 25"), 0);
    LeaveFolder();
}
END_TEST

#ifdef QC_THROUGH_DOUBLE_PROGRAM
START_TEST(no_pair_penetrates_in_double_precision)
{
    EnterFolder();
    double planes = 0.0;
    RunThrough(QC_THROUGH_DOUBLE_PROGRAM, "--quick --hz 60 --scene throw-50,soft-sheets,rigid-sheets");
    ck_assert_int_eq(ForEachRow("o.csv", HEADER, CheckFree, &planes), 5);
    ck_assert_double_gt(planes, 0.0);
    ck_assert_ptr_null(strstr(GetOutput(), "?"));
    LeaveFolder();
}
END_TEST
#endif

START_TEST(mistakes_are_refused_with_a_message)
{
    static const CommandMistake wrong[] = {
        {"--scene throw-21", 2, "there is no scene 'throw-21', only: throw-5, throw-20"},
        {"--world clasic", 2, "--world: 'clasic' is not one of classic, deformable"},
        {"--hz 50", 2, "--hz: '50' is not one of 60, 240"},
        {"--runs -1", 2, "--runs: '-1' is not"},
        {"--runs 0", 2, "--runs: '0' is not a whole number in 1..1000"},
        {"--scene film", 2, "--scene: film needs --frames FOLDER"},
        {"--frames ''", 2, "--frames: no folder is named"},
        {"--scenes bin", 2, "unrecognized option '--scenes'"},
        {"bin", 2, "'bin': options only"},
        {"--quick --scene soft-sheets --csv none/o.csv", 1, "none/o.csv"},
    };
    EnterFolder();
    CheckMistakes(QC_THROUGH_PROGRAM, wrong, sizeof wrong / sizeof wrong[0]);
    ck_assert_int_eq(Run(QC_THROUGH_PROGRAM " --help"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "--scene=NAME"));
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("bench through", no_pair_penetrates_in_thrown_cloth_sheets_and_cloth_on_small_meshes,
             a_mesh_that_turns_does_not_go_through_the_cloth_around_it, pairs_are_found_where_contact_is_not_continuous,
             testing_every_pair_finds_the_same_ones, what_is_crushed_is_reported,
             each_row_stands_beside_that_of_the_version_before, the_film_is_drawn_where_there_is_a_device,
#ifdef QC_THROUGH_DOUBLE_PROGRAM
             no_pair_penetrates_in_double_precision,
#endif
             mistakes_are_refused_with_a_message)
