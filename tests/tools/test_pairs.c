// qc-pairs as a user runs it: the pairs that it writes, and what it refuses. The oracle is every pair of triangles
// through the exact test.
#define _POSIX_C_SOURCE 200809L
#include "support/run_program.h"
#include "support/suite.h"
#include "tools/json_report.h"
#include "tools/pair_meshes.h"

#include <check.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define PAIRS QC_PAIRS_PROGRAM

typedef struct Query
{
    const char* options;
    bool self, touching, neighbours;
    double margin;
} Query;

/// The lines that --out must hold.
static size_t WriteExpected(const Query* query, char* text, size_t size)
{
    size_t length = 0, pairs = 0;
    for (uint32_t i = 0; i < qc_meshCount * qc_triangleCount; ++i)
    {
        for (uint32_t k = i + 1; k < qc_meshCount * qc_triangleCount; ++k)
        {
            uint32_t bodyA = i / qc_triangleCount, a = i % qc_triangleCount;
            uint32_t bodyB = k / qc_triangleCount, b = k % qc_triangleCount;
            if (bodyA == bodyB && (!query->self || (!query->neighbours && AreNeighbours(g_meshes[bodyA].indices[a],
                                                                                        g_meshes[bodyB].indices[b]))))
                continue;
            qcRelation relation = Relate(bodyA, a, bodyB, b, query->margin);
            if (relation == qc_relationDisjoint || (relation == qc_relationTouching && !query->touching))
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

static const Query s_queries[] = {
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

/// Standard error holds lines of progress ("detecting, 1 s") or nothing: a loaded machine takes longer than a second.
static void AssertOnlyProgress(void)
{
    for (const char* line = GetErrors(); *line != 0; line = strchr(line, '\n') + 1)
        ck_assert_msg(strchr(line, '\n') != NULL && strncmp(strchr(line, '\n') - 2, " s", 2) == 0, "%s", line);
}

START_TEST(out_holds_exactly_the_pairs_that_brute_force_finds)
{
    const Query* query = &s_queries[_i];
    size_t pairs = WriteExpected(query, s_expected, sizeof s_expected);
    ck_assert_uint_gt(pairs, 10);
    ck_assert_int_eq(Run("%s %s --out found 0.ply 1.ply 2.ply", PAIRS, query->options), 0);
    AssertOnlyProgress();
    ck_assert(ReadText("found", s_written, sizeof s_written));
    ck_assert_str_eq(s_written, s_expected);
    char line[64];
    snprintf(line, sizeof line, "pairs        %zu: ", pairs);
    ck_assert_msg(strstr(GetOutput(), line) != NULL, "'%s' is not in: %s", line, GetOutput());
}
END_TEST

START_TEST(proximities_follow_their_pairs)
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
        const double* p = g_meshes[0].positions[i];
        // An eighth more: off the lattice that floats still hold there.
        fprintf(stream, "%s%.17g %.17g %.17g\n", ply ? "" : "v ", p[0] + 0.125 * (i % 8) + offset, p[1], p[2]);
    }
    for (int t = 0; t < qc_triangleCount; ++t)
    {
        const uint32_t* index = g_meshes[0].indices[t];
        uint32_t first = ply ? 0 : 1;
        fprintf(stream, "%s %u %u %u\n", ply ? "3" : "f", index[0] + first, index[1] + first, index[2] + first);
    }
    ck_assert_int_eq(fclose(stream), 0);
}

START_TEST(f64_finds_the_same_pairs_far_from_the_origin)
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
            // Rounded to floats, these are other meshes.
            ck_assert_int_eq(Run("%s %s --out far %s", PAIRS, options[i], far), 0);
            ck_assert(ReadText("far", s_written, sizeof s_written));
            ck_assert_str_ne(s_written, s_expected);
        }
    }
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
    {"--out - --json 0.ply", 2, "--json: the pairs have standard output; name a file with --out"},
    {"--views x --method=sweep 0.ply", 2, "--views: it is for quick and cullide, and the method is sweep"},
    {"--resolution 64 0.ply", 2, "--resolution: it is for quick and cullide, and the method is auto"},
    {"--method layers --iterations 3 0.ply", 2, "--iterations: it is for quick and cullide"},
    {"--method brute --back-to-front 0.ply", 2, "--back-to-front: it is for quick and cullide"},
    {"--second-pass-from-back 0.ply", 2, "--second-pass-from-back: it is for quick and cullide"},
    {"--reliable 0.ply --margin 1", 2, "--reliable: it is for quick and cullide"},
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
    {"--out - 0.ply 1.ply >/dev/full", 1, "standard output: No space left on device"},
};

START_TEST(a_refusal_gives_the_reason_and_leaves_the_old_output)
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

START_TEST(no_mesh_and_no_other_output_is_replaced)
{
    static const char* const arguments[] = {"--out link 0.ply",      "--out link 1.ply 0.ply",
                                            "--out ./0 0",           "--picture 0.png 0.png",
                                            "--picture l.png 0.png", "--picture m.png --out ./m.png 0.ply"};
    ck_assert_int_eq(Run("ln -s 0.ply link; ln 0.ply 0; cp 0.ply 0.png; ln -s 0.png l.png"), 0);
    const size_t entries = CountEntries();
    for (size_t i = 0; i < sizeof arguments / sizeof arguments[0]; ++i)
    {
        ck_assert_msg(Run("%s %s", PAIRS, arguments[i]) == 2, "%s", arguments[i]);
        ck_assert_ptr_nonnull(strstr(GetErrors(), "--help"));
    }
    ck_assert_uint_eq(CountEntries(), entries);
    ck_assert_int_eq(Run("cmp 0.ply 0.png && cmp 0.ply link"), 0);
    ck_assert_int_eq(Run("%s --out /dev/null --picture a.png 0.ply", PAIRS), 0);
}
END_TEST

START_TEST(names_that_are_no_utf_8_are_valid_json)
{
    ck_assert_int_eq(Run("cp 0.ply \"$(printf 'a\\377\\303\\251b.ply')\""), 0);
    ck_assert_int_eq(Run("%s --json a*b.ply", PAIRS), 0);
    json_object* object = Parse(GetOutput());
    json_object* mesh = json_object_array_get_idx(Get(object, "meshes"), 0);
    ck_assert_str_eq(json_object_get_string(Get(mesh, "file")), "a\xef\xbf\xbd\xc3\xa9"
                                                                "b.ply");
    json_object_put(object);
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

START_TEST(pairs_go_to_standard_output_and_the_report_to_standard_error)
{
    ck_assert_int_eq(Run("%s --out found 0.ply 1.ply", PAIRS), 0);
    ck_assert(ReadText("found", s_expected, sizeof s_expected));
    for (int i = 0; i < 2; ++i)
    {
        size_t entries = CountEntries();
        ck_assert_int_eq(Run("%s --out %s 0.ply 1.ply", PAIRS, i == 0 ? "-" : "/dev/stdout"), 0);
        ck_assert_str_eq(GetOutput(), s_expected);
        ck_assert_ptr_nonnull(strstr(GetErrors(), "\npairs        "));
        ck_assert_uint_eq(CountEntries(), entries);
    }
    ck_assert_int_eq(Run("{ { %s --out /dev/fd/3 0.ply 1.ply >/dev/null; } 3>&1 | cmp - found; }", PAIRS), 0);
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

START_TEST(meshes_without_triangles_have_no_pairs)
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
    TCase* tests = qcMakeCase("qc_pairs");
    tcase_add_checked_fixture(tests, EnterWithMeshes, LeaveFolder);
    tcase_add_loop_test(tests, out_holds_exactly_the_pairs_that_brute_force_finds, 0,
                        sizeof s_queries / sizeof s_queries[0]);
    tcase_add_test(tests, proximities_follow_their_pairs);
    tcase_add_test(tests, f64_finds_the_same_pairs_far_from_the_origin);
    tcase_add_loop_test(tests, a_refusal_gives_the_reason_and_leaves_the_old_output, 0,
                        sizeof s_refusals / sizeof s_refusals[0]);
    tcase_add_test(tests, a_device_that_does_not_work_here_ends_with_4);
    tcase_add_test(tests, no_mesh_and_no_other_output_is_replaced);
    tcase_add_test(tests, names_that_are_no_utf_8_are_valid_json);
    tcase_add_test(tests, a_pipe_is_written_and_stays_a_pipe);
    tcase_add_test(tests, pairs_go_to_standard_output_and_the_report_to_standard_error);
    tcase_add_test(tests, help_names_every_option_and_exit_status);
    tcase_add_test(tests, meshes_without_triangles_have_no_pairs);
    return qcRunCase("qc_pairs", tests);
}
