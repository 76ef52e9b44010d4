#include "gl/visibility/fragment_flags.h"

#include "gl/visibility/tile_schedule.h"
#include "base/status.h"

#include <string.h>

// Corners are fetched by number: gl_PrimitiveID is wrong in some drivers' long draws (llvmpipe of Mesa 22.3).
static const char* const s_vertexShader =
    "#version 430 core\n"
    "invariant gl_Position;\n"
    "layout(std430, binding = 0) readonly buffer Corners { float corners[]; };\n"
    "layout(std430, binding = 1) readonly buffer Polygons { uint polygons[]; };\n"
    "uniform int axis;\n"
    "uniform float scale;\n"
    "flat out uint stepOf;\n"
    "flat out uint isCounted;\n"
    "void main()\n"
    "{\n"
    "    int polygon = 3 * (gl_VertexID / 3);\n"
    "    int corner = 9 * int(polygons[polygon]) + 3 * (gl_VertexID % 3);\n"
    "    stepOf = polygons[polygon + 1];\n"
    "    isCounted = polygons[polygon + 2];\n"
    "    gl_Position = vec4(corners[corner + (axis + 1) % 3], corners[corner + (axis + 2) % 3],\n"
    "                       scale * corners[corner + axis], 1.0);\n"
    "}\n";

// A fragment of a test that gets here has passed "greater" or "greater or equal": it is hidden. All parts use one
// program: binding the buffers anew for each batch would make llvmpipe wait each time. `part`: of qcFlagPart.
static const char* const s_fragmentShader = "#version 430 core\n"
                                            "layout(early_fragment_tests) in;\n"
                                            "layout(std430, binding = 2) buffer Flags { uint flags[]; };\n"
                                            "uniform int part;\n"
                                            "flat in uint stepOf;\n"
                                            "flat in uint isCounted;\n"
                                            "void main()\n"
                                            "{\n"
                                            "    if (part == 0)\n"
                                            "        flags[stepOf] = 1u;\n"
                                            "    else if (isCounted != 0u)\n"
                                            "        atomicAdd(flags[stepOf], part == 1 ? 1u : 0xffffffffu);\n"
                                            "}\n";

bool qcFragmentFlags_AreSupported(const struct qcGlFunctions* gl)
{
    if (gl->DispatchCompute == NULL)
        return false;
    GLint vertexBlocks = 0, fragmentBlocks = 0;
    gl->GetIntegerv(GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, &vertexBlocks);
    gl->GetIntegerv(GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS, &fragmentBlocks);
    return vertexBlocks >= 2 && fragmentBlocks >= 1;
}

/// Replaces the contents of a buffer, and binds it for the shaders.
static void Upload(const struct qcGlFunctions* gl, GLuint buffer, GLuint binding, const qcArray* data, size_t size)
{
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(data->count * size), data->data, GL_STREAM_COPY);
}

qcStatus qcFragmentFlags_Create(const struct qcGlFunctions* gl, const qcArray* corners, qcFragmentFlags* flags)
{
    QC_TRY(qcGlFunctions_GetProgram(gl, "visibility flags", s_vertexShader, s_fragmentShader, &flags->program));
    flags->partUniform = gl->GetUniformLocation(flags->program, "part");
    gl->GenBuffers(1, &flags->cornerBuffer);
    gl->GenBuffers(1, &flags->polygonBuffer);
    gl->GenBuffers(1, &flags->flagBuffer);
    Upload(gl, flags->cornerBuffer, 0, corners, sizeof(float));
    return qc_statusOk;
}

void qcFragmentFlags_Delete(const struct qcGlFunctions* gl, const qcFragmentFlags* flags)
{
    gl->DeleteBuffers(1, &flags->cornerBuffer);
    gl->DeleteBuffers(1, &flags->polygonBuffer);
    gl->DeleteBuffers(1, &flags->flagBuffer);
}

void qcFragmentFlags_Free(qcFragmentFlags* flags)
{
    qcArray_Free(&flags->flags);
}

qcStatus qcFragmentFlags_BeginPass(const struct qcGlFunctions* gl, qcFragmentFlags* flags, const qcArray* polygons,
                                   uint32_t stepCount, int axis, float scale)
{
    QC_TRY(qcArray_Resize(&flags->flags, stepCount, sizeof(uint32_t), "visibility flags"));
    if (stepCount > 0)
        memset(flags->flags.data, 0, stepCount * sizeof(uint32_t));
    gl->UseProgram(flags->program);
    gl->Uniform1i(gl->GetUniformLocation(flags->program, "axis"), axis);
    gl->Uniform1f(gl->GetUniformLocation(flags->program, "scale"), scale);
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, flags->cornerBuffer);
    Upload(gl, flags->polygonBuffer, 1, polygons, sizeof(qcSchedulePolygon));
    Upload(gl, flags->flagBuffer, 2, &flags->flags, sizeof(uint32_t));
    return qc_statusOk;
}

void qcFragmentFlags_Draw(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, size_t first, size_t count,
                          qcFlagPart part)
{
    gl->Uniform1i(flags->partUniform, part);
    gl->DrawArrays(GL_TRIANGLES, (GLint)(3 * first), (GLsizei)(3 * count));
}

void qcFragmentFlags_Read(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, uint8_t* visible)
{
    uint32_t* failed = flags->flags.data;
    size_t count = flags->flags.count;
    if (count == 0)
        return;
    // Flags that can't be read keep this value: hidden is the conservative result.
    memset(failed, 0xff, count * sizeof(uint32_t));
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, flags->flagBuffer);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)(count * sizeof(uint32_t)), failed);
    for (size_t i = 0; i < count; ++i)
        if (failed[i] != 0)
            visible[i] = 0;
}
