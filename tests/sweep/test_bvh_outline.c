// An outline of a BVH has the boxes of a whole fit, bit by bit, from leaf nodes up; its leaf nodes, fitted on demand,
// have those of a whole fit too.
#include "scene/float_positions.h"
#include "support/failing_heap.h"
#include "support/suite.h"
#include "sweep/bvh/triangle_bvh.h"
#include "sweep/sample_bodies.h"

#include <string.h>

/// A body, a BVH of which outlines are fitted, and one that is fitted as a whole.
typedef struct Fits
{
    qcBodies bodies;
    uint32_t slot;
    qcTriangleBvh outline, whole;
    qcBvhScratch scratch;
    const qcTriangleKernels* kernels;
    uint32_t threads;
} Fits;

static Fits MakeFits(qcSoup* soup, const qcTriangleKernels* kernels, uint32_t threads)
{
    Fits f = {.kernels = kernels, .threads = threads};
    f.slot = qcAddToBodies(&f.bodies, soup);
    CHECK_OK(qcTriangleBvh_Build(&f.outline, qcBodyAt(&f.bodies, f.slot), &(qcOrderOptions){.threads = 1}));
    CHECK_OK(qcTriangleBvh_Build(&f.whole, qcBodyAt(&f.bodies, f.slot), &(qcOrderOptions){.threads = 1}));
    return f;
}

static void FreeFits(Fits* f)
{
    qcTriangleBvh_Free(&f->outline);
    qcTriangleBvh_Free(&f->whole);
    qcBvhScratch_Free(&f->scratch);
    qcBodies_Free(&f->bodies);
}

static const qcBody* BodyOf(const Fits* f)
{
    return qcBodyAt(&f->bodies, f->slot);
}

/// New positions, kept as floats or as doubles.
static void Move(Fits* f, const qcSoup* soup, bool asFloats)
{
    if (!asFloats)
    {
        CHECK_OK(qcBodies_SetVertices(&f->bodies, f->slot, soup->positions, qc_positionF64, 0));
        return;
    }
    float* floats = malloc((size_t)soup->vertexCount * 3 * sizeof(float));
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
        floats[i] = (float)soup->positions[i];
    for (int i = 0; i < 2; i++)
    {
        CHECK_OK(qcBodies_SetVertices(&f->bodies, f->slot, floats, qc_positionF32, 0));
        CHECK_OK(qcFloatPositions_Keep(&QC_AT(qcBody, f->bodies.slots, f->slot)));
    }
    ck_assert(qcBody_IsInFloats(BodyOf(f)));
    free(floats);
}

static void FitWhole(Fits* f, double margin)
{
    bool fits;
    CHECK_OK(qcTriangleBvh_Fit(&f->whole, BodyOf(f), margin, f->kernels, f->threads, &f->scratch, &fits));
    ck_assert(fits && qcTriangleBvh_IsUpToDate(&f->whole, BodyOf(f), margin));
    ck_assert(qcTriangleBvh_IsOutlineUpToDate(&f->whole, BodyOf(f), margin));
}

/// The boxes and points of leaf nodes become others, which no fit would make.
static void FitOutline(Fits* f, double margin)
{
    bool fits;
    qcTriangleBvh* bvh = &f->outline;
    memset(bvh->fit.boxes.data, 0x55, (bvh->box8Count[0] + bvh->box8Count[1]) * sizeof(qcBox8));
    memset(bvh->fit.points.data, 0x55, bvh->vertexCount * sizeof(qcPoint));
    bvh->fit.fitted = false;
    CHECK_OK(qcTriangleBvh_FitOutline(bvh, BodyOf(f), margin, f->kernels, f->threads, &f->scratch, &fits));
    ck_assert(fits && qcTriangleBvh_IsOutlineUpToDate(bvh, BodyOf(f), margin));
    ck_assert(!qcTriangleBvh_IsUpToDate(bvh, BodyOf(f), margin));
}

static void CheckEqual(const qcTriangleBvh* a, const qcTriangleBvh* b, uint32_t level, size_t first, size_t count)
{
    ck_assert_mem_eq(qcTriangleBvh_Box8At(a, &a->fit, level, (uint32_t)first),
                     qcTriangleBvh_Box8At(b, &b->fit, level, (uint32_t)first), count * sizeof(qcBox8));
}

static void CheckUpperLevels(const Fits* f)
{
    const qcTriangleBvh *a = &f->outline, *b = &f->whole;
    for (uint32_t level = 2; level < a->levels; level++)
        CheckEqual(a, b, level, 0, a->box8Count[level]);
    ck_assert_mem_eq(&a->fit.root, &b->fit.root, sizeof a->fit.root);
}

static void CheckNode(const Fits* f, uint32_t node)
{
    const qcTriangleBvh *a = &f->outline, *b = &f->whole;
    CheckEqual(a, b, 0, (size_t)node * qc_boxLanes, qc_boxLanes);
    CheckEqual(a, b, 1, node, 1);
    for (size_t slot = (size_t)node * qc_nodeSize; slot < ((size_t)node + 1) * qc_nodeSize; slot++)
        for (int c = 0; c < 3; c++)
        {
            uint32_t vertex = QC_AT(qcCorners, a->corners, slot).vertex[c];
            ck_assert_mem_eq(&QC_AT(qcPoint, a->fit.points, vertex), &QC_AT(qcPoint, b->fit.points, vertex),
                             sizeof(qcPoint));
        }
}

static qcStatus FitNodes(Fits* f, const uint8_t* flags)
{
    return qcTriangleBvh_FitNodes(&f->outline, BodyOf(f), flags, f->kernels, f->threads, &f->scratch);
}

/// Fits some leaf nodes, then more, then all.
static void CheckNodes(Fits* f, uint64_t seed)
{
    qcRandom random = {seed};
    uint32_t nodeCount = f->outline.clusters.nodeCount;
    uint8_t* flags = calloc(nodeCount, 1);
    for (uint32_t share = 4; share-- > 0;)
    {
        for (uint32_t node = 0; node < nodeCount; node++)
            flags[node] = flags[node] || qcRandom_Below(&random, share + 1) == 0;
        CHECK_OK(FitNodes(f, flags));
        for (uint32_t node = 0; node < nodeCount; node++)
            if (flags[node])
                CheckNode(f, node);
    }
    ck_assert_uint_eq(f->outline.fit.fittedCount, nodeCount);
    free(flags);
}

static void CheckSoup(qcSoup* soup, const qcSoup* moved)
{
    FOR_EACH_KERNELS(k)
    for (uint32_t threads = 1; threads <= 3; threads += 2)
    {
        Fits f = MakeFits(soup, k, threads);
        for (int step = 0; step < 4; step++)
        {
            double margin = step / 2 == 0 ? 0.0 : 0.01;
            Move(&f, step == 1 ? moved : soup, step % 2 == 0);
            FitWhole(&f, margin);
            FitOutline(&f, margin);
            CheckUpperLevels(&f);
            CheckNodes(&f, (uint64_t)step);
        }
        FreeFits(&f);
    }
}

START_TEST(an_outline_and_its_leaf_nodes_are_those_of_a_whole_fit)
{
    const uint32_t sides[] = {1, 6, 20, 90};
    for (size_t i = 0; i < sizeof sides / sizeof *sides; i++)
    {
        qcSoup soup = qcSoup_MakeFoldedCloth(3, sides[i], 0.02, 0.03),
               moved = qcSoup_MakeFoldedCloth(4, sides[i], 0.02, 0.05);
        qcSoup_Translate(&moved, 1e6, -3.0, 0.0);
        CheckSoup(&soup, &moved);
        qcSoup_Free(&soup);
        qcSoup_Free(&moved);
    }
    qcSoup apart = qcSoup_MakeRandom(5, 1000, 0.1);
    CheckSoup(&apart, &apart);
    qcSoup_Free(&apart);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_whole_fit_follows_an_outline_of_the_same_positions)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 20, 0.02, 0.03);
    Fits f = MakeFits(&soup, qcTriangleKernels_Get(), 1);
    bool fits;
    FitWhole(&f, 0.0);
    FitOutline(&f, 0.0);
    CHECK_OK(qcTriangleBvh_Fit(&f.outline, BodyOf(&f), 0.0, f.kernels, 1, &f.scratch, &fits));
    CheckUpperLevels(&f);
    for (uint32_t node = 0; node < f.outline.clusters.nodeCount; node++)
        CheckNode(&f, node);
    // An outline of these positions has nothing to add.
    uint64_t fitCount = f.outline.fitCount;
    CHECK_OK(qcTriangleBvh_FitOutline(&f.outline, BodyOf(&f), 0.0, f.kernels, 1, &f.scratch, &fits));
    ck_assert(fits && !f.outline.fit.isOutline && f.outline.fitCount == fitCount);
    FreeFits(&f);
    qcSoup_Free(&soup);
}
END_TEST

static void CheckWhole(const Fits* f, const qcBvhFit* a, const qcBvhFit* b)
{
    ck_assert(!a->isOutline && !b->isOutline);
    ck_assert_mem_eq(a->boxes.data, b->boxes.data, f->whole.totalBox8Count * sizeof(qcBox8));
    ck_assert_mem_eq(a->points.data, b->points.data, f->whole.vertexCount * sizeof(qcPoint));
}

START_TEST(a_fit_to_a_motion_takes_nothing_from_an_outline)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 20, 0.02, 0.03), moved = qcSoup_MakeFoldedCloth(4, 20, 0.02, 0.03);
    // Outlines at the start, at the end, at both and where the body rests.
    for (int outlines = 1; outlines < 8; outlines++)
    {
        Fits f = MakeFits(&soup, qcTriangleKernels_Get(), 1);
        bool fits;
        if ((outlines & 1) != 0)
            FitOutline(&f, 0.0);
        CHECK_OK(qcBodies_MarkStart(&f.bodies));
        if ((outlines & 4) == 0)
            Move(&f, &moved, false);
        if ((outlines & 2) != 0)
            FitOutline(&f, 0.0);
        CHECK_OK(qcTriangleBvh_FitMotion(&f.outline, BodyOf(&f), f.kernels, 1, &f.scratch, &fits));
        ck_assert(fits);
        CHECK_OK(qcTriangleBvh_FitMotion(&f.whole, BodyOf(&f), f.kernels, 1, &f.scratch, &fits));
        CheckWhole(&f, &f.outline.fit, &f.whole.fit);
        CheckWhole(&f, qcTriangleBvh_StartFit(&f.outline, BodyOf(&f)), qcTriangleBvh_StartFit(&f.whole, BodyOf(&f)));
        FreeFits(&f);
    }
    qcSoup_Free(&soup);
    qcSoup_Free(&moved);
}
END_TEST

START_TEST(an_outline_does_not_pay_for_some_fits_if_many_leaf_nodes_are_fitted)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 60, 0.02, 0.03);
    Fits f = MakeFits(&soup, qcTriangleKernels_Get(), 1);
    uint32_t nodeCount = f.outline.clusters.nodeCount, fitsUntil = 0;
    uint8_t* flags = calloc(nodeCount, 1);
    bool fits;
    FitOutline(&f, 0.0);
    flags[0] = flags[nodeCount - 1] = 1;
    CHECK_OK(FitNodes(&f, flags));
    ck_assert_uint_eq(f.outline.wholeFits, 0);
    memset(flags, 1, nodeCount / 2);
    CHECK_OK(FitNodes(&f, flags));
    for (; f.outline.wholeFits != 0; fitsUntil++)
    {
        Move(&f, &soup, false);
        CHECK_OK(qcTriangleBvh_Fit(&f.outline, BodyOf(&f), 0.0, f.kernels, 1, &f.scratch, &fits));
        ck_assert_uint_lt(fitsUntil, 100);
    }
    ck_assert_uint_gt(fitsUntil, 1);
    free(flags);
    FreeFits(&f);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(leaf_nodes_grow_if_layers_part)
{
    // Three layers on top of each other, which share leaf nodes.
    qcSoup tight = qcSoup_MakeFoldedCloth(3, 60, 1e-4, 0.0), parted = qcSoup_MakeFoldedCloth(3, 60, 5.0, 0.0);
    Fits f = MakeFits(&tight, qcTriangleKernels_Get(), 1);
    for (int i = 0; i < 40; i++)
    {
        Move(&f, i < 20 ? &tight : &parted, i % 2 == 0);
        FitOutline(&f, i % 3 == 0 ? 0.01 : 0.0);
        if (i < 20)
            ck_assert(!qcTriangleBvh_HasGrown(&f.outline));
    }
    ck_assert(qcTriangleBvh_HasGrown(&f.outline));
    FreeFits(&f);
    qcSoup_Free(&tight);
    qcSoup_Free(&parted);
}
END_TEST

/// Fits an outline and all leaf nodes; after a failure once more.
static qcStatus FitBoth(Fits* f, const uint8_t* flags)
{
    bool fits;
    qcStatus status = qcTriangleBvh_FitOutline(&f->outline, BodyOf(f), 0.0, f->kernels, f->threads, &f->scratch, &fits);
    if (status == qc_statusOk)
        status = FitNodes(f, flags);
    if (status != qc_statusOk)
    {
        CHECK_OK(qcTriangleBvh_FitOutline(&f->outline, BodyOf(f), 0.0, f->kernels, f->threads, &f->scratch, &fits));
        CHECK_OK(FitNodes(f, flags));
    }
    return status;
}

START_TEST(after_a_failed_allocation_the_same_fit_succeeds)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 12, 0.02, 0.03);
    size_t live = heap.live, calls = 1;
    for (size_t i = 0; i <= calls; i++)
    {
        Fits f = MakeFits(&soup, qcTriangleKernels_Get(), 1);
        uint8_t* flags = malloc(f.outline.clusters.nodeCount);
        memset(flags, 1, f.outline.clusters.nodeCount);
        heap = (qcFailingHeap){heap.live, 0, i};
        ck_assert_int_eq(FitBoth(&f, flags), i == 0 ? qc_statusOk : qc_statusOutOfMemory);
        calls = i == 0 ? heap.calls : calls;
        heap = (qcFailingHeap){heap.live, 0, 0};
        FitWhole(&f, 0.0);
        CheckUpperLevels(&f);
        for (uint32_t node = 0; node < f.outline.clusters.nodeCount; node++)
            CheckNode(&f, node);
        FreeFits(&f);
        free(flags);
    }
    ck_assert_uint_gt(calls, 5);
    ck_assert_uint_eq(heap.live, live);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
    qcSoup_Free(&soup);
}
END_TEST

QC_RUN_TESTS("bvh_outline", an_outline_and_its_leaf_nodes_are_those_of_a_whole_fit,
             a_whole_fit_follows_an_outline_of_the_same_positions, a_fit_to_a_motion_takes_nothing_from_an_outline,
             an_outline_does_not_pay_for_some_fits_if_many_leaf_nodes_are_fitted, leaf_nodes_grow_if_layers_part,
             after_a_failed_allocation_the_same_fit_succeeds)
