// A libOSMesa in front of the system's, as egl_shim.c is one of libEGL.
#include "gl/gl_shim.h"

SHIM void* OSMesaCreateContextAttribs(const int* attributes, void* share)
{
    // The third pair is the major version.
    if (Is("no context") || (Is("GL 3.3") && attributes[5] > 3))
        return NULL;
    return ((void* (*)(const int*, void*))Real(QC_OSMESA_LIBRARY, "OSMesaCreateContextAttribs"))(attributes, share);
}

SHIM unsigned char OSMesaMakeCurrent(void* context, void* buffer, unsigned type, int width, int height)
{
    if (Is("not current"))
        return 0;
    return ((unsigned char (*)(void*, void*, unsigned, int, int))Real(QC_OSMESA_LIBRARY, "OSMesaMakeCurrent"))(
        context, buffer, type, width, height);
}

SHIM void OSMesaDestroyContext(void* context)
{
    ((void (*)(void*))Real(QC_OSMESA_LIBRARY, "OSMesaDestroyContext"))(context);
}

SHIM void (*OSMesaGetProcAddress(const char* name))(void)
{
    return ((void (*(*)(const char*))(void))Real(QC_OSMESA_LIBRARY, "OSMesaGetProcAddress"))(name);
}
