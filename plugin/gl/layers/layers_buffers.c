// Allocation, mapping and upload of the buffers of `layers`. Kernels read most of them through buffer textures.
#include "gl/layers/layers_buffers.h"

#include "base/status.h"
#include "gl/compute.h"

#include <assert.h>

typedef struct BufferShape
{
    const char* sampler; ///< name in the kernels; null: not sampled
    uint32_t elementSize;
    GLenum format;
    GLbitfield mapping[2]; ///< 0: not mapped; for pairs, for the image
} BufferShape;

#define READ GL_MAP_READ_BIT
#define READ_AND_WRITE (GL_MAP_READ_BIT | GL_MAP_WRITE_BIT)

static const BufferShape s_shapes[qc_layersBufferCount] = {
    [qc_layersVertices] = {"vertices", 16, GL_RGBA32F, {0, READ_AND_WRITE}},
    [qc_layersLocals] = {"locals", 16, GL_RGBA32UI, {0, 0}},
    [qc_layersTriangles] = {"triangles", 16, GL_RGBA32UI, {0, 0}},
    [qc_layersNodes] = {"nodes", 16, GL_RGBA32UI, {0, 0}},
    [qc_layersLinks] = {"links", 8, GL_RG32UI, {0, 0}},
    [qc_layersTables] = {"tables", 8, GL_RG32UI, {0, 0}},
    [qc_workBoxes] = {NULL, 16, 0, {0, READ}},
    [qc_workClusterBoxes] = {"clusterBoxes", 16, GL_RGBA32UI, {0, 0}},
    [qc_workNodeBoxes] = {NULL, 16, 0, {0, READ}},
    [qc_workEntries] = {NULL, 16, 0, {0, READ}},
    [qc_workNodePairs] = {NULL, 16, 0, {0, 0}},
    [qc_workTrianglePairs] = {NULL, 8, 0, {0, 0}},
    [qc_workResults] = {NULL, 8, 0, {READ, 0}},
    [qc_workLists] = {NULL, 4, 0, {0, READ_AND_WRITE}},
    [qc_workStep] = {NULL, 4, 0, {0, 0}},
};

enum
{
    qc_storageBindings = 8, // as many as GL 4.3 guarantees
    qc_stream = -1
};

/// Buffers of the storage blocks, for pairs and for the image.
static const int s_bindings[2][qc_storageBindings] = {
    {qc_workLists, qc_layersVertices, qc_workBoxes, qc_workTrianglePairs, qc_workStep, qc_workNodePairs, qc_workResults,
     qc_stream},
    {qc_workLists, qc_layersVertices, qc_workBoxes, qc_workTrianglePairs, qc_workEntries, qc_workClusterBoxes,
     qc_workNodeBoxes, qc_stream}};

const char* qcLayersBuffers_SamplerName(int buffer)
{
    return s_shapes[buffer].sampler;
}

qcStatus qcLayersBuffers_Create(const struct qcGlFunctions* gl, qcLayersBuffers* b)
{
    GLint64 texels = 0;
    gl->GetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    b->maxBytes = (size_t)qcGl_MaxStorageBytes(gl);
    b->maxTexels = texels > 0 ? (size_t)texels : 0;
    b->persistent = gl->BufferStorage != NULL;
    gl->GenBuffers(qc_layersBufferCount, b->buffers);
    gl->GenTextures(qc_layersBufferCount, b->textures);
    return qcGl_CheckError(gl, "layers: no buffers on the device");
}

void qcLayersBuffers_Delete(const struct qcGlFunctions* gl, const qcLayersBuffers* b)
{
    gl->DeleteTextures(qc_layersBufferCount, b->textures);
    gl->DeleteBuffers(qc_layersBufferCount, b->buffers);
}

qcStatus qcLayersBuffers_Allocate(const struct qcGlFunctions* gl, size_t bytes, GLbitfield mapping, void** mapped)
{
    *mapped = NULL;
    GLbitfield flags = mapping != 0 ? mapping | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT : 0;
    if (gl->BufferStorage != NULL)
        gl->BufferStorage(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, NULL, flags | GL_DYNAMIC_STORAGE_BIT);
    else
        gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, NULL, GL_DYNAMIC_COPY);
    QC_TRY(qcGl_CheckError(gl, "layers: no memory for %zu bytes on the device", bytes));
    if (mapping == 0 || gl->BufferStorage == NULL)
        return qc_statusOk;
    *mapped = gl->MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)bytes, flags);
    if (*mapped != NULL)
        return qc_statusOk;
    // A lost context maps nothing, and may report no error.
    QC_TRY(qcGl_CheckError(gl, "layers: memory of the device can't be mapped"));
    return qcFail(qc_statusDevice, "layers: memory of the device can't be mapped");
}

static void BindTexture(const struct qcGlFunctions* gl, const qcLayersBuffers* b, int buffer)
{
    gl->ActiveTexture(GL_TEXTURE0 + (GLenum)buffer);
    gl->BindTexture(GL_TEXTURE_BUFFER, b->textures[buffer]);
}

qcStatus qcLayersBuffers_Resize(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer, size_t count)
{
    const BufferShape* shape = &s_shapes[buffer];
    const char* sampler = qcLayersBuffers_SamplerName(buffer);
    size_t bytes = count * shape->elementSize;
    if (bytes > b->maxBytes || (sampler != NULL && count > b->maxTexels))
        return qcFail(qc_statusDevice, "layers: %zu %s are more than the device's buffers hold", count,
                      sampler != NULL ? sampler : "elements of a list");
    // An error of an earlier call is reported separately, not as the allocation's.
    QC_TRY(qcGl_CheckError(gl, "layers: before an allocation"));
    b->capacity[buffer] = 0;
    gl->state->bound = NULL;
    if (b->persistent)
    {
        // Storage never changes its size.
        gl->DeleteBuffers(1, &b->buffers[buffer]);
        b->mapped[buffer] = NULL;
        gl->GenBuffers(1, &b->buffers[buffer]);
    }
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, b->buffers[buffer]);
    QC_TRY(qcLayersBuffers_Allocate(gl, bytes, shape->mapping[b->imageOnly], &b->mapped[buffer]));
    b->capacity[buffer] = count;
    if (sampler != NULL)
    {
        BindTexture(gl, b, buffer);
        gl->TexBuffer(GL_TEXTURE_BUFFER, shape->format, b->buffers[buffer]);
    }
    return qc_statusOk;
}

qcStatus qcLayersBuffers_Reserve(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer, size_t count)
{
    // Never empty: a buffer texture needs a buffer.
    count = count > 0 ? count : 1;
    return count <= b->capacity[buffer] ? qc_statusOk : qcLayersBuffers_Resize(gl, b, buffer, count + count / 4);
}

size_t qcLayersBuffers_Upload(const struct qcGlFunctions* gl, const qcLayersBuffers* b, const qcLayersUpload* upload)
{
    size_t size = s_shapes[upload->buffer].elementSize;
    assert(upload->first + upload->count <= b->capacity[upload->buffer]);
    if (upload->count == 0)
        return 0;
    qcGl_Counted(gl)->BindBuffer(GL_SHADER_STORAGE_BUFFER, b->buffers[upload->buffer]);
    qcGl_Counted(gl)->BufferSubData(GL_SHADER_STORAGE_BUFFER, (GLintptr)(upload->first * size),
                                    (GLsizeiptr)(upload->count * size), upload->data);
    return upload->count * size;
}

void qcLayersBuffers_BindAll(const struct qcGlFunctions* gl, const qcLayersBuffers* b, GLuint stream)
{
    for (int buffer = 0; buffer < qc_layersBufferCount; buffer++)
        if (qcLayersBuffers_SamplerName(buffer) != NULL)
            BindTexture(gl, b, buffer);
    gl->ActiveTexture(GL_TEXTURE0);
    const int* bindings = s_bindings[b->imageOnly];
    for (GLuint i = 0; i < qc_storageBindings; i++)
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, bindings[i] == qc_stream ? stream : b->buffers[bindings[i]]);
    GLsizeiptr bytes = qc_parameterWords * sizeof(uint32_t);
    gl->BindBufferRange(GL_UNIFORM_BUFFER, qc_streamParameters, stream, 0, bytes);
    if (!b->imageOnly)
        gl->BindBufferRange(GL_UNIFORM_BUFFER, qc_copiedParameters, b->buffers[qc_workStep], 0, bytes);
}

const void* qcLayersBuffers_Read(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer)
{
    size_t bytes = b->capacity[buffer] * s_shapes[buffer].elementSize;
    if (b->mapped[buffer] != NULL)
        return b->mapped[buffer];
    qcGl_Counted(gl)->BindBuffer(GL_SHADER_STORAGE_BUFFER, b->buffers[buffer]);
    b->mapped[buffer] =
        qcGl_Counted(gl)->MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)bytes, GL_MAP_READ_BIT);
    return b->mapped[buffer];
}

void qcLayersBuffers_UnmapAll(const struct qcGlFunctions* gl, qcLayersBuffers* b)
{
    for (int buffer = 0; !b->persistent && buffer < qc_layersBufferCount; buffer++)
    {
        if (b->mapped[buffer] == NULL)
            continue;
        qcGl_Counted(gl)->BindBuffer(GL_SHADER_STORAGE_BUFFER, b->buffers[buffer]);
        qcGl_Counted(gl)->UnmapBuffer(GL_SHADER_STORAGE_BUFFER);
        b->mapped[buffer] = NULL;
    }
}

size_t qcLayersBuffers_ByteCount(const qcLayersBuffers* b)
{
    size_t bytes = 0;
    for (int buffer = 0; buffer < qc_layersBufferCount; buffer++)
        bytes += b->capacity[buffer] * s_shapes[buffer].elementSize;
    return bytes;
}
