// `qc-bench gpu` as a user runs it, on any device of this machine; and the comparison of lists of pairs.
#include "support/csv_rows.h"
#include "bench/gpu/gpu.h"
#include "support/run_program.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <check.h>
#include <string.h>

#define BENCH QC_BENCH_PROGRAM

/// False, and a line of output, where no device opens with these options; a failure where one is required.
static bool HasDevice(const char* options)
{
    int status = Run("%s gpu --triangles 0 --out head %s", BENCH, options);
    ck_assert_msg(status == 0 || status == 4, "%s", GetErrors());
    const char* required = getenv("QC_TEST_DEVICES");
    ck_assert_msg(status == 0 || options[0] != 0 || required == NULL || required[0] == 0, "%s", GetErrors());
    if (status != 0)
        printf("skipped: %s", GetErrors());
    return status == 0;
}

static bool IsSoftware(void)
{
    return strstr(GetOutput(), ", software\n") != NULL;
}

/// Whether layers makes an image. Call it after a run.
static bool HasImage(void)
{
    const char* refiner = getenv("QC_LAYERS_REFINE");
    return refiner != NULL ? strcmp(refiner, "processor") == 0 : IsSoftware();
}

START_TEST(lists_agree_only_if_all_frames_and_all_steps_do)
{
    qcGpuRow row = {.runCount = 3};
    for (int i = 0; i < 3; ++i)
        row.runs[i] = (qcGpuRun){.hashes = {5, 6, 7, 8}, .steady = true};
    ck_assert(qcGpuRow_Agrees(&row));
    row.runs[2].hashes[3] = 9;
    ck_assert(!qcGpuRow_Agrees(&row));
    row.runs[2].hashes[3] = 8;
    row.runs[0].steady = false;
    ck_assert(!qcGpuRow_Agrees(&row));
    row.runs[0].steady = true;
    ck_assert(qcGpuRow_Agrees(&row));
}
END_TEST

typedef struct Rows
{
    bool haveImage; ///< of layers: it is made for software GL alone
    char hash[128]; ///< of the row of layers
} Rows;

static void CheckRow(const Row* row, void* context)
{
    Rows* rows = context;
    char* hash = rows->hash;
    bool layers = Is(row, "method", "layers");
    ck_assert(layers || Is(row, "method", "auto") || Is(row, "method", "sweep"));
    ck_assert(GetNumber(row, "ms") >= GetNumber(row, "ms_least") && GetNumber(row, "ms_least") > 0.0);
    ck_assert_double_ge(GetNumber(row, "steps"), 8.0);
    if (!Is(row, "method", "auto"))
        ck_assert_double_eq(GetNumber(row, "device_steps"), layers ? GetNumber(row, "steps") : 0.0);
    ck_assert_double_gt(GetNumber(row, "pairs"), 20.0);
    ck_assert(GetNumber(row, "candidates") >= GetNumber(row, "pairs"));
    ck_assert((GetNumber(row, "entries") > 0.0) == (layers && rows->haveImage));
    ck_assert((GetNumber(row, "device_bytes") > 0.0) == layers);
    ck_assert(Is(row, "agrees", "1") && Is(row, "failure", "\"\""));
    ck_assert_double_eq(GetNumber(row, "waits"), layers ? 1.0 : 0.0);
    ck_assert_double_le(GetNumber(row, "gl_calls"), 20.0);
    ck_assert((GetNumber(row, "gl_calls") > 0.0) == layers && (GetNumber(row, "processor_ms") > 0.0) == layers);
    // Where threads share the work, their buffers grow in some later step.
    if (layers && GetNumber(row, "threads") == 1.0)
        ck_assert_double_eq(GetNumber(row, "allocations"), 0.0);
    // Layers stand first.
    if (layers)
        strcpy(hash, Get(row, "hash"));
    ck_assert_uint_eq(strlen(hash), 4 * 16 + 3);
    ck_assert_str_eq(hash, Get(row, "hash"));
}

#define HEADER                                                                                                         \
    "scene,bodies,triangles,method,threads,steps,device_steps,ms,ms_least,first_ms,candidates,pairs,hash,agrees,"      \
    "entries,uploaded_bytes,device_bytes,gl_calls,waits,allocations,processor_ms,failure,renderer"

START_TEST(each_scene_and_size_has_its_rows_with_equal_lists)
{
    if (!HasDevice(""))
        return;
    ck_assert_int_eq(Run("%s gpu --triangles 6000 --threads 2 --out deep/er", BENCH), 0);
    Rows rows = {.haveImage = HasImage()};
    // Four scenes in two sizes, three in one; four runs each.
    ck_assert_int_eq(ForEachRow("deep/er/gpu.csv", HEADER, CheckRow, &rows), (4 * 2 + 3) * 4);
    ck_assert_ptr_null(strstr(GetOutput(), "DIFFERENT"));
    // Software GL is named.
    ck_assert((strstr(GetOutput(), "*** THIS IS NO GPU. ") != NULL) == IsSoftware());
    static char s_text[1 << 18];
    ck_assert(ReadText("deep/er/gpu.txt", s_text, sizeof s_text));
    ck_assert_int_eq(strncmp(s_text, "device: ", 8), 0);
    ck_assert_ptr_nonnull(strstr(s_text, "\npile: "));
    ck_assert((strstr(s_text, "*** THIS IS NO GPU. ") != NULL) == IsSoftware());
}
END_TEST

typedef struct Stages
{
    int refinements, kernels, vertices; ///< rows in which the stage ran
} Stages;

static void CheckStage(const Row* row, void* context)
{
    static const char* const columns[] = {"thread_ms", "device_ms"};
    Stages* stages = context;
    for (int i = 0; i < 2; ++i)
        ck_assert(Is(row, columns[i], "n/a") || GetNumber(row, columns[i]) >= 0.0);
    bool ran = !Is(row, "thread_ms", "n/a");
    stages->refinements += ran && Is(row, "stage", "pair tests");
    stages->vertices += ran && Is(row, "stage", "vertices");
    stages->kernels += ran && Is(row, "stage", "nodes");
    ck_assert_msg(ran || Is(row, "device_ms", "n/a"), "%s ran on the device alone", Get(row, "stage"));
}

START_TEST(each_kernel_has_its_times_where_it_runs)
{
    if (!HasDevice(""))
        return;
    Stages all = {0}, image = {0};
    ck_assert_int_eq(
        Run("QC_LAYERS_REFINE=device %s gpu --scenes cloth,pile --triangles 1000 --threads 1 --out all", BENCH), 0);
    ck_assert_int_eq(ForEachRow("all/gpu_stages.csv", "scene,triangles,stage,thread_ms,device_ms", CheckStage, &all),
                     2 * 19);
    ck_assert_int_eq(Run("QC_LAYERS_REFINE=processor %s gpu --scenes cloth,pile --triangles 1000 --threads 1 "
                         "--out image",
                         BENCH),
                     0);
    ForEachRow("image/gpu_stages.csv", "scene,triangles,stage,thread_ms,device_ms", CheckStage, &image);
    ck_assert(all.refinements == 2 && image.refinements == 0);
    ck_assert(all.kernels == 2 && image.kernels == 2);
    // All vertices come into the frame there; for the image alone, those of rigid bodies.
    ck_assert(all.vertices == 2 && image.vertices == 1);
    // On one thread there is one sweep.
    Rows rows = {.haveImage = false};
    ck_assert_int_eq(ForEachRow("all/gpu.csv", HEADER, CheckRow, &rows), 2 * 3);
}
END_TEST

START_TEST(too_few_triangles_for_all_scenes_are_refused)
{
    ck_assert_int_eq(Run("%s gpu --scenes cloth,tangle-92k --triangles 500 --out small", BENCH), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "none of the scenes has at most 500 triangles (--triangles)"));
}
END_TEST

START_TEST(scenes_without_their_files_are_skipped)
{
    if (!HasDevice(""))
        return;
    ck_assert_int_eq(Run("%s gpu --scenes dragon,paper-cloth --recordings nowhere", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "\ndragon is skipped: --dragon names no file"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "\npaper-cloth is skipped: there is no nowhere/cloth.qcr"));
    ck_assert_int_eq(Run("%s gpu --scenes bunnies-27 --bunny nowhere", BENCH), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "nowhere"));
    WriteText("cloth.qcr", "no recording");
    ck_assert_int_eq(Run("%s gpu --scenes paper-cloth --recordings .", BENCH), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "./cloth.qcr"));
}
END_TEST

/// Ten frames of a deforming cloth and rigid soups; one of these is added before frame `added`.
static void Record(const char* path, int added)
{
    qcSoup cloth = qcSoup_MakeFoldedCloth(3, 14, 0.02, 0.02), soup = qcSoup_MakeRandom(5, 300, 0.1);
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = qcBodyDefOf(&cloth);
    def.deforming = true;
    qcBodyId id, rigid = qcAddSoup(scene, &soup);
    const qcResult* result;
    const qcDetectDef plain = qcDefaultDetectDef();
    ck_assert_int_eq(qcScene_AddBody(scene, &def, &id), qc_statusOk);
    ck_assert_int_eq(qcScene_Record(scene, path), qc_statusOk);
    for (int frame = 0; frame < 10; ++frame)
    {
        qcTransform transform = qcIdentityTransform();
        transform.translation[0] = 0.01 * frame;
        cloth.positions[3 * frame] += 0.01;
        if (frame == added)
            qcAddSoup(scene, &soup);
        ck_assert_int_eq(qcScene_SetTransform(scene, rigid, &transform), qc_statusOk);
        ck_assert_int_eq(qcScene_SetVertices(scene, id, cloth.positions, qc_positionF64, 0), qc_statusOk);
        ck_assert_int_eq(qcScene_Detect(scene, &plain, &result), qc_statusOk);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&cloth);
    qcSoup_Free(&soup);
}

static void CheckRecordedRow(const Row* row, void* bodies)
{
    ck_assert_double_eq(GetNumber(row, "bodies"), *(const double*)bodies);
    ck_assert_double_gt(GetNumber(row, "pairs"), 20.0);
    ck_assert(Is(row, "agrees", "1") && Is(row, "failure", "\"\""));
}

START_TEST(frames_from_the_middle_of_a_recording_are_measured)
{
    if (!HasDevice(""))
        return;
    double bodies = 2.0;
    Record("leaves.qcr", 9);
    ck_assert_int_eq(Run("%s gpu --scenes paper-leaves --recordings . --threads 1 --out out", BENCH), 0);
    ck_assert_int_eq(ForEachRow("out/gpu.csv", HEADER, CheckRecordedRow, &bodies), 3);
    // The frames begin anew with a new body.
    Record("leaves.qcr", 6);
    bodies = 3.0;
    ck_assert_int_eq(Run("%s gpu --scenes paper-leaves --recordings . --threads 1 --out out", BENCH), 0);
    ck_assert_int_eq(ForEachRow("out/gpu.csv", HEADER, CheckRecordedRow, &bodies), 3);
    Record("leaves.qcr", 7);
    ck_assert_int_eq(Run("%s gpu --scenes paper-leaves --recordings . --threads 1 --out out", BENCH), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "no 4 frames with the same bodies"));
}
END_TEST

START_TEST(a_device_that_does_not_work_is_a_clear_error)
{
    ck_assert_int_eq(Run("__EGL_VENDOR_LIBRARY_DIRS=/nowhere __EGL_VENDOR_LIBRARY_FILENAMES= "
                         "%s gpu --device surfaceless --out new",
                         BENCH),
                     4);
    ck_assert_int_eq(strncmp(GetErrors(), "qc-bench gpu: device surfaceless: ", 34), 0);
    ck_assert_str_eq(GetOutput(), "");
    ck_assert_int_eq(Run("%s gpu --gpu 'no such GPU' --out new", BENCH), 4);
    ck_assert_int_eq(strncmp(GetErrors(), "qc-bench gpu: device egl: ", 26), 0);
    ck_assert_int_eq(Run("test -e new/gpu.csv"), 1);
    if (!HasDevice("--device osmesa"))
        return;
    // Below GL 4.3.
    ck_assert_int_eq(Run("MESA_GL_VERSION_OVERRIDE=4.2 %s gpu --device osmesa --out new", BENCH), 4);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "compute shaders"));
    ck_assert_int_eq(Run("test -e new/gpu.csv"), 1);
}
END_TEST

START_TEST(mistakes_are_refused_before_anything_is_measured)
{
    static const char* const mistakes[] = {
        "--scenes clot", "--triangles -1", "--device none",           "--device gpu", "--threads 0",
        "--gpu ''",      "cloth",          "--device osmesa --gpu 0", "--out ''"};
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; ++i)
    {
        ck_assert_msg(Run("%s gpu %s", BENCH, mistakes[i]) == 2, "%s: %s", mistakes[i], GetErrors());
        ck_assert_int_eq(strncmp(GetErrors(), "qc-bench gpu: ", 14), 0);
        ck_assert_uint_eq(CountEntries(), 0);
    }
    WriteText("file", "");
    ck_assert_int_eq(Run("%s gpu --out file/below", BENCH), 1);
}
END_TEST

START_TEST(a_run_that_is_ended_keeps_its_rows)
{
    if (!HasDevice(""))
        return;
    Rows rows = {.haveImage = HasImage()};
    int status = Run("%s gpu --scenes cloth --threads 1 --out out >log & "
                     "until [ -s out/gpu.txt ]; do sleep 0.02; done; kill $!; wait $!",
                     BENCH);
    ck_assert_int_eq(status, 128 + 15);
    ck_assert_int_ge(ForEachRow("out/gpu.csv", HEADER, CheckRow, &rows), 3);
    // No half-written file is left.
    ck_assert_int_eq(Run("test $(ls -A out | wc -l) -eq 3"), 0);
}
END_TEST

int main(void)
{
    TCase* tcase = qcMakeCase("qc-bench gpu");
    tcase_add_checked_fixture(tcase, EnterFolder, LeaveFolder);
    tcase_add_test(tcase, lists_agree_only_if_all_frames_and_all_steps_do);
    tcase_add_test(tcase, each_scene_and_size_has_its_rows_with_equal_lists);
    tcase_add_test(tcase, each_kernel_has_its_times_where_it_runs);
    tcase_add_test(tcase, too_few_triangles_for_all_scenes_are_refused);
    tcase_add_test(tcase, scenes_without_their_files_are_skipped);
    tcase_add_test(tcase, frames_from_the_middle_of_a_recording_are_measured);
    tcase_add_test(tcase, a_device_that_does_not_work_is_a_clear_error);
    tcase_add_test(tcase, mistakes_are_refused_before_anything_is_measured);
    tcase_add_test(tcase, a_run_that_is_ended_keeps_its_rows);
    return qcRunCase("qc-bench gpu", tcase);
}
