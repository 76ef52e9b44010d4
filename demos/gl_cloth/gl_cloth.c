// EGL, buffers and kernels of the cloth.
#include "gl_cloth/gl_cloth.h"

#include "cloth_script.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static bool OpenContext(GlCloth* cloth, EGLenum platform, qcMessage* message)
{
    static const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION_KHR, 4, EGL_CONTEXT_MINOR_VERSION_KHR, 5, EGL_NONE};
    EGLDeviceEXT device = NULL;
    EGLint count = 0;
    if (!epoxy_has_egl() || !epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base"))
        return qcMessage_Fail(message, "there is no EGL with platforms");
    if (platform == EGL_PLATFORM_DEVICE_EXT && (!eglQueryDevicesEXT(1, &device, &count) || count == 0))
        return qcMessage_Fail(message, "EGL lists no GPU");
    cloth->display = eglGetPlatformDisplayEXT(platform, device, NULL);
    if (cloth->display == EGL_NO_DISPLAY || !eglInitialize(cloth->display, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API))
        return qcMessage_Fail(message, "EGL opens no display on this platform");
    cloth->context = eglCreateContext(cloth->display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (cloth->context == EGL_NO_CONTEXT || !eglMakeCurrent(cloth->display, NULL, NULL, cloth->context))
        return qcMessage_Fail(message, "EGL gives no context of GL 4.5");
    return true;
}

static bool BuildKernel(int kernel, GLuint* program, qcMessage* message)
{
    char head[64], log[512] = "";
    GLint linked = GL_FALSE;
    snprintf(head, sizeof head, "#version 430 core\n#define KERNEL %d\n", kernel);
    const char* sources[] = {head, s_clothScript};
    *program = glCreateShaderProgramv(GL_COMPUTE_SHADER, 2, sources);
    glGetProgramiv(*program, GL_LINK_STATUS, &linked);
    if (linked)
        return true;
    glGetProgramInfoLog(*program, sizeof log, NULL, log);
    return qcMessage_Fail(message, "kernel %d: %s", kernel, log);
}

/// A square above the ball, a little tilted, so that it folds.
static bool MakeMesh(GlCloth* cloth, qcMessage* message)
{
    uint32_t side = cloth->side, *index;
    cloth->vertexCount = side * side;
    cloth->triangleCount = 2 * (side - 1) * (side - 1);
    cloth->positions = malloc(3 * sizeof(float) * cloth->vertexCount);
    index = cloth->indices = malloc(3 * sizeof(uint32_t) * cloth->triangleCount);
    if (cloth->positions == NULL || index == NULL)
        return qcMessage_Fail(message, "out of memory");
    for (uint32_t v = 0; v < cloth->vertexCount; v++)
    {
        float x = 2.0f * (float)(v % side) / (float)(side - 1) - 1.0f,
              z = 2.0f * (float)(v / side) / (float)(side - 1) - 1.0f;
        cloth->positions[3 * v] = x + 0.1f;
        cloth->positions[3 * v + 1] = 1.25f + 0.1f * x;
        cloth->positions[3 * v + 2] = z * 0.995f;
    }
    for (uint32_t z = 0; z + 1 < side; z++)
        for (uint32_t x = 0; x + 1 < side; x++, index += 6)
        {
            uint32_t v = z * side + x;
            const uint32_t quad[6] = {v, v + side, v + 1, v + 1, v + side, v + side + 1};
            for (int i = 0; i < 6; i++)
                index[i] = quad[i];
        }
    return true;
}

static void MakeBuffers(GlCloth* cloth)
{
    GLsizeiptr vertices = 3 * (GLsizeiptr)sizeof(float) * cloth->vertexCount;
    cloth->pairCapacity = 4 * cloth->triangleCount;
    glGenBuffers(qc_clothBufferCount, cloth->buffers);
    for (int i = 0; i < qc_clothBufferCount; i++)
    {
        GLsizeiptr size = i < 4    ? vertices
                          : i == 4 ? 4 * (GLsizeiptr)sizeof(int) * cloth->vertexCount
                          : i == 5 ? 4 + 20 * (GLsizeiptr)cloth->pairCapacity
                                   : 3 * (GLsizeiptr)sizeof(uint32_t) * cloth->triangleCount;
        glBindBuffer(GL_SHADER_STORAGE_BUFFER, cloth->buffers[i]);
        glBufferData(GL_SHADER_STORAGE_BUFFER, size,
                     i < 4    ? (void*)cloth->positions
                     : i == 6 ? (void*)cloth->indices
                              : NULL,
                     GL_DYNAMIC_COPY);
    }
    const GLuint zero = 0;
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, cloth->buffers[4]);
    glClearBufferData(GL_SHADER_STORAGE_BUFFER, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
    // The library's context sees a buffer once the commands that made it have finished.
    glFinish();
}

bool GlCloth_Open(GlCloth* cloth, EGLenum platform, uint32_t side, qcMessage* message)
{
    *cloth = (GlCloth){.side = side};
    if (!OpenContext(cloth, platform, message) || !MakeMesh(cloth, message))
        return false;
    for (int kernel = 0; kernel < qc_kernelCount; kernel++)
        if (!BuildKernel(kernel, &cloth->kernels[kernel], message))
            return false;
    MakeBuffers(cloth);
    return true;
}

static void Run(const GlCloth* cloth, int kernel)
{
    GLuint program = cloth->kernels[kernel];
    glUseProgram(program);
    for (GLuint i = 0; i < qc_clothBufferCount; i++)
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, i, cloth->buffers[i]);
    glUniform1ui(glGetUniformLocation(program, "side"), cloth->side);
    glUniform1f(glGetUniformLocation(program, "time"), (float)cloth->time);
    glDispatchCompute((cloth->vertexCount + 63) / 64, 1, 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

GLsync GlCloth_Step(GlCloth* cloth)
{
    enum
    {
        timeSteps = 8, // of 1/480 s
        iterations = 6 // an even number: the result lies in the first buffer again
    };
    for (int step = 0; step < timeSteps; step++)
    {
        Run(cloth, 0);
        for (int i = 0; i < iterations; i++)
        {
            Run(cloth, 1);
            GLuint next = cloth->buffers[2];
            cloth->buffers[2] = cloth->buffers[qc_clothPositions];
            cloth->buffers[qc_clothPositions] = next;
        }
        cloth->time += 1.0 / 480.0;
    }
    GLsync fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    glFlush();
    return fence;
}

void GlCloth_Respond(GlCloth* cloth)
{
    Run(cloth, 2);
    Run(cloth, 3);
}

void GlCloth_Read(const GlCloth* cloth, float* positions)
{
    glBindBuffer(GL_SHADER_STORAGE_BUFFER, cloth->buffers[qc_clothPositions]);
    glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, 3 * (GLsizeiptr)sizeof(float) * cloth->vertexCount, positions);
}

void GlCloth_Close(GlCloth* cloth)
{
    free(cloth->positions);
    free(cloth->indices);
    if (cloth->context == EGL_NO_CONTEXT)
        return;
    eglMakeCurrent(cloth->display, NULL, NULL, EGL_NO_CONTEXT);
    eglDestroyContext(cloth->display, cloth->context);
}
