// Visibility tests whose result no rounding of a rasteriser can change, found from the triangles alone: a software
// device then draws the other tests, and the renders that these need. Proof: plugin/docs/proofs/sure_results.md.
#ifndef QC_GL_VISIBILITY_SURE_RESULTS_H
#define QC_GL_VISIBILITY_SURE_RESULTS_H

#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"

/// All zero at first; keeps its memory between passes.
typedef struct qcSureResults
{
    qcArray steps;  ///< qcVisibilityStep: what is left to test and to render, a triangle each
    qcArray stepOf; ///< uint32_t: the step of the pass that each belongs to; it is hidden if one of its tests is
    qcArray triangles, cellFirst, entries, drawn; // scratch
} qcSureResults;

typedef struct qcSureView
{
    const float* corners; ///< nine floats a triangle, within [-1, 1]
    uint32_t resolution;  ///< pixels on a side of the image
    int axis;             ///< of view; the image's x is the next axis in cyclic order
    bool fromBack;
} qcSureView;

/// Sets visible[i] of the tests that are sure, and 1 of those left. Fills `steps`. O(overlaps of the triangles' boxes).
qcStatus qcSureResults_Find(qcSureResults* results, const qcSureView* view, const qcVisibilityStep* steps,
                            uint32_t stepCount, uint8_t* visible);
void qcSureResults_Free(qcSureResults* results);

#endif
