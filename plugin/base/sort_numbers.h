// Sorts few numbers.
#ifndef QC_BASE_SORT_NUMBERS_H
#define QC_BASE_SORT_NUMBERS_H

#include <stdint.h>

/// Insertion sort, ascending; no number is NaN.
static inline void qcSortNumbers(double* numbers, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++)
    {
        double number = numbers[i];
        uint32_t at = i;
        for (; at > 0 && numbers[at - 1] > number; at--)
            numbers[at] = numbers[at - 1];
        numbers[at] = number;
    }
}

#endif
