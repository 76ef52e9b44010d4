// Each function of GL fails in turn: it does nothing and leaves an error behind. And the n-th look at GL's errors finds
// one, or finds the context lost, for each n of a step. Whatever fails: a status, every pair, and the next step is
// whole.
#define _POSIX_C_SOURCE 200809L
#include "gl/replaced_driver.h"
#include "support/suite.h"

#include <stddef.h>

//  ---- the shim --------------------------------------------------------------------------------------------------

typedef struct Function
{
    const char* name;
    size_t offset; ///< of its pointer in qcGlFunctions
} Function;

#define FUNCTION(Type, Name) {#Name, offsetof(struct qcGlFunctions, Name)},
static const Function s_functions[] = {QC_GL_FUNCTIONS(FUNCTION) FUNCTION(, DispatchCompute) FUNCTION(
    , DispatchComputeIndirect) FUNCTION(, MemoryBarrier) FUNCTION(, BufferStorage)};

enum
{
    qc_functionCount = sizeof s_functions / sizeof s_functions[0]
};

static size_t s_failing;           ///< the function that fails
static uint32_t s_calls;           ///< of it
static bool s_isPending;           ///< an error that GetError has not returned yet
static uint32_t s_looks, s_lookAt; ///< looks at errors; the one that finds one, from 1 on; 0: none
static bool s_losesContext;        ///< what is found is a lost context

/// Stands for any function: does nothing.
static uintptr_t FailCall(void)
{
    s_calls++;
    s_isPending = true;
    return 0;
}

static GLenum APIENTRY GetPendingError(void)
{
    GLenum real = s_real.GetError();
    bool found = s_isPending || ++s_looks == s_lookAt;
    s_isPending = false;
    if (!found)
        return real;
    return s_losesContext ? GL_CONTEXT_LOST : GL_INVALID_OPERATION;
}

static void MakeFailing(struct qcGlFunctions* gl)
{
    gl->GetError = GetPendingError;
    if (s_failing == qc_functionCount)
        return;
    qcGlFunction* fail = (qcGlFunction*)FailCall;
    qcGlFunction* real;
    char* pointer = (char*)gl + s_functions[s_failing].offset;
    memcpy(&real, pointer, sizeof real);
    // What this GL does not have, cannot fail; and errors themselves are no call that fails.
    if (real != NULL && (qcGlFunction*)gl->GetError != real)
        memcpy(pointer, &fail, sizeof fail);
}

static qcStatus Restore(const struct qcGlFunctions* gl, void* context)
{
    (void)context;
    struct qcGlFunctions restored = s_real;
    restored.programs = gl->programs;
    *(struct qcGlFunctions*)gl = restored;
    return qc_statusOk;
}

static void RestoreDriver(qcDevice* device)
{
    s_lookAt = 0;
    s_isPending = false;
    CHECK_OK(qcDevice_Run(device, Restore, NULL, "a test"));
}

/// From the next job on. `failing`: qc_functionCount for none.
static void BeginToFail(qcDevice* device, size_t failing)
{
    s_failing = failing;
    s_lookAt = 0;
    s_losesContext = false;
    Replacement replacement = {MakeFailing};
    // This job resets GL's state already by functions that fail.
    (void)qcDevice_Run(device, Replace, &replacement, "a test");
    s_calls = s_looks = 0;
    s_isPending = false;
}

static bool Computes(qcDevice* device)
{
    qcDeviceInfo info;
    CHECK_OK(qcDevice_GetInfo(device, &info));
    return info.compute;
}

//  ---- steps -----------------------------------------------------------------------------------------------------

/// A step by `quick` or `cullide`: every pair, or a failure of the device.
static qcStatus DetectVisible(qcScene* scene, qcMethod method)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    qcPairList expected = qcDetectPairs(scene, &def);
    ck_assert_uint_gt(expected.count, 5);
    def.method = method;
    def.reliable = true;
    def.resolution = 32;
    const qcResult* result = NULL;
    qcStatus status = qcScene_Detect(scene, &def, &result);
    if (status == qc_statusOk)
    {
        qcPairList found = qcListOf(result);
        qcCheckSamePairs(&expected, &found, qcMethod_Name(method));
    }
    else
        ck_assert_msg(status == qc_statusDevice || status == qc_statusDeviceLost, "%s", qcLastMessage());
    free(expected.pairs);
    return status;
}

/// Each triangle is drawn several times a step by `quick` and `cullide`.
static World MakeWorldFor(qcDevice* device, qcMethod method)
{
    return MakeWorldOf(device, method == qc_methodLayers ? 200 : 40);
}

/// A step by a method; true if the device did it.
static bool RunStep(World* world, qcMethod method)
{
    MoveAll(world);
    return method == qc_methodLayers ? CheckPairs(world->scene, 0.0) == NULL
                                     : DetectVisible(world->scene, method) == qc_statusOk;
}

typedef struct Way
{
    qcMethod method;
    const char* refinement; ///< of layers
    bool everywhere;        ///< on every device; otherwise on the first
} Way;

static const Way s_ways[] = {{qc_methodLayers, "processor", true},
                             {qc_methodLayers, "device", true},
                             {qc_methodQuick, "processor", false},
                             {qc_methodCullide, "processor", false}};

enum
{
    qc_wayCount = sizeof s_ways / sizeof s_ways[0]
};

/// Whether a function is called only where programs are compiled, in the first step of a device.
static bool IsOfPrograms(const char* name)
{
    return strstr(name, "Shader") != NULL || strstr(name, "Program") != NULL || strstr(name, "Location") != NULL;
}

/// A step in a new scene, in which the device is tried again at once.
static void CheckThatItRecovers(qcDevice* device, qcMethod method, const char* failed)
{
    World world = MakeWorldFor(device, method);
    ck_assert_msg(RunStep(&world, method), "%s, %s: the device does not recover: %s", qcMethod_Name(method), failed,
                  qcLastMessage());
    qcScene_Destroy(world.scene);
}

/// Two steps while a function fails: the first ones of a scene, or after a successful one. Returns whether it was
/// called.
static bool CheckFailingFunction(qcDevice* device, size_t function, qcMethod method, bool isFirst)
{
    const char* name = s_functions[function].name;
    if (isFirst && IsOfPrograms(name))
        CHECK_OK(qcDevice_Reopen(device));
    World world = MakeWorldFor(device, method);
    if (!isFirst)
        ck_assert(RunStep(&world, method));
    BeginToFail(device, function);
    for (int step = 0; step < 2; step++)
        RunStep(&world, method);
    bool wasCalled = s_calls > 0;
    RestoreDriver(device);
    RunStep(&world, method);
    qcScene_Destroy(world.scene);
    if (wasCalled)
        CheckThatItRecovers(device, method, name);
    return wasCalled;
}

START_TEST(a_function_that_fails_loses_no_pair)
{
    const Way* way = &s_ways[_i];
    setenv("QC_LAYERS_REFINE", way->refinement, 1);
    bool isTried = false;
    QC_FOR_EACH_DEVICE(device)
    {
        if (!Computes(device) || (isTried && !way->everywhere))
            continue;
        isTried = true;
        uint32_t called[2] = {0, 0};
        for (size_t function = 0; function < qc_functionCount; function++)
            for (int first = 0; first < 2; first++)
                called[first] += CheckFailingFunction(device, function, way->method, first != 0);
        ck_assert_uint_gt(called[0], 5);
        ck_assert_uint_gt(called[1], 15);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// The first two steps of a scene, in which a look at GL's errors finds one. Returns whether there were so many looks.
static bool CheckFailingLook(qcDevice* device, uint32_t look, qcMethod method, bool losesContext)
{
    World world = MakeWorldFor(device, method);
    BeginToFail(device, qc_functionCount);
    s_losesContext = losesContext;
    s_lookAt = look;
    for (int step = 0; step < 2; step++)
        RunStep(&world, method);
    bool found = s_looks >= look;
    qcDeviceInfo info;
    CHECK_OK(qcDevice_GetInfo(device, &info));
    if (info.lost)
        CHECK_OK(qcDevice_Reopen(device));
    else
        RestoreDriver(device);
    if (info.lost || look % 8 == 0)
        CheckThatItRecovers(device, method, "an error");
    qcScene_Destroy(world.scene);
    return found;
}

START_TEST(an_error_or_a_loss_at_any_time_loses_no_pair)
{
    const Way* way = &s_ways[_i / 2];
    bool losesContext = _i % 2 != 0;
    setenv("QC_LAYERS_REFINE", way->refinement, 1);
    bool isTried = false;
    QC_FOR_EACH_DEVICE(device)
    {
        if (!Computes(device) || (isTried && !(way->everywhere && !losesContext)))
            continue;
        isTried = true;
        uint32_t look = 1;
        while (CheckFailingLook(device, look, way->method, losesContext))
            ck_assert_uint_lt(look++, 1000);
        printf("%s: %u looks at errors\n", qcMethod_Name(way->method), look - 1);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

int main(void)
{
    Suite* suite = suite_create("failing calls");
    TCase* testCase = tcase_create("failing calls");
    tcase_set_timeout(testCase, 300);
    tcase_add_loop_test(testCase, a_function_that_fails_loses_no_pair, 0, qc_wayCount);
    tcase_add_loop_test(testCase, an_error_or_a_loss_at_any_time_loses_no_pair, 0, 2 * qc_wayCount);
    suite_add_tcase(suite, testCase);
    return qcRunSuite(suite);
}
