// Pairs of neighbours that the kernel drops have no features without a common vertex within the query distance, by
// rational arithmetic. Nearly all neighbours of a smooth mesh are dropped; all others are listed once.
#include "support/oracle.h"
#include "support/pairs.h"
#include "support/suite.h"
#include "sweep/bvh/neighbour_pairs.h"
#include "sweep/sample_bodies.h"
#include "scene/step_triangles.h"

#include <math.h>
#include <stdio.h>

enum
{
    qc_checked = 11 ///< one in this number of dropped pairs is tested in rational arithmetic
};

typedef struct Corner
{
    uint32_t vertex;
    double x[3];
} Corner;

/// Two triangles with `common` common vertices.
typedef struct Neighbours
{
    Corner a[3], b[3];
    int common;
} Neighbours;

//  ---- the oracle ----------------------------------------------------------------------------------

/// The corners of two features.
typedef struct Features
{
    double a[3][3], b[3][3];
} Features;

/// False: they have a common vertex.
static bool SetFeatures(Features* f, const Corner* a, int countA, const Corner* b, int countB)
{
    for (int i = 0; i < countA; i++)
        for (int k = 0; k < countB; k++)
            if (a[i].vertex == b[k].vertex)
                return false;
    for (int c = 0; c < 3; c++)
    {
        memcpy(f->a[c], a[c < countA ? c : 0].x, sizeof f->a[c]);
        memcpy(f->b[c], b[c < countB ? c : 0].x, sizeof f->b[c]);
    }
    return true;
}

/// Lists pairs of a corner and a triangle, and of two edges, without a common vertex. Returns their number.
static int ListFeatures(const Neighbours* n, Features features[16])
{
    int count = 0;
    for (int i = 0; i < 3; i++)
    {
        count += SetFeatures(&features[count], &n->a[i], 1, n->b, 3);
        count += SetFeatures(&features[count], n->a, 3, &n->b[i], 1);
        for (int k = 0; k < 3; k++)
        {
            Corner edgeA[2] = {n->a[i], n->a[(i + 1) % 3]}, edgeB[2] = {n->b[k], n->b[(k + 1) % 3]};
            count += SetFeatures(&features[count], edgeA, 2, edgeB, 2);
        }
    }
    return count;
}

/// True if their boxes are farther apart.
static bool AreBoxesFarther(const Features* f, double query)
{
    for (int axis = 0; axis < 3; axis++)
    {
        double lowA = fmin(f->a[0][axis], fmin(f->a[1][axis], f->a[2][axis])),
               highA = fmax(f->a[0][axis], fmax(f->a[1][axis], f->a[2][axis])),
               lowB = fmin(f->b[0][axis], fmin(f->b[1][axis], f->b[2][axis])),
               highB = fmax(f->b[0][axis], fmax(f->b[1][axis], f->b[2][axis]));
        if (lowA - highB > 1.001 * query || lowB - highA > 1.001 * query)
            return true;
    }
    return false;
}

static bool AreSeparated(const Neighbours* n, double query)
{
    Features features[16];
    int count = ListFeatures(n, features);
    bool isSeparated = true;
    for (int i = 0; i < count && isSeparated; i++)
    {
        if (AreBoxesFarther(&features[i], query))
            continue;
        qcOracleDistance* distance =
            qcOracleDistance_Create((const double(*)[3])features[i].a, (const double(*)[3])features[i].b);
        isSeparated = qcOracleDistance_Compare(distance, query) > 0;
        qcOracleDistance_Destroy(distance);
    }
    return isSeparated;
}

/// The least distance of two features without a common vertex, roughly.
static double FindLeastDistance(const Neighbours* n)
{
    Features features[16];
    int count = ListFeatures(n, features);
    double least = 1.0;
    for (int i = 0; i < count; i++)
    {
        qcOracleDistance* distance =
            qcOracleDistance_Create((const double(*)[3])features[i].a, (const double(*)[3])features[i].b);
        least = fmin(least, qcOracleDistance_Get(distance));
        qcOracleDistance_Destroy(distance);
    }
    return least;
}

//  ---- the kernel ----------------------------------------------------------------------------------

/// Tests a pair among copies of another one, in a random lane.
static bool Keeps(const qcTriangleKernels* k, const Neighbours* n, float query, qcRandom* random)
{
    enum
    {
        qc_pairs = 19
    };
    static uint32_t s_vertices[6];
    qcPoint points[9] = {{{0.0f, 0.0f, 0.0f, 0.0f}}};
    // The other pair: flat neighbours whose features are far apart.
    qcCorners corners[4] = {{{0}}, {{0}}, {{6, 7, 8}}, {{6, 8, 7}}};
    uint32_t names = 0;
    for (int side = 0; side < 2; side++)
        for (int c = 0; c < 3; c++)
        {
            const Corner* corner = side == 0 ? &n->a[c] : &n->b[c];
            uint32_t name = 0;
            while (name < names && s_vertices[name] != corner->vertex)
                name++;
            names += name == names;
            s_vertices[name] = corner->vertex;
            for (int axis = 0; axis < 3; axis++)
                points[name].x[axis] = (float)corner->x[axis];
            corners[side].vertex[c] = name;
        }
    qcSlotPair pairs[qc_pairs];
    size_t count = 1 + qcRandom_Below(random, qc_pairs), at = qcRandom_Below(random, (uint32_t)count);
    for (size_t i = 0; i < count; i++)
        pairs[i] = i == at ? (qcSlotPair){0, 1} : (qcSlotPair){2, 3};
    qcIndexedTriangles side = {corners, points};
    qcDistanceThresholds thresholds = {.pointError = 0x1p-24f, .query = query};
    size_t kept = k->filterNeighbours(&side, &thresholds, pairs, count);
    bool isKept = false;
    size_t others = 0;
    for (size_t i = 0; i < kept; i++)
    {
        isKept = isKept || pairs[i].a == 0;
        others += pairs[i].a == 2;
    }
    // Triangles with three common corners are always kept.
    CHECK_THAT(others == count - 1 && kept == others + isKept, "%s: %zu of %zu kept", k->name, kept, count);
    return isKept;
}

//  ---- pairs ---------------------------------------------------------------------------------------

static void Shuffle(qcRandom* random, Corner corners[3])
{
    for (uint32_t i = 2; i > 0; i--)
    {
        uint32_t k = qcRandom_Below(random, i + 1);
        Corner corner = corners[i];
        corners[i] = corners[k];
        corners[k] = corner;
    }
}

/// Around a vertex: in a plane, bent out of it, or anywhere; some are needles.
static Neighbours MakeNeighbours(qcRandom* random, int common)
{
    Neighbours n = {.common = common};
    double size = ldexp(0.3, -(int)qcRandom_Below(random, 12)), bend = ldexp(1.0, -(int)qcRandom_Below(random, 20));
    bend = qcRandom_Below(random, 4) == 0 ? 0.0 : bend;
    double angles[4] = {0.0, qcRandom_Uniform(random, 0.02, 2.0), 0.0, 0.0}, at[3];
    angles[2] = angles[1] + (common == 2 ? 0.0 : qcRandom_Uniform(random, 0.0, 2.0));
    angles[3] = angles[2] + qcRandom_Uniform(random, 0.02, 2.0);
    for (int axis = 0; axis < 3; axis++)
        at[axis] = qcRandom_Uniform(random, 0.35, 0.65);
    bool anywhere = qcRandom_Below(random, 4) == 0;
    int first = (int)qcRandom_Below(random, 3);
    Corner corners[5] = {{0, {at[0], at[1], at[2]}}};
    for (int i = 0; i < 4; i++)
    {
        double length = size * (qcRandom_Below(random, 5) == 0 ? 0.05 : qcRandom_Uniform(random, 0.5, 1.5));
        double local[3] = {length * cos(angles[i]), length * sin(angles[i]),
                           bend * size * qcRandom_Uniform(random, -1.0, 1.0)};
        corners[1 + i].vertex = (uint32_t)i + 1;
        for (int axis = 0; axis < 3; axis++)
            corners[1 + i].x[(axis + first) % 3] =
                at[(axis + first) % 3] + (anywhere ? size * qcRandom_Uniform(random, -1.0, 1.0) : local[axis]);
    }
    n.a[0] = n.b[0] = corners[0];
    n.a[1] = corners[1];
    n.a[2] = corners[2];
    n.b[1] = common == 2 ? corners[2] : corners[3];
    n.b[2] = corners[4];
    Shuffle(random, n.a);
    Shuffle(random, n.b);
    return n;
}

START_TEST(dropped_neighbours_have_no_other_features_within_the_query_distance)
{
    qcRandom random = {23};
    int separated = 0, dropped = 0, count = qcGetTestPairCount(800);
    for (int i = 0; i < count; i++)
    {
        Neighbours n = MakeNeighbours(&random, 1 + i % 2);
        double limit = FindLeastDistance(&n);
        // Just below the least distance, just above it, or any.
        const double factors[4] = {1.0 - 0x1p-10, 1.0 + 0x1p-20, 0.5, 2.0};
        float query = (float)(limit * factors[i / 2 % 4]);
        bool isSeparated = AreSeparated(&n, query);
        FOR_EACH_KERNELS(k)
        {
            bool isKept = Keeps(k, &n, query, &random);
            CHECK_THAT(isKept || isSeparated, "%s: pair %d, %d common, query %a", k->name, i, n.common, (double)query);
            dropped += kernelIndex == 0 && !isKept && factors[i / 2 % 4] == 0.5;
            separated += kernelIndex == 0 && factors[i / 2 % 4] == 0.5;
        }
    }
    ck_assert_int_gt(dropped, separated / 4);
}
END_TEST

START_TEST(neighbours_with_three_common_or_repeated_corners_are_kept)
{
    qcRandom random = {24};
    for (int i = 0; i < 60; i++)
    {
        Neighbours n = MakeNeighbours(&random, 1 + i % 2);
        if (i % 3 == 0)
            memcpy(n.b, n.a, sizeof n.b);
        else
            n.b[i % 3] = n.b[(i + 1) % 3];
        float query = (float)ldexp(1.0, -i % 24);
        if (i % 3 != 0 && AreSeparated(&n, query))
            continue;
        FOR_EACH_KERNELS(k)
        ck_assert(Keeps(k, &n, query, &random));
    }
}
END_TEST

//  ---- bodies --------------------------------------------------------------------------------------

typedef struct Found
{
    qcBodies bodies;
    const qcBody* body;
    qcArray keys;             ///< sorted
    size_t separated, others; ///< vertices by their fans
} Found;

static int CompareKeys(const void* a, const void* b)
{
    uint64_t x = *(const uint64_t*)a, y = *(const uint64_t*)b;
    return x < y ? -1 : x > y;
}

enum
{
    qc_maxThreads = 4
};

/// The pairs of each worker.
typedef struct Given
{
    const qcTriangleBvh* bvh;
    qcArray keys[qc_maxThreads];
} Given;

static void Take(void* context, const qcSlotPair* pairs, size_t count, uint32_t worker)
{
    Given* given = context;
    const uint32_t* triangles = given->bvh->clusters.triangles.data;
    CHECK_THAT(worker < qc_maxThreads, "worker %u", worker);
    qcArray* keys = &given->keys[worker];
    CHECK_THAT(qcArray_Reserve(keys, keys->count + count, sizeof(uint64_t), "keys") == qc_statusOk, "no memory");
    for (size_t i = 0; i < count; i++)
        QC_AT(uint64_t, *keys, keys->count++) = qcStepTriangles_Key(triangles[pairs[i].a], triangles[pairs[i].b]);
}

static Found FindKeys(const qcTriangleKernels* kernels, const qcSoup* soup, double margin, uint32_t threads)
{
    Found found = {.keys = {0}};
    found.body = qcBodyAt(&found.bodies, qcAddToBodies(&found.bodies, soup));
    qcBodyBvh bvh;
    qcBvhScratch scratch = {0};
    bool fits;
    CHECK_OK(qcBodyBvh_Build(&bvh, found.body, NULL, 1));
    CHECK_OK(qcBodyBvh_BuildAdjacency(&bvh, 1));
    CHECK_OK(qcTriangleBvh_Fit(&bvh.bvh, found.body, margin, kernels, threads, &scratch, &fits));
    ck_assert(fits);
    Given given = {.bvh = &bvh.bvh};
    qcNeighbourPairsJob job = {
        .kernels = kernels, .body = &bvh, .threads = threads, .function = Take, .context = &given};
    CHECK_OK(qcNeighbourPairs_Find(&job));
    for (uint32_t v = 0; v < bvh.bvh.vertexCount; v++)
        *(QC_AT(uint8_t, bvh.isSeparated, v) ? &found.separated : &found.others) += 1;
    for (int worker = 0; worker < qc_maxThreads; worker++)
    {
        CHECK_OK(qcArray_Append(&found.keys, &given.keys[worker], sizeof(uint64_t), "keys"));
        qcArray_Free(&given.keys[worker]);
    }
    if (found.keys.count != 0)
        qsort(found.keys.data, found.keys.count, sizeof(uint64_t), CompareKeys);
    qcBvhScratch_Free(&scratch);
    qcBodyBvh_Free(&bvh);
    return found;
}

static void Found_Free(Found* found)
{
    qcArray_Free(&found->keys);
    qcBodies_Free(&found->bodies);
}

static Neighbours NeighboursOf(const qcBody* body, uint32_t a, uint32_t b)
{
    Neighbours n = {.common = 0};
    for (int c = 0; c < 3; c++)
    {
        n.a[c].vertex = body->indices[3 * (size_t)a + (size_t)c];
        n.b[c].vertex = body->indices[3 * (size_t)b + (size_t)c];
        qcBody_GetVertex(body, n.a[c].vertex, n.a[c].x);
        qcBody_GetVertex(body, n.b[c].vertex, n.b[c].x);
        for (int k = 0; k < 3; k++)
            n.common += body->indices[3 * (size_t)b + (size_t)k] == n.a[c].vertex;
    }
    return n;
}

/// Checks that each pair of neighbours is listed once, or has no such contact; some of the latter are tested. Returns
/// the number of pairs.
static size_t CheckListed(const Found* found, double margin, const char* what)
{
    size_t missing = 0, at = 0;
    for (uint32_t a = 0; a < found->body->triangleCount; a++)
        for (uint32_t b = a + 1; b < found->body->triangleCount; b++)
        {
            Neighbours n = NeighboursOf(found->body, a, b);
            uint64_t key = (uint64_t)a << 32 | b;
            bool isListed = at < found->keys.count && QC_AT(uint64_t, found->keys, at) == key;
            at += isListed;
            if (n.common == 0)
                CHECK_THAT(!isListed, "%s: %u and %u are no neighbours", what, a, b);
            else if (!isListed && missing++ % qc_checked == 0)
                CHECK_THAT(AreSeparated(&n, margin), "%s: %u and %u are missing", what, a, b);
        }
    CHECK_THAT(at == found->keys.count, "%s: a pair is listed twice", what);
    return missing;
}

START_TEST(neighbours_that_are_not_listed_have_no_other_features_within_the_margin)
{
    for (int kind = 0; kind < qc_soupKindCount; kind++)
    {
        qcSoup soup = qcMakeSoup((qcSoupKind)kind, 3);
        const double margins[2] = {0.002, 0.05};
        for (int m = 0; m < 2; m++)
            FOR_EACH_KERNELS(k)
            {
                char what[80];
                snprintf(what, sizeof what, "soup %d, margin %g, %s", kind, margins[m], k->name);
                Found found = FindKeys(k, &soup, margins[m], 1 + (uint32_t)kernelIndex);
                CheckListed(&found, margins[m], what);
                Found_Free(&found);
            }
        qcSoup_Free(&soup);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(hardly_any_neighbours_of_a_smooth_mesh_are_listed)
{
    qcSoup sphere = qcSoup_MakeSphere(3, 0.5);
    FOR_EACH_KERNELS(k)
    {
        // A fifth of an edge.
        Found found = FindKeys(k, &sphere, 0.015, 2);
        size_t missing = CheckListed(&found, 0.015, k->name);
        ck_assert_uint_gt(missing, 1000);
        ck_assert_uint_lt(found.keys.count, missing / 50);
        ck_assert_uint_lt(found.others, found.separated / 50);
        Found_Free(&found);
    }
    qcSoup_Free(&sphere);
}
END_TEST

QC_RUN_TESTS("neighbour_pairs", dropped_neighbours_have_no_other_features_within_the_query_distance,
             neighbours_with_three_common_or_repeated_corners_are_kept,
             neighbours_that_are_not_listed_have_no_other_features_within_the_margin,
             hardly_any_neighbours_of_a_smooth_mesh_are_listed)
