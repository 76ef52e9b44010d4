// `qc-bench accuracy` as a user runs it: rows of its CSV, skipped scenes, pictures, refused options. The oracle is
// every pair of triangles through the exact test.
#include "bench/scenes/scenes.h"
#include "support/csv_rows.h"
#include "support/run_program.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BENCH QC_BENCH_PROGRAM

//  ---- the CSV -------------------------------------------------------------------------------------

static const char s_header[] =
    "scene,bodies,triangles,margin,touching,reference,exact,method,ran,resolution,views,rounds,order,second_pass,"
    "reliable,device,threads,image,queries,runs,ms,ms_least,pcs,candidates,found,missed,extra,missed_share,note";

static bool IsSkipped(const Row* row)
{
    return strncmp(Get(row, "note"), "\"skipped: ", 10) == 0;
}

static void GetTriangle(const qcMesh* mesh, uint32_t triangle, double corners[9], double lower[3], double upper[3])
{
    const float* positions = mesh->positions;
    for (int i = 0; i < 9; ++i)
        corners[i] = positions[3 * (size_t)mesh->indices[3 * triangle + (uint32_t)i / 3] + (size_t)i % 3];
    for (int axis = 0; axis < 3; ++axis)
    {
        lower[axis] = fmin(fmin(corners[axis], corners[axis + 3]), corners[axis + 6]);
        upper[axis] = fmax(fmax(corners[axis], corners[axis + 3]), corners[axis + 6]);
    }
}

/// Penetrating pairs of one triangle of each mesh: all pairs whose boxes overlap, through the exact test.
static uint32_t CountPairs(const qcMesh* a, const qcMesh* b)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < a->triangleCount; ++i)
    {
        double ta[9], la[3], ua[3];
        GetTriangle(a, i, ta, la, ua);
        for (uint32_t k = 0; k < b->triangleCount; ++k)
        {
            double tb[9], lb[3], ub[3];
            GetTriangle(b, k, tb, lb, ub);
            bool apart = false;
            for (int axis = 0; axis < 3; ++axis)
                apart = apart || la[axis] > ub[axis] || lb[axis] > ua[axis];
            count += !apart && qcRelateTriangles(ta, tb) == qc_relationPenetrating;
        }
    }
    return count;
}

static int FindScene(const char* name)
{
    for (int i = 0; i < qc_benchSceneCount; ++i)
    {
        if (strcmp(qcBenchScene_Name(i), name) == 0)
            return i;
    }
    ck_abort_msg("no scene %s", name);
    return 0;
}

static qcBenchScene MakeScene(const char* name)
{
    qcBenchScene scene;
    qcMessage message = {""};
    const qcBenchModels models = {QC_BUNNY_PATH, NULL};
    ck_assert_msg(qcBenchScene_Make(FindScene(name), &models, &scene, &message) == qc_benchMade, "%s", message.text);
    return scene;
}

typedef struct Seen
{
    uint32_t exact;   ///< pairs
    int ran, sampled; ///< rows
    double minMissed; ///< min missed pairs of the sampled rows that miss any
} Seen;

static void CheckRow(const Row* row, void* context)
{
    Seen* seen = context;
    ck_assert(Is(row, "scene", "sheets-1e-2"));
    ck_assert(Is(row, "reference", "brute"));
    ck_assert(GetNumber(row, "exact") == seen->exact);
    if (IsSkipped(row))
    {
        ck_assert(Is(row, "ms", "") && Is(row, "found", ""));
        ck_assert(!Is(row, "method", "auto") && !Is(row, "method", "sweep") && !Is(row, "method", "brute"));
        return;
    }
    double missed = GetNumber(row, "missed");
    ck_assert(GetNumber(row, "found") + missed == seen->exact);
    ck_assert(GetNumber(row, "extra") == 0.0);
    ck_assert_double_eq_tol(GetNumber(row, "missed_share"), missed / seen->exact, 1e-6);
    ck_assert(GetNumber(row, "ms") >= GetNumber(row, "ms_least") && GetNumber(row, "ms_least") > 0.0);
    ck_assert(GetNumber(row, "candidates") >= GetNumber(row, "found"));
    ck_assert(GetNumber(row, "pcs") <= GetNumber(row, "triangles"));
    ck_assert(GetNumber(row, "runs") == 1.0);
    ++seen->ran;
    if (Is(row, "method", "quick") || Is(row, "method", "cullide"))
    {
        ++seen->sampled;
        ck_assert(Is(row, "ran", Get(row, "method")));
        ck_assert(GetNumber(row, "image") == GetNumber(row, "resolution"));
        seen->minMissed = missed > 0.0 && missed < seen->minMissed ? missed : seen->minMissed;
    }
    else
        ck_assert(missed == 0.0);
}

START_TEST(each_row_accounts_for_every_pair_of_the_scene)
{
    qcBenchScene scene = MakeScene("sheets-1e-2");
    Seen seen = {CountPairs(&scene.bodies[0], &scene.bodies[1]), 0, 0, HUGE_VAL};
    ck_assert_uint_gt(seen.exact, 100);
    qcBenchScene_Free(&scene);
    ck_assert_int_eq(
        Run("%s accuracy --scenes sheets-1e-2 --resolutions 32,64 --views z,yx --runs 1 --out deep/er", BENCH), 0);
    // auto, sweep, brute; layers once and over 2 images; cullide over 2 * 2, quick in four orders.
    ck_assert_int_eq(ForEachRow("deep/er/accuracy.csv", s_header, CheckRow, &seen), 3 + 3 + 4 + 16);
    ck_assert_int_ge(seen.ran, 3);
    // With 64 * 64 pixels over triangles of half a pixel, some pixels lie beside a crossing: some sampled rows miss
    // some pairs, but not all.
    ck_assert(seen.sampled == 0 || (seen.sampled == 20 && seen.minMissed < seen.exact));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "auto "));
}
END_TEST

static void CheckSkipped(const Row* row, void* context)
{
    int* skipped = context;
    ck_assert(Is(row, "device", "none"));
    if (!IsSkipped(row))
        ck_assert(Is(row, "method", "sweep"));
    *skipped += IsSkipped(row);
}

START_TEST(methods_that_the_device_cannot_run_are_skipped_with_a_reason)
{
    ck_assert_int_eq(Run("%s accuracy --scenes dragon,sheets-1e-6 --methods sweep,quick,cullide --resolutions 32 "
                         "--views z --device none --runs 1 --out .",
                         BENCH),
                     0);
    int skipped = 0;
    ck_assert_int_eq(ForEachRow("accuracy.csv", s_header, CheckSkipped, &skipped), 6);
    ck_assert_int_eq(skipped, 5);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "dragon is skipped: --dragon names no file"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "quick, as published            1 of 1 settings skipped: "));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "... and reliable               1 of 1 settings skipped: "));
}
END_TEST

//  ---- the scenes ----------------------------------------------------------------------------------

START_TEST(a_scene_is_the_same_each_time)
{
    static const char* const names[] = {"cloth-20k", "sheets-1e-5", "slivers"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
    {
        qcBenchScene a = MakeScene(names[i]), b = MakeScene(names[i]);
        ck_assert_uint_eq(a.bodyCount, b.bodyCount);
        for (uint32_t k = 0; k < a.bodyCount; ++k)
        {
            const qcMesh *x = &a.bodies[k], *y = &b.bodies[k];
            ck_assert_uint_eq(x->vertexCount, y->vertexCount);
            ck_assert_uint_eq(x->triangleCount, y->triangleCount);
            ck_assert_int_eq(memcmp(x->positions, y->positions, 12 * (size_t)x->vertexCount), 0);
            ck_assert_int_eq(memcmp(x->indices, y->indices, 12 * (size_t)x->triangleCount), 0);
        }
        qcBenchScene_Free(&a);
        qcBenchScene_Free(&b);
    }
}
END_TEST

static size_t CountScenePairs(const char* name, size_t* between)
{
    qcBenchScene bodies = MakeScene(name);
    qcScene* scene = qcMakeScene(NULL);
    for (uint32_t i = 0; i < bodies.bodyCount; ++i)
    {
        const qcMesh* mesh = &bodies.bodies[i];
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = mesh->positions;
        def.vertexCount = mesh->vertexCount;
        def.indices = mesh->indices;
        def.triangleCount = mesh->triangleCount;
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(scene, &def, &id));
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    qcPairList list = qcDetectPairs(scene, &def);
    *between = 0;
    for (size_t i = 0; i < list.count; ++i)
        *between += list.pairs[i].bodyA != list.pairs[i].bodyB;
    free(list.pairs);
    qcScene_Destroy(scene);
    qcBenchScene_Free(&bodies);
    return list.count;
}

START_TEST(each_scene_has_enough_pairs_for_a_share)
{
    size_t between, pairs = CountScenePairs("cloth-20k", &between);
    ck_assert_uint_gt(pairs, 200);
    ck_assert_uint_lt(pairs, 1000);
    // Every second needle pokes through the one before.
    ck_assert_uint_ge(CountScenePairs("slivers", &between), 2500);
    for (int gap = 1; gap <= 6; ++gap)
    {
        char name[16];
        snprintf(name, sizeof name, "sheets-1e-%d", gap);
        pairs = CountScenePairs(name, &between);
        ck_assert_uint_gt(pairs, 200);
        ck_assert_uint_lt(pairs, 1000);
        ck_assert_uint_eq(between, pairs);
    }
}
END_TEST

//  ---- pictures ------------------------------------------------------------------------------------

#define TINY "accuracy --scenes sheets-1e-3 --resolutions 32,64 --views z --runs 1 --out ."

START_TEST(gnuplot_draws_a_picture_a_scene_and_one_of_all)
{
    if (Run("command -v gnuplot") != 0)
        return;
    ck_assert_int_eq(Run("%s " TINY " --full", BENCH), 0);
    // gnuplot's warnings, and progress on a slow machine, go there.
    ck_assert_ptr_null(strstr(GetErrors(), "arning"));
    // The CSV, the script, two pictures.
    ck_assert_uint_eq(CountEntries(), 4);
    bool png = strstr(GetOutput(), "Pictures: accuracy.png") != NULL;
    // Two images with each of three switches on and off.
    ck_assert_int_eq(Run("test $(grep -c ',quick,' accuracy.csv) -eq 16"), 0);
    static const char* const names[] = {"accuracy", "accuracy_sheets-1e-3"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
    {
        ck_assert_int_eq(
            Run("head -c 256 %s%s | grep -a -c '%s'", names[i], png ? ".png" : ".svg", png ? "PNG" : "<svg"), 0);
        // A page without points is smaller.
        ck_assert_int_eq(Run("test $(wc -c <%s%s) -gt 10000", names[i], png ? ".png" : ".svg"), 0);
    }
    // The script stands for itself.
    ck_assert_int_eq(Run("rm accuracy_* && gnuplot accuracy.gp"), 0);
    ck_assert_uint_eq(CountEntries(), 4);
}
END_TEST

START_TEST(without_gnuplot_there_is_the_csv_and_the_script)
{
    ck_assert_int_eq(Run("PATH=/nowhere; %s " TINY " --methods auto", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "gnuplot is not installed"));
    ck_assert_uint_eq(CountEntries(), 2);
}
END_TEST

START_TEST(a_gnuplot_that_fails_is_reported)
{
    WriteText("gnuplot", "#!/bin/sh\nexit 3\n");
    ck_assert_int_eq(Run("chmod +x gnuplot; PATH=$PWD:$PATH; %s " TINY " --methods auto", BENCH), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "gnuplot could not draw ./accuracy.gp"));
}
END_TEST

//  ---- refusals ------------------------------------------------------------------------------------

typedef struct Refused
{
    const char* arguments;
    int status;
    const char* message;
} Refused;

static const Refused s_refused[] = {
    {"", 2, "no BENCHMARK is named"},
    {"acuracy", 2, "there is no benchmark 'acuracy', only: accuracy, peers, first"},
    {"--scenes sheets accuracy", 2, "unrecognized option '--scenes'"},
    {"accuracy sheets", 2, "'sheets': options only"},
    {"accuracy --scene sheet", 2, "--scenes: 'sheet' is not one of all, cloth-20k,"},
    {"accuracy --scenes sheets-1e", 2, "--scenes: 'sheets-1e' is not one of"},
    {"accuracy --scenes ''", 2, "--scenes: '' is not a list"},
    {"accuracy --scenes sheets,,slivers", 2, "is not a list"},
    {"accuracy --methods quik", 2, "--methods: 'quik' is not one of auto, brute, cullide, quick, sweep, layers"},
    {"accuracy --methods auto,", 2, "--methods: 'auto,' is not a list"},
    {"accuracy --resolutions 256,4097", 2, "--resolutions: '4097' is not a whole number in 1..4096"},
    {"accuracy --resolutions 1,2,3,4,5,6,7,8,9,10,11,12,13,14", 2, "--resolutions: more than 13"},
    {"accuracy --views z,xx", 2, "--views: 'xx' is not"},
    {"accuracy --views x,x,x,x,x,x,x,x,x,x,x,x,x,x,x,x", 2, "--views: more than 15"},
    {"accuracy --runs 0", 2, "--runs: '0' is not a whole number in 1..15"},
    {"accuracy --rounds -1", 2, "--rounds: '-1'"},
    {"accuracy --margin 1.5", 2, "--margin: '1.5' is more than"},
    {"accuracy --margin nan", 2, "--margin: 'nan' is not a number"},
    {"accuracy --margin ''", 2, "--margin: '' is not a number"},
    {"accuracy --device gpu", 2, "--device: 'gpu' is not one of"},
    {"accuracy --threads many", 2, "--threads: 'many'"},
    {"accuracy --out ''", 2, "--out: no folder is named"},
    {"accuracy --out file/below", 1, "file: Not a directory"},
    {"accuracy --out file", 1, "file: Not a directory"},
    {"accuracy --scenes dragon --dragon none.ply", 3, "none.ply"},
    {"scaling cloth", 2, "'cloth': options only"},
    {"scaling --triangles -1", 2, "--triangles: '-1' is not a whole number"},
    {"scaling --boxes 1e3", 2, "--boxes: '1e3' is not a whole number"},
    {"scaling --threads 0", 2, "--threads: '0' is not a whole number in 1..1024"},
    {"scaling --threads 1,2,1", 2, "--threads: '1' is named twice"},
    {"scaling --out ''", 2, "--out: no folder is named"},
    {"scaling --out file", 1, "file: Not a directory"},
    {"accuracy --scenes pile --bunny file", 3, "file"},
    {"accuracy --scenes pile --bunny none.obj", 3, "none.obj"},
};

START_TEST(a_mistake_is_refused_with_a_message_that_names_it)
{
    const Refused* refused = &s_refused[_i];
    WriteText("file", "no mesh");
    ck_assert_int_eq(Run("%s %s", BENCH, refused->arguments), refused->status);
    ck_assert_msg(strstr(GetErrors(), refused->message) != NULL, "'%s' is not in: %s", refused->message, GetErrors());
    ck_assert_ptr_nonnull(strstr(GetErrors(), "qc-bench"));
}
END_TEST

START_TEST(a_missing_dragon_is_skipped)
{
    ck_assert_int_eq(Run("%s accuracy --scenes dragon --out .", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "dragon is skipped: --dragon names no file"));
}
END_TEST

START_TEST(help_explains_each_level)
{
    ck_assert_int_eq(Run("%s --help", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "accuracy   run time against error"));
    ck_assert_int_eq(Run("%s accuracy --help", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "Usage: qc-bench accuracy "));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "--resolutions"));
    ck_assert_int_eq(Run("%s peers --help", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "Usage: qc-bench peers "));
    ck_assert_int_eq(Run("%s scaling --help", BENCH), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "Usage: qc-bench scaling "));
}
END_TEST

START_TEST(version_is_that_of_the_library)
{
    char version[32];
    snprintf(version, sizeof version, " %u.%u.%u\n", qcVersion() / 10000, qcVersion() / 100 % 100, qcVersion() % 100);
    for (int i = 0; i < 2; ++i)
    {
        ck_assert_int_eq(Run("%s %s --version", BENCH, i == 0 ? "" : "accuracy"), 0);
        ck_assert_ptr_nonnull(strstr(GetOutput(), "qc-bench"));
        ck_assert_ptr_nonnull(strstr(GetOutput(), version));
    }
}
END_TEST

int main(void)
{
    const TTest* const tests[] = {each_row_accounts_for_every_pair_of_the_scene,
                                  methods_that_the_device_cannot_run_are_skipped_with_a_reason,
                                  a_scene_is_the_same_each_time,
                                  each_scene_has_enough_pairs_for_a_share,
                                  gnuplot_draws_a_picture_a_scene_and_one_of_all,
                                  without_gnuplot_there_is_the_csv_and_the_script,
                                  a_gnuplot_that_fails_is_reported,
                                  a_missing_dragon_is_skipped,
                                  help_explains_each_level,
                                  version_is_that_of_the_library};
    TCase* tcase = qcMakeCase("qc-bench");
    tcase_add_checked_fixture(tcase, EnterFolder, LeaveFolder);
    for (size_t i = 0; i < sizeof tests / sizeof tests[0]; ++i)
        tcase_add_test(tcase, tests[i]);
    tcase_add_loop_test(tcase, a_mistake_is_refused_with_a_message_that_names_it, 0,
                        (int)(sizeof s_refused / sizeof s_refused[0]));
    return qcRunCase("qc-bench", tcase);
}
