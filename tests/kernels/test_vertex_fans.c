// Stars of a surface are all the closed fans that it has, and no others; a star that the kernel calls quiet has no two
// features without a common vertex within the reach, by rational arithmetic; and most stars of bent cloth are quiet.
#include "support/oracle.h"
#include "support/pairs.h"
#include "support/suite.h"
#include "mesh/vertex_fans.h"
#include "sweep/sample_bodies.h"

#include <math.h>

//  ---- the kernel ----------------------------------------------------------------------------------

/// The middle, then the vertices around it.
typedef struct Star
{
    int valence;
    double x[1 + qc_maxFanSize][3];
    float error; ///< of coordinates in single precision
    qcPoint points[1 + qc_maxFanSize];
} Star;

static void PlaceFeature(const Star* star, const int* vertices, int count, double corners[3][3])
{
    for (int c = 0; c < 3; c++)
        memcpy(corners[c], star->x[vertices[c < count ? c : 0]], sizeof corners[c]);
}

static double DistanceOf(const Star* star, const int* a, int countA, const int* b, int countB)
{
    for (int i = 0; i < countA; i++)
        for (int k = 0; k < countB; k++)
            if (a[i] == b[k])
                return INFINITY;
    double p[3][3], q[3][3];
    PlaceFeature(star, a, countA, p);
    PlaceFeature(star, b, countB, q);
    qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])p, (const double(*)[3])q);
    double result = qcOracleDistance_Get(distance);
    qcOracleDistance_Destroy(distance);
    return result;
}

/// The least distance of two features without a common vertex, to 2^-51 of itself: of vertices from triangles, and of
/// edges from edges.
static double FindQuietReach(const Star* star)
{
    int k = star->valence, edges[2 * qc_maxFanSize][2];
    double least = INFINITY;
    for (int i = 0; i < k; i++)
    {
        int triangle[3] = {0, 1 + i, 1 + (i + 1) % k};
        for (int v = 1; v <= k; v++)
            least = fmin(least, DistanceOf(star, &v, 1, triangle, 3));
        edges[2 * i][0] = 0;
        edges[2 * i][1] = edges[2 * i + 1][0] = 1 + i;
        edges[2 * i + 1][1] = triangle[2];
    }
    for (int i = 0; i < 2 * k; i++)
        for (int j = 0; j < i; j++)
            least = fmin(least, DistanceOf(star, edges[i], 2, edges[j], 2));
    return least;
}

/// At even angles around the middle, once or twice or back and forth, as far from it or not; then bent, or anywhere.
static Star MakeStar(qcRandom* random)
{
    Star star = {.valence = qc_minFanSize + (int)qcRandom_Below(random, qc_maxFanSize - qc_minFanSize + 1)};
    double size = ldexp(0.3, -(int)qcRandom_Below(random, 10)), bend = ldexp(1.0, -(int)qcRandom_Below(random, 8));
    double turns = qcRandom_Below(random, 5) == 0 ? 2.0 : 1.0, jitter = qcRandom_Below(random, 2) == 0 ? 0.0 : 0.9;
    bool isPlane = qcRandom_Below(random, 3) == 0, isAnywhere = qcRandom_Below(random, 8) == 0;
    double shift = isPlane ? qcRandom_Uniform(random, 0.0, 0.2) : 0.0;
    int first = (int)qcRandom_Below(random, 3), k = star.valence;
    for (int i = 0; i <= k; i++)
    {
        double angle = turns * 2.0 * 3.14159265358979 / k * (i + jitter * qcRandom_Uniform(random, -0.5, 0.5));
        double length = i == 0 ? 0.0 : size * (jitter == 0.0 ? 1.0 : qcRandom_Uniform(random, 0.5, 1.5));
        double local[3] = {length * cos(angle) + (i == 0 ? shift * size : 0.0), length * sin(angle),
                           isPlane ? 0.0 : bend * size * qcRandom_Uniform(random, -1.0, 1.0)};
        for (int axis = 0; axis < 3; axis++)
            star.x[i][(axis + first) % 3] =
                0.5 + (isAnywhere ? size * qcRandom_Uniform(random, -1.0, 1.0) : local[axis]);
    }
    // What the kernel sees is off by up to the error, mostly by all of it.
    star.error = (float)ldexp(1.0, qcRandom_Below(random, 2) == 0 ? -24 : -24 + (int)qcRandom_Below(random, 16));
    for (int i = 0; i <= k; i++)
        for (int axis = 0; axis < 3; axis++)
        {
            float x = (float)star.x[i][axis];
            double off = star.error * (0.999 - 0x1p-25 / star.error) * (qcRandom_Below(random, 2) == 0 ? -1.0 : 1.0);
            star.points[i].x[axis] = x;
            star.x[i][axis] = (double)x + off;
        }
    return star;
}

/// The kernel's answer for stars side by side, as many as a batch has, of one valence.
static uint32_t Ask(const qcTriangleKernels* k, const Star* const stars[qc_fanLanes], float error, float reach)
{
    static qcPoint s_points[qc_fanLanes * (1 + qc_maxFanSize)];
    uint32_t vertices[qc_fanLanes * (1 + qc_maxFanSize)], rows = 1 + (uint32_t)stars[0]->valence;
    for (uint32_t lane = 0; lane < qc_fanLanes; lane++)
        for (uint32_t row = 0; row < rows; row++)
        {
            uint32_t vertex = lane * rows + row;
            s_points[vertex] = stars[lane]->points[row];
            vertices[row * qc_fanLanes + lane] = vertex;
        }
    qcDistanceThresholds bound = {.pointError = error, .query = reach};
    return k->findSeparatedFans(s_points, vertices, rows - 1, &bound);
}

static bool IsQuiet(const qcTriangleKernels* k, const Star* star, float reach)
{
    const Star* stars[qc_fanLanes];
    for (int lane = 0; lane < qc_fanLanes; lane++)
        stars[lane] = star;
    uint32_t quiet = Ask(k, stars, star->error, reach);
    CHECK_THAT(quiet == 0 || quiet == 0xffffu, "%s: the same star, other answers: %x", k->name, quiet);
    return quiet != 0;
}

START_TEST(quiet_stars_have_no_features_within_the_reach)
{
    qcRandom random = {31};
    int quiet = 0, count = qcGetTestPairCount(400);
    for (int i = 0; i < count; i++)
    {
        Star star = MakeStar(&random);
        double limit = FindQuietReach(&star);
        // Just what is no longer quiet, more, or less.
        const double factors[4] = {1.0 + 0x1p-23, 1.0, 2.0, 0.9};
        for (int f = 0; f < 4; f++)
        {
            float reach = (float)(limit * factors[f]);
            FOR_EACH_KERNELS(k)
            {
                bool isQuiet = IsQuiet(k, &star, reach);
                CHECK_THAT(!isQuiet || (double)reach < limit, "%s: star %d of %d, reach %a", k->name, i, star.valence,
                           (double)reach);
                quiet += kernelIndex == 0 && isQuiet && f == 3;
            }
        }
    }
    // The others are stars of which the distances that count are not told by a projection.
    ck_assert_int_gt(quiet, count / 20);
}
END_TEST

START_TEST(lanes_do_not_depend_on_each_other)
{
    qcRandom random = {32};
    Star stars[qc_fanLanes];
    int mixed = 0;
    for (int i = 0; i < 60; i++)
    {
        const Star* order[qc_fanLanes];
        for (int lane = 0; lane < qc_fanLanes; lane++)
        {
            do
                stars[lane] = MakeStar(&random);
            while (stars[lane].valence != qc_minFanSize + i % (qc_maxFanSize - qc_minFanSize + 1));
            stars[lane].error = 0x1p-20f;
            order[lane] = &stars[lane];
        }
        float reach = (float)ldexp(0.05, -(int)qcRandom_Below(&random, 10));
        FOR_EACH_KERNELS(k)
        {
            uint32_t quiet = Ask(k, order, 0x1p-20f, reach);
            for (int lane = 0; lane < qc_fanLanes; lane++)
                ck_assert(IsQuiet(k, &stars[lane], reach) == (quiet >> lane & 1u));
            mixed += quiet != 0 && quiet != 0xffffu;
        }
    }
    ck_assert_int_gt(mixed, 5);
}
END_TEST

START_TEST(of_a_star_that_is_bent_a_reach_of_a_quarter_of_an_edge_is_quiet)
{
    // Around a vertex of cloth with crossed diagonals, on a cylinder with a radius of four edges.
    Star star = {.valence = 8, .error = 0x1p-24f};
    const double ring[9][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    for (int i = 0; i < 9; i++)
    {
        const double place[3] = {0.04 * sin(ring[i][0] / 4.0), 0.01 * ring[i][1], 0.04 * cos(ring[i][0] / 4.0)};
        for (int axis = 0; axis < 3; axis++)
            star.points[i].x[axis] = (float)(0.5 + place[axis]);
    }
    FOR_EACH_KERNELS(k)
    ck_assert(IsQuiet(k, &star, 0.0025f));
}
END_TEST

//  ---- the stars -----------------------------------------------------------------------------------

/// Do the triangles around a vertex, `sides` of which lie opposite, make one closed fan? Every vertex there has two of
/// them, and from one all can be reached.
static bool IsFan(const uint32_t sides[][2], size_t count)
{
    bool reached[qc_maxFanSize] = {true};
    for (size_t i = 0; i < count; i++)
        for (int end = 0; end < 2; end++)
        {
            int at = 0;
            for (size_t k = 0; k < count; k++)
                at += (sides[k][0] == sides[i][end]) + (sides[k][1] == sides[i][end]);
            if (at != 2)
                return false;
        }
    size_t total = 1;
    for (size_t round = 0; round < count; round++)
        for (size_t i = 0; i < count; i++)
            for (size_t k = 0; k < count && !reached[i]; k++)
                if (reached[k] && (sides[i][0] == sides[k][0] || sides[i][0] == sides[k][1] ||
                                   sides[i][1] == sides[k][0] || sides[i][1] == sides[k][1]))
                {
                    reached[i] = true;
                    total++;
                }
    return total == count;
}

/// The triangles that have a vertex, and whether they make a star.
static bool IsStar(const qcCorners* corners, size_t count, uint32_t vertex, uint32_t* triangles, size_t* found)
{
    uint32_t sides[qc_maxFanSize][2];
    bool isProper = true;
    *found = 0;
    for (uint32_t t = 0; t < count; t++)
    {
        const uint32_t* v = corners[t].vertex;
        if (v[0] != vertex && v[1] != vertex && v[2] != vertex)
            continue;
        isProper = isProper && v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
        for (int c = 0, side = 0; c < 3 && *found < qc_maxFanSize; c++)
            if (v[c] != vertex && side < 2)
                sides[*found][side++] = v[c];
        triangles[(*found)++] = t;
    }
    return isProper && *found >= qc_minFanSize && *found <= qc_maxFanSize && IsFan((const uint32_t(*)[2])sides, *found);
}

static bool HasTriangle(const qcCorners* corners, const uint32_t* triangles, size_t count, uint32_t a, uint32_t b)
{
    size_t found = 0;
    for (size_t i = 0; i < count; i++)
    {
        const uint32_t* v = corners[triangles[i]].vertex;
        found += (v[0] == a || v[1] == a || v[2] == a) && (v[0] == b || v[1] == b || v[2] == b);
    }
    return found == 1;
}

/// Where the vertex stands: the batch and its lane. False: nowhere. It stands there once.
static bool FindStar(const qcVertexFans* stars, uint32_t vertex, const qcVertexFanBatch** batch, uint32_t* lane)
{
    int found = 0;
    for (size_t i = 0; i < stars->batches.count; i++)
    {
        const qcVertexFanBatch* b = &QC_AT(qcVertexFanBatch, stars->batches, i);
        ck_assert(b->count > 0 && b->count <= qc_fanLanes);
        for (uint32_t l = 0; l < qc_fanLanes; l++)
        {
            // Lanes without a star have the first one's vertices.
            uint32_t middle = QC_AT(uint32_t, stars->vertices, b->firstVertex + l);
            ck_assert(l < b->count || middle == QC_AT(uint32_t, stars->vertices, b->firstVertex));
            if (l >= b->count || middle != vertex)
                continue;
            *batch = b;
            *lane = l;
            found++;
        }
    }
    ck_assert_int_le(found, 1);
    return found == 1;
}

/// Returns the number of stars.
static int CheckStars(const qcCorners* corners, size_t count, uint32_t vertexCount)
{
    qcVertexFans stars = {.made = false};
    CHECK_OK(qcVertexFans_Make(&stars, corners, count, vertexCount));
    uint32_t* triangles = malloc((count + 1) * sizeof *triangles);
    ck_assert_ptr_nonnull(triangles);
    int starCount = 0;
    for (uint32_t v = 0; v < vertexCount; v++)
    {
        size_t found;
        const qcVertexFanBatch* batch = NULL;
        uint32_t lane = 0;
        bool isStar = IsStar(corners, count, v, triangles, &found);
        uint32_t first = QC_AT(uint32_t, stars.firstPlace, v);
        ck_assert_uint_eq(QC_AT(uint32_t, stars.firstPlace, v + 1) - first, found);
        for (size_t i = 0; i < found; i++)
            ck_assert_uint_eq(QC_AT(uint32_t, stars.places, first + i), triangles[i]);
        ck_assert(FindStar(&stars, v, &batch, &lane) == isStar);
        if (!isStar)
            continue;
        starCount++;
        ck_assert_uint_eq(batch->valence, found);
        const uint32_t* column = &QC_AT(uint32_t, stars.vertices, batch->firstVertex + lane);
        for (uint32_t i = 0; i < batch->valence; i++)
            ck_assert(HasTriangle(corners, triangles, found, column[(1 + i) * qc_fanLanes],
                                  column[(1 + (i + 1) % batch->valence) * qc_fanLanes]));
    }
    free(triangles);
    qcVertexFans_Free(&stars);
    return starCount;
}

START_TEST(stars_are_all_closed_fans)
{
    for (int kind = 0; kind < qc_soupKindCount; kind++)
    {
        qcSoup soup = qcMakeSoup((qcSoupKind)kind, 5);
        // Without its last triangle, and with the one before gone: as a place with no triangle.
        qcCorners* corners = (qcCorners*)soup.indices;
        if (soup.triangleCount > 2)
            corners[soup.triangleCount - 2] = (qcCorners){{soup.vertexCount, soup.vertexCount, soup.vertexCount}};
        int count = CheckStars(corners, soup.triangleCount, soup.vertexCount);
        ck_assert(count > 0 || (kind != qc_soupSphere && kind != qc_soupCloth && kind != qc_soupFlat));
        qcSoup_Free(&soup);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(fans_of_any_size_and_nearly_closed_ones_are_told_apart)
{
    qcRandom random = {33};
    int found = 0;
    for (uint32_t valence = 1; valence < 2 * qc_maxFanSize; valence++)
        for (int change = 0; change < 4; change++)
        {
            qcCorners corners[2 * qc_maxFanSize];
            for (uint32_t i = 0; i < valence; i++)
            {
                uint32_t turn = qcRandom_Below(&random, 3), next = 1 + (i + 1) % valence;
                bool back = qcRandom_Below(&random, 2) == 0;
                corners[i].vertex[turn] = 0;
                corners[i].vertex[(turn + 1) % 3] = back ? next : 1 + i;
                corners[i].vertex[(turn + 2) % 3] = back ? 1 + i : next;
            }
            // As it is; one triangle twice; open; two fans that only share the middle.
            uint32_t last = valence - 1, half = valence / 2;
            if (change == 1)
                corners[last] = corners[0];
            else if (change == 2)
                corners[last] = (qcCorners){{0, valence, valence + 1}};
            else if (change == 3)
            {
                corners[half == 0 ? 0 : half - 1] = (qcCorners){{0, half == 0 ? 1 : half, 1}};
                corners[last] = (qcCorners){{0, valence, 1 + half}};
            }
            found += CheckStars(corners, valence, valence + 2) > 0 && change == 0;
        }
    ck_assert_int_ge(found, qc_maxFanSize - qc_minFanSize + 1);
}
END_TEST

START_TEST(among_few_vertices_every_fan_is_found)
{
    qcRandom random = {34};
    int found = 0;
    for (int i = 0; i < 3000; i++)
    {
        qcCorners corners[9];
        uint32_t count = 3 + qcRandom_Below(&random, 7), vertexCount = 4 + qcRandom_Below(&random, 3);
        for (uint32_t t = 0; t < count; t++)
            for (int c = 0; c < 3; c++)
                corners[t].vertex[c] = qcRandom_Below(&random, vertexCount);
        found += CheckStars(corners, count, vertexCount);
    }
    ck_assert_int_gt(found, 50);
}
END_TEST

QC_RUN_TESTS("stars", quiet_stars_have_no_features_within_the_reach, lanes_do_not_depend_on_each_other,
             of_a_star_that_is_bent_a_reach_of_a_quarter_of_an_edge_is_quiet, stars_are_all_closed_fans,
             fans_of_any_size_and_nearly_closed_ones_are_told_apart, among_few_vertices_every_fan_is_found)
