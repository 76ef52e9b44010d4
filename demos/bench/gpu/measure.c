// A scene by layers, by auto and by sweep. Timed steps run without the timers of layers; further steps with timers give
// the times of its parts. The pairs of all steps are compared.
#include "bench/gpu/gpu.h"

#include "common/device.h"
#include "common/stopwatch.h"
#include "common/progress.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_minSteps = 8,
    qc_maxSteps = 64
};

// The time limit of one size.
static const double s_enoughMs = 600.0;
// A GPU that was idle has a low clock for some tenths of a second: an H200 begins at 345 of 1980 MHz.
static const double s_warmUpMs = 500.0;

/// Times of each part over the steps that were measured with timers.
typedef struct StageTimes
{
    double thread[qc_maxGpuStages][qc_maxSteps], device[qc_maxGpuStages][qc_maxSteps];
    uint32_t threadCount[qc_maxGpuStages], deviceCount[qc_maxGpuStages];
} StageTimes;

typedef struct Bench
{
    const qcAnimation* animation;
    qcAnimatedScene ours;
    qcDetectDef def;
    uint32_t frame; ///< next frame
    double ms;      ///< of the last step
    char failure[256];
} Bench;

//  ---- allocations ---------------------------------------------------------------------------------

static atomic_uint_fast64_t s_allocations;

static void* Allocate(size_t size, void* context)
{
    (void)context;
    atomic_fetch_add(&s_allocations, 1);
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void Release(void* memory, size_t size, void* context)
{
    (void)size;
    (void)context;
    free(memory);
}

void qcGpu_CountAllocations(void)
{
    qcSetAllocator(Allocate, Release, NULL);
}

//  ---- a step --------------------------------------------------------------------------------------

/// FNV-1a over the list as it is reported.
static uint64_t HashPairs(const qcResult* result)
{
    uint64_t hash = 0xcbf29ce484222325u;
    for (size_t i = 0; i < result->pairCount; ++i)
    {
        const qcPair* p = &result->pairs[i];
        const uint32_t words[] = {p->bodyA, p->triangleA, p->bodyB, p->triangleB, (uint32_t)p->relation};
        for (int k = 0; k < 5; ++k)
            hash = (hash ^ words[k]) * 0x100000001b3u;
    }
    return hash;
}

static bool Step(Bench* bench, qcGpuRun* run)
{
    uint32_t frame = bench->frame % qc_gpuFrames;
    bool seen = bench->frame++ >= qc_gpuFrames;
    double start = qcStopwatch_NowMs();
    bool ran = qcAnimatedScene_Step(&bench->ours, bench->animation, frame, &bench->def);
    bench->ms = qcStopwatch_NowMs() - start;
    if (!ran)
        return false;
    const char* fallback = bench->ours.result->profile.fallback;
    if (fallback != NULL && bench->failure[0] == 0)
        snprintf(bench->failure, sizeof bench->failure, "%s", fallback);
    uint64_t hash = HashPairs(bench->ours.result);
    if (frame == 0 && !seen)
    {
        run->pairs = bench->ours.result->pairCount;
        run->candidates = bench->ours.result->profile.candidates;
    }
    if (!seen)
        run->hashes[frame] = hash;
    run->steady = run->steady && hash == run->hashes[frame];
    return true;
}

//  ---- stages --------------------------------------------------------------------------------------

static void Keep(StageTimes* times, qcGpuRow* row, uint32_t stage, const char* name, double threadMs, double deviceMs)
{
    row->stages[stage].name = name;
    row->stageCount = stage + 1;
    if (threadMs >= 0.0)
        times->thread[stage][times->threadCount[stage]++] = threadMs;
    if (deviceMs >= 0.0)
        times->device[stage][times->deviceCount[stage]++] = deviceMs;
}

/// The parts of a step in the order in which they run.
static void KeepStep(const Bench* bench, StageTimes* times, qcGpuRow* row)
{
    const qcProfile* p = &bench->ours.result->profile;
    double objects = p->planMs + p->cullObjectsMs + p->sweepObjectsMs;
    double triangles = p->cullTrianglesMs + p->sweepTrianglesMs;
    double rest = p->totalMs - objects - triangles - p->exactMs - p->contactMs - p->manifoldMs;
    uint32_t stage = 0;
    Keep(times, row, stage++, "move", bench->ours.moveMs, -1.0);
    Keep(times, row, stage++, "objects", objects, -1.0);
    for (size_t i = 0; i < p->layerTimeCount && stage < qc_maxGpuStages - 3; ++i)
    {
        const qcLayerTime* part = &p->layerTimes[i];
        Keep(times, row, stage++, part->name, part->threadMs, part->deviceMs);
        triangles -= part->threadMs > 0.0 ? part->threadMs : 0.0;
    }
    Keep(times, row, stage++, "candidates", triangles > 0.0 ? triangles : 0.0, -1.0);
    // The list of the PCS, and positions on the device that the exact test reads.
    Keep(times, row, stage++, "report", rest > 0.0 ? rest : 0.0, -1.0);
    Keep(times, row, stage++, "exact", p->exactMs, -1.0);
}

static bool MeasureStages(Bench* bench, qcGpuRun* run, qcGpuRow* row)
{
    StageTimes* times = calloc(1, sizeof *times);
    double spent = 0.0;
    bool ran = times != NULL;
    bench->def.layerTimes = true;
    // The first ones: reading back is not measured in them.
    ran = ran && Step(bench, run);
    for (uint32_t i = 0; ran && (i < qc_minSteps || (i < qc_maxSteps && spent < s_enoughMs)); ++i)
    {
        ran = Step(bench, run);
        spent += bench->ms;
        if (ran)
            KeepStep(bench, times, row);
    }
    for (uint32_t i = 0; ran && i < row->stageCount; ++i)
    {
        qcGpuStage* stage = &row->stages[i];
        stage->threadMs = stage->deviceMs = -1.0;
        if (times->threadCount[i] != 0)
            stage->threadMs = qcStopwatch_Median(times->thread[i], times->threadCount[i]);
        if (times->deviceCount[i] != 0)
            stage->deviceMs = qcStopwatch_Median(times->device[i], times->deviceCount[i]);
    }
    free(times);
    return ran;
}

//  ---- rows ----------------------------------------------------------------------------------------

/// Steps that are not timed.
static bool WarmUp(Bench* bench, qcGpuRun* run)
{
    bool ran = true;
    double end = qcStopwatch_NowMs() + s_warmUpMs;
    while (ran && qcStopwatch_NowMs() < end)
        ran = Step(bench, run);
    return ran;
}

/// Each frame once, then timed steps.
static bool Time(Bench* bench, bool isSoftware, qcGpuRun* run)
{
    double times[qc_maxSteps], spent = 0.0;
    bool ran = true;
    for (uint32_t i = 0; ran && i < qc_gpuFrames; ++i)
    {
        ran = Step(bench, run);
        run->firstMs = i == 0 ? bench->ms : run->firstMs;
    }
    if (ran && run->method != qc_methodSweep && !isSoftware)
        ran = WarmUp(bench, run);
    uint64_t allocations = s_allocations;
    while (ran && (run->steps < qc_minSteps || (run->steps < qc_maxSteps && spent < s_enoughMs)))
    {
        ran = Step(bench, run);
        times[run->steps++] = bench->ms;
        run->deviceSteps += ran && bench->ours.result->profile.partsOnDevice != 0;
        spent += bench->ms;
    }
    run->allocations = s_allocations - allocations;
    run->ms = qcStopwatch_Median(times, run->steps);
    run->minMs = times[0];
    return ran;
}

/// Sums the parts of a step that are the processor's own.
static double FindProcessorMs(const qcGpuRow* row, bool software)
{
    static const char* const others[] = {"hand-over", "wait", "timers", "exact"};
    static const char* const kernels[] = {"vertices",       "boxes",      "nodes", "node pairs",
                                          "triangle pairs", "pair tests", "order"};
    double ms = 0.0;
    for (uint32_t i = 0; i < row->stageCount; ++i)
    {
        const qcGpuStage* stage = &row->stages[i];
        bool counts = stage->threadMs > 0.0;
        for (int k = 0; k < 4; ++k)
            counts = counts && strcmp(stage->name, others[k]) != 0;
        for (int k = 0; software && k < 7; ++k)
            counts = counts && strcmp(stage->name, kernels[k]) != 0;
        ms += counts ? stage->threadMs : 0.0;
    }
    return ms;
}

static bool MeasureLayers(Bench* bench, bool isSoftware, qcGpuRun* run, qcGpuRow* row)
{
    if (!Time(bench, isSoftware, run))
        return false;
    const qcProfile* p = &bench->ours.result->profile;
    row->deviceCalls = p->deviceCalls;
    row->deviceWaits = p->deviceWaits;
    if (!MeasureStages(bench, run, row))
        return false;
    p = &bench->ours.result->profile;
    row->processorMs = FindProcessorMs(row, isSoftware);
    row->entries = p->fragments;
    row->uploadedBytes = p->uploadedBytes;
    row->deviceBytes = p->deviceBytes;
    memcpy(row->failure, bench->failure, sizeof row->failure);
    return true;
}

static bool MeasureRun(const qcAnimation* animation, const qcGpuDevice* device, qcGpuRun* run, qcGpuRow* row)
{
    Bench bench = {.animation = animation, .def = qcDefaultDetectDef()};
    bench.def.method = run->method;
    bench.def.threads = run->threads;
    run->steady = true;
    qcStopwatch_Rest();
    bool ran = qcAnimatedScene_Open(animation, device->device, &bench.ours), isSoftware = device->info.software;
    if (ran)
        ran = run->method == qc_methodLayers ? MeasureLayers(&bench, isSoftware, run, row)
                                             : Time(&bench, isSoftware, run);
    qcAnimatedScene_Close(&bench.ours);
    return ran;
}

bool qcGpu_Measure(const qcGpuOptions* options, const qcGpuDevice* device, int scene, const qcAnimation* animation,
                   qcGpuRow* row, qcMessage* message)
{
    bool measured = true;
    qcProgress_Begin(0, qcGpuScene_Name(scene));
    *row = (qcGpuRow){.scene = scene, .bodies = animation->bodyCount, .triangles = animation->triangleCount};
    row->runs[row->runCount++] = (qcGpuRun){.method = qc_methodLayers, .threads = options->threads};
    row->runs[row->runCount++] = (qcGpuRun){.method = qc_methodAuto, .threads = options->threads};
    row->runs[row->runCount++] = (qcGpuRun){.method = qc_methodSweep, .threads = 1};
    if (options->threads != 1)
        row->runs[row->runCount++] = (qcGpuRun){.method = qc_methodSweep, .threads = options->threads};
    for (uint32_t i = 0; measured && i < row->runCount; ++i)
    {
        measured = MeasureRun(animation, device, &row->runs[i], row);
        if (!measured)
            qcMessage_Fail(message, "%s, %u triangles, %s: %s", qcGpuScene_Name(scene), row->triangles,
                           qcMethod_Name(row->runs[i].method), qcLastMessage());
    }
    qcProgress_End();
    return measured;
}

//  ---- the device ----------------------------------------------------------------------------------

static void ReadProcessor(char* name, size_t size)
{
    char line[256];
    name[0] = 0;
    FILE* stream = fopen("/proc/cpuinfo", "r");
    while (stream != NULL && name[0] == 0 && fgets(line, sizeof line, stream) != NULL)
    {
        const char* colon = strchr(line, ':');
        if (strncmp(line, "model name", strlen("model name")) == 0 && colon != NULL)
            snprintf(name, size, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
    }
    if (stream != NULL)
        fclose(stream);
}

/// Runs a step of the smallest cloth, to test whether the device works.
static bool Try(const qcGpuOptions* options, qcGpuDevice* device, qcMessage* message)
{
    qcAnimation animation;
    if (qcGpuScene_Make(0, 0, options, &animation, message) != qc_benchMade)
        return false;
    qcAnimatedScene ours;
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodLayers;
    def.threads = options->threads;
    double start = qcStopwatch_NowMs();
    bool ran =
        qcAnimatedScene_Open(&animation, device->device, &ours) && qcAnimatedScene_Step(&ours, &animation, 0, &def);
    device->firstStepMs = qcStopwatch_NowMs() - start;
    if (!ran || ours.result->profile.fallback != NULL)
        ran = qcMessage_Fail(message, "device %s (%s): %s", device->info.name, device->info.renderer,
                             ran ? ours.result->profile.fallback : qcLastMessage());
    qcAnimatedScene_Close(&ours);
    qcAnimation_Free(&animation);
    return ran;
}

static void FindWhyNoGpu(qcGpuDevice* device)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = qc_deviceEgl;
    qcDevice* gpu = NULL;
    if (qcDevice_Create(&def, &gpu) != qc_statusOk)
        snprintf(device->noGpu, sizeof device->noGpu, "%s", qcLastMessage());
    qcDevice_Destroy(gpu);
}

qcExitStatus qcGpu_OpenDevice(const qcGpuOptions* options, qcGpuDevice* device, qcMessage* message)
{
    *device = (qcGpuDevice){.device = NULL};
    ReadProcessor(device->processor, sizeof device->processor);
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = options->device;
    def.gpuIndex = options->gpuIndex;
    def.gpuName = options->gpuName;
    double start = qcStopwatch_NowMs();
    qcExitStatus status = qcToolDevice_Open(&def, &device->device, &device->info, message);
    device->openMs = qcStopwatch_NowMs() - start;
    if (status != qc_exitDone)
        return status;
    if (device->info.kind == qc_deviceNone)
    {
        qcMessage_Fail(message,
                       "no GL device works here, neither a GPU nor software GL; --device egl gives the reason");
        return qc_exitDevice;
    }
    if (options->device == qc_deviceAuto && device->info.software)
        FindWhyNoGpu(device);
    return Try(options, device, message) ? qc_exitDone : qc_exitDevice;
}
