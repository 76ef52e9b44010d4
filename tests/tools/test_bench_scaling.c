// `qc-bench scaling` as a user runs it; and the exponent of times whose exponent is known.
#include "support/csv_rows.h"
#include "bench/scaling/scaling.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <math.h>
#include <string.h>

#define BENCH QC_BENCH_PROGRAM

START_TEST(the_exponent_is_that_of_the_times_from_20_k_to_1_m)
{
    static qcScalingTable table;
    for (uint32_t n = 1000; n <= 4096000; n *= 2)
    {
        // Sizes outside of the range, and other numbers of threads, are not used.
        bool inside = n > 19000 && n < 1050000;
        double ms = inside ? 0.001 * pow(n, 1.25) : 7.0;
        table.meshes[table.meshCount++] = (qcScalingMeshRow){.triangles = n, .threads = 1, .ms = ms};
        table.meshes[table.meshCount++] = (qcScalingMeshRow){.triangles = n, .threads = 2, .ms = sqrt(n)};
    }
    ck_assert_double_eq_tol(qcScaling_FindExponent(&table, 1), 1.25, 1e-9);
    ck_assert_double_eq_tol(qcScaling_FindExponent(&table, 2), 0.5, 1e-9);
    table.meshCount = 2 * 6; // one size in the range
    ck_assert(qcScaling_FindExponent(&table, 1) == 0.0);
}
END_TEST

static void CheckMesh(const Row* row, void* context)
{
    double* last = context;
    double triangles = GetNumber(row, "triangles"), sum = 0.0;
    ck_assert_double_gt(triangles, *last);
    *last = triangles;
    ck_assert(Is(row, "threads", "1"));
    ck_assert(GetNumber(row, "ms") >= GetNumber(row, "ms_least") && GetNumber(row, "ms_least") > 0.0);
    static const char* const stages[] = {"ms_vertices", "ms_objects", "ms_triangles", "ms_exact", "ms_other"};
    for (size_t i = 0; i < sizeof stages / sizeof stages[0]; ++i)
    {
        ck_assert(GetNumber(row, stages[i]) >= 0.0);
        sum += GetNumber(row, stages[i]);
    }
    ck_assert_double_gt(sum, 0.0);
    // Positions and indices alone take 24; more than 10000 would be no number of bytes.
    ck_assert(GetNumber(row, "bytes") > 24.0 && GetNumber(row, "bytes") < 1e4);
    ck_assert(GetNumber(row, "pairs") > 20.0 && GetNumber(row, "candidates") >= GetNumber(row, "pairs"));
}

static void CheckBoxes(const Row* row, void* context)
{
    int* rows = context;
    ++*rows;
    double boxes = GetNumber(row, "boxes"), percent = GetNumber(row, "percent"), moving = GetNumber(row, "moving");
    ck_assert(moving == floor(boxes * percent / 100.0));
    ck_assert((GetNumber(row, "pairs") > 0.0) == (percent > 1.0) || percent == 1.0);
    // Each overlaps about four others.
    if (percent == 100.0)
        ck_assert(GetNumber(row, "pairs") > boxes && GetNumber(row, "pairs") < 3.0 * boxes);
    ck_assert(GetNumber(row, "ms") >= GetNumber(row, "ms_least"));
}

START_TEST(each_size_has_its_rows)
{
    ck_assert_int_eq(Run("%s scaling --triangles 4000 --boxes 200 --threads 1 --out deep/er", BENCH), 0);
    double last = 0.0;
    int rows = 0;
    ck_assert_int_eq(ForEachRow("deep/er/scaling_meshes.csv",
                                "triangles,threads,steps,ms,ms_least,first_ms,second_ms,bytes,ms_vertices,ms_objects,"
                                "ms_triangles,ms_exact,ms_other,candidates,pairs",
                                CheckMesh, &last),
                     3);
    ck_assert_int_eq(ForEachRow("deep/er/scaling_boxes.csv",
                                "boxes,percent,moving,steps,ms,ms_least,add_ms,bytes,pairs", CheckBoxes, &rows),
                     8);
    if (Run("command -v gnuplot") == 0)
        ck_assert_int_eq(Run("test $(cat deep/er/scaling.png deep/er/scaling.svg 2>/dev/null | wc -c) -gt 10000"), 0);
}
END_TEST

START_TEST(a_signal_leaves_the_rows_so_far)
{
    ck_assert_int_eq(Run("timeout --foreground --preserve-status -s TERM 1 %s scaling --threads 1 --out .", BENCH),
                     128 + 15);
    ck_assert_int_eq(Run("test $(wc -l <scaling_meshes.csv) -gt 1 && test -s scaling_boxes.csv"), 0);
}
END_TEST

START_TEST(sizes_of_0_are_left_out)
{
    ck_assert_int_eq(Run("%s scaling --triangles 0 --boxes 100 --out .", BENCH), 0);
    ck_assert_ptr_null(strstr(GetOutput(), "triangles threads"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "boxes  moving"));
    ck_assert_ptr_null(strstr(GetErrors(), "arning"));
    ck_assert_int_eq(Run("%s scaling --triangles 1000 --boxes 0 --threads 2 --out .", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "triangles threads"));
    ck_assert_ptr_null(strstr(GetOutput(), "boxes  moving"));
    ck_assert_int_eq(Run("%s scaling --triangles 0 --boxes 0 --out .", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "nothing ran: no picture"));
}
END_TEST

int main(void)
{
    TCase* tcase = qcMakeCase("qc-bench scaling");
    tcase_add_checked_fixture(tcase, EnterFolder, LeaveFolder);
    tcase_add_test(tcase, the_exponent_is_that_of_the_times_from_20_k_to_1_m);
    tcase_add_test(tcase, each_size_has_its_rows);
    tcase_add_test(tcase, a_signal_leaves_the_rows_so_far);
    tcase_add_test(tcase, sizes_of_0_are_left_out);
    return qcRunCase("qc-bench scaling", tcase);
}
