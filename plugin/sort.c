// Least significant digit first, 11 bits a pass or, for few, 8; each digit begins at a bit in which keys differ.
#include "sort.h"

#include "status.h"

#include <string.h>

enum
{
    qc_digitBits = 11,
    qc_digits = 1 << qc_digitBits,
    // A pass over 11 bits takes 1.5 us for any few, one over 8 bits 0.2 us, but there are more of them.
    qc_shortDigitBits = 8,
    qc_fewItems = 1024,
    // Insertion takes 0.5 us for 32 items.
    qc_insertedItems = 32
};

/// For so few that counting digits would take longer.
static void InsertItems(qcSortItem* items, size_t count)
{
    for (size_t i = 1; i < count; i++)
    {
        qcSortItem item = items[i];
        size_t at = i;
        for (; at > 0 && items[at - 1].key > item.key; at--)
            items[at] = items[at - 1];
        items[at] = item;
    }
}

static void SortByDigit(const qcSortItem* from, qcSortItem* to, size_t count, int shift, uint64_t mask)
{
    size_t offset[qc_digits];
    memset(offset, 0, (mask + 1) * sizeof *offset);
    for (size_t i = 0; i < count; i++)
        offset[from[i].key >> shift & mask]++;
    size_t sum = 0;
    for (uint64_t d = 0; d <= mask; d++)
    {
        size_t number = offset[d];
        offset[d] = sum;
        sum += number;
    }
    for (size_t i = 0; i < count; i++)
        to[offset[from[i].key >> shift & mask]++] = from[i];
}

qcStatus qcSort_Items(qcSortItem* items, size_t count, qcArray* scratch)
{
    if (count <= qc_insertedItems)
    {
        InsertItems(items, count);
        return qc_statusOk;
    }
    QC_TRY(qcArray_Reserve(scratch, count, sizeof(qcSortItem), "sorting"));
    uint64_t differ = 0;
    for (size_t i = 1; i < count; i++)
        differ |= items[i].key ^ items[0].key;
    qcSortItem *from = items, *to = scratch->data;
    int bits = count <= qc_fewItems ? qc_shortDigitBits : qc_digitBits;
    uint64_t mask = ((uint64_t)1 << bits) - 1;
    while (differ != 0)
    {
        int shift = __builtin_ctzll(differ);
        differ &= ~(mask << shift);
        SortByDigit(from, to, count, shift, mask);
        qcSortItem* swap = from;
        from = to;
        to = swap;
    }
    if (from != items)
        memcpy(items, from, count * sizeof *items);
    return qc_statusOk;
}
