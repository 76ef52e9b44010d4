// The body of the box kernels. The file of an instruction set defines, before it includes this one:
//   Lanes          an octet in registers
//   LoadLanes      loads it from memory
//   OverlapLanes   a bit for each lane that overlaps a box
//   CastLanes      a bit for each lane of an octet in memory whose slabs a cast hits
//
// No overlap is missed: a lane of a level contains all that lies below it (minimum and maximum, no arithmetic), so
// boxes that overlap have overlapping lanes on every level. NaN fails every comparison: an empty lane overlaps nothing.
#ifndef QC_BROADPHASE_BOX_KERNELS_INL_H
#define QC_BROADPHASE_BOX_KERNELS_INL_H

#include "broadphase/box_kernels.h"

#define QC_INLINE static inline __attribute__((always_inline))

QC_INLINE uint32_t OverlapOctet(const qcOctet* octet, const qcFloatBox* box)
{
    Lanes lanes = LoadLanes(octet);
    return OverlapLanes(&lanes, box);
}

static uint32_t Overlap(const qcOctet* octet, const qcFloatBox* box)
{
    return OverlapOctet(octet, box);
}

static uint32_t CastOctet(const qcOctet* octet, const qcFloatCast* cast, float fraction, float entries[qc_lanes])
{
    return OverlapOctet(octet, &cast->path) & CastLanes(octet, cast, fraction, entries);
}

QC_INLINE qcFloatBox LaneOf(const qcOctet* octet, uint32_t lane)
{
    return (qcFloatBox){{octet->lower[0][lane], octet->lower[1][lane], octet->lower[2][lane]},
                        {octet->upper[0][lane], octet->upper[1][lane], octet->upper[2][lane]}};
}

/// The lanes of `tree` that overlap the given rows of `query`.
QC_INLINE uint64_t OverlapRows(const qcOctet* query, uint32_t rows, const qcOctet* tree)
{
    uint64_t lanes = 0;
    Lanes columns = LoadLanes(tree);
    for (; rows != 0; rows &= rows - 1)
    {
        uint32_t row = (uint32_t)__builtin_ctz(rows);
        qcFloatBox box = LaneOf(query, row);
        lanes |= (uint64_t)OverlapLanes(&columns, &box) << 8 * row;
    }
    return lanes;
}

typedef struct Node
{
    uint32_t level, octet;
} Node;

static size_t FindOverlaps(const qcOctet* octet, const qcOctetTree* tree, uint32_t first, qcOctetHit* hits)
{
    // A popped node pushes at most eight of the level below.
    Node stack[7 * qc_treeLevels + 1];
    uint32_t stackCount = 0;
    size_t count = 0;
    Lanes rows = LoadLanes(octet);
    qcFloatBox around = qcOctet_Around(octet);
    if (tree->levelCount == 1)
    {
        hits[0] = (qcOctetHit){OverlapRows(octet, 0xff, tree->octets), 0};
        return hits[0].lanes != 0;
    }
    stack[stackCount++] = (Node){tree->levelCount - 1, 0};
    while (stackCount > 0)
    {
        Node node = stack[--stackCount];
        const qcOctet* above = &tree->octets[tree->first[node.level] + node.octet];
        uint32_t level = node.level - 1;
        for (uint32_t lanes = OverlapOctet(above, &around); lanes != 0; lanes &= lanes - 1)
        {
            uint32_t lane = (uint32_t)__builtin_ctz(lanes), below = qc_lanes * node.octet + lane;
            if (((uint64_t)below + 1) << 3 * level <= first)
                continue;
            if (level != 0)
            {
                stack[stackCount++] = (Node){level, below};
                continue;
            }
            qcFloatBox box = LaneOf(above, lane);
            hits[count] = (qcOctetHit){OverlapRows(octet, OverlapLanes(&rows, &box), &tree->octets[below]), below};
            count += hits[count].lanes != 0;
        }
    }
    return count;
}

#endif
