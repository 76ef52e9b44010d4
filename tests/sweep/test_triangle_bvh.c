// Boxes on the lattice agree with exact coordinates: two boxes within the margin overlap, on each level, at any scale
// and anywhere; and few others do.
#include "scene/float_positions.h"
#include "support/failing_heap.h"
#include "support/suite.h"
#include "sweep/bvh/body_bvh.h"
#include "sweep/sample_bodies.h"

#include <math.h>

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

//  ---- boxes ---------------------------------------------------------------------------------------

/// Ends as levels. lower > upper: an empty slot.
typedef struct Box
{
    int lower[3], upper[3];
} Box;

static Box BoxAt(const qcTriangleBvh* s, uint32_t level, size_t i)
{
    const qcBox8* box8 = qcTriangleBvh_Box8At(s, &s->fit, level, (uint32_t)(i / qc_boxLanes));
    Box box;
    for (int axis = 0; axis < 3; axis++)
    {
        box.lower[axis] = box8->ends[axis][i % qc_boxLanes];
        box.upper[axis] = ~box8->ends[axis][qc_boxLanes + i % qc_boxLanes];
    }
    return box;
}

static bool IsEmpty(const Box* box)
{
    return box->lower[0] > box->upper[0];
}

static bool Overlap(const Box* a, const Box* b)
{
    for (int axis = 0; axis < 3; axis++)
        if (a->lower[axis] > b->upper[axis] || b->lower[axis] > a->upper[axis])
            return false;
    return true;
}

/// a <= b + margin, without rounding: the sum's error is a double too (Knuth's two-sum).
static bool IsWithin(double a, double b, double margin)
{
    double sum = b + margin, back = sum - b, error = (b - (sum - back)) + (margin - back);
    return a < sum || (a == sum && error >= 0.0);
}

static bool AreWithin(const qcBody* body, uint32_t a, uint32_t b, double margin)
{
    double lowerA[3], upperA[3], lowerB[3], upperB[3];
    qcBody_GetTriangleBox(body, a, lowerA, upperA);
    qcBody_GetTriangleBox(body, b, lowerB, upperB);
    for (int axis = 0; axis < 3; axis++)
        if (!IsWithin(lowerA[axis], upperB[axis], margin) || !IsWithin(lowerB[axis], upperA[axis], margin))
            return false;
    return true;
}

/// Farther apart than the margin, two levels and some roundings of coordinates: such boxes must not overlap.
static bool AreClearlyApart(const qcTriangleBvh* s, const qcBody* body, uint32_t a, uint32_t b, double margin)
{
    double lowerA[3], upperA[3], lowerB[3], upperB[3];
    qcBody_GetTriangleBox(body, a, lowerA, upperA);
    qcBody_GetTriangleBox(body, b, lowerB, upperB);
    for (int axis = 0; axis < 3; axis++)
    {
        double slack =
            1.01 / s->fit.lattice.scale[axis] + 0x1p-50 * (fabs(body->lower[axis]) + fabs(body->upper[axis]) + margin);
        if (lowerA[axis] - upperB[axis] > margin + slack || lowerB[axis] - upperA[axis] > margin + slack)
            return true;
    }
    return false;
}

//  ---- invariants ----------------------------------------------------------------------------------

static uint32_t TriangleAt(const qcTriangleBvh* s, size_t slot)
{
    return QC_AT(uint32_t, s->clusters.triangles, slot);
}

static void CheckCorners(const qcTriangleBvh* s, const qcBody* body)
{
    for (size_t slot = 0; slot < s->corners.count; slot++)
        for (size_t c = 0; c < 3; c++)
        {
            uint32_t vertex = QC_AT(qcCorners, s->corners, slot).vertex[c];
            if (TriangleAt(s, slot) == QC_NO_TRIANGLE)
                CHECK_THAT(vertex == s->vertexCount, "empty slot %zu has vertex %u", slot, vertex);
            else
                CHECK_THAT(vertex < s->vertexCount && QC_AT(uint32_t, s->vertexOf, vertex) ==
                                                          body->indices[3 * (size_t)TriangleAt(s, slot) + c],
                           "slot %zu, corner %zu: vertex %u", slot, c, vertex);
        }
}

static void CheckPoints(const qcTriangleBvh* s, const qcBody* body)
{
    for (uint32_t v = 0; v < s->vertexCount; v++)
        for (size_t axis = 0; axis < 3; axis++)
        {
            // A difference of doubles times a power of two: 64 bits suffice.
            long double x = body->world[3 * (size_t)QC_AT(uint32_t, s->vertexOf, v) + axis];
            long double point = (x - s->fit.lattice.origin[axis]) * s->fit.lattice.unit[axis];
            CHECK_THAT(fabsl(QC_AT(qcPoint, s->fit.points, v).x[axis] - point) <= s->fit.pointError &&
                           fabsl(point) <= 1.0L,
                       "vertex %u is at %Lg, not %g", v, point, (double)QC_AT(qcPoint, s->fit.points, v).x[axis]);
        }
}

/// Each box is the one around its eight children, up to the root.
static void CheckLevels(const qcTriangleBvh* s)
{
    ck_assert_uint_eq(s->box8Count[0], s->clusters.triangles.count / qc_boxLanes);
    ck_assert_uint_eq(s->box8Count[s->levels - 1], 1);
    for (uint32_t level = 1; level <= s->levels; level++)
    {
        size_t below = s->box8Count[level - 1], box8s = level < s->levels ? s->box8Count[level] : 1;
        ck_assert_uint_eq(box8s, (below + qc_boxLanes - 1) / qc_boxLanes);
        for (size_t i = 0; i < box8s * qc_boxLanes; i++)
        {
            Box box = BoxAt(s, level, i),
                expected = {{INT16_MAX, INT16_MAX, INT16_MAX}, {INT16_MIN, INT16_MIN, INT16_MIN}};
            for (size_t k = i * qc_boxLanes; k < (i + 1) * qc_boxLanes && i < below; k++)
            {
                Box child = BoxAt(s, level - 1, k);
                for (int axis = 0; axis < 3; axis++)
                {
                    expected.lower[axis] =
                        child.lower[axis] < expected.lower[axis] ? child.lower[axis] : expected.lower[axis];
                    expected.upper[axis] =
                        child.upper[axis] > expected.upper[axis] ? child.upper[axis] : expected.upper[axis];
                }
            }
            CHECK_THAT(memcmp(&box, &expected, sizeof box) == 0, "level %u, box %zu is not the one around its children",
                       level, i);
        }
    }
}

static void CheckPairs(const qcTriangleBvh* s, const qcBody* body, double margin)
{
    size_t slots = s->clusters.triangles.count;
    for (size_t p = 0; p < slots; p++)
    {
        Box a = BoxAt(s, 0, p);
        uint32_t t = TriangleAt(s, p);
        CHECK_THAT(IsEmpty(&a) == (t == QC_NO_TRIANGLE), "slot %zu", p);
        for (size_t q = p; q < slots && t != QC_NO_TRIANGLE; q++)
        {
            Box b = BoxAt(s, 0, q);
            uint32_t u = TriangleAt(s, q);
            if (u == QC_NO_TRIANGLE)
            {
                CHECK_THAT(!Overlap(&a, &b), "slot %zu overlaps the empty slot %zu", p, q);
                continue;
            }
            if (Overlap(&a, &b))
                CHECK_THAT(!AreClearlyApart(s, body, t, u, margin), "the boxes of %u and %u overlap", t, u);
            else
                CHECK_THAT(!AreWithin(body, t, u, margin), "the boxes of %u and %u don't overlap", t, u);
        }
    }
}

static void CheckBvh(const qcTriangleBvh* s, const qcBody* body, double margin)
{
    CheckCorners(s, body);
    CheckPoints(s, body);
    CheckLevels(s);
    CheckPairs(s, body, margin);
}

static bool AreSame(const qcTriangleBvh* a, const qcTriangleBvh* b)
{
    return a->fit.boxes.count == b->fit.boxes.count && a->fit.points.count == b->fit.points.count &&
           memcmp(a->fit.boxes.data, b->fit.boxes.data, a->fit.boxes.count * sizeof(qcBox8)) == 0 &&
           memcmp(a->fit.points.data, b->fit.points.data, a->fit.points.count * sizeof(qcPoint)) == 0 &&
           memcmp(&a->fit.root, &b->fit.root, sizeof a->fit.root) == 0;
}

/// With all kernels, on one thread and on three: all fits are equal and right.
static void CheckFits(const qcBody* body, double margin)
{
    qcTriangleBvh first = {0};
    FOR_EACH_KERNELS(k)
    for (uint32_t threads = 1; threads <= 3; threads += 2)
    {
        qcTriangleBvh bvh;
        qcBvhScratch scratch = {0};
        bool fits;
        CHECK_OK(qcTriangleBvh_Build(&bvh, body, &(qcOrderOptions){.threads = 1}));
        CHECK_OK(qcTriangleBvh_Fit(&bvh, body, margin, k, threads, &scratch, &fits));
        ck_assert(fits);
        qcBvhScratch_Free(&scratch);
        if (first.levels == 0)
        {
            CheckBvh(&bvh, body, margin);
            first = bvh;
            continue;
        }
        CHECK_THAT(AreSame(&first, &bvh), "%s on %u threads fits differently", k->name, threads);
        qcTriangleBvh_Free(&bvh);
    }
    qcTriangleBvh_Free(&first);
}

static void CheckSoup(qcSoup* soup, double margin)
{
    qcBodies bodies = {0};
    CheckFits(qcBodyAt(&bodies, qcAddToBodies(&bodies, soup)), margin);
    qcBodies_Free(&bodies);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    qcSoup_Free(soup);
}

//  ---- tests ---------------------------------------------------------------------------------------

START_TEST(boxes_within_the_margin_overlap_and_few_others_do)
{
    const double margins[] = {0.0, 0.01, 3.0};
    for (int kind = 0; kind < qc_soupKindCount; kind++)
        for (size_t i = 0; i < LENGTH(margins); i++)
        {
            qcSoup soup = qcMakeSoup((qcSoupKind)kind, (uint64_t)kind);
            CheckSoup(&soup, margins[i]);
        }
}
END_TEST

START_TEST(boxes_within_the_margin_overlap_far_from_the_origin)
{
    // Coordinates have few bits left, down to one value that they all round to.
    const double offsets[] = {1e3, -1e9, 1e12, 1e15, -1e17};
    for (size_t i = 0; i < LENGTH(offsets); i++)
        for (int kind = 0; kind < qc_soupKindCount; kind++)
        {
            qcSoup soup = qcMakeSoup((qcSoupKind)kind, 7);
            qcSoup_Place(&soup, 1.0, offsets[i], -0.7 * offsets[i], 0.0);
            CheckSoup(&soup, i % 2 == 0 ? 0.0 : 0.013);
        }
}
END_TEST

START_TEST(boxes_within_the_margin_overlap_at_any_scale)
{
    const double scales[] = {5e-324, 1e-310, 1e-300, 1e-280, 1e-30, 1e30, 1e280};
    for (size_t i = 0; i < LENGTH(scales); i++)
        for (int kind = 0; kind < qc_soupKindCount; kind++)
        {
            qcSoup soup = qcMakeSoup((qcSoupKind)kind, 8);
            qcSoup_Place(&soup, scales[i], 0.0, 0.0, 0.0);
            CheckSoup(&soup, kind % 2 == 0 ? 0.0 : 0.01 * scales[i]);
        }
}
END_TEST

/// Thin triangles in a row along each axis, each at the margin from the next, give or take some ulps.
static qcSoup MakeRow(qcRandom* random, uint32_t count, double margin, double offset)
{
    qcSoup soup = qcSoup_MakeRandom(1, count, 0.1);
    for (int axis = 0; axis < 3; axis++)
    {
        double at = offset;
        for (uint32_t t = 0; t < count; t++)
        {
            double upper = at + qcRandom_Uniform(random, 0.0, 0.01);
            for (uint32_t c = 0; c < 3; c++)
                soup.positions[9 * (size_t)t + 3 * c + (size_t)axis] = c == 0 ? at : upper;
            at = upper + margin;
            for (uint32_t steps = qcRandom_Below(random, 5); steps > 0; steps--)
                at = nextafter(at, steps % 2 == 0 ? INFINITY : -INFINITY);
            if (qcRandom_Below(random, 4) == 0)
                at = nextafter(at, INFINITY);
        }
    }
    return soup;
}

START_TEST(boxes_exactly_at_the_margin_overlap)
{
    qcRandom random = {9};
    const double margins[] = {0.0, 0.001, 0.1, 1e-9}, offsets[] = {0.0, -0.3, 1e6, 1e13};
    for (int round = 0; round < 40; round++)
    {
        qcSoup soup = MakeRow(&random, 150, margins[round % 4], offsets[round / 4 % 4]);
        CheckSoup(&soup, margins[round % 4]);
    }
}
END_TEST

START_TEST(bodies_of_any_number_of_triangles_have_all_levels)
{
    for (uint32_t n = 1; n <= 700; n += n < 130 ? 1 : 63)
    {
        qcSoup soup = qcSoup_MakeRandom(n, n, 0.1);
        CheckSoup(&soup, 0.0);
    }
}
END_TEST

START_TEST(large_bodies_are_fitted_on_any_number_of_threads)
{
    // Several blocks of vertices and of clusters, the last not full; five levels.
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 145, 0.02, 0.03);
    qcBodies bodies = {0};
    const qcBody* body = qcBodyAt(&bodies, qcAddToBodies(&bodies, &soup));
    qcTriangleBvh first = {0};
    FOR_EACH_KERNELS(k)
    for (uint32_t threads = 1; threads <= 4; threads++)
    {
        qcTriangleBvh bvh;
        qcBvhScratch scratch = {0};
        bool fits;
        CHECK_OK(qcTriangleBvh_Build(&bvh, body, &(qcOrderOptions){.threads = 1}));
        CHECK_OK(qcTriangleBvh_Fit(&bvh, body, 0.001, k, threads, &scratch, &fits));
        qcBvhScratch_Free(&scratch);
        CheckCorners(&bvh, body);
        CheckPoints(&bvh, body);
        CheckLevels(&bvh);
        if (first.levels != 0)
        {
            ck_assert(AreSame(&first, &bvh));
            qcTriangleBvh_Free(&first);
        }
        first = bvh;
    }
    ck_assert_uint_ge(first.levels, 5);
    qcTriangleBvh_Free(&first);
    qcBodies_Free(&bodies);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(vertices_without_a_triangle_are_left_out)
{
    qcSoup soup = qcSoup_MakeRandom(4, 100, 0.1);
    soup.triangleCount = 80;
    for (uint32_t v = 240; v < soup.vertexCount; v++)
        soup.positions[3 * v] = 1e300;
    qcBodies bodies = {0};
    const qcBody* body = qcBodyAt(&bodies, qcAddToBodies(&bodies, &soup));
    qcTriangleBvh bvh;
    CHECK_OK(qcTriangleBvh_Build(&bvh, body, &(qcOrderOptions){.threads = 1}));
    ck_assert_uint_eq(bvh.vertexCount, 240);
    qcTriangleBvh_Free(&bvh);
    CheckFits(body, 0.0);
    qcBodies_Free(&bodies);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(a_fit_follows_the_body_and_the_margin)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 12, 0.02, 0.03);
    qcBodies bodies = {0};
    uint32_t slot = qcAddToBodies(&bodies, &soup);
    qcTriangleBvh bvh;
    qcBvhScratch scratch = {0};
    bool fits;
    CHECK_OK(qcTriangleBvh_Build(&bvh, qcBodyAt(&bodies, slot), &(qcOrderOptions){.threads = 1}));
    for (int step = 0; step < 6; step++)
    {
        double margin = step == 3 ? 0.05 : step == 4 ? 0.01 : 0.0;
        if (step % 2 == 0)
        {
            qcSoup next = qcSoup_MakeFoldedCloth(10 + (uint64_t)step, 12, 0.02, 0.05);
            qcSoup_Translate(&next, step, 0.0, 0.0);
            CHECK_OK(qcBodies_SetVertices(&bodies, slot, next.positions, qc_positionF64, 0));
            qcSoup_Free(&next);
        }
        CHECK_OK(qcTriangleBvh_Fit(&bvh, qcBodyAt(&bodies, slot), margin, qcTriangleKernels_Get(), 1, &scratch, &fits));
        ck_assert(fits);
        CheckBvh(&bvh, qcBodyAt(&bodies, slot), margin);
    }
    // A body that has not moved is not read.
    qcBodyAt(&bodies, slot)->world[0] += 1.0;
    qcTriangleBvh before = bvh;
    float x = QC_AT(qcPoint, bvh.fit.points, 0).x[0];
    CHECK_OK(qcTriangleBvh_Fit(&bvh, qcBodyAt(&bodies, slot), 0.0, qcTriangleKernels_Get(), 1, &scratch, &fits));
    ck_assert(fits && QC_AT(qcPoint, bvh.fit.points, 0).x[0] == x &&
              before.fit.root.ends[0][0] == bvh.fit.root.ends[0][0]);
    qcBvhScratch_Free(&scratch);
    qcTriangleBvh_Free(&bvh);
    qcBodies_Free(&bodies);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// Fits often enough that one fit is measured.
static bool HasGrown(qcTriangleBvh* bvh, qcBodies* bodies, uint32_t slot, const qcSoup* soup)
{
    qcBvhScratch scratch = {0};
    bool fits;
    for (int i = 0; i < 20; i++)
    {
        CHECK_OK(qcBodies_SetVertices(bodies, slot, soup->positions, qc_positionF64, 0));
        CHECK_OK(qcTriangleBvh_Fit(bvh, qcBodyAt(bodies, slot), i % 2 == 0 ? 0.01 : 0.0, qcTriangleKernels_Get(), 1,
                                   &scratch, &fits));
    }
    qcBvhScratch_Free(&scratch);
    return qcTriangleBvh_HasGrown(bvh);
}

START_TEST(clusters_grow_if_layers_part_and_not_if_a_body_turns_or_crumples)
{
    // Three layers on top of each other, which share clusters.
    qcSoup tight = qcSoup_MakeFoldedCloth(3, 60, 1e-4, 0.0), crumpled = qcSoup_MakeFoldedCloth(4, 60, 1e-4, 0.03),
           parted = qcSoup_MakeFoldedCloth(3, 60, 0.3, 0.0), turned = qcSoup_MakeFoldedCloth(3, 60, 1e-4, 0.0);
    for (size_t i = 0; i < 3 * (size_t)turned.vertexCount; i += 3)
    {
        double *p = turned.positions + i, x = p[0], z = p[2];
        p[0] = 0.6 * x - 0.8 * z;
        p[2] = 0.8 * x + 0.6 * z;
    }
    qcBodies bodies = {0};
    uint32_t slot = qcAddToBodies(&bodies, &tight);
    qcTriangleBvh bvh;
    CHECK_OK(qcTriangleBvh_Build(&bvh, qcBodyAt(&bodies, slot), &(qcOrderOptions){.threads = 1}));
    ck_assert(!HasGrown(&bvh, &bodies, slot, &tight));
    ck_assert(!HasGrown(&bvh, &bodies, slot, &turned));
    ck_assert(!HasGrown(&bvh, &bodies, slot, &crumpled));
    ck_assert(HasGrown(&bvh, &bodies, slot, &parted));
    // Built anew, it has not grown.
    qcTriangleBvh_Free(&bvh);
    CHECK_OK(qcTriangleBvh_Build(&bvh, qcBodyAt(&bodies, slot), &(qcOrderOptions){.threads = 1}));
    ck_assert(!HasGrown(&bvh, &bodies, slot, &parted));
    qcTriangleBvh_Free(&bvh);
    qcBodies_Free(&bodies);
    qcSoup* soups[] = {&tight, &crumpled, &parted, &turned};
    for (size_t i = 0; i < 4; i++)
        qcSoup_Free(soups[i]);
}
END_TEST

START_TEST(a_body_too_large_for_a_lattice_does_not_fit_and_may_fit_later)
{
    const double scales[] = {1e300, 1.0}, margins[] = {0.0, 1e300};
    qcSoup soup = qcSoup_MakeRandom(4, 100, 0.1);
    qcBodies bodies = {0};
    uint32_t slot = qcAddToBodies(&bodies, &soup);
    qcTriangleBvh bvh;
    qcBvhScratch scratch = {0};
    CHECK_OK(qcTriangleBvh_Build(&bvh, qcBodyAt(&bodies, slot), &(qcOrderOptions){.threads = 1}));
    for (int i = 0; i < 4; i++)
    {
        qcSoup next = qcSoup_MakeRandom(4, 100, 0.1);
        qcSoup_Place(&next, scales[i % 2], 0.0, 0.0, 0.0);
        CHECK_OK(qcBodies_SetVertices(&bodies, slot, next.positions, qc_positionF64, 0));
        bool fits, expected = scales[i % 2] == 1.0 && margins[i / 2] == 0.0;
        CHECK_OK(qcTriangleBvh_Fit(&bvh, qcBodyAt(&bodies, slot), margins[i / 2], qcTriangleKernels_Get(), 1, &scratch,
                                   &fits));
        ck_assert_int_eq(fits, expected);
        ck_assert_int_eq(bvh.fit.fitted, expected);
        if (fits)
            CheckBvh(&bvh, qcBodyAt(&bodies, slot), 0.0);
        qcSoup_Free(&next);
    }
    qcBvhScratch_Free(&scratch);
    qcTriangleBvh_Free(&bvh);
    qcBodies_Free(&bodies);
    qcSoup_Free(&soup);
}
END_TEST

//  ---- out of memory -------------------------------------------------------------------------------

static qcStatus BuildAndFit(const qcBody* body, qcBodyBvh* bvh, qcBvhScratch* scratch)
{
    bool fits;
    qcStatus status = qcBodyBvh_Build(bvh, body, NULL, 1);
    if (status != qc_statusOk)
        ck_assert_uint_eq(bvh->bvh.generation, 0);
    else
        status = qcTriangleBvh_Fit(&bvh->bvh, body, 0.0, qcTriangleKernels_Get(), 1, scratch, &fits);
    if (status != qc_statusOk && bvh->bvh.generation != 0)
    {
        // The BVH is whole: the same call, with memory, succeeds.
        ck_assert(!bvh->bvh.fit.fitted);
        CHECK_OK(qcTriangleBvh_Fit(&bvh->bvh, body, 0.0, qcTriangleKernels_Get(), 1, scratch, &fits));
        CheckBvh(&bvh->bvh, body, 0.0);
    }
    qcBodyBvh_Free(bvh);
    qcBvhScratch_Free(scratch);
    return status;
}

START_TEST(a_failed_allocation_leaves_nothing)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcSoup soup = qcSoup_MakeFoldedCloth(3, 12, 0.02, 0.03);
    qcBodies bodies = {0};
    const qcBody* body = qcBodyAt(&bodies, qcAddToBodies(&bodies, &soup));
    size_t live = heap.live;
    heap.calls = 0;
    qcBodyBvh bvh;
    qcBvhScratch scratch = {0};
    CHECK_OK(BuildAndFit(body, &bvh, &scratch));
    size_t calls = heap.calls;
    ck_assert_uint_gt(calls, 10);
    for (size_t i = 1; i <= calls; i++)
    {
        heap = (qcFailingHeap){live, 0, i};
        memset(&bvh, 0xff, sizeof bvh);
        ck_assert_int_eq(BuildAndFit(body, &bvh, &scratch), qc_statusOutOfMemory);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "out of memory"));
        ck_assert_uint_eq(heap.live, live);
    }
    qcBodies_Free(&bodies);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
    qcSoup_Free(&soup);
}
END_TEST

QC_RUN_TESTS("triangle_bvh", boxes_within_the_margin_overlap_and_few_others_do,
             boxes_within_the_margin_overlap_far_from_the_origin, boxes_within_the_margin_overlap_at_any_scale,
             boxes_exactly_at_the_margin_overlap, bodies_of_any_number_of_triangles_have_all_levels,
             large_bodies_are_fitted_on_any_number_of_threads, vertices_without_a_triangle_are_left_out,
             a_fit_follows_the_body_and_the_margin, clusters_grow_if_layers_part_and_not_if_a_body_turns_or_crumples,
             a_body_too_large_for_a_lattice_does_not_fit_and_may_fit_later, a_failed_allocation_leaves_nothing)
