// Least significant digit first, 11 bits a pass; passes in which all keys agree are left out.
#include "sort.h"

#include "status.h"

#include <string.h>

enum
{
    qc_digitBits = 11,
    qc_digits = 1 << qc_digitBits
};

qcStatus qcSort_Items(qcSortItem* items, size_t count, qcArray* scratch)
{
    if (count < 2)
        return qc_statusOk;
    QC_TRY(qcArray_Reserve(scratch, count, sizeof(qcSortItem), "sorting"));
    uint64_t differ = 0;
    for (size_t i = 1; i < count; i++)
        differ |= items[i].key ^ items[0].key;
    qcSortItem *from = items, *to = scratch->data;
    for (int shift = 0; shift < 64; shift += qc_digitBits)
    {
        if ((differ >> shift & (qc_digits - 1)) == 0)
            continue;
        size_t offset[qc_digits] = {0};
        for (size_t i = 0; i < count; i++)
            offset[from[i].key >> shift & (qc_digits - 1)]++;
        size_t sum = 0;
        for (int d = 0; d < qc_digits; d++)
        {
            size_t number = offset[d];
            offset[d] = sum;
            sum += number;
        }
        for (size_t i = 0; i < count; i++)
            to[offset[from[i].key >> shift & (qc_digits - 1)]++] = from[i];
        qcSortItem* swap = from;
        from = to;
        to = swap;
    }
    if (from != items)
        memcpy(items, from, count * sizeof *items);
    return qc_statusOk;
}
