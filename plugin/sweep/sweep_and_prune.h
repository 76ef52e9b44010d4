// Object-space overlap of boxes: sweep and prune in strips.
#ifndef QC_SWEEP_SWEEP_AND_PRUNE_H
#define QC_SWEEP_SWEEP_AND_PRUNE_H

#include "base/memory.h"

/// A box in the sweep's own coordinates (see qcSweepFrame), with two numbers of the caller's.
typedef struct qcSweepBox
{
    float lower[3], upper[3];
    uint32_t body, item;
} qcSweepBox;

/// Maps world coordinates to the sweep's, by one subtraction and one rounding.
typedef struct qcSweepFrame
{
    double origin[3];
    /// Boxes are this much larger at their upper ends: boxes no further apart than it in every axis overlap.
    double margin;
} qcSweepFrame;

qcSweepBox qcSweepFrame_Map(const qcSweepFrame* frame, const double lower[3], const double upper[3], uint32_t body,
                            uint32_t item);

/// Called once for each pair of boxes that overlap, in no order; `worker` as in qcParallel_For.
typedef void qcSweepFunction(void* context, const qcSweepBox* a, const qcSweepBox* b, uint32_t worker);

/// Memory that a sweep keeps between steps.
typedef struct qcSweep
{
    qcArray order, scratch, stripFirst, entries;
} qcSweep;

/// Finds all overlapping pairs. O(n log n + pairs) for boxes of similar sizes, O(n^2) at worst.
qcStatus qcSweep_FindPairs(qcSweep* sweep, const qcSweepBox* boxes, uint32_t count, uint32_t threads,
                           qcSweepFunction* function, void* context);
void qcSweep_Free(qcSweep* sweep);

#endif
