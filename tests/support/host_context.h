// A GL context of the host's, for tests that share it with the library: EGL or OSMesa, opened like an application does.
#ifndef QC_TESTS_SUPPORT_HOST_CONTEXT_H
#define QC_TESTS_SUPPORT_HOST_CONTEXT_H

#include "support/devices.h"

#include <dlfcn.h>

typedef void qcHostFunction(void);

typedef struct qcHost
{
    qcDeviceKind kind;
    void *display, *context; ///< display: null for OSMesa
    qcHostFunction* (*getFunction)(const char* name);
    unsigned (*makeCurrent)(void* display, void* draw, void* read, void* context);
    void* (*getCurrent)(void);
    unsigned (*destroy)(void* display, void* context);
    unsigned char image[4 * 4 * 4];
} qcHost;

#define QC_HOST_FIND(library, target, name) *(void**)(void*)&(target) = dlsym(library, name)

static inline bool qcHost_OpenOsmesa(qcHost* host)
{
    static const int attributes[] = {0x22, 0x1908, 0x33, 0x34, 0x36, 4, 0x37, 5, 0}; // RGBA, core, 4.5
    unsigned char (*makeCurrent)(void*, void*, unsigned, int, int);
    void* (*create)(const int*, void*);
    void* library = dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
    if (library == NULL || qcIsZinkProcess())
        return false;
    QC_HOST_FIND(library, create, "OSMesaCreateContextAttribs");
    QC_HOST_FIND(library, makeCurrent, "OSMesaMakeCurrent");
    QC_HOST_FIND(library, host->getFunction, "OSMesaGetProcAddress");
    QC_HOST_FIND(library, host->getCurrent, "OSMesaGetCurrentContext");
    host->context = create(attributes, NULL);
    return host->context != NULL && makeCurrent(host->context, host->image, 0x1401, 4, 4);
}

/// `platform`: EGL_PLATFORM_SURFACELESS_MESA or EGL_PLATFORM_DEVICE_EXT, for the latter the first device.
static inline bool qcHost_OpenEgl(qcHost* host, unsigned platform)
{
    static const int attributes[] = {0x3098, 4, 0x30FB, 5, 0x3038};
    unsigned (*initialize)(void*, int*, int*), (*bindApi)(unsigned);
    void* (*create)(void*, void*, void*, const int*);
    void* library = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == NULL)
        return false;
    QC_HOST_FIND(library, initialize, "eglInitialize");
    QC_HOST_FIND(library, bindApi, "eglBindAPI");
    QC_HOST_FIND(library, create, "eglCreateContext");
    QC_HOST_FIND(library, host->makeCurrent, "eglMakeCurrent");
    QC_HOST_FIND(library, host->getCurrent, "eglGetCurrentContext");
    QC_HOST_FIND(library, host->destroy, "eglDestroyContext");
    QC_HOST_FIND(library, host->getFunction, "eglGetProcAddress");
    void* (*getDisplay)(unsigned, void*, const int*) =
        (void* (*)(unsigned, void*, const int*))host->getFunction("eglGetPlatformDisplayEXT");
    unsigned (*queryDevices)(int, void**, int*) =
        (unsigned (*)(int, void**, int*))host->getFunction("eglQueryDevicesEXT");
    void* device = NULL;
    int count = 0;
    if (platform == 0x313F && (queryDevices == NULL || !queryDevices(1, &device, &count) || count == 0))
        return false;
    host->display = getDisplay != NULL ? getDisplay(platform, device, NULL) : NULL;
    if (host->display == NULL || !initialize(host->display, NULL, NULL) || !bindApi(0x30A2))
        return false;
    host->context = create(host->display, NULL, NULL, attributes);
    return host->context != NULL && host->makeCurrent(host->display, NULL, NULL, host->context);
}

/// A context that is current on this thread. False, after a line of output, if this kind does not work here.
static inline bool qcHost_Open(qcHost* host, qcDeviceKind kind)
{
    *host = (qcHost){.kind = kind};
    bool opened = !(qcIsZinkProcess() && kind == qc_deviceEgl) &&
                  (kind == qc_deviceOsmesa ? qcHost_OpenOsmesa(host)
                                           : qcHost_OpenEgl(host, kind == qc_deviceEgl ? 0x313F : 0x31DD));
    if (!opened)
        printf("skipped: the host opens no context of kind %d\n", (int)kind);
    return opened;
}

static inline void qcHost_Close(qcHost* host)
{
    void (*release)(void*);
    if (host->display != NULL)
    {
        host->makeCurrent(host->display, NULL, NULL, NULL);
        host->destroy(host->display, host->context);
        return;
    }
    QC_HOST_FIND(dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL), release, "OSMesaDestroyContext");
    release(host->context);
}

/// A device that shares the host's context.
static inline qcStatus qcHost_ShareDevice(const qcHost* host, qcDevice** device)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.shareContext = host->context;
    def.shareDisplay = host->display;
    return qcDevice_Create(&def, device);
}

/// Iterates over the kinds of hosts, each with a device that shares its context.
typedef struct qcHostWalk
{
    int next;
    bool opened[qc_testDeviceCount + 1];
    qcHost host;
    qcDevice* device;
} qcHostWalk;

static inline bool qcHostWalk_Next(qcHostWalk* walk)
{
    if (walk->device != NULL)
    {
        qcDevice_Destroy(walk->device);
        qcHost_Close(&walk->host);
    }
    walk->device = NULL;
    for (; walk->device == NULL && walk->next < qc_testDeviceCount; walk->next++)
    {
        if (!qcHost_Open(&walk->host, qc_testKinds[walk->next]))
            continue;
        ck_assert_msg(qcHost_ShareDevice(&walk->host, &walk->device) == qc_statusOk, "%s", qcLastMessage());
        // The host's first EGL device may draw in software: no hardware GPU then.
        qcDeviceInfo info;
        qcDevice_GetInfo(walk->device, &info);
        walk->opened[qcGetTestName(walk->next)] = qc_testKinds[walk->next] != qc_deviceEgl || !info.software;
    }
    if (walk->device == NULL)
        qcReportDevices(walk->opened);
    return walk->device != NULL;
}

#define QC_FOR_EACH_HOST(walk) for (qcHostWalk walk = {.next = 0}; qcHostWalk_Next(&walk);)

#endif
