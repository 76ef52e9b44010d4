// Devices: opening and its messages, the choice of a GPU, reopening, jobs and their errors.
#define _POSIX_C_SOURCE 200809L
#include "gl/device_jobs.h"
#include "base/status.h"
#include "support/suite.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

static const char* const s_names[] = {"auto", "egl", "osmesa", "surfaceless", "none"};

//  ---- opening -------------------------------------------------------------------------------------

START_TEST(a_named_kind_opens_or_gives_a_reason)
{
    for (int kind = qc_deviceEgl; kind <= qc_deviceNone; ++kind)
    {
        qcDevice* device = NULL;
        qcStatus status = qcOpenKind((qcDeviceKind)kind, &device);
        if (status == qc_statusOk)
        {
            qcDeviceInfo info;
            ck_assert_int_eq(qcDevice_GetInfo(device, &info), qc_statusOk);
            ck_assert_int_eq(info.kind, kind);
            ck_assert_str_eq(info.name, s_names[kind]);
        }
        else
        {
            ck_assert_int_eq(status, qc_statusDevice);
            ck_assert_ptr_null(device);
            char start[32];
            snprintf(start, sizeof start, "device %s: ", s_names[kind]);
            ck_assert_int_eq(strncmp(qcLastMessage(), start, strlen(start)), 0);
            ck_assert_uint_gt(strlen(qcLastMessage()), strlen(start));
        }
        qcDevice_Destroy(device);
        ck_assert_uint_eq(qcGetByteCount(), 0);
    }
}
END_TEST

START_TEST(the_device_none_always_opens_and_has_no_gl)
{
    qcDevice* device = NULL;
    ck_assert_int_eq(qcOpenKind(qc_deviceNone, &device), qc_statusOk);
    qcDeviceInfo info;
    ck_assert_int_eq(qcDevice_GetInfo(device, &info), qc_statusOk);
    ck_assert_int_eq(info.kind, qc_deviceNone);
    ck_assert_str_eq(info.renderer, "");
    ck_assert_str_eq(info.version, "");
    ck_assert_uint_eq(info.maxResolution, 0);
    ck_assert_int_eq(qcDevice_Run(device, NULL, NULL, "a test"), qc_statusDevice);
    ck_assert_str_eq(qcLastMessage(), "a test: the device none has no GL");
    qcDevice_Destroy(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static void CountSkipped(const char* line, void* context)
{
    // "device KIND skipped: REASON"
    ck_assert_ptr_nonnull(strstr(line, " skipped: "));
    ++*(int*)context;
}

START_TEST(auto_opens_the_first_kind_that_works_and_logs_the_others)
{
    int skipped = 0;
    qcSetLog(CountSkipped, &skipped);
    qcDevice* device = NULL;
    ck_assert_int_eq(qcOpenKind(qc_deviceAuto, &device), qc_statusOk);
    qcSetLog(NULL, NULL);
    qcDeviceInfo info;
    ck_assert_int_eq(qcDevice_GetInfo(device, &info), qc_statusOk);
    qcDeviceKind kinds[] = {qc_deviceEgl, qc_deviceOsmesa, qc_deviceSurfaceless, qc_deviceNone};
    if (getenv("GALLIUM_DRIVER") != NULL || getenv("MESA_LOADER_DRIVER_OVERRIDE") != NULL)
    {
        kinds[1] = qc_deviceSurfaceless;
        kinds[2] = qc_deviceOsmesa;
    }
    int at = 0;
    for (; at < 3 && kinds[at] != info.kind; ++at)
    {
        qcDevice* other = NULL;
        ck_assert_int_eq(qcOpenKind(kinds[at], &other), qc_statusDevice);
    }
    ck_assert_int_eq(info.kind, kinds[at]);
    ck_assert_int_eq(skipped, at);
    qcDevice_Destroy(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(auto_prefers_surfaceless_where_the_environment_names_a_driver)
{
    setenv("GALLIUM_DRIVER", "softpipe", 1);
    qcDevice *surfaceless = NULL, *device = NULL;
    if (qcOpenKind(qc_deviceSurfaceless, &surfaceless) == qc_statusOk)
    {
        ck_assert_int_eq(qcOpenKind(qc_deviceAuto, &device), qc_statusOk);
        qcDeviceInfo info;
        qcDevice_GetInfo(device, &info);
        ck_assert(info.kind == qc_deviceSurfaceless || info.kind == qc_deviceEgl);
    }
    qcDevice_Destroy(surfaceless);
    qcDevice_Destroy(device);
}
END_TEST

START_TEST(osmesa_refuses_drivers_that_it_crashes_with)
{
    const char* drivers[] = {"zink", "swr", "no such driver"};
    for (int i = 0; i < 3; ++i)
    {
        setenv("GALLIUM_DRIVER", drivers[i], 1);
        qcDevice* device = NULL;
        ck_assert_int_eq(qcOpenKind(qc_deviceOsmesa, &device), qc_statusDevice);
        ck_assert_ptr_null(device);
    }
}
END_TEST

START_TEST(a_bad_definition_is_refused_by_name)
{
    qcDevice* device = NULL;
    qcDeviceDef def = qcDefaultDeviceDef();
    ck_assert_int_eq(qcDevice_Create(NULL, &device), qc_statusBadInput);
    ck_assert_int_eq(qcDevice_Create(&def, NULL), qc_statusBadInput);
    def.structSize = 3;
    ck_assert_int_eq(qcDevice_Create(&def, &device), qc_statusBadInput);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "structSize"));
    def = qcDefaultDeviceDef();
    def.kind = (qcDeviceKind)17;
    ck_assert_int_eq(qcDevice_Create(&def, &device), qc_statusBadInput);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "17"));
    const uint8_t uuid[16] = {1};
    char longName[129];
    memset(longName, 'x', 128);
    longName[128] = 0;
    const struct
    {
        qcDeviceKind kind;
        int32_t index;
        const char* name;
        const uint8_t* uuid;
        const char* message;
    } choices[] = {{qc_deviceEgl, -2, NULL, NULL, "gpuIndex is -2"},
                   {qc_deviceEgl, -1, longName, NULL, "gpuName has 128 bytes"},
                   {qc_deviceAuto, 0, NULL, NULL, "def->kind is auto"},
                   {qc_deviceOsmesa, -1, "x", NULL, "def->kind is osmesa"},
                   {qc_deviceSurfaceless, -1, NULL, uuid, "def->kind is surfaceless"}};
    for (size_t i = 0; i < sizeof choices / sizeof choices[0]; ++i)
    {
        def = qcDefaultDeviceDef();
        def.kind = choices[i].kind;
        def.gpuIndex = choices[i].index;
        def.gpuName = choices[i].name;
        def.gpuUuid = choices[i].uuid;
        ck_assert_int_eq(qcDevice_Create(&def, &device), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), choices[i].message));
    }
    def = qcDefaultDeviceDef();
    def.reopenSeconds = (double)NAN;
    ck_assert_int_eq(qcDevice_Create(&def, &device), qc_statusBadInput);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "reopenSeconds is not a number"));
    ck_assert_int_eq(qcDevice_Reopen(NULL), qc_statusBadInput);
    qcDeviceInfo info;
    ck_assert_int_eq(qcDevice_GetInfo(NULL, &info), qc_statusBadInput);
    ck_assert_ptr_null(device);
    qcDevice_Destroy(NULL);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static qcStatus OpenGpu(int32_t index, const char* name, const uint8_t* uuid, qcDevice** device)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = qc_deviceEgl;
    def.gpuIndex = index;
    def.gpuName = name;
    def.gpuUuid = uuid;
    return qcDevice_Create(&def, device);
}

/// True if this choice opens this GPU. A failure message lists the GPUs of EGL, or those that were tried.
static bool OpensAs(int32_t index, const char* name, const uint8_t* uuid, const char* renderer)
{
    qcDevice* device = NULL;
    qcStatus status = OpenGpu(index, name, uuid, &device);
    if (status != qc_statusOk)
    {
        ck_assert_int_eq(status, qc_statusDevice);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), renderer));
        return false;
    }
    qcDeviceInfo info;
    qcDevice_GetInfo(device, &info);
    ck_assert_int_eq(info.kind, qc_deviceEgl);
    bool same = strcmp(info.renderer, renderer) == 0;
    qcDevice_Destroy(device);
    return same;
}

START_TEST(a_gpu_is_chosen_by_number_by_name_and_by_uuid)
{
    const uint8_t none[16] = {0};
    int32_t index = 0;
    qcDevice* device = NULL;
    for (; OpenGpu(index, NULL, NULL, &device) == qc_statusOk; ++index)
    {
        qcDeviceInfo info;
        qcDevice_GetInfo(device, &info);
        ck_assert_int_eq(info.kind, qc_deviceEgl);
        char renderer[128], part[128];
        snprintf(renderer, sizeof renderer, "%s", info.renderer);
        snprintf(part, sizeof part, "%s", info.renderer + 2);
        uint8_t uuid[16];
        memcpy(uuid, info.uuid, sizeof uuid);
        bool hasUuid = memcmp(uuid, none, sizeof uuid) != 0;
        printf("GPU %d: %s%s\n", (int)index, renderer, hasUuid ? "" : " (no UUID)");
        qcDevice_Destroy(device);

        ck_assert(OpensAs(index, renderer, NULL, renderer));
        ck_assert(OpensAs(-1, part, NULL, renderer));
        ck_assert(!OpensAs(index, "no such name", NULL, renderer));
        ck_assert(!OpensAs(-1, "no such name", NULL, renderer));
        ck_assert(!hasUuid || OpensAs(-1, NULL, uuid, renderer));
        ck_assert(!hasUuid || OpensAs(index, part, uuid, renderer));
        uuid[3] ^= 1;
        ck_assert(!OpensAs(index, NULL, uuid, renderer));
        ck_assert(!OpensAs(-1, renderer, uuid, renderer));
    }
    ck_assert_int_eq(OpenGpu(64, NULL, NULL, &device), qc_statusDevice);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_device_that_is_reopened_draws_again)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo before, after;
        qcDevice_GetInfo(device, &before);
        char renderer[128];
        snprintf(renderer, sizeof renderer, "%s", before.renderer);
        for (uint32_t round = 0; round < 3; ++round)
        {
            ck_assert_uint_eq(qcDevice_GetGeneration(device), round + 1);
            uint8_t rgba[4] = {10, 20, 30, 0};
            ck_assert_int_eq(qcDevice_Run(device, qcClearAndRead, rgba, "a test"), qc_statusOk);
            ck_assert_uint_eq(rgba[0], 10);
            ck_assert_int_eq(qcDevice_Reopen(device), qc_statusOk);
        }
        qcDevice_GetInfo(device, &after);
        ck_assert_int_eq(after.kind, before.kind);
        ck_assert_str_eq(after.renderer, renderer);
        ck_assert(!after.lost);
    }
    qcDevice* none = NULL;
    ck_assert_int_eq(qcOpenKind(qc_deviceNone, &none), qc_statusOk);
    ck_assert_int_eq(qcDevice_Reopen(none), qc_statusOk);
    qcDevice_Destroy(none);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_device_that_does_not_reopen_stays_lost_until_it_does)
{
    unsetenv("GALLIUM_DRIVER");
    qcDevice* device = qcOpenOrSkip(qc_deviceOsmesa);
    if (device == NULL)
        return;
    setenv("GALLIUM_DRIVER", "none", 1);
    for (int i = 0; i < 2; ++i)
    {
        ck_assert_int_eq(qcDevice_Reopen(device), qc_statusDevice);
        uint8_t rgba[4] = {10, 20, 30, 0};
        ck_assert_int_eq(qcDevice_Run(device, qcClearAndRead, rgba, "a test"), qc_statusDeviceLost);
        qcDeviceInfo info;
        qcDevice_GetInfo(device, &info);
        ck_assert(info.lost);
    }
    unsetenv("GALLIUM_DRIVER");
    ck_assert_int_eq(qcDevice_Reopen(device), qc_statusOk);
    uint8_t rgba[4] = {10, 20, 30, 0};
    ck_assert_int_eq(qcDevice_Run(device, qcClearAndRead, rgba, "a test"), qc_statusOk);
    qcDevice_Destroy(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(software_devices_are_identified)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo info;
        ck_assert_int_eq(qcDevice_GetInfo(device, &info), qc_statusOk);
        ck_assert_uint_gt(strlen(info.renderer), 0);
        ck_assert_uint_gt(strlen(info.version), 0);
        ck_assert_uint_ge(info.maxResolution, 1024); // the minimum of GL 3.3
        if (info.kind == qc_deviceOsmesa)
            ck_assert(info.software);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static void* RefuseMemory(size_t size, void* context)
{
    (void)size;
    (void)context;
    return NULL;
}

static void FreeMemory(void* memory, size_t size, void* context)
{
    (void)size;
    (void)context;
    free(memory);
}

START_TEST(a_device_without_memory_fails_with_a_status)
{
    ck_assert_int_eq(qcSetAllocator(RefuseMemory, FreeMemory, NULL), qc_statusOk);
    qcDevice* device = NULL;
    ck_assert_int_eq(qcOpenKind(qc_deviceAuto, &device), qc_statusOutOfMemory);
    ck_assert_ptr_null(device);
    ck_assert_int_eq(qcSetAllocator(NULL, NULL, NULL), qc_statusOk);
}
END_TEST

START_TEST(devices_open_and_close_many_times_and_side_by_side)
{
    qcDevice* devices[6] = {NULL};
    for (int round = 0; round < 5; ++round)
    {
        for (int i = 0; i < 6; ++i)
        {
            if (qcOpenKind(qc_testKinds[i % qc_testDeviceCount], &devices[i]) != qc_statusOk)
                devices[i] = NULL;
        }
        // Not in the order in which they were opened.
        for (int i = 0; i < 6; ++i)
        {
            qcDevice_Destroy(devices[(5 * i + round) % 6]);
            devices[(5 * i + round) % 6] = NULL;
        }
        ck_assert_uint_eq(qcGetByteCount(), 0);
    }
}
END_TEST

//  ---- jobs ----------------------------------------------------------------------------------------

static qcStatus CheckVersion(const struct qcGlFunctions* gl, void* context)
{
    GLint major = 0, minor = 0;
    gl->GetIntegerv(GL_MAJOR_VERSION, &major);
    gl->GetIntegerv(GL_MINOR_VERSION, &minor);
    *(int*)context = 10 * major + minor;
    return qc_statusOk;
}

START_TEST(a_job_finds_a_context_of_gl_3_3_or_more)
{
    QC_FOR_EACH_DEVICE(device)
    {
        int version = 0;
        ck_assert_int_eq(qcDevice_Run(device, CheckVersion, &version, "a test"), qc_statusOk);
        ck_assert_int_ge(version, 33);
    }
}
END_TEST

static qcStatus FailJob(const struct qcGlFunctions* gl, void* context)
{
    (void)gl;
    return qcFail(qc_statusOutOfMemory, "the job fails: %s", (const char*)context);
}

static qcStatus MakeGlErrors(const struct qcGlFunctions* gl, void* context)
{
    (void)context;
    gl->Enable(0xdead);
    gl->DepthFunc(0xbeef);
    gl->Viewport(0, 0, -1, -1);
    return qc_statusOk;
}

START_TEST(status_and_message_of_a_job_reach_the_caller)
{
    QC_FOR_EACH_DEVICE(device)
    {
        ck_assert_int_eq(qcDevice_Run(device, FailJob, "no", "a test"), qc_statusOutOfMemory);
        ck_assert_str_eq(qcLastMessage(), "the job fails: no");
    }
}
END_TEST

START_TEST(a_gl_error_is_a_status_and_the_device_goes_on)
{
    QC_FOR_EACH_DEVICE(device)
    {
        ck_assert_int_eq(qcDevice_Run(device, MakeGlErrors, NULL, "bad drawing"), qc_statusDevice);
        ck_assert_str_eq(qcLastMessage(), "bad drawing: GL_INVALID_ENUM (0x500)");
        // Nothing of it is left for the next job.
        int version = 0;
        ck_assert_int_eq(qcDevice_Run(device, CheckVersion, &version, "a test"), qc_statusOk);
    }
}
END_TEST

START_TEST(gl_errors_have_names)
{
    const struct
    {
        GLenum error;
        const char* name;
    } errors[] = {{GL_INVALID_VALUE, "GL_INVALID_VALUE"},
                  {GL_INVALID_OPERATION, "GL_INVALID_OPERATION"},
                  {GL_INVALID_FRAMEBUFFER_OPERATION, "GL_INVALID_FRAMEBUFFER_OPERATION"},
                  {GL_OUT_OF_MEMORY, "GL_OUT_OF_MEMORY"},
                  {GL_CONTEXT_LOST, "GL_CONTEXT_LOST"},
                  {0x9999, "a GL error"}};
    for (size_t i = 0; i < sizeof errors / sizeof errors[0]; i++)
        ck_assert_str_eq(qcGl_ErrorName(errors[i].error), errors[i].name);
}
END_TEST

static qcStatus LeaveStateBehind(const struct qcGlFunctions* gl, void* context)
{
    (void)context;
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_POLYGON_OFFSET_FILL);
    gl->Enable(GL_FRAMEBUFFER_SRGB);
    gl->DepthMask(GL_FALSE);
    gl->DepthFunc(GL_GREATER);
    gl->FrontFace(GL_CW);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, 77);
    return qc_statusOk;
}

static qcStatus FindInitialState(const struct qcGlFunctions* gl, void* context)
{
    (void)context;
    const struct
    {
        GLenum name;
        GLint initial;
    } states[] = {{GL_DEPTH_TEST, 0},      {GL_POLYGON_OFFSET_FILL, 0}, {GL_FRAMEBUFFER_SRGB, 0},
                  {GL_DEPTH_WRITEMASK, 1}, {GL_DEPTH_FUNC, GL_LESS},    {GL_FRONT_FACE, GL_CCW},
                  {GL_PACK_ROW_LENGTH, 0}};
    for (size_t i = 0; i < sizeof states / sizeof states[0]; ++i)
    {
        GLint value = -1;
        gl->GetIntegerv(states[i].name, &value);
        if (value != states[i].initial)
            return qcFail(qc_statusBadInput, "state 0x%x is 0x%x", states[i].name, (unsigned)value);
    }
    GLint modes[2] = {0, 0};
    gl->GetIntegerv(GL_POLYGON_MODE, modes);
    return modes[0] == GL_FILL ? qc_statusOk
                               : qcFail(qc_statusBadInput, "the polygon mode is 0x%x", (unsigned)modes[0]);
}

START_TEST(a_job_finds_the_initial_state)
{
    QC_FOR_EACH_DEVICE(device)
    {
        ck_assert_int_eq(qcDevice_Run(device, FindInitialState, NULL, "a test"), qc_statusOk);
        ck_assert_int_eq(qcDevice_Run(device, LeaveStateBehind, NULL, "a test"), qc_statusOk);
        qcStatus status = qcDevice_Run(device, FindInitialState, NULL, "a test");
        ck_assert_msg(status == qc_statusOk, "%s", qcLastMessage());
    }
}
END_TEST

enum
{
    qc_jobsPerCaller = 200
};

typedef struct Caller
{
    qcDevice* device;
    int* count; ///< no lock: jobs of one device never overlap
    int number;
    int wrongMessages;
} Caller;

static qcStatus CountJob(const struct qcGlFunctions* gl, void* context)
{
    (void)gl;
    Caller* caller = context;
    ++*caller->count;
    return qcFail(qc_statusBadInput, "caller %d", caller->number);
}

static void* CallOften(void* argument)
{
    Caller* caller = argument;
    char expected[32];
    snprintf(expected, sizeof expected, "caller %d", caller->number);
    for (int i = 0; i < qc_jobsPerCaller; ++i)
    {
        if (qcDevice_Run(caller->device, CountJob, caller, "a test") != qc_statusBadInput ||
            strcmp(qcLastMessage(), expected) != 0)
            ++caller->wrongMessages;
    }
    return NULL;
}

START_TEST(many_callers_are_served_one_after_another_each_with_its_own_message)
{
    QC_FOR_EACH_DEVICE(device)
    {
        int count = 0;
        Caller callers[4];
        pthread_t threads[4];
        for (int i = 0; i < 4; ++i)
        {
            callers[i] = (Caller){device, &count, i, 0};
            ck_assert_int_eq(pthread_create(&threads[i], NULL, CallOften, &callers[i]), 0);
        }
        for (int i = 0; i < 4; ++i)
        {
            ck_assert_int_eq(pthread_join(threads[i], NULL), 0);
            ck_assert_int_eq(callers[i].wrongMessages, 0);
        }
        ck_assert_int_eq(count, 4 * qc_jobsPerCaller);
    }
}
END_TEST

typedef struct Drawer
{
    qcDeviceKind kind;
    uint8_t color;
    int wrong;
} Drawer;

static void* DrawOften(void* argument)
{
    Drawer* drawer = argument;
    for (int round = 0; round < 5; ++round)
    {
        qcDevice* device = NULL;
        if (qcOpenKind(drawer->kind, &device) != qc_statusOk)
            return NULL;
        for (int i = 0; i < 20; ++i)
        {
            uint8_t rgba[4] = {drawer->color, (uint8_t)i, 0, 0};
            if (qcDevice_Run(device, qcClearAndRead, rgba, "a test") != qc_statusOk || rgba[0] != drawer->color ||
                rgba[1] != i || rgba[3] != 255)
                ++drawer->wrong;
        }
        qcDevice_Destroy(device);
    }
    return NULL;
}

START_TEST(devices_on_several_threads_do_not_disturb_each_other)
{
    Drawer drawers[4];
    pthread_t threads[4];
    for (int i = 0; i < 4; ++i)
    {
        drawers[i] = (Drawer){qc_testKinds[i % qc_testDeviceCount], (uint8_t)(50 * i + 20), 0};
        ck_assert_int_eq(pthread_create(&threads[i], NULL, DrawOften, &drawers[i]), 0);
    }
    for (int i = 0; i < 4; ++i)
    {
        ck_assert_int_eq(pthread_join(threads[i], NULL), 0);
        ck_assert_int_eq(drawers[i].wrong, 0);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("device", a_named_kind_opens_or_gives_a_reason, the_device_none_always_opens_and_has_no_gl,
                        auto_opens_the_first_kind_that_works_and_logs_the_others,
                        auto_prefers_surfaceless_where_the_environment_names_a_driver,
                        osmesa_refuses_drivers_that_it_crashes_with, a_bad_definition_is_refused_by_name,
                        a_gpu_is_chosen_by_number_by_name_and_by_uuid, a_device_that_is_reopened_draws_again,
                        a_device_that_does_not_reopen_stays_lost_until_it_does, software_devices_are_identified,
                        a_device_without_memory_fails_with_a_status, devices_open_and_close_many_times_and_side_by_side,
                        a_job_finds_a_context_of_gl_3_3_or_more, status_and_message_of_a_job_reach_the_caller,
                        a_gl_error_is_a_status_and_the_device_goes_on, gl_errors_have_names,
                        a_job_finds_the_initial_state,
                        many_callers_are_served_one_after_another_each_with_its_own_message,
                        devices_on_several_threads_do_not_disturb_each_other)
