// Recordings: any bytes are read to their end, or fail with a message; so are the same bytes with the right hashes, so
// that the mutations of a recording reach what lies behind them. All operations are applied to a scene, or written as
// those of a broadphase, and recorded again: the copy reports the same.
#define _GNU_SOURCE
#include "fuzz/fuzz.h"

#include <quickcullide/hash.h>
#include <quickcullide/recording.h>

#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum
{
    qc_headerBytes = 16, ///< before its hash
    qc_headBytes = 16,   ///< of a record, before its data
    qc_hashBytes = 8,
    qc_maxOperations = 200
};

/// Writes the hashes that the records should have.
static void Repair(uint8_t* file, size_t size)
{
    if (size < qc_headerBytes + qc_hashBytes)
        return;
    uint64_t hash = qcXxh64(file, qc_headerBytes, 0);
    memcpy(file + qc_headerBytes, &hash, sizeof hash);
    size_t at = qc_headerBytes + qc_hashBytes;
    for (uint64_t record = 0; size - at >= qc_headBytes + qc_hashBytes; record++)
    {
        uint64_t dataBytes;
        memcpy(&dataBytes, file + at + 8, sizeof dataBytes);
        if (dataBytes > size - at - qc_headBytes - qc_hashBytes)
            return;
        size_t hashed = qc_headBytes + (size_t)dataBytes;
        hash = qcXxh64(file + at, hashed, record);
        memcpy(file + at + hashed, &hash, sizeof hash);
        at += hashed + qc_hashBytes;
    }
}

//  ---- files in memory ---------------------------------------------------------------------------------------------

typedef struct File
{
    int descriptor;
    char path[64]; ///< under which others open it
} File;

static File File_Create(const uint8_t* data, size_t size)
{
    File file = {.descriptor = memfd_create("recording", 0)};
    FUZZ_CHECK(file.descriptor >= 0 && write(file.descriptor, data, size) == (ssize_t)size);
    snprintf(file.path, sizeof file.path, "/proc/self/fd/%d", file.descriptor);
    return file;
}

static qcScene* MakeScene(void)
{
    qcSceneDef def = qcDefaultSceneDef();
    qcScene* scene;
    FUZZ_CHECK(qcScene_Create(&def, &scene) == qc_statusOk);
    return scene;
}

//  ---- scenes ------------------------------------------------------------------------------------------------------

/// What both scenes report for their bodies as they are.
static void CheckSameScenes(qcScene* a, qcScene* b)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.maxPairs = 100000;
    const qcResult* result = NULL;
    qcStatus status = qcScene_Detect(a, &def, &result);
    qcResultHash hash = status == qc_statusOk ? qcResult_Hash(result) : (qcResultHash){0};
    FUZZ_CHECK(qcScene_Detect(b, &def, &result) == status);
    qcResultHash other = status == qc_statusOk ? qcResult_Hash(result) : (qcResultHash){0};
    FUZZ_CHECK(memcmp(&hash, &other, sizeof hash) == 0);
}

/// The copy is whole, each of its operations succeeds in a new scene, and its detections report what was recorded.
static void ReplayCopy(const char* path, qcScene* original)
{
    qcRecording* recording = NULL;
    const qcOperation* operation;
    qcScene* scene = MakeScene();
    FUZZ_CHECK(qcRecording_Open(path, &recording) == qc_statusOk);
    for (;;)
    {
        FUZZ_CHECK(qcRecording_Next(recording, &operation) == qc_statusOk);
        if (operation->kind == qc_operationEnd)
            break;
        const qcResult* result = NULL;
        qcStatus status = qcOperation_Apply(operation, scene, &result);
        if (operation->kind != qc_operationDetect)
        {
            FUZZ_CHECK(status == qc_statusOk);
            continue;
        }
        FUZZ_CHECK(operation->hasResult && status == operation->resultStatus);
        qcResultHash hash = status == qc_statusOk ? qcResult_Hash(result) : operation->resultHash;
        FUZZ_CHECK(memcmp(&hash, &operation->resultHash, sizeof hash) == 0);
    }
    FUZZ_CHECK(operation->isComplete);
    CheckSameScenes(original, scene);
    qcScene_Destroy(scene);
    qcRecording_Close(recording);
}

/// False: no further operation can be read, or there is none.
static bool Next(qcRecording* recording, uint64_t number, const qcOperation** operation)
{
    qcStatus status = qcRecording_Next(recording, operation);
    if (status != qc_statusOk)
    {
        FUZZ_CHECK(status == qc_statusFile && qcLastMessage()[0] != '\0');
        // No further one can be read.
        FUZZ_CHECK(qcRecording_Next(recording, operation) == qc_statusFile);
        return false;
    }
    FUZZ_CHECK((*operation)->number <= number);
    FUZZ_CHECK(strlen(qcOperationKind_Name((*operation)->kind)) > 0);
    return (*operation)->kind != qc_operationEnd;
}

/// Applies operations to a scene that is itself recorded, from one of them on.
static void ReplayScene(qcRecording* recording, uint64_t recordFrom)
{
    qcScene* scene = MakeScene();
    File copy = File_Create(NULL, 0);
    const qcOperation* operation;
    for (uint64_t i = 0; i < qc_maxOperations && Next(recording, i, &operation); i++)
    {
        if (i == recordFrom)
            FUZZ_CHECK(qcScene_Record(scene, copy.path) == qc_statusOk);
        const qcResult* result = NULL;
        qcStatus status = qcOperation_Apply(operation, scene, &result);
        FUZZ_CHECK(status != qc_statusOk || operation->kind != qc_operationDetect || result != NULL);
    }
    FUZZ_CHECK(qcScene_Record(scene, NULL) == qc_statusOk);
    if (lseek(copy.descriptor, 0, SEEK_END) > 0)
        ReplayCopy(copy.path, scene);
    close(copy.descriptor);
    qcScene_Destroy(scene);
}

//  ---- broadphases -------------------------------------------------------------------------------------------------

/// Calls the recorder as the broadphase did; returns the operations that this writes, moves left out: they are joined.
static uint64_t WriteBoxes(qcBoxRecorder* recorder, const qcOperation* operation)
{
    const qcBoxOperation* boxes = &operation->boxes;
    switch (operation->kind)
    {
        case qc_operationAddBox:
            qcBoxRecorder_Add(recorder, boxes->ids[0], boxes->bounds, boxes->group, boxes->mask);
            break;
        case qc_operationRemoveBox: qcBoxRecorder_Remove(recorder, boxes->ids[0]); break;
        case qc_operationMoveBoxes:
            for (uint32_t i = 0; i < boxes->count; i++)
                qcBoxRecorder_Move(recorder, boxes->ids[i], boxes->bounds + 6 * (size_t)i);
            return 0;
        case qc_operationSetBoxFilter:
            qcBoxRecorder_SetFilter(recorder, boxes->ids[0], boxes->group, boxes->mask);
            break;
        case qc_operationResetBoxes: qcBoxRecorder_Reset(recorder); break;
        default:
            qcBoxRecorder_Begin(recorder);
            if (operation->kind == qc_operationFindPairs)
                qcBoxRecorder_EndPairs(recorder, boxes->rejected, boxes->rejectedCount, boxes->hasCallback,
                                       boxes->rejected, boxes->rejectedCount);
            else if (operation->kind == qc_operationQueryBox)
                qcBoxRecorder_EndQuery(recorder, boxes->bounds, boxes->ids, boxes->count);
            else
                qcBoxRecorder_EndCast(recorder, &boxes->cast, boxes->ids, boxes->lambdas, boxes->count);
    }
    return 1;
}

/// Reads operations and writes them to a copy, which has as many.
static void ReplayBoxes(qcRecording* recording, uint32_t scalarSize)
{
    File copy = File_Create(NULL, 0);
    qcBoxRecorder* recorder = NULL;
    const qcOperation* operation;
    FUZZ_CHECK(qcBoxRecorder_Open(copy.path, scalarSize, &recorder) == qc_statusOk);
    uint64_t written = 0, read = 0;
    for (uint64_t i = 0; i < qc_maxOperations && Next(recording, i, &operation); i++)
        written += WriteBoxes(recorder, operation);
    FUZZ_CHECK(qcBoxRecorder_Close(recorder) == qc_statusOk);
    qcRecording* again = NULL;
    FUZZ_CHECK(qcRecording_Open(copy.path, &again) == qc_statusOk);
    FUZZ_CHECK(qcRecording_GetInfo(again).boxScalarSize == scalarSize);
    while (Next(again, UINT64_MAX, &operation))
        read += operation->kind != qc_operationMoveBoxes;
    FUZZ_CHECK(operation->kind == qc_operationEnd && operation->isComplete && read == written);
    qcRecording_Close(again);
    close(copy.descriptor);
}

static void Read(const uint8_t* data, size_t size)
{
    File file = File_Create(data, size);
    qcRecording* recording = NULL;
    if (qcRecording_Open(file.path, &recording) == qc_statusOk)
    {
        uint32_t scalarSize = qcRecording_GetInfo(recording).boxScalarSize;
        // A small number that the input decides.
        if (scalarSize == 0)
            ReplayScene(recording, data[size - 1] % 8);
        else
            ReplayBoxes(recording, scalarSize);
        qcRecording_Close(recording);
    }
    else
        FUZZ_CHECK(qcLastMessage()[0] != '\0');
    close(file.descriptor);
}

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    Read(data, size);
    uint8_t* repaired = malloc(size > 0 ? size : 1);
    FUZZ_CHECK(repaired != NULL);
    if (size > 0)
        memcpy(repaired, data, size);
    Repair(repaired, size);
    Read(repaired, size);
    free(repaired);
    return 0;
}
