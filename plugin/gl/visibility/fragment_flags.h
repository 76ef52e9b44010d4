// Visibility tests without queries: a fragment that fails its test stores a flag for its step. Depth tests are early,
// so that no other fragment does; one draw tests a whole batch, and one wait reads a pass. A triangle that is rendered,
// too, needs no batch of its own: its fragments are counted, then those that pass as it is rendered are taken off.
// Proof: plugin/docs/proofs/counted_tests.md. Fragments of dilated triangles compute their depths, so that no test is
// early: they keep the depths in a buffer and compare them themselves.
#ifndef QC_GL_VISIBILITY_FRAGMENT_FLAGS_H
#define QC_GL_VISIBILITY_FRAGMENT_FLAGS_H

#include "gl/gl_functions.h"
#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"

/// GL objects, and memory retained between passes. All zero at first.
typedef struct qcFragmentFlags
{
    GLuint program, endProgram, cornerBuffer, polygonBuffer, flagBuffer;
    GLuint depthBuffer; ///< of dilated triangles: a tile's depths, the bits of floats
    uint32_t tileSize;  ///< of these
    GLint axisUniform, greaterUniform, partUniform, scaleUniform, tileSizeUniform, tileUniform, endUniform, runUniform;
    uint32_t runNumber;  ///< of the last pass
    GLsizei vertexCount; ///< of a polygon
    qcArray flags;       ///< of uint32_t, one a step: 0 if no fragment failed; then the number of the pass
} qcFragmentFlags;

/// What a fragment that passes the current depth test does.
typedef enum qcFlagPart
{
    qc_flagTest,  ///< flags its step
    qc_flagCount, ///< in a counted polygon: adds one to its step's count
    qc_flagRender ///< in a counted polygon: takes one off that count
} qcFlagPart;

/// Whether the device's vertex and fragment shaders use storage buffers, which GL 4.3 doesn't guarantee.
/// `maxTriangles`: those of whose buffers they reach all: what is beyond a device's limit reads as anything, such as
/// visible.
bool qcFragmentFlags_AreSupported(const struct qcGlFunctions* gl, bool dilated, uint32_t* maxTriangles);

/// Compiles the program. `tileSize`: of dilated triangles' depths; 0: triangles are not dilated.
qcStatus qcFragmentFlags_Create(const struct qcGlFunctions* gl, uint32_t tileSize, qcFragmentFlags* flags);
/// Uploads nine floats a triangle, or qc_dilatedCorners of qcDilatedCorner.
void qcFragmentFlags_SetCorners(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, const void* corners,
                                size_t bytes);
void qcFragmentFlags_Delete(const struct qcGlFunctions* gl, const qcFragmentFlags* flags);
void qcFragmentFlags_Free(qcFragmentFlags* flags);

typedef struct qcFlagPass
{
    const qcArray* polygons; ///< of qcSchedulePolygon
    uint32_t stepCount;
    int axis;
    float scale;  ///< of depths
    bool greater; ///< dilated triangles: the test fails at greater depths, not at equal ones
} qcFlagPass;

/// Uploads the polygons and clears the flags.
qcStatus qcFragmentFlags_BeginPass(const struct qcGlFunctions* gl, qcFragmentFlags* flags, const qcFlagPass* pass);
/// Clears the depths of dilated triangles.
void qcFragmentFlags_BeginTile(const struct qcGlFunctions* gl, const qcFragmentFlags* flags);
/// Draws polygons with the current depth test.
void qcFragmentFlags_Draw(const struct qcGlFunctions* gl, const qcFragmentFlags* flags, size_t first, size_t count,
                          qcFlagPart part);
/// Waits, then fills flags->flags. Fails if the device has not come to the end of the pass.
qcStatus qcFragmentFlags_Read(const struct qcGlFunctions* gl, qcFragmentFlags* flags);

#endif
