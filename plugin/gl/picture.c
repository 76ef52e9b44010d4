// Pictures of meshes, shaded by a light above the eye and by the sky, antialiased, with optional edges and marked
// triangles. Drawn tile by tile, so that the memory for samples doesn't grow with the picture.
#include "base/definition.h"
#include "base/float_mode.h"
#include "gl/device.h"
#include "gl/gl_functions.h"
#include "base/memory.h"
#include "base/status.h"

#include <limits.h>
#include <math.h>
#include <string.h>

enum
{
    qc_maxPictureSide = 8192,
    // 2048 x 2048 x 8 samples x (colour + depth) are 256 MiB.
    qc_pictureTileSize = 2048,
    qc_maxSamples = 8
};

static const char* const s_vertexShader = "#version 330 core\n"
                                          "in vec3 position;\n"
                                          "in vec3 normal;\n"
                                          "uniform mat4 clip;\n"
                                          "uniform vec3 eye;\n"
                                          "out vec3 fromEye;\n"
                                          "out vec3 smoothNormal;\n"
                                          "void main()\n"
                                          "{\n"
                                          "    fromEye = position - eye;\n"
                                          "    smoothNormal = normal;\n"
                                          "    gl_Position = clip * vec4(position, 1.0);\n"
                                          "}\n";

static const char* const s_fragmentShader =
    "#version 330 core\n"
    "in vec3 fromEye;\n"
    "in vec3 smoothNormal;\n"
    "uniform vec3 up;\n"
    "uniform vec3 front;\n"
    "uniform vec3 back;\n"
    "uniform bool flatShading;\n"
    "uniform bool edges;\n"
    "uniform float glow;\n" // 0: shaded; 1: the plain colour
    "out vec4 color;\n"
    "void main()\n"
    "{\n"
    "    vec3 base = gl_FrontFacing ? front : back;\n"
    "    vec3 toEye = -normalize(fromEye);\n"
    "    vec3 facet = cross(dFdx(fromEye), dFdy(fromEye));\n" // undefined for edges
    "    facet = !edges && dot(facet, facet) > 0.0 ? normalize(facet) : toEye;\n"
    "    facet = dot(facet, toEye) < 0.0 ? -facet : facet;\n"
    "    bool usesFacet = flatShading || dot(smoothNormal, smoothNormal) < 1e-6;\n"
    "    vec3 n = usesFacet ? facet : normalize(smoothNormal);\n"
    "    n = dot(n, facet) < 0.0 ? -n : n;\n"
    "    vec3 light = normalize(toEye + 0.8 * up - 0.5 * cross(up, toEye));\n"
    "    float sky = 0.5 + 0.5 * dot(n, up);\n"
    "    float diffuse = max(dot(n, light), 0.0);\n"
    "    float shine = pow(max(dot(n, normalize(light + toEye)), 0.0), 40.0);\n"
    "    vec3 shaded = (0.10 + 0.22 * sky + 0.78 * diffuse) * base + 0.05 * shine;\n"
    "    color = vec4((edges ? 0.3 : 1.0) * mix(shaded, base, glow), 1.0);\n"
    "}\n";

typedef struct Camera
{
    float clip[16]; ///< column by column
    float up[3];    ///< across the line of sight
} Camera;

/// A mesh for upload.
typedef struct Upload
{
    qcArray vertices; ///< position and normal, six floats
    qcArray indices;  ///< plain triangles first, then marked ones
    uint32_t plainCount;
    GLuint vertexArray, vertexBuffer, indexBuffer;
} Upload;

typedef struct PictureJob
{
    const qcPictureDef* def;
    Camera camera;
    qcArray uploads;
    uint8_t* rgb;
    GLuint program;
    GLuint framebuffers[2], colors[2], depth; ///< with samples, and without
} PictureJob;

static float Dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void Cross(const float a[3], const float b[3], float result[3])
{
    result[0] = a[1] * b[2] - a[2] * b[1];
    result[1] = a[2] * b[0] - a[0] * b[2];
    result[2] = a[0] * b[1] - a[1] * b[0];
}

static bool Normalize(float v[3])
{
    float length = sqrtf(Dot(v, v));
    if (!(length > 0.0f) || !isfinite(length))
        return false;
    for (int i = 0; i < 3; ++i)
        v[i] /= length;
    return true;
}

static bool AreFinite(const float* values, size_t count)
{
    for (size_t i = 0; i < count; ++i)
    {
        if (!isfinite(values[i]))
            return false;
    }
    return true;
}

static bool IsColor(const float color[3])
{
    for (int i = 0; i < 3; ++i)
    {
        if (!(color[i] >= 0.0f && color[i] <= 1.0f))
            return false;
    }
    return true;
}

static qcStatus CheckMesh(const qcPictureMesh* mesh, uint32_t m)
{
    if ((mesh->positions == NULL && mesh->vertexCount > 0) || (mesh->indices == NULL && mesh->triangleCount > 0))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: %s of mesh %u is null",
                      mesh->positions == NULL && mesh->vertexCount > 0 ? "positions" : "indices", m);
    if (mesh->triangleCount > INT_MAX / 3)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: mesh %u has %u triangles, more than %d", m,
                      mesh->triangleCount, INT_MAX / 3);
    for (size_t i = 0; i < mesh->vertexCount; ++i)
    {
        if (!AreFinite(mesh->positions + 3 * i, 3))
            return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: vertex %zu of mesh %u is not finite", i, m);
    }
    for (size_t i = 0; i < (size_t)3 * mesh->triangleCount; ++i)
    {
        if (mesh->indices[i] >= mesh->vertexCount)
            return qcFail(qc_statusBadInput,
                          "qcDevice_DrawPicture: index %zu of mesh %u is %u, but the mesh has %u vertices", i, m,
                          mesh->indices[i], mesh->vertexCount);
    }
    if (!IsColor(mesh->color) || !IsColor(mesh->backColor) || !IsColor(mesh->markColor))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: a colour of mesh %u is not in 0..1", m);
    return qc_statusOk;
}

static qcStatus CheckDef(const qcPictureDef* def)
{
    if (def->width == 0 || def->width > qc_maxPictureSide || def->height == 0 || def->height > qc_maxPictureSide)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: %u x %u pixels are not in 1..%d", def->width,
                      def->height, qc_maxPictureSide);
    if (!AreFinite(def->eye, 3) || !AreFinite(def->target, 3) || !AreFinite(def->up, 3))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: eye, target or up is not finite");
    if (!(def->fieldOfView > 0.0f && def->fieldOfView < 180.0f))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: a field of view of %g degrees is not between 0 and 180",
                      (double)def->fieldOfView);
    if (!IsColor(def->background))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: the background is not in 0..1");
    if (def->meshes == NULL && def->meshCount > 0)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: meshes is null");
    for (uint32_t m = 0; m < def->meshCount; ++m)
        QC_TRY(CheckMesh(&def->meshes[m], m));
    return qc_statusOk;
}

/// Distances along the line of sight that bound all visible vertices.
static void FindDepths(const qcPictureDef* def, const float forward[3], float* nearest, float* farthest)
{
    float low = INFINITY, high = 0.0f;
    for (uint32_t m = 0; m < def->meshCount; ++m)
    {
        const qcPictureMesh* mesh = &def->meshes[m];
        for (size_t i = 0; i < mesh->vertexCount; ++i)
        {
            const float* p = mesh->positions + 3 * i;
            const float fromEye[3] = {p[0] - def->eye[0], p[1] - def->eye[1], p[2] - def->eye[2]};
            float depth = Dot(fromEye, forward);
            low = depth < low ? depth : low;
            high = depth > high ? depth : high;
        }
    }
    *farthest = high > 0.0f && isfinite(high) ? 1.01f * high : 1.0f;
    // 1/5000: a depth buffer of 24 bits still separates layers at a distance of 1/1000 of the scene.
    float closest = *farthest / 5000.0f;
    *nearest = 0.99f * low > closest && low < high ? 0.99f * low : closest;
}

static qcStatus PlaceCamera(const qcPictureDef* def, Camera* camera)
{
    float forward[3], right[3];
    for (int i = 0; i < 3; ++i)
        forward[i] = def->target[i] - def->eye[i];
    if (!Normalize(forward))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: eye and target are the same point, or too far apart");
    float up[3] = {def->up[0], def->up[1], def->up[2]};
    if (!Normalize(up))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: up has no length");
    Cross(forward, up, right);
    // 1e-4: closer to the line of sight than this, rounding dominates the camera's orientation.
    if (!(Dot(right, right) > 1e-8f))
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: up is along the line of sight");
    Normalize(right);
    Cross(right, forward, camera->up);

    float nearest, farthest;
    FindDepths(def, forward, &nearest, &farthest);
    float fy = 1.0f / tanf(def->fieldOfView * 0.00872664626f);
    float fx = fy * (float)def->height / (float)def->width;
    float a = (farthest + nearest) / (farthest - nearest);
    float b = -2.0f * farthest * nearest / (farthest - nearest);
    for (int i = 0; i < 3; ++i)
    {
        camera->clip[4 * i + 0] = fx * right[i];
        // Upside down: GL reads rows from below, and the picture's first row is the top one.
        camera->clip[4 * i + 1] = -fy * camera->up[i];
        camera->clip[4 * i + 2] = a * forward[i];
        camera->clip[4 * i + 3] = forward[i];
    }
    camera->clip[12] = -fx * Dot(right, def->eye);
    camera->clip[13] = fy * Dot(camera->up, def->eye);
    camera->clip[14] = b - a * Dot(forward, def->eye);
    camera->clip[15] = -Dot(forward, def->eye);
    return qc_statusOk;
}

/// Adds to each vertex the normals of its triangles, weighted by area.
static void AddNormals(const qcPictureMesh* mesh, float* vertices)
{
    for (size_t t = 0; t < mesh->triangleCount; ++t)
    {
        const uint32_t* index = mesh->indices + 3 * t;
        const float* p[3];
        for (int c = 0; c < 3; ++c)
            p[c] = mesh->positions + (size_t)3 * index[c];
        const float ab[3] = {p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
        const float ac[3] = {p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
        float normal[3];
        Cross(ab, ac, normal);
        for (int c = 0; c < 3; ++c)
        {
            for (int i = 0; i < 3; ++i)
                vertices[(size_t)6 * index[c] + 3 + (size_t)i] += normal[i];
        }
    }
    // Unit length: vertices get equal weight in the interpolation.
    for (size_t i = 0; i < mesh->vertexCount; ++i)
    {
        float* normal = vertices + 6 * i + 3;
        if (!Normalize(normal))
            memset(normal, 0, 3 * sizeof(float));
    }
}

static qcStatus PrepareMesh(const qcPictureMesh* mesh, Upload* upload)
{
    QC_TRY(qcArray_Resize(&upload->vertices, (size_t)6 * mesh->vertexCount, sizeof(float), "a picture's vertices"));
    float* vertices = upload->vertices.data;
    for (size_t i = 0; i < mesh->vertexCount; ++i)
    {
        memcpy(vertices + 6 * i, mesh->positions + 3 * i, 3 * sizeof(float));
        memset(vertices + 6 * i + 3, 0, 3 * sizeof(float));
    }
    if (mesh->smooth || mesh->wireframe)
        AddNormals(mesh, vertices);

    QC_TRY(qcArray_Reserve(&upload->indices, (size_t)3 * mesh->triangleCount, sizeof(uint32_t), "a picture's indices"));
    uint32_t* indices = upload->indices.data;
    for (int marked = 0; marked < 2; ++marked)
    {
        for (size_t t = 0; t < mesh->triangleCount; ++t)
        {
            bool isMarked = mesh->marked != NULL && mesh->marked[t] != 0;
            if (isMarked != (marked == 1))
                continue;
            memcpy(indices + upload->indices.count, mesh->indices + 3 * t, 3 * sizeof(uint32_t));
            upload->indices.count += 3;
        }
        if (marked == 0)
            upload->plainCount = (uint32_t)(upload->indices.count / 3);
    }
    return qc_statusOk;
}

static void UploadMesh(const struct qcGlFunctions* gl, Upload* upload)
{
    gl->GenVertexArrays(1, &upload->vertexArray);
    gl->BindVertexArray(upload->vertexArray);
    gl->GenBuffers(1, &upload->vertexBuffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, upload->vertexBuffer);
    gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(upload->vertices.count * sizeof(float)), upload->vertices.data,
                   GL_STATIC_DRAW);
    gl->GenBuffers(1, &upload->indexBuffer);
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, upload->indexBuffer);
    gl->BufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(upload->indices.count * sizeof(uint32_t)),
                   upload->indices.data, GL_STATIC_DRAW);
    for (GLuint i = 0; i < 2; ++i)
    {
        gl->VertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, 6 * sizeof(float), (const void*)(3 * i * sizeof(float)));
        gl->EnableVertexAttribArray(i);
    }
}

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

/// Sets the colours of both sides, and the share of the plain colour.
static void SetColors(const struct qcGlFunctions* gl, GLuint program, const float front[3], const float back[3],
                      float glow)
{
    gl->Uniform3fv(gl->GetUniformLocation(program, "front"), 1, front);
    gl->Uniform3fv(gl->GetUniformLocation(program, "back"), 1, back);
    gl->Uniform1f(gl->GetUniformLocation(program, "glow"), glow);
}

/// Draws the faces of a mesh, or its edges, darker.
static void DrawMesh(const struct qcGlFunctions* gl, GLuint program, const qcPictureMesh* mesh, const Upload* upload,
                     bool edges)
{
    gl->BindVertexArray(upload->vertexArray);
    gl->PolygonMode(GL_FRONT_AND_BACK, edges ? GL_LINE : GL_FILL);
    // An offset moves faces back, so that the edges drawn over them are visible.
    if (!edges)
        gl->Enable(GL_POLYGON_OFFSET_FILL);
    else
        gl->Disable(GL_POLYGON_OFFSET_FILL);
    gl->Uniform1i(gl->GetUniformLocation(program, "edges"), edges);
    gl->Uniform1i(gl->GetUniformLocation(program, "flatShading"), !edges && !mesh->smooth);

    SetColors(gl, program, mesh->color, mesh->backColor, 0.0f);
    gl->DrawElements(GL_TRIANGLES, (GLsizei)(3 * upload->plainCount), GL_UNSIGNED_INT, NULL);
    // 0.5: bright from every side, with enough shading to show the shape.
    SetColors(gl, program, mesh->markColor, mesh->markColor, 0.5f);
    size_t first = (size_t)3 * upload->plainCount;
    gl->DrawElements(GL_TRIANGLES, (GLsizei)(upload->indices.count - first), GL_UNSIGNED_INT,
                     (const void*)(first * sizeof(uint32_t)));
}

static void DrawTile(const struct qcGlFunctions* gl, const PictureJob* job, GLint x, GLint y, GLsizei width,
                     GLsizei height)
{
    const qcPictureDef* def = job->def;
    gl->BindFramebuffer(GL_FRAMEBUFFER, job->framebuffers[0]);
    gl->Viewport(-x, -y, (GLsizei)def->width, (GLsizei)def->height);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    for (uint32_t m = 0; m < def->meshCount; ++m)
    {
        const qcPictureMesh* mesh = &def->meshes[m];
        const Upload* upload = &QC_AT(Upload, job->uploads, m);
        DrawMesh(gl, job->program, mesh, upload, false);
        if (mesh->wireframe)
            DrawMesh(gl, job->program, mesh, upload, true);
    }
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, job->framebuffers[1]);
    gl->BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl->BindFramebuffer(GL_READ_FRAMEBUFFER, job->framebuffers[1]);
    gl->ReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, job->rgb + ((size_t)y * def->width + (size_t)x) * 3);
}

static qcStatus DrawTiles(const struct qcGlFunctions* gl, PictureJob* job)
{
    const qcPictureDef* def = job->def;
    QC_TRY(qcGlFunctions_GetProgram(gl, "picture", s_vertexShader, s_fragmentShader, &job->program));
    GLint width = (GLint)def->width, height = (GLint)def->height;
    GLint tileWidth = width < qc_pictureTileSize ? width : qc_pictureTileSize;
    GLint tileHeight = height < qc_pictureTileSize ? height : qc_pictureTileSize;
    QC_TRY(CreateFramebuffers(gl, job, tileWidth, tileHeight));
    for (uint32_t m = 0; m < def->meshCount; ++m)
        UploadMesh(gl, &QC_AT(Upload, job->uploads, m));

    gl->UseProgram(job->program);
    gl->UniformMatrix4fv(gl->GetUniformLocation(job->program, "clip"), 1, GL_FALSE, job->camera.clip);
    gl->Uniform3fv(gl->GetUniformLocation(job->program, "eye"), 1, def->eye);
    gl->Uniform3fv(gl->GetUniformLocation(job->program, "up"), 1, job->camera.up);
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
    qcStatus status = DrawTiles(gl, job);
    for (size_t m = 0; m < job->uploads.count; ++m)
    {
        const Upload* upload = &QC_AT(Upload, job->uploads, m);
        gl->DeleteVertexArrays(1, &upload->vertexArray);
        gl->DeleteBuffers(1, &upload->vertexBuffer);
        gl->DeleteBuffers(1, &upload->indexBuffer);
    }
    gl->DeleteFramebuffers(2, job->framebuffers);
    gl->DeleteRenderbuffers(2, job->colors);
    gl->DeleteRenderbuffers(1, &job->depth);
    return status;
}

static qcStatus PrepareMeshes(PictureJob* job)
{
    const qcPictureDef* def = job->def;
    QC_TRY(qcArray_Resize(&job->uploads, def->meshCount, sizeof(Upload), "a picture's meshes"));
    if (def->meshCount > 0)
        memset(job->uploads.data, 0, def->meshCount * sizeof(Upload));
    for (uint32_t m = 0; m < def->meshCount; ++m)
        QC_TRY(PrepareMesh(&def->meshes[m], &QC_AT(Upload, job->uploads, m)));
    return qc_statusOk;
}

__attribute__((noinline)) static qcStatus DrawPicture(qcDevice* device, const qcPictureDef* given, uint8_t* rgb)
{
    if (device == NULL || given == NULL || rgb == NULL)
        return qcFail(qc_statusBadInput, "qcDevice_DrawPicture: %s is null",
                      device == NULL ? "device" : (given == NULL ? "def" : "rgb"));
    qcPictureDef def = qcDefaultPictureDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT("qcDevice_DrawPicture", qcPictureDef, width), &def));
    QC_TRY(CheckDef(&def));
    PictureJob job = {.def = &def, .rgb = rgb};
    QC_TRY(PlaceCamera(&def, &job.camera));
    qcStatus status = PrepareMeshes(&job);
    if (status == qc_statusOk)
        status = qcDevice_Run(device, RunPictureJob, &job, "qcDevice_DrawPicture");
    for (size_t m = 0; m < job.uploads.count; ++m)
    {
        qcArray_Free(&QC_AT(Upload, job.uploads, m).vertices);
        qcArray_Free(&QC_AT(Upload, job.uploads, m).indices);
    }
    qcArray_Free(&job.uploads);
    return status;
}

qcStatus qcDevice_DrawPicture(qcDevice* device, const qcPictureDef* def, uint8_t* rgb)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = DrawPicture(device, def, rgb);
    qcFloatMode_End(mode);
    return status;
}
