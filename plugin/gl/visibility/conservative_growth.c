// Grows triangles by half a pixel and a box. Govindaraju, Lin, Manocha: Fast and Reliable Collision Culling Using
// Graphics Hardware, VRST 2004, with planes for depths instead of the faces of the Minkowski sum.
//
// Coordinates are the image's: the scene is within [-1, 1], a pixel 2 / resolution wide and at least 2^-11. A corner in
// memory is within 2^-24 of the true one. T is a true triangle, t the one in memory, m a point of the image within the
// half sizes `size` of a point of T, and c the centre of a pixel that holds m (its border included). To show:
// (1) the sample at c gets a fragment of t's polygon; (2) the depths `nearest` and `farthest` of that fragment, as
// gl/visibility/occlusion_queries.c draws them, enclose the depth of m. So two triangles with such a point m in common,
// and those no further apart than twice `size` have one half-way, have a pixel in common in which their depth intervals
// overlap.
//
// (1) The polygon is t and all within `half` = size + half a pixel + an eighth of a pixel of it, in x and y each; c is
// inside, an eighth of a pixel less 2^-24 away from its border. A corner of the polygon is off by 2^-22 in float, and
// by what the rasteriser rounds: GL demands 4 bits of subpixel, 1/16 pixel. In sum that is less. So while the corners
// move to where the rasteriser sees them, the border never crosses c and still winds around it once; and the signed
// areas of the fan's triangles add up to the winding number, so that one of them holds c. A sample on a border counts
// as moved by something infinitely small, always the same, and nothing changes; what GL cuts off lies outside the
// image, and c does not. A triangle seen edge-on, or nearly, has no orientation that can be trusted (|area| <= 2^-20 of
// its terms): its third corner lies beside its longest edge, no farther off than |area| / length <= 2^-19 * length <
// 2^-17, so that the edge, grown by that much more, holds it all.
//
// (2) m is at most `size` + 2^-24 above or below some point of t, and that one is no farther than `way` = size + half a
// pixel + 2^-24 from c in x and y. On a plane z = base + gx x + gy y, depth changes by |gx| way.x + |gy| way.y at most
// over it. Where the area is above the bound, the slopes are off by 2^-30 of E, the sum of the magnitudes of their
// terms; the device's float arithmetic adds at most 2^-21 (|base| + 2 Ex + 2 Ey + 2). `slack` covers these with 2^-19.
// Steep planes have a slack beyond all depths and leave the answer to the nearest and farthest corner, which hold for
// every plane; 2^-20 covers how these and the drawn depth are rounded. m itself lies within [-1, 1], where depths are
// cut off.
#include "gl/visibility/conservative_growth.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

// More never matters: two points of the image are no farther apart.
static const double s_largest = 2.0;

double qcGrowth_GetReach(const qcGrowth* growth, int axis)
{
    return 0.5 * growth->size[axis] * growth->resolution + 0.625;
}

typedef struct Grower
{
    double half[2];    ///< of the polygon, in the image's x and y
    double way[3];     ///< from the sample to the triangle, in the image's x and y and in depth
    double resolution; ///< pixels
} Grower;

typedef struct Point
{
    double x, y, z;
} Point;

/// The quadrant of an edge's outward normal, (y, -x) of its direction; the four in turn, each with its first half-axis.
static int FindQuadrant(Point from, Point to)
{
    double x = to.y - from.y, y = from.x - to.x;
    if (x > 0.0 && y >= 0.0)
        return 0;
    if (x <= 0.0 && y > 0.0)
        return 1;
    return x < 0.0 && y <= 0.0 ? 2 : 3;
}

/// Goes around a convex polygon, counter-clockwise: at a corner the box's corners from one edge's quadrant to the
/// next's. Returns how many corners there are now.
static int AddCorner(const Grower* grower, Point corner, int quadrant, int nextQuadrant, qcGrownCorner* grown,
                     int count)
{
    static const double signX[4] = {1.0, -1.0, -1.0, 1.0}, signY[4] = {1.0, 1.0, -1.0, -1.0};
    for (int q = quadrant;; q = (q + 1) % 4)
    {
        grown[count].x = (float)(corner.x + signX[q] * grower->half[0]);
        grown[count++].y = (float)(corner.y + signY[q] * grower->half[1]);
        if (q == nextQuadrant)
            return count;
    }
}

/// The border around a triangle whose area has this sign. Four steps of a quadrant and three corners: seven.
static int SurroundTriangle(const Grower* grower, const Point corners[3], bool clockwise, qcGrownCorner* grown)
{
    const Point ring[3] = {corners[0], corners[clockwise ? 2 : 1], corners[clockwise ? 1 : 2]};
    int quadrants[3], count = 0;
    for (int i = 0; i < 3; i++)
        quadrants[i] = FindQuadrant(ring[i], ring[(i + 1) % 3]);
    for (int i = 0; i < 3; i++)
        count = AddCorner(grower, ring[i], quadrants[(i + 2) % 3], quadrants[i], grown, count);
    return count;
}

/// The border around the longest edge of a triangle that is hardly more than that, or a point.
static int SurroundEdge(const Grower* grower, const Point corners[3], qcGrownCorner* grown)
{
    Grower wider = *grower;
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
    int count = AddCorner(&wider, from, opposite, quadrant, grown, 0);
    return AddCorner(&wider, to, quadrant, opposite, grown, count);
}

/// The plane of a triangle of this area (twice, signed), or none: any slack beyond 2 says nothing.
static void FindPlane(const Grower* grower, const Point corners[3], double area, qcGrownCorner* shared)
{
    Point a = corners[0], b = corners[1], c = corners[2];
    double ux = b.x - a.x, uy = b.y - a.y, uz = b.z - a.z, vx = c.x - a.x, vy = c.y - a.y, vz = c.z - a.z;
    double gx = (uz * vy - vz * uy) / area, gy = (vz * ux - uz * vx) / area;
    double termsX = (fabs(uz * vy) + fabs(vz * uy)) / fabs(area), termsY = (fabs(vz * ux) + fabs(uz * vx)) / fabs(area);
    // The pixel's column and row, each with a half, are (x + 1) * resolution / 2.
    double base = a.z - gx * a.x - gy * a.y - gx - gy;
    double slack = fabs(gx) * grower->way[0] + fabs(gy) * grower->way[1] + grower->way[2] +
                   0x1p-19 * (fabs(base) + 2.0 * (termsX + termsY) + 1.0);
    if (!(slack <= 2.0))
        return;
    shared->base = (float)base;
    shared->slopeX = (float)(gx * 2.0 / grower->resolution);
    shared->slopeY = (float)(gy * 2.0 / grower->resolution);
    shared->slack = (float)slack;
}

static void Grow(const Grower* grower, const Point corners[3], qcGrownCorner* grown)
{
    double nearest = fmin(corners[0].z, fmin(corners[1].z, corners[2].z)) - grower->way[2];
    double farthest = fmax(corners[0].z, fmax(corners[1].z, corners[2].z)) + grower->way[2];
    qcGrownCorner shared = {
        .nearest = (float)fmax(nearest, -1.0), .farthest = (float)fmin(farthest, 1.0), .slack = 4.0f};

    double ux = corners[1].x - corners[0].x, uy = corners[1].y - corners[0].y;
    double vx = corners[2].x - corners[0].x, vy = corners[2].y - corners[0].y;
    double area = ux * vy - vx * uy;
    bool hasArea = fabs(area) > 0x1p-20 * (fabs(ux * vy) + fabs(vx * uy));
    int count = hasArea ? SurroundTriangle(grower, corners, area < 0.0, grown) : SurroundEdge(grower, corners, grown);
    if (hasArea)
        FindPlane(grower, corners, area, &shared);
    for (int i = 0; i < qc_grownCorners; i++)
    {
        const qcGrownCorner* place = &grown[i < count ? i : count - 1];
        shared.x = place->x;
        shared.y = place->y;
        grown[i] = shared;
    }
}

void qcGrowth_Apply(const qcGrowth* growth, const float* corners, uint32_t triangleCount, qcGrownCorner* grown)
{
    const int axes[3] = {(growth->axis + 1) % 3, (growth->axis + 2) % 3, growth->axis};
    Grower grower = {.resolution = growth->resolution};
    for (int i = 0; i < 3; i++)
    {
        double size = fmin(growth->size[axes[i]], s_largest);
        grower.way[i] = size + (i < 2 ? 1.0 / growth->resolution + 0x1p-24 : 0x1p-20);
        if (i < 2)
            grower.half[i] = size + 1.25 / growth->resolution;
    }
    for (uint32_t t = 0; t < triangleCount; t++)
    {
        Point points[3];
        for (int i = 0; i < 3; i++)
        {
            const float* corner = corners + 9 * (size_t)t + 3 * i;
            points[i] = (Point){corner[axes[0]], corner[axes[1]], corner[axes[2]]};
        }
        Grow(&grower, points, grown + qc_grownCorners * (size_t)t);
    }
}
