// The command line of `qc-bench peers`. A word that is not known is refused with the words that are.
#include "bench/peers/peers.h"

#include "common/option_values.h"

#include <string.h>

typedef enum OptionKey
{
    // Beyond every character: no option has a short name.
    key_scenes = 256,
    key_peers,
    key_threads,
    key_frames,
    key_rounds,
    key_device,
    key_bunny,
    key_dragon,
    key_out
} OptionKey;

static void TakeScene(const struct argp_state* state, const char* word, void* context)
{
    qcPeersOptions* options = context;
    char known[512] = "all";
    bool all = strcmp(word, "all") == 0, any = all;
    for (int i = 0; i < qc_peerWorkCount; ++i)
    {
        if (all || strcmp(word, qcPeerWork_Name(i)) == 0)
            options->works[i] = any = true;
        size_t length = strlen(known);
        snprintf(known + length, sizeof known - length, ", %s", qcPeerWork_Name(i));
    }
    if (!any)
        argp_error(state, "--scenes: '%s' is not one of %s", word, known);
}

static void TakePeer(const struct argp_state* state, const char* word, void* context)
{
    qcPeersOptions* options = context;
    qcWord words[qc_peerLibraryCount + 1] = {{NULL, 0}};
    for (int i = 0; i < qc_peerLibraryCount; ++i)
        words[i] = (qcWord){qcPeerModule_Name(i), i};
    options->libraries[qcOption_ReadWord(state, "--peers", word, words)] = true;
}

static void TakeThreads(const struct argp_state* state, const char* word, void* context)
{
    qcPeersOptions* options = context;
    uint32_t threads = qcOption_ReadNumber(state, "--threads", word, 1, 1024);
    for (uint32_t i = 0; i < options->threadsCount; ++i)
    {
        if (options->threads[i] == threads)
            argp_error(state, "--threads: '%s' is named twice", word);
    }
    if (options->threadsCount == qc_maxPeerThreads)
        argp_error(state, "--threads: more than %d of them", qc_maxPeerThreads);
    options->threads[options->threadsCount++] = threads;
}

/// What was not named gets its default.
static void Complete(qcPeersOptions* options)
{
    if (memchr(options->works, true, sizeof options->works) == NULL)
        memset(options->works, true, sizeof options->works);
    if (memchr(options->libraries, true, sizeof options->libraries) == NULL)
        memset(options->libraries, true, sizeof options->libraries);
    if (options->threadsCount != 0)
        return;
    options->threads[options->threadsCount++] = 1;
    options->threads[options->threadsCount++] = 2;
}

static error_t ReadOption(int key, char* text, struct argp_state* state)
{
    qcPeersOptions* options = state->input;
    switch (key)
    {
        case key_scenes: qcOption_ReadList(state, "--scenes", text, TakeScene); return 0;
        case key_peers: qcOption_ReadList(state, "--peers", text, TakePeer); return 0;
        case key_threads: qcOption_ReadList(state, "--threads", text, TakeThreads); return 0;
        // Of a closed motion of two frames the second would be the way back.
        case key_frames: options->frames = qcOption_ReadNumber(state, "--frames", text, 3, qc_maxPeerFrames); return 0;
        case key_rounds: options->rounds = qcOption_ReadNumber(state, "--rounds", text, 1, qc_maxPeerRounds); return 0;
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
     "Of cloth-1k, cloth-20k, tangle-20k (crossing itself in thousands of places), cloth-250k, cloth-1m, bunny, "
     "dragon: each with itself; bunnies-27 (of 5000 triangles: the model's vertices in each cell of a grid become one) "
     "and bunnies-8 (as they are): with each other, all vertices "
     "new in each frame; rigid-27, rigid-8: the same bodies, transforms new in each frame",
     1},
    {"peers", key_peers, "LIST", 0, "Of embree, bullet, cgal", 1},
    {NULL, 0, NULL, 0, "How it is measured:", 2},
    {"threads", key_threads, "LIST", 0, "Numbers of threads; 1,2 by default", 2},
    {"frames", key_frames, "N", 0, "Frames of the motion, 3 to 32; 8 by default", 2},
    {"rounds", key_rounds, "N", 0, "Times that each method goes through the frames, in turn; 3 by default", 2},
    {"device", key_device, "DEVICE", 0,
     "auto, egl (a GPU), osmesa or surfaceless (software): layers is measured too; none by default", 2},
    {NULL, 0, NULL, 0, "Files:", 3},
    {"bunny", key_bunny, "FILE", 0, "The model of the bunnies; that of the package glmark2-data by default", 3},
    {"dragon", key_dragon, "FILE", 0, "The model of dragon, which is skipped without it; tests/dragon.sh fetches it",
     3},
    {"out", key_out, "FOLDER", 0,
     "Where peers.csv, peers.gp and the picture go; out/bench by default, made if it is missing", 3},
    {0}};

static const char s_help[] =
    "Our sweep beside other libraries: Embree's rtcCollide, Bullet's btDbvt, CGAL's box_intersection_d, as far as they "
    "were installed when this was built. All get the same meshes in the same run, and a triangle test that is as exact "
    "as ours, so that all must find the same pairs. A step is new positions in (vertices move by 0.3 % of the "
    "scene's diagonal, rigid bodies by that of their own), pairs out.\v"
    "The environment variable QC_KERNELS (plain, avx2, avx512) chooses our instruction set; the peers are compiled for "
    "this machine.\n\n"
    "Exit status: as for qc-bench; 1 also where a method found other pairs than ours.";

void qcPeers_ReadOptions(int argumentCount, char** arguments, qcPeersOptions* options)
{
    static const struct argp parser = {s_options, ReadOption, NULL, s_help, NULL, NULL, NULL};
    *options = (qcPeersOptions){
        .frames = 8, .rounds = 3, .device = qc_deviceNone, .models = {.bunny = QC_BUNNY_PATH}, .out = "out/bench"};
    argp_err_exit_status = qc_benchUsage;
    argp_parse(&parser, argumentCount, arguments, 0, NULL, options);
}
