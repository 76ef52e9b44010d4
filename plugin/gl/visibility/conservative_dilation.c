// Dilates triangles by half a pixel and a box, so that sampling at pixel centres loses nothing. After Govindaraju, Lin,
// Manocha: Fast and Reliable Collision Culling Using Graphics Hardware, VRST 2004.
// Proof: plugin/docs/proofs/conservative_dilation.md.
#include "gl/visibility/conservative_dilation.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

// Points of the image are at most this far apart on an axis.
static const double s_maxSize = 2.0;

double qcDilation_InPixels(const qcDilation* dilation, int axis)
{
    return 0.5 * dilation->size[axis] * dilation->resolution + 0.625;
}

typedef struct Dilator
{
    double half[2];    ///< half sizes by which the polygon is larger, in the image's x and y
    double offset[3];  ///< largest offset from the sample to the triangle, in the image's x and y and in depth
    double resolution; ///< pixels
} Dilator;

typedef struct Point
{
    double x, y, z;
} Point;

/// The quadrant of an edge's outward normal, (y, -x) of its direction. A quadrant includes its first half-axis.
static int FindQuadrant(Point from, Point to)
{
    double x = to.y - from.y, y = from.x - to.x;
    if (x > 0.0 && y >= 0.0)
        return 0;
    if (x <= 0.0 && y > 0.0)
        return 1;
    return x < 0.0 && y <= 0.0 ? 2 : 3;
}

/// Adds the box's corners around a corner of a convex polygon, counter-clockwise, from one edge's quadrant to the
/// next's. Returns the number of corners.
static int AddCorner(const Dilator* dilator, Point corner, int quadrant, int nextQuadrant, qcDilatedCorner* dilated,
                     int count)
{
    static const double signX[4] = {1.0, -1.0, -1.0, 1.0}, signY[4] = {1.0, 1.0, -1.0, -1.0};
    for (int q = quadrant;; q = (q + 1) % 4)
    {
        dilated[count].x = (float)(corner.x + signX[q] * dilator->half[0]);
        dilated[count++].y = (float)(corner.y + signY[q] * dilator->half[1]);
        if (q == nextQuadrant)
            return count;
    }
}

/// The border around a triangle whose area has this sign: at most seven corners, three and four quadrant steps.
static int SurroundTriangle(const Dilator* dilator, const Point corners[3], bool clockwise, qcDilatedCorner* dilated)
{
    const Point ring[3] = {corners[0], corners[clockwise ? 2 : 1], corners[clockwise ? 1 : 2]};
    int quadrants[3], count = 0;
    for (int i = 0; i < 3; i++)
        quadrants[i] = FindQuadrant(ring[i], ring[(i + 1) % 3]);
    for (int i = 0; i < 3; i++)
        count = AddCorner(dilator, ring[i], quadrants[(i + 2) % 3], quadrants[i], dilated, count);
    return count;
}

/// The border around the longest edge of a triangle seen edge-on.
static int SurroundEdge(const Dilator* dilator, const Point corners[3], qcDilatedCorner* dilated)
{
    Dilator wider = *dilator;
    wider.half[0] += 0x1p-17;
    wider.half[1] += 0x1p-17;
    Point from = corners[0], to = corners[0];
    double longest = -1.0;
    for (int i = 0; i < 3; i++)
    {
        Point a = corners[i], b = corners[(i + 1) % 3];
        double length = (b.x - a.x) * (b.x - a.x) + (b.y - a.y) * (b.y - a.y);
        if (length > longest)
        {
            longest = length;
            from = a;
            to = b;
        }
    }
    int quadrant = FindQuadrant(from, to), opposite = (quadrant + 2) % 4;
    int count = AddCorner(&wider, from, opposite, quadrant, dilated, 0);
    return AddCorner(&wider, to, quadrant, opposite, dilated, count);
}

/// The depth plane of a triangle of this area (twice, signed). Too steep: the slack stays beyond all depths.
static void FindPlane(const Dilator* dilator, const Point corners[3], double area, qcDilatedCorner* shared)
{
    Point a = corners[0], b = corners[1], c = corners[2];
    double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
    double gx = (uz * vy - vz * uy) / area, gy = (vz * ux - uz * vx) / area;
    double termsX = (fabs(uz * vy) + fabs(vz * uy)) / fabs(area), termsY = (fabs(vz * ux) + fabs(uz * vx)) / fabs(area);
    // A pixel's column and row, plus a half each, are (x + 1) * resolution / 2.
    double base = a.z - gx * a.x - gy * a.y - gx - gy;
    double slack = fabs(gx) * dilator->offset[0] + fabs(gy) * dilator->offset[1] + dilator->offset[2] +
                   0x1p-19 * (fabs(base) + 2.0 * (termsX + termsY) + 1.0);
    if (!(slack <= 2.0))
        return;
    shared->base = (float)base;
    shared->slopeX = (float)(gx * 2.0 / dilator->resolution);
    shared->slopeY = (float)(gy * 2.0 / dilator->resolution);
    shared->slack = (float)slack;
}

static void Dilate(const Dilator* dilator, const Point corners[3], qcDilatedCorner* dilated)
{
    double nearest = fmin(corners[0].z, fmin(corners[1].z, corners[2].z)) - dilator->offset[2];
    double farthest = fmax(corners[0].z, fmax(corners[1].z, corners[2].z)) + dilator->offset[2];
    qcDilatedCorner shared = {
        .nearest = (float)fmax(nearest, -1.0), .farthest = (float)fmin(farthest, 1.0), .slack = 4.0f};

    double ux = corners[1].x - corners[0].x, uy = corners[1].y - corners[0].y;
    double vx = corners[2].x - corners[0].x, vy = corners[2].y - corners[0].y;
    double area = ux * vy - vx * uy;
    bool hasArea = fabs(area) > 0x1p-20 * (fabs(ux * vy) + fabs(vx * uy));
    int count =
        hasArea ? SurroundTriangle(dilator, corners, area < 0.0, dilated) : SurroundEdge(dilator, corners, dilated);
    if (hasArea)
        FindPlane(dilator, corners, area, &shared);
    for (int i = 0; i < qc_dilatedCorners; i++)
    {
        const qcDilatedCorner* corner = &dilated[i < count ? i : count - 1];
        shared.x = corner->x;
        shared.y = corner->y;
        dilated[i] = shared;
    }
}

void qcDilation_Apply(const qcDilation* dilation, const float* corners, uint32_t triangleCount,
                      qcDilatedCorner* dilated)
{
    const int axes[3] = {(dilation->axis + 1) % 3, (dilation->axis + 2) % 3, dilation->axis};
    Dilator dilator = {.resolution = dilation->resolution};
    for (int i = 0; i < 3; i++)
    {
        double size = fmin(dilation->size[axes[i]], s_maxSize);
        dilator.offset[i] = size + (i < 2 ? 1.0 / dilation->resolution + 0x1p-24 : 0x1p-20);
        if (i < 2)
            dilator.half[i] = size + 1.25 / dilation->resolution;
    }
    for (uint32_t t = 0; t < triangleCount; t++)
    {
        Point points[3];
        for (size_t i = 0; i < 3; i++)
        {
            const float* corner = corners + 9 * (size_t)t + 3 * i;
            points[i] = (Point){corner[axes[0]], corner[axes[1]], corner[axes[2]]};
        }
        Dilate(&dilator, points, dilated + qc_dilatedCorners * (size_t)t);
    }
}
