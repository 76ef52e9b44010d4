// The pair finder as its users meet it: what it prints, writes and answers, and how it refuses. The oracle is every
// pair of triangles through the exact test.
#define _POSIX_C_SOURCE 200809L
#include "support/run_program.h"
#include "support/suite.h"

#include <quickcullide/quickcullide.h>

#include <check.h>
#include <inttypes.h>
#include <json-c/json.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define PAIRS QC_PAIRS_PROGRAM

enum
{
    qc_meshCount = 3,
    qc_vertexCount = 60,
    qc_triangleCount = 70
};

typedef struct TestMesh
{
    double positions[qc_vertexCount][3];
    uint32_t indices[qc_triangleCount][3];
} TestMesh;

static TestMesh s_meshes[qc_meshCount];

/// Soups on a coarse lattice, so that triangles also touch, share edges in place and lie in one plane.
static void MakeMeshes(void)
{
    srand(11);
    for (int m = 0; m < qc_meshCount; ++m)
    {
        for (int i = 0; i < qc_vertexCount; ++i)
        {
            for (int axis = 0; axis < 3; ++axis)
                s_meshes[m].positions[i][axis] = (rand() % 13 + (axis == 0 ? 7 * m : 0)) * 0.25;
        }
        for (int t = 0; t < qc_triangleCount; ++t)
        {
            for (int corner = 0; corner < 3; ++corner)
                s_meshes[m].indices[t][corner] = (uint32_t)(rand() % qc_vertexCount);
        }
    }
    // One that only a double holds, so that reading it as a float would show.
    s_meshes[1].positions[0][0] += 1e-13;
}

static void WriteMeshes(void)
{
    for (int m = 0; m < qc_meshCount; ++m)
    {
        char name[16];
        snprintf(name, sizeof name, "%d.ply", m);
        FILE* stream = fopen(name, "w");
        ck_assert_ptr_nonnull(stream);
        fprintf(stream,
                "ply\nformat ascii 1.0\nelement vertex %d\nproperty double x\nproperty double y\nproperty double z\n"
                "element face %d\nproperty list uchar int vertex_indices\nend_header\n",
                qc_vertexCount, qc_triangleCount);
        for (int i = 0; i < qc_vertexCount; ++i)
            fprintf(stream, "%.17g %.17g %.17g\n", s_meshes[m].positions[i][0], s_meshes[m].positions[i][1],
                    s_meshes[m].positions[i][2]);
        for (int t = 0; t < qc_triangleCount; ++t)
            fprintf(stream, "3 %u %u %u\n", s_meshes[m].indices[t][0], s_meshes[m].indices[t][1],
                    s_meshes[m].indices[t][2]);
        ck_assert_int_eq(fclose(stream), 0);
    }
}

static void Enter(void)
{
    EnterFolder();
    MakeMeshes();
    WriteMeshes();
}

static bool AreNeighbours(const uint32_t a[3], const uint32_t b[3])
{
    for (int i = 0; i < 9; ++i)
    {
        if (a[i / 3] == b[i % 3])
            return true;
    }
    return false;
}

static void GetTriangles(uint32_t bodyA, uint32_t a, uint32_t bodyB, uint32_t b, double triangles[2][9])
{
    for (int corner = 0; corner < 3; ++corner)
    {
        memcpy(triangles[0] + 3 * corner, s_meshes[bodyA].positions[s_meshes[bodyA].indices[a][corner]],
               3 * sizeof(double));
        memcpy(triangles[1] + 3 * corner, s_meshes[bodyB].positions[s_meshes[bodyB].indices[b][corner]],
               3 * sizeof(double));
    }
}

/// Near: not further apart than the margin.
static qcRelation Relate(uint32_t bodyA, uint32_t a, uint32_t bodyB, uint32_t b, double margin)
{
    double triangles[2][9];
    GetTriangles(bodyA, a, bodyB, b, triangles);
    qcRelation relation = qcRelateTriangles(triangles[0], triangles[1]);
    bool isNear =
        relation == qc_relationDisjoint && margin > 0.0 && qcTrianglesWithin(triangles[0], triangles[1], margin, NULL);
    return isNear ? qc_relationNear : relation;
}

typedef struct Asked
{
    const char* options;
    bool self, touching, neighbours;
    double margin;
} Asked;

/// The lines that --out must hold.
static size_t WriteExpected(const Asked* asked, char* text, size_t size)
{
    size_t length = 0, pairs = 0;
    for (uint32_t i = 0; i < qc_meshCount * qc_triangleCount; ++i)
    {
        for (uint32_t k = i + 1; k < qc_meshCount * qc_triangleCount; ++k)
        {
            uint32_t bodyA = i / qc_triangleCount, a = i % qc_triangleCount;
            uint32_t bodyB = k / qc_triangleCount, b = k % qc_triangleCount;
            if (bodyA == bodyB && (!asked->self || (!asked->neighbours && AreNeighbours(s_meshes[bodyA].indices[a],
                                                                                        s_meshes[bodyB].indices[b]))))
                continue;
            qcRelation relation = Relate(bodyA, a, bodyB, b, asked->margin);
            if (relation == qc_relationDisjoint || (relation == qc_relationTouching && !asked->touching))
                continue;
            length += (size_t)snprintf(text + length, size - length, "%u %u %u %u %s\n", bodyA, a, bodyB, b,
                                       relation == qc_relationTouching ? "touching"
                                       : relation == qc_relationNear   ? "near"
                                                                       : "penetrating");
            ck_assert_uint_lt(length, size);
            ++pairs;
        }
    }
    return pairs;
}

static const Asked s_asked[] = {
    {"", true, false, false, 0.0},
    {"--method=brute", true, false, false, 0.0},
    {"--method sweep --touching", true, true, false, 0.0},
    {"--touching --neighbours", true, true, true, 0.0},
    {"--neighbours --threads 2", true, false, true, 0.0},
    {"--no-self", false, false, false, 0.0},
    {"--no-self --touching --method brute --reps 3", false, true, false, 0.0},
    {"--method quick --device none", true, false, false, 0.0},
    {"--method cullide --device none --touching", true, true, false, 0.0},
    {"--method layers --touching", true, true, false, 0.0},
    {"--method layers --device none", true, false, false, 0.0},
    {"--method quick --reliable --resolution 200", true, false, false, 0.0},
    {"--method quick --reliable --back-to-front --second-pass-from-back --resolution 100 --no-self --touching", false,
     true, false, 0.0},
    {"--method cullide --reliable --views zx --resolution 64 --neighbours", true, false, true, 0.0},
    {"--margin 0 --f64", true, false, false, 0.0},
    // Margins that some pairs on the lattice are apart exactly.
    {"--margin 0.25", true, true, false, 0.25},
    {"--margin=.5 --method brute --no-self", false, true, false, 0.5},
    {"--margin 1e-3 --method sweep --neighbours", true, true, true, 1e-3},
    {"--margin 0.25 --method layers --touching", true, true, false, 0.25},
    {"--margin 0.25 --method quick --reliable --resolution 128", true, true, false, 0.25},
};

static char s_expected[1 << 19], s_written[1 << 19];

START_TEST(out_holds_exactly_the_pairs_that_brute_force_finds)
{
    const Asked* asked = &s_asked[_i];
    size_t pairs = WriteExpected(asked, s_expected, sizeof s_expected);
    ck_assert_uint_gt(pairs, 10);
    ck_assert_int_eq(Run("%s %s --out found 0.ply 1.ply 2.ply", PAIRS, asked->options), 0);
    ck_assert_str_eq(GetErrors(), "");
    ck_assert(ReadText("found", s_written, sizeof s_written));
    ck_assert_str_eq(s_written, s_expected);
    char line[64];
    snprintf(line, sizeof line, "pairs        %zu: ", pairs);
    ck_assert_msg(strstr(GetOutput(), line) != NULL, "'%s' is not in: %s", line, GetOutput());
}
END_TEST

static json_object* Parse(const char* text)
{
    enum json_tokener_error error;
    json_object* object = json_tokener_parse_verbose(text, &error);
    ck_assert_msg(error == json_tokener_success, "%s in: %s", json_tokener_error_desc(error), text);
    return object;
}

static json_object* Get(json_object* object, const char* name)
{
    json_object* member;
    ck_assert_msg(json_object_object_get_ex(object, name, &member), "no %s", name);
    return member;
}

START_TEST(proximities_stand_behind_their_pairs)
{
    const double margin = 0.1;
    ck_assert_int_eq(Run("%s --margin %g --proximities --out found 0.ply 1.ply", PAIRS, margin), 0);
    ck_assert(ReadText("found", s_written, sizeof s_written));
    size_t count[4] = {0, 0, 0, 0};
    for (char* line = s_written; *line != 0; line = strchr(line, '\n') + 1)
    {
        uint32_t bodyA, a, bodyB, b;
        char word[16], end;
        double distance, depth, p[3], q[3], n[3];
        ck_assert_int_eq(sscanf(line, "%u %u %u %u %15s %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf%c", &bodyA, &a,
                                &bodyB, &b, word, &distance, &depth, &p[0], &p[1], &p[2], &q[0], &q[1], &q[2], &n[0],
                                &n[1], &n[2], &end),
                         17);
        ck_assert_int_eq(end, '\n');
        double triangles[2][9];
        qcProximity expected;
        GetTriangles(bodyA, a, bodyB, b, triangles);
        ck_assert(qcTrianglesWithin(triangles[0], triangles[1], margin, &expected));
        // 17 digits give back the same doubles.
        ck_assert_double_eq(distance, expected.distance);
        ck_assert_double_eq(depth, expected.depth);
        ck_assert_mem_eq(p, expected.pointA, sizeof p);
        ck_assert_mem_eq(q, expected.pointB, sizeof q);
        ck_assert_mem_eq(n, expected.normal, sizeof n);
        qcRelation relation = Relate(bodyA, a, bodyB, b, margin);
        ck_assert_str_eq(word, qcRelation_Name(relation));
        ck_assert((distance > 0.0) == (relation == qc_relationNear));
        ++count[relation];
    }
    ck_assert_uint_gt(count[qc_relationNear], 10);
    ck_assert_uint_gt(count[qc_relationTouching], 10);
    ck_assert_uint_gt(count[qc_relationPenetrating], 10);
}
END_TEST

/// A mesh of the set, each vertex moved along x, as text with every digit; a ".ply" declares floats.
static void WriteMoved(const char* name, double offset, bool ply)
{
    FILE* stream = fopen(name, "w");
    ck_assert_ptr_nonnull(stream);
    if (ply)
        fprintf(stream,
                "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
                "element face %d\nproperty list uchar int vertex_indices\nend_header\n",
                qc_vertexCount, qc_triangleCount);
    for (int i = 0; i < qc_vertexCount; ++i)
    {
        const double* p = s_meshes[0].positions[i];
        // An eighth more: off the lattice that floats still hold there.
        fprintf(stream, "%s%.17g %.17g %.17g\n", ply ? "" : "v ", p[0] + 0.125 * (i % 8) + offset, p[1], p[2]);
    }
    for (int t = 0; t < qc_triangleCount; ++t)
    {
        const uint32_t* index = s_meshes[0].indices[t];
        uint32_t first = ply ? 0 : 1;
        fprintf(stream, "%s %u %u %u\n", ply ? "3" : "f", index[0] + first, index[1] + first, index[2] + first);
    }
    ck_assert_int_eq(fclose(stream), 0);
}

START_TEST(f64_keeps_a_mesh_far_away_as_it_is_at_the_origin)
{
    static const char* const options[] = {"--touching", "--margin 0.125 --touching", "--method brute --touching"};
    for (int ply = 0; ply < 2; ++ply)
    {
        const char *near = ply ? "near.ply" : "near.obj", *far = ply ? "far.ply" : "far.obj";
        WriteMoved(near, 0.0, ply == 1);
        WriteMoved(far, 1e7, ply == 1);
        for (int i = 0; i < 3; ++i)
        {
            ck_assert_int_eq(Run("%s %s --out near %s", PAIRS, options[i], near), 0);
            ck_assert_int_eq(Run("%s %s --f64 --out far --json %s", PAIRS, options[i], far), 0);
            json_object* object = Parse(GetOutput());
            json_object* mesh = json_object_array_get_idx(Get(object, "meshes"), 0);
            ck_assert_str_eq(json_object_get_string(Get(mesh, "positions")), "double");
            json_object_put(object);
            ck_assert(ReadText("near", s_expected, sizeof s_expected));
            ck_assert(ReadText("far", s_written, sizeof s_written));
            ck_assert_uint_gt(strlen(s_expected), 1000);
            ck_assert_str_eq(s_written, s_expected);
            // As floats they are other meshes there.
            ck_assert_int_eq(Run("%s %s --out far %s", PAIRS, options[i], far), 0);
            ck_assert(ReadText("far", s_written, sizeof s_written));
            ck_assert_str_ne(s_written, s_expected);
        }
    }
}
END_TEST

//  ---- the report ----------------------------------------------------------------------------------

static uint64_t GetNumber(json_object* object, const char* name)
{
    json_object* member = Get(object, name);
    ck_assert_msg(json_object_is_type(member, json_type_int), "%s is not a whole number", name);
    return json_object_get_uint64(member);
}

START_TEST(json_tells_what_was_found_and_what_it_cost)
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

START_TEST(a_method_that_cannot_draw_says_which_one_answered)
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

/// Whether some device draws here; auto opens one then.
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

//  ---- the picture ---------------------------------------------------------------------------------

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

START_TEST(the_report_says_what_was_asked)
{
    ck_assert_int_eq(Run("%s --json --margin 0.125 --back-to-front 0.ply", PAIRS), 0);
    json_object* object = Parse(GetOutput());
    ck_assert_double_eq(json_object_get_double(Get(object, "margin")), 0.125);
    ck_assert(json_object_get_boolean(Get(object, "backToFront")));
    ck_assert(!json_object_get_boolean(Get(object, "secondPassFromBack")));
    ck_assert(!json_object_get_boolean(Get(object, "reliable")));
    uint64_t near = GetNumber(object, "near"), touching = GetNumber(object, "touching");
    ck_assert_uint_eq(GetNumber(object, "pairs"), near + touching + GetNumber(object, "penetrating"));
    json_object_put(object);
    char line[64];
    snprintf(line, sizeof line, " %" PRIu64 " touching, %" PRIu64 " near\n", touching, near);
    ck_assert_int_eq(Run("%s --margin 0.125 0.ply", PAIRS), 0);
    ck_assert_msg(strstr(GetOutput(), line) != NULL, "'%s' is not in: %s", line, GetOutput());
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

//  ---- refusals ------------------------------------------------------------------------------------

typedef struct Refusal
{
    const char* arguments;
    int ending;
    const char* expected;
} Refusal;

static const Refusal s_refusals[] = {
    {"", 2, "no MESH is named"},
    {"--json", 2, "no MESH is named"},
    {"--method quik 0.ply", 2, "--method: 'quik' is not one of brute, sweep, layers, quick, cullide, auto"},
    {"--device gpu 0.ply", 2, "--device: 'gpu' is not one of auto, egl, osmesa, surfaceless, none"},
    {"--views xx 0.ply", 2, "--views: 'xx' is not 1 to 3 different letters of x, y and z"},
    {"--views xyzx 0.ply", 2, "--views: 'xyzx'"},
    {"--views w 0.ply", 2, "--views: 'w'"},
    {"--views '' 0.ply", 2, "--views: ''"},
    {"--resolution abc 0.ply", 2, "--resolution: 'abc' is not a whole number in 1..4096"},
    {"--resolution 0 0.ply", 2, "--resolution: '0' is not a whole number in 1..4096"},
    {"--resolution 5000 --method cullide 0.ply", 2, "--resolution: '5000' is not a whole number in 1..4096"},
    {"--resolution 128x 0.ply", 2, "--resolution: '128x'"},
    {"--resolution -1 0.ply", 2, "--resolution: '-1'"},
    {"--resolution 18446744073709551617 0.ply", 2, "--resolution: '18446744073709551617'"},
    {"--iterations -1 0.ply", 2, "--iterations: '-1' is not a whole number in 0..4294967295"},
    {"--threads many 0.ply", 2, "--threads: 'many' is not a whole number in 0..1024"},
    {"--margin -1 0.ply", 2, "--margin: '-1' is not a number of 0 or more"},
    {"--margin nan 0.ply", 2, "--margin: 'nan' is not a number"},
    {"--margin 1e999 0.ply", 2, "--margin: '1e999' is not a number"},
    {"--margin 0x1 0.ply", 2, "--margin: '0x1' is not a number"},
    {"--margin '1 ' 0.ply", 2, "--margin: '1 ' is not a number"},
    {"--margin '' 0.ply", 2, "--margin: '' is not a number"},
    {"--margin 1 --method quick 0.ply", 2, "--margin: quick needs --reliable"},
    {"--method cullide 0.ply --margin 1", 2, "--margin: cullide needs --reliable"},
    {"--proximities 0.ply", 2, "--proximities: they are written with the pairs; name a file with --out"},
    {"--reps 0 0.ply", 2, "--reps: '0' is not a whole number in 1.."},
    {"--touchign 0.ply", 2, "unrecognized option '--touchign'"},
    {"--out", 2, "option '--out' requires an argument"},
    {"--out 1.ply 0.ply", 2, "--out: '1.ply' is named as a mesh"},
    {"--picture a.jpg 0.ply", 2, "--picture: 'a.jpg' does not end in .png"},
    {"--picture a.png --out a.png 0.ply", 2, "--out and --picture name the same file"},
    {"none.ply", 3, "none.ply: No such file or directory"},
    {"0.ply .", 3, ".: Is a directory"},
    {"0.ply bad.obj", 3, "bad.obj: line 2: 'abc' is not a finite number"},
    {"--out found bad.obj", 3, "bad.obj: line 2: "},
    {"--out . 0.ply", 1, ".: Is a directory"},
    {"--out no/found 0.ply", 1, "no/found: No such file or directory"},
    {"--out /dev/full 0.ply 1.ply", 1, "/dev/full: No space left on device"},
    {"--picture no/a.png 0.ply", 1, "no/a.png: No such file or directory"},
    {"0.ply >/dev/full", 1, "standard output: No space left on device"},
    {"--json 0.ply >/dev/full", 1, "standard output: No space left on device"},
};

START_TEST(a_refusal_says_why_and_leaves_the_old_output)
{
    const Refusal* refusal = &s_refusals[_i];
    WriteText("found", "old");
    WriteText("bad.obj", "v 0 0 0\nv abc\n");
    size_t entries = CountEntries();
    int ending = Run("%s %s", PAIRS, refusal->arguments);
    ck_assert_msg(ending == refusal->ending, "%d, not %d: %s", ending, refusal->ending, GetErrors());
    ck_assert_msg(strncmp(GetErrors(), PAIRS ": ", 10) == 0 || strstr(GetErrors(), "qc-pairs: ") != NULL, "%s",
                  GetErrors());
    ck_assert_msg(strstr(GetErrors(), refusal->expected) != NULL, "'%s' does not say '%s'", GetErrors(),
                  refusal->expected);
    if (ending == 2)
        ck_assert_ptr_nonnull(strstr(GetErrors(), "--help"));
    ck_assert_str_eq(GetOutput(), "");
    ck_assert_uint_eq(CountEntries(), entries);
    ck_assert(ReadText("found", s_written, sizeof s_written));
    ck_assert_str_eq(s_written, "old");
}
END_TEST

START_TEST(a_device_that_does_not_work_here_ends_with_4)
{
    // Without a vendor's library EGL has no display.
    int ending = Run("__EGL_VENDOR_LIBRARY_DIRS=/none %s --device egl --out found 0.ply", PAIRS);
    ck_assert_int_eq(ending, 4);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "qc-pairs: "));
    ck_assert(!ReadText("found", s_written, sizeof s_written));
}
END_TEST

START_TEST(a_pipe_is_written_and_stays_a_pipe)
{
    ck_assert_int_eq(mkfifo("pipe", 0600), 0);
    ck_assert_int_eq(Run("cat pipe >copy & %s --out pipe 0.ply 1.ply && wait", PAIRS), 0);
    ck_assert_int_eq(Run("%s --out found 0.ply 1.ply && cmp found copy && test -p pipe", PAIRS), 0);
}
END_TEST

START_TEST(help_names_every_option_and_exit_status)
{
    static const char* words[] = {
        "--method",   "--device",       "--views",       "--resolution",    "--iterations",
        "--no-self",  "--touching",     "--neighbours",  "--threads",       "--reps",
        "--json",     "--out",          "--picture",     "brute",           "sweep",
        "--margin",   "--f64",          "--proximities", "--back-to-front", "--second-pass-from-back",
        "--reliable", "layers",         "near",          "quick",           "cullide",
        "auto",       "Exit status: 0", "MESH"};
    ck_assert_int_eq(Run("%s --help", PAIRS), 0);
    for (size_t i = 0; i < sizeof words / sizeof words[0]; ++i)
        ck_assert_msg(strstr(GetOutput(), words[i]) != NULL, "%s", words[i]);
    ck_assert_str_eq(GetErrors(), "");
}
END_TEST

START_TEST(meshes_without_triangles_meet_nothing)
{
    WriteText("empty.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\n"
                           "property float z\nelement face 0\nproperty list uchar int vertex_indices\nend_header\n");
    ck_assert_msg(Run("%s --out found empty.ply empty.ply", PAIRS) == 0, "%s", GetErrors());
    ck_assert(ReadText("found", s_written, sizeof s_written));
    ck_assert_str_eq(s_written, "");
    ck_assert_msg(Run("%s --out found empty.ply 0.ply", PAIRS) == 0, "%s", GetErrors());
}
END_TEST

int main(void)
{
    Suite* suite = suite_create("qc_pairs");
    TCase* tests = tcase_create("qc_pairs");
    tcase_add_checked_fixture(tests, Enter, LeaveFolder);
    tcase_add_loop_test(tests, out_holds_exactly_the_pairs_that_brute_force_finds, 0,
                        sizeof s_asked / sizeof s_asked[0]);
    tcase_add_test(tests, proximities_stand_behind_their_pairs);
    tcase_add_test(tests, f64_keeps_a_mesh_far_away_as_it_is_at_the_origin);
    tcase_add_test(tests, json_tells_what_was_found_and_what_it_cost);
    tcase_add_test(tests, a_method_that_cannot_draw_says_which_one_answered);
    tcase_add_test(tests, visibility_methods_report_their_passes);
    tcase_add_test(tests, layers_reports_its_image_and_its_memory);
    tcase_add_test(tests, the_report_says_what_was_asked);
    tcase_add_test(tests, the_picture_shows_the_potentially_colliding_set_in_red);
    tcase_add_loop_test(tests, a_refusal_says_why_and_leaves_the_old_output, 0,
                        sizeof s_refusals / sizeof s_refusals[0]);
    tcase_add_test(tests, a_device_that_does_not_work_here_ends_with_4);
    tcase_add_test(tests, a_pipe_is_written_and_stays_a_pipe);
    tcase_add_test(tests, help_names_every_option_and_exit_status);
    tcase_add_test(tests, meshes_without_triangles_meet_nothing);
    tcase_set_timeout(tests, 60);
    suite_add_tcase(suite, tests);
    return qcRunSuite(suite);
}
