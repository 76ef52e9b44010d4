// Visibility tests: depth only, one occlusion query or one flag for each. Quick-CULLIDE, VR 2005, sections 3.1 and 3.2.
// gl/visibility/tile_schedule.c gives the order of drawing.
#include "gl/visibility/occlusion_queries.h"

#include "gl/device.h"
#include "gl/visibility/conservative_dilation.h"
#include "gl/visibility/fragment_flags.h"
#include "gl/visibility/sure_results.h"
#include "gl/visibility/tile_schedule.h"
#include "gl/gl_functions.h"
#include "base/status.h"

#include <assert.h>
#include <limits.h>
#include <stddef.h>
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

/// How tests get their results. The results are the same.
typedef enum Way
{
    qc_wayDefault, ///< sure results on software devices, else flags
    qc_wayQueries, ///< a query for each test
    qc_wayFlags,   ///< flags stored by fragments; queries where the device can't
    qc_waySure     ///< the same for the tests that geometry leaves open
} Way;

struct qcVisibility
{
    qcDevice* device;
    uint32_t generation; ///< of the device
    uint32_t triangleCount;
    uint32_t resolution, tileSize;
    bool isDilated;
    double dilation[3];
    qcArray corners; ///< of float
    qcArray dilated; ///< of qcDilatedCorner, for one axis
    int dilatedAxis; ///< the axis of those on the device, or -1
    qcTileSchedule schedule;
    GLuint program, vertexArray, vertexBuffer, indexBuffer, framebuffer, depthBuffer;
    bool isSoftware;
    Way way;
    bool storesFlags; ///< and issues no queries
    qcFragmentFlags flags;
    qcSureResults sure;
    qcArray queries; ///< of GLuint
};

// `scale`: 0.9 keeps every depth off the ends of the range, so the cleared depth is behind everything. -0.9: the view
// from the other side, with the same comparison.
static const char* const s_vertexShader =
    "#version 330 core\n"
    "invariant gl_Position;\n"
    "in vec3 position;\n"
    "uniform int axis;\n"
    "uniform float scale;\n"
    "void main()\n"
    "{\n"
    "    gl_Position = vec4(position[(axis + 1) % 3], position[(axis + 2) % 3], scale * position[axis], 1.0);\n"
    "}\n";

// Never discards, but might: without that, an NVIDIA GPU takes blocks of 8 x 8 samples as passed by a coarse depth
// test, and hides what nothing covers (H200, driver 580.159: 107 of 45 691 tests of test_visibility_ways).
static const char* const s_fragmentShader = "#version 330 core\n"
                                            "void main()\n"
                                            "{\n"
                                            "    if (gl_FragCoord.x < -1.0)\n"
                                            "        discard;\n"
                                            "}\n";

// Dilated triangles: each fragment computes its depth from flat values. The error of interpolated ones has no bound
// where a triangle is seen nearly edge-on.
static const char* const s_dilatedVertexShader = "#version 330 core\n"
                                                 "layout(location = 0) in vec4 position;\n"
                                                 "layout(location = 1) in vec4 plane;\n"
                                                 "flat out vec2 range;\n"
                                                 "flat out vec4 face;\n"
                                                 "void main()\n"
                                                 "{\n"
                                                 "    range = position.zw;\n"
                                                 "    face = plane;\n"
                                                 "    gl_Position = vec4(position.xy, 0.0, 1.0);\n"
                                                 "}\n";

// `tile`: first pixel of the tile in the image, then -1 for a triangle's nearest possible depth, 1 for its farthest.
static const char* const s_dilatedFragmentShader =
    "#version 330 core\n"
    "flat in vec2 range;\n"
    "flat in vec4 face;\n"
    "uniform vec3 tile;\n"
    "uniform float scale;\n"
    "void main()\n"
    "{\n"
    "    vec2 pixel = gl_FragCoord.xy + tile.xy;\n"
    "    float depth = face.x + face.y * pixel.x + face.z * pixel.y + tile.z * face.w;\n"
    "    gl_FragDepth = 0.5 + 0.5 * scale * clamp(depth, range.x, range.y);\n"
    "}\n";

/// Sets the vertex layout: the caller's corners, uploaded once here, or dilated ones, uploaded for each axis.
static void LayOutVertices(const struct qcGlFunctions* gl, const qcVisibility* v)
{
    gl->EnableVertexAttribArray(0);
    if (!v->isDilated)
    {
        gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(v->corners.count * sizeof(float)), v->corners.data,
                       GL_STATIC_DRAW);
        gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
        return;
    }
    gl->VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(qcDilatedCorner), (void*)offsetof(qcDilatedCorner, x));
    gl->EnableVertexAttribArray(1);
    gl->VertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(qcDilatedCorner), (void*)offsetof(qcDilatedCorner, base));
}

/// GPUs draw faster than the CPU finds what is sure. On software GL nothing is as fast as not drawing.
static bool WantsSureResults(const qcVisibility* v)
{
    return !v->isDilated && (v->way == qc_wayDefault ? v->isSoftware : v->way == qc_waySure);
}

/// On llvmpipe neither way is always quicker for dilated triangles (4096 x 4096, 2 cores): with queries and with flags,
/// six passes of the demo leaves take 3.6 and 4.3 s, one of breaking 3.3 and 2.4 s.
static bool WantsFlags(const qcVisibility* v)
{
    return v->way == qc_wayFlags || (v->way != qc_wayQueries && !(v->isDilated && v->isSoftware));
}

static qcStatus CreateObjects(const struct qcGlFunctions* gl, void* context)
{
    qcVisibility* v = context;
    if (v->isDilated)
        QC_TRY(qcGlFunctions_GetProgram(gl, "dilated visibility", s_dilatedVertexShader, s_dilatedFragmentShader,
                                        &v->program));
    else
        QC_TRY(qcGlFunctions_GetProgram(gl, "visibility", s_vertexShader, s_fragmentShader, &v->program));
    v->storesFlags = WantsFlags(v) && qcFragmentFlags_AreSupported(gl);
    if (v->storesFlags)
        QC_TRY(qcFragmentFlags_Create(gl, v->isDilated ? v->tileSize : 0, &v->flags));
    if (v->storesFlags && !v->isDilated)
        qcFragmentFlags_SetCorners(gl, &v->flags, &v->corners, sizeof(float));

    gl->GenBuffers(1, &v->vertexBuffer);
    gl->GenBuffers(1, &v->indexBuffer);
    gl->GenVertexArrays(1, &v->vertexArray);
    gl->BindVertexArray(v->vertexArray);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, v->indexBuffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, v->vertexBuffer);
    LayOutVertices(gl, v);

    GLsizei size = (GLsizei)v->tileSize;
    gl->GenRenderbuffers(1, &v->depthBuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, v->depthBuffer);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, size, size);
    gl->GenFramebuffers(1, &v->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, v->framebuffer);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, v->depthBuffer);
    gl->DrawBuffer(GL_NONE);
    gl->ReadBuffer(GL_NONE); // below GL 4.1 a buffer to read from must exist, or be none
    GLenum complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    if (complete != GL_FRAMEBUFFER_COMPLETE)
        return qcFail(qc_statusDevice, "visibility queries: no depth buffer of %d x %d (0x%x)", size, size, complete);
    return qc_statusOk;
}

static qcStatus DeleteObjects(const struct qcGlFunctions* gl, void* context)
{
    qcVisibility* v = context;
    gl->DeleteQueries((GLsizei)v->queries.count, v->queries.data);
    qcFragmentFlags_Delete(gl, &v->flags);
    gl->DeleteFramebuffers(1, &v->framebuffer);
    gl->DeleteRenderbuffers(1, &v->depthBuffer);
    gl->DeleteVertexArrays(1, &v->vertexArray);
    gl->DeleteBuffers(1, &v->indexBuffer);
    gl->DeleteBuffers(1, &v->vertexBuffer);
    return qc_statusOk;
}

typedef struct PassJob
{
    qcVisibility* visibility;
    const qcVisibilityPass* pass;
    GLint tileUniform; ///< location; dilated triangles only
    uint8_t* visible;
    uint32_t stepCount;
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
    gl->Uniform3fv(job->tileUniform, 1, values);
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

static void DrawTile(const struct qcGlFunctions* gl, PassJob* job, const qcScheduleTile* tile)
{
    const qcVisibility* v = job->visibility;
    // The whole image's viewport, moved: the samples are those of the untiled image.
    gl->Viewport(-(GLint)tile->x, -(GLint)tile->y, (GLsizei)v->resolution, (GLsizei)v->resolution);
    gl->DepthMask(GL_TRUE);
    gl->Clear(GL_DEPTH_BUFFER_BIT);
    if (v->storesFlags)
        qcFragmentFlags_BeginTile(gl, &v->flags);
    if (tile->countedCount > 0)
    {
        gl->DepthFunc(GL_ALWAYS);
        gl->DepthMask(GL_FALSE);
        qcFragmentFlags_Draw(gl, &v->flags, tile->firstPolygon, tile->polygonCount, qc_flagCount);
    }
    const qcScheduleBatch* batch = &QC_AT(qcScheduleBatch, v->schedule.batches, tile->firstBatch);
    for (const qcScheduleBatch* end = batch + tile->batchCount; batch < end; ++batch)
        DrawBatch(gl, job, tile, batch);
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
            job->visible[QC_AT(qcScheduleTest, v->schedule.tests, i).step] = 0;
    }
    job->firstPending = job->endPending;
}

static void UploadDilated(const struct qcGlFunctions* gl, qcVisibility* v, int axis)
{
    if (v->dilatedAxis == axis)
        return;
    if (v->storesFlags)
        qcFragmentFlags_SetCorners(gl, &v->flags, &v->dilated, sizeof(qcDilatedCorner));
    else
    {
        gl->BindBuffer(GL_ARRAY_BUFFER, v->vertexBuffer);
        gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(v->dilated.count * sizeof(qcDilatedCorner)), v->dilated.data,
                       GL_STREAM_DRAW);
    }
    v->dilatedAxis = axis;
}

static qcStatus BeginFlags(const struct qcGlFunctions* gl, PassJob* job, float scale)
{
    qcVisibility* v = job->visibility;
    const qcFlagPass pass = {.polygons = &v->schedule.polygons,
                             .stepCount = job->stepCount,
                             .axis = job->pass->axis,
                             .scale = scale,
                             .greater = job->pass->compare == qc_compareGreater};
    job->tileUniform = v->flags.tileUniform;
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
        // A sliver whose corners are rounded may be drawn far beyond them: never as far as the cleared depth.
        gl->Enable(GL_DEPTH_CLAMP);
        gl->DepthRange(0.0, 0.5);
    }
    gl->BindVertexArray(v->vertexArray);
    if (v->isDilated)
        UploadDilated(gl, v, pass->axis);
    if (v->storesFlags)
        return BeginFlags(gl, job, scale);
    gl->UseProgram(v->program);
    gl->Uniform1f(gl->GetUniformLocation(v->program, "scale"), scale);
    if (v->isDilated)
        job->tileUniform = gl->GetUniformLocation(v->program, "tile");
    else
        gl->Uniform1i(gl->GetUniformLocation(v->program, "axis"), pass->axis);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(schedule->indices.count * sizeof(uint32_t)),
                   schedule->indices.data, GL_STREAM_DRAW);
    return qc_statusOk;
}

static qcStatus DrawPass(const struct qcGlFunctions* gl, void* context)
{
    PassJob* job = context;
    qcVisibility* v = job->visibility;
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
        qcFragmentFlags_Read(gl, &v->flags, job->visible);
    else
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
static Way ChooseWay(void)
{
    static const char* const names[] = {[qc_wayQueries] = "queries", [qc_wayFlags] = "flags", [qc_waySure] = "sure"};
    const char* choice = getenv("QC_VISIBILITY");
    for (int way = qc_wayQueries; choice != NULL && way <= qc_waySure; ++way)
        if (strcmp(choice, names[way]) == 0)
            return (Way)way;
    return qc_wayDefault;
}

qcStatus qcVisibility_Create(const qcVisibilityDef* def, qcVisibility** visibility)
{
    qcDeviceInfo info;
    QC_TRY(qcDevice_GetInfo(def->device, &info));
    QC_TRY(CheckDef(def, &info));
    qcVisibility* v = qcAllocateZeroed(sizeof *v);
    if (v == NULL)
        return qcFailMemory(sizeof *v, "visibility queries");
    uint32_t defaultSize = info.software ? qc_softwareTileSize : def->resolution;
    uint32_t tileSize = def->tileSize != 0 ? def->tileSize : defaultSize;
    if (def->dilated && tileSize > qc_maxDilatedTileSize)
        tileSize = qc_maxDilatedTileSize;
    v->device = def->device;
    v->generation = qcDevice_GetGeneration(def->device);
    v->triangleCount = def->triangleCount;
    v->resolution = def->resolution;
    v->tileSize = tileSize < def->resolution ? tileSize : def->resolution;
    v->isDilated = def->dilated;
    v->dilatedAxis = -1;
    v->isSoftware = info.software;
    v->way = ChooseWay();
    memcpy(v->dilation, def->dilation, sizeof v->dilation);
    size_t floatCount = (size_t)9 * def->triangleCount;
    qcStatus status = qcArray_Resize(&v->corners, floatCount, sizeof(float), "triangles of visibility queries");
    if (status == qc_statusOk)
    {
        if (floatCount > 0)
            memcpy(v->corners.data, def->corners, floatCount * sizeof(float));
        status = qcDevice_RunIn(def->device, v->generation, CreateObjects, v, "visibility queries, upload");
    }
    if (status != qc_statusOk)
    {
        qcVisibility_Destroy(v);
        return status;
    }
    *visibility = v;
    return qc_statusOk;
}

void qcVisibility_Destroy(qcVisibility* v)
{
    if (v == NULL)
        return;
    // Called after failures too: the message of the first failure stays.
    char message[512];
    snprintf(message, sizeof message, "%s", qcLastMessage());
    if (qcDevice_RunIn(v->device, v->generation, DeleteObjects, v, "visibility queries, release") != qc_statusOk)
        qcFail(qc_statusDevice, "%s", message);
    qcArray_Free(&v->corners);
    qcArray_Free(&v->dilated);
    qcArray_Free(&v->queries);
    qcFragmentFlags_Free(&v->flags);
    qcSureResults_Free(&v->sure);
    qcTileSchedule_Free(&v->schedule);
    qcFree(v, sizeof *v);
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
    qcDilation_Apply(&dilation, v->corners.data, v->triangleCount, v->dilated.data);
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
    qcScheduleView view = {.corners = v->corners.data,
                           .resolution = v->resolution,
                           .tileSize = v->tileSize,
                           .axis = pass->axis,
                           .polygonCorners = GetPolygonCorners(v),
                           .counts = v->storesFlags && !v->isDilated};
    if (v->isDilated)
        QC_TRY(Dilate(v, pass->axis, view.dilation));
    if (WantsSureResults(v))
    {
        const qcSureView sure = {v->corners.data, v->resolution, pass->axis, pass->fromBack};
        QC_TRY(qcSureResults_Find(&v->sure, &sure, steps, stepCount, visible));
        QC_TRY(qcTileSchedule_Build(&v->schedule, &view, v->sure.steps.data, (uint32_t)v->sure.steps.count));
        qcTileSchedule_Renumber(&v->schedule, v->sure.stepOf.data);
    }
    else
        QC_TRY(qcTileSchedule_Build(&v->schedule, &view, steps, stepCount));
    PassJob job = {.visibility = v, .pass = pass, .visible = visible, .stepCount = stepCount};
    return qcDevice_RunIn(v->device, v->generation, DrawPass, &job, "visibility queries, pass");
}
