// Pictures of meshes, antialiased, with optional edges and marked triangles. Drawn tile by tile, so that the memory for
// samples doesn't grow with the picture.
#include "base/definition.h"
#include "base/float_mode.h"
#include "base/status.h"
#include "gl/device.h"
#include "gl/picture/check_picture.h"
#include "gl/picture/received_light.h"
#include "gl/programs.h"
#include "picture_shaders.h"

enum
{
    // 2048 x 2048 x 8 samples x (colour + depth) are 256 MiB.
    qc_pictureTileSize = 2048,
    qc_maxSamples = 8
};

typedef struct PictureJob
{
    const qcPictureDef* def;
    qcPictureSpace space;
    qcPictureMeshes meshes;
    qcReceivedLight light;
    uint8_t* rgb;
    GLuint program;
    GLuint framebuffers[2], colors[2], depth; ///< with samples, and without
} PictureJob;

static qcStatus CreateFramebuffers(const struct qcGlFunctions* gl, PictureJob* job, GLsizei width, GLsizei height)
{
    GLint samples = 0;
    gl->GetIntegerv(GL_MAX_SAMPLES, &samples);
    if (samples > qc_maxSamples)
        samples = qc_maxSamples;
    gl->GenFramebuffers(2, job->framebuffers);
    gl->GenRenderbuffers(2, job->colors);
    gl->GenRenderbuffers(1, &job->depth);
    gl->BindRenderbuffer(GL_RENDERBUFFER, job->depth);
    gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, width, height);
    for (int i = 0; i < 2; ++i)
    {
        gl->BindRenderbuffer(GL_RENDERBUFFER, job->colors[i]);
        // sRGB: samples are averaged as light, then encoded.
        gl->RenderbufferStorageMultisample(GL_RENDERBUFFER, i == 0 ? samples : 0, GL_SRGB8_ALPHA8, width, height);
        gl->BindFramebuffer(GL_FRAMEBUFFER, job->framebuffers[i]);
        gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, job->colors[i]);
        if (i == 0)
            gl->FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, job->depth);
        GLenum complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
        if (complete != GL_FRAMEBUFFER_COMPLETE)
            return qcFail(qc_statusDevice, "qcDevice_DrawPicture: no image of %d x %d (0x%x)", width, height, complete);
    }
    return qc_statusOk;
}

static void SetVector(const struct qcGlFunctions* gl, GLuint program, const char* name, const float vector[3])
{
    gl->Uniform3fv(gl->GetUniformLocation(program, name), 1, vector);
}

static void SetInteger(const struct qcGlFunctions* gl, GLuint program, const char* name, GLint value)
{
    gl->Uniform1i(gl->GetUniformLocation(program, name), value);
}

/// Sets the colours of both sides, and the share of the plain colour.
static void SetColors(const struct qcGlFunctions* gl, GLuint program, const float front[3], const float back[3],
                      float glow)
{
    SetVector(gl, program, "front", front);
    SetVector(gl, program, "back", back);
    gl->Uniform1f(gl->GetUniformLocation(program, "glow"), glow);
}

/// Draws the faces of a mesh, or its edges, darker.
static void DrawMesh(const struct qcGlFunctions* gl, GLuint program, const qcPictureMesh* mesh,
                     const qcPictureRange* range, bool edges)
{
    gl->PolygonMode(GL_FRONT_AND_BACK, edges ? GL_LINE : GL_FILL);
    // An offset moves faces back, so that the edges drawn over them are visible. It moves those most that are seen edge
    // on: without edges there is none, or faces behind a silhouette would show through it.
    if (mesh->wireframe && !edges)
        gl->Enable(GL_POLYGON_OFFSET_FILL);
    else
        gl->Disable(GL_POLYGON_OFFSET_FILL);
    SetInteger(gl, program, "edges", edges);
    SetInteger(gl, program, "flatShading", !edges && !mesh->smooth);
    SetColors(gl, program, mesh->color, mesh->backColor, 0.0f);
    qcPictureMeshes_Draw(gl, range, false);
    // 0.5: bright from every side, with enough shading to show the shape.
    SetColors(gl, program, mesh->markColor, mesh->markColor, 0.5f);
    qcPictureMeshes_Draw(gl, range, true);
}

static void DrawGround(const struct qcGlFunctions* gl, const PictureJob* job)
{
    const qcPictureRange* range = &QC_AT(qcPictureRange, job->meshes.ranges, job->def->meshCount);
    SetInteger(gl, job->program, "isGround", 1);
    SetInteger(gl, job->program, "edges", 0);
    SetColors(gl, job->program, job->def->groundColor, job->def->groundColor, 0.0f);
    gl->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    // Behind what lies on it.
    gl->Enable(GL_POLYGON_OFFSET_FILL);
    qcPictureMeshes_Draw(gl, range, false);
    gl->Disable(GL_POLYGON_OFFSET_FILL);
    SetInteger(gl, job->program, "isGround", 0);
}

static void DrawTile(const struct qcGlFunctions* gl, const PictureJob* job, GLint x, GLint y, GLsizei width,
                     GLsizei height)
{
    const qcPictureDef* def = job->def;
    gl->BindFramebuffer(GL_FRAMEBUFFER, job->framebuffers[0]);
    gl->Viewport(-x, -y, (GLsizei)def->width, (GLsizei)def->height);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    const float place[4] = {(float)x, (float)y, 1.0f / (float)def->width, 1.0f / (float)def->height};
    gl->Uniform4fv(gl->GetUniformLocation(job->program, "place"), 1, place);
    for (uint32_t m = 0; m < def->meshCount; ++m)
    {
        const qcPictureMesh* mesh = &def->meshes[m];
        const qcPictureRange* range = &QC_AT(qcPictureRange, job->meshes.ranges, m);
        DrawMesh(gl, job->program, mesh, range, false);
        if (mesh->wireframe)
            DrawMesh(gl, job->program, mesh, range, true);
    }
    DrawGround(gl, job);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, job->framebuffers[1]);
    gl->BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, job->framebuffers[1]);
    gl->ReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, job->rgb + ((size_t)y * def->width + (size_t)x) * 3);
}

/// Sets what all tiles and meshes share.
static void SetUniforms(const struct qcGlFunctions* gl, const PictureJob* job)
{
    const qcPictureSpace* space = &job->space;
    GLuint program = job->program;
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, "clip"), 1, GL_FALSE, space->clip);
    SetVector(gl, program, "up", space->up);
    SetVector(gl, program, "light", space->light);
    SetVector(gl, program, "background", job->def->background);
    SetVector(gl, program, "middle", space->groundMiddle);
    gl->Uniform1f(gl->GetUniformLocation(program, "extent"), space->groundExtent);
    const float* corner = space->tileCorner;
    const float tiles[4] = {corner[0], corner[1], corner[2], space->tileWidth};
    gl->Uniform4fv(gl->GetUniformLocation(program, "tiles"), 1, tiles);
    gl->ActiveTexture(GL_TEXTURE0);
    gl->BindTexture(GL_TEXTURE_2D, job->light.result);
    SetInteger(gl, program, "lights", 0);
    SetInteger(gl, program, "isGround", 0);
}

static qcStatus DrawTiles(const struct qcGlFunctions* gl, PictureJob* job)
{
    const qcPictureDef* def = job->def;
    GLint width = (GLint)def->width, height = (GLint)def->height;
    GLint tileWidth = width < qc_pictureTileSize ? width : qc_pictureTileSize;
    GLint tileHeight = height < qc_pictureTileSize ? height : qc_pictureTileSize;
    QC_TRY(CreateFramebuffers(gl, job, tileWidth, tileHeight));
    QC_TRY(qcGlPrograms_Get(gl, "picture", s_pictureMesh, s_picturePicture, &job->program));
    gl->UseProgram(job->program);
    SetUniforms(gl, job);
    gl->Enable(GL_DEPTH_TEST);
    gl->Enable(GL_FRAMEBUFFER_SRGB);
    // The picture is upside down, which reverses the winding of its triangles.
    gl->FrontFace(GL_CW);
    gl->PolygonOffset(1.0f, 1.0f);
    gl->ClearColor(def->background[0], def->background[1], def->background[2], 1.0f);
    gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl->PixelStorei(GL_PACK_ROW_LENGTH, width);
    for (GLint y = 0; y < height; y += tileHeight)
    {
        for (GLint x = 0; x < width; x += tileWidth)
            DrawTile(gl, job, x, y, width - x < tileWidth ? width - x : tileWidth,
                     height - y < tileHeight ? height - y : tileHeight);
    }
    return qc_statusOk;
}

static qcStatus RunPictureJob(const struct qcGlFunctions* gl, void* context)
{
    PictureJob* job = context;
    qcPictureMeshes_Upload(gl, &job->meshes);
    qcStatus status = qcReceivedLight_Make(gl, job->def, &job->space, &job->meshes, &job->light);
    if (status == qc_statusOk)
        status = DrawTiles(gl, job);
    qcReceivedLight_Delete(gl, &job->light);
    qcPictureMeshes_Delete(gl, &job->meshes);
    gl->DeleteFramebuffers(2, job->framebuffers);
    gl->DeleteRenderbuffers(2, job->colors);
    gl->DeleteRenderbuffers(1, &job->depth);
    return status;
}

__attribute__((noinline)) static qcStatus DrawPicture(qcDevice* device, const qcPictureDef* given, uint8_t* rgb)
{
    if (device == NULL || given == NULL || rgb == NULL)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: %s is null",
                      device == NULL ? "device" : (given == NULL ? "def" : "rgb"));
    qcPictureDef def = qcDefaultPictureDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT("qcDevice_DrawPicture", qcPictureDef, width), &def));
    QC_TRY(qcPicture_Check(&def));
    PictureJob job = {.def = &def, .rgb = rgb};
    QC_TRY(qcPictureSpace_Place(&def, &job.space));
    qcStatus status = qcPictureMeshes_Prepare(&job.meshes, &def, &job.space);
    if (status == qc_statusOk)
        status = qcDevice_Run(device, RunPictureJob, &job, "qcDevice_DrawPicture");
    qcPictureMeshes_Free(&job.meshes);
    return status;
}

qcStatus qcDevice_DrawPicture(qcDevice* device, const qcPictureDef* def, uint8_t* rgb)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = DrawPicture(device, def, rgb);
    qcFloatMode_End(mode);
    return status;
}
