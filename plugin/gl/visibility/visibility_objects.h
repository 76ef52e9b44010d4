// What visibility tests keep on the device: programs, buffers, the image. How each test gets its result.
#ifndef QC_GL_VISIBILITY_VISIBILITY_OBJECTS_H
#define QC_GL_VISIBILITY_VISIBILITY_OBJECTS_H

#include "gl/visibility/fragment_flags.h"
#include "gl/visibility/sure_kernels.h"
#include "gl/visibility/tile_schedule.h"

/// How tests get their results. The results are the same.
typedef enum qcVisibilityWay
{
    qc_wayDefault, ///< sure results: the processor finds them for software devices, else the device
    qc_wayQueries, ///< a query for each test
    qc_wayFlags,   ///< flags stored by fragments; queries where the device can't
    qc_waySure,    ///< the same for the tests that geometry leaves open
    qc_wayComputed ///< the same, and the device finds what is sure; flags alone where it can't
} qcVisibilityWay;

struct qcVisibility
{
    qcDevice* device;
    uint32_t generation;            ///< of the device
    const struct qcGlFunctions* gl; ///< while work runs on the device's thread; else null
    bool isSoftware;
    qcVisibilityWay way;
    uint32_t resolution, tileSize;
    bool isDilated;

    const float* corners;
    uint32_t triangleCount;
    double dilation[3];
    bool isUploaded; ///< the corners are on the device
    qcArray dilated; ///< of qcDilatedCorner, for one axis
    int dilatedAxis; ///< the axis of those on the device, or -1

    qcTileSchedule schedule;
    qcSureResults sure;
    bool storesFlags;          ///< and issues no queries
    uint32_t maxFlagTriangles; ///< with more, it can't
    qcFragmentFlags flags;
    bool computesSure; ///< the device finds what is sure
    qcSureKernels kernels;
    GLuint vertexArray, framebuffer, depthBuffer;
    GLuint program, vertexBuffer, indexBuffer; ///< of queries
    GLint axisUniform, scaleUniform, tileUniform;
    qcArray queries; ///< of GLuint
};

/// Whether the processor finds what is sure. On software GL nothing is as fast as not drawing.
bool qcVisibilityObjects_WantSure(const qcVisibility* visibility);

/// Jobs of the device; the context is a qcVisibility.
qcStatus qcVisibilityObjects_Create(const struct qcGlFunctions* gl, void* visibility);
qcStatus qcVisibilityObjects_Delete(const struct qcGlFunctions* gl, void* visibility);

/// In a job: uploads the triangles, dilated ones for the axis. Nothing if they are there.
void qcVisibilityObjects_Upload(const struct qcGlFunctions* gl, qcVisibility* visibility, int axis);

#endif
