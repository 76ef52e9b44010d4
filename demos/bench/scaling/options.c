// The command line of `qc-bench scaling`.
#include "bench/scaling/scaling.h"

#include "common/option_values.h"

typedef enum OptionKey
{
    // Beyond every character: no option has a short name.
    key_triangles = 256,
    key_boxes,
    key_threads,
    key_out
} OptionKey;

static void TakeThreads(const struct argp_state* state, const char* word, void* context)
{
    qcScalingOptions* options = context;
    uint32_t threads = qcOption_ReadNumber(state, "--threads", word, 1, 1024);
    for (uint32_t i = 0; i < options->threadsCount; ++i)
    {
        if (options->threads[i] == threads)
            argp_error(state, "--threads: '%s' is named twice", word);
    }
    if (options->threadsCount == qc_maxScalingThreads)
        argp_error(state, "--threads: more than %d of them", qc_maxScalingThreads);
    options->threads[options->threadsCount++] = threads;
}

/// What was not named gets its default.
static void Complete(qcScalingOptions* options)
{
    if (options->threadsCount != 0)
        return;
    options->threads[options->threadsCount++] = 1;
    options->threads[options->threadsCount++] = 2;
}

static error_t ReadOption(int key, char* text, struct argp_state* state)
{
    qcScalingOptions* options = state->input;
    switch (key)
    {
        case key_triangles:
            options->mostTriangles = qcOption_ReadNumber(state, "--triangles", text, 0, UINT32_MAX);
            return 0;
        case key_boxes: options->mostBoxes = qcOption_ReadNumber(state, "--boxes", text, 0, UINT32_MAX); return 0;
        case key_threads: qcOption_ReadList(state, "--threads", text, TakeThreads); return 0;
        case key_out: options->out = qcOption_ReadFolder(state, "--out", text); return 0;
        case ARGP_KEY_ARG: argp_error(state, "'%s': options only, please", text); return 0;
        case ARGP_KEY_END: Complete(options); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option s_options[] = {
    {"triangles", key_triangles, "N", 0, "Cloths of 1000 triangles up to this many; 4000000 by default, 0: none", 1},
    {"boxes", key_boxes, "N", 0, "Sets of 100 boxes up to this many; 200000 by default, 0: none", 1},
    {"threads", key_threads, "LIST", 0, "Numbers of threads for the cloths; 1,2 by default", 1},
    {"out", key_out, "FOLDER", 0,
     "Where scaling_meshes.csv, scaling_boxes.csv, scaling.gp and the picture go; out/bench by default, made if it is "
     "missing",
     2},
    {0}};

static const char s_help[] =
    "Time and memory against size. A folded cloth with itself by sweep, each step with new vertices: time, its stages, "
    "bytes of the library a triangle, and the exponent of the growth from 20 K to 1 M. Boxes of which 0, 1, 10 and "
    "100 % move: time of a step, in which those that move are moved and the pairs they take part in are found.\v"
    "Exit status: as for qc-bench.";

void qcScaling_ReadOptions(int argumentCount, char** arguments, qcScalingOptions* options)
{
    static const struct argp parser = {s_options, ReadOption, NULL, s_help, NULL, NULL, NULL};
    *options = (qcScalingOptions){.mostTriangles = 4000000, .mostBoxes = 200000, .out = "out/bench"};
    argp_err_exit_status = qc_benchUsage;
    argp_parse(&parser, argumentCount, arguments, 0, NULL, options);
}
