// Each function of GL fails in turn: it does nothing and leaves an error behind. And the n-th look at GL's errors finds
// one, or finds the context lost, for each n of a step. Or the device reports other limits than it has. Whatever fails:
// a status, every pair, and the next step is whole.
#define _POSIX_C_SOURCE 200809L
#include "gl/replaced_driver.h"
#include "support/long_form.h"
#include "support/suite.h"

#include <stddef.h>

//  ---- the shim --------------------------------------------------------------------------------------------------

typedef struct Function
{
    const char* name;
    size_t offset; ///< of its pointer in qcGlFunctions
} Function;

#define FUNCTION(Type, Name) {#Name, offsetof(struct qcGlFunctions, Name)},
static const Function s_functions[] = {QC_GL_FUNCTIONS(FUNCTION) FUNCTION(, DispatchCompute) FUNCTION(, MemoryBarrier)
                                           FUNCTION(, BufferStorage)};

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
    restored.state = gl->state;
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

/// Each triangle is drawn several times a step by `quick` and `cullide`: few and large ones.
static World MakeWorldFor(qcDevice* device, qcMethod method)
{
    return method == qc_methodLayers ? MakeWorldOf(device, 200, 0.15) : MakeWorldOf(device, 12, 0.4);
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
    bool everywhere;        ///< on every device in the long form; otherwise on the first
} Way;

static const Way s_ways[] = {{qc_methodLayers, "processor", true},
                             {qc_methodLayers, "device", true},
                             {qc_methodQuick, "processor", false},
                             {qc_methodCullide, "processor", false}};

enum
{
    qc_wayCount = sizeof s_ways / sizeof s_ways[0]
};

static bool IsEverywhere(const Way* way)
{
    return way->everywhere && qcIsLongForm();
}

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
        if (!Computes(device) || (isTried && !IsEverywhere(way)))
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
        if (!Computes(device) || (isTried && (losesContext || !IsEverywhere(way))))
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

//  ---- limits ----------------------------------------------------------------------------------------------------

static int64_t s_limit;        ///< what is reported for every limit
static GLsizeiptr s_roomBytes; ///< of the largest buffer that there really is

static bool IsLimit(GLenum name)
{
    return name == GL_MAX_SHADER_STORAGE_BLOCK_SIZE || name == GL_MAX_TEXTURE_BUFFER_SIZE ||
           name == GL_MAX_RENDERBUFFER_SIZE || name == GL_MAX_VIEWPORT_DIMS ||
           name == GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS || name == GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS ||
           name == GL_SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT;
}

static void APIENTRY GetOtherLimit(GLenum name, GLint* values)
{
    s_real.GetIntegerv(name, values);
    if (!IsLimit(name))
        return;
    for (int i = 0; i < (name == GL_MAX_VIEWPORT_DIMS ? 2 : 1); i++)
        values[i] = s_limit < INT32_MIN ? INT32_MIN : s_limit > INT32_MAX ? INT32_MAX : (GLint)s_limit;
}

static void APIENTRY GetOtherLimit64(GLenum name, GLint64* value)
{
    s_real.GetInteger64v(name, value);
    if (IsLimit(name))
        *value = s_limit;
}

static void APIENTRY AllocateInRoom(GLenum target, GLsizeiptr bytes, const void* data, GLenum usage)
{
    if (bytes <= s_roomBytes)
        s_real.BufferData(target, bytes, data, usage);
    else
        s_isPending = true;
}

static void APIENTRY AllocateStorageInRoom(GLenum target, GLsizeiptr bytes, const void* data, GLbitfield flags)
{
    if (bytes <= s_roomBytes)
        s_real.BufferStorage(target, bytes, data, flags);
    else
        s_isPending = true;
}

static void MakeLiar(struct qcGlFunctions* gl)
{
    gl->GetIntegerv = GetOtherLimit;
    gl->GetInteger64v = GetOtherLimit64;
    gl->GetError = GetPendingError;
    gl->BufferData = AllocateInRoom;
    if (gl->BufferStorage != NULL)
        gl->BufferStorage = AllocateStorageInRoom;
}

/// Three steps on a device that reports a limit and has room for buffers of some bytes. Returns how many the device
/// did.
static int CheckLimits(qcDevice* device, qcMethod method, int64_t limit, GLsizeiptr roomBytes)
{
    s_limit = limit;
    s_roomBytes = roomBytes;
    s_losesContext = false;
    World world = MakeWorldFor(device, method);
    Replacement replacement = {MakeLiar};
    CHECK_OK(qcDevice_Run(device, Replace, &replacement, "a test"));
    int done = 0;
    for (int step = 0; step < 3; step++)
        done += RunStep(&world, method);
    RestoreDriver(device);
    qcScene_Destroy(world.scene);
    CheckThatItRecovers(device, method, "limits");
    return done;
}

START_TEST(a_device_that_lies_about_its_limits_loses_no_pair)
{
    static const int64_t limits[] = {INT64_MIN, INT32_MIN, -1, 0, 1, 3, 100, 4096, 100000, INT32_MAX, INT64_MAX};
    const Way* way = &s_ways[_i];
    setenv("QC_LAYERS_REFINE", way->refinement, 1);
    bool isTried = false;
    QC_FOR_EACH_DEVICE(device)
    {
        if (!Computes(device) || (isTried && !IsEverywhere(way)))
            continue;
        isTried = true;
        for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++)
            for (GLsizeiptr room = 64; room <= 1 << 26; room *= 32)
            {
                int done = CheckLimits(device, way->method, limits[i], room);
                if (limits[i] == INT64_MAX && room == 1 << 26)
                    ck_assert_int_eq(done, 3);
                if (limits[i] <= 0 && way->method == qc_methodLayers)
                    ck_assert_int_eq(done, 0);
            }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

int main(void)
{
    TCase* testCase = qcMakeCase("failing calls");
    tcase_add_loop_test(testCase, a_function_that_fails_loses_no_pair, 0, qc_wayCount);
    tcase_add_loop_test(testCase, an_error_or_a_loss_at_any_time_loses_no_pair, 0, 2 * qc_wayCount);
    tcase_add_loop_test(testCase, a_device_that_lies_about_its_limits_loses_no_pair, 0, qc_wayCount);
    return qcRunCase("failing calls", testCase);
}
