// Drivers that fail, and lost devices: the failure is reported, and `layers` still finds every pair, by the sweep if it
// must.
#define _POSIX_C_SOURCE 200809L
#include "gl/replaced_driver.h"
#include "support/suite.h"

//  ---- failures ------------------------------------------------------------------------------------------------------

static int s_failures; // still to happen

static void APIENTRY FailTexBuffer(GLenum target, GLenum format, GLuint buffer)
{
    // The second call is one of many in the first step.
    s_real.TexBuffer(target, ++s_failures == 2 ? 0xdead : format, buffer);
}

static void MakeErring(struct qcGlFunctions* gl)
{
    gl->TexBuffer = FailTexBuffer;
}

START_TEST(a_gl_error_between_two_allocations_is_reported)
{
    QC_FOR_EACH_DEVICE(device)
    {
        if (!MakeDriver(device, MakeErring))
            continue;
        s_failures = 0;
        World world = MakeWorld(device);
        CheckReason(CheckPairs(world.scene, 0.0), "GL_INVALID_ENUM");
        MoveAll(&world);
        CheckAnswered(CheckPairs(world.scene, 0.0));
        qcScene_Destroy(world.scene);
    }
}
END_TEST

/// A mapping that shows nothing of what the device wrote.
static void* APIENTRY MapNothing(GLenum target, GLintptr offset, GLsizeiptr size, GLbitfield access)
{
    static uint32_t s_nothing[4096];
    void* data = s_real.MapBufferRange(target, offset, size, access);
    return s_failures > 0 && s_failures-- > 0 ? s_nothing : data;
}

static void MakeUnreadable(struct qcGlFunctions* gl)
{
    // Below GL 4.4 the results are mapped in each step.
    gl->BufferStorage = NULL;
    gl->MapBufferRange = MapNothing;
}

static void* APIENTRY MapNowhere(GLenum target, GLintptr offset, GLsizeiptr size, GLbitfield access)
{
    return s_failures > 0 && s_failures-- > 0 ? NULL : s_real.MapBufferRange(target, offset, size, access);
}

static void MakeUnmapped(struct qcGlFunctions* gl)
{
    gl->BufferStorage = NULL;
    gl->MapBufferRange = MapNowhere;
}

static GLenum APIENTRY WaitInVain(GLsync fence, GLbitfield flags, GLuint64 timeout)
{
    GLenum reached = s_real.ClientWaitSync(fence, flags, timeout);
    return s_failures > 0 && s_failures-- > 0 ? GL_TIMEOUT_EXPIRED : reached;
}

static void MakeEndless(struct qcGlFunctions* gl)
{
    gl->ClientWaitSync = WaitInVain;
}

static void APIENTRY DispatchNothing(GLuint x, GLuint y, GLuint z)
{
    if (s_failures <= 0)
        s_real.DispatchCompute(x, y, z);
}

static void MakeIdle(struct qcGlFunctions* gl)
{
    gl->DispatchCompute = DispatchNothing;
}

static int s_kernelsOfStep, s_dispatches, s_missing;

/// Runs all kernels of a step but the one numbered s_missing.
static void APIENTRY DispatchAllButOne(GLuint x, GLuint y, GLuint z)
{
    if (s_dispatches++ % s_kernelsOfStep != s_missing || s_failures <= 0)
        s_real.DispatchCompute(x, y, z);
}

static void MakeNearlyDone(struct qcGlFunctions* gl)
{
    s_dispatches = 0;
    gl->DispatchCompute = DispatchAllButOne;
}

static void APIENTRY CountDispatch(GLuint x, GLuint y, GLuint z)
{
    s_dispatches++;
    s_real.DispatchCompute(x, y, z);
}

/// In place of the kernel numbered s_missing the one before it runs again. A steady step does not call glGetError.
static void APIENTRY UseAllButOne(GLuint program)
{
    if (s_dispatches % s_kernelsOfStep != s_missing || s_failures <= 0)
        s_real.UseProgram(program);
}

static void MakeRepeating(struct qcGlFunctions* gl)
{
    s_dispatches = 0;
    gl->DispatchCompute = CountDispatch;
    gl->UseProgram = UseAllButOne;
}

static void CheckUnfinished(qcReplace* replace, int failures, const char* refiner)
{
    setenv("QC_LAYERS_REFINE", refiner, 1);
    QC_FOR_EACH_DEVICE(device)
    {
        if (!MakeDriver(device, replace))
            continue;
        World world = MakeWorld(device);
        s_failures = failures;
        CheckReason(CheckPairs(world.scene, 0.0), "the device did not finish");
        s_failures = 0;
        MoveAll(&world);
        CheckPairs(world.scene, 0.0);
        // Again after a successful step: in the first one no result has been read before.
        MoveAll(&world);
        s_failures = failures;
        CheckReason(CheckPairs(world.scene, 0.0), "the device did not finish");
        qcScene_Destroy(world.scene);
    }
}

START_TEST(a_readback_that_does_nothing_is_no_result)
{
    CheckUnfinished(MakeUnreadable, 1, "device");
    CheckUnfinished(MakeUnreadable, 1, "processor");
    CheckUnfinished(MakeEndless, 1, "device");
    CheckUnfinished(MakeEndless, 1, "processor");
}
END_TEST

START_TEST(a_readback_that_is_refused_is_named_and_the_next_step_reads)
{
    const char* refiners[] = {"device", "processor"};
    for (int i = 0; i < 2; i++)
    {
        setenv("QC_LAYERS_REFINE", refiners[i], 1);
        QC_FOR_EACH_DEVICE(device)
        {
            if (!MakeDriver(device, MakeUnmapped))
                continue;
            World world = MakeWorld(device);
            CheckAnswered(CheckPairs(world.scene, 0.0));
            MoveAll(&world);
            s_failures = 1;
            CheckReason(CheckPairs(world.scene, 0.0), "the device's answer can't be read");
            qcScene_Destroy(world.scene);
            // In a new scene the device is tried at once.
            world = MakeWorld(device);
            CheckAnswered(CheckPairs(world.scene, 0.0));
            qcScene_Destroy(world.scene);
        }
    }
}
END_TEST

/// Lacks a kernel in a steady step. With 1000 triangles there are so many pairs that the device puts them in order.
static void CheckSteadyStep(qcDevice* device, qcReplace* replace, uint32_t triangles)
{
    if (!MakeDriver(device, replace))
        return;
    World world = MakeWorldOf(device, triangles, 0.15);
    for (int step = 0; step < 4; step++)
    {
        MoveAll(&world);
        s_dispatches = 0;
        s_failures = step == 2;
        const char* fallback = CheckPairs(world.scene, 0.0);
        if (step == 2)
            CheckReason(fallback, "the device did not finish");
        else
            ck_assert_ptr_null(fallback);
        // The first step's lists may grow; the second puts its pairs in order.
        ck_assert(step != 1 || s_dispatches == s_kernelsOfStep);
    }
    qcScene_Destroy(world.scene);
}

static void CheckEachKernel(qcReplace* replace, int kernels, uint32_t triangles)
{
    s_kernelsOfStep = kernels;
    for (s_missing = 0; s_missing < kernels; s_missing++)
        QC_FOR_EACH_DEVICE(device)
    CheckSteadyStep(device, replace, triangles);
}

START_TEST(kernels_that_do_not_run_give_no_result)
{
    CheckUnfinished(MakeIdle, 1, "device");
    CheckUnfinished(MakeIdle, 1, "processor");
    s_kernelsOfStep = 5;
    for (s_missing = 0; s_missing < s_kernelsOfStep; s_missing++)
        CheckUnfinished(MakeNearlyDone, 1, "device");
    setenv("QC_LAYERS_REFINE", "device", 1);
    CheckEachKernel(MakeNearlyDone, 6, 1000);
}
END_TEST

START_TEST(kernels_that_run_in_place_of_others_give_no_result)
{
    setenv("QC_LAYERS_REFINE", "device", 1);
    CheckEachKernel(MakeRepeating, 5, 200);
    CheckEachKernel(MakeRepeating, 6, 1000);
}
END_TEST

static bool s_isRefused;

/// Refuses the upload numbered s_failures, from 1 on.
static void APIENTRY RefuseUpload(GLenum target, GLintptr at, GLsizeiptr size, const void* data)
{
    bool refuses = s_failures > 0 && --s_failures == 0;
    if (!refuses)
        s_real.BufferSubData(target, at, size, data);
    s_isRefused |= refuses;
}

static GLenum APIENTRY GetRefusal(void)
{
    GLenum error = s_isRefused ? GL_INVALID_OPERATION : s_real.GetError();
    s_isRefused = false;
    return error;
}

static void MakeRefusing(struct qcGlFunctions* gl)
{
    gl->BufferSubData = RefuseUpload;
    gl->GetError = GetRefusal;
}

/// A body takes the place of another: there is room, and nothing else is new.
static void CheckRefusedUpload(qcDevice* device, int upload)
{
    World world = MakeWorld(device);
    for (int step = 0; step < 3; step++)
    {
        MoveAll(&world);
        CheckAnswered(CheckPairs(world.scene, 0.0));
    }
    CHECK_OK(qcScene_RemoveBody(world.scene, world.ids[0]));
    qcSoup soup = qcSoup_MakeRandom(99, 200, 0.15);
    world.ids[0] = qcAddSoup(world.scene, &soup);
    qcSoup_Free(&soup);
    s_failures = upload;
    CheckReason(CheckPairs(world.scene, 0.0), "GL_INVALID_OPERATION");
    ck_assert_int_eq(s_failures, 0);
    qcScene_Destroy(world.scene);
}

START_TEST(a_refused_upload_of_a_body_is_reported)
{
    setenv("QC_LAYERS_REFINE", "device", 1);
    QC_FOR_EACH_DEVICE(device)
    if (MakeDriver(device, MakeRefusing))
        for (int upload = 1; upload <= 3; upload++)
            CheckRefusedUpload(device, upload);
}
END_TEST

static uint32_t s_attempts;
static bool s_hasRun, s_isFull;

static void APIENTRY CountAttempts(GLsizei count, GLuint* textures)
{
    s_attempts++;
    s_hasRun = false;
    s_real.GenTextures(count, textures);
}

static void APIENTRY NoteRun(GLuint x, GLuint y, GLuint z)
{
    s_hasRun = true;
    s_real.DispatchCompute(x, y, z);
}

static void APIENTRY RunOutOfMemory(GLenum target, GLsizeiptr size, const void* data, GLenum usage)
{
    // Like a failing GL: no memory, and the error.
    s_isFull = s_failures > 0 && s_hasRun;
    s_real.BufferData(target, s_isFull ? 0 : size, data, usage);
}

static GLenum APIENTRY GetMemoryError(void)
{
    GLenum error = s_isFull ? GL_OUT_OF_MEMORY : s_real.GetError();
    s_isFull = false;
    return error;
}

static void APIENTRY RunOutOfStorage(GLenum target, GLsizeiptr size, const void* data, GLbitfield flags)
{
    s_isFull = s_failures > 0 && s_hasRun;
    if (!s_isFull)
        s_real.BufferStorage(target, size, data, flags);
}

static void MakeSmall(struct qcGlFunctions* gl)
{
    gl->GenTextures = CountAttempts;
    gl->DispatchCompute = NoteRun;
    gl->BufferData = RunOutOfMemory;
    if (gl->BufferStorage != NULL)
        gl->BufferStorage = RunOutOfStorage;
    gl->GetError = GetMemoryError;
}

static void DetectLayers(qcScene* scene, const char** fallback)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodLayers;
    const qcResult* result = NULL;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    *fallback = result->profile.fallback;
}

START_TEST(a_device_that_keeps_failing_is_tried_ever_less)
{
    setenv("QC_LAYERS_REFINE", "device", 1);
    // All triangles overlap: lists must grow.
    qcSoup soup = qcSoup_MakeRandom(5, 1200, 0.25);
    QC_FOR_EACH_DEVICE(device)
    {
        if (!MakeDriver(device, MakeSmall))
            continue;
        s_failures = 1;
        s_attempts = 0;
        qcScene* scene = qcMakeScene(device);
        const qcBodyId id = qcAddDeformingSoup(scene, &soup);
        const char* fallback = NULL;
        for (int step = 0; step < 64; step++)
        {
            CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
            DetectLayers(scene, &fallback);
            CheckReason(fallback, "no memory for");
        }
        ck_assert_uint_ge(s_attempts, 4);
        ck_assert_uint_le(s_attempts, 8);
        // The device is never given up.
        s_failures = 0;
        int steps = 0;
        for (; fallback != NULL && steps < 256; steps++)
        {
            CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
            DetectLayers(scene, &fallback);
        }
        ck_assert_ptr_null(fallback);
        CheckAnswered(CheckPairs(scene, 0.0));
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(a_device_that_failed_is_tried_at_once_when_the_scene_is_of_another_size)
{
    setenv("QC_LAYERS_REFINE", "device", 1);
    qcSoup soup = qcSoup_MakeRandom(5, 1200, 0.25), small = qcSoup_MakeRandom(6, 200, 0.25);
    QC_FOR_EACH_DEVICE(device)
    {
        if (!MakeDriver(device, MakeSmall))
            continue;
        s_failures = 1;
        qcScene* scene = qcMakeScene(device);
        const qcBodyId id = qcAddDeformingSoup(scene, &soup);
        const char* fallback = NULL;
        for (int step = 0; step < 20; step++)
        {
            CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
            DetectLayers(scene, &fallback);
        }
        // 16 steps are left to the next attempt, but not for a scene of a sixth of the size.
        CheckReason(fallback, "next attempt in");
        CHECK_OK(qcScene_RemoveBody(scene, id));
        qcAddSoup(scene, &small);
        s_failures = 0;
        DetectLayers(scene, &fallback);
        ck_assert_ptr_null(fallback);
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&soup);
    qcSoup_Free(&small);
}
END_TEST

//  ---- lost devices --------------------------------------------------------------------------------------------------

static GLenum APIENTRY ReportReset(void)
{
    return GL_INNOCENT_CONTEXT_RESET;
}

static void MakeLost(struct qcGlFunctions* gl)
{
    gl->GetGraphicsResetStatus = ReportReset;
}

static qcStatus DetectQuick(qcScene* scene)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodQuick;
    def.resolution = 256;
    const qcResult* result = NULL;
    return qcScene_Detect(scene, &def, &result);
}

static qcStatus Draw(qcDevice* device)
{
    uint8_t rgb[16 * 16 * 3];
    qcPictureDef def = qcDefaultPictureDef();
    def.width = def.height = 16;
    return qcDevice_DrawPicture(device, &def, rgb);
}

START_TEST(a_lost_device_is_reported_and_its_scenes_go_on_once_it_is_reopened)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo info;
        CHECK_OK(qcDevice_GetInfo(device, &info));
        if (!info.compute)
            continue;
        World worlds[2] = {MakeWorld(device), MakeWorld(device)};
        for (int i = 0; i < 2; i++)
            CheckAnswered(CheckPairs(worlds[i].scene, 0.0));
        CHECK_OK(Draw(device));

        Replacement replacement = {MakeLost};
        ck_assert_int_eq(qcDevice_Run(device, Replace, &replacement, "a test"), qc_statusDeviceLost);
        ck_assert_str_eq(qcLastMessage(), "a test: the GL context is lost");
        CHECK_OK(qcDevice_GetInfo(device, &info));
        ck_assert(info.lost);
        for (int i = 0; i < 2; i++)
        {
            MoveAll(&worlds[i]);
            CheckReason(CheckPairs(worlds[i].scene, 0.0), "the GL context is lost");
        }
        ck_assert_int_eq(DetectQuick(worlds[0].scene), qc_statusDeviceLost);
        ck_assert_int_eq(Draw(device), qc_statusDeviceLost);

        CHECK_OK(qcDevice_Reopen(device));
        CHECK_OK(qcDevice_GetInfo(device, &info));
        ck_assert(!info.lost);
        // In reverse order: names in the new context belong to other objects than before.
        for (int i = 1; i >= 0; i--)
        {
            MoveAll(&worlds[i]);
            CheckAnswered(CheckPairs(worlds[i].scene, 0.0));
        }
        CHECK_OK(DetectQuick(worlds[0].scene));
        CHECK_OK(Draw(device));

        // Objects of a lost context are not deleted in the new one.
        CHECK_OK(qcDevice_Reopen(device));
        MoveAll(&worlds[1]);
        CheckAnswered(CheckPairs(worlds[1].scene, 0.0));
        qcScene_Destroy(worlds[0].scene);
        MoveAll(&worlds[1]);
        CheckAnswered(CheckPairs(worlds[1].scene, 0.0));
        qcScene_Destroy(worlds[1].scene);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("failing drivers", a_gl_error_between_two_allocations_is_reported,
                        a_readback_that_does_nothing_is_no_result,
                        a_readback_that_is_refused_is_named_and_the_next_step_reads,
                        kernels_that_do_not_run_give_no_result, kernels_that_run_in_place_of_others_give_no_result,
                        a_refused_upload_of_a_body_is_reported, a_device_that_keeps_failing_is_tried_ever_less,
                        a_device_that_failed_is_tried_at_once_when_the_scene_is_of_another_size,
                        a_lost_device_is_reported_and_its_scenes_go_on_once_it_is_reopened)
