// GL libraries that lack something or refuse something: the reason is named and nothing stays open. And a GPU, which is
// Mesa under another name. egl_shim.c and osmesa_shim.c stand in front of the system's libraries.
#define _POSIX_C_SOURCE 200809L
#include "gl/device_jobs.h"
#include "gl/replaced_driver.h"
#include "support/suite.h"

#include <dlfcn.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>

/// From here on this process has a library under the name that it gives itself, as if the system had it.
static void Preload(const char* path)
{
    ck_assert_msg(dlopen(path, RTLD_NOW | RTLD_LOCAL) != NULL, "%s", dlerror());
}

static void Behave(const char* behaviour)
{
    setenv("QC_GL_SHIM", behaviour, 1);
}

static const struct
{
    qcDeviceKind kind;
    const char *behaviour, *reason;
} s_refusals[] = {
    {qc_deviceEgl, "no platforms", "libEGL lacks EGL_EXT_platform_base"},
    {qc_deviceEgl, "no devices", "libEGL lacks EGL_EXT_device_base or EGL_EXT_platform_device"},
    {qc_deviceEgl, "no GPU", "EGL lists no GPU"},
    {qc_deviceEgl, "", "draws in software"},
    {qc_deviceEgl, "software behind a GPU", "draws in software (llvmpipe"},
    {qc_deviceSurfaceless, "no platforms", "libEGL lacks EGL_EXT_platform_base"},
    {qc_deviceSurfaceless, "no surfaceless", "libEGL lacks EGL_MESA_platform_surfaceless"},
    {qc_deviceSurfaceless, "no display", "no EGL display (error 0x"},
    {qc_deviceSurfaceless, "not initialised", "eglInitialize failed (error 0x"},
    {qc_deviceSurfaceless, "no surfaceless contexts", "lacks EGL_KHR_surfaceless_context or EGL_KHR_create_context"},
    {qc_deviceSurfaceless, "no desktop GL", "EGL has no desktop GL (error 0x"},
    {qc_deviceSurfaceless, "no configuration", "EGL has no configuration for desktop GL"},
    {qc_deviceSurfaceless, "no context", "EGL gives no context of GL 3.3 core (error 0x"},
    {qc_deviceSurfaceless, "not current", "eglMakeCurrent failed (error 0x"},
    {qc_deviceSurfaceless, "no renderer", "the GL context reports no renderer"},
    {qc_deviceSurfaceless, "a function less", "the GL function glDrawArrays is missing"},
    {qc_deviceOsmesa, "no context", "OSMesa gives no context of GL 3.3 core"},
    {qc_deviceOsmesa, "not current", "OSMesaMakeCurrent failed"},
};

START_TEST(a_library_that_refuses_is_named_with_its_reason)
{
    Preload(QC_EGL_SHIM);
    Preload(QC_OSMESA_SHIM);
    Behave(s_refusals[_i].behaviour);
    // Twice: what the first attempt leaves behind doesn't hinder the second.
    for (int attempt = 0; attempt < 2; attempt++)
    {
        qcDevice* device = NULL;
        ck_assert_int_eq(qcOpenKind(s_refusals[_i].kind, &device), qc_statusDevice);
        ck_assert_ptr_null(device);
        ck_assert_msg(strstr(qcLastMessage(), s_refusals[_i].reason) != NULL, "'%s' lacks '%s'", qcLastMessage(),
                      s_refusals[_i].reason);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static const struct
{
    qcDeviceKind kind;
    const char* behaviour;
} s_detours[] = {
    {qc_deviceSurfaceless, "configurations"}, {qc_deviceSurfaceless, "GL 3.3"}, {qc_deviceOsmesa, "GL 3.3"}};

START_TEST(a_library_that_needs_a_configuration_or_an_older_version_draws)
{
    Preload(QC_EGL_SHIM);
    Preload(QC_OSMESA_SHIM);
    Behave(s_detours[_i].behaviour);
    qcDevice* device = NULL;
    CHECK_OK(qcOpenKind(s_detours[_i].kind, &device));
    uint8_t rgba[4] = {10, 20, 30, 0};
    CHECK_OK(qcDevice_Run(device, qcClearAndRead, rgba, "a test"));
    ck_assert(rgba[0] == 10 && rgba[1] == 20 && rgba[2] == 30);
    qcDevice_Destroy(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static const struct
{
    qcDeviceKind kind;
    const char *library, *reason;
} s_libraries[] = {{qc_deviceEgl, QC_EMPTY_EGL, "libEGL lacks eglBindAPI"},
                   {qc_deviceSurfaceless, QC_EMPTY_EGL, "libEGL lacks eglBindAPI"},
                   {qc_deviceOsmesa, QC_EMPTY_OSMESA, "libOSMesa lacks OSMesaCreateContextAttribs"},
                   // No library: no file can be opened.
                   {qc_deviceEgl, NULL, "no libEGL: libEGL.so.1: cannot open shared object file"},
                   {qc_deviceOsmesa, NULL, "no libOSMesa: libOSMesa.so: cannot open shared object file"}};

START_TEST(a_library_that_is_missing_or_lacks_a_function_is_named)
{
    struct rlimit limit;
    ck_assert_int_eq(getrlimit(RLIMIT_NOFILE, &limit), 0);
    const struct rlimit none = {3, limit.rlim_max};
    if (s_libraries[_i].library != NULL)
        Preload(s_libraries[_i].library);
    else
        ck_assert_int_eq(setrlimit(RLIMIT_NOFILE, &none), 0);
    qcDevice* device = NULL;
    ck_assert_int_eq(qcOpenKind(s_libraries[_i].kind, &device), qc_statusDevice);
    ck_assert_msg(strstr(qcLastMessage(), s_libraries[_i].reason) != NULL, "'%s' lacks '%s'", qcLastMessage(),
                  s_libraries[_i].reason);
    ck_assert_int_eq(setrlimit(RLIMIT_NOFILE, &limit), 0);
    ck_assert_ptr_null(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- a GPU -------------------------------------------------------------------------------------------------------

static qcStatus OpenGpu(const char* name, const uint8_t* uuid, qcDevice** device)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = qc_deviceEgl;
    def.gpuName = name;
    def.gpuUuid = uuid;
    return qcDevice_Create(&def, device);
}

START_TEST(a_gpu_is_no_software_and_the_first_choice_of_auto)
{
    Preload(QC_EGL_SHIM);
    Behave("a GPU");
    qcDevice* device = NULL;
    CHECK_OK(qcOpenKind(qc_deviceAuto, &device));
    qcDeviceInfo info;
    CHECK_OK(qcDevice_GetInfo(device, &info));
    ck_assert_int_eq(info.kind, qc_deviceEgl);
    ck_assert_str_eq(info.renderer, "Shim 1");
    ck_assert(!info.software);
    qcDevice_Destroy(device);
    device = NULL;
    const uint8_t uuid[16] = {1, 2, 3};
    ck_assert_int_eq(OpenGpu("Shim 2", NULL, &device), qc_statusDevice);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "has another name (Shim 1)"));
    ck_assert_int_eq(OpenGpu("Shim", uuid, &device), qc_statusDevice);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "has another UUID or none (Shim 1)"));
    CHECK_OK(OpenGpu("Shim", NULL, &device));
    qcDevice_Destroy(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// By default a GPU refines layers itself and stores flags for visibility.
START_TEST(a_gpu_finds_the_pairs_of_the_cpu)
{
    Preload(QC_EGL_SHIM);
    Behave("a GPU");
    qcDevice* device = NULL;
    CHECK_OK(qcOpenKind(qc_deviceEgl, &device));
    World world = MakeWorldOf(device, 60, 0.15);
    CheckAnswered(CheckPairs(world.scene, 0.0));
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    qcPairList expected = qcDetectPairs(world.scene, &def);
    def.method = qc_methodQuick;
    def.reliable = true;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(world.scene, &def, &result));
    ck_assert_int_eq(result->profile.method, qc_methodQuick);
    ck_assert_str_eq(result->profile.device, "egl");
    ck_assert(!result->profile.softwareDevice);
    qcPairList found = qcListOf(result);
    qcCheckSamePairs(&expected, &found, "quick");
    free(expected.pairs);
    qcScene_Destroy(world.scene);
    qcDevice_Destroy(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static char s_line[512];
static atomic_bool s_hasLine;

/// Keeps the first line.
static void KeepLine(const char* line, void* context)
{
    (void)context;
    if (atomic_load(&s_hasLine))
        return;
    snprintf(s_line, sizeof s_line, "%s", line);
    atomic_store(&s_hasLine, true);
}

static GLenum APIENTRY ReportReset(void)
{
    return GL_INNOCENT_CONTEXT_RESET;
}

static void MakeLost(struct qcGlFunctions* gl)
{
    gl->GetGraphicsResetStatus = ReportReset;
}

START_TEST(a_lost_gpu_is_not_replaced_by_another)
{
    Preload(QC_EGL_SHIM);
    Behave("a GPU");
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = qc_deviceEgl;
    def.reopenSeconds = 1e-6;
    qcDevice* device = NULL;
    CHECK_OK(qcDevice_Create(&def, &device));
    Replacement replacement = {MakeLost};
    ck_assert_int_eq(qcDevice_Run(device, Replace, &replacement, "a test"), qc_statusDeviceLost);
    Behave("another GPU");
    qcSetLog(KeepLine, NULL);
    uint8_t rgba[4] = {0};
    for (int i = 0; i < 3000 && !atomic_load(&s_hasLine); i++)
    {
        ck_assert_int_eq(qcDevice_Run(device, qcClearAndRead, rgba, "a test"), qc_statusDeviceLost);
        const struct timespec pause = {0, 10000000};
        nanosleep(&pause, NULL);
    }
    qcDevice_Destroy(device);
    qcSetLog(NULL, NULL);
    ck_assert_str_eq(s_line, "device egl: not opened again: in place of Shim 1 there is Shim 2");
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

int main(void)
{
    TCase* testCase = qcMakeCase("gl_libraries");
    // Each in a process of its own: a library is opened once.
    tcase_add_loop_test(testCase, a_library_that_refuses_is_named_with_its_reason, 0,
                        sizeof s_refusals / sizeof s_refusals[0]);
    tcase_add_loop_test(testCase, a_library_that_needs_a_configuration_or_an_older_version_draws, 0,
                        sizeof s_detours / sizeof s_detours[0]);
    tcase_add_loop_test(testCase, a_library_that_is_missing_or_lacks_a_function_is_named, 0,
                        sizeof s_libraries / sizeof s_libraries[0]);
    tcase_add_test(testCase, a_gpu_is_no_software_and_the_first_choice_of_auto);
    tcase_add_test(testCase, a_gpu_finds_the_pairs_of_the_cpu);
    tcase_add_test(testCase, a_lost_gpu_is_not_replaced_by_another);
    return qcRunCase("gl_libraries", testCase);
}
