// The cluster order: each triangle once, wherever the triangles lie; clusters as small where coordinates span very
// different sizes as elsewhere; the same order with any number of threads.
#include "support/check_ok.h"
#include "mesh/cluster_order.h"
#include "mesh/limits.h"
#include "mesh/small_order.h"
#include "support/soups.h"
#include "support/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

/// The slots with these threads; nodes are full but for the last.
static qcArray Order(const qcSoup* soup, uint32_t threads)
{
    qcArray slots = {0};
    qcOrderSummary summary;
    CHECK_OK(qcClusterOrder_Make(&slots, soup->indices, soup->triangleCount, soup->positions, soup->vertexCount,
                                 &(qcOrderOptions){.threads = threads}, &summary));
    ck_assert(!summary.hasHub && !summary.isLimited);
    ck_assert_uint_eq(slots.count, ((size_t)soup->triangleCount + qc_nodeSize - 1) / qc_nodeSize * qc_nodeSize);
    return slots;
}

static void CheckOnce(const qcSoup* soup, const qcArray* slots)
{
    char* seen = calloc(soup->triangleCount, 1);
    ck_assert_ptr_nonnull(seen);
    for (size_t i = 0; i < slots->count; i++)
    {
        uint32_t triangle = QC_AT(uint32_t, *slots, i);
        ck_assert((triangle == QC_NO_TRIANGLE) == (i >= soup->triangleCount));
        if (triangle == QC_NO_TRIANGLE)
            continue;
        ck_assert_uint_lt(triangle, soup->triangleCount);
        ck_assert(!seen[triangle]);
        seen[triangle] = 1;
    }
    free(seen);
}

/// Triangles without extent, at one point each.
static qcSoup MakePoints(uint32_t count)
{
    qcSoup soup = {calloc(3 * (size_t)count, sizeof(double)), count, malloc(3 * (size_t)count * sizeof(uint32_t)),
                   count};
    ck_assert(soup.positions != NULL && soup.indices != NULL);
    for (uint32_t i = 0; i < 3 * count; i++)
        soup.indices[i] = i / 3;
    return soup;
}

enum
{
    point_equal,
    point_twoValues,
    point_ascending,
    point_descending,
    point_halvings,  ///< 2^-k: half of them in any half of what is left
    point_outliers,  ///< few that no sample has
    point_lastBit,   ///< equal but for the last bits of a float
    point_oneAndAll, ///< one triangle far from all others
    point_kinds
};

static double Point(int kind, uint32_t i, uint32_t count, qcRandom* random)
{
    switch (kind)
    {
        case point_twoValues: return i % 3 == 0;
        case point_ascending: return i;
        case point_descending: return -(double)i;
        case point_halvings: return ldexp(1.0, -(int)qcRandom_Below(random, 60));
        case point_outliers: return i % 20011 == 7 ? 1.0 + i : 0.0;
        case point_lastBit: return i == 0 ? 0.0 : 1.0 - ldexp(1.0, -24) * qcRandom_Below(random, 3);
        case point_oneAndAll: return i == count / 2 ? 1e30 : qcRandom_Uniform(random, 0.0, 1.0);
        default: return 5.0;
    }
}

START_TEST(triangles_anywhere_stand_once_in_the_same_order_with_any_number_of_threads)
{
    const uint32_t counts[] = {1, 8, 9, 64, 65, 4095, 4096, 4097, 8193, 70001};
    for (size_t n = 0; n < LENGTH(counts); n++)
        for (int kind = 0; kind < point_kinds; kind++)
        {
            qcSoup soup = MakePoints(counts[n]);
            qcRandom random = {(uint64_t)kind};
            for (uint32_t i = 0; i < counts[n]; i++)
                soup.positions[3 * (size_t)i + (size_t)(kind % 3)] = Point(kind, i, counts[n], &random);
            qcArray slots = Order(&soup, 1), others = Order(&soup, 3);
            CheckOnce(&soup, &slots);
            ck_assert_mem_eq(slots.data, others.data, slots.count * sizeof(uint32_t));
            qcArray_Free(&slots);
            qcArray_Free(&others);
            qcSoup_Free(&soup);
        }
}
END_TEST

/// The mean, over the clusters of triangles below `count` alone, of the cluster's longest side.
static double MeanExtent(const qcSoup* soup, uint32_t count)
{
    qcArray slots = Order(soup, 1);
    double sum = 0.0;
    uint32_t clusters = 0;
    for (size_t first = 0; first < slots.count; first += qc_clusterSize)
    {
        double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, longest = 0.0;
        bool isOfThese = true;
        for (size_t i = first; i < first + qc_clusterSize && isOfThese; i++)
        {
            double corners[3][3];
            isOfThese = QC_AT(uint32_t, slots, i) < count;
            if (isOfThese)
                qcSoup_GetTriangle(soup, QC_AT(uint32_t, slots, i), corners);
            for (int k = 0; k < 9 && isOfThese; k++)
            {
                low[k % 3] = fmin(low[k % 3], corners[k / 3][k % 3]);
                high[k % 3] = fmax(high[k % 3], corners[k / 3][k % 3]);
            }
        }
        if (!isOfThese)
            continue;
        for (int k = 0; k < 3; k++)
            longest = fmax(longest, high[k] - low[k]);
        sum += longest;
        clusters++;
    }
    qcArray_Free(&slots);
    ck_assert_uint_gt(clusters, count / 32);
    return sum / clusters;
}

/// A grid over a square of this side, and more triangles in the unit box behind it.
static qcSoup MakeDetail(uint32_t gridSide, double side, uint32_t others)
{
    qcSoup grid = qcSoup_MakeGrid(gridSide), soup = qcSoup_MakeRandom(1, others, 0.05);
    uint32_t vertices = grid.vertexCount + soup.vertexCount, triangles = grid.triangleCount + soup.triangleCount;
    grid.positions = realloc(grid.positions, 3 * (size_t)vertices * sizeof(double));
    grid.indices = realloc(grid.indices, 3 * (size_t)triangles * sizeof(uint32_t));
    ck_assert(grid.positions != NULL && grid.indices != NULL);
    for (size_t i = 0; i < 3 * (size_t)grid.vertexCount; i++)
        grid.positions[i] *= side;
    memcpy(grid.positions + 3 * (size_t)grid.vertexCount, soup.positions,
           3 * (size_t)soup.vertexCount * sizeof(double));
    for (size_t i = 0; i < 3 * (size_t)soup.triangleCount; i++)
        grid.indices[3 * (size_t)grid.triangleCount + i] = soup.indices[i] + grid.vertexCount;
    grid.vertexCount = vertices;
    grid.triangleCount = triangles;
    qcSoup_Free(&soup);
    return grid;
}

START_TEST(clusters_of_small_details_are_as_small_as_those_of_the_detail_alone)
{
    const double sides[] = {1e-2, 1e-3, 1e-4};
    const struct
    {
        uint32_t gridSide, others;
    } bodies[] = {{40, 200}, {40, 800}, {60, 3000}, {120, 300}};
    for (size_t b = 0; b < LENGTH(bodies); b++)
    {
        qcSoup grid = qcSoup_MakeGrid(bodies[b].gridSide);
        double alone = MeanExtent(&grid, grid.triangleCount);
        for (size_t s = 0; s < LENGTH(sides); s++)
        {
            qcSoup soup = MakeDetail(bodies[b].gridSide, sides[s], bodies[b].others);
            ck_assert_double_lt(MeanExtent(&soup, grid.triangleCount) / sides[s], 1.15 * alone);
            qcSoup_Free(&soup);
        }
        qcSoup_Free(&grid);
    }
}
END_TEST

START_TEST(a_far_vertex_makes_few_clusters_larger)
{
    // All triangles but those around it, which are in the last row.
    const double distances[] = {-1e5, 1e5, -1e9, 1e9, -1e100, 1e300};
    const uint32_t side = 60;
    for (size_t i = 0; i < LENGTH(distances); i++)
    {
        qcSoup grid = qcSoup_MakeGrid(side);
        uint32_t count = grid.triangleCount - 2 * side;
        double alone = MeanExtent(&grid, count);
        double* last = grid.positions + 3 * (size_t)(grid.vertexCount - 1 - side / 2);
        last[0] = last[1] = last[2] = distances[i];
        ck_assert_double_lt(MeanExtent(&grid, count), 1.3 * alone);
        qcSoup_Free(&grid);
    }
}
END_TEST

/// Counts triangles in slots; none is there twice.
static uint32_t CountSlots(const qcSoup* soup, const qcArray* slots)
{
    uint32_t count = 0;
    char* seen = calloc(soup->triangleCount, 1);
    for (size_t i = 0; i < slots->count; i++)
    {
        uint32_t triangle = QC_AT(uint32_t, *slots, i);
        if (triangle == QC_NO_TRIANGLE)
            continue;
        ck_assert_uint_lt(triangle, soup->triangleCount);
        ck_assert(!seen[triangle]);
        seen[triangle] = 1;
        count++;
    }
    free(seen);
    return count;
}

START_TEST(a_limited_order_is_completed_behind_its_slots)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(1, 60, 0.02, 0.05);
    double lower[3], upper[3];
    for (int k = 0; k < 3; k++)
        lower[k] = upper[k] = soup.positions[k];
    for (size_t i = 0; i < 3 * (size_t)soup.vertexCount; i++)
    {
        lower[i % 3] = fmin(lower[i % 3], soup.positions[i]);
        upper[i % 3] = fmax(upper[i % 3], soup.positions[i]);
    }
    // A corner of the cloth, nothing, all of it, and nearly all, of which none is left out either.
    const double shares[][2] = {{0.3, 1.0}, {-1.0, 1.0}, {1.0, 1.0}, {1.0, 0.9}};
    for (uint32_t i = 0; i < 3 * LENGTH(shares); i++)
    {
        double share = shares[i % LENGTH(shares)][0], across = shares[i % LENGTH(shares)][1],
               end[3] = {lower[0] + share * (upper[0] - lower[0]), lower[1] + across * (upper[1] - lower[1]), upper[2]};
        qcRegionCells region;
        qcOrderSummary summary;
        qcArray slots = {0}, first = {0};
        const qcOrderOptions options = {.threads = 1 + i / LENGTH(shares), .region = &region};
        ck_assert(qcRegionCells_Begin(&region, lower, upper));
        if (share > 0.0)
            qcRegionCells_Mark(&region, lower, end, 0.0);
        CHECK_OK(qcClusterOrder_Make(&slots, soup.indices, soup.triangleCount, soup.positions, soup.vertexCount,
                                     &options, &summary));
        ck_assert_int_eq(summary.isLimited, share < 1.0);
        uint32_t count = CountSlots(&soup, &slots);
        ck_assert(share != 0.3 || (count > soup.triangleCount / 5 && count < soup.triangleCount / 2));
        ck_assert_int_eq(count == 1, share < 0.0);
        if (summary.isLimited)
        {
            CHECK_OK(qcArray_Append(&first, &slots, sizeof(uint32_t), "slots"));
            CHECK_OK(qcClusterOrder_Complete(&slots, soup.indices, soup.triangleCount, soup.positions, soup.vertexCount,
                                             &options));
            ck_assert_mem_eq(slots.data, first.data, first.count * sizeof(uint32_t));
        }
        ck_assert_uint_eq(CountSlots(&soup, &slots), soup.triangleCount);
        qcArray_Free(&slots);
        qcArray_Free(&first);
    }
    qcSoup_Free(&soup);
}
END_TEST

/// Centroids of few distinct coordinates, so that many are equal at the medians, or of many.
static void FillCentroids(qcCentroid* centroids, uint32_t count, uint32_t distinct, qcRandom* random)
{
    for (uint32_t i = 0; i < count; i++)
    {
        centroids[i].triangle = 7 * i + 3;
        for (int k = 0; k < 3; k++)
            centroids[i].at[k] = (float)qcRandom_Below(random, distinct) / (float)distinct / (float)(k + 1);
    }
}

/// Each half of the first node's axis lies on its side of the other: the smaller half that is cut off first.
static void CheckFirstCut(const qcCentroid* centroids, const uint32_t* triangles, uint32_t count)
{
    uint32_t lower = qcSmallOrder_CutAt(count, qc_clusterSize);
    bool isCut = false;
    for (int k = 0; k < 3; k++)
    {
        float low = 0.0f, high = 1.0f;
        for (uint32_t i = 0; i < count; i++)
        {
            float x = centroids[(triangles[i] - 3) / 7].at[k];
            if (i < lower)
                low = fmaxf(low, x);
            else
                high = fminf(high, x);
        }
        // The coordinates are rounded to 15 bits.
        isCut = isCut || low <= high + 0x1p-14f;
    }
    ck_assert(isCut);
}

START_TEST(few_triangles_have_the_same_order_with_all_instruction_sets)
{
    enum
    {
        maxCount = qc_maxSmallOrder,
        guard = 64
    };
    qcRandom random = {1};
    qcCentroid *centroids = malloc(maxCount * sizeof *centroids), *memory = malloc((maxCount + 1) * sizeof *memory);
    uint32_t *expected = malloc(maxCount * sizeof *expected), *found = malloc((maxCount + guard) * sizeof *found);
    ck_assert(centroids != NULL && memory != NULL && expected != NULL && found != NULL);
    const uint32_t distinct[] = {1, 2, 9, 100, 1000000};
    for (uint32_t n = 1; n <= maxCount; n += n < 140 ? 1 : 1 + n / 2)
        for (uint32_t d = 0; d < LENGTH(distinct); d++)
        {
            FillCentroids(centroids, n, distinct[d], &random);
            qcOrderKernels_scalar.makeSmallOrder(centroids, n, memory, expected);
            if (n > qc_clusterSize && n <= qc_nodeSize)
                CheckFirstCut(centroids, expected, n);
            for (size_t k = 1; qcOrderKernels_Nth(k) != NULL; k++)
            {
                memset(found, 0xff, (n + guard) * sizeof *found);
                memset(&memory[n], 0xff, sizeof *memory);
                qcOrderKernels_Nth(k)->makeSmallOrder(centroids, n, memory, found);
                ck_assert_mem_eq(found, expected, n * sizeof *found);
                ck_assert_uint_eq(found[n], UINT32_MAX);
                ck_assert_uint_eq(memory[n].triangle, UINT32_MAX);
            }
        }
    free(centroids);
    free(memory);
    free(expected);
    free(found);
}
END_TEST

QC_RUN_TESTS("cluster order", few_triangles_have_the_same_order_with_all_instruction_sets,
             a_limited_order_is_completed_behind_its_slots,
             triangles_anywhere_stand_once_in_the_same_order_with_any_number_of_threads,
             clusters_of_small_details_are_as_small_as_those_of_the_detail_alone,
             a_far_vertex_makes_few_clusters_larger)
