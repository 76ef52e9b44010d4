// `layers` on the device: compute kernels from vertices to pairs of triangles, or to the image, which keeps for each
// pixel and slice of depth a list of the nodes that cover it (after Yang et al.: Real-Time Concurrent Linked List
// Construction on the GPU, 2010). A step is one submission and one wait. The README.md of this room lists the kernels.
// Proof that no pair is lost: plugin/docs/proofs/layers.md.
#include "gl/layers/layers_gpu.h"

#include "base/clock.h"
#include "gl/device.h"
#include "gl/layers/layers_buffers.h"
#include "gl/layers/layers_kernels.h"
#include "gl/layers/layers_stream.h"
#include "gl/timers.h"
#include "base/status.h"

#include <assert.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>

enum
{
    // No kernel adds 2^31 items at once, and each notices a counter that has reached 2^31: none wraps around unseen.
    qc_maxItems = 1 << 25,
    qc_maxReruns = 64,
    // Calls for each job in device.c, beside those that are counted here: for errors, unless there can be none.
    qc_callsOfJob = 1,
    qc_spareItems = 4096,
    // Bytes of an element of qc_workNodePairs.
    qc_nodePairBytes = 16,
    // Words that an invocation of the first kernel resets or copies.
    qc_resetShare = 8,
    // Workgroups that compare tiles, where there are few tiles: a GPU of 132 multiprocessors runs half as many at a
    // time.
    qc_comparingGroups = 2048,
    // Workgroups that find pairs of triangles, while each takes few pairs of nodes (H200: a folded cloth of 20 K
    // triangles has 2300 pairs of nodes, 4 a workgroup, a tangled one of 92 K has 15 000, 8 a workgroup).
    qc_pairingGroups = 2560,
    // With as many pairs of triangles or more the device puts them in order: that takes a GPU some 10 microseconds, and
    // a processor 12 for a thousand. Buckets are many, since pairs lie in few places: of the bench's tangles and piles
    // none has more than 500 pairs, on average 14 to 60.
    qc_minOrdered = 4096,
    qc_pairsOfBucket = 64,
    qc_minBuckets = 1024,
    qc_maxBuckets = 4096,
    // Rounds of a workgroup that goes through a list, so that no implementation stops its loops after 65 535
    // iterations: a round of triangle pairs has up to 564.
    qc_maxRounds = 32
};

// Nanoseconds: a device that needs more is lost. Software GL compiles its first kernels on cores that others use, too.
static const GLuint64 s_maxWait = 10000000000u, s_maxSoftwareWait = 60000000000u;

/// The lists whose items are counted.
typedef enum List
{
    list_entries,   ///< for the image
    list_nodePairs, ///< for pairs, and all that follow
    list_trianglePairs,
    list_survivors,
    list_count
} List;

static const int s_lists[list_count] = {qc_workEntries, qc_workNodePairs, qc_workTrianglePairs, qc_workResults};
/// Room in a list's buffer that is none of the list's: for the item that doesn't fit, and for the counters.
static const uint32_t s_reserved[list_count] = {1, 1, 1, 1 + qc_counterWords / 2};

static const int s_kernelParts[qc_kernelCount] = {qc_partVertices,  qc_partBoxes,     qc_partNodes,
                                                  qc_partNodes,     qc_partNodePairs, qc_partTrianglePairs,
                                                  qc_partPairTests, qc_partOrder};

/// A counter as the kernels define it (common.glsl), on a cache line of its own.
typedef struct Counter
{
    uint32_t count, unused[15];
} Counter;

typedef struct Counters
{
    Counter lists[list_count], skippedNodes, stopped, overflow, finished, unordered;
} Counters;
_Static_assert(sizeof(Counters) == qc_counterWords * sizeof(uint32_t), "the counters of the kernels");

struct qcLayers
{
    qcDevice* device;
    uint32_t generation; ///< of the device
    bool imageOnly;
    qcLayersBuffers buffers;
    qcLayersStream stream;
    qcLayersKernels kernels;
    Counters counters;                 ///< of the last run
    uint32_t listRoom[list_count];     ///< elements of its buffer that a list has: buckets may need a larger one
    uint32_t bucketCount, bucketShift; ///< of the step; 0 buckets: pairs stay in no order
    uint32_t runNumber;                ///< of the last run; the last kernel writes it to `finished`
    GLsync fence;                      ///< of the run on the device; null: there is none
    bool showsErrors;                  ///< the run has no call whose failure its answer would not show
    qcGlTimers timers;
    GLuint64 maxWait;  ///< for a run
    qcLayersStep step; ///< the last one begun
    qcLayersAnswer answer;
};

static qcStatus CreateObjects(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    layers->kernels.imageOnly = layers->buffers.imageOnly = layers->imageOnly;
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

//  ---- a step's data -----------------------------------------------------------------------------------------------

/// Words from the start of a step's data.
typedef struct Places
{
    size_t nodes, chunks, floats, end; ///< parameters are the first, then bodies
} Places;

static Places FindPlaces(const qcLayersStep* step)
{
    Places p = {.nodes = qc_parameterWords + step->bodyCount * (sizeof(qcLayersBody) / sizeof(uint32_t))};
    p.chunks = p.nodes + step->activeCount;
    p.floats = p.chunks + step->chunkCount * (sizeof(qcLayersChunk) / sizeof(uint32_t));
    p.end = p.floats + step->floatCount;
    return p;
}

static uint32_t TileCount(const qcLayersStep* step)
{
    return (step->activeCount + qc_tileNodes - 1) / qc_tileNodes;
}

/// Workgroups that compare one tile with others: many, so that few wait for one, but no more than pay.
static uint32_t PartsOfTile(uint32_t tiles)
{
    uint32_t min = (tiles + qc_nodeComparers - 1) / qc_nodeComparers, max = tiles;
    uint32_t count = tiles != 0 ? qc_comparingGroups / tiles : 0;
    count = count < max ? count : max;
    return count > min ? count : min;
}

/// Words of qc_workLists between the counters and the buckets.
static uint32_t ListWords(const qcLayers* layers, const qcLayersStep* step)
{
    return layers->imageOnly ? 1u << (step->cellsLog2[0] + step->cellsLog2[1] + step->cellsLog2[2])
                             : TileCount(step) * qc_tileWords;
}

/// Word of qc_workLists.
static uint32_t BucketsAt(const qcLayers* layers, const qcLayersStep* step)
{
    return qc_counterWords + ListWords(layers, step);
}

/// Chunks whose floats lie in the stream.
static uint32_t OwnChunkCount(const qcLayersStep* step)
{
    uint32_t count = step->chunkCount;
    for (uint32_t i = 0; i < step->sourceCount; i++)
        count -= step->sources[i].chunkCount;
    return count;
}

/// Bytes that the processor writes for a step, beside its uploads and parameters.
static size_t StepBytes(const qcLayersStep* step)
{
    return (FindPlaces(step).end - qc_parameterWords) * sizeof(uint32_t) + step->vertexCount * sizeof(qcPoint);
}

/// The number of items that a list holds.
static uint32_t ListCapacity(const qcLayers* layers, List list)
{
    return layers->listRoom[list] > s_reserved[list] ? layers->listRoom[list] - s_reserved[list] : 0;
}

static uint32_t CountOf(const qcLayers* layers, List list)
{
    return layers->counters.lists[list].count;
}

/// For about as many pairs as in the last run.
static void ChooseBuckets(qcLayers* layers)
{
    uint32_t pairs = CountOf(layers, list_survivors), last = layers->step.triangleCount - 1, buckets = qc_minBuckets;
    layers->bucketCount = layers->bucketShift = 0;
    if (layers->imageOnly || pairs < qc_minOrdered)
        return;
    while (buckets < qc_maxBuckets && pairs / qc_pairsOfBucket > buckets)
        buckets *= 2;
    while (last >> layers->bucketShift >= buckets)
        layers->bucketShift++;
    layers->bucketCount = (last >> layers->bucketShift) + 1;
}

/// About as many as in the last run.
static uint64_t ExpectedItems(const qcLayers* layers, List list)
{
    uint64_t capacity = ListCapacity(layers, list), last = CountOf(layers, list);
    uint64_t items = last != 0 ? last + last / 4 : capacity / 8;
    return items < capacity ? items : capacity;
}

/// Pairs of nodes that a workgroup takes at a time.
static uint32_t NodePairsOfGroup(const qcLayers* layers)
{
    uint32_t count = qc_minNodePairs;
    while (count < qc_maxNodePairs && ExpectedItems(layers, list_nodePairs) > (uint64_t)count * qc_pairingGroups)
        count *= 2;
    return count;
}

static void WriteParameters(const qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    Places p = FindPlaces(step);
    qcLayersParameters values = {.chunkCount = OwnChunkCount(step),
                                 .changedNodes = step->changedNodes,
                                 .activeNodes = step->activeCount,
                                 .runNumber = layers->runNumber,
                                 .entryCapacity = ListCapacity(layers, list_entries),
                                 .nodePairCapacity = ListCapacity(layers, list_nodePairs),
                                 .trianglePairCapacity = ListCapacity(layers, list_trianglePairs),
                                 .survivorCapacity = ListCapacity(layers, list_survivors),
                                 .listWords = ListWords(layers, step),
                                 .nodesAt = (uint32_t)p.nodes,
                                 .chunksAt = (uint32_t)p.chunks,
                                 .floatsAt = (uint32_t)p.floats,
                                 .nodeBoxesAt = (uint32_t)(qc_boxesOfNode * step->capacity[qc_layersNodes]),
                                 .partsOfTile = PartsOfTile(TileCount(step)),
                                 .nodePairsOfGroup = NodePairsOfGroup(layers),
                                 .testNeighbours = step->testNeighbours,
                                 .pointError = step->pointError,
                                 .queryDistance = step->queryDistance,
                                 .unit = step->frame.unit,
                                 .bucketCount = layers->bucketCount,
                                 .bucketShift = layers->bucketShift,
                                 .bucketsAt = BucketsAt(layers, step)};
    values.groupsAt = (uint32_t)(layers->buffers.capacity[qc_workNodeBoxes] / qc_texelsOfImageNode * 4);
    for (int i = 0; i < 3; i++)
    {
        values.cellShift[i] = 15 - step->cellsLog2[i];
        values.axes[i] = (uint32_t)step->frame.axes[i];
        values.origin[i] = step->frame.origin[i];
    }
    memcpy(values.scale, step->scale, sizeof values.scale);
    memcpy(values.slack, step->slack, sizeof values.slack);
    memcpy(qcLayersStream_Data(&layers->stream), &values, sizeof values);
}

static void WriteStep(const qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    Places p = FindPlaces(step);
    uint32_t* words = (uint32_t*)(void*)qcLayersStream_Data(&layers->stream);
    memcpy(words + qc_parameterWords, step->bodies, step->bodyCount * sizeof(qcLayersBody));
    memcpy(words + p.nodes, step->activeNodes, step->activeCount * sizeof(uint32_t));
    if (step->chunkCount != 0)
        memcpy(words + p.chunks, step->chunks, step->chunkCount * sizeof(qcLayersChunk));
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
    size_t bytes = FindPlaces(opening->step).end * sizeof(uint32_t);
    if (bytes > layers->stream.size)
        QC_TRY(qcLayersStream_Grow(gl, &layers->stream, bytes));
    if (!qcLayers_SharesVertices(layers))
        return qc_statusOk;
    return qcLayersBuffers_Reserve(gl, &layers->buffers, qc_layersVertices, opening->step->capacity[qc_layersVertices]);
}

qcStatus qcLayers_Open(qcLayers* layers, const qcLayersStep* step, qcLayersMemory* memory)
{
    Places p = FindPlaces(step);
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

/// Whether the step fills a list.
static bool HasList(const qcLayers* layers, int list)
{
    return layers->imageOnly == (list == list_entries);
}

static void Run(const struct qcGlFunctions* gl, qcLayers* layers, qcLayersKernel kernel, uint64_t groups)
{
    qcLayersKernel last = layers->imageOnly          ? qc_kernelImageNodes
                          : layers->bucketCount != 0 ? qc_kernelOrder
                                                     : qc_kernelPairTests;
    qcLayersKernels_Run(gl, &layers->kernels, kernel, groups, kernel == last);
    qcGlTimers_Mark(gl, &layers->timers, s_kernelParts[kernel]);
}

/// Vertices in buffers of the caller's.
static void RunSources(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    uint32_t first = OwnChunkCount(step);
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
    size_t words = BucketsAt(layers, step) + (size_t)layers->bucketCount, copied = FindPlaces(step).chunks;
    words = copied > words && !layers->imageOnly ? copied : words;
    uint64_t chunks = OwnChunkCount(step), share = (uint64_t)qc_layersChunkSize * qc_resetShare;
    uint64_t groups = (words + share - 1) / share;
    if (qcLayers_SharesVertices(layers) && step->chunkCount == 0)
    {
        memset(lists, 0, qc_counterWords * sizeof(uint32_t));
        memset((uint32_t*)lists + qc_counterWords, 0xff, ListWords(layers, step) * sizeof(uint32_t));
        qcGlTimers_Mark(gl, &layers->timers, qc_partUpload);
        return;
    }
    Run(gl, layers, qc_kernelVertices, chunks > groups ? chunks : groups);
    RunSources(gl, layers);
}

/// Workgroups that go through a list, `share` items at a time: once each if there are as many as expected. Any number
/// gets to the end.
static uint64_t GroupsOfList(const qcLayers* layers, List list, uint32_t share)
{
    uint64_t expected = ExpectedItems(layers, list), min = ListCapacity(layers, list) / qc_maxRounds;
    return (expected > min ? expected : min) / share + 1;
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
    uint32_t tiles = TileCount(step);
    Run(gl, layers, qc_kernelNodes, step->activeCount);
    Run(gl, layers, qc_kernelNodePairs, (uint64_t)tiles * PartsOfTile(tiles));
    Run(gl, layers, qc_kernelTrianglePairs, GroupsOfList(layers, list_nodePairs, NodePairsOfGroup(layers)));
    Run(gl, layers, qc_kernelPairTests, GroupsOfList(layers, list_trianglePairs, qc_testsOfGroup));
    if (layers->bucketCount != 0)
        Run(gl, layers, qc_kernelOrder, layers->bucketCount);
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
    WriteParameters(layers);
    qcLayersStream_Submit(gl, &layers->stream, FindPlaces(&layers->step).end * sizeof(uint32_t));
    layers->showsErrors = ShowsErrors(gl, layers);
    if (gl->state->bound != layers)
        qcLayersBuffers_BindAll(gl, &layers->buffers, layers->stream.buffer);
    qcGlTimers_Mark(gl, &layers->timers, qc_partUpload);
    RunKernels(gl, layers);
    layers->fence = qcGl_Counted(gl)->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    qcGl_KeepBindings(gl, layers);
}

static qcStatus ReserveElements(const struct qcGlFunctions* gl, qcLayers* layers, int buffer, size_t count)
{
    bool fits = count <= layers->buffers.capacity[buffer];
    return fits ? qc_statusOk : qcLayersBuffers_Resize(gl, &layers->buffers, buffer, count);
}

/// Makes room for a list of `count` elements, and a quarter more if it grows.
static qcStatus ReserveList(const struct qcGlFunctions* gl, qcLayers* layers, List list, size_t count)
{
    if (count <= layers->listRoom[list])
        return qc_statusOk;
    QC_TRY(ReserveElements(gl, layers, s_lists[list], count + count / 4));
    layers->listRoom[list] = (uint32_t)(count + count / 4);
    return qc_statusOk;
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
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workLists, BucketsAt(layers, step) + (size_t)layers->bucketCount));
    QC_TRY(qcLayersBuffers_Reserve(gl, b, qc_workStep, imageOnly ? 0 : FindPlaces(step).chunks));
    // Items per node that a folded cloth needs, and enough for most small scenes; one that needs more takes one more
    // run.
    static const size_t s_itemsPerNode[list_count] = {4, 12, 64, 8};
    // Never empty: a block of a kernel needs a buffer.
    for (int list = 0; list < list_count; list++)
        QC_TRY(ReserveList(gl, layers, (List)list,
                           HasList(layers, list) ? s_itemsPerNode[list] * nodes + qc_spareItems : 1));
    // At most 16 MiB, which each GL allows.
    return ReserveElements(gl, layers, qc_workNodePairs,
                           (size_t)layers->bucketCount * qc_bucketSize * sizeof(uint64_t) / qc_nodePairBytes);
}

static qcStatus SubmitStep(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = &layers->step;
    gl->state->calls = 0;
    qcGlTimers_Begin(gl, &layers->timers, step->timed, step->started, qc_partHandOver);
    layers->answer = (qcLayersAnswer){.uploadedBytes = StepBytes(step)};
    ChooseBuckets(layers);
    QC_TRY(ReserveAll(gl, layers));
    for (size_t i = 0; i < step->uploadCount; i++)
        layers->answer.uploadedBytes += qcLayersBuffers_Upload(gl, &layers->buffers, &step->uploads[i]);
    WriteStep(layers);
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
    memcpy(&layers->counters, counters, sizeof layers->counters);
    qcGlTimers_MarkPassed(&layers->timers);
    qcGlTimers_Mark(gl, &layers->timers, qc_partWait);
    return qc_statusOk;
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
    for (int list = 0; list < list_count; list++)
    {
        uint32_t count = CountOf(layers, (List)list);
        if (!HasList(layers, list))
            continue;
        if (count > qc_maxItems || layers->counters.overflow.count != 0)
            return qcFail(qc_statusDevice, "layers: more than %d pairs in one list", qc_maxItems);
        if (count <= ListCapacity(layers, (List)list))
            continue;
        QC_TRY(ReserveList(gl, layers, (List)list, (size_t)count + s_reserved[list] + 1));
        *again = true;
    }
    return qc_statusOk;
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
        .entryCount = CountOf(layers, list_entries),
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
    layers->answer.pairCount = CountOf(layers, list_survivors);
    return qc_statusOk;
}

/// Waits, and repeats the run until every list has room.
static qcStatus FinishStep(const struct qcGlFunctions* gl, qcLayers* layers)
{
    qcLayersAnswer* answer = &layers->answer;
    bool again = true;
    QC_TRY(Wait(gl, layers));
    // Seen with zink (Mesa 22.3) in one run of some twenty, where another context shares objects: the cause is unknown.
    if (layers->counters.finished.count != layers->runNumber && layers->step.sourceCount != 0)
    {
        Submit(gl, layers);
        QC_TRY(Wait(gl, layers));
        answer->reruns++;
    }
    QC_TRY(GrowLists(gl, layers, &again));
    for (; again; answer->reruns++)
    {
        if (answer->reruns == qc_maxReruns)
            return qcFail(qc_statusDevice, "layers: the device does not finish");
        Submit(gl, layers);
        QC_TRY(Wait(gl, layers));
        QC_TRY(GrowLists(gl, layers, &again));
    }
    gl->state->isAnswered = true;
    gl->state->hasNoErrors = layers->showsErrors;
    QC_TRY(layers->imageOnly ? ReadImage(gl, layers) : ReadPairs(gl, layers));
    answer->entries = CountOf(layers, list_entries);
    answer->trianglePairs = CountOf(layers, list_trianglePairs);
    answer->skippedNodes = layers->counters.skippedNodes.count;
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
