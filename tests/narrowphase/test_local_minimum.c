// Contacts of a deforming body with a rigid one where only the rigid body's nearest points count, and bodies' margins.
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>

typedef struct Contacts
{
    qcContact* contacts;
    size_t count;
} Contacts;

/// Returns a copy of the contacts between two bodies, the first of which deforms.
static Contacts Find(const qcSoup* soft, const qcSoup* rigid, double margin, bool nearest)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = qcBodyDefOf(soft);
    def.deforming = true;
    def.selfCollision = false;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    def = qcBodyDefOf(rigid);
    def.selfCollision = false;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    qcDetectDef detect = qcDefaultDetectDef();
    detect.contactMargin = margin;
    detect.nearestContacts = nearest;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    Contacts found = {malloc((result->contactCount + 1) * sizeof(qcContact)), result->contactCount};
    memcpy(found.contacts, result->contacts, found.count * sizeof(qcContact));
    qcScene_Destroy(scene);
    return found;
}

static bool IsVertexOfSoft(const qcContact* contact)
{
    return contact->bodyA == 0 && contact->weightsA[0] == 1.0;
}

static double NearestOf(const Contacts* found, uint32_t vertex)
{
    double nearest = INFINITY;
    for (size_t i = 0; i < found->count; i++)
        if (IsVertexOfSoft(&found->contacts[i]) && found->contacts[i].verticesA[0] == vertex)
            nearest = fmin(nearest, found->contacts[i].distance);
    return nearest;
}

static double NearestOfAll(const Contacts* found)
{
    double nearest = INFINITY;
    for (size_t i = 0; i < found->count; i++)
        nearest = fmin(nearest, found->contacts[i].distance);
    return nearest;
}

/// Checks that the remaining contacts are some of all, in their order, and that each vertex keeps its nearest contact.
static void CheckNearest(const qcSoup* soft, const Contacts* all, const Contacts* nearest)
{
    size_t at = 0;
    for (size_t i = 0; i < nearest->count; i++, at++)
    {
        while (at < all->count && memcmp(&all->contacts[at], &nearest->contacts[i], sizeof(qcContact)) != 0)
            at++;
        ck_assert_uint_lt(at, all->count);
    }
    for (uint32_t vertex = 0; vertex < soft->vertexCount; vertex++)
        ck_assert_double_eq(NearestOf(all, vertex), NearestOf(nearest, vertex));
}

START_TEST(each_vertex_keeps_its_nearest_contact_and_few_others)
{
    for (uint64_t seed = 1; seed <= 6; seed++)
    {
        qcSoup cloth = qcSoup_MakeFoldedCloth(seed, 14, 0.05, 0.01),
               ground = qcSoup_MakeFoldedCloth(seed + 9, 40, 0.3, 0.02);
        qcSoup_Translate(&cloth, 0.0, 0.0, 0.02);
        Contacts all = Find(&cloth, &ground, 0.1, false), nearest = Find(&cloth, &ground, 0.1, true);
        CheckNearest(&cloth, &all, &nearest);
        ck_assert_double_eq_tol(NearestOfAll(&all), NearestOfAll(&nearest), 1e-5);
        ck_assert_uint_gt(nearest.count, 100);
        ck_assert_uint_lt(5 * nearest.count, all.count);
        free(all.contacts);
        free(nearest.contacts);
        qcSoup_Free(&cloth);
        qcSoup_Free(&ground);
    }
}
END_TEST

START_TEST(on_a_fine_ball_the_nearest_contact_of_all_is_kept)
{
    qcSoup cloth = qcSoup_MakeGrid(7), ball = qcSoup_MakeSphere(4, 0.4);
    for (int place = 0; place < 20; place++)
    {
        qcSoup_Translate(&cloth, place == 0 ? -0.52 : 0.003, place == 0 ? -0.51 : -0.002, place == 0 ? 0.42 : -0.0002);
        Contacts all = Find(&cloth, &ball, 0.05, false), nearest = Find(&cloth, &ball, 0.05, true);
        CheckNearest(&cloth, &all, &nearest);
        ck_assert_double_eq_tol(NearestOfAll(&all), NearestOfAll(&nearest), 1e-6);
        free(all.contacts);
        free(nearest.contacts);
    }
    qcSoup_Free(&cloth);
    qcSoup_Free(&ball);
}
END_TEST

/// Contacts of one large triangle above a flat strip, or a flat square, of 2 by `count` triangles.
static size_t CountUnder(double width, double length)
{
    double wide[9] = {-5, -5, 0.01, 5, -5, 0.01, 0, 8, 0.01}, strip[36];
    uint32_t one[3] = {0, 1, 2}, several[24];
    for (uint32_t i = 0; i < 10; i++)
    {
        strip[3 * i] = length * (i / 2) / 4.0;
        strip[3 * i + 1] = i % 2 ? width : 0.0;
        strip[3 * i + 2] = 0.0;
    }
    for (uint32_t i = 0; i < 4; i++)
    {
        const uint32_t quad[6] = {2 * i, 2 * i + 2, 2 * i + 1, 2 * i + 1, 2 * i + 2, 2 * i + 3};
        memcpy(several + 6 * i, quad, sizeof quad);
    }
    qcSoup cloth = {wide, 3, one, 1}, flat = {strip, 10, several, 8};
    Contacts found = Find(&cloth, &flat, 0.02, true);
    free(found.contacts);
    return found.count;
}

START_TEST(a_rigid_body_smaller_than_a_triangle_has_contacts_at_its_border)
{
    // Ten vertices, of which four are corners; all lie on the border.
    ck_assert_uint_eq(CountUnder(0.1, 0.1), 10);
    // Reaching out on both sides: two edges of the triangle over two of the strip are among them.
    ck_assert_uint_ge(CountUnder(0.1, 20.0), 4);
}
END_TEST

START_TEST(contacts_are_reported_up_to_the_sum_of_the_margins_of_their_bodies)
{
    qcSoup soups[2] = {qcSoup_MakeFoldedCloth(5, 20, 0.02, 0.004), qcSoup_MakeSphere(3, 0.2)};
    qcSoup_Translate(&soups[1], 0.5, 0.5, 0.2);
    const double margins[2] = {0.006, 0.02};
    Contacts expected = {NULL, 0};
    for (int limited = 0; limited < 2; limited++)
        for (int method = 0; method < 2; method++)
        {
            qcScene* scene = qcMakeScene(NULL);
            for (int i = 0; i < 2; i++)
            {
                qcBodyDef def = qcBodyDefOf(&soups[i]);
                def.margin = limited ? margins[i] : INFINITY;
                def.deforming = i == 0;
                def.selfCollision = i == 0;
                qcBodyId id;
                CHECK_OK(qcScene_AddBody(scene, &def, &id));
            }
            qcDetectDef detect = qcDefaultDetectDef();
            detect.method = method == 0 ? qc_methodSweep : qc_methodBrute;
            detect.contactMargin = 0.04;
            const qcResult* result;
            CHECK_OK(qcScene_Detect(scene, &detect, &result));
            if (limited == 0 && method == 0)
                expected.contacts = malloc(result->contactCount * sizeof(qcContact));
            for (size_t i = 0; i < result->contactCount && limited == 0 && method == 0; i++)
            {
                const qcContact* contact = &result->contacts[i];
                double reach = margins[contact->bodyA] + margins[contact->bodyB];
                if (contact->distance <= reach)
                    expected.contacts[expected.count++] = *contact;
            }
            if (limited)
            {
                ck_assert_uint_gt(expected.count, 500);
                ck_assert_uint_eq(result->contactCount, expected.count);
                ck_assert_int_eq(memcmp(result->contacts, expected.contacts, expected.count * sizeof(qcContact)), 0);
            }
            qcScene_Destroy(scene);
        }
    free(expected.contacts);
    qcSoup_Free(&soups[0]);
    qcSoup_Free(&soups[1]);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("nearest contacts", each_vertex_keeps_its_nearest_contact_and_few_others,
             on_a_fine_ball_the_nearest_contact_of_all_is_kept,
             a_rigid_body_smaller_than_a_triangle_has_contacts_at_its_border,
             contacts_are_reported_up_to_the_sum_of_the_margins_of_their_bodies)
