// Child processes: a device that fork() leaves behind is named in messages, and nothing waits for it.
#define _DEFAULT_SOURCE // fork, usleep

#include "support/devices.h"
#include "support/sanitizers.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <pthread.h>
#include <stdatomic.h>
#include <sys/wait.h>
#include <unistd.h>

enum
{
    // A limit against hanging, not a claim about speed.
    qc_childSeconds = 60
};

/// The exit status of a child; 0: success.
typedef int Work(qcScene* scene, qcDevice* device);

/// Ends a child: by exit(), so that the library's exit handlers run; by _exit() where the parent has OSMesa, whose exit
/// handlers crash in any child.
typedef void End(int);

static bool s_isChild;

/// Called by the leak sanitizer where there is one. In a child it takes what the parent's other threads hold for leaks.
__attribute__((visibility("default"))) int __lsan_is_turned_off(void);

int __lsan_is_turned_off(void)
{
    return s_isChild;
}

/// Runs the work in a child process.
static void CheckChild(Work* work, qcScene* scene, qcDevice* device, End* end, const char* what)
{
    fflush(NULL);
    pid_t child = fork();
    ck_assert_int_ge(child, 0);
    if (child == 0)
    {
        s_isChild = true;
        alarm(qc_childSeconds);
        end(work(scene, device));
    }
    int status = 0;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert_msg(!WIFSIGNALED(status), "%s: the child ended by signal %d", what, WTERMSIG(status));
    ck_assert_msg(WEXITSTATUS(status) == 0, "%s: the child failed at %d", what, WEXITSTATUS(status));
}

/// A cloth, large enough for threads and for a device.
static qcScene* MakeScene(qcDevice* device)
{
    qcScene* scene = qcMakeScene(device);
    qcSoup cloth = qcSoup_MakeFoldedCloth(3, 40, 0.02, 0.02);
    qcAddSoup(scene, &cloth);
    qcSoup_Free(&cloth);
    return scene;
}

static qcStatus Detect(qcScene* scene, qcMethod method, double margin, const qcResult** result)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.margin = margin; // another one than before: the last result is not given again
    def.resolution = 64;
    def.threads = 3;
    return qcScene_Detect(scene, &def, result);
}

/// Changes the scene, so that the next step is computed anew.
static qcStatus Move(qcScene* scene, double x)
{
    const qcTransform moved = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {x, 0, 0}};
    return qcScene_SetTransform(scene, (qcBodyId){0, 1}, &moved);
}

static bool NamesParent(const char* text)
{
    char name[64];
    snprintf(name, sizeof name, "process %ld", (long)getppid());
    return text != NULL && strstr(text, name) != NULL;
}

static int AskByLayers(qcScene* scene, qcDevice* device)
{
    const qcResult *result, *expected;
    qcScene* other = MakeScene(NULL);
    if (Detect(other, qc_methodSweep, 0.001, &expected) != qc_statusOk)
        return 1;
    if (Detect(scene, qc_methodLayers, 0.001, &result) != qc_statusOk)
        return 2;
    if (result->profile.method != qc_methodSweep || !NamesParent(result->profile.fallback))
        return 3;
    if (result->pairCount == 0 || result->pairCount != expected->pairCount ||
        memcmp(result->pairs, expected->pairs, result->pairCount * sizeof(qcPair)) != 0)
        return 4;
    if (Detect(scene, qc_methodAuto, 0.002, &result) != qc_statusOk || result->profile.method != qc_methodSweep)
        return 5;
    qcScene_Destroy(other);
    qcScene_Destroy(scene);
    qcDevice_Destroy(device);
    return qcGetByteCount() == 0 ? 0 : 6;
}

START_TEST(layers_in_a_child_falls_back_to_the_sweep_and_gives_the_reason)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo info;
        CHECK_OK(qcDevice_GetInfo(device, &info));
        if (!info.compute)
            continue;
        qcScene* scene = MakeScene(device);
        const qcResult* result;
        CHECK_OK(Detect(scene, qc_methodLayers, 0.0, &result));
        ck_assert_int_eq(result->profile.method, qc_methodLayers);
        CheckChild(AskByLayers, scene, device, _exit, info.name);
        // The parent goes on.
        CHECK_OK(Detect(scene, qc_methodLayers, 0.001, &result));
        ck_assert_int_eq(result->profile.method, qc_methodLayers);
        qcScene_Destroy(scene);
    }
}
END_TEST

static int AskByQuick(qcScene* scene, qcDevice* device)
{
    const qcResult* result;
    if (Move(scene, 1.0) != qc_statusOk || Detect(scene, qc_methodQuick, 0.0, &result) != qc_statusDevice ||
        !NamesParent(qcLastMessage()))
        return 1;
    // The scene is unchanged.
    if (Detect(scene, qc_methodSweep, 0.0, &result) != qc_statusOk || result->pairCount == 0)
        return 2;
    qcDevice_Destroy(device);
    return 0;
}

START_TEST(calls_that_need_the_device_fail_in_a_child_and_name_the_process)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = MakeScene(device);
        const qcResult* result;
        CHECK_OK(Detect(scene, qc_methodQuick, 0.0, &result));
        CheckChild(AskByQuick, scene, device, _exit, "quick");
        qcScene_Destroy(scene);
    }
}
END_TEST

static int OpenDevices(qcScene* scene, qcDevice* device)
{
    (void)scene;
    (void)device;
    for (int kind = qc_deviceAuto; kind <= qc_deviceNone; kind++)
    {
        qcDeviceDef def = qcDefaultDeviceDef();
        def.kind = (qcDeviceKind)kind;
        qcDevice* opened = NULL;
        qcStatus status = qcDevice_Create(&def, &opened);
        bool without = kind == qc_deviceAuto || kind == qc_deviceNone;
        if (status != (without ? qc_statusOk : qc_statusDevice))
            return 1 + kind;
        if (!without && !NamesParent(qcLastMessage()))
            return 11 + kind;
        qcDevice_Destroy(opened);
    }
    return 0;
}

START_TEST(gl_can_not_be_opened_in_a_child_of_a_process_that_had_opened_it)
{
    // Whether it is still open or closed again: drivers keep their threads.
    for (size_t k = 0; k < qc_testDeviceCount; k++)
    {
        qcDevice* device = qcOpenOrSkip(qc_testKinds[k]);
        if (device == NULL)
            continue;
        CheckChild(OpenDevices, NULL, NULL, _exit, "while one is open");
        qcDevice_Destroy(device);
        CheckChild(OpenDevices, NULL, NULL, _exit, "after it was closed");
    }
}
END_TEST

static int OpenAny(qcScene* scene, qcDevice* parents)
{
    (void)scene;
    (void)parents;
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* mine = MakeScene(device);
        const qcResult* result;
        if (Detect(mine, qc_methodQuick, 0.0, &result) != qc_statusOk)
            return 1;
        qcScene_Destroy(mine);
    }
    return 0;
}

START_TEST(a_child_opens_gl_where_its_parent_has_not)
{
    CheckChild(OpenAny, NULL, NULL, exit, "a child");
    CheckChild(OpenAny, NULL, NULL, exit, "another child");
}
END_TEST

//  ---- while other threads work --------------------------------------------------------------------

typedef struct Worker
{
    pthread_t thread;
    qcDevice* device;
    atomic_bool ends;
    atomic_int steps;
} Worker;

static void* StepOn(void* context)
{
    Worker* worker = context;
    qcScene* scene = MakeScene(worker->device);
    const qcResult* result;
    for (int i = 0; !worker->ends; i++)
    {
        qcMethod method = worker->device != NULL ? qc_methodQuick : qc_methodSweep;
        if (Move(scene, i % 2) != qc_statusOk || Detect(scene, method, 0.0, &result) != qc_statusOk)
            abort();
        worker->steps++;
    }
    qcScene_Destroy(scene);
    return NULL;
}

static void CheckWhileWorking(qcDevice* device, Work* work, qcScene* scene, int children)
{
    Worker worker = {.device = device};
    ck_assert_int_eq(pthread_create(&worker.thread, NULL, StepOn, &worker), 0);
    for (int i = 0; i < children; i++)
    {
        // At another moment of a step each time.
        for (int steps = worker.steps; worker.steps <= steps + i % 2;)
            usleep((unsigned)(100 + 37 * i));
        CheckChild(work, scene, device, device != NULL ? _exit : exit, "a child");
    }
    worker.ends = true;
    ck_assert_int_eq(pthread_join(worker.thread, NULL), 0);
}

static int SweepAnew(qcScene* scene, qcDevice* device)
{
    (void)device;
    const qcResult* result;
    qcScene* mine = MakeScene(NULL);
    if (Detect(mine, qc_methodSweep, 0.0, &result) != qc_statusOk || result->pairCount == 0)
        return 1;
    qcScene_Destroy(mine);
    return Detect(scene, qc_methodSweep, 0.0, &result) == qc_statusOk && result->pairCount != 0 ? 0 : 2;
}

START_TEST(a_child_of_a_process_whose_threads_are_in_a_loop_sweeps_with_its_own)
{
    if (!qcChildrenCanStartThreads())
        return;
    qcScene* scene = MakeScene(NULL);
    CheckWhileWorking(NULL, SweepAnew, scene, 30);
    qcScene_Destroy(scene);
}
END_TEST

static int DestroyDevice(qcScene* scene, qcDevice* device)
{
    const qcResult* result;
    if (Detect(scene, qc_methodQuick, 0.0, &result) != qc_statusDevice)
        return 1;
    qcScene_Destroy(scene);
    qcDevice_Destroy(device);
    return 0;
}

START_TEST(a_child_closes_a_device_that_another_thread_was_using)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = MakeScene(device);
        CheckWhileWorking(device, DestroyDevice, scene, 5);
        qcScene_Destroy(scene);
    }
}
END_TEST

QC_RUN_TESTS("fork", layers_in_a_child_falls_back_to_the_sweep_and_gives_the_reason,
             calls_that_need_the_device_fail_in_a_child_and_name_the_process,
             gl_can_not_be_opened_in_a_child_of_a_process_that_had_opened_it, a_child_opens_gl_where_its_parent_has_not,
             a_child_of_a_process_whose_threads_are_in_a_loop_sweeps_with_its_own,
             a_child_closes_a_device_that_another_thread_was_using)
