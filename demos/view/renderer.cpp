// OpenGL 3.3 core through epoxy, which loads functions for any kind of context.
#include "view/renderer.h"

#include "view/shaders.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace
{
constexpr int s_shadowSize = 2048;

btVector3 Sun()
{
    return btVector3(btScalar(-0.7), btScalar(1.2), btScalar(0.35)).normalized();
}

/// 0 with a message if it does not compile.
unsigned MakeShader(unsigned type, const char* source, std::string* message)
{
    unsigned shader = glCreateShader(type);
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    int ok = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok != 0)
        return shader;
    char text[1024] = "";
    glGetShaderInfoLog(shader, sizeof text, nullptr, text);
    *message = std::string("a shader does not compile: ") + text;
    glDeleteShader(shader);
    return 0;
}

unsigned MakeProgram(const char* vertexSource, const char* fragmentSource, std::string* message)
{
    unsigned vertex = MakeShader(GL_VERTEX_SHADER, vertexSource, message);
    unsigned fragment = vertex != 0 ? MakeShader(GL_FRAGMENT_SHADER, fragmentSource, message) : 0;
    if (fragment == 0)
        return 0;
    unsigned program = glCreateProgram();
    glAttachShader(program, vertex);
    glAttachShader(program, fragment);
    glLinkProgram(program);
    glDeleteShader(vertex);
    glDeleteShader(fragment);
    int ok = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    if (ok != 0)
        return program;
    *message = "a shader does not link";
    glDeleteProgram(program);
    return 0;
}

void SetMatrix(unsigned program, const char* name, const qcMatrix& m)
{
    glUniformMatrix4fv(glGetUniformLocation(program, name), 1, GL_FALSE, m.data());
}

void SetVector(unsigned program, const char* name, const btVector3& v)
{
    glUniform3f(glGetUniformLocation(program, name), float(v.x()), float(v.y()), float(v.z()));
}

qcMatrix MatrixOf(const btTransform& place)
{
    qcMatrix m{};
    for (size_t row = 0; row < 3; row++)
    {
        for (size_t column = 0; column < 3; column++)
            m[4 * column + row] = float(place.getBasis()[int(row)][int(column)]);
        m[12 + row] = float(place.getOrigin()[int(row)]);
    }
    m[15] = 1;
    return m;
}

/// Position and another vector, three floats each.
void SetLayout()
{
    for (unsigned i = 0; i < 2; i++)
    {
        glEnableVertexAttribArray(i);
        glVertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, 6 * sizeof(float),
                              reinterpret_cast<const void*>(i * 3 * sizeof(float)));
    }
}

/// The view of the sun on all that throws a shadow.
qcMatrix LightMatrix(const qcViewFrame& frame)
{
    btVector3 middle = (frame.lower + frame.upper) / 2;
    btScalar radius = std::max((frame.upper - frame.lower).length() / 2, btScalar(1e-3));
    return qcMultiply(qcOrthographic(float(radius), float(radius), float(radius), 5 * float(radius)),
                      qcLookAt(middle + Sun() * (3 * radius), middle, btVector3(0, 0, 1)));
}
} // namespace

qcViewRenderer::~qcViewRenderer()
{
    for (auto& [id, buffer] : m_buffers)
        buffer.used = false;
    ReleaseUnused();
    for (unsigned program : {m_surfaceProgram, m_shadowProgram, m_coloredProgram, m_skyProgram})
        glDeleteProgram(program);
    glDeleteTextures(1, &m_shadowMap);
    glDeleteFramebuffers(1, &m_shadowTarget);
    glDeleteVertexArrays(1, &m_coloredArray);
    glDeleteVertexArrays(1, &m_emptyArray);
    glDeleteBuffers(1, &m_coloredVertices);
}

bool qcViewRenderer::Create(std::string* message)
{
    m_surfaceProgram = MakeProgram(qcSurfaceVertexShader, qcSurfaceFragmentShader, message);
    m_shadowProgram = MakeProgram(qcShadowVertexShader, qcShadowFragmentShader, message);
    m_coloredProgram = MakeProgram(qcColoredVertexShader, qcColoredFragmentShader, message);
    m_skyProgram = MakeProgram(qcSkyVertexShader, qcSkyFragmentShader, message);
    if (m_surfaceProgram == 0 || m_shadowProgram == 0 || m_coloredProgram == 0 || m_skyProgram == 0)
        return false;
    glGenTextures(1, &m_shadowMap);
    glBindTexture(GL_TEXTURE_2D, m_shadowMap);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, s_shadowSize, s_shadowSize, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
                 nullptr);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glGenFramebuffers(1, &m_shadowTarget);
    glBindFramebuffer(GL_FRAMEBUFFER, m_shadowTarget);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, m_shadowMap, 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glGenVertexArrays(1, &m_emptyArray);
    glGenVertexArrays(1, &m_coloredArray);
    glGenBuffers(1, &m_coloredVertices);
    glBindVertexArray(m_coloredArray);
    glBindBuffer(GL_ARRAY_BUFFER, m_coloredVertices);
    SetLayout();
    return true;
}

const qcViewRenderer::Buffer& qcViewRenderer::Upload(const qcViewTriangles& triangles)
{
    Buffer& buffer = m_buffers[triangles.id];
    buffer.used = true;
    bool isNew = buffer.vertexArray == 0;
    if (isNew)
    {
        glGenVertexArrays(1, &buffer.vertexArray);
        glGenBuffers(1, &buffer.vertices);
    }
    if (!isNew && buffer.changes == triangles.changes)
        return buffer;
    glBindVertexArray(buffer.vertexArray);
    glBindBuffer(GL_ARRAY_BUFFER, buffer.vertices);
    glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(triangles.shaded.size() * sizeof(qcShadedVertex)), triangles.shaded.data(),
                 triangles.changes == 0 ? GL_STATIC_DRAW : GL_STREAM_DRAW);
    SetLayout();
    buffer.count = int(triangles.shaded.size());
    buffer.changes = triangles.changes;
    return buffer;
}

void qcViewRenderer::ReleaseUnused()
{
    for (auto at = m_buffers.begin(); at != m_buffers.end();)
    {
        if (at->second.used)
        {
            at->second.used = false;
            ++at;
            continue;
        }
        glDeleteVertexArrays(1, &at->second.vertexArray);
        glDeleteBuffers(1, &at->second.vertices);
        at = m_buffers.erase(at);
    }
}

void qcViewRenderer::DrawShadows(const qcViewFrame& frame, const qcMatrix& light)
{
    glBindFramebuffer(GL_FRAMEBUFFER, m_shadowTarget);
    glViewport(0, 0, s_shadowSize, s_shadowSize);
    glClear(GL_DEPTH_BUFFER_BIT);
    glUseProgram(m_shadowProgram);
    SetMatrix(m_shadowProgram, "light", light);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(4.0f, 64.0f);
    for (const qcViewItem& item : frame.items)
    {
        const Buffer& buffer = Upload(*item.surface->triangles);
        if (item.surface->unbounded)
            continue;
        SetMatrix(m_shadowProgram, "place", MatrixOf(item.surface->place));
        glBindVertexArray(buffer.vertexArray);
        glDrawArrays(GL_TRIANGLES, 0, buffer.count);
    }
    glDisable(GL_POLYGON_OFFSET_FILL);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

void qcViewRenderer::DrawSurfaces(const qcViewFrame& frame, const qcMatrix& viewProjection, const qcMatrix& light)
{
    btScalar extent = (frame.upper - frame.lower).length();
    glUseProgram(m_surfaceProgram);
    SetMatrix(m_surfaceProgram, "viewProjection", viewProjection);
    SetMatrix(m_surfaceProgram, "light", light);
    SetVector(m_surfaceProgram, "eye", frame.camera->Eye());
    SetVector(m_surfaceProgram, "target", (frame.lower + frame.upper) / 2);
    SetVector(m_surfaceProgram, "sun", Sun());
    glUniform1f(glGetUniformLocation(m_surfaceProgram, "fade"), float(4 * extent));
    glUniform1f(glGetUniformLocation(m_surfaceProgram, "grid"),
                std::pow(10.0f, std::round(std::log10(float(extent)))) / 10);
    glUniform1i(glGetUniformLocation(m_surfaceProgram, "shadowMap"), 0);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, m_shadowMap);
    for (const qcViewItem& item : frame.items)
    {
        const Buffer& buffer = Upload(*item.surface->triangles);
        const qcViewColors& c = item.colors;
        btScalar add = item.selected ? btScalar(0.06) : btScalar(0);
        SetMatrix(m_surfaceProgram, "place", MatrixOf(item.surface->place));
        SetVector(m_surfaceProgram, "front", btVector3(c.front[0] + add, c.front[1] + add, c.front[2] + add));
        SetVector(m_surfaceProgram, "back", btVector3(c.back[0] + add, c.back[1] + add, c.back[2] + add));
        glUniform1i(glGetUniformLocation(m_surfaceProgram, "isGround"), item.surface->unbounded);
        glBindVertexArray(buffer.vertexArray);
        glDrawArrays(GL_TRIANGLES, 0, buffer.count);
    }
}

void qcViewRenderer::DrawColored(const std::vector<qcColoredVertex>& vertices, unsigned mode,
                                 const qcMatrix& viewProjection, float alpha)
{
    if (vertices.empty())
        return;
    glUseProgram(m_coloredProgram);
    SetMatrix(m_coloredProgram, "viewProjection", viewProjection);
    SetVector(m_coloredProgram, "sun", Sun());
    glUniform1i(glGetUniformLocation(m_coloredProgram, "shaded"), mode == GL_TRIANGLES);
    glUniform1f(glGetUniformLocation(m_coloredProgram, "alpha"), alpha);
    glBindVertexArray(m_coloredArray);
    glBindBuffer(GL_ARRAY_BUFFER, m_coloredVertices);
    glBufferData(GL_ARRAY_BUFFER, GLsizeiptr(vertices.size() * sizeof(qcColoredVertex)), vertices.data(),
                 GL_STREAM_DRAW);
    glDrawArrays(mode, 0, int(vertices.size()));
}

void qcViewRenderer::Draw(const qcViewFrame& frame)
{
    glEnable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
    qcMatrix light = LightMatrix(frame);
    DrawShadows(frame, light);
    glViewport(0, 0, frame.width, frame.height);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(m_skyProgram);
    glBindVertexArray(m_emptyArray);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    qcMatrix viewProjection = frame.camera->ViewProjection(btScalar(frame.width) / btScalar(frame.height),
                                                           (frame.upper - frame.lower).length());
    DrawSurfaces(frame, viewProjection, light);
    // In front of the surfaces that they lie on.
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(-1.0f, -1.0f);
    DrawColored(frame.marks->Triangles(), GL_TRIANGLES, viewProjection, 1);
    glDisable(GL_POLYGON_OFFSET_FILL);
    // Contacts lie between two surfaces: lines are moved to the front a little, and seen faintly through all.
    glDepthRange(0, 0.9996);
    DrawColored(frame.lines->Lines(), GL_LINES, viewProjection, 1);
    glDepthRange(0, 1);
    glDisable(GL_DEPTH_TEST);
    DrawColored(frame.lines->Lines(), GL_LINES, viewProjection, 0.12f);
    glDisable(GL_BLEND);
    ReleaseUnused();
}
