// A cloth whose vertices are in GL buffers and never leave them: the application's part of qc-gl-cloth, without the
// library.
#ifndef QC_DEMOS_GL_CLOTH_GL_CLOTH_H
#define QC_DEMOS_GL_CLOTH_GL_CLOTH_H

#include "common/message.h"

#include <epoxy/egl.h>
#include <epoxy/gl.h>

enum
{
    qc_kernelCount = 4,
    qc_clothBufferCount = 7,
    qc_clothPositions = 0, ///< buffers of GlCloth that the library sees
    qc_clothPairs = 5
};

typedef struct GlCloth
{
    EGLDisplay display;
    EGLContext context;
    GLuint kernels[qc_kernelCount], buffers[qc_clothBufferCount]; ///< by binding: shaders/cloth.comp
    uint32_t side, vertexCount, triangleCount, pairCapacity;
    float* positions; ///< at the start
    uint32_t* indices;
    double time; ///< seconds
} GlCloth;

/// Opens a context without a window, on `platform`, and the cloth in it. False: the message names the reason.
bool GlCloth_Open(GlCloth* cloth, EGLenum platform, uint32_t side, qcMessage* message);
/// A frame of 1/60 s. Returns a fence behind it.
GLsync GlCloth_Step(GlCloth* cloth);
/// Pushes the triangles of the pairs in their buffer apart.
void GlCloth_Respond(GlCloth* cloth);
/// Reads the positions back, for a picture or a check.
void GlCloth_Read(const GlCloth* cloth, float* positions);
void GlCloth_Close(GlCloth* cloth);

#endif
