// The demos' live window, on a display without a screen: screenshots have the scene, the colours of the marks and the
// panels where they belong.
#define _POSIX_C_SOURCE 200809L
#include "support/run_program.h"
#include "support/suite.h"

#include "common/mesh_io/bunny_path.h"

#include <check.h>
#include <png.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// A window of 1280 x 800; Mesa draws it in software. The file of authorizations is in the test's folder: where xvfb-run
// fails to remove a folder of its own, it exits with status 5 in place of the program's status.
#define DISPLAY "LIBGL_ALWAYS_SOFTWARE=1 xvfb-run -a -f authority -s '-screen 0 1280x800x24' "
#define CLOTH DISPLAY QC_CLOTH_PROGRAM " --triangles 2000 --method sweep "
#define FRACTURE DISPLAY QC_FRACTURE_PROGRAM " "

enum
{
    qc_width = 1280,
    qc_height = 800
};

typedef struct Picture
{
    png_image image;
    uint8_t* rgb;
} Picture;

static Picture Read(const char* path)
{
    Picture p = {.image = {.version = PNG_IMAGE_VERSION}};
    ck_assert_msg(png_image_begin_read_from_file(&p.image, path), "%s: %s", path, p.image.message);
    p.image.format = PNG_FORMAT_RGB;
    p.rgb = malloc(PNG_IMAGE_SIZE(p.image));
    ck_assert(png_image_finish_read(&p.image, NULL, p.rgb, 0, NULL));
    ck_assert_uint_eq(p.image.width, qc_width);
    ck_assert_uint_eq(p.image.height, qc_height);
    return p;
}

typedef bool IsColor(int r, int g, int b);

static bool IsOrange(int r, int g, int b)
{
    return r > g + 25 && g > b + 15;
}

static bool IsBlue(int r, int g, int b)
{
    return b > r + 40 && b > g + 15;
}

static bool IsRed(int r, int g, int b)
{
    return r > 110 && r > 3 * g && r > 3 * b;
}

static bool IsGreen(int r, int g, int b)
{
    return g > 80 && g > 2 * r && g > b + 40;
}

static bool IsLight(int r, int g, int b)
{
    return r > 215 && g > 215 && b > 215;
}

static bool IsDark(int r, int g, int b)
{
    return r + g + b < 300;
}

/// Share of the pixels of a rectangle that have a colour, in percent.
static double Share(const Picture* p, IsColor* isColor, int left, int top, int right, int bottom)
{
    int count = 0;
    for (int y = top; y < bottom; y++)
        for (int x = left; x < right; x++)
        {
            const uint8_t* pixel = p->rgb + 3 * ((size_t)y * qc_width + (size_t)x);
            count += isColor(pixel[0], pixel[1], pixel[2]);
        }
    return 100.0 * count / ((right - left) * (bottom - top));
}

/// Between the panels.
static double ShareOfScene(const Picture* p, IsColor* isColor)
{
    return Share(p, isColor, 320, 0, 960, qc_height);
}

/// Runs a command and reads its screenshot.
static Picture TakePicture(const char* command, const char* options)
{
    int status = Run("%s --view-screenshot a.png %s", command, options);
    ck_assert_msg(status == 0, "exit status %d: %s", status, GetErrors());
    return Read("a.png");
}

START_TEST(the_cloth_covers_a_part_of_the_window_in_its_colours)
{
    EnterFolder();
    Picture p = TakePicture(CLOTH, "--view-frames 3");
    // Flat and a little above the table: its upper side is orange.
    double orange = ShareOfScene(&p, IsOrange);
    ck_assert_msg(orange > 15.0 && orange < 70.0, "%g %% orange", orange);
    ck_assert_double_lt(ShareOfScene(&p, IsRed), 0.1);
    ck_assert_double_lt(ShareOfScene(&p, IsGreen), 0.1);
    // The floor around it.
    ck_assert_double_gt(Share(&p, IsLight, 320, 640, 960, 800), 25.0);
    free(p.rgb);
    LeaveFolder();
}
END_TEST

START_TEST(the_panels_are_at_both_sides_with_text)
{
    EnterFolder();
    Picture p = TakePicture(CLOTH, "--view-frames 3");
    static const int panels[2][2] = {{12, 304}, {976, 1268}};
    for (int i = 0; i < 2; i++)
    {
        double light = Share(&p, IsLight, panels[i][0], 14, panels[i][1], 300);
        double dark = Share(&p, IsDark, panels[i][0], 14, panels[i][1], 300);
        ck_assert_msg(light > 60.0, "panel %d: %g %% light", i, light);
        ck_assert_msg(dark > 1.0 && dark < 25.0, "panel %d: %g %% dark", i, dark);
    }
    // The bars of the stages.
    ck_assert_double_gt(Share(&p, IsBlue, 976, 60, 1268, 400), 1.0);
    free(p.rgb);
    LeaveFolder();
}
END_TEST

START_TEST(the_marked_pcs_is_red_and_the_rest_grey)
{
    EnterFolder();
    Picture p = TakePicture(CLOTH, "--view-frames 14 --view-show pcs");
    // The cloth lies on the table: its candidates are red.
    double red = ShareOfScene(&p, IsRed);
    ck_assert_msg(red > 1.0, "%g %% red", red);
    ck_assert_double_lt(ShareOfScene(&p, IsOrange), 1.0);
    free(p.rgb);
    LeaveFolder();
}
END_TEST

START_TEST(the_sets_of_quick_cullide_have_colours_of_their_own)
{
    EnterFolder();
    Picture p = TakePicture(CLOTH, "--view-frames 20 --view-show sets");
    // FFV or SFV: which of them is large depends on the order of the triangles.
    double free1 = ShareOfScene(&p, IsGreen), free2 = ShareOfScene(&p, IsBlue);
    ck_assert_msg(free1 + free2 > 1.0, "%g %% green, %g %% blue", free1, free2);
    ck_assert_double_lt(ShareOfScene(&p, IsOrange), 1.0);
    free(p.rgb);
    LeaveFolder();
}
END_TEST

START_TEST(debug_lines_change_the_picture)
{
    EnterFolder();
    Picture plain = TakePicture(CLOTH, "--view-frames 14");
    Picture lines = TakePicture(CLOTH, "--view-frames 14 --view-show candidates,contacts,manifolds,boxes");
    size_t different = 0;
    for (int y = 0; y < qc_height; y++)
        for (int x = 320; x < 960; x++)
            different += memcmp(plain.rgb + 3 * ((size_t)y * qc_width + (size_t)x),
                                lines.rgb + 3 * ((size_t)y * qc_width + (size_t)x), 3) != 0;
    ck_assert_uint_gt(different, 2000);
    free(plain.rgb);
    free(lines.rgb);
    LeaveFolder();
}
END_TEST

START_TEST(the_breaking_body_is_in_its_window)
{
    EnterFolder();
    if (access(QC_BUNNY_PATH, R_OK) == 0)
    {
        Picture p = TakePicture(FRACTURE, "--triangles 1000 --pieces 20 --view-frames 3");
        ck_assert_double_gt(ShareOfScene(&p, IsOrange) + ShareOfScene(&p, IsBlue), 5.0);
        free(p.rgb);
    }
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    EnterFolder();
    ck_assert_int_eq(Run("%s --view --view-show pcs,colours", QC_CLOTH_PROGRAM), 2);
    ck_assert_msg(strstr(GetErrors(), "--view-show") != NULL && strstr(GetErrors(), "colours") != NULL, "%s",
                  GetErrors());
    ck_assert_int_eq(Run("env -u DISPLAY -u WAYLAND_DISPLAY %s --triangles 200 --view", QC_CLOTH_PROGRAM), 4);
    ck_assert_msg(strstr(GetErrors(), "no window") != NULL, "%s", GetErrors());
    ck_assert_int_eq(Run("%s --view --view-frames 1 --view-screenshot no/a.png", CLOTH), 1);
    ck_assert_msg(strstr(GetErrors(), "no/a.png: No such file or directory") != NULL, "%s", GetErrors());
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("view", the_cloth_covers_a_part_of_the_window_in_its_colours, the_panels_are_at_both_sides_with_text,
             the_marked_pcs_is_red_and_the_rest_grey, the_sets_of_quick_cullide_have_colours_of_their_own,
             debug_lines_change_the_picture, the_breaking_body_is_in_its_window, mistakes_are_refused_with_a_message)
