// `qc-bench stability` as a user runs it: scenes at rest are stable, and each measure is written.
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <string.h>

#define HEADER                                                                                                         \
    "scene,step,seconds,energy,contacts,depth,remaining,pairs,soft_pairs,bytes,resident,ms,kinetic,hanging,below"

typedef struct Course
{
    double first, last, contacts;
    int rows, boxes;
} Course;

static void TakeRow(const Row* row, void* context)
{
    Course* course = context;
    course->first = course->rows == 0 ? GetNumber(row, "energy") : course->first;
    course->last = GetNumber(row, "energy");
    course->contacts += GetNumber(row, "contacts");
    course->rows++;
    course->boxes += Is(row, "scene", "boxes");
    ck_assert_double_gt(GetNumber(row, "bytes"), 0.0);
    ck_assert_double_gt(GetNumber(row, "resident"), 1e6);
    ck_assert_double_gt(GetNumber(row, "ms"), 0.0);
    ck_assert(Is(row, "pairs", "0"));
    ck_assert(Is(row, "remaining", Is(row, "scene", "boxes") ? "-1" : "0"));
}

START_TEST(boxes_stay_where_they_stand)
{
    EnterFolder();
    ck_assert_msg(Run(QC_BENCH_PROGRAM " stability --scene boxes --steps 400 --out o") == 0, "%s", GetErrors());
    ck_assert_ptr_nonnull(strstr(GetOutput(), "\n1 of 1 scenes are stable\n"));
    Course course = {0};
    ck_assert_int_eq(ForEachRow("o/stability.csv", HEADER, TakeRow, &course), 400);
    ck_assert_int_eq(course.boxes, 400);
    // 60 boxes of 10 kg, the centre of the lowest a quarter of a metre above the ground.
    ck_assert_double_gt(course.first, 60 * 10 * 9.8 * 0.25);
    ck_assert_double_lt(course.last, course.first);
    ck_assert_double_gt(course.contacts, 400 * 100);
    LeaveFolder();
}
END_TEST

START_TEST(a_cloth_falls_without_a_penetrating_pair)
{
    EnterFolder();
    ck_assert_msg(Run(QC_BENCH_PROGRAM " stability --scene cloth --steps 150 --out o") == 0, "%s", GetErrors());
    ck_assert_ptr_nonnull(strstr(GetOutput(), " stable, but too short for the energy\n"));
    Course course = {0};
    ck_assert_int_eq(ForEachRow("o/stability.csv", HEADER, TakeRow, &course), 150);
    ck_assert_double_lt(course.last, course.first);
    LeaveFolder();
}
END_TEST

START_TEST(a_tangle_that_is_not_resolved_fails)
{
    EnterFolder();
    ck_assert_int_eq(Run(QC_BENCH_PROGRAM " stability --scene tangle --steps 4 --out o"), 1);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "NOT STABLE"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "pairs of triangles penetrate at the end"));
    ck_assert_ptr_nonnull(strstr(GetErrors(), "tangle is not stable"));
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    static const CommandMistake wrong[] = {
        {"--scene clot", 2, "there is no scene 'clot', only: cloth, "},
        {"--jitter 0", 2, "--jitter: '0' is not a whole number in 1.."},
        {"--steps 3", 2, "--steps: '3' is not a whole number in 4.."},
        {"--out ''", 2, "--out: no folder is named"},
        {"cloth", 2, "'cloth': options only"},
        {"--scene boxes --steps 4 --out /dev/null/o", 1, "/dev/null"},
    };
    EnterFolder();
    CheckMistakes(QC_BENCH_PROGRAM " stability", wrong, sizeof wrong / sizeof wrong[0]);
    ck_assert_int_eq(Run(QC_BENCH_PROGRAM " stability --help"), 0);
    // Whole lines.
    ck_assert_ptr_nonnull(strstr(GetOutput(), "40 pieces; --full: 5 000 triangles, 200 pieces\n"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "30 cells; --full: 250 000 triangles, 700 cells\n"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "--scene=NAME"));
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("bench stability", boxes_stay_where_they_stand, a_cloth_falls_without_a_penetrating_pair,
             a_tangle_that_is_not_resolved_fails, mistakes_are_refused_with_a_message)
