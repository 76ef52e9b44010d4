// Flatness of patches. Why a flat patch has no self-contact: plugin/docs/proofs/flat_patch_test.md.
#include "sweep/bvh/patch_state.h"

#include "base/parallel_for.h"
#include "base/status.h"
#include "sweep/bvh/bvh_lattice.h"

enum
{
    // Large patches, each with its small ones.
    qc_patchBlock = 1,
    qc_minBlocks = 16,
    // A patch that isn't flat is tested again after so many fits.
    qc_cooldownFits = 7
};

static qcStatus AllocateFlags(const qcPatchState* state, qcPatchFlags* flags)
{
    QC_TRY(qcArray_Resize(&flags->isFlat, state->patches.patches.count, 1, "flat patches"));
    return qcArray_GrowZeroed(&flags->cooldown, state->patches.patches.count, 1, "flat patches");
}

static qcStatus Build(qcPatchState* state, const qcPatchSource* source, uint32_t nodeCount, uint32_t threads)
{
    if (state->growth.builders == NULL)
        QC_TRY(qcFlatPatches_Begin(&state->patches, &state->growth, source));
    QC_TRY(qcFlatPatches_Grow(&state->patches, &state->growth, source, nodeCount, threads));
    if (state->growth.nextNode < state->patches.nodeCount)
        return qc_statusOk;
    qcPatchGrowth_Free(&state->growth);
    return AllocateFlags(state, &state->present);
}

qcStatus qcPatchState_Build(qcPatchState* state, const qcTriangleBvh* bvh, const qcAdjacency* adjacency,
                            uint32_t nodeCount, uint32_t threads)
{
    const qcPatchSource source = {&bvh->clusters, adjacency, bvh->corners.data, bvh->vertexCount};
    qcStatus status = Build(state, &source, nodeCount, threads);
    if (status != qc_statusOk)
        qcPatchState_Free(state);
    return status;
}

typedef struct Testing
{
    const qcFlatPatches* patches;
    qcPatchFlags* flags;
    const qcTriangleBvh* bvh;
    const qcBvhFit* startFit; ///< null: the present alone
    const qcTriangleKernels* kernels;
} Testing;

static qcPatchGeometry GeometryOf(const Testing* t, const qcFlatPatch* patch, const qcBvhFit* fit)
{
    return (qcPatchGeometry){.corners = t->bvh->corners.data,
                             .points = fit->points.data,
                             .slots = &QC_AT(uint32_t, t->patches->slots, patch->firstSlot),
                             .loop = &QC_AT(uint32_t, t->patches->loops, patch->firstLoop),
                             .slotCount = patch->slotCount,
                             .loopCount = patch->loopCount,
                             .pointError = fit->pointError};
}

/// Errors of their points may be larger than the kernels allow for.
static bool HasOutliers(const Testing* t, const qcFlatPatch* patch, const qcBvhFit* fit)
{
    bool has = false;
    for (size_t i = 0; fit->lattice.hasOutliers && i < patch->slotCount; i++)
    {
        uint32_t slot = QC_AT(uint32_t, t->patches->slots, patch->firstSlot + i);
        has |= qcBvhFit_IsOutlier(fit, &QC_AT(qcCorners, t->bvh->corners, slot));
    }
    return has;
}

static bool IsFlat(const Testing* t, const qcFlatPatch* patch)
{
    const qcBvhFit* fit = &t->bvh->fit;
    if (HasOutliers(t, patch, fit) || (t->startFit != NULL && HasOutliers(t, patch, t->startFit)))
        return false;
    qcPatchGeometry geometry = GeometryOf(t, patch, fit);
    if (t->startFit == NULL)
    {
        geometry.query = qcTriangleBvh_DistanceInFrame(t->bvh, fit->margin);
        return t->kernels->isPatchFlat(&geometry);
    }
    const qcPatchGeometry patches[2] = {GeometryOf(t, patch, t->startFit), geometry};
    double start = t->startFit->lattice.unit[0], end = fit->lattice.unit[0], unit = start < end ? start : end;
    const float scales[2] = {(float)(unit / start), (float)(unit / end)};
    return t->kernels->isPatchFlatInMotion(patches, scales);
}

static void TestPatch(const Testing* t, uint32_t patch)
{
    const qcFlatPatch* p = &QC_AT(qcFlatPatch, t->patches->patches, patch);
    uint8_t *isFlat = &QC_AT(uint8_t, t->flags->isFlat, patch), *cooldown = &QC_AT(uint8_t, t->flags->cooldown, patch);
    *isFlat = 0;
    if (p->slotCount == 0)
        return;
    if (*cooldown > 0)
    {
        (*cooldown)--;
        return;
    }
    *isFlat = IsFlat(t, p);
    *cooldown = *isFlat ? 0 : qc_cooldownFits;
}

/// Large patches first: where one is flat, the small ones in it add little.
static void TestBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Testing* t = context;
    const qcFlatPatches* patches = t->patches;
    uint32_t nodes = patches->nodeCount, first = (uint32_t)block * qc_patchBlock * qc_patchNodes;
    uint32_t end = nodes - first < qc_patchBlock * qc_patchNodes ? nodes : first + qc_patchBlock * qc_patchNodes;
    for (uint32_t node = first; node < end; node++)
    {
        uint32_t large = qcFlatPatches_Large(patches, node);
        if (node % qc_patchNodes == 0)
            TestPatch(t, large);
        if (!qcPatchFlags_IsFlat(t->flags, large))
            TestPatch(t, node);
        else
            QC_AT(uint8_t, t->flags->isFlat, node) = 0;
    }
}

static void RunTests(Testing* testing, uint32_t threads)
{
    size_t blockNodes = (size_t)qc_patchBlock * qc_patchNodes;
    size_t blocks = (testing->patches->nodeCount + blockNodes - 1) / blockNodes;
    qcParallel_For(threads, blocks, qc_minBlocks, TestBlock, testing);
    testing->flags->fitCount = testing->bvh->fit.fitCount;
}

void qcPatchState_Test(qcPatchState* state, const qcTriangleBvh* bvh, const qcTriangleKernels* kernels,
                       uint32_t threads)
{
    if (state->present.fitCount == bvh->fit.fitCount)
        return;
    Testing testing = {&state->patches, &state->present, bvh, NULL, kernels};
    RunTests(&testing, threads);
}

qcStatus qcPatchState_TestMotion(qcPatchState* state, const qcTriangleBvh* bvh, const qcBvhFit* startFit,
                                 const qcTriangleKernels* kernels, uint32_t threads)
{
    qcPatchFlags* flags = &state->motion;
    if (flags->fitCount == bvh->fit.fitCount && flags->startFitCount == startFit->fitCount)
        return qc_statusOk;
    QC_TRY(AllocateFlags(state, flags));
    Testing testing = {&state->patches, flags, bvh, startFit, kernels};
    RunTests(&testing, threads);
    flags->startFitCount = startFit->fitCount;
    return qc_statusOk;
}

uint64_t qcPatchState_CountFlat(const qcPatchState* state, const qcPatchFlags* flags)
{
    const qcFlatPatches* patches = &state->patches;
    uint64_t count = 0;
    for (uint32_t node = 0; node < patches->nodeCount; node++)
    {
        const uint64_t* own = &QC_AT(uint64_t, patches->own, qc_patchSizes * (size_t)node);
        uint64_t flat = (qcPatchFlags_IsFlat(flags, node) ? own[0] : 0) |
                        (qcPatchFlags_IsFlat(flags, qcFlatPatches_Large(patches, node)) ? own[1] : 0);
        count += (uint64_t)__builtin_popcountll(flat);
    }
    return count;
}

int qcPatchState_FindExclusions(const qcPatchState* state, const qcPatchFlags* flags, const qcClusters* clusters,
                                uint32_t node, uint32_t link, qcPairExclusion exclusions[qc_maxExclusions])
{
    const qcFlatPatches* patches = &state->patches;
    const qcPatchLink* patchLink = &QC_AT(qcPatchLink, patches->links, link);
    const uint64_t* own = patches->own.data;
    uint32_t other = QC_AT(qcLeafLink, clusters->links, link).other;
    int count = 0;
    for (size_t size = 0; size < qc_patchSizes; size++)
    {
        uint32_t patch = size == 0 ? node : qcFlatPatches_Large(patches, node),
                 patchOfOther = size == 0 ? other : qcFlatPatches_Large(patches, other);
        if (qcPatchFlags_IsFlat(flags, patch) && patchLink->ofNode[size] != 0)
            exclusions[count++] = (qcPairExclusion){own[qc_patchSizes * (size_t)node + size], patchLink->ofNode[size]};
        if (patch != patchOfOther && qcPatchFlags_IsFlat(flags, patchOfOther) && patchLink->ofOther[size] != 0)
            exclusions[count++] =
                (qcPairExclusion){patchLink->ofOther[size], own[qc_patchSizes * (size_t)other + size]};
    }
    return count;
}

void qcPatchState_Free(qcPatchState* state)
{
    qcFlatPatches_Free(&state->patches);
    qcPatchGrowth_Free(&state->growth);
    qcArray_Free(&state->present.isFlat);
    qcArray_Free(&state->present.cooldown);
    qcArray_Free(&state->motion.isFlat);
    qcArray_Free(&state->motion.cooldown);
    *state = (qcPatchState){0};
}
