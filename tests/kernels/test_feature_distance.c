// Features that the kernels of every instruction set prove to be without a contact have none in double arithmetic
// either: for pairs of all kinds and scales, also at the margin. Most features without a contact are proven.
#include "narrowphase/feature_contacts.h"
#include "support/pairs.h"
#include "support/suite.h"
#include "sweep/sample_bodies.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef struct Pair
{
    double positions[2][9];
    uint32_t indices[2][3];
    qcOwnedFeatures owned[2];
    qcBody bodies[2];
    qcContactPair pair;
} Pair;

static void Make(const double a[3][3], const double b[3][3], double margin, Pair* made)
{
    *made = (Pair){.owned = {0x3f, 0x3f}};
    memcpy(made->positions[0], a, sizeof made->positions[0]);
    memcpy(made->positions[1], b, sizeof made->positions[1]);
    for (uint32_t i = 0; i < 2; i++)
    {
        for (uint32_t c = 0; c < 3; c++)
            made->indices[i][c] = c;
        made->bodies[i] = (qcBody){.deforming = true,
                                   .isIdentity = true,
                                   .world = made->positions[i],
                                   .indices = made->indices[i],
                                   .owned = &made->owned[i],
                                   .vertexCount = 3,
                                   .triangleCount = 1};
    }
    made->pair = (qcContactPair){{&made->bodies[0], 0, 0, NULL}, {&made->bodies[1], 1, 0, NULL}, margin};
}

static int Find(const Pair* made, qcFeatureMask near, qcContact contacts[qc_maxContactsPerPair])
{
    qcContactTriangle a = {.index = NULL}, b = {.index = NULL};
    qcContactTriangle_Load(&a, &made->pair.a);
    qcContactTriangle_Load(&b, &made->pair.b);
    return qcContact_Find(&a, &b, made->pair.margin, near, contacts);
}

static const qcFeatureMask s_all = 0x7fff;

typedef struct Counts
{
    Pair pairs[qc_featurePairs];
    size_t count;
    int contacts, without;     ///< pairs of features with a contact, and without
    int proven[qc_maxKernels]; ///< features that are proven to be without a contact
} Counts;

static void CheckPair(Counts* q, const Pair* pair, qcFeatureMask near, size_t kernel, const char* name)
{
    qcContact all[qc_maxContactsPerPair], found[qc_maxContactsPerPair];
    memset(all, 0, sizeof all);
    memset(found, 0, sizeof found);
    int count = Find(pair, s_all, all), foundCount = Find(pair, near, found);
    CHECK_THAT(count == foundCount && memcmp(all, found, (size_t)count * sizeof all[0]) == 0,
               "%s: %d of %d contacts within %a, features %x", name, foundCount, count, pair->pair.margin, near);
    q->proven[kernel] += 15 - __builtin_popcount(near);
    if (kernel == 0)
    {
        q->contacts += count;
        q->without += 15 - count;
    }
}

static void Flush(Counts* q)
{
    qcContactPair pairs[qc_featurePairs];
    qcFeatureMask near[qc_featurePairs];
    if (q->count == 0)
        return;
    for (size_t i = 0; i < q->count; i++)
        pairs[i] = q->pairs[i].pair;
    FOR_EACH_KERNELS(k)
    {
        qcContact_FindNear(k, pairs, q->count, near);
        for (size_t i = 0; i < q->count; i++)
            CheckPair(q, &q->pairs[i], near[i], (size_t)kernelIndex, k->name);
    }
    q->count = 0;
}

static void CheckMargin(Counts* q, const double a[3][3], const double b[3][3], double margin)
{
    Make(a, b, margin, &q->pairs[q->count]);
    if (++q->count == qc_featurePairs)
        Flush(q);
}

/// Tests with margins at the distances of the features and near them.
static void CheckAtDistances(Counts* q, const qcTrianglePair* pair, double off)
{
    Pair made;
    qcContact contacts[qc_maxContactsPerPair];
    Make(pair->a, pair->b, DBL_MAX, &made);
    int count = Find(&made, s_all, contacts);
    for (int i = 0; i < count; i++)
    {
        double distance = contacts[i].distance;
        CheckMargin(q, pair->a, pair->b, distance);
        CheckMargin(q, pair->a, pair->b, distance * (1.0 + off));
        CheckMargin(q, pair->a, pair->b, distance * (1.0 - off));
    }
}

START_TEST(no_contact_is_lost)
{
    Counts q = {.count = 0};
    qcRandom random = {41};
    int count = qcGetTestPairCount(6000);
    for (int i = 0; i < count; i++)
    {
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&random, &pair);
        CheckAtDistances(&q, &pair, ldexp(1.0, -i % 50));
        CheckMargin(&q, pair.a, pair.b, 0.0);
        // Also batches that are not full.
        if (i % 3 == 0)
            Flush(&q);
    }
    Flush(&q);
    ck_assert_int_gt(q.contacts, count);
}
END_TEST

START_TEST(nearly_parallel_edges_keep_their_contacts)
{
    Counts q = {.count = 0};
    qcRandom random = {42};
    for (int i = 0; i < 20000; i++)
    {
        qcTrianglePair pair = {.kind = qc_pairGeneral};
        double turn = ldexp(1.0, -i % 40), apart = ldexp(1.0, -i / 40 % 20);
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++)
            {
                pair.a[c][axis] = qcRandom_Uniform(&random, -1.0, 1.0);
                pair.b[c][axis] =
                    pair.a[c][axis] + turn * qcRandom_Uniform(&random, -1.0, 1.0) + (axis == i % 3 ? apart : 0.0);
            }
        CheckAtDistances(&q, &pair, ldexp(1.0, -i % 23));
    }
    Flush(&q);
    ck_assert_int_gt(q.contacts, 20000);
}
END_TEST

START_TEST(the_smallest_and_the_largest_numbers_lose_no_contact)
{
    Counts q = {.count = 0};
    qcRandom random = {43};
    for (int i = 0; i < 4000; i++)
    {
        // Floats range from 2^-149 to 2^128.
        qcTrianglePair pair = {.kind = qc_pairGeneral};
        double size = ldexp(1.0, i % 2 == 0 ? 120 + i / 2 % 30 : -115 - i / 2 % 60);
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++)
            {
                pair.a[c][axis] = size * qcRandom_Uniform(&random, -1.0, 1.0);
                pair.b[c][axis] = size * qcRandom_Uniform(&random, -1.0, 1.0);
            }
        CheckAtDistances(&q, &pair, ldexp(1.0, -i % 30));
    }
    Flush(&q);
    ck_assert_int_gt(q.contacts, 4000);
}
END_TEST

START_TEST(most_features_without_a_contact_are_proven_so)
{
    Counts q = {.count = 0};
    qcRandom random = {44};
    for (int i = 0; i < 20000; i++)
    {
        // Like triangles of two meshes near each other, in a world of another size.
        qcTrianglePair pair = {.kind = qc_pairGeneral};
        for (int axis = 0; axis < 3; axis++)
        {
            double centre = qcRandom_Uniform(&random, 1e3, 2e3), other = centre + qcRandom_Uniform(&random, -0.5, 0.5);
            for (int c = 0; c < 3; c++)
            {
                pair.a[c][axis] = centre + qcRandom_Uniform(&random, -1.0, 1.0);
                pair.b[c][axis] = other + qcRandom_Uniform(&random, -1.0, 1.0);
            }
        }
        CheckMargin(&q, pair.a, pair.b, 0.2);
    }
    Flush(&q);
    FOR_EACH_KERNELS(k)
    CHECK_THAT(q.proven[kernelIndex] > q.without / 100 * 80, "%s tells %d of %d", k->name, q.proven[kernelIndex],
               q.without);
}
END_TEST

QC_RUN_TESTS("feature_distance", no_contact_is_lost, nearly_parallel_edges_keep_their_contacts,
             the_smallest_and_the_largest_numbers_lose_no_contact, most_features_without_a_contact_are_proven_so)
