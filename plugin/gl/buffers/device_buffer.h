// A buffer of the host's on the device: qcDeviceBuffer of quickcullide/buffers.h.
#ifndef QC_GL_BUFFERS_DEVICE_BUFFER_H
#define QC_GL_BUFFERS_DEVICE_BUFFER_H

#include "gl/gl_functions.h"
#include "quickcullide/buffers.h"

struct qcDeviceBuffer
{
    qcDevice* device;
    uint32_t generation; ///< of the device
    GLuint name;
    GLuint memory;  ///< the imported memory object; 0: the host's GL buffer
    uint64_t begin; ///< of the host's buffer in the GL buffer: bytes
};

/// A range of a buffer, in a job: `bytes` from `offset` on.
typedef struct qcBufferRange
{
    const qcDeviceBuffer* buffer;
    uint64_t offset, bytes;
} qcBufferRange;

/// Checks the device and the generation of a buffer, outside of jobs. `function` is named in messages.
qcStatus qcDeviceBuffer_Check(const qcDeviceBuffer* buffer, const qcDevice* device, const char* function);

/// In a job: checks that the buffer exists and holds the range. `first`: the range's first byte in the GL buffer.
qcStatus qcBufferRange_Check(const struct qcGlFunctions* gl, const qcBufferRange* range, const char* function,
                             uint64_t* first);

/// Writes the number of pairs, then the pairs, and waits until they are written. `room`: where they go, and for how
/// many there is room.
qcStatus qcDeviceBuffer_Write(const qcBufferRange* room, const qcPair* pairs, size_t count, const char* function);

/// In a job: waits until the host's fence, which may be null, is signalled.
qcStatus qcGl_WaitForHost(const struct qcGlFunctions* gl, void* fence, const char* function);

#endif
