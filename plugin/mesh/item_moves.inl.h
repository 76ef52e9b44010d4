// What mesh/small_order.inl.h needs, for instruction sets without compressed stores: items move one at a time.
#ifndef QC_MESH_ITEM_MOVES_INL_H
#define QC_MESH_ITEM_MOVES_INL_H

#include "mesh/order_item.h"

#include <stdbool.h>
#include <string.h>

/// The coordinates of items along an axis. There is room for qc_maxSmallOrder.
static inline void ReadKeys(const Item* items, uint32_t count, int axis, int16_t* keys)
{
    for (uint32_t i = 0; i < count; i++)
        keys[i] = items[i].at[axis];
}

/// The keys below a value; `count` is rounded up to a multiple of qc_countedKeys.
static inline uint32_t CountBelow(const int16_t* keys, uint32_t count, int value)
{
    Shorts sums[qc_countedKeys / qc_shorts] = {{0}};
    const Shorts limit = (Shorts){0} + (int16_t)value;
    for (uint32_t i = 0; i < count; i += qc_countedKeys)
        for (size_t k = 0; k < qc_countedKeys / qc_shorts; k++)
            sums[k] -= LoadShorts(keys + i + qc_shorts * k) < limit;
    uint64_t fours[qc_countedKeys / 4], sum = 0;
    memcpy(fours, sums, sizeof fours);
    for (size_t k = 0; k < qc_countedKeys / 4; k++)
        sum += fours[k];
    // The sum of four shorts, without a carry between them, to the highest one.
    return (uint32_t)(sum * UINT64_C(0x0001000100010001) >> 48);
}

/// Moves the items with keys below the median to the front, the others to `back` and the places before it.
static inline void MoveItems(Item* items, const int16_t* keys, uint32_t count, int median, Item* back)
{
    // Without branches: each item is written to both places where it may belong.
    Item* front = items;
    for (uint32_t i = 0; i < count; i++)
    {
        const uint64_t item = items[i].all;
        bool isLower = keys[i] < median;
        front->all = back->all = item;
        front += isLower;
        back -= !isLower;
    }
}

#endif
