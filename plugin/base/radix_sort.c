// Least significant digit first, up to 12 bits a pass, or 8 for few items. A digit may consist of two parts with equal
// bits between them, which are skipped: keys made of two small numbers have such a gap. Where the most significant
// digit leaves few items together, one pass over it and insertion suffice.
#include "base/radix_sort.h"

#include "base/status.h"

#include <stdbool.h>
#include <string.h>

enum
{
    qc_digitBits = 11,
    qc_digits = 1 << qc_digitBits,
    // One bit more where that saves a pass: the 34 bits of the pairs of the bench's tangle-92k take 3 passes.
    qc_maxDigitBits = 12,
    // For few items a pass over 11 bits takes 1.5 us, one over 8 bits 0.2 us, but more passes are needed.
    qc_shortDigitBits = 8,
    qc_maxShortItems = 1024,
    // Insertion takes 0.5 us for 32 items.
    qc_maxInsertedItems = 32,
    // Items with the same leading digit, on average over items, up to which insertion is quicker than other passes: the
    // 4500 pairs of the bench's bunnies-27 have 12 each.
    qc_maxTogether = 24
};

// Below, an item is `words` words of 64 bits, of which the first is its key: 1 or 2, a constant in each caller.

/// Insertion sort, faster than counting digits for very few items.
static inline void InsertItems(uint64_t* items, size_t count, size_t words)
{
    for (size_t i = 1; i < count; i++)
    {
        uint64_t item[2];
        memcpy(item, items + words * i, words * sizeof *items);
        size_t at = i;
        for (; at > 0 && items[words * (at - 1)] > item[0]; at--)
            memcpy(items + words * at, items + words * (at - 1), words * sizeof *items);
        memcpy(items + words * at, item, words * sizeof *items);
    }
}

/// Bits in which keys differ, ascending, from two ranges of the key; all keys agree between the ranges.
typedef struct Digit
{
    int shift[2], width;
    uint64_t mask[2];
} Digit;

/// Removes up to `bits` of the lowest remaining bits.
static Digit TakeDigit(uint64_t* remaining, int bits)
{
    Digit digit = {.shift = {__builtin_ctzll(*remaining), 0}};
    uint64_t window = *remaining >> digit.shift[0] & (((uint64_t)1 << bits) - 1);
    digit.width = 64 - __builtin_clzll(window);
    digit.mask[0] = ((uint64_t)1 << digit.width) - 1;
    *remaining &= ~(digit.mask[0] << digit.shift[0]);
    if (digit.width == bits || *remaining == 0)
        return digit;
    digit.shift[1] = __builtin_ctzll(*remaining);
    digit.mask[1] = ((uint64_t)1 << (bits - digit.width)) - 1;
    *remaining &= ~(digit.mask[1] << digit.shift[1]);
    return digit;
}

static size_t DigitOf(uint64_t key, const Digit* digit)
{
    return (key >> digit->shift[0] & digit->mask[0]) | (key >> digit->shift[1] & digit->mask[1]) << digit->width;
}

/// Counts the keys of each value of a digit.
static inline void CountDigits(const uint64_t* items, size_t count, size_t words, const Digit* digit, size_t digits,
                               size_t* number)
{
    memset(number, 0, digits * sizeof *number);
    for (size_t i = 0; i < count; i++)
        number[DigitOf(items[words * i], digit)]++;
}

/// Orders by a digit whose values are counted in `number`; items of one value keep their order.
static inline void Distribute(const uint64_t* from, uint64_t* to, size_t count, size_t words, const Digit* digit,
                              size_t digits, size_t* number)
{
    size_t sum = 0;
    for (size_t d = 0; d < digits; d++)
    {
        size_t of = number[d];
        number[d] = sum;
        sum += of;
    }
    for (size_t i = 0; i < count; i++)
        memcpy(to + words * number[DigitOf(from[words * i], digit)]++, from + words * i, words * sizeof *to);
}

/// Sorts by the leading digit, then inserts, if that is quick. Otherwise it does nothing, and returns false. `differ`
/// has the bits in which keys differ.
static inline bool SortByLeadingDigit(uint64_t* items, uint64_t* scratch, size_t count, size_t words, uint64_t differ)
{
    int top = 64 - __builtin_clzll(differ), shift = top > qc_digitBits ? top - qc_digitBits : 0;
    const Digit digit = {.shift = {shift, 0}, .width = qc_digitBits, .mask = {qc_digits - 1, 0}};
    size_t number[qc_digits];
    CountDigits(items, count, words, &digit, qc_digits, number);
    uint64_t together = 0;
    for (size_t d = 0; d < qc_digits; d++)
        together += (uint64_t)number[d] * number[d];
    if (together > (uint64_t)qc_maxTogether * count)
        return false;
    memcpy(scratch, items, count * words * sizeof *items);
    Distribute(scratch, items, count, words, &digit, qc_digits, number);
    InsertItems(items, count, words);
    return true;
}

static int ChooseDigitBits(size_t count, uint64_t differ)
{
    if (count <= qc_maxShortItems)
        return qc_shortDigitBits;
    int bits = __builtin_popcountll(differ), passes = (bits + qc_digitBits - 1) / qc_digitBits;
    return bits > (passes - 1) * qc_maxDigitBits ? qc_digitBits : qc_maxDigitBits;
}

/// The bits in which keys differ.
static inline uint64_t FindDifference(const uint64_t* items, size_t count, size_t words)
{
    uint64_t differ = 0;
    for (size_t i = 1; i < count; i++)
        differ |= items[words * i] ^ items[0];
    return differ;
}

/// `scratch` has room for the items.
static inline void SortWith(uint64_t* items, uint64_t* scratch, size_t count, size_t words)
{
    if (count <= qc_maxInsertedItems)
    {
        InsertItems(items, count, words);
        return;
    }
    uint64_t differ = FindDifference(items, count, words);
    // With more items the average is larger.
    if (count <= (size_t)qc_maxTogether * qc_digits && differ != 0 &&
        SortByLeadingDigit(items, scratch, count, words, differ))
        return;
    uint64_t *from = items, *to = scratch;
    int bits = ChooseDigitBits(count, differ);
    while (differ != 0)
    {
        Digit digit = TakeDigit(&differ, bits);
        size_t number[1 << qc_maxDigitBits], digits = (size_t)1 << bits;
        CountDigits(from, count, words, &digit, digits, number);
        Distribute(from, to, count, words, &digit, digits, number);
        uint64_t* swap = from;
        from = to;
        to = swap;
    }
    if (from != items)
        memcpy(items, from, count * words * sizeof *items);
}

static inline qcStatus Sort(uint64_t* items, size_t count, size_t words, qcArray* scratch)
{
    if (count > qc_maxInsertedItems)
        QC_TRY(qcArray_Reserve(scratch, count, words * sizeof *items, "sorting"));
    SortWith(items, scratch->data, count, words);
    return qc_statusOk;
}

qcStatus qcSort_Items(qcSortItem* items, size_t count, qcArray* scratch)
{
    return Sort((uint64_t*)items, count, 2, scratch);
}

qcStatus qcSort_Keys(uint64_t* keys, size_t count, qcArray* scratch)
{
    return Sort(keys, count, 1, scratch);
}

void qcSort_KeysWith(uint64_t* keys, uint64_t* scratch, size_t count)
{
    SortWith(keys, scratch, count, 1);
}

uint64_t qcSort_FindDifference(const uint64_t* keys, size_t count)
{
    return FindDifference(keys, count, 1);
}
