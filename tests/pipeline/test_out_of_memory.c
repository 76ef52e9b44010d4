// Every allocation fails once: a status each time, the scene as before, nothing leaked, and the next try succeeds.
#include "support/devices.h"
#include "support/failing_heap.h"
#include "support/scenes.h"
#include "support/suite.h"

/// Adds the number of pairs. Where that fails the scene is whole: the same call, with memory, succeeds.
static qcStatus Detect(qcScene* scene, const qcDetectDef* def, size_t* pairs)
{
    const qcResult* result;
    qcStatus status = qcScene_Detect(scene, def, &result);
    if (status != qc_statusOk)
    {
        CHECK_OK(qcScene_Detect(scene, def, &result));
        ck_assert_int_eq(result->profile.method, def->method);
    }
    *pairs += result->pairCount;
    return status;
}

/// Moves a vertex a little and detects without contacts: a body in the Verlet list gets a partial refit.
static qcStatus MoveAndDetect(qcScene* scene, qcBodyId id, const qcSoup* soup, qcDetectDef def, size_t* pairs)
{
    double before = soup->positions[0];
    soup->positions[0] += def.contactMargin / 8.0;
    qcStatus status = qcScene_SetVertices(scene, id, soup->positions, qc_positionF64, 0);
    soup->positions[0] = before;
    def.contactMargin = 0.0;
    return status == qc_statusOk ? Detect(scene, &def, pairs) : status;
}

/// New positions: as floats for devices, which keep them so.
static qcStatus SetVertices(qcScene* scene, qcBodyId id, const qcSoup* soup, qcMethod method)
{
    if (method != qc_methodLayers)
        return qcScene_SetVertices(scene, id, soup->positions, qc_positionF64, 0);
    float* floats = malloc(3 * sizeof *floats * soup->vertexCount);
    ck_assert_ptr_nonnull(floats);
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
        floats[i] = (float)soup->positions[i];
    qcStatus status = qcScene_SetVertices(scene, id, floats, qc_positionF32, 0);
    free(floats);
    return status;
}

/// One whole use of the library; the first status that is not ok.
static qcStatus UseScene(qcDevice* device, const qcSoup* soup, qcMethod method, double margin, bool manifolds,
                         size_t* pairs)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    sceneDef.device = device;
    qcScene* scene = NULL;
    qcStatus status = qcScene_Create(&sceneDef, &scene);
    qcBodyDef bodyDef = qcBodyDefOf(soup);
    qcBodyId id;
    if (status == qc_statusOk)
        status = qcScene_AddBody(scene, &bodyDef, &id);
    bodyDef.deforming = true;
    if (status == qc_statusOk)
        status = qcScene_AddBody(scene, &bodyDef, &id);
    if (status == qc_statusOk)
        status = SetVertices(scene, id, soup, method);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.touching = def.segments = def.proximities = def.candidates = def.sets = true;
    def.manifolds = manifolds;
    def.contactMargin = margin;
    def.nearestContacts = true;
    def.threads = 1;
    if (status == qc_statusOk)
    {
        *pairs = 0;
        status = Detect(scene, &def, pairs);
        qcStatus moved = margin > 0.0 ? MoveAndDetect(scene, id, soup, def, pairs) : qc_statusOk;
        status = status == qc_statusOk ? moved : status;
    }
    qcScene_Destroy(scene);
    return status;
}

/// The device is opened before allocations fail: see test_device.c.
static void FailEachOn(qcDeviceKind kind, qcMethod method, double margin, bool manifolds, uint32_t side)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcDevice* device = qcOpenOrSkip(kind);
    qcSoup soup = qcSoup_MakeFoldedCloth(2, side, 0.02, 0.03);
    size_t expected = 0, live = heap.live, bytes = qcGetByteCount();
    heap.calls = 0;
    if (device != NULL)
    {
        CHECK_OK(UseScene(device, &soup, method, margin, manifolds, &expected));
        ck_assert_uint_gt(expected, 0);
        ck_assert_uint_gt(heap.calls, 20);
    }
    for (size_t i = 1, calls = heap.calls; i <= calls; i++)
    {
        size_t pairs = expected;
        heap = (qcFailingHeap){live, 0, i};
        ck_assert_int_eq(UseScene(device, &soup, method, margin, manifolds, &pairs), qc_statusOutOfMemory);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "out of memory"));
        ck_assert_uint_eq(pairs, expected);
        ck_assert_uint_eq(heap.live, live);
        ck_assert_uint_eq(qcGetByteCount(), bytes);
    }
    qcSoup_Free(&soup);
    qcDevice_Destroy(device);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}

static void FailEach(qcMethod method, double margin, bool manifolds, uint32_t side)
{
    FailEachOn(qc_deviceNone, method, margin, manifolds, side);
}

START_TEST(a_failed_allocation_in_sweep_leaves_the_scene_valid)
{
    FailEach(qc_methodSweep, 0.0, false, 12);
}
END_TEST

START_TEST(a_failed_allocation_in_brute_force_leaves_the_scene_valid)
{
    FailEach(qc_methodBrute, 0.0, false, 12);
}
END_TEST

START_TEST(a_failed_allocation_in_contacts_leaves_the_scene_valid)
{
    FailEach(qc_methodSweep, 0.03, false, 12);
}
END_TEST

START_TEST(a_failed_allocation_in_manifolds_leaves_the_scene_valid)
{
    FailEach(qc_methodSweep, 0.0, true, 5);
}
END_TEST

START_TEST(a_failed_allocation_in_layers_leaves_the_scene_valid)
{
    // With contacts: neighbours are listed too.
    FailEachOn(qc_deviceOsmesa, qc_methodLayers, 0.0, false, 6);
    FailEachOn(qc_deviceSurfaceless, qc_methodLayers, 0.03, false, 6);
}
END_TEST

//  ---- motions -----------------------------------------------------------------------------------------------------

enum
{
    qc_motionDetections = 3
};

/// Counts a lack of memory, after which a second call succeeds.
#define TRY_TWICE(failures, call)                                                                                      \
    do                                                                                                                 \
    {                                                                                                                  \
        if ((call) != qc_statusOk)                                                                                     \
        {                                                                                                              \
            ck_assert_ptr_nonnull(strstr(qcLastMessage(), "out of memory"));                                           \
            (failures)++;                                                                                              \
            CHECK_OK(call);                                                                                            \
        }                                                                                                              \
    } while (0)

/// Moves all vertices of a body to and fro.
static void Shake(qcScene* scene, qcBodyId id, const qcSoup* soup, uint64_t seed)
{
    qcRandom random = {seed};
    double* moved = malloc(3 * sizeof(double) * soup->vertexCount);
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
        moved[i] = soup->positions[i] + qcRandom_Uniform(&random, -0.05, 0.05);
    CHECK_OK(qcScene_SetVertices(scene, id, moved, qc_positionF64, 0));
    free(moved);
}

static qcPairList DetectMotion(qcScene* scene, qcMethod method, size_t* failures)
{
    const qcResult* result;
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.motion = def.proximities = true;
    def.threads = 1;
    TRY_TWICE(*failures, qcScene_Detect(scene, &def, &result));
    qcPairList list = {malloc((result->pairCount + 1) * sizeof(qcPair)), result->pairCount};
    if (list.count != 0)
        memcpy(list.pairs, result->pairs, list.count * sizeof(qcPair));
    return list;
}

/// Two steps, with a body that is added between them. A mark that fails leaves the motion as it was.
static size_t UseMotion(qcMethod method, const qcSoup* cloth, const qcSoup* sphere,
                        qcPairList found[qc_motionDetections])
{
    size_t failures = 0;
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = NULL;
    qcBodyDef bodyDef = qcBodyDefOf(sphere);
    qcBodyId rigid, first, second;
    TRY_TWICE(failures, qcScene_Create(&sceneDef, &scene));
    TRY_TWICE(failures, qcScene_AddBody(scene, &bodyDef, &rigid));
    bodyDef = qcBodyDefOf(cloth);
    bodyDef.deforming = bodyDef.selfCollision = true;
    TRY_TWICE(failures, qcScene_AddBody(scene, &bodyDef, &first));
    TRY_TWICE(failures, qcScene_MarkStart(scene));
    Shake(scene, first, cloth, 1);
    found[0] = DetectMotion(scene, method, &failures);
    TRY_TWICE(failures, qcScene_AddBody(scene, &bodyDef, &second));
    found[1] = DetectMotion(scene, method, &failures);
    if (qcScene_MarkStart(scene) != qc_statusOk)
    {
        // The new body has no start, and no motion.
        Shake(scene, second, cloth, 4);
        CHECK_OK(qcScene_SetVertices(scene, second, cloth->positions, qc_positionF64, 0));
        qcPairList again = DetectMotion(scene, method, &failures);
        qcCheckSamePairs(&found[1], &again, "after a mark without memory");
        free(again.pairs);
        CHECK_OK(qcScene_MarkStart(scene));
        failures++;
    }
    qcTransform transform = qcIdentityTransform();
    transform.translation[2] = 0.2;
    CHECK_OK(qcScene_SetTransform(scene, rigid, &transform));
    Shake(scene, first, cloth, 2);
    Shake(scene, second, cloth, 3);
    found[2] = DetectMotion(scene, method, &failures);
    qcScene_Destroy(scene);
    return failures;
}

static void FailEachOfMotion(qcMethod method)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcSoup cloth = qcSoup_MakeFoldedCloth(2, 6, 0.02, 0.0), sphere = qcSoup_MakeSphere(0, 0.3);
    qcPairList expected[qc_motionDetections], found[qc_motionDetections];
    ck_assert_uint_eq(UseMotion(method, &cloth, &sphere, expected), 0);
    for (size_t i = 1, calls = heap.calls; i <= calls; i++)
    {
        heap = (qcFailingHeap){0, 0, i};
        ck_assert_uint_eq(UseMotion(method, &cloth, &sphere, found), 1);
        ck_assert_uint_eq(heap.live, 0);
        for (int k = 0; k < qc_motionDetections; k++)
        {
            qcCheckSamePairs(&expected[k], &found[k], "a motion");
            free(found[k].pairs);
        }
    }
    for (int k = 0; k < qc_motionDetections; k++)
    {
        ck_assert_uint_gt(expected[k].count, 0);
        free(expected[k].pairs);
    }
    qcSoup_Free(&cloth);
    qcSoup_Free(&sphere);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}

START_TEST(a_calibration_without_memory_leaves_auto_with_all_pairs)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcDevice* device = qcOpenOrSkip(qc_deviceOsmesa);
    qcSoup soup = qcSoup_MakeFoldedCloth(2, 60, 0.02, 0.03);
    qcScene* reference = qcMakeScene(NULL);
    qcAddSoup(reference, &soup);
    qcDetectDef def = qcDefaultDetectDef();
    def.threads = 1;
    qcPairList expected = qcDetectPairs(reference, &def);
    for (size_t call = 13; call <= 27 && device != NULL; call++)
    {
        // Without costs, so that the first step measures them, after its first twelve allocations.
        CHECK_OK(qcDevice_Reopen(device));
        qcScene* scene = qcMakeScene(device);
        qcAddSoup(scene, &soup);
        heap.calls = 0;
        heap.failAt = call;
        const qcResult* result;
        qcStatus status = qcScene_Detect(scene, &def, &result);
        ck_assert_uint_ge(heap.calls, call);
        heap.failAt = 0;
        ck_assert(status == qc_statusOk || status == qc_statusOutOfMemory);
        if (status != qc_statusOk)
            CHECK_OK(qcScene_Detect(scene, &def, &result));
        qcPairList found = qcListOf(result);
        qcCheckSamePairs(&expected, &found, "auto");
        qcScene_Destroy(scene);
    }
    free(expected.pairs);
    qcSoup_Free(&soup);
    qcScene_Destroy(reference);
    qcDevice_Destroy(device);
    ck_assert_uint_eq(heap.live, 0);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

START_TEST(a_failed_allocation_in_a_motion_leaves_the_scene_valid)
{
    FailEachOfMotion(qc_methodSweep);
    FailEachOfMotion(qc_methodBrute);
}
END_TEST

START_TEST(the_allocator_cannot_change_while_bytes_are_held)
{
    qcFailingHeap heap = {0, 0, 0};
    qcScene* scene = qcMakeScene(NULL);
    ck_assert_int_eq(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap), qc_statusBadInput);
    ck_assert_int_eq(qcSetAllocator(qcFailingHeap_Allocate, NULL, &heap), qc_statusBadInput);
    qcScene_Destroy(scene);
}
END_TEST

QC_RUN_TESTS("out of memory", a_failed_allocation_in_sweep_leaves_the_scene_valid,
             a_failed_allocation_in_brute_force_leaves_the_scene_valid,
             a_failed_allocation_in_contacts_leaves_the_scene_valid,
             a_failed_allocation_in_manifolds_leaves_the_scene_valid,
             a_failed_allocation_in_layers_leaves_the_scene_valid,
             a_calibration_without_memory_leaves_auto_with_all_pairs,
             a_failed_allocation_in_a_motion_leaves_the_scene_valid, the_allocator_cannot_change_while_bytes_are_held)
