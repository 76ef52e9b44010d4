// Visibility tests without queries: a fragment that fails its test stores a flag for its step. Depth tests are early,
// so that no other fragment does; one draw tests a whole batch, and one wait reads a pass. A triangle that is rendered,
// too, needs no batch of its own: its fragments are counted, then those that pass as it is rendered are taken off.
// Proof: plugin/docs/proofs/counted_tests.md.
#ifndef QC_GL_VISIBILITY_FRAGMENT_FLAGS_H
#define QC_GL_VISIBILITY_FRAGMENT_FLAGS_H

#include "gl/gl_functions.h"
#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"

/// GL objects, and memory retained between passes. All zero at first.
typedef struct qcFragmentFlags
{
    GLuint program, cornerBuffer, polygonBuffer, flagBuffer;
    GLint partUniform;
    qcArray flags; ///< of uint32_t, one a step: 0 if no fragment failed
} qcFragmentFlags;

/// What a fragment that passes the current depth test does.
typedef enum qcFlagPart
{
    qc_flagTest,  ///< flags its step
    qc_flagCount, ///< in a counted polygon: adds one to its step's count
    qc_flagRender ///< in a counted polygon: takes one off that count
} qcFlagPart;

/// Whether the device's vertex and fragment shaders use storage buffers; GL 4.3 has them, but guarantees none there.
bool qcFragmentFlags_AreSupported(const struct qcGlFunctions* gl);

/// Compiles the program and uploads the triangles' corners, nine floats each.
qcStatus qcFragmentFlags_Create(const struct qcGlFunctions* gl, const qcArray* corners, qcFragmentFlags* flags);
void qcFragmentFlags_Delete(const struct qcGlFunctions* gl, const qcFragmentFlags* flags);
void qcFragmentFlags_Free(qcFragmentFlags* flags);

/// Uploads the polygons (of qcSchedulePolygon) and clears the flags. `scale`: of depths.
qcStatus qcFragmentFlags_BeginPass(const struct qcGlFunctions* gl, qcFragmentFlags* flags, const qcArray* polygons,
                                   uint32_t stepCount, int axis, float scale);
/// Draws polygons with the current depth test.
void qcFragmentFlags_Draw(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, size_t first, size_t count,
                          qcFlagPart part);
/// Waits, then sets visible[i] = 0 for each step i with a fragment that failed.
void qcFragmentFlags_Read(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, uint8_t* visible);

#endif
