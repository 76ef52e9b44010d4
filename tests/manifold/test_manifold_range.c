// Manifolds of scenes of any size: scaled by a power of two, a scene gives the same points, scaled.
#include "manifold/manifold_scenes.h"
#include "support/suite.h"

typedef struct Case
{
    const char* name;
    qcBodyKind kind;
    double margin;
} Case;

static const Case s_cases[] = {
    {"two random soups", qc_bodyDeforming, 0.05},    {"degenerate soup with itself", qc_bodyWithItself, 0.03},
    {"balls in each other", qc_bodyDeforming, 0.03}, {"cloth, tangled", qc_bodyWithItself, 0.003},
    {"box in a tilted floor", qc_bodyRigid, 0.02},
};

enum
{
    qc_caseCount = sizeof s_cases / sizeof s_cases[0]
};

static void MakeCase(int number, qcSoup soups[2])
{
    const qcSoup none = {NULL, 0, NULL, 0};
    soups[1] = none;
    switch (number)
    {
        case 0:
            soups[0] = qcSoup_MakeRandom(13, 120, 0.3);
            soups[1] = qcSoup_MakeRandom(14, 150, 0.2);
            break;
        case 1: soups[0] = qcSoup_MakeDegenerate(12, 250, 0.2, 0.4); break;
        case 2:
            soups[0] = qcSoup_MakeSphere(3, 1.0);
            soups[1] = qcSoup_MakeSphere(2, 0.7);
            qcTurnSoup(&soups[1]);
            qcSoup_Translate(&soups[1], 0.4, 1.5, 0.65);
            break;
        case 3: soups[0] = qcSoup_MakeFoldedCloth(15, 20, 0.004, 0.003); break;
        default:
            soups[0] = qcMakeBox(3);
            soups[1] = qcMakeFloor(9, -0.53, -0.47, 2.0);
            qcSoup_Translate(&soups[0], 0.0, 0.0, -0.01);
            qcTurnSoup(&soups[0]);
            qcTurnSoup(&soups[1]);
            break;
    }
    // Rounded to 32 bits: exact down to the smallest numbers of the tests.
    qcSoup_RoundToFloat(&soups[0]);
    qcSoup_RoundToFloat(&soups[1]);
}

static bool IsScaled(double found, double expected, int exponent)
{
    return found == ldexp(expected, exponent);
}

static void CheckPoint(const qcManifoldPoint* found, const qcManifoldPoint* expected, int exponent)
{
    bool same = found->triangleA == expected->triangleA && found->triangleB == expected->triangleB &&
                memcmp(found->featureA, expected->featureA, sizeof found->featureA) == 0 &&
                memcmp(found->featureB, expected->featureB, sizeof found->featureB) == 0 &&
                IsScaled(found->distance, expected->distance, exponent);
    for (int axis = 0; axis < 3; axis++)
        same = same && found->normal[axis] == expected->normal[axis] &&
               IsScaled(found->pointA[axis], expected->pointA[axis], exponent) &&
               IsScaled(found->pointB[axis], expected->pointB[axis], exponent);
    if (!same)
        ck_abort_msg("2^%d: triangles %u and %u at distance %g, expected %u and %u at %g", exponent, found->triangleA,
                     found->triangleB, found->distance, expected->triangleA, expected->triangleB,
                     ldexp(expected->distance, exponent));
}

START_TEST(a_scene_scaled_by_a_power_of_two_gives_the_same_points_scaled)
{
    static const int exponents[] = {-900, -700, -500, -300, -270, -200, -130, -64, -10, 10,
                                    64,   130,  200,  270,  300,  500,  700,  900, 1000};
    const Case* sought = &s_cases[_i];
    qcSoup soups[2], scaled[2];
    MakeCase(_i, soups);
    qcManifoldScene m =
        qcFindManifolds(&soups[0], soups[1].triangleCount != 0 ? &soups[1] : NULL, sought->kind, sought->margin, 1);
    ck_assert_uint_gt(m.result->manifoldPointCount, 3);
    for (size_t e = 0; e < sizeof exponents / sizeof exponents[0]; e++)
    {
        MakeCase(_i, scaled);
        double scale = ldexp(1.0, exponents[e]);
        qcScaleSoup(&scaled[0], scale, scale, scale);
        qcScaleSoup(&scaled[1], scale, scale, scale);
        qcManifoldScene n = qcFindManifolds(&scaled[0], scaled[1].triangleCount != 0 ? &scaled[1] : NULL, sought->kind,
                                            ldexp(sought->margin, exponents[e]), 1);
        if (n.result->manifoldPointCount != m.result->manifoldPointCount)
            ck_abort_msg("%s, 2^%d: %zu points, expected %zu", sought->name, exponents[e], n.result->manifoldPointCount,
                         m.result->manifoldPointCount);
        ck_assert_uint_eq(n.result->manifoldCount, m.result->manifoldCount);
        ck_assert_mem_eq(n.result->manifolds, m.result->manifolds, m.result->manifoldCount * sizeof(qcManifold));
        for (size_t i = 0; i < m.result->manifoldPointCount; i++)
            CheckPoint(&n.result->manifoldPoints[i], &m.result->manifoldPoints[i], exponents[e]);
        qcManifoldScene_Free(&n);
        qcSoup_Free(&scaled[0]);
        qcSoup_Free(&scaled[1]);
    }
    qcManifoldScene_Free(&m);
    qcSoup_Free(&soups[0]);
    qcSoup_Free(&soups[1]);
}
END_TEST

/// The soup scaled to this size, and a triangle at the given height far from it, over the corner (1, 1).
static qcSoup MakeSmallBesideLarge(const qcSoup* soup, double scale, double size, double height)
{
    qcSoup both = qcMakeEmptySoup(soup->vertexCount + 3, soup->triangleCount + 1);
    for (uint32_t i = 0; i < 3 * soup->vertexCount; i++)
        both.positions[i] = soup->positions[i] * scale;
    const double corners[9] = {1.0, 1.0, height, 0.5, 1.0, height, 1.0, 0.5, height};
    for (int i = 0; i < 9; i++)
        both.positions[3 * (size_t)soup->vertexCount + (size_t)i] = corners[i] * size;
    memcpy(both.indices, soup->indices, 3 * sizeof(uint32_t) * soup->triangleCount);
    for (uint32_t c = 0; c < 3; c++)
        both.indices[3 * (size_t)soup->triangleCount + c] = soup->vertexCount + c;
    return both;
}

START_TEST(triangles_far_smaller_than_the_largest_coordinate_have_correct_points)
{
    // The hardest sizes: the last ones that are not scaled, the smallest and the largest of all.
    static const double sizes[] = {0x1p-64, 0x1p64, 0x1p-800, 0x1p1000};
    double size = sizes[_i], scale = size * 1e-50;
    qcSoup soups[2], both[2];
    MakeCase(0, soups);
    for (int b = 0; b < 2; b++)
        both[b] = MakeSmallBesideLarge(&soups[b], scale, size, 0.01 * b);
    qcManifoldScene m = qcFindManifolds(&both[0], &both[1], qc_bodyDeforming, 0.02 * size, 1);
    size_t small = 0;
    for (size_t i = 0; i < m.result->manifoldPointCount; i++)
    {
        const qcManifoldPoint* point = &m.result->manifoldPoints[i];
        ck_assert_double_eq_tol(qcDot3(point->normal, point->normal), 1.0, 1e-12);
        if (point->triangleA >= soups[0].triangleCount)
            continue;
        small++;
        for (int axis = 0; axis < 3; axis++)
            if (!(fabs(point->pointA[axis] - point->pointB[axis] - point->distance * point->normal[axis]) <=
                  1e-9 * scale))
                ck_abort_msg("point %zu: ends are off by more than its distance", i);
    }
    ck_assert_uint_gt(small, 500);
    qcManifoldScene_Free(&m);
    for (int b = 0; b < 2; b++)
    {
        qcSoup_Free(&soups[b]);
        qcSoup_Free(&both[b]);
    }
}
END_TEST

int main(void)
{
    TCase* testCase = qcMakeCase("manifold range");
    tcase_add_loop_test(testCase, a_scene_scaled_by_a_power_of_two_gives_the_same_points_scaled, 0, qc_caseCount);
    tcase_add_loop_test(testCase, triangles_far_smaller_than_the_largest_coordinate_have_correct_points, 0, 4);
    return qcRunCase("manifold range", testCase);
}
