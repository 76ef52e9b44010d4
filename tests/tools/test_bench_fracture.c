// `qc-bench fracture` as a user runs it: a small mesh breaks into a few pieces, as meshes and as hulls.
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <stdio.h>
#include <string.h>

#define HEADER                                                                                                         \
    "shapes,seed,pieces,steps,break_ms,cut_ms,bodies_ms,detection_ms,solver_ms,first_ms,later_ms,longest_ms,points,"   \
    "deepest_mm,mean_depth_mm,under_floor_mm,penetrating,energy,awake,rest_seconds"

/// A closed tetrahedron.
static void WriteMesh(void)
{
    FILE* stream = fopen("body.obj", "w");
    ck_assert_ptr_nonnull(stream);
    fprintf(stream, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    fclose(stream);
}

typedef struct Rows
{
    int meshes, hulls;
    double seeds;
    double cutMs;
} Rows;

static void TakeRow(const Row* row, void* context)
{
    Rows* rows = context;
    rows->meshes += Is(row, "shapes", "meshes");
    rows->hulls += Is(row, "shapes", "hulls");
    rows->seeds += GetNumber(row, "seed");
    rows->cutMs += GetNumber(row, "cut_ms");
    ck_assert(Is(row, "steps", "60"));
    ck_assert_double_ge(GetNumber(row, "pieces"), 5.0);
    static const char* const times[] = {"break_ms", "bodies_ms", "detection_ms", "solver_ms",
                                        "first_ms", "later_ms",  "longest_ms"};
    for (size_t i = 0; i < sizeof times / sizeof times[0]; ++i)
        ck_assert_double_gt(GetNumber(row, times[i]), 0.0);
    ck_assert_double_ge(GetNumber(row, "longest_ms"), GetNumber(row, "first_ms"));
    ck_assert_double_gt(GetNumber(row, "points"), 3.0);
    ck_assert_double_ge(GetNumber(row, "deepest_mm"), GetNumber(row, "mean_depth_mm"));
    // Contact with the floor begins before its surface, and no piece falls through it.
    ck_assert_double_ge(GetNumber(row, "under_floor_mm"), 0.0);
    ck_assert_double_lt(GetNumber(row, "under_floor_mm"), 100.0);
    // It fell from 0.9 m, and lies on the floor or nearly so.
    ck_assert_double_gt(GetNumber(row, "energy"), 0.0);
    if (Is(row, "shapes", "meshes"))
        ck_assert(Is(row, "penetrating", "0"));
}

START_TEST(a_body_breaks_as_meshes_and_as_hulls)
{
    EnterFolder();
    WriteMesh();
    ck_assert_msg(Run(QC_BENCH_PROGRAM " fracture --mesh body.obj --pieces 5 --seeds 2 --steps 60 --out o") == 0, "%s",
                  GetErrors());
    Rows rows = {0};
    ck_assert_int_eq(ForEachRow("o/fracture.csv", HEADER, TakeRow, &rows), 4);
    ck_assert_int_eq(rows.meshes, 2);
    ck_assert_int_eq(rows.hulls, 2);
    ck_assert_double_eq(rows.seeds, 6.0);
    ck_assert_double_gt(rows.cutMs, 0.0);
    LeaveFolder();
}
END_TEST

START_TEST(pieces_that_were_cut_before_cost_no_cutting)
{
    EnterFolder();
    WriteMesh();
    ck_assert_msg(Run(QC_BENCH_PROGRAM " fracture --mesh body.obj --pieces 5 --seeds 1 --steps 60 --precut --out o") ==
                      0,
                  "%s", GetErrors());
    Rows rows = {0};
    ck_assert_int_eq(ForEachRow("o/fracture.csv", HEADER, TakeRow, &rows), 2);
    ck_assert_double_eq(rows.cutMs, 0.0);
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    static const CommandMistake wrong[] = {
        {"--seeds 0", 2, "--seeds: '0' is not a whole number in 1.."},
        {"--out ''", 2, "--out: no folder is named"},
        {"bunny", 2, "'bunny': options only"},
        {"--mesh none.obj", 3, "none.obj"},
        {"--steps 1 --out /dev/null/o", 1, "/dev/null"},
    };
    EnterFolder();
    CheckMistakes(QC_BENCH_PROGRAM " fracture", wrong, sizeof wrong / sizeof wrong[0]);
    ck_assert_int_eq(Run(QC_BENCH_PROGRAM " fracture --help"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "--precut"));
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("bench fracture", a_body_breaks_as_meshes_and_as_hulls, pieces_that_were_cut_before_cost_no_cutting,
             mistakes_are_refused_with_a_message)
