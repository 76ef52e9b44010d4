// Allocation and upload of a step's data.
#include "gl/layers/layers_stream.h"

#include "base/status.h"
#include "gl/compute.h"
#include "gl/layers/layers_buffers.h"

void qcLayersStream_Delete(const struct qcGlFunctions* gl, qcLayersStream* stream)
{
    gl->DeleteBuffers(1, &stream->buffer);
    *stream = (qcLayersStream){.staging = stream->staging};
}

qcStatus qcLayersStream_Grow(const struct qcGlFunctions* gl, qcLayersStream* stream, size_t bytes)
{
    bool persistent = gl->BufferStorage != NULL;
    size_t size = bytes + bytes / 4;
    if (size > qcGl_MaxStorageBytes(gl))
        return qcFail(qc_statusDevice, "layers: %zu bytes of a step are more than the device's buffers hold", size);
    qcLayersStream_Delete(gl, stream);
    gl->state->bound = NULL;
    gl->GenBuffers(1, &stream->buffer);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, stream->buffer);
    void* mapped = NULL;
    QC_TRY(qcLayersBuffers_Allocate(gl, size, GL_MAP_WRITE_BIT, &mapped));
    if (!persistent)
        QC_TRY(qcArray_Resize(&stream->staging, size, 1, "data for the device"));
    stream->mapped = mapped;
    stream->size = size;
    return qc_statusOk;
}

void qcLayersStream_Submit(const struct qcGlFunctions* gl, const qcLayersStream* stream, size_t bytes)
{
    if (stream->mapped != NULL)
        return;
    qcGl_Counted(gl)->BindBuffer(GL_SHADER_STORAGE_BUFFER, stream->buffer);
    qcGl_Counted(gl)->BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)bytes, stream->staging.data);
}
