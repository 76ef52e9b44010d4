// Conservative dilation of triangles: polygons and depth intervals that lose nothing to sampling at pixel centres.
#ifndef QC_GL_VISIBILITY_CONSERVATIVE_DILATION_H
#define QC_GL_VISIBILITY_CONSERVATIVE_DILATION_H

#include <stdint.h>

enum
{
    qc_dilatedCorners = 7 ///< of a polygon; unused corners repeat the last one
};

/// A corner of a dilated triangle's polygon. All fields but x and y are the triangle's.
typedef struct qcDilatedCorner
{
    float x, y;              ///< in the image, which is [-1, 1] in both
    float nearest, farthest; ///< bounds of all its depths
    /// At the centre of pixel (column, row) depths are within base + slope . (column + 1/2, row + 1/2) +- slack.
    float base, slopeX, slopeY, slack;
} qcDilatedCorner;

typedef struct qcDilation
{
    int axis;            ///< of view: 0, 1, 2; the image's x is the next axis in cyclic order
    uint32_t resolution; ///< pixels on a side of the image, 1..4096
    double size[3];      ///< half sizes of the box around each point, in x, y and z; 0 or more
} qcDilation;

/// Distance, in pixels along an axis of the image, by which a dilated triangle's pixels may lie beyond it.
double qcDilation_InPixels(const qcDilation* dilation, int axis);

/// Dilates triangles. `corners`: nine floats a triangle, within [-1, 1]. Fills qc_dilatedCorners corners a triangle, to
/// be drawn as a fan. O(triangleCount).
void qcDilation_Apply(const qcDilation* dilation, const float* corners, uint32_t triangleCount,
                      qcDilatedCorner* dilated);

#endif
