// `qc-bench piles` as a user runs it: every shape falls in the same scene, and each figure is written.
#include "support/csv_rows.h"
#include "support/suite.h"

#include <check.h>
#include <string.h>

#define HEADER                                                                                                         \
    "scene,shapes,bodies,triangles,threads,steps,falling_ms,rest_ms,asleep_ms,longest_ms,falling_detection_ms,"        \
    "rest_detection_ms,falling_points,rest_points,deepest,under_ground,penetrating,rest_seconds,drift,starts,restless"

typedef struct Rows
{
    int ours, gimpact, hulls;
} Rows;

static void TakeRow(const Row* row, void* context)
{
    Rows* rows = context;
    rows->ours += Is(row, "shapes", "qcMeshShape");
    rows->gimpact += Is(row, "shapes", "btGImpactMeshShape");
    rows->hulls += Is(row, "shapes", "btConvexHullShape");
    ck_assert(Is(row, "bodies", "6"));
    ck_assert(Is(row, "triangles", "3456"));
    ck_assert(Is(row, "steps", "30"));
    ck_assert(Is(row, "threads", "1"));
    ck_assert_double_gt(GetNumber(row, "falling_ms"), 0.0);
    ck_assert_double_gt(GetNumber(row, "rest_ms"), GetNumber(row, "rest_detection_ms"));
    ck_assert_double_ge(GetNumber(row, "longest_ms"), GetNumber(row, "falling_ms"));
    // Asleep bodies are not queried.
    ck_assert_double_lt(GetNumber(row, "asleep_ms"), GetNumber(row, "rest_ms"));
    // Six rings that lie on each other: every shape finds them.
    if (Is(row, "scene", "stack-6"))
        ck_assert_double_gt(GetNumber(row, "rest_points"), 6.0);
    if (Is(row, "shapes", "qcMeshShape"))
        ck_assert(Is(row, "penetrating", "0"));
}

START_TEST(every_shape_falls_in_the_same_scene)
{
    EnterFolder();
    ck_assert_msg(Run(QC_BENCH_PROGRAM " piles --scene stack-6,chain-6 --steps 30 --out o") == 0, "%s", GetErrors());
    ck_assert_ptr_nonnull(strstr(GetOutput(), "Threads of qcMeshContact: 1\n"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "\nstack-6    btGImpactMeshShape "));
    Rows rows = {0};
    ck_assert_int_eq(ForEachRow("o/piles.csv", HEADER, TakeRow, &rows), 5);
    ck_assert_int_eq(rows.ours, 2);
    ck_assert_int_eq(rows.gimpact, 2);
    // The hulls of linked rings would overlap from the beginning.
    ck_assert_int_eq(rows.hulls, 1);
    LeaveFolder();
}
END_TEST

static void TakeChain(const Row* row, void* context)
{
    ++*(int*)context;
    ck_assert(Is(row, "penetrating", "0"));
    ck_assert(Is(row, "deepest", "0"));
    // It lands on the ground, a plane, 32 mm deep.
    ck_assert_double_lt(GetNumber(row, "under_ground"), 0.05);
    ck_assert_double_gt(GetNumber(row, "rest_seconds"), 0.0);
    ck_assert_double_lt(GetNumber(row, "drift"), 0.05);
}

START_TEST(linked_rings_stay_linked_and_come_to_rest)
{
    EnterFolder();
    ck_assert_msg(Run(QC_BENCH_PROGRAM " piles --scene chain-6 --shape mesh --steps 360 --out o") == 0, "%s",
                  GetErrors());
    int rows = 0;
    ck_assert_int_eq(ForEachRow("o/piles.csv", HEADER, TakeChain, &rows), 1);
    ck_assert_int_eq(rows, 1);
    LeaveFolder();
}
END_TEST

START_TEST(one_shape_can_be_chosen)
{
    EnterFolder();
    ck_assert_msg(Run(QC_BENCH_PROGRAM " piles --scene tori-6 --shape mesh --steps 4 --seed 2 --out o") == 0, "%s",
                  GetErrors());
    ck_assert_ptr_nonnull(strstr(GetOutput(), "\ntori-6     qcMeshShape "));
    ck_assert_ptr_null(strstr(GetOutput(), "btGImpactMeshShape"));
    LeaveFolder();
}
END_TEST

static void TakeStarts(const Row* row, void* context)
{
    ++*(int*)context;
    ck_assert(Is(row, "starts", "3"));
    ck_assert(Is(row, "steps", "18"));
    // They still fall.
    ck_assert(Is(row, "restless", "3"));
    ck_assert(Is(row, "rest_seconds", "-1"));
    ck_assert_double_gt(GetNumber(row, "drift"), 0.0);
}

START_TEST(figures_of_several_starts_are_put_together)
{
    EnterFolder();
    ck_assert_msg(Run(QC_BENCH_PROGRAM " piles --scene tori-6 --shape mesh --steps 6 --starts 3 --out o") == 0, "%s",
                  GetErrors());
    int rows = 0;
    ck_assert_int_eq(ForEachRow("o/piles.csv", HEADER, TakeStarts, &rows), 1);
    ck_assert_int_eq(rows, 1);
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    static const CommandMistake wrong[] = {
        {"--scene tori", 2, "there is no scene 'tori', only: tori-6, "},
        {"--shape hulls", 2, "there is no shape 'hulls', only: mesh, gimpact, hull"},
        {"--steps 3", 2, "--steps: '3' is not a whole number in 4.."},
        {"--starts 0", 2, "--starts: '0' is not a whole number in 1.."},
        {"--out ''", 2, "--out: no folder is named"},
        {"tori-6", 2, "'tori-6': options only"},
        {"--scene tori-6 --steps 4 --out /dev/null/o", 1, "/dev/null"},
    };
    EnterFolder();
    CheckMistakes(QC_BENCH_PROGRAM " piles", wrong, sizeof wrong / sizeof wrong[0]);
    ck_assert_int_eq(Run(QC_BENCH_PROGRAM " piles --help"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "bunnies-12"));
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("bench piles", every_shape_falls_in_the_same_scene, linked_rings_stay_linked_and_come_to_rest,
             one_shape_can_be_chosen, figures_of_several_starts_are_put_together, mistakes_are_refused_with_a_message)
