// A recording is read as far as it is whole, and the message names the operation and the byte where it is not.
#include "recording/random_history.h"
#include "recording/recorded_boxes.h"
#include "recording/recorded_bytes.h"
#include "support/suite.h"

#include <stdio.h>
#include <unistd.h>

static char s_path[64];

/// What is recorded, by the index of a test.
static const uint32_t s_scalarSizes[] = {0, 4, 8};

/// A small history with every kind of operation.
static void RecordScene(void)
{
    qcScene* scene = qcMakeScene(NULL);
    CHECK_OK(qcScene_Record(scene, s_path));
    History history = History_Start(11, scene, 1);
    for (int i = 0; i < 8; i++)
        History_Step(&history);
    qcScene_Destroy(scene);
    History_End(&history);
}

/// 0: a scene; 4 and 8: a broadphase with numbers of this size. The file's bytes.
static Bytes MakeRecording(uint32_t scalarSize)
{
    snprintf(s_path, sizeof s_path, "damaged.%d.qcr", (int)getpid());
    if (scalarSize == 0)
        RecordScene();
    else
        RecordBoxes(s_path, scalarSize);
    return Bytes_Read(s_path);
}

/// Reads a file to its end, applying the operations; the number of those that were read. The status is that of the
/// call that failed.
static uint64_t ReadAll(qcStatus* status, bool* isComplete)
{
    qcRecording* recording = NULL;
    *isComplete = false;
    *status = qcRecording_Open(s_path, &recording);
    uint64_t count = 0;
    const qcOperation* operation;
    qcScene* scene = qcMakeScene(NULL);
    while (*status == qc_statusOk)
    {
        *status = qcRecording_Next(recording, &operation);
        if (*status != qc_statusOk)
            // The recording stays where it is.
            ck_assert_int_eq(qcRecording_Next(recording, &operation), *status);
        else if (operation->kind == qc_operationEnd)
        {
            *isComplete = operation->isComplete;
            break;
        }
        else
        {
            qcOperation_Apply(operation, scene, NULL);
            count++;
        }
    }
    qcScene_Destroy(scene);
    qcRecording_Close(recording);
    return count;
}

START_TEST(each_flipped_byte_is_found_and_named)
{
    Bytes whole = MakeRecording(s_scalarSizes[_i]);
    qcStatus status;
    bool isComplete;
    uint64_t operations = ReadAll(&status, &isComplete), previous = 0;
    ck_assert(status == qc_statusOk && isComplete);
    for (size_t i = 0; i < whole.size; i++)
    {
        whole.data[i] ^= (unsigned char)(1u << i % 8);
        WriteBytes(s_path, whole.data, whole.size);
        whole.data[i] ^= (unsigned char)(1u << i % 8);
        uint64_t count = ReadAll(&status, &isComplete);
        ck_assert_msg(status == qc_statusFile, "byte %zu: status %d", i, (int)status);
        // What lies before the damage is read.
        ck_assert_uint_ge(count, previous);
        previous = count;
        if (i < 24)
            ck_assert_ptr_nonnull(strstr(qcLastMessage(), i < 8 ? "is no recording" : "bytes 0 to 23"));
        else
        {
            unsigned long long operation, byte;
            const char* place = strstr(qcLastMessage(), "operation ");
            ck_assert_msg(place != NULL && sscanf(place, "operation %llu at byte %llu:", &operation, &byte) == 2, "%s",
                          qcLastMessage());
            ck_assert_uint_eq(operation, count);
            ck_assert_uint_le(byte, i);
        }
    }
    ck_assert_uint_eq(previous, operations);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    free(whole.data);
    remove(s_path);
}
END_TEST

START_TEST(a_file_cut_anywhere_is_read_up_to_the_cut)
{
    Bytes whole = MakeRecording(s_scalarSizes[_i]);
    qcStatus status;
    bool isComplete;
    uint64_t operations = ReadAll(&status, &isComplete), previous = 0;
    size_t clean = 0;
    for (size_t size = 0; size < whole.size; size++)
    {
        WriteBytes(s_path, whole.data, size);
        uint64_t count = ReadAll(&status, &isComplete);
        ck_assert(!isComplete);
        ck_assert_uint_ge(count, previous);
        previous = count;
        // Between two records nothing is missing but the end.
        clean += status == qc_statusOk;
        if (status != qc_statusOk)
        {
            ck_assert_int_eq(status, qc_statusFile);
            char place[64];
            snprintf(place, sizeof place, "at byte %zu", size);
            ck_assert_msg(strstr(qcLastMessage(), size < 8 ? "is no recording" : place) != NULL, "%zu: %s", size,
                          qcLastMessage());
        }
    }
    ck_assert_uint_eq(previous, operations);
    // Behind each operation, and between a detection and its result.
    ck_assert_uint_ge(clean, operations);
    free(whole.data);
    remove(s_path);
}
END_TEST

/// QC_TEST_FILES: the number of files; QC_TEST_SEED: their seed.
START_TEST(bytes_behind_the_end_are_found)
{
    Bytes whole = MakeRecording(s_scalarSizes[_i]);
    unsigned char* twice = malloc(2 * whole.size);
    ck_assert_ptr_nonnull(twice);
    memcpy(twice, whole.data, whole.size);
    memcpy(twice + whole.size, whole.data, whole.size);
    qcStatus status;
    bool isComplete;
    const uint64_t operations = ReadAll(&status, &isComplete);
    for (size_t more = 1; more <= whole.size; more += whole.size - 1)
    {
        WriteBytes(s_path, twice, whole.size + more);
        ck_assert_uint_eq(ReadAll(&status, &isComplete), operations);
        ck_assert_int_eq(status, qc_statusFile);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "behind the end"));
    }
    free(twice);
    free(whole.data);
}
END_TEST

START_TEST(forged_files_with_right_hashes_crash_nothing)
{
    Bytes whole = MakeRecording(s_scalarSizes[_i]);
    unsigned char* data = malloc(whole.size);
    ck_assert_ptr_nonnull(data);
    const char *files = getenv("QC_TEST_FILES"), *seed = getenv("QC_TEST_SEED");
    long count = files != NULL ? atol(files) : 4000;
    qcRandom random = {seed != NULL ? (uint64_t)atoll(seed) : 1};
    size_t refused = 0;
    for (long i = 0; i < count; i++)
    {
        memcpy(data, whole.data, whole.size);
        Bytes forged = {data, whole.size};
        for (uint32_t k = 1 + qcRandom_Below(&random, 3); k > 0; k--)
        {
            size_t at = 24 + qcRandom_Below(&random, (uint32_t)whole.size - 24);
            // Numbers in the head and in front of the data are what sizes are computed from.
            unsigned char byte = (unsigned char)qcRandom_Below(&random, 256);
            data[at] = qcRandom_Below(&random, 2) == 0 ? byte : (unsigned char)(data[at] + byte % 3 - 1);
            if (qcRandom_Below(&random, 8) == 0)
                memset(data + at, byte % 2 == 0 ? 0xff : 0x00, whole.size - at < 4 ? whole.size - at : 4);
        }
        Bytes_Rehash(forged);
        WriteBytes(s_path, data, whole.size);
        qcStatus status;
        bool isComplete;
        ReadAll(&status, &isComplete);
        refused += status != qc_statusOk;
        ck_assert_uint_eq(qcGetByteCount(), 0);
    }
    ck_assert_uint_gt(refused, 0);
    ck_assert_uint_lt(refused, (size_t)count);
    free(data);
    free(whole.data);
    remove(s_path);
}
END_TEST

START_TEST(calls_of_a_broadphase_are_read_as_they_were_made)
{
    free(MakeRecording(4).data);
    qcRecording* recording = NULL;
    CHECK_OK(qcRecording_Open(s_path, &recording));
    ck_assert_uint_eq(qcRecording_GetInfo(recording).boxScalarSize, 4);
    const qcOperationKind kinds[] = {qc_operationAddBox,    qc_operationAddBox,    qc_operationAddBox,
                                     qc_operationAddBox,    qc_operationMoveBoxes, qc_operationSetBoxFilter,
                                     qc_operationFindPairs, qc_operationMoveBoxes, qc_operationRemoveBox,
                                     qc_operationQueryBox,  qc_operationCastBox,   qc_operationResetBoxes,
                                     qc_operationEnd};
    const qcOperation* operation;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
    {
        CHECK_OK(qcRecording_Next(recording, &operation));
        ck_assert_int_eq(operation->kind, kinds[i]);
        const qcBoxOperation* boxes = &operation->boxes;
        if (i == 4)
            ck_assert(boxes->count == 3 && boxes->ids[2] == 3 && boxes->bounds[17] == 5.0);
        if (i == 6)
            ck_assert(boxes->pairCount == 2 && boxes->hasCallback && boxes->isDisturbed && boxes->rejectedCount == 1 &&
                      boxes->rejected[0].b == 2);
        if (i == 10)
            ck_assert(boxes->count == 2 && boxes->ids[1] == 3 && boxes->lambdas[1] == 0.25 &&
                      boxes->cast.directionInverse[2] == 3.0 && boxes->cast.lambda == 7.0 && !boxes->isDisturbed);
        if (i < 12)
            ck_assert_int_eq(qcOperation_Apply(operation, NULL, NULL), qc_statusBadInput);
    }
    ck_assert(operation->isComplete);
    qcRecording_Close(recording);
    remove(s_path);
}
END_TEST

START_TEST(what_is_no_recording_is_refused_with_its_name)
{
    char garbage;
    qcRecording* recording = (qcRecording*)(void*)&garbage;
    ck_assert_int_eq(qcRecording_Open("/no/such/file.qcr", &recording), qc_statusFile);
    ck_assert_ptr_null(recording);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "/no/such/file.qcr can't be opened: No such file"));
    ck_assert_int_eq(qcRecording_Open("/", &recording), qc_statusFile);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "/ can't be read: Is a directory"));
    ck_assert_int_eq(qcRecording_Open(NULL, &recording), qc_statusBadInput);
    ck_assert_int_eq(qcRecording_Open("/", NULL), qc_statusBadInput);
    const qcOperation* operation;
    ck_assert_int_eq(qcRecording_Next(NULL, &operation), qc_statusBadInput);
    ck_assert_int_eq(qcOperation_Apply(NULL, NULL, NULL), qc_statusBadInput);
    ck_assert_ptr_null(recording);
    qcRecording_Close(NULL);
}
END_TEST

START_TEST(a_newer_format_is_refused_with_both_versions)
{
    Bytes whole = MakeRecording(0);
    uint32_t version = 2;
    memcpy(whole.data + 8, &version, sizeof version);
    uint64_t hash = qcXxh64(whole.data, 16, 0);
    memcpy(whole.data + 16, &hash, sizeof hash);
    WriteBytes(s_path, whole.data, whole.size);
    qcRecording* recording;
    ck_assert_int_eq(qcRecording_Open(s_path, &recording), qc_statusFile);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "the format is version 2"));
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "reads version 1"));
    free(whole.data);
    remove(s_path);
}
END_TEST

int main(void)
{
    const TTest* const each[] = {each_flipped_byte_is_found_and_named, a_file_cut_anywhere_is_read_up_to_the_cut,
                                 bytes_behind_the_end_are_found, forged_files_with_right_hashes_crash_nothing};
    const TTest* const once[] = {calls_of_a_broadphase_are_read_as_they_were_made,
                                 what_is_no_recording_is_refused_with_its_name,
                                 a_newer_format_is_refused_with_both_versions};
    TCase* testCase = qcMakeCase("damaged_files");
    for (size_t i = 0; i < sizeof each / sizeof each[0]; i++)
        tcase_add_loop_test(testCase, each[i], 0, sizeof s_scalarSizes / sizeof s_scalarSizes[0]);
    for (size_t i = 0; i < sizeof once / sizeof once[0]; i++)
        tcase_add_test(testCase, once[i]);
    return qcRunCase("damaged_files", testCase);
}
