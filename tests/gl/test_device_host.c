// The host's own contexts stay current and draw while devices are opened and used beside them.
// These tests open OSMesa and EGL by themselves, like an application.
#include "gl/device_jobs.h"
#include "support/suite.h"

#include <dlfcn.h>
#include <stdio.h>

/// Opens, uses and closes each kind of device, like the library during a step.
static void UseEveryKind(void)
{
    for (int kind = qc_deviceAuto; kind <= qc_deviceNone; ++kind)
    {
        qcDevice* device = NULL;
        if (qcOpenKind((qcDeviceKind)kind, &device) != qc_statusOk)
            continue;
        uint8_t rgba[4] = {10, 20, 30, 0};
        qcStatus status = qcDevice_Run(device, qcClearAndRead, rgba, "a test");
        qcDeviceInfo info;
        qcDevice_GetInfo(device, &info);
        ck_assert_int_eq(status, info.kind == qc_deviceNone ? qc_statusDevice : qc_statusOk);
        qcDevice_Destroy(device);
    }
}

static void* FindFunction(void* library, const char* name)
{
    void* function = dlsym(library, name);
    ck_assert_msg(function != NULL, "%s is missing", name);
    return function;
}

START_TEST(an_osmesa_context_of_the_host_stays_current_and_draws)
{
    if (qcIsZinkProcess())
        return; // libOSMesa would crash
    void* library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
    if (library == NULL)
        library = dlopen("libOSMesa.so.6", RTLD_NOW | RTLD_LOCAL);
    if (library == NULL)
    {
        printf("skipped: no libOSMesa\n");
        return;
    }
    void* (*create)(GLenum, void*) = (void* (*)(GLenum, void*))FindFunction(library, "OSMesaCreateContext");
    GLboolean (*makeCurrent)(void*, void*, GLenum, GLsizei, GLsizei) =
        (GLboolean(*)(void*, void*, GLenum, GLsizei, GLsizei))FindFunction(library, "OSMesaMakeCurrent");
    void* (*getCurrent)(void) = (void* (*)(void))FindFunction(library, "OSMesaGetCurrentContext");
    void (*destroy)(void*) = (void (*)(void*))FindFunction(library, "OSMesaDestroyContext");
    qcGlGetFunction* getFunction = (qcGlGetFunction*)FindFunction(library, "OSMesaGetProcAddress");

    uint8_t image[8 * 8 * 4] = {0};
    void* context = create(GL_RGBA, NULL);
    ck_assert_ptr_nonnull(context);
    ck_assert(makeCurrent(context, image, GL_UNSIGNED_BYTE, 8, 8));
    PFNGLCLEARCOLORPROC clearColor = (PFNGLCLEARCOLORPROC)getFunction("glClearColor");
    PFNGLCLEARPROC clear = (PFNGLCLEARPROC)getFunction("glClear");
    PFNGLFINISHPROC finish = (PFNGLFINISHPROC)getFunction("glFinish");
    PFNGLGETERRORPROC getError = (PFNGLGETERRORPROC)getFunction("glGetError");
    clearColor(1.0f, 0.0f, 0.0f, 1.0f);
    clear(GL_COLOR_BUFFER_BIT);

    UseEveryKind();

    ck_assert_ptr_eq(getCurrent(), context);
    finish();
    ck_assert_uint_eq(image[0], 255);
    ck_assert_uint_eq(image[1], 0);
    clearColor(0.0f, 1.0f, 0.0f, 1.0f);
    clear(GL_COLOR_BUFFER_BIT);
    finish();
    ck_assert_uint_eq(image[0], 0);
    ck_assert_uint_eq(image[1], 255);
    ck_assert_uint_eq(getError(), GL_NO_ERROR);
    makeCurrent(NULL, NULL, 0, 0, 0);
    destroy(context);
}
END_TEST

// The part of EGL that the host uses.
enum
{
    egl_none = 0x3038,
    egl_openglApi = 0x30A2,
    egl_platformSurfaceless = 0x31DD
};

START_TEST(a_surfaceless_egl_context_of_the_host_stays_current_and_draws)
{
    void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == NULL)
    {
        printf("skipped: no libEGL\n");
        return;
    }
    qcGlGetFunction* getFunction = (qcGlGetFunction*)FindFunction(library, "eglGetProcAddress");
    unsigned (*initialize)(void*, int*, int*) = (unsigned (*)(void*, int*, int*))FindFunction(library, "eglInitialize");
    unsigned (*bindApi)(unsigned) = (unsigned (*)(unsigned))FindFunction(library, "eglBindAPI");
    void* (*create)(void*, void*, void*, const int*) =
        (void* (*)(void*, void*, void*, const int*))FindFunction(library, "eglCreateContext");
    unsigned (*makeCurrent)(void*, void*, void*, void*) =
        (unsigned (*)(void*, void*, void*, void*))FindFunction(library, "eglMakeCurrent");
    void* (*getCurrent)(void) = (void* (*)(void))FindFunction(library, "eglGetCurrentContext");
    unsigned (*queryApi)(void) = (unsigned (*)(void))FindFunction(library, "eglQueryAPI");
    unsigned (*destroy)(void*, void*) = (unsigned (*)(void*, void*))FindFunction(library, "eglDestroyContext");
    void* (*getDisplay)(unsigned, void*, const int*) =
        (void* (*)(unsigned, void*, const int*))getFunction("eglGetPlatformDisplayEXT");

    void* display = getDisplay != NULL ? getDisplay(egl_platformSurfaceless, NULL, NULL) : NULL;
    const int attributes[] = {egl_none};
    void* context = NULL;
    if (display != NULL && initialize(display, NULL, NULL) && bindApi(egl_openglApi))
        context = create(display, NULL, NULL, attributes);
    if (context == NULL)
    {
        printf("skipped: no surfaceless EGL\n");
        return;
    }
    ck_assert(makeCurrent(display, NULL, NULL, context));

    UseEveryKind();

    ck_assert_ptr_eq(getCurrent(), context);
    ck_assert_uint_eq(queryApi(), egl_openglApi);
    struct qcGlFunctions gl = {0};
    ck_assert_int_eq(qcGlFunctions_Load(&gl, getFunction), qc_statusOk);
    uint8_t rgba[4] = {200, 100, 50, 0};
    ck_assert_int_eq(qcClearAndRead(&gl, rgba), qc_statusOk);
    ck_assert_uint_eq(rgba[0], 200);
    ck_assert_uint_eq(rgba[1], 100);
    ck_assert_uint_eq(gl.GetError(), GL_NO_ERROR);
    ck_assert(makeCurrent(display, NULL, NULL, NULL));
    destroy(display, context);
}
END_TEST

QC_RUN_TESTS("device, host", an_osmesa_context_of_the_host_stays_current_and_draws,
             a_surfaceless_egl_context_of_the_host_stays_current_and_draws)
