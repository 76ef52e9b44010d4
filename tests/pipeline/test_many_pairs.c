// Scenes made to cost much: triangles that coincide, thousands of tiny bodies. All pairs are found, memory stays small,
// and qcDetectDef::maxPairs bounds it.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

/// Copies of one triangle, without common vertices. Their first corners differ.
static qcBodyId AddCoincident(qcScene* scene, uint32_t count)
{
    static const float corners[3][3] = {{0.1f, 0.2f, 0.3f}, {1.1f, 0.25f, 0.35f}, {0.3f, 1.2f, 0.7f}};
    float* positions = malloc(count * sizeof corners);
    uint32_t* indices = malloc(3 * count * sizeof *indices);
    for (uint32_t i = 0; i < 3 * count; i++)
    {
        memcpy(positions + 3 * i, corners[(i + i / 3) % 3], sizeof corners[0]);
        indices[i] = i;
    }
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = positions;
    def.vertexCount = 3 * count;
    def.indices = indices;
    def.triangleCount = count;
    def.deforming = true;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    free(positions);
    free(indices);
    return id;
}

static size_t AllPairs(size_t count)
{
    return count * (count - 1) / 2;
}

static void CheckCoincident(qcDevice* device, qcMethod method)
{
    const uint32_t count = 300;
    qcScene* scene = qcMakeScene(device);
    AddCoincident(scene, count);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    for (def.threads = 1; def.threads <= 2; def.threads++)
    {
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_int_eq(result->profile.method, method);
        ck_assert_uint_eq(result->pairCount, AllPairs(count));
        for (size_t i = 0; i < result->pairCount; i++)
            ck_assert_int_eq(result->pairs[i].relation, qc_relationPenetrating);
    }
    qcScene_Destroy(scene);
}

START_TEST(all_pairs_of_coincident_triangles_penetrate)
{
    CheckCoincident(NULL, qc_methodSweep);
    CheckCoincident(NULL, qc_methodBrute);
    for (int kind = 0; kind < qc_testDeviceCount; kind++)
    {
        qcDevice* device = qcOpenOrSkip(qc_testKinds[kind]);
        if (device == NULL)
            continue;
        CheckCoincident(device, qc_methodLayers);
        qcDevice_Destroy(device);
    }
}
END_TEST

START_TEST(a_pair_takes_64_bytes)
{
    qcDetectDef def = qcDefaultDetectDef();
    for (def.threads = 1; def.threads <= 2; def.threads++)
    {
        qcScene* scene = qcMakeScene(NULL);
        AddCoincident(scene, 1500);
        size_t before = qcGetByteCount();
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_eq(result->pairCount, AllPairs(1500));
        ck_assert_uint_le((qcGetByteCount() - before) / result->pairCount, 64);
        qcScene_Destroy(scene);
    }
}
END_TEST

static void CheckLimit(qcScene* scene, qcDetectDef def, size_t pairs)
{
    const qcResult* result;
    for (def.threads = 1; def.threads <= 2; def.threads++)
    {
        def.maxPairs = pairs - 1;
        ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusTooManyPairs);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "pairs of triangles (qcDetectDef::maxPairs)"));
        def.maxPairs = 1;
        ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusTooManyPairs);
        def.maxPairs = pairs;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_eq(result->pairCount, pairs);
        def.maxPairs = 0;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_eq(result->pairCount, pairs);
    }
}

START_TEST(a_step_with_more_pairs_than_allowed_is_refused_and_the_next_one_works)
{
    // One large body; two; many tiny ones.
    for (int kind = 0; kind < 3; kind++)
    {
        const uint32_t count = 240, bodies = kind == 0 ? 1 : kind == 1 ? 2 : 60;
        qcScene* scene = qcMakeScene(NULL);
        for (uint32_t body = 0; body < bodies; body++)
            AddCoincident(scene, count / bodies);
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_gt(result->pairCount, count);
        size_t pairs = result->pairCount;
        CheckLimit(scene, def, pairs);
        def.margin = 0.1;
        CheckLimit(scene, def, pairs);
        def.margin = 0.0;
        def.method = qc_methodBrute;
        CheckLimit(scene, def, pairs);
        qcScene_Destroy(scene);
    }
}
END_TEST

START_TEST(pairs_for_contacts_count_too)
{
    qcScene* scene = qcMakeScene(NULL);
    AddCoincident(scene, 100);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.contactMargin = 0.01;
    def.maxPairs = AllPairs(100) - 1;
    const qcResult* result;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusTooManyPairs);
    def.maxPairs++;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_eq(result->pairCount, AllPairs(100));
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(the_device_keeps_the_limit_too)
{
    for (int kind = 0; kind < qc_testDeviceCount; kind++)
    {
        qcDevice* device = qcOpenOrSkip(qc_testKinds[kind]);
        if (device == NULL)
            continue;
        qcScene* scene = qcMakeScene(device);
        AddCoincident(scene, 100);
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodLayers;
        CheckLimit(scene, def, AllPairs(100));
        qcScene_Destroy(scene);
        qcDevice_Destroy(device);
    }
}
END_TEST

/// A body of `count` random triangles near a point of a grid.
static void AddTiny(qcScene* scene, qcRandom* random, float spacing, uint32_t place, uint32_t count)
{
    float positions[16][9];
    uint32_t indices[48];
    for (uint32_t t = 0; t < count; t++)
        for (uint32_t k = 0; k < 9; k++)
        {
            float corner = (float)(k % 3 == 0 ? place % 32 : k % 3 == 1 ? place / 32 % 32 : place / 1024);
            positions[t][k] = spacing * corner + 1.2f * (float)qcRandom_Uniform(random, 0.0, 1.0);
            indices[3 * t + k / 3] = 3 * t + k / 3;
        }
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = positions[0];
    def.vertexCount = 3 * count;
    def.indices = indices;
    def.triangleCount = count;
    def.deforming = place % 2 != 0;
    def.selfCollision = place % 3 != 0;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
}

START_TEST(a_body_of_one_triangle_takes_2048_bytes)
{
    qcRandom random = {1};
    qcScene* scene = qcMakeScene(NULL);
    for (uint32_t i = 0; i < 4096; i++)
        AddTiny(scene, &random, 0.75f, i, 1);
    qcDetectDef def = qcDefaultDetectDef();
    def.threads = 1;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_gt(result->pairCount, 500);
    ck_assert_uint_le(qcGetByteCount() / 4096, 2048);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(tiny_bodies_have_the_pairs_of_brute_force)
{
    // Alone, at the limit of bodies that the sweep takes without a BVH, and among larger ones.
    static const uint32_t sizes[4][2] = {{1, 1}, {1, 8}, {7, 9}, {1, 16}};
    for (int kind = 0; kind < 4; kind++)
    {
        qcRandom random = {(uint64_t)kind + 1};
        qcScene* scene = qcMakeScene(NULL);
        for (uint32_t i = 0; i < 300; i++)
            AddTiny(scene, &random, 0.4f, i,
                    sizes[kind][0] + qcRandom_Below(&random, sizes[kind][1] - sizes[kind][0] + 1));
        for (int margin = 0; margin < 2; margin++)
        {
            qcDetectDef def = qcDefaultDetectDef();
            def.margin = margin != 0 ? 0.02 : 0.0;
            def.contactMargin = def.margin;
            def.method = qc_methodBrute;
            qcPairList expected = qcDetectPairs(scene, &def);
            ck_assert_uint_gt(expected.count, 50);
            def.method = qc_methodSweep;
            qcPairList found = qcDetectPairs(scene, &def);
            qcCheckSamePairs(&expected, &found, "tiny bodies");
            free(expected.pairs);
            free(found.pairs);
        }
        qcScene_Destroy(scene);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("many pairs", all_pairs_of_coincident_triangles_penetrate, a_pair_takes_64_bytes,
             a_step_with_more_pairs_than_allowed_is_refused_and_the_next_one_works, pairs_for_contacts_count_too,
             the_device_keeps_the_limit_too, a_body_of_one_triangle_takes_2048_bytes,
             tiny_bodies_have_the_pairs_of_brute_force)
