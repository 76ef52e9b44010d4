// Flatness of patches. Why a flat patch has no self-contact: plugin/docs/proofs/flat_patch_test.md.
#include "sweep/bvh/patch_state.h"

#include "base/parallel_for.h"
#include "base/status.h"

enum
{
    // Large patches, each with its small ones.
    qc_patchBlock = 4,
    qc_minBlocks = 4,
    // A patch that isn't flat is tested again after so many fits.
    qc_cooldownFits = 7
};

static qcStatus Build(qcPatchState* state, const qcTriangleBvh* bvh, const qcAdjacency* adjacency, uint32_t threads)
{
    QC_TRY(
        qcFlatPatches_Build(&state->patches, &bvh->clusters, adjacency, bvh->corners.data, bvh->vertexCount, threads));
    QC_TRY(qcArray_Resize(&state->isFlat, state->patches.patches.count, 1, "flat patches"));
    return qcArray_GrowZeroed(&state->cooldown, state->patches.patches.count, 1, "flat patches");
}

qcStatus qcPatchState_Build(qcPatchState* state, const qcTriangleBvh* bvh, const qcAdjacency* adjacency,
                            uint32_t threads)
{
    *state = (qcPatchState){0};
    qcStatus status = Build(state, bvh, adjacency, threads);
    if (status != qc_statusOk)
        qcPatchState_Free(state);
    return status;
}

typedef struct Testing
{
    qcPatchState* state;
    const qcTriangleBvh* bvh;
    const qcTriangleKernels* kernels;
} Testing;

static void TestPatch(const Testing* t, uint32_t patch)
{
    const qcFlatPatches* patches = &t->state->patches;
    const qcFlatPatch* p = &QC_AT(qcFlatPatch, patches->patches, patch);
    uint8_t *isFlat = &QC_AT(uint8_t, t->state->isFlat, patch), *cooldown = &QC_AT(uint8_t, t->state->cooldown, patch);
    *isFlat = 0;
    if (p->slotCount == 0)
        return;
    if (*cooldown > 0)
    {
        (*cooldown)--;
        return;
    }
    qcPatchGeometry geometry = {.corners = t->bvh->corners.data,
                                .points = t->bvh->points.data,
                                .slots = &QC_AT(uint32_t, patches->slots, p->firstSlot),
                                .loop = &QC_AT(uint32_t, patches->loops, p->firstLoop),
                                .slotCount = p->slotCount,
                                .loopCount = p->loopCount,
                                .pointError = t->bvh->pointError,
                                .query = qcTriangleBvh_DistanceInFrame(t->bvh, t->bvh->margin)};
    *isFlat = t->kernels->isPatchFlat(&geometry);
    *cooldown = *isFlat ? 0 : qc_cooldownFits;
}

/// Large patches first: where one is flat, the small ones in it add little.
static void TestBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Testing* t = context;
    const qcFlatPatches* patches = &t->state->patches;
    uint32_t nodes = patches->nodeCount, first = (uint32_t)block * qc_patchBlock * qc_patchNodes;
    uint32_t end = nodes - first < qc_patchBlock * qc_patchNodes ? nodes : first + qc_patchBlock * qc_patchNodes;
    for (uint32_t node = first; node < end; node++)
    {
        uint32_t large = qcFlatPatches_Large(patches, node);
        if (node % qc_patchNodes == 0)
            TestPatch(t, large);
        if (!qcPatchState_IsFlat(t->state, large))
            TestPatch(t, node);
        else
            QC_AT(uint8_t, t->state->isFlat, node) = 0;
    }
}

void qcPatchState_Test(qcPatchState* state, const qcTriangleBvh* bvh, const qcTriangleKernels* kernels,
                       uint32_t threads)
{
    if (state->fitCount == bvh->fitCount)
        return;
    Testing testing = {state, bvh, kernels};
    size_t blockNodes = (size_t)qc_patchBlock * qc_patchNodes;
    size_t blocks = (state->patches.nodeCount + blockNodes - 1) / blockNodes;
    qcParallel_For(threads, blocks, qc_minBlocks, TestBlock, &testing);
    state->fitCount = bvh->fitCount;
}

uint64_t qcPatchState_CountFlat(const qcPatchState* state)
{
    const qcFlatPatches* patches = &state->patches;
    uint64_t count = 0;
    for (uint32_t node = 0; node < patches->nodeCount; node++)
    {
        const uint64_t* own = &QC_AT(uint64_t, patches->own, qc_patchSizes * (size_t)node);
        uint64_t flat = (qcPatchState_IsFlat(state, node) ? own[0] : 0) |
                        (qcPatchState_IsFlat(state, qcFlatPatches_Large(patches, node)) ? own[1] : 0);
        count += (uint64_t)__builtin_popcountll(flat);
    }
    return count;
}

int qcPatchState_FindExclusions(const qcPatchState* state, const qcClusters* clusters, uint32_t node, uint32_t link,
                                qcPairExclusion exclusions[qc_maxExclusions])
{
    const qcFlatPatches* patches = &state->patches;
    const qcPatchLink* patchLink = &QC_AT(qcPatchLink, patches->links, link);
    const uint64_t* own = patches->own.data;
    uint32_t other = QC_AT(qcLeafLink, clusters->links, link).other;
    int count = 0;
    for (int size = 0; size < qc_patchSizes; size++)
    {
        uint32_t patch = size == 0 ? node : qcFlatPatches_Large(patches, node),
                 patchOfOther = size == 0 ? other : qcFlatPatches_Large(patches, other);
        if (qcPatchState_IsFlat(state, patch) && patchLink->ofNode[size] != 0)
            exclusions[count++] = (qcPairExclusion){own[qc_patchSizes * (size_t)node + size], patchLink->ofNode[size]};
        if (patch != patchOfOther && qcPatchState_IsFlat(state, patchOfOther) && patchLink->ofOther[size] != 0)
            exclusions[count++] =
                (qcPairExclusion){patchLink->ofOther[size], own[qc_patchSizes * (size_t)other + size]};
    }
    return count;
}

void qcPatchState_Free(qcPatchState* state)
{
    qcFlatPatches_Free(&state->patches);
    qcArray_Free(&state->isFlat);
    qcArray_Free(&state->cooldown);
    *state = (qcPatchState){0};
}
