// Light in pictures: shadows where they belong and nowhere else, a ground that ends in the background, and the same
// picture on every device.
#include "support/devices.h"
#include "support/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_width = 96,
    qc_height = 64
};

static uint8_t s_rgb[qc_width * qc_height * 3];

static const uint32_t s_squareIndices[6] = {0, 1, 2, 0, 2, 3};

static qcPictureMesh Square(const float positions[12])
{
    return (qcPictureMesh){.positions = positions,
                           .vertexCount = 4,
                           .indices = s_squareIndices,
                           .triangleCount = 2,
                           .color = {0.7f, 0.1f, 0.1f},
                           .backColor = {0.1f, 0.1f, 0.7f}};
}

/// Seen from above at an angle of 45 degrees, over a ground at y = 0.
static qcPictureDef Scene(const qcPictureMesh* meshes, uint32_t count)
{
    qcPictureDef def = qcDefaultPictureDef();
    def.width = qc_width;
    def.height = qc_height;
    def.eye[1] = def.eye[2] = 6.0f;
    def.light[1] = 1.0f;
    def.hasGround = true;
    def.meshes = meshes;
    def.meshCount = count;
    return def;
}

static void Draw(qcDevice* device, const qcPictureDef* def)
{
    memset(s_rgb, 0, sizeof s_rgb);
    qcStatus status = qcDevice_DrawPicture(device, def, s_rgb);
    ck_assert_msg(status == qc_statusOk, "%s", qcLastMessage());
}

static const uint8_t* Pixel(int x, int y)
{
    return s_rgb + (size_t)3 * ((size_t)y * qc_width + (size_t)x);
}

static int Brightness(int x, int y)
{
    const uint8_t* p = Pixel(x, y);
    return (p[0] + p[1] + p[2]) / 3;
}

START_TEST(a_ground_ends_in_the_background)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureDef def = Scene(NULL, 0);
        def.eye[1] = 1.0f; // the horizon is in the picture
        def.groundColor[0] = def.groundColor[1] = def.groundColor[2] = 0.3f;
        Draw(device, &def);
        int background = (int)lround(255.0 * (1.055 * pow(0.94, 1.0 / 2.4) - 0.055));
        ck_assert_int_le(abs(Brightness(48, 1) - background), 2);
        ck_assert_int_lt(Brightness(48, 62), background - 50);
        for (int y = 1; y < qc_height; y++)
        {
            int step = Brightness(48, y) - Brightness(48, y - 1);
            ck_assert_msg(step <= 2 && step > -50, "a step of %d at row %d", step, y);
        }
    }
}
END_TEST

START_TEST(a_ground_above_the_eye_is_left_out)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureDef def = Scene(NULL, 0);
        def.groundHeight = 7.0f;
        Draw(device, &def);
        int background = Brightness(48, 32);
        ck_assert_int_gt(background, 240);
        def.groundHeight = 5.0f;
        Draw(device, &def);
        ck_assert_int_lt(Brightness(48, 32), background - 20);
    }
}
END_TEST

START_TEST(a_mesh_shadows_the_ground_below_it_and_not_beside)
{
    QC_FOR_EACH_DEVICE(device)
    {
        // In the picture it covers rows 12 to 23. It is dark below it in rows 27 to 37, half dark up to row 42.
        const float plate[12] = {-0.8f, 1.5f, -0.8f, -0.8f, 1.5f, 0.8f, 0.8f, 1.5f, 0.8f, 0.8f, 1.5f, -0.8f};
        qcPictureMesh mesh = Square(plate);
        qcPictureDef def = Scene(&mesh, 0);
        Draw(device, &def);
        int below = Brightness(48, 32), beside = Brightness(8, 32);
        def.meshCount = 1;
        Draw(device, &def);
        ck_assert_int_eq(Pixel(48, 32)[0] > Pixel(48, 32)[1] + 40, 0); // the ground, not the plate
        ck_assert_int_lt(Brightness(48, 32), below - 60);
        ck_assert_int_le(abs(Brightness(8, 32) - beside), 2);
    }
}
END_TEST

START_TEST(a_shadow_begins_at_the_foot_of_what_casts_it)
{
    QC_FOR_EACH_DEVICE(device)
    {
        // A wall; light comes from behind it, at an angle of 45 degrees.
        const float wall[12] = {-1.2f, 0, 0, 1.2f, 0, 0, 1.2f, 0.8f, 0, -1.2f, 0.8f, 0};
        qcPictureMesh mesh = Square(wall);
        qcPictureDef def = Scene(&mesh, 1);
        def.light[2] = -1.0f;
        Draw(device, &def);
        int foot = 0;
        while (foot < qc_height && Pixel(48, qc_height - 1 - foot)[0] < Pixel(48, qc_height - 1 - foot)[2] + 40)
            foot++;
        foot = qc_height - 1 - foot; // the lowest row of the wall
        ck_assert_int_gt(foot, 25);
        ck_assert_int_lt(foot, 40);
        int shadow = Brightness(48, foot + 5), lit = Brightness(48, 62);
        ck_assert_int_lt(shadow, lit - 40);
        for (int y = foot + 2; y < foot + 5; y++)
            ck_assert_int_le(Brightness(48, y), shadow + 5);
    }
}
END_TEST

START_TEST(a_plane_has_no_shadow_of_its_own_at_any_angle_of_light)
{
    QC_FOR_EACH_DEVICE(device)
    {
        const float plane[12] = {-30, 0, -30, -30, 0, 30, 30, 0, 30, 30, 0, -30};
        qcPictureMesh mesh = Square(plane);
        qcPictureDef def = Scene(&mesh, 1);
        def.hasGround = false;
        def.eye[1] = def.eye[2] = 600.0f; // nearly parallel rays
        def.fieldOfView = 0.2f;
        for (int angle = 10; angle <= 90; angle += 16)
        {
            double a = angle * 3.14159265358979 / 180.0;
            def.light[0] = 0.6f * (float)cos(a);
            def.light[1] = (float)sin(a);
            def.light[2] = 0.8f * (float)cos(a);
            Draw(device, &def);
            int low = 255, high = 0;
            for (int i = 0; i < qc_width * qc_height; i++)
            {
                int brightness = Brightness(i % qc_width, i / qc_width);
                low = brightness < low ? brightness : low;
                high = brightness > high ? brightness : high;
            }
            ck_assert_msg(high - low <= 3, "%d to %d under light at %d degrees", low, high, angle);
        }
    }
}
END_TEST

START_TEST(a_mesh_that_lies_in_the_ground_hides_it)
{
    QC_FOR_EACH_DEVICE(device)
    {
        const float sheet[12] = {-30, 0, -30, -30, 0, 30, 30, 0, 30, 30, 0, -30};
        qcPictureMesh mesh = Square(sheet);
        qcPictureDef def = Scene(&mesh, 1);
        def.groundExtent = 100.0f;
        Draw(device, &def);
        for (int i = 0; i < qc_width * qc_height; i++)
            ck_assert_int_gt(s_rgb[3 * i], s_rgb[3 * i + 1] + 40);
    }
}
END_TEST

enum
{
    qc_rings = 24,
    qc_segments = 48
};

/// A closed ball of radius 1 around (0, y, 0), red outside, blue inside.
static qcPictureMesh Ball(float y)
{
    static float positions[(qc_rings + 1) * qc_segments * 3];
    static uint32_t indices[qc_rings * qc_segments * 6];
    uint32_t count = 0;
    for (uint32_t ring = 0; ring <= qc_rings; ring++)
    {
        for (uint32_t i = 0; i < qc_segments; i++)
        {
            double polar = 3.14159265358979 * ring / qc_rings, turn = 6.28318530717959 * i / qc_segments;
            float* p = positions + 3 * (ring * qc_segments + i);
            p[0] = (float)(sin(polar) * cos(turn));
            p[1] = y + (float)cos(polar);
            p[2] = (float)(sin(polar) * sin(turn));
            if (ring == qc_rings)
                continue;
            uint32_t a = ring * qc_segments + i, b = ring * qc_segments + (i + 1) % qc_segments;
            const uint32_t corners[6] = {a, b, b + qc_segments, a, b + qc_segments, a + qc_segments};
            memcpy(indices + count, corners, sizeof corners);
            count += 6;
        }
    }
    return (qcPictureMesh){.positions = positions,
                           .vertexCount = (qc_rings + 1) * qc_segments,
                           .indices = indices,
                           .triangleCount = count / 3,
                           .color = {0.7f, 0.1f, 0.1f},
                           .backColor = {0.1f, 0.1f, 0.7f},
                           .smooth = true};
}

START_TEST(a_steep_surface_hides_what_is_just_behind_it)
{
    QC_FOR_EACH_DEVICE(device)
    {
        // Seen from (0, 0, 5). The far end of the first, seen nearly edge on, is just before all of the second.
        const float steep[12] = {-1, -1, 0, 3.4f, -1, -12, 3.4f, 1, -12, -1, 1, 0};
        const float behind[12] = {2.4f, -0.5f, -12.02f, 3.4f, -0.5f, -12.02f, 3.4f, 0.5f, -12.02f, 2.4f, 0.5f, -12.02f};
        qcPictureMesh meshes[2] = {Square(steep), Square(behind)};
        memcpy(meshes[1].color, meshes[1].backColor, sizeof meshes[1].color);
        qcPictureDef def = Scene(meshes, 2);
        def.hasGround = false;
        def.eye[1] = 0.0f;
        def.eye[2] = 5.0f;
        Draw(device, &def);
        int red = 0;
        for (int i = 0; i < qc_width * qc_height; i++)
        {
            ck_assert_int_le(s_rgb[3 * i + 2], s_rgb[3 * i] + 20);
            red += s_rgb[3 * i] > s_rgb[3 * i + 2] + 40;
        }
        ck_assert_int_gt(red, 100);
    }
}
END_TEST

START_TEST(the_picture_is_the_same_on_every_device)
{
    // Averages of cells of 8 x 8 pixels, row by row, as OSMesa draws them.
    static const uint8_t expected[96] = {
        196, 195, 196, 195, 195, 196, 195, 195, 196, 195, 195, 196, 196, 196, 195, 196, 190, 155, 141, 184,
        195, 196, 195, 196, 195, 197, 196, 196, 162, 135, 110, 130, 196, 197, 196, 197, 199, 194, 199, 194,
        163, 109, 89,  112, 155, 183, 199, 194, 196, 199, 195, 200, 194, 149, 117, 137, 136, 174, 195, 198,
        197, 198, 198, 197, 200, 195, 194, 184, 190, 196, 198, 198, 201, 196, 199, 199, 197, 201, 196, 200,
        198, 198, 200, 195, 196, 203, 194, 200, 201, 194, 204, 197, 197, 203, 194, 200};
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh ball = Ball(1.0f);
        qcPictureDef def = Scene(&ball, 1);
        def.light[0] = -1.0f;
        def.groundTile = 0.7f;
        Draw(device, &def);
        for (int cell = 0; cell < 96; cell++)
        {
            int sum = 0;
            for (int i = 0; i < 64; i++)
                sum += Brightness(cell % 12 * 8 + i % 8, cell / 12 * 8 + i / 8);
            ck_assert_msg(abs((sum + 32) / 64 - expected[cell]) <= 3, "cell %d: %d instead of %d", cell,
                          (sum + 32) / 64, expected[cell]);
        }
    }
}
END_TEST

START_TEST(definitions_of_older_headers_are_drawn)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh ball = Ball(1.0f);
        qcPictureDef def = Scene(&ball, 1);
        def.hasGround = false;
        memset(def.light, 0, sizeof def.light);
        Draw(device, &def);
        static uint8_t expected[sizeof s_rgb];
        memcpy(expected, s_rgb, sizeof s_rgb);
        // What lies beyond structSize must not be read, nor what was padding.
        def.structSize = (uint32_t)offsetof(qcPictureDef, light);
        memset(def.reserved, 0xff, sizeof def - offsetof(qcPictureDef, reserved));
        Draw(device, &def);
        ck_assert_mem_eq(s_rgb, expected, sizeof s_rgb);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("picture_light", a_ground_ends_in_the_background, a_ground_above_the_eye_is_left_out,
                        a_mesh_shadows_the_ground_below_it_and_not_beside, a_shadow_begins_at_the_foot_of_what_casts_it,
                        a_plane_has_no_shadow_of_its_own_at_any_angle_of_light, a_mesh_that_lies_in_the_ground_hides_it,
                        a_steep_surface_hides_what_is_just_behind_it, the_picture_is_the_same_on_every_device,
                        definitions_of_older_headers_are_drawn)
