// What the parts of `qc-bench gpu` share: the options, the scenes and their sizes, a row for each.
#ifndef QC_DEMOS_BENCH_GPU_GPU_H
#define QC_DEMOS_BENCH_GPU_GPU_H

#include "bench/bench.h"
#include "bench/scenes/animated_scene.h"
#include "bench/scenes/scenes.h"

#include <stdio.h>

enum
{
    qc_gpuSizeCount = 6,
    qc_gpuSceneCount = 7,
    qc_gpuFrames = 4,
    qc_maxGpuRuns = 3,   ///< of a row: layers, sweep on 1 thread, sweep on all
    qc_maxGpuStages = 24 ///< of a step of layers
};

typedef struct qcGpuOptions
{
    bool scenes[qc_gpuSceneCount];
    uint32_t maxTriangles; ///< larger sizes are left out
    uint32_t threads;      ///< all
    qcDeviceKind device;
    int32_t gpuIndex;    ///< see qcDeviceDef
    const char* gpuName; ///< likewise
    const char* out;
} qcGpuOptions;

/// Reads the command line; ends the program after --help and on a mistake.
void qcGpu_ReadOptions(int argumentCount, char** arguments, qcGpuOptions* options);

//  ---- scenes --------------------------------------------------------------------------------------

/// "cloth"; `scene` below qc_gpuSceneCount.
const char* qcGpuScene_Name(int scene);
const char* qcGpuScene_Title(int scene);
/// Sizes of the scene that are no larger than the options allow.
uint32_t qcGpuScene_CountSizes(int scene, const qcGpuOptions* options);
/// Makes the bodies of the scene in a size and their frames; empty unless it was made. Deterministic to the bit.
bool qcGpuScene_Make(int scene, uint32_t size, qcAnimation* animation, qcMessage* message);

//  ---- rows ----------------------------------------------------------------------------------------

/// The device, and the time that opening it and its first step took.
typedef struct qcGpuDevice
{
    qcDevice* device;
    qcDeviceInfo info;
    double openMs, firstStepMs; ///< in the first step kernels are compiled
    char processor[128];        ///< "" where the system does not report it
    char noGpu[512];            ///< why `auto` took software GL; otherwise ""
} qcGpuDevice;

/// A method on a number of threads.
typedef struct qcGpuRun
{
    qcMethod method;
    uint32_t threads;
    uint32_t steps;   ///< timed
    double ms, minMs; ///< positions in, pairs out: median and least
    double firstMs;
    uint64_t candidates, pairs;    ///< in the first frame
    uint64_t hashes[qc_gpuFrames]; ///< of the list of pairs in each frame
    bool steady;                   ///< each later step of a frame had the same hash
} qcGpuRun;

/// A part of a step of layers: medians; below 0: did not run, or was not measured.
typedef struct qcGpuStage
{
    const char* name;
    double threadMs, deviceMs;
} qcGpuStage;

/// A scene in a size.
typedef struct qcGpuRow
{
    int scene;
    uint32_t bodies, triangles;
    qcGpuRun runs[qc_maxGpuRuns]; ///< layers first
    uint32_t runCount;
    qcGpuStage stages[qc_maxGpuStages];
    uint32_t stageCount;
    uint64_t entries, uploadedBytes, deviceBytes; ///< of layers, in its last step
    char failure[256];                            ///< why layers did not run; empty: it did
} qcGpuRow;

typedef struct qcGpuTable
{
    qcGpuRow rows[qc_gpuSceneCount * qc_gpuSizeCount];
    uint32_t rowCount;
} qcGpuTable;

/// Opens the device and runs a small step of layers on it. A device that can't is closed, and qc_exitDevice returned.
qcExitStatus qcGpu_OpenDevice(const qcGpuOptions* options, qcGpuDevice* device, qcMessage* message);
/// Measures a scene in a size. False with a message: out of memory, or the sweep failed.
bool qcGpu_Measure(const qcGpuOptions* options, const qcGpuDevice* device, int scene, uint32_t size, qcGpuRow* row,
                   qcMessage* message);
/// All methods found the same list of pairs in each frame, in every step.
static inline bool qcGpuRow_Agrees(const qcGpuRow* row)
{
    for (uint32_t i = 0; i < row->runCount; ++i)
        for (int frame = 0; frame < qc_gpuFrames; ++frame)
            if (!row->runs[i].steady || row->runs[i].hashes[frame] != row->runs[0].hashes[frame])
                return false;
    return true;
}

//  ---- reports -------------------------------------------------------------------------------------

/// The device, for a reader: loudly where it is no GPU.
void qcGpu_WriteDevice(FILE* stream, const qcGpuOptions* options, const qcGpuDevice* device);
/// The rows of a scene, for a reader; nothing if there are none.
void qcGpu_WriteScene(FILE* stream, const qcGpuTable* table, int scene);
/// gpu.csv, gpu_stages.csv, and gpu.txt, which is what a reader sees.
bool qcGpu_WriteFiles(const qcGpuOptions* options, const qcGpuDevice* device, const qcGpuTable* table,
                      qcMessage* message);

#endif
