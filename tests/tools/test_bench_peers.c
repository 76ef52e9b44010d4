// `qc-bench peers` as a user runs it: with the peers that were built, without, and with one that is wrong. The oracle
// is every pair of triangles through the exact test.
#include "bench/scenes/motion.h"
#include "bench/scenes/shapes.h"
#include "support/csv_rows.h"
#include "common/mesh_io/decimate.h"
#include "support/pairs.h"
#include "bench/peers/peers.h"
#include "bench/peers/triangles.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BENCH QC_BENCH_PROGRAM
#define LIAR QC_LYING_PEER

static const char s_header[] =
    "scene,kind,bodies,triangles,threads,method,library,steps,ms,ms_least,of_ours,open_ms,first_ms,second_ms,pairs,"
    "agrees,skipped";

//  ---- the triangle test of the peers --------------------------------------------------------------

START_TEST(the_triangle_test_of_the_peers_is_exact)
{
    qcRandom random = {.state = 2021};
    int penetrating = 0, guessed = 0, count = qcGetTestPairCount(200000);
    for (int i = 0; i < count; ++i)
    {
        qcTrianglePair pair;
        char text[1024];
        if (i % 2 == 0)
            qcTrianglePair_Make(&random, (qcPairKind)(i / 2 % qc_pairKindCount), &pair);
        else
            qcTrianglePair_MakeAny(&random, &pair);
        bool penetrate = qcRelateTriangles(pair.a[0], pair.b[0]) == qc_relationPenetrating;
        int guess = qcPeerTriangle_Guess(pair.a[0], pair.b[0]);
        ck_assert_msg(guess < 0 || (guess != 0) == penetrate, "%s", qcTrianglePair_Print(&pair, text));
        ck_assert(qcPeerTriangle_Penetrate(pair.a[0], pair.b[0]) == penetrate);
        penetrating += penetrate;
        guessed += guess >= 0;
    }
    // The bound decides many of each: otherwise this would only test the exact test.
    ck_assert_int_gt(penetrating, count / 20);
    ck_assert_int_gt(guessed, count / 5);
}
END_TEST

//  ---- the scenes ----------------------------------------------------------------------------------

enum
{
    qc_frames = 3
};

static void MakeFrame(uint32_t frame, qcMesh* mesh, float* positions, qcBenchMotion* motion)
{
    ck_assert(qcBenchShapes_MakeCloth(22, 1.0, mesh));
    *motion = qcBenchMotion_Make(mesh, 1, qc_frames);
    qcBenchMotion_Deform(motion, mesh, frame, positions);
}

START_TEST(a_frame_moves_each_vertex_by_little_and_the_last_leads_to_the_first)
{
    static float positions[qc_frames][3 * 23 * 23];
    qcMesh mesh;
    qcBenchMotion motion;
    for (uint32_t frame = 0; frame < qc_frames; ++frame)
    {
        MakeFrame(frame, &mesh, positions[frame], &motion);
        qcMesh_Free(&mesh);
    }
    double most = 0.0;
    for (uint32_t frame = 0; frame < qc_frames; ++frame)
    {
        const float *p = positions[frame], *q = positions[(frame + 1) % qc_frames];
        for (size_t i = 0; i < 3 * 23 * 23; i += 3)
        {
            double way = 0.0;
            for (size_t axis = 0; axis < 3; ++axis)
                way += ((double)p[i + axis] - q[i + axis]) * ((double)p[i + axis] - q[i + axis]);
            most = sqrt(way) > most ? sqrt(way) : most;
        }
    }
    ck_assert_double_gt(most, 0.002 * motion.diagonal);
    ck_assert_double_lt(most, 0.0045 * motion.diagonal);
}
END_TEST

START_TEST(a_decimated_mesh_has_about_the_requested_number_of_triangles)
{
    qcMesh mesh, coarse;
    ck_assert(qcBenchShapes_MakeCloth(60, 1.0, &mesh));
    ck_assert(qcMesh_Decimate(&mesh, 2000, &coarse));
    ck_assert_uint_le(coarse.triangleCount, 2000);
    ck_assert_uint_gt(coarse.triangleCount, 1000);
    for (uint32_t i = 0; i < coarse.triangleCount; ++i)
    {
        const uint32_t* t = &coarse.indices[3 * (size_t)i];
        ck_assert(t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        ck_assert(t[0] < coarse.vertexCount && t[1] < coarse.vertexCount && t[2] < coarse.vertexCount);
    }
    qcMesh_Free(&coarse);
    qcMesh_Free(&mesh);
}
END_TEST

/// Penetrating pairs without a common vertex.
static uint32_t CountPairs(const qcMesh* mesh, const float* positions)
{
    qcPeerBody body = {mesh->indices, mesh->vertexCount, mesh->triangleCount};
    qcPeerPose pose = {positions, NULL};
    uint32_t count = 0;
    for (uint32_t i = 0; i < body.triangleCount; ++i)
    {
        double a[9], b[9];
        qcPeerTriangle_Get(&body, &pose, i, a);
        for (uint32_t k = i + 1; k < body.triangleCount; ++k)
        {
            if (qcPeerTriangle_AreNeighbours(&body, i, k))
                continue;
            qcPeerTriangle_Get(&body, &pose, k, b);
            count += qcRelateTriangles(a, b) == qc_relationPenetrating;
        }
    }
    return count;
}

START_TEST(coincident_triangles_have_corners_of_their_own_and_all_penetrate)
{
    enum
    {
        count = 20
    };
    qcMesh mesh;
    ck_assert(qcBenchShapes_MakeCoincident(count, &mesh));
    const float* p = mesh.positions;
    ck_assert_uint_eq(mesh.triangleCount, count);
    ck_assert_uint_eq(mesh.vertexCount, 3 * count);
    ck_assert_uint_eq(CountPairs(&mesh, p), count * (count - 1) / 2);
    for (size_t i = 0; i < 3 * count; ++i)
    {
        ck_assert_uint_eq(mesh.indices[i], i);
        ck_assert_mem_eq(p + 3 * i, p + 3 * (i % 3), 3 * sizeof(float));
    }
    // In each frame of a motion, too: a vertex moves by its place.
    static float positions[3 * 3 * count];
    qcBenchMotion motion = qcBenchMotion_Make(&mesh, 1, qc_frames);
    for (uint32_t frame = 0; frame < qc_frames; ++frame)
    {
        qcBenchMotion_Deform(&motion, &mesh, frame, positions);
        ck_assert_uint_eq(CountPairs(&mesh, positions), count * (count - 1) / 2);
    }
    qcMesh_Free(&mesh);
}
END_TEST

START_TEST(preprocessing_is_for_pairs_where_these_outnumber_triangles)
{
    const qcPeersTable table = {.triangleCount = 2000};
    qcPeerRow ours = {.ms = 100.0, .pairs = 2000};
    ck_assert(!qcPeersTable_GrowsWithPairs(&table, &ours));
    ck_assert_double_eq_tol(qcPeersTable_Preprocessing(&table, &ours, 300.0), 10.0, 1e-9);
    ck_assert_double_eq(qcPeersTable_Preprocessing(&table, &ours, 99.0), 0.0);
    ours.pairs = 4000000;
    ck_assert(qcPeersTable_GrowsWithPairs(&table, &ours));
    ck_assert_double_eq_tol(qcPeersTable_Preprocessing(&table, &ours, 300.0), 0.05, 1e-9);
}
END_TEST

//  ---- with the peers that were built --------------------------------------------------------------

typedef struct Seen
{
    double pairs; ///< of all rows
    double oursMs;
    const char* kind;
    int bodies, rows, ours;
} Seen;

static void CheckRow(const Row* row, void* context)
{
    Seen* seen = context;
    ++seen->rows;
    ck_assert(Is(row, "skipped", "\"\""));
    ck_assert(Is(row, "agrees", "1"));
    if (seen->kind != NULL)
        ck_assert(Is(row, "kind", seen->kind));
    ck_assert(GetNumber(row, "bodies") == seen->bodies);
    // Our sweep is the first of each number of threads.
    if (Is(row, "method", "sweep"))
    {
        ++seen->ours;
        ck_assert(Is(row, "library", "\"ours\"") && Is(row, "of_ours", "1.0000"));
        seen->oursMs = GetNumber(row, "ms");
        if (seen->pairs < 0.0)
            seen->pairs = GetNumber(row, "pairs");
    }
    ck_assert(GetNumber(row, "pairs") == seen->pairs);
    ck_assert(GetNumber(row, "ms") >= GetNumber(row, "ms_least") && GetNumber(row, "ms_least") > 0.0);
    ck_assert(GetNumber(row, "steps") == qc_frames - 1);
    ck_assert_double_eq_tol(GetNumber(row, "of_ours") * seen->oursMs / GetNumber(row, "ms"), 1.0, 0.01);
    ck_assert(GetNumber(row, "open_ms") >= 0.0 && GetNumber(row, "second_ms") > 0.0);
}

START_TEST(every_method_finds_the_pairs_of_a_cloth)
{
    static float positions[3 * 23 * 23];
    qcMesh mesh;
    qcBenchMotion motion;
    MakeFrame(0, &mesh, positions, &motion);
    Seen seen = {.pairs = CountPairs(&mesh, positions), .kind = "self", .bodies = 1};
    qcMesh_Free(&mesh);
    ck_assert_double_gt(seen.pairs, 20.0);
    ck_assert_int_eq(Run("%s peers --scenes cloth-1k --frames 3 --rounds 1 --out deep/er", BENCH), 0);
    ForEachRow("deep/er/peers.csv", s_header, CheckRow, &seen);
    ck_assert_int_eq(seen.ours, 2);
    ck_assert_int_gt(seen.rows, seen.ours);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "cloth-1k: folded cloth with itself, 968 triangles"));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "ours on 2 threads: "));
}
END_TEST

START_TEST(every_method_finds_the_pairs_of_a_pile)
{
    static const char* const kinds[] = {"deforming", "rigid"};
    static const char* const names[] = {"bunnies-27", "rigid-27"};
    for (int i = 0; i < 2; ++i)
    {
        ck_assert_int_eq(Run("%s peers --scenes %s --threads 1 --frames 3 --rounds 1 --out .", BENCH, names[i]), 0);
        if (strstr(GetOutput(), "27 is skipped: ") != NULL)
            return;
        Seen seen = {.pairs = -1.0, .kind = kinds[i], .bodies = 27};
        ForEachRow("peers.csv", s_header, CheckRow, &seen);
        ck_assert_double_gt(seen.pairs, 1000.0);
        ck_assert_int_eq(seen.ours, 1);
    }
}
END_TEST

START_TEST(the_tangles_are_tangled)
{
    static const struct
    {
        const char* name;
        double minPairs, maxPairs;
    } tangles[] = {{"tangle-92k", 0.5 * 92450, 92450}, {"wrung-80k", 1000, 4000}};
    for (int i = 0; i < 2; ++i)
    {
        Seen seen = {.pairs = -1.0, .kind = "self", .bodies = 1};
        ck_assert_int_eq(Run("%s peers --scenes %s --threads 1 --frames 3 --rounds 1 --out .", BENCH, tangles[i].name),
                         0);
        ForEachRow("peers.csv", s_header, CheckRow, &seen);
        ck_assert_double_ge(seen.pairs, tangles[i].minPairs);
        ck_assert_double_le(seen.pairs, tangles[i].maxPairs);
    }
}
END_TEST

START_TEST(gnuplot_draws_a_picture)
{
    if (Run("command -v gnuplot") != 0)
        return;
    ck_assert_int_eq(Run("%s peers --scenes cloth-1k --frames 3 --rounds 1 --out .", BENCH), 0);
    ck_assert_ptr_null(strstr(GetErrors(), "arning"));
    ck_assert_uint_eq(CountEntries(), 3);
    ck_assert_int_eq(Run("test $(wc -c <peers.*g) -gt 10000 || test $(wc -c <peers.png) -gt 10000"), 0);
    ck_assert_int_eq(Run("rm peers.*g; gnuplot peers.gp"), 0);
    ck_assert_uint_eq(CountEntries(), 3);
}
END_TEST

//  ---- with others ---------------------------------------------------------------------------------

START_TEST(without_peers_the_packages_are_named)
{
    ck_assert_int_eq(Run("cp %s qc-bench && ./qc-bench peers --scenes cloth-1k --out out", BENCH), 5);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "not built with: embree, bullet, cgal. Install libembree-dev "
                                              "libbullet-dev libcgal-dev libtbb-dev"));
    ck_assert_int_eq(Run("./qc-bench peers --peers cgal"), 5);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "not built with: cgal. Install libcgal-dev"));
    // Nothing but the program.
    ck_assert_uint_eq(CountEntries(), 1);
}
END_TEST

START_TEST(a_module_that_does_not_load_is_reported)
{
    WriteText("qc-bench-peer-cgal.so", "no library");
    ck_assert_int_eq(Run("cp %s qc-bench && ./qc-bench peers --scenes cloth-1k --out .", BENCH), 1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "qc-bench-peer-cgal.so"));
}
END_TEST

static void CheckLiar(const Row* row, void* context)
{
    int* seen = context;
    if (Is(row, "method", "blind"))
    {
        ck_assert(Is(row, "library", "\"Liar 1\"") && Is(row, "agrees", "0") && Is(row, "pairs", "0"));
        ++*seen;
    }
    else if (!Is(row, "method", "sweep"))
    {
        ck_assert(Is(row, "ms", "") && Is(row, "pairs", ""));
        ck_assert_ptr_nonnull(
            strstr(Get(row, "skipped"), Is(row, "method", "fails") ? "the library failed" : "refused"));
        ++*seen;
    }
}

START_TEST(a_peer_that_finds_other_pairs_is_reported_and_one_that_fails_is_skipped)
{
    ck_assert_int_eq(Run("cp %s qc-bench && cp %s qc-bench-peer-bullet.so && ./qc-bench peers --scenes cloth-1k "
                         "--threads 1 --frames 3 --rounds 1 --out out",
                         BENCH, LIAR),
                     1);
    ck_assert_ptr_nonnull(strstr(GetErrors(), "not built with: embree, cgal."));
    ck_assert_ptr_nonnull(strstr(GetErrors(), "cloth-1k: blind finds other pairs than our sweep (0 and "));
    ck_assert_ptr_nonnull(strstr(GetOutput(), "other pairs than ours"));
    int seen = 0;
    ck_assert_int_eq(ForEachRow("out/peers.csv", s_header, CheckLiar, &seen), 4);
    ck_assert_int_eq(seen, 3);
}
END_TEST

//  ---- refusals ------------------------------------------------------------------------------------

typedef struct Refused
{
    const char* arguments;
    int status;
    const char* message;
} Refused;

static const Refused s_refused[] = {
    {"cloth", 2, "'cloth': options only"},
    {"--scenes cloth", 2, "--scenes: 'cloth' is not one of all, cloth-1k, cloth-20k,"},
    {"--scenes bunny,", 2, "--scenes: 'bunny,' is not a list"},
    {"--peers fcl", 2, "--peers: 'fcl' is not one of embree, bullet, cgal"},
    {"--threads 0", 2, "--threads: '0' is not a whole number in 1..1024"},
    {"--threads 2,2", 2, "--threads: '2' is named twice"},
    {"--threads 1,2,3,4,5,6,7,8,9", 2, "--threads: more than 8"},
    {"--frames 2", 2, "--frames: '2' is not a whole number in 3..32"},
    {"--rounds 17", 2, "--rounds: '17' is not a whole number in 1..16"},
    {"--device gpu", 2, "--device: 'gpu' is not one of"},
    {"--out ''", 2, "--out: no folder is named"},
    {"--out file/below", 1, "file: Not a directory"},
    {"--scenes dragon --dragon none.ply", 3, "none.ply"},
    {"--scenes bunny --bunny file", 3, "file"},
    {"--scenes bunny --bunny none.obj", 3, "none.obj"},
};

START_TEST(a_mistake_is_refused_with_a_message_that_names_it)
{
    const Refused* refused = &s_refused[_i];
    WriteText("file", "no mesh");
    // With a peer, so that what comes after the command line is reached on every machine.
    ck_assert_int_eq(
        Run("cp %s qc-bench && cp %s qc-bench-peer-bullet.so && ./qc-bench peers %s", BENCH, LIAR, refused->arguments),
        refused->status);
    ck_assert_msg(strstr(GetErrors(), refused->message) != NULL, "'%s' is not in: %s", refused->message, GetErrors());
}
END_TEST

START_TEST(a_missing_model_is_skipped)
{
    ck_assert_int_eq(
        Run("cp %s qc-bench && cp %s qc-bench-peer-bullet.so && ./qc-bench peers --scenes dragon --out .", BENCH, LIAR),
        0);
    ck_assert_ptr_nonnull(strstr(GetOutput(), "dragon is skipped: --dragon names no file"));
    ck_assert_ptr_nonnull(strstr(GetErrors(), "nothing ran: no picture"));
}
END_TEST

int main(void)
{
    TCase* tcase = qcMakeCase("qc-bench peers");
    tcase_add_checked_fixture(tcase, EnterFolder, LeaveFolder);
    tcase_add_test(tcase, the_triangle_test_of_the_peers_is_exact);
    tcase_add_test(tcase, a_frame_moves_each_vertex_by_little_and_the_last_leads_to_the_first);
    tcase_add_test(tcase, a_decimated_mesh_has_about_the_requested_number_of_triangles);
    tcase_add_test(tcase, coincident_triangles_have_corners_of_their_own_and_all_penetrate);
    tcase_add_test(tcase, preprocessing_is_for_pairs_where_these_outnumber_triangles);
    // Where no peer was built there is nothing to compare.
    if (QC_BENCH_PEERS > 0)
    {
        tcase_add_test(tcase, every_method_finds_the_pairs_of_a_cloth);
        tcase_add_test(tcase, every_method_finds_the_pairs_of_a_pile);
        tcase_add_test(tcase, the_tangles_are_tangled);
        tcase_add_test(tcase, gnuplot_draws_a_picture);
    }
    tcase_add_test(tcase, without_peers_the_packages_are_named);
    tcase_add_test(tcase, a_module_that_does_not_load_is_reported);
    tcase_add_test(tcase, a_peer_that_finds_other_pairs_is_reported_and_one_that_fails_is_skipped);
    tcase_add_test(tcase, a_missing_model_is_skipped);
    tcase_add_loop_test(tcase, a_mistake_is_refused_with_a_message_that_names_it, 0,
                        (int)(sizeof s_refused / sizeof s_refused[0]));
    return qcRunCase("qc-bench peers", tcase);
}
