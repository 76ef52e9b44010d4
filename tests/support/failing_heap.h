// A heap for qcSetAllocator in which one allocation fails.
#ifndef QC_TESTS_SUPPORT_FAILING_HEAP_H
#define QC_TESTS_SUPPORT_FAILING_HEAP_H

#include <stddef.h>
#include <stdlib.h>

typedef struct qcFailingHeap
{
    size_t live, calls, failAt; ///< failAt: number of the failing call, from 1 on; 0: none
} qcFailingHeap;

static inline void* qcFailingHeap_Allocate(size_t size, void* context)
{
    qcFailingHeap* heap = context;
    if (++heap->calls == heap->failAt)
        return NULL;
    heap->live += size;
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static inline void qcFailingHeap_Release(void* memory, size_t size, void* context)
{
    qcFailingHeap* heap = context;
    heap->live -= size;
    free(memory);
}

#endif
