// Recorded scenes, replayed by other methods and numbers of threads, report what they reported when they were recorded.
#include "recording/random_history.h"
#include "support/replay.h"
#include "support/devices.h"
#include "support/suite.h"

#include <stdio.h>
#include <unistd.h>

static char s_path[64];

static void MakePath(const char* name)
{
    snprintf(s_path, sizeof s_path, "%s.%d.qcr", name, (int)getpid());
}

/// Records `steps` steps of a history, after `unrecorded` others.
static History Record(uint64_t seed, uint32_t unrecorded, uint32_t steps)
{
    qcScene* scene = qcMakeScene(NULL);
    History history = History_Start(seed, scene, 8);
    for (uint32_t i = 0; i < unrecorded; i++)
        History_Step(&history);
    CHECK_OK(qcScene_Record(scene, s_path));
    history.detections = 0;
    for (uint32_t i = 0; i < steps; i++)
        History_Step(&history);
    CHECK_OK(qcScene_Record(scene, NULL));
    qcScene_Destroy(scene);
    History_End(&history);
    return history;
}

START_TEST(every_method_and_number_of_threads_replays_the_recorded_results)
{
    MakePath("replay");
    size_t filtered = 0, motions = 0;
    for (uint64_t seed = 1; seed <= 12; seed++)
    {
        History history = Record(seed, 0, 12);
        ck_assert_uint_gt(history.pairs, 0);
        for (uint32_t threads = 1; threads <= 3; threads++)
        {
            Replay replay = ReplayFile(s_path, NULL, qc_methodSweep, threads);
            ck_assert_uint_eq(replay.detections, history.detections);
            ck_assert(replay.isComplete);
            filtered += replay.filtered;
            motions += replay.motions;
        }
        ReplayFile(s_path, NULL, qc_methodBrute, 2);
        ReplayFile(s_path, NULL, qc_methodAuto, 0);
    }
    ck_assert_uint_gt(filtered, 0);
    ck_assert_uint_gt(motions, 0);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    remove(s_path);
}
END_TEST

START_TEST(layers_on_a_device_replay_the_recorded_results)
{
    MakePath("layers");
    qcDevice* device = qcOpenOrSkip(qc_deviceOsmesa);
    for (uint64_t seed = 1; seed <= 3 && device != NULL; seed++)
    {
        Record(seed, 0, 8);
        ReplayFile(s_path, device, qc_methodLayers, 1);
        remove(s_path);
    }
    qcDevice_Destroy(device);
}
END_TEST

START_TEST(a_recording_names_the_device_of_its_scene)
{
    MakePath("device");
    qcDevice* device = qcOpenOrSkip(qc_deviceOsmesa);
    qcDeviceInfo info = {.renderer = "none"};
    if (device != NULL)
        CHECK_OK(qcDevice_GetInfo(device, &info));
    qcScene* scene = qcMakeScene(device);
    CHECK_OK(qcScene_Record(scene, s_path));
    qcScene_Destroy(scene);
    qcRecording* recording = NULL;
    CHECK_OK(qcRecording_Open(s_path, &recording));
    ck_assert_str_eq(qcRecording_GetInfo(recording).device, info.renderer);
    qcRecording_Close(recording);
    qcDevice_Destroy(device);
    remove(s_path);
}
END_TEST

static bool RejectEvenSums(void* context, uint32_t slotA, uint32_t slotB)
{
    (void)context;
    return (slotA + slotB) % 2 != 0;
}

START_TEST(hundreds_of_rejected_pairs_are_recorded_each_once)
{
    enum
    {
        bodies = 30
    };
    MakePath("rejected");
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soup = qcSoup_MakeRandom(3, 12, 0.3);
    CHECK_OK(qcScene_Record(scene, s_path));
    size_t rejected = 0;
    for (int a = 0; a < bodies; a++)
    {
        qcAddSoup(scene, &soup);
        for (int b = 0; b < a; b++)
            rejected += (a + b) % 2 == 0;
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.pairFilter = RejectEvenSums;
    const qcResult* result;
    for (int step = 0; step < 2; step++)
        CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_gt(result->pairCount, 0);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    qcRecording* recording = NULL;
    const qcOperation* operation;
    CHECK_OK(qcRecording_Open(s_path, &recording));
    for (int i = 0; i < bodies + 2; i++)
        CHECK_OK(qcRecording_Next(recording, &operation));
    ck_assert_int_eq(operation->kind, qc_operationDetect);
    ck_assert_uint_eq(operation->rejectedPairCount, rejected);
    qcRecording_Close(recording);
    ck_assert_uint_eq(ReplayFile(s_path, NULL, qc_methodSweep, 2).filtered, 2);
    remove(s_path);
}
END_TEST

START_TEST(a_recording_that_starts_late_begins_with_the_scene_as_it_is)
{
    MakePath("late");
    size_t motions = 0;
    for (uint64_t seed = 1; seed <= 40; seed++)
    {
        History history = Record(seed, 10, 6);
        Replay replay = ReplayFile(s_path, NULL, qc_methodSweep, 1);
        ck_assert_uint_eq(replay.detections, history.detections);
        motions += replay.motions;
    }
    ck_assert_uint_gt(motions, 0);
    remove(s_path);
}
END_TEST

static char* ReadBytes(const char* path, long* size)
{
    FILE* file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    fseek(file, 0, SEEK_END);
    *size = ftell(file);
    rewind(file);
    char* bytes = malloc((size_t)*size);
    ck_assert_ptr_nonnull(bytes);
    ck_assert_uint_eq(fread(bytes, 1, (size_t)*size, file), (size_t)*size);
    fclose(file);
    return bytes;
}

START_TEST(equal_histories_give_equal_bytes_and_others_do_not)
{
    MakePath("equal");
    char* bytes[3];
    long sizes[3];
    for (int i = 0; i < 3; i++)
    {
        Record(i < 2 ? 5 : 6, 3, 10);
        bytes[i] = ReadBytes(s_path, &sizes[i]);
    }
    ck_assert_int_eq(sizes[0], sizes[1]);
    ck_assert_int_eq(memcmp(bytes[0], bytes[1], (size_t)sizes[0]), 0);
    ck_assert(sizes[0] != sizes[2] || memcmp(bytes[0], bytes[2], (size_t)sizes[0]) != 0);
    for (int i = 0; i < 3; i++)
        free(bytes[i]);
    remove(s_path);
}
END_TEST

/// Bytes of a recording of `count` bodies with the same indices.
static long SizeOfBodies(int count)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soup = qcSoup_MakeGrid(40);
    CHECK_OK(qcScene_Record(scene, s_path));
    for (int i = 0; i < count; i++)
        qcAddSoup(scene, &soup);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    long size;
    free(ReadBytes(s_path, &size));
    return size;
}

START_TEST(equal_indices_are_written_once)
{
    MakePath("indices");
    long one = SizeOfBodies(1), two = SizeOfBodies(2);
    // A grid of 40 quads a side has 3200 triangles: 12 bytes each.
    ck_assert_int_lt(two - one, one - 3200 * 12 + 64);
    remove(s_path);
}
END_TEST

START_TEST(a_different_result_has_a_different_hash)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soup = qcSoup_MakeFoldedCloth(2, 20, 0.02, 0.03);
    qcAddSoup(scene, &soup);
    qcDetectDef def = qcDefaultDetectDef();
    def.margin = 0.01;
    def.proximities = def.segments = def.manifolds = true;
    def.contactMargin = 0.02;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert(result->pairCount > 0 && result->contactCount > 0 && result->manifoldCount > 0);
    qcResultHash whole = qcResult_Hash(result);
    uint64_t* fields = (uint64_t*)(void*)&whole;
    const struct
    {
        const void* array;
        size_t field;
    } arrays[] = {{result->pairs, 1},    {result->segments, 2},  {result->proximities, 3},
                  {result->contacts, 5}, {result->manifolds, 7}, {result->manifoldPoints, 9}};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
    {
        unsigned char* byte = (unsigned char*)(uintptr_t)arrays[i].array + 3;
        *byte ^= 1;
        qcResultHash changed = qcResult_Hash(result);
        *byte ^= 1;
        for (size_t f = 0; f < sizeof whole / sizeof *fields; f++)
            ck_assert((((const uint64_t*)(const void*)&changed)[f] != fields[f]) == (f == arrays[i].field));
    }
    qcSoup_Free(&soup);
    qcScene_Destroy(scene);
}
END_TEST

QC_RUN_TESTS("replay", every_method_and_number_of_threads_replays_the_recorded_results,
             layers_on_a_device_replay_the_recorded_results, a_recording_names_the_device_of_its_scene,
             hundreds_of_rejected_pairs_are_recorded_each_once,
             a_recording_that_starts_late_begins_with_the_scene_as_it_is,
             equal_histories_give_equal_bytes_and_others_do_not, equal_indices_are_written_once,
             a_different_result_has_a_different_hash)
