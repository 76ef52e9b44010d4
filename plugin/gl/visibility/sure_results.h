// Visibility tests whose result no rounding of a rasteriser can change, found from the triangles alone: the device then
// draws the other tests, and the renders that these need. gl/visibility/sure_kernels.h: the same on a GPU.
// Proof: plugin/docs/proofs/sure_results.md.
#ifndef QC_GL_VISIBILITY_SURE_RESULTS_H
#define QC_GL_VISIBILITY_SURE_RESULTS_H

#include "gl/visibility/occlusion_queries.h"
#include "base/memory.h"

/// What is drawn of a triangle of a step, or that it needs no drawing.
typedef enum qcSureFound
{
    qc_sureTest = 1,   ///< it is tested
    qc_sureRender = 2, ///< it is rendered
    qc_sureHidden = 4  ///< it is hidden, and with it its step
} qcSureFound;

/// All zero at first; keeps its memory between passes.
typedef struct qcSureResults
{
    /// A triangle that is tested and rendered is left as one step, so that it can be counted (fragment_flags.h).
    bool counts;
    qcArray steps;  ///< qcVisibilityStep: what is left to test and to render, a triangle each
    qcArray stepOf; ///< uint32_t: the step of the pass that each belongs to; it is hidden if one of its tests is
    qcArray triangles, cellFirst, entries, found; // scratch
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
/// Triangles of a step that takes part.
static inline uint32_t qcSureResults_CountParts(const qcVisibilityStep* step)
{
    return step->test || step->render ? step->triangleCount : 0;
}

/// Triangles of all steps, whether they take part or not.
static inline size_t qcSureResults_CountTriangles(const qcVisibilityStep* steps, uint32_t stepCount)
{
    size_t count = 0;
    for (uint32_t s = 0; s < stepCount; ++s)
        count += steps[s].triangleCount;
    return count;
}

/// Takes results found elsewhere. `found`: for each triangle of each step that takes part, bits of qcSureFound.
qcStatus qcSureResults_Take(qcSureResults* results, const qcVisibilityStep* steps, uint32_t stepCount,
                            const uint32_t* found, uint8_t* visible);
void qcSureResults_Free(qcSureResults* results);

#endif
