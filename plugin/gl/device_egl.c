// EGL contexts without a window system: one of the GPUs (EXT_platform_device) or MESA_platform_surfaceless.
// libEGL is opened at run time, so that the library runs where it is missing.
#define _POSIX_C_SOURCE 200809L
#include "gl/context.h"

#include "base/status.h"

#include <epoxy/egl.h>

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

/// Functions that libEGL exports.
#define QC_EGL_FUNCTIONS(X)                                                                                            \
    X(PFNEGLBINDAPIPROC, BindAPI)                                                                                      \
    X(PFNEGLCHOOSECONFIGPROC, ChooseConfig)                                                                            \
    X(PFNEGLCREATECONTEXTPROC, CreateContext)                                                                          \
    X(PFNEGLDESTROYCONTEXTPROC, DestroyContext)                                                                        \
    X(PFNEGLGETERRORPROC, GetError)                                                                                    \
    X(PFNEGLGETPROCADDRESSPROC, GetProcAddress)                                                                        \
    X(PFNEGLINITIALIZEPROC, Initialize)                                                                                \
    X(PFNEGLMAKECURRENTPROC, MakeCurrent)                                                                              \
    X(PFNEGLQUERYSTRINGPROC, QueryString)                                                                              \
    X(PFNEGLRELEASETHREADPROC, ReleaseThread)

static struct
{
#define QC_EGL_FIELD(Type, Name) Type Name;
    QC_EGL_FUNCTIONS(QC_EGL_FIELD)
#undef QC_EGL_FIELD
    PFNEGLGETPLATFORMDISPLAYEXTPROC GetPlatformDisplayEXT;
    PFNEGLQUERYDEVICESEXTPROC QueryDevicesEXT;
    PFNEGLQUERYDEVICESTRINGEXTPROC QueryDeviceStringEXT;
    const char* extensions; ///< client extensions
    char error[256];        ///< why the library can't be used; empty when it can
} s_egl;

static pthread_once_t s_once = PTHREAD_ONCE_INIT;

static bool HasWord(const char* words, const char* word)
{
    size_t length = strlen(word);
    for (const char* found = words; found != NULL && (found = strstr(found, word)) != NULL; found += length)
    {
        bool begins = found == words || found[-1] == ' ';
        bool ends = found[length] == ' ' || found[length] == 0;
        if (begins && ends)
            return true;
    }
    return false;
}

static void LoadLibrary(void)
{
    // RTLD_LOCAL: its symbols must not shadow those of a host's own EGL. Never closed: drivers have exit handlers and
    // thread-local data that need its code.
    void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == NULL)
    {
        const char* reason = dlerror();
        snprintf(s_egl.error, sizeof s_egl.error, "no libEGL: %s", reason != NULL ? reason : "not found");
        return;
    }
#define QC_EGL_LOAD(Type, Name)                                                                                        \
    s_egl.Name = (Type)dlsym(library, "egl" #Name);                                                                    \
    if (s_egl.Name == NULL)                                                                                            \
    {                                                                                                                  \
        snprintf(s_egl.error, sizeof s_egl.error, "libEGL lacks egl" #Name);                                           \
        return;                                                                                                        \
    }
    QC_EGL_FUNCTIONS(QC_EGL_LOAD)
#undef QC_EGL_LOAD

    s_egl.extensions = s_egl.QueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!HasWord(s_egl.extensions, "EGL_EXT_platform_base"))
    {
        snprintf(s_egl.error, sizeof s_egl.error, "libEGL lacks EGL_EXT_platform_base");
        return;
    }
    s_egl.GetPlatformDisplayEXT = (PFNEGLGETPLATFORMDISPLAYEXTPROC)s_egl.GetProcAddress("eglGetPlatformDisplayEXT");
    s_egl.QueryDevicesEXT = (PFNEGLQUERYDEVICESEXTPROC)s_egl.GetProcAddress("eglQueryDevicesEXT");
    s_egl.QueryDeviceStringEXT = (PFNEGLQUERYDEVICESTRINGEXTPROC)s_egl.GetProcAddress("eglQueryDeviceStringEXT");
}

static EGLContext CreateContext(EGLDisplay display, EGLConfig config, EGLContext share)
{
    static const struct
    {
        EGLint major, minor;
        bool reportsLoss;
    } versions[] = {{4, 5, true}, {4, 5, false}, {3, 3, true}, {3, 3, false}};
    for (size_t i = 0; i < sizeof versions / sizeof versions[0]; ++i)
    {
        // A context that doesn't report its loss returns garbage afterwards: a query that reads zero means "visible",
        // and a collision would be missed silently.
        const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION_KHR,
                                     versions[i].major,
                                     EGL_CONTEXT_MINOR_VERSION_KHR,
                                     versions[i].minor,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
                                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
                                     versions[i].reportsLoss ? EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY_KHR
                                                             : EGL_NONE,
                                     EGL_LOSE_CONTEXT_ON_RESET_KHR,
                                     EGL_NONE};
        EGLContext handle = s_egl.CreateContext(display, config, share, attributes);
        if (handle != EGL_NO_CONTEXT)
            return handle;
    }
    return EGL_NO_CONTEXT;
}

// The display stays initialised, on failure and after the last context: a process has one display per platform and
// native device, the host may use the same one, and eglTerminate would end the host's contexts too.
static qcStatus OpenOnDisplay(EGLDisplay display, EGLContext share, qcContext* context)
{
    if (display == EGL_NO_DISPLAY)
        return qcFail(qc_statusDevice, "no EGL display (error 0x%x)", (unsigned)s_egl.GetError());
    if (!s_egl.Initialize(display, NULL, NULL))
        return qcFail(qc_statusDevice, "eglInitialize failed (error 0x%x)", (unsigned)s_egl.GetError());
    const char* extensions = s_egl.QueryString(display, EGL_EXTENSIONS);
    if (!HasWord(extensions, "EGL_KHR_surfaceless_context") || !HasWord(extensions, "EGL_KHR_create_context"))
        return qcFail(qc_statusDevice, "the EGL display lacks EGL_KHR_surfaceless_context or EGL_KHR_create_context");
    if (!s_egl.BindAPI(EGL_OPENGL_API))
        return qcFail(qc_statusDevice, "EGL has no desktop GL (error 0x%x)", (unsigned)s_egl.GetError());

    EGLConfig config = NULL;
    if (!HasWord(extensions, "EGL_KHR_no_config_context"))
    {
        // Pbuffers: the default requires windows, which these platforms don't have.
        const EGLint attributes[] = {EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_NONE};
        EGLint count = 0;
        if (!s_egl.ChooseConfig(display, attributes, &config, 1, &count) || count == 0)
            return qcFail(qc_statusDevice, "EGL has no configuration for desktop GL");
    }
    EGLContext handle = CreateContext(display, config, share);
    if (handle == EGL_NO_CONTEXT && share != EGL_NO_CONTEXT)
        return qcFail(qc_statusDevice,
                      "EGL gives no context of GL 3.3 core that shares objects with def->shareContext (error 0x%x): it "
                      "must be a context of desktop GL on def->shareDisplay",
                      (unsigned)s_egl.GetError());
    if (handle == EGL_NO_CONTEXT)
        return qcFail(qc_statusDevice, "EGL gives no context of GL 3.3 core (error 0x%x)", (unsigned)s_egl.GetError());
    if (!s_egl.MakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, handle))
    {
        EGLint error = s_egl.GetError();
        s_egl.DestroyContext(display, handle);
        return qcFail(qc_statusDevice, "eglMakeCurrent failed (error 0x%x)", (unsigned)error);
    }
    *context = (qcContext){.getFunction = s_egl.GetProcAddress, .display = display, .handle = handle};
    return qc_statusOk;
}

static bool IsGiven(const qcGpuChoice* choice)
{
    return choice->index >= 0 || choice->name[0] != 0 || choice->hasUuid;
}

static qcStatus CheckChoice(const qcGpuChoice* choice, const qcGpuIdentity* gpu)
{
    if (gpu->software && !IsGiven(choice))
        return qcFail(qc_statusDevice, "draws in software (%s)", gpu->renderer);
    if (strstr(gpu->renderer, choice->name) == NULL)
        return qcFail(qc_statusDevice, "has another name (%s)", gpu->renderer);
    if (choice->hasUuid && memcmp(gpu->uuid, choice->uuid, sizeof gpu->uuid) != 0)
        return qcFail(qc_statusDevice, "has another UUID or none (%s)", gpu->renderer);
    return qc_statusOk;
}

static qcStatus OpenOnDevice(EGLDeviceEXT device, const qcGpuChoice* choice, qcContext* context)
{
    if (!IsGiven(choice) && HasWord(s_egl.QueryDeviceStringEXT(device, EGL_EXTENSIONS), "EGL_MESA_device_software"))
        return qcFail(qc_statusDevice, "draws in software");
    QC_TRY(OpenOnDisplay(s_egl.GetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT, device, NULL), EGL_NO_CONTEXT, context));

    // A driver may fall back to software behind a hardware device.
    qcGpuIdentity gpu;
    qcStatus status = qcContext_Identify(context, &gpu);
    if (status == qc_statusOk)
        status = CheckChoice(choice, &gpu);
    if (status != qc_statusOk)
        qcCloseEglContext(context);
    return status;
}

/// Appends this thread's last message as a reason, truncated to the space left.
static void AddReason(char* reasons, size_t size, int index)
{
    size_t length = strlen(reasons);
    snprintf(reasons + length, size - length, "%sGPU %d %s", length > 0 ? "; " : "", index, qcLastMessage());
}

static qcStatus OpenOnAny(const EGLDeviceEXT* devices, int count, const qcGpuChoice* choice, qcContext* context)
{
    if (choice->index >= count)
        return qcFail(qc_statusDevice, "GPU %d is not among the %d that EGL lists", choice->index, count);
    char reasons[400] = "";
    for (int i = 0; i < count; ++i)
    {
        if (choice->index >= 0 && i != choice->index)
            continue;
        if (OpenOnDevice(devices[i], choice, context) == qc_statusOk)
            return qc_statusOk;
        AddReason(reasons, sizeof reasons, i);
    }
    return qcFail(qc_statusDevice, "none of the %d GPUs that EGL lists is usable: %s", count, reasons);
}

qcStatus qcOpenEglContext(const qcGpuChoice* choice, qcContext* context)
{
    pthread_once(&s_once, LoadLibrary);
    if (s_egl.error[0] != 0)
        return qcFail(qc_statusDevice, "%s", s_egl.error);
    if (choice->shareContext != NULL)
        return OpenOnDisplay(choice->shareDisplay, choice->shareContext, context);
    bool listsDevices =
        HasWord(s_egl.extensions, "EGL_EXT_device_base") ||
        (HasWord(s_egl.extensions, "EGL_EXT_device_enumeration") && HasWord(s_egl.extensions, "EGL_EXT_device_query"));
    if (!listsDevices || !HasWord(s_egl.extensions, "EGL_EXT_platform_device"))
        return qcFail(qc_statusDevice, "libEGL lacks EGL_EXT_device_base or EGL_EXT_platform_device");

    enum
    {
        maxDevices = 64
    };
    EGLDeviceEXT devices[maxDevices];
    EGLint count = 0;
    if (!s_egl.QueryDevicesEXT(maxDevices, devices, &count) || count == 0)
        return qcFail(qc_statusDevice, "EGL lists no GPU");
    return OpenOnAny(devices, count, choice, context);
}

qcStatus qcOpenSurfacelessContext(const qcGpuChoice* choice, qcContext* context)
{
    pthread_once(&s_once, LoadLibrary);
    if (s_egl.error[0] != 0)
        return qcFail(qc_statusDevice, "%s", s_egl.error);
    if (choice->shareContext != NULL)
        return OpenOnDisplay(choice->shareDisplay, choice->shareContext, context);
    if (!HasWord(s_egl.extensions, "EGL_MESA_platform_surfaceless"))
        return qcFail(qc_statusDevice, "libEGL lacks EGL_MESA_platform_surfaceless");
    return OpenOnDisplay(s_egl.GetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL),
                         EGL_NO_CONTEXT, context);
}

void qcCloseEglContext(qcContext* context)
{
    s_egl.MakeCurrent(context->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    s_egl.DestroyContext(context->display, context->handle);
    s_egl.ReleaseThread();
}
