// `layers` on the device: compute kernels from vertices to pairs of triangles. Where the paper asks whether a fragment
// is visible, the image here keeps, for each pixel and slice of depth, a list of all that covers it with its intervals,
// and asks which of them overlap. After per-pixel linked lists (Yang et al.: Real-Time Concurrent Linked List
// Construction on the GPU, 2010).
//
//   vertices        rigid bodies into the frame
//   boxes           triangles and clusters of 8, rounded outward to 15-bit levels
//   nodes           nodes of 64; each into the list of every cell (a slice of a pixel) it covers
//   node_pairs      entries of one list that overlap, once, in the first cell both cover
//   cluster_pairs   8 x 8 boxes, in registers
//   triangle_pairs  8 x 8 boxes, neighbours masked out by table
//   filter          separating axes
//
// The last four make sense on a GPU. Where GL is the processor itself, its vectors do the same without four more
// dispatches and in fewer instructions (a whole step of the folded cloth of 20 K of qc-bench peers on llvmpipe, AVX2:
// 12 instead of 22 million): there the answer is the image, with boxes laid as the processor's kernels
// (kernels/triangle_kernels.h) want them, and cull/layers/cpu_refine.c reads it.
//
// Why no pair within the reach r is lost. All lengths are in units of the frame; t is the true coordinate of a vertex,
// x the one in the buffer, |x - t| <= e (pointError). Floating-point operations are taken to be right to one unit in
// the last place, which any rounding mode gives, fused or not, and denormals to be zero.
//
// - Levels. g = x * scale is at most 2^15, so that the product is wrong by at most 2^-8. If A and B are within r, then
//   for every axis there are points of both whose coordinates differ by at most r. So lower(A) <= upper(B) in g's units
//   as soon as both boxes have grown by slack = (e + r / 2) * scale + 2^-8 and by the rounding of that growth itself,
//   2^-8; the caller adds 2^-6 in all. The diagonal (gx + gy) / 2 moves by at most half the sum of what x and y move;
//   its sum rounds once more. Clamping and truncation to whole levels are monotone and the same for both, so that lower
//   <= upper stays. Where there is no triangle, the box has lower ends 32767 and upper ends 0: it meets no box, since
//   none is clamped below 1.
// - Boxes of clusters and nodes are least and greatest levels of what they hold: overlap of parts is overlap of wholes.
// - Cells are runs of 2^cellShift levels along each axis: overlapping boxes share the cell of the greater of their
//   lower ends in x, y and z, both have an entry in its list, and there the pair is met: the entry that comes first in
//   the list finds the other further on. In any other cell the two are not this pair's first, so it is found once. A
//   node with itself needs no list.
// - The masks leave out the pairs that the rules leave out (a table is of the topology alone) and nothing else.
// - Filter. For any vector w, if the projections on w of all points of A and all points of B are further apart than
//   r |w|, so are the triangles. The vertices are taken relative to one of them and scaled by a power of two s,
//   exactly, so that the largest coordinate is in [1, 2): each is wrong by 2 e s + 2^-22. A product of three terms with
//   w is then wrong by at most |w|_1 (2 e s + 2^-22 + 4 * 2 * 2^-23), the difference of two such by twice that and its
//   own rounding |w|_1 2^-21: together |w|_1 (4 e s + 2.9e-6). The kernel requires a gap of |w|_1 ((4 e + r) s 1.0001 +
//   4e-6), and |w|_1 >= |w|. All products are with the same w: `precise`, as GLSL may round each use of an expression
//   differently. Axes shorter than 1e-20, where products could vanish, don't count.
// - Lists. Each kernel counts what it would write, whether it fits or not; what was too small grows, and the kernels
//   run again. Loops that an implementation stopped early are noticed, and kernels that did not run, since the last one
//   writes the number of the run beside the counters: then the step fails, and the sweep answers. The counters also
//   make the number of workgroups that the next kernel starts.
#include "gl/layers/layers_gpu.h"

#include "base/clock.h"
#include "gl/device.h"
#include "gl/gl_functions.h"
#include "gl/timers.h"
#include "layers_shaders.h"
#include "base/status.h"

#include <assert.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

typedef enum WorkBuffer
{
    work_boxes = qc_layersInputCount,
    work_clusterBoxes,
    work_nodeBoxes,
    work_nodeGroups,
    work_entries,
    work_nodePairs,
    work_nodePairTables,
    work_clusterPairs,
    work_trianglePairs,
    work_survivors,
    work_heads,
    work_counters,
    work_end
} WorkBuffer;

typedef struct BufferShape
{
    const char* sampler; ///< name in the kernels; null: not sampled
    uint32_t elementSize;
    GLenum format;
} BufferShape;

static const BufferShape s_shapes[work_end] = {
    [qc_layersVertices] = {"vertices", 16, GL_RGBA32F},
    [qc_layersLocals] = {"locals", 16, GL_RGBA32UI},
    [qc_layersTriangles] = {"triangles", 16, GL_RGBA32UI},
    [qc_layersNodes] = {"nodes", 16, GL_RGBA32UI},
    [qc_layersLinks] = {"links", 8, GL_RG32UI},
    [qc_layersTables] = {"tables", 8, GL_RG32UI},
    [qc_layersBodies] = {"bodies", 16, GL_RGBA32UI},
    [qc_layersActiveNodes] = {"activeNodes", 4, GL_R32UI},
    [qc_layersChunks] = {"chunks", 4, GL_R32UI},
    [work_boxes] = {"boxes", 16, GL_RGBA32UI},
    [work_clusterBoxes] = {"clusterBoxes", 16, GL_RGBA32UI},
    [work_nodeBoxes] = {"nodeBoxes", 16, GL_RGBA32UI},
    [work_nodeGroups] = {NULL, sizeof(qcBox8), 0},
    [work_entries] = {"entries", 16, GL_RGBA32UI},
    [work_nodePairs] = {"nodePairs", 8, GL_RG32UI},
    [work_nodePairTables] = {"nodePairTables", 4, GL_R32UI},
    [work_clusterPairs] = {"clusterPairs", 4, GL_R32UI},
    [work_trianglePairs] = {"trianglePairs", 4, GL_R32UI},
    [work_survivors] = {NULL, 8, 0},
    [work_heads] = {NULL, 4, 0},
    [work_counters] = {"counted", 4, GL_R32UI},
};

typedef enum Kernel
{
    kernel_vertices,
    kernel_boxes,
    kernel_nodes,
    kernel_nodePairs,
    kernel_clusterPairs,
    kernel_trianglePairs,
    kernel_filter,
    kernel_count
} Kernel;

enum
{
    qc_mostOutputs = 5
};

typedef struct KernelShape
{
    const char* name;
    const char* groupsName; ///< of another program, for the image only; null: the same
    const char* source;
    int localSize; ///< invocations of a workgroup; fewer where items are few, for all threads to have some
    WorkBuffer outputs[qc_mostOutputs]; ///< bindings from 1 on; work_end: no more
} KernelShape;

static const KernelShape s_kernels[kernel_count] = {
    [kernel_vertices] = {"layers, vertices", NULL, s_layersVertices, 64, {(WorkBuffer)qc_layersVertices, work_end}},
    [kernel_boxes] = {"layers, boxes", "layers, groups", s_layersBoxes, 64, {work_boxes, work_clusterBoxes, work_end}},
    [kernel_nodes] = {"layers, nodes",
                      "layers, nodes and groups",
                      s_layersNodes,
                      16,
                      {work_nodeBoxes, work_heads, work_entries, work_nodePairs, work_nodeGroups}},
    [kernel_nodePairs] = {"layers, node pairs", NULL, s_layersNodePairs, 16, {work_nodePairs, work_end}},
    [kernel_clusterPairs] =
        {"layers, cluster pairs", NULL, s_layersClusterPairs, 16, {work_clusterPairs, work_nodePairTables, work_end}},
    [kernel_trianglePairs] =
        {"layers, triangle pairs", NULL, s_layersTrianglePairs, 64, {work_trianglePairs, work_end}},
    [kernel_filter] = {"layers, filter", NULL, s_layersFilter, 64, {work_survivors, work_end}},
};

static const qcLayersPart s_kernelParts[kernel_count] = {qc_partVertices,  qc_partBoxes,        qc_partNodes,
                                                         qc_partNodePairs, qc_partClusterPairs, qc_partTrianglePairs,
                                                         qc_partFilter};

typedef enum UniformName
{
    uniform_chunkCount,
    uniform_nodeCount,
    uniform_entryCapacity,
    uniform_nodePairCapacity,
    uniform_clusterPairCapacity,
    uniform_trianglePairCapacity,
    uniform_survivorCapacity,
    uniform_testNeighbours,
    uniform_runNumber,
    uniform_integers, ///< those above are
    uniform_cellShift = uniform_integers,
    uniform_scale,
    uniform_slack,
    uniform_pointError,
    uniform_reach,
    uniform_count
} UniformName;

static const char* const s_uniforms[uniform_count] = {"chunkCount",
                                                      "nodeCount",
                                                      "entryCapacity",
                                                      "nodePairCapacity",
                                                      "clusterPairCapacity",
                                                      "trianglePairCapacity",
                                                      "survivorCapacity",
                                                      "testNeighbours",
                                                      "runNumber",
                                                      "cellShift",
                                                      "scale",
                                                      "slack",
                                                      "pointError",
                                                      "reach"};

enum
{
    qc_groupsInRow = 1 << 15, ///< workgroups, of a dispatch
    // A list's word holds the item before it and six bits; and an item makes at most 64 of the next list, so that no
    // counter runs over. (What can, entries and pairs of nodes, is watched by its kernel.)
    qc_mostItems = 1 << 25,
    qc_mostReruns = 64
};

/// The lists whose items are counted.
typedef enum List
{
    list_entries,
    list_nodePairs,
    list_clusterPairs,
    list_trianglePairs,
    list_survivors,
    list_count
} List;

static const WorkBuffer s_lists[list_count] = {work_entries, work_nodePairs, work_clusterPairs, work_trianglePairs,
                                               work_survivors};

/// The counters as the kernels know them, each on a cache line of its own.
typedef struct Counter
{
    uint32_t count, groups[3], unused[12]; ///< groups: of a list, the workgroups of the kernel that takes it
} Counter;

typedef struct Counters
{
    Counter lists[list_count], skippedNodes, stopped, overflow, finished;
} Counters;

struct qcLayers
{
    qcDevice* device;
    uint32_t generation; ///< of the device
    bool imageOnly;
    GLuint buffers[work_end], textures[work_end], programs[kernel_count];
    GLint uniforms[kernel_count][uniform_count];
    size_t capacity[work_end]; ///< elements
    size_t largestBuffer;      ///< bytes that a kernel can see
    size_t largestTexture;     ///< elements
    Counters counters;         ///< of the last run
    uint32_t runNumber;        ///< of the last run, from 1; the last kernel writes it to `finished`
    bool mapped;               ///< the buffers of s_mapped are, for the image
    qcArray pairs;
    qcGlTimers timers;
    double started; ///< when the calling thread handed the step over
    const qcLayersStep* step;
    qcLayersAnswer* answer;
};

static qcStatus CheckError(const struct qcGlFunctions* gl, const char* place)
{
    GLenum error = gl->GetError();
    return error == GL_NO_ERROR ? qc_statusOk
                                : qcFail(qc_statusDevice, "layers: %s: %s (0x%x)", place, qcGl_ErrorName(error), error);
}

static qcStatus Resize(const struct qcGlFunctions* gl, qcLayers* layers, int buffer, size_t count)
{
    const BufferShape* shape = &s_shapes[buffer];
    size_t bytes = count * shape->elementSize;
    if (bytes > layers->largestBuffer || (shape->sampler != NULL && count > layers->largestTexture))
        return qcFail(qc_statusDevice, "layers: %zu %s are more than the device's buffers hold", count,
                      shape->sampler != NULL ? shape->sampler : "pairs");
    // An error of an earlier call is reported as such, and not taken for the allocation's.
    QC_TRY(CheckError(gl, "before an allocation"));
    layers->capacity[buffer] = 0;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers[buffer]);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, NULL, GL_DYNAMIC_COPY);
    char purpose[64];
    snprintf(purpose, sizeof purpose, "no memory for %zu bytes on the device", bytes);
    QC_TRY(CheckError(gl, purpose));
    layers->capacity[buffer] = count;
    if (shape->sampler != NULL)
    {
        gl->ActiveTexture(GL_TEXTURE0 + (GLenum)buffer);
        gl->BindTexture(GL_TEXTURE_BUFFER, layers->textures[buffer]);
        gl->TexBuffer(GL_TEXTURE_BUFFER, shape->format, layers->buffers[buffer]);
    }
    return qc_statusOk;
}

static qcStatus Reserve(const struct qcGlFunctions* gl, qcLayers* layers, int buffer, size_t count)
{
    // Never empty: a texture wants a buffer behind it.
    count = count > 0 ? count : 1;
    return count <= layers->capacity[buffer] ? qc_statusOk : Resize(gl, layers, buffer, count + count / 4);
}

static void Upload(const struct qcGlFunctions* gl, qcLayers* layers, int buffer, size_t first, size_t count,
                   const void* data)
{
    size_t size = s_shapes[buffer].elementSize;
    assert(first + count <= layers->capacity[buffer]);
    if (count == 0)
        return;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers[buffer]);
    gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, (GLintptr)(first * size), (GLsizeiptr)(count * size), data);
    layers->answer->uploadedBytes += count * size;
}

static int KernelCount(const qcLayers* layers)
{
    return layers->imageOnly ? kernel_nodes + 1 : kernel_count;
}

/// Lists up to the one whose items are the answer.
static int ListCount(const qcLayers* layers)
{
    return layers->imageOnly ? list_entries + 1 : list_count;
}

static qcStatus GetProgram(const struct qcGlFunctions* gl, qcLayers* layers, int kernel)
{
    char constants[256];
    bool grouped = layers->imageOnly && s_kernels[kernel].groupsName != NULL;
    snprintf(constants, sizeof constants,
             "#version 430 core\n%s#define BODY_TEXELS %d\n#define GROUPS_IN_ROW %du\n#define LOCAL_SIZE %d\n"
             "#define TAKER_SIZES uint[4](%du, %du, %du, %du)\n",
             grouped ? "#define IMAGE_ONLY\n" : "", qc_layersBodyTexels, qc_groupsInRow, s_kernels[kernel].localSize,
             s_kernels[kernel_nodePairs].localSize, s_kernels[kernel_clusterPairs].localSize,
             s_kernels[kernel_trianglePairs].localSize, s_kernels[kernel_filter].localSize);
    const char* sources[] = {constants, s_layersCommon, s_kernels[kernel].source};
    GLuint program;
    const char* name = grouped ? s_kernels[kernel].groupsName : s_kernels[kernel].name;
    QC_TRY(qcGlFunctions_GetComputeProgram(gl, name, sources, 3, &program));
    layers->programs[kernel] = program;
    gl->UseProgram(program);
    for (int buffer = 0; buffer < work_end; buffer++)
        if (s_shapes[buffer].sampler != NULL)
            gl->Uniform1i(gl->GetUniformLocation(program, s_shapes[buffer].sampler), buffer);
    for (int i = 0; i < uniform_count; i++)
        layers->uniforms[kernel][i] = gl->GetUniformLocation(program, s_uniforms[i]);
    return qc_statusOk;
}

static qcStatus CreateObjects(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    if (gl->DispatchCompute == NULL)
        return qcFail(qc_statusDevice, "layers: the device has no compute shaders (GL below 4.3)");
    // 64 bits: the limits of some GPUs are 2^31 and more.
    GLint64 bytes = 0, texels = 0;
    gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    gl->GetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    layers->largestBuffer = bytes > 0 ? (size_t)bytes : 0;
    layers->largestTexture = texels > 0 ? (size_t)texels : 0;
    gl->GenBuffers(work_end, layers->buffers);
    gl->GenTextures(work_end, layers->textures);
    for (int kernel = 0; kernel < KernelCount(layers); kernel++)
        QC_TRY(GetProgram(gl, layers, kernel));
    return Resize(gl, layers, work_counters, sizeof(Counters) / s_shapes[work_counters].elementSize);
}

bool qcLayers_IsAlive(const qcLayers* layers)
{
    return layers != NULL && layers->generation == qcDevice_GetGeneration(layers->device);
}

static qcStatus DeleteObjects(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    qcGlTimers_Delete(gl, &layers->timers);
    gl->DeleteTextures(work_end, layers->textures);
    gl->DeleteBuffers(work_end, layers->buffers);
    return qc_statusOk;
}

static void BindAll(const struct qcGlFunctions* gl, const qcLayers* layers)
{
    for (int buffer = 0; buffer < work_end; buffer++)
        if (s_shapes[buffer].sampler != NULL)
        {
            gl->ActiveTexture(GL_TEXTURE0 + (GLenum)buffer);
            gl->BindTexture(GL_TEXTURE_BUFFER, layers->textures[buffer]);
        }
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, layers->buffers[work_counters]);
}

/// One less than there is room for; see common.glsl.
static GLuint ListCapacity(const qcLayers* layers, int buffer)
{
    return (GLuint)(layers->capacity[buffer] - 1);
}

static void SetUniforms(const struct qcGlFunctions* gl, const qcLayers* layers, int kernel, uint32_t nodeCount)
{
    const qcLayersStep* step = layers->step;
    const GLint* at = layers->uniforms[kernel];
    const GLuint values[uniform_integers] = {
        [uniform_chunkCount] = step->chunkCount,
        [uniform_nodeCount] = nodeCount,
        [uniform_entryCapacity] = ListCapacity(layers, work_entries),
        [uniform_nodePairCapacity] = ListCapacity(layers, work_nodePairs),
        [uniform_clusterPairCapacity] = ListCapacity(layers, work_clusterPairs),
        [uniform_trianglePairCapacity] = ListCapacity(layers, work_trianglePairs),
        [uniform_survivorCapacity] = ListCapacity(layers, work_survivors),
        [uniform_testNeighbours] = step->testNeighbours,
        [uniform_runNumber] = layers->runNumber,
    };
    for (int i = 0; i < uniform_integers; i++)
        if (at[i] >= 0)
            gl->Uniform1ui(at[i], values[i]);
    if (at[uniform_cellShift] >= 0)
        gl->Uniform3ui(at[uniform_cellShift], 15 - step->cellsLog2[0], 15 - step->cellsLog2[1],
                       15 - step->cellsLog2[2]);
    if (at[uniform_scale] >= 0)
        gl->Uniform3fv(at[uniform_scale], 1, step->scale);
    if (at[uniform_slack] >= 0)
        gl->Uniform4fv(at[uniform_slack], 1, step->slack);
    if (at[uniform_pointError] >= 0)
        gl->Uniform1f(at[uniform_pointError], step->pointError);
    if (at[uniform_reach] >= 0)
        gl->Uniform1f(at[uniform_reach], step->reach);
}

/// Makes a kernel the one to dispatch.
static void UseKernel(const struct qcGlFunctions* gl, const qcLayers* layers, int kernel, uint32_t nodeCount)
{
    const KernelShape* shape = &s_kernels[kernel];
    gl->UseProgram(layers->programs[kernel]);
    for (GLuint i = 0; i < qc_mostOutputs && shape->outputs[i] != work_end; i++)
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, i + 1, layers->buffers[shape->outputs[i]]);
    SetUniforms(gl, layers, kernel, nodeCount);
}

static void FinishKernel(const struct qcGlFunctions* gl, qcLayers* layers, int kernel)
{
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT |
                      GL_COMMAND_BARRIER_BIT);
    qcGlTimers_Mark(gl, &layers->timers, s_kernelParts[kernel]);
}

/// One invocation an item, or more; one workgroup at least, for the last kernel's mark.
static void RunKernel(const struct qcGlFunctions* gl, qcLayers* layers, int kernel, uint64_t items, uint32_t nodeCount)
{
    uint64_t localSize = (uint64_t)s_kernels[kernel].localSize, groups = (items + localSize - 1) / localSize;
    groups = groups > 0 ? groups : 1;
    UseKernel(gl, layers, kernel, nodeCount);
    gl->DispatchCompute((GLuint)(groups < qc_groupsInRow ? groups : qc_groupsInRow),
                        (GLuint)((groups + qc_groupsInRow - 1) / qc_groupsInRow), 1);
    FinishKernel(gl, layers, kernel);
}

/// One invocation for each item of a list: how many those are stays on the device until the end.
static void TakeList(const struct qcGlFunctions* gl, qcLayers* layers, List list)
{
    int kernel = kernel_nodePairs + (int)list;
    UseKernel(gl, layers, kernel, 0);
    gl->DispatchComputeIndirect((GLintptr)(list * sizeof(Counter) + offsetof(Counter, groups)));
    FinishKernel(gl, layers, kernel);
}

static uint32_t Count(const qcLayers* layers, List list)
{
    return layers->counters.lists[list].count;
}

/// The kernels from nodes on; they may run again.
static void RunLists(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const GLuint none = UINT32_MAX;
    layers->runNumber++;
    layers->counters = (Counters){0};
    for (int list = 0; list < list_survivors; list++)
        for (int axis = 0; axis < 3; axis++)
            layers->counters.lists[list].groups[axis] = 1;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers[work_counters]);
    gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof layers->counters, &layers->counters);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers[work_heads]);
    gl->ClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    gl->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, layers->buffers[work_counters]);
    qcGlTimers_Mark(gl, &layers->timers, qc_partClear);
    RunKernel(gl, layers, kernel_nodes, layers->step->activeNodes, layers->step->activeNodes);
    for (int list = 0; list < ListCount(layers) - 1; list++)
        TakeList(gl, layers, (List)list);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers[work_counters]);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof layers->counters, &layers->counters);
    qcGlTimers_MarkPassed(&layers->timers);
    qcGlTimers_Mark(gl, &layers->timers, qc_partCounters);
}

/// Makes room for what did not fit; `*again` says whether something did not.
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
        uint32_t count = Count(layers, (List)list);
        if (count > qc_mostItems || layers->counters.overflow.count != 0)
            return qcFail(qc_statusDevice, "layers: more than %d pairs in one list", qc_mostItems);
        if (count <= ListCapacity(layers, s_lists[list]))
            continue;
        QC_TRY(Resize(gl, layers, s_lists[list], count + count / 4 + 2));
        *again = true;
    }
    return qc_statusOk;
}

static void FillAnswer(qcLayers* layers)
{
    qcLayersAnswer* answer = layers->answer;
    answer->entries = Count(layers, list_entries);
    answer->trianglePairs = Count(layers, list_trianglePairs);
    answer->skippedNodes = layers->counters.skippedNodes.count;
    for (int buffer = 0; buffer < work_end; buffer++)
        answer->deviceBytes += layers->capacity[buffer] * s_shapes[buffer].elementSize;
}

static qcStatus ReadPairs(const struct qcGlFunctions* gl, qcLayers* layers)
{
    size_t count = Count(layers, list_survivors);
    QC_TRY(qcArray_Resize(&layers->pairs, 2 * count, sizeof(uint32_t), "pairs from the device"));
    if (count != 0)
    {
        gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers[work_survivors]);
        // No triangle's place: it must be overwritten.
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

static const int s_mapped[] = {work_entries, work_nodeBoxes, work_boxes, work_nodeGroups, qc_layersVertices};
enum
{
    qc_mappedCount = sizeof s_mapped / sizeof s_mapped[0]
};

static void Unmap(const struct qcGlFunctions* gl, qcLayers* layers)
{
    for (int i = 0; layers->mapped && i < qc_mappedCount; i++)
    {
        gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers[s_mapped[i]]);
        gl->UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
    }
    layers->mapped = false;
}

/// The image where it lies: what is the processor's own memory is not copied.
static qcStatus MapImage(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const void* data[qc_mappedCount];
    layers->mapped = true;
    for (int i = 0; i < qc_mappedCount; i++)
    {
        size_t bytes = layers->capacity[s_mapped[i]] * s_shapes[s_mapped[i]].elementSize;
        gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, layers->buffers[s_mapped[i]]);
        data[i] = gl->MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)bytes, GL_MAP_READ_BIT);
        if (data[i] == NULL)
            return qcFail(qc_statusDevice, "layers: the device's answer can't be read");
    }
    layers->answer->image = (qcLayersImage){.entries = data[0],
                                            .entryCount = Count(layers, list_entries),
                                            .nodeBoxes = data[1],
                                            .clusterGroups = data[2],
                                            .nodeGroups = data[3],
                                            .vertices = data[4]};
    return qc_statusOk;
}

/// Room for the step, as far as it can be known before.
static qcStatus ReserveAll(const struct qcGlFunctions* gl, qcLayers* layers)
{
    const qcLayersStep* step = layers->step;
    size_t nodes = step->capacity[qc_layersNodes];
    for (int buffer = 0; buffer < qc_layersInputCount; buffer++)
        QC_TRY(Reserve(gl, layers, buffer, step->capacity[buffer]));
    QC_TRY(Reserve(gl, layers, work_boxes, layers->imageOnly ? 48 * nodes : 64 * nodes));
    QC_TRY(Reserve(gl, layers, work_nodeGroups, layers->imageOnly ? nodes : 0));
    QC_TRY(Reserve(gl, layers, work_clusterBoxes, 8 * nodes));
    QC_TRY(Reserve(gl, layers, work_nodeBoxes, nodes));
    // Cleared as a whole: no larger than the image.
    size_t cells = (size_t)1 << (step->cellsLog2[0] + step->cellsLog2[1] + step->cellsLog2[2]);
    if (layers->capacity[work_heads] != cells)
        QC_TRY(Resize(gl, layers, work_heads, cells));
    // A folded cloth's needs; a scene that needs more runs once more.
    static const size_t s_needs[list_count] = {4, 12, 64, 64, 8};
    for (int list = 0; list < ListCount(layers); list++)
        QC_TRY(Reserve(gl, layers, s_lists[list], s_needs[list] * nodes + 64));
    return qc_statusOk;
}

static qcStatus RunStep(const struct qcGlFunctions* gl, void* context)
{
    qcLayers* layers = context;
    const qcLayersStep* step = layers->step;
    qcGlTimers_Begin(gl, &layers->timers, step->timed, layers->started, qc_partHandOver);
    Unmap(gl, layers);
    QC_TRY(ReserveAll(gl, layers));
    for (size_t i = 0; i < step->uploadCount; i++)
    {
        const qcLayersUpload* upload = &step->uploads[i];
        Upload(gl, layers, upload->buffer, upload->first, upload->count, upload->data);
    }
    BindAll(gl, layers);
    qcGlTimers_Mark(gl, &layers->timers, qc_partUpload);
    if (step->chunkCount != 0)
        RunKernel(gl, layers, kernel_vertices, 64 * (uint64_t)step->chunkCount, step->activeNodes);
    if (step->changedNodes != 0)
        RunKernel(gl, layers, kernel_boxes, 8 * (uint64_t)step->changedNodes, step->changedNodes);
    bool again = true;
    for (uint32_t run = 0; again; run++)
    {
        if (run == qc_mostReruns)
            return qcFail(qc_statusDevice, "layers: the device does not finish");
        layers->answer->reruns = run;
        QC_TRY(Reserve(gl, layers, work_nodePairTables, layers->imageOnly ? 0 : layers->capacity[work_nodePairs]));
        RunLists(gl, layers);
        QC_TRY(GrowLists(gl, layers, &again));
    }
    FillAnswer(layers);
    QC_TRY(layers->imageOnly ? MapImage(gl, layers) : ReadPairs(gl, layers));
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
    layers->imageOnly = imageOnly;
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
    // Called after failures too: the message of the first is the one to keep. Names of an earlier context may be those
    // of other objects in the present one.
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
