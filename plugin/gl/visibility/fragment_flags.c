#include "gl/visibility/fragment_flags.h"

#include "gl/visibility/conservative_dilation.h"
#include "gl/visibility/tile_schedule.h"
#include "base/status.h"
#include "gl/compute.h"
#include "gl/programs.h"

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

// The polygon of a dilated triangle is a fan. Each corner has eight floats: qcDilatedCorner.
static const char* const s_dilatedVertexShader =
    "#version 430 core\n"
    "layout(std430, binding = 0) readonly buffer Corners { vec4 corners[]; };\n"
    "layout(std430, binding = 1) readonly buffer Polygons { uint polygons[]; };\n"
    "flat out uint stepOf;\n"
    "flat out vec2 range;\n"
    "flat out vec4 face;\n"
    "void main()\n"
    "{\n"
    "    int polygon = 3 * (gl_VertexID / 15), triangle = gl_VertexID % 15 / 3, turn = gl_VertexID % 3;\n"
    "    int corner = 2 * (7 * int(polygons[polygon]) + (turn == 0 ? 0 : triangle + turn));\n"
    "    stepOf = polygons[polygon + 1];\n"
    "    range = corners[corner].zw;\n"
    "    face = corners[corner + 1];\n"
    "    gl_Position = vec4(corners[corner].xy, 0.0, 1.0);\n"
    "}\n";

// The depth is that of the queries' shader. All depths are above 0: their bits are in the order of the depths.
static const char* const s_dilatedFragmentShader =
    "#version 430 core\n"
    "layout(std430, binding = 2) writeonly buffer Flags { uint flags[]; };\n"
    "layout(std430, binding = 3) buffer Depths { uint depths[]; };\n"
    "uniform int part;\n"
    "uniform float scale;\n"
    "uniform vec3 tile;\n"
    "uniform uint tileSize;\n"
    "uniform uint greater;\n"
    "flat in uint stepOf;\n"
    "flat in vec2 range;\n"
    "flat in vec4 face;\n"
    "void main()\n"
    "{\n"
    "    vec2 pixel = gl_FragCoord.xy + tile.xy;\n"
    "    float depth = face.x + face.y * pixel.x + face.z * pixel.y + tile.z * face.w;\n"
    "    uint bits = floatBitsToUint(0.5 + 0.5 * scale * clamp(depth, range.x, range.y));\n"
    "    uint at = uint(gl_FragCoord.y) * tileSize + uint(gl_FragCoord.x);\n"
    "    if (part == 2)\n"
    "        atomicMin(depths[at], bits);\n"
    "    else if (bits >= depths[at] + greater)\n"
    "        flags[stepOf] = 1u;\n"
    "}\n";

// Behind the flags: that the device has come to the end of a pass. A context that is lost, and can't say so, draws
// nothing, and hides nothing.
static const char* const s_endShader = "#version 430 core\n"
                                       "layout(local_size_x = 1) in;\n"
                                       "layout(std430, binding = 2) writeonly buffer Flags { uint flags[]; };\n"
                                       "uniform uint end;\n"
                                       "uniform uint run;\n"
                                       "void main()\n"
                                       "{\n"
                                       "    flags[end] = run;\n"
                                       "}\n";

enum
{
    // Numbers of vertices and of floats are ints of GLSL: 15 of a polygon, 14 of a triangle.
    qc_maxFlagPolygons = INT32_MAX / 15,
    qc_maxFlagTriangles = INT32_MAX / 14,
    qc_usualPolygons = 4 ///< of a triangle in a pass, if it is not in many tiles
};

bool qcFragmentFlags_AreSupported(const struct qcGlFunctions* gl, bool dilated, uint32_t* maxTriangles)
{
    *maxTriangles = 0;
    if (gl->DispatchCompute == NULL)
        return false;
    GLint vertexBlocks = 0, fragmentBlocks = 0;
    gl->GetIntegerv(GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, &vertexBlocks);
    gl->GetIntegerv(GL_MAX_FRAGMENT_SHADER_STORAGE_BLOCKS, &fragmentBlocks);
    if (vertexBlocks < 2 || fragmentBlocks < 2)
        return false;
    const uint64_t corners = dilated ? qc_dilatedCorners * sizeof(qcDilatedCorner) : 9 * sizeof(float);
    const uint64_t polygons = qc_usualPolygons * sizeof(qcSchedulePolygon);
    const uint64_t most = qcGl_MaxStorageBytes(gl) / (corners > polygons ? corners : polygons);
    *maxTriangles = most < qc_maxFlagTriangles ? (uint32_t)most : qc_maxFlagTriangles;
    return true;
}

/// Replaces the contents of a buffer, and binds it for the shaders.
static void Upload(const struct qcGlFunctions* gl, GLuint buffer, GLuint binding, const void* data, size_t bytes)
{
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)bytes, data, GL_STREAM_COPY);
}

/// A tile's depths. Their contents are undefined.
static void CreateDepths(const struct qcGlFunctions* gl, uint32_t tileSize, qcFragmentFlags* flags)
{
    gl->GenBuffers(1, &flags->depthBuffer);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, flags->depthBuffer);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)tileSize * tileSize * (GLsizeiptr)sizeof(uint32_t), NULL,
                   GL_DYNAMIC_COPY);
    flags->tileSize = tileSize;
    flags->tileSizeUniform = gl->GetUniformLocation(flags->program, "tileSize");
}

qcStatus qcFragmentFlags_Create(const struct qcGlFunctions* gl, uint32_t tileSize, qcFragmentFlags* flags)
{
    bool dilated = tileSize != 0;
    QC_TRY(qcGlPrograms_Get(gl, dilated ? "dilated visibility flags" : "visibility flags",
                            dilated ? s_dilatedVertexShader : s_vertexShader,
                            dilated ? s_dilatedFragmentShader : s_fragmentShader, &flags->program));
    QC_TRY(qcGlPrograms_GetCompute(gl, "end of visibility flags", &s_endShader, 1, &flags->endProgram));
    flags->endUniform = gl->GetUniformLocation(flags->endProgram, "end");
    flags->runUniform = gl->GetUniformLocation(flags->endProgram, "run");
    flags->axisUniform = gl->GetUniformLocation(flags->program, "axis");
    flags->greaterUniform = gl->GetUniformLocation(flags->program, "greater");
    flags->scaleUniform = gl->GetUniformLocation(flags->program, "scale");
    flags->partUniform = gl->GetUniformLocation(flags->program, "part");
    flags->tileUniform = gl->GetUniformLocation(flags->program, "tile");
    flags->vertexCount = (GLsizei)qcTileSchedule_GetIndexCount(dilated ? qc_dilatedCorners : 3);
    gl->GenBuffers(1, &flags->cornerBuffer);
    gl->GenBuffers(1, &flags->polygonBuffer);
    gl->GenBuffers(1, &flags->flagBuffer);
    if (dilated)
        CreateDepths(gl, tileSize, flags);
    return qc_statusOk;
}

void qcFragmentFlags_SetCorners(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, const void* corners,
                                size_t bytes)
{
    Upload(gl, flags->cornerBuffer, 0, corners, bytes);
}

void qcFragmentFlags_Delete(const struct qcGlFunctions* gl, const qcFragmentFlags* flags)
{
    gl->DeleteBuffers(1, &flags->cornerBuffer);
    gl->DeleteBuffers(1, &flags->polygonBuffer);
    gl->DeleteBuffers(1, &flags->flagBuffer);
    gl->DeleteBuffers(1, &flags->depthBuffer);
}

void qcFragmentFlags_Free(qcFragmentFlags* flags)
{
    qcArray_Free(&flags->flags);
}

qcStatus qcFragmentFlags_BeginPass(const struct qcGlFunctions* gl, qcFragmentFlags* flags, const qcFlagPass* pass)
{
    const size_t polygonBytes = pass->polygons->count * sizeof(qcSchedulePolygon);
    if (pass->polygons->count > qc_maxFlagPolygons || polygonBytes > qcGl_MaxStorageBytes(gl))
        return qcFail(qc_statusDevice, "visibility flags: %zu polygons are more than the device's shaders read",
                      pass->polygons->count);
    const size_t words = (size_t)pass->stepCount + 1;
    QC_TRY(qcArray_Resize(&flags->flags, words, sizeof(uint32_t), "visibility flags"));
    memset(flags->flags.data, 0, words * sizeof(uint32_t));
    gl->UseProgram(flags->program);
    gl->Uniform1f(flags->scaleUniform, pass->scale);
    if (flags->depthBuffer == 0)
        gl->Uniform1i(flags->axisUniform, pass->axis);
    else
    {
        gl->Disable(GL_DEPTH_TEST);
        // Scenes of other resolutions use the program, too.
        gl->Uniform1ui(flags->tileSizeUniform, flags->tileSize);
        gl->Uniform1ui(flags->greaterUniform, pass->greater);
        gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, flags->depthBuffer);
    }
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, flags->cornerBuffer);
    Upload(gl, flags->polygonBuffer, 1, pass->polygons->data, polygonBytes);
    Upload(gl, flags->flagBuffer, 2, flags->flags.data, flags->flags.count * sizeof(uint32_t));
    return qc_statusOk;
}

void qcFragmentFlags_BeginTile(const struct qcGlFunctions* gl, const qcFragmentFlags* flags)
{
    if (flags->depthBuffer == 0)
        return;
    static const float farthest = 1.0f;
    uint32_t bits;
    memcpy(&bits, &farthest, sizeof bits);
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, flags->depthBuffer);
    gl->ClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &bits);
}

void qcFragmentFlags_Draw(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, size_t first, size_t count,
                          qcFlagPart part)
{
    if (flags->depthBuffer != 0)
        gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT);
    gl->Uniform1i(flags->partUniform, (GLint)part);
    gl->DrawArrays(GL_TRIANGLES, (GLint)first * flags->vertexCount, (GLsizei)count * flags->vertexCount);
}

qcStatus qcFragmentFlags_Read(const struct qcGlFunctions* gl, qcFragmentFlags* flags)
{
    uint32_t* failed = flags->flags.data;
    const size_t words = flags->flags.count, end = words - 1;
    // 0 is what the buffer has before the pass, all ones is what isn't read.
    flags->runNumber = flags->runNumber % INT32_MAX + 1;
    gl->UseProgram(flags->endProgram);
    gl->Uniform1ui(flags->endUniform, (GLuint)end);
    gl->Uniform1ui(flags->runUniform, flags->runNumber);
    (void)qcGl_Dispatch(gl, 1);
    memset(failed, 0xff, words * sizeof(uint32_t));
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, flags->flagBuffer);
    gl->GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, (GLsizeiptr)(words * sizeof(uint32_t)), failed);
    if (failed[end] != flags->runNumber)
        return qcFail(qc_statusDevice, "visibility flags: the device hasn't drawn a pass");
    return qc_statusOk;
}
