// OSMesa contexts: software GL in memory, on any machine. The library is opened at run time, since Mesa 25.1 dropped
// it. The interface of osmesa.h is restated here: that header conflicts with epoxy's over GLAPI.
#define _POSIX_C_SOURCE 200809L
#include "gl/context.h"

#include "base/status.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_osmesaFormat = 0x22,
    qc_osmesaProfile = 0x33,
    qc_osmesaCoreProfile = 0x34,
    qc_osmesaMajorVersion = 0x36,
    qc_osmesaMinorVersion = 0x37,

    // An odd size: Mesa before 22 shares one image among contexts of equal format and size, the host's included.
    qc_imageWidth = 5,
    qc_imageHeight = 3
};

static struct
{
    void* (*CreateContextAttribs)(const int* attributes, void* share);
    GLboolean (*MakeCurrent)(void* context, void* buffer, GLenum type, GLsizei width, GLsizei height);
    void (*DestroyContext)(void* context);
    qcGlGetFunction* GetProcAddress;
    char error[256]; ///< why the library can't be used; empty when it can
} s_osmesa;

static pthread_once_t s_once = PTHREAD_ONCE_INIT;

// Mesa before 22 keeps a list of images without a lock.
static pthread_mutex_t s_mutex = PTHREAD_MUTEX_INITIALIZER;

// Never drawn to: jobs draw to framebuffers of their own. Static, since Mesa before 22 uses the address after the
// context is destroyed.
static uint8_t s_image[qc_imageWidth * qc_imageHeight * 4];

static void LoadLibrary(void)
{
    static const char* const names[] = {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"};
    // RTLD_LOCAL: its gl* symbols must not shadow those of a host's own GL. Never closed: Mesa has exit handlers and
    // thread-local data that need its code.
    void* library = NULL;
    for (size_t i = 0; library == NULL && i < sizeof names / sizeof names[0]; ++i)
        library = dlopen(names[i], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL)
    {
        const char* reason = dlerror();
        snprintf(s_osmesa.error, sizeof s_osmesa.error, "no libOSMesa: %s", reason != NULL ? reason : "not found");
        return;
    }
    s_osmesa.CreateContextAttribs = (void* (*)(const int*, void*))dlsym(library, "OSMesaCreateContextAttribs");
    s_osmesa.MakeCurrent = (GLboolean(*)(void*, void*, GLenum, GLsizei, GLsizei))dlsym(library, "OSMesaMakeCurrent");
    s_osmesa.DestroyContext = (void (*)(void*))dlsym(library, "OSMesaDestroyContext");
    s_osmesa.GetProcAddress = (qcGlGetFunction*)dlsym(library, "OSMesaGetProcAddress");
    if (s_osmesa.CreateContextAttribs == NULL || s_osmesa.MakeCurrent == NULL || s_osmesa.DestroyContext == NULL ||
        s_osmesa.GetProcAddress == NULL)
        snprintf(s_osmesa.error, sizeof s_osmesa.error, "libOSMesa lacks OSMesaCreateContextAttribs (Mesa 11.2)");
}

static void* CreateContext(int major, int minor, void* share)
{
    const int attributes[] = {qc_osmesaFormat,
                              GL_RGBA,
                              qc_osmesaProfile,
                              qc_osmesaCoreProfile,
                              qc_osmesaMajorVersion,
                              major,
                              qc_osmesaMinorVersion,
                              minor,
                              0};
    return s_osmesa.CreateContextAttribs(attributes, share);
}

/// libOSMesa crashes if GALLIUM_DRIVER names a driver that it lacks, and with zink (Mesa 22.3).
static qcStatus CheckDriver(void)
{
    const char* driver = getenv("GALLIUM_DRIVER");
    if (driver == NULL || driver[0] == 0 || strcmp(driver, "llvmpipe") == 0 || strcmp(driver, "softpipe") == 0)
        return qc_statusOk;
    return qcFail(qc_statusDevice, "libOSMesa crashes with GALLIUM_DRIVER=%s", driver);
}

qcStatus qcOpenOsmesaContext(const qcGpuChoice* choice, qcContext* context)
{
    QC_TRY(CheckDriver());
    pthread_once(&s_once, LoadLibrary);
    if (s_osmesa.error[0] != 0)
        return qcFail(qc_statusDevice, "%s", s_osmesa.error);

    pthread_mutex_lock(&s_mutex);
    void* handle = CreateContext(4, 5, choice->shareContext);
    if (handle == NULL)
        handle = CreateContext(3, 3, choice->shareContext);
    GLboolean current = GL_FALSE;
    if (handle != NULL)
    {
        current = s_osmesa.MakeCurrent(handle, s_image, GL_UNSIGNED_BYTE, qc_imageWidth, qc_imageHeight);
        if (current == GL_FALSE)
            s_osmesa.DestroyContext(handle);
    }
    pthread_mutex_unlock(&s_mutex);

    if (handle == NULL)
        return qcFail(qc_statusDevice, "OSMesa gives no context of GL 3.3 core");
    if (current == GL_FALSE)
        return qcFail(qc_statusDevice, "OSMesaMakeCurrent failed");
    *context = (qcContext){.getFunction = s_osmesa.GetProcAddress, .handle = handle};
    return qc_statusOk;
}

void qcCloseOsmesaContext(qcContext* context)
{
    pthread_mutex_lock(&s_mutex);
    s_osmesa.MakeCurrent(NULL, NULL, 0, 0, 0);
    s_osmesa.DestroyContext(context->handle);
    pthread_mutex_unlock(&s_mutex);
}
