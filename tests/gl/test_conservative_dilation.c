// Conservative dilation: triangles within the dilation of one point are never fully visible, wherever that point lies
// between the samples. The point is chosen first; triangles of every shape are then placed through it.
#include "support/devices.h"
#include "gl/visibility/conservative_dilation.h"
#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"
#include "support/soups.h"
#include "support/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

//  ---- triangles -----------------------------------------------------------------------------------

typedef enum Shape
{
    shape_general,
    shape_sliver,    ///< the third corner next to the line through the others
    shape_edgeOn,    ///< the third corner above the line through the others
    shape_alongAxes, ///< an edge along an axis
    shape_segment,
    shape_point,
    shape_count
} Shape;

/// 2^lower .. 2^upper, uniform in the exponent.
static double Magnitude(qcRandom* random, double lower, double upper)
{
    return exp2(qcRandom_Uniform(random, lower, upper));
}

/// A triangle around the origin, seen along `axis`.
static void MakeTriangle(qcRandom* random, Shape shape, int axis, double size, double t[3][3])
{
    for (int i = 0; i < 9; i++)
        t[i / 3][i % 3] = qcRandom_Uniform(random, -size, size);
    double share = qcRandom_Uniform(random, 0.0, 1.0), off = size * Magnitude(random, -40.0, -5.0);
    for (int k = 0; k < 3; k++)
    {
        double between = t[0][k] + share * (t[1][k] - t[0][k]);
        switch (shape)
        {
            case shape_sliver: t[2][k] = between + qcRandom_Uniform(random, -off, off); break;
            case shape_edgeOn: t[2][k] = k == axis ? t[2][k] : between; break;
            case shape_alongAxes: t[1][k] = k == (axis + 1) % 3 ? t[1][k] : t[0][k]; break;
            case shape_segment: t[2][k] = t[1][k]; break;
            case shape_point: t[2][k] = t[1][k] = t[0][k]; break;
            default: break;
        }
    }
}

/// Moves a triangle so that a random point of it, often on its border, is at `to`.
static void PutThrough(qcRandom* random, const double to[3], double t[3][3])
{
    double weights[3] = {qcRandom_Uniform(random, 0.0, 1.0), qcRandom_Uniform(random, 0.0, 1.0), 1.0};
    for (int i = 0; i < 2; i++)
        if (qcRandom_Below(random, 3) == 0)
            weights[i] = 0.0;
    if (weights[0] + weights[1] > 0.0 && qcRandom_Below(random, 3) == 0)
        weights[2] = 0.0;
    double sum = weights[0] + weights[1] + weights[2];
    for (int k = 0; k < 3; k++)
    {
        double at = (weights[0] * t[0][k] + weights[1] * t[1][k] + weights[2] * t[2][k]) / sum;
        for (int i = 0; i < 3; i++)
            t[i][k] += to[k] - at;
    }
}

static bool IsInImage(const double t[3][3])
{
    for (int i = 0; i < 9; i++)
        if (fabs(t[i / 3][i % 3]) > 1.0)
            return false;
    return true;
}

/// A triangle in the image with a point within `dilation` of m in each axis.
static Shape MakeNear(qcRandom* random, int axis, const double dilation[3], const double m[3], double t[3][3])
{
    for (double largest = 0.0;; largest -= 0.5) // a triangle that is small enough fits
    {
        Shape shape = (Shape)qcRandom_Below(random, shape_count);
        double to[3];
        for (int k = 0; k < 3; k++)
        {
            double side = qcRandom_Below(random, 3) == 0 ? 1.0 : qcRandom_Uniform(random, 0.0, 1.0);
            to[k] = m[k] + (qcRandom_Below(random, 2) == 0 ? side : -side) * dilation[k];
            to[k] = to[k] < -1.0 ? -1.0 : to[k] > 1.0 ? 1.0 : to[k];
        }
        MakeTriangle(random, shape, axis, Magnitude(random, largest - 16.0, largest), t);
        PutThrough(random, to, t);
        if (IsInImage(t))
            return shape;
    }
}

static void MakeDilation(qcRandom* random, double dilation[3])
{
    uint32_t kind = qcRandom_Below(random, 3);
    double all = Magnitude(random, -20.0, -1.0);
    for (int k = 0; k < 3; k++)
        dilation[k] = kind == 0 ? 0.0 : kind == 1 ? all : Magnitude(random, -20.0, 2.0);
}

/// A point of the image; often on the border of a pixel, or at its centre, or at the image's border.
static void MakePoint(qcRandom* random, uint32_t resolution, double m[3])
{
    for (int k = 0; k < 3; k++)
    {
        double pixel = qcRandom_Below(random, resolution), part = qcRandom_Uniform(random, 0.0, 1.0);
        uint32_t kind = qcRandom_Below(random, 4);
        part = kind == 0 ? 0.0 : kind == 1 ? 0.5 : kind == 2 ? 1.0 : part;
        m[k] = (pixel + part) * 2.0 / resolution - 1.0;
    }
}

static void Store(const double t[3][3], float* corners)
{
    for (int i = 0; i < 9; i++)
        corners[i] = (float)t[i / 3][i % 3];
}

static const uint32_t s_resolutions[] = {1, 2, 7, 64, 256, 1000, 4096};

enum
{
    qc_resolutionCount = sizeof s_resolutions / sizeof s_resolutions[0]
};

//  ---- polygons and depths -------------------------------------------------------------------------

/// Winding number of a polygon around a point.
static int WindAround(const qcDilatedCorner* ring, double x, double y)
{
    int winding = 0;
    for (int i = 0; i < qc_dilatedCorners; i++)
    {
        const qcDilatedCorner *a = &ring[i], *b = &ring[(i + 1) % qc_dilatedCorners];
        bool aboveA = a->y > y, aboveB = b->y > y;
        double side = ((double)b->x - a->x) * (y - a->y) - (x - a->x) * ((double)b->y - a->y);
        winding += !aboveA && aboveB && side > 0.0;
        winding -= aboveA && !aboveB && side < 0.0;
    }
    return winding;
}

START_TEST(each_pixel_near_a_triangle_lies_well_inside_its_polygon_and_its_depths_hold)
{
    static int shapes[shape_count];
    qcRandom random = {31};
    for (int round = 0; round < 100000; round++)
    {
        qcDilation dilation = {.axis = (int)qcRandom_Below(&random, 3),
                               .resolution = s_resolutions[qcRandom_Below(&random, qc_resolutionCount)]};
        int axes[3] = {(dilation.axis + 1) % 3, (dilation.axis + 2) % 3, dilation.axis};
        double m[3], t[3][3];
        MakeDilation(&random, dilation.size);
        MakePoint(&random, dilation.resolution, m);
        shapes[MakeNear(&random, dilation.axis, dilation.size, m, t)]++;
        float corners[9];
        Store(t, corners);
        qcDilatedCorner ring[qc_dilatedCorners];
        qcDilation_Apply(&dilation, corners, 1, ring);

        // A pixel that contains m, and points nearly an eighth of a pixel around its centre: GL rounds by less.
        double pixel = 2.0 / dilation.resolution, at[2], place[2];
        for (int k = 0; k < 2; k++)
        {
            place[k] = floor((m[axes[k]] + 1.0) / pixel - qcRandom_Below(&random, 2) * 1e-9);
            place[k] = fmin(fmax(place[k], 0.0), dilation.resolution - 1.0) + 0.5;
            at[k] = place[k] * pixel - 1.0;
        }
        for (int k = 0; k < 4; k++)
            ck_assert_msg(WindAround(ring, at[0] + (k & 1 ? 0.124 : -0.124) * pixel,
                                     at[1] + (k & 2 ? 0.124 : -0.124) * pixel) == 1,
                          "round %d: outside", round);
        for (int i = 0; i < qc_dilatedCorners; i++)
        {
            // The arithmetic of the fragment shader.
            float depth = ring[i].base + ring[i].slopeX * (float)place[0] + ring[i].slopeY * (float)place[1];
            float nearest = fminf(fmaxf(depth - ring[i].slack, ring[i].nearest), ring[i].farthest);
            float farthest = fminf(fmaxf(depth + ring[i].slack, ring[i].nearest), ring[i].farthest);
            ck_assert_msg(nearest <= m[axes[2]] && m[axes[2]] <= farthest, "round %d: %.9g is not within %.9g .. %.9g",
                          round, m[axes[2]], nearest, farthest);
        }
    }
    for (int shape = 0; shape < shape_count; shape++)
        ck_assert_int_gt(shapes[shape], 1000);
}
END_TEST

START_TEST(a_polygon_covers_no_more_than_its_triangle_dilated_by_a_pixel)
{
    qcRandom random = {37};
    for (int round = 0; round < 20000; round++)
    {
        qcDilation dilation = {.axis = 2, .resolution = s_resolutions[qcRandom_Below(&random, qc_resolutionCount)]};
        double m[3], t[3][3], pixel = 2.0 / dilation.resolution;
        const double none[3] = {0.0, 0.0, 0.0};
        MakeDilation(&random, dilation.size);
        MakePoint(&random, dilation.resolution, m);
        MakeNear(&random, 2, none, m, t);
        float corners[9];
        Store(t, corners);
        qcDilatedCorner ring[qc_dilatedCorners];
        qcDilation_Apply(&dilation, corners, 1, ring);
        // Its extent in 16 directions.
        for (int direction = 0; direction < 16; direction++)
        {
            double nx = cos(direction * 0.39269908), ny = sin(direction * 0.39269908), triangle = -9.0, polygon = -9.0;
            for (int i = 0; i < 3; i++)
                triangle = fmax(triangle, nx * corners[3 * i] + ny * corners[3 * i + 1]);
            for (int i = 0; i < qc_dilatedCorners; i++)
                polygon = fmax(polygon, nx * ring[i].x + ny * ring[i].y);
            double max = fabs(nx) * (fmin(dilation.size[0], 2.0) + 0.65 * pixel) +
                         fabs(ny) * (fmin(dilation.size[1], 2.0) + 0.65 * pixel);
            ck_assert_msg(polygon <= triangle + max, "round %d: %g beyond %g", round, polygon - triangle, max);
        }
    }
}
END_TEST

//  ---- visibility ----------------------------------------------------------------------------------

/// True if the first triangle of two is fully visible after the second is rendered.
static bool IsVisible(qcDevice* device, const qcVisibilityDef* def, int axis, bool fromBack)
{
    const qcVisibilityStep steps[2] = {{1, 1, false, true}, {0, 1, true, false}};
    const qcVisibilityPass pass = {axis, qc_compareGreaterEqual, fromBack};
    qcVisibilityDef here = *def;
    here.device = device;
    qcVisibility* visibility = NULL;
    uint8_t visible[2];
    ck_assert_msg(qcVisibility_Prepare(&here, &visibility) == qc_statusOk, "%s", qcLastMessage());
    ck_assert_msg(qcVisibility_RunPass(visibility, &pass, steps, 2, visible) == qc_statusOk, "%s", qcLastMessage());
    qcVisibility_Destroy(visibility);
    return visible[1] != 0;
}

START_TEST(triangles_within_the_dilation_of_one_point_hide_each_other_from_both_sides)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcRandom random = {41};
        for (int round = 0; round < 700; round++)
        {
            uint32_t resolution = s_resolutions[qcRandom_Below(&random, qc_resolutionCount)];
            int axis = (int)qcRandom_Below(&random, 3);
            double m[3], t[2][3][3];
            qcVisibilityDef def = {.triangleCount = 2,
                                   .resolution = resolution,
                                   .tileSize = resolution < 100 ? 1 + qcRandom_Below(&random, resolution) : 0,
                                   .dilated = true};
            MakeDilation(&random, def.dilation);
            MakePoint(&random, resolution, m);
            float corners[18];
            int shapes[2];
            for (int i = 0; i < 2; i++)
            {
                shapes[i] = (int)MakeNear(&random, axis, def.dilation, m, t[i]);
                Store(t[i], corners + 9 * i);
            }
            def.corners = corners;
            for (int fromBack = 0; fromBack < 2; fromBack++)
                ck_assert_msg(!IsVisible(device, &def, axis, fromBack == 1),
                              "round %d: shapes %d and %d, %u pixels, from the %s: visible", round, shapes[0],
                              shapes[1], resolution, fromBack ? "back" : "front");
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(parallel_planes_separate_as_soon_as_their_gap_exceeds_the_dilation_and_a_pixel)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcRandom random = {43};
        for (int round = 0; round < 60; round++)
        {
            uint32_t resolution = s_resolutions[3 + qcRandom_Below(&random, qc_resolutionCount - 3)];
            int axis = (int)qcRandom_Below(&random, 3), x = (axis + 1) % 3, y = (axis + 2) % 3;
            qcVisibilityDef def = {.triangleCount = 2, .resolution = resolution, .dilated = true};
            double slopeX = qcRandom_Uniform(&random, -0.3, 0.3), slopeY = qcRandom_Uniform(&random, -0.3, 0.3);
            for (int k = 0; k < 3; k++)
                def.dilation[k] = qcRandom_Below(&random, 2) == 0 ? 0.0 : Magnitude(&random, -12.0, -5.0);
            // 5/8 of a pixel on either side.
            double change = fabs(slopeX) * (def.dilation[x] + 1.25 / resolution) +
                            fabs(slopeY) * (def.dilation[y] + 1.25 / resolution) + def.dilation[axis];
            double gap = 2.0 * change + 1e-4;
            // A large triangle, and a smaller one in front of it or behind it.
            static const double places[2][3][2] = {{{-0.9, -0.9}, {0.9, -0.8}, {0.1, 0.9}},
                                                   {{-0.2, -0.1}, {0.3, -0.2}, {0.1, 0.4}}};
            bool isBehind = qcRandom_Below(&random, 2) == 0;
            float corners[18];
            for (int i = 0; i < 6; i++)
            {
                const double* place = places[1 - i / 3][i % 3];
                corners[3 * i + x] = (float)place[0];
                corners[3 * i + y] = (float)place[1];
                corners[3 * i + axis] = (float)(slopeX * place[0] + slopeY * place[1] +
                                                (i >= 3 ? 0.0 : (isBehind ? 0.5 : -0.5) * 2.0 * gap));
            }
            def.corners = corners;
            ck_assert_msg(IsVisible(device, &def, axis, isBehind), "round %d", round);
            ck_assert_msg(!IsVisible(device, &def, axis, !isBehind), "round %d", round);
        }
    }
}
END_TEST

START_TEST(triangles_a_pixel_and_the_dilation_apart_in_the_image_are_fully_visible)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcRandom random = {47};
        for (int round = 0; round < 120; round++)
        {
            uint32_t resolution = s_resolutions[3 + qcRandom_Below(&random, qc_resolutionCount - 3)];
            int axis = (int)qcRandom_Below(&random, 3);
            qcVisibilityDef def = {.triangleCount = 2, .resolution = resolution, .dilated = true};
            for (int k = 0; k < 3; k++)
                def.dilation[k] = qcRandom_Below(&random, 2) == 0 ? 0.0 : Magnitude(&random, -12.0, -5.0);
            // On both sides of a line of any direction.
            double angle = qcRandom_Uniform(&random, 0.0, 6.2831853), nx = cos(angle), ny = sin(angle);
            double reach = fabs(nx) * (def.dilation[(axis + 1) % 3] + 1.4 / resolution) +
                           fabs(ny) * (def.dilation[(axis + 2) % 3] + 1.4 / resolution);
            float corners[18];
            for (int i = 0; i < 6; i++)
            {
                double along = qcRandom_Uniform(&random, -0.5, 0.5), away = qcRandom_Uniform(&random, 0.0, 0.3) + reach;
                away = i < 3 ? away : -away;
                corners[3 * i + (axis + 1) % 3] = (float)(nx * away - ny * along);
                corners[3 * i + (axis + 2) % 3] = (float)(ny * away + nx * along);
                corners[3 * i + axis] = (float)qcRandom_Uniform(&random, -1.0, 1.0);
            }
            def.corners = corners;
            ck_assert_msg(IsVisible(device, &def, axis, false) && IsVisible(device, &def, axis, true), "round %d",
                          round);
        }
    }
}
END_TEST

QC_RUN_TESTS("conservative dilation", each_pixel_near_a_triangle_lies_well_inside_its_polygon_and_its_depths_hold,
             a_polygon_covers_no_more_than_its_triangle_dilated_by_a_pixel,
             triangles_within_the_dilation_of_one_point_hide_each_other_from_both_sides,
             parallel_planes_separate_as_soon_as_their_gap_exceeds_the_dilation_and_a_pixel,
             triangles_a_pixel_and_the_dilation_apart_in_the_image_are_fully_visible)
