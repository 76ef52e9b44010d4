// `qc-bench terrain` as a user runs it: each row is written, and no body passes the hills on this library's shape.
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <string.h>

#define PROGRAM QC_BENCH_PROGRAM " terrain"

typedef struct Sums
{
    double oursBelow, bulletBelow, limitMs;
} Sums;

static void CheckRow(const Row* row, void* context)
{
    Sums* sums = context;
    ck_assert(Is(row, "bodies", "balls") || Is(row, "bodies", "hulls"));
    ck_assert(Is(row, "start", "rolling") || Is(row, "start", "thrown"));
    ck_assert(Is(row, "triangles", "3200") || Is(row, "triangles", "80000"));
    ck_assert(Is(row, "count", "30"));
    ck_assert_double_gt(GetNumber(row, "bullet ms"), 0.0);
    ck_assert_double_gt(GetNumber(row, "ours ms"), GetNumber(row, "limits ms"));
    sums->oursBelow += GetNumber(row, "ours below");
    sums->bulletBelow += GetNumber(row, "bullet below");
    sums->limitMs += GetNumber(row, "limits ms");
}

START_TEST(each_row_is_written_and_nothing_is_below)
{
    EnterFolder();
    ck_assert_msg(Run(PROGRAM " --kinds balls,hulls --bodies 30 --steps 20 --out o") == 0, "%s", GetErrors());
    Sums sums = {0};
    ck_assert_int_eq(ForEachRow("o/terrain.csv",
                                "bodies,start,triangles,count,bullet ms,ours ms,limits ms,bullet below,ours below",
                                CheckRow, &sums),
                     8);
    ck_assert_double_eq(sums.oursBelow, 0.0);
    // The hills are thin, and the bodies fast enough for Bullet to lose some.
    ck_assert_double_gt(sums.bulletBelow, 0.0);
    ck_assert_double_gt(sums.limitMs, 0.0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "hulls      thrown"));
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    static const CommandMistake wrong[] = {
        {"--kinds cubes", 2, "--kinds: 'cubes' is not one of balls, boxes, capsules, hulls, compounds"},
        {"--bodies 0", 2, "--bodies: '0' is not a whole number in 1..100000"},
        {"--steps 0", 2, "--steps: '0' is not"},
        {"--out ''", 2, "--out: no folder is named"},
        {"balls", 2, "'balls': options only"},
        {"--kinds balls --bodies 1 --steps 1 --out /dev/null/o", 1, "/dev/null: Not a directory"},
    };
    EnterFolder();
    CheckMistakes(PROGRAM, wrong, sizeof wrong / sizeof wrong[0]);
    ck_assert_int_eq(Run(PROGRAM " --help"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "--kinds=LIST"));
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("bench terrain", each_row_is_written_and_nothing_is_below, mistakes_are_refused_with_a_message)
