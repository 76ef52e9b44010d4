// Shadow map, nearest surfaces, and from them ambient occlusion and soft shadows.
#include "gl/picture/received_light.h"

#include "base/status.h"
#include "gl/programs.h"
#include "picture_shaders.h"

enum
{
    qc_shadowMapSize = 2048,
    qc_maxLightSide = 2048, ///< of the result, for the largest pictures
    qc_shadowDepths = 0,    ///< textures
    qc_surfaceDepths,
    qc_surfaceNormals,
    qc_noisyLights,
    qc_smoothLights
};

static void MakeTexture(const struct qcGlFunctions* gl, GLuint texture, GLenum format, GLsizei width, GLsizei height)
{
    bool isDepth = format == GL_DEPTH_COMPONENT24;
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->TexImage2D(GL_TEXTURE_2D, 0, (GLint)format, width, height, 0, isDepth ? GL_DEPTH_COMPONENT : GL_RGBA,
                   isDepth ? GL_UNSIGNED_INT : GL_FLOAT, NULL);
    static const GLenum names[4] = {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER, GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T};
    for (int i = 0; i < 4; ++i)
        gl->TexParameteri(GL_TEXTURE_2D, names[i], i < 2 ? GL_NEAREST : GL_CLAMP_TO_EDGE);
}

/// A framebuffer of textures; 0: none.
static qcStatus MakeFramebuffer(const struct qcGlFunctions* gl, GLuint framebuffer, GLuint color, GLuint depth)
{
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    if (color != 0)
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color, 0);
    else
    {
        gl->DrawBuffer(GL_NONE);
        gl->ReadBuffer(GL_NONE);
    }
    if (depth != 0)
        gl->FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
    GLenum complete = gl->CheckFramebufferStatus(GL_FRAMEBUFFER);
    if (complete != GL_FRAMEBUFFER_COMPLETE)
        return qcFail(qc_statusDevice, "qcDevice_DrawPicture: no textures for the light (0x%x)", complete);
    return qc_statusOk;
}

static qcStatus MakeTargets(const struct qcGlFunctions* gl, const qcPictureDef* def, qcReceivedLight* light)
{
    uint32_t side = def->width > def->height ? def->width : def->height;
    uint32_t divisor = side > 2 * qc_maxLightSide ? (side + qc_maxLightSide - 1) / qc_maxLightSide : 2;
    GLsizei width = (GLsizei)((def->width + divisor - 1) / divisor);
    GLsizei height = (GLsizei)((def->height + divisor - 1) / divisor);
    light->width = width;
    light->height = height;
    gl->GenTextures(qc_lightTextureCount, light->textures);
    gl->GenFramebuffers(qc_lightFramebufferCount, light->framebuffers);
    const GLuint* textures = light->textures;
    gl->ActiveTexture(GL_TEXTURE0);
    MakeTexture(gl, textures[qc_shadowDepths], GL_DEPTH_COMPONENT24, qc_shadowMapSize, qc_shadowMapSize);
    MakeTexture(gl, textures[qc_surfaceDepths], GL_DEPTH_COMPONENT24, width, height);
    MakeTexture(gl, textures[qc_surfaceNormals], GL_RGB10_A2, width, height);
    MakeTexture(gl, textures[qc_noisyLights], GL_RGBA32F, width, height);
    MakeTexture(gl, textures[qc_smoothLights], GL_RGBA32F, width, height);
    light->result = textures[qc_smoothLights];
    QC_TRY(MakeFramebuffer(gl, light->framebuffers[0], 0, textures[qc_shadowDepths]));
    QC_TRY(MakeFramebuffer(gl, light->framebuffers[1], textures[qc_surfaceNormals], textures[qc_surfaceDepths]));
    QC_TRY(MakeFramebuffer(gl, light->framebuffers[2], textures[qc_noisyLights], 0));
    return MakeFramebuffer(gl, light->framebuffers[3], textures[qc_smoothLights], 0);
}

static qcStatus DrawShadowMap(const struct qcGlFunctions* gl, const qcPictureDef* def, const qcPictureSpace* space,
                              const qcPictureMeshes* meshes, GLuint framebuffer)
{
    GLuint program = 0;
    QC_TRY(qcGlPrograms_Get(gl, "picture, shadows", s_pictureMesh, s_pictureShadow, &program));
    gl->UseProgram(program);
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, "clip"), 1, GL_FALSE, space->lightClip);
    gl->BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    gl->Viewport(0, 0, qc_shadowMapSize, qc_shadowMapSize);
    gl->Clear(GL_DEPTH_BUFFER_BIT);
    for (uint32_t m = 0; m < def->meshCount; ++m)
    {
        for (int marked = 0; marked < 2; ++marked)
            qcPictureMeshes_Draw(gl, &QC_AT(qcPictureRange, meshes->ranges, m), marked == 1);
    }
    return qc_statusOk;
}

static qcStatus DrawSurfaces(const struct qcGlFunctions* gl, const qcPictureDef* def, const qcPictureSpace* space,
                             const qcPictureMeshes* meshes, const qcReceivedLight* light)
{
    GLuint program = 0;
    QC_TRY(qcGlPrograms_Get(gl, "picture, surfaces", s_pictureMesh, s_pictureSurface, &program));
    gl->UseProgram(program);
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, "clip"), 1, GL_FALSE, space->clip);
    gl->Uniform1i(gl->GetUniformLocation(program, "edges"), 0);
    gl->BindFramebuffer(GL_FRAMEBUFFER, light->framebuffers[1]);
    gl->Viewport(0, 0, light->width, light->height);
    gl->ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl->Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    GLint flatShading = gl->GetUniformLocation(program, "flatShading");
    for (uint32_t m = 0; m <= def->meshCount; ++m) // the ground is last
    {
        gl->Uniform1i(flatShading, m < def->meshCount && !def->meshes[m].smooth);
        for (int marked = 0; marked < 2; ++marked)
            qcPictureMeshes_Draw(gl, &QC_AT(qcPictureRange, meshes->ranges, m), marked == 1);
    }
    return qc_statusOk;
}

static void BindInput(const struct qcGlFunctions* gl, GLuint program, const char* name, GLuint unit, GLuint texture)
{
    gl->ActiveTexture(GL_TEXTURE0 + unit);
    gl->BindTexture(GL_TEXTURE_2D, texture);
    gl->Uniform1i(gl->GetUniformLocation(program, name), (GLint)unit);
}

static qcStatus FindLight(const struct qcGlFunctions* gl, const qcPictureSpace* space, const qcReceivedLight* light)
{
    GLuint program = 0;
    QC_TRY(qcGlPrograms_Get(gl, "picture, light", s_pictureScreen, s_pictureLight, &program));
    gl->UseProgram(program);
    BindInput(gl, program, "depths", 0, light->textures[qc_surfaceDepths]);
    BindInput(gl, program, "normals", 1, light->textures[qc_surfaceNormals]);
    BindInput(gl, program, "shadowMap", 2, light->textures[qc_shadowDepths]);
    const float projection[4] = {space->projection[0], space->projection[1],
                                 0.5f * (float)light->width * space->clipScale[0],
                                 0.5f * (float)light->height * space->clipScale[1]};
    gl->Uniform4fv(gl->GetUniformLocation(program, "projection"), 1, projection);
    gl->Uniform3fv(gl->GetUniformLocation(program, "forward"), 1, space->forward);
    gl->Uniform3fv(gl->GetUniformLocation(program, "rayX"), 1, space->rayX);
    gl->Uniform3fv(gl->GetUniformLocation(program, "rayY"), 1, space->rayY);
    gl->Uniform3fv(gl->GetUniformLocation(program, "light"), 1, space->light);
    gl->Uniform3fv(gl->GetUniformLocation(program, "lightExtents"), 1, space->lightExtents);
    gl->UniformMatrix4fv(gl->GetUniformLocation(program, "lightClip"), 1, GL_FALSE, space->lightMap);
    gl->BindFramebuffer(GL_FRAMEBUFFER, light->framebuffers[2]);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);

    QC_TRY(qcGlPrograms_Get(gl, "picture, blur", s_pictureScreen, s_pictureBlur, &program));
    gl->UseProgram(program);
    BindInput(gl, program, "lights", 0, light->textures[qc_noisyLights]);
    gl->BindFramebuffer(GL_FRAMEBUFFER, light->framebuffers[3]);
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
    return qc_statusOk;
}

qcStatus qcReceivedLight_Make(const struct qcGlFunctions* gl, const qcPictureDef* def, const qcPictureSpace* space,
                              const qcPictureMeshes* meshes, qcReceivedLight* light)
{
    QC_TRY(MakeTargets(gl, def, light));
    gl->Enable(GL_DEPTH_TEST);
    QC_TRY(DrawShadowMap(gl, def, space, meshes, light->framebuffers[0]));
    QC_TRY(DrawSurfaces(gl, def, space, meshes, light));
    gl->Disable(GL_DEPTH_TEST);
    return FindLight(gl, space, light);
}

void qcReceivedLight_Delete(const struct qcGlFunctions* gl, qcReceivedLight* light)
{
    gl->DeleteFramebuffers(qc_lightFramebufferCount, light->framebuffers);
    gl->DeleteTextures(qc_lightTextureCount, light->textures);
}
