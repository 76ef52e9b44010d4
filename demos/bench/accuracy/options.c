// The command line of `qc-bench accuracy`.
#include "bench/accuracy/accuracy.h"

#include "common/options.h"

#include <string.h>

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

static void TakeViews(const struct argp_state* state, const char* word, void* context)
{
    qcAccuracyOptions* options = context;
    char views[4];
    qcOption_ReadViews(state, "--views", word, views);
    if (options->viewCount == qc_maxViews)
        argp_error(state, "--views: more than %d of them", qc_maxViews);
    memcpy(options->views[options->viewCount++], views, sizeof views);
}

/// Lists that are not given get their defaults.
static void Complete(const struct argp_state* state, void* context)
{
    qcAccuracyOptions* options = context;
    if (options->margin > 1.0)
        argp_error(state, "--margin: '%g' is more than the scene's extent, 1", options->margin);
    // Images that are given are measured on every scene.
    options->thin = !options->full && options->resolutionCount == 0 && options->viewCount == 0;
    if (memchr(options->scenes, true, sizeof options->scenes) == NULL)
        memset(options->scenes, true, sizeof options->scenes);
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

static const char s_help[] =
    "Run time against error. Each method answers scenes whose pairs are known; a row of the CSV says how long it took "
    "(new vertices in, pairs out) and how many pairs it found, missed, and reported without reason. gnuplot draws it.\v"
    "Settings that take long run once, others several times: the median counts. Scenes other than cloth-20k get fewer "
    "settings of cullide and quick unless --full, --resolutions or --views is given.\n\n"
    "Exit status: as for qc-bench; 1 also where a method that never misses missed.";

void qcAccuracy_ReadOptions(int argumentCount, char** arguments, qcAccuracyOptions* options)
{
    *options =
        (qcAccuracyOptions){.runs = qc_maxRuns, .rounds = 1, .models = {.bunny = QC_BUNNY_PATH}, .out = "out/bench"};
    qcWord methods[qc_methodCount + 1] = {{NULL, 0}};
    for (int i = 0; i < qc_methodCount; ++i)
        methods[i] = (qcWord){qcMethod_Name((qcMethod)i), i};
    const qcOption rows[] = {
        {.group = 1, .help = "What is tried; all of it by default:"},
        {1, "scenes", "LIST",
         "Of cloth-20k, cloth-250k, cloth-2m (all but cullide and quick), pile (three bunnies), dragon (with itself), "
         "sheets-1e-1 to sheets-1e-6 (two sheets, their gap as a share of the extent), slivers; \"cloth\" and "
         "\"sheets\" are all of their kind",
         qcOption_Texts(TakeScene, options)},
        {1, "methods", "LIST", "Of auto, brute, cullide, quick, sweep, layers",
         qcOption_Marks(options->methods, qc_methodCount, methods)},
        {1, "resolutions", "LIST",
         "Pixels on a side of the image; 256,512,1024,2048,4096 by default, for layers 4,16,64,256 unless --full",
         qcOption_Numbers(options->resolutions, &options->resolutionCount, qc_maxResolutions, 1, 4096, false)},
        {1, "views", "LIST",
         "Axes to look along, in this order; z,xz,xyz by default. layers looks along one: it takes those of one letter",
         qcOption_Texts(TakeViews, options)},
        {1, "full", NULL,
         "Every setting on every scene, all switches of quick, and brute force for up to 300 000 triangles: hours on "
         "software GL",
         qcOption_Flag(&options->full, true)},
        {1, "runs", "N", "Timed runs of a quick setting, at most; %s by default",
         qcOption_Number(&options->runs, 1, qc_maxRuns)},
        {.group = 2, .help = "How it is queried:"},
        {2, "rounds", "N",
         "Rounds of cullide and quick over the views; 0: until nothing changes. %s by default: it costs and misses "
         "least",
         qcOption_Number(&options->rounds, 0, UINT32_MAX)},
        {2, "touching", NULL, "Pairs that only touch are reported too", qcOption_Flag(&options->touching, true)},
        {2, "margin", "SHARE", "Pairs no further apart than this share of the scene's extent are reported too",
         qcOption_Length(&options->margin)},
        {2, "threads", "N", "Threads; 0, the default: one per core", qcOption_Number(&options->threads, 0, 1024)},
        {2, "device", "DEVICE",
         "auto (the default), egl (a GPU), osmesa or surfaceless (software), or none (methods that draw are skipped)",
         qcOption_Device(&options->device)},
        {.group = 3, .help = "Files:"},
        {3, "bunny", "FILE", "The model of pile; that of the package glmark2-data by default",
         qcOption_Text(&options->models.bunny)},
        {3, "dragon", "FILE", "The model of dragon, which is skipped without it; tests/dragon.sh fetches it",
         qcOption_Text(&options->models.dragon)},
        {3, "out", "FOLDER",
         "Where accuracy.csv, accuracy.gp and the pictures go; %s by default, made if it is missing",
         qcOption_Folder(&options->out)},
        {0}};
    qcCommandLine line = {.options = rows, .help = s_help, .complete = Complete, .context = options};
    qcCommandLine_Parse(&line, argumentCount, arguments);
}
