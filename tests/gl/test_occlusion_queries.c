// Visibility queries: scenes with known results, and random passes against a rasteriser on the CPU that leaves
// undecided what rounding may decide. Every scene runs along each axis, with both comparisons, in one tile and in
// several.
#include "support/devices.h"
#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"
#include "support/soups.h"
#include "support/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

//  ---- scenes --------------------------------------------------------------------------------------

enum
{
    qc_maxTriangles = 64
};

/// Triangles in the coordinates of the image: x and y, then the depth.
typedef struct Scene
{
    float corners[9 * qc_maxTriangles];
    uint32_t count;
} Scene;

static void AddTriangle(Scene* scene, float ax, float ay, float az, float bx, float by, float bz, float cx, float cy,
                        float cz)
{
    const float corners[9] = {ax, ay, az, bx, by, bz, cx, cy, cz};
    memcpy(scene->corners + (size_t)9 * scene->count++, corners, sizeof corners);
}

/// Two triangles over [x0, x1] x [y0, y1]; the depth goes from z0 at the left side to z1 at the right one.
static void AddSquare(Scene* scene, float x0, float y0, float x1, float y1, float z0, float z1)
{
    AddTriangle(scene, x0, y0, z0, x1, y0, z1, x1, y1, z1);
    AddTriangle(scene, x0, y0, z0, x1, y1, z1, x0, y1, z0);
}

/// Converts triangles to world coordinates, for a view along an axis.
static void TurnToAxis(const float* image, size_t triangleCount, int axis, float* world)
{
    for (size_t i = 0; i < 3 * triangleCount; ++i)
    {
        world[3 * i + (size_t)((axis + 1) % 3)] = image[3 * i];
        world[3 * i + (size_t)((axis + 2) % 3)] = image[3 * i + 1];
        world[3 * i + (size_t)axis] = image[3 * i + 2];
    }
}

static const qcVisibilityCompare s_compares[2] = {qc_compareGreaterEqual, qc_compareGreater};

/// Creates queries in tiles of `tileSize` pixels; 0: the device's default.
static qcVisibility* Open(qcDevice* device, const float* corners, uint32_t triangleCount, uint32_t resolution,
                          uint32_t tileSize)
{
    qcVisibilityDef def = {.device = device,
                           .corners = corners,
                           .triangleCount = triangleCount,
                           .resolution = resolution,
                           .tileSize = tileSize};
    qcVisibility* visibility = NULL;
    qcStatus status = qcVisibility_Prepare(&def, &visibility);
    ck_assert_msg(status == qc_statusOk, "%s", qcLastMessage());
    return visibility;
}

static void RunPass(qcVisibility* visibility, int axis, qcVisibilityCompare compare, bool fromBack,
                    const qcVisibilityStep* steps, uint32_t stepCount, uint8_t* visible)
{
    qcVisibilityPass pass = {axis, compare, fromBack};
    qcStatus status = qcVisibility_RunPass(visibility, &pass, steps, stepCount, visible);
    ck_assert_msg(status == qc_statusOk, "%s", qcLastMessage());
}

/// The mirrored triangles, for the view from the back.
static void MirrorDepths(float* corners, size_t triangleCount, int axis)
{
    for (size_t i = 0; i < 3 * triangleCount; ++i)
        corners[3 * i + (size_t)axis] = -corners[3 * i + (size_t)axis];
}

/// Runs a pass on every device, along every axis, tiled and not, from the front and (mirrored) from the back, and
/// checks the answers to both comparisons: a string of '1' (visible) and '0' for each.
static void ExpectVisible(const Scene* scene, const qcVisibilityStep* steps, uint32_t stepCount,
                          const char* greaterEqual, const char* greater)
{
    QC_FOR_EACH_DEVICE(device)
    {
        for (int variant = 0; variant < 12; ++variant)
        {
            int axis = variant % 3;
            bool fromBack = variant >= 6;
            float world[9 * qc_maxTriangles];
            TurnToAxis(scene->corners, scene->count, axis, world);
            if (fromBack)
                MirrorDepths(world, scene->count, axis);
            qcVisibility* visibility = Open(device, world, scene->count, 100, variant % 6 < 3 ? 100 : 23);
            for (int i = 0; i < 2; ++i)
            {
                uint8_t visible[qc_maxTriangles];
                memset(visible, 9, sizeof visible);
                RunPass(visibility, axis, s_compares[i], fromBack, steps, stepCount, visible);
                for (uint32_t k = 0; k < stepCount; ++k)
                    ck_assert_msg(visible[k] == (i == 0 ? greaterEqual : greater)[k] - '0',
                                  "step %u, axis %d, variant %d, comparison %d: %u", k, axis, variant, i, visible[k]);
            }
            qcVisibility_Destroy(visibility);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

static const bool Y = true, N = false;

START_TEST(a_rendered_triangle_hides_only_triangles_behind_it)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, -0.3f, -0.3f);
    AddSquare(&scene, -0.4f, -0.4f, 0.6f, 0.6f, 0.3f, 0.3f);
    const qcVisibilityStep nearFirst[2] = {{0, 2, Y, Y}, {2, 2, Y, Y}};
    ExpectVisible(&scene, nearFirst, 2, "10", "10");
    const qcVisibilityStep farFirst[2] = {{2, 2, Y, Y}, {0, 2, Y, Y}};
    ExpectVisible(&scene, farFirst, 2, "11", "11");
}
END_TEST

START_TEST(crossing_triangles_hide_each_other_in_either_order)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, -0.3f, 0.3f);
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, 0.3f, -0.3f);
    const qcVisibilityStep steps[2] = {{0, 2, Y, Y}, {2, 2, Y, Y}};
    ExpectVisible(&scene, steps, 2, "10", "10");
    const qcVisibilityStep reversed[2] = {{2, 2, Y, Y}, {0, 2, Y, Y}};
    ExpectVisible(&scene, reversed, 2, "10", "10");
}
END_TEST

START_TEST(triangles_that_share_an_edge_do_not_hide_each_other)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.7f, -0.6f, 0.8f, 0.5f, -0.2f, 0.4f);
    const qcVisibilityStep steps[2] = {{0, 1, Y, Y}, {1, 1, Y, Y}};
    ExpectVisible(&scene, steps, 2, "11", "11");
    const qcVisibilityStep reversed[2] = {{1, 1, Y, Y}, {0, 1, Y, Y}};
    ExpectVisible(&scene, reversed, 2, "11", "11");
}
END_TEST

START_TEST(equal_depth_hides_between_objects_and_not_within_one)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, 0.25f, 0.25f);
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, 0.25f, 0.25f);
    const qcVisibilityStep steps[2] = {{0, 2, Y, Y}, {2, 2, Y, Y}};
    ExpectVisible(&scene, steps, 2, "10", "11");
}
END_TEST

START_TEST(both_orientations_of_a_triangle_are_drawn_and_tested)
{
    Scene scene = {.count = 0};
    for (int turned = 0; turned < 2; ++turned)
    {
        // One counter-clockwise, one clockwise; once in front and once behind.
        float x = turned == 0 ? -0.8f : 0.1f;
        AddTriangle(&scene, x, -0.5f, turned ? 0.2f : -0.2f, x + 0.7f, -0.5f, turned ? 0.2f : -0.2f, x, 0.5f,
                    turned ? 0.2f : -0.2f);
        AddTriangle(&scene, x, -0.5f, turned ? -0.2f : 0.2f, x, 0.5f, turned ? -0.2f : 0.2f, x + 0.7f, -0.5f,
                    turned ? -0.2f : 0.2f);
    }
    const qcVisibilityStep steps[4] = {{0, 1, Y, Y}, {1, 1, Y, Y}, {3, 1, Y, Y}, {2, 1, Y, Y}};
    ExpectVisible(&scene, steps, 4, "1010", "1010");
}
END_TEST

START_TEST(a_triangle_to_the_side_stays_visible)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.9f, -0.5f, -0.1f, 0.5f, -0.5f, -0.5f);
    AddSquare(&scene, 0.1f, -0.5f, 0.9f, 0.5f, 0.5f, 0.5f);
    const qcVisibilityStep steps[2] = {{0, 2, Y, Y}, {2, 2, Y, Y}};
    ExpectVisible(&scene, steps, 2, "11", "11");
}
END_TEST

START_TEST(an_empty_buffer_hides_nothing_not_even_the_farthest_depth)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -1.0f, -1.0f, 1.0f, 1.0f, 1.0f, 1.0f);
    AddSquare(&scene, -1.0f, -1.0f, 1.0f, 1.0f, -1.0f, -1.0f);
    const qcVisibilityStep steps[3] = {{0, 2, Y, Y}, {2, 2, Y, Y}, {0, 2, Y, N}};
    ExpectVisible(&scene, steps, 3, "110", "110");
}
END_TEST

START_TEST(a_test_sees_the_renders_before_it_and_none_after)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, -0.3f, -0.3f);
    AddSquare(&scene, -0.4f, -0.4f, 0.6f, 0.6f, 0.3f, 0.3f);
    const qcVisibilityStep steps[5] = {{2, 2, Y, N}, {0, 2, N, Y}, {2, 2, Y, N}, {0, 2, Y, N}, {2, 2, N, Y}};
    // The fourth step is tested against its own depth: hidden if equal depths hide.
    ExpectVisible(&scene, steps, 5, "10000", "10010");
}
END_TEST

START_TEST(a_test_alone_draws_nothing)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, -0.3f, -0.3f);
    AddSquare(&scene, -0.4f, -0.4f, 0.6f, 0.6f, 0.3f, 0.3f);
    const qcVisibilityStep steps[2] = {{0, 2, Y, N}, {2, 2, Y, N}};
    ExpectVisible(&scene, steps, 2, "11", "11");
}
END_TEST

START_TEST(a_step_that_tests_and_renders_does_not_hide_itself)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, -0.3f, -0.3f);
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, 0.3f, 0.3f);
    const qcVisibilityStep steps[2] = {{0, 4, Y, Y}, {0, 4, Y, N}};
    ExpectVisible(&scene, steps, 2, "10", "10");
}
END_TEST

START_TEST(the_nearest_depth_is_kept)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, -0.3f, -0.3f);
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, 0.3f, 0.3f);
    AddSquare(&scene, -0.1f, -0.1f, 0.1f, 0.1f, 0.0f, 0.0f);
    const qcVisibilityStep steps[3] = {{0, 2, N, Y}, {2, 2, N, Y}, {4, 2, Y, N}};
    ExpectVisible(&scene, steps, 3, "000", "000");
}
END_TEST

START_TEST(one_hidden_triangle_hides_its_whole_object)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.9f, -0.9f, -0.7f, -0.7f, -0.3f, -0.3f);
    for (int i = 0; i < 9; ++i) // the first of them behind the square, the others elsewhere
        AddSquare(&scene, -0.85f + 0.2f * (float)i, -0.85f, -0.75f + 0.2f * (float)i, -0.75f, 0.3f, 0.3f);
    const qcVisibilityStep steps[4] = {{0, 2, Y, Y}, {4, 16, Y, N}, {2, 18, Y, N}, {2, 1, Y, N}};
    ExpectVisible(&scene, steps, 4, "1100", "1100");
}
END_TEST

START_TEST(a_step_without_triangles_is_visible_and_without_a_test_is_not)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, 0.0f, 0.0f);
    const qcVisibilityStep steps[6] = {{0, 2, Y, Y}, {0, 0, Y, N}, {2, 0, Y, Y},
                                       {1, 0, N, N}, {0, 2, N, N}, {0, 2, N, Y}};
    ExpectVisible(&scene, steps, 6, "111000", "111000");
    ExpectVisible(&scene, NULL, 0, "", "");
    Scene empty = {.count = 0};
    ExpectVisible(&empty, &(qcVisibilityStep){0, 0, Y, Y}, 1, "1", "1");
}
END_TEST

START_TEST(a_triangle_without_area_is_visible)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -1.0f, -1.0f, 1.0f, 1.0f, -0.5f, -0.5f);
    AddTriangle(&scene, -0.3f, -0.2f, 0.0f, 0.5f, 0.1f, 0.0f, 0.5f, 0.1f, 0.0f);
    AddTriangle(&scene, 0.2f, 0.2f, 0.0f, 0.2f, 0.2f, 0.0f, 0.2f, 0.2f, 0.0f);
    const qcVisibilityStep steps[3] = {{0, 2, N, Y}, {2, 1, Y, N}, {3, 1, Y, N}};
    ExpectVisible(&scene, steps, 3, "011", "011");
}
END_TEST

//  ---- random passes -------------------------------------------------------------------------------

enum
{
    qc_resolution = 96,
    qc_soupSize = 400,
    qc_soupSteps = 500
};

/// Per pixel: the nearest depth that is certain, and the nearest that is possible.
typedef struct DepthBuffer
{
    double sure[qc_resolution][qc_resolution], possible[qc_resolution][qc_resolution];
} DepthBuffer;

// Rasterisers round corners to 1/256 of a pixel or finer, and depths to about 24 bits.
static const double s_pixelError = 0.02, s_depthError = 1e-4;

/// Coverage of a pixel by a triangle (image coordinates): 2 certain, 1 possible, 0 none; and the depth there.
static int Cover(const float* corner, int px, int py, double* depth)
{
    double x = (px + 0.5) * 2.0 / qc_resolution - 1.0, y = (py + 0.5) * 2.0 / qc_resolution - 1.0;
    double ux = corner[3] - corner[0], uy = corner[4] - corner[1], vx = corner[6] - corner[0],
           vy = corner[7] - corner[1];
    double area = ux * vy - vx * uy;
    double weight[3];
    weight[1] = ((x - corner[0]) * vy - vx * (y - corner[1])) / area;
    weight[2] = (ux * (y - corner[1]) - (x - corner[0]) * uy) / area;
    weight[0] = 1.0 - weight[1] - weight[2];
    *depth = weight[0] * corner[2] + weight[1] * corner[5] + weight[2] * corner[8];
    int cover = 2;
    for (int i = 0; i < 3; ++i)
    {
        // The distance from the edge opposite to corner i, in pixels.
        const float* a = corner + 3 * ((i + 1) % 3);
        const float* b = corner + 3 * ((i + 2) % 3);
        double distance = weight[i] * fabs(area) / hypot(b[0] - a[0], b[1] - a[1]) * qc_resolution / 2.0;
        int here = distance > s_pixelError ? 2 : (distance > -s_pixelError ? 1 : 0);
        cover = here < cover ? here : cover;
    }
    return cover;
}

/// Tests and draws a step. '1' visible, '0' hidden, '?' undecided, ' ' not tested.
static char StepOnCpu(DepthBuffer* buffer, const float* corners, const qcVisibilityStep* step)
{
    char answer = step->test ? '1' : ' ';
    for (int round = 0; round < 2; ++round) // tests, then renders
    {
        if (!(round == 0 ? step->test : step->render))
            continue;
        for (uint32_t t = step->firstTriangle; t < step->firstTriangle + step->triangleCount; ++t)
        {
            const float* corner = corners + (size_t)9 * t;
            int first[2], last[2];
            for (int i = 0; i < 2; ++i)
            {
                float lower = fminf(corner[i], fminf(corner[3 + i], corner[6 + i]));
                float upper = fmaxf(corner[i], fmaxf(corner[3 + i], corner[6 + i]));
                first[i] = (int)fmaxf((lower + 1.0f) * 0.5f * qc_resolution - 2.0f, 0.0f);
                last[i] = (int)fminf((upper + 1.0f) * 0.5f * qc_resolution + 2.0f, qc_resolution - 1);
            }
            for (int y = first[1]; y <= last[1]; ++y)
            {
                for (int x = first[0]; x <= last[0]; ++x)
                {
                    double depth;
                    int cover = Cover(corner, x, y, &depth);
                    double* sure = &buffer->sure[y][x];
                    double* possible = &buffer->possible[y][x];
                    if (cover == 0)
                        continue;
                    if (round == 1)
                    {
                        *sure = cover == 2 && depth < *sure ? depth : *sure;
                        *possible = depth < *possible ? depth : *possible;
                    }
                    else if (cover == 2 && depth - s_depthError > *sure)
                        answer = '0';
                    else if (answer == '1' && depth + s_depthError > *possible)
                        answer = '?';
                }
            }
        }
    }
    return answer;
}

/// Triangles of general position; runs of one to five that test, render or both, in no order.
static void MakeSoup(uint64_t seed, float* corners, qcVisibilityStep* steps)
{
    qcRandom random = {seed};
    for (size_t t = 0; t < qc_soupSize; ++t)
    {
        float* corner = corners + (size_t)9 * t;
        double center[3], area;
        double size = qcRandom_Below(&random, 20) == 0 ? 0.9 : 0.12;
        do
        {
            for (int axis = 0; axis < 3; ++axis)
                center[axis] = qcRandom_Uniform(&random, -1.0 + size, 1.0 - size);
            for (int i = 0; i < 9; ++i)
                corner[i] = (float)(center[i % 3] + qcRandom_Uniform(&random, -size, size));
            area =
                (corner[3] - corner[0]) * (corner[7] - corner[1]) - (corner[6] - corner[0]) * (corner[4] - corner[1]);
        } while (fabs(area) < 1e-3); // steep ones have depths that a little rounding moves far
    }
    for (int i = 0; i < qc_soupSteps; ++i)
    {
        steps[i].triangleCount = 1 + qcRandom_Below(&random, 5);
        steps[i].firstTriangle = qcRandom_Below(&random, qc_soupSize - 5);
        steps[i].test = qcRandom_Below(&random, 4) != 0;
        steps[i].render = qcRandom_Below(&random, 4) == 0;
    }
}

START_TEST(random_passes_agree_with_a_rasteriser_on_the_cpu_in_tiles_of_any_size)
{
    static float image[9 * qc_soupSize], world[9 * qc_soupSize];
    static qcVisibilityStep steps[qc_soupSteps];
    static DepthBuffer buffer;
    static char expected[qc_soupSteps];
    for (uint64_t seed = 1; seed <= 3; ++seed)
    {
        MakeSoup(seed, image, steps);
        for (int y = 0; y < qc_resolution; ++y)
        {
            for (int x = 0; x < qc_resolution; ++x)
                buffer.sure[y][x] = buffer.possible[y][x] = 10.0;
        }
        int answers[256] = {0};
        for (int i = 0; i < qc_soupSteps; ++i)
        {
            expected[i] = StepOnCpu(&buffer, image, &steps[i]);
            ++answers[(int)expected[i]];
        }
        // Enough decided results for the comparison to be meaningful.
        ck_assert_int_gt(answers['1'], 50);
        ck_assert_int_gt(answers['0'], 50);
        ck_assert_int_lt(answers['?'], qc_soupSteps / 10);

        int axis = (int)(seed % 3);
        TurnToAxis(image, qc_soupSize, axis, world);
        QC_FOR_EACH_DEVICE(device)
        {
            static uint8_t visible[2][qc_soupSteps], untiled[2][qc_soupSteps];
            const uint32_t tileSizes[4] = {qc_resolution, 64, 32, 7};
            for (int t = 0; t < 8; ++t)
            {
                bool fromBack = t >= 4;
                if (t == 4)
                    MirrorDepths(world, qc_soupSize, axis);
                qcVisibility* visibility = Open(device, world, qc_soupSize, qc_resolution, tileSizes[t % 4]);
                for (int c = 0; c < 2; ++c)
                {
                    RunPass(visibility, axis, s_compares[c], fromBack, steps, qc_soupSteps, visible[c]);
                    for (int i = 0; i < qc_soupSteps; ++i)
                    {
                        // Visibility of a step against its own triangles at equal depth is not specified, so both
                        // comparisons agree here.
                        char seen = !steps[i].test ? ' ' : (visible[c][i] ? '1' : '0');
                        ck_assert_msg(expected[i] == '?' || expected[i] == seen,
                                      "seed %d, variant %d, comparison %d, step %d: %c instead of %c", (int)seed, t, c,
                                      i, seen, expected[i]);
                    }
                }
                // A depth is rounded differently from the back.
                if (t % 4 == 0)
                    memcpy(untiled, visible, sizeof visible);
                ck_assert_mem_eq(visible, untiled, sizeof visible);
                qcVisibility_Destroy(visibility);
            }
            MirrorDepths(world, qc_soupSize, axis);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(over_a_thousand_queries_in_one_pass_lose_none)
{
    enum
    {
        side = 20,
        layer = 2 * side * side
    };
    // Two flat grids; every triangle of the far one is behind the near one, and nothing else hides anything. Visible
    // and hidden ones alternate, so that a query's count could leak into the next.
    static float corners[9 * 2 * layer];
    static qcVisibilityStep steps[2 * layer];
    static uint8_t visible[2 * layer];
    float* corner = corners;
    for (int z = 0; z < 2; ++z)
    {
        for (int k = 0; k < layer; ++k)
        {
            static const int offsets[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
            for (int c = 0; c < 3; ++c)
            {
                *corner++ = (float)(k / 2 % side + offsets[k % 2][c][0]) * (1.9f / side) - 0.95f;
                *corner++ = (float)(k / 2 / side + offsets[k % 2][c][1]) * (1.9f / side) - 0.95f;
                *corner++ = z == 0 ? -0.5f : 0.5f;
            }
        }
    }
    for (uint32_t i = 0; i < 2 * layer; ++i)
        steps[i] = (qcVisibilityStep){i / 2 + i % 2 * layer, 1, true, true};
    QC_FOR_EACH_DEVICE(device)
    {
        // Untiled, too: there each query takes most of a software device's memory for commands.
        for (uint32_t tileSize = 512; tileSize <= 4096; tileSize *= 8)
        {
            qcVisibility* visibility = Open(device, corners, 2 * layer, 4096, tileSize);
            RunPass(visibility, 2, qc_compareGreater, false, steps, 2 * layer, visible);
            for (int i = 0; i < 2 * layer; ++i)
                ck_assert_msg(visible[i] == (i % 2 == 0 ? 1 : 0), "tile size %u, step %d: %u", tileSize, i, visible[i]);
            qcVisibility_Destroy(visibility);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- failing -------------------------------------------------------------------------------------

START_TEST(bad_resolutions_and_devices_are_refused)
{
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    qcVisibility* visibility = NULL;
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo info;
        ck_assert_int_eq(qcDevice_GetInfo(device, &info), qc_statusOk);
        qcVisibilityDef def = {.device = device, .corners = corners, .triangleCount = 1};
        ck_assert_int_eq(qcVisibility_Prepare(&def, &visibility), qc_statusBadInput);
        def.resolution = info.maxResolution + 1;
        ck_assert_int_eq(qcVisibility_Prepare(&def, &visibility), qc_statusBadInput);
        def.resolution = 64;
        def.triangleCount = 0x80000000u;
        ck_assert_int_eq(qcVisibility_Prepare(&def, &visibility), qc_statusBadInput);
        // Dilated, each triangle becomes five.
        def.triangleCount = 0x7fffffff / 15 + 1;
        def.dilated = true;
        ck_assert_int_eq(qcVisibility_Prepare(&def, &visibility), qc_statusBadInput);
        // The limit itself is fine; tiled, so that no GPU runs out of memory here.
        qcVisibility_Destroy(Open(device, corners, 1, info.maxResolution, 512));
    }
    qcDeviceDef deviceDef = qcDefaultDeviceDef();
    deviceDef.kind = qc_deviceNone;
    qcDevice* none = NULL;
    ck_assert_int_eq(qcDevice_Create(&deviceDef, &none), qc_statusOk);
    qcVisibilityDef def = {.device = none, .corners = corners, .triangleCount = 1, .resolution = 64};
    ck_assert_int_eq(qcVisibility_Prepare(&def, &visibility), qc_statusDevice);
    ck_assert_ptr_null(visibility);
    qcVisibility_Destroy(NULL);
    qcDevice_Destroy(none);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

typedef struct Heap
{
    int left; ///< allocations that still succeed
} Heap;

static void* Allocate(size_t size, void* context)
{
    Heap* heap = context;
    return heap->left-- > 0 ? aligned_alloc(64, (size + 63) / 64 * 64) : NULL;
}

static void Release(void* memory, size_t size, void* context)
{
    (void)size;
    (void)context;
    free(memory);
}

/// Allows one allocation more each time, until a pass succeeds.
static void FailEachAllocation(qcDevice* device, Heap* heap, bool dilated)
{
    Scene scene = {.count = 0};
    AddSquare(&scene, -0.5f, -0.5f, 0.5f, 0.5f, -0.3f, -0.3f);
    AddSquare(&scene, -0.4f, -0.4f, 0.6f, 0.6f, 0.3f, 0.3f);
    const qcVisibilityStep steps[2] = {{0, 2, Y, Y}, {2, 2, Y, Y}};
    const qcVisibilityPass pass = {2, qc_compareGreaterEqual, false};
    const qcVisibilityDef def = {.device = device,
                                 .corners = scene.corners,
                                 .triangleCount = scene.count,
                                 .resolution = 64,
                                 .tileSize = 17,
                                 .dilated = dilated};
    size_t before = qcGetByteCount();
    int failures = 0;
    qcStatus status = qc_statusOutOfMemory;
    for (int allowed = 0; status != qc_statusOk; ++allowed)
    {
        qcVisibility* visibility = NULL;
        uint8_t visible[2];
        heap->left = allowed;
        status = qcVisibility_Prepare(&def, &visibility);
        if (status == qc_statusOk)
        {
            status = qcVisibility_RunPass(visibility, &pass, steps, 2, visible);
            heap->left = 1 << 30;
            ck_assert_int_eq(qcVisibility_RunPass(visibility, &pass, steps, 2, visible), qc_statusOk);
            ck_assert_uint_eq(visible[0], 1);
            ck_assert_uint_eq(visible[1], 0);
        }
        ck_assert(status == qc_statusOk || status == qc_statusOutOfMemory);
        failures += status != qc_statusOk ? 1 : 0;
        qcVisibility_Destroy(visibility);
        ck_assert_uint_eq(qcGetByteCount(), before);
    }
    ck_assert_int_gt(failures, 5);
    heap->left = 1 << 30;
}

START_TEST(any_allocation_may_fail_and_the_next_pass_succeeds)
{
    Heap heap = {1 << 30};
    ck_assert_int_eq(qcSetAllocator(Allocate, Release, &heap), qc_statusOk);
    QC_FOR_EACH_DEVICE(device)
    {
        for (int dilated = 0; dilated < 2; ++dilated)
            FailEachAllocation(device, &heap, dilated == 1);
    }
    ck_assert_int_eq(qcSetAllocator(NULL, NULL, NULL), qc_statusOk);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES(
    "occlusion queries", a_rendered_triangle_hides_only_triangles_behind_it,
    crossing_triangles_hide_each_other_in_either_order, triangles_that_share_an_edge_do_not_hide_each_other,
    equal_depth_hides_between_objects_and_not_within_one, both_orientations_of_a_triangle_are_drawn_and_tested,
    a_triangle_to_the_side_stays_visible, an_empty_buffer_hides_nothing_not_even_the_farthest_depth,
    a_test_sees_the_renders_before_it_and_none_after, a_test_alone_draws_nothing,
    a_step_that_tests_and_renders_does_not_hide_itself, the_nearest_depth_is_kept,
    one_hidden_triangle_hides_its_whole_object, a_step_without_triangles_is_visible_and_without_a_test_is_not,
    a_triangle_without_area_is_visible, random_passes_agree_with_a_rasteriser_on_the_cpu_in_tiles_of_any_size,
    over_a_thousand_queries_in_one_pass_lose_none, bad_resolutions_and_devices_are_refused,
    any_allocation_may_fail_and_the_next_pass_succeeds)
