// The demos of Bullet as a user runs them: the tables add up, a body breaks once and keeps its momentum, pictures and
// CSV are there, mistakes are refused, a signal ends them with a table.
#define _POSIX_C_SOURCE 200809L
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CLOTH QC_CLOTH_PROGRAM
#define FRACTURE QC_FRACTURE_PROGRAM

enum
{
    qc_maxColumns = 8,
    qc_labelWidth = 48,
    qc_textSize = 1 << 18
};

//  ---- what a step costs -----------------------------------------------------------------------------

static const char* FindLine(const char* text, const char* part)
{
    const char* found = strstr(text, part);
    ck_assert_msg(found != NULL, "no '%s' in\n%s", part, text);
    while (found > text && found[-1] != '\n')
        --found;
    return found;
}

/// Reads the numbers after a label; returns their count.
static int ReadColumns(const char* line, double values[qc_maxColumns])
{
    int count = 0;
    size_t length = strcspn(line, "\n");
    const char* rest = line + (length < qc_labelWidth ? length : (size_t)qc_labelWidth);
    for (char* end; rest < line + length && count < qc_maxColumns; rest = end)
    {
        values[count] = strtod(rest, &end);
        ck_assert_msg(end != rest, "no number in '%.*s'", (int)length, line);
        ++count;
    }
    return count;
}

/// Every row of the breakdown is 0 or more, and all rows together are the step, in each column.
static void CheckCosts(void)
{
    double whole[qc_maxColumns], gathering[qc_maxColumns], share[qc_maxColumns], sum[qc_maxColumns] = {0.0};
    const char* end = FindLine(GetOutput(), "the whole step");
    int columns = ReadColumns(end, whole), rows = 0;
    ck_assert_int_ge(columns, 2);
    const char* line = strchr(FindLine(GetOutput(), "milliseconds of a step"), '\n') + 1;
    for (; line < end; line = strchr(line, '\n') + 1, ++rows)
    {
        double values[qc_maxColumns];
        ck_assert_int_eq(ReadColumns(line, values), columns);
        for (int i = 0; i < columns; ++i)
        {
            // Printed with two digits.
            ck_assert_msg(values[i] > -0.0051, "%.*s", (int)strcspn(line, "\n"), line);
            sum[i] += values[i];
        }
    }
    ck_assert_int_ge(rows, 8);
    ck_assert_int_eq(ReadColumns(FindLine(GetOutput(), "geometry gathered"), gathering), columns);
    ck_assert_int_eq(ReadColumns(FindLine(GetOutput(), "gathering, % of the step"), share), columns);
    for (int i = 0; i < columns; ++i)
    {
        ck_assert_double_gt(whole[i], 0.0);
        ck_assert_msg(fabs(sum[i] - whole[i]) <= 0.0051 * (rows + 1), "column %d: %g, not %g", i, sum[i], whole[i]);
        double error = 100.0 * 0.0051 * (1.0 + gathering[i] / whole[i]) / whole[i] + 0.051;
        ck_assert_double_le(fabs(share[i] - 100.0 * gathering[i] / whole[i]), error);
    }
}

START_TEST(the_costs_of_a_step_add_up_to_it)
{
    EnterFolder();
    ck_assert_int_eq(Run(CLOTH " --triangles 800 --steps 30 --pull-steps 20 --device none --out o"), 0);
    CheckCosts();
    // No column is named twice.
    ck_assert_int_eq(Run("head -n 1 o/cloth.csv | tr , '\\n' | sort | uniq -d | grep ."), 1);
    LeaveFolder();
}
END_TEST

//  ---- fracture --------------------------------------------------------------------------------------

/// A closed L, so that it is not convex.
static void WriteAngle(void)
{
    static const int outline[6][2] = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 4}, {0, 4}};
    FILE* stream = fopen("angle.obj", "w");
    ck_assert_ptr_nonnull(stream);
    for (int i = 0; i < 12; ++i)
        fprintf(stream, "v %d %d %d\n", outline[i % 6][0], outline[i % 6][1], i / 6);
    for (int i = 0; i < 6; ++i)
        fprintf(stream, "f %d %d %d %d\n", i + 1, i + 7, (i + 1) % 6 + 7, (i + 1) % 6 + 1);
    // Both faces are fans around the inner corner, from which all of them can be seen.
    fprintf(stream, "f 4 5 6 1 2 3\nf 10 9 8 7 12 11\n");
    ck_assert_int_eq(fclose(stream), 0);
}

static const char s_header[] =
    "step,seconds,step_ms,boxes_ms,pairs_ms,gather_ms,ahead_ms,cull_ms,sweep_ms,exact_ms,points_ms,"
    "other_query_ms,manifolds_ms,solver_ms,break_ms,rest_ms,method,bodies,awake,pairs,"
    "points,penetration_mm,lowest_mm,kinetic_j";

typedef struct Course
{
    int steps, breaks;
    double bodies, lowest, energy, energyAtBreak;
} Course;

static void CheckStep(const Row* row, void* context)
{
    static const char* const costs[] = {"boxes_ms",  "pairs_ms", "gather_ms", "ahead_ms",       "cull_ms",
                                        "sweep_ms",  "exact_ms", "points_ms", "other_query_ms", "manifolds_ms",
                                        "solver_ms", "break_ms", "rest_ms"};
    Course* course = context;
    const size_t count = sizeof costs / sizeof costs[0];
    double sum = 0.0;
    for (size_t i = 0; i < count; ++i)
    {
        ck_assert_msg(GetNumber(row, costs[i]) > -0.00051, "%s in step %s", costs[i], Get(row, "step"));
        sum += GetNumber(row, costs[i]);
    }
    ck_assert_double_le(fabs(sum - GetNumber(row, "step_ms")), 0.00051 * (double)(count + 1));
    bool breaks = GetNumber(row, "bodies") != course->bodies;
    ck_assert((GetNumber(row, "break_ms") > 0.0) == (breaks && course->steps > 0));
    ++course->steps;
    ck_assert_double_eq(GetNumber(row, "step"), course->steps);
    if (breaks && course->steps > 1)
    {
        ++course->breaks;
        course->energyAtBreak = GetNumber(row, "kinetic_j");
        // In that very step pieces lie on the floor and on each other.
        ck_assert_double_gt(GetNumber(row, "points"), GetNumber(row, "bodies"));
    }
    course->bodies = GetNumber(row, "bodies");
    course->lowest = fmin(course->lowest, GetNumber(row, "lowest_mm"));
    course->energy = GetNumber(row, "kinetic_j");
}

/// The last number of a line.
static double LastNumber(const char* line)
{
    size_t length = strcspn(line, "\n");
    while (length > 0 && line[length - 1] != ' ')
        --length;
    return strtod(line + length, NULL);
}

START_TEST(a_body_breaks_once_keeps_its_momentum_and_its_pieces_stay_above_the_floor)
{
    EnterFolder();
    WriteAngle();
    ck_assert_msg(Run(FRACTURE " --mesh angle.obj --pieces 12 --steps 300 --device none --out o/p") == 0, "%s",
                  GetErrors());
    CheckCosts();
    Course course = {.bodies = 1.0};
    ck_assert_int_eq(ForEachRow("o/p/fracture.csv", s_header, CheckStep, &course), 300);
    ck_assert_int_eq(course.breaks, 1);
    ck_assert_double_ge(course.bodies, 12.0);
    // At 4 m/s and steps of 1/240 s a piece moves less than 2 cm into the floor in a step. Millimetres.
    ck_assert_double_gt(course.lowest, -60.0);
    ck_assert_double_lt(course.energy, 0.5 * course.energyAtBreak);
    ck_assert_double_lt(LastNumber(FindLine(GetOutput(), "  momentum, kg m/s")), 1e-5);
    // Bullet keeps only the diagonal of a piece's tensor.
    ck_assert_double_lt(LastNumber(FindLine(GetOutput(), "  angular momentum, ")), 0.1);
    FindLine(GetOutput(), "It broke in step ");
    LeaveFolder();
}
END_TEST

/// Without the measured times.
static void KeepCourse(const Row* row, void* context)
{
    char* text = context;
    size_t length = strlen(text);
    snprintf(text + length, qc_textSize - length, "%s %s %s %s %s\n", Get(row, "bodies"), Get(row, "points"),
             Get(row, "penetration_mm"), Get(row, "lowest_mm"), Get(row, "kinetic_j"));
}

START_TEST(the_result_depends_on_the_seed_and_not_on_method_and_threads)
{
    static const char* const options[] = {"--seed 7 --threads 1", "--seed 7 --method sweep --threads 2", "--seed 8"};
    static char texts[3][qc_textSize];
    EnterFolder();
    WriteAngle();
    for (int i = 0; i < 3; ++i)
    {
        ck_assert_int_eq(Run(FRACTURE " --mesh angle.obj --pieces 5 --steps 130 --device none --out o %s", options[i]),
                         0);
        ForEachRow("o/fracture.csv", s_header, KeepCourse, texts[i]);
    }
    ck_assert_str_eq(texts[0], texts[1]);
    ck_assert_str_ne(texts[0], texts[2]);
    LeaveFolder();
}
END_TEST

START_TEST(pieces_from_a_file_move_as_those_that_were_saved)
{
    static const char* const options[] = {"--save p.qcp", "--load p.qcp"};
    static char texts[2][qc_textSize];
    EnterFolder();
    WriteAngle();
    for (int i = 0; i < 2; ++i)
    {
        ck_assert_msg(Run(FRACTURE " --mesh angle.obj --pieces 5 --steps 130 --device none --out o %s", options[i]) ==
                          0,
                      "%s", GetErrors());
        ForEachRow("o/fracture.csv", s_header, KeepCourse, texts[i]);
    }
    ck_assert_str_eq(texts[0], texts[1]);
    FindLine(GetOutput(), "It broke in step ");
    ck_assert_int_eq(Run("truncate -s -9 p.qcp && " FRACTURE " --mesh angle.obj --load p.qcp --device none --out o"),
                     3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "qcFracture_Load: p.qcp: the last record at byte "));
    ck_assert_int_eq(Run(FRACTURE " --mesh angle.obj --pieces 5 --steps 3 --save q.qcp --device none --out o"), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "nothing broke, and q.qcp was not written"));
    ck_assert_int_eq(Run(FRACTURE " --mesh angle.obj --load p.qcp --save q.qcp --device none --out o"), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "--save: nothing is cut with --load"));
    ck_assert_int_eq(Run(FRACTURE " --mesh angle.obj --save no/q.qcp --device none --out o"), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "qc-fracture: no/q.qcp: No such file or directory"));
    LeaveFolder();
}
END_TEST

/// Coarse grids make triangles twice of the bunny's ears, and qcFracture_Split refuses these.
START_TEST(a_mesh_breaks_however_coarse_it_is_made)
{
    static const char* const counts[] = {"100", "300", "700"};
    EnterFolder();
    for (int i = 0; i < 3 && QC_BUNNY[0] != 0; ++i)
        ck_assert_msg(Run(FRACTURE " --mesh " QC_BUNNY " --triangles %s --pieces 5 --precut --steps 1 --device none "
                                   "--out o",
                          counts[i]) == 0,
                      "%s", GetErrors());
    LeaveFolder();
}
END_TEST

START_TEST(frames_are_drawn_where_there_is_a_device)
{
    EnterFolder();
    WriteAngle();
    int status = Run(FRACTURE " --mesh angle.obj --pieces 3 --steps 5 --frame-every 2 --device osmesa --out o");
    if (status != 4)
    {
        ck_assert_int_eq(status, 0);
        ck_assert_int_eq(Run("test -s o/frame_0000.png && test -s o/frame_0001.png && test -s o/frame_0002.png"), 0);
        ck_assert_int_eq(Run("test $(ls o | wc -l) -eq 4"), 0);
    }
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    static const CommandMistake wrong[] = {
        {"--pices 3", 2, "unrecognized option '--pices'"},
        {"--pieces 0", 2, "--pieces: '0' is not a whole number in 1..10000"},
        {"--pieces 1e3", 2, "--pieces: '1e3' is not"},
        {"--steps=-1", 2, "--steps: '-1' is not"},
        {"--seed 4294967296", 2, "--seed: '4294967296' is not"},
        {"--triangles x", 2, "--triangles: 'x' is not"},
        {"--method quick", 2, "--method: 'quick' is not one of layers, auto, sweep"},
        {"--out ''", 2, "--out: no folder is named"},
        {"bunny.obj", 2, "'bunny.obj': options only"},
        {"--mesh none.obj", 3, "none.obj: No such file"},
        {"--mesh angle.obj --load none.qcp", 3, "none.qcp: it can't be opened: No such file"},
        {"--mesh open.obj", 3, "open.obj: the mesh is not closed"},
        {"--out angle.obj/o", 1, "angle.obj: Not a directory"},
    };
    EnterFolder();
    WriteAngle();
    WriteText("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    CheckMistakes(FRACTURE " --device none --steps 2", wrong, sizeof wrong / sizeof wrong[0]);
    ck_assert_int_eq(Run(CLOTH " --steps 0 --device none"), 2);
    ck_assert_int_eq(Run(FRACTURE " --help"), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "--pieces=N"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "out/fracture by default"));
    // Programs name themselves without their folder.
    ck_assert_int_eq(Run(FRACTURE " --pices 3"), 2);
    ck_assert_int_eq(strncmp(GetErrors(), "qc-fracture: ", 13), 0);
    ck_assert_int_eq(Run(CLOTH " --device none --out angle.obj"), 1);
    ck_assert_str_eq(GetErrors(), "qc-cloth: angle.obj: Not a directory\n");
    LeaveFolder();
}
END_TEST

START_TEST(what_can_not_be_printed_is_a_failure)
{
    static const char* const commands[] = {
        FRACTURE " --help",
        CLOTH " --version",
        CLOTH " --triangles 200 --steps 2 --pull-steps 0 --device none --out o",
        FRACTURE " --mesh angle.obj --pieces 3 --steps 2 --device none --out o",
    };
    EnterFolder();
    WriteAngle();
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; ++i)
    {
        ck_assert_int_eq(Run("%s >/dev/full", commands[i]), 1);
        ck_assert_ptr_nonnull(strstr(GetErrors(), "standard output: No space left on device"));
    }
    // The status of a mistake stays.
    ck_assert_int_eq(Run(FRACTURE " --pieces 0 >/dev/full"), 2);
    LeaveFolder();
}
END_TEST

START_TEST(a_signal_ends_them_with_a_table)
{
    EnterFolder();
    WriteAngle();
    // Not SIGINT, which background jobs of a shell ignore; and in the foreground, where timeout sends it once: the
    // second signal ends a demo at once.
    ck_assert_int_eq(Run("timeout --foreground --preserve-status -s TERM 2 " FRACTURE
                         " --mesh angle.obj --pieces 5 --steps 1000000 --device none --out o"),
                     128 + 15);
    FindLine(GetOutput(), "the whole step");
    FindLine(GetOutput(), "It broke in step ");
    ck_assert_int_eq(Run("test -s o/fracture.csv && test $(ls o | wc -l) -eq 1"), 0);
    ck_assert_int_eq(Run("timeout --foreground --preserve-status -s TERM 2 " CLOTH
                         " --triangles 200 --steps 1000000 --device none --out c"),
                     128 + 15);
    FindLine(GetOutput(), "the whole step");
    // The second run has not begun.
    ck_assert_ptr_null(strstr(GetOutput(), " off"));
    ck_assert_int_eq(Run("test -s c/cloth.csv && test $(ls c | wc -l) -eq 1"), 0);
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("demos", the_costs_of_a_step_add_up_to_it,
             a_body_breaks_once_keeps_its_momentum_and_its_pieces_stay_above_the_floor,
             the_result_depends_on_the_seed_and_not_on_method_and_threads,
             pieces_from_a_file_move_as_those_that_were_saved, a_mesh_breaks_however_coarse_it_is_made,
             frames_are_drawn_where_there_is_a_device, mistakes_are_refused_with_a_message,
             what_can_not_be_printed_is_a_failure, a_signal_ends_them_with_a_table)
