// Triangles grown to all that they may touch: polygons and depths that lose nothing to the sampling at pixel centres.
#ifndef QC_GL_VISIBILITY_CONSERVATIVE_GROWTH_H
#define QC_GL_VISIBILITY_CONSERVATIVE_GROWTH_H

#include <stdint.h>

enum
{
    qc_grownCorners = 7 ///< of a polygon; corners it does not need repeat its last one
};

/// A corner of the polygon that a grown triangle may touch. All but x and y are those of the triangle.
typedef struct qcGrownCorner
{
    float x, y;              ///< in the image, which is [-1, 1] in both
    float nearest, farthest; ///< no depth of the triangle lies outside
    /// At the centre of pixel (column, row) its depths are within base + slope . (column + 1/2, row + 1/2) +- slack.
    float base, slopeX, slopeY, slack;
} qcGrownCorner;

typedef struct qcGrowth
{
    int axis;            ///< looked along (0, 1, 2); the image's x is the next axis in cyclic order
    uint32_t resolution; ///< pixels on a side of the image, 1..4096
    double size[3];      ///< half sizes of the box around each point, in x, y and z; 0 or more
} qcGrowth;

/// How far a grown triangle's pixels reach beyond it, along an axis of the image, in pixels.
double qcGrowth_GetReach(const qcGrowth* growth, int axis);

/// `corners`: nine floats a triangle, within [-1, 1]. Fills qc_grownCorners corners a triangle, to be drawn as a fan.
void qcGrowth_Apply(const qcGrowth* growth, const float* corners, uint32_t triangleCount, qcGrownCorner* grown);

#endif
