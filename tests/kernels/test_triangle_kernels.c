// The box kernels and the pair masks of every instruction set that this CPU has, against one vertex, one box or one
// pair at a time. (Boxes of another BVH: kernels/test_lattice_transform.c.)
#define _POSIX_C_SOURCE 200809L // setenv
#include "kernels/boxes.h"
#include "support/suite.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

//  ---- boxes one at a time -------------------------------------------------------------------------

static Box BoxOfRow(const qcBoxRow* row)
{
    Box box;
    for (int axis = 0; axis < 3; axis++)
    {
        box.lower[axis] = row->ends[axis] + 32768;
        box.upper[axis] = -1 - row->ends[axis + 4] + 32768;
    }
    return box;
}

static void PutInRow(const Box* box, qcBoxRow* row)
{
    for (int axis = 0; axis < 3; axis++)
    {
        row->ends[axis] = (int16_t)(box->lower[axis] - 32768);
        row->ends[axis + 4] = (int16_t)(-1 - (box->upper[axis] - 32768));
    }
    row->ends[3] = row->ends[7] = 0;
}

static Box Around(Box a, Box b)
{
    for (int axis = 0; axis < 3; axis++)
    {
        a.lower[axis] = a.lower[axis] < b.lower[axis] ? a.lower[axis] : b.lower[axis];
        a.upper[axis] = a.upper[axis] > b.upper[axis] ? a.upper[axis] : b.upper[axis];
    }
    return a;
}

static const struct
{
    int first, spread;
} s_ranges[] = {{0, 3}, {65530, 3}, {0, 65533}, {32766, 3}, {0, 300}, {100, 12}};

//  ---- vertices ------------------------------------------------------------------------------------

START_TEST(a_vertex_becomes_its_point_and_its_levels)
{
    enum
    {
        count = 500,
        first = 3,
        end = count - 2
    };
    qcRandom random = {1};
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 40; round++)
    {
        static double positions[3 * count];
        static uint32_t vertexOf[count];
        static qcPoint points[count];
        static qcBoxRow rows[count];
        qcLatticeTransform map = {.origin = {0.0}};
        double margin = round % 3 == 0 ? 0.0 : 0.01;
        for (int axis = 0; axis < 3; axis++)
        {
            double extent = qcRandom_Uniform(&random, 1e-3, 1.0);
            map.origin[axis] = round % 2 == 0 ? qcRandom_Uniform(&random, -1.0, 1.0) : 1e9;
            map.margin[axis] = margin;
            map.scale[axis] = 65533.0 * (1.0 - 1e-12) / (extent + margin);
            map.unit[axis] = 0.5;
            // The last vertex, and one in eight besides, lies at the upper end.
            for (int i = 0; i < count; i++)
                positions[3 * i + axis] =
                    map.origin[axis] + (i % 8 == 7 ? extent : qcRandom_Uniform(&random, 0.0, extent)) * (1 - 1e-6);
        }
        for (uint32_t i = 0; i < count; i++)
            vertexOf[i] = i * 7 % count;
        memset(rows, 0x55, sizeof rows);
        memset(points, 0x55, sizeof points);
        qcBoxRow untouched = rows[0];
        qcVertexRange range = {{.doubles = positions, .vertexOf = vertexOf}, first, end};
        k->transformVertices(&map, &range, points, rows);
        for (size_t i = 0; i < count; i++)
        {
            if (i < first || i >= end)
            {
                ck_assert_mem_eq(&rows[i], &untouched, sizeof untouched);
                continue;
            }
            const double* x = positions + 3 * (size_t)vertexOf[i];
            Box box;
            for (int axis = 0; axis < 3; axis++)
            {
                box.lower[axis] = (int)floor((x[axis] - map.origin[axis]) * map.scale[axis]);
                box.upper[axis] = (int)floor((x[axis] + margin - map.origin[axis]) * map.scale[axis]);
                CHECK_THAT(points[i].x[axis] == (float)((x[axis] - map.origin[axis]) * map.unit[axis]), "%s: point %zu",
                           k->name, i);
            }
            CHECK_THAT(points[i].x[3] == 0.0f, "%s: point %zu", k->name, i);
            CheckBox(BoxOfRow(&rows[i]), box, k->name, i);
        }
    }
}
END_TEST

/// Random vertices as floats and, with equal values, as doubles; their lattice.
typedef struct TwinVertices
{
    float floats[3 * 200 + 1];
    double doubles[3 * 200];
    uint32_t vertexOf[200];
    qcLatticeTransform map;
} TwinVertices;

static TwinVertices MakeTwins(qcRandom* random, double origin, double margin)
{
    TwinVertices twins = {.floats = {0.0f}};
    for (uint32_t i = 0; i < LENGTH(twins.doubles); i++)
    {
        twins.floats[i] = (float)(origin + qcRandom_Uniform(random, 0.0, 1.0));
        twins.doubles[i] = (double)twins.floats[i];
    }
    twins.floats[LENGTH(twins.doubles)] = -1.0f;
    for (uint32_t i = 0; i < LENGTH(twins.vertexOf); i++)
        twins.vertexOf[i] = i * 7 % LENGTH(twins.vertexOf);
    for (int axis = 0; axis < 3; axis++)
    {
        twins.map.origin[axis] = origin - 1e-3;
        twins.map.margin[axis] = margin;
        twins.map.scale[axis] = 65533.0 / 1.1;
        twins.map.unit[axis] = 0.5;
    }
    return twins;
}

START_TEST(vertices_as_floats_become_the_points_and_levels_of_doubles)
{
    qcRandom random = {3};
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 40; round++)
    {
        TwinVertices twins = MakeTwins(&random, round % 2 == 0 ? 0.0 : 1000.0, round % 3 == 0 ? 0.0 : 0.01);
        enum
        {
            count = LENGTH(twins.vertexOf)
        };
        qcPoint points[2][count];
        qcBoxRow rows[2][count];
        const qcVertexRange ofDoubles = {{.doubles = twins.doubles, .vertexOf = twins.vertexOf}, 0, count};
        const qcVertexRange ofFloats = {{.floats = twins.floats, .vertexOf = twins.vertexOf}, 0, count};
        k->transformVertices(&twins.map, &ofDoubles, points[0], rows[0]);
        k->transformVertices(&twins.map, &ofFloats, points[1], rows[1]);
        ck_assert_mem_eq(points[0], points[1], sizeof points[0]);
        ck_assert_mem_eq(rows[0], rows[1], sizeof rows[0]);
    }
}
END_TEST

START_TEST(the_row_of_a_leaf_node_is_around_those_of_its_vertices)
{
    // Own vertices and shared ones, one kind alone, and none.
    uint32_t firstOwn[] = {0, 40, 40, 90, 90, 200}, firstShared[] = {0, 0, 5, 9, 9, 12};
    uint32_t shared[] = {3, 1, 39, 20, 7, 39, 2, 0, 11, 89, 45, 12};
    const qcNodeVertices vertices = {
        .firstOwn = {.data = firstOwn}, .firstShared = {.data = firstShared}, .shared = {.data = shared}};
    qcRandom random = {4};
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 40; round++)
    {
        TwinVertices twins = MakeTwins(&random, round % 2 == 0 ? 0.0 : -1000.0, round % 3 == 0 ? 0.0 : 0.01);
        enum
        {
            count = LENGTH(twins.vertexOf),
            nodeCount = LENGTH(firstOwn) - 1
        };
        qcPoint points[count];
        qcBoxRow rows[count], around[nodeCount];
        qcVertexSource source = {.doubles = twins.doubles, .vertexOf = twins.vertexOf};
        const qcVertexRange all = {source, 0, count};
        k->transformVertices(&twins.map, &all, points, rows);
        if (round % 4 < 2)
            source = (qcVertexSource){.floats = twins.floats, .vertexOf = twins.vertexOf};
        k->boundNodes(&twins.map, &source, &vertices, 0, 2, around);
        k->boundNodes(&twins.map, &source, &vertices, 2, nodeCount, around);
        for (size_t node = 0; node < nodeCount; node++)
        {
            Box box = EmptyBox();
            for (uint32_t i = firstOwn[node]; i < firstOwn[node + 1]; i++)
                box = Around(box, BoxOfRow(&rows[i]));
            for (uint32_t j = firstShared[node]; j < firstShared[node + 1]; j++)
                box = Around(box, BoxOfRow(&rows[shared[j]]));
            CheckBox(BoxOfRow(&around[node]), box, k->name, node);
        }
    }
}
END_TEST

//  ---- boxes ---------------------------------------------------------------------------------------

START_TEST(boxes_of_triangles_and_their_rows_are_tight)
{
    enum
    {
        vertexCount = 90,
        box8Count = 11,
        first = 2,
        end = 10
    };
    qcRandom random = {2};
    FOR_EACH_KERNELS(k)
    for (size_t r = 0; r < LENGTH(s_ranges); r++)
    {
        qcBoxRow vertices[vertexCount], rows[box8Count];
        Box boxes[vertexCount];
        qcCorners corners[box8Count * qc_boxLanes];
        qcBox8 fitted[box8Count], untouched;
        for (int i = 0; i < vertexCount; i++)
        {
            boxes[i] = i == vertexCount - 1 ? EmptyBox() : MakeBox(&random, s_ranges[r].first, s_ranges[r].spread);
            PutInRow(&boxes[i], &vertices[i]);
        }
        for (size_t i = 0; i < LENGTH(corners); i++)
            for (int c = 0; c < 3; c++)
                corners[i].vertex[c] = i % 5 == 4 ? vertexCount - 1 : qcRandom_Below(&random, vertexCount);
        memset(fitted, 0x55, sizeof fitted);
        memset(rows, 0x55, sizeof rows);
        untouched = fitted[0];
        k->fitTriangles(corners, vertices, first, end, fitted, rows);
        for (size_t g = 0; g < box8Count; g++)
        {
            if (g < first || g >= end)
            {
                ck_assert_mem_eq(&fitted[g], &untouched, sizeof untouched);
                ck_assert_mem_eq(&rows[g], &untouched, sizeof rows[g]);
                continue;
            }
            Box around = EmptyBox();
            for (size_t i = 0; i < qc_boxLanes; i++)
            {
                const uint32_t* c = corners[g * qc_boxLanes + i].vertex;
                Box box = Around(Around(boxes[c[0]], boxes[c[1]]), boxes[c[2]]);
                CheckBox(BoxAt(&fitted[g], (int)i), box, k->name, i);
                around = Around(around, box);
            }
            CheckBox(BoxOfRow(&rows[g]), around, k->name, g);
        }
    }
}
END_TEST

START_TEST(boxes_of_nodes_are_those_of_their_children)
{
    enum
    {
        box8Count = 9,
        first = 1,
        end = 8
    };
    qcRandom random = {3};
    FOR_EACH_KERNELS(k)
    for (size_t r = 0; r < LENGTH(s_ranges); r++)
    {
        qcBoxRow children[box8Count * qc_boxLanes], rows[box8Count];
        Box boxes[box8Count * qc_boxLanes];
        qcBox8 fitted[box8Count], untouched;
        for (size_t i = 0; i < LENGTH(boxes); i++)
        {
            boxes[i] = MakeBox(&random, s_ranges[r].first, s_ranges[r].spread);
            PutInRow(&boxes[i], &children[i]);
        }
        memset(fitted, 0x55, sizeof fitted);
        untouched = fitted[0];
        k->fitBoxes(children, first, end, fitted, rows);
        ck_assert_mem_eq(&fitted[first - 1], &untouched, sizeof untouched);
        ck_assert_mem_eq(&fitted[end], &untouched, sizeof untouched);
        for (size_t g = first; g < end; g++)
        {
            Box around = EmptyBox();
            for (size_t i = 0; i < qc_boxLanes; i++)
            {
                CheckBox(BoxAt(&fitted[g], (int)i), boxes[g * qc_boxLanes + i], k->name, i);
                around = Around(around, boxes[g * qc_boxLanes + i]);
            }
            CheckBox(BoxOfRow(&rows[g]), around, k->name, g);
        }
    }
}
END_TEST

static uint64_t CompareOneByOne(const qcBox8* a, const qcBox8* b)
{
    uint64_t overlaps = 0;
    for (int i = 0; i < qc_boxLanes; i++)
        for (int j = 0; j < qc_boxLanes; j++)
            overlaps |= (uint64_t)Overlap(BoxAt(a, i), BoxAt(b, j)) << (i + 8 * j);
    return overlaps;
}

START_TEST(bits_are_set_for_overlapping_boxes)
{
    qcRandom random = {4};
    size_t meetings = 0, all = 0;
    FOR_EACH_KERNELS(k)
    for (size_t r = 0; r < LENGTH(s_ranges); r++)
        for (int round = 0; round < 3000; round++)
        {
            qcBox8 a, b;
            MakeBox8(&random, s_ranges[r].first, s_ranges[r].spread, &a);
            MakeBox8(&random, s_ranges[r].first, s_ranges[r].spread, &b);
            uint64_t expected = CompareOneByOne(&a, &b);
            CHECK_THAT(k->findOverlaps(&a, &b) == expected, "%s: %llx, expected %llx", k->name,
                       (unsigned long long)k->findOverlaps(&a, &b), (unsigned long long)expected);
            meetings += (size_t)__builtin_popcountll(expected);
            all += 64;
        }
    ck_assert_uint_gt(meetings, all / 8);
    ck_assert_uint_lt(meetings, all / 8 * 7);
}
END_TEST

/// Apart along one axis, in the same order at both ends.
static bool StayApart(const Box a[2], const Box b[2])
{
    for (int axis = 0; axis < 3; axis++)
    {
        bool above = true, below = true;
        for (int t = 0; t < 2; t++)
        {
            above = above && a[t].lower[axis] > b[t].upper[axis];
            below = below && a[t].upper[axis] < b[t].lower[axis];
        }
        if (above || below)
            return true;
    }
    return false;
}

START_TEST(bits_of_a_motion_are_set_for_boxes_that_no_order_separates)
{
    qcRandom random = {6};
    size_t meetings = 0, swaps = 0, all = 0;
    FOR_EACH_KERNELS(k)
    for (size_t r = 0; r < LENGTH(s_ranges); r++)
        for (int round = 0; round < 3000; round++)
        {
            qcBox8 a[2], b[2];
            for (int t = 0; t < 2; t++)
            {
                MakeBox8(&random, s_ranges[r].first, s_ranges[r].spread, &a[t]);
                MakeBox8(&random, s_ranges[r].first, s_ranges[r].spread, &b[t]);
            }
            const qcBox8 *const ofA[2] = {&a[0], &a[1]}, *const ofB[2] = {&b[0], &b[1]};
            uint64_t expected = 0;
            for (int i = 0; i < qc_boxLanes; i++)
                for (int j = 0; j < qc_boxLanes; j++)
                {
                    const Box p[2] = {BoxAt(&a[0], i), BoxAt(&a[1], i)}, q[2] = {BoxAt(&b[0], j), BoxAt(&b[1], j)};
                    bool apart = StayApart(p, q);
                    expected |= (uint64_t)!apart << (i + 8 * j);
                    swaps += !apart && !Overlap(p[0], q[0]) && !Overlap(p[1], q[1]);
                }
            uint64_t found = k->findMotionOverlaps(ofA, ofB);
            CHECK_THAT(found == expected, "%s: %llx, expected %llx", k->name, (unsigned long long)found,
                       (unsigned long long)expected);
            meetings += (size_t)__builtin_popcountll(expected);
            all += 64;
        }
    ck_assert_uint_gt(meetings, all / 8);
    ck_assert_uint_lt(meetings, all / 8 * 7);
    ck_assert_uint_gt(swaps, all / 100);
}
END_TEST

//  ---- pairs of two nodes --------------------------------------------------------------------------

/// The arguments of collectPairs besides the nodes.
typedef struct Choice
{
    const uint64_t* words;
    const qcPairExclusion* skips;
    int skipCount;
} Choice;

static bool IsChosen(const Choice* choice, uint32_t p, uint32_t q)
{
    uint32_t word = p / 8 + 8 * (q / 8), bit = p % 8 + 8 * (q % 8);
    for (int i = 0; i < choice->skipCount; i++)
        if ((choice->skips[i].a >> p & 1) != 0 && (choice->skips[i].b >> q & 1) != 0)
            return false;
    return choice->words == NULL || (choice->words[word] >> bit & 1) != 0;
}

static size_t CollectOneByOne(const Nodes* a, uint32_t nodeA, const Nodes* b, uint32_t nodeB, const Choice* choice,
                              qcSlotPair* pairs)
{
    size_t count = 0;
    for (uint32_t p = 0; p < qc_nodeSize; p++)
        for (uint32_t q = 0; q < qc_nodeSize; q++)
        {
            uint32_t i = p / 8, j = q / 8;
            if (IsChosen(choice, p, q) && Overlap(BoxAt(&a->nodes[nodeA], (int)i), BoxAt(&b->nodes[nodeB], (int)j)) &&
                Overlap(BoxAt(&a->clusters[nodeA * 8 + i], (int)p % 8), BoxAt(&b->clusters[nodeB * 8 + j], (int)q % 8)))
                pairs[count++] = (qcSlotPair){nodeA * qc_nodeSize + p, nodeB * qc_nodeSize + q};
        }
    return count;
}

START_TEST(collected_pairs_overlap_have_their_bit_set_and_are_not_excluded)
{
    static qcSlotPair found[qc_maxPairs], expected[qc_maxPairs];
    qcRandom random = {5};
    size_t pairs = 0;
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 90; round++)
    {
        Nodes a, b;
        MakeNodes(&random, 1 + round % 9, &a);
        MakeNodes(&random, 1 + round % 9, &b);
        uint64_t words[qc_nodeSize];
        for (int i = 0; i < qc_nodeSize; i++)
            words[i] = i % 3 == 0 ? 0 : i % 5 == 0 ? UINT64_MAX : qcRandom_Next(&random);
        uint64_t table[qc_maxPairMaskSize + 1];
        table[qcPairMask_Pack(words, table)] = qcRandom_Next(&random);
        qcPairExclusion skips[qc_maxExclusions];
        for (int i = 0; i < qc_maxExclusions; i++)
            skips[i] = (qcPairExclusion){qcRandom_Next(&random) & qcRandom_Next(&random), qcRandom_Next(&random)};
        Choice choice = {round % 2 == 0 ? words : NULL, skips, round % 3 == 0 ? round / 3 % (qc_maxExclusions + 1) : 0};
        uint32_t nodeA = qcRandom_Below(&random, qc_nodesInTest), nodeB = qcRandom_Below(&random, qc_nodesInTest);
        qcBvhBoxes sideA = {a.clusters, a.nodes}, sideB = {b.clusters, b.nodes};
        size_t count = (size_t)(k->collectPairs(&sideA, nodeA, &sideB, nodeB, choice.words != NULL ? table : NULL,
                                                skips, choice.skipCount, NULL, found) -
                                found);
        size_t expectedCount = CollectOneByOne(&a, nodeA, &b, nodeB, &choice, expected);
        CheckSamePairs(found, count, expected, expectedCount, k->name);
        pairs += count;
    }
    ck_assert_uint_gt(pairs, 1000);
}
END_TEST

//  ---- choice --------------------------------------------------------------------------------------

//  ---- common vertices -----------------------------------------------------------------------------

static bool HaveCommonVertex(const qcClusterVertices* a, int u, const qcClusterVertices* b, int v)
{
    bool common = false;
    for (int i = 0; i < 9; i++)
        common = common || a->vertex[i / 3][u] == b->vertex[i % 3][v];
    return common;
}

/// Compares the mask of all clusters of two nodes with all pairs of their triangles.
static void CheckPairMask(const qcTriangleKernels* k, const qcClusterVertices* a, const qcClusterVertices* b)
{
    uint64_t packed[qc_maxPairMaskSize + 1];
    uint32_t neighbours = 0, found = k->findPairMask(a, b, UINT64_MAX, packed);
    for (uint32_t word = 0; word < qc_pairMaskWords; word++)
    {
        uint32_t i = word % qc_boxLanes, j = word / qc_boxLanes;
        uint64_t expected = 0;
        for (int bit = 0; bit < 64; bit++)
        {
            int u = bit % 8, v = bit / 8;
            if (a == b && (i > j || (i == j && u >= v)))
                continue;
            bool common = HaveCommonVertex(&a[i], u, &b[j], v);
            neighbours += common;
            expected |= (uint64_t)!common << bit;
        }
        uint64_t own = (packed[1] >> word & 1u) != 0 ? 0 : qcPairMask_Word(packed, word);
        ck_assert_uint_eq(own, expected);
    }
    ck_assert_uint_eq(found, neighbours);
}

START_TEST(pairs_with_a_common_vertex_have_no_bit_whatever_the_numbers)
{
    // Numbers that differ in their lower halves alone, in the upper ones alone, and in both; also across 2^16 and 2^31.
    const struct
    {
        uint32_t first, count, step;
    } numbers[] = {{0, 40, 1},       {65500, 80, 1},      {7, 40, 65536},           {65535, 90, 65535},
                   {1000, 300, 257}, {0, 4000000000u, 1}, {0x7ffffff0u, 40, 1},     {0, 90, 32768},
                   {0, 3, 65536},    {3, 2, 1},           {UINT32_MAX - 500, 90, 1}};
    qcRandom random = {5};
    FOR_EACH_KERNELS(k)
    for (size_t n = 0; n < LENGTH(numbers); n++)
        for (int round = 0; round < 6; round++)
        {
            qcClusterVertices nodes[2][qc_boxLanes];
            for (int i = 0; i < 2 * 8 * 24; i++)
                nodes[i / 192][i / 24 % 8].vertex[i % 3][i / 3 % 8] =
                    numbers[n].first + numbers[n].step * qcRandom_Below(&random, numbers[n].count);
            CheckPairMask(k, nodes[0], nodes[1]);
            CheckPairMask(k, nodes[0], nodes[0]);
        }
}
END_TEST

START_TEST(the_environment_selects_the_kernels)
{
    unsetenv("QC_KERNELS");
    const qcTriangleKernels* best = qcTriangleKernels_Get();
    FOR_EACH_KERNELS(k)
    {
        ck_assert(qcTriangleKernels_Nth(kernelIndex + 1) != NULL || best == k);
        setenv("QC_KERNELS", k->name, 1);
        ck_assert_ptr_eq(qcTriangleKernels_Get(), k);
    }
    setenv("QC_KERNELS", "no such kernels", 1);
    ck_assert_ptr_eq(qcTriangleKernels_Get(), best);
    ck_assert_str_eq(qcTriangleKernels_Nth(0)->name, "plain");
}
END_TEST

QC_RUN_TESTS("triangle_kernels", a_vertex_becomes_its_point_and_its_levels,
             vertices_as_floats_become_the_points_and_levels_of_doubles,
             the_row_of_a_leaf_node_is_around_those_of_its_vertices, boxes_of_triangles_and_their_rows_are_tight,
             boxes_of_nodes_are_those_of_their_children, bits_are_set_for_overlapping_boxes,
             bits_of_a_motion_are_set_for_boxes_that_no_order_separates,
             collected_pairs_overlap_have_their_bit_set_and_are_not_excluded,
             pairs_with_a_common_vertex_have_no_bit_whatever_the_numbers, the_environment_selects_the_kernels)
