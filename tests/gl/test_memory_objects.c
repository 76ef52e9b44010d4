// Memory of another API, imported by a driver that is made up: its memory objects are buffers of the device's own GL
// with the content that a test gives them. What the real ones do: test_imported_memory.c, where there is Vulkan.
#define _GNU_SOURCE // memfd_create
#include "gl/replaced_driver.h"
#include "support/suite.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

enum
{
    t_offset = 20,  ///< of the positions in the memory
    t_reserve = 64, ///< bytes that llvmpipe keeps behind a buffer
    t_object = 77
};

static const void* s_content; ///< of the memory
static GLsizeiptr s_room;     ///< bytes that a buffer may have
static GLenum s_importError, s_pendingError;
static int s_objects, s_fd; ///< memory objects that there are; the descriptor that was imported last
static bool s_isDedicated;

static void APIENTRY CreateObjects(GLsizei count, GLuint* objects)
{
    ck_assert_int_eq(count, 1);
    objects[0] = t_object;
    s_objects++;
}

static void APIENTRY DeleteObjects(GLsizei count, const GLuint* objects)
{
    ck_assert(count == 1 && objects[0] == t_object);
    s_objects--;
}

static void APIENTRY SetParameter(GLuint object, GLenum name, const GLint* values)
{
    ck_assert(object == t_object && name == GL_DEDICATED_MEMORY_OBJECT_EXT);
    s_isDedicated = values[0] == GL_TRUE;
}

/// Takes the descriptor, unless it fails.
static void APIENTRY Import(GLuint object, GLuint64 size, GLenum type, GLint fd)
{
    ck_assert(object == t_object && size > 0 && type == GL_HANDLE_TYPE_OPAQUE_FD_EXT);
    s_fd = fd;
    s_pendingError = s_importError;
    if (s_importError == GL_NO_ERROR)
        close(fd);
}

static void APIENTRY MakeStorage(GLenum target, GLsizeiptr size, GLuint object, GLuint64 offset)
{
    ck_assert(object == t_object && offset == 0);
    if (size <= s_room)
        s_real.BufferData(target, size, s_content, GL_STATIC_DRAW);
    else
        s_pendingError = GL_OUT_OF_MEMORY;
}

static bool s_drops;    ///< the run until the next fence does nothing
static int s_dropCount; ///< of kernels

static void APIENTRY Dispatch(GLuint x, GLuint y, GLuint z)
{
    s_dropCount += s_drops;
    if (!s_drops)
        s_real.DispatchCompute(x, y, z);
}

static GLsync APIENTRY EndRun(GLenum condition, GLbitfield flags)
{
    s_drops = false;
    return s_real.FenceSync(condition, flags);
}

static GLenum APIENTRY GetPendingError(void)
{
    GLenum error = s_pendingError;
    s_pendingError = GL_NO_ERROR;
    return error != GL_NO_ERROR ? error : s_real.GetError();
}

static void MakeImporting(struct qcGlFunctions* gl)
{
    gl->CreateMemoryObjects = CreateObjects;
    gl->DeleteMemoryObjects = DeleteObjects;
    gl->MemoryObjectParameteriv = SetParameter;
    gl->ImportMemoryFd = Import;
    gl->BufferStorageMem = MakeStorage;
    gl->GetError = GetPendingError;
    gl->DispatchCompute = Dispatch;
    gl->FenceSync = EndRun;
}

/// A definition of memory; the caller closes its descriptor.
static qcDeviceBufferDef MakeDef(uint64_t size)
{
    qcDeviceBufferDef def = qcDefaultDeviceBufferDef();
    def.memoryFd = memfd_create("memory", 0);
    ck_assert_int_ge(def.memoryFd, 0);
    def.memorySize = size;
    def.memoryOffset = t_offset;
    s_importError = s_pendingError = GL_NO_ERROR;
    s_room = (GLsizeiptr)size;
    s_isDedicated = false;
    return def;
}

/// A cloth as floats behind t_offset bytes, and its size with what llvmpipe keeps.
static char* MakeContent(const qcSoup* soup, uint64_t* size)
{
    *size = t_offset + 3 * sizeof(float) * (uint64_t)soup->vertexCount + t_reserve;
    char* content = calloc(*size, 1);
    ck_assert_ptr_nonnull(content);
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
    {
        float x = (float)soup->positions[i];
        memcpy(content + t_offset + i * sizeof x, &x, sizeof x);
    }
    return content;
}

static qcScene* MakeCloth(qcDevice* device, const qcSoup* soup, qcBodyId* id)
{
    qcScene* scene = qcMakeScene(device);
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = true;
    CHECK_OK(qcScene_AddBody(scene, &def, id));
    return scene;
}

/// The scene takes its positions from the buffer, and finds the pairs of the same floats without a device. `drops`: its
/// first run does nothing.
static void CheckPairsOf(qcDeviceBuffer* buffer, qcDevice* device, const qcSoup* soup, const char* content, bool drops)
{
    qcBodyId ids[2];
    qcSoup flat = *soup;
    flat.positions = calloc(soup->vertexCount, 3 * sizeof(double));
    qcScene *onDevice = MakeCloth(device, &flat, &ids[0]), *onCpu = MakeCloth(NULL, soup, &ids[1]);
    qcVertexBufferDef vertices = qcDefaultVertexBufferDef();
    vertices.buffer = buffer;
    CHECK_OK(qcScene_SetVertexBuffer(onDevice, ids[0], &vertices));
    CHECK_OK(qcScene_SetVertices(onCpu, ids[1], content + t_offset, qc_positionF32, 0));
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    qcPairList expected = qcDetectPairs(onCpu, &def);
    ck_assert_uint_gt(expected.count, 10);
    def.method = qc_methodLayers;
    s_drops = drops;
    s_dropCount = 0;
    qcPairList found = qcDetectPairs(onDevice, &def);
    ck_assert(!s_drops && (s_dropCount > 0) == drops);
    const qcResult* result;
    CHECK_OK(qcScene_Detect(onDevice, &def, &result));
    ck_assert_int_eq(result->profile.method, qc_methodLayers);
    qcCheckSamePairs(&expected, &found, "imported");
    free(expected.pairs);
    free(found.pairs);
    free(flat.positions);
    qcScene_Destroy(onDevice);
    qcScene_Destroy(onCpu);
}

START_TEST(imported_memory_has_the_pairs_of_the_cpu_also_where_its_end_is_reserved_or_a_run_is_dropped)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(5, 16, 0.02, 0.011);
    uint64_t size;
    char* content = MakeContent(&soup, &size);
    s_content = content;
    QC_FOR_EACH_DEVICE(device)
    {
        for (int isReserved = 0; isReserved < 2 && MakeDriver(device, MakeImporting); isReserved++)
        {
            qcDeviceBufferDef def = MakeDef(size);
            def.dedicated = isReserved != 0;
            s_room = (GLsizeiptr)(isReserved != 0 ? size - t_reserve : size);
            qcDeviceBuffer* buffer = NULL;
            CHECK_OK(qcDevice_OpenBuffer(device, &def, &buffer));
            // The driver has a descriptor of its own.
            ck_assert_int_ne(s_fd, def.memoryFd);
            ck_assert_int_eq(close(def.memoryFd), 0);
            ck_assert(s_isDedicated == def.dedicated);
            CheckPairsOf(buffer, device, &soup, content, isReserved != 0);
            ck_assert_int_eq(s_objects, 1);
            qcDeviceBuffer_Close(buffer);
            ck_assert_int_eq(s_objects, 0);
            // Otherwise the next round takes this driver for the real one.
            CHECK_OK(qcDevice_Reopen(device));
        }
    }
    free(content);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(memory_that_is_not_imported_is_named_and_its_descriptor_closed)
{
    QC_FOR_EACH_DEVICE(device)
    {
        if (!MakeDriver(device, MakeImporting))
            continue;
        const struct
        {
            GLenum importError;
            GLsizeiptr room;
            const char* reason;
        } cases[] = {{GL_INVALID_VALUE, 4096, "can't import the memory of def->memoryFd: GL_INVALID_VALUE (0x501)"},
                     {GL_NO_ERROR, 4096 - t_reserve - 1, "GL_OUT_OF_MEMORY"}};
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        {
            qcDeviceBufferDef def = MakeDef(4096);
            s_importError = cases[i].importError;
            s_room = cases[i].room;
            qcDeviceBuffer* buffer = NULL;
            ck_assert_int_eq(qcDevice_OpenBuffer(device, &def, &buffer), qc_statusDevice);
            ck_assert_ptr_null(buffer);
            ck_assert_msg(strstr(qcLastMessage(), cases[i].reason) != NULL, "%s", qcLastMessage());
            ck_assert_int_eq(s_objects, 0);
            ck_assert_int_eq(fcntl(s_fd, F_GETFD), -1);
            // The caller's is still open.
            ck_assert_int_eq(close(def.memoryFd), 0);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static void MakePoor(struct qcGlFunctions* gl)
{
    gl->ImportMemoryFd = NULL;
}

static void MakeOld(struct qcGlFunctions* gl)
{
    gl->DispatchCompute = NULL;
}

START_TEST(mistakes_and_what_a_device_lacks_are_named)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceBuffer* buffer = NULL;
        qcDeviceBufferDef def = MakeDef(4096);
        ck_assert_int_eq(qcDevice_OpenBuffer(NULL, &def, &buffer), qc_statusBadInput);
        ck_assert_int_eq(qcDevice_OpenBuffer(device, NULL, &buffer), qc_statusBadInput);
        ck_assert_int_eq(qcDevice_OpenBuffer(device, &def, NULL), qc_statusBadInput);
        ck_assert_str_eq(qcLastMessage(), "qcDevice_OpenBuffer: buffer is null");
        def.memoryOffset = 4096;
        ck_assert_int_eq(qcDevice_OpenBuffer(device, &def, &buffer), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "memoryOffset is 4096, memorySize 4096"));
        def.memoryOffset = 2;
        ck_assert_int_eq(qcDevice_OpenBuffer(device, &def, &buffer), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "it must be a multiple of 4"));
        def.memoryOffset = 0;
        if (MakeDriver(device, MakeImporting))
        {
            qcDeviceBufferDef closed = def;
            closed.memoryFd = 987;
            ck_assert_int_eq(qcDevice_OpenBuffer(device, &closed, &buffer), qc_statusBadInput);
            ck_assert_ptr_nonnull(strstr(qcLastMessage(), "987 is not an open file descriptor"));
        }
        CHECK_OK(qcDevice_Reopen(device));
        (void)MakeDriver(device, MakePoor);
        ck_assert_int_eq(qcDevice_OpenBuffer(device, &def, &buffer), qc_statusDevice);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "GL_EXT_memory_object_fd is missing"));
        (void)MakeDriver(device, MakeOld);
        ck_assert_int_eq(qcDevice_OpenBuffer(device, &def, &buffer), qc_statusDevice);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "no compute shaders (GL below 4.3)"));
        ck_assert_ptr_null(buffer);
        close(def.memoryFd);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("memory_objects",
                        imported_memory_has_the_pairs_of_the_cpu_also_where_its_end_is_reserved_or_a_run_is_dropped,
                        memory_that_is_not_imported_is_named_and_its_descriptor_closed,
                        mistakes_and_what_a_device_lacks_are_named)
