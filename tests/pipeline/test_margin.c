// Every method that never misses reports exactly the pairs that the oracle finds within the margin, on small soups and
// for pairs exactly at it, with the proximity of each.
#include "support/devices.h"
#include "support/oracle.h"
#include "support/pairs.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

typedef struct Method
{
    const char* name;
    qcMethod method;
    uint32_t threads;
} Method;

static const Method s_methods[] = {
    {"brute", qc_methodBrute, 1}, {"brute, two threads", qc_methodBrute, 2},
    {"sweep", qc_methodSweep, 1}, {"sweep, three threads", qc_methodSweep, 3},
    {"auto", qc_methodAuto, 1},
};

enum
{
    qc_methodCount = sizeof s_methods / sizeof s_methods[0],
    qc_marginCount = 6
};

//  ---- against the oracle ------------------------------------------------------------------------------------

/// All pairs of a soup with their exact distances.
typedef struct Expected
{
    const qcSoup* soup;
    size_t count;
    qcPair* pairs; ///< sorted; disjoint ones too
    qcOracleDistance** distances;
} Expected;

static Expected Expect(const qcSoup* soup)
{
    size_t most = (size_t)soup->triangleCount * soup->triangleCount / 2;
    Expected e = {soup, 0, malloc(most * sizeof(qcPair)), malloc(most * sizeof(qcOracleDistance*))};
    for (uint32_t i = 0; i < soup->triangleCount; i++)
        for (uint32_t j = i + 1; j < soup->triangleCount; j++, e.count++)
        {
            double a[3][3], b[3][3];
            qcSoup_GetTriangle(soup, i, a);
            qcSoup_GetTriangle(soup, j, b);
            e.pairs[e.count] = (qcPair){0, i, 0, j, qcOracle_Relate((const double(*)[3])a, (const double(*)[3])b)};
            e.distances[e.count] = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
        }
    return e;
}

static void FreeExpected(Expected* e)
{
    for (size_t i = 0; i < e->count; i++)
        qcOracleDistance_Destroy(e->distances[i]);
    free(e->distances);
    free(e->pairs);
}

static qcPairList ListExpected(const Expected* e, const qcDetectDef* def)
{
    qcPairList list = {malloc((e->count + 1) * sizeof(qcPair)), 0};
    for (size_t i = 0; i < e->count; i++)
    {
        qcPair pair = e->pairs[i];
        if (!def->neighbours && qcSoup_AreNeighbours(e->soup, pair.triangleA, pair.triangleB))
            continue;
        if (pair.relation == qc_relationDisjoint)
        {
            if (qcOracleDistance_Compare(e->distances[i], def->margin) > 0)
                continue;
            pair.relation = qc_relationNear;
        }
        if (pair.relation == qc_relationTouching && !def->touching && def->margin == 0.0)
            continue;
        list.pairs[list.count++] = pair;
    }
    return list;
}

/// Returns the number of pairs, over all margins, that are near but disjoint.
static size_t CheckSoup(qcSoup soup, const double margins[qc_marginCount], const char* what)
{
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    Expected expected = Expect(&soup);
    size_t apart = 0;
    for (int m = 0; m < 4 * qc_marginCount; m++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.margin = margins[m / 4];
        def.touching = m % 2 != 0;
        def.neighbours = m / 2 % 2 != 0;
        qcPairList list = ListExpected(&expected, &def);
        for (size_t i = 0; i < list.count; i++)
            apart += list.pairs[i].relation == qc_relationNear;
        for (int k = 0; k < qc_methodCount; k++)
        {
            char name[200];
            snprintf(name, sizeof name, "%s, %s, margin %g", what, s_methods[k].name, def.margin);
            def.method = s_methods[k].method;
            def.threads = s_methods[k].threads;
            qcPairList found = qcDetectPairs(scene, &def);
            qcCheckSamePairs(&list, &found, name);
            free(found.pairs);
        }
        free(list.pairs);
    }
    FreeExpected(&expected);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    return apart;
}

START_TEST(every_method_finds_the_pairs_of_the_oracle_in_random_soups)
{
    const double margins[qc_marginCount] = {0, 1e-9, 0.01, 0.05, 0.2, 10};
    ck_assert_uint_gt(CheckSoup(qcSoup_MakeRandom(31, 70, 0.2), margins, "random soup"), 5000);
    qcSoup far = qcSoup_MakeRandom(32, 70, 0.2);
    qcSoup_Translate(&far, 1e7, -1e7, 1e7);
    ck_assert_uint_gt(CheckSoup(far, margins, "far soup"), 5000);
    ck_assert_uint_gt(CheckSoup(qcSoup_MakeDegenerate(33, 70, 0.2, 0.5), margins, "degenerate soup"), 5000);
}
END_TEST

START_TEST(every_method_finds_the_pairs_of_the_oracle_in_a_folded_cloth)
{
    const double edge = 1.0 / 6;
    const double margins[qc_marginCount] = {0, edge / 100, edge / 4, edge, 2 * edge, 3 * edge};
    ck_assert_uint_gt(CheckSoup(qcSoup_MakeFoldedCloth(34, 6, 0.02, 0.01), margins, "cloth"), 1000);
}
END_TEST

START_TEST(every_method_finds_the_pairs_of_the_oracle_on_a_sphere)
{
    const double margins[qc_marginCount] = {0, 0.01, 0.1, 0.25, 0.6, 2};
    ck_assert_uint_gt(CheckSoup(qcSoup_MakeSphere(1, 1), margins, "sphere"), 1000);
}
END_TEST

START_TEST(sheets_exactly_the_margin_apart_are_near_and_by_an_ulp_less_are_not)
{
    // Squares of 1/4: the pairs of one sheet are at the margin as well.
    const double gap = 0.25;
    const double margins[qc_marginCount] = {nextafter(gap, 0), gap, nextafter(gap, 1), 0.1, 2 * gap, nextafter(0.5, 0)};
    ck_assert_uint_gt(CheckSoup(qcSoup_MakeSheets(3, 4, gap), margins, "sheets"), 2000);
}
END_TEST

//  ---- two bodies exactly at the margin --------------------------------------------------------------------

static qcScene* MakePairOfBodies(const qcTrianglePair* pair)
{
    static uint32_t s_indices[3] = {0, 1, 2};
    double corners[2][9];
    memcpy(corners[0], pair->a, sizeof corners[0]);
    memcpy(corners[1], pair->b, sizeof corners[1]);
    qcScene* scene = qcMakeScene(NULL);
    for (int body = 0; body < 2; body++)
    {
        qcSoup soup = {corners[body], 3, s_indices, 1};
        qcAddSoup(scene, &soup);
    }
    return scene;
}

START_TEST(bodies_exactly_the_margin_apart_are_found_and_by_an_ulp_less_are_not)
{
    qcRandom random = {35};
    for (int i = 0; i < 4000; i++)
    {
        qcTrianglePair pair;
        double distance;
        char text[1024];
        qcTrianglePair_MakeApart(&random, 1 + i % 3, 1 + i / 3 % 3, &pair, &distance);
        qcScene* scene = MakePairOfBodies(&pair);
        for (int k = 0; k < 2 * qc_methodCount; k++)
        {
            qcDetectDef def = qcDefaultDetectDef();
            def.method = s_methods[k / 2].method;
            def.threads = s_methods[k / 2].threads;
            def.margin = k % 2 == 0 ? distance : nextafter(distance, 0);
            const qcResult* result;
            CHECK_OK(qcScene_Detect(scene, &def, &result));
            if (result->pairCount != (k % 2 == 0) || (k % 2 == 0 && result->pairs[0].relation != qc_relationNear))
                ck_abort_msg("%s: %zu pairs at margin %a, distance %a, for %s", s_methods[k / 2].name,
                             result->pairCount, def.margin, distance, qcTrianglePair_Print(&pair, text));
        }
        qcScene_Destroy(scene);
    }
}
END_TEST

//  ---- margins of bodies -----------------------------------------------------------------------------------

enum
{
    qc_bodiesWithMargins = 4
};

/// The pairs of bodies of one soup each, in order of their slots.
static qcPairList ListWithin(const qcSoup* soups, const double* bodyMargins, double margin)
{
    qcPairList list = {malloc(4096 * sizeof(qcPair)), 0};
    for (uint32_t x = 0; x < qc_bodiesWithMargins; x++)
        for (uint32_t i = 0; i < soups[x].triangleCount; i++)
            for (uint32_t y = x; y < qc_bodiesWithMargins; y++)
                for (uint32_t j = y == x ? i + 1 : 0; j < soups[y].triangleCount; j++)
                {
                    if (y == x && qcSoup_AreNeighbours(&soups[x], i, j))
                        continue;
                    double a[3][3], b[3][3], sum = bodyMargins[x] + bodyMargins[y];
                    qcSoup_GetTriangle(&soups[x], i, a);
                    qcSoup_GetTriangle(&soups[y], j, b);
                    qcRelation relation = qcOracle_Relate((const double(*)[3])a, (const double(*)[3])b);
                    qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
                    bool isFar = qcOracleDistance_Compare(distance, sum < margin ? sum : margin) > 0;
                    qcOracleDistance_Destroy(distance);
                    if (relation == qc_relationDisjoint && isFar)
                        continue;
                    ck_assert_uint_lt(list.count, 4096);
                    relation = relation == qc_relationDisjoint ? qc_relationNear : relation;
                    list.pairs[list.count++] = (qcPair){x, i, y, j, relation};
                }
    return list;
}

static void CheckMarginsOfBodies(qcDevice* device, bool deforming)
{
    const double margins[][qc_bodiesWithMargins] = {{INFINITY, INFINITY, INFINITY, INFINITY},
                                                    {0.0, 0.0, 0.0, 0.0},
                                                    {0.01, 0.05, 0.0, INFINITY},
                                                    {0.2, 0.02, 0.1, 0.03}};
    qcSoup soups[qc_bodiesWithMargins];
    qcBodyId ids[qc_bodiesWithMargins];
    qcScene* scene = qcMakeScene(device);
    for (uint32_t i = 0; i < qc_bodiesWithMargins; i++)
    {
        soups[i] = qcSoup_MakeRandom(50 + i, 20, 0.2);
        qcBodyDef def = qcBodyDefOf(&soups[i]);
        def.deforming = deforming;
        CHECK_OK(qcScene_AddBody(scene, &def, &ids[i]));
    }
    size_t counts[4];
    for (int round = 0; round < 4; round++)
    {
        for (int i = 0; i < qc_bodiesWithMargins; i++)
            CHECK_OK(qcScene_SetMargin(scene, ids[i], margins[round][i]));
        qcDetectDef def = qcDefaultDetectDef();
        def.margin = 0.1;
        qcPairList expected = ListWithin(soups, margins[round], def.margin);
        counts[round] = expected.count;
        for (int k = 0; k <= qc_methodCount; k++)
        {
            char name[100];
            def.method = k < qc_methodCount ? s_methods[k].method : qc_methodLayers;
            def.threads = k < qc_methodCount ? s_methods[k].threads : 1;
            snprintf(name, sizeof name, "round %d, method %d, deforming %d", round, (int)def.method, deforming);
            qcPairList found = qcDetectPairs(scene, &def);
            qcCheckSamePairs(&expected, &found, name);
            free(found.pairs);
        }
        free(expected.pairs);
    }
    ck_assert(counts[1] < counts[2] && counts[2] < counts[3] && counts[3] < counts[0]);
    qcScene_Destroy(scene);
    for (int i = 0; i < qc_bodiesWithMargins; i++)
        qcSoup_Free(&soups[i]);
}

START_TEST(pairs_are_reported_up_to_the_sum_of_the_margins_of_their_bodies)
{
    QC_FOR_EACH_DEVICE(device)
    {
        CheckMarginsOfBodies(device, false);
        CheckMarginsOfBodies(device, true);
    }
}
END_TEST

START_TEST(the_largest_margin_reports_all_pairs)
{
    qcSoup soup = qcSoup_MakeRandom(36, 40, 0.1);
    for (uint32_t v = 0; v < 3 * soup.vertexCount; v++)
        soup.positions[v] *= 1e307; // box ends plus the margin are beyond all doubles
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    for (int k = 0; k < qc_methodCount; k++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.method = s_methods[k].method;
        def.threads = s_methods[k].threads;
        def.margin = DBL_MAX;
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_eq(result->pairCount, 40 * 39 / 2);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

//  ---- proximities -------------------------------------------------------------------------------------------

START_TEST(each_pair_has_the_proximity_of_its_triangles_on_request)
{
    qcSoup soup = qcSoup_MakeRandom(37, 300, 0.2);
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    for (int k = 0; k < qc_methodCount; k++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.method = s_methods[k].method;
        def.threads = s_methods[k].threads;
        def.margin = 0.05;
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_ptr_null(result->proximities);
        def.proximities = true;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_gt(result->pairCount, 500);
        for (size_t i = 0; i < result->pairCount; i++)
        {
            double a[3][3], b[3][3];
            qcSoup_GetTriangle(&soup, result->pairs[i].triangleA, a);
            qcSoup_GetTriangle(&soup, result->pairs[i].triangleB, b);
            qcProximity p;
            ck_assert(qcTrianglesWithin(&a[0][0], &b[0][0], def.margin, &p));
            ck_assert_mem_eq(&p, &result->proximities[i], sizeof p);
            ck_assert(result->pairs[i].relation == qc_relationNear ? p.distance > 0 : p.distance == 0);
        }
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

QC_RUN_TESTS("margin", every_method_finds_the_pairs_of_the_oracle_in_random_soups,
             every_method_finds_the_pairs_of_the_oracle_in_a_folded_cloth,
             every_method_finds_the_pairs_of_the_oracle_on_a_sphere,
             sheets_exactly_the_margin_apart_are_near_and_by_an_ulp_less_are_not,
             bodies_exactly_the_margin_apart_are_found_and_by_an_ulp_less_are_not,
             pairs_are_reported_up_to_the_sum_of_the_margins_of_their_bodies, the_largest_margin_reports_all_pairs,
             each_pair_has_the_proximity_of_its_triangles_on_request)
