// A libEGL in front of the system's, to which it forwards. QC_GL_SHIM, read at each call, names what it does otherwise:
// see test_gl_libraries.c. A program that has opened it gets it for "libEGL.so.1", its name in the dynamic linker.
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <dlfcn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Macros of epoxy.
#undef eglBindAPI
#undef eglChooseConfig
#undef eglCreateContext
#undef eglDestroyContext
#undef eglGetError
#undef eglGetProcAddress
#undef eglInitialize
#undef eglMakeCurrent
#undef eglQueryString
#undef eglReleaseThread

#define SHIM __attribute__((visibility("default")))

static bool Is(const char* behaviour)
{
    const char* set = getenv("QC_GL_SHIM");
    return set != NULL && strcmp(set, behaviour) == 0;
}

static void* Real(const char* name)
{
    static void* library;
    if (library == NULL)
        library = dlopen(QC_EGL_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    return library != NULL ? dlsym(library, name) : NULL;
}

/// The words without one of them.
static const char* Without(const char* words, const char* word)
{
    static char kept[4096];
    snprintf(kept, sizeof kept, "%s", words);
    char* found = strstr(kept, word);
    if (found != NULL)
        memset(found, '-', strlen(word));
    return kept;
}

//  ---- functions that libEGL exports -------------------------------------------------------------------------------

SHIM EGLBoolean eglBindAPI(EGLenum api)
{
    return Is("no desktop GL") ? EGL_FALSE : ((PFNEGLBINDAPIPROC)Real("eglBindAPI"))(api);
}

SHIM EGLBoolean eglChooseConfig(EGLDisplay display, const EGLint* attributes, EGLConfig* configs, EGLint size,
                                EGLint* count)
{
    *count = 0;
    if (Is("no configuration"))
        return EGL_TRUE;
    return ((PFNEGLCHOOSECONFIGPROC)Real("eglChooseConfig"))(display, attributes, configs, size, count);
}

SHIM EGLContext eglCreateContext(EGLDisplay display, EGLConfig config, EGLContext share, const EGLint* attributes)
{
    if (Is("no context") || (Is("GL 3.3") && attributes[1] > 3))
        return EGL_NO_CONTEXT;
    return ((PFNEGLCREATECONTEXTPROC)Real("eglCreateContext"))(display, config, share, attributes);
}

SHIM EGLBoolean eglDestroyContext(EGLDisplay display, EGLContext context)
{
    return ((PFNEGLDESTROYCONTEXTPROC)Real("eglDestroyContext"))(display, context);
}

SHIM EGLint eglGetError(void)
{
    return ((PFNEGLGETERRORPROC)Real("eglGetError"))();
}

SHIM EGLBoolean eglInitialize(EGLDisplay display, EGLint* major, EGLint* minor)
{
    return Is("not initialised") ? EGL_FALSE : ((PFNEGLINITIALIZEPROC)Real("eglInitialize"))(display, major, minor);
}

SHIM EGLBoolean eglMakeCurrent(EGLDisplay display, EGLSurface draw, EGLSurface read, EGLContext context)
{
    if (Is("not current") && context != EGL_NO_CONTEXT)
        return EGL_FALSE;
    return ((PFNEGLMAKECURRENTPROC)Real("eglMakeCurrent"))(display, draw, read, context);
}

SHIM const char* eglQueryString(EGLDisplay display, EGLint name)
{
    const char* words = ((PFNEGLQUERYSTRINGPROC)Real("eglQueryString"))(display, name);
    if (name != EGL_EXTENSIONS || words == NULL)
        return words;
    if (display == EGL_NO_DISPLAY)
        return Is("no platforms")     ? Without(words, "EGL_EXT_platform_base")
               : Is("no devices")     ? Without(words, "EGL_EXT_platform_device")
               : Is("no surfaceless") ? Without(words, "EGL_MESA_platform_surfaceless")
                                      : words;
    return Is("no surfaceless contexts")                    ? Without(words, "EGL_KHR_surfaceless_context")
           : Is("no configuration") || Is("configurations") ? Without(words, "EGL_KHR_no_config_context")
                                                            : words;
}

SHIM EGLBoolean eglReleaseThread(void)
{
    return ((PFNEGLRELEASETHREADPROC)Real("eglReleaseThread"))();
}

//  ---- functions by name -------------------------------------------------------------------------------------------

static void* RealByName(const char* name)
{
    // Objects and functions have one size here, as dlsym() presumes.
    void (*function)(void) = ((PFNEGLGETPROCADDRESSPROC)Real("eglGetProcAddress"))(name);
    void* pointer;
    memcpy(&pointer, &function, sizeof pointer);
    return pointer;
}

static EGLDisplay EGLAPIENTRY GetPlatformDisplay(EGLenum platform, void* device, const EGLint* attributes)
{
    if (Is("no display"))
        return EGL_NO_DISPLAY;
    return ((PFNEGLGETPLATFORMDISPLAYEXTPROC)RealByName("eglGetPlatformDisplayEXT"))(platform, device, attributes);
}

static EGLBoolean EGLAPIENTRY QueryDevices(EGLint size, EGLDeviceEXT* devices, EGLint* count)
{
    *count = 0;
    if (Is("no GPU"))
        return EGL_TRUE;
    return ((PFNEGLQUERYDEVICESEXTPROC)RealByName("eglQueryDevicesEXT"))(size, devices, count);
}

static const char* EGLAPIENTRY QueryDeviceString(EGLDeviceEXT device, EGLint name)
{
    const char* words = ((PFNEGLQUERYDEVICESTRINGEXTPROC)RealByName("eglQueryDeviceStringEXT"))(device, name);
    bool isHardware = Is("a GPU") || Is("another GPU") || Is("software behind a GPU");
    return isHardware && words != NULL ? Without(words, "EGL_MESA_device_software") : words;
}

static const GLubyte* APIENTRY GetString(GLenum name)
{
    if (Is("no renderer"))
        return NULL;
    if (name == GL_RENDERER && (Is("a GPU") || Is("another GPU")))
        return (const GLubyte*)(Is("a GPU") ? "Shim 1" : "Shim 2");
    return ((PFNGLGETSTRINGPROC)RealByName("glGetString"))(name);
}

SHIM void (*eglGetProcAddress(const char* name))(void)
{
    if (strcmp(name, "eglGetPlatformDisplayEXT") == 0)
        return (void (*)(void))GetPlatformDisplay;
    if (strcmp(name, "eglQueryDevicesEXT") == 0)
        return (void (*)(void))QueryDevices;
    if (strcmp(name, "eglQueryDeviceStringEXT") == 0)
        return (void (*)(void))QueryDeviceString;
    if (strcmp(name, "glGetString") == 0)
        return (void (*)(void))GetString;
    if (strcmp(name, "glDrawArrays") == 0 && Is("a function less"))
        return NULL;
    return ((PFNEGLGETPROCADDRESSPROC)Real("eglGetProcAddress"))(name);
}
