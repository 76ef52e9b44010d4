// The command line of `qc-bench gpu`.
#include "bench/gpu/gpu.h"

#include "common/options.h"

#include <string.h>
#include <unistd.h>

/// Reads --gpu, a number in EGL's list or a part of a name, and checks it with the device.
static void Complete(const struct argp_state* state, void* context)
{
    qcGpuOptions* options = context;
    if (options->device == qc_deviceNone)
        argp_error(state, "--device: 'none' can't be measured");
    if (options->gpuName == NULL)
        return;
    if (*options->gpuName == 0)
        argp_error(state, "--gpu: neither a number nor a name");
    if (options->device != qc_deviceAuto && options->device != qc_deviceEgl)
        argp_error(state, "--gpu is for --device egl");
    options->device = qc_deviceEgl;
    if (strspn(options->gpuName, "0123456789") != strlen(options->gpuName))
        return;
    options->gpuIndex = (int32_t)qcOption_ReadNumber(state, "--gpu", options->gpuName, 0, 255);
    options->gpuName = NULL;
}

static const char s_help[] =
    "The method layers on a GL device: which device and driver it is; whether layers and auto find the same pairs as "
    "sweep; the time of a step (new positions in, pairs out) beside sweep on 1 and on all threads; and where a step of "
    "layers spends its time, by the device's clock (GL_TIMESTAMP) for each kernel, and by the clock of the threads.\v"
    "Software GL is no GPU: it is named loudly. There the processor reads the image itself; QC_LAYERS_REFINE=device in "
    "the environment runs all kernels on it.\n\n"
    "Exit status: as for qc-bench; 1 also where layers finds other pairs than sweep, 4 also where the device fails "
    "in some size.";

void qcGpu_ReadOptions(int argumentCount, char** arguments, qcGpuOptions* options)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    *options = (qcGpuOptions){.maxTriangles = UINT32_MAX,
                              .threads = cores < 1      ? 1
                                         : cores > 1024 ? 1024
                                                        : (uint32_t)cores,
                              .device = qc_deviceAuto,
                              .gpuIndex = -1,
                              .models = {.bunny = QC_BUNNY_PATH},
                              .recordings = "out/recordings",
                              .out = "out/gpu"};
    qcWord scenes[qc_gpuSceneCount + 1] = {{NULL, 0}};
    for (int i = 0; i < qc_gpuSceneCount; ++i)
        scenes[i] = (qcWord){qcGpuScene_Name(i), i};
    const qcOption rows[] = {
        {1, "device", "DEVICE",
         "auto (a GPU, otherwise software GL), egl (a GPU), osmesa or surfaceless (software); auto by default",
         qcOption_Device(&options->device)},
        {1, "gpu", "N|NAME",
         "Which GPU of EGL's list, from 0, or a part of its renderer's name; the first that works by default",
         qcOption_Text(&options->gpuName)},
        {2, "scenes", "LIST",
         "Of cloth and tangle (a folded cloth with itself; in a tangle most layers cross), crowd and pile (27 such "
         "cloths with each other, deforming or rigid): from 1000 to 4000000 triangles; sheets-1e-3, sheets-1e-6 (two "
         "sheets so far apart) and slivers (needles that cross): 5000 triangles; tangle-92k, wrung-80k, dragon, "
         "bunnies-27 and rigid-27 as in qc-bench peers; paper-cloth, paper-breaking and paper-leaves (frames from the "
         "middle of the paper's scenes). All by default",
         qcOption_Marks(options->scenes, qc_gpuSceneCount, scenes)},
        {2, "triangles", "N",
         "Sizes up to this many; 4000000 by default, 1000000 on software GL; 0: the device is shown, no more",
         qcOption_Number(&options->maxTriangles, 0, UINT32_MAX)},
        {2, "threads", "N", "Threads of layers, and of sweep beside 1; all cores by default",
         qcOption_Number(&options->threads, 1, 1024)},
        {3, "bunny", "FILE", "The model of the bunnies; that of the package glmark2-data by default",
         qcOption_Text(&options->models.bunny)},
        {3, "dragon", "FILE", "The model of dragon, which is skipped without it; tests/dragon.sh fetches it",
         qcOption_Text(&options->models.dragon)},
        {3, "recordings", "FOLDER",
         "Where the paper's scenes are; %s by default; \"demos/run.sh bench paper\" makes them",
         qcOption_Folder(&options->recordings)},
        {3, "out", "FOLDER", "Where gpu.csv, gpu_stages.csv and gpu.txt go; %s by default, made if it is missing",
         qcOption_Folder(&options->out)},
        {0}};
    qcCommandLine line = {.options = rows, .help = s_help, .complete = Complete, .context = options};
    qcCommandLine_Parse(&line, argumentCount, arguments);
}
