// Opens the host's buffers. Memory of other APIs: GL_EXT_memory_object, GL_EXT_memory_object_fd.
#define _POSIX_C_SOURCE 200809L
#include "gl/buffers/device_buffer.h"

#include "base/definition.h"
#include "base/memory.h"
#include "base/status.h"
#include "gl/device.h"

#include <fcntl.h>
#include <unistd.h>

enum
{
    qc_fenceSeconds = 10,
    // A wait is cut into parts, so that no driver's limit (GL_MAX_SERVER_WAIT_TIMEOUT) matters.
    qc_waitNanoseconds = 100000000,
    qc_waitsPerSecond = 10
};

typedef struct Opening
{
    qcDeviceBuffer* buffer;
    const qcDeviceBufferDef* def;
} Opening;

static qcStatus CheckDef(const qcDevice* device, const qcDeviceBufferDef* def)
{
    if ((def->name != 0) == (def->memoryFd >= 0))
        return qcFail(qc_statusBadInput, "qcDevice_OpenBuffer: def must have either a name or a memoryFd");
    if (def->memoryFd >= 0 && def->memoryOffset >= def->memorySize)
        return qcFail(qc_statusBadInput, "qcDevice_OpenBuffer: def->memoryOffset is %llu, memorySize %llu",
                      (unsigned long long)def->memoryOffset, (unsigned long long)def->memorySize);
    if (def->memoryFd >= 0 && def->memoryOffset % 4 != 0)
        return qcFail(qc_statusBadInput, "qcDevice_OpenBuffer: def->memoryOffset is %llu; it must be a multiple of 4",
                      (unsigned long long)def->memoryOffset);
    if (def->name != 0 && !qcDevice_SharesContext(device))
        return qcFail(
            qc_statusBadInput,
            "qcDevice_OpenBuffer: the device shares no context (qcDeviceDef::shareContext), so def->name means "
            "nothing there");
    return qc_statusOk;
}

static qcStatus FailBuffer(const char* function, GLuint name)
{
    return qcFail(qc_statusBadInput, "%s: %u is not the name of a buffer in the shared context", function, name);
}

/// A GL buffer of all the memory, since Mesa 22.3 ignores the offset of a buffer. Its llvmpipe keeps 48 bytes behind a
/// buffer. Returns GL's error.
static GLenum MakeStorage(const struct qcGlFunctions* gl, uint64_t size, qcDeviceBuffer* buffer)
{
    static const uint32_t s_reserves[] = {0, 64};
    GLenum error = GL_OUT_OF_MEMORY;
    for (int i = 0; i < 2 && error == GL_OUT_OF_MEMORY && size > s_reserves[i]; i++)
    {
        gl->GenBuffers(1, &buffer->name);
        gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffer->name);
        gl->BufferStorageMem(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(size - s_reserves[i]), buffer->memory, 0);
        error = gl->GetError();
        if (error != GL_NO_ERROR)
            gl->DeleteBuffers(1, &buffer->name);
    }
    return error;
}

static qcStatus Import(const struct qcGlFunctions* gl, const qcDeviceBufferDef* def, qcDeviceBuffer* buffer)
{
    if (gl->ImportMemoryFd == NULL)
        return qcFail(qc_statusDevice,
                      "qcDevice_OpenBuffer: the device can't import memory (GL_EXT_memory_object_fd is missing)");
    int fd = fcntl(def->memoryFd, F_DUPFD_CLOEXEC, 0);
    if (fd < 0)
        return qcFail(qc_statusBadInput, "qcDevice_OpenBuffer: def->memoryFd %d is not an open file descriptor",
                      def->memoryFd);
    const GLint dedicated = GL_TRUE;
    buffer->begin = def->memoryOffset;
    gl->CreateMemoryObjects(1, &buffer->memory);
    if (def->dedicated)
        gl->MemoryObjectParameteriv(buffer->memory, GL_DEDICATED_MEMORY_OBJECT_EXT, &dedicated);
    gl->ImportMemoryFd(buffer->memory, def->memorySize, GL_HANDLE_TYPE_OPAQUE_FD_EXT, fd);
    GLenum error = gl->GetError();
    // A successful import takes the descriptor.
    if (error != GL_NO_ERROR)
        close(fd);
    if (error == GL_NO_ERROR)
        error = MakeStorage(gl, def->memorySize, buffer);
    if (error == GL_NO_ERROR)
        return qc_statusOk;
    gl->DeleteMemoryObjects(1, &buffer->memory);
    return qcFail(qc_statusDevice,
                  "qcDevice_OpenBuffer: the device can't import the memory of def->memoryFd: %s (0x%x)",
                  qcGl_ErrorName(error), error);
}

static qcStatus Open(const struct qcGlFunctions* gl, void* context)
{
    const Opening* opening = context;
    const qcDeviceBufferDef* def = opening->def;
    if (gl->DispatchCompute == NULL)
        return qcFail(qc_statusDevice, "qcDevice_OpenBuffer: the device has no compute shaders (GL below 4.3)");
    if (def->memoryFd >= 0)
        return Import(gl, def, opening->buffer);
    opening->buffer->name = def->name;
    return gl->IsBuffer(def->name) ? qc_statusOk : FailBuffer("qcDevice_OpenBuffer", def->name);
}

qcStatus qcDevice_OpenBuffer(qcDevice* device, const qcDeviceBufferDef* given, qcDeviceBuffer** result)
{
    if (device == NULL || given == NULL || result == NULL)
        return qcFail(qc_statusBadInput, "qcDevice_OpenBuffer: %s is null",
                      device == NULL  ? "device"
                      : given == NULL ? "def"
                                      : "buffer");
    qcDeviceBufferDef def = qcDefaultDeviceBufferDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT("qcDevice_OpenBuffer", qcDeviceBufferDef, name), &def));
    QC_TRY(CheckDef(device, &def));
    qcDeviceBuffer* buffer = qcAllocateZeroed(sizeof *buffer);
    if (buffer == NULL)
        return qcFailMemory(sizeof *buffer, "a buffer of the host's");
    *buffer = (qcDeviceBuffer){.device = device, .generation = qcDevice_GetGeneration(device)};
    Opening opening = {buffer, &def};
    qcStatus status = qcDevice_RunIn(device, buffer->generation, Open, &opening, "qcDevice_OpenBuffer");
    if (status == qc_statusOk)
        *result = buffer;
    else
        qcFree(buffer, sizeof *buffer);
    return status;
}

static qcStatus Close(const struct qcGlFunctions* gl, void* context)
{
    const qcDeviceBuffer* buffer = context;
    gl->DeleteBuffers(1, &buffer->name);
    gl->DeleteMemoryObjects(1, &buffer->memory);
    return qc_statusOk;
}

void qcDeviceBuffer_Close(qcDeviceBuffer* buffer)
{
    if (buffer == NULL)
        return;
    // A lost context takes its objects along.
    if (buffer->memory != 0 && buffer->generation == qcDevice_GetGeneration(buffer->device))
        (void)qcDevice_RunIn(buffer->device, buffer->generation, Close, buffer, "qcDeviceBuffer_Close");
    qcFree(buffer, sizeof *buffer);
}

qcStatus qcDeviceBuffer_Check(const qcDeviceBuffer* buffer, const qcDevice* device, const char* function)
{
    if (buffer == NULL)
        return qcFail(qc_statusBadInput, "%s: def->buffer is null", function);
    if (buffer->device != device)
        return qcFail(qc_statusBadInput, "%s: def->buffer belongs to another device than the scene's", function);
    if (buffer->generation != qcDevice_GetGeneration(buffer->device))
        return qcFail(qc_statusDeviceLost, "%s: the device was reopened since def->buffer was opened", function);
    return qc_statusOk;
}

qcStatus qcBufferRange_Check(const struct qcGlFunctions* gl, const qcBufferRange* range, const char* function,
                             uint64_t* first)
{
    GLint64 whole = 0;
    if (!gl->IsBuffer(range->buffer->name))
        return FailBuffer(function, range->buffer->name);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, range->buffer->name);
    gl->GetBufferParameteri64v(GL_SHADER_STORAGE_BUFFER, GL_BUFFER_SIZE, &whole);
    uint64_t begin = range->buffer->begin, size = (uint64_t)whole > begin ? (uint64_t)whole - begin : 0;
    *first = begin + range->offset;
    if (range->offset <= size && range->bytes <= size - range->offset)
        return qc_statusOk;
    return qcFail(qc_statusBadInput, "%s: %llu bytes from byte %llu on are more than the buffer's %llu", function,
                  (unsigned long long)range->bytes, (unsigned long long)range->offset, (unsigned long long)size);
}

typedef struct Writing
{
    const qcBufferRange* room;
    const qcPair* pairs;
    size_t count;
    const char* function;
} Writing;

/// By way of a buffer of our own: the host's may be one that only the device writes (GL_DYNAMIC_STORAGE_BIT).
static qcStatus Write(const struct qcGlFunctions* gl, void* context)
{
    const Writing* w = context;
    const uint32_t count = (uint32_t)w->count;
    const GLsizeiptr bytes = (GLsizeiptr)(sizeof count + w->count * sizeof(qcPair));
    uint64_t first = 0;
    GLuint copy = 0;
    QC_TRY(qcBufferRange_Check(gl, w->room, w->function, &first));
    gl->GenBuffers(1, &copy);
    gl->BindBuffer(GL_COPY_READ_BUFFER, copy);
    gl->BufferData(GL_COPY_READ_BUFFER, bytes, NULL, GL_STREAM_COPY);
    gl->BufferSubData(GL_COPY_READ_BUFFER, 0, sizeof count, &count);
    if (count != 0)
        gl->BufferSubData(GL_COPY_READ_BUFFER, sizeof count, (GLsizeiptr)(w->count * sizeof(qcPair)), w->pairs);
    gl->CopyBufferSubData(GL_COPY_READ_BUFFER, GL_SHADER_STORAGE_BUFFER, 0, (GLintptr)first, bytes);
    gl->DeleteBuffers(1, &copy);
    gl->Finish();
    return qc_statusOk;
}

qcStatus qcDeviceBuffer_Write(const qcBufferRange* room, const qcPair* pairs, size_t count, const char* function)
{
    Writing writing = {room, pairs, count, function};
    return qcDevice_RunIn(room->buffer->device, room->buffer->generation, Write, &writing, function);
}

qcStatus qcGl_WaitForHost(const struct qcGlFunctions* gl, void* fence, const char* function)
{
    if (fence == NULL)
        return qc_statusOk;
    if (!gl->IsSync((GLsync)fence))
        return qcFail(qc_statusBadInput, "%s: def->fence is not a GLsync of the shared context", function);
    // On this side of the call: some drivers don't wait in glWaitSync.
    for (int i = 0; i < qc_fenceSeconds * qc_waitsPerSecond; i++)
    {
        GLenum state = gl->ClientWaitSync((GLsync)fence, 0, qc_waitNanoseconds);
        if (state == GL_ALREADY_SIGNALED || state == GL_CONDITION_SATISFIED)
            return qc_statusOk;
        if (state == GL_WAIT_FAILED)
            return qcFail(qc_statusDevice, "%s: waiting for def->fence failed", function);
    }
    return qcFail(qc_statusDevice,
                  "%s: def->fence was not signalled in %d seconds (does the host call glFlush after glFenceSync?)",
                  function, qc_fenceSeconds);
}
