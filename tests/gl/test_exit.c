// A process that ends with a device and a scene still there, which its exit handlers destroy: drivers' own handlers
// have run before.
#define _DEFAULT_SOURCE // fork

#include "support/devices.h"
#include "support/sanitizers.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <sys/wait.h>
#include <unistd.h>

enum
{
    // A limit against hanging, not a claim about speed.
    qc_childSeconds = 60,
    qc_isSkipped = 77
};

static qcDevice* s_device;
static qcScene* s_scene;
static bool s_isChild;

/// Called by the leak sanitizer where there is one: drivers keep memory.
__attribute__((visibility("default"))) int __lsan_is_turned_off(void);

int __lsan_is_turned_off(void)
{
    return s_isChild;
}

static void DestroyAll(void)
{
    qcScene_Destroy(s_scene);
    qcDevice_Destroy(s_device);
    // What is left to do at the end is done without a device.
    if (qcGetByteCount() != 0)
        _exit(1);
}

/// Opens a device after the handler that destroys it is registered, as a static object's is, and uses it.
static void RunChild(qcDeviceKind kind)
{
    s_isChild = true;
    alarm(qc_childSeconds);
    atexit(DestroyAll);
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = kind;
    if (qcDevice_Create(&def, &s_device) != qc_statusOk)
        exit(qc_isSkipped);
    s_scene = qcMakeScene(s_device);
    qcSoup soup = qcSoup_MakeRandom(3, 200, 0.15);
    qcAddDeformingSoup(s_scene, &soup);
    qcSoup_Free(&soup);
    qcDetectDef detect = qcDefaultDetectDef();
    detect.method = qcHasCompute(s_device) ? qc_methodLayers : qc_methodQuick;
    const qcResult* result = NULL;
    if (qcScene_Detect(s_scene, &detect, &result) != qc_statusOk)
        exit(2);
    exit(0);
}

START_TEST(a_device_may_be_destroyed_at_exit)
{
    int ran = 0;
    for (int kind = qc_deviceEgl; kind <= qc_deviceSurfaceless; kind++)
    {
        fflush(NULL);
        pid_t child = fork();
        ck_assert_int_ge(child, 0);
        if (child == 0)
            RunChild((qcDeviceKind)kind);
        int status = 0;
        ck_assert_int_eq(waitpid(child, &status, 0), child);
        if (WIFEXITED(status) && WEXITSTATUS(status) == qc_isSkipped)
            continue;
        ran++;
        ck_assert_msg(WIFEXITED(status) && WEXITSTATUS(status) == 0, "device of kind %d: wait status %d", kind, status);
    }
    ck_assert_int_ge(ran, 1);
}
END_TEST

QC_RUN_TESTS("exit", a_device_may_be_destroyed_at_exit)
