// `layers` on the device: compute kernels from vertices to pairs of triangles. The image keeps, for each pixel and
// slice of depth, a list of the nodes that cover it, and pairs are searched within a list. After per-pixel linked lists
// (Yang et al.: Real-Time Concurrent Linked List Construction on the GPU, 2010). The README.md of this room lists the
// kernels. Proof that no pair is lost: plugin/docs/proofs/layers.md.
#include "gl/layers/layers_gpu.h"

#include "base/clock.h"
#include "gl/device.h"
#include "gl/layers/layers_buffers.h"
#include "gl/layers/layers_kernels.h"
#include "gl/timers.h"
#include "base/status.h"

#include <assert.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

enum
{
    // A list's word holds the item that it comes from and six bits; an item yields at most 64 of the next list, so no
    // counter overflows. (Two counters can, of entries and of node pairs: their kernels check.)
    qc_maxItems = 1 << 25,
    qc_maxReruns = 64
};

/// The lists whose items are counted. List i is the input of kernel qc_kernelNodePairs + i.
typedef enum List
{
    list_entries,
    list_nodePairs,
    list_clusterPairs,
    list_trianglePairs,
    list_survivors,
    list_count
} List;

static const qcLayersWork s_lists[list_count] = {qc_workEntries, qc_workNodePairs, qc_workClusterPairs,
                                                 qc_workTrianglePairs, qc_workSurvivors};

static const qcLayersPart s_kernelParts[qc_kernelCount] = {qc_partVertices,  qc_partBoxes,        qc_partNodes,
                                                           qc_partNodePairs, qc_partClusterPairs, qc_partTrianglePairs,
                                                           qc_partFilter};

/// A counter as the kernels define it (common.glsl), on a cache line of its own.
typedef struct Counter
{
    uint32_t count, groups[3], unused[12]; ///< groups: for a list, the workgroups of the kernel that reads it
} Counter;

typedef struct Counters
{
    Counter lists[list_count], skippedNodes, stopped, overflow, finished;
} Counters;

struct qcLayers
{
    qcDevice* device;
    uint32_t generation; ///< of the device
    qcLayersBuffers buffers;
    qcLayersKernels kernels;
    Counters counters;  ///< of the last run
    uint32_t runNumber; ///< of the last run, from 1; the last kernel writes it to `finished`
    bool mapped;        ///< the buffers of s_mapped are, for the image
    qcArray pairs;
    qcGlTimers timers;
    double started; ///< time at which the calling thread handed the step over
    const qcLayersStep* step;
    qcLayersAnswer* answer;
};

static qcStatus CreateObjects(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    QC_TRY(qcLayersKernels_Create(gl, &layers->kernels));
    qcLayersBuffers_Create(gl, &layers->buffers);
    return qcLayersBuffers_Resize(gl, &layers->buffers, qc_workCounters,
                                  sizeof(Counters) / qcLayersBuffers_ElementSize(qc_workCounters));
}

bool qcLayers_IsAlive(const qcLayers* layers)
{
    return layers != NULL && layers->generation == qcDevice_GetGeneration(layers->device);
}

static qcStatus DeleteObjects(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    qcGlTimers_Delete(gl, &layers->timers);
    qcLayersBuffers_Delete(gl, &layers->buffers);
    return qc_statusOk;
}

//  ---- kernels -----------------------------------------------------------------------------------------------------

/// The number of lists, up to the one with the result.
static int ListCount(const qcLayers* layers)
{
    return layers->kernels.imageOnly ? list_entries + 1 : list_count;
}

static uint32_t CountOf(const qcLayers* layers, List list)
{
    return layers->counters.lists[list].count;
}

/// The number of items that a list holds, one less than the buffer's capacity: see WRITE_BITS in common.glsl.
static uint32_t ListCapacity(const qcLayers* layers, int buffer)
{
    return (uint32_t)(layers->buffers.capacity[buffer] - 1);
}

static qcLayersUniforms MakeUniforms(const qcLayers* layers, uint32_t nodeCount)
{
    const qcLayersStep* step = layers->step;
    qcLayersUniforms values = {
        .chunkCount = step->chunkCount,
        .nodeCount = nodeCount,
        .entryCapacity = ListCapacity(layers, qc_workEntries),
        .nodePairCapacity = ListCapacity(layers, qc_workNodePairs),
        .clusterPairCapacity = ListCapacity(layers, qc_workClusterPairs),
        .trianglePairCapacity = ListCapacity(layers, qc_workTrianglePairs),
        .survivorCapacity = ListCapacity(layers, qc_workSurvivors),
        .testNeighbours = step->testNeighbours,
        .runNumber = layers->runNumber,
        .pointError = step->pointError,
        .queryDistance = step->queryDistance,
    };
    for (int axis = 0; axis < 3; axis++)
        values.cellShift[axis] = 15 - step->cellsLog2[axis];
    memcpy(values.scale, step->scale, sizeof values.scale);
    memcpy(values.slack, step->slack, sizeof values.slack);
    return values;
}

static void RunKernel(const struct qcGlFunctions* gl, qcLayers* layers, qcLayersKernel kernel, uint64_t items,
                      uint32_t nodeCount)
{
    qcLayersUniforms values = MakeUniforms(layers, nodeCount);
    qcLayersKernels_Run(gl, &layers->kernels, &layers->buffers, kernel, &values, items);
    qcGlTimers_Mark(gl, &layers->timers, s_kernelParts[kernel]);
}

/// Runs the kernel that reads a list. The number of items stays on the device.
static void RunKernelOn(const struct qcGlFunctions* gl, qcLayers* layers, List list)
{
    qcLayersKernel kernel = (qcLayersKernel)(qc_kernelNodePairs + (int)list);
    qcLayersUniforms values = MakeUniforms(layers, 0);
    qcLayersKernels_RunIndirect(gl, &layers->kernels, &layers->buffers, kernel, &values,
                                list * sizeof(Counter) + offsetof(Counter, groups));
    qcGlTimers_Mark(gl, &layers->timers, s_kernelParts[kernel]);
}

/// Resets the counters and the lists' heads.
static void ClearLists(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const GLuint none = UINT32_MAX;
    const GLuint* buffers = layers->buffers.buffers;
    layers->runNumber++;
    layers->counters = (Counters){0};
    for (int list = 0; list < list_survivors; list++)
        for (int axis = 0; axis < 3; axis++)
            layers->counters.lists[list].groups[axis] = 1;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[qc_workCounters]);
    gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof layers->counters, &layers->counters);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[qc_workHeads]);
    gl->ClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    gl->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffers[qc_workCounters]);
    qcGlTimers_Mark(gl, &layers->timers, qc_partClear);
}

/// Runs the kernels from nodes on, and reads the counters. May be repeated.
static void RunLists(const struct qcGlFunctions* gl, qcLayers* layers)
{
    ClearLists(gl, layers);
    RunKernel(gl, layers, qc_kernelNodes, layers->step->activeNodes, layers->step->activeNodes);
    for (int list = 0; list < ListCount(layers) - 1; list++)
        RunKernelOn(gl, layers, (List)list);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers.buffers[qc_workCounters]);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof layers->counters, &layers->counters);
    qcGlTimers_MarkPassed(&layers->timers);
    qcGlTimers_Mark(gl, &layers->timers, qc_partCounters);
}

/// Checks the run, and makes room for lists that overflowed; `*again`: some did.
static qcStatus GrowLists(const struct qcGlFunctions* gl, qcLayers* layers, bool* again)
{
    *again = false;
    if (layers->counters.finished.count != layers->runNumber)
        return qcFail(qc_statusDevice, "layers: the device did not finish its kernels");
    if (layers->counters.stopped.count != 0)
        return qcFail(qc_statusDevice,
                      "layers: a cell's list, a node's cells or its links are more than the device's loops do");
    for (int list = 0; list < ListCount(layers); list++)
    {
        uint32_t count = CountOf(layers, (List)list);
        if (count > qc_maxItems || layers->counters.overflow.count != 0)
            return qcFail(qc_statusDevice, "layers: more than %d pairs in one list", qc_maxItems);
        if (count <= ListCapacity(layers, s_lists[list]))
            continue;
        QC_TRY(qcLayersBuffers_Resize(gl, &layers->buffers, s_lists[list], count + count / 4 + 2));
        *again = true;
    }
    return qc_statusOk;
}

//  ---- results -----------------------------------------------------------------------------------------------------

static void FillCounts(qcLayers* layers)
{
    qcLayersAnswer* answer = layers->answer;
    answer->entries = CountOf(layers, list_entries);
    answer->trianglePairs = CountOf(layers, list_trianglePairs);
    answer->skippedNodes = layers->counters.skippedNodes.count;
    answer->deviceBytes = qcLayersBuffers_ByteCount(&layers->buffers);
}

static qcStatus ReadPairs(const struct qcGlFunctions* gl, qcLayers* layers)
{
    size_t count = CountOf(layers, list_survivors);
    QC_TRY(qcArray_Resize(&layers->pairs, 2 * count, sizeof(uint32_t), "pairs from the device"));
    if (count != 0)
    {
        gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers.buffers[qc_workSurvivors]);
        // No triangle has this slot: it must be overwritten.
        uint32_t* last = &QC_AT(uint32_t, layers->pairs, 2 * count - 1);
        *last = QC_NO_TRIANGLE;
        gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)(2 * count * sizeof(uint32_t)),
                             layers->pairs.data);
        if (*last == QC_NO_TRIANGLE)
            return qcFail(qc_statusDevice, "layers: the device did not finish reading its pairs back");
    }
    layers->answer->pairs = layers->pairs.data;
    layers->answer->pairCount = count;
    return qc_statusOk;
}

static const int s_mapped[] = {qc_workEntries, qc_workNodeBoxes, qc_workBoxes, qc_workNodeGroups, qc_layersVertices};
enum
{
    qc_mappedCount = sizeof s_mapped / sizeof s_mapped[0]
};

static void UnmapImage(const struct qcGlFunctions* gl, qcLayers* layers)
{
    for (int i = 0; layers->mapped && i < qc_mappedCount; i++)
    {
        gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers.buffers[s_mapped[i]]);
        gl->UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
    }
    layers->mapped = false;
}

/// Maps the image instead of copying it: it lies in the processor's own memory.
static qcStatus MapImage(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const void* data[qc_mappedCount];
    layers->mapped = true;
    for (int i = 0; i < qc_mappedCount; i++)
    {
        size_t bytes = layers->buffers.capacity[s_mapped[i]] * qcLayersBuffers_ElementSize(s_mapped[i]);
        gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers.buffers[s_mapped[i]]);
        data[i] = gl->MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)bytes, GL_MAP_READ_BIT);
        if (data[i] == NULL)
            return qcFail(qc_statusDevice, "layers: the device's answer can't be read");
    }
    layers->answer->image = (qcLayersImage){.entries = data[0],
                                            .entryCount = CountOf(layers, list_entries),
                                            .nodeBoxes = data[1],
                                            .clusterGroups = data[2],
                                            .nodeGroups = data[3],
                                            .vertices = data[4]};
    return qc_statusOk;
}

//  ---- a step ------------------------------------------------------------------------------------------------------

/// Makes room for the step, as far as its sizes are known beforehand.
static qcStatus ReserveAll(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = layers->step;
    qcLayersBuffers* b = &layers->buffers;
    size_t nodes = step->capacity[qc_layersNodes];
    bool imageOnly = layers->kernels.imageOnly;
    for (int buffer = 0; buffer < qc_layersInputCount; buffer++)
        QC_TRY(qcLayersBuffers_Reserve(gl, b, buffer, step->capacity[buffer]));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workBoxes, imageOnly ? 48 * nodes : 64 * nodes));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workNodeGroups, imageOnly ? nodes : 0));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workClusterBoxes, 8 * nodes));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workNodeBoxes, nodes));
    // Cleared as a whole, so exactly as large as the image.
    size_t cells = (size_t)1 << (step->cellsLog2[0] + step->cellsLog2[1] + step->cellsLog2[2]);
    if (b->capacity[qc_workHeads] != cells)
        QC_TRY(qcLayersBuffers_Resize(gl, b, qc_workHeads, cells));
    // Items per node that a folded cloth needs; a scene that needs more takes one more run.
    static const size_t s_itemsPerNode[list_count] = {4, 12, 64, 64, 8};
    for (int list = 0; list < ListCount(layers); list++)
        QC_TRY(qcLayersBuffers_Reserve(gl, b, s_lists[list], s_itemsPerNode[list] * nodes + 64));
    return qc_statusOk;
}

static void UploadAll(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = layers->step;
    for (size_t i = 0; i < step->uploadCount; i++)
        layers->answer->uploadedBytes += qcLayersBuffers_Upload(gl, &layers->buffers, &step->uploads[i]);
}

/// Runs the kernels from nodes on until every list has room.
static qcStatus RunUntilListsFit(const struct qcGlFunctions* gl, qcLayers* layers)
{
    bool again = true;
    for (uint32_t run = 0; again; run++)
    {
        if (run == qc_maxReruns)
            return qcFail(qc_statusDevice, "layers: the device does not finish");
        layers->answer->reruns = run;
        QC_TRY(qcLayersBuffers_Reserve(gl, &layers->buffers, qc_workNodePairTables,
                                       layers->kernels.imageOnly ? 0 : layers->buffers.capacity[qc_workNodePairs]));
        RunLists(gl, layers);
        QC_TRY(GrowLists(gl, layers, &again));
    }
    return qc_statusOk;
}

static qcStatus RunStep(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    const qcLayersStep* step = layers->step;
    qcGlTimers_Begin(gl, &layers->timers, step->timed, layers->started, qc_partHandOver);
    UnmapImage(gl, layers);
    QC_TRY(ReserveAll(gl, layers));
    UploadAll(gl, layers);
    qcLayersBuffers_BindAll(gl, &layers->buffers);
    qcGlTimers_Mark(gl, &layers->timers, qc_partUpload);
    if (step->chunkCount != 0)
        RunKernel(gl, layers, qc_kernelVertices, 64 * (uint64_t)step->chunkCount, step->activeNodes);
    if (step->changedNodes != 0)
        RunKernel(gl, layers, qc_kernelBoxes, 8 * (uint64_t)step->changedNodes, step->changedNodes);
    QC_TRY(RunUntilListsFit(gl, layers));
    FillCounts(layers);
    QC_TRY(layers->kernels.imageOnly ? MapImage(gl, layers) : ReadPairs(gl, layers));
    qcGlTimers_Mark(gl, &layers->timers, qc_partResults);
    qcGlTimers_End(gl, &layers->timers);
    return qc_statusOk;
}

qcStatus qcLayers_Create(qcDevice* device, bool imageOnly, qcLayers** result)
{
    qcLayers* layers = qcAllocateZeroed(sizeof *layers);
    if (layers == NULL)
        return qcFailMemory(sizeof *layers, "layers");
    layers->device = device;
    layers->generation = qcDevice_GetGeneration(device);
    layers->kernels.imageOnly = imageOnly;
    qcStatus status = qcDevice_Run(device, CreateObjects, layers, "layers, set-up");
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
        qcDevice_Run(layers->device, DeleteObjects, layers, "layers, release") != qc_statusOk)
        qcFail(qc_statusDevice, "%s", message);
    qcArray_Free(&layers->pairs);
    qcFree(layers, sizeof *layers);
}

qcStatus qcLayers_Run(qcLayers* layers, const qcLayersStep* step, qcLayersAnswer* answer)
{
    assert(step->cellsLog2[0] <= 12 && step->cellsLog2[1] <= 12 && step->cellsLog2[2] <= 12);
    assert(step->cellsLog2[0] + step->cellsLog2[1] + step->cellsLog2[2] <= 24);
    *answer = (qcLayersAnswer){0};
    layers->step = step;
    layers->answer = answer;
    layers->started = step->timed ? qcClock_Now() : 0.0;
    QC_TRY(qcDevice_Run(layers->device, RunStep, layers, "layers"));
    if (!step->timed)
        return qc_statusOk;
    layers->timers.threadMs[qc_partHandBack] = qcClock_Now() - layers->timers.clock;
    answer->threadMs = layers->timers.threadMs;
    answer->deviceMs = layers->timers.deviceMs;
    return qc_statusOk;
}
