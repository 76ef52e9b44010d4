// Visibility queries: the part of CULLIDE that only GL can do. Triangles go up once; passes of tests and
// renders in a given order come after, one for each view and direction.
#ifndef QC_PLUGIN_GL_VISIBILITY_H
#define QC_PLUGIN_GL_VISIBILITY_H

#include "quickcullide/device.h"

typedef struct qcVisibility qcVisibility;

/// What a pass does to a run of triangles that lie together in memory.
typedef struct qcVisibilityStep
{
    uint32_t firstTriangle, triangleCount;
    /// Test against what was rendered before, with an occlusion query; nothing is drawn.
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

/// `corners`: nine floats a triangle, every coordinate within [-1, 1] (x, y, z as in the world).
/// `resolution`: pixels on a side, at most the device's limit.
qcStatus qcVisibility_Create(qcDevice* device, const float* corners, uint32_t triangleCount, uint32_t resolution,
                             qcVisibility** visibility);
/// As qcVisibility_Create, with the image cut into tiles of this many pixels on a side, on any device.
/// The samples are the same; corners and depths may be rounded differently in the last bit.
qcStatus qcVisibility_CreateTiled(qcDevice* device, const float* corners, uint32_t triangleCount, uint32_t resolution,
                                  uint32_t tileSize, qcVisibility** visibility);
void qcVisibility_Destroy(qcVisibility* visibility);

/// Runs one pass from an empty buffer, looking along `axis` (0, 1, 2). The steps take effect in their order.
/// visible[i] = 1 when step i has its test flag and no fragment of it fails; else 0.
/// Queries are issued all together and read afterwards.
qcStatus qcVisibility_RunPass(qcVisibility* visibility, int axis, qcVisibilityCompare compare,
                              const qcVisibilityStep* steps, uint32_t stepCount, uint8_t* visible);

#endif
