// Median splits along the longest axis of the centres, down to eight boxes. Bentley: Multidimensional binary search
// trees used for associative searching, 1975.
//
// Boxes much larger than the median come last and are split among themselves: among small boxes each would enlarge all
// nodes above it, and every query would visit the nodes above a ground plane or an infinite box.
#include "broadphase/bvh_build_order.h"

#include <math.h>
#include <string.h>

enum
{
    qc_exponents = 256,
    // Boxes more than 2^3 times as large as the median come last.
    qc_largeBy = 3
};

/// An item in one register. Copied in two halves, an item just stored could not be loaded from the store buffer, and a
/// partition took three times as long.
typedef int32_t Register __attribute__((vector_size(16), aligned(4), may_alias));

//  ---- splits ----------------------------------------------------------------------------------------

/// A strict order of all items: by centre, then by id.
static inline int64_t KeyOf(const qcBoxItem* item, int axis)
{
    return (int64_t)item->center[axis] * ((int64_t)1 << 32) + item->id;
}

static inline void Exchange(qcBoxItem* a, qcBoxItem* b)
{
    Register item = *(Register*)a;
    *(Register*)a = *(Register*)b;
    *(Register*)b = item;
}

/// Moves the median of three samples to the end. The samples are scattered: at fixed positions a regular order of the
/// items, such as a grid's, could make each choice a bad one.
static void ChoosePivot(qcBoxItem* items, size_t count, int axis)
{
    size_t sample[3];
    for (size_t i = 0; i < 3; i++)
        sample[i] = (size_t)((count + i) * 0x9e3779b97f4a7c15u >> 32) % count;
    if (KeyOf(&items[sample[1]], axis) < KeyOf(&items[sample[0]], axis))
        Exchange(&items[sample[0]], &items[sample[1]]);
    if (KeyOf(&items[sample[2]], axis) < KeyOf(&items[sample[1]], axis))
        Exchange(&items[sample[1]], &items[sample[2]]);
    if (KeyOf(&items[sample[1]], axis) < KeyOf(&items[sample[0]], axis))
        Exchange(&items[sample[0]], &items[sample[1]]);
    Exchange(&items[sample[1]], &items[count - 1]);
}

/// Partial sort: item `nth` is in its sorted position, smaller items before it, the others after. Hoare: Find, 1961.
static void Select(qcBoxItem* items, size_t count, size_t nth, int axis)
{
    while (count > 1)
    {
        ChoosePivot(items, count, axis);
        const int64_t pivot = KeyOf(&items[count - 1], axis);
        size_t smaller = 0;
        for (size_t i = 0; i + 1 < count; i++)
        {
            // Without a branch: the side of an item is unpredictable.
            int64_t key = KeyOf(&items[i], axis);
            Exchange(&items[i], &items[smaller]);
            smaller += key < pivot;
        }
        Exchange(&items[smaller], &items[count - 1]);
        if (nth == smaller)
            return;
        if (nth < smaller)
        {
            count = smaller;
            continue;
        }
        items += smaller + 1;
        count -= smaller + 1;
        nth -= smaller + 1;
    }
}

static inline Register Less(Register a, Register b)
{
    Register less = a < b;
    return (a & less) | (b & ~less);
}

static inline Register More(Register a, Register b)
{
    Register more = a > b;
    return (a & more) | (b & ~more);
}

static int LongestAxis(const qcBoxItem* items, size_t count)
{
    // The bounds of every second item: a comparison waits for the one before.
    Register lower[2], upper[2];
    lower[0] = lower[1] = upper[0] = upper[1] = *(const Register*)&items[count - 1];
    for (size_t i = 0; i + 2 <= count; i += 2)
        for (size_t j = 0; j < 2; j++)
        {
            Register item = *(const Register*)&items[i + j];
            lower[j] = Less(lower[j], item);
            upper[j] = More(upper[j], item);
        }
    Register lowest = Less(lower[0], lower[1]), highest = More(upper[0], upper[1]);
    int longest = 0;
    float length = -1.0f;
    for (int k = 0; k < 3; k++)
    {
        float edge = qcFloatOrder_Float(highest[k]) - qcFloatOrder_Float(lowest[k]);
        longest = edge > length ? k : longest;
        length = edge > length ? edge : length;
    }
    return longest;
}

/// Splits recursively, at the node boundary nearest to the middle. Aligned: at other addresses its loops, and with them
/// adding boxes and the first search, took a twentieth longer.
__attribute__((aligned(64))) static void Split(qcBoxItem* items, size_t first, size_t end)
{
    while (first / qc_lanes != (end - 1) / qc_lanes)
    {
        size_t size = qc_lanes;
        while (first / (size * qc_lanes) != (end - 1) / (size * qc_lanes))
            size *= qc_lanes;
        size_t middle = (first + end + size) / (2 * size) * size;
        Select(items + first, end - first, middle - first, LongestAxis(items + first, end - first));
        Split(items, first, middle);
        first = middle;
    }
}

//  ---- sizes -----------------------------------------------------------------------------------------

/// Exponent of the longest edge; the largest exponent for an infinite edge.
static uint32_t SizeExponent(const qcFloatBox* box)
{
    float longest = 0.0f;
    for (int k = 0; k < 3; k++)
    {
        float edge = box->upper[k] - box->lower[k];
        // The comparison keeps NaN, the edge of a box at infinity.
        longest = edge <= longest ? longest : edge;
    }
    union
    {
        float f;
        uint32_t u;
    } bits = {longest};
    return bits.u >> 23 & (qc_exponents - 1);
}

/// The largest exponent of a box that is not much larger than the median. `counted`: boxes per exponent, `count` in
/// all.
static uint32_t FindLimit(const size_t counted[qc_exponents], size_t count)
{
    size_t sum = 0;
    uint32_t exponent = 0;
    while ((sum += counted[exponent]) < (count + 1) / 2)
        exponent++;
    return exponent + qc_largeBy;
}

/// Moves boxes up to the size limit to the front and splits them; then repeats with the rest.
static void ArrangeBySize(qcBoxItem* items, size_t count, const qcFloatBox* boxes)
{
    size_t counted[qc_exponents] = {0};
    for (size_t i = 0; i < count; i++)
        counted[SizeExponent(&boxes[items[i].id])]++;
    for (size_t first = 0; first < count;)
    {
        uint32_t limit = FindLimit(counted, count - first);
        size_t small = 0;
        for (uint32_t exponent = 0; exponent <= limit && exponent < qc_exponents; exponent++)
        {
            small += counted[exponent];
            counted[exponent] = 0;
        }
        size_t middle = first + small;
        for (size_t i = first, to = first; middle < count && to < middle; i++)
            if (SizeExponent(&boxes[items[i].id]) <= limit)
                Exchange(&items[i], &items[to++]);
        Split(items, first, middle);
        first = middle;
    }
}

void qcBuildOrder_Arrange(qcBoxItem* items, size_t count, const qcFloatBox* boxes)
{
    if (count <= qc_lanes)
        return;
    uint32_t min = qc_exponents, max = 0;
    for (size_t i = 0; i < count; i++)
    {
        if (i + qc_fetchAhead < count)
            __builtin_prefetch(&boxes[items[i + qc_fetchAhead].id]);
        uint32_t exponent = SizeExponent(&boxes[items[i].id]);
        min = exponent < min ? exponent : min;
        max = exponent > max ? exponent : max;
    }
    if (max <= min + qc_largeBy)
        Split(items, 0, count);
    else
        ArrangeBySize(items, count, boxes);
}
