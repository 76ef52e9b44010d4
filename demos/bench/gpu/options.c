// The command line of `qc-bench gpu`.
#include "bench/gpu/gpu.h"

#include "common/option_values.h"

#include <string.h>
#include <unistd.h>

typedef enum OptionKey
{
    // Beyond every character: no option has a short name.
    key_scenes = 256,
    key_triangles,
    key_threads,
    key_device,
    key_gpu,
    key_out
} OptionKey;

static void TakeScene(const struct argp_state* state, const char* word, void* context)
{
    qcGpuOptions* options = context;
    qcWord words[qc_gpuSceneCount + 1] = {{NULL, 0}};
    for (int i = 0; i < qc_gpuSceneCount; ++i)
        words[i] = (qcWord){qcGpuScene_Name(i), i};
    options->scenes[qcOption_ReadWord(state, "--scenes", word, words)] = true;
}

/// Options that are not given get their defaults.
static void Complete(const struct argp_state* state, qcGpuOptions* options)
{
    if (memchr(options->scenes, true, sizeof options->scenes) == NULL)
        memset(options->scenes, true, sizeof options->scenes);
    if (options->gpuIndex < 0 && options->gpuName == NULL)
        return;
    if (options->device != qc_deviceAuto && options->device != qc_deviceEgl)
        argp_error(state, "--gpu is for --device egl");
    options->device = qc_deviceEgl;
}

/// A number in EGL's list, or a part of a name.
static void TakeGpu(const struct argp_state* state, const char* text, qcGpuOptions* options)
{
    if (*text == 0)
        argp_error(state, "--gpu: neither a number nor a name");
    if (strspn(text, "0123456789") == strlen(text))
        options->gpuIndex = (int32_t)qcOption_ReadNumber(state, "--gpu", text, 0, 255);
    else
        options->gpuName = text;
}

static error_t ReadOption(int key, char* text, struct argp_state* state)
{
    qcGpuOptions* options = state->input;
    switch (key)
    {
        case key_scenes: qcOption_ReadList(state, "--scenes", text, TakeScene); return 0;
        case key_triangles:
            options->maxTriangles = qcOption_ReadNumber(state, "--triangles", text, 0, UINT32_MAX);
            return 0;
        case key_threads: options->threads = qcOption_ReadNumber(state, "--threads", text, 1, 1024); return 0;
        case key_device:
            options->device = (qcDeviceKind)qcOption_ReadWord(state, "--device", text, qcDeviceWords);
            if (options->device == qc_deviceNone)
                argp_error(state, "--device: 'none' can't be measured");
            return 0;
        case key_gpu: TakeGpu(state, text, options); return 0;
        case key_out: options->out = qcOption_ReadFolder(state, "--out", text); return 0;
        case ARGP_KEY_ARG: argp_error(state, "'%s': options only, please; scenes follow --scenes", text); return 0;
        case ARGP_KEY_END: Complete(state, options); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option s_options[] = {
    {"device", key_device, "DEVICE", 0,
     "auto (a GPU, otherwise software GL), egl (a GPU), osmesa or surfaceless (software); auto by default", 1},
    {"gpu", key_gpu, "N|NAME", 0,
     "Which GPU of EGL's list, from 0, or a part of its renderer's name; the first that works by default", 1},
    {"scenes", key_scenes, "LIST", 0,
     "Of cloth and tangle (a folded cloth with itself; in a tangle most layers cross), crowd and pile (27 such cloths "
     "with each other, deforming or rigid): from 1000 to 1000000 triangles; sheets-1e-3, sheets-1e-6 (two sheets so "
     "far apart) and slivers (needles that cross): 5000 triangles. All by default",
     2},
    {"triangles", key_triangles, "N", 0, "Sizes up to this many; 1000000 by default, 0: the device is shown, no more",
     2},
    {"threads", key_threads, "N", 0, "Threads of layers, and of sweep beside 1; all cores by default", 2},
    {"out", key_out, "FOLDER", 0,
     "Where gpu.csv, gpu_stages.csv and gpu.txt go; out/gpu by default, made if it is missing", 3},
    {0}};

static const char s_help[] =
    "The method layers on a GL device: which device and driver it is; whether layers finds the same pairs as sweep; "
    "the time of a step (new positions in, pairs out) beside sweep on 1 and on all threads; and where a step of layers "
    "spends its time, by the device's clock (GL_TIMESTAMP) for each kernel, and by the clock of the threads.\v"
    "Software GL is no GPU: it is named loudly. There the processor reads the image itself; QC_LAYERS_REFINE=device in "
    "the environment runs all kernels on it.\n\n"
    "Exit status: as for qc-bench; 1 also where layers finds other pairs than sweep, 4 also where the device does not "
    "answer in all sizes.";

void qcGpu_ReadOptions(int argumentCount, char** arguments, qcGpuOptions* options)
{
    static const struct argp parser = {s_options, ReadOption, NULL, s_help, NULL, NULL, NULL};
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    *options = (qcGpuOptions){.maxTriangles = 1000000,
                              .threads = cores < 1      ? 1
                                         : cores > 1024 ? 1024
                                                        : (uint32_t)cores,
                              .device = qc_deviceAuto,
                              .gpuIndex = -1,
                              .out = "out/gpu"};
    argp_err_exit_status = qc_benchUsage;
    argp_parse(&parser, argumentCount, arguments, 0, NULL, options);
}
