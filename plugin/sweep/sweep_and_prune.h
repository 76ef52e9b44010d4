// Overlapping boxes by sweep and prune in strips.
#ifndef QC_SWEEP_SWEEP_AND_PRUNE_H
#define QC_SWEEP_SWEEP_AND_PRUNE_H

#include "base/memory.h"

/// A box in the coordinates of a qcSweepFrame, with two numbers of the caller.
typedef struct qcSweepBox
{
    float lower[3], upper[3];
    uint32_t body, item;
} qcSweepBox;

enum
{
    // The median of 31 corners lies among the boxes even if ten of them are far away.
    qc_originCorners = 31
};

/// From world coordinates to single precision near the origin.
typedef struct qcSweepFrame
{
    double origin[3];
    /// Upper ends grow by this: boxes no further apart in any axis overlap.
    double margin;
} qcSweepFrame;

qcSweepBox qcSweepFrame_Map(const qcSweepFrame* frame, const double lower[3], const double upper[3], uint32_t body,
                            uint32_t item);

/// Makes the median of lower corners of boxes, by axis, the origin. Any origin is correct; one among most of the boxes
/// keeps them apart in single precision. Rearranges the corners. No corners: nothing changes.
void qcSweepFrame_SetOrigin(qcSweepFrame* frame, double (*corners)[3], uint32_t count);

/// Receives each pair of overlapping boxes once, in no order; `worker` as in qcParallel_For.
typedef void qcSweepFunction(void* context, const qcSweepBox* a, const qcSweepBox* b, uint32_t worker);

/// Memory, retained between steps.
typedef struct qcSweep
{
    qcArray order, scratch, stripFirst, entries;
    uint64_t comparisons; ///< pairs of boxes compared by the last search
} qcSweep;

/// Finds all overlapping pairs. O(n log n + pairs) for boxes most of which are of similar sizes, wherever they are:
/// a few far away or very large ones cost O(n) each at worst. O(n^2) at worst.
qcStatus qcSweep_FindPairs(qcSweep* sweep, const qcSweepBox* boxes, uint32_t count, uint32_t threads,
                           qcSweepFunction* function, void* context);
void qcSweep_Free(qcSweep* sweep);

#endif
