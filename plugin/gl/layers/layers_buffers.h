// The buffers of `layers` on the device: inputs uploaded by the caller, and outputs of the kernels.
#ifndef QC_GL_LAYERS_LAYERS_BUFFERS_H
#define QC_GL_LAYERS_LAYERS_BUFFERS_H

#include "gl/gl_functions.h"
#include "gl/layers/layers_gpu.h"

/// Buffers that the kernels fill; they follow the inputs, qcLayersBuffer.
typedef enum qcLayersWork
{
    qc_workBoxes = qc_layersInputCount, ///< of triangles; for the image only: qcBox8, a cluster each
    qc_workClusterBoxes,
    qc_workNodeBoxes,
    qc_workNodeGroups, ///< qcBox8, a node each: boxes of its clusters; for the image only
    qc_workEntries,    ///< qcLayersEntry
    qc_workNodePairs,
    qc_workNodePairTables, ///< by node pair: its pair masks, or none
    qc_workClusterPairs,   ///< node pair << 6 | cluster + 8 * cluster
    qc_workTrianglePairs,  ///< cluster pair << 6 | triangle + 8 * triangle
    qc_workSurvivors,      ///< slots of two triangles
    qc_workHeads,          ///< by cell: its first entry
    qc_workCounters,
    qc_layersBufferCount
} qcLayersWork;

typedef struct qcLayersBuffers
{
    GLuint buffers[qc_layersBufferCount], textures[qc_layersBufferCount];
    size_t capacity[qc_layersBufferCount]; ///< elements
    size_t maxBytes;                       ///< of a buffer that a kernel reads
    size_t maxTexels;                      ///< elements of a buffer that is sampled
} qcLayersBuffers;

void qcLayersBuffers_Create(const struct qcGlFunctions* gl, qcLayersBuffers* b);
void qcLayersBuffers_Delete(const struct qcGlFunctions* gl, const qcLayersBuffers* b);

/// Name of the sampler of a buffer in the kernels; null: it has none.
const char* qcLayersBuffers_SamplerName(int buffer);
size_t qcLayersBuffers_ElementSize(int buffer);

/// Resizes a buffer to exactly `count` elements; its content is lost. qc_statusDevice names the limit or the error.
qcStatus qcLayersBuffers_Resize(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer, size_t count);
/// Makes room for `count` elements or more; the content stays if the buffer is large enough already.
qcStatus qcLayersBuffers_Reserve(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer, size_t count);

/// Returns the number of bytes uploaded.
size_t qcLayersBuffers_Upload(const struct qcGlFunctions* gl, const qcLayersBuffers* b, const qcLayersUpload* upload);
/// Binds all samplers, and the counters as storage block 0.
void qcLayersBuffers_BindAll(const struct qcGlFunctions* gl, const qcLayersBuffers* b);
/// Bytes of all buffers.
size_t qcLayersBuffers_ByteCount(const qcLayersBuffers* b);

#endif
