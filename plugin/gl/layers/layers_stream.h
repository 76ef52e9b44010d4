// The data of single steps on their way to the device: a ring of three parts of one buffer, persistently mapped where
// GL has it, otherwise uploaded with one call.
#ifndef QC_GL_LAYERS_LAYERS_STREAM_H
#define QC_GL_LAYERS_LAYERS_STREAM_H

#include "base/memory.h"
#include "gl/gl_functions.h"

enum
{
    qc_streamParts = 3
};

typedef struct qcLayersStream
{
    GLuint buffer;
    size_t partBytes;
    char* mapped;    ///< null: `staging` is uploaded
    qcArray staging; ///< of bytes, one part
    uint32_t part;   ///< the present one
} qcLayersStream;

void qcLayersStream_Delete(const struct qcGlFunctions* gl, qcLayersStream* stream);
/// Makes room for `bytes` in each part; the device has finished with all parts, and their contents are lost.
qcStatus qcLayersStream_Grow(const struct qcGlFunctions* gl, qcLayersStream* stream, size_t bytes);
/// Goes on to the next part.
static inline void qcLayersStream_Next(qcLayersStream* stream)
{
    stream->part = (stream->part + 1) % qc_streamParts;
}

/// The present part's place in the buffer.
static inline size_t qcLayersStream_Offset(const qcLayersStream* stream)
{
    return stream->mapped != NULL ? stream->part * stream->partBytes : 0;
}

/// The present part, for writing.
static inline char* qcLayersStream_Data(const qcLayersStream* stream)
{
    return stream->mapped != NULL ? stream->mapped + qcLayersStream_Offset(stream) : stream->staging.data;
}

static inline size_t qcLayersStream_ByteCount(const qcLayersStream* stream)
{
    return (stream->mapped != NULL ? qc_streamParts : 1) * stream->partBytes;
}

/// Uploads the first bytes of the present part unless it is mapped.
void qcLayersStream_Submit(const struct qcGlFunctions* gl, const qcLayersStream* stream, size_t bytes);

#endif
