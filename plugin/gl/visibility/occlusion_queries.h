// Visibility tests of CULLIDE. Triangles are uploaded once. Each pass, for a view and a direction, tests and renders
// them in a given order.
#ifndef QC_GL_VISIBILITY_OCCLUSION_QUERIES_H
#define QC_GL_VISIBILITY_OCCLUSION_QUERIES_H

#include "quickcullide/device.h"

typedef struct qcVisibility qcVisibility;

/// What a pass does to a range of triangles.
typedef struct qcVisibilityStep
{
    uint32_t firstTriangle, triangleCount;
    /// Test against the depths rendered so far; nothing is drawn.
    bool test;
    /// Then draw into the depth buffer, keeping the nearest depth.
    bool render;
} qcVisibilityStep;

typedef enum qcVisibilityCompare
{
    /// Between objects (section 3.1): fully visible when no fragment has a depth greater than or equal to the buffer's.
    qc_compareGreaterEqual = 0,
    /// Within an object (section 3.2): fully visible when no fragment has a depth greater than the buffer's.
    qc_compareGreater = 1
} qcVisibilityCompare;

typedef struct qcVisibilityDef
{
    qcDevice* device;
    /// Nine floats a triangle, every coordinate within [-1, 1] (x, y, z as in the world). Read by each pass.
    const float* corners;
    uint32_t triangleCount;
    uint32_t resolution; ///< pixels on a side, at most the device's limit
    /// The image is drawn in tiles of this many pixels on a side; 0: the device's default. Samples don't depend on it;
    /// corners and depths may be rounded differently in the last bit.
    uint32_t tileSize;
    /// Dilate each triangle by half a pixel and by a box of these half sizes. No point is then within the half sizes of
    /// both a fully visible triangle and a rendered one. Proof: plugin/docs/proofs/conservative_dilation.md.
    bool dilated;
    double dilation[3];
} qcVisibilityDef;

/// Prepares tests of these triangles. `visibility`: null, or made before for other triangles; then its memory and its
/// GL objects are kept where they fit. On failure it may be the old one or null.
qcStatus qcVisibility_Prepare(const qcVisibilityDef* def, qcVisibility** visibility);
/// Before the device's.
void qcVisibility_Destroy(qcVisibility* visibility);

typedef struct qcVisibilityPass
{
    int axis; ///< of view: 0, 1, 2
    qcVisibilityCompare compare;
    /// View from the other side: rendering keeps the farthest depth, and fully visible means fully behind.
    bool fromBack;
} qcVisibilityPass;

/// Work that runs passes, on the device's thread.
typedef qcStatus qcVisibilityWork(void* context);

/// Runs work and waits for it: threads change once for all its passes. GL's errors are found at its end.
qcStatus qcVisibility_Run(qcVisibility* visibility, qcVisibilityWork* work, void* context);

/// Runs one pass from an empty buffer. The steps take effect in their order.
/// visible[i] = 1 when step i has its test flag and no fragment of it fails; else 0.
/// All tests are issued before results are read.
qcStatus qcVisibility_RunPass(qcVisibility* visibility, const qcVisibilityPass* pass, const qcVisibilityStep* steps,
                              uint32_t stepCount, uint8_t* visible);

#endif
