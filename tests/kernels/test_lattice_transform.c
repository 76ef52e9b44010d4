// The kernels that transform boxes of one BVH to the lattice of another, against wider arithmetic.
#include "kernels/boxes.h"

#include <math.h>

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

/// The exact transform; the kernels get it rounded to floats.
typedef struct ExactTransform
{
    long double linear[3][3], shift[3];
} ExactTransform;

/// The transform for the kernels. Its float error is at most eleven roundings of the largest numbers that occur.
static qcBoxTransform ToBoxTransform(const ExactTransform* map)
{
    qcBoxTransform rounded = {.isDiagonal = false};
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

/// The exact image of the box. A level is an interval, up to the beginning of the next.
static void TransformBox(const ExactTransform* map, Box box, int axis, long double* low, long double* high)
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

/// Rotated by any angle or not; the target lattice contains a part of the source lattice, all of it, or nothing.
static ExactTransform MakeTrueMap(qcRandom* random, bool turned)
{
    ExactTransform map = {{{0.0L}}, {0.0L}};
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

/// The box contains low .. high within the lattice and exceeds it by at most twice `grow`. Returns whether the lattice
/// contains any part of it.
static bool CheckRange(Box found, int axis, long double low, long double high, long double grow, const char* kernels)
{
    bool isInside = high >= 0.0L && low < 65533.0L;
    CHECK_THAT(!isInside ||
                   (found.lower[axis] <= fmaxl(low, 0.0L) && found.upper[axis] >= floorl(fminl(high, 65532.0L))),
               "%s: %d .. %d, but it goes from %Lg to %Lg", kernels, found.lower[axis], found.upper[axis], low, high);
    CHECK_THAT(found.lower[axis] >= fminl(fmaxl(floorl(low - 2.0L * grow), 0.0L), 65533.0L), "%s: %d for %Lg", kernels,
               found.lower[axis], low);
    CHECK_THAT(found.upper[axis] <= fminl(fmaxl(floorl(high + 2.0L * grow), 0.0L), 65533.0L), "%s: %d for %Lg", kernels,
               found.upper[axis], high);
    return isInside;
}

START_TEST(a_transformed_box_contains_the_image_of_the_box_and_is_little_larger)
{
    qcRandom random = {6};
    size_t inside = 0;
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 12000; round++)
    {
        ExactTransform map = MakeTrueMap(&random, round % 2 != 0);
        qcBoxTransform rounded = ToBoxTransform(&map);
        rounded.isDiagonal = round % 4 == 0;
        qcBox8 boxes, transformed;
        MakeBox8(&random, round % 3 == 0 ? 0 : round % 3 == 1 ? 60000 : 30000, round % 5 == 0 ? 33 : 5533, &boxes);
        k->transformBoxes(&boxes, &rounded, &transformed);
        for (int i = 0; i < qc_boxLanes; i++)
        {
            Box box = BoxAt(&boxes, i), found = BoxAt(&transformed, i);
            if (box.lower[0] > box.upper[0])
            {
                CheckBox(found, EmptyBox(), k->name, (size_t)i);
                continue;
            }
            for (int axis = 0; axis < 3; axis++)
            {
                long double low, high;
                TransformBox(&map, box, axis, &low, &high);
                inside += CheckRange(found, axis, low, high, rounded.grow[axis], k->name);
            }
        }
    }
    ck_assert_uint_gt(inside, 10000);
}
END_TEST

START_TEST(a_transform_too_large_for_floats_gives_boxes_that_overlap_everything)
{
    const float large[] = {INFINITY, -INFINITY, 3e38f, -3e38f, 1e35f, 0.0f};
    qcRandom random = {7};
    FOR_EACH_KERNELS(k)
    for (size_t i = 0; i < LENGTH(large); i++)
        for (size_t j = 0; j < LENGTH(large); j++)
            for (int round = 0; round < 20; round++)
            {
                qcBoxTransform map = {.grow = {INFINITY, INFINITY, INFINITY}, .isDiagonal = round % 2 != 0};
                for (int axis = 0; axis < 3; axis++)
                {
                    map.linear[axis][axis] = large[i];
                    map.shift[axis] = large[j];
                }
                qcBox8 boxes, transformed;
                MakeBox8(&random, 0, 65533, &boxes);
                k->transformBoxes(&boxes, &map, &transformed);
                for (int b = 0; b < qc_boxLanes; b++)
                {
                    Box all = {{0, 0, 0}, {65533, 65533, 65533}};
                    bool isEmpty = boxes.ends[0][b] == qc_emptyEnd;
                    CheckBox(BoxAt(&transformed, b), isEmpty ? EmptyBox() : all, k->name, (size_t)b);
                }
            }
}
END_TEST

START_TEST(ends_of_boxes_with_outliers_are_unbounded)
{
    const Box all = {{0, 0, 0}, {65533, 65533, 65533}};
    qcRandom random = {18};
    int open = 0;
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 3000; round++)
    {
        ExactTransform map = MakeTrueMap(&random, round % 2 != 0);
        qcBoxTransform rounded = ToBoxTransform(&map), without;
        rounded.isDiagonal = round % 2 == 0;
        without = rounded;
        rounded.hasOutliers = true;
        qcBox8 boxes, transformed, expected;
        MakeBox8(&random, round % 4 < 2 ? 0 : 65533 - 20, 20, &boxes);
        k->transformBoxes(&boxes, &rounded, &transformed);
        k->transformBoxes(&boxes, &without, &expected);
        for (int i = 0; i < qc_boxLanes; i++)
        {
            Box box = BoxAt(&boxes, i), found = BoxAt(&transformed, i), closed = BoxAt(&expected, i);
            bool isOpen = false;
            for (int axis = 0; axis < 3 && box.lower[0] <= box.upper[0]; axis++)
            {
                if (box.lower[axis] == 0)
                    closed.lower[axis] = 0;
                if (box.upper[axis] == 65533)
                    closed.upper[axis] = 65533;
                isOpen |= box.lower[axis] == 0 || box.upper[axis] == 65533;
            }
            CheckBox(found, isOpen && !rounded.isDiagonal ? all : closed, k->name, (size_t)i);
            open += isOpen;
        }
    }
    ck_assert_int_gt(open, 1000);
}
END_TEST

//  ---- triangles -----------------------------------------------------------------------------------

enum
{
    qc_pointsInTest = 40
};

/// Another BVH, with triangles between any of its points; an empty box has no triangle.
typedef struct Other
{
    Nodes nodes;
    qcPoint points[qc_pointsInTest + 1]; ///< the last is that of slots without a triangle
    qcCorners corners[qc_clustersInTest * qc_clusterSize];
    qcTransformedBvh transformed;
} Other;

static void MakeOther(qcRandom* random, int spread, Other* other)
{
    MakeNodes(random, spread, &other->nodes);
    for (int i = 0; i < qc_pointsInTest; i++)
        for (int axis = 0; axis < 4; axis++)
            other->points[i].x[axis] = axis < 3 ? (float)qcRandom_Uniform(random, 0.0, 1.0) : 0.0f;
    other->points[qc_pointsInTest] = (qcPoint){{0.0f, 0.0f, 0.0f, (float)qc_emptyEnd}};
    for (int i = 0; i < qc_clustersInTest * qc_clusterSize; i++)
    {
        bool isEmpty = other->nodes.clusters[i / qc_clusterSize].ends[0][i % qc_clusterSize] == qc_emptyEnd;
        for (int c = 0; c < 3; c++)
            other->corners[i].vertex[c] = isEmpty ? qc_pointsInTest : qcRandom_Below(random, qc_pointsInTest);
    }
    other->transformed = (qcTransformedBvh){.boxes = {other->nodes.clusters, other->nodes.nodes},
                                            .triangles = {other->corners, other->points}};
}

/// From points, whose coordinates are at most 1, to levels.
static ExactTransform MakePointTransform(qcRandom* random, double least, double most)
{
    ExactTransform map = {{{0.0L}}, {0.0L}};
    double scale = qcRandom_Uniform(random, least, most);
    for (int axis = 0; axis < 3; axis++)
    {
        for (int k = 0; k < 3; k++)
            map.linear[axis][k] = qcRandom_Uniform(random, -1.0, 1.0) * scale;
        map.shift[axis] = qcRandom_Uniform(random, -0.5, 1.5) * scale;
    }
    return map;
}

static void FindRange(const ExactTransform* map, const Other* other, size_t triangle, int axis, long double* low,
                      long double* high)
{
    *low = INFINITY;
    *high = -INFINITY;
    for (int c = 0; c < 3; c++)
    {
        const float* x = other->points[other->corners[triangle].vertex[c]].x;
        long double at = map->shift[axis];
        for (int k = 0; k < 3; k++)
            at += map->linear[axis][k] * x[k];
        *low = fminl(*low, at);
        *high = fmaxl(*high, at);
    }
}

/// Room for the rounding of points.
static void SetGrow(const ExactTransform* map, qcBoxTransform* points)
{
    for (int axis = 0; axis < 3; axis++)
    {
        long double sizes = fabsl(map->shift[axis]);
        for (int j = 0; j < 3; j++)
            sizes += fabsl(map->linear[axis][j]);
        points->grow[axis] = (float)(0x1p-20L * sizes + 0x1p-4L);
    }
}

START_TEST(the_box_of_a_transformed_triangle_contains_its_corners_and_is_little_larger)
{
    static Other other;
    qcRandom random = {16};
    size_t inside = 0;
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 3000; round++)
    {
        MakeOther(&random, 9, &other);
        ExactTransform map =
            round % 2 == 0 ? MakePointTransform(&random, 1.0, 9.0) : MakePointTransform(&random, 1000.0, 300000.0);
        // ToBoxTransform allows for levels; points are smaller.
        other.transformed.points = ToBoxTransform(&map);
        SetGrow(&map, &other.transformed.points);
        uint32_t cluster = qcRandom_Below(&random, qc_clustersInTest);
        qcBox8 transformed;
        k->transformTriangles(&other.transformed, cluster, &transformed);
        for (int i = 0; i < qc_boxLanes; i++)
        {
            Box found = BoxAt(&transformed, i);
            if (other.nodes.clusters[cluster].ends[0][i] == qc_emptyEnd)
            {
                CheckBox(found, EmptyBox(), k->name, (size_t)i);
                continue;
            }
            for (int axis = 0; axis < 3; axis++)
            {
                long double low, high;
                FindRange(&map, &other, cluster * qc_clusterSize + (size_t)i, axis, &low, &high);
                inside += CheckRange(found, axis, low, high, other.transformed.points.grow[axis], k->name);
            }
        }
    }
    ck_assert_uint_gt(inside, 10000);
}
END_TEST

START_TEST(the_box_of_a_transformed_outlier_contains_its_corners)
{
    static Other other;
    qcRandom random = {19};
    size_t inside = 0;
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 3000; round++)
    {
        MakeOther(&random, 9, &other);
        double size = ldexp(1.0, 3 * (round % 40));
        for (int i = 0; i < qc_pointsInTest; i += 3)
            for (int axis = 0; axis < 3; axis++)
                other.points[i].x[axis] =
                    round % 40 == 39 ? -INFINITY : (float)(size * qcRandom_Uniform(&random, -1.0, 1.0));
        ExactTransform map = MakePointTransform(&random, 1000.0, 300000.0);
        other.transformed.points = ToBoxTransform(&map);
        other.transformed.points.hasOutliers = true;
        SetGrow(&map, &other.transformed.points);
        uint32_t cluster = qcRandom_Below(&random, qc_clustersInTest);
        qcBox8 transformed;
        k->transformTriangles(&other.transformed, cluster, &transformed);
        for (int i = 0; i < qc_boxLanes; i++)
            for (int axis = 0; axis < 3 && other.nodes.clusters[cluster].ends[0][i] != qc_emptyEnd; axis++)
            {
                long double low, high;
                Box found = BoxAt(&transformed, i);
                FindRange(&map, &other, cluster * qc_clusterSize + (size_t)i, axis, &low, &high);
                bool isBounded = low == low && high == high; // no NaN
                CHECK_THAT(found.lower[axis] <= (isBounded ? fminl(fmaxl(low, 0.0L), 65533.0L) : 0.0L) &&
                               found.upper[axis] >= (isBounded ? floorl(fmaxl(fminl(high, 65533.0L), 0.0L)) : 65533.0L),
                           "%s: %d .. %d, but it goes from %Lg to %Lg", k->name, found.lower[axis], found.upper[axis],
                           low, high);
                inside += high >= 0.0L && low < 65533.0L;
            }
    }
    ck_assert_uint_gt(inside, 10000);
}
END_TEST

START_TEST(triangles_under_a_transform_too_large_for_floats_overlap_everything)
{
    static Other other;
    const float large[] = {INFINITY, -INFINITY, 3e38f, -3e38f, 1e35f, 0.0f, NAN};
    qcRandom random = {17};
    FOR_EACH_KERNELS(k)
    for (size_t i = 0; i < LENGTH(large); i++)
        for (size_t j = 0; j < LENGTH(large); j++)
        {
            MakeOther(&random, 9, &other);
            other.transformed.points = (qcBoxTransform){.grow = {INFINITY, INFINITY, INFINITY}};
            for (int axis = 0; axis < 3; axis++)
            {
                other.transformed.points.linear[axis][axis] = large[i];
                other.transformed.points.shift[axis] = large[j];
            }
            qcBox8 transformed;
            k->transformTriangles(&other.transformed, 1, &transformed);
            for (int b = 0; b < qc_boxLanes; b++)
            {
                Box all = {{0, 0, 0}, {65533, 65533, 65533}};
                bool isEmpty = other.nodes.clusters[1].ends[0][b] == qc_emptyEnd;
                CheckBox(BoxAt(&transformed, b), isEmpty ? EmptyBox() : all, k->name, (size_t)b);
            }
        }
}
END_TEST

//  ---- pairs of two nodes --------------------------------------------------------------------------

/// The box around eight; empty ones are left out.
static Box FindAround(const qcBox8* boxes)
{
    Box around = EmptyBox();
    for (int i = 0; i < qc_boxLanes; i++)
    {
        Box box = BoxAt(boxes, i);
        for (int axis = 0; axis < 3; axis++)
        {
            around.lower[axis] = box.lower[axis] < around.lower[axis] ? box.lower[axis] : around.lower[axis];
            around.upper[axis] = box.upper[axis] > around.upper[axis] ? box.upper[axis] : around.upper[axis];
        }
    }
    return around;
}

static uint64_t FindClusters(const qcTriangleKernels* k, const Nodes* a, uint32_t nodeA, const Other* b, uint32_t nodeB)
{
    qcBox8 node;
    k->transformBoxes(&b->nodes.nodes[nodeB], &b->transformed.levels, &node);
    return k->findOverlaps(&a->nodes[nodeA], &node);
}

/// Clusters of both nodes meet as boxes, and that of a meets the triangles of that of b.
static size_t CollectOneByOne(const qcTriangleKernels* k, const Nodes* a, uint32_t nodeA, const Other* b,
                              uint32_t nodeB, qcSlotPair* pairs)
{
    size_t count = 0;
    qcBox8 node, clusters[qc_boxLanes];
    k->transformBoxes(&b->nodes.nodes[nodeB], &b->transformed.levels, &node);
    for (uint32_t j = 0; j < qc_boxLanes; j++)
        k->transformTriangles(&b->transformed, nodeB * 8 + j, &clusters[j]);
    for (uint32_t p = 0; p < qc_nodeSize; p++)
        for (uint32_t q = 0; q < qc_nodeSize; q++)
            if (Overlap(BoxAt(&a->nodes[nodeA], (int)p / 8), BoxAt(&node, (int)q / 8)) &&
                Overlap(BoxAt(&a->nodes[nodeA], (int)p / 8), FindAround(&clusters[q / 8])) &&
                Overlap(BoxAt(&a->clusters[nodeA * 8 + p / 8], (int)p % 8), BoxAt(&clusters[q / 8], (int)q % 8)))
                pairs[count++] = (qcSlotPair){nodeA * qc_nodeSize + p, nodeB * qc_nodeSize + q};
    return count;
}

START_TEST(collected_pairs_of_two_lattices_are_those_whose_transformed_boxes_overlap)
{
    static qcSlotPair found[qc_maxPairs], expected[qc_maxPairs];
    static Other b;
    qcRandom random = {8};
    size_t pairs = 0;
    FOR_EACH_KERNELS(k)
    for (int round = 0; round < 40; round++)
    {
        Nodes a;
        MakeNodes(&random, 2 + round % 9, &a);
        MakeOther(&random, 2 + round % 9, &b);
        for (int axis = 0; axis < 3; axis++)
        {
            qcBoxTransform *levels = &b.transformed.levels, *points = &b.transformed.points;
            levels->linear[axis][axis] = (float)qcRandom_Uniform(&random, 0.5, 2.0);
            levels->shift[axis] = 1002.0f - levels->linear[axis][axis] * (1002.0f - 32768.0f);
            points->linear[axis][axis] = (float)qcRandom_Uniform(&random, 1.0, 9.0);
            points->shift[axis] = 1000.0f;
            levels->grow[axis] = points->grow[axis] = 0.1f;
        }
        uint32_t nodeA = qcRandom_Below(&random, qc_nodesInTest), nodeB = qcRandom_Below(&random, qc_nodesInTest);
        qcBvhBoxes sideA = {a.clusters, a.nodes};
        uint64_t clusters = FindClusters(k, &a, nodeA, &b, nodeB);
        size_t count =
            (size_t)(k->collectTransformedPairs(&sideA, nodeA, &b.transformed, nodeB, clusters, NULL, found) - found);
        size_t expectedCount = CollectOneByOne(k, &a, nodeA, &b, nodeB, expected);
        CheckSamePairs(found, count, expected, expectedCount, k->name);
        pairs += count;
    }
    ck_assert_uint_gt(pairs, 1000);
}
END_TEST

QC_RUN_TESTS("lattice_transform", ends_of_boxes_with_outliers_are_unbounded,
             the_box_of_a_transformed_outlier_contains_its_corners,
             a_transformed_box_contains_the_image_of_the_box_and_is_little_larger,
             a_transform_too_large_for_floats_gives_boxes_that_overlap_everything,
             the_box_of_a_transformed_triangle_contains_its_corners_and_is_little_larger,
             triangles_under_a_transform_too_large_for_floats_overlap_everything,
             collected_pairs_of_two_lattices_are_those_whose_transformed_boxes_overlap)
