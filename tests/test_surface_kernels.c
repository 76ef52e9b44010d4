// The kernels of every instruction set that the machine has, against one vertex, one box or one pair of boxes at a
// time; maps against wider arithmetic. (The filter: test_surface_filter.c; flat discs: test_surface_flat.c.)
#define _POSIX_C_SOURCE 200809L // setenv
#include "suite.h"
#include "surfaces.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

//  ---- boxes one at a time -------------------------------------------------------------------------

/// From 0 to 65533, both ends included; lower > upper: none.
typedef struct Box
{
    int lower[3], upper[3];
} Box;

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

static Box BoxOfGroup(const qcBoxGroup* group, int i)
{
    Box box;
    for (int axis = 0; axis < 3; axis++)
    {
        box.lower[axis] = group->ends[axis][i] + 32768;
        box.upper[axis] = -1 - group->ends[axis][qc_groupSize + i] + 32768;
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

static void PutInGroup(const Box* box, qcBoxGroup* group, int i)
{
    for (int axis = 0; axis < 3; axis++)
    {
        group->ends[axis][i] = (int16_t)(box->lower[axis] - 32768);
        group->ends[axis][qc_groupSize + i] = (int16_t)(-1 - (box->upper[axis] - 32768));
    }
}

/// Its ends are qc_emptyEnd.
static Box EmptyBox(void)
{
    return (Box){{65535, 65535, 65535}, {0, 0, 0}};
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

static bool Overlap(Box a, Box b)
{
    for (int axis = 0; axis < 3; axis++)
        if (a.lower[axis] > b.upper[axis] || b.lower[axis] > a.upper[axis])
            return false;
    return true;
}

/// Levels first .. first + spread: with a small spread most boxes touch or are next to each other. Some are none.
static Box MakeBox(qcRandom* random, int first, int spread)
{
    if (qcRandom_Below(random, 8) == 0)
        return EmptyBox();
    Box box;
    for (int axis = 0; axis < 3; axis++)
    {
        int a = first + (int)qcRandom_Below(random, (uint32_t)spread + 1),
            b = first + (int)qcRandom_Below(random, (uint32_t)spread + 1);
        box.lower[axis] = a < b ? a : b;
        box.upper[axis] = a < b ? b : a;
    }
    return box;
}

static void MakeGroup(qcRandom* random, int first, int spread, qcBoxGroup* group)
{
    for (int i = 0; i < qc_groupSize; i++)
    {
        Box box = MakeBox(random, first, spread);
        PutInGroup(&box, group, i);
    }
}

static const struct
{
    int first, spread;
} s_ranges[] = {{0, 3}, {65530, 3}, {0, 65533}, {32766, 3}, {0, 300}, {100, 12}};

static void CheckBox(Box found, Box expected, const char* kernels, size_t place)
{
    CHECK_THAT(memcmp(&found, &expected, sizeof found) == 0, "%s: box %zu is %d %d %d .. %d %d %d", kernels, place,
               found.lower[0], found.lower[1], found.lower[2], found.upper[0], found.upper[1], found.upper[2]);
}

//  ---- vertices ------------------------------------------------------------------------------------

START_TEST(a_vertex_has_its_point_and_its_levels)
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
        qcLatticeMap map = {{0.0}, {0.0}, {0.0}, {0.0}};
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
        qcVertexRange range = {positions, vertexOf, first, end};
        k->map(&map, &range, points, rows);
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

//  ---- boxes ---------------------------------------------------------------------------------------

START_TEST(the_boxes_of_triangles_are_around_their_corners_and_those_of_groups_around_them)
{
    enum
    {
        vertexCount = 90,
        groupCount = 11,
        first = 2,
        end = 10
    };
    qcRandom random = {2};
    FOR_EACH_KERNELS(k)
    for (size_t r = 0; r < LENGTH(s_ranges); r++)
    {
        qcBoxRow vertices[vertexCount], rows[groupCount];
        Box boxes[vertexCount];
        qcCorners corners[groupCount * qc_groupSize];
        qcBoxGroup groups[groupCount], untouched;
        for (int i = 0; i < vertexCount; i++)
        {
            boxes[i] = i == vertexCount - 1 ? EmptyBox() : MakeBox(&random, s_ranges[r].first, s_ranges[r].spread);
            PutInRow(&boxes[i], &vertices[i]);
        }
        for (size_t i = 0; i < LENGTH(corners); i++)
            for (int c = 0; c < 3; c++)
                corners[i].vertex[c] = i % 5 == 4 ? vertexCount - 1 : qcRandom_Below(&random, vertexCount);
        memset(groups, 0x55, sizeof groups);
        memset(rows, 0x55, sizeof rows);
        untouched = groups[0];
        k->fitTriangles(corners, vertices, first, end, groups, rows);
        for (size_t g = 0; g < groupCount; g++)
        {
            if (g < first || g >= end)
            {
                ck_assert_mem_eq(&groups[g], &untouched, sizeof untouched);
                ck_assert_mem_eq(&rows[g], &untouched, sizeof rows[g]);
                continue;
            }
            Box around = EmptyBox();
            for (size_t i = 0; i < qc_groupSize; i++)
            {
                const uint32_t* c = corners[g * qc_groupSize + i].vertex;
                Box box = Around(Around(boxes[c[0]], boxes[c[1]]), boxes[c[2]]);
                CheckBox(BoxOfGroup(&groups[g], (int)i), box, k->name, i);
                around = Around(around, box);
            }
            CheckBox(BoxOfRow(&rows[g]), around, k->name, g);
        }
    }
}
END_TEST

START_TEST(the_boxes_of_groups_are_those_of_their_children)
{
    enum
    {
        groupCount = 9,
        first = 1,
        end = 8
    };
    qcRandom random = {3};
    FOR_EACH_KERNELS(k)
    for (size_t r = 0; r < LENGTH(s_ranges); r++)
    {
        qcBoxRow children[groupCount * qc_groupSize], rows[groupCount];
        Box boxes[groupCount * qc_groupSize];
        qcBoxGroup groups[groupCount], untouched;
        for (size_t i = 0; i < LENGTH(boxes); i++)
        {
            boxes[i] = MakeBox(&random, s_ranges[r].first, s_ranges[r].spread);
            PutInRow(&boxes[i], &children[i]);
        }
        memset(groups, 0x55, sizeof groups);
        untouched = groups[0];
        k->fitGroups(children, first, end, groups, rows);
        ck_assert_mem_eq(&groups[first - 1], &untouched, sizeof untouched);
        ck_assert_mem_eq(&groups[end], &untouched, sizeof untouched);
        for (size_t g = first; g < end; g++)
        {
            Box around = EmptyBox();
            for (int i = 0; i < qc_groupSize; i++)
            {
                CheckBox(BoxOfGroup(&groups[g], i), boxes[g * qc_groupSize + i], k->name, (size_t)i);
                around = Around(around, boxes[g * qc_groupSize + i]);
            }
            CheckBox(BoxOfRow(&rows[g]), around, k->name, g);
        }
    }
}
END_TEST

static uint64_t CompareOneByOne(const qcBoxGroup* a, const qcBoxGroup* b)
{
    uint64_t meet = 0;
    for (int i = 0; i < qc_groupSize; i++)
        for (int j = 0; j < qc_groupSize; j++)
            meet |= (uint64_t)Overlap(BoxOfGroup(a, i), BoxOfGroup(b, j)) << (i + 8 * j);
    return meet;
}

START_TEST(groups_meet_where_their_boxes_do)
{
    qcRandom random = {4};
    size_t meetings = 0, all = 0;
    FOR_EACH_KERNELS(k)
    for (size_t r = 0; r < LENGTH(s_ranges); r++)
        for (int round = 0; round < 3000; round++)
        {
            qcBoxGroup a, b;
            MakeGroup(&random, s_ranges[r].first, s_ranges[r].spread, &a);
            MakeGroup(&random, s_ranges[r].first, s_ranges[r].spread, &b);
            uint64_t expected = CompareOneByOne(&a, &b);
            CHECK_THAT(k->compare(&a, &b) == expected, "%s: %llx, expected %llx", k->name,
                       (unsigned long long)k->compare(&a, &b), (unsigned long long)expected);
            meetings += (size_t)__builtin_popcountll(expected);
            all += 64;
        }
    ck_assert_uint_gt(meetings, all / 8);
    ck_assert_uint_lt(meetings, all / 8 * 7);
}
END_TEST

//  ---- pairs of two nodes --------------------------------------------------------------------------

enum
{
    qc_nodesInTest = 3,
    qc_clustersInTest = qc_nodesInTest * qc_groupSize,
    qc_mostPairs = qc_nodeSize * qc_nodeSize
};

typedef struct Nodes
{
    qcBoxGroup clusters[qc_clustersInTest], nodes[qc_nodesInTest];
} Nodes;

/// Boxes of clusters that have nothing to do with those of triangles, so that it shows which were asked.
static void MakeNodes(qcRandom* random, int spread, Nodes* nodes)
{
    for (int i = 0; i < qc_clustersInTest; i++)
        MakeGroup(random, 1000, spread, &nodes->clusters[i]);
    for (int i = 0; i < qc_nodesInTest; i++)
        MakeGroup(random, 1000, spread, &nodes->nodes[i]);
}

static int ComparePlacePairs(const void* x, const void* y)
{
    const qcPlacePair *a = x, *b = y;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return a->b < b->b ? -1 : a->b > b->b;
}

static void CheckSamePairs(qcPlacePair* found, size_t count, qcPlacePair* expected, size_t expectedCount,
                           const char* kernels)
{
    CHECK_THAT(count == expectedCount, "%s: %zu pairs, expected %zu", kernels, count, expectedCount);
    qsort(found, count, sizeof *found, ComparePlacePairs);
    qsort(expected, count, sizeof *expected, ComparePlacePairs);
    for (size_t i = 0; i < count; i++)
        CHECK_THAT(ComparePlacePairs(&found[i], &expected[i]) == 0, "%s: pair %u %u, expected %u %u", kernels,
                   found[i].a, found[i].b, expected[i].a, expected[i].b);
}

/// What collect is asked for besides the nodes.
typedef struct Choice
{
    const uint64_t* words;
    const qcPlaceSkip* skips;
    int skipCount;
    const qcGroupMap* map;
} Choice;

static bool IsChosen(const Choice* choice, uint32_t p, uint32_t q)
{
    uint32_t word = p / 8 + 8 * (q / 8), bit = p % 8 + 8 * (q % 8);
    for (int i = 0; i < choice->skipCount; i++)
        if ((choice->skips[i].a >> p & 1) != 0 && (choice->skips[i].b >> q & 1) != 0)
            return false;
    return choice->words == NULL || (choice->words[word] >> bit & 1) != 0;
}

/// By triangles, in the lattice of b where there is no map.
static size_t CollectOneByOne(const qcSurfaceKernels* k, const Nodes* a, uint32_t nodeA, const Nodes* b, uint32_t nodeB,
                              const Choice* choice, qcPlacePair* pairs)
{
    size_t count = 0;
    for (uint32_t p = 0; p < qc_nodeSize; p++)
        for (uint32_t q = 0; q < qc_nodeSize; q++)
        {
            uint32_t i = p / 8, j = q / 8;
            qcBoxGroup node = b->nodes[nodeB], cluster = b->clusters[nodeB * 8 + j];
            if (choice->map != NULL)
            {
                k->mapGroup(&b->nodes[nodeB], choice->map, &node);
                k->mapGroup(&b->clusters[nodeB * 8 + j], choice->map, &cluster);
            }
            if (IsChosen(choice, p, q) && Overlap(BoxOfGroup(&a->nodes[nodeA], (int)i), BoxOfGroup(&node, (int)j)) &&
                Overlap(BoxOfGroup(&a->clusters[nodeA * 8 + i], (int)p % 8), BoxOfGroup(&cluster, (int)q % 8)))
                pairs[count++] = (qcPlacePair){nodeA * qc_nodeSize + p, nodeB * qc_nodeSize + q};
        }
    return count;
}

START_TEST(pairs_of_nodes_are_those_whose_boxes_overlap_whose_bit_is_set_and_that_no_skip_has)
{
    static qcPlacePair found[qc_mostPairs], expected[qc_mostPairs];
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
            words[i] = i % 3 == 0 ? 0 : qcRandom_Next(&random);
        qcPlaceSkip skips[qc_mostSkips];
        for (int i = 0; i < qc_mostSkips; i++)
            skips[i] = (qcPlaceSkip){qcRandom_Next(&random) & qcRandom_Next(&random), qcRandom_Next(&random)};
        Choice choice = {round % 2 == 0 ? words : NULL, skips, round % 3 == 0 ? round / 3 % (qc_mostSkips + 1) : 0,
                         NULL};
        uint32_t nodeA = qcRandom_Below(&random, qc_nodesInTest), nodeB = qcRandom_Below(&random, qc_nodesInTest);
        qcSurfaceBoxes sideA = {a.clusters, a.nodes}, sideB = {b.clusters, b.nodes};
        size_t count =
            (size_t)(k->collect(&sideA, nodeA, &sideB, nodeB, choice.words, skips, choice.skipCount, found) - found);
        size_t expectedCount = CollectOneByOne(k, &a, nodeA, &b, nodeB, &choice, expected);
        CheckSamePairs(found, count, expected, expectedCount, k->name);
        pairs += count;
    }
    ck_assert_uint_gt(pairs, 1000);
}
END_TEST

//  ---- maps ----------------------------------------------------------------------------------------

/// A map as it is meant; the kernels have its floats.
typedef struct TrueMap
{
    long double linear[3][3], shift[3];
} TrueMap;

/// As the kernels get it: errors of floats are at most eleven roundings of the largest numbers that come up.
static qcGroupMap ToGroupMap(const TrueMap* map)
{
    qcGroupMap rounded;
    for (int axis = 0; axis < 3; axis++)
    {
        long double sum = 0.0L;
        for (int k = 0; k < 3; k++)
        {
            rounded.linear[axis][k] = (float)map->linear[axis][k];
            sum += 65536.0L * fabsl(map->linear[axis][k]);
        }
        rounded.shift[axis] = (float)map->shift[axis];
        rounded.grow[axis] = (float)(0x1p-20L * (fabsl(map->shift[axis]) + sum) + 0x1p-4L);
    }
    return rounded;
}

/// Where the box goes: a level is an interval up to where the next begins.
static void MapBox(const TrueMap* map, Box box, int axis, long double* low, long double* high)
{
    *low = *high = map->shift[axis];
    for (int k = 0; k < 3; k++)
    {
        long double a = map->linear[axis][k] * (box.lower[k] - 32768),
                    b = map->linear[axis][k] * (box.upper[k] - 32767);
        *low += a < b ? a : b;
        *high += a < b ? b : a;
    }
}

/// Turned by any angle if asked for; the lattice there shows a part of the one here, all of it, or nothing.
static TrueMap MakeTrueMap(qcRandom* random, bool turned)
{
    TrueMap map = {{{0.0L}}, {0.0L}};
    double scale = exp2(qcRandom_Uniform(random, -20.0, 20.0));
    for (int axis = 0; axis < 3; axis++)
    {
        for (int k = 0; k < 3; k++)
            if (turned || k == axis)
                map.linear[axis][k] = (turned ? qcRandom_Uniform(random, -1.0, 1.0) : 1.0) * scale;
        map.shift[axis] =
            32768.0L * qcRandom_Uniform(random, -1.2, 1.2) * scale + qcRandom_Uniform(random, 0.0, 65533.0);
    }
    return map;
}

START_TEST(a_mapped_box_is_around_where_the_box_goes_and_little_larger)
{
    qcRandom random = {6};
    size_t inside = 0;
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 12000; round++)
    {
        TrueMap map = MakeTrueMap(&random, round % 2 != 0);
        qcGroupMap rounded = ToGroupMap(&map);
        qcBoxGroup group, mapped;
        MakeGroup(&random, round % 3 == 0 ? 0 : round % 3 == 1 ? 60000 : 30000, round % 5 == 0 ? 33 : 5533, &group);
        k->mapGroup(&group, &rounded, &mapped);
        for (int i = 0; i < qc_groupSize; i++)
        {
            Box box = BoxOfGroup(&group, i), found = BoxOfGroup(&mapped, i);
            if (box.lower[0] > box.upper[0])
            {
                CheckBox(found, EmptyBox(), k->name, (size_t)i);
                continue;
            }
            for (int axis = 0; axis < 3; axis++)
            {
                long double low, high, grow = rounded.grow[axis];
                MapBox(&map, box, axis, &low, &high);
                if (high >= 0.0L && low < 65533.0L)
                {
                    CHECK_THAT(found.lower[axis] <= fmaxl(low, 0.0L) &&
                                   found.upper[axis] >= floorl(fminl(high, 65532.0L)),
                               "%s: %d .. %d, but the box goes to %Lg .. %Lg", k->name, found.lower[axis],
                               found.upper[axis], low, high);
                    inside++;
                }
                long double least = floorl(low - 2.0L * grow), most = floorl(high + 2.0L * grow);
                CHECK_THAT(found.lower[axis] >= fminl(fmaxl(least, 0.0L), 65533.0L), "%s: %d for %Lg", k->name,
                           found.lower[axis], low);
                CHECK_THAT(found.upper[axis] <= fminl(fmaxl(most, 0.0L), 65533.0L), "%s: %d for %Lg", k->name,
                           found.upper[axis], high);
            }
        }
    }
    ck_assert_uint_gt(inside, 10000);
}
END_TEST

START_TEST(a_map_that_floats_cannot_hold_gives_boxes_that_meet_everything)
{
    const float large[] = {INFINITY, -INFINITY, 3e38f, -3e38f, 1e35f, 0.0f};
    qcRandom random = {7};
    FOR_EACH_KERNELS(k)
    for (size_t i = 0; i < LENGTH(large); i++)
        for (size_t j = 0; j < LENGTH(large); j++)
            for (int round = 0; round < 20; round++)
            {
                qcGroupMap map = {{{0}}, {0}, {INFINITY, INFINITY, INFINITY}};
                for (int axis = 0; axis < 3; axis++)
                {
                    map.linear[axis][axis] = large[i];
                    map.shift[axis] = large[j];
                }
                qcBoxGroup group, mapped;
                MakeGroup(&random, 0, 65533, &group);
                k->mapGroup(&group, &map, &mapped);
                for (int b = 0; b < qc_groupSize; b++)
                {
                    Box all = {{0, 0, 0}, {65533, 65533, 65533}};
                    bool isEmpty = group.ends[0][b] == qc_emptyEnd;
                    CheckBox(BoxOfGroup(&mapped, b), isEmpty ? EmptyBox() : all, k->name, (size_t)b);
                }
            }
}
END_TEST

START_TEST(pairs_of_nodes_of_two_lattices_are_those_whose_mapped_boxes_overlap)
{
    static qcPlacePair found[qc_mostPairs], expected[qc_mostPairs];
    qcRandom random = {8};
    size_t pairs = 0;
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 40; round++)
    {
        Nodes a, b;
        MakeNodes(&random, 2 + round % 9, &a);
        MakeNodes(&random, 2 + round % 9, &b);
        qcGroupMap map = {{{0}}, {0}, {0.1f, 0.1f, 0.1f}};
        for (int axis = 0; axis < 3; axis++)
        {
            map.linear[axis][axis] = (float)qcRandom_Uniform(&random, 0.5, 2.0);
            map.shift[axis] = 1002.0f - map.linear[axis][axis] * (1002.0f - 32768.0f);
        }
        uint32_t nodeA = qcRandom_Below(&random, qc_nodesInTest), nodeB = qcRandom_Below(&random, qc_nodesInTest);
        qcSurfaceBoxes sideA = {a.clusters, a.nodes}, sideB = {b.clusters, b.nodes};
        size_t count = (size_t)(k->collectMapped(&sideA, nodeA, &sideB, nodeB, &map, found) - found);
        Choice choice = {.map = &map};
        size_t expectedCount = CollectOneByOne(k, &a, nodeA, &b, nodeB, &choice, expected);
        CheckSamePairs(found, count, expected, expectedCount, k->name);
        pairs += count;
    }
    ck_assert_uint_gt(pairs, 1000);
}
END_TEST

//  ---- choice --------------------------------------------------------------------------------------

START_TEST(the_environment_names_the_kernels)
{
    unsetenv("QC_KERNELS");
    const qcSurfaceKernels* best = qcSurfaceKernels_Get();
    FOR_EACH_KERNELS(k)
    {
        ck_assert(qcSurfaceKernels_Nth(kernelIndex + 1) != NULL || best == k);
        setenv("QC_KERNELS", k->name, 1);
        ck_assert_ptr_eq(qcSurfaceKernels_Get(), k);
    }
    setenv("QC_KERNELS", "no such kernels", 1);
    ck_assert_ptr_eq(qcSurfaceKernels_Get(), best);
    ck_assert_str_eq(qcSurfaceKernels_Nth(0)->name, "plain");
}
END_TEST

QC_RUN_TESTS("surface_kernels", a_vertex_has_its_point_and_its_levels,
             the_boxes_of_triangles_are_around_their_corners_and_those_of_groups_around_them,
             the_boxes_of_groups_are_those_of_their_children, groups_meet_where_their_boxes_do,
             pairs_of_nodes_are_those_whose_boxes_overlap_whose_bit_is_set_and_that_no_skip_has,
             a_mapped_box_is_around_where_the_box_goes_and_little_larger,
             a_map_that_floats_cannot_hold_gives_boxes_that_meet_everything,
             pairs_of_nodes_of_two_lattices_are_those_whose_mapped_boxes_overlap, the_environment_names_the_kernels)
