// `qc-bench first` as a user runs it: the columns agree with each other, mistakes are refused.
#include "common/options.h"
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <string.h>

#define BENCH QC_BENCH_PROGRAM

static const char s_header[] =
    "scene,triangles,threads,add_ms,first_ms,second_ms,third_ms,longest_ms,steady_ms,new_ms,embree_ms,"
    "embree_of_first,embree_of_two,embree_of_new,first_of_steady,pairs,agrees";

static void CheckRatio(const Row* row, const char* ratio, double a, double b)
{
    ck_assert_double_eq_tol(GetNumber(row, ratio), a / b, 0.01 * (1.0 + a / b));
}

static void CheckRow(const Row* row, void* context)
{
    double* pairs = context;
    double first = GetNumber(row, "first_ms"), second = GetNumber(row, "second_ms");
    ck_assert(Is(row, "scene", "cloth-1k") && Is(row, "triangles", "968") && Is(row, "agrees", "1"));
    ck_assert(first > 0.0 && second > 0.0 && GetNumber(row, "steady_ms") > 0.0 && GetNumber(row, "new_ms") > 0.0);
    ck_assert_double_gt(GetNumber(row, "pairs"), 20.0);
    ck_assert(*pairs == 0.0 || GetNumber(row, "pairs") == *pairs);
    *pairs = GetNumber(row, "pairs");
    // With one life each is its own median.
    ck_assert_double_ge(GetNumber(row, "longest_ms"), second);
    ck_assert_double_ge(GetNumber(row, "longest_ms"), GetNumber(row, "third_ms"));
    if (strstr(GetOutput(), "without Embree") != NULL)
    {
        ck_assert(Is(row, "embree_ms", "") && Is(row, "embree_of_first", "") && Is(row, "embree_of_two", ""));
        ck_assert(Is(row, "embree_of_new", ""));
    }
    else
    {
        double embree = GetNumber(row, "embree_ms");
        ck_assert_double_gt(embree, 0.0);
        CheckRatio(row, "embree_of_first", embree, first);
        CheckRatio(row, "embree_of_two", 2.0 * embree, first + second);
        CheckRatio(row, "embree_of_new", embree, GetNumber(row, "new_ms"));
    }
    CheckRatio(row, "first_of_steady", first, GetNumber(row, "steady_ms"));
}

START_TEST(each_step_of_a_life_finds_the_pairs_that_others_find)
{
    double pairs = 0.0;
    ck_assert_int_eq(Run("%s first --scenes cloth-1k --steps 40 --rounds 1 --out deep/er", BENCH), 0);
    ck_assert_int_eq(ForEachRow("deep/er/first.csv", s_header, CheckRow, &pairs), 2);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "cloth-1k"));
    ck_assert_ptr_null(strstr(GetOutput(), "DIFFERENT"));
}
END_TEST

START_TEST(without_embree_our_own_steps_are_measured)
{
    ck_assert_int_eq(
        Run("cp %s qc-bench && ./qc-bench first --scenes cloth-1k --threads 1 --steps 4 --rounds 2 --out .", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "without Embree: its package libembree-dev was not there"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "|                 -      -      -\n"));
    double pairs = 0.0;
    ck_assert_int_eq(ForEachRow("first.csv", s_header, CheckRow, &pairs), 1);
}
END_TEST

START_TEST(a_missing_model_is_skipped)
{
    ck_assert_int_eq(Run("%s first --scenes dragon --out .", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "dragon is skipped: --dragon names no file"));
}
END_TEST

START_TEST(all_are_the_words_below_the_count_and_others_have_to_be_named)
{
    static const struct
    {
        const char* argument;
        bool marks[3];
    } lists[] = {{"--names=all", {true, true, false}},
                 {"--names=vast", {false, false, true}},
                 {"--names=all,vast", {true, true, true}},
                 {"", {true, true, false}}};
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i)
    {
        const qcWord words[] = {{"all", -1}, {"small", 0}, {"large", 1}, {"vast", 2}, {NULL, 0}};
        bool marks[3] = {false};
        const qcOption rows[] = {{1, "names", "LIST", "", qcOption_Marks(marks, 2, words)}, {0}};
        qcCommandLine line = {.options = rows, .help = ""};
        // The words of a list are separated in place.
        char program[] = "program", argument[32] = "";
        char* arguments[] = {program, argument, NULL};
        strcpy(argument, lists[i].argument);
        qcCommandLine_Parse(&line, argument[0] != 0 ? 2 : 1, arguments);
        ck_assert_mem_eq(marks, lists[i].marks, sizeof marks);
    }
}
END_TEST

START_TEST(a_mistake_is_refused_with_a_message_that_names_it)
{
    static const CommandMistake wrong[] = {
        {"cloth", 2, "'cloth': options only"},
        {"--scenes cloth", 2, "--scenes: 'cloth' is not one of all, cloth-1k, cloth-20k,"},
        {"--threads 0", 2, "--threads: '0' is not a whole number in 1..1024"},
        {"--steps 3", 2, "--steps: '3' is not a whole number in 4..64"},
        {"--rounds 17", 2, "--rounds: '17' is not a whole number in 1..16"},
        {"--out ''", 2, "--out: no folder is named"},
        {"--out file/below", 1, "file: Not a directory"},
    };
    WriteText("file", "no mesh");
    CheckMistakes(BENCH " first", wrong, sizeof wrong / sizeof wrong[0]);
}
END_TEST

START_TEST(a_file_that_is_no_mesh_or_missing_is_named)
{
    WriteText("file", "no mesh");
    ck_assert_int_eq(Run("%s first --scenes dragon --dragon none.ply --out .", BENCH), 3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "none.ply"));
    ck_assert_int_eq(Run("%s first --scenes bunny --bunny none.obj --out .", BENCH), 3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "none.obj"));
    ck_assert_int_eq(Run("%s first --scenes bunny --bunny file --out .", BENCH), 3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "file"));
}
END_TEST

int main(void)
{
    TCase* tcase = qcMakeCase("qc-bench first");
    tcase_add_checked_fixture(tcase, EnterFolder, LeaveFolder);
    tcase_add_test(tcase, each_step_of_a_life_finds_the_pairs_that_others_find);
    tcase_add_test(tcase, without_embree_our_own_steps_are_measured);
    tcase_add_test(tcase, all_are_the_words_below_the_count_and_others_have_to_be_named);
    tcase_add_test(tcase, a_missing_model_is_skipped);
    tcase_add_test(tcase, a_mistake_is_refused_with_a_message_that_names_it);
    tcase_add_test(tcase, a_file_that_is_no_mesh_or_missing_is_named);
    return qcRunCase("qc-bench first", tcase);
}
