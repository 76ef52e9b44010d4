// Queries, flags and sure results, found by the processor or by the device, give the same visibility, step for step:
// random passes over soups, cloths and degenerate triangles; and the same PCS, primitive for primitive, in whole
// scenes.
#define _POSIX_C_SOURCE 200809L
#include "gl/device.h"
#include "gl/visibility/occlusion_queries.h"
#include "gl/visibility/sure_kernels.h"
#include "gl/visibility/sure_results.h"
#include "gl/visibility/tile_schedule.h"
#include "support/devices.h"
#include "support/long_form.h"
#include "support/scenes.h"
#include "support/soups.h"
#include "support/suite.h"

#include <stdlib.h>
#include <string.h>

enum
{
    qc_wayCount = 4
};

static const char* const s_ways[qc_wayCount] = {"queries", "flags", "sure", "computed"};

//  ---- passes --------------------------------------------------------------------------------------

/// The triangles of a soup in the image, nine floats each.
static float* MakeCorners(const qcSoup* soup)
{
    double lower[3] = {1e30, 1e30, 1e30}, upper[3] = {-1e30, -1e30, -1e30};
    for (uint32_t i = 0; i < 3 * soup->vertexCount; i++)
    {
        double at = soup->positions[i];
        lower[i % 3] = at < lower[i % 3] ? at : lower[i % 3];
        upper[i % 3] = at > upper[i % 3] ? at : upper[i % 3];
    }
    float* corners = malloc((size_t)soup->triangleCount * 9 * sizeof *corners);
    for (uint32_t i = 0; i < 3 * soup->triangleCount; i++)
        for (int axis = 0; axis < 3; axis++)
        {
            double extent = upper[axis] > lower[axis] ? upper[axis] - lower[axis] : 1.0;
            corners[3 * i + (uint32_t)axis] =
                (float)((soup->positions[3 * soup->indices[i] + (uint32_t)axis] - lower[axis]) / extent * 2.0 - 1.0);
        }
    return corners;
}

/// Steps as of a pass: each triangle once, or in runs; then some triangles again.
static uint32_t MakeSteps(qcRandom* random, uint32_t triangleCount, qcVisibilityStep* steps)
{
    uint32_t count = 0, longest = qcRandom_Below(random, 3) == 0 ? 5 : 1;
    for (uint32_t t = 0, length; t < triangleCount; t += length)
    {
        length = 1 + qcRandom_Below(random, longest);
        length = length < triangleCount - t ? length : triangleCount - t;
        steps[count++] = (qcVisibilityStep){t, length, qcRandom_Below(random, 8) != 0, qcRandom_Below(random, 8) != 0};
    }
    for (uint32_t i = count - 1; i > 0 && qcRandom_Below(random, 2) == 0; i--)
    {
        uint32_t other = qcRandom_Below(random, i + 1);
        qcVisibilityStep step = steps[i];
        steps[i] = steps[other];
        steps[other] = step;
    }
    for (uint32_t i = 0; i < 20; i++)
        steps[count++] = (qcVisibilityStep){qcRandom_Below(random, triangleCount), 1, true, i % 2 == 0};
    return count;
}

static void RunWay(int way, const qcVisibilityDef* def, const qcVisibilityPass* pass, const qcVisibilityStep* steps,
                   uint32_t stepCount, uint8_t* visible)
{
    setenv("QC_VISIBILITY", s_ways[way], 1);
    qcVisibility* visibility = NULL;
    ck_assert_msg(qcVisibility_Prepare(def, &visibility) == qc_statusOk, "%s", qcLastMessage());
    qcStatus status = qcVisibility_RunPass(visibility, pass, steps, stepCount, visible);
    ck_assert_msg(status == qc_statusOk, "%s", qcLastMessage());
    qcVisibility_Destroy(visibility);
    unsetenv("QC_VISIBILITY");
}

/// Random passes over a soup: all ways agree.
static void ComparePasses(qcDevice* device, const qcSoup* soup, uint64_t seed, int passCount)
{
    qcRandom random = {seed};
    float* corners = MakeCorners(soup);
    qcVisibilityStep* steps = malloc((soup->triangleCount + 20) * sizeof *steps);
    uint8_t* visible[qc_wayCount];
    for (int way = 0; way < qc_wayCount; way++)
        visible[way] = malloc(soup->triangleCount + 20);
    static const uint32_t resolutions[6] = {7, 33, 64, 200, 512, 1500};
    for (int i = 0; i < passCount; i++)
    {
        uint32_t stepCount = MakeSteps(&random, soup->triangleCount, steps);
        qcVisibilityDef def = {.device = device,
                               .corners = corners,
                               .triangleCount = soup->triangleCount,
                               .resolution = resolutions[qcRandom_Below(&random, 6)],
                               .dilated = i % 2 == 1,
                               .dilation = {0.001, 0.002, 0.003}};
        qcVisibilityPass pass = {(int)qcRandom_Below(&random, 3),
                                 qcRandom_Below(&random, 2) == 0 ? qc_compareGreater : qc_compareGreaterEqual,
                                 qcRandom_Below(&random, 2) == 0};
        for (int way = 0; way < qc_wayCount; way++)
            RunWay(way, &def, &pass, steps, stepCount, visible[way]);
        for (int way = 1; way < qc_wayCount; way++)
            for (uint32_t s = 0; s < stepCount; s++)
                ck_assert_msg(visible[way][s] == visible[0][s],
                              "seed %d, pass %d, %s, resolution %u, axis %d, step %u: %d instead of %d", (int)seed, i,
                              s_ways[way], def.resolution, pass.axis, s, visible[way][s], visible[0][s]);
    }
    for (int way = 0; way < qc_wayCount; way++)
        free(visible[way]);
    free(steps);
    free(corners);
}

/// Soups of one kind each: general position, degenerate, a regular grid with shared corners, folded cloths, a sphere.
static qcSoup MakeSoup(uint64_t seed)
{
    switch (seed % 6)
    {
        case 0: return qcSoup_MakeRandom(seed, 300, 0.2);
        case 1: return qcSoup_MakeDegenerate(seed, 300, 0.3, 0.3);
        case 2: return qcSoup_MakeGrid(12);
        case 3: return qcSoup_MakeFoldedCloth(seed, 16, 0.02, 0.02);
        case 4: return qcSoup_MakeFoldedCloth(seed, 16, 0.02, 0.005);
        default: return qcSoup_MakeSphere(2, 0.5);
    }
}

START_TEST(random_passes_have_the_same_results_each_way)
{
    const char* seeds = getenv("QC_TEST_SEEDS");
    uint64_t seedCount = seeds != NULL ? (uint64_t)atoi(seeds) : 12;
    QC_FOR_EACH_DEVICE(device)
    {
        for (uint64_t seed = 0; seed < seedCount; seed++)
        {
            qcSoup soup = MakeSoup(seed);
            ComparePasses(device, &soup, seed, 4);
            qcSoup_Free(&soup);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(slivers_have_the_same_results_each_way)
{
    // The first seed in which a sliver, unless it is clamped, is drawn as far as the cleared depth, which hides it.
    const uint64_t seed = 115;
    qcSoup soup = MakeSoup(seed);
    QC_FOR_EACH_DEVICE(device)
    {
        ComparePasses(device, &soup, seed, 4);
    }
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_batch_of_thousands_of_tests_flags_the_right_ones)
{
    // The far sheet is rendered first, so one batch tests all of the near one, some of whose triangles lie behind.
    qcSoup sheets = qcSoup_MakeSheets(2, 60, 0.5);
    float* corners = MakeCorners(&sheets);
    uint32_t layer = sheets.triangleCount / 2;
    qcVisibilityStep* steps = malloc(sheets.triangleCount * sizeof *steps);
    uint8_t* visible = malloc(sheets.triangleCount);
    for (uint32_t i = 0; i < sheets.triangleCount; i++)
    {
        steps[i] = (qcVisibilityStep){i, 1, true, i < layer};
        for (uint32_t corner = 0; corner < 3; corner++)
            corners[9 * i + 3 * corner + 2] = i < layer ? 0.5f : (i - layer) % 97 == 0 ? 1.0f : -0.5f;
    }
    QC_FOR_EACH_DEVICE(device)
    {
        qcVisibilityDef def = {
            .device = device, .corners = corners, .triangleCount = sheets.triangleCount, .resolution = 600};
        const qcVisibilityPass pass = {2, qc_compareGreaterEqual, false};
        for (int way = 0; way < qc_wayCount; way++)
        {
            RunWay(way, &def, &pass, steps, sheets.triangleCount, visible);
            for (uint32_t i = 0; i < layer; i++)
                ck_assert_msg(visible[layer + i] == (i % 97 == 0 ? 0 : 1), "%s, triangle %u: %d", s_ways[way], i,
                              visible[layer + i]);
        }
    }
    free(steps);
    free(visible);
    free(corners);
    qcSoup_Free(&sheets);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(triangles_of_any_size_have_the_same_results_each_way)
{
    // Cells are as small as most triangles. The large ones are in so many that the device has no room for them.
    enum
    {
        large = 100,
        count = 2000
    };
    qcRandom random = {1};
    float* corners = malloc(count * 9 * sizeof *corners);
    qcVisibilityStep steps[count];
    for (uint32_t i = 0; i < count; i++)
    {
        double size = i % (count / large) == 0 ? 1.9 : 0.02;
        double lower[3];
        for (int axis = 0; axis < 3; axis++)
            lower[axis] = qcRandom_Uniform(&random, -1.0, 1.0 - size);
        for (int k = 0; k < 9; k++)
            corners[9 * i + (uint32_t)k] = (float)(lower[k % 3] + qcRandom_Uniform(&random, 0.0, size));
        steps[i] = (qcVisibilityStep){i, 1, true, i % 3 != 0};
    }
    QC_FOR_EACH_DEVICE(device)
    {
        qcVisibilityDef def = {.device = device, .corners = corners, .triangleCount = count, .resolution = 300};
        const qcVisibilityPass pass = {0, qc_compareGreaterEqual, false};
        uint8_t visible[qc_wayCount][count];
        for (int way = 0; way < qc_wayCount; way++)
        {
            RunWay(way, &def, &pass, steps, count, visible[way]);
            ck_assert_msg(memcmp(visible[way], visible[0], count) == 0, "%s", s_ways[way]);
        }
    }
    free(corners);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(what_is_prepared_serves_other_triangles)
{
    static const uint32_t sizes[3] = {16, 5, 24}, resolutions[3] = {200, 200, 90};
    QC_FOR_EACH_DEVICE(device)
    {
        for (int way = 0; way < qc_wayCount; way++)
        {
            qcVisibility* kept = NULL;
            for (int i = 0; i < 6; i++)
            {
                qcSoup cloth = qcSoup_MakeFoldedCloth((uint64_t)i, sizes[i % 3], 0.02, 0.02);
                float* corners = MakeCorners(&cloth);
                qcVisibilityStep* steps = malloc(cloth.triangleCount * sizeof *steps);
                uint8_t *expected = malloc(cloth.triangleCount), *visible = malloc(cloth.triangleCount);
                for (uint32_t t = 0; t < cloth.triangleCount; t++)
                    steps[t] = (qcVisibilityStep){t, 1, true, true};
                qcVisibilityDef def = {.device = device,
                                       .corners = corners,
                                       .triangleCount = cloth.triangleCount,
                                       .resolution = resolutions[i % 3],
                                       .dilated = i == 4,
                                       .dilation = {0.001, 0.001, 0.001}};
                const qcVisibilityPass pass = {i % 2, qc_compareGreater, i == 1};
                RunWay(0, &def, &pass, steps, cloth.triangleCount, expected);
                setenv("QC_VISIBILITY", s_ways[way], 1);
                CHECK_OK(qcVisibility_Prepare(&def, &kept));
                unsetenv("QC_VISIBILITY");
                CHECK_OK(qcVisibility_RunPass(kept, &pass, steps, cloth.triangleCount, visible));
                ck_assert_msg(memcmp(visible, expected, cloth.triangleCount) == 0, "%s, cloth %d", s_ways[way], i);
                // A context that is opened anew has none of the old one's objects.
                if (i == 2)
                    CHECK_OK(qcDevice_Reopen(device));
                free(visible);
                free(expected);
                free(steps);
                free(corners);
                qcSoup_Free(&cloth);
            }
            qcVisibility_Destroy(kept);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(images_of_other_sizes_on_a_device_make_no_difference)
{
    static const uint32_t resolutions[2] = {64, 200};
    qcSoup soup = qcSoup_MakeRandom(1, 40, 0.2);
    float* corners = MakeCorners(&soup);
    qcVisibilityStep* steps = malloc(soup.triangleCount * sizeof *steps);
    uint8_t *expected = malloc(soup.triangleCount), *visible = malloc(soup.triangleCount);
    for (uint32_t t = 0; t < soup.triangleCount; t++)
        steps[t] = (qcVisibilityStep){t, 1, true, true};
    QC_FOR_EACH_DEVICE(device)
    {
        for (int way = 0; way < 2 * qc_wayCount; way++)
        {
            qcVisibility* kept[2] = {NULL, NULL};
            for (int i = 0; i < 6; i++)
            {
                qcVisibilityDef def = {.device = device,
                                       .corners = corners,
                                       .triangleCount = soup.triangleCount,
                                       .resolution = resolutions[i % 2],
                                       .dilated = way % 2 == 1,
                                       .dilation = {0.001, 0.001, 0.001}};
                const qcVisibilityPass pass = {2, qc_compareGreater, false};
                RunWay(0, &def, &pass, steps, soup.triangleCount, expected);
                ck_assert_ptr_nonnull(memchr(expected, 1, soup.triangleCount));
                setenv("QC_VISIBILITY", s_ways[way / 2], 1);
                CHECK_OK(qcVisibility_Prepare(&def, &kept[i % 2]));
                unsetenv("QC_VISIBILITY");
                CHECK_OK(qcVisibility_RunPass(kept[i % 2], &pass, steps, soup.triangleCount, visible));
                ck_assert_msg(memcmp(visible, expected, soup.triangleCount) == 0, "%s, image %d", s_ways[way / 2], i);
            }
            qcVisibility_Destroy(kept[0]);
            qcVisibility_Destroy(kept[1]);
        }
    }
    free(visible);
    free(expected);
    free(steps);
    free(corners);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(equal_depths_of_dilated_triangles_hide_as_the_comparison_says)
{
    // Dilated by 1/4 and 2^-20, the first one's nearest depth is the second one's farthest.
    const float near = 0.0f, far = 0.5f + 0x1p-19f;
    const float corners[18] = {-0.5f, -0.5f, far,  0.5f, -0.5f, far,  0.0f, 0.5f, far,
                               -0.5f, -0.5f, near, 0.5f, -0.5f, near, 0.0f, 0.5f, near};
    const qcVisibilityStep steps[2] = {{0, 1, false, true}, {1, 1, true, false}};
    QC_FOR_EACH_DEVICE(device)
    {
        qcVisibilityDef def = {.device = device,
                               .corners = corners,
                               .triangleCount = 2,
                               .resolution = 64,
                               .dilated = true,
                               .dilation = {0.0, 0.0, 0.25}};
        for (int way = 0; way < qc_wayCount; way++)
            for (int compare = qc_compareGreaterEqual; compare <= qc_compareGreater; compare++)
            {
                const qcVisibilityPass pass = {2, (qcVisibilityCompare)compare, false};
                uint8_t visible[2];
                RunWay(way, &def, &pass, steps, 2, visible);
                ck_assert_msg(visible[1] == (compare == qc_compareGreater), "%s, comparison %d", s_ways[way], compare);
            }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(most_results_of_a_cloth_are_sure)
{
    qcSoup cloth = qcSoup_MakeFoldedCloth(3, 40, 0.02, 0.005);
    float* corners = MakeCorners(&cloth);
    qcVisibilityStep* steps = malloc(cloth.triangleCount * sizeof *steps);
    uint8_t* visible = malloc(cloth.triangleCount);
    for (uint32_t i = 0; i < cloth.triangleCount; i++)
        steps[i] = (qcVisibilityStep){i, 1, true, true};
    const qcSureView view = {corners, 4096, 2, false};
    qcSureResults results = {0};
    ck_assert_int_eq(qcSureResults_Find(&results, &view, steps, cloth.triangleCount, visible), qc_statusOk);
    uint32_t open = 0, rendered = 0;
    for (size_t i = 0; i < results.steps.count; i++)
    {
        open += ((const qcVisibilityStep*)results.steps.data)[i].test;
        rendered += ((const qcVisibilityStep*)results.steps.data)[i].render;
    }
    ck_assert_uint_gt(open, 0);
    ck_assert_uint_lt(open, cloth.triangleCount / 5);
    ck_assert_uint_lt(rendered, cloth.triangleCount / 3);
    qcSureResults_Free(&results);
    free(steps);
    free(visible);
    free(corners);
    qcSoup_Free(&cloth);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

typedef struct Finding
{
    const qcSureView* view;
    const qcVisibilityStep* steps;
    uint32_t count;
    uint32_t* found;
} Finding;

/// A job of the device: its sure results, one triangle a step.
static qcStatus FindOnDevice(const struct qcGlFunctions* gl, void* context)
{
    Finding* f = context;
    qcSureKernels kernels = {0};
    const uint32_t* found = NULL;
    GLuint corners = 0;
    gl->GenBuffers(1, &corners);
    gl->BindBuffer(GL_SHADER_STORAGE_BUFFER, corners);
    gl->BufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)(f->count * 9 * sizeof(float)), f->view->corners,
                   GL_STATIC_DRAW);
    qcStatus status = qcSureKernels_Create(gl, &kernels);
    if (status == qc_statusOk)
        status = qcSureKernels_Find(gl, &kernels, f->view, corners, f->steps, f->count, &found);
    if (found != NULL)
        memcpy(f->found, found, f->count * sizeof *found);
    qcSureKernels_Delete(gl, &kernels);
    qcSureKernels_Free(&kernels);
    gl->DeleteBuffers(1, &corners);
    return status;
}

START_TEST(the_device_finds_what_the_processor_finds)
{
    qcSoup cloth = qcSoup_MakeFoldedCloth(3, 40, 0.02, 0.005);
    float* corners = MakeCorners(&cloth);
    uint32_t count = cloth.triangleCount, different = 0;
    qcVisibilityStep* steps = malloc(count * sizeof *steps);
    uint8_t* visible = malloc(count);
    uint32_t* found = malloc(count * sizeof *found);
    for (uint32_t i = 0; i < count; i++)
        steps[i] = (qcVisibilityStep){i, 1, i % 5 != 0, i % 7 != 0 || i % 5 == 0};
    const qcSureView view = {corners, 4096, 2, true};
    qcSureResults results = {0};
    CHECK_OK(qcSureResults_Find(&results, &view, steps, count, visible));
    Finding finding = {&view, steps, count, found};
    QC_FOR_EACH_DEVICE(device)
    {
        memset(found, 0xff, count * sizeof *found);
        CHECK_OK(qcDevice_Run(device, FindOnDevice, &finding, "a test"));
        for (uint32_t i = 0; i < count; i++)
            different += found[i] != ((const uint32_t*)results.found.data)[i];
    }
    // Rounding may decide whether one is sure.
    ck_assert_uint_le(different, count / 1000);
    qcSureResults_Free(&results);
    free(found);
    free(steps);
    free(visible);
    free(corners);
    qcSoup_Free(&cloth);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(counted_tests_of_a_cloth_need_one_batch)
{
    qcSoup cloth = qcSoup_MakeFoldedCloth(3, 40, 0.02, 0.005);
    float* corners = MakeCorners(&cloth);
    qcVisibilityStep* steps = malloc(cloth.triangleCount * sizeof *steps);
    qcScheduleView view = {
        .corners = corners, .resolution = 1024, .tileSize = 1024, .axis = 2, .polygonCorners = 3, .counts = true};
    qcTileSchedule schedule = {0};
    for (uint32_t i = 0; i < cloth.triangleCount; i++)
        steps[i] = (qcVisibilityStep){i, 1, true, true};
    ck_assert_int_eq(qcTileSchedule_Build(&schedule, &view, steps, cloth.triangleCount), qc_statusOk);
    ck_assert_uint_eq(schedule.batches.count, 1);
    ck_assert_uint_eq(((const qcScheduleTile*)schedule.tiles.data)->countedCount, cloth.triangleCount);
    for (uint32_t i = 0; i < cloth.triangleCount; i++)
        ck_assert_uint_eq(((const qcSchedulePolygon*)schedule.polygons.data)[i].step, i);
    // Without counting each triangle waits for the renders of its neighbours.
    view.counts = false;
    ck_assert_int_eq(qcTileSchedule_Build(&schedule, &view, steps, cloth.triangleCount), qc_statusOk);
    ck_assert_uint_gt(schedule.batches.count, 100);
    qcTileSchedule_Free(&schedule);
    free(steps);
    free(corners);
    qcSoup_Free(&cloth);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- scenes --------------------------------------------------------------------------------------

/// A cloth, a soup and a few spheres, near each other.
static void AddBodies(qcScene* scene, uint64_t seed)
{
    qcRandom random = {seed};
    qcSoup soup = qcSoup_MakeRandom(seed, 120, 0.15), cloth = qcSoup_MakeFoldedCloth(seed, 20, 0.02, 0.02);
    qcSoup_Translate(&cloth, 0.0, 0.0, 0.5);
    qcAddSoup(scene, &soup);
    qcAddSoup(scene, &cloth);
    qcSoup_Free(&soup);
    qcSoup_Free(&cloth);
    for (int body = 0; body < 12; body++)
    {
        qcSoup sphere = qcSoup_MakeSphere(1, 0.12);
        qcSoup_Translate(&sphere, qcRandom_Uniform(&random, 0, 0.9), qcRandom_Uniform(&random, 0, 0.9),
                         qcRandom_Uniform(&random, 0, 0.9));
        qcAddSoup(scene, &sphere);
        qcSoup_Free(&sphere);
    }
}

typedef struct Answer
{
    qcTriangleRef* pcs;
    qcPassRecord* passes;
    size_t pcsCount, passCount, pairCount;
} Answer;

static Answer Detect(qcScene* scene, const qcDetectDef* def, int way)
{
    setenv("QC_VISIBILITY", s_ways[way], 1);
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, def, &result));
    ck_assert(!result->profile.reused);
    unsetenv("QC_VISIBILITY");
    Answer answer = {.pcsCount = result->pcsCount,
                     .passCount = result->profile.passCount,
                     .pairCount = result->pairCount,
                     .pcs = calloc(result->pcsCount + 1, sizeof(qcTriangleRef)),
                     .passes = calloc(result->profile.passCount + 1, sizeof(qcPassRecord))};
    if (answer.pcsCount != 0)
        memcpy(answer.pcs, result->pcs, answer.pcsCount * sizeof(qcTriangleRef));
    if (answer.passCount != 0)
        memcpy(answer.passes, result->profile.passes, answer.passCount * sizeof(qcPassRecord));
    return answer;
}

static void CheckSameAnswer(const Answer* a, const Answer* b, const char* what)
{
    ck_assert_msg(a->pcsCount == b->pcsCount, "%s: a PCS of %zu instead of %zu", what, b->pcsCount, a->pcsCount);
    for (size_t i = 0; i < a->pcsCount; i++)
        ck_assert_msg(a->pcs[i].body == b->pcs[i].body && a->pcs[i].triangle == b->pcs[i].triangle, "%s: PCS", what);
    ck_assert_uint_eq(a->pairCount, b->pairCount);
    ck_assert_uint_eq(a->passCount, b->passCount);
    for (size_t i = 0; i < a->passCount; i++)
    {
        const qcPassRecord *p = &a->passes[i], *q = &b->passes[i];
        ck_assert_uint_eq(p->queries, q->queries);
        ck_assert_uint_eq(p->rendered, q->rendered);
        ck_assert_uint_eq(p->bfv, q->bfv);
        ck_assert_uint_eq(p->ffv, q->ffv);
        ck_assert_uint_eq(p->sfv, q->sfv);
        ck_assert_uint_eq(p->nfv, q->nfv);
    }
}

START_TEST(scenes_have_the_same_pcs_each_way)
{
    static const char* const views[] = {"z", "xz", "xyz"};
    const uint32_t resolutions[] = {64, 200, qcIsLongForm() ? 2048 : 400};
    QC_FOR_EACH_DEVICE(device)
    {
        for (uint64_t seed = 1; seed <= 3; seed++)
        {
            // One scene would return its last result again.
            qcScene* scenes[qc_wayCount];
            for (int way = 0; way < qc_wayCount; way++)
            {
                scenes[way] = qcMakeScene(device);
                AddBodies(scenes[way], seed);
            }
            for (int variant = 0; variant < 5; variant++)
            {
                qcDetectDef def = qcDefaultDetectDef();
                def.method = variant == 0 ? qc_methodCullide : qc_methodQuick;
                strcpy(def.views, views[seed % 3]);
                def.resolution = resolutions[(seed + (uint64_t)variant) % 3];
                def.iterations = (uint32_t)(seed + (uint64_t)variant) % 3;
                def.backToFront = variant >= 2;
                def.secondPassFromBack = variant == 3;
                def.reliable = variant == 4;
                def.margin = variant == 4 ? 0.001 : 0.0;
                Answer expected = Detect(scenes[0], &def, 0);
                for (int way = 1; way < qc_wayCount; way++)
                {
                    Answer answer = Detect(scenes[way], &def, way);
                    CheckSameAnswer(&expected, &answer, s_ways[way]);
                    free(answer.pcs);
                    free(answer.passes);
                }
                free(expected.pcs);
                free(expected.passes);
            }
            for (int way = 0; way < qc_wayCount; way++)
                qcScene_Destroy(scenes[way]);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("visibility, each way", random_passes_have_the_same_results_each_way,
                        slivers_have_the_same_results_each_way, a_batch_of_thousands_of_tests_flags_the_right_ones,
                        triangles_of_any_size_have_the_same_results_each_way, what_is_prepared_serves_other_triangles,
                        images_of_other_sizes_on_a_device_make_no_difference,
                        equal_depths_of_dilated_triangles_hide_as_the_comparison_says, most_results_of_a_cloth_are_sure,
                        the_device_finds_what_the_processor_finds, counted_tests_of_a_cloth_need_one_batch,
                        scenes_have_the_same_pcs_each_way)
