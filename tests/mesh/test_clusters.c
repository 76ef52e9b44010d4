// Clusters against a loop over all pairs of triangles: each triangle in one slot, links and pair masks complete.
#include "support/check_ok.h"
#include "mesh/clusters.h"
#include "support/failing_heap.h"
#include "support/soups.h"
#include "support/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

//  ---- bodies --------------------------------------------------------------------------------------

static qcSoup Allocate(uint32_t vertexCount, uint32_t triangleCount)
{
    qcSoup soup = {calloc(3 * (size_t)vertexCount + 1, sizeof(double)), vertexCount,
                   malloc((3 * (size_t)triangleCount + 1) * sizeof(uint32_t)), triangleCount};
    ck_assert(soup.positions != NULL && soup.indices != NULL);
    return soup;
}

/// Triangles of random vertices, some with the same vertex two or three times. Few vertices: most pairs share one.
static qcSoup MakeTangle(uint64_t seed, uint32_t vertexCount, uint32_t triangleCount)
{
    qcRandom random = {seed};
    qcSoup soup = Allocate(vertexCount, triangleCount);
    for (size_t i = 0; i < 3 * (size_t)vertexCount; i++)
        soup.positions[i] = qcRandom_Uniform(&random, -1.0, 1.0);
    for (size_t i = 0; i < 3 * (size_t)triangleCount; i++)
        soup.indices[i] = qcRandom_Below(&random, vertexCount);
    return soup;
}

/// Triangles around vertex 0, then around vertex 1, ...; each with a rim of its own.
static qcSoup MakeFans(uint32_t fanCount, uint32_t valence)
{
    qcSoup soup = Allocate(fanCount * (valence + 1), fanCount * valence);
    qcRandom random = {7};
    for (size_t i = 0; i < 3 * (size_t)soup.vertexCount; i++)
        soup.positions[i] = qcRandom_Uniform(&random, -1.0, 1.0);
    for (uint32_t t = 0; t < soup.triangleCount; t++)
    {
        uint32_t fan = t / valence, rim = fanCount + fan * valence;
        soup.indices[3 * t] = fan;
        soup.indices[3 * t + 1] = rim + t % valence;
        soup.indices[3 * t + 2] = rim + (t + 1) % valence;
    }
    return soup;
}

/// A sphere of two poles and rings of squares between them: two hubs in one component.
static qcSoup MakeGlobe(uint32_t rings, uint32_t valence)
{
    qcSoup soup = Allocate(2 + rings * valence, 2 * rings * valence);
    soup.positions[2] = 1.0;
    soup.positions[5] = -1.0;
    for (uint32_t i = 0; i < rings * valence; i++)
    {
        double z = 1.0 - 2.0 * (i / valence + 1) / (rings + 1), angle = 6.283185307179586 * (i % valence) / valence;
        soup.positions[3 * (2 + i)] = sqrt(1.0 - z * z) * cos(angle);
        soup.positions[3 * (2 + i) + 1] = sqrt(1.0 - z * z) * sin(angle);
        soup.positions[3 * (2 + i) + 2] = z;
    }
    uint32_t* at = soup.indices;
    for (uint32_t k = 0; k < valence; k++)
    {
        uint32_t next = (k + 1) % valence, last = 2 + (rings - 1) * valence;
        const uint32_t caps[] = {0, 2 + k, 2 + next, 1, last + next, last + k};
        memcpy(at, caps, sizeof caps);
        at += LENGTH(caps);
        for (uint32_t r = 0; r + 1 < rings; r++)
        {
            uint32_t low = 2 + r * valence, high = low + valence;
            const uint32_t square[] = {low + k, high + k, high + next, low + k, high + next, low + next};
            memcpy(at, square, sizeof square);
            at += LENGTH(square);
        }
    }
    ck_assert_ptr_eq(at, soup.indices + 3 * (size_t)soup.triangleCount);
    return soup;
}

/// Both in one, with unused vertices between and after them. Frees the two.
static qcSoup Join(qcSoup a, qcSoup b)
{
    enum
    {
        unused = 5
    };
    qcSoup soup = Allocate(a.vertexCount + b.vertexCount + 2 * unused, a.triangleCount + b.triangleCount);
    uint32_t shift = a.vertexCount + unused;
    memcpy(soup.positions, a.positions, 3 * sizeof(double) * a.vertexCount);
    memcpy(soup.positions + 3 * (size_t)shift, b.positions, 3 * sizeof(double) * b.vertexCount);
    memcpy(soup.indices, a.indices, 3 * sizeof(uint32_t) * a.triangleCount);
    for (size_t i = 0; i < 3 * (size_t)b.triangleCount; i++)
        soup.indices[3 * (size_t)a.triangleCount + i] = b.indices[i] + shift;
    qcSoup_Free(&a);
    qcSoup_Free(&b);
    return soup;
}

/// The triangles in random order.
static qcSoup Shuffle(qcSoup soup, uint64_t seed)
{
    qcRandom random = {seed};
    for (uint32_t t = soup.triangleCount; t > 1; t--)
    {
        uint32_t a[3], *b = soup.indices + 3 * (size_t)qcRandom_Below(&random, t),
                       *c = soup.indices + 3 * (size_t)(t - 1);
        memcpy(a, b, sizeof a);
        memcpy(b, c, sizeof a);
        memcpy(c, a, sizeof a);
    }
    return soup;
}

//  ---- checks -------------------------------------------------------------------------------------

static qcClusters Build(const qcSoup* soup)
{
    qcClusters clusters;
    CHECK_OK(qcClusters_Build(&clusters, soup->indices, soup->triangleCount, soup->positions, soup->vertexCount, 1));
    return clusters;
}

static uint32_t TriangleAt(const qcClusters* c, uint32_t node, uint32_t slotOfNode)
{
    return QC_AT(uint32_t, c->triangles, (size_t)node * qc_nodeSize + slotOfNode);
}

static void CheckTrianglesOnce(const qcClusters* c, const qcSoup* soup)
{
    ck_assert_uint_eq(c->triangles.count, (size_t)c->nodeCount * qc_nodeSize);
    char* seen = calloc(soup->triangleCount + 1, 1);
    uint32_t count = 0;
    for (size_t i = 0; i < c->triangles.count; i++)
    {
        uint32_t t = QC_AT(uint32_t, c->triangles, i);
        if (t == QC_NO_TRIANGLE)
            continue;
        ck_assert_uint_lt(t, soup->triangleCount);
        ck_assert_msg(!seen[t], "triangle %u has two slots", t);
        seen[t] = 1;
        count++;
    }
    ck_assert_uint_eq(count, soup->triangleCount);
    free(seen);
}

static void CheckOrderOfLinks(const qcClusters* c)
{
    ck_assert_uint_eq(c->firstLink.count, (size_t)c->nodeCount + 1);
    ck_assert_uint_eq(QC_AT(uint32_t, c->firstLink, 0), 0);
    ck_assert_uint_eq(QC_AT(uint32_t, c->firstLink, c->nodeCount), c->links.count);
    for (uint32_t node = 0; node < c->nodeCount; node++)
    {
        uint32_t first = QC_AT(uint32_t, c->firstLink, node), end = QC_AT(uint32_t, c->firstLink, node + 1);
        ck_assert_uint_lt(first, end);
        ck_assert_uint_eq(QC_AT(qcLeafLink, c->links, first).other, node);
        for (uint32_t l = first; l < end; l++)
        {
            qcLeafLink link = QC_AT(qcLeafLink, c->links, l);
            ck_assert_uint_lt(link.other, c->nodeCount);
            ck_assert_uint_lt(link.mask + 2, c->pairMasks.count);
            ck_assert(l == first || QC_AT(qcLeafLink, c->links, l - 1).other < link.other);
        }
    }
}

/// The pair mask of two nodes by comparing all their triangles. Returns whether the nodes share a vertex.
static bool CompareAll(const qcClusters* c, const qcSoup* soup, uint32_t a, uint32_t b, uint64_t mask[64])
{
    bool isNear = false;
    memset(mask, 0, 64 * sizeof *mask);
    for (uint32_t p = 0; p < qc_nodeSize; p++)
        for (uint32_t q = 0; q < qc_nodeSize; q++)
        {
            uint32_t t = TriangleAt(c, a, p), u = TriangleAt(c, b, q);
            if (t == QC_NO_TRIANGLE || u == QC_NO_TRIANGLE)
                continue;
            if (qcSoup_AreNeighbours(soup, t, u))
                isNear = true;
            else if (a != b || p < q)
                mask[p / 8 + 8 * (q / 8)] |= UINT64_C(1) << (p % 8 + 8 * (q % 8));
        }
    return isNear;
}

static void CheckPairMasks(const qcClusters* c, const qcSoup* soup)
{
    for (uint32_t a = 0; a < c->nodeCount; a++)
    {
        uint32_t link = QC_AT(uint32_t, c->firstLink, a), end = QC_AT(uint32_t, c->firstLink, a + 1);
        for (uint32_t b = a; b < c->nodeCount; b++)
        {
            uint64_t expected[64];
            bool isNear = CompareAll(c, soup, a, b, expected);
            bool isLinked = link < end && QC_AT(qcLeafLink, c->links, link).other == b;
            ck_assert_msg(isNear == isLinked, "nodes %u and %u: near %d, linked %d", a, b, isNear, isLinked);
            if (!isLinked)
                continue;
            const uint64_t* mask = qcClusters_PairMask(c, link++);
            for (uint32_t word = 0; word < 64; word++)
                if (expected[word] != ((mask[1] >> word & 1u) != 0 ? 0 : qcPairMask_Word(mask, word)))
                    ck_abort_msg("nodes %u and %u, word %u", a, b, word);
            // The word that is read but not used lies within the array.
            size_t last =
                (size_t)(mask - (const uint64_t*)c->pairMasks.data) + 2 + (size_t)__builtin_popcountll(mask[0]);
            ck_assert_uint_lt(last, c->pairMasks.count);
        }
        ck_assert_uint_eq(link, end);
    }
}

static void CheckAll(qcSoup soup)
{
    qcClusters clusters = Build(&soup);
    CheckTrianglesOnce(&clusters, &soup);
    CheckOrderOfLinks(&clusters);
    CheckPairMasks(&clusters, &soup);
    qcClusters_Free(&clusters);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    qcSoup_Free(&soup);
}

static bool AreEqual(const qcArray* a, const qcArray* b, size_t size)
{
    return a->count == b->count && (a->count == 0 || memcmp(a->data, b->data, a->count * size) == 0);
}

/// Percentage of slots in use.
static uint32_t Fill(const qcClusters* c, const qcSoup* soup)
{
    return (uint32_t)(100 * (size_t)soup->triangleCount / c->triangles.count);
}

//  ---- tests ---------------------------------------------------------------------------------------

START_TEST(meshes_have_each_triangle_once_and_all_pairs_in_masks)
{
    CheckAll(qcSoup_MakeFoldedCloth(3, 24, 0.02, 0.03));
    CheckAll(Shuffle(qcSoup_MakeFoldedCloth(4, 17, 0.02, 0.03), 1));
    CheckAll(qcSoup_MakeGrid(9));
    CheckAll(qcSoup_MakeSphere(3, 1.0));
    CheckAll(Shuffle(qcSoup_MakeSphere(2, 1e-300), 2));
}
END_TEST

START_TEST(any_number_of_triangles_has_each_once_and_all_pairs_in_masks)
{
    for (uint32_t n = 0; n <= 140; n++)
    {
        CheckAll(MakeTangle(n, 1 + n, n));
        CheckAll(qcSoup_MakeRandom(n, n, 0.1));
    }
}
END_TEST

START_TEST(tangles_and_soups_have_each_triangle_once_and_all_pairs_in_masks)
{
    const uint32_t vertexCounts[] = {1, 2, 3, 10, 60, 300, 1000, 5000};
    for (size_t i = 0; i < LENGTH(vertexCounts); i++)
        CheckAll(MakeTangle(i, vertexCounts[i], 1000));
    CheckAll(qcSoup_MakeRandom(5, 1000, 0.1));
    CheckAll(qcSoup_MakeDegenerate(6, 1000, 0.1, 0.5));
}
END_TEST

START_TEST(fans_have_each_triangle_once_and_all_pairs_in_masks)
{
    CheckAll(MakeFans(1, 3));
    CheckAll(MakeFans(1, 64));
    CheckAll(MakeFans(3, 700));
    CheckAll(Shuffle(MakeFans(2, 1500), 3));
    CheckAll(MakeGlobe(2, 1100));
    CheckAll(Shuffle(MakeGlobe(3, 500), 4));
}
END_TEST

START_TEST(components_and_unused_vertices_have_each_triangle_once_and_all_pairs_in_masks)
{
    qcSoup soup = qcSoup_MakeSphere(1, 1.0);
    for (int i = 0; i < 6; i++)
        soup = Join(soup, i % 2 != 0 ? qcSoup_MakeGrid(3) : qcSoup_MakeRandom((uint64_t)i, 21, 0.1));
    soup = Join(soup, MakeFans(1, 1200));
    CheckAll(Shuffle(Join(soup, MakeTangle(9, 40, 90)), 5));
}
END_TEST

START_TEST(positions_of_any_size_have_each_triangle_once_and_all_pairs_in_masks)
{
    const double scales[] = {0.0, 5e-324, 1e-310, 1e300, 1.7976931348623157e308};
    for (size_t i = 0; i < LENGTH(scales); i++)
    {
        qcSoup soup = Join(qcSoup_MakeSphere(2, 1.0), MakeTangle(i, 500, 400));
        for (size_t k = 0; k < 3 * (size_t)soup.vertexCount; k++)
            soup.positions[k] *= scales[i];
        CheckAll(soup);
    }
}
END_TEST

START_TEST(the_same_body_has_the_same_clusters)
{
    qcSoup soup = Shuffle(Join(qcSoup_MakeFoldedCloth(2, 20, 0.02, 0.03), MakeTangle(3, 200, 300)), 6);
    qcClusters a = Build(&soup), b = Build(&soup);
    ck_assert_uint_eq(a.nodeCount, b.nodeCount);
    ck_assert(AreEqual(&a.triangles, &b.triangles, sizeof(uint32_t)));
    ck_assert(AreEqual(&a.firstLink, &b.firstLink, sizeof(uint32_t)));
    ck_assert(AreEqual(&a.links, &b.links, sizeof(qcLeafLink)));
    ck_assert(AreEqual(&a.pairMasks, &b.pairMasks, sizeof(uint64_t)));
    qcClusters_Free(&a);
    qcClusters_Free(&b);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(a_body_without_triangles_has_no_nodes)
{
    qcSoup soup = Allocate(3, 0);
    qcClusters clusters = Build(&soup);
    ck_assert_uint_eq(clusters.nodeCount, 0);
    ck_assert_uint_eq(clusters.firstLink.count, 1);
    ck_assert_uint_eq(clusters.links.count + clusters.triangles.count, 0);
    qcClusters_Free(&clusters);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(few_slots_of_meshes_and_soups_are_empty)
{
    qcSoup soups[] = {qcSoup_MakeFoldedCloth(2, 60, 0.02, 0.03), Shuffle(qcSoup_MakeSphere(5, 1.0), 7),
                      Join(qcSoup_MakeGrid(33), qcSoup_MakeGrid(47)), qcSoup_MakeRandom(8, 5000, 0.1)};
    for (size_t i = 0; i < LENGTH(soups); i++)
    {
        qcClusters clusters = Build(&soups[i]);
        ck_assert_uint_ge(Fill(&clusters, &soups[i]), 95);
        qcClusters_Free(&clusters);
        qcSoup_Free(&soups[i]);
    }
}
END_TEST

START_TEST(a_mesh_has_few_links)
{
    // Rectangles on a plane, four to a corner, have eight neighbours: four later ones and itself. One more for folds.
    qcSoup soup = Shuffle(qcSoup_MakeFoldedCloth(2, 100, 0.2, 0.03), 8);
    qcClusters clusters = Build(&soup);
    ck_assert_uint_lt(clusters.links.count, (size_t)clusters.nodeCount * 6);
    qcClusters_Free(&clusters);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(the_nodes_of_a_large_fan_share_one_pair_mask)
{
    qcSoup soup = Shuffle(MakeFans(1, 20000), 9);
    qcClusters clusters = Build(&soup);
    CheckTrianglesOnce(&clusters, &soup);
    CheckOrderOfLinks(&clusters);
    size_t nodes = clusters.nodeCount;
    ck_assert_uint_eq(nodes, (20000 + 63) / 64);
    ck_assert_uint_eq(clusters.links.count, nodes * (nodes + 1) / 2);
    // No word has any bits: two words, and the one more that may be read.
    ck_assert_uint_eq(clusters.pairMasks.count, 3);
    ck_assert_uint_eq(qcClusters_PairMask(&clusters, 0)[1], UINT64_MAX);
    qcClusters_Free(&clusters);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(two_large_fans_on_one_rim_have_few_pair_masks)
{
    qcSoup soup = Shuffle(MakeGlobe(1, 20000), 10);
    qcClusters clusters = Build(&soup);
    CheckTrianglesOnce(&clusters, &soup);
    CheckOrderOfLinks(&clusters);
    ck_assert_uint_gt(clusters.links.count, (size_t)clusters.nodeCount * clusters.nodeCount / 4);
    ck_assert_uint_lt(clusters.pairMasks.count, (size_t)clusters.nodeCount * 100);
    qcClusters_Free(&clusters);
    qcSoup_Free(&soup);
}
END_TEST

//  ---- numbers of vertices -------------------------------------------------------------------------

/// The numbers as documented: in the order in which slots use the vertices.
static void CheckNumbers(const qcClusters* clusters, const qcSoup* soup, const qcCorners* corners,
                         const qcArray* vertexOf)
{
    uint32_t* number = malloc(soup->vertexCount * sizeof(uint32_t));
    ck_assert_ptr_nonnull(number);
    memset(number, 0xff, soup->vertexCount * sizeof(uint32_t));
    uint32_t count = 0;
    for (size_t slot = 0; slot < clusters->triangles.count; slot++)
        for (size_t k = 0; k < 3; k++)
        {
            size_t triangle = QC_AT(uint32_t, clusters->triangles, slot);
            uint32_t expected = (uint32_t)vertexOf->count;
            if (triangle != QC_NO_TRIANGLE)
            {
                uint32_t v = soup->indices[3 * triangle + k];
                number[v] = number[v] == UINT32_MAX ? count++ : number[v];
                expected = number[v];
                ck_assert_uint_eq(QC_AT(uint32_t, *vertexOf, expected), v);
            }
            ck_assert_uint_eq(corners[slot].vertex[k], expected);
        }
    ck_assert_uint_eq(vertexOf->count, count);
    free(number);
}

START_TEST(any_number_of_threads_numbers_vertices_in_the_order_of_first_use)
{
    // A surface, triangles that share vertices far apart, and hubs, whose nodes have empty slots.
    qcSoup soups[] = {Shuffle(MakeGlobe(40, 500), 3), MakeTangle(4, 9000, 40001), MakeFans(30, 1100)};
    for (size_t i = 0; i < LENGTH(soups); i++)
    {
        qcClusters clusters;
        CHECK_OK(qcClusters_Arrange(&clusters, soups[i].indices, soups[i].triangleCount, soups[i].positions,
                                    soups[i].vertexCount, &(qcOrderOptions){.threads = 1}));
        for (uint32_t threads = 1; threads <= 16; threads += threads < 4 ? 1 : 6)
        {
            qcArray corners = {0}, vertexOf = {0};
            CHECK_OK(qcClusters_NumberVertices(&clusters, soups[i].indices, soups[i].vertexCount, threads, &corners,
                                               &vertexOf));
            CheckNumbers(&clusters, &soups[i], corners.data, &vertexOf);
            qcArray_Free(&corners);
            qcArray_Free(&vertexOf);
        }
        qcClusters_Free(&clusters);
        qcSoup_Free(&soups[i]);
    }
}
END_TEST

//  ---- out of memory -------------------------------------------------------------------------------

START_TEST(a_failed_allocation_leaves_nothing)
{
    qcSoup soup = Join(qcSoup_MakeFoldedCloth(2, 30, 0.02, 0.03), MakeFans(1, 1100));
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcClusters clusters = Build(&soup);
    qcClusters_Free(&clusters);
    size_t calls = heap.calls;
    ck_assert_uint_gt(calls, 20);
    for (size_t i = 1; i <= calls; i++)
    {
        heap = (qcFailingHeap){0, 0, i};
        memset(&clusters, 0xff, sizeof clusters);
        qcStatus status =
            qcClusters_Build(&clusters, soup.indices, soup.triangleCount, soup.positions, soup.vertexCount, 1);
        ck_assert_int_eq(status, qc_statusOutOfMemory);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "out of memory"));
        ck_assert_uint_eq(heap.live, 0);
        ck_assert_uint_eq(qcGetByteCount(), 0);
        ck_assert_uint_eq(clusters.nodeCount, 0);
        qcClusters_Free(&clusters);
    }
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
    qcSoup_Free(&soup);
}
END_TEST

QC_RUN_TESTS("clusters", meshes_have_each_triangle_once_and_all_pairs_in_masks,
             any_number_of_triangles_has_each_once_and_all_pairs_in_masks,
             tangles_and_soups_have_each_triangle_once_and_all_pairs_in_masks,
             fans_have_each_triangle_once_and_all_pairs_in_masks,
             components_and_unused_vertices_have_each_triangle_once_and_all_pairs_in_masks,
             positions_of_any_size_have_each_triangle_once_and_all_pairs_in_masks, the_same_body_has_the_same_clusters,
             a_body_without_triangles_has_no_nodes, few_slots_of_meshes_and_soups_are_empty, a_mesh_has_few_links,
             the_nodes_of_a_large_fan_share_one_pair_mask, two_large_fans_on_one_rim_have_few_pair_masks,
             any_number_of_threads_numbers_vertices_in_the_order_of_first_use, a_failed_allocation_leaves_nothing)
