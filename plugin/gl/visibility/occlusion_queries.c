// Visibility tests: depth only, one occlusion query or one flag for each. Quick-CULLIDE, VR 2005, sections 3.1 and 3.2.
// gl/visibility/tile_schedule.c gives the order of drawing.
#include "gl/visibility/occlusion_queries.h"

#include "gl/device.h"
#include "gl/visibility/conservative_dilation.h"
#include "gl/visibility/visibility_objects.h"
#include "base/status.h"

#include <assert.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    // Software rasterisers bin each query into every 64 x 64 block of the framebuffer: 20 000 queries at 4096 x 4096
    // take 1.8 s untiled, 0.35 s in tiles of this size, more in smaller or larger tiles (llvmpipe, 2 cores).
    qc_softwareTileSize = 512,
    // GL 4.3 guarantees buffers of 16 MiB for shaders: so many depths of four bytes.
    qc_maxDilatedTileSize = 2048,
    // llvmpipe gives wrong results (hidden instead of visible) when its 36 MiB of commands run full at a query's begin
    // or end. A test and the render after it take up to 128 KiB of them.
    qc_queriesPerFlush = 128,
    // Limits the memory for query objects. Reading less often is no faster.
    qc_maxPending = 16384
};

// A sliver whose corners are rounded may be drawn far beyond them. It is clamped: never as far as the cleared depth, 1.
static const double s_farthestDepth = 0.5;

typedef struct PassJob
{
    qcVisibility* visibility;
    const qcVisibilityPass* pass;
    const qcVisibilityStep* steps;
    uint8_t* visible;
    uint32_t stepCount;
    const uint32_t* stepOf;          ///< of the steps that are scheduled, the step of the pass; null: the same
    uint32_t scheduledCount;         ///< steps
    size_t firstPending, endPending; ///< tests that were issued and are not read yet
    size_t unflushed;
} PassJob;

static uint32_t GetPolygonCorners(const qcVisibility* v)
{
    return v->isDilated ? qc_dilatedCorners : 3;
}

static void DrawPolygons(const struct qcGlFunctions* gl, const qcVisibility* v, size_t first, size_t count)
{
    size_t indexCount = qcTileSchedule_GetIndexCount(GetPolygonCorners(v));
    gl->DrawElements(GL_TRIANGLES, (GLsizei)(indexCount * count), GL_UNSIGNED_INT,
                     (const void*)(first * indexCount * sizeof(uint32_t)));
}

static qcStatus GrowQueries(const struct qcGlFunctions* gl, qcArray* queries, size_t count)
{
    QC_TRY(qcArray_Reserve(queries, count, sizeof(GLuint), "occlusion queries"));
    if (count > queries->count)
    {
        gl->GenQueries((GLsizei)(count - queries->count), &QC_AT(GLuint, *queries, queries->count));
        queries->count = count;
    }
    return qc_statusOk;
}

static void IssueTest(const struct qcGlFunctions* gl, PassJob* job, const qcScheduleTest* test)
{
    if (++job->unflushed > qc_queriesPerFlush)
    {
        gl->Flush();
        job->unflushed = 1;
    }
    gl->BeginQuery(GL_ANY_SAMPLES_PASSED, QC_AT(GLuint, job->visibility->queries, job->endPending - job->firstPending));
    DrawPolygons(gl, job->visibility, test->firstPolygon, test->polygonCount);
    gl->EndQuery(GL_ANY_SAMPLES_PASSED);
    ++job->endPending;
}

/// Selects the depth of dilated triangles: the nearest to the eye to hide others, the farthest from it to be tested.
static void SelectDepth(const struct qcGlFunctions* gl, const PassJob* job, const qcScheduleTile* tile, bool test)
{
    if (!job->visibility->isDilated)
        return;
    const float values[3] = {(float)tile->x, (float)tile->y, test == job->pass->fromBack ? -1.0f : 1.0f};
    gl->Uniform3fv(job->visibility->tileUniform, 1, values);
}

static void DrawTests(const struct qcGlFunctions* gl, PassJob* job, const qcScheduleBatch* batch)
{
    const qcVisibility* v = job->visibility;
    if (v->storesFlags)
        qcFragmentFlags_Draw(gl, &v->flags, batch->firstTested, batch->testedCount, qc_flagTest);
    for (size_t i = 0; !v->storesFlags && i < batch->testCount; ++i)
        IssueTest(gl, job, &QC_AT(qcScheduleTest, v->schedule.tests, batch->firstTest + i));
}

static void DrawRenders(const struct qcGlFunctions* gl, const qcVisibility* v, const qcScheduleBatch* batch)
{
    if (v->storesFlags)
        qcFragmentFlags_Draw(gl, &v->flags, batch->firstPolygon, batch->polygonCount, qc_flagRender);
    else
        DrawPolygons(gl, v, batch->firstPolygon, batch->polygonCount);
}

static void DrawBatch(const struct qcGlFunctions* gl, PassJob* job, const qcScheduleTile* tile,
                      const qcScheduleBatch* batch)
{
    bool greater = job->pass->compare == qc_compareGreater;
    if (batch->testCount > 0)
    {
        gl->DepthFunc(greater ? GL_GREATER : GL_GEQUAL);
        gl->DepthMask(GL_FALSE);
        SelectDepth(gl, job, tile, true);
        DrawTests(gl, job, batch);
    }
    if (batch->polygonCount > 0)
    {
        // The opposite of the test: what passes is not hidden. At equal depth nothing changes.
        gl->DepthFunc(greater ? GL_LEQUAL : GL_LESS);
        gl->DepthMask(GL_TRUE);
        SelectDepth(gl, job, tile, false);
        DrawRenders(gl, job->visibility, batch);
    }
}

/// Clears the depths of a tile and counts the fragments of what is counted.
static void BeginTile(const struct qcGlFunctions* gl, const qcVisibility* v, const qcScheduleTile* tile)
{
    gl->DepthFunc(GL_ALWAYS);
    gl->DepthMask(GL_TRUE);
    if (v->computesSure)
    {
        // What is not sure covers little of a large image: only its samples are cleared. On an H200 that takes 0.1 to
        // 0.4 ms, counting included, and clearing the image 1.2 ms (bench accuracy, cloth-20k, 4096 x 4096).
        gl->DepthRange(1.0, 1.0);
        qcFragmentFlags_Draw(gl, &v->flags, tile->firstPolygon, tile->polygonCount, qc_flagCount);
        gl->DepthRange(0.0, s_farthestDepth);
        return;
    }
    gl->Clear(GL_DEPTH_BUFFER_BIT);
    if (v->storesFlags)
        qcFragmentFlags_BeginTile(gl, &v->flags);
    gl->DepthMask(GL_FALSE);
    if (tile->countedCount > 0)
        qcFragmentFlags_Draw(gl, &v->flags, tile->firstPolygon, tile->polygonCount, qc_flagCount);
}

static void DrawTile(const struct qcGlFunctions* gl, PassJob* job, const qcScheduleTile* tile)
{
    const qcVisibility* v = job->visibility;
    // The whole image's viewport, moved: the samples are those of the untiled image.
    gl->Viewport(-(GLint)tile->x, -(GLint)tile->y, (GLsizei)v->resolution, (GLsizei)v->resolution);
    BeginTile(gl, v, tile);
    const qcScheduleBatch* batch = &QC_AT(qcScheduleBatch, v->schedule.batches, tile->firstBatch);
    for (const qcScheduleBatch* end = batch + tile->batchCount; batch < end; ++batch)
        DrawBatch(gl, job, tile, batch);
}

/// The step of the pass that a scheduled step is a part of.
static uint32_t StepOf(const PassJob* job, uint32_t scheduled)
{
    return job->stepOf != NULL ? job->stepOf[scheduled] : scheduled;
}

static void ReadPending(const struct qcGlFunctions* gl, PassJob* job)
{
    const qcVisibility* v = job->visibility;
    for (size_t i = job->firstPending; i < job->endPending; ++i)
    {
        // A query that can't be read leaves this value: hidden is the conservative result.
        GLuint failed = GL_TRUE;
        gl->GetQueryObjectuiv(QC_AT(GLuint, v->queries, i - job->firstPending), GL_QUERY_RESULT, &failed);
        if (failed)
            job->visible[StepOf(job, QC_AT(qcScheduleTest, v->schedule.tests, i).step)] = 0;
    }
    job->firstPending = job->endPending;
}

static qcStatus ReadFlags(const struct qcGlFunctions* gl, const PassJob* job)
{
    qcFragmentFlags* flags = &job->visibility->flags;
    QC_TRY(qcFragmentFlags_Read(gl, flags));
    for (uint32_t i = 0; i < job->scheduledCount; ++i)
        if (QC_AT(uint32_t, flags->flags, i) != 0)
            job->visible[StepOf(job, i)] = 0;
    return qc_statusOk;
}

static qcStatus BeginFlags(const struct qcGlFunctions* gl, PassJob* job, float scale)
{
    qcVisibility* v = job->visibility;
    const qcFlagPass pass = {.polygons = &v->schedule.polygons,
                             .stepCount = job->scheduledCount,
                             .axis = job->pass->axis,
                             .scale = scale,
                             .greater = job->pass->compare == qc_compareGreater};
    return qcFragmentFlags_BeginPass(gl, &v->flags, &pass);
}

/// Prepares the programs and the vertices of a pass.
static qcStatus BeginPass(const struct qcGlFunctions* gl, PassJob* job)
{
    qcVisibility* v = job->visibility;
    const qcVisibilityPass* pass = job->pass;
    const qcTileSchedule* schedule = &v->schedule;
    float scale = pass->fromBack ? -0.9f : 0.9f;
    gl->BindFramebuffer(GL_FRAMEBUFFER, v->framebuffer);
    gl->Enable(GL_DEPTH_TEST);
    if (!v->isDilated)
    {
        gl->Enable(GL_DEPTH_CLAMP);
        gl->DepthRange(0.0, s_farthestDepth);
    }
    gl->BindVertexArray(v->vertexArray);
    qcVisibilityObjects_Upload(gl, v, pass->axis);
    if (v->storesFlags)
        return BeginFlags(gl, job, scale);
    gl->UseProgram(v->program);
    gl->Uniform1f(v->scaleUniform, scale);
    if (!v->isDilated)
        gl->Uniform1i(v->axisUniform, pass->axis);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(schedule->indices.count * sizeof(uint32_t)),
                   schedule->indices.data, GL_STREAM_DRAW);
    return qc_statusOk;
}

static qcScheduleView ViewOf(const qcVisibility* v, int axis)
{
    return (qcScheduleView){.corners = v->corners,
                            .resolution = v->resolution,
                            .tileSize = v->tileSize,
                            .axis = axis,
                            .polygonCorners = GetPolygonCorners(v),
                            .counts = v->storesFlags && !v->isDilated};
}

static qcStatus ScheduleAll(PassJob* job, const qcScheduleView* view)
{
    job->stepOf = NULL;
    job->scheduledCount = job->stepCount;
    return qcTileSchedule_Build(&job->visibility->schedule, view, job->steps, job->stepCount);
}

/// Schedules what is not sure.
static qcStatus ScheduleOpen(PassJob* job, const qcScheduleView* view)
{
    qcVisibility* v = job->visibility;
    job->stepOf = v->sure.stepOf.data;
    job->scheduledCount = (uint32_t)v->sure.steps.count;
    return qcTileSchedule_Build(&v->schedule, view, v->sure.steps.data, job->scheduledCount);
}

/// Schedules what the device doesn't find sure.
static qcStatus ScheduleComputed(const struct qcGlFunctions* gl, PassJob* job)
{
    qcVisibility* v = job->visibility;
    const qcVisibilityPass* pass = job->pass;
    const qcSureView sure = {v->corners, v->resolution, pass->axis, pass->fromBack};
    const qcScheduleView view = ViewOf(v, pass->axis);
    const uint32_t* found = NULL;
    qcVisibilityObjects_Upload(gl, v, pass->axis);
    QC_TRY(qcSureKernels_Find(gl, &v->kernels, &sure, v->flags.cornerBuffer, job->steps, job->stepCount, &found));
    if (found == NULL)
        return ScheduleAll(job, &view);
    v->sure.counts = true;
    QC_TRY(qcSureResults_Take(&v->sure, job->steps, job->stepCount, found, job->visible));
    return ScheduleOpen(job, &view);
}

static qcStatus DrawPass(const struct qcGlFunctions* gl, void* context)
{
    PassJob* job = context;
    qcVisibility* v = job->visibility;
    if (v->computesSure)
        QC_TRY(ScheduleComputed(gl, job));
    if (v->schedule.tiles.count == 0)
        return qc_statusOk;
    QC_TRY(BeginPass(gl, job));
    for (size_t i = 0; i < v->schedule.tiles.count; ++i)
    {
        const qcScheduleTile* tile = &QC_AT(qcScheduleTile, v->schedule.tiles, i);
        if (tile->testCount == 0 && tile->countedCount == 0)
            continue;
        if (!v->storesFlags)
        {
            if (job->endPending - job->firstPending + tile->testCount > qc_maxPending)
                ReadPending(gl, job);
            QC_TRY(GrowQueries(gl, &v->queries, job->endPending - job->firstPending + tile->testCount));
        }
        DrawTile(gl, job, tile);
    }
    if (v->storesFlags)
        return ReadFlags(gl, job);
    ReadPending(gl, job);
    return qc_statusOk;
}

static qcStatus CheckDef(const qcVisibilityDef* def, const qcDeviceInfo* info)
{
    if (info->kind == qc_deviceNone)
        return qcFail(qc_statusDevice, "visibility queries: the device none has no GL");
    if (def->resolution == 0 || def->resolution > info->maxResolution)
        return qcFail(qc_statusBadInput, "visibility queries: resolution %u is not in 1..%u, the limit of device %s",
                      def->resolution, info->maxResolution, info->name);
    // GL counts the indices of a draw in an int.
    uint32_t max = (uint32_t)(INT_MAX / qcTileSchedule_GetIndexCount(def->dilated ? qc_dilatedCorners : 3));
    if (def->triangleCount > max)
        return qcFail(qc_statusBadInput, "visibility queries: %u triangles are more than %u", def->triangleCount, max);
    return qc_statusOk;
}

/// QC_VISIBILITY chooses, so that tests can compare.
static qcVisibilityWay ChooseWay(void)
{
    static const char* const names[] = {
        [qc_wayQueries] = "queries", [qc_wayFlags] = "flags", [qc_waySure] = "sure", [qc_wayComputed] = "computed"};
    const char* choice = getenv("QC_VISIBILITY");
    for (int way = qc_wayQueries; choice != NULL && way <= qc_wayComputed; ++way)
        if (strcmp(choice, names[way]) == 0)
            return (qcVisibilityWay)way;
    return qc_wayDefault;
}

static uint32_t ChooseTileSize(const qcVisibilityDef* def, const qcDeviceInfo* info)
{
    uint32_t defaultSize = info->software ? qc_softwareTileSize : def->resolution;
    uint32_t tileSize = def->tileSize != 0 ? def->tileSize : defaultSize;
    if (def->dilated && tileSize > qc_maxDilatedTileSize)
        tileSize = qc_maxDilatedTileSize;
    return tileSize < def->resolution ? tileSize : def->resolution;
}

static void SetTriangles(qcVisibility* v, const qcVisibilityDef* def)
{
    v->corners = def->corners;
    v->triangleCount = def->triangleCount;
    memcpy(v->dilation, def->dilation, sizeof v->dilation);
    v->isUploaded = false;
    v->dilatedAxis = -1;
}

static qcStatus Create(const qcVisibilityDef* def, const qcDeviceInfo* info, qcVisibility** visibility)
{
    qcVisibility* v = qcAllocateZeroed(sizeof *v);
    if (v == NULL)
        return qcFailMemory(sizeof *v, "visibility queries");
    v->device = def->device;
    v->generation = qcDevice_GetGeneration(def->device);
    v->isSoftware = info->software;
    v->way = ChooseWay();
    v->resolution = def->resolution;
    v->tileSize = ChooseTileSize(def, info);
    v->isDilated = def->dilated;
    SetTriangles(v, def);
    qcStatus status =
        qcDevice_RunIn(def->device, v->generation, qcVisibilityObjects_Create, v, "visibility queries, creation");
    if (status == qc_statusOk)
        *visibility = v;
    else
        qcVisibility_Destroy(v);
    return status;
}

/// Whether an object made before serves these triangles.
static bool IsReusable(const qcVisibility* v, const qcVisibilityDef* def, const qcDeviceInfo* info)
{
    return v != NULL && v->device == def->device && v->generation == qcDevice_GetGeneration(def->device) &&
           v->resolution == def->resolution && v->tileSize == ChooseTileSize(def, info) &&
           v->isDilated == def->dilated && v->way == ChooseWay() &&
           (!v->storesFlags || def->triangleCount <= v->maxFlagTriangles);
}

qcStatus qcVisibility_Prepare(const qcVisibilityDef* def, qcVisibility** visibility)
{
    qcDeviceInfo info;
    QC_TRY(qcDevice_GetInfo(def->device, &info));
    QC_TRY(CheckDef(def, &info));
    if (IsReusable(*visibility, def, &info))
    {
        SetTriangles(*visibility, def);
        return qc_statusOk;
    }
    qcVisibility_Destroy(*visibility);
    *visibility = NULL;
    return Create(def, &info, visibility);
}

void qcVisibility_Destroy(qcVisibility* v)
{
    if (v == NULL)
        return;
    // Called after failures too: the message of the first failure stays.
    char message[512];
    snprintf(message, sizeof message, "%s", qcLastMessage());
    if (qcDevice_RunIn(v->device, v->generation, qcVisibilityObjects_Delete, v, "visibility queries, release") !=
        qc_statusOk)
        qcFail(qc_statusDevice, "%s", message);
    qcArray_Free(&v->dilated);
    qcArray_Free(&v->queries);
    qcFragmentFlags_Free(&v->flags);
    qcSureKernels_Free(&v->kernels);
    qcSureResults_Free(&v->sure);
    qcTileSchedule_Free(&v->schedule);
    qcFree(v, sizeof *v);
}

typedef struct WorkJob
{
    qcVisibility* visibility;
    qcVisibilityWork* work;
    void* context;
} WorkJob;

static qcStatus RunWork(const struct qcGlFunctions* gl, void* context)
{
    const WorkJob* job = context;
    job->visibility->gl = gl;
    qcStatus status = job->work(job->context);
    job->visibility->gl = NULL;
    return status;
}

qcStatus qcVisibility_Run(qcVisibility* v, qcVisibilityWork* work, void* context)
{
    WorkJob job = {v, work, context};
    return qcDevice_RunIn(v->device, v->generation, RunWork, &job, "visibility queries, passes");
}

/// Dilates the triangles for an axis, unless those on the device are. `pixels`: by which they extend.
static qcStatus Dilate(qcVisibility* v, int axis, float pixels[2])
{
    qcDilation dilation = {.axis = axis, .resolution = v->resolution};
    memcpy(dilation.size, v->dilation, sizeof dilation.size);
    for (int i = 0; i < 2; ++i)
        pixels[i] = (float)qcDilation_InPixels(&dilation, (axis + 1 + i) % 3);
    if (v->dilatedAxis == axis)
        return qc_statusOk;
    size_t count = (size_t)v->triangleCount * qc_dilatedCorners;
    QC_TRY(qcArray_Resize(&v->dilated, count, sizeof(qcDilatedCorner), "dilated triangles"));
    qcDilation_Apply(&dilation, v->corners, v->triangleCount, v->dilated.data);
    return qc_statusOk;
}

qcStatus qcVisibility_RunPass(qcVisibility* v, const qcVisibilityPass* pass, const qcVisibilityStep* steps,
                              uint32_t stepCount, uint8_t* visible)
{
    assert(pass->axis >= 0 && pass->axis < 3);
    for (uint32_t i = 0; i < stepCount; ++i)
    {
        assert(steps[i].firstTriangle <= v->triangleCount &&
               steps[i].triangleCount <= v->triangleCount - steps[i].firstTriangle);
        visible[i] = steps[i].test ? 1 : 0;
    }
    PassJob job = {.visibility = v, .pass = pass, .steps = steps, .visible = visible, .stepCount = stepCount};
    qcScheduleView view = ViewOf(v, pass->axis);
    if (v->isDilated)
        QC_TRY(Dilate(v, pass->axis, view.dilation));
    if (qcVisibilityObjects_WantSure(v))
    {
        const qcSureView sure = {v->corners, v->resolution, pass->axis, pass->fromBack};
        QC_TRY(qcSureResults_Find(&v->sure, &sure, steps, stepCount, visible));
        QC_TRY(ScheduleOpen(&job, &view));
    }
    else if (!v->computesSure)
        QC_TRY(ScheduleAll(&job, &view));
    if (v->gl != NULL)
        return DrawPass(v->gl, &job);
    return qcDevice_RunIn(v->device, v->generation, DrawPass, &job, "visibility queries, pass");
}
