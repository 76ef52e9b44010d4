// A libOSMesa in front of the system's, as egl_shim.c is one of libEGL.
#include <dlfcn.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

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
        library = dlopen(QC_OSMESA_LIBRARY, RTLD_NOW | RTLD_LOCAL);
    return library != NULL ? dlsym(library, name) : NULL;
}

SHIM void* OSMesaCreateContextAttribs(const int* attributes, void* share)
{
    // The third pair is the major version.
    if (Is("no context") || (Is("GL 3.3") && attributes[5] > 3))
        return NULL;
    return ((void* (*)(const int*, void*))Real("OSMesaCreateContextAttribs"))(attributes, share);
}

SHIM unsigned char OSMesaMakeCurrent(void* context, void* buffer, unsigned type, int width, int height)
{
    if (Is("not current"))
        return 0;
    return ((unsigned char (*)(void*, void*, unsigned, int, int))Real("OSMesaMakeCurrent"))(context, buffer, type,
                                                                                            width, height);
}

SHIM void OSMesaDestroyContext(void* context)
{
    ((void (*)(void*))Real("OSMesaDestroyContext"))(context);
}

SHIM void (*OSMesaGetProcAddress(const char* name))(void)
{
    return ((void (*(*)(const char*))(void))Real("OSMesaGetProcAddress"))(name);
}
