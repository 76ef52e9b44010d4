// Types and functions of `qc-bench gpu`: the options, the scenes and their sizes, a row for each.
#ifndef QC_DEMOS_BENCH_GPU_GPU_H
#define QC_DEMOS_BENCH_GPU_GPU_H

#include "bench/bench.h"
#include "bench/scenes/animated_scene.h"
#include "bench/scenes/scenes.h"

#include <stdio.h>

enum
{
    qc_gpuSizeCount = 7,
    qc_gpuSceneCount = 15,
    qc_gpuFrames = 4,
    qc_maxGpuRuns = 4,   ///< of a row: layers, auto, sweep on 1 thread, sweep on all
    qc_maxGpuStages = 24 ///< of a step of layers
};

typedef struct qcGpuOptions
{
    bool scenes[qc_gpuSceneCount];
    uint32_t maxTriangles; ///< larger sizes are left out; UINT32_MAX: by the device
    uint32_t threads;      ///< of layers, and of the sweep on all threads
    qcDeviceKind device;
    int32_t gpuIndex;    ///< see qcDeviceDef
    const char* gpuName; ///< likewise
    qcBenchModels models;
    const char* recordings; ///< folder of the paper's scenes
    const char* out;
} qcGpuOptions;

/// Reads the command line; ends the program after --help and on a mistake.
void qcGpu_ReadOptions(int argumentCount, char** arguments, qcGpuOptions* options);

//  ---- scenes --------------------------------------------------------------------------------------

/// "cloth"; `scene` below qc_gpuSceneCount.
const char* qcGpuScene_Name(int scene);
const char* qcGpuScene_Title(int scene);
/// Number of sizes of the scene within the options' limit.
uint32_t qcGpuScene_CountSizes(int scene, const qcGpuOptions* options);
/// Makes the bodies of the scene in a size and their frames; empty unless it was made. Deterministic to the bit.
qcBenchMade qcGpuScene_Make(int scene, uint32_t size, const qcGpuOptions* options, qcAnimation* animation,
                            qcMessage* message);
/// Reads bodies and frames from the middle of a recording; empty unless it was made.
qcBenchMade qcGpuRecorded_Make(const char* path, qcAnimation* animation, qcMessage* message);

//  ---- rows ----------------------------------------------------------------------------------------

/// The device, and the time that opening it and its first step took.
typedef struct qcGpuDevice
{
    qcDevice* device;
    qcDeviceInfo info;
    double openMs, firstStepMs; ///< the first step includes compiling kernels
    char processor[128];        ///< "" where the system does not report it
    char noGpu[512];            ///< reason why `auto` opened software GL; otherwise ""
} qcGpuDevice;

/// A method on a number of threads.
typedef struct qcGpuRun
{
    qcMethod method;
    uint32_t threads;
    uint32_t steps;       ///< timed steps
    uint32_t deviceSteps; ///< those of them that the device has answered
    double ms, minMs;     ///< positions in, pairs out: median and minimum
    double firstMs;
    uint64_t allocations;          ///< in all timed steps
    uint64_t candidates, pairs;    ///< in the first frame
    uint64_t hashes[qc_gpuFrames]; ///< of the list of pairs in each frame
    bool steady;                   ///< every step of a frame had the same hash
} qcGpuRun;

/// A part of a step of layers: median times; negative: did not run, or was not measured.
typedef struct qcGpuStage
{
    const char* name;
    double threadMs, deviceMs;
} qcGpuStage;

/// A scene in one size.
typedef struct qcGpuRow
{
    int scene;
    uint32_t bodies, triangles;
    qcGpuRun runs[qc_maxGpuRuns]; ///< layers first
    uint32_t runCount;
    qcGpuStage stages[qc_maxGpuStages];
    uint32_t stageCount;
    uint64_t entries, uploadedBytes, deviceBytes; ///< of layers, in its last step
    uint32_t deviceCalls, deviceWaits;            ///< likewise
    /// The processor's share of a step of layers: everything but waiting and the exact test; with software GL, but the
    /// kernels, too.
    double processorMs;
    char failure[256]; ///< reason why layers did not run; empty: it ran
} qcGpuRow;

typedef struct qcGpuTable
{
    qcGpuRow rows[qc_gpuSceneCount * qc_gpuSizeCount];
    uint32_t rowCount;
} qcGpuTable;

/// Counts the library's allocations from now on.
void qcGpu_CountAllocations(void);
/// Opens the device and runs a small step of layers on it. Returns qc_exitDevice, with the device closed, if that
/// fails.
qcExitStatus qcGpu_OpenDevice(const qcGpuOptions* options, qcGpuDevice* device, qcMessage* message);
/// Measures a scene in one size. False with a message: out of memory, or the sweep failed.
bool qcGpu_Measure(const qcGpuOptions* options, const qcGpuDevice* device, int scene, const qcAnimation* animation,
                   qcGpuRow* row, qcMessage* message);
/// True if all methods found the same list of pairs in each frame, in every step.
static inline bool qcGpuRow_Agrees(const qcGpuRow* row)
{
    for (uint32_t i = 0; i < row->runCount; ++i)
        for (int frame = 0; frame < qc_gpuFrames; ++frame)
            if (!row->runs[i].steady || row->runs[i].hashes[frame] != row->runs[0].hashes[frame])
                return false;
    return true;
}

//  ---- reports -------------------------------------------------------------------------------------

/// Writes a readable description of the device, with a warning if it is no GPU.
void qcGpu_WriteDevice(FILE* stream, const qcGpuOptions* options, const qcGpuDevice* device);
/// Writes a readable table of the rows of a scene; nothing if there are none.
void qcGpu_WriteScene(FILE* stream, const qcGpuTable* table, int scene);
/// Writes gpu.csv, gpu_stages.csv, and gpu.txt, the readable report.
bool qcGpu_WriteFiles(const qcGpuOptions* options, const qcGpuDevice* device, const qcGpuTable* table,
                      qcMessage* message);

#endif
