// The reports of qc-pairs: text, JSON and picture.
#include "support/run_program.h"
#include "support/suite.h"
#include "tools/json_report.h"
#include "tools/pair_meshes.h"

#include <check.h>
#include <inttypes.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PAIRS QC_PAIRS_PROGRAM

static char s_written[1 << 19];

START_TEST(json_reports_pairs_and_times)
{
    ck_assert_int_eq(Run("%s --json --touching --method sweep --reps 4 --out found 2.ply 0.ply", PAIRS), 0);
    json_object* object = Parse(GetOutput());
    ck_assert(ReadText("found", s_written, sizeof s_written));
    uint64_t lines = 0, touching = 0;
    for (const char* line = s_written; *line != 0; line = strchr(line, '\n') + 1)
    {
        ++lines;
        touching += strchr(line, '\n')[-2] == 'n' && strchr(line, '\n')[-8] == 't';
    }
    ck_assert_uint_eq(GetNumber(object, "pairs"), lines);
    ck_assert_uint_eq(GetNumber(object, "touching"), touching);
    ck_assert_uint_eq(GetNumber(object, "penetrating"), lines - touching);
    ck_assert_uint_eq(GetNumber(object, "near"), 0);
    ck_assert_uint_eq(GetNumber(object, "bodies"), 2);
    ck_assert_uint_eq(GetNumber(object, "triangles"), 2 * qc_triangleCount);
    ck_assert_uint_eq(GetNumber(object, "reps"), 4);
    ck_assert_uint_ge(GetNumber(object, "candidates"), lines);
    ck_assert_str_eq(json_object_get_string(Get(object, "method")), "sweep");
    ck_assert_str_eq(json_object_get_string(Get(object, "device")), "none");
    ck_assert_ptr_null(Get(object, "fallback"));
    json_object* mesh = json_object_array_get_idx(Get(object, "meshes"), 0);
    ck_assert_str_eq(json_object_get_string(Get(mesh, "file")), "2.ply");
    ck_assert_str_eq(json_object_get_string(Get(mesh, "positions")), "double");
    ck_assert_uint_eq(GetNumber(mesh, "vertices"), qc_vertexCount);
    json_object* total = Get(Get(object, "milliseconds"), "total");
    double least = json_object_get_double(Get(total, "min")), median = json_object_get_double(Get(total, "median"));
    ck_assert(least > 0.0 && least <= median);
    ck_assert_uint_gt(GetNumber(Get(object, "skips"), "skippedNeighbours"), 0);
    json_object_put(object);
}
END_TEST

START_TEST(a_method_that_cannot_draw_reports_which_one_ran)
{
    ck_assert_int_eq(Run("%s --method quick --device none 0.ply 1.ply", PAIRS), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "sweep instead of quick: "));
    ck_assert_int_eq(Run("%s --method quick --device none --json 0.ply 1.ply", PAIRS), 0);
    json_object* object = Parse(GetOutput());
    ck_assert_str_eq(json_object_get_string(Get(object, "methodAsked")), "quick");
    ck_assert_str_eq(json_object_get_string(Get(object, "method")), "sweep");
    ck_assert_ptr_nonnull(Get(object, "fallback"));
    json_object_put(object);
}
END_TEST

/// True if some device draws here; auto opens one then.
static bool CanDraw(void)
{
    qcDeviceDef def = qcDefaultDeviceDef();
    qcDevice* device;
    qcDeviceInfo info;
    ck_assert_int_eq(qcDevice_Create(&def, &device), qc_statusOk);
    ck_assert_int_eq(qcDevice_GetInfo(device, &info), qc_statusOk);
    bool draws = info.kind != qc_deviceNone;
    qcDevice_Destroy(device);
    return draws;
}

START_TEST(visibility_methods_report_their_passes)
{
    int ending = Run("%s --method quick --views zx --resolution 256 --json 0.ply 1.ply", PAIRS);
    ck_assert_int_eq(ending, 0);
    json_object* object = Parse(GetOutput());
    size_t passes = json_object_array_length(Get(object, "passes"));
    if (CanDraw())
    {
        ck_assert_str_eq(json_object_get_string(Get(object, "method")), "quick");
        ck_assert_uint_eq(GetNumber(object, "resolution"), 256);
        ck_assert_uint_ge(passes, 2);
        json_object* first = json_object_array_get_idx(Get(object, "passes"), 0);
        ck_assert_str_eq(json_object_get_string(Get(first, "level")), "objects");
        ck_assert_str_eq(json_object_get_string(Get(first, "axis")), "z");
    }
    else
        ck_assert_uint_eq(passes, 0);
    json_object_put(object);
}
END_TEST

START_TEST(layers_reports_its_image_and_its_memory)
{
    ck_assert_int_eq(Run("%s --method layers --json 0.ply 1.ply", PAIRS), 0);
    json_object* object = Parse(GetOutput());
    bool ran = strcmp(json_object_get_string(Get(object, "method")), "layers") == 0;
    static const char* const counts[] = {"columns", "fragments", "listPairs", "uploadedBytes", "deviceBytes"};
    for (int i = 0; i < 5; ++i)
        ck_assert_int_eq(GetNumber(object, counts[i]) > 0, ran);
    GetNumber(object, "reruns");
    ck_assert_uint_gt(GetNumber(object, "hostBytes"), 0);
    ck_assert_int_eq(json_object_get_boolean(Get(object, "softwareDevice")) && !ran, false);
    ck_assert_int_eq(Get(object, "fallback") == NULL, ran);
    json_object_put(object);
}
END_TEST

START_TEST(the_report_repeats_the_options)
{
    ck_assert_int_eq(Run("%s --json --margin 0.125 --method quick --reliable --back-to-front 0.ply", PAIRS), 0);
    json_object* object = Parse(GetOutput());
    ck_assert_double_eq(json_object_get_double(Get(object, "margin")), 0.125);
    ck_assert(json_object_get_boolean(Get(object, "backToFront")));
    ck_assert(!json_object_get_boolean(Get(object, "secondPassFromBack")));
    ck_assert(json_object_get_boolean(Get(object, "reliable")));
    uint64_t near = GetNumber(object, "near"), touching = GetNumber(object, "touching");
    ck_assert_uint_eq(GetNumber(object, "pairs"), near + touching + GetNumber(object, "penetrating"));
    json_object_put(object);
    char line[64];
    snprintf(line, sizeof line, " %" PRIu64 " touching, %" PRIu64 " near\n", touching, near);
    ck_assert_int_eq(Run("%s --margin 0.125 0.ply", PAIRS), 0);
    ck_assert_msg(strstr(GetOutput(), line) != NULL, "'%s' is not in: %s", line, GetOutput());
}
END_TEST

START_TEST(memory_is_given_by_the_triangle_for_many_triangles_only)
{
    ck_assert_int_eq(Run("%s 0.ply", PAIRS), 0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), " bytes on the host, 0 on the device\n"));
    FILE* strip = fopen("strip.obj", "w");
    ck_assert_ptr_nonnull(strip);
    for (int i = 0; i < 10002; ++i)
        fprintf(strip, "v %d %d 0\n", i, i % 2);
    for (int i = 1; i <= 10000; ++i)
        fprintf(strip, "f %d %d %d\n", i, i + 1, i + 2);
    ck_assert_int_eq(fclose(strip), 0);
    ck_assert_int_eq(Run("%s strip.obj", PAIRS), 0);
    const char* memory = strstr(GetOutput(), " on the device, ");
    double host, device;
    ck_assert_ptr_nonnull(memory);
    ck_assert_int_eq(sscanf(memory, " on the device, %lf and %lf a triangle\n", &host, &device), 2);
    ck_assert_double_gt(host, 10.0);
    ck_assert_double_eq(device, 0.0);
}
END_TEST

START_TEST(the_picture_shows_the_potentially_colliding_set_in_red)
{
    // Two crossing triangles, and one apart.
    WriteText("cross.obj", "v -1 0 0\nv 1 0 0\nv 0 2 0\nv 0 1 -1\nv 0 1 1\nv 0 -1 0\nv 3 0 0\nv 4 0 0\nv 3 1 0\n"
                           "f 1 2 3\nf 4 5 6\nf 7 8 9\n");
    int ending = Run("%s --method sweep --picture a.png cross.obj", PAIRS);
    if (!CanDraw())
    {
        ck_assert_int_eq(ending, 4);
        ck_assert_ptr_nonnull(strstr(GetErrors(), "--picture: "));
        return;
    }
    ck_assert_msg(ending == 0, "%s", GetErrors());
    png_image image;
    memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    ck_assert(png_image_begin_read_from_file(&image, "a.png"));
    image.format = PNG_FORMAT_RGB;
    uint8_t* rgb = malloc(PNG_IMAGE_SIZE(image));
    ck_assert_ptr_nonnull(rgb);
    ck_assert(png_image_finish_read(&image, NULL, rgb, 0, NULL));
    size_t red = 0, other = 0, count = (size_t)image.width * image.height;
    for (size_t i = 0; i < count; ++i)
    {
        const uint8_t* pixel = rgb + 3 * i;
        bool isRed = pixel[0] > 2 * pixel[1] && pixel[0] > 2 * pixel[2];
        bool isBackground = memcmp(pixel, rgb, 3) == 0;
        red += isRed;
        other += !isRed && !isBackground;
    }
    // Each fills some of the picture and none all of it.
    ck_assert_uint_gt(red, count / 100);
    ck_assert_uint_gt(other, count / 500);
    ck_assert_uint_lt(red + other, count / 2);
    free(rgb);
}
END_TEST

int main(void)
{
    TCase* tests = qcMakeCase("qc_pairs_report");
    tcase_add_checked_fixture(tests, EnterWithMeshes, LeaveFolder);
    tcase_add_test(tests, json_reports_pairs_and_times);
    tcase_add_test(tests, a_method_that_cannot_draw_reports_which_one_ran);
    tcase_add_test(tests, visibility_methods_report_their_passes);
    tcase_add_test(tests, layers_reports_its_image_and_its_memory);
    tcase_add_test(tests, the_report_repeats_the_options);
    tcase_add_test(tests, memory_is_given_by_the_triangle_for_many_triangles_only);
    tcase_add_test(tests, the_picture_shows_the_potentially_colliding_set_in_red);
    return qcRunCase("qc_pairs_report", tests);
}
