// The leaves demo as a user runs it: frames, a CSV with a row for each step, a table, a recording, and mistakes.
#define _POSIX_C_SOURCE 200809L
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <string.h>

#define LEAVES QC_LEAVES_PROGRAM

static const char s_header[] =
    "step,seconds,step_ms,hanging,kinetic_j,lowest_mm,method,device,detect_ms,respond_ms,contacts,penetrating_before,"
    "rounds,planes,zone_nodes,exempt,unproven,penetrating_after,cullide_pcs,cullide_found,cullide_missed,"
    "cullide_query_ms,quick_pcs,quick_found,quick_missed,quick_query_ms,quick_sorted_pcs,quick_sorted_found,"
    "quick_sorted_missed,quick_sorted_query_ms,quick_sorted_back_pcs,quick_sorted_back_found,"
    "quick_sorted_back_missed,quick_sorted_back_query_ms,sweep_pcs,sweep_found,sweep_missed,sweep_query_ms,auto_pcs,"
    "auto_found,auto_missed,auto_query_ms,layers_pcs,layers_found,layers_missed,layers_query_ms";

static void CheckStep(const Row* row, void* context)
{
    int* steps = context;
    ck_assert_double_eq(GetNumber(row, "step"), ++*steps);
    ck_assert_double_gt(GetNumber(row, "step_ms"), 0.0);
    ck_assert_double_eq(GetNumber(row, "hanging"), 20.0);
    ck_assert_double_gt(GetNumber(row, "lowest_mm"), 300.0);
    ck_assert_double_gt(GetNumber(row, "kinetic_j"), 0.0);
    ck_assert_double_eq(GetNumber(row, "penetrating_after"), 0.0);
    // A frame is every second step, and the last step.
    bool isFrame = *steps % 2 == 0 || *steps == 5;
    ck_assert_int_eq(Get(row, "sweep_found")[0] != 0, isFrame);
    if (isFrame)
        ck_assert_double_eq(GetNumber(row, "sweep_found"), 0.0);
}

START_TEST(each_step_has_a_row_and_nothing_penetrates)
{
    EnterFolder();
    ck_assert_msg(Run(LEAVES " --leaves 20 --steps 5 --frame-every 2 --device none --record r.qcr --out o") == 0, "%s",
                  GetErrors());
    int steps = 0;
    ck_assert_int_eq(ForEachRow("o/leaves.csv", s_header, CheckStep, &steps), 5);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "Leaves fall from a tree: 20 leaves of 2200 triangles in all"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "the whole step"));
    ck_assert_int_eq(Run("test $(ls o | wc -l) -eq 1 && test -s r.qcr"), 0);
    LeaveFolder();
}
END_TEST

START_TEST(frames_are_drawn_where_there_is_a_device)
{
    EnterFolder();
    int status = Run(LEAVES " --leaves 20 --steps 5 --frame-every 2 --resolution 64 --device osmesa --out o");
    if (status != 4)
    {
        ck_assert_msg(status == 0, "%s", GetErrors());
        ck_assert_int_eq(Run("test -s o/frame_0000.png && test -s o/frame_0001.png && test -s o/frame_0002.png"), 0);
        ck_assert_int_eq(Run("test $(ls o | wc -l) -eq 4"), 0);
    }
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    static const CommandMistake wrong[] = {
        {"--leafs 3", 2, "unrecognized option '--leafs'"}, {"--leaves 0", 2, "--leaves: '0' is not"},
        {"--pcs-every x", 2, "--pcs-every: 'x' is not"},   {"--record none/r.qcr", 1, "none/r.qcr"},
        {"--out file/o", 1, "file: Not a directory"},
    };
    EnterFolder();
    ck_assert_int_eq(Run("touch file"), 0);
    CheckMistakes(LEAVES " --device none --leaves 5 --steps 2", wrong, sizeof wrong / sizeof wrong[0]);
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("leaves demo", each_step_has_a_row_and_nothing_penetrates, frames_are_drawn_where_there_is_a_device,
             mistakes_are_refused_with_a_message)
