// The flat patches of a body (mesh/flat_patches.h), and which of them are proven flat at its current positions: pairs
// of triangles of one flat patch need no test.
#ifndef QC_SWEEP_BVH_PATCH_STATE_H
#define QC_SWEEP_BVH_PATCH_STATE_H

#include "mesh/flat_patches.h"
#include "sweep/bvh/triangle_bvh.h"

/// The result of a test.
typedef struct qcPatchFlags
{
    qcArray isFlat;         ///< uint8_t by patch: proven flat by the last test
    qcArray cooldown;       ///< uint8_t by patch: tests left until its flatness is computed again
    uint64_t fitCount;      ///< of the fit at the last test; 0: none yet
    uint64_t startFitCount; ///< of the fit to the start of a motion
} qcPatchFlags;

typedef struct qcPatchState
{
    qcFlatPatches patches;
    qcPatchGrowth growth; ///< until all patches are made
    qcPatchFlags present; ///< at the last fit
    qcPatchFlags motion;  ///< over the motion
} qcPatchState;

/// Makes the patches of the next nodes, of a BVH whose clusters are linked: at least so many, or those that are left.
/// `adjacency` is that of its corners. O(nodes); the first call: O(triangles). On failure nothing is left.
qcStatus qcPatchState_Build(qcPatchState* state, const qcTriangleBvh* bvh, const qcAdjacency* adjacency,
                            uint32_t nodeCount, uint32_t threads);

/// Whether all patches are made.
static inline bool qcPatchState_IsBuilt(const qcPatchState* state)
{
    return state->present.isFlat.count != 0;
}

/// Tests which patches have no self-contact within the margin of the fit; once for each fit. A patch that isn't flat is
/// skipped for the next seven fits. O(triangles).
void qcPatchState_Test(qcPatchState* state, const qcTriangleBvh* bvh, const qcTriangleKernels* kernels,
                       uint32_t threads);

/// Tests which patches have no self-contact over the motion between both fits; once for each two fits.
qcStatus qcPatchState_TestMotion(qcPatchState* state, const qcTriangleBvh* bvh, const qcBvhFit* startFit,
                                 const qcTriangleKernels* kernels, uint32_t threads);

/// Triangles in patches that are flat.
uint64_t qcPatchState_CountFlat(const qcPatchState* state, const qcPatchFlags* flags);

/// The pairs of triangles of a leaf node and the other node of its link that lie in one flat patch. Returns the number
/// of exclusions.
int qcPatchState_FindExclusions(const qcPatchState* state, const qcPatchFlags* flags, const qcClusters* clusters,
                                uint32_t node, uint32_t link, qcPairExclusion exclusions[qc_maxExclusions]);

static inline bool qcPatchFlags_IsFlat(const qcPatchFlags* flags, uint32_t patch)
{
    return QC_AT(uint8_t, flags->isFlat, patch) != 0;
}

void qcPatchState_Free(qcPatchState* state);

#endif
