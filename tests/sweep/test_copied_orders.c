// Copies of a mesh take over the cluster order of one of them: an order suits a body if the triangles connect the same
// vertices and lie alike, and each step has the pairs of brute force.
#include "support/scenes.h"
#include "support/suite.h"
#include "sweep/bvh/bvh_copy.h"
#include "sweep/failing_steps.h"
#include "sweep/sample_bodies.h"

#include <math.h>

enum
{
    qc_side = 24,
    qc_triangles = 2 * qc_side * qc_side,
    qc_copies = 5
};

// Sheets that are so far apart meet in a strip.
static const double s_spacing = 0.8;

/// A crumpled sheet, bent by a seed, turned about the y axis and moved along x.
static qcSoup MakeCopy(uint64_t seed, double angle, double x)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(1, qc_side, 0.02, 0.05);
    qcRandom random = {seed};
    for (uint32_t v = 0; v < soup.vertexCount; v++)
    {
        double* p = soup.positions + 3 * (size_t)v;
        const double at[3] = {p[0] + qcRandom_Uniform(&random, -0.005, 0.005), p[1], p[2] + 0.05 * sin(4.0 * p[1])};
        p[0] = cos(angle) * at[0] + sin(angle) * at[2] + x;
        p[2] = cos(angle) * at[2] - sin(angle) * at[0];
    }
    return soup;
}

static qcBodyId AddDeforming(qcScene* scene, const qcSoup* soup, bool selfCollision)
{
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = true;
    def.selfCollision = selfCollision;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    return id;
}

/// Checks the pairs of a step. Returns how many triangles were fitted.
static uint64_t CheckStep(qcScene* scene, uint32_t threads)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.threads = threads;
    def.method = qc_methodBrute;
    qcPairList expected = qcDetectPairs(scene, &def);
    ck_assert_uint_gt(expected.count, 0);
    const qcResult* result;
    def.method = qc_methodSweep;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    qcPairList found = qcListOf(result);
    qcCheckSamePairs(&expected, &found, "sweep");
    free(expected.pairs);
    return result->profile.fittedTriangles;
}

//  ---- orders --------------------------------------------------------------------------------------

typedef struct Bodies
{
    qcBodies bodies;
    qcTriangleBvh bvh; ///< of the first one
} Bodies;

static Bodies MakeBodies(const qcSoup* first)
{
    Bodies made = {.bodies = {.count = 0}};
    uint32_t slot = qcAddToBodies(&made.bodies, first);
    const qcOrderOptions options = {.threads = 1};
    CHECK_OK(qcTriangleBvh_Build(&made.bvh, qcBodyAt(&made.bodies, slot), &options));
    return made;
}

/// Whether the order of the first body suits another one.
static bool Suits(Bodies* made, const qcSoup* soup)
{
    uint32_t slot = qcAddToBodies(&made->bodies, soup);
    const qcBody *first = qcBodyAt(&made->bodies, 0), *other = qcBodyAt(&made->bodies, slot);
    bool suits = qcBvhCopy_Suits(&made->bvh, first, other);
    ck_assert(!suits || qcBvhCopy_KeyOf(first) == qcBvhCopy_KeyOf(other));
    return suits;
}

static void FreeBodies(Bodies* made)
{
    qcTriangleBvh_Free(&made->bvh);
    qcBodies_Free(&made->bodies);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

START_TEST(an_order_suits_turned_bent_and_scaled_copies)
{
    qcSoup first = MakeCopy(1, 0.0, 0.0);
    Bodies made = MakeBodies(&first);
    for (uint64_t seed = 2; seed < 40; seed++)
    {
        qcSoup copy = MakeCopy(seed, 0.4 * (double)seed, (double)seed);
        qcSoup_Place(&copy, pow(0.5, (double)(seed % 5)), 0.0, 0.0, 0.0);
        ck_assert(Suits(&made, &copy));
        qcSoup_Free(&copy);
    }
    FreeBodies(&made);
    qcSoup_Free(&first);
}
END_TEST

START_TEST(an_order_suits_no_body_of_other_triangles)
{
    qcSoup first = MakeCopy(1, 0.0, 0.0);
    Bodies made = MakeBodies(&first);
    for (uint32_t t = 0; t < 3 * first.triangleCount; t += 97)
    {
        // The key has seen three indices only.
        qcSoup other = MakeCopy(1, 0.0, 0.0);
        other.indices[t] = (other.indices[t] + 1) % other.vertexCount;
        ck_assert(!Suits(&made, &other));
        qcSoup_Free(&other);
    }
    qcSoup rotated = MakeCopy(1, 0.0, 0.0), sphere = qcSoup_MakeSphere(2, 0.5);
    qcSoup_RotateTriangles(&rotated, 1);
    ck_assert(!Suits(&made, &rotated));
    ck_assert(!Suits(&made, &sphere));
    qcSoup_Free(&rotated);
    qcSoup_Free(&sphere);
    FreeBodies(&made);
    qcSoup_Free(&first);
}
END_TEST

START_TEST(an_order_suits_no_body_whose_triangles_lie_elsewhere)
{
    // Triangles without common vertices have the same indices in all bodies of their number. In a single leaf node the
    // order hardly matters.
    const uint32_t counts[] = {100, 300, 3000};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
    {
        qcSoup first = qcSoup_MakeRandom(1, counts[i], 0.05), other = qcSoup_MakeRandom(2, counts[i], 0.05);
        Bodies made = MakeBodies(&first);
        ck_assert(Suits(&made, &first));
        ck_assert(!Suits(&made, &other));
        FreeBodies(&made);
        qcSoup_Free(&first);
        qcSoup_Free(&other);
    }
    // All at one place: how they lie cannot be compared.
    qcSoup points = qcMakeSoup(qc_soupPoint, 1);
    Bodies made = MakeBodies(&points);
    ck_assert(!Suits(&made, &points));
    FreeBodies(&made);
    qcSoup_Free(&points);
}
END_TEST

START_TEST(a_bvh_in_the_order_of_a_copy_has_its_slots)
{
    qcSoup first = MakeCopy(1, 0.0, 0.0), copy = MakeCopy(2, 0.7, 3.0);
    Bodies made = MakeBodies(&first);
    const qcBody* body = qcBodyAt(&made.bodies, qcAddToBodies(&made.bodies, &copy));
    qcTriangleBvh bvh, own;
    const qcOrderOptions options = {.threads = 1};
    CHECK_OK(qcTriangleBvh_Build(&own, body, &options));
    CHECK_OK(qcTriangleBvh_BuildLike(&bvh, body, &made.bvh));
    const qcArray *slots = &bvh.clusters.triangles, *expected = &made.bvh.clusters.triangles;
    ck_assert_uint_eq(slots->count, expected->count);
    ck_assert_mem_eq(slots->data, expected->data, slots->count * sizeof(uint32_t));
    ck_assert_mem_ne(own.clusters.triangles.data, expected->data, slots->count * sizeof(uint32_t));
    ck_assert_mem_eq(bvh.corners.data, made.bvh.corners.data, bvh.corners.count * sizeof(qcCorners));
    ck_assert_mem_eq(bvh.vertexOf.data, made.bvh.vertexOf.data, bvh.vertexOf.count * sizeof(uint32_t));
    ck_assert_uint_eq(bvh.vertexCount, made.bvh.vertexCount);
    ck_assert_uint_eq(bvh.generation, body->generation);
    qcTriangleBvh_Free(&bvh);
    qcTriangleBvh_Free(&own);
    FreeBodies(&made);
    qcSoup_Free(&first);
    qcSoup_Free(&copy);
}
END_TEST

//  ---- scenes --------------------------------------------------------------------------------------

START_TEST(copies_are_fitted_whole_and_others_where_they_meet)
{
    // Without copies, only triangles that others may come near are put in order and fitted.
    for (uint32_t isOther = 0; isOther < 2; isOther++)
    {
        qcScene* scene = qcMakeScene(NULL);
        for (uint32_t i = 0; i < qc_copies; i++)
        {
            qcSoup soup = MakeCopy(i, 0.0, s_spacing * i);
            qcSoup_RotateTriangles(&soup, isOther * i);
            AddDeforming(scene, &soup, false);
            qcSoup_Free(&soup);
        }
        uint64_t fitted = CheckStep(scene, 1);
        ck_assert(isOther == 1 ? fitted < qc_copies * qc_triangles * 9 / 10 : fitted == qc_copies * qc_triangles);
        qcScene_Destroy(scene);
    }
}
END_TEST

START_TEST(a_later_copy_is_fitted_whole)
{
    for (uint32_t isOther = 0; isOther < 2; isOther++)
    {
        qcScene* scene = qcMakeScene(NULL);
        for (uint32_t i = 0; i < 3; i++)
        {
            qcSoup soup = MakeCopy(i, 0.0, s_spacing * i);
            if (i == 2)
            {
                qcSoup_RotateTriangles(&soup, isOther);
                CheckStep(scene, 1);
            }
            AddDeforming(scene, &soup, false);
            qcSoup_Free(&soup);
        }
        uint64_t fitted = CheckStep(scene, 1);
        ck_assert(isOther == 1 ? fitted < qc_triangles * 9 / 10 : fitted == qc_triangles);
        qcScene_Destroy(scene);
    }
}
END_TEST

START_TEST(a_limited_order_is_not_taken_over)
{
    // The first sheet is put in order where it meets the second one; its copy meets the third one elsewhere.
    qcScene* scene = qcMakeScene(NULL);
    for (uint32_t i = 0; i < 4; i++)
    {
        const double places[] = {0.0, s_spacing, 8.0, 8.0 - s_spacing};
        qcSoup soup = MakeCopy(i, 0.0, places[i]);
        qcSoup_RotateTriangles(&soup, i % 2 == 1 ? i : 0);
        AddDeforming(scene, &soup, false);
        qcSoup_Free(&soup);
        if (i == 1)
            ck_assert_uint_lt(CheckStep(scene, 1), 2 * qc_triangles * 9 / 10);
    }
    CheckStep(scene, 1);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(copies_that_come_and_go_miss_no_pair)
{
    for (uint64_t seed = 0; seed < 9; seed++)
    {
        qcRandom random = {seed};
        qcScene* scene = qcMakeScene(NULL);
        qcBodyId ids[2 * qc_copies];
        size_t count = 0;
        for (uint32_t step = 0; step < 8; step++)
        {
            // Several at once or one, among bodies with self-collision and rigid ones, and strangers of the same
            // indices.
            uint32_t added = step == 0 ? qc_copies : qcRandom_Below(&random, 3);
            for (uint32_t i = 0; i < added && count < 2 * qc_copies; i++)
            {
                qcSoup soup = seed % 3 == 0 ? qcSoup_MakeRandom(seed + qcRandom_Below(&random, 3), 300, 0.1)
                                            : MakeCopy(seed, qcRandom_Uniform(&random, 0.0, 6.0), 0.1 * i);
                if (qcRandom_Below(&random, 8) == 0)
                    qcSoup_RotateTriangles(&soup, 1);
                uint32_t kind = qcRandom_Below(&random, 4);
                ids[count++] = kind < 2 ? AddDeforming(scene, &soup, kind == 1) : qcAddSoup(scene, &soup);
                qcSoup_Free(&soup);
            }
            CheckStep(scene, 1 + step % 3);
            if (step % 2 == 1)
            {
                size_t at = qcRandom_Below(&random, (uint32_t)count);
                CHECK_OK(qcScene_RemoveBody(scene, ids[at]));
                ids[at] = ids[--count];
            }
        }
        qcScene_Destroy(scene);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static qcScene* MakeThreeCopies(void)
{
    qcScene* scene = qcMakeScene(NULL);
    for (uint32_t i = 0; i < 3; i++)
    {
        qcSoup soup = MakeCopy(i, 0.0, s_spacing * i);
        AddDeforming(scene, &soup, i == 1);
        qcSoup_Free(&soup);
    }
    return scene;
}

START_TEST(after_a_failed_allocation_copies_have_all_pairs)
{
    qcFailEachAllocation(MakeThreeCopies, CheckStep);
}
END_TEST

QC_RUN_TESTS("copied_orders", an_order_suits_turned_bent_and_scaled_copies, an_order_suits_no_body_of_other_triangles,
             an_order_suits_no_body_whose_triangles_lie_elsewhere, a_bvh_in_the_order_of_a_copy_has_its_slots,
             copies_are_fitted_whole_and_others_where_they_meet, a_later_copy_is_fitted_whole,
             a_limited_order_is_not_taken_over, copies_that_come_and_go_miss_no_pair,
             after_a_failed_allocation_copies_have_all_pairs)
