// Least significant digit first, 11 bits a pass or, for few, 8; bits in which keys don't differ are left out between
// the lower and the upper part of a digit, as keys made of two small numbers have them.
#include "base/radix_sort.h"

#include "base/status.h"

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

/// Bits in which keys differ, in their order, from two places of the key: between them all keys are alike.
typedef struct Digit
{
    int shift[2], width;
    uint64_t mask[2];
} Digit;

/// The lowest `bits` of those that are left, or a few less; takes them from there.
static Digit TakeDigit(uint64_t* left, int bits)
{
    Digit digit = {.shift = {__builtin_ctzll(*left), 0}};
    uint64_t window = *left >> digit.shift[0] & (((uint64_t)1 << bits) - 1);
    digit.width = 64 - __builtin_clzll(window);
    digit.mask[0] = ((uint64_t)1 << digit.width) - 1;
    *left &= ~(digit.mask[0] << digit.shift[0]);
    if (digit.width == bits || *left == 0)
        return digit;
    digit.shift[1] = __builtin_ctzll(*left);
    digit.mask[1] = ((uint64_t)1 << (bits - digit.width)) - 1;
    *left &= ~(digit.mask[1] << digit.shift[1]);
    return digit;
}

static size_t DigitOf(uint64_t key, const Digit* digit)
{
    return (key >> digit->shift[0] & digit->mask[0]) | (key >> digit->shift[1] & digit->mask[1]) << digit->width;
}

static void SortByDigit(const qcSortItem* from, qcSortItem* to, size_t count, const Digit* digit, size_t digits)
{
    size_t offset[qc_digits];
    memset(offset, 0, digits * sizeof *offset);
    for (size_t i = 0; i < count; i++)
        offset[DigitOf(from[i].key, digit)]++;
    size_t sum = 0;
    for (size_t d = 0; d < digits; d++)
    {
        size_t number = offset[d];
        offset[d] = sum;
        sum += number;
    }
    for (size_t i = 0; i < count; i++)
        to[offset[DigitOf(from[i].key, digit)]++] = from[i];
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
    while (differ != 0)
    {
        Digit digit = TakeDigit(&differ, bits);
        SortByDigit(from, to, count, &digit, (size_t)1 << bits);
        qcSortItem* swap = from;
        from = to;
        to = swap;
    }
    if (from != items)
        memcpy(items, from, count * sizeof *items);
    return qc_statusOk;
}
