// Allocation and upload of the buffers of `layers`. Kernels read most of them through buffer textures.
#include "gl/layers/layers_buffers.h"

#include "base/status.h"

#include <assert.h>
#include <stdio.h>

typedef struct BufferShape
{
    const char* sampler; ///< name in the kernels; null: not sampled
    uint32_t elementSize;
    GLenum format;
} BufferShape;

static const BufferShape s_shapes[qc_layersBufferCount] = {
    [qc_layersVertices] = {"vertices", 16, GL_RGBA32F},
    [qc_layersLocals] = {"locals", 16, GL_RGBA32UI},
    [qc_layersTriangles] = {"triangles", 16, GL_RGBA32UI},
    [qc_layersNodes] = {"nodes", 16, GL_RGBA32UI},
    [qc_layersLinks] = {"links", 8, GL_RG32UI},
    [qc_layersTables] = {"tables", 8, GL_RG32UI},
    [qc_layersBodies] = {"bodies", 16, GL_RGBA32UI},
    [qc_layersActiveNodes] = {"activeNodes", 4, GL_R32UI},
    [qc_layersChunks] = {"chunks", 4, GL_R32UI},
    [qc_workBoxes] = {"boxes", 16, GL_RGBA32UI},
    [qc_workClusterBoxes] = {"clusterBoxes", 16, GL_RGBA32UI},
    [qc_workNodeBoxes] = {"nodeBoxes", 16, GL_RGBA32UI},
    [qc_workNodeGroups] = {NULL, sizeof(qcBox8), 0},
    [qc_workEntries] = {"entries", 16, GL_RGBA32UI},
    [qc_workNodePairs] = {"nodePairs", 8, GL_RG32UI},
    [qc_workNodePairTables] = {"nodePairTables", 4, GL_R32UI},
    [qc_workClusterPairs] = {"clusterPairs", 4, GL_R32UI},
    [qc_workTrianglePairs] = {"trianglePairs", 4, GL_R32UI},
    [qc_workSurvivors] = {NULL, 8, 0},
    [qc_workHeads] = {NULL, 4, 0},
    [qc_workCounters] = {"counted", 4, GL_R32UI},
};

const char* qcLayersBuffers_SamplerName(int buffer)
{
    return s_shapes[buffer].sampler;
}

size_t qcLayersBuffers_ElementSize(int buffer)
{
    return s_shapes[buffer].elementSize;
}

void qcLayersBuffers_Create(const struct qcGlFunctions* gl, qcLayersBuffers* b)
{
    // 64 bits: the limits of some GPUs are 2^31 and more.
    GLint64 bytes = 0, texels = 0;
    gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    gl->GetInteger64v(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    b->maxBytes = bytes > 0 ? (size_t)bytes : 0;
    b->maxTexels = texels > 0 ? (size_t)texels : 0;
    gl->GenBuffers(qc_layersBufferCount, b->buffers);
    gl->GenTextures(qc_layersBufferCount, b->textures);
}

void qcLayersBuffers_Delete(const struct qcGlFunctions* gl, const qcLayersBuffers* b)
{
    gl->DeleteTextures(qc_layersBufferCount, b->textures);
    gl->DeleteBuffers(qc_layersBufferCount, b->buffers);
}

static qcStatus CheckError(const struct qcGlFunctions* gl, const char* moment)
{
    GLenum error = gl->GetError();
    return error == GL_NO_ERROR
               ? qc_statusOk
               : qcFail(qc_statusDevice, "layers: %s: %s (0x%x)", moment, qcGl_ErrorName(error), error);
}

static void BindTexture(const struct qcGlFunctions* gl, const qcLayersBuffers* b, int buffer)
{
    gl->ActiveTexture(GL_TEXTURE0 + (GLenum)buffer);
    gl->BindTexture(GL_TEXTURE_BUFFER, b->textures[buffer]);
}

qcStatus qcLayersBuffers_Resize(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer, size_t count)
{
    const BufferShape* shape = &s_shapes[buffer];
    size_t bytes = count * shape->elementSize;
    if (bytes > b->maxBytes || (shape->sampler != NULL && count > b->maxTexels))
        return qcFail(qc_statusDevice, "layers: %zu %s are more than the device's buffers hold", count,
                      shape->sampler != NULL ? shape->sampler : "pairs");
    // An error of an earlier call is reported separately, not as the allocation's.
    QC_TRY(CheckError(gl, "before an allocation"));
    b->capacity[buffer] = 0;
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, b->buffers[buffer]);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, NULL, GL_DYNAMIC_COPY);
    char purpose[64];
    snprintf(purpose, sizeof purpose, "no memory for %zu bytes on the device", bytes);
    QC_TRY(CheckError(gl, purpose));
    b->capacity[buffer] = count;
    if (shape->sampler != NULL)
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
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, b->buffers[upload->buffer]);
    gl->BufferSubData(GL_SHADER_STORAGE_BUFFER, (GLintptr)(upload->first * size), (GLsizeiptr)(upload->count * size),
                      upload->data);
    return upload->count * size;
}

void qcLayersBuffers_BindAll(const struct qcGlFunctions* gl, const qcLayersBuffers* b)
{
    for (int buffer = 0; buffer < qc_layersBufferCount; buffer++)
        if (s_shapes[buffer].sampler != NULL)
            BindTexture(gl, b, buffer);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, b->buffers[qc_workCounters]);
}

size_t qcLayersBuffers_ByteCount(const qcLayersBuffers* b)
{
    size_t bytes = 0;
    for (int buffer = 0; buffer < qc_layersBufferCount; buffer++)
        bytes += b->capacity[buffer] * s_shapes[buffer].elementSize;
    return bytes;
}
