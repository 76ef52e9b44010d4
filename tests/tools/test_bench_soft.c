// `qc-bench soft --demos` as a user runs it.
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>

#define BENCH QC_BENCH_PROGRAM

static void CheckRow(const Row* row, void* context)
{
    int* rows = context;
    ++*rows;
    ck_assert(GetNumber(row, "nodes") > 100.0);
    double bullet = GetNumber(row, "bullet_ms");
    ck_assert(bullet > 0.0);
    ck_assert_double_eq_tol(GetNumber(row, "ratio"), GetNumber(row, "ms") / bullet, 1e-4 * GetNumber(row, "ratio"));
    ck_assert_double_eq_tol(GetNumber(row, "like_bullet_ratio"), GetNumber(row, "like_bullet_ms") / bullet,
                            1e-4 * GetNumber(row, "like_bullet_ratio"));
    // No scene begins tangled.
    ck_assert(Is(row, "pairs", "0"));
}

START_TEST(each_small_scene_has_its_row_and_no_penetrating_pairs)
{
    ck_assert_int_eq(Run("%s soft --demos --steps 12 --out deep/er", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "50 flyers in the wind"));
    ck_assert_int_eq(Run("test -e deep/er/soft.csv"), 1);
    int rows = 0;
    ck_assert_int_eq(ForEachRow("deep/er/soft_demos.csv",
                                "scene,nodes,bullet_ms,ms,ratio,like_bullet_ms,like_bullet_ratio,bullet_pairs,pairs,"
                                "like_bullet_pairs",
                                CheckRow, &rows),
                     15);
    ck_assert_int_eq(rows, 15);
}
END_TEST

START_TEST(a_signal_leaves_the_rows_so_far)
{
    ck_assert_int_eq(Run("timeout --foreground --preserve-status -s TERM 2 %s soft --demos --steps 600 --out .", BENCH),
                     128 + 15);
    ck_assert_int_eq(Run("test $(wc -l <soft_demos.csv) -gt 1"), 0);
    ck_assert_int_eq(Run("timeout --foreground --preserve-status -s TERM 1 %s soft --out .", BENCH), 128 + 15);
    ck_assert_int_eq(Run("test -s soft.csv"), 0);
}
END_TEST

START_TEST(mistakes_are_named)
{
    ck_assert_int_ne(Run("%s soft --demos --steps 0", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "steps"));
    ck_assert_int_eq(Run("touch file; %s soft --demos --out file/in", BENCH), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "file"));
}
END_TEST

int main(void)
{
    TCase* tcase = qcMakeCase("qc-bench soft");
    tcase_add_checked_fixture(tcase, EnterFolder, LeaveFolder);
    tcase_add_test(tcase, each_small_scene_has_its_row_and_no_penetrating_pairs);
    tcase_add_test(tcase, a_signal_leaves_the_rows_so_far);
    tcase_add_test(tcase, mistakes_are_named);
    return qcRunCase("qc-bench soft", tcase);
}
