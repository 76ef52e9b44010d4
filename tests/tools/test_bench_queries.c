// `qc-bench queries` as a user runs it: no hit is lost, batches agree with single calls, each row is written.
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <string.h>

#define PROGRAM QC_BENCH_PROGRAM " queries"

static void CheckRow(const Row* row, void* context)
{
    ck_assert(Is(row, "mesh", "hills-5k") && Is(row, "triangles", "5000"));
    ck_assert(Is(row, "lost", "0") && Is(row, "differ", "0"));
    ck_assert_double_gt(GetNumber(row, "queries"), 10.0);
    ck_assert_double_gt(GetNumber(row, "ours us"), 0.0);
    ck_assert_double_gt(GetNumber(row, "bullet us"), 0.0);
    bool misses = strstr(Get(row, "query"), "no hit") != NULL;
    ck_assert_int_eq(GetNumber(row, "hits") == 0.0, misses);
    ++*(int*)context;
}

static void CheckBatch(const Row* row, void* context)
{
    ck_assert(Is(row, "same", "1"));
    ck_assert_double_gt(GetNumber(row, "batch us"), 0.0);
    *(double*)context += GetNumber(row, "threads");
}

START_TEST(no_hit_is_lost_and_batches_agree_with_single_calls)
{
    EnterFolder();
    ck_assert_msg(Run(PROGRAM " --mesh hills-5k --budget 2 --threads 1,3 --out o") == 0, "%s", GetErrors());
    int rows = 0;
    ck_assert_int_eq(ForEachRow("o/queries.csv",
                                "mesh,triangles,query,ours us,bullet us,ratio,hits,queries,differ,lost", CheckRow,
                                &rows),
                     14);
    ck_assert_int_eq(rows, 14);
    double threads = 0.0;
    ck_assert_int_eq(
        ForEachRow("o/queries_batches.csv", "mesh,query,queries,threads,single us,batch us,same", CheckBatch, &threads),
        8);
    ck_assert_double_eq(threads, 4 * (1 + 3));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "ray 60 m, all hits"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "3 threads"));
    LeaveFolder();
}
END_TEST

START_TEST(a_signal_leaves_the_rows_so_far)
{
    EnterFolder();
    ck_assert_int_eq(
        Run("timeout --foreground --preserve-status -s TERM 2 " PROGRAM " --mesh hills-5k --budget 1000 --out o"),
        128 + 15);
    ck_assert_int_eq(Run("test $(wc -l <o/queries.csv) -gt 1 && test -s o/queries_batches.csv"), 0);
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    static const CommandMistake wrong[] = {
        {"--mesh hills-6k", 2, "--mesh: 'hills-6k' is not one of hills-5k, bunny-70k, hills-500k"},
        {"--budget 0", 2, "--budget: '0' is not a whole number in 1..100000"},
        {"--threads 0", 2, "--threads: '0' is not"},
        {"--out ''", 2, "--out: no folder is named"},
        {"--meshes hills-5k", 2, "unrecognized option '--meshes'"},
        {"hills-5k", 2, "'hills-5k': options only"},
        {"--mesh hills-5k --budget 1 --out /dev/null/o", 1, "/dev/null: Not a directory"},
    };
    EnterFolder();
    CheckMistakes(PROGRAM, wrong, sizeof wrong / sizeof wrong[0]);
    ck_assert_int_eq(Run(PROGRAM " --help"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "--mesh=NAME"));
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("bench queries", no_hit_is_lost_and_batches_agree_with_single_calls, a_signal_leaves_the_rows_so_far,
             mistakes_are_refused_with_a_message)
