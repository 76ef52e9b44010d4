// `layers` on the device: compute kernels from vertices to pairs of triangles, or to the image, which keeps for each
// pixel and slice of depth a list of the nodes that cover it (after Yang et al.: Real-Time Concurrent Linked List
// Construction on the GPU, 2010). A step is one submission and one wait. The README.md of this room lists the kernels.
// Proof that no pair is lost: plugin/docs/proofs/layers.md.
#include "gl/layers/layers_gpu.h"

#include "base/clock.h"
#include "base/status.h"
#include "gl/device.h"
#include "gl/layers/layers_kernels.h"
#include "gl/layers/step_data.h"
#include "gl/timers.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

enum
{
    qc_maxReruns = 64,
    // Calls for each job in device.c, beside those that are counted here: for errors, unless there can be none.
    qc_callsOfJob = 1,
    // Words that an invocation of the first kernel resets or copies.
    qc_resetShare = 8
};

// Nanoseconds: a device that needs more is lost. Software GL compiles its first kernels on cores that others use, too.
static const GLuint64 s_maxWait = 10000000000u, s_maxSoftwareWait = 60000000000u;

static const int s_kernelParts[qc_kernelCount] = {qc_partVertices,  qc_partBoxes,     qc_partNodes,
                                                  qc_partNodes,     qc_partNodePairs, qc_partTrianglePairs,
                                                  qc_partPairTests, qc_partOrder};

struct qcLayers
{
    qcDevice* device;
    uint32_t generation; ///< of the device
    bool imageOnly;
    qcLayersBuffers buffers;
    qcLayersStream stream;
    qcLayersKernels kernels;
    qcLayersLists lists;
    uint32_t runNumber; ///< of the last run; the last kernel writes it to `finished`
    GLsync fence;       ///< of the run on the device; null: there is none
    bool showsErrors;   ///< the run has no call whose failure its answer would not show
    qcGlTimers timers;
    GLuint64 maxWait;  ///< for a run
    qcLayersStep step; ///< the last one begun
    qcLayersAnswer answer;
};

static qcStatus CreateObjects(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    layers->kernels.imageOnly = layers->buffers.imageOnly = layers->lists.imageOnly = layers->imageOnly;
    QC_TRY(qcLayersKernels_Create(gl, &layers->kernels));
    return qcLayersBuffers_Create(gl, &layers->buffers);
}

bool qcLayers_IsAlive(const qcLayers* layers)
{
    return layers != NULL && layers->generation == qcDevice_GetGeneration(layers->device);
}

bool qcLayers_SharesVertices(const qcLayers* layers)
{
    return layers->imageOnly && layers->buffers.persistent;
}

static qcStatus DeleteObjects(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    gl->DeleteSync(layers->fence);
    qcGlTimers_Delete(gl, &layers->timers);
    qcLayersStream_Delete(gl, &layers->stream);
    qcLayersBuffers_Delete(gl, &layers->buffers);
    return qc_statusOk;
}

typedef struct Opening
{
    qcLayers* layers;
    const qcLayersStep* step;
} Opening;

static qcStatus GrowForStep(const struct qcGlFunctions* gl, void* context)
{
    const Opening* opening = context;
    qcLayers* layers = opening->layers;
    size_t bytes = qcStepData_FindPlaces(opening->step).end * sizeof(uint32_t);
    if (bytes > layers->stream.size)
        QC_TRY(qcLayersStream_Grow(gl, &layers->stream, bytes));
    if (!qcLayers_SharesVertices(layers))
        return qc_statusOk;
    return qcLayersBuffers_Reserve(gl, &layers->buffers, qc_layersVertices, opening->step->capacity[qc_layersVertices]);
}

qcStatus qcLayers_Open(qcLayers* layers, const qcLayersStep* step, qcLayersMemory* memory)
{
    qcStepPlaces p = qcStepData_FindPlaces(step);
    bool shares = qcLayers_SharesVertices(layers);
    if (p.end * sizeof(uint32_t) > layers->stream.size ||
        (shares && step->capacity[qc_layersVertices] > layers->buffers.capacity[qc_layersVertices]))
    {
        Opening opening = {layers, step};
        QC_TRY(qcDevice_RunIn(layers->device, layers->generation, GrowForStep, &opening, "layers, memory"));
    }
    float* words = (float*)(void*)qcLayersStream_Data(&layers->stream);
    *memory = (qcLayersMemory){.floats = words + p.floats,
                               .vertices = shares ? layers->buffers.mapped[qc_layersVertices] : NULL};
    return qc_statusOk;
}

//  ---- kernels -----------------------------------------------------------------------------------------------------

static void Run(const struct qcGlFunctions* gl, qcLayers* layers, qcLayersKernel kernel, uint64_t groups)
{
    qcLayersKernel last = layers->imageOnly                ? qc_kernelImageNodes
                          : layers->lists.bucketCount != 0 ? qc_kernelOrder
                                                           : qc_kernelPairTests;
    qcLayersKernels_Run(gl, &layers->kernels, kernel, groups, kernel == last);
    qcGlTimers_Mark(gl, &layers->timers, s_kernelParts[kernel]);
}

/// Vertices in buffers of the caller's.
static void RunSources(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    uint32_t first = qcStepData_OwnChunkCount(step);
    for (uint32_t i = 0; i < step->sourceCount; i++)
    {
        qcGl_Counted(gl)->BindBufferBase(GL_SHADER_STORAGE_BUFFER, qc_sourceBinding, step->sources[i].buffer);
        qcLayersKernels_RunForeign(gl, &layers->kernels, first, first + step->sources[i].chunkCount);
        first += step->sources[i].chunkCount;
    }
    if (step->sourceCount != 0)
        qcGl_Counted(gl)->BindBufferBase(GL_SHADER_STORAGE_BUFFER, qc_sourceBinding,
                                         layers->buffers.buffers[qc_workTrianglePairs]);
}

/// New vertices into the frame; empty lists; for pairs, a copy of the step's data.
static void RunVertices(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    void* lists = layers->buffers.mapped[qc_workLists];
    size_t words = qcStepData_BucketsAt(step, layers->imageOnly) + (size_t)layers->lists.bucketCount,
           copied = qcStepData_FindPlaces(step).chunks;
    words = copied > words && !layers->imageOnly ? copied : words;
    uint64_t chunks = qcStepData_OwnChunkCount(step), share = (uint64_t)qc_layersChunkSize * qc_resetShare;
    uint64_t groups = (words + share - 1) / share;
    if (qcLayers_SharesVertices(layers) && step->chunkCount == 0)
    {
        memset(lists, 0, qc_counterWords * sizeof(uint32_t));
        memset((uint32_t*)lists + qc_counterWords, 0xff,
               qcStepData_ListWords(step, layers->imageOnly) * sizeof(uint32_t));
        qcGlTimers_Mark(gl, &layers->timers, qc_partUpload);
        return;
    }
    Run(gl, layers, qc_kernelVertices, chunks > groups ? chunks : groups);
    RunSources(gl, layers);
}

static void RunKernels(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    RunVertices(gl, layers);
    if (layers->imageOnly)
    {
        if (step->changedNodes != 0)
            Run(gl, layers, qc_kernelImageBoxes, (step->changedNodes + UINT64_C(7)) / 8);
        Run(gl, layers, qc_kernelImageNodes, (step->activeCount + UINT64_C(15)) / 16);
        return;
    }
    const qcLayersLists* lists = &layers->lists;
    Run(gl, layers, qc_kernelNodes, step->activeCount);
    Run(gl, layers, qc_kernelNodePairs, qcStepData_ComparingGroupCount(step));
    Run(gl, layers, qc_kernelTrianglePairs,
        qcLayersLists_GroupCount(lists, qc_listNodePairs, qcLayersLists_NodePairsOfGroup(lists)));
    Run(gl, layers, qc_kernelPairTests, qcLayersLists_GroupCount(lists, qc_listTrianglePairs, qc_testsOfGroup));
    if (layers->lists.bucketCount != 0)
        Run(gl, layers, qc_kernelOrder, layers->lists.bucketCount);
}

/// Whether the next run shows each failure in its answer. It calls for its kernels and its fence only: a program that
/// is not used, a kernel that is not dispatched or a fence that is not there leave the run without its number. Errors
/// of other calls are looked for once the job is done.
static bool ShowsErrors(const struct qcGlFunctions* gl, const qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    return gl->state->bound == layers && layers->buffers.persistent && !layers->imageOnly && !step->timed &&
           step->uploadCount == 0 && step->sourceCount == 0 && layers->answer.reruns == 0;
}

/// Submits a run: all kernels, and a fence behind them. May be repeated.
static void Submit(const struct qcGlFunctions* gl, qcLayers* layers)
{
    // No two runs of a process have the same: new buffers may hold the answer of one that is gone.
    static atomic_uint s_runs;
    layers->runNumber = atomic_fetch_add(&s_runs, 1) + 1;
    qcLayersBuffers_UnmapAll(gl, &layers->buffers);
    qcStepData_WriteParameters(&layers->step, &layers->lists, &layers->buffers, layers->runNumber, &layers->stream);
    qcLayersStream_Submit(gl, &layers->stream, qcStepData_FindPlaces(&layers->step).end * sizeof(uint32_t));
    layers->showsErrors = ShowsErrors(gl, layers);
    if (gl->state->bound != layers)
        qcLayersBuffers_BindAll(gl, &layers->buffers, layers->stream.buffer);
    qcGlTimers_Mark(gl, &layers->timers, qc_partUpload);
    RunKernels(gl, layers);
    layers->fence = qcGl_Counted(gl)->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    qcGl_KeepBindings(gl, layers);
}

/// Makes room for the step, as far as its sizes are known beforehand.
static qcStatus ReserveAll(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    qcLayersBuffers* b = &layers->buffers;
    size_t nodes = step->capacity[qc_layersNodes];
    bool imageOnly = layers->imageOnly;
    for (int buffer = 0; buffer < qc_layersInputCount; buffer++)
        QC_TRY(qcLayersBuffers_Reserve(gl, b, buffer, step->capacity[buffer]));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workBoxes, imageOnly ? 48 * nodes : (qc_boxesOfNode + 1) * nodes));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workClusterBoxes, imageOnly ? 8 * nodes : 0));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workNodeBoxes, imageOnly ? qc_texelsOfImageNode * nodes : 0));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workLists,
                                   qcStepData_BucketsAt(step, layers->imageOnly) + (size_t)layers->lists.bucketCount));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workStep, imageOnly ? 0 : qcStepData_FindPlaces(step).chunks));
    return qcLayersLists_Reserve(gl, &layers->lists, b, nodes);
}

static qcStatus SubmitStep(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    gl->state->calls = 0;
    qcGlTimers_Begin(gl, &layers->timers, step->timed, step->started, qc_partHandOver);
    layers->answer = (qcLayersAnswer){.uploadedBytes = qcStepData_ByteCount(step)};
    qcLayersLists_ChooseBuckets(&layers->lists, step->triangleCount);
    QC_TRY(ReserveAll(gl, layers));
    for (size_t i = 0; i < step->uploadCount; i++)
        layers->answer.uploadedBytes += qcLayersBuffers_Upload(gl, &layers->buffers, &step->uploads[i]);
    qcStepData_Write(step, &layers->stream);
    Submit(gl, layers);
    return qc_statusOk;
}

//  ---- results -----------------------------------------------------------------------------------------------------

/// Waits for the run and reads its counters.
static qcStatus Wait(const struct qcGlFunctions* gl, qcLayers* layers)
{
    GLenum reached = qcGl_Counted(gl)->ClientWaitSync(layers->fence, GL_SYNC_FLUSH_COMMANDS_BIT, layers->maxWait);
    layers->answer.waits++;
    qcGl_Counted(gl)->DeleteSync(layers->fence);
    layers->fence = NULL;
    if (reached != GL_ALREADY_SIGNALED && reached != GL_CONDITION_SATISFIED)
        return qcFail(qc_statusDevice, "layers: the device did not finish its kernels in time");
    const void* counters =
        qcLayersBuffers_Read(gl, &layers->buffers, layers->imageOnly ? qc_workLists : qc_workResults);
    if (counters == NULL)
        return qcFail(qc_statusDevice, "layers: the device's answer can't be read");
    memcpy(&layers->lists.counters, counters, sizeof layers->lists.counters);
    qcGlTimers_MarkPassed(&layers->timers);
    qcGlTimers_Mark(gl, &layers->timers, qc_partWait);
    return qc_statusOk;
}

/// Checks the run, and makes room for lists that overflowed; `*again`: some did.
static qcStatus CheckRun(const struct qcGlFunctions* gl, qcLayers* layers, bool* again)
{
    if (layers->lists.counters.finished.count != layers->runNumber)
        return qcFail(qc_statusDevice, "layers: the device did not finish its kernels");
    if (layers->lists.counters.stopped.count != 0)
        return qcFail(qc_statusDevice,
                      "layers: a cell's list, a node's cells or its links are more than the device's loops do");
    return qcLayersLists_Grow(gl, &layers->lists, &layers->buffers, again);
}

static qcStatus ReadImage(const struct qcGlFunctions* gl, qcLayers* layers)
{
    static const int s_read[] = {qc_workEntries, qc_workNodeBoxes, qc_workBoxes, qc_layersVertices};
    const void* data[sizeof s_read / sizeof s_read[0]];
    qcLayersBuffers* b = &layers->buffers;
    for (size_t i = 0; i < sizeof s_read / sizeof s_read[0]; i++)
    {
        data[i] = qcLayersBuffers_Read(gl, b, s_read[i]);
        if (data[i] == NULL)
            return qcFail(qc_statusDevice, "layers: the device's answer can't be read");
    }
    const uint32_t(*nodeBoxes)[4] = data[1];
    layers->answer.image = (qcLayersImage){
        .entries = data[0],
        .entryCount = qcLayersLists_Count(&layers->lists, qc_listEntries),
        .nodeBoxes = nodeBoxes,
        .clusterGroups = data[2],
        .nodeGroups = (const qcBox8*)(const void*)(nodeBoxes + b->capacity[qc_workNodeBoxes] / qc_texelsOfImageNode),
        .vertices = data[3]};
    return qc_statusOk;
}

static qcStatus ReadPairs(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const uint32_t(*results)[2] = qcLayersBuffers_Read(gl, &layers->buffers, qc_workResults);
    layers->answer.pairs = results + qc_counterWords / 2;
    layers->answer.pairCount = qcLayersLists_Count(&layers->lists, qc_listSurvivors);
    return qc_statusOk;
}

/// Waits, and repeats the run until every list has room.
static qcStatus FinishStep(const struct qcGlFunctions* gl, qcLayers* layers)
{
    qcLayersAnswer* answer = &layers->answer;
    bool again = true;
    QC_TRY(Wait(gl, layers));
    // Seen with zink (Mesa 22.3) in one run of some twenty, where another context shares objects: the cause is unknown.
    if (layers->lists.counters.finished.count != layers->runNumber && layers->step.sourceCount != 0)
    {
        Submit(gl, layers);
        QC_TRY(Wait(gl, layers));
        answer->reruns++;
    }
    QC_TRY(CheckRun(gl, layers, &again));
    for (; again; answer->reruns++)
    {
        if (answer->reruns == qc_maxReruns)
            return qcFail(qc_statusDevice, "layers: the device does not finish");
        Submit(gl, layers);
        QC_TRY(Wait(gl, layers));
        QC_TRY(CheckRun(gl, layers, &again));
    }
    gl->state->isAnswered = true;
    gl->state->hasNoErrors = layers->showsErrors;
    QC_TRY(layers->imageOnly ? ReadImage(gl, layers) : ReadPairs(gl, layers));
    answer->entries = qcLayersLists_Count(&layers->lists, qc_listEntries);
    answer->trianglePairs = qcLayersLists_Count(&layers->lists, qc_listTrianglePairs);
    answer->skippedNodes = layers->lists.counters.skippedNodes.count;
    answer->deviceBytes = qcLayersBuffers_ByteCount(&layers->buffers) + layers->stream.size;
    answer->glCalls = gl->state->calls + (layers->showsErrors ? 0 : qc_callsOfJob);
    qcGlTimers_Mark(gl, &layers->timers, qc_partWait);
    qcGlTimers_End(gl, &layers->timers, qc_partTimers);
    qcGl_KeepBindings(gl, gl->state->bound);
    return qc_statusOk;
}

//  ---- jobs --------------------------------------------------------------------------------------------------------

static qcStatus RunJob(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    QC_TRY(SubmitStep(gl, layers));
    return FinishStep(gl, layers);
}

qcStatus qcLayers_Create(qcDevice* device, bool imageOnly, qcLayers** result)
{
    qcDeviceInfo info;
    QC_TRY(qcDevice_GetInfo(device, &info));
    qcLayers* layers = qcAllocateZeroed(sizeof *layers);
    if (layers == NULL)
        return qcFailMemory(sizeof *layers, "layers");
    layers->device = device;
    layers->generation = qcDevice_GetGeneration(device);
    layers->imageOnly = imageOnly;
    layers->maxWait = info.software ? s_maxSoftwareWait : s_maxWait;
    qcStatus status = qcDevice_RunIn(device, layers->generation, CreateObjects, layers, "layers, set-up");
    if (status != qc_statusOk)
    {
        qcLayers_Destroy(layers);
        return status;
    }
    *result = layers;
    return qc_statusOk;
}

void qcLayers_Destroy(qcLayers* layers)
{
    if (layers == NULL)
        return;
    // Called after failures too: the message of the first failure stays. Names of objects of an earlier context may
    // belong to other objects in the present one, so these are not deleted.
    char message[512];
    snprintf(message, sizeof message, "%s", qcLastMessage());
    if (qcLayers_IsAlive(layers) &&
        qcDevice_RunIn(layers->device, layers->generation, DeleteObjects, layers, "layers, release") != qc_statusOk)
        qcFail(qc_statusDevice, "%s", message);
    qcArray_Free(&layers->stream.staging);
    qcFree(layers, sizeof *layers);
}

static void KeepStep(qcLayers* layers, const qcLayersStep* step)
{
    assert(step->cellsLog2[0] <= 12 && step->cellsLog2[1] <= 12 && step->cellsLog2[2] <= 12);
    assert(step->cellsLog2[0] + step->cellsLog2[1] + step->cellsLog2[2] <= 24);
    layers->step = *step;
}

static void TakeAnswer(qcLayers* layers, qcLayersAnswer* answer)
{
    *answer = layers->answer;
    if (!layers->step.timed)
        return;
    layers->timers.threadMs[qc_partHandBack] = qcClock_Now() - layers->timers.clock;
    answer->threadMs = layers->timers.threadMs;
    answer->deviceMs = layers->timers.deviceMs;
}

qcStatus qcLayers_Run(qcLayers* layers, const qcLayersStep* step, qcLayersAnswer* answer)
{
    KeepStep(layers, step);
    QC_TRY(qcDevice_RunIn(layers->device, layers->generation, RunJob, layers, "layers"));
    TakeAnswer(layers, answer);
    return qc_statusOk;
}
