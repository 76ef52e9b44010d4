// A libEGL in front of the system's, to which it forwards. QC_GL_SHIM, read at each call, names what it does otherwise:
// see test_gl_libraries.c. A program that has opened it gets it for "libEGL.so.1", its name in the dynamic linker.
#include "gl/gl_shim.h"

#include <stdio.h>

// The part of EGL that is needed, restated: headers of GL belong to plugin/gl.
typedef unsigned Boolean;
typedef void* Handle; ///< of a display, configuration, context, surface or device
typedef void Function(void);

enum
{
    egl_extensions = 0x3055,
    gl_renderer = 0x1f01
};

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

SHIM Boolean eglBindAPI(unsigned api)
{
    return Is("no desktop GL") ? 0 : ((Boolean(*)(unsigned))Real(QC_EGL_LIBRARY, "eglBindAPI"))(api);
}

SHIM Boolean eglChooseConfig(Handle display, const int* attributes, Handle* configs, int size, int* count)
{
    *count = 0;
    if (Is("no configuration"))
        return 1;
    return ((Boolean(*)(Handle, const int*, Handle*, int, int*))Real(QC_EGL_LIBRARY, "eglChooseConfig"))(
        display, attributes, configs, size, count);
}

SHIM Handle eglCreateContext(Handle display, Handle config, Handle share, const int* attributes)
{
    if (Is("no context") || (Is("GL 3.3") && attributes[1] > 3))
        return NULL;
    return ((Handle(*)(Handle, Handle, Handle, const int*))Real(QC_EGL_LIBRARY, "eglCreateContext"))(display, config,
                                                                                                     share, attributes);
}

SHIM Boolean eglDestroyContext(Handle display, Handle context)
{
    return ((Boolean(*)(Handle, Handle))Real(QC_EGL_LIBRARY, "eglDestroyContext"))(display, context);
}

SHIM int eglGetError(void)
{
    return ((int (*)(void))Real(QC_EGL_LIBRARY, "eglGetError"))();
}

SHIM Boolean eglInitialize(Handle display, int* major, int* minor)
{
    return Is("not initialised")
               ? 0
               : ((Boolean(*)(Handle, int*, int*))Real(QC_EGL_LIBRARY, "eglInitialize"))(display, major, minor);
}

SHIM Boolean eglMakeCurrent(Handle display, Handle draw, Handle read, Handle context)
{
    if (Is("not current") && context != NULL)
        return 0;
    return ((Boolean(*)(Handle, Handle, Handle, Handle))Real(QC_EGL_LIBRARY, "eglMakeCurrent"))(display, draw, read,
                                                                                                context);
}

SHIM const char* eglQueryString(Handle display, int name)
{
    const char* words = ((const char* (*)(Handle, int))Real(QC_EGL_LIBRARY, "eglQueryString"))(display, name);
    if (name != egl_extensions || words == NULL)
        return words;
    if (display == NULL)
        return Is("no platforms")     ? Without(words, "EGL_EXT_platform_base")
               : Is("no devices")     ? Without(words, "EGL_EXT_platform_device")
               : Is("no surfaceless") ? Without(words, "EGL_MESA_platform_surfaceless")
                                      : words;
    return Is("no surfaceless contexts")                    ? Without(words, "EGL_KHR_surfaceless_context")
           : Is("no configuration") || Is("configurations") ? Without(words, "EGL_KHR_no_config_context")
                                                            : words;
}

SHIM Boolean eglReleaseThread(void)
{
    return ((Boolean(*)(void))Real(QC_EGL_LIBRARY, "eglReleaseThread"))();
}

//  ---- functions by name -------------------------------------------------------------------------------------------

static void* RealByName(const char* name)
{
    // Objects and functions have one size here, as dlsym() presumes.
    Function* function = ((Function * (*)(const char*)) Real(QC_EGL_LIBRARY, "eglGetProcAddress"))(name);
    void* pointer;
    memcpy(&pointer, &function, sizeof pointer);
    return pointer;
}

static Handle GetPlatformDisplay(unsigned platform, void* device, const int* attributes)
{
    if (Is("no display"))
        return NULL;
    return ((Handle(*)(unsigned, void*, const int*))RealByName("eglGetPlatformDisplayEXT"))(platform, device,
                                                                                            attributes);
}

static Boolean QueryDevices(int size, Handle* devices, int* count)
{
    *count = 0;
    if (Is("no GPU"))
        return 1;
    return ((Boolean(*)(int, Handle*, int*))RealByName("eglQueryDevicesEXT"))(size, devices, count);
}

static const char* QueryDeviceString(Handle device, int name)
{
    const char* words = ((const char* (*)(Handle, int))RealByName("eglQueryDeviceStringEXT"))(device, name);
    bool isHardware = Is("a GPU") || Is("another GPU") || Is("software behind a GPU");
    return isHardware && words != NULL ? Without(words, "EGL_MESA_device_software") : words;
}

static const char* GetString(unsigned name)
{
    if (Is("no renderer"))
        return NULL;
    if (name == gl_renderer && (Is("a GPU") || Is("another GPU")))
        return Is("a GPU") ? "Shim 1" : "Shim 2";
    return ((const char* (*)(unsigned))RealByName("glGetString"))(name);
}

SHIM Function* eglGetProcAddress(const char* name)
{
    if (strcmp(name, "eglGetPlatformDisplayEXT") == 0)
        return (Function*)GetPlatformDisplay;
    if (strcmp(name, "eglQueryDevicesEXT") == 0)
        return (Function*)QueryDevices;
    if (strcmp(name, "eglQueryDeviceStringEXT") == 0)
        return (Function*)QueryDeviceString;
    if (strcmp(name, "glGetString") == 0)
        return (Function*)GetString;
    if (strcmp(name, "glDrawArrays") == 0 && Is("a function less"))
        return NULL;
    return ((Function * (*)(const char*)) Real(QC_EGL_LIBRARY, "eglGetProcAddress"))(name);
}
