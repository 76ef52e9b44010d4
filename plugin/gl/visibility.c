// Visibility queries: depth only, one occlusion query for each test. Quick-CULLIDE, VR 2005, sections 3.1 and 3.2.
// The order of drawing is schedule.c's; this file only draws it.
#include "gl/visibility.h"

#include "gl/device.h"
#include "gl/schedule.h"
#include "gl/table.h"
#include "status.h"

#include <assert.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

enum
{
    // Software rasterisers bin each query into every 64 x 64 block of the framebuffer: 20 000 queries at 4096 x 4096
    // take 1.8 s untiled, 0.35 s in tiles of this size, more in smaller or larger ones (llvmpipe, 2 cores).
    qc_softwareTileSize = 512,
    // llvmpipe counts wrongly (hidden where it is visible) when its 36 MiB of commands run full at a query's begin or
    // end; a test and the render after it take up to 128 KiB of them.
    qc_queriesPerFlush = 128,
    // Bounds the memory in query objects. Reading less often than this is no faster.
    qc_maxPending = 16384
};

struct qcVisibility
{
    qcDevice* device;
    uint32_t triangleCount;
    uint32_t resolution, tileSize;
    qcArray corners; ///< of float
    qcSchedule schedule;
    GLuint program, vertexArray, vertexBuffer, indexBuffer, framebuffer, depthBuffer;
    qcArray queries; ///< of GLuint
};

// 0.9: every depth stays off the ends of the range, so that the cleared depth is behind everything.
static const char* const s_vertexShader =
    "#version 330 core\n"
    "in vec3 position;\n"
    "uniform int axis;\n"
    "void main()\n"
    "{\n"
    "    gl_Position = vec4(position[(axis + 1) % 3], position[(axis + 2) % 3], 0.9 * position[axis], 1.0);\n"
    "}\n";

static const char* const s_fragmentShader = "#version 330 core\n"
                                            "void main()\n"
                                            "{\n"
                                            "}\n";

static qcStatus CreateObjects(const struct qcGlTable* gl, void* context)
{
    qcVisibility* v = context;
    QC_TRY(qcGlTable_GetProgram(gl, "visibility", s_vertexShader, s_fragmentShader, &v->program));

    gl->GenBuffers(1, &v->vertexBuffer);
    gl->GenBuffers(1, &v->indexBuffer);
    gl->GenVertexArrays(1, &v->vertexArray);
    gl->BindVertexArray(v->vertexArray);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, v->indexBuffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, v->vertexBuffer);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(v->corners.count * sizeof(float)), v->corners.data, GL_STATIC_DRAW);
    gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    gl->EnableVertexAttribArray(0);

    GLsizei size = (GLsizei)v->tileSize;
    gl->GenRenderbuffers(1, &v->depthBuffer);
    gl->BindRenderbuffer(GL_RENDERBUFFER, v->depthBuffer);
    gl->RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, size, size);
    gl->GenFramebuffers(1, &v->framebuffer);
    gl->BindFramebuffer(GL_FRAMEBUFFER, v->framebuffer);
    gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, v->depthBuffer);
    gl->DrawBuffer(GL_NONE);
    GLenum complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    if (complete != GL_FRAMEBUFFER_COMPLETE)
        return qcFail(qc_statusDevice, "visibility queries: no depth buffer of %d x %d (0x%x)", size, size, complete);
    return qc_statusOk;
}

static qcStatus DeleteObjects(const struct qcGlTable* gl, void* context)
{
    qcVisibility* v = context;
    gl->DeleteQueries((GLsizei)v->queries.count, v->queries.data);
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
    int axis;
    GLenum compare;
    uint8_t* visible;
    size_t firstPending, endPending; ///< tests that were issued and not read yet
    size_t unflushed;
} PassJob;

static void DrawTriangles(const struct qcGlTable* gl, size_t first, size_t count)
{
    gl->DrawElements(GL_TRIANGLES, (GLsizei)(3 * count), GL_UNSIGNED_INT, (const void*)(first * 3 * sizeof(uint32_t)));
}

static qcStatus GrowQueries(const struct qcGlTable* gl, qcArray* queries, size_t count)
{
    QC_TRY(qcArray_Reserve(queries, count, sizeof(GLuint), "occlusion queries"));
    if (count > queries->count)
    {
        gl->GenQueries((GLsizei)(count - queries->count), &QC_AT(GLuint, *queries, queries->count));
        queries->count = count;
    }
    return qc_statusOk;
}

static void IssueTest(const struct qcGlTable* gl, PassJob* job, const qcScheduleTest* test)
{
    if (++job->unflushed > qc_queriesPerFlush)
    {
        gl->Flush();
        job->unflushed = 1;
    }
    gl->BeginQuery(GL_ANY_SAMPLES_PASSED, QC_AT(GLuint, job->visibility->queries, job->endPending - job->firstPending));
    DrawTriangles(gl, test->firstTriangle, test->triangleCount);
    gl->EndQuery(GL_ANY_SAMPLES_PASSED);
    ++job->endPending;
}

static void DrawTile(const struct qcGlTable* gl, PassJob* job, const qcScheduleTile* tile)
{
    const qcVisibility* v = job->visibility;
    // The whole image's viewport, moved: the samples are those of the untiled image.
    gl->Viewport(-(GLint)tile->x, -(GLint)tile->y, (GLsizei)v->resolution, (GLsizei)v->resolution);
    gl->Clear(GL_DEPTH_BUFFER_BIT);
    const qcScheduleBatch* batch = &QC_AT(qcScheduleBatch, v->schedule.batches, tile->firstBatch);
    for (const qcScheduleBatch* end = batch + tile->batchCount; batch < end; ++batch)
    {
        if (batch->testCount > 0)
        {
            gl->DepthFunc(job->compare);
            gl->DepthMask(GL_FALSE);
            for (size_t i = 0; i < batch->testCount; ++i)
                IssueTest(gl, job, &QC_AT(qcScheduleTest, v->schedule.tests, batch->firstTest + i));
            gl->DepthFunc(GL_LESS);
            gl->DepthMask(GL_TRUE);
        }
        if (batch->triangleCount > 0)
            DrawTriangles(gl, batch->firstTriangle, batch->triangleCount);
    }
}

static void ReadPending(const struct qcGlTable* gl, PassJob* job)
{
    const qcVisibility* v = job->visibility;
    for (size_t i = job->firstPending; i < job->endPending; ++i)
    {
        // A query that can't be read leaves this as it is: hidden is the safe answer.
        GLuint failed = GL_TRUE;
        gl->GetQueryObjectuiv(QC_AT(GLuint, v->queries, i - job->firstPending), GL_QUERY_RESULT, &failed);
        if (failed)
            job->visible[QC_AT(qcScheduleTest, v->schedule.tests, i).step] = 0;
    }
    job->firstPending = job->endPending;
}

static qcStatus DrawPass(const struct qcGlTable* gl, void* context)
{
    PassJob* job = context;
    qcVisibility* v = job->visibility;
    const qcSchedule* schedule = &v->schedule;
    gl->UseProgram(v->program);
    gl->Uniform1i(gl->GetUniformLocation(v->program, "axis"), job->axis);
    gl->BindVertexArray(v->vertexArray);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(schedule->indices.count * sizeof(uint32_t)),
                   schedule->indices.data, GL_STREAM_DRAW);
    gl->BindFramebuffer(GL_FRAMEBUFFER, v->framebuffer);
    gl->Enable(GL_DEPTH_TEST);
    for (size_t i = 0; i < schedule->tiles.count; ++i)
    {
        const qcScheduleTile* tile = &QC_AT(qcScheduleTile, schedule->tiles, i);
        if (tile->testCount == 0)
            continue;
        if (job->endPending - job->firstPending + tile->testCount > qc_maxPending)
            ReadPending(gl, job);
        QC_TRY(GrowQueries(gl, &v->queries, job->endPending - job->firstPending + tile->testCount));
        DrawTile(gl, job, tile);
    }
    ReadPending(gl, job);
    return qc_statusOk;
}

qcStatus qcVisibility_Create(qcDevice* device, const float* corners, uint32_t triangleCount, uint32_t resolution,
                             qcVisibility** visibility)
{
    qcDeviceInfo info;
    QC_TRY(qcDevice_GetInfo(device, &info));
    uint32_t tileSize = info.software ? qc_softwareTileSize : resolution;
    return qcVisibility_CreateTiled(device, corners, triangleCount, resolution, tileSize, visibility);
}

qcStatus qcVisibility_CreateTiled(qcDevice* device, const float* corners, uint32_t triangleCount, uint32_t resolution,
                                  uint32_t tileSize, qcVisibility** visibility)
{
    qcDeviceInfo info;
    QC_TRY(qcDevice_GetInfo(device, &info));
    if (info.kind == qc_deviceNone)
        return qcFail(qc_statusDevice, "visibility queries: the device none has no GL");
    if (resolution == 0 || resolution > info.maxResolution || tileSize == 0)
        return qcFail(qc_statusBadInput, "visibility queries: resolution %u is not in 1..%u, the limit of device %s",
                      resolution, info.maxResolution, info.name);
    // GL counts the corners of a draw in an int.
    if (triangleCount > INT_MAX / 3)
        return qcFail(qc_statusBadInput, "visibility queries: %u triangles are more than %d", triangleCount,
                      INT_MAX / 3);

    qcVisibility* v = qcAllocateZeroed(sizeof *v);
    if (v == NULL)
        return qcFailMemory(sizeof *v, "visibility queries");
    v->device = device;
    v->triangleCount = triangleCount;
    v->resolution = resolution;
    v->tileSize = tileSize < resolution ? tileSize : resolution;
    size_t floatCount = (size_t)9 * triangleCount;
    qcStatus status = qcArray_Resize(&v->corners, floatCount, sizeof(float), "triangles of visibility queries");
    if (status == qc_statusOk)
    {
        if (floatCount > 0)
            memcpy(v->corners.data, corners, floatCount * sizeof(float));
        status = qcDevice_Run(device, CreateObjects, v, "visibility queries, upload");
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
    // It is called after failures too: the message of the first is the one to keep.
    char message[512];
    snprintf(message, sizeof message, "%s", qcLastMessage());
    if (qcDevice_Run(v->device, DeleteObjects, v, "visibility queries, release") != qc_statusOk)
        qcFail(qc_statusDevice, "%s", message);
    qcArray_Free(&v->corners);
    qcArray_Free(&v->queries);
    qcSchedule_Free(&v->schedule);
    qcFree(v, sizeof *v);
}

qcStatus qcVisibility_RunPass(qcVisibility* v, int axis, qcVisibilityCompare compare, const qcVisibilityStep* steps,
                              uint32_t stepCount, uint8_t* visible)
{
    assert(axis >= 0 && axis < 3);
    for (uint32_t i = 0; i < stepCount; ++i)
    {
        assert(steps[i].firstTriangle <= v->triangleCount &&
               steps[i].triangleCount <= v->triangleCount - steps[i].firstTriangle);
        visible[i] = steps[i].test ? 1 : 0;
    }
    qcScheduleView view = {v->corners.data, v->resolution, v->tileSize, axis};
    QC_TRY(qcSchedule_Build(&v->schedule, &view, steps, stepCount));
    PassJob job = {.visibility = v,
                   .axis = axis,
                   .compare = compare == qc_compareGreater ? GL_GREATER : GL_GEQUAL,
                   .visible = visible};
    return qcDevice_Run(v->device, DrawPass, &job, "visibility queries, pass");
}
