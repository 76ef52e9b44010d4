// A scene far from the origin is as exact as at the origin: coordinates on a lattice that doubles hold in both places
// give the same pairs and relations, by every method that does not miss. Single precision would lose them.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>
#include <stdio.h>

// The methods that never miss: with a device those that use it.
static const qcMethod s_methods[2][3] = {{qc_methodSweep, qc_methodBrute, qc_methodAuto},
                                         {qc_methodLayers, qc_methodAuto, qc_methodQuick}};

/// Integers with 20 bits behind the point and 24 before it: 44 of a double's 53.
static const double s_offsets[][3] = {{1e7, 0.0, 0.0}, {-1e7, 1e7, 9999999.0}, {0.0, 16777215.0, -1e7}};

enum
{
    qc_methodCount = sizeof s_methods[0] / sizeof s_methods[0][0],
    qc_offsetCount = sizeof s_offsets / sizeof s_offsets[0]
};

/// Rounds positions to the lattice of 2^-bits. A coarse one makes touching and coplanar pairs.
static void Snap(qcSoup* soup, int bits)
{
    for (uint32_t i = 0; i < 3 * soup->vertexCount; i++)
        soup->positions[i] = ldexp(nearbyint(ldexp(soup->positions[i], bits)), -bits);
}

typedef enum Way
{
    way_positions, ///< the vertices are far away
    way_transform, ///< floats near the origin, moved by the body's transform
    way_deforming, ///< the vertices are set afterwards
    way_count
} Way;

static qcSoup MakeSoup(uint64_t seed, int body)
{
    int bits = seed % 2 == 0 ? 20 : 4;
    qcSoup soup = body == 0   ? qcSoup_MakeRandom(seed, 150, 0.25)
                  : body == 1 ? qcSoup_MakeFoldedCloth(seed, 12, 0.01, 0.01)
                              : qcSoup_MakeDegenerate(seed, 100, 0.25, 0.4);
    Snap(&soup, bits);
    return soup;
}

static qcScene* MakeFarScene(qcDevice* device, uint64_t seed, const double offset[3], Way way)
{
    qcScene* scene = qcMakeScene(device);
    for (int body = 0; body < 3; body++)
    {
        qcSoup soup = MakeSoup(seed, body);
        qcBodyDef def = qcBodyDefOf(&soup);
        float* floats = malloc(3 * (size_t)soup.vertexCount * sizeof *floats);
        ck_assert_ptr_nonnull(floats);
        for (uint32_t i = 0; i < 3 * soup.vertexCount; i++)
            floats[i] = (float)soup.positions[i];
        qcBodyId id;
        if (way == way_transform)
        {
            def.positions = floats;
            def.positionType = qc_positionF32;
            memcpy(def.transform.translation, offset, 3 * sizeof(double));
        }
        else if (way == way_positions)
            qcSoup_Translate(&soup, offset[0], offset[1], offset[2]);
        def.deforming = way == way_deforming;
        CHECK_OK(qcScene_AddBody(scene, &def, &id));
        if (way == way_deforming)
        {
            qcSoup_Translate(&soup, offset[0], offset[1], offset[2]);
            CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
        }
        free(floats);
        qcSoup_Free(&soup);
    }
    return scene;
}

/// Compares the result at the origin with the one far away.
static void CheckSame(qcScene* near, qcScene* far, const qcDetectDef* def, const double offset[3], const char* what)
{
    qcDetectDef brute = *def;
    brute.method = qc_methodBrute;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(near, &brute, &result));
    qcPairList expected = {(qcPair*)result->pairs, result->pairCount};
    const qcProximity* proximities = result->proximities;
    ck_assert_uint_gt(expected.count, 100);

    CHECK_OK(qcScene_Detect(far, def, &result));
    qcPairList found = {(qcPair*)result->pairs, result->pairCount};
    qcCheckSamePairs(&expected, &found, what);
    for (size_t i = 0; proximities != NULL && i < found.count; i++)
    {
        const qcProximity *p = &proximities[i], *q = &result->proximities[i];
        // 1e7 leaves 2^-29 of a unit to a coordinate.
        ck_assert_msg(fabs(p->distance - q->distance) <= 1e-8 && fabs(p->depth - q->depth) <= 1e-8,
                      "%s: pair %zu: distance %.9g, depth %.9g, expected %.9g and %.9g", what, i, q->distance, q->depth,
                      p->distance, p->depth);
        for (int axis = 0; axis < 3 && p->distance > 0.0; axis++)
            ck_assert_msg(fabs(q->pointA[axis] - q->pointB[axis] - q->normal[axis] * q->distance) <= 1e-8 &&
                              fabs(q->pointA[axis] - offset[axis]) <= 4.0,
                          "%s: pair %zu: its points are not at its ends", what, i);
    }
}

/// All methods at all offsets, each reached in another way; with a device, which takes longer, at one of them.
static void CheckMethods(qcDevice* device, const qcDetectDef* given, uint64_t seed)
{
    const double origin[3] = {0.0, 0.0, 0.0};
    qcScene* near = MakeFarScene(NULL, seed, origin, way_positions);
    int first = device != NULL ? (int)(seed % qc_offsetCount) : 0;
    for (int offset = first; offset < (device != NULL ? first + 1 : qc_offsetCount); offset++)
    {
        Way way = (Way)(((uint64_t)offset + seed) % way_count);
        qcScene* far = MakeFarScene(device, seed, s_offsets[offset], way);
        for (int method = 0; method < qc_methodCount; method++)
        {
            qcDetectDef def = *given;
            def.method = s_methods[device != NULL][method];
            def.reliable = true;
            def.resolution = 256;
            char what[64];
            snprintf(what, sizeof what, "%s, way %d, offset %d, margin %g", qcMethod_Name(def.method), (int)way, offset,
                     def.margin);
            CheckSame(near, far, &def, s_offsets[offset], what);
        }
        qcScene_Destroy(far);
    }
    qcScene_Destroy(near);
}

static void CheckEverywhere(const qcDetectDef* given, uint64_t seed)
{
    CheckMethods(NULL, given, seed);
    QC_FOR_EACH_DEVICE(device)
    {
        CheckMethods(device, given, seed);
    }
}

START_TEST(ten_million_units_from_the_origin_the_pairs_and_relations_are_those_at_the_origin)
{
    for (uint64_t seed = 1; seed <= 2; seed++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        def.neighbours = seed == 2;
        CheckEverywhere(&def, seed);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(pairs_within_a_margin_are_those_at_the_origin)
{
    // On the lattice itself, so that pairs are exactly that far apart, and next to it.
    static const double s_margins[] = {0x1p-4, 0x1p-20, 0.0123456789, 0x1p-6 + 0x1p-50};
    for (uint64_t seed = 1; seed <= 4; seed++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.margin = s_margins[seed - 1];
        def.proximities = true;
        CheckEverywhere(&def, seed);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(single_precision_would_lose_these_pairs)
{
    qcSoup soup = MakeSoup(2, 0);
    qcSoup_Translate(&soup, 1e7, 1e7, 1e7);
    qcScene* scenes[2] = {qcMakeScene(NULL), qcMakeScene(NULL)};
    qcAddSoup(scenes[0], &soup);
    qcSoup_RoundToFloat(&soup);
    qcAddSoup(scenes[1], &soup);
    qcDetectDef def = qcDefaultDetectDef();
    qcPairList doubles = qcDetectPairs(scenes[0], &def), floats = qcDetectPairs(scenes[1], &def);
    ck_assert_uint_gt(doubles.count, 100);
    ck_assert_uint_ne(doubles.count, floats.count);
    free(doubles.pairs);
    free(floats.pairs);
    for (int i = 0; i < 2; i++)
        qcScene_Destroy(scenes[i]);
    qcSoup_Free(&soup);
}
END_TEST

QC_RUN_TESTS("far_away", ten_million_units_from_the_origin_the_pairs_and_relations_are_those_at_the_origin,
             pairs_within_a_margin_are_those_at_the_origin, single_precision_would_lose_these_pairs)
