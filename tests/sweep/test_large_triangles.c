// Bodies with large triangles beside fine meshes and cloth, at rest and over a motion: the sweep against brute force.
#define _POSIX_C_SOURCE 200809L // setenv
#include "support/scenes.h"
#include "support/suite.h"
#include "support/transforms.h"
#include "sweep/sample_bodies.h"

#include <stdio.h>

enum
{
    qc_rooms = 3,
    qc_largeCount = 72, // two leaf nodes: the deforming body is fitted as an outline
    qc_steps = 3        // in the first one the bodies are new
};

/// A fine sphere of 1280 triangles, a fine cloth, and large triangles.
typedef struct Room
{
    qcScene* scene;
    qcSoup sphere, cloth, large;
    bool deforming; ///< the large triangles
    qcBodyId ids[3];
} Room;

typedef enum LargeKind
{
    qc_largeRigid,
    qc_largeDeforming,
    qc_largeWide, ///< rigid, so wide that its lattice is too coarse for the sphere
    qc_largeKindCount
} LargeKind;

/// Large triangles all over the room. `smallCount`: also so many small ones, in one part of it.
static qcSoup MakeLarge(uint64_t seed, uint32_t largeCount, uint32_t smallCount)
{
    qcSoup soup = qcSoup_MakeRandom(seed, largeCount + smallCount, 0.7);
    qcSoup small = qcSoup_MakeRandom(seed + 1, smallCount + 1, 0.02);
    qcSoup_Place(&small, 0.4, 0.3, 0.3, 0.3);
    size_t first = 9 * (size_t)largeCount;
    memcpy(soup.positions + first, small.positions, 9 * (size_t)smallCount * sizeof(double));
    qcSoup_Free(&small);
    return soup;
}

static void AddBody(Room* room, int number, qcSoup* soup, bool deforming)
{
    qcSoup_RoundToFloat(soup); // a motion is tested at exact positions
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = deforming;
    def.selfCollision = false;
    def.owner = number == 2 ? 1 : 2; // the sphere and the cloth aren't tested with each other
    CHECK_OK(qcScene_AddBody(room->scene, &def, &room->ids[number]));
}

static Room MakeRoom(uint64_t seed, uint32_t smallCount, LargeKind kind)
{
    Room room = {.scene = qcMakeScene(NULL),
                 .sphere = qcSoup_MakeSphere(3, 0.3),
                 .cloth = qcSoup_MakeFoldedCloth(seed, 20, 0.3, 0.01),
                 .large = MakeLarge(seed, qc_largeCount, smallCount),
                 .deforming = kind == qc_largeDeforming};
    if (kind == qc_largeWide)
        room.large.positions[0] = 1e4;
    AddBody(&room, 0, &room.sphere, false);
    AddBody(&room, 1, &room.cloth, true);
    AddBody(&room, 2, &room.large, room.deforming);
    return room;
}

static void FreeRoom(Room* room)
{
    qcScene_Destroy(room->scene);
    qcSoup_Free(&room->sphere);
    qcSoup_Free(&room->cloth);
    qcSoup_Free(&room->large);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

/// Moves a rigid body to any place in the room, or exchanges the axes of a deforming one.
static void MoveBody(qcRandom* random, const Room* room, int number, qcSoup* soup, bool deforming)
{
    if (!deforming)
    {
        qcTransform t = qcIdentityTransform();
        qcMakeRotation(random, t.linear);
        for (int axis = 0; axis < 3; axis++)
            t.translation[axis] = qcRandom_Uniform(random, 0.2, 0.8) - (number == 2 ? 0.5 : 0.0);
        CHECK_OK(qcScene_SetTransform(room->scene, room->ids[number], &t));
        return;
    }
    for (size_t v = 0; v < soup->vertexCount; v++)
    {
        double *at = soup->positions + 3 * v, x = at[0];
        at[0] = at[1] + qcRandom_Uniform(random, -0.01, 0.01);
        at[1] = at[2];
        at[2] = x;
    }
    qcSoup_RoundToFloat(soup);
    CHECK_OK(qcScene_SetVertices(room->scene, room->ids[number], soup->positions, qc_positionF64, 0));
}

static void Move(qcRandom* random, Room* room)
{
    MoveBody(random, room, 0, &room->sphere, false);
    MoveBody(random, room, 1, &room->cloth, true);
    MoveBody(random, room, 2, &room->large, room->deforming);
}

/// Returns the number of pairs that brute force finds, and the sweep, too.
static size_t CheckStep(const Room* room, qcDetectDef def, const char* what)
{
    def.method = qc_methodBrute;
    qcPairList expected = qcDetectPairs(room->scene, &def);
    def.method = qc_methodSweep;
    for (uint32_t threads = 1; threads <= 3; threads += 2)
    {
        def.threads = threads;
        qcPairList found = qcDetectPairs(room->scene, &def);
        qcCheckSamePairs(&expected, &found, what);
        free(found.pairs);
    }
    free(expected.pairs);
    return expected.count;
}

static void UseKernels(int i)
{
    static const char* const names[] = {"avx512", "avx2", "plain"};
    setenv("QC_KERNELS", names[i % 3], 1);
}

/// Plays a room, with a margin or over a motion in turn.
static size_t PlayRoom(uint64_t seed, uint32_t smallCount, LargeKind kind)
{
    qcRandom random = {seed};
    Room room = MakeRoom(seed, smallCount, kind);
    size_t pairs = 0;
    for (int step = 0; step < qc_steps; step++)
    {
        char what[64];
        snprintf(what, sizeof what, "room %d, kind %d, %u small ones, step %d", (int)seed, (int)kind, smallCount, step);
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        def.margin = step == 1 ? 0.0 : 0.01;
        pairs += CheckStep(&room, def, what);
        CHECK_OK(qcScene_MarkStart(room.scene));
        Move(&random, &room);
        def = qcDefaultDetectDef();
        def.motion = true;
        (void)CheckStep(&room, def, what);
        Move(&random, &room);
    }
    FreeRoom(&room);
    return pairs;
}

START_TEST(large_triangles_have_the_pairs_of_brute_force)
{
    for (int i = 0; i < qc_rooms * qc_largeKindCount; i++)
    {
        UseKernels(i / qc_largeKindCount);
        ck_assert_uint_gt(PlayRoom((uint64_t)i, 0, (LargeKind)(i % qc_largeKindCount)), 500);
    }
}
END_TEST

START_TEST(small_triangles_among_large_ones_have_the_pairs_of_brute_force)
{
    // With 300 small ones the triangles are still large on average, and more clusters are near the sphere than it has
    // leaf nodes.
    for (int i = 0; i < qc_rooms; i++)
    {
        UseKernels(i);
        ck_assert_uint_gt(PlayRoom((uint64_t)i + 50, i % 2 == 0 ? 300 : 1500, qc_largeRigid), 500);
    }
}
END_TEST

/// Triangles that are visited of a sphere of 20 480, and of two level walls of eight triangles each. The sphere is
/// turned, touches one wall, and is far from the other.
static uint64_t CountVisited(bool motion)
{
    qcRandom random = {9};
    qcScene* scene = qcMakeScene(NULL);
    qcSoup sphere = qcSoup_MakeSphere(5, 1.0), walls = qcSoup_MakeSheets(2, 2, 0.8);
    qcSoup_Place(&walls, 10.0, -5.0, -5.0, -0.999);
    qcBodyId ids[2];
    for (int side = 0; side < 2; side++)
    {
        qcBodyDef def = qcBodyDefOf(side == 0 ? &sphere : &walls);
        def.selfCollision = false;
        CHECK_OK(qcScene_AddBody(scene, &def, &ids[side]));
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.motion = motion;
    const qcResult* result = NULL;
    for (int step = 0; step < qc_steps; step++)
    {
        qcTransform turned = qcIdentityTransform();
        qcMakeRotation(&random, turned.linear);
        CHECK_OK(qcScene_SetTransform(scene, ids[0], &turned));
        CHECK_OK(qcScene_MarkStart(scene));
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_gt(result->pairCount, 0);
    }
    uint64_t visited = result->profile.trianglePcs;
    qcScene_Destroy(scene);
    qcSoup_Free(&sphere);
    qcSoup_Free(&walls);
    return visited;
}

START_TEST(the_parts_of_a_fine_mesh_far_from_large_triangles_are_not_visited)
{
    for (int motion = 0; motion < 2; motion++)
        CHECK_THAT(CountVisited(motion != 0) < 2000, "%d triangles are visited", (int)CountVisited(motion != 0));
}
END_TEST

QC_RUN_TESTS("large_triangles", large_triangles_have_the_pairs_of_brute_force,
             small_triangles_among_large_ones_have_the_pairs_of_brute_force,
             the_parts_of_a_fine_mesh_far_from_large_triangles_are_not_visited)
