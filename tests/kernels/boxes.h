// Boxes one at a time, for the kernels that compare eight with eight.
#ifndef QC_TESTS_KERNELS_BOXES_H
#define QC_TESTS_KERNELS_BOXES_H

#include "support/suite.h"
#include "sweep/sample_bodies.h"

#include <stdlib.h>
#include <string.h>

/// Levels from 0 to 65533, both ends included. lower > upper: an empty box.
typedef struct Box
{
    int lower[3], upper[3];
} Box;

static inline Box BoxAt(const qcBox8* boxes, int i)
{
    Box box;
    for (int axis = 0; axis < 3; axis++)
    {
        box.lower[axis] = boxes->ends[axis][i] + 32768;
        box.upper[axis] = -1 - boxes->ends[axis][qc_boxLanes + i] + 32768;
    }
    return box;
}

static inline void SetBox(const Box* box, qcBox8* boxes, int i)
{
    for (int axis = 0; axis < 3; axis++)
    {
        boxes->ends[axis][i] = (int16_t)(box->lower[axis] - 32768);
        boxes->ends[axis][qc_boxLanes + i] = (int16_t)(-1 - (box->upper[axis] - 32768));
    }
}

/// Both of its ends are qc_emptyEnd.
static inline Box EmptyBox(void)
{
    return (Box){{65535, 65535, 65535}, {0, 0, 0}};
}

static inline bool Overlap(Box a, Box b)
{
    for (int axis = 0; axis < 3; axis++)
        if (a.lower[axis] > b.upper[axis] || b.lower[axis] > a.upper[axis])
            return false;
    return true;
}

/// Levels first .. first + spread; with a small spread most boxes touch or are next to each other. Some are empty.
static inline Box MakeBox(qcRandom* random, int first, int spread)
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

static inline void MakeBox8(qcRandom* random, int first, int spread, qcBox8* boxes)
{
    for (int i = 0; i < qc_boxLanes; i++)
    {
        Box box = MakeBox(random, first, spread);
        SetBox(&box, boxes, i);
    }
}

static inline void CheckBox(Box found, Box expected, const char* kernels, size_t index)
{
    CHECK_THAT(memcmp(&found, &expected, sizeof found) == 0, "%s: box %zu is %d %d %d .. %d %d %d", kernels, index,
               found.lower[0], found.lower[1], found.lower[2], found.upper[0], found.upper[1], found.upper[2]);
}

enum
{
    qc_nodesInTest = 3,
    qc_clustersInTest = qc_nodesInTest * qc_boxLanes,
    qc_maxPairs = qc_nodeSize * qc_nodeSize
};

typedef struct Nodes
{
    qcBox8 clusters[qc_clustersInTest], nodes[qc_nodesInTest];
} Nodes;

/// Makes nodes. Boxes of clusters are unrelated to those of triangles, so that the test detects which were read.
static inline void MakeNodes(qcRandom* random, int spread, Nodes* nodes)
{
    for (int i = 0; i < qc_clustersInTest; i++)
        MakeBox8(random, 1000, spread, &nodes->clusters[i]);
    for (int i = 0; i < qc_nodesInTest; i++)
        MakeBox8(random, 1000, spread, &nodes->nodes[i]);
}

static inline int CompareSlotPairs(const void* x, const void* y)
{
    const qcSlotPair *a = x, *b = y;
    if (a->a != b->a)
        return a->a < b->a ? -1 : 1;
    return a->b < b->b ? -1 : a->b > b->b;
}

static inline void CheckSamePairs(qcSlotPair* found, size_t count, qcSlotPair* expected, size_t expectedCount,
                                  const char* kernels)
{
    CHECK_THAT(count == expectedCount, "%s: %zu pairs, expected %zu", kernels, count, expectedCount);
    qsort(found, count, sizeof *found, CompareSlotPairs);
    qsort(expected, count, sizeof *expected, CompareSlotPairs);
    for (size_t i = 0; i < count; i++)
        CHECK_THAT(CompareSlotPairs(&found[i], &expected[i]) == 0, "%s: pair %u %u, expected %u %u", kernels,
                   found[i].a, found[i].b, expected[i].a, expected[i].b);
}

#endif
