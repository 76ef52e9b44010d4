// Pictures: colours in the right pixels, the top row first, no seam between tiles, and bad input refused by name.
// Colours are compared by their largest channel, since light changes their brightness.
#include "gl/replaced_driver.h"
#include "support/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// A square of two triangles facing +z, in the plane z = 0.
static const float s_square[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const uint32_t s_squareIndices[6] = {0, 1, 2, 0, 2, 3};

static qcPictureMesh Square(void)
{
    return (qcPictureMesh){.positions = s_square,
                           .vertexCount = 4,
                           .indices = s_squareIndices,
                           .triangleCount = 2,
                           .color = {0.8f, 0.1f, 0.1f},
                           .backColor = {0.1f, 0.1f, 0.8f},
                           .markColor = {0.1f, 0.8f, 0.1f}};
}

/// A picture of 90 x 60 pixels with its own memory.
typedef struct Picture
{
    qcPictureDef def;
    uint8_t* rgb;
} Picture;

static Picture Prepare(const qcPictureMesh* meshes, uint32_t count)
{
    Picture picture = {.def = qcDefaultPictureDef()};
    picture.def.width = 90;
    picture.def.height = 60;
    picture.def.meshes = meshes;
    picture.def.meshCount = count;
    return picture;
}

static void Draw(qcDevice* device, Picture* picture)
{
    size_t size = (size_t)picture->def.width * picture->def.height * 3;
    picture->rgb = realloc(picture->rgb, size);
    memset(picture->rgb, 0, size);
    qcStatus status = qcDevice_DrawPicture(device, &picture->def, picture->rgb);
    ck_assert_msg(status == qc_statusOk, "%s", qcLastMessage());
}

static const uint8_t* Pixel(const Picture* picture, uint32_t x, uint32_t y)
{
    return picture->rgb + 3 * ((size_t)y * picture->def.width + x);
}

/// 'r', 'g' or 'b': the channel that is largest by far; '.': there is none.
static char Lead(const uint8_t* rgb)
{
    for (int i = 0; i < 3; ++i)
    {
        if (rgb[i] > rgb[(i + 1) % 3] + 40 && rgb[i] > rgb[(i + 2) % 3] + 40)
            return "rgb"[i];
    }
    return '.';
}

static bool IsBackground(const Picture* picture, const uint8_t* rgb)
{
    for (int i = 0; i < 3; ++i)
    {
        double linear = picture->def.background[i];
        double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
        if (fabs((double)rgb[i] - 255.0 * encoded) > 1.5)
            return false;
    }
    return true;
}

START_TEST(a_mesh_is_drawn_in_the_middle_and_background_in_the_corners)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh mesh = Square();
        Picture picture = Prepare(&mesh, 1);
        picture.def.background[0] = 0.2f;
        picture.def.background[1] = 0.5f;
        picture.def.background[2] = 0.001f;
        Draw(device, &picture);
        ck_assert_int_eq(Lead(Pixel(&picture, 45, 30)), 'r');
        for (uint32_t corner = 0; corner < 4; ++corner)
            ck_assert(IsBackground(&picture, Pixel(&picture, corner % 2 * 89, corner / 2 * 59)));
        free(picture.rgb);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(the_back_is_seen_from_behind)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh mesh = Square();
        Picture picture = Prepare(&mesh, 1);
        picture.def.eye[2] = -5.0f;
        Draw(device, &picture);
        ck_assert_int_eq(Lead(Pixel(&picture, 45, 30)), 'b');
        free(picture.rgb);
    }
}
END_TEST

START_TEST(marked_triangles_and_only_they_have_the_mark_colour)
{
    QC_FOR_EACH_DEVICE(device)
    {
        const uint8_t marked[2] = {0, 1};
        qcPictureMesh mesh = Square();
        mesh.marked = marked;
        Picture picture = Prepare(&mesh, 1);
        Draw(device, &picture);
        // The diagonal runs from below left to above right; the second triangle lies above it.
        ck_assert_int_eq(Lead(Pixel(&picture, 40, 20)), 'g');
        ck_assert_int_eq(Lead(Pixel(&picture, 50, 40)), 'r');
        // From behind, too.
        picture.def.eye[2] = -5.0f;
        Draw(device, &picture);
        ck_assert_int_eq(Lead(Pixel(&picture, 50, 20)), 'g');
        ck_assert_int_eq(Lead(Pixel(&picture, 40, 40)), 'b');
        free(picture.rgb);
    }
}
END_TEST

START_TEST(the_top_row_is_first_and_the_left_column_too)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh mesh = Square();
        const float aboveLeft[12] = {-1, 0.2f, 0, -0.2f, 0.2f, 0, -0.2f, 1, 0, -1, 1, 0};
        mesh.positions = aboveLeft;
        Picture picture = Prepare(&mesh, 1);
        Draw(device, &picture);
        ck_assert_int_eq(Lead(Pixel(&picture, 34, 19)), 'r');
        ck_assert(IsBackground(&picture, Pixel(&picture, 55, 19)));
        ck_assert(IsBackground(&picture, Pixel(&picture, 34, 40)));
        free(picture.rgb);
    }
}
END_TEST

START_TEST(the_nearer_mesh_hides_the_farther_one)
{
    QC_FOR_EACH_DEVICE(device)
    {
        const float nearer[12] = {-1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
        qcPictureMesh meshes[2] = {Square(), Square()};
        meshes[1].positions = nearer;
        meshes[1].color[0] = 0.1f;
        meshes[1].color[1] = 0.8f;
        Picture picture = Prepare(meshes, 2);
        Draw(device, &picture);
        ck_assert_int_eq(Lead(Pixel(&picture, 45, 30)), 'g');
        qcPictureMesh other = meshes[0];
        meshes[0] = meshes[1];
        meshes[1] = other;
        Draw(device, &picture);
        ck_assert_int_eq(Lead(Pixel(&picture, 45, 30)), 'g');
        free(picture.rgb);
    }
}
END_TEST

START_TEST(edges_are_drawn_as_darker_lines)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh mesh = Square();
        Picture picture = Prepare(&mesh, 1);
        picture.def.width = picture.def.height = 101; // the diagonal goes through the middle of pixels
        Draw(device, &picture);
        int plain = Pixel(&picture, 50, 50)[0], beside = Pixel(&picture, 50, 40)[0];
        mesh.wireframe = true;
        Draw(device, &picture);
        ck_assert_int_lt(Pixel(&picture, 50, 50)[0], plain - 20);
        ck_assert_int_eq(Pixel(&picture, 50, 40)[0], beside);
        free(picture.rgb);
    }
}
END_TEST

START_TEST(a_slanted_edge_is_antialiased)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh mesh = Square();
        const uint32_t half[3] = {0, 1, 2};
        mesh.indices = half;
        mesh.triangleCount = 1;
        Picture picture = Prepare(&mesh, 1);
        picture.def.target[0] = 0.013f; // off the symmetric case
        Draw(device, &picture);
        int between = 0;
        for (uint32_t y = 15; y < 45; ++y)
        {
            for (uint32_t x = 0; x < 90; ++x)
            {
                int green = Pixel(&picture, x, y)[1];
                between += green > 120 && green < 230 ? 1 : 0;
            }
        }
        ck_assert_int_gt(between, 10);
        free(picture.rgb);
    }
}
END_TEST

START_TEST(smooth_shading_changes_within_a_triangle_flat_shading_does_not)
{
    QC_FOR_EACH_DEVICE(device)
    {
        // A roof: its ridge runs along y.
        const float roof[18] = {-1, -1, 0, 0, -1, 0.8f, 0, 1, 0.8f, -1, 1, 0, 1, -1, 0, 1, 1, 0};
        const uint32_t indices[12] = {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2};
        qcPictureMesh mesh = Square();
        mesh.positions = roof;
        mesh.vertexCount = 6;
        mesh.indices = indices;
        mesh.triangleCount = 4;
        Picture picture = Prepare(&mesh, 1);
        picture.def.eye[2] = 50.0f;
        picture.def.fieldOfView = 3.0f;
        int difference[2];
        for (int smooth = 0; smooth < 2; ++smooth)
        {
            mesh.smooth = smooth == 1;
            Draw(device, &picture);
            difference[smooth] = abs((int)Pixel(&picture, 47, 30)[0] - (int)Pixel(&picture, 60, 30)[0]);
        }
        ck_assert_int_le(difference[0], 2);
        ck_assert_int_ge(difference[1], 10);
        free(picture.rgb);
    }
}
END_TEST

START_TEST(a_picture_larger_than_a_tile_has_no_seam)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh mesh = Square();
        Picture picture = Prepare(&mesh, 1);
        picture.def.width = 2300;
        picture.def.height = 6;
        picture.def.fieldOfView = 0.05f; // the square fills it
        Draw(device, &picture);
        for (uint32_t x = 0; x < 2300; ++x)
        {
            ck_assert_int_eq(Lead(Pixel(&picture, x, 3)), 'r');
            if (x > 0)
                ck_assert_int_le(abs((int)Pixel(&picture, x, 3)[0] - (int)Pixel(&picture, x - 1, 3)[0]), 1);
        }
        free(picture.rgb);
    }
}
END_TEST

START_TEST(an_empty_picture_is_background)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh empty = {0};
        Picture picture = Prepare(&empty, 1);
        for (uint32_t count = 0; count < 2; ++count)
        {
            picture.def.meshCount = count;
            picture.def.width = picture.def.height = 1;
            Draw(device, &picture);
            ck_assert(IsBackground(&picture, Pixel(&picture, 0, 0)));
        }
        free(picture.rgb);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static void Refuse(qcDevice* device, const qcPictureDef* def, const char* words)
{
    uint8_t rgb[90 * 60 * 3];
    memset(rgb, 7, sizeof rgb);
    ck_assert_int_eq(qcDevice_DrawPicture(device, def, rgb), qc_statusBadInput);
    ck_assert_msg(strstr(qcLastMessage(), words) != NULL, "'%s' is not in '%s'", words, qcLastMessage());
    for (size_t i = 0; i < sizeof rgb; ++i)
        ck_assert_uint_eq(rgb[i], 7);
}

static int s_statusesLeft; // of framebuffers, until one is incomplete

static GLenum APIENTRY CheckStatus(GLenum target)
{
    return s_statusesLeft-- == 0 ? GL_FRAMEBUFFER_UNSUPPORTED : s_real.CheckFramebufferStatus(target);
}

static void MakeIncomplete(struct qcGlFunctions* gl)
{
    gl->CheckFramebufferStatus = CheckStatus;
}

START_TEST(an_image_that_the_driver_refuses_is_named_and_the_next_picture_is_drawn)
{
    QC_FOR_EACH_DEVICE(device)
    {
        (void)MakeDriver(device, MakeIncomplete);
        const qcPictureMesh square = Square();
        Picture picture = Prepare(&square, 1);
        picture.def.hasGround = true;
        uint8_t* rgb = calloc((size_t)picture.def.width * picture.def.height, 3);
        int refused = 0;
        for (s_statusesLeft = 0; qcDevice_DrawPicture(device, &picture.def, rgb) != qc_statusOk;
             s_statusesLeft = refused)
        {
            ck_assert_ptr_nonnull(strstr(qcLastMessage(), "(0x8cdd)"));
            refused++;
        }
        // The picture's two framebuffers, and those of the light.
        ck_assert_int_ge(refused, 4);
        free(rgb);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_bad_camera_is_refused_by_name)
{
    // Input is checked before the device is used.
    qcDeviceDef deviceDef = qcDefaultDeviceDef();
    deviceDef.kind = qc_deviceNone;
    qcDevice* device = NULL;
    ck_assert_int_eq(qcDevice_Create(&deviceDef, &device), qc_statusOk);
    qcPictureMesh mesh = Square();
    const qcPictureDef good = Prepare(&mesh, 1).def;
    uint8_t rgb[3];
    ck_assert_int_eq(qcDevice_DrawPicture(NULL, &good, rgb), qc_statusBadInput);
    ck_assert_int_eq(qcDevice_DrawPicture(device, NULL, rgb), qc_statusBadInput);
    ck_assert_int_eq(qcDevice_DrawPicture(device, &good, NULL), qc_statusBadInput);

    qcPictureDef bad = good;
    bad.structSize = 1;
    Refuse(device, &bad, "structSize");
    const uint32_t sizes[4][2] = {{0, 60}, {90, 0}, {8193, 60}, {90, 8193}};
    for (int i = 0; i < 4; ++i)
    {
        bad = good;
        bad.width = sizes[i][0];
        bad.height = sizes[i][1];
        Refuse(device, &bad, "pixels");
    }
    bad = good;
    bad.eye[1] = NAN;
    Refuse(device, &bad, "eye");
    bad = good;
    memcpy(bad.target, bad.eye, sizeof bad.eye);
    Refuse(device, &bad, "same point");
    bad = good;
    memset(bad.up, 0, sizeof bad.up);
    Refuse(device, &bad, "up");
    bad = good;
    bad.up[1] = 0.0f;
    bad.up[2] = 1.0f;
    Refuse(device, &bad, "line of sight");
    bad = good;
    bad.fieldOfView = 180.0f;
    Refuse(device, &bad, "field of view");
    bad = good;
    bad.background[2] = 1.5f;
    Refuse(device, &bad, "background");
    bad = good;
    bad.light[2] = INFINITY;
    Refuse(device, &bad, "the light is not finite");
    // Without a ground, what it would be is of no interest.
    bad = good;
    bad.groundTile = -1.0f;
    ck_assert_int_eq(qcDevice_DrawPicture(device, &bad, rgb), qc_statusDevice);
    bad.hasGround = true;
    Refuse(device, &bad, "the ground's tiles");
    bad.groundTile = 0.0f;
    bad.groundHeight = NAN;
    Refuse(device, &bad, "the ground's height");
    bad.groundHeight = 0.0f;
    bad.groundExtent = -1.0f;
    Refuse(device, &bad, "the ground's extent");
    bad.groundExtent = 0.0f;
    bad.groundColor[1] = 2.0f;
    Refuse(device, &bad, "the ground's colour");

    ck_assert_int_eq(qcDevice_DrawPicture(device, &good, rgb), qc_statusDevice);
    qcDevice_Destroy(device);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_bad_mesh_is_refused_by_number)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcPictureMesh meshes[2] = {Square(), Square()};
        qcPictureDef def = Prepare(meshes, 2).def;
        def.meshes = NULL;
        Refuse(device, &def, "meshes is null");
        def.meshes = meshes;

        meshes[1].positions = NULL;
        Refuse(device, &def, "positions of mesh 1 is null");
        meshes[1] = Square();
        meshes[1].indices = NULL;
        Refuse(device, &def, "indices of mesh 1 is null");
        meshes[1] = Square();
        const uint32_t outside[6] = {0, 1, 2, 0, 4, 3};
        meshes[1].indices = outside;
        Refuse(device, &def, "index 4 of mesh 1 is 4, but the mesh has 4 vertices");
        meshes[1] = Square();
        float broken[12];
        memcpy(broken, s_square, sizeof broken);
        broken[7] = INFINITY;
        meshes[1].positions = broken;
        Refuse(device, &def, "vertex 2 of mesh 1 is not finite");
        meshes[1] = Square();
        meshes[1].markColor[0] = NAN;
        Refuse(device, &def, "colour of mesh 1");
        meshes[1] = Square();
        meshes[1].triangleCount = 0x7fffffff;
        Refuse(device, &def, "mesh 1 has 2147483647 triangles");
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("picture", a_mesh_is_drawn_in_the_middle_and_background_in_the_corners,
                        the_back_is_seen_from_behind, marked_triangles_and_only_they_have_the_mark_colour,
                        the_top_row_is_first_and_the_left_column_too, the_nearer_mesh_hides_the_farther_one,
                        edges_are_drawn_as_darker_lines, a_slanted_edge_is_antialiased,
                        smooth_shading_changes_within_a_triangle_flat_shading_does_not,
                        a_picture_larger_than_a_tile_has_no_seam, an_empty_picture_is_background,
                        an_image_that_the_driver_refuses_is_named_and_the_next_picture_is_drawn,
                        a_bad_camera_is_refused_by_name, a_bad_mesh_is_refused_by_number)
