// The vertex fans of a mesh are all its closed fans, and no others. A fan that the kernel proves separated has no two
// features without a common vertex within the query distance, by rational arithmetic. Most fans of bent cloth are
// proven.
#include "support/oracle.h"
#include "support/pairs.h"
#include "support/suite.h"
#include "mesh/vertex_fans.h"
#include "sweep/sample_bodies.h"

#include <math.h>

//  ---- the kernel ----------------------------------------------------------------------------------

/// The centre, then the vertices around it.
typedef struct Fan
{
    int valence;
    double x[1 + qc_maxFanSize][3];
    float error; ///< of coordinates in single precision
    qcPoint points[1 + qc_maxFanSize];
} Fan;

static void PlaceFeature(const Fan* fan, const int* vertices, int count, double corners[3][3])
{
    for (int c = 0; c < 3; c++)
        memcpy(corners[c], fan->x[vertices[c < count ? c : 0]], sizeof corners[c]);
}

static double DistanceOf(const Fan* fan, const int* a, int countA, const int* b, int countB)
{
    for (int i = 0; i < countA; i++)
        for (int k = 0; k < countB; k++)
            if (a[i] == b[k])
                return INFINITY;
    double p[3][3], q[3][3];
    PlaceFeature(fan, a, countA, p);
    PlaceFeature(fan, b, countB, q);
    qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])p, (const double(*)[3])q);
    double result = qcOracleDistance_Get(distance);
    qcOracleDistance_Destroy(distance);
    return result;
}

/// The least distance of two features without a common vertex, to 2^-51 of itself: of vertices from triangles, and of
/// edges from edges.
static double FindLeastDistance(const Fan* fan)
{
    int k = fan->valence, edges[2 * qc_maxFanSize][2];
    double least = INFINITY;
    for (int i = 0; i < k; i++)
    {
        int triangle[3] = {0, 1 + i, 1 + (i + 1) % k};
        for (int v = 1; v <= k; v++)
            least = fmin(least, DistanceOf(fan, &v, 1, triangle, 3));
        edges[2 * i][0] = 0;
        edges[2 * i][1] = edges[2 * i + 1][0] = 1 + i;
        edges[2 * i + 1][1] = triangle[2];
    }
    for (int i = 0; i < 2 * k; i++)
        for (int j = 0; j < i; j++)
            least = fmin(least, DistanceOf(fan, edges[i], 2, edges[j], 2));
    return least;
}

/// At even angles around the centre, in one or two turns or back and forth, at equal distances or not; then bent, or
/// anywhere.
static Fan MakeFan(qcRandom* random)
{
    Fan fan = {.valence = qc_minFanSize + (int)qcRandom_Below(random, qc_maxFanSize - qc_minFanSize + 1)};
    double size = ldexp(0.3, -(int)qcRandom_Below(random, 10)), bend = ldexp(1.0, -(int)qcRandom_Below(random, 8));
    double turns = qcRandom_Below(random, 5) == 0 ? 2.0 : 1.0, jitter = qcRandom_Below(random, 2) == 0 ? 0.0 : 0.9;
    bool isPlane = qcRandom_Below(random, 3) == 0, isAnywhere = qcRandom_Below(random, 8) == 0;
    double shift = isPlane ? qcRandom_Uniform(random, 0.0, 0.2) : 0.0;
    int first = (int)qcRandom_Below(random, 3), k = fan.valence;
    for (int i = 0; i <= k; i++)
    {
        double angle = turns * 2.0 * 3.14159265358979 / k * (i + jitter * qcRandom_Uniform(random, -0.5, 0.5));
        double length = i == 0 ? 0.0 : size * (jitter == 0.0 ? 1.0 : qcRandom_Uniform(random, 0.5, 1.5));
        double local[3] = {length * cos(angle) + (i == 0 ? shift * size : 0.0), length * sin(angle),
                           isPlane ? 0.0 : bend * size * qcRandom_Uniform(random, -1.0, 1.0)};
        for (int axis = 0; axis < 3; axis++)
            fan.x[i][(axis + first) % 3] =
                0.5 + (isAnywhere ? size * qcRandom_Uniform(random, -1.0, 1.0) : local[axis]);
    }
    // The kernel's points are wrong by up to the error, mostly by all of it.
    fan.error = (float)ldexp(1.0, qcRandom_Below(random, 2) == 0 ? -24 : -24 + (int)qcRandom_Below(random, 16));
    for (int i = 0; i <= k; i++)
        for (int axis = 0; axis < 3; axis++)
        {
            float x = (float)fan.x[i][axis];
            double off = fan.error * (0.999 - 0x1p-25 / fan.error) * (qcRandom_Below(random, 2) == 0 ? -1.0 : 1.0);
            fan.points[i].x[axis] = x;
            fan.x[i][axis] = (double)x + off;
        }
    return fan;
}

/// The kernel's result for a batch of fans of one valence.
static uint32_t TestBatch(const qcTriangleKernels* k, const Fan* const fans[qc_fanLanes], float error, float query)
{
    static qcPoint s_points[qc_fanLanes * (1 + qc_maxFanSize)];
    uint32_t vertices[qc_fanLanes * (1 + qc_maxFanSize)], rows = 1 + (uint32_t)fans[0]->valence;
    for (uint32_t lane = 0; lane < qc_fanLanes; lane++)
        for (uint32_t row = 0; row < rows; row++)
        {
            uint32_t vertex = lane * rows + row;
            s_points[vertex] = fans[lane]->points[row];
            vertices[row * qc_fanLanes + lane] = vertex;
        }
    qcDistanceThresholds thresholds = {.pointError = error, .query = query};
    return k->findSeparatedFans(s_points, vertices, rows - 1, &thresholds);
}

static bool IsSeparated(const qcTriangleKernels* k, const Fan* fan, float query)
{
    const Fan* fans[qc_fanLanes];
    for (int lane = 0; lane < qc_fanLanes; lane++)
        fans[lane] = fan;
    uint32_t separated = TestBatch(k, fans, fan->error, query);
    CHECK_THAT(separated == 0 || separated == 0xffffu, "%s: equal fans, different results: %x", k->name, separated);
    return separated != 0;
}

START_TEST(separated_fans_have_no_features_within_the_query_distance)
{
    qcRandom random = {31};
    int separated = 0, count = qcGetTestPairCount(400);
    for (int i = 0; i < count; i++)
    {
        Fan fan = MakeFan(&random);
        double limit = FindLeastDistance(&fan);
        // At the least distance, above it, or below.
        const double factors[4] = {1.0 + 0x1p-23, 1.0, 2.0, 0.9};
        for (int f = 0; f < 4; f++)
        {
            float query = (float)(limit * factors[f]);
            FOR_EACH_KERNELS(k)
            {
                bool isSeparated = IsSeparated(k, &fan, query);
                CHECK_THAT(!isSeparated || (double)query < limit, "%s: fan %d of %d, query %a", k->name, i, fan.valence,
                           (double)query);
                separated += kernelIndex == 0 && isSeparated && f == 3;
            }
        }
    }
    // The others are fans whose least distance no projection shows.
    ck_assert_int_gt(separated, count / 20);
}
END_TEST

START_TEST(lanes_do_not_depend_on_each_other)
{
    qcRandom random = {32};
    Fan fans[qc_fanLanes];
    int mixed = 0;
    for (int i = 0; i < 60; i++)
    {
        const Fan* order[qc_fanLanes];
        for (int lane = 0; lane < qc_fanLanes; lane++)
        {
            do
                fans[lane] = MakeFan(&random);
            while (fans[lane].valence != qc_minFanSize + i % (qc_maxFanSize - qc_minFanSize + 1));
            fans[lane].error = 0x1p-20f;
            order[lane] = &fans[lane];
        }
        float query = (float)ldexp(0.05, -(int)qcRandom_Below(&random, 10));
        FOR_EACH_KERNELS(k)
        {
            uint32_t separated = TestBatch(k, order, 0x1p-20f, query);
            for (int lane = 0; lane < qc_fanLanes; lane++)
                ck_assert(IsSeparated(k, &fans[lane], query) == (separated >> lane & 1u));
            mixed += separated != 0 && separated != 0xffffu;
        }
    }
    ck_assert_int_gt(mixed, 5);
}
END_TEST

START_TEST(a_bent_fan_is_separated_within_a_quarter_of_an_edge)
{
    // Around a vertex of cloth with crossed diagonals, on a cylinder with a radius of four edges.
    Fan fan = {.valence = 8, .error = 0x1p-24f};
    const double ring[9][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    for (int i = 0; i < 9; i++)
    {
        const double position[3] = {0.04 * sin(ring[i][0] / 4.0), 0.01 * ring[i][1], 0.04 * cos(ring[i][0] / 4.0)};
        for (int axis = 0; axis < 3; axis++)
            fan.points[i].x[axis] = (float)(0.5 + position[axis]);
    }
    FOR_EACH_KERNELS(k)
    ck_assert(IsSeparated(k, &fan, 0.0025f));
}
END_TEST

//  ---- the fans ------------------------------------------------------------------------------------

/// True if the triangles around a vertex form one closed fan, given the `sides` opposite to it: each vertex has two of
/// them, and they are connected.
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

/// The triangles around a vertex, and whether they form a fan.
static bool ListFan(const qcCorners* corners, size_t count, uint32_t vertex, uint32_t* triangles, size_t* found)
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

/// Finds the batch and the lane of a vertex. False: there is none. A vertex has at most one.
static bool FindFan(const qcVertexFans* fans, uint32_t vertex, const qcVertexFanBatch** batch, uint32_t* lane)
{
    int found = 0;
    for (size_t i = 0; i < fans->batches.count; i++)
    {
        const qcVertexFanBatch* b = &QC_AT(qcVertexFanBatch, fans->batches, i);
        ck_assert(b->count > 0 && b->count <= qc_fanLanes);
        for (uint32_t l = 0; l < qc_fanLanes; l++)
        {
            // Empty lanes repeat the first fan.
            uint32_t middle = QC_AT(uint32_t, fans->vertices, b->firstVertex + l);
            ck_assert(l < b->count || middle == QC_AT(uint32_t, fans->vertices, b->firstVertex));
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

/// Returns the number of fans.
static int CheckFans(const qcCorners* corners, size_t count, uint32_t vertexCount)
{
    qcVertexFans fans = {.made = false};
    CHECK_OK(qcVertexFans_Make(&fans, corners, count, vertexCount));
    uint32_t* triangles = malloc((count + 1) * sizeof *triangles);
    ck_assert_ptr_nonnull(triangles);
    int fanCount = 0;
    for (uint32_t v = 0; v < vertexCount; v++)
    {
        size_t found;
        const qcVertexFanBatch* batch = NULL;
        uint32_t lane = 0;
        bool isFan = ListFan(corners, count, v, triangles, &found);
        uint32_t first = QC_AT(uint32_t, fans.around.first, v);
        ck_assert_uint_eq(QC_AT(uint32_t, fans.around.first, v + 1) - first, found);
        for (size_t i = 0; i < found; i++)
            ck_assert_uint_eq(QC_AT(uint32_t, fans.around.triangles, first + i), triangles[i]);
        ck_assert(FindFan(&fans, v, &batch, &lane) == isFan);
        if (!isFan)
            continue;
        fanCount++;
        ck_assert_uint_eq(batch->valence, found);
        const uint32_t* column = &QC_AT(uint32_t, fans.vertices, batch->firstVertex + lane);
        for (uint32_t i = 0; i < batch->valence; i++)
            ck_assert(HasTriangle(corners, triangles, found, column[(1 + i) * qc_fanLanes],
                                  column[(1 + (i + 1) % batch->valence) * qc_fanLanes]));
    }
    free(triangles);
    qcVertexFans_Free(&fans);
    return fanCount;
}

START_TEST(all_closed_fans_of_a_mesh_are_listed)
{
    for (int kind = 0; kind < qc_soupKindCount; kind++)
    {
        qcSoup soup = qcMakeSoup((qcSoupKind)kind, 5);
        // Without its last triangle, and with an empty slot for the previous one.
        qcCorners* corners = (qcCorners*)soup.indices;
        if (soup.triangleCount > 2)
            corners[soup.triangleCount - 2] = (qcCorners){{soup.vertexCount, soup.vertexCount, soup.vertexCount}};
        int count = CheckFans(corners, soup.triangleCount, soup.vertexCount);
        ck_assert(count > 0 || (kind != qc_soupSphere && kind != qc_soupCloth && kind != qc_soupFlat));
        qcSoup_Free(&soup);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(only_closed_fans_within_the_size_limits_are_listed)
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
            // Unchanged; one triangle twice; open; two fans that only share the centre.
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
            found += CheckFans(corners, valence, valence + 2) > 0 && change == 0;
        }
    ck_assert_int_ge(found, qc_maxFanSize - qc_minFanSize + 1);
}
END_TEST

START_TEST(every_fan_among_few_vertices_is_listed)
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
        found += CheckFans(corners, count, vertexCount);
    }
    ck_assert_int_gt(found, 50);
}
END_TEST

QC_RUN_TESTS("vertex_fans", separated_fans_have_no_features_within_the_query_distance,
             lanes_do_not_depend_on_each_other, a_bent_fan_is_separated_within_a_quarter_of_an_edge,
             all_closed_fans_of_a_mesh_are_listed, only_closed_fans_within_the_size_limits_are_listed,
             every_fan_among_few_vertices_is_listed)
