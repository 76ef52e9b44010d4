// The buffers of `layers` on the device: inputs uploaded by the caller, and outputs of the kernels. Where GL has
// persistent storage (ARB_buffer_storage), buffers that the processor reads or writes stay mapped.
#ifndef QC_GL_LAYERS_LAYERS_BUFFERS_H
#define QC_GL_LAYERS_LAYERS_BUFFERS_H

#include "gl/gl_functions.h"
#include "gl/layers/layers_gpu.h"

/// Buffers that the kernels fill; they follow the inputs, qcLayersBuffer.
typedef enum qcLayersWork
{
    /// qc_boxesOfNode a node: triangles, clusters, the node; then one an active node. For the image: qcBox8, a cluster
    /// each
    qc_workBoxes = qc_layersInputCount,
    qc_workClusterBoxes,  ///< for the image only
    qc_workNodeBoxes,     ///< for the image only: of all nodes, then a qcBox8 a node, boxes of its clusters
    qc_workEntries,       ///< for the image only: qcLayersEntry
    qc_workNodePairs,     ///< for pairs, and all that follow: two nodes, their pair masks; later buckets of results
    qc_workTrianglePairs, ///< two slots each
    qc_workResults,       ///< a copy of the counters, then pairs of triangles, as in qcLayersAnswer
    qc_workLists, ///< counters; for the image by cell its first entry, for pairs by tile its box, by bucket its size
    qc_workStep,  ///< for pairs: a copy of the step's parameters, bodies and active nodes
    qc_layersBufferCount
} qcLayersWork;

enum
{
    qc_boxesOfNode = 73,
    qc_texelsOfImageNode = 7, ///< of qc_workNodeBoxes
    qc_counterWords = 144,
    qc_tileNodes = 16, ///< active nodes of a tile
    qc_tileWords = 8,
    qc_parameterWords = 64, ///< of the step's data: the first ones, a uniform block
    // Uniform blocks of the kernels.
    qc_streamParameters = 0,
    qc_copiedParameters = 1, ///< those of qc_workStep
    // Storage blocks of the kernels.
    qc_sourceBinding = 3, ///< qc_workTrianglePairs; while vertices are made, a qcLayersSource
    qc_copyBinding = 4,   ///< qc_workStep
    qc_streamBinding = 7
};

typedef struct qcLayersBuffers
{
    bool imageOnly;
    bool persistent; ///< GL has persistent storage
    GLuint buffers[qc_layersBufferCount], textures[qc_layersBufferCount];
    size_t capacity[qc_layersBufferCount]; ///< elements
    void* mapped[qc_layersBufferCount];    ///< null: is not mapped
    size_t maxBytes;                       ///< of a buffer that a kernel reads
    size_t maxTexels;                      ///< elements of a buffer that is sampled
} qcLayersBuffers;

/// `imageOnly` has been set.
qcStatus qcLayersBuffers_Create(const struct qcGlFunctions* gl, qcLayersBuffers* b);
void qcLayersBuffers_Delete(const struct qcGlFunctions* gl, const qcLayersBuffers* b);

/// Name of the sampler of a buffer in the kernels; null: it has none.
const char* qcLayersBuffers_SamplerName(int buffer);

/// Resizes a buffer to exactly `count` elements; its content is lost, and so are all bindings. qc_statusDevice names
/// the limit or the error.
qcStatus qcLayersBuffers_Resize(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer, size_t count);
/// Makes room for `count` elements or more; the content stays if the buffer is large enough already.
qcStatus qcLayersBuffers_Reserve(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer, size_t count);

/// Returns the number of bytes uploaded.
size_t qcLayersBuffers_Upload(const struct qcGlFunctions* gl, const qcLayersBuffers* b, const qcLayersUpload* upload);
/// Binds all buffers and samplers. `stream`: the buffer of the steps' data.
void qcLayersBuffers_BindAll(const struct qcGlFunctions* gl, const qcLayersBuffers* b, GLuint stream);
/// The content, for reading; null: GL failed. Where nothing is persistent, it is mapped until UnmapAll.
const void* qcLayersBuffers_Read(const struct qcGlFunctions* gl, qcLayersBuffers* b, int buffer);
void qcLayersBuffers_UnmapAll(const struct qcGlFunctions* gl, qcLayersBuffers* b);
/// Bytes of all buffers.
size_t qcLayersBuffers_ByteCount(const qcLayersBuffers* b);

/// Allocates storage for the buffer bound to GL_SHADER_STORAGE_BUFFER. `mapping`: GL_MAP_READ_BIT and GL_MAP_WRITE_BIT;
/// 0: it is not mapped. `*mapped` is null where nothing is persistent. qc_statusDevice names the error.
qcStatus qcLayersBuffers_Allocate(const struct qcGlFunctions* gl, size_t bytes, GLbitfield mapping, void** mapped);

#endif
