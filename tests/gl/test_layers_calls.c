// What a steady step of `layers` costs the processor: calls of GL, waits, bytes, allocations. Counted at the driver.
#define _POSIX_C_SOURCE 200809L
#include "gl/replaced_driver.h"
#include "support/failing_heap.h"
#include "support/suite.h"

static uint32_t s_calls, s_waits, s_unexpected;

/// Stands for every function that no steady step calls.
static uintptr_t CallUnexpected(void)
{
    s_calls++;
    s_unexpected++;
    return 0;
}

static void APIENTRY UseProgram(GLuint program)
{
    s_calls++;
    s_real.UseProgram(program);
}

static void APIENTRY DispatchCompute(GLuint x, GLuint y, GLuint z)
{
    s_calls++;
    s_real.DispatchCompute(x, y, z);
}

static void APIENTRY MemoryBarrier(GLbitfield barriers)
{
    s_calls++;
    s_real.MemoryBarrier(barriers);
}

static GLsync APIENTRY FenceSync(GLenum condition, GLbitfield flags)
{
    s_calls++;
    return s_real.FenceSync(condition, flags);
}

static GLenum APIENTRY ClientWaitSync(GLsync fence, GLbitfield flags, GLuint64 timeout)
{
    s_calls++;
    s_waits++;
    return s_real.ClientWaitSync(fence, flags, timeout);
}

static void APIENTRY DeleteSync(GLsync fence)
{
    s_calls++;
    s_real.DeleteSync(fence);
}

static GLenum APIENTRY GetError(void)
{
    s_calls++;
    return s_real.GetError();
}

static GLenum APIENTRY GetGraphicsResetStatus(void)
{
    s_calls++;
    return s_real.GetGraphicsResetStatus();
}

/// Counts all calls. The bindings of the step before stay.
static void MakeCounting(struct qcGlFunctions* gl)
{
#define REPLACE(Type, Name) gl->Name = (Type)(qcGlFunction*)CallUnexpected;
    QC_GL_FUNCTIONS(REPLACE)
#undef REPLACE
    gl->UseProgram = UseProgram;
    gl->DispatchCompute = DispatchCompute;
    gl->MemoryBarrier = MemoryBarrier;
    gl->FenceSync = FenceSync;
    gl->ClientWaitSync = ClientWaitSync;
    gl->DeleteSync = DeleteSync;
    gl->GetError = GetError;
    gl->GetGraphicsResetStatus = s_real.GetGraphicsResetStatus != NULL ? GetGraphicsResetStatus : NULL;
    qcGl_KeepBindings(gl, gl->state->bound);
}

static qcStatus RestoreDriver(const struct qcGlFunctions* gl, void* context)
{
    (void)context;
    *(struct qcGlFunctions*)gl = s_real;
    return qc_statusOk;
}

typedef struct Cloth
{
    qcScene* scene;
    qcBodyId ids[2];
    qcSoup soup;
    float* positions[2]; ///< of two frames
    bool rigid;
} Cloth;

/// A soup with itself, or two rigid ones.
static Cloth MakeCloth(qcDevice* device, qcSoup soup, bool rigid)
{
    Cloth cloth = {.scene = qcMakeScene(device), .soup = soup, .rigid = rigid};
    qcBodyDef def = qcBodyDefOf(&cloth.soup);
    def.deforming = !rigid;
    def.selfCollision = !rigid;
    for (int i = 0; i < (rigid ? 2 : 1); i++)
        CHECK_OK(qcScene_AddBody(cloth.scene, &def, &cloth.ids[i]));
    for (int frame = 0; frame < 2; frame++)
    {
        cloth.positions[frame] = malloc(3 * sizeof(float) * cloth.soup.vertexCount);
        ck_assert_ptr_nonnull(cloth.positions[frame]);
        for (uint32_t i = 0; i < 3 * cloth.soup.vertexCount; i++)
            cloth.positions[frame][i] = (float)(cloth.soup.positions[i] * (frame == 0 ? 1.0 : 1.001));
    }
    return cloth;
}

static void FreeCloth(Cloth* cloth)
{
    qcScene_Destroy(cloth->scene);
    free(cloth->positions[0]);
    free(cloth->positions[1]);
    qcSoup_Free(&cloth->soup);
}

static const qcProfile* Step(const Cloth* cloth, uint32_t step)
{
    qcTransform transform = qcIdentityTransform();
    transform.translation[2] = 0.01 + 0.001 * (step % 2);
    if (cloth->rigid)
        CHECK_OK(qcScene_SetTransform(cloth->scene, cloth->ids[0], &transform));
    else
        CHECK_OK(qcScene_SetVertices(cloth->scene, cloth->ids[0], cloth->positions[step % 2], qc_positionF32, 0));
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodLayers;
    def.threads = 1;
    const qcResult* result = NULL;
    CHECK_OK(qcScene_Detect(cloth->scene, &def, &result));
    CheckAnswered(result->profile.fallback);
    ck_assert_uint_gt(result->pairCount, 10);
    return &result->profile;
}

/// At most what a step needs: vertices once, a table of bodies, nodes and chunks.
static void CheckBytes(const Cloth* cloth, const qcProfile* profile, uint32_t vertexBytes)
{
    uint32_t bodies = cloth->rigid ? 2 : 1, vertices = cloth->soup.vertexCount;
    uint32_t tables = bodies * (80 + 4 * (cloth->soup.triangleCount / 16 + 1) + 16 * (vertices / 64 + 1));
    uint32_t moved = cloth->rigid ? 0 : vertexBytes * vertices;
    ck_assert_uint_ge(profile->uploadedBytes, moved);
    ck_assert_uint_le(profile->uploadedBytes, moved + tables);
}

static void CheckSteadySteps(const Cloth* cloth, const qcFailingHeap* heap, uint32_t vertexBytes, uint32_t maxCalls)
{
    for (uint32_t step = 0; step < 6; step++)
    {
        size_t allocations = heap->calls;
        s_calls = s_waits = s_unexpected = 0;
        const qcProfile* profile = Step(cloth, step);
        ck_assert_uint_eq(s_unexpected, 0);
        ck_assert_uint_eq(s_waits, 1);
        ck_assert_uint_eq(profile->deviceWaits, 1);
        ck_assert_uint_le(s_calls, maxCalls);
        ck_assert_uint_eq(profile->deviceCalls, s_calls);
        ck_assert_uint_eq(profile->reruns, 0);
        ck_assert_uint_eq(heap->calls, allocations);
        CheckBytes(cloth, profile, vertexBytes);
    }
}

static void CheckCloth(Cloth cloth, qcDevice* device, const qcFailingHeap* heap, uint32_t vertexBytes,
                       uint32_t maxCalls)
{
    for (uint32_t step = 0; step < 6; step++)
        Step(&cloth, step);
    ck_assert(MakeDriver(device, MakeCounting));
    CheckSteadySteps(&cloth, heap, vertexBytes, maxCalls);
    CHECK_OK(qcDevice_Run(device, RestoreDriver, NULL, "a test"));
    FreeCloth(&cloth);
}

START_TEST(a_steady_step_has_one_wait_and_at_most_17_calls_and_allocates_nothing)
{
    static const char* const refiners[] = {"device", "processor"};
    static const uint32_t vertexBytes[] = {12, 16};
    qcFailingHeap heap = {0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    for (int i = 0; i < 4; i++)
    {
        setenv("QC_LAYERS_REFINE", refiners[i % 2], 1);
        QC_FOR_EACH_DEVICE(device)
        if (qcHasCompute(device))
            CheckCloth(MakeCloth(device, qcSoup_MakeFoldedCloth(5, 24, 0.02, 0.03), i >= 2), device, &heap,
                       vertexBytes[i % 2], 17);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(to_put_many_pairs_in_order_takes_three_calls)
{
    qcFailingHeap heap = {0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    setenv("QC_LAYERS_REFINE", "device", 1);
    QC_FOR_EACH_DEVICE(device)
    if (qcHasCompute(device))
        CheckCloth(MakeCloth(device, qcSoup_MakeRandom(5, 2000, 0.15), false), device, &heap, 12, 20);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("layers, calls", a_steady_step_has_one_wait_and_at_most_17_calls_and_allocates_nothing,
             to_put_many_pairs_in_order_takes_three_calls)
