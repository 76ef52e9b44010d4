// GL objects of visibility tests, and the shaders of occlusion queries; those of flags: fragment_flags.c.
#include "gl/visibility/visibility_objects.h"

#include "base/status.h"
#include "gl/programs.h"
#include "gl/visibility/conservative_dilation.h"

#include <stddef.h>

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

bool qcVisibilityObjects_WantSure(const qcVisibility* v)
{
    return !v->isDilated && (v->way == qc_wayDefault ? v->isSoftware : v->way == qc_waySure);
}

/// GPUs draw faster than the processor finds what is sure, and find it faster than they draw.
static bool WantsComputing(const qcVisibility* v)
{
    return !v->isDilated && (v->way == qc_wayDefault ? !v->isSoftware : v->way == qc_wayComputed);
}

/// On llvmpipe neither way is always quicker for dilated triangles (4096 x 4096, 2 cores): with queries and with flags,
/// six passes of the demo leaves take 3.6 and 4.3 s, one of breaking 3.3 and 2.4 s.
static bool WantsFlags(const qcVisibility* v)
{
    return v->way == qc_wayFlags || (v->way != qc_wayQueries && !(v->isDilated && v->isSoftware));
}

static qcStatus CreateFlags(const struct qcGlFunctions* gl, qcVisibility* v)
{
    QC_TRY(qcFragmentFlags_Create(gl, v->isDilated ? v->tileSize : 0, &v->flags));
    v->tileUniform = v->flags.tileUniform;
    v->computesSure = WantsComputing(v) && qcSureKernels_AreSupported(gl);
    return v->computesSure ? qcSureKernels_Create(gl, &v->kernels) : qc_statusOk;
}

/// The vertices are the caller's corners, or dilated ones.
static void LayOutVertices(const struct qcGlFunctions* gl, const qcVisibility* v)
{
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, v->indexBuffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, v->vertexBuffer);
    gl->EnableVertexAttribArray(0);
    if (!v->isDilated)
    {
        gl->VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
        return;
    }
    gl->VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, sizeof(qcDilatedCorner), (void*)offsetof(qcDilatedCorner, x));
    gl->EnableVertexAttribArray(1);
    gl->VertexAttribPointer(1, 4, GL_FLOAT, GL_FALSE, sizeof(qcDilatedCorner), (void*)offsetof(qcDilatedCorner, base));
}

static qcStatus CreateQueries(const struct qcGlFunctions* gl, qcVisibility* v)
{
    if (v->isDilated)
        QC_TRY(qcGlPrograms_Get(gl, "dilated visibility", s_dilatedVertexShader, s_dilatedFragmentShader, &v->program));
    else
        QC_TRY(qcGlPrograms_Get(gl, "visibility", s_vertexShader, s_fragmentShader, &v->program));
    v->axisUniform = gl->GetUniformLocation(v->program, "axis");
    v->scaleUniform = gl->GetUniformLocation(v->program, "scale");
    v->tileUniform = gl->GetUniformLocation(v->program, "tile");
    gl->GenBuffers(1, &v->vertexBuffer);
    gl->GenBuffers(1, &v->indexBuffer);
    LayOutVertices(gl, v);
    return qc_statusOk;
}

static qcStatus CreateImage(const struct qcGlFunctions* gl, qcVisibility* v)
{
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

qcStatus qcVisibilityObjects_Create(const struct qcGlFunctions* gl, void* visibility)
{
    qcVisibility* v = visibility;
    gl->GenVertexArrays(1, &v->vertexArray);
    gl->BindVertexArray(v->vertexArray);
    v->storesFlags = WantsFlags(v) && qcFragmentFlags_AreSupported(gl, v->isDilated, &v->maxFlagTriangles) &&
                     v->triangleCount <= v->maxFlagTriangles;
    QC_TRY(v->storesFlags ? CreateFlags(gl, v) : CreateQueries(gl, v));
    return CreateImage(gl, v);
}

qcStatus qcVisibilityObjects_Delete(const struct qcGlFunctions* gl, void* visibility)
{
    qcVisibility* v = visibility;
    gl->DeleteQueries((GLsizei)v->queries.count, v->queries.data);
    qcFragmentFlags_Delete(gl, &v->flags);
    qcSureKernels_Delete(gl, &v->kernels);
    gl->DeleteFramebuffers(1, &v->framebuffer);
    gl->DeleteRenderbuffers(1, &v->depthBuffer);
    gl->DeleteVertexArrays(1, &v->vertexArray);
    gl->DeleteBuffers(1, &v->indexBuffer);
    gl->DeleteBuffers(1, &v->vertexBuffer);
    return qc_statusOk;
}

void qcVisibilityObjects_Upload(const struct qcGlFunctions* gl, qcVisibility* v, int axis)
{
    if (v->isDilated ? v->dilatedAxis == axis : v->isUploaded)
        return;
    const void* corners = v->isDilated ? v->dilated.data : v->corners;
    size_t bytes = v->isDilated ? v->dilated.count * sizeof(qcDilatedCorner) : v->triangleCount * 9 * sizeof(float);
    if (v->storesFlags)
        qcFragmentFlags_SetCorners(gl, &v->flags, corners, bytes);
    else
    {
        gl->BindBuffer(GL_ARRAY_BUFFER, v->vertexBuffer);
        gl->BufferData(GL_ARRAY_BUFFER, (GLsizeiptr)bytes, corners, GL_STREAM_DRAW);
    }
    v->isUploaded = true;
    v->dilatedAxis = axis;
}
