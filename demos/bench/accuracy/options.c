// The command line of `qc-bench accuracy`. A word that is not known is refused with the words that are.
#include "bench/accuracy/accuracy.h"

#include "common/option_values.h"

#include <string.h>

typedef enum OptionKey
{
    // Beyond every character: no option has a short name.
    key_scenes = 256,
    key_methods,
    key_resolutions,
    key_views,
    key_runs,
    key_rounds,
    key_full,
    key_margin,
    key_touching,
    key_threads,
    key_device,
    key_bunny,
    key_dragon,
    key_out
} OptionKey;

static const uint32_t s_resolutions[] = {256, 512, 1024, 2048, 4096};
// `layers` needs no more than this; larger images cost more and change nothing.
static const uint32_t s_layerResolutions[] = {4, 16, 64, 256};
static const char s_views[][4] = {"z", "xz", "xyz"};

static void TakeScene(const struct argp_state* state, const char* word, void* context)
{
    qcAccuracyOptions* options = context;
    char known[512] = "all";
    if (strcmp(word, "all") == 0)
    {
        memset(options->scenes, true, sizeof options->scenes);
        return;
    }
    if (qcBenchScene_Mark(word, options->scenes))
        return;
    for (int i = 0; i < qc_benchSceneCount; ++i)
    {
        size_t length = strlen(known);
        snprintf(known + length, sizeof known - length, ", %s", qcBenchScene_Name(i));
    }
    argp_error(state, "--scenes: '%s' is not one of %s", word, known);
}

static void TakeMethod(const struct argp_state* state, const char* word, void* context)
{
    qcAccuracyOptions* options = context;
    qcWord words[qc_methodCount + 1] = {{NULL, 0}};
    for (int i = 0; i < qc_methodCount; ++i)
        words[i] = (qcWord){qcMethod_Name((qcMethod)i), i};
    options->methods[qcOption_ReadWord(state, "--methods", word, words)] = true;
}

static void TakeResolution(const struct argp_state* state, const char* word, void* context)
{
    qcAccuracyOptions* options = context;
    uint32_t resolution = qcOption_ReadNumber(state, "--resolutions", word, 1, 4096);
    if (options->resolutionCount == qc_maxResolutions)
        argp_error(state, "--resolutions: more than %d of them", qc_maxResolutions);
    options->resolutions[options->resolutionCount++] = resolution;
}

static void TakeViews(const struct argp_state* state, const char* word, void* context)
{
    qcAccuracyOptions* options = context;
    char views[4];
    qcOption_ReadViews(state, "--views", word, views);
    if (options->viewCount == qc_maxViews)
        argp_error(state, "--views: more than %d of them", qc_maxViews);
    memcpy(options->views[options->viewCount++], views, sizeof views);
}

static double ReadShare(const struct argp_state* state, const char* option, const char* text)
{
    double share = qcOption_ReadLength(state, option, text);
    if (share > 1.0)
        argp_error(state, "%s: '%s' is more than the scene's extent, 1", option, text);
    return share;
}

static bool Any(const bool* flags, int count)
{
    return memchr(flags, true, (size_t)count) != NULL;
}

/// What was not named gets its default.
static void Complete(qcAccuracyOptions* options)
{
    // Somebody who names images wants them on every scene.
    options->thin = !options->full && options->resolutionCount == 0 && options->viewCount == 0;
    if (!Any(options->scenes, qc_benchSceneCount))
        memset(options->scenes, true, sizeof options->scenes);
    if (!Any(options->methods, qc_methodCount))
        memset(options->methods, true, sizeof options->methods);
    bool named = options->resolutionCount != 0;
    if (!named)
    {
        memcpy(options->resolutions, s_resolutions, sizeof s_resolutions);
        options->resolutionCount = sizeof s_resolutions / sizeof s_resolutions[0];
    }
    memcpy(options->layerResolutions, options->resolutions, sizeof options->resolutions);
    options->layerResolutionCount = options->resolutionCount;
    if (!named && !options->full)
    {
        memcpy(options->layerResolutions, s_layerResolutions, sizeof s_layerResolutions);
        options->layerResolutionCount = sizeof s_layerResolutions / sizeof s_layerResolutions[0];
    }
    if (options->viewCount == 0)
    {
        memcpy(options->views, s_views, sizeof s_views);
        options->viewCount = sizeof s_views / sizeof s_views[0];
    }
}

static error_t ReadOption(int key, char* text, struct argp_state* state)
{
    qcAccuracyOptions* options = state->input;
    switch (key)
    {
        case key_scenes: qcOption_ReadList(state, "--scenes", text, TakeScene); return 0;
        case key_methods: qcOption_ReadList(state, "--methods", text, TakeMethod); return 0;
        case key_resolutions: qcOption_ReadList(state, "--resolutions", text, TakeResolution); return 0;
        case key_views: qcOption_ReadList(state, "--views", text, TakeViews); return 0;
        case key_runs: options->runs = qcOption_ReadNumber(state, "--runs", text, 1, qc_maxRuns); return 0;
        case key_rounds: options->rounds = qcOption_ReadNumber(state, "--rounds", text, 0, UINT32_MAX); return 0;
        case key_full: options->full = true; return 0;
        case key_margin: options->margin = ReadShare(state, "--margin", text); return 0;
        case key_touching: options->touching = true; return 0;
        case key_threads: options->threads = qcOption_ReadNumber(state, "--threads", text, 0, 1024); return 0;
        case key_device:
            options->device = (qcDeviceKind)qcOption_ReadWord(state, "--device", text, qcDeviceWords);
            return 0;
        case key_bunny: options->models.bunny = text; return 0;
        case key_dragon: options->models.dragon = text; return 0;
        case key_out: options->out = qcOption_ReadFolder(state, "--out", text); return 0;
        case ARGP_KEY_ARG: argp_error(state, "'%s': options only, please; scenes follow --scenes", text); return 0;
        case ARGP_KEY_END: Complete(options); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option s_options[] = {
    {NULL, 0, NULL, 0, "What is tried; all of it by default:", 1},
    {"scenes", key_scenes, "LIST", 0,
     "Of cloth-20k, cloth-250k, cloth-2m (all but cullide and quick), pile (three bunnies), dragon (with itself), "
     "sheets-1e-1 to sheets-1e-6 (two sheets, their gap as a share of the extent), slivers; \"cloth\" and \"sheets\" "
     "are all of their kind",
     1},
    {"methods", key_methods, "LIST", 0, "Of auto, brute, cullide, quick, sweep, layers", 1},
    {"resolutions", key_resolutions, "LIST", 0,
     "Pixels on a side of the image; 256,512,1024,2048,4096 by default, for layers 4,16,64,256 unless --full", 1},
    {"views", key_views, "LIST", 0,
     "Axes to look along, in this order; z,xz,xyz by default. layers looks along one: it takes those of one letter", 1},
    {"full", key_full, NULL, 0,
     "Every setting on every scene, all switches of quick, and brute force for up to 300 000 triangles: hours on "
     "software GL",
     1},
    {"runs", key_runs, "N", 0, "Timed runs of a quick setting, at most; 15 by default", 1},
    {NULL, 0, NULL, 0, "How it is asked:", 2},
    {"rounds", key_rounds, "N", 0,
     "Rounds of cullide and quick over the views; 0: until nothing changes. 1 by default: it costs and misses least",
     2},
    {"touching", key_touching, NULL, 0, "Pairs that only touch count too", 2},
    {"margin", key_margin, "SHARE", 0, "Pairs no further apart than this share of the scene's extent count too", 2},
    {"threads", key_threads, "N", 0, "Threads; 0, the default: one per core", 2},
    {"device", key_device, "DEVICE", 0,
     "auto (the default), egl (a GPU), osmesa or surfaceless (software), or none (methods that draw are skipped)", 2},
    {NULL, 0, NULL, 0, "Files:", 3},
    {"bunny", key_bunny, "FILE", 0, "The model of pile; that of the package glmark2-data by default", 3},
    {"dragon", key_dragon, "FILE", 0, "The model of dragon, which is skipped without it; tests/dragon.sh fetches it",
     3},
    {"out", key_out, "FOLDER", 0,
     "Where accuracy.csv, accuracy.gp and the pictures go; out/bench by default, made if it is missing", 3},
    {0}};

static const char s_help[] =
    "Run time against error. Each method answers scenes whose pairs are known; a row of the CSV says how long it took "
    "(new vertices in, pairs out) and how many pairs it found, missed, and reported without reason. gnuplot draws it.\v"
    "Settings that take long run once, others several times: the median counts. Scenes other than cloth-20k get fewer "
    "settings of cullide and quick unless --full, --resolutions or --views is given.\n\n"
    "Exit status: as for qc-bench; 1 also where a method that never misses missed.";

void qcAccuracy_ReadOptions(int argumentCount, char** arguments, qcAccuracyOptions* options)
{
    static const struct argp parser = {s_options, ReadOption, NULL, s_help, NULL, NULL, NULL};
    *options =
        (qcAccuracyOptions){.runs = qc_maxRuns, .rounds = 1, .models = {.bunny = QC_BUNNY_PATH}, .out = "out/bench"};
    argp_err_exit_status = qc_benchUsage;
    argp_parse(&parser, argumentCount, arguments, 0, NULL, options);
}
