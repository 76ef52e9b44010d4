// `qc-report` as a user runs it: the page is well-formed, holds all that it shows, and names what is missing.
#include "common/png_file.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum
{
    qc_maxPage = 1 << 20
};

static char s_page[qc_maxPage];

static void WritePicture(const char* path, uint8_t shade)
{
    uint8_t rgb[4 * 3 * 3];
    memset(rgb, shade, sizeof rgb);
    qcMessage message;
    ck_assert_msg(qcPng_Write(path, 4, 3, rgb, &message), "%s", message.text);
}

/// A folder of results: a demo with a film and frames, a benchmark that is known, and one that is not.
static void WriteResults(void)
{
    ck_assert_int_eq(Run("mkdir -p out/cloth out/bench"), 0);
    WriteText("out/cloth/cloth.txt", "$ demos/run.sh cloth --steps 5\na < b & \"c\"\n");
    WriteText("out/cloth/cloth.mp4", "no film, but bytes");
    for (int i = 0; i < 9; ++i)
    {
        char path[64];
        snprintf(path, sizeof path, "out/cloth/frame_%04d.png", i);
        WritePicture(path, (uint8_t)i);
    }
    WriteText("out/bench/scaling.txt", "$ demos/run.sh bench scaling\nms\n");
    WriteText("out/bench/scaling_meshes.csv", "name,ms\n\"a, \"\"b\"\"\",1.5\nc,\n");
    WritePicture("out/bench/scaling.png", 200);
    WriteText("out/bench/scaling.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\"><title>plot</title></svg>\n");
    WriteText("out/bench/unheard-of_part.csv", "x\n1\n");
    WriteText("out/bench/scaling.gp", "not shown\n");
}

/// Writes the page, and reads it.
static void MakePage(const char* options)
{
    ck_assert_msg(Run(QC_REPORT_PROGRAM " --page page.html %s", options) == 0, "%s", GetErrors());
    ck_assert(ReadText("page.html", s_page, sizeof s_page));
}

static size_t Count(const char* part)
{
    size_t count = 0;
    for (const char* c = strstr(s_page, part); c != NULL; c = strstr(c + 1, part))
        ++count;
    return count;
}

START_TEST(the_page_is_well_formed)
{
    EnterFolder();
    WriteResults();
    MakePage("");
    ck_assert_msg(Run("xmllint --noout --nonet --huge page.html") == 0, "%s", GetErrors());
    ck_assert_str_eq(GetErrors(), "");
    ck_assert_int_eq(Run("mkdir empty"), 0);
    MakePage("--from empty");
    ck_assert_msg(Run("xmllint --noout --nonet --huge page.html") == 0, "%s", GetErrors());
    LeaveFolder();
}
END_TEST

/// Calls a function with the value of each attribute of this name.
static void ForEachValue(const char* attribute, void (*take)(const char* value, size_t length))
{
    char begin[32];
    snprintf(begin, sizeof begin, " %s=\"", attribute);
    for (const char* c = strstr(s_page, begin); c != NULL; c = strstr(c, begin))
    {
        c += strlen(begin);
        take(c, strcspn(c, "\""));
    }
}

static void CheckInside(const char* value, size_t length)
{
    ck_assert_msg(value[0] == '#' || strncmp(value, "data:", 5) == 0, "%.*s", (int)length, value);
}

START_TEST(nothing_leads_out_of_the_page)
{
    EnterFolder();
    WriteResults();
    MakePage("");
    ForEachValue("src", CheckInside);
    ForEachValue("href", CheckInside);
    // Names of elements and attributes that load files, and of CSS.
    static const char* const loaders[] = {"<script", "<link", "<iframe", "srcset", "poster=", "url(", "@import"};
    for (size_t i = 0; i < sizeof loaders / sizeof loaders[0]; ++i)
        ck_assert_msg(strstr(s_page, loaders[i]) == NULL, "%s", loaders[i]);
    // The namespace.
    ck_assert_uint_eq(Count("http"), 1);
    // Each link within the page has its goal.
    for (const char* c = strstr(s_page, "href=\"#"); c != NULL; c = strstr(c + 1, "href=\"#"))
    {
        char goal[256];
        snprintf(goal, sizeof goal, "id=\"%.*s\"", (int)strcspn(c + 7, "\""), c + 7);
        ck_assert_msg(strstr(s_page, goal) != NULL, "%s", goal);
    }
    LeaveFolder();
}
END_TEST

static unsigned s_pictures;

static void Decode(const char* value, size_t length)
{
    static const char type[] = "data:image/png;base64,";
    if (strncmp(value, type, sizeof type - 1) != 0)
        return;
    FILE* stream = fopen("picture.base64", "w");
    ck_assert_ptr_nonnull(stream);
    fwrite(value + sizeof type - 1, 1, length - sizeof type + 1, stream);
    fclose(stream);
    ck_assert_int_eq(Run("base64 --decode picture.base64 >picture.png"), 0);
    png_image image = {.version = PNG_IMAGE_VERSION};
    ck_assert_msg(png_image_begin_read_from_file(&image, "picture.png") != 0, "%s", image.message);
    ck_assert_uint_eq(image.width, 4);
    uint8_t rgb[4 * 3 * 3];
    image.format = PNG_FORMAT_RGB;
    ck_assert_msg(png_image_finish_read(&image, NULL, rgb, 0, NULL) != 0, "%s", image.message);
    // The frames in the page are the third, the sixth and the last.
    ck_assert_uint_eq(rgb[0], 2 + 3 * s_pictures);
    ++s_pictures;
}

START_TEST(every_picture_decodes_and_three_frames_stand_for_a_series)
{
    EnterFolder();
    WriteResults();
    MakePage("");
    s_pictures = 0;
    ForEachValue("src", Decode);
    ck_assert_uint_eq(s_pictures, 3);
    ck_assert_uint_eq(Count("<video "), 1);
    ck_assert_uint_eq(Count("src=\"data:video/mp4;base64,bm8gZmlsbSwgYnV0IGJ5dGVz\""), 1);
    LeaveFolder();
}
END_TEST

START_TEST(a_drawing_stands_for_the_same_plot_in_pixels_unless_it_is_older)
{
    EnterFolder();
    WriteResults();
    ck_assert_int_eq(Run("touch -d '2020-01-01' out/bench/scaling.png"), 0);
    MakePage("");
    ck_assert_uint_eq(Count("alt=\"scaling.svg\""), 1);
    ck_assert_uint_eq(Count("alt=\"scaling.png\""), 0);
    ck_assert_int_eq(Run("touch -d '2019-01-01' out/bench/scaling.svg"), 0);
    MakePage("");
    ck_assert_uint_eq(Count("alt=\"scaling.png\""), 1);
    LeaveFolder();
}
END_TEST

START_TEST(texts_and_tables_are_whole)
{
    EnterFolder();
    WriteResults();
    MakePage("--revision 12ab");
    ck_assert_uint_eq(Count("<p class=\"command\"><code>demos/run.sh cloth --steps 5</code></p>"), 1);
    ck_assert_uint_eq(Count("a &lt; b &amp; &quot;c&quot;\n"), 1);
    ck_assert_uint_eq(Count("<tr><td>a, &quot;b&quot;</td><td class=\"n\">1.5</td></tr>"), 1);
    ck_assert_uint_eq(Count("<tr><td>c</td><td class=\"n\"></td></tr>"), 1);
    ck_assert_uint_eq(Count("scaling_meshes.csv: 2 rows"), 1);
    ck_assert_uint_eq(Count("<h2>unheard-of</h2>"), 1);
    ck_assert_uint_eq(Count(", revision 12ab</td>"), 1);
    ck_assert_uint_eq(Count("not shown"), 0);
    LeaveFolder();
}
END_TEST

START_TEST(a_demo_and_a_benchmark_of_one_name_have_their_own_files)
{
    EnterFolder();
    ck_assert_int_eq(Run("mkdir -p out/bench out/fracture"), 0);
    WriteText("out/bench/fracture.txt", "$ demos/run.sh bench fracture\nhulls\n");
    MakePage("");
    ck_assert_uint_eq(Count("This makes it: <code>demos/run.sh fracture</code>"), 1);
    ck_assert_uint_eq(Count("This makes it: <code>demos/run.sh bench fracture</code>"), 0);
    WriteText("out/fracture/fracture.txt", "$ demos/run.sh fracture\npieces\n");
    ck_assert_int_eq(Run("rm out/bench/fracture.txt"), 0);
    MakePage("");
    ck_assert_uint_eq(Count("This makes it: <code>demos/run.sh fracture</code>"), 0);
    ck_assert_uint_eq(Count("This makes it: <code>demos/run.sh bench fracture</code>"), 1);
    LeaveFolder();
}
END_TEST

START_TEST(what_is_missing_is_named_with_its_command)
{
    EnterFolder();
    WriteResults();
    MakePage("");
    ck_assert_uint_eq(Count("This makes it: <code>demos/run.sh fracture</code>"), 1);
    ck_assert_uint_eq(Count("This makes it: <code>demos/run.sh bench peers</code>"), 1);
    ck_assert_uint_eq(Count("This makes it: <code>demos/run.sh cloth</code>"), 0);
    LeaveFolder();
}
END_TEST

START_TEST(a_picture_that_is_cut_is_named_not_shown)
{
    EnterFolder();
    WriteResults();
    ck_assert_int_eq(Run("truncate -s -9 out/cloth/frame_0008.png"), 0);
    MakePage("");
    ck_assert_uint_eq(Count("frame_0008.png is not complete"), 1);
    ck_assert_uint_eq(Count("alt=\"frame_0008.png\""), 0);
    LeaveFolder();
}
END_TEST

START_TEST(a_smaller_film_takes_the_place_of_its_namesake)
{
    EnterFolder();
    WriteResults();
    ck_assert_int_eq(Run("mkdir small"), 0);
    WriteText("small/cloth.mp4", "small");
    MakePage("--films small");
    ck_assert_uint_eq(Count("src=\"data:video/mp4;base64,c21hbGw=\""), 1);
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_with_a_message)
{
    EnterFolder();
    ck_assert_int_eq(Run(QC_REPORT_PROGRAM " --form out"), 2);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "unrecognized option '--form'"));
    ck_assert_int_eq(Run(QC_REPORT_PROGRAM " --from elsewhere --page page.html"), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "elsewhere: No such file or directory"));
    ck_assert_int_eq(Run("mkdir out"), 0);
    ck_assert_int_eq(Run(QC_REPORT_PROGRAM " --page nowhere/page.html"), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "nowhere/page.html"));
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("report", the_page_is_well_formed, nothing_leads_out_of_the_page,
             every_picture_decodes_and_three_frames_stand_for_a_series,
             a_drawing_stands_for_the_same_plot_in_pixels_unless_it_is_older, texts_and_tables_are_whole,
             a_demo_and_a_benchmark_of_one_name_have_their_own_files, what_is_missing_is_named_with_its_command,
             a_picture_that_is_cut_is_named_not_shown, a_smaller_film_takes_the_place_of_its_namesake,
             mistakes_are_refused_with_a_message)
