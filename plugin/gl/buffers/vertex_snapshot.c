// Copies, bounds, gathers and reads positions on the device.
#include "gl/buffers/vertex_snapshot.h"

#include "base/status.h"
#include "buffers_shaders.h"
#include "gl/compute.h"
#include "gl/device.h"
#include "gl/programs.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum
{
    qc_lanes = 64,
    qc_copiedPerGroup = 1024, ///< vertices; snapshot.comp
    qc_maxBefore = 1024,      ///< bytes before a range with which its binding may begin
    qc_positionBytes = 3 * sizeof(float),
    // More than a run has workgroups, and odd.
    qc_runSpacing = 50331653
};

/// The kernel's answer: see snapshot.comp.
typedef struct Bounds
{
    uint32_t lower[3], upper[3], firstBad, finished;
} Bounds;

typedef struct Copying
{
    qcVertexSnapshot* snapshot;
    const qcSnapshotSource* source;
    Bounds bounds;
} Copying;

static qcStatus Allocate(const struct qcGlFunctions* gl, GLuint* buffer, size_t bytes, const void* data, GLenum usage)
{
    if (*buffer == 0)
        gl->GenBuffers(1, buffer);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, *buffer);
    // A binding needs a buffer that isn't empty.
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(bytes > 0 ? bytes : 4), bytes > 0 ? data : NULL, usage);
    return qcGl_CheckError(gl, "vertex buffer: no memory on the device, %zu bytes", bytes);
}

static qcStatus Use(const struct qcGlFunctions* gl, const char* name, const char* source, GLuint* program)
{
    QC_TRY(qcGlPrograms_GetCompute(gl, name, &source, 1, program));
    gl->UseProgram(*program);
    return qc_statusOk;
}

static void SetUint(const struct qcGlFunctions* gl, GLuint program, const char* name, uint32_t value)
{
    gl->Uniform1ui(gl->GetUniformLocation(program, name), value);
}

/// What was read back must be of this run: a reset, or a fence that a driver signals too early, would leave old
/// results.
static qcStatus CheckFinished(uint32_t finished, uint32_t run, uint32_t groups)
{
    return finished == run + groups ? qc_statusOk
                                    : qcFail(qc_statusDevice, "vertex buffer: the device did not finish its kernels");
}

//  ---- copies ------------------------------------------------------------------------------------------------------

static qcStatus UploadUsed(const struct qcGlFunctions* gl, qcVertexSnapshot* snapshot, const uint8_t* used)
{
    qcArray words = {0};
    size_t count = used != NULL ? ((size_t)snapshot->vertexCount + 31) / 32 : 0;
    QC_TRY(qcArray_GrowZeroed(&words, count, sizeof(uint32_t), "vertices in use"));
    for (uint32_t v = 0; used != NULL && v < snapshot->vertexCount; v++)
        QC_AT(uint32_t, words, v >> 5) |= (uint32_t)(used[v] != 0) << (v & 31);
    qcStatus status = Allocate(gl, &snapshot->used, count * sizeof(uint32_t), words.data, GL_STATIC_DRAW);
    qcArray_Free(&words);
    return status;
}

/// Objects of the present context, at the first copy and after the device was reopened.
static qcStatus CreateObjects(const struct qcGlFunctions* gl, qcVertexSnapshot* snapshot, const uint8_t* used)
{
    const uint32_t generation = qcDevice_GetGeneration(snapshot->device);
    if (snapshot->allocated && snapshot->generation == generation)
        return qc_statusOk;
    // Those of another generation went with their context; of this one, what a failed call has made is used.
    if (snapshot->generation != generation)
        snapshot->bounds = snapshot->used = snapshot->buffers[0] = snapshot->buffers[1] = 0;
    snapshot->allocated = false;
    snapshot->generation = generation;
    snapshot->lost = true;
    size_t bytes = (size_t)snapshot->vertexCount * qc_positionBytes;
    for (int i = 0; i < 2; i++)
        QC_TRY(Allocate(gl, &snapshot->buffers[i], bytes, NULL, GL_STATIC_COPY));
    QC_TRY(UploadUsed(gl, snapshot, used));
    QC_TRY(Allocate(gl, &snapshot->bounds, sizeof(Bounds), NULL, GL_DYNAMIC_READ));
    snapshot->allocated = true;
    return qc_statusOk;
}

/// Binds the source from an aligned byte on. Returns the words before the first position.
static uint32_t BindSource(const struct qcGlFunctions* gl, const qcBufferRange* range, uint64_t firstByte)
{
    GLint alignment = 0;
    gl->GetIntegerv(GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT, &alignment);
    uint64_t before = alignment > 0 ? firstByte % (uint64_t)alignment : 0;
    gl->BindBufferRange(GL_SHADER_STORAGE_BUFFER, 0, range->buffer->name, (GLintptr)(firstByte - before),
                        (GLsizeiptr)(range->bytes + before));
    return (uint32_t)(before / sizeof(uint32_t));
}

static qcStatus CheckLimit(const struct qcGlFunctions* gl, uint64_t bytes)
{
    return bytes + qc_maxBefore <= qcGl_MaxStorageBytes(gl)
               ? qc_statusOk
               : qcFail(qc_statusDevice, "vertex buffer: %llu bytes are more than the device's kernels read",
                        (unsigned long long)bytes);
}

static qcStatus Copy(const struct qcGlFunctions* gl, void* context)
{
    Copying* copying = context;
    qcVertexSnapshot* snapshot = copying->snapshot;
    const qcSnapshotSource* source = copying->source;
    const char* function = "qcScene_SetVertexBuffer";
    GLuint program;
    uint64_t firstByte = 0;
    QC_TRY(qcBufferRange_Check(gl, &source->range, function, &firstByte));
    QC_TRY(CheckLimit(gl, source->range.bytes));
    QC_TRY(CreateObjects(gl, snapshot, source->used));
    QC_TRY(qcGl_WaitForHost(gl, source->fence, function));
    memset(&copying->bounds, 0xff, sizeof copying->bounds);
    if (snapshot->vertexCount == 0)
        return qc_statusOk;
    QC_TRY(Use(gl, "vertex buffer, snapshot", s_buffersSnapshot, &program));
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, snapshot->bounds);
    copying->bounds.finished = ++snapshot->runNumber * qc_runSpacing;
    gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof copying->bounds, &copying->bounds);
    SetUint(gl, program, "first", BindSource(gl, &source->range, firstByte));
    SetUint(gl, program, "stride", source->stride / (uint32_t)sizeof(uint32_t));
    SetUint(gl, program, "vertexCount", snapshot->vertexCount);
    SetUint(gl, program, "skipsUnused", source->used != NULL);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, snapshot->buffers[1]);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, snapshot->bounds);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, snapshot->used);
    uint32_t groups = qcGl_Dispatch(gl, ((uint64_t)snapshot->vertexCount + qc_copiedPerGroup - 1) / qc_copiedPerGroup);
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, snapshot->bounds);
    copying->bounds = (Bounds){0};
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, sizeof copying->bounds, &copying->bounds);
    return CheckFinished(copying->bounds.finished, snapshot->runNumber * qc_runSpacing, groups);
}

/// The float of an ordered integer.
static float FloatOf(uint32_t ordered)
{
    uint32_t bits = (ordered & 0x80000000u) != 0 ? ordered & 0x7fffffffu : ~ordered;
    float x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

qcStatus qcVertexSnapshot_Copy(qcVertexSnapshot* snapshot, const qcSnapshotSource* source, float lower[3],
                               float upper[3])
{
    Copying copying = {.snapshot = snapshot, .source = source};
    QC_TRY(
        qcDevice_RunIn(snapshot->device, source->range.buffer->generation, Copy, &copying, "qcScene_SetVertexBuffer"));
    const Bounds* bounds = &copying.bounds;
    if (bounds->firstBad != UINT32_MAX)
        return qcFail(qc_statusBadInput, "vertex %u of body %u is not finite", bounds->firstBad, source->slot);
    bool any = bounds->lower[0] != UINT32_MAX || bounds->upper[0] != UINT32_MAX;
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = any ? FloatOf(bounds->lower[axis]) : INFINITY;
        upper[axis] = any ? FloatOf(~bounds->upper[axis]) : -INFINITY;
    }
    GLuint copied = snapshot->buffers[1];
    snapshot->buffers[1] = snapshot->buffers[0];
    snapshot->buffers[0] = copied;
    snapshot->active = true;
    snapshot->complete = snapshot->lost = false;
    return qc_statusOk;
}

//  ---- back to the CPU ---------------------------------------------------------------------------------------------

bool qcVertexSnapshot_IsOnDevice(const qcVertexSnapshot* snapshot)
{
    return snapshot != NULL && snapshot->active && !snapshot->lost &&
           snapshot->generation == qcDevice_GetGeneration(snapshot->device);
}

qcStatus qcVertexSnapshot_CheckAlive(const qcVertexSnapshot* snapshot, uint32_t slot)
{
    if (!qcVertexSnapshot_IsOnlyCopy(snapshot) || qcVertexSnapshot_IsOnDevice(snapshot))
        return qc_statusOk;
    return qcFail(qc_statusDeviceLost, "the positions of body %u were lost with the GL context: set them anew", slot);
}

typedef struct Reading
{
    const qcVertexSnapshot* snapshot;
    float* positions;
} Reading;

static qcStatus Read(const struct qcGlFunctions* gl, void* context)
{
    const Reading* reading = context;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, reading->snapshot->buffers[0]);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0,
                         (GLsizeiptr)((size_t)reading->snapshot->vertexCount * qc_positionBytes), reading->positions);
    return qc_statusOk;
}

qcStatus qcVertexSnapshot_Read(const qcVertexSnapshot* snapshot, float* positions)
{
    Reading reading = {snapshot, positions};
    return qcDevice_RunIn(snapshot->device, snapshot->generation, Read, &reading, "reading a vertex buffer back");
}

typedef struct Gathering
{
    const qcSnapshotPart* parts;
    size_t partCount;
    const uint32_t* vertices;
    size_t vertexCount;
    float* positions;
} Gathering;

/// `buffers`: the list; the number of workgroups that have finished, and the positions.
static qcStatus GatherInto(const struct qcGlFunctions* gl, const Gathering* g, GLuint buffers[2])
{
    const GLsizeiptr head = sizeof(uint32_t), bytes = (GLsizeiptr)(g->vertexCount * qc_positionBytes);
    const uint32_t run = g->parts[0].snapshot->listNumber * qc_runSpacing;
    uint32_t groups = 0, finished = 0;
    GLuint program;
    QC_TRY(CheckLimit(gl, (uint64_t)(head + bytes)));
    QC_TRY(Allocate(gl, &buffers[0], g->vertexCount * sizeof(uint32_t), g->vertices, GL_STREAM_DRAW));
    QC_TRY(Allocate(gl, &buffers[1], (size_t)(head + bytes), NULL, GL_STREAM_READ));
    gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, head, &run);
    QC_TRY(Use(gl, "vertex buffer, gather", s_buffersGather, &program));
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, buffers[0]);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, buffers[1]);
    for (size_t i = 0; i < g->partCount; i++)
    {
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, g->parts[i].snapshot->buffers[0]);
        SetUint(gl, program, "first", (uint32_t)g->parts[i].first);
        SetUint(gl, program, "count", (uint32_t)g->parts[i].count);
        groups += qcGl_Dispatch(gl, ((uint64_t)g->parts[i].count + qc_lanes - 1) / qc_lanes);
    }
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffers[1]);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, head, &finished);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, head, bytes, g->positions);
    return CheckFinished(finished, run, groups);
}

static qcStatus Gather(const struct qcGlFunctions* gl, void* context)
{
    GLuint buffers[2] = {0, 0};
    qcStatus status = GatherInto(gl, context, buffers);
    gl->DeleteBuffers(2, buffers);
    return status;
}

qcStatus qcVertexSnapshots_Gather(qcDevice* device, const qcSnapshotPart* parts, size_t partCount,
                                  const uint32_t* vertices, size_t vertexCount, float* positions)
{
    Gathering gathering = {parts, partCount, vertices, vertexCount, positions};
    return vertexCount == 0
               ? qc_statusOk
               : qcDevice_RunIn(device, parts[0].snapshot->generation, Gather, &gathering, "gathering positions");
}

//  ---- life --------------------------------------------------------------------------------------------------------

qcStatus qcVertexSnapshot_Create(qcDevice* device, uint32_t vertexCount, qcVertexSnapshot** result)
{
    qcVertexSnapshot* snapshot = qcAllocateZeroed(sizeof *snapshot);
    if (snapshot == NULL)
        return qcFailMemory(sizeof *snapshot, "positions on the device");
    snapshot->device = device;
    snapshot->vertexCount = vertexCount;
    *result = snapshot;
    return qc_statusOk;
}

static qcStatus DeleteObjects(const struct qcGlFunctions* gl, void* context)
{
    const qcVertexSnapshot* snapshot = context;
    const GLuint buffers[] = {snapshot->buffers[0], snapshot->buffers[1], snapshot->bounds, snapshot->used};
    gl->DeleteBuffers(sizeof buffers / sizeof buffers[0], buffers);
    return qc_statusOk;
}

void qcVertexSnapshot_Destroy(qcVertexSnapshot* snapshot)
{
    if (snapshot == NULL)
        return;
    // A lost context takes its objects along.
    if (snapshot->generation == qcDevice_GetGeneration(snapshot->device))
        (void)qcDevice_RunIn(snapshot->device, snapshot->generation, DeleteObjects, snapshot,
                             "releasing positions on the device");
    qcArray_Free(&snapshot->marks);
    qcFree(snapshot, sizeof *snapshot);
}
