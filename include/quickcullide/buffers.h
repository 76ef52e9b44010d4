/// @file
/// Geometry that is already on the GPU: a scene's positions come from buffers in the device's memory, and its pairs can
/// go there. Buffers belong to the host: GL buffers of a context that shares objects with the device's
/// (qcDeviceDef::shareContext), or memory of another API, such as Vulkan, imported by a file descriptor.
///
/// Thread-safety: a device and its buffers may be used on any thread; a scene on one thread at a time.
#ifndef QUICKCULLIDE_BUFFERS_H
#define QUICKCULLIDE_BUFFERS_H

#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A buffer of the host's in the device's memory.
///
///     deviceDef.shareDisplay = eglGetCurrentDisplay();  deviceDef.shareContext = eglGetCurrentContext();
///     qcDeviceBufferDef bufferDef = qcDefaultDeviceBufferDef();
///     bufferDef.name = clothVertices;                   qcDevice_OpenBuffer(device, &bufferDef, &buffer);
///     qcVertexBufferDef vertices = qcDefaultVertexBufferDef();
///     vertices.buffer = buffer;                         // each step:
///     glMemoryBarrier(GL_ALL_BARRIER_BITS);
///     vertices.fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
///     glFlush();
///     qcScene_SetVertexBuffer(scene, cloth, &vertices); qcScene_Detect(scene, &detectDef, &result);
typedef struct qcDeviceBuffer qcDeviceBuffer;

/// Where a buffer of the host's is: exactly one of name and memoryFd. Make it with qcDefaultDeviceBufferDef.
typedef struct qcDeviceBufferDef
{
    uint32_t structSize; ///< sizeof(qcDeviceBufferDef)
    /// The name of a GL buffer in the context that the device shares (qcDeviceDef::shareContext). The commands that
    /// made it must have finished (glFinish). The host keeps the buffer; it must exist while it is open here. 0, the
    /// default: none.
    uint32_t name;
    /// A file descriptor of memory that another API has allocated, on the same GPU: an opaque handle, such as
    /// VK_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD_BIT (GL_EXT_memory_object_fd). The library imports a duplicate; the
    /// caller's descriptor stays the caller's. -1, the default: none.
    int32_t memoryFd;
    /// Bytes of that allocation, all of it. Software GL (llvmpipe) makes a buffer of all but the last 64 bytes.
    uint64_t memorySize;
    uint64_t memoryOffset; ///< bytes from the allocation's begin to the buffer's, a multiple of 4
    bool dedicated;        ///< the allocation is a dedicated one (VkMemoryDedicatedAllocateInfo)
} qcDeviceBufferDef;

/// The default definition: no buffer.
static inline qcDeviceBufferDef qcDefaultDeviceBufferDef(void)
{
    qcDeviceBufferDef def;
    def.structSize = (uint32_t)sizeof(qcDeviceBufferDef);
    def.name = 0;
    def.memoryFd = -1;
    def.memorySize = 0;
    def.memoryOffset = 0;
    def.dedicated = false;
    return def;
}

/// Opens a buffer of the host's, for qcScene_SetVertexBuffer and qcScene_WritePairs. Nothing is copied. Any thread.
///
/// qc_statusBadInput: the device shares no context, the name is no buffer there, or a field is invalid.
/// qc_statusDevice: the device is of kind none, has no compute shaders or can't import memory. qc_statusDeviceLost.
/// qc_statusOutOfMemory.
QC_API qcStatus qcDevice_OpenBuffer(qcDevice* device, const qcDeviceBufferDef* def, qcDeviceBuffer** buffer);

/// Releases what qcDevice_OpenBuffer made; the host's buffer stays. Call it before qcDevice_Destroy, and while no other
/// call uses the buffer. Scenes keep nothing of it. Null is allowed. Any thread.
QC_API void qcDeviceBuffer_Close(qcDeviceBuffer* buffer);

/// Positions that are in the device's memory already. Make it with qcDefaultVertexBufferDef.
typedef struct qcVertexBufferDef
{
    uint32_t structSize;    ///< sizeof(qcVertexBufferDef)
    uint32_t stride;        ///< bytes from one position to the next, a multiple of 4; 0, the default: 12
    qcDeviceBuffer* buffer; ///< of the scene's device
    uint64_t offset;        ///< bytes from the buffer's begin to the first position, a multiple of 4
    /// A GLsync of the shared context, behind the commands that write the positions, or null: those commands have
    /// finished (glFinish; a fence of the API that owns imported memory). The call waits for it, at most ten seconds.
    /// After writes by shaders the host calls glMemoryBarrier(GL_ALL_BARRIER_BITS), glFenceSync and glFlush, in this
    /// order.
    void* fence;
} qcVertexBufferDef;

/// The default definition: no buffer.
static inline qcVertexBufferDef qcDefaultVertexBufferDef(void)
{
    qcVertexBufferDef def;
    def.structSize = (uint32_t)sizeof(qcVertexBufferDef);
    def.stride = 0;
    def.buffer = NULL;
    def.offset = 0;
    def.fence = NULL;
    return def;
}

/// Gives a deforming body new positions in world space from a buffer on the device: three floats each, as many as the
/// body has vertices. Nothing is uploaded. The device copies them into memory of the scene and finds their bounds; the
/// call returns when it has read the buffer, so the host may write it again at once. O(n) on the device, plus a wait.
///
/// The positions stay on the device while `layers` finds all pairs: qcScene_Detect then reads back those of triangles
/// in candidate pairs alone (qcProfile::readBackBytes). All of the body's positions are read back, once, where the CPU
/// needs them: for another method, a fallback to `sweep`, contactMargin, manifolds, motion, qcScene_MarkStart, or a
/// recording. Results are those of the same floats given to qcScene_SetVertices, to the last bit. The leaf nodes of
/// `layers` are laid out by the positions of qcScene_AddBody, which should have the shape's size.
///
/// qcScene_SetVertices gives the body back to the CPU. If the device is lost, so are the positions: qcScene_Detect
/// returns qc_statusDeviceLost until they are set anew. A request that repeats the last one, with nothing changed, still
/// returns that result.
///
/// qc_statusBadInput: also if the body is rigid, the buffer is too small or of another device, or a position is not
/// finite. qc_statusDevice: the device failed, or the fence was not signalled in time. qc_statusDeviceLost.
QC_API qcStatus qcScene_SetVertexBuffer(qcScene* scene, qcBodyId id, const qcVertexBufferDef* def);

/// Where pairs go on the device. Make it with qcDefaultPairBufferDef.
typedef struct qcPairBufferDef
{
    uint32_t structSize;    ///< sizeof(qcPairBufferDef)
    uint32_t capacity;      ///< pairs that fit into the buffer
    qcDeviceBuffer* buffer; ///< of the scene's device
    uint64_t offset;        ///< bytes from the buffer's begin, a multiple of 4
} qcPairBufferDef;

/// The default definition: no buffer.
static inline qcPairBufferDef qcDefaultPairBufferDef(void)
{
    qcPairBufferDef def;
    def.structSize = (uint32_t)sizeof(qcPairBufferDef);
    def.capacity = 0;
    def.buffer = NULL;
    def.offset = 0;
    return def;
}

/// Writes the pairs of the last qcScene_Detect into a buffer on the device: their number, 4 bytes, then the array of
/// qcPair, 20 bytes each. In GLSL: `layout(std430) buffer Pairs { uint count; Pair pairs[]; }` with a struct Pair of
/// five uints. These are the exact pairs, in the order of the result: the exact test runs on the CPU, so they are
/// uploaded, 20 bytes a pair. The host's commands that use the buffer must have finished; on return the pairs are
/// written, and the host's context sees them once it binds the buffer anew. O(pairs).
///
/// qc_statusBadInput: there is no result, the pairs exceed the capacity (the message has their number), the
/// capacity exceeds the buffer, or the buffer is of another device. qc_statusDevice and qc_statusDeviceLost: as for
/// qcScene_SetVertexBuffer.
QC_API qcStatus qcScene_WritePairs(qcScene* scene, const qcPairBufferDef* def);

#ifdef __cplusplus
}
#endif

#endif
