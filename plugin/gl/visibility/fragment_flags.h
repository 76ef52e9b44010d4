// Visibility tests without queries: a fragment that fails its test stores a flag for its step. Depth tests are early,
// so that no other fragment does; one draw tests a whole batch, and one wait reads a pass.
#ifndef QC_GL_VISIBILITY_FRAGMENT_FLAGS_H
#define QC_GL_VISIBILITY_FRAGMENT_FLAGS_H

#include "gl/gl_functions.h"
#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"

/// GL objects, and memory retained between passes. All zero at first.
typedef struct qcFragmentFlags
{
    GLuint program, cornerBuffer, polygonBuffer, flagBuffer;
    GLint testsUniform;
    qcArray flags; ///< of uint32_t, one a step
} qcFragmentFlags;

/// Whether the device's vertex and fragment shaders use storage buffers; GL 4.3 has them, but guarantees none there.
bool qcFragmentFlags_AreSupported(const struct qcGlFunctions* gl);

/// Compiles the program and uploads the triangles' corners, nine floats each.
qcStatus qcFragmentFlags_Create(const struct qcGlFunctions* gl, const qcArray* corners, qcFragmentFlags* flags);
void qcFragmentFlags_Delete(const struct qcGlFunctions* gl, const qcFragmentFlags* flags);
void qcFragmentFlags_Free(qcFragmentFlags* flags);

/// Uploads the polygons (of qcSchedulePolygon) and clears the flags. `scale`: of depths.
qcStatus qcFragmentFlags_BeginPass(const struct qcGlFunctions* gl, qcFragmentFlags* flags, const qcArray* polygons,
                                   uint32_t stepCount, int axis, float scale);
/// Draws polygons with the current depth test; those that `test` store the flags of their steps.
void qcFragmentFlags_Draw(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, size_t first, size_t count,
                          bool test);
/// Waits, then sets visible[i] = 0 for each step i with a fragment that failed.
void qcFragmentFlags_Read(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, uint8_t* visible);

#endif
