// Memory over a long run: what the library holds, what the C library has in use, and what is resident.
#ifndef QC_TESTS_LONG_MEMORY_USE_H
#define QC_TESTS_LONG_MEMORY_USE_H

#include "quickcullide/base.h"

#include <check.h>
#include <malloc.h>
#include <stdio.h>

enum
{
    qc_memorySamples = 32
};

typedef struct qcMemoryUse
{
    int count;
    size_t bytes[qc_memorySamples];     ///< qcGetByteCount
    size_t heapBytes[qc_memorySamples]; ///< of all allocations of the program
    long residentKb[qc_memorySamples];
} qcMemoryUse;

static inline long qcResidentKb(void)
{
    long size = 0, resident = 0;
    FILE* file = fopen("/proc/self/statm", "r");
    if (file != NULL && fscanf(file, "%ld %ld", &size, &resident) != 2)
        resident = 0;
    if (file != NULL)
        fclose(file);
    return 4 * resident;
}

/// Takes a sample, at a moment at which the same things are alive each time.
static inline void qcMemoryUse_Add(qcMemoryUse* memory)
{
    ck_assert_int_lt(memory->count, qc_memorySamples);
    memory->bytes[memory->count] = qcGetByteCount();
    // Large allocations have mappings of their own; which ones do changes as a program runs.
    const struct mallinfo2 heap = mallinfo2();
    memory->heapBytes[memory->count] = heap.uordblks + heap.hblkhd;
    memory->residentKb[memory->count++] = qcResidentKb();
}

/// From the first tenth of the samples on none is above the largest of these by more than a quarter; 64 KB of heap and
/// 8 MB of resident memory don't count.
static inline void qcMemoryUse_Check(const qcMemoryUse* memory)
{
    size_t bytes = 0, heapBytes = 0;
    long residentKb = 0;
    for (int i = 0; i < memory->count; i++)
    {
        if (i >= memory->count / 5)
        {
            ck_assert_msg(memory->bytes[i] <= bytes + bytes / 4 + 65536, "sample %d: %zu bytes, before %zu", i,
                          memory->bytes[i], bytes);
            ck_assert_msg(memory->heapBytes[i] <= heapBytes + heapBytes / 4 + 65536,
                          "sample %d: %zu bytes in the heap, before %zu", i, memory->heapBytes[i], heapBytes);
            ck_assert_msg(memory->residentKb[i] <= residentKb + residentKb / 4 + 8192,
                          "sample %d: %ld KB are resident, before %ld", i, memory->residentKb[i], residentKb);
            continue;
        }
        bytes = memory->bytes[i] > bytes ? memory->bytes[i] : bytes;
        heapBytes = memory->heapBytes[i] > heapBytes ? memory->heapBytes[i] : heapBytes;
        residentKb = memory->residentKb[i] > residentKb ? memory->residentKb[i] : residentKb;
    }
}

#endif
