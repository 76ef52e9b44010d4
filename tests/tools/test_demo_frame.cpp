// Frames of the demos: the scene at the left, the same with the PCS in red at the right.
#include "common/bullet/demo_frame.h"

#include "support/suite.h"

#include <png.h>

#include <cstdio>
#include <unistd.h>

namespace
{
constexpr uint32_t s_width = 80, s_height = 60;
const float s_square[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
const uint32_t s_indices[6] = {0, 1, 2, 0, 2, 3};

struct Image
{
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgb;

    /// Pixels in a range of columns in which red is by far the strongest.
    int Reds(uint32_t from, uint32_t to) const
    {
        int count = 0;
        for (uint32_t y = 0; y < height; y++)
            for (uint32_t x = from; x < to; x++)
            {
                const uint8_t* p = &rgb[3 * (size_t(y) * width + x)];
                count += p[0] > 150 && p[0] > p[1] + 80 && p[0] > p[2] + 80;
            }
        return count;
    }
    /// Pixels in which the channels differ.
    int Coloured(uint32_t from, uint32_t to) const
    {
        int count = 0;
        for (uint32_t y = 0; y < height; y++)
            for (uint32_t x = from; x < to; x++)
            {
                const uint8_t* p = &rgb[3 * (size_t(y) * width + x)];
                count += std::abs(p[0] - p[1]) > 25 || std::abs(p[1] - p[2]) > 25;
            }
        return count;
    }
};

Image Read(const std::string& path)
{
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    ck_assert_msg(png_image_begin_read_from_file(&png, path.c_str()) != 0, "%s", png.message);
    png.format = PNG_FORMAT_RGB;
    Image image;
    image.width = png.width;
    image.height = png.height;
    image.rgb.resize(PNG_IMAGE_SIZE(png));
    ck_assert(png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr) != 0);
    return image;
}

qcFrameMesh Square()
{
    qcFrameMesh mesh;
    mesh.positions = s_square;
    mesh.vertexCount = 4;
    mesh.indices = s_indices;
    mesh.triangleCount = 2;
    qcSet3(mesh.color, 0.1f, 0.5f, 0.1f);
    return mesh;
}

qcDevice* OpenDevice()
{
    qcDeviceDef def = qcDefaultDeviceDef();
    qcDevice* device = nullptr;
    ck_assert_int_eq(qcDevice_Create(&def, &device), qc_statusOk);
    return device;
}

Image Write(qcDemoFrame* frame)
{
    std::string path = "frame_" + std::to_string(getpid()) + ".png", message;
    qcDevice* device = OpenDevice();
    ck_assert_msg(frame->Write(device, path, &message), "%s", message.c_str());
    qcDevice_Destroy(device);
    Image image = Read(path);
    std::remove(path.c_str());
    return image;
}
} // namespace

START_TEST(the_pcs_is_red_at_the_right_and_nothing_else_has_a_colour_there)
{
    const uint8_t pcs[2] = {0, 1};
    qcDemoFrame frame(s_width, s_height);
    frame.ground.isDrawn = false;
    qcFrameMesh mesh = Square();
    mesh.pcs = pcs;
    frame.Add(mesh);
    Image image = Write(&frame);
    ck_assert_uint_eq(image.width, 2 * s_width);
    ck_assert_uint_eq(image.height, s_height);
    ck_assert_int_eq(image.Reds(0, s_width), 0);
    int reds = image.Reds(s_width, 2 * s_width), coloured = image.Coloured(0, s_width);
    ck_assert_int_gt(reds, 100);
    // One of two triangles.
    ck_assert_int_lt(2 * reds, coloured + 60);
    ck_assert_int_le(image.Coloured(s_width, 2 * s_width), reds + 60); // the rim of the red is antialiased
}
END_TEST

START_TEST(without_flags_there_is_no_right_half)
{
    qcDemoFrame frame(s_width, s_height);
    frame.Add(Square());
    Image image = Write(&frame);
    ck_assert_uint_eq(image.width, s_width);
    ck_assert_int_gt(image.Coloured(0, s_width), 100);
}
END_TEST

START_TEST(bodies_are_drawn_where_they_are_and_stay_until_the_frame_is_cleared)
{
    qcDemoFrame frame(s_width, s_height);
    frame.ground.isDrawn = false;
    std::vector<btVector3> vertices;
    for (int i = 0; i < 4; i++)
        vertices.emplace_back(0.2f * s_square[3 * i], 0.2f * s_square[3 * i + 1], 0.0f);
    qcFrameMesh mesh = Square();
    const float* first = nullptr;
    for (int i = 0; i < 500; i++)
    {
        btTransform place(btQuaternion::getIdentity(), btVector3(i == 0 ? btScalar(-1) : btScalar(1), 1, 0));
        mesh.positions = frame.Place(vertices.data(), vertices.size(), place);
        first = i == 0 ? mesh.positions : first;
        frame.Add(mesh);
    }
    ck_assert_float_eq_tol(first[0], -1.2f, 1e-6f);
    Image image = Write(&frame);
    ck_assert_int_gt(image.Coloured(0, s_width / 2), 20);
    ck_assert_int_gt(image.Coloured(s_width / 2, s_width), 20);
    frame.Clear();
    ck_assert_int_eq(Write(&frame).Coloured(0, s_width), 0);
}
END_TEST

START_TEST(a_folder_that_is_missing_is_named)
{
    qcDemoFrame frame(s_width, s_height);
    qcDevice* device = OpenDevice();
    std::string message;
    ck_assert(!frame.Write(device, "no/such/folder/frame.png", &message));
    ck_assert_msg(message.find("no/such/folder/frame.png") != std::string::npos, "%s", message.c_str());
    qcDevice_Destroy(device);
}
END_TEST

QC_RUN_TESTS("demo_frame", the_pcs_is_red_at_the_right_and_nothing_else_has_a_colour_there,
             without_flags_there_is_no_right_half, bodies_are_drawn_where_they_are_and_stay_until_the_frame_is_cleared,
             a_folder_that_is_missing_is_named)
