// Positions in buffers of a shared context: the same results as those of the same floats on the CPU, to the last bit.
#define _POSIX_C_SOURCE 200809L
#include "gl/gl_functions.h"
#include "quickcullide/quickcullide.h"
#include "support/check_ok.h"
#include "support/failing_heap.h"
#include "support/host_context.h"
#include "support/replay.h"
#include "support/soups.h"
#include "support/suite.h"

#include <math.h>
#include <unistd.h>

enum
{
    t_side = 40,
    t_offset = 20, ///< of the positions in the host's buffer
    t_stride = 16
};

/// A cloth of floats, as a body in two scenes: from a buffer of the host's, and from the CPU.
typedef struct Cloth
{
    qcSoup soup;
    float* positions; ///< three a vertex
    const qcHost* host;
    struct qcGlFunctions gl; ///< the host's
    PFNGLFENCESYNCPROC fenceSync;
    GLuint name;
    qcDeviceBuffer* buffer;
    qcScene *onDevice, *onCpu;
    qcBodyId ids[2];
} Cloth;

static void AddBody(qcScene* scene, const Cloth* cloth, qcBodyId* id)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = cloth->positions;
    def.vertexCount = cloth->soup.vertexCount;
    def.indices = cloth->soup.indices;
    def.triangleCount = cloth->soup.triangleCount;
    def.deforming = true;
    CHECK_OK(qcScene_AddBody(scene, &def, id));
}

static void Open(Cloth* cloth, const qcHost* host, qcDevice* device, qcSoup soup)
{
    *cloth = (Cloth){.soup = soup, .host = host};
    cloth->positions = malloc(3 * sizeof(float) * soup.vertexCount);
    for (size_t i = 0; i < 3 * (size_t)soup.vertexCount; i++)
        cloth->positions[i] = (float)soup.positions[i];
    CHECK_OK(qcGlFunctions_Load(&cloth->gl, host->getFunction));
    cloth->fenceSync = (PFNGLFENCESYNCPROC)host->getFunction("glFenceSync");
    cloth->gl.GenBuffers(1, &cloth->name);
    cloth->gl.BindBuffer(GL_ARRAY_BUFFER, cloth->name);
    cloth->gl.BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(t_offset + t_stride * soup.vertexCount), NULL, GL_DYNAMIC_DRAW);
    cloth->gl.Finish();
    qcDeviceBufferDef def = qcDefaultDeviceBufferDef();
    def.name = cloth->name;
    CHECK_OK(qcDevice_OpenBuffer(device, &def, &cloth->buffer));
    qcSceneDef sceneDef = qcDefaultSceneDef();
    CHECK_OK(qcScene_Create(&sceneDef, &cloth->onCpu));
    sceneDef.device = device;
    CHECK_OK(qcScene_Create(&sceneDef, &cloth->onDevice));
    AddBody(cloth->onCpu, cloth, &cloth->ids[0]);
    AddBody(cloth->onDevice, cloth, &cloth->ids[1]);
}

static void Close(Cloth* cloth)
{
    qcScene_Destroy(cloth->onCpu);
    qcScene_Destroy(cloth->onDevice);
    qcDeviceBuffer_Close(cloth->buffer);
    GLint bound = 0;
    cloth->gl.GetIntegerv(GL_ARRAY_BUFFER_BINDING, &bound);
    ck_assert_int_eq(bound, (GLint)cloth->name);
    ck_assert_ptr_eq(cloth->host->getCurrent(), cloth->host->context);
    ck_assert_uint_eq(cloth->gl.GetError(), GL_NO_ERROR);
    cloth->gl.DeleteBuffers(1, &cloth->name);
    free(cloth->positions);
    qcSoup_Free(&cloth->soup);
}

/// Writes the positions into the host's buffer.
static qcStatus SetBuffer(const Cloth* cloth)
{
    for (uint32_t v = 0; v < cloth->soup.vertexCount; v++)
        cloth->gl.BufferSubData(GL_ARRAY_BUFFER, t_offset + t_stride * (GLintptr)v, 3 * sizeof(float),
                                cloth->positions + 3 * (size_t)v);
    qcVertexBufferDef def = qcDefaultVertexBufferDef();
    def.buffer = cloth->buffer;
    def.offset = t_offset;
    def.stride = t_stride;
    def.fence = cloth->fenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    cloth->gl.Flush();
    qcStatus status = qcScene_SetVertexBuffer(cloth->onDevice, cloth->ids[1], &def);
    ((PFNGLDELETESYNCPROC)cloth->host->getFunction("glDeleteSync"))(def.fence);
    // The host may write at once.
    const float junk[3] = {NAN, NAN, NAN};
    for (uint32_t v = 0; v < cloth->soup.vertexCount; v++)
        cloth->gl.BufferSubData(GL_ARRAY_BUFFER, t_offset + t_stride * (GLintptr)v, sizeof junk, junk);
    cloth->gl.Flush();
    return status;
}

static void SetBoth(const Cloth* cloth)
{
    CHECK_OK(qcScene_SetVertices(cloth->onCpu, cloth->ids[0], cloth->positions, qc_positionF32, 0));
    CHECK_OK(SetBuffer(cloth));
}

static void Jiggle(Cloth* cloth, uint64_t seed, double size)
{
    qcRandom random = {seed};
    for (size_t i = 0; i < 3 * (size_t)cloth->soup.vertexCount; i++)
        cloth->positions[i] = (float)(cloth->soup.positions[i] + qcRandom_Uniform(&random, -size, size));
}

/// Detects in both scenes and compares all results. Returns the device's.
static const qcResult* DetectBoth(const Cloth* cloth, const qcDetectDef* given)
{
    const qcResult *result, *expected;
    qcDetectDef def = *given;
    CHECK_OK(qcScene_Detect(cloth->onDevice, &def, &result));
    if (def.method == qc_methodLayers)
        def.method = qc_methodSweep;
    CHECK_OK(qcScene_Detect(cloth->onCpu, &def, &expected));
    ck_assert_uint_eq(result->pairCount, expected->pairCount);
    ck_assert_uint_eq(result->contactCount, expected->contactCount);
    ck_assert_uint_eq(result->manifoldPointCount, expected->manifoldPointCount);
    for (size_t i = 0; i < result->pairCount; i++)
    {
        ck_assert_mem_eq(&result->pairs[i], &expected->pairs[i], sizeof(qcPair));
        if (def.segments)
            ck_assert_mem_eq(&result->segments[i], &expected->segments[i], sizeof(qcSegment));
        if (def.proximities)
            ck_assert_mem_eq(&result->proximities[i], &expected->proximities[i], sizeof(qcProximity));
    }
    return result;
}

static qcDetectDef LayersDef(void)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodLayers;
    return def;
}

static uint64_t AllBytes(const Cloth* cloth)
{
    return 3 * sizeof(float) * (uint64_t)cloth->soup.vertexCount;
}

static qcSoup MakeCloth(void)
{
    return qcSoup_MakeFoldedCloth(5, t_side, 0.02, 0.011);
}

START_TEST(a_buffer_gives_the_pairs_of_the_same_floats_and_no_vertex_is_uploaded)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        const qcDetectDef def = LayersDef();
        for (uint64_t step = 0; step < 4; step++)
        {
            Jiggle(&cloth, step, 0.004);
            SetBoth(&cloth);
            const qcResult* result = DetectBoth(&cloth, &def);
            ck_assert_int_eq(result->profile.method, qc_methodLayers);
            ck_assert_ptr_null(result->profile.fallback);
            ck_assert_uint_gt(result->pairCount, 10);
            ck_assert_uint_lt(result->profile.readBackBytes, AllBytes(&cloth));
            if (step > 0)
                ck_assert_uint_lt(result->profile.uploadedBytes, AllBytes(&cloth) / 4);
        }
        Close(&cloth);
    }
}
END_TEST

START_TEST(segments_and_proximities_have_the_bits_of_the_cpus)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        qcDetectDef def = LayersDef();
        def.segments = def.proximities = true;
        def.margin = 0.004;
        for (uint64_t step = 0; step < 3; step++)
        {
            Jiggle(&cloth, 10 + step, 0.004);
            SetBoth(&cloth);
            const qcResult* result = DetectBoth(&cloth, &def);
            ck_assert_int_eq(result->profile.method, qc_methodLayers);
            ck_assert_uint_gt(result->pairCount, 10);
        }
        Close(&cloth);
    }
}
END_TEST

START_TEST(steps_that_need_all_positions_read_them_back_once)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        qcDetectDef defs[4] = {LayersDef(), LayersDef(), LayersDef(), LayersDef()};
        defs[0].method = qc_methodSweep;
        defs[1].manifolds = true;
        defs[2].contactMargin = 0.003;
        defs[3].method = qc_methodBrute;
        for (int i = 0; i < 4; i++)
        {
            Jiggle(&cloth, 20 + (uint64_t)i, 0.004);
            SetBoth(&cloth);
            ck_assert_uint_eq(DetectBoth(&cloth, &defs[i])->profile.readBackBytes, AllBytes(&cloth));
            ck_assert_uint_eq(DetectBoth(&cloth, &defs[(i + 1) % 4])->profile.readBackBytes, 0);
        }
        Close(&cloth);
    }
}
END_TEST

START_TEST(a_motion_is_that_of_the_cpu)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        qcDetectDef def = LayersDef(), motion = qcDefaultDetectDef();
        motion.motion = true;
        for (uint64_t step = 0; step < 3; step++)
        {
            Jiggle(&cloth, 30 + step, 0.004);
            SetBoth(&cloth);
            CHECK_OK(qcScene_MarkStart(cloth.onDevice));
            CHECK_OK(qcScene_MarkStart(cloth.onCpu));
            Jiggle(&cloth, 40 + step, 0.004);
            SetBoth(&cloth);
            DetectBoth(&cloth, &def);
            ck_assert_uint_gt(DetectBoth(&cloth, &motion)->pairCount, 10);
        }
        Close(&cloth);
    }
}
END_TEST

START_TEST(a_cloth_of_denormal_floats_loses_no_pair)
{
    QC_FOR_EACH_HOST(walk)
    {
        qcSoup soup = MakeCloth();
        for (size_t i = 0; i < 3 * (size_t)soup.vertexCount; i++)
            soup.positions[i] *= 1e-39;
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, soup);
        const qcDetectDef def = LayersDef();
        SetBoth(&cloth);
        const qcResult* result = DetectBoth(&cloth, &def);
        ck_assert_int_eq(result->profile.method, qc_methodLayers);
        ck_assert_uint_gt(result->pairCount, 10);
        Close(&cloth);
    }
}
END_TEST

START_TEST(a_position_that_is_not_finite_is_refused_and_changes_nothing)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        const float bad[3] = {NAN, INFINITY, -INFINITY};
        const qcDetectDef def = LayersDef();
        SetBoth(&cloth);
        size_t pairs = DetectBoth(&cloth, &def)->pairCount;
        for (int i = 0; i < 3; i++)
        {
            Jiggle(&cloth, 50, 0.01);
            cloth.positions[3 * 77 + i] = cloth.positions[3 * 1000 + i] = bad[i];
            ck_assert_int_eq(SetBuffer(&cloth), qc_statusBadInput);
            ck_assert_str_eq(qcLastMessage(), "vertex 77 of body 0 is not finite");
            ck_assert_uint_eq(DetectBoth(&cloth, &def)->pairCount, pairs);
        }
        Close(&cloth);
    }
}
END_TEST

START_TEST(bodies_come_go_and_change_between_the_cpu_and_the_device)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        const qcDetectDef def = LayersDef();
        qcScene* scenes[2] = {cloth.onCpu, cloth.onDevice};
        qcSoup ball = qcSoup_MakeSphere(2, 0.3);
        for (int i = 0; i < 2; i++)
        {
            qcBodyId id;
            qcBodyDef rigid = qcDefaultBodyDef();
            rigid.positions = ball.positions;
            rigid.positionType = qc_positionF64;
            rigid.vertexCount = ball.vertexCount;
            rigid.indices = ball.indices;
            rigid.triangleCount = ball.triangleCount;
            rigid.transform.translation[0] = 0.5;
            CHECK_OK(qcScene_AddBody(scenes[i], &rigid, &id));
        }
        qcSoup_Free(&ball);
        SetBoth(&cloth);
        ck_assert_int_eq(DetectBoth(&cloth, &def)->profile.method, qc_methodLayers);
        Jiggle(&cloth, 60, 0.004); // to the CPU
        for (int i = 0; i < 2; i++)
            CHECK_OK(qcScene_SetVertices(scenes[i], cloth.ids[i], cloth.positions, qc_positionF32, 0));
        ck_assert_uint_eq(DetectBoth(&cloth, &def)->profile.readBackBytes, 0);
        Jiggle(&cloth, 61, 0.004); // and back
        SetBoth(&cloth);
        ck_assert_uint_gt(DetectBoth(&cloth, &def)->profile.readBackBytes, 0);
        for (int i = 0; i < 2; i++) // another body in its place
        {
            CHECK_OK(qcScene_RemoveBody(scenes[i], cloth.ids[i]));
            AddBody(scenes[i], &cloth, &cloth.ids[i]);
        }
        ck_assert_uint_eq(DetectBoth(&cloth, &def)->profile.readBackBytes, 0);
        SetBoth(&cloth);
        DetectBoth(&cloth, &def);
        Close(&cloth);
    }
}
END_TEST

START_TEST(a_body_without_vertices_takes_a_buffer)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        qcBodyDef empty = qcDefaultBodyDef();
        empty.deforming = true;
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(cloth.onDevice, &empty, &id));
        qcVertexBufferDef def = qcDefaultVertexBufferDef();
        def.buffer = cloth.buffer;
        CHECK_OK(qcScene_SetVertexBuffer(cloth.onDevice, id, &def));
        SetBoth(&cloth);
        const qcDetectDef detect = LayersDef();
        ck_assert_uint_gt(DetectBoth(&cloth, &detect)->pairCount, 10);
        CHECK_OK(qcScene_SetVertexBuffer(cloth.onDevice, id, &def));
        Close(&cloth);
    }
}
END_TEST

START_TEST(vertices_without_a_triangle_do_not_enlarge_the_image)
{
    QC_FOR_EACH_HOST(walk)
    {
        qcSoup soup = MakeCloth();
        uint32_t count = soup.vertexCount;
        soup.positions = realloc(soup.positions, 3 * sizeof(double) * (count + 1));
        soup.vertexCount++;
        for (int axis = 0; axis < 3; axis++)
            soup.positions[3 * (size_t)count + (size_t)axis] = 1e30;
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, soup);
        const qcDetectDef def = LayersDef();
        SetBoth(&cloth);
        const qcResult* result = DetectBoth(&cloth, &def);
        ck_assert_uint_gt(result->pairCount, 10);
        ck_assert_uint_lt(result->profile.listPairs + result->profile.candidates, 100 * (uint64_t)count);
        Close(&cloth);
    }
}
END_TEST

START_TEST(pairs_written_to_a_buffer_are_those_of_the_result)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        const struct qcGlFunctions* gl = &cloth.gl;
        const qcDetectDef def = LayersDef();
        GLuint name;
        qcPairBufferDef to = qcDefaultPairBufferDef();
        to.capacity = 4000;
        gl->GenBuffers(1, &name);
        gl->BindBuffer(GL_COPY_WRITE_BUFFER, name);
        // Where GL has such buffers: one into which only the device writes.
        if (gl->BufferStorage != NULL)
            gl->BufferStorage(GL_COPY_WRITE_BUFFER, 8 + 4 + 20 * 4000, NULL, 0);
        else
            gl->BufferData(GL_COPY_WRITE_BUFFER, 8 + 4 + 20 * 4000, NULL, GL_DYNAMIC_DRAW);
        gl->Finish();
        qcDeviceBufferDef bufferDef = qcDefaultDeviceBufferDef();
        bufferDef.name = name;
        CHECK_OK(qcDevice_OpenBuffer(walk.device, &bufferDef, &to.buffer));
        ck_assert_int_eq(qcScene_WritePairs(cloth.onDevice, &to), qc_statusBadInput); // no result yet
        SetBoth(&cloth);
        const qcResult* result = DetectBoth(&cloth, &def);
        ck_assert_uint_gt(result->pairCount, 10);
        to.offset = 8;
        CHECK_OK(qcScene_WritePairs(cloth.onDevice, &to));
        gl->BindBuffer(GL_COPY_WRITE_BUFFER, name);
        uint32_t count = 0;
        qcPair* pairs = malloc(sizeof(qcPair) * result->pairCount);
        gl->GetBufferSubData(GL_COPY_WRITE_BUFFER, 8, 4, &count);
        gl->GetBufferSubData(GL_COPY_WRITE_BUFFER, 12, (GLsizeiptr)(20 * result->pairCount), pairs);
        ck_assert_uint_eq(count, result->pairCount);
        ck_assert_mem_eq(pairs, result->pairs, sizeof(qcPair) * result->pairCount);
        free(pairs);
        to.offset = 6;
        ck_assert_int_eq(qcScene_WritePairs(cloth.onDevice, &to), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "def->offset is 6; it must be a multiple of 4"));
        to.offset = 8;
        to.capacity = 4001; // more than the buffer has
        ck_assert_int_eq(qcScene_WritePairs(cloth.onDevice, &to), qc_statusBadInput);
        to.capacity = (uint32_t)result->pairCount - 1;
        ck_assert_int_eq(qcScene_WritePairs(cloth.onDevice, &to), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "pairs"));
        qcDeviceBuffer_Close(to.buffer);
        gl->DeleteBuffers(1, &name);
        Close(&cloth);
    }
}
END_TEST

START_TEST(a_reopened_device_has_lost_the_positions_until_they_are_set_anew)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        const qcDetectDef def = LayersDef();
        const qcResult* result;
        SetBoth(&cloth);
        DetectBoth(&cloth, &def);
        CHECK_OK(qcDevice_Reopen(walk.device));
        Jiggle(&cloth, 70, 0.004);
        ck_assert_int_eq(SetBuffer(&cloth), qc_statusDeviceLost); // the buffer is of the former context
        qcDeviceBuffer_Close(cloth.buffer);
        qcDeviceBufferDef bufferDef = qcDefaultDeviceBufferDef();
        bufferDef.name = cloth.name;
        CHECK_OK(qcDevice_OpenBuffer(walk.device, &bufferDef, &cloth.buffer));
        CHECK_OK(qcScene_SetActivity(cloth.onDevice, cloth.ids[1], qc_activitySleeping));
        ck_assert_int_eq(qcScene_Detect(cloth.onDevice, &def, &result), qc_statusDeviceLost);
        ck_assert_int_eq(qcScene_MarkStart(cloth.onDevice), qc_statusDeviceLost);
        ck_assert_int_eq(qcScene_Record(cloth.onDevice, "lost.qcr"), qc_statusDeviceLost);
        CHECK_OK(qcScene_SetActivity(cloth.onDevice, cloth.ids[1], qc_activityMoving));
        SetBoth(&cloth);
        ck_assert_int_eq(DetectBoth(&cloth, &def)->profile.method, qc_methodLayers);
        Close(&cloth);
    }
}
END_TEST

/// Objects of the share group; the library's have the next free names.
static int CountObjects(const qcHost* host)
{
    static const char* const s_names[] = {"glIsBuffer", "glIsTexture", "glIsRenderbuffer", "glIsProgram", "glIsShader"};
    int count = 0;
    for (size_t kind = 0; kind < sizeof s_names / sizeof s_names[0]; kind++)
    {
        PFNGLISBUFFERPROC is = (PFNGLISBUFFERPROC)host->getFunction(s_names[kind]);
        for (GLuint name = 1; name < 2000; name++)
            count += is(name) == GL_TRUE;
    }
    return count;
}

START_TEST(a_closed_device_leaves_nothing_in_the_share_group)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        CHECK_OK(qcDevice_Reopen(walk.device));
        const int before = CountObjects(&walk.host);
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        qcDetectDef def = LayersDef();
        SetBoth(&cloth);
        DetectBoth(&cloth, &def);
        def.method = qc_methodQuick;
        def.resolution = 64;
        const qcResult* result;
        CHECK_OK(qcScene_Detect(cloth.onDevice, &def, &result));
        ck_assert_int_gt(CountObjects(&walk.host), before + 10);
        CHECK_OK(qcDevice_Reopen(walk.device));
        ck_assert_int_eq(CountObjects(&walk.host), before + 1); // the cloth's buffer
        Close(&cloth);
        ck_assert_int_eq(CountObjects(&walk.host), before);
    }
}
END_TEST

START_TEST(a_recording_has_the_positions_of_the_buffer)
{
    char path[64];
    snprintf(path, sizeof path, "buffers.%d.qcr", (int)getpid());
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        const qcDetectDef def = LayersDef();
        CHECK_OK(qcScene_Record(cloth.onDevice, path));
        for (uint64_t step = 0; step < 3; step++)
        {
            Jiggle(&cloth, step, 0.004);
            SetBoth(&cloth);
            ck_assert_uint_gt(DetectBoth(&cloth, &def)->pairCount, 10);
        }
        CHECK_OK(qcScene_Record(cloth.onDevice, NULL));
        Replay replay = ReplayFile(path, NULL, qc_methodSweep, 1);
        ck_assert_uint_eq(replay.detections, 3);
        // The body, and its positions before each detection.
        ck_assert_uint_eq(replay.operations, 1 + 2 * 3);
        Close(&cloth);
        remove(path);
    }
}
END_TEST

/// Opens the host's buffer once more, and takes the positions of a new body from it in steps that read them on the
/// device and on the CPU. The first status that is not ok.
static qcStatus UseBuffer(const Cloth* cloth, qcDevice* device, size_t* pairs)
{
    qcDeviceBufferDef bufferDef = qcDefaultDeviceBufferDef();
    bufferDef.name = cloth->name;
    qcVertexBufferDef vertices = qcDefaultVertexBufferDef();
    qcStatus status = qcDevice_OpenBuffer(device, &bufferDef, &vertices.buffer);
    vertices.offset = t_offset;
    vertices.stride = t_stride;
    qcBodyDef body = qcDefaultBodyDef();
    body.vertexCount = cloth->soup.vertexCount;
    float* flat = calloc(body.vertexCount, 3 * sizeof *flat);
    body.positions = flat;
    body.indices = cloth->soup.indices;
    body.triangleCount = cloth->soup.triangleCount;
    body.deforming = true;
    qcBodyId id = {0};
    qcSceneDef sceneDef = qcDefaultSceneDef();
    sceneDef.device = device;
    qcScene* scene = NULL;
    status = status == qc_statusOk ? qcScene_Create(&sceneDef, &scene) : status;
    status = status == qc_statusOk ? qcScene_AddBody(scene, &body, &id) : status;
    status = status == qc_statusOk ? qcScene_SetVertexBuffer(scene, id, &vertices) : status;
    qcDetectDef def = LayersDef();
    def.threads = 1;
    for (int way = 0; way < 2 && status == qc_statusOk; way++)
    {
        const qcResult* result;
        def.method = way == 0 ? qc_methodLayers : qc_methodSweep;
        status = qcScene_Detect(scene, &def, &result);
        *pairs = status == qc_statusOk ? result->pairCount : *pairs;
    }
    free(flat);
    qcScene_Destroy(scene);
    if (vertices.buffer != NULL)
        qcDeviceBuffer_Close(vertices.buffer);
    return status;
}

START_TEST(each_failed_allocation_with_a_buffer_is_a_status_and_leaks_nothing)
{
    // Where the cache of programs has no memory, the programs are compiled, and the call succeeds.
    ck_assert_int_eq(setenv("QC_PROGRAM_CACHE", "off", 1), 0);
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, qcSoup_MakeFoldedCloth(5, 12, 0.02, 0.03));
        for (uint32_t v = 0; v < cloth.soup.vertexCount; v++)
            cloth.gl.BufferSubData(GL_ARRAY_BUFFER, t_offset + t_stride * (GLintptr)v, 3 * sizeof(float),
                                   cloth.positions + 3 * (size_t)v);
        cloth.gl.Finish();
        size_t expected = 0, live = heap.live;
        heap.calls = 0;
        CHECK_OK(UseBuffer(&cloth, walk.device, &expected));
        ck_assert_uint_gt(expected, 10);
        for (size_t call = 1, calls = heap.calls; call <= calls; call++)
        {
            size_t pairs = expected;
            heap = (qcFailingHeap){live, 0, call};
            ck_assert_int_eq(UseBuffer(&cloth, walk.device, &pairs), qc_statusOutOfMemory);
            ck_assert_ptr_nonnull(strstr(qcLastMessage(), "out of memory"));
            ck_assert_uint_eq(pairs, expected);
            ck_assert_uint_eq(heap.live, live);
        }
        heap.failAt = 0;
        Close(&cloth);
    }
    ck_assert_uint_eq(heap.live, 0);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

START_TEST(a_mistake_is_named)
{
    QC_FOR_EACH_HOST(walk)
    {
        Cloth cloth;
        Open(&cloth, &walk.host, walk.device, MakeCloth());
        qcVertexBufferDef good = qcDefaultVertexBufferDef();
        good.buffer = cloth.buffer;
        const struct
        {
            uint32_t stride;
            uint64_t offset;
            void* fence;
            const char* message;
        } cases[] = {
            {8, 0, NULL, "stride"},
            {14, 0, NULL, "stride"},
            {0, 2, NULL, "offset"},
            {0, 1u << 30, NULL, "buffer's"},
            {0, UINT64_MAX - 3, NULL, "buffer's"},
            {1u << 20, 0, NULL, "buffer's"},
            {0, 0, &good, "fence"},
        };
        for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        {
            qcVertexBufferDef def = good;
            def.stride = cases[i].stride;
            def.offset = cases[i].offset;
            def.fence = cases[i].fence;
            ck_assert_int_eq(qcScene_SetVertexBuffer(cloth.onDevice, cloth.ids[1], &def), qc_statusBadInput);
            ck_assert_msg(strstr(qcLastMessage(), cases[i].message) != NULL, "%s", qcLastMessage());
        }
        // A rigid body.
        qcBodyDef rigid = qcBodyDefOf(&cloth.soup);
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(cloth.onDevice, &rigid, &id));
        ck_assert_int_eq(qcScene_SetVertexBuffer(cloth.onDevice, id, &good), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "body 1 is rigid"));
        ck_assert_int_eq(qcScene_SetVertexBuffer(cloth.onDevice, (qcBodyId){7, 1}, &good), qc_statusBadInput);
        // Another device's, and none.
        ck_assert_int_eq(qcScene_SetVertexBuffer(cloth.onCpu, cloth.ids[0], &good), qc_statusBadInput);
        good.buffer = NULL;
        ck_assert_int_eq(qcScene_SetVertexBuffer(cloth.onDevice, cloth.ids[1], &good), qc_statusBadInput);
        qcDeviceBufferDef def = qcDefaultDeviceBufferDef();
        qcDeviceBuffer* buffer;
        ck_assert_int_eq(qcDevice_OpenBuffer(walk.device, &def, &buffer), qc_statusBadInput);
        def.name = 12345;
        ck_assert_int_eq(qcDevice_OpenBuffer(walk.device, &def, &buffer), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "12345"));
        def.name = 0;
        def.memoryFd = 987;
        def.memorySize = 4096;
        ck_assert_int_ne(qcDevice_OpenBuffer(walk.device, &def, &buffer), qc_statusOk);
        Close(&cloth);
    }
}
END_TEST

START_TEST(a_context_that_cannot_be_shared_is_refused_by_name)
{
    int context = 0;
    qcDevice* device = NULL;
    const struct
    {
        qcDeviceKind kind;
        void *context, *display;
        const char* message;
    } cases[] = {
        {qc_deviceAuto, NULL, &context, "without def->shareContext"},
        {qc_deviceNone, &context, NULL, "none shares"},
        {qc_deviceEgl, &context, NULL, "needs def->shareDisplay"},
        {qc_deviceSurfaceless, &context, NULL, "needs def->shareDisplay"},
        {qc_deviceOsmesa, &context, &context, "osmesa shares no"},
        {qc_deviceEgl, &context, &context, "def->shareContext has a GPU"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
    {
        qcDeviceDef def = qcDefaultDeviceDef();
        def.kind = cases[i].kind;
        def.shareContext = cases[i].context;
        def.shareDisplay = cases[i].display;
        def.gpuIndex = i == sizeof cases / sizeof cases[0] - 1 ? 0 : -1;
        ck_assert_int_eq(qcDevice_Create(&def, &device), qc_statusBadInput);
        ck_assert_msg(strstr(qcLastMessage(), cases[i].message) != NULL, "%s", qcLastMessage());
    }
    qcHost host;
    if (!qcHost_Open(&host, qc_deviceSurfaceless))
        return;
    qcDeviceDef def = qcDefaultDeviceDef();
    def.shareDisplay = host.display;
    def.shareContext = &context; // no context of this display
    ck_assert_int_eq(qcDevice_Create(&def, &device), qc_statusDevice);
    ck_assert_msg(strstr(qcLastMessage(), "shareContext") != NULL, "%s", qcLastMessage());
    // A device that shares nothing takes no names of the host's.
    def = qcDefaultDeviceDef();
    def.kind = qc_deviceSurfaceless;
    CHECK_OK(qcDevice_Create(&def, &device));
    qcDeviceBufferDef bufferDef = qcDefaultDeviceBufferDef();
    qcDeviceBuffer* buffer;
    bufferDef.name = 1;
    ck_assert_int_eq(qcDevice_OpenBuffer(device, &bufferDef, &buffer), qc_statusBadInput);
    ck_assert_msg(strstr(qcLastMessage(), "shares no context") != NULL, "%s", qcLastMessage());
    qcDevice_Destroy(device);
    qcHost_Close(&host);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES(
    "vertex buffers", a_buffer_gives_the_pairs_of_the_same_floats_and_no_vertex_is_uploaded,
    segments_and_proximities_have_the_bits_of_the_cpus, steps_that_need_all_positions_read_them_back_once,
    a_motion_is_that_of_the_cpu, a_cloth_of_denormal_floats_loses_no_pair,
    a_position_that_is_not_finite_is_refused_and_changes_nothing,
    bodies_come_go_and_change_between_the_cpu_and_the_device, vertices_without_a_triangle_do_not_enlarge_the_image,
    pairs_written_to_a_buffer_are_those_of_the_result, a_recording_has_the_positions_of_the_buffer,
    each_failed_allocation_with_a_buffer_is_a_status_and_leaks_nothing, a_body_without_vertices_takes_a_buffer,
    a_reopened_device_has_lost_the_positions_until_they_are_set_anew, a_closed_device_leaves_nothing_in_the_share_group,
    a_mistake_is_named, a_context_that_cannot_be_shared_is_refused_by_name)
