// Steps in which an allocation fails.
#ifndef QC_TESTS_SWEEP_FAILING_STEPS_H
#define QC_TESTS_SWEEP_FAILING_STEPS_H

#include "support/failing_heap.h"
#include "support/scenes.h"

/// Lets each allocation of a new scene's first step fail, one after the other, until the step succeeds. The next step
/// has to succeed; in every eighth scene `check` looks at its pairs, on one thread.
static inline void qcFailEachAllocation(qcScene* (*make)(void), uint64_t (*check)(qcScene* scene, uint32_t threads))
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcStatus status = qc_statusOutOfMemory;
    size_t calls = 0;
    while (status != qc_statusOk)
    {
        qcScene* scene = make();
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.threads = 1;
        const qcResult* result;
        heap = (qcFailingHeap){heap.live, 0, ++calls};
        status = qcScene_Detect(scene, &def, &result);
        ck_assert(status == qc_statusOk || status == qc_statusOutOfMemory);
        heap = (qcFailingHeap){heap.live, 0, 0};
        if (calls % 8 == 0)
            check(scene, 1);
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        qcScene_Destroy(scene);
    }
    ck_assert_uint_gt(calls, 30);
    ck_assert_uint_eq(heap.live, 0);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}

#endif
