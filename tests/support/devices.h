// The GL devices of this machine, for tests that run on each:
//   egl          a hardware GPU
//   osmesa       software GL in memory
//   surfaceless  Mesa's GL through EGL
//   zink         Mesa's GL over Vulkan, with a compiler and a memory model of its own. Environment variables select it
//                before Mesa is loaded: programs run a second time with these, and zink is then the only device.
// QC_TEST_DEVICES lists, separated by commas, devices that must open: a test fails if one of them doesn't.
#ifndef QC_TESTS_SUPPORT_DEVICES_H
#define QC_TESTS_SUPPORT_DEVICES_H

#include "quickcullide/device.h"
#include "support/long_form.h"
#include "support/suite.h"

#include <check.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_testDeviceCount = 3,
    // Indices of names.
    qc_testOsmesa = 1,
    qc_testSurfaceless = 2,
    qc_testZink = qc_testDeviceCount
};

static const qcDeviceKind qc_testKinds[qc_testDeviceCount] = {qc_deviceEgl, qc_deviceOsmesa, qc_deviceSurfaceless};
static const char* const qc_testDeviceNames[qc_testDeviceCount + 1] = {"egl", "osmesa", "surfaceless", "zink"};

static inline bool qcIsZinkProcess(void)
{
    const char* driver = getenv("MESA_LOADER_DRIVER_OVERRIDE");
    return driver != NULL && strcmp(driver, "zink") == 0;
}

/// Whether QC_LAYERS_REFINE lets devices refine, which software devices leave to the processor by default.
static inline bool qcDevicesRefine(void)
{
    const char* refinement = getenv("QC_LAYERS_REFINE");
    return refinement != NULL && strcmp(refinement, "device") == 0;
}

/// Whether a device has compute shaders.
static inline bool qcHasCompute(qcDevice* device)
{
    qcDeviceInfo info;
    return qcDevice_GetInfo(device, &info) == qc_statusOk && info.compute;
}

/// Whether the processor refines the image of `layers`, which is made for it alone.
static inline bool qcHasImage(qcDevice* device)
{
    qcDeviceInfo info;
    return qcDevice_GetInfo(device, &info) == qc_statusOk && info.software && !qcDevicesRefine();
}

/// Whether a device is left out, after those that have opened: osmesa and surfaceless have the same rasterizer and
/// compiler, and where QC_ONE_RASTERIZER is set the short form uses the first of them that opens.
static inline bool qcIsLeftOut(int device, const bool opened[qc_testDeviceCount + 1])
{
    return getenv("QC_ONE_RASTERIZER") != NULL && !qcIsLongForm() && opened[qc_testOsmesa] &&
           device == qc_testSurfaceless;
}

/// Null, after a line of output, if this kind does not work here.
static inline qcDevice* qcOpenOrSkip(qcDeviceKind kind)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = kind;
    qcDevice* device = NULL;
    if (qcIsZinkProcess() && kind != qc_deviceSurfaceless && kind != qc_deviceNone)
        return NULL;
    if (qcDevice_Create(&def, &device) != qc_statusOk)
    {
        printf("skipped: %s\n", qcLastMessage());
        return NULL;
    }
    qcDeviceInfo info;
    qcDevice_GetInfo(device, &info);
    if (!qcIsZinkProcess() || kind == qc_deviceNone || strncmp(info.renderer, "zink", 4) == 0)
        return device;
    printf("skipped: zink does not open, but %s\n", info.renderer);
    qcDevice_Destroy(device);
    return NULL;
}

/// Fails if QC_TEST_DEVICES lists a device of this process that did not open, or an unknown one. `opened`: a flag for
/// each of qc_testDeviceNames.
static inline void qcCheckRequired(const bool opened[qc_testDeviceCount + 1])
{
    const char* required = getenv("QC_TEST_DEVICES");
    while (required != NULL && *required != 0)
    {
        size_t length = strcspn(required, ",");
        int device = 0;
        while (device <= qc_testZink && (strlen(qc_testDeviceNames[device]) != length ||
                                         strncmp(qc_testDeviceNames[device], required, length) != 0))
            device++;
        ck_assert_msg(device <= qc_testZink, "QC_TEST_DEVICES: '%.*s' is not one of egl, osmesa, surfaceless, zink",
                      (int)length, required);
        ck_assert_msg(opened[device] || (device == qc_testZink) != qcIsZinkProcess() || qcIsLeftOut(device, opened),
                      "QC_TEST_DEVICES requires %s, which did not open", qc_testDeviceNames[device]);
        required += length + (required[length] == ',');
    }
}

/// Prints and checks which devices a test has run on. Returns their count.
static inline int qcReportDevices(const bool opened[qc_testDeviceCount + 1])
{
    int count = 0;
    char names[64] = "";
    for (int i = 0; i <= qc_testZink; i++)
    {
        if (!opened[i])
            continue;
        size_t length = strlen(names);
        snprintf(names + length, sizeof names - length, "%s%s", count++ > 0 ? ", " : "", qc_testDeviceNames[i]);
    }
    if (count > 0)
        printf("ran on %d GL device%s: %s\n", count, count == 1 ? "" : "s", names);
    else
        fprintf(stderr, "NO GL DEVICE OPENED: what a test does on each device did not run\n");
    fflush(stdout);
    qcCheckRequired(opened);
    return count;
}

static inline int qcGetTestName(int kind)
{
    return qcIsZinkProcess() ? qc_testZink : kind;
}

/// Opens all devices at once, null for those that do not open. Returns the count of open ones.
static inline int qcOpenTestDevices(qcDevice* devices[qc_testDeviceCount])
{
    bool opened[qc_testDeviceCount + 1] = {false};
    for (int i = 0; i < qc_testDeviceCount; i++)
    {
        devices[i] = qcIsLeftOut(i, opened) ? NULL : qcOpenOrSkip(qc_testKinds[i]);
        if (devices[i] != NULL)
            opened[qcGetTestName(i)] = true;
    }
    return qcReportDevices(opened);
}

static inline void qcCloseTestDevices(qcDevice* devices[qc_testDeviceCount])
{
    for (int i = 0; i < qc_testDeviceCount; i++)
        qcDevice_Destroy(devices[i]);
}

/// Iterates over the devices, one open at a time.
typedef struct qcDeviceWalk
{
    int next; ///< of qc_testKinds
    bool opened[qc_testDeviceCount + 1];
    qcDevice* device;
} qcDeviceWalk;

/// Closes the open device and opens the next. False, after a report, if there is no other.
static inline bool qcDeviceWalk_Next(qcDeviceWalk* walk)
{
    qcDevice_Destroy(walk->device);
    walk->device = NULL;
    while (walk->device == NULL && walk->next < qc_testDeviceCount)
    {
        if (!qcIsLeftOut(walk->next, walk->opened))
            walk->device = qcOpenOrSkip(qc_testKinds[walk->next]);
        if (walk->device != NULL)
            walk->opened[qcGetTestName(walk->next)] = true;
        walk->next++;
    }
    if (walk->device == NULL)
        qcReportDevices(walk->opened);
    return walk->device != NULL;
}

/// Runs the following statement for each device, open as `device`.
#define QC_FOR_EACH_DEVICE(device)                                                                                     \
    for (qcDeviceWalk device##Walk = {0, {false, false, false, false}, NULL}; qcDeviceWalk_Next(&device##Walk);)       \
        for (qcDevice* device = device##Walk.device; device != NULL; device = NULL)

/// Loads the software drivers with their compiler before the first test. Each test is a child of the program, and would
/// load and relocate them again: a tenth of a second each time. A program with libraries of its own in their place
/// doesn't call it.
static inline void qcLoadDrivers(void)
{
    dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
    dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
}

/// QC_RUN_TESTS for tests several of which open devices.
#define QC_RUN_TESTS_ON_DEVICES(name, ...)                                                                             \
    QC_TEST_MAIN()                                                                                                     \
    {                                                                                                                  \
        qcLoadDrivers();                                                                                               \
        QC_RUN_LISTED(name, __VA_ARGS__);                                                                              \
    }

#endif
