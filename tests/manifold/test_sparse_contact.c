// Contact of fine meshes with a spacing: few points, of which one covers each near pair.
// plugin/docs/proofs/sparse_contact.md
#include "manifold/manifold_scenes.h"
#include "support/suite.h"

/// Two rigid soups, and a detection of their pairs with proximities.
typedef struct Contact
{
    qcManifoldScene all;
    qcScene* scene; ///< the same bodies, without proximities
} Contact;

static Contact MakeContact(const qcSoup* first, const qcSoup* second, double margin)
{
    Contact contact = {qcFindManifolds(first, second, qc_bodyRigid, margin, 1), qcMakeScene(NULL)};
    for (int i = 0; i < 2; i++)
    {
        qcBodyDef def = qcBodyDefOf(i == 0 ? first : second);
        qcBodyId id;
        def.deforming = false;
        def.selfCollision = false;
        CHECK_OK(qcScene_AddBody(contact.scene, &def, &id));
    }
    return contact;
}

static void Contact_Free(Contact* contact)
{
    qcManifoldScene_Free(&contact->all);
    qcScene_Destroy(contact->scene);
}

typedef struct Query
{
    double spacing;
    bool unoriented;
    uint32_t threads;
} Query;

static const qcResult* Detect(const Contact* contact, Query query)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.margin = contact->all.margin;
    def.touching = def.manifolds = true;
    def.spacing = query.spacing;
    def.unoriented = query.unoriented;
    def.threads = query.threads;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(contact->scene, &def, &result));
    return result;
}

/// A closed, bumpy ball of radius 1 on the plane z = height.
static qcSoup MakeBall(uint64_t seed, uint32_t level, double height)
{
    qcSoup ball = qcSoup_MakeSphere(level, 1.0);
    qcRandom random = {seed};
    for (uint32_t v = 0; v < ball.vertexCount; v++)
    {
        double scale = 1.0 + qcRandom_Uniform(&random, 0.0, 0.002);
        for (size_t axis = 0; axis < 3; axis++)
            ball.positions[3 * v + axis] *= scale;
    }
    qcSoup_Translate(&ball, 0.0, 0.0, 1.0 + height);
    return ball;
}

static bool HasPointNear(const qcResult* result, const qcProximity* pair, double distance, double reach)
{
    for (size_t i = 0; i < result->manifoldPointCount; i++)
    {
        const qcManifoldPoint* point = &result->manifoldPoints[i];
        double near = fmin(qcDistance3(point->pointA, pair->pointA), qcDistance3(point->pointB, pair->pointB));
        if (point->distance <= distance && near <= reach)
            return true;
    }
    return false;
}

/// Each near pair has a point no farther apart than itself, within four spacings.
static void CheckCovers(const Contact* contact, const qcResult* sparse, double spacing)
{
    const qcResult* all = contact->all.result;
    ck_assert_uint_gt(all->pairCount, 0);
    for (size_t i = 0; i < all->pairCount; i++)
        ck_assert_msg(
            HasPointNear(sparse, &all->proximities[i], all->proximities[i].distance * (1.0 + 1e-5), 4.0 * spacing),
            "pair %zu of %zu, %g apart, has no point", i, all->pairCount, all->proximities[i].distance);
}

START_TEST(every_near_pair_has_a_point_that_is_as_near)
{
    qcSoup ball = MakeBall((uint64_t)_i, 5, 0.004), floor = qcMakeRoughFloor((uint64_t)_i, _i % 2 ? 40 : 1, 0.0, 0.002);
    qcSoup_Translate(&floor, -0.5, -0.5, 0.0);
    const double spacings[] = {0.08, 0.15};
    for (int order = 0; order < 2; order++)
    {
        Contact contact = MakeContact(order ? &floor : &ball, order ? &ball : &floor, 0.03);
        for (int k = 0; k < 2; k++)
        {
            const qcResult* sparse = Detect(&contact, (Query){spacings[k], false, 1});
            ck_assert_uint_lt(sparse->manifoldPointCount, contact.all.result->manifoldPointCount);
            CheckCovers(&contact, sparse, spacings[k]);
        }
        Contact_Free(&contact);
    }
    qcSoup_Free(&ball);
    qcSoup_Free(&floor);
}
END_TEST

START_TEST(pairs_are_reported_as_without_a_spacing)
{
    qcSoup ball = MakeBall(1, 5, 0.004), floor = qcMakeFloor(30, -0.5, -0.5, 1.0);
    Contact contact = MakeContact(&ball, &floor, 0.03);
    const qcResult* sparse = Detect(&contact, (Query){0.1, false, 1});
    ck_assert_uint_eq(sparse->pairCount, contact.all.result->pairCount);
    ck_assert_mem_eq(sparse->pairs, contact.all.result->pairs, sparse->pairCount * sizeof(qcPair));
    Contact_Free(&contact);
    qcSoup_Free(&ball);
    qcSoup_Free(&floor);
}
END_TEST

START_TEST(finer_triangles_give_no_more_points)
{
    size_t counts[2];
    for (uint32_t finer = 0; finer < 2; finer++)
    {
        qcSoup ball = MakeBall(1, 5 + finer, 0.004), floor = qcMakeFloor(40u << finer, -0.5, -0.5, 1.0);
        Contact contact = MakeContact(&ball, &floor, 0.03);
        counts[finer] = Detect(&contact, (Query){0.08, false, 1})->manifoldPointCount;
        if (finer)
            ck_assert_uint_gt(contact.all.result->pairCount, 100 * counts[1]);
        Contact_Free(&contact);
        qcSoup_Free(&ball);
        qcSoup_Free(&floor);
    }
    ck_assert_msg(counts[1] < counts[0] * 3 / 2, "%zu points, then %zu", counts[0], counts[1]);
}
END_TEST

START_TEST(a_fine_sheet_in_a_slit_touches_both_walls)
{
    qcSoup sheet = qcMakeFloor(40, -0.5, -0.5, 1.0), walls = qcSoup_MakeSheets(2, 37, 0.02);
    qcSoup_Translate(&sheet, 0.0, 0.0, 0.008);
    qcSoup_Translate(&walls, -0.45, -0.45, 0.0);
    Contact contact = MakeContact(&sheet, &walls, 0.015);
    const qcResult* sparse = Detect(&contact, (Query){0.1, false, 1});
    size_t up = 0, down = 0;
    for (size_t i = 0; i < sparse->manifoldPointCount; i++)
    {
        const qcManifoldPoint* point = &sparse->manifoldPoints[i];
        up += point->normal[2] > 0.999 && fabs(point->distance - 0.008) < 1e-9;
        down += point->normal[2] < -0.999 && fabs(point->distance - 0.012) < 1e-9;
    }
    ck_assert_uint_gt(up, 50);
    ck_assert_uint_gt(down, 50);
    ck_assert_uint_lt(sparse->manifoldPointCount, contact.all.result->pairCount / 10);
    CheckCovers(&contact, sparse, 0.1);
    Contact_Free(&contact);
    qcSoup_Free(&sheet);
    qcSoup_Free(&walls);
}
END_TEST

/// All bytes but those of padding are compared: both results are of one scene.
static void CheckSameManifolds(const qcResult* result, const qcManifoldPoint* points, size_t count)
{
    ck_assert_uint_eq(result->manifoldPointCount, count);
    ck_assert_mem_eq(result->manifoldPoints, points, count * sizeof *points);
}

static qcManifoldPoint* CopyPoints(const qcResult* result)
{
    size_t size = result->manifoldPointCount * sizeof(qcManifoldPoint);
    qcManifoldPoint* copy = malloc(size);
    ck_assert(copy != NULL);
    memcpy(copy, result->manifoldPoints, size);
    return copy;
}

START_TEST(bodies_that_intersect_keep_all_their_points)
{
    qcSoup ball = MakeBall(1, 4, -0.01), floor = qcMakeFloor(30, -0.5, -0.5, 1.0);
    Contact contact = MakeContact(&ball, &floor, 0.03);
    const qcResult* result = Detect(&contact, (Query){0.0, false, 1});
    size_t count = result->manifoldPointCount;
    qcManifoldPoint* points = CopyPoints(result);
    CheckSameManifolds(Detect(&contact, (Query){0.2, false, 1}), points, count);
    free(points);
    Contact_Free(&contact);
    qcSoup_Free(&ball);
    qcSoup_Free(&floor);
}
END_TEST

START_TEST(unoriented_points_lie_along_the_shortest_differences)
{
    qcSoup ball = MakeBall(1, 5, -0.01), floor = qcMakeFloor(30, -0.5, -0.5, 1.0);
    Contact contact = MakeContact(&ball, &floor, 0.03);
    const qcResult* result = Detect(&contact, (Query){0.1, true, 1});
    size_t outside = 0, behind = 0;
    for (size_t i = 0; i < result->manifoldPointCount; i++)
    {
        const qcManifoldPoint* point = &result->manifoldPoints[i];
        ck_assert_double_ge(point->distance, 0.0);
        outside += point->normal[2] > 0.9;
        behind += point->normal[2] < -0.9;
    }
    ck_assert_uint_gt(outside, 0);
    ck_assert_uint_gt(behind, 0);
    Contact_Free(&contact);
    qcSoup_Free(&ball);
    qcSoup_Free(&floor);
}
END_TEST

START_TEST(threads_make_no_difference)
{
    qcSoup ball = MakeBall(1, 6, 0.004), floor = qcMakeFloor(60, -0.5, -0.5, 1.0);
    Contact contact = MakeContact(&ball, &floor, 0.03);
    const qcResult* result = Detect(&contact, (Query){0.05, false, 1});
    size_t count = result->manifoldPointCount;
    qcManifoldPoint* points = CopyPoints(result);
    CheckSameManifolds(Detect(&contact, (Query){0.05, false, 4}), points, count);
    free(points);
    Contact_Free(&contact);
    qcSoup_Free(&ball);
    qcSoup_Free(&floor);
}
END_TEST

START_TEST(a_spacing_that_is_no_length_is_refused)
{
    qcScene* scene = qcMakeScene(NULL);
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result;
    const double spacings[] = {-1.0, (double)NAN, (double)INFINITY};
    for (int i = 0; i < 3; i++)
    {
        def.spacing = spacings[i];
        ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "spacing"));
    }
    qcScene_Destroy(scene);
}
END_TEST

int main(void)
{
    TCase* testCase = qcMakeCase("sparse contact");
    tcase_add_loop_test(testCase, every_near_pair_has_a_point_that_is_as_near, 0, 6);
    tcase_add_test(testCase, pairs_are_reported_as_without_a_spacing);
    tcase_add_test(testCase, finer_triangles_give_no_more_points);
    tcase_add_test(testCase, a_fine_sheet_in_a_slit_touches_both_walls);
    tcase_add_test(testCase, bodies_that_intersect_keep_all_their_points);
    tcase_add_test(testCase, unoriented_points_lie_along_the_shortest_differences);
    tcase_add_test(testCase, threads_make_no_difference);
    tcase_add_test(testCase, a_spacing_that_is_no_length_is_refused);
    return qcRunCase("sparse contact", testCase);
}
