// Certificates of motion against exact arithmetic: their directions in integers (GMP), and the triangles themselves at
// times k / 64, which are exact in double for these pairs.
#include "support/oracle.h"
#include "support/suite.h"
#include "triangle/motion_certificate.h"
#include "triangle/motion_claims.h"

#include <stdio.h>
#include <string.h>

enum
{
    qc_sampleStep = 4 ///< every fourth time, from a random one on; and half time and both ends
};

//  ---- what is claimed ---------------------------------------------------------------------------------------------

static bool MeetAtSampledTime(qcRandom* random, const Class* c, const Pair* pair)
{
    for (int t = 0; t < 2; t++)
        if (qcClaim_MeetElsewhere(pair->at[t], pair->common))
            return true;
    int first = 1 + (int)qcRandom_Below(random, qc_sampleStep);
    for (int k = first - qc_sampleStep; k < qc_times && !c->isOffLattice; k += qc_sampleStep)
    {
        double corners[qc_cornerCount][3];
        qcClaim_GetPositions(pair, k < 0 ? qc_times / 2 : k, corners);
        if (qcClaim_MeetElsewhere(corners, pair->common))
            return true;
    }
    return false;
}

static void Fail(const Class* c, const Pair* pair, const char* what)
{
    for (int t = 0; t < 2; t++)
        for (int i = 0; i < qc_cornerCount; i++)
            printf("%s %c%d: %a, %a, %a\n", t == 0 ? "start" : "end", "ab"[i / 3], i % 3, pair->at[t][i][0],
                   pair->at[t][i][1], pair->at[t][i][2]);
    ck_abort_msg("%s: %s", c->name, what);
}

/// A triangle of the pair, with its corners in another order, and their vertex indices.
static void GetTriangle(const Pair* pair, int first, uint32_t order, qcMovingTriangle* triangle, uint32_t indices[3])
{
    for (uint32_t c = 0; c < 3; c++)
    {
        // The first three orders keep the orientation, the others reverse it.
        int corner = (int)(order < 3 ? (c + order) % 3 : (order - c) % 3);
        memcpy(triangle->start[c], pair->at[0][first + corner], sizeof triangle->start[c]);
        memcpy(triangle->end[c], pair->at[1][first + corner], sizeof triangle->end[c]);
        indices[c] = (uint32_t)(corner < pair->common ? corner : first + corner);
    }
}

/// In any order of the corners and of the triangles.
static bool Certify(qcRandom* random, const Class* c, const Pair* pair)
{
    qcMovingTriangle a, b;
    uint32_t indicesA[3], indicesB[3];
    GetTriangle(pair, 0, qcRandom_Below(random, 6), &a, indicesA);
    GetTriangle(pair, 3, qcRandom_Below(random, 6), &b, indicesB);
    bool isReversed = qcRandom_Below(random, 2) == 0;
    bool apart = isReversed ? qcMotion_SeparatesNeighbours(&b, indicesB, &a, indicesA)
                            : qcMotion_SeparatesNeighbours(&a, indicesA, &b, indicesB);
    if (pair->common != 0)
        return apart;
    double direction[3];
    bool found = isReversed ? qcMotion_Separates(&b, &a, direction) : qcMotion_Separates(&a, &b, direction);
    if (found != apart)
        Fail(c, pair, "the result depends on whether a direction is required");
    for (int axis = 0; axis < 3 && isReversed; axis++)
        direction[axis] = -direction[axis];
    for (int t = 0; t < 2 && apart; t++)
        if (!qcClaim_IsAbove(direction, pair->at[t]))
            Fail(c, pair,
                 t == 0 ? "the direction doesn't separate the start" : "the direction doesn't separate the end");
    return apart;
}

//  ---- tests -------------------------------------------------------------------------------------------------------

static const Class s_classes[] = {
    {"random, float", MakeRandom, 16, 100.0, 0.0, {0, -10}, 0, false, 0.85},
    {"random, double", MakeRandom, 38, 100.0, 0.0, {0, -38}, 0, false, 0.85},
    {"turning", MakeTurning, 20, 1.0, 0.0, {0, -20}, 0, false, 0.83},
    {"coarse lattice", MakeCoarse, 1, 4.0, 0.0, {0, -1}, 0, false, 0.8},
    {"coplanar", MakeCoplanar, 16, 100.0, 0.0, {0, -16}, 0, false, 0.9},
    {"needles", MakeNeedles, 30, 10.0, 0.0, {0, -30}, 0, false, 0.9},
    {"touching at the end", MakeTouchingEnd, 38, 10.0, 0.0, {0, -38}, 0, false, 0.5},
    {"touching at the start", MakeTouchingStart, 20, 10.0, 0.0, {0, -20}, 0, false, 0.5},
    {"tiny gaps", MakeTinyGaps, 40, 1.0, 0.0, {0, -40}, 0, false, 0.9},
    {"tiny gaps, float", MakeTinyGaps, 20, 1.0, 0.0, {0, -20}, 0, false, 0.95},
    {"passing", MakePassing, 16, 100.0, 0.0, {0, -16}, 0, false, 0.8},
    {"layers in flight", MakeLayers, 16, 100.0, 0.0, {0, -16}, 0, false, 0.99},
    {"far away, float", MakeRandom, 4, 4.0, 1e6, {0, -4}, 0, false, 0.88},
    {"far away, double", MakeLayers, 22, 100.0, 1e6, {0, -22}, 0, false, 0.99},
    {"1e-20 and 1e20", MakeRandom, 20, 100.0, 0.0, {-86, 46}, 0, false, 0.85},
    {"1e-306 and 1e300", MakeLayers, 16, 100.0, 0.0, {-1036, 980}, 0, false, 0.99},
    {"touching midway", MakeTouchingMidway, 30, 10.0, 0.0, {0, -30}, 0, false, 0.0},
    {"any doubles", MakeAny, 0, 1.0, 0.0, {0, 0}, 0, true, 0.65},
    {"common vertex", MakeRandom, 16, 100.0, 0.0, {0, -16}, 1, false, 0.8},
    {"common edge", MakeRandom, 16, 100.0, 0.0, {0, -16}, 2, false, 0.7},
    {"common vertex, coarse", MakeCoarse, 1, 2.0, 0.0, {0, -1}, 1, false, 0.7},
    {"common edge, coarse", MakeCoarse, 1, 2.0, 0.0, {0, -1}, 2, false, 0.5},
    {"common vertex, folding", MakeFolding, 20, 10.0, 0.0, {0, -20}, 1, false, 0.75},
    {"common edge, folding", MakeFolding, 20, 10.0, 0.0, {0, -20}, 2, false, 0.55},
    {"common vertex, smooth", MakeSmooth, 22, 100.0, 0.0, {0, -22}, 1, false, 0.99},
    {"common edge, smooth", MakeSmooth, 22, 100.0, 0.0, {0, -22}, 2, false, 0.99},
    {"common vertex, far away", MakeSmooth, 22, 100.0, 1e6, {0, -80}, 1, false, 0.99},
};

enum
{
    qc_classCount = sizeof s_classes / sizeof s_classes[0],
    qc_firstNeighbours = 18
};

START_TEST(nothing_that_is_certified_meets)
{
    const Class* c = &s_classes[_i];
    qcRandom random = {1000 + (uint64_t)_i};
    int count = qcGetTestPairCount(300000) / qc_classCount, certified = 0, met = 0;
    for (int i = 0; i < count; i++)
    {
        Pair pair;
        MakePair(&random, c, &pair);
        bool apart = Certify(&random, c, &pair), meets = MeetAtSampledTime(&random, c, &pair);
        if (apart && meets)
            Fail(c, &pair, "a certified pair meets");
        certified += apart;
        met += meets;
    }
    printf("%-24s %9d pairs %9d certified %9d met %9d neither\n", c->name, count, certified, met,
           count - certified - met);
    ck_assert_int_ge(certified, (int)(c->minShare * (count - met)));
}
END_TEST

/// The corners lie on one line.
static bool IsDegenerate(const double triangle[3][3])
{
    return qcOracle_Orient2d(triangle[0], triangle[1], triangle[2], 0, 1) == 0 &&
           qcOracle_Orient2d(triangle[0], triangle[1], triangle[2], 1, 2) == 0 &&
           qcOracle_Orient2d(triangle[0], triangle[1], triangle[2], 2, 0) == 0;
}

START_TEST(the_test_for_neighbours_is_that_of_the_oracle)
{
    qcRandom random = {2000};
    int count = qcGetTestPairCount(300000) / 10, met[3] = {0, 0, 0}, apart[3] = {0, 0, 0};
    for (int i = 0; i < count; i++)
    {
        const Class* c = &s_classes[qc_firstNeighbours + qcRandom_Below(&random, qc_classCount - qc_firstNeighbours)];
        Pair pair;
        MakePair(&random, c, &pair);
        double at[qc_cornerCount][3];
        qcClaim_GetPositions(&pair, (int)qcRandom_Below(&random, 3) * qc_times / 2, at);
        const double(*corners)[3] = (const double(*)[3])at;
        if (IsDegenerate(corners) || IsDegenerate(corners + 3))
            continue;
        // The corners of the intersection are those of the common vertex or edge, or there are more.
        qcOracleAnswer answer;
        qcOracle_Intersect(corners, corners + 3, &answer);
        bool meets = answer.pointCount != c->common;
        ck_assert_int_eq(meets, qcClaim_MeetElsewhere(corners, c->common));
        (meets ? met : apart)[c->common]++;
    }
    for (int common = 1; common <= 2; common++)
    {
        ck_assert_int_gt(met[common], count / 100);
        ck_assert_int_gt(apart[common], count / 100);
    }
}
END_TEST

int main(void)
{
    TCase* tests = qcMakeCase("motion certificate");
    tcase_add_loop_test(tests, nothing_that_is_certified_meets, 0, qc_classCount);
    tcase_add_test(tests, the_test_for_neighbours_is_that_of_the_oracle);
    return qcRunCase("motion certificate", tests);
}
