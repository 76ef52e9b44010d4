// Recordings: any bytes are read to their end, or fail with a message; so are the same bytes with the right hashes, so
// that the mutations of a recording reach what lies behind them. All operations are applied to a scene.
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

/// Applies operations until one fails or the recording ends.
static void Replay(qcRecording* recording, qcScene* scene)
{
    bool isOfBoxes = qcRecording_GetInfo(recording).boxScalarSize != 0;
    for (int i = 0; i < qc_maxOperations; i++)
    {
        const qcOperation* operation;
        qcStatus status = qcRecording_Next(recording, &operation);
        if (status != qc_statusOk)
        {
            FUZZ_CHECK(status == qc_statusFile && qcLastMessage()[0] != '\0');
            // No further one can be read.
            FUZZ_CHECK(qcRecording_Next(recording, &operation) == qc_statusFile);
            return;
        }
        FUZZ_CHECK(operation->number <= (uint64_t)i);
        FUZZ_CHECK(strlen(qcOperationKind_Name(operation->kind)) > 0);
        if (operation->kind == qc_operationEnd)
            return;
        if (isOfBoxes)
            continue;
        const qcResult* result = NULL;
        status = qcOperation_Apply(operation, scene, &result);
        FUZZ_CHECK(status != qc_statusOk || operation->kind != qc_operationDetect || result != NULL);
    }
}

static void Read(const uint8_t* data, size_t size)
{
    int file = memfd_create("recording", 0);
    FUZZ_CHECK(file >= 0 && write(file, data, size) == (ssize_t)size);
    char path[64];
    snprintf(path, sizeof path, "/proc/self/fd/%d", file);
    qcRecording* recording = NULL;
    if (qcRecording_Open(path, &recording) == qc_statusOk)
    {
        qcSceneDef def = qcDefaultSceneDef();
        qcScene* scene;
        FUZZ_CHECK(qcScene_Create(&def, &scene) == qc_statusOk);
        Replay(recording, scene);
        qcScene_Destroy(scene);
        qcRecording_Close(recording);
    }
    else
        FUZZ_CHECK(qcLastMessage()[0] != '\0');
    close(file);
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
