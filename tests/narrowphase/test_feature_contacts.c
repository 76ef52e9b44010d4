// Contacts within a margin: each pair of features once, none missed, against a search over all features.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>

static double Dot(const double* a, const double* b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void Weighted(const qcSoup* soup, const uint32_t vertices[3], const double weights[3], double out[3])
{
    for (size_t axis = 0; axis < 3; axis++)
    {
        out[axis] = 0.0;
        for (int i = 0; i < 3; i++)
            out[axis] += weights[i] * soup->positions[3 * vertices[i] + axis];
    }
}

/// Distance of a vertex from a triangle, by dense search over barycentric coordinates refined around the best.
static double SampledDistance(const qcSoup* soup, uint32_t vertex, uint32_t triangle)
{
    const uint32_t* corner = soup->indices + 3 * triangle;
    double bestB = 0.3, bestC = 0.3, best = INFINITY, span = 1.0;
    for (int round = 0; round < 18; round++, span *= 0.35)
    {
        double centreB = bestB, centreC = bestC;
        for (int i = -6; i <= 6; i++)
            for (int j = -6; j <= 6; j++)
            {
                double b = fmin(fmax(centreB + span * i / 6, 0.0), 1.0);
                double c = fmin(fmax(centreC + span * j / 6, 0.0), 1.0 - b);
                double weights[3] = {1.0 - b - c, b, c}, point[3], d[3];
                Weighted(soup, corner, weights, point);
                for (size_t axis = 0; axis < 3; axis++)
                    d[axis] = point[axis] - soup->positions[3 * vertex + axis];
                if (Dot(d, d) < best)
                {
                    best = Dot(d, d);
                    bestB = b;
                    bestC = c;
                }
            }
    }
    return sqrt(best);
}

static bool HasVertex(const uint32_t* index, uint32_t vertex)
{
    return index[0] == vertex || index[1] == vertex || index[2] == vertex;
}

static const qcResult* DetectContacts(qcScene* scene, qcMethod method, double margin)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.contactMargin = margin;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    return result;
}

static size_t CountVertexFace(const qcResult* result, uint32_t vertex, const uint32_t* face)
{
    size_t count = 0;
    for (size_t i = 0; i < result->contactCount; i++)
        count += result->contacts[i].weightsA[0] == 1.0 && result->contacts[i].verticesA[0] == vertex &&
                 memcmp(result->contacts[i].verticesB, face, sizeof result->contacts[i].verticesB) == 0;
    return count;
}

START_TEST(every_vertex_near_a_face_is_reported_once)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 9, 0.02, 0.004);
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    double margin = 0.03;
    const qcResult* result = DetectContacts(scene, qc_methodSweep, margin);
    size_t near = 0;
    for (uint32_t vertex = 0; vertex < soup.vertexCount; vertex++)
        for (uint32_t triangle = 0; triangle < soup.triangleCount; triangle++)
        {
            const uint32_t* face = soup.indices + 3 * triangle;
            if (HasVertex(face, vertex))
                continue;
            double distance = SampledDistance(&soup, vertex, triangle);
            if (fabs(distance - margin) < 1e-6)
                continue; // too close to the margin for the sampled distance
            ck_assert_uint_eq(CountVertexFace(result, vertex, face), distance < margin);
            near += distance < margin;
        }
    ck_assert_uint_gt(near, 100);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(distance_normal_and_weights_agree_with_the_closest_points)
{
    qcSoup soup = qcSoup_MakeRandom(8, 300, 0.15);
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    const qcResult* result = DetectContacts(scene, qc_methodSweep, 0.05);
    ck_assert_uint_gt(result->contactCount, 200);
    size_t edges = 0;
    for (size_t i = 0; i < result->contactCount; i++)
    {
        const qcContact* contact = &result->contacts[i];
        double a[3], b[3], d[3];
        Weighted(&soup, contact->verticesA, contact->weightsA, a);
        Weighted(&soup, contact->verticesB, contact->weightsB, b);
        for (int axis = 0; axis < 3; axis++)
            d[axis] = a[axis] - b[axis];
        ck_assert_double_le(contact->distance, 0.05);
        ck_assert_double_eq_tol(sqrt(Dot(d, d)), contact->distance, 1e-12);
        ck_assert_double_eq_tol(Dot(d, contact->normal), contact->distance, 1e-12);
        ck_assert_double_eq_tol(Dot(contact->normal, contact->normal), 1.0, 1e-12);
        if (contact->weightsA[0] == 1.0)
            continue;
        edges++;
        // Between two edges the shortest way is perpendicular to both.
        for (int side = 0; side < 2; side++)
        {
            const uint32_t* v = side == 0 ? contact->verticesA : contact->verticesB;
            double along[3];
            for (size_t axis = 0; axis < 3; axis++)
                along[axis] = soup.positions[3 * v[1] + axis] - soup.positions[3 * v[0] + axis];
            ck_assert_double_eq_tol(Dot(d, along), 0.0, 1e-9);
        }
    }
    ck_assert_uint_gt(edges, 50);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(no_pair_of_edges_is_reported_twice)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 16, 0.02, 0.004);
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    const qcResult* result = DetectContacts(scene, qc_methodSweep, 0.03);
    for (size_t i = 0; i < result->contactCount; i++)
        for (size_t k = i + 1; k < result->contactCount; k++)
        {
            const qcContact *x = &result->contacts[i], *y = &result->contacts[k];
            if (x->weightsA[0] == 1.0 || y->weightsA[0] == 1.0)
                continue;
            uint32_t p[4] = {x->verticesA[0], x->verticesA[1], x->verticesB[0], x->verticesB[1]};
            uint32_t q[4] = {y->verticesA[0], y->verticesA[1], y->verticesB[0], y->verticesB[1]};
            size_t shared = 0;
            for (int a = 0; a < 4; a++)
                for (int b = 0; b < 4; b++)
                    shared += p[a] == q[b];
            bool sameFirst = (p[0] == q[0] && p[1] == q[1]) || (p[0] == q[1] && p[1] == q[0]) ||
                             (p[0] == q[2] && p[1] == q[3]) || (p[0] == q[3] && p[1] == q[2]);
            ck_assert(!(shared == 4 && sameFirst));
        }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

/// Each call uses a new scene: a method's first step with a body differs from its later ones.
static void CheckSameContacts(qcDevice* device, qcMethod method, const qcSoup soups[2], const qcContact* expected,
                              size_t count)
{
    qcScene* scene = qcMakeScene(device);
    qcAddSoup(scene, &soups[0]);
    qcAddSoup(scene, &soups[1]);
    for (uint32_t threads = 1; threads <= 4; threads++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.threads = threads;
        def.method = method;
        def.contactMargin = 0.02;
        def.touching = threads % 2 == 0; // so that the scene computes anew
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert(method == qc_methodAuto || result->profile.method == method);
        ck_assert_uint_eq(result->contactCount, count);
        ck_assert_int_eq(memcmp(result->contacts, expected, count * sizeof *expected), 0);
    }
    qcScene_Destroy(scene);
}

START_TEST(methods_and_threads_give_the_same_contacts_in_the_same_order)
{
    // Large enough for more than one thread to be used.
    qcSoup soups[2] = {qcSoup_MakeFoldedCloth(4, 52, 0.02, 0.01), qcSoup_MakeSphere(2, 0.1)};
    qcSoup_Translate(&soups[1], 0.5, 0.1, 0.0);
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soups[0]);
    qcAddSoup(scene, &soups[1]);
    const qcResult* result = DetectContacts(scene, qc_methodBrute, 0.02);
    size_t count = result->contactCount;
    ck_assert_uint_gt(count, 500);
    qcContact* expected = malloc(count * sizeof *expected);
    memcpy(expected, result->contacts, count * sizeof *expected);
    qcScene_Destroy(scene);
    CheckSameContacts(NULL, qc_methodSweep, soups, expected, count);
    QC_FOR_EACH_DEVICE(device)
    {
        CheckSameContacts(device, qc_methodLayers, soups, expected, count);
        CheckSameContacts(device, qc_methodAuto, soups, expected, count);
    }
    free(expected);
    qcSoup_Free(&soups[0]);
    qcSoup_Free(&soups[1]);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// A cloth, and a triangle so far away that both lie in a device's image, but the margin around the cloth leaves the
/// range of a BVH's coordinates: the device's neighbours are listed without a BVH.
START_TEST(neighbours_have_contacts_where_the_margin_leaves_the_range_of_bvhs)
{
    uint32_t indices[] = {0, 1, 2};
    double far = ldexp(1.0, 950), triangle[9] = {far, far, far, far, far, 0, far, 0, far};
    qcSoup soups[2] = {qcSoup_MakeFoldedCloth(4, 4, 0.02, 0.01), {triangle, 3, indices, 1}};
    qcDetectDef def = qcDefaultDetectDef();
    def.contactMargin = ldexp(1.0, 966);
    const qcResult *expected, *found;
    def.method = qc_methodBrute;
    qcScene* scene = qcMakeScene(NULL);
    for (int i = 0; i < 2; i++)
        qcAddSoup(scene, &soups[i]);
    CHECK_OK(qcScene_Detect(scene, &def, &expected));
    ck_assert_uint_gt(expected->contactCount, 100);
    def.method = qc_methodLayers;
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* other = qcMakeScene(device);
        for (int i = 0; i < 2; i++)
            qcAddSoup(other, &soups[i]);
        CHECK_OK(qcScene_Detect(other, &def, &found));
        ck_assert_int_eq(found->profile.method, qc_methodLayers);
        qcResultHash a = qcResult_Hash(expected), b = qcResult_Hash(found);
        ck_assert_mem_eq(&a, &b, sizeof a);
        qcScene_Destroy(other);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soups[0]);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(image_methods_refuse_a_contact_margin)
{
    qcScene* scene = qcMakeScene(NULL);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodQuick;
    def.contactMargin = 0.1;
    const qcResult* result;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusBadInput);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "contactMargin"));
    def.contactMargin = 0.0;
    def.margin = 0.1;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusBadInput);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "quick has a margin only if it is reliable"));
    def.margin = 0.0;
    def.method = qc_methodSweep;
    def.contactMargin = -1.0;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusBadInput);
    def.contactMargin = (double)NAN;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusBadInput);
    qcScene_Destroy(scene);
}
END_TEST

/// Contacts between two bodies of one triangle each.
static size_t CountBetween(qcMethod method, const double* a, const double* b, double margin)
{
    static const uint32_t indices[] = {0, 1, 2};
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = qcDefaultBodyDef();
    def.positionType = qc_positionF64;
    def.triangleCount = 1;
    qcBodyId id;
    def.positions = a;
    def.vertexCount = 3;
    def.indices = indices;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    def.positions = b;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    size_t count = DetectContacts(scene, method, margin)->contactCount;
    qcScene_Destroy(scene);
    return count;
}

START_TEST(a_vertex_on_a_sliver_is_in_contact)
{
    qcRandom random = {3};
    for (int exponent = 10; exponent <= 18; exponent++)
        for (int i = 0; i < 200; i++)
        {
            double width = pow(10.0, -exponent), place = qcRandom_Uniform(&random, 0.1, 0.9);
            double tilt = qcRandom_Uniform(&random, -1.0, 1.0), rise = qcRandom_Uniform(&random, -1.0, 1.0);
            double sliver[9] = {0, 0, 0, 1, tilt, rise, 0.4, 0.4 * tilt + width, 0.4 * rise};
            double spike[9] = {place, place * tilt, place * rise, place, 5, 5, place, 5, 6};
            ck_assert_uint_ge(CountBetween(qc_methodSweep, spike, sliver, 0.01), 1);
        }
}
END_TEST

START_TEST(nearly_parallel_edges_have_a_contact_where_they_cross)
{
    for (double angle = 1e-3; angle > 1e-12; angle /= 10)
    {
        double a[9] = {-1, 0, 0, 1, 0, 0, 0, 0, -3}, b[9] = {-1, -angle, angle / 100, 1, angle, angle / 100, 0, 0, 3};
        // The crossing is angle / 100 apart, the ends angle: only two edges are that close.
        ck_assert_uint_eq(CountBetween(qc_methodSweep, a, b, angle / 50), 1);
        ck_assert_uint_eq(CountBetween(qc_methodSweep, a, b, angle / 200), 0);
    }
}
END_TEST

START_TEST(methods_agree_at_the_margin_itself)
{
    // Rounded, the difference of the two is the margin, though their sum with it falls short.
    const double a = -0.56757292929057535, x = 0.94435921705577208, margin = 1.5119321463463473;
    double first[9] = {a, 0, 0, a, 1, 0, a, 0, 1}, second[9] = {x, 0.2, 0.2, x + 1, 3, 0, x + 1, 0, 3};
    ck_assert_uint_eq(CountBetween(qc_methodSweep, first, second, margin),
                      CountBetween(qc_methodBrute, first, second, margin));
    ck_assert_uint_ge(CountBetween(qc_methodSweep, first, second, margin), 1);
}
END_TEST

QC_RUN_TESTS("contacts", every_vertex_near_a_face_is_reported_once,
             distance_normal_and_weights_agree_with_the_closest_points, no_pair_of_edges_is_reported_twice,
             methods_and_threads_give_the_same_contacts_in_the_same_order,
             neighbours_have_contacts_where_the_margin_leaves_the_range_of_bvhs, image_methods_refuse_a_contact_margin,
             a_vertex_on_a_sliver_is_in_contact, nearly_parallel_edges_have_a_contact_where_they_cross,
             methods_agree_at_the_margin_itself)
