// Each field of each record, damaged behind a right hash: the message names the operation, its byte and the field.
#include "recording/recorded_boxes.h"
#include "recording/recorded_bytes.h"
#include "support/failing_heap.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <stddef.h>
#include <unistd.h>

static char s_path[64];

static bool RejectAll(void* context, uint32_t slotA, uint32_t slotB)
{
    (void)context;
    (void)slotA;
    (void)slotB;
    return false;
}

enum
{
    op_addBent, ///< body 0: deforming, doubles, new indices
    op_addRigid,
    op_bendDoubles, ///< packed
    op_bendFloats,  ///< as they are
    op_bendFloatsAgain,
    op_transform,
    op_activity,
    op_filter,
    op_selfCollision,
    op_margin,
    op_markStart,
    op_detect,
    op_remove
};

/// The operations above, in this order.
static void RecordScene(void)
{
    double square[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    float floats[12];
    const uint32_t indices[6] = {0, 1, 2, 1, 3, 2};
    const qcTransform transform = qcIdentityTransform();
    qcScene* scene = qcMakeScene(NULL);
    CHECK_OK(qcScene_Record(scene, s_path));
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = square;
    def.positionType = qc_positionF64;
    def.vertexCount = 4;
    def.indices = indices;
    def.triangleCount = 2;
    def.deforming = true;
    qcBodyId ids[2];
    CHECK_OK(qcScene_AddBody(scene, &def, &ids[0]));
    def.deforming = false;
    CHECK_OK(qcScene_AddBody(scene, &def, &ids[1]));
    for (int i = 0; i < 12; i++)
        floats[i] = (float)(square[i] += 0.1 * i);
    CHECK_OK(qcScene_SetVertices(scene, ids[0], square, qc_positionF64, 0));
    CHECK_OK(qcScene_SetVertices(scene, ids[0], floats, qc_positionF32, 0));
    floats[0] += 0.25f;
    CHECK_OK(qcScene_SetVertices(scene, ids[0], floats, qc_positionF32, 0));
    CHECK_OK(qcScene_SetTransform(scene, ids[1], &transform));
    CHECK_OK(qcScene_SetActivity(scene, ids[1], qc_activityMoving));
    CHECK_OK(qcScene_SetFilter(scene, ids[1], 1, 1));
    CHECK_OK(qcScene_SetSelfCollision(scene, ids[1], false));
    CHECK_OK(qcScene_SetMargin(scene, ids[1], 0.5));
    CHECK_OK(qcScene_MarkStart(scene));
    qcDetectDef detect = qcDefaultDetectDef();
    detect.manifolds = true;
    detect.spacing = 0.5;
    detect.margin = 2.0;
    detect.maxPairs = 1000;
    detect.pairFilter = RejectAll;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    CHECK_OK(qcScene_RemoveBody(scene, ids[1]));
    qcScene_Destroy(scene);
}

/// 0: a scene; 4 and 8: a broadphase with numbers of this size.
static Bytes MakeRecording(uint32_t scalarSize)
{
    snprintf(s_path, sizeof s_path, "fields.%d.qcr", (int)getpid());
    if (scalarSize == 0)
        RecordScene();
    else
        RecordBoxes(s_path, scalarSize);
    return Bytes_Read(s_path);
}

/// The record of an operation: the first names the device, and the result follows the detection.
static uint32_t RecordOf(uint32_t operation)
{
    return operation + 1 + (operation > op_detect);
}

/// Checks that the file is read up to an operation, whose record begins at `byte`, and that the message is `reason`.
static void CheckReason(uint32_t operation, size_t byte, const char* reason)
{
    qcStatus status;
    ck_assert_uint_eq(CountOperations(s_path, &status), operation);
    ck_assert_int_eq(status, qc_statusFile);
    char expected[200];
    snprintf(expected, sizeof expected, ": operation %u at byte %zu: %s", operation, byte, reason);
    ck_assert_msg(strstr(qcLastMessage(), expected) != NULL, "'%s' is not in '%s'", expected, qcLastMessage());
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

typedef struct Damage
{
    uint32_t operation;
    size_t offset; ///< in the record, with its head
    uint32_t value;
    const char* reason;
} Damage;

static void CheckDamages(const Damage* damages, size_t count, bool isScene)
{
    Bytes whole = MakeRecording(isScene ? 0 : 8);
    for (size_t i = 0; i < count; i++)
    {
        Damage damage = damages[i];
        size_t at;
        Bytes_FindRecord(whole, isScene ? RecordOf(damage.operation) : damage.operation + 1, &at);
        Bytes damaged = {malloc(whole.size), whole.size};
        ck_assert_ptr_nonnull(damaged.data);
        memcpy(damaged.data, whole.data, whole.size);
        memcpy(damaged.data + at + damage.offset, &damage.value, sizeof damage.value);
        Bytes_Rehash(damaged);
        WriteBytes(s_path, damaged.data, damaged.size);
        CheckReason(damage.operation, at, damage.reason);
        free(damaged.data);
    }
    free(whole.data);
    remove(s_path);
}

#define HEAD(field) offsetof(qcRecordHead, field)
#define DATA(Record, field) (sizeof(qcRecordHead) + offsetof(Record, field))
#define BEHIND(Record) (sizeof(qcRecordHead) + sizeof(Record))

START_TEST(each_damaged_field_of_a_scene_is_named)
{
    const Damage damages[] = {
        {op_addBent, HEAD(kind), 11, "unknown operation 11"},
        {op_addBent, HEAD(kind), qc_operationAddBox, "unknown operation 20"},
        {op_addBent, HEAD(slot), 3, "body 3 is added, but the next free slot is 0"},
        {op_addBent, DATA(qcBodyRecord, flags), 16, "unknown flags 0x10"},
        {op_addBent, DATA(qcBodyRecord, indexSet), 5, "it names the indices 5 of 0"},
        {op_addBent, DATA(qcBodyRecord, vertexCount), 1000, "its data is too short"},
        {op_addBent, DATA(qcBodyRecord, vertexCount), UINT32_MAX, "its data is too short"},
        {op_addBent, DATA(qcBodyRecord, triangleCount), 1000, "its data is too short"},
        {op_addBent, DATA(qcBodyRecord, triangleCount), 1, "its data is too long"},
        {op_addBent, BEHIND(qcBodyRecord) + sizeof(double[12]), 77, "index 77 is out of range: there are 4 vertices"},
        {op_addRigid, HEAD(slot), 0, "body 0 is added, but the next free slot is 1"},
        {op_addRigid, DATA(qcBodyRecord, flags), qc_bodyFlags, "its data is too short"},
        {op_addRigid, DATA(qcBodyRecord, indexSet), 1, "it names the indices 1 of 1"},
        {op_addRigid, DATA(qcBodyRecord, triangleCount), 1, "it has 1 triangles, but its indices are those of 2"},
        {op_bendDoubles, HEAD(slot), 1, "body 1 is rigid"},
        {op_bendDoubles, HEAD(slot), 9, "body 9 is not there"},
        {op_bendDoubles, DATA(qcVerticesRecord, vertexCount), 5, "body 0 has 4 vertices, not 5"},
        {op_bendDoubles, DATA(qcVerticesRecord, coding), 4, "unknown coding 4"},
        {op_bendDoubles, DATA(qcVerticesRecord, coding), qc_codingPackedF32,
         "its positions are differences to positions of another type"},
        {op_bendDoubles, BEHIND(qcVerticesRecord), 65, "its positions are damaged"},
        {op_bendDoubles, BEHIND(qcVerticesRecord), 0, "its data is too long"},
        {op_bendFloats, DATA(qcVerticesRecord, coding), qc_codingF64, "its data is too short"},
        {op_bendFloatsAgain, BEHIND(qcVerticesRecord), 33, "its positions are damaged"},
        {op_bendFloatsAgain, HEAD(kind), qc_operationSetTransform, "body 0 is deforming"},
        {op_transform, HEAD(slot), 0, "body 0 is deforming"},
        {op_activity, HEAD(slot), 2, "body 2 is not there"},
        {op_filter, HEAD(slot), UINT32_MAX, "body 4294967295 is not there"},
        {op_selfCollision, HEAD(kind), qc_operationRemoveBody, "its data is too long"},
        {op_margin, HEAD(kind), qc_recordResult, "unknown operation 65"},
        {op_markStart, HEAD(kind), qc_operationDetect, "its data is too short"},
        {op_detect, DATA(qcDetectRecord, flags), 1 << 20, "unknown flags 0x100000"},
        {op_detect, DATA(qcDetectRecord, flags), 0, "its data is too long"},
        {op_remove, HEAD(slot), 2, "body 2 is not there"},
        {op_remove, HEAD(kind), qc_recordDevice, "unknown operation 64"},
    };
    CheckDamages(damages, sizeof damages / sizeof damages[0], true);
}
END_TEST

START_TEST(each_damaged_field_of_a_broadphase_is_named)
{
    // As MakeBoxCalls has them.
    enum
    {
        op_addBox = 0,
        op_moveBoxes = 4,
        op_filterBox,
        op_findPairs,
        op_moveBehind,
        op_removeBox,
        op_queryBox,
        op_castBox
    };
    const Damage damages[] = {
        {op_addBox, HEAD(kind), qc_operationAddBody, "unknown operation 1 of a broadphase"},
        {op_addBox, HEAD(kind), qc_operationSetBoxFilter, "its data is too long"},
        {op_addBox, HEAD(kind), qc_operationRemoveBox, "its data is too long"},
        {op_moveBoxes, DATA(qcBoxesRecord, count), 1000, "its data is too short"},
        {op_moveBoxes, DATA(qcBoxesRecord, count), UINT32_MAX, "its data is too short"},
        {op_moveBoxes, DATA(qcBoxesRecord, count), 1, "its data is too long"},
        {op_filterBox, HEAD(kind), qc_operationAddBox, "its data is too short"},
        {op_filterBox, HEAD(kind), qc_operationFindPairs, "its data is too short"},
        {op_removeBox, HEAD(kind), qc_operationQueryBox, "its data is too short"},
        {op_queryBox, DATA(qcBoxesRecord, count), 9, "its data is too short"},
        {op_queryBox, DATA(qcBoxesRecord, count), 0, "its data is too long"},
        {op_castBox, DATA(qcBoxesRecord, count), 40, "its data is too short"},
        {op_castBox, DATA(qcBoxesRecord, count), 4, "its data is too short"},
        {op_castBox, DATA(qcBoxesRecord, count), 1, "its data is too long"},
        {op_castBox, HEAD(kind), 0, "unknown operation 0 of a broadphase"},
    };
    CheckDamages(damages, sizeof damages / sizeof damages[0], false);
}
END_TEST

/// The whole recording with 8 bytes more, or less, at the end of a record's data.
static Bytes Resize(Bytes whole, uint32_t number, bool isLonger)
{
    size_t at;
    qcRecordHead head = Bytes_FindRecord(whole, number, &at);
    size_t end = at + sizeof head + (size_t)head.size;
    Bytes resized = {calloc(whole.size + 8, 1), isLonger ? whole.size + 8 : whole.size - 8};
    ck_assert_ptr_nonnull(resized.data);
    memcpy(resized.data, whole.data, end);
    head.size = isLonger ? head.size + 8 : head.size - 8;
    memcpy(resized.data + at, &head, sizeof head);
    if (isLonger)
        memset(resized.data + end, 0, 8);
    memcpy(resized.data + (isLonger ? end + 8 : end - 8), whole.data + end, whole.size - end);
    Bytes_Rehash(resized);
    return resized;
}

/// `_i`: what is recorded.
START_TEST(a_record_that_is_longer_or_shorter_is_refused)
{
    const uint32_t scalarSizes[] = {0, 4, 8};
    Bytes whole = MakeRecording(scalarSizes[_i]);
    size_t at;
    uint32_t refused = 0;
    for (uint32_t number = 1; Bytes_FindRecord(whole, number, &at).kind != 0; number++)
        for (int isLonger = 0; isLonger < 2; isLonger++)
        {
            qcRecordHead head = Bytes_FindRecord(whole, number, &at);
            // Rejected pairs fill what is left, and the end has no data that matters.
            if (head.kind == qc_recordResult || head.kind == qc_operationFindPairs || head.kind == qc_recordEnd)
                continue;
            if (head.size == 0 && !isLonger)
                continue;
            Bytes resized = Resize(whole, number, isLonger != 0);
            WriteBytes(s_path, resized.data, resized.size);
            qcStatus status;
            uint64_t count = CountOperations(s_path, &status);
            ck_assert_msg(status == qc_statusFile, "record %u, kind %u, longer %d", number, head.kind, isLonger);
            ck_assert_uint_eq(count, number - 1 - (_i == 0 && number > RecordOf(op_detect)));
            ck_assert_msg(strstr(qcLastMessage(), "its data is too") != NULL ||
                              strstr(qcLastMessage(), "its positions are damaged") != NULL,
                          "%s", qcLastMessage());
            free(resized.data);
            refused++;
        }
    ck_assert_uint_gt(refused, 10);
    free(whole.data);
    remove(s_path);
}
END_TEST

START_TEST(what_names_no_device_and_no_numbers_is_refused)
{
    const struct
    {
        uint32_t scalarSize;
        size_t offset;
        uint32_t value;
        const char* reason;
    } damages[] = {{0, HEAD(kind), qc_operationAddBody, "it does not name a device"},
                   {0, sizeof(qcRecordHead) + 4, 0x20202020, "it does not name a device"},
                   {4, sizeof(qcRecordHead), 5, "its numbers have 5 bytes"}};
    for (size_t i = 0; i < sizeof damages / sizeof damages[0]; i++)
    {
        Bytes whole = MakeRecording(damages[i].scalarSize);
        memcpy(whole.data + sizeof(qcFileHeader) + damages[i].offset, &damages[i].value, sizeof damages[i].value);
        Bytes_Rehash(whole);
        WriteBytes(s_path, whole.data, whole.size);
        CheckReason(0, sizeof(qcFileHeader), damages[i].reason);
        free(whole.data);
    }
    // Only the header is there.
    Bytes whole = MakeRecording(0);
    WriteBytes(s_path, whole.data, sizeof(qcFileHeader));
    CheckReason(0, sizeof(qcFileHeader), "the file ends before it");
    free(whole.data);
    remove(s_path);
}
END_TEST

/// A result that is another record: the detection is whole and has none.
START_TEST(a_detection_without_a_result_is_read_and_what_follows_it_is_named)
{
    Bytes whole = MakeRecording(0);
    size_t at;
    ck_assert_uint_eq(Bytes_FindRecord(whole, RecordOf(op_detect) + 1, &at).kind, qc_recordResult);
    const uint32_t kind = qc_operationMarkStart;
    memcpy(whole.data + at, &kind, sizeof kind);
    Bytes_Rehash(whole);
    WriteBytes(s_path, whole.data, whole.size);
    CheckReason(op_detect + 1, at, "its data is too long");
    free(whole.data);
    remove(s_path);
}
END_TEST

START_TEST(a_scene_with_other_bodies_refuses_a_recorded_one)
{
    free(MakeRecording(0).data);
    qcRecording* recording;
    const qcOperation* operation;
    CHECK_OK(qcRecording_Open(s_path, &recording));
    CHECK_OK(qcRecording_Next(recording, &operation));
    qcScene* scene = qcMakeScene(NULL);
    CHECK_OK(qcOperation_Apply(operation, scene, NULL));
    ck_assert_int_eq(qcOperation_Apply(operation, scene, NULL), qc_statusBadInput);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "(add body): the scene has had other operations: its next body is 1, "
                                                  "generation 1"));
    // What was refused is not left behind.
    ck_assert(!qcScene_IsValid(scene, (qcBodyId){1, 1}));
    qcScene_Destroy(scene);
    qcRecording_Close(recording);
    remove(s_path);
}
END_TEST

START_TEST(each_kind_of_operation_has_a_name_of_its_own)
{
    const qcOperationKind first[] = {qc_operationEnd, qc_operationAddBox},
                          last[] = {qc_operationDetect, qc_operationCastBox};
    const char* names[32];
    size_t count = 0;
    for (int range = 0; range < 2; range++)
        for (int kind = (int)first[range]; kind <= (int)last[range]; kind++)
        {
            names[count] = qcOperationKind_Name((qcOperationKind)kind);
            ck_assert_str_ne(names[count], "unknown operation");
            for (size_t i = 0; i < count; i++)
                ck_assert_str_ne(names[i], names[count]);
            count++;
        }
    ck_assert_uint_eq(count, 19);
    ck_assert_str_eq(qcOperationKind_Name((qcOperationKind)(qc_operationCastBox + 1)), "unknown operation");
    ck_assert_str_eq(qcRecording_GetInfo(NULL).device, "none");
}
END_TEST

START_TEST(each_failed_allocation_of_the_reader_is_a_status_and_leaks_nothing)
{
    const uint32_t scalarSizes[] = {0, 4, 8};
    free(MakeRecording(scalarSizes[_i]).data);
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcStatus status = qc_statusOutOfMemory;
    size_t failures = 0;
    uint64_t previous = 0;
    for (heap.failAt = 1; status != qc_statusOk; heap.failAt++)
    {
        heap.calls = 0;
        uint64_t count = CountOperations(s_path, &status);
        ck_assert_uint_eq(heap.live, 0);
        ck_assert_uint_ge(count, previous);
        previous = count;
        if (status == qc_statusOk)
            continue;
        ck_assert_int_eq(status, qc_statusOutOfMemory);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "out of memory"));
        failures++;
    }
    ck_assert_uint_ge(failures, 5);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
    remove(s_path);
}
END_TEST

int main(void)
{
    TCase* testCase = qcMakeCase("damaged_fields");
    tcase_add_test(testCase, each_damaged_field_of_a_scene_is_named);
    tcase_add_test(testCase, each_damaged_field_of_a_broadphase_is_named);
    tcase_add_test(testCase, what_names_no_device_and_no_numbers_is_refused);
    tcase_add_test(testCase, a_detection_without_a_result_is_read_and_what_follows_it_is_named);
    tcase_add_test(testCase, a_scene_with_other_bodies_refuses_a_recorded_one);
    tcase_add_test(testCase, each_kind_of_operation_has_a_name_of_its_own);
    tcase_add_loop_test(testCase, a_record_that_is_longer_or_shorter_is_refused, 0, 3);
    tcase_add_loop_test(testCase, each_failed_allocation_of_the_reader_is_a_status_and_leaks_nothing, 0, 3);
    return qcRunCase("damaged_fields", testCase);
}
