// Stable radix sort of keys with values. All results of the library are sorted by it.
#ifndef QC_BASE_RADIX_SORT_H
#define QC_BASE_RADIX_SORT_H

#include "base/memory.h"

typedef struct qcSortItem
{
    uint64_t key;
    uint64_t value;
} qcSortItem;

/// Sorts by key, ascending; items with the same key keep their order. O(count) per 12 bits in which keys differ.
/// `scratch` is memory to reuse.
qcStatus qcSort_Items(qcSortItem* items, size_t count, qcArray* scratch);
/// Sorts keys without values. O(count) per 12 bits in which keys differ.
qcStatus qcSort_Keys(uint64_t* keys, size_t count, qcArray* scratch);
/// Like qcSort_Keys; `scratch` has room for as many keys.
void qcSort_KeysWith(uint64_t* keys, uint64_t* scratch, size_t count);
/// The bits in which keys differ.
uint64_t qcSort_FindDifference(const uint64_t* keys, size_t count);

/// A key whose order is the order of the floats (NaN excluded).
static inline uint32_t qcSort_FloatKey(float value)
{
    union
    {
        float f;
        uint32_t u;
    } bits = {value + 0.0f}; // -0 becomes +0, which compares equal
    return bits.u & 0x80000000u ? ~bits.u : bits.u | 0x80000000u;
}

/// As qcSort_FloatKey, for doubles.
static inline uint64_t qcSort_DoubleKey(double value)
{
    union
    {
        double d;
        uint64_t u;
    } bits = {value + 0.0};
    return bits.u >> 63 != 0 ? ~bits.u : bits.u | (uint64_t)1 << 63;
}

#endif
