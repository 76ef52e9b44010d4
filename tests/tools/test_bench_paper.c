// qc-bench paper as a user runs it: on a recording whose pairs are known, without one, and on a damaged one.
#include "support/check_ok.h"
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <quickcullide/quickcullide.h>

#include <stdio.h>
#include <string.h>

#define BENCH QC_BENCH_PROGRAM
#define HEADER "scene,frame,method,views,resolution,rounds,pcs,ms,exact,found,missed"

enum
{
    qc_frames = 6
};

static const uint32_t s_indices[6] = {0, 1, 2, 3, 4, 5};
// Two triangles side by side in the plane z = 0, and a steep one for each that crosses it.
static const float s_flat[18] = {0, 0, 0, 4, 0, 0, 0, 4, 0, 10, 0, 0, 14, 0, 0, 10, 4, 0};
static const float s_steep[18] = {1, 1, -1, 1.3f, 1.8f, 1, 2, 1, 1, 11, 1, -1, 11.3f, 1.8f, 1, 12, 1, 1};

static qcBodyId Add(qcScene* scene, const float* positions, uint32_t triangles, bool deforming)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = positions;
    def.vertexCount = 3 * triangles;
    def.indices = s_indices;
    def.triangleCount = triangles;
    def.deforming = deforming;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    return id;
}

/// The number of pairs of each frame: a steep body sinks into the flat one, a second one comes, the first one goes.
static const double s_pairs[qc_frames] = {0, 0, 2, 2, 3, 1};

static void MakeRecording(const char* path)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene;
    CHECK_OK(qcScene_Create(&sceneDef, &scene));
    CHECK_OK(qcScene_Record(scene, path));
    Add(scene, s_flat, 2, false);
    qcBodyId first = Add(scene, s_steep, 2, true);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    strcpy(def.views, "z");
    def.iterations = 1;
    for (int frame = 0; frame < qc_frames; ++frame)
    {
        float positions[18];
        for (int i = 0; i < 18; ++i)
            positions[i] = s_steep[i] + (i % 3 == 2 && frame < 2 ? 3.0f : 0.01f * (float)frame);
        if (frame < 5)
            CHECK_OK(qcScene_SetVertices(scene, first, positions, qc_positionF32, 0));
        if (frame == 4)
            Add(scene, s_steep + 9, 1, false);
        if (frame == 5)
            CHECK_OK(qcScene_RemoveBody(scene, first));
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_double_eq((double)result->pairCount, s_pairs[frame]);
    }
    CHECK_OK(qcScene_Record(scene, NULL));
    qcScene_Destroy(scene);
}

typedef struct Seen
{
    int sampled, exact;
} Seen;

static void CheckRow(const Row* row, void* context)
{
    Seen* seen = context;
    int frame = (int)GetNumber(row, "frame");
    double pairs = s_pairs[frame];
    ck_assert(Is(row, "scene", "cloth") && Is(row, "views", "z") && Is(row, "rounds", "1"));
    ck_assert_double_eq(GetNumber(row, "exact"), pairs);
    ck_assert_double_eq(GetNumber(row, "found") + GetNumber(row, "missed"), pairs);
    ck_assert_double_gt(GetNumber(row, "ms"), 0.0);
    bool sampled = strstr(Get(row, "method"), "quick") != NULL || Is(row, "method", "cullide");
    seen->sampled += sampled;
    seen->exact += !sampled;
    if (!sampled)
        ck_assert_double_eq(GetNumber(row, "missed"), 0.0);
    else
        ck_assert_double_eq(GetNumber(row, "resolution"), 64.0);
}

START_TEST(each_method_has_a_row_for_each_of_its_frames)
{
    MakeRecording("cloth.qcr");
    ck_assert_int_eq(
        Run("%s paper --recordings . --parts cloth --frames 2 --resolution 64 --iterations 1 --rounds 2 --out o",
            BENCH),
        0);
    Seen seen = {0, 0};
    ForEachRow("o/paper.csv", HEADER, CheckRow, &seen);
    // Four sampled methods, if there is GL; sweep and auto, layers where there is GL, Embree if it is built in.
    ck_assert(seen.sampled == 4 * 2 || strstr(GetOutput(), "device: none") != NULL);
    ck_assert(seen.exact % qc_frames == 0 && seen.exact >= 2 * qc_frames && seen.exact <= 4 * qc_frames);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "210    1340  0.157 |      2"));
    if (Run("command -v gnuplot") == 0)
        ck_assert_int_eq(Run("test -s o/paper_pcs_cloth.png -a -s o/paper_ms_cloth.png -o -s o/paper_pcs_cloth.svg"),
                         0);

    ck_assert_int_eq(
        Run("%s paper --recordings . --parts cloth --frames all --iterations 1 --device none --out p", BENCH), 0);
    seen = (Seen){0, 0};
    ForEachRow("p/paper.csv", HEADER, CheckRow, &seen);
    ck_assert(seen.sampled == 0 && seen.exact >= 2 * qc_frames);
}
END_TEST

START_TEST(a_missing_recording_is_skipped_with_the_command_that_makes_it)
{
    MakeRecording("cloth.qcr");
    ck_assert_int_eq(Run("%s paper --recordings . --parts cloth,leaves --device none --out o", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "leaves is skipped: there is no ./leaves.qcr; \"qc-leaves --record"));
    // The cloth's one command makes both recordings.
    ck_assert_int_eq(Run("%s paper --recordings . --parts cloth,cloth-without --device none --out o", BENCH), 0);
    ck_assert_ptr_nonnull(
        strstr(GetOutput(), "there is no ./cloth_without.qcr; \"qc-cloth --record ./cloth.qcr\" makes it"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "Cloth over a table"));
    ck_assert_int_eq(Run("%s paper --recordings nowhere --device none --out o", BENCH), 3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "no recording was found"));
    // The factors have the recording of cloth-without, which is named once.
    ck_assert_int_eq(Run("%s paper --recordings nowhere --out o", BENCH), 3);
    const char* line = strstr(GetOutput(), "cloth-without is skipped");
    ck_assert_ptr_nonnull(line);
    ck_assert_ptr_null(strstr(line + 1, "cloth-without is skipped"));
}
END_TEST

START_TEST(a_damaged_recording_is_refused_by_name)
{
    MakeRecording("whole.qcr");
    ck_assert_int_eq(Run("head -c 700 whole.qcr > cloth.qcr"), 0);
    ck_assert_int_eq(Run("%s paper --recordings . --parts cloth --device none --out o", BENCH), 3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "./cloth.qcr"));
    WriteText("cloth.qcr", "no recording");
    ck_assert_int_eq(Run("%s paper --recordings . --parts cloth --device none --out o", BENCH), 3);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "./cloth.qcr"));
}
END_TEST

START_TEST(a_mistake_on_the_command_line_is_named)
{
    ck_assert_int_eq(Run("%s paper --parts clot", BENCH), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "clot"));
    ck_assert_int_eq(Run("%s paper --frames some", BENCH), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "--frames"));
}
END_TEST

int main(void)
{
    TCase* tcase = qcMakeCase("qc-bench paper");
    tcase_add_checked_fixture(tcase, EnterFolder, LeaveFolder);
    tcase_add_test(tcase, each_method_has_a_row_for_each_of_its_frames);
    tcase_add_test(tcase, a_missing_recording_is_skipped_with_the_command_that_makes_it);
    tcase_add_test(tcase, a_damaged_recording_is_refused_by_name);
    tcase_add_test(tcase, a_mistake_on_the_command_line_is_named);
    return qcRunCase("qc-bench paper", tcase);
}
