// What the kernels for boxes have in common. The file of an instruction set defines, before it includes this one:
//
//   Lanes                      an octet in registers
//   LoadLanes                  from memory
//   MeetLanes                  a bit for each lane that meets a box
//
// Why nothing is missed: what a lane of a level is around, it contains (minimum and maximum, no arithmetic), so boxes
// that meet have lanes that meet on every level. NaN fails every comparison, and a comparison that fails turns away.
#ifndef QC_BROADPHASE_BOX_KERNELS_INL_H
#define QC_BROADPHASE_BOX_KERNELS_INL_H

#include "broadphase/box_kernels.h"

#define QC_INLINE static inline __attribute__((always_inline))

static uint32_t Meet(const qcOctet* octet, const qcFloatBox* box)
{
    Lanes lanes = LoadLanes(octet);
    return MeetLanes(&lanes, box);
}

QC_INLINE qcFloatBox LaneOf(const qcOctet* octet, uint32_t lane)
{
    return (qcFloatBox){{octet->lower[0][lane], octet->lower[1][lane], octet->lower[2][lane]},
                        {octet->upper[0][lane], octet->upper[1][lane], octet->upper[2][lane]}};
}

/// The lanes of `found` that meet the given rows of `sought`.
QC_INLINE uint64_t MeetRows(const qcOctet* sought, uint32_t rows, const qcOctet* found)
{
    uint64_t lanes = 0;
    Lanes columns = LoadLanes(found);
    for (; rows != 0; rows &= rows - 1)
    {
        uint32_t row = (uint32_t)__builtin_ctz(rows);
        qcFloatBox box = LaneOf(sought, row);
        lanes |= (uint64_t)MeetLanes(&columns, &box) << 8 * row;
    }
    return lanes;
}

typedef struct Stop
{
    uint32_t level, octet;
} Stop;

static size_t Seek(const qcOctet* octet, const qcOctetTree* tree, uint32_t first, qcOctetHit* hits)
{
    // A stop is taken and leaves eight at most, which are one level down.
    Stop stack[7 * qc_treeLevels + 1];
    uint32_t stops = 0;
    size_t count = 0;
    Lanes rows = LoadLanes(octet);
    qcFloatBox around = qcOctet_Around(octet);
    if (tree->levelCount == 1)
    {
        hits[0] = (qcOctetHit){MeetRows(octet, 0xff, tree->octets), 0};
        return hits[0].lanes != 0;
    }
    stack[stops++] = (Stop){tree->levelCount - 1, 0};
    while (stops > 0)
    {
        Stop stop = stack[--stops];
        const qcOctet* above = &tree->octets[tree->first[stop.level] + stop.octet];
        uint32_t level = stop.level - 1;
        for (uint32_t meet = Meet(above, &around); meet != 0; meet &= meet - 1)
        {
            uint32_t lane = (uint32_t)__builtin_ctz(meet), below = qc_lanes * stop.octet + lane;
            if (((uint64_t)below + 1) << 3 * level <= first)
                continue;
            if (level != 0)
            {
                stack[stops++] = (Stop){level, below};
                continue;
            }
            qcFloatBox box = LaneOf(above, lane);
            hits[count] = (qcOctetHit){MeetRows(octet, MeetLanes(&rows, &box), &tree->octets[below]), below};
            count += hits[count].lanes != 0;
        }
    }
    return count;
}

#endif
