// Invariants of all manifolds, for any soup: every pair is covered, every point is of a reported pair, no point is
// there twice, and the result does not depend on how a shape is represented.
#define _POSIX_C_SOURCE 200809L // setenv

#include "manifold/manifold_scenes.h"
#include "support/suite.h"

//  ---- scenes --------------------------------------------------------------------------------------

typedef struct Case
{
    const char* name;
    qcBodyKind kind;
    double margin;
} Case;

static const Case s_cases[] = {
    {"random soup with itself", qc_bodyWithItself, 0.0},
    {"random soup with itself, margin", qc_bodyWithItself, 0.03},
    {"degenerate soup with itself, margin", qc_bodyWithItself, 0.03},
    {"two random soups, margin", qc_bodyDeforming, 0.05},
    {"balls apart", qc_bodyDeforming, 0.03},
    {"balls in each other", qc_bodyDeforming, 0.03},
    {"balls in each other, no margin", qc_bodyDeforming, 0.0},
    {"cloth, layers apart", qc_bodyWithItself, 0.006},
    {"cloth, tangled", qc_bodyWithItself, 0.003},
    {"box on a tilted floor", qc_bodyDeforming, 0.02},
    {"box in a tilted floor", qc_bodyDeforming, 0.02},
    {"rough floors, wide margin", qc_bodyDeforming, 0.2},
};

enum
{
    qc_caseCount = sizeof s_cases / sizeof s_cases[0]
};

/// The soups of a case; the second has no triangles where there is none.
static void MakeCase(int number, qcSoup soups[2])
{
    const qcSoup none = {NULL, 0, NULL, 0};
    soups[1] = none;
    switch (number)
    {
        case 0:
        case 1: soups[0] = qcSoup_MakeRandom(11, 250, 0.2); break;
        case 2: soups[0] = qcSoup_MakeDegenerate(12, 250, 0.2, 0.4); break;
        case 3:
            soups[0] = qcSoup_MakeRandom(13, 120, 0.3);
            soups[1] = qcSoup_MakeRandom(14, 150, 0.2);
            break;
        case 4:
        case 5:
        case 6:
            soups[0] = qcSoup_MakeSphere(4, 1.0);
            soups[1] = qcSoup_MakeSphere(3, 0.7);
            qcTurnSoup(&soups[1]);
            qcSoup_Translate(&soups[1], 0.4, 1.5, number == 4 ? 0.75 : 0.65);
            break;
        case 7:
        case 8: soups[0] = qcSoup_MakeFoldedCloth(15, 30, 0.004, number == 7 ? 0.0004 : 0.003); break;
        case 11:
            soups[0] = qcMakeRoughFloor(16, 9, 0.11, 0.1);
            soups[1] = qcMakeRoughFloor(17, 7, 0.0, 0.1);
            break;
        default:
            soups[0] = qcMakeBox(3);
            soups[1] = qcMakeFloor(9, -0.53, -0.47, 2.0);
            qcSoup_Translate(&soups[0], 0.0, 0.0, number == 9 ? 0.01 : -0.01);
            qcTurnSoup(&soups[0]);
            qcTurnSoup(&soups[1]);
            break;
    }
}

static void FreeCase(qcSoup soups[2])
{
    qcSoup_Free(&soups[0]);
    qcSoup_Free(&soups[1]);
}

static qcManifoldScene FindCase(int number, const qcSoup soups[2], uint32_t threads)
{
    return qcFindManifolds(&soups[0], soups[1].triangleCount != 0 ? &soups[1] : NULL, s_cases[number].kind,
                           s_cases[number].margin, threads);
}

static const qcSoup* SoupOf(const qcManifoldScene* m, uint32_t slot)
{
    return m->soups[slot];
}

static double LongestEdge(const qcSoup* soup, uint32_t triangle)
{
    double corner[3][3];
    qcSoup_GetTriangle(soup, triangle, corner);
    return fmax(fmax(qcDistance3(corner[0], corner[1]), qcDistance3(corner[1], corner[2])),
                qcDistance3(corner[2], corner[0]));
}

//  ---- points --------------------------------------------------------------------------------------

/// The pair of a point, or null. In a body with itself the sides may be exchanged.
static const qcPair* FindPair(const qcResult* result, const qcManifold* manifold, const qcManifoldPoint* point)
{
    qcPair pair = {manifold->bodyA, point->triangleA, manifold->bodyB, point->triangleB, qc_relationTouching};
    if (pair.bodyA == pair.bodyB && pair.triangleA > pair.triangleB)
    {
        pair.triangleA = point->triangleB;
        pair.triangleB = point->triangleA;
    }
    return bsearch(&pair, result->pairs, result->pairCount, sizeof(qcPair), qcComparePairs);
}

/// Distance of a point from a triangle by its nearest edge, or 0 if it is over and in the face.
static double DistanceFromTriangle(const qcSoup* soup, uint32_t triangle, const double point[3])
{
    double corner[3][3], corners[9], needle[9];
    qcSoup_GetTriangle(soup, triangle, corner);
    memcpy(corners, corner, sizeof corners);
    for (int i = 0; i < 9; i++)
        needle[i] = point[i % 3];
    qcProximity proximity;
    ck_assert(qcTrianglesWithin(corners, needle, 1e3, &proximity));
    return proximity.distance;
}

/// True if the distance is at most `limit`.
static bool IsNear(const qcSoup* soup, uint32_t triangle, const double point[3], double limit)
{
    const double* corner = soup->positions + 3 * (size_t)soup->indices[3 * (size_t)triangle];
    return qcDistance3(corner, point) <= LongestEdge(soup, triangle) + limit &&
           DistanceFromTriangle(soup, triangle, point) <= limit;
}

static bool IsFace(const uint32_t feature[2])
{
    return feature[0] == UINT32_MAX;
}

START_TEST(every_point_lies_on_the_two_triangles_of_a_reported_pair)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    const qcResult* result = m.result;
    size_t points = 0;
    for (size_t i = 0; i < result->manifoldCount; i++)
    {
        const qcManifold* manifold = &result->manifolds[i];
        ck_assert_uint_eq(manifold->firstPoint, points);
        ck_assert_uint_gt(manifold->pointCount, 0);
        ck_assert_uint_le(manifold->bodyA, manifold->bodyB);
        points += manifold->pointCount;
        for (uint32_t p = 0; p < manifold->pointCount; p++)
        {
            const qcManifoldPoint* point = &result->manifoldPoints[manifold->firstPoint + p];
            ck_assert_ptr_nonnull(FindPair(result, manifold, point));
            ck_assert_double_eq_tol(qcDot3(point->normal, point->normal), 1.0, 1e-12);
            ck_assert_double_le(point->distance, m.margin + 1e-8);
            for (int axis = 0; axis < 3; axis++)
                ck_assert_double_eq_tol(point->pointA[axis] - point->pointB[axis],
                                        point->distance * point->normal[axis], 1e-7);
            // A point without features has the pair's closest points, perhaps along another normal.
            double off = IsFace(point->featureA) && IsFace(point->featureB) ? m.margin : 1e-9;
            ck_assert_double_le(DistanceFromTriangle(SoupOf(&m, manifold->bodyA), point->triangleA, point->pointA),
                                off);
            ck_assert_double_le(DistanceFromTriangle(SoupOf(&m, manifold->bodyB), point->triangleB, point->pointB),
                                off);
        }
    }
    ck_assert_uint_eq(points, result->manifoldPointCount);
    ck_assert_uint_gt(points, 5);
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

START_TEST(points_are_sorted_deepest_first)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    for (size_t i = 0; i < m.result->manifoldCount; i++)
    {
        const qcManifold* manifold = &m.result->manifolds[i];
        const qcManifoldPoint* points = m.result->manifoldPoints + manifold->firstPoint;
        for (uint32_t p = 1; p < manifold->pointCount; p++)
            if (!(points[p - 1].distance <= points[p].distance))
                ck_abort_msg("point %u is %.17g deep, the one before it %.17g", p, -points[p].distance,
                             -points[p - 1].distance);
    }
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

static bool HasVertex(const uint32_t* triangle, uint32_t v)
{
    return triangle[0] == v || triangle[1] == v || triangle[2] == v;
}

static void CheckFeature(const qcSoup* soup, uint32_t triangle, const uint32_t feature[2], const double point[3])
{
    const uint32_t* corner = soup->indices + 3 * (size_t)triangle;
    if (IsFace(feature))
        return;
    ck_assert_uint_le(feature[0], feature[1]);
    ck_assert(HasVertex(corner, feature[0]) && HasVertex(corner, feature[1]));
    const double *a = soup->positions + 3 * (size_t)feature[0], *b = soup->positions + 3 * (size_t)feature[1];
    // On the segment between the two: the way over the point is no longer.
    double detour = qcDistance3(a, point) + qcDistance3(point, b) - qcDistance3(a, b);
    ck_assert_double_le(detour, 1e-12);
}

START_TEST(every_point_lies_on_the_features_that_it_names)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    for (size_t i = 0; i < m.result->manifoldCount; i++)
    {
        const qcManifold* manifold = &m.result->manifolds[i];
        for (uint32_t p = 0; p < manifold->pointCount; p++)
        {
            const qcManifoldPoint* point = &m.result->manifoldPoints[manifold->firstPoint + p];
            CheckFeature(SoupOf(&m, manifold->bodyA), point->triangleA, point->featureA, point->pointA);
            CheckFeature(SoupOf(&m, manifold->bodyB), point->triangleB, point->featureB, point->pointB);
        }
    }
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

START_TEST(no_two_points_of_one_normal_are_at_one_place)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    const qcResult* result = m.result;
    for (size_t i = 0; i < result->manifoldCount; i++)
    {
        const qcManifold* manifold = &result->manifolds[i];
        const qcManifoldPoint* points = result->manifoldPoints + manifold->firstPoint;
        // The promise is about the mean of the region; this tests 1/64 of its smallest triangle.
        double apart = INFINITY;
        for (uint32_t p = 0; p < manifold->pointCount; p++)
        {
            apart = fmin(apart, LongestEdge(SoupOf(&m, manifold->bodyA), points[p].triangleA) / 65.0);
            apart = fmin(apart, LongestEdge(SoupOf(&m, manifold->bodyB), points[p].triangleB) / 65.0);
        }
        for (uint32_t p = 0; p < manifold->pointCount && manifold->pointCount < 3000; p++)
            for (uint32_t q = 0; q < p; q++)
                ck_assert(qcDistance3(points[p].pointA, points[q].pointA) > apart * 0.2 ||
                          qcDistance3(points[p].pointB, points[q].pointB) > apart * 0.2 ||
                          qcDot3(points[p].normal, points[q].normal) < 0.866);
        for (uint32_t p = 1; p < manifold->pointCount; p++)
            ck_assert_double_le(points[p - 1].distance, points[p].distance + 1e-7);
    }
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

//  ---- pairs ---------------------------------------------------------------------------------------

static bool AreSameOrNeighbours(const qcSoup* soup, uint32_t s, uint32_t t)
{
    double p[3][3], q[3][3];
    qcSoup_GetTriangle(soup, s, p);
    qcSoup_GetTriangle(soup, t, q);
    for (int i = 0; i < 9; i++)
        if (memcmp(p[i / 3], q[i % 3], sizeof p[0]) == 0)
            return true;
    return s == t;
}

/// True if a point is of this pair or an adjacent one, or lies within `near` of one of the pair's triangles.
static bool HasPointOf(const qcManifoldScene* m, const qcPair* pair, const qcManifold* manifold,
                       const qcManifoldPoint* point, double near)
{
    const qcSoup *a = SoupOf(m, pair->bodyA), *b = SoupOf(m, pair->bodyB);
    if (manifold->bodyA != pair->bodyA || manifold->bodyB != pair->bodyB)
        return false;
    bool swaps = pair->bodyA == pair->bodyB;
    for (int swap = 0; swap <= swaps; swap++)
    {
        uint32_t first = swap ? point->triangleB : point->triangleA;
        uint32_t second = swap ? point->triangleA : point->triangleB;
        if (AreSameOrNeighbours(a, pair->triangleA, first) && AreSameOrNeighbours(b, pair->triangleB, second))
            return true;
        const double *p = swap ? point->pointB : point->pointA, *q = swap ? point->pointA : point->pointB;
        if (IsNear(a, pair->triangleA, p, near) || IsNear(b, pair->triangleB, q, near))
            return true;
    }
    return false;
}

static bool HasPoint(const qcManifoldScene* m, const qcPair* pair, double near)
{
    const qcResult* result = m->result;
    for (size_t k = 0; k < result->manifoldCount; k++)
        for (uint32_t p = 0; p < result->manifolds[k].pointCount; p++)
            if (HasPointOf(m, pair, &result->manifolds[k], &result->manifoldPoints[result->manifolds[k].firstPoint + p],
                           near))
                return true;
    return false;
}

/// True if a closer pair shares one of the two triangles, and its other triangle contains this pair's closest point.
static bool IsNoLocalMinimum(const qcManifoldScene* m, size_t index)
{
    const qcPair* pair = &m->result->pairs[index];
    const qcProximity* proximity = &m->result->proximities[index];
    for (size_t i = 0; i < m->result->pairCount; i++)
    {
        const qcPair* other = &m->result->pairs[i];
        if (other->bodyA != pair->bodyA || other->bodyB != pair->bodyB ||
            m->result->proximities[i].distance >= proximity->distance)
            continue;
        if ((other->triangleA == pair->triangleA &&
             IsNear(SoupOf(m, pair->bodyB), other->triangleB, proximity->pointB, 1e-12)) ||
            (other->triangleB == pair->triangleB &&
             IsNear(SoupOf(m, pair->bodyA), other->triangleA, proximity->pointA, 1e-12)))
            return true;
    }
    return false;
}

START_TEST(every_pair_is_covered)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    const qcResult* result = m.result;
    // A point that represents another one lies within 1/64 of the size of the region's triangles of one of its ends.
    double longest = 0.0;
    for (int i = 0; i < 2; i++)
        for (uint32_t t = 0; t < soups[i].triangleCount; t++)
            longest = fmax(longest, LongestEdge(&soups[i], t));
    for (size_t i = 0; i < result->pairCount; i++)
    {
        const qcPair* pair = &result->pairs[i];
        bool seam = pair->relation == qc_relationTouching && pair->bodyA == pair->bodyB &&
                    AreSameOrNeighbours(&soups[pair->bodyA], pair->triangleA, pair->triangleB);
        ck_assert_msg(seam || HasPoint(&m, pair, longest / 64.0) || IsNoLocalMinimum(&m, i),
                      "%s: pair %zu (%u %u %u %u, %s) has no point", s_cases[_i].name, i, pair->bodyA, pair->triangleA,
                      pair->bodyB, pair->triangleB, qcRelation_Name(pair->relation));
    }
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

START_TEST(the_deepest_point_is_no_shallower_than_the_deepest_pair)
{
    // Each pair alone has its minimum depth over all directions; no common normal gives less.
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    const qcResult* result = m.result;
    double deepest = 0.0, claimed = 0.0;
    bool apart = true;
    for (size_t i = 0; i < result->pairCount; i++)
    {
        deepest = fmax(deepest, result->proximities[i].depth);
        apart = apart && result->pairs[i].relation == qc_relationNear;
    }
    for (size_t i = 0; i < result->manifoldPointCount; i++)
        claimed = fmax(claimed, -result->manifoldPoints[i].distance);
    ck_assert_double_ge(claimed, deepest - 1e-9);
    // Where all pairs are separated no point penetrates.
    if (apart)
        ck_assert_double_le(claimed, 1e-9);
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

//  ---- other representations -----------------------------------------------------------------------

/// Each point of the first result is in the second one, its normal times `sign`, its sides exchanged if that is -1.
static void CheckCounterparts(const qcResult* of, const qcResult* in, double sign, double tolerance, const char* what)
{
    for (size_t i = 0; i < of->manifoldPointCount; i++)
    {
        const qcManifoldPoint* p = &of->manifoldPoints[i];
        bool found = false;
        for (size_t k = 0; k < in->manifoldPointCount && !found; k++)
        {
            const qcManifoldPoint* q = &in->manifoldPoints[k];
            found = qcDistance3(p->pointA, sign > 0.0 ? q->pointA : q->pointB) <= tolerance &&
                    qcDistance3(p->pointB, sign > 0.0 ? q->pointB : q->pointA) <= tolerance &&
                    fabs(p->distance - q->distance) <= tolerance &&
                    sign * qcDot3(p->normal, q->normal) >= 1.0 - tolerance - 1e-15;
        }
        ck_assert_msg(found, "%s: point %zu of %zu, at %g %g %g, distance %g, has no counterpart", what, i,
                      of->manifoldPointCount, p->pointA[0], p->pointA[1], p->pointA[2], p->distance);
    }
}

START_TEST(points_do_not_depend_on_windings)
{
    qcSoup soups[2], flipped[2];
    MakeCase(_i, soups);
    MakeCase(_i, flipped);
    qcFlipSome(&flipped[0], 21);
    qcFlipSome(&flipped[1], 22);
    qcManifoldScene m = FindCase(_i, soups, 1), n = FindCase(_i, flipped, 1);
    ck_assert_uint_eq(m.result->manifoldCount, n.result->manifoldCount);
    ck_assert_uint_eq(m.result->manifoldPointCount, n.result->manifoldPointCount);
    CheckCounterparts(m.result, n.result, 1.0, 1e-9, s_cases[_i].name);
    qcManifoldScene_Free(&m);
    qcManifoldScene_Free(&n);
    FreeCase(soups);
    FreeCase(flipped);
}
END_TEST

START_TEST(points_do_not_depend_on_shared_indices)
{
    qcSoup soups[2], alone[2];
    // Not a body with itself: neighbours without shared vertices would be pairs.
    if (s_cases[_i].kind == qc_bodyWithItself)
        return;
    MakeCase(_i, soups);
    MakeCase(_i, alone);
    qcUnshare(&alone[0]);
    qcUnshare(&alone[1]);
    qcManifoldScene m = FindCase(_i, soups, 1), n = FindCase(_i, alone, 1);
    ck_assert_uint_eq(m.result->manifoldCount, n.result->manifoldCount);
    ck_assert_uint_eq(m.result->manifoldPointCount, n.result->manifoldPointCount);
    CheckCounterparts(m.result, n.result, 1.0, 1e-15, s_cases[_i].name);
    qcManifoldScene_Free(&m);
    qcManifoldScene_Free(&n);
    FreeCase(soups);
    FreeCase(alone);
}
END_TEST

START_TEST(exchanging_the_bodies_negates_the_normals)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    if (soups[1].triangleCount != 0)
    {
        qcManifoldScene m = FindCase(_i, soups, 1);
        qcManifoldScene n = qcFindManifolds(&soups[1], &soups[0], s_cases[_i].kind, s_cases[_i].margin, 1);
        ck_assert_uint_eq(m.result->manifoldCount, n.result->manifoldCount);
        ck_assert_uint_eq(m.result->manifoldPointCount, n.result->manifoldPointCount);
        CheckCounterparts(m.result, n.result, -1.0, 1e-9, s_cases[_i].name);
        qcManifoldScene_Free(&m);
        qcManifoldScene_Free(&n);
    }
    FreeCase(soups);
}
END_TEST

static void CheckSame(const qcResult* m, const qcResult* n)
{
    ck_assert_uint_eq(m->manifoldCount, n->manifoldCount);
    ck_assert_uint_eq(m->manifoldPointCount, n->manifoldPointCount);
    ck_assert_mem_eq(m->manifolds, n->manifolds, m->manifoldCount * sizeof(qcManifold));
    ck_assert_mem_eq(m->manifoldPoints, n->manifoldPoints, m->manifoldPointCount * sizeof(qcManifoldPoint));
}

START_TEST(points_do_not_depend_on_the_number_of_threads)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    for (uint32_t threads = 2; threads <= 8; threads *= 4)
    {
        qcManifoldScene n = FindCase(_i, soups, threads);
        CheckSame(m.result, n.result);
        qcManifoldScene_Free(&n);
    }
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

START_TEST(points_do_not_depend_on_the_instruction_set)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    setenv("QC_KERNELS", "plain", 1);
    qcManifoldScene n = FindCase(_i, soups, 1);
    CheckSame(m.result, n.result);
    unsetenv("QC_KERNELS");
    qcManifoldScene_Free(&n);
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

START_TEST(a_second_step_gives_the_points_of_the_first)
{
    qcSoup soups[2];
    MakeCase(_i, soups);
    qcManifoldScene m = FindCase(_i, soups, 1);
    size_t bytes = m.result->manifoldPointCount * sizeof(qcManifoldPoint);
    qcManifoldPoint* points = malloc(bytes);
    memcpy(points, m.result->manifoldPoints, bytes);
    const qcBodyId first = {0, 1};
    CHECK_OK(qcScene_SetVertices(m.scene, first, soups[0].positions, qc_positionF64, 0));
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.margin = s_cases[_i].margin;
    def.touching = def.manifolds = true;
    CHECK_OK(qcScene_Detect(m.scene, &def, &m.result));
    ck_assert_ptr_null(m.result->proximities); // not requested
    ck_assert_uint_eq(m.result->manifoldPointCount * sizeof(qcManifoldPoint), bytes);
    ck_assert_mem_eq(m.result->manifoldPoints, points, bytes);
    def.manifolds = false;
    CHECK_OK(qcScene_Detect(m.scene, &def, &m.result));
    ck_assert_uint_eq(m.result->manifoldCount, 0);
    ck_assert_uint_eq(m.result->manifoldPointCount, 0);
    free(points);
    qcManifoldScene_Free(&m);
    FreeCase(soups);
}
END_TEST

int main(void)
{
    const TTest* const tests[] = {every_point_lies_on_the_two_triangles_of_a_reported_pair,
                                  points_are_sorted_deepest_first,
                                  every_point_lies_on_the_features_that_it_names,
                                  no_two_points_of_one_normal_are_at_one_place,
                                  every_pair_is_covered,
                                  the_deepest_point_is_no_shallower_than_the_deepest_pair,
                                  points_do_not_depend_on_windings,
                                  points_do_not_depend_on_shared_indices,
                                  exchanging_the_bodies_negates_the_normals,
                                  points_do_not_depend_on_the_number_of_threads,
                                  points_do_not_depend_on_the_instruction_set,
                                  a_second_step_gives_the_points_of_the_first};
    TCase* testCase = qcMakeCase("manifold rules");
    for (size_t i = 0; i < sizeof tests / sizeof tests[0]; i++)
        tcase_add_loop_test(testCase, tests[i], 0, qc_caseCount);
    return qcRunCase("manifold rules", testCase);
}
