// The data of a step on its way to the device: a buffer that stays mapped where GL has persistent storage, otherwise
// uploaded with one call. The device has read it before the next step's is written: each step waits for its run.
#ifndef QC_GL_LAYERS_LAYERS_STREAM_H
#define QC_GL_LAYERS_LAYERS_STREAM_H

#include "base/memory.h"
#include "gl/gl_functions.h"

typedef struct qcLayersStream
{
    GLuint buffer;
    size_t size;     ///< bytes
    char* mapped;    ///< null: `staging` is uploaded
    qcArray staging; ///< of bytes
} qcLayersStream;

void qcLayersStream_Delete(const struct qcGlFunctions* gl, qcLayersStream* stream);
/// Makes room for `bytes`; the content is lost.
qcStatus qcLayersStream_Grow(const struct qcGlFunctions* gl, qcLayersStream* stream, size_t bytes);
/// The data, for writing.
static inline char* qcLayersStream_Data(const qcLayersStream* stream)
{
    return stream->mapped != NULL ? stream->mapped : stream->staging.data;
}

/// Uploads the first bytes unless they are mapped.
void qcLayersStream_Submit(const struct qcGlFunctions* gl, const qcLayersStream* stream, size_t bytes);

#endif
