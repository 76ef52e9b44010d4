// A recording as bytes, to be damaged: see plugin/docs/recording.md for the layout.
#ifndef QC_TESTS_RECORDING_RECORDED_BYTES_H
#define QC_TESTS_RECORDING_RECORDED_BYTES_H

#include "quickcullide/hash.h"
#include "quickcullide/recording.h"
#include "recording/format.h"
#include "support/check_ok.h"
#include "support/write_bytes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Bytes
{
    unsigned char* data;
    size_t size;
} Bytes;

static inline Bytes Bytes_Read(const char* path)
{
    FILE* file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    fseek(file, 0, SEEK_END);
    Bytes bytes = {NULL, (size_t)ftell(file)};
    rewind(file);
    bytes.data = malloc(bytes.size);
    ck_assert_ptr_nonnull(bytes.data);
    ck_assert_uint_eq(fread(bytes.data, 1, bytes.size, file), bytes.size);
    fclose(file);
    return bytes;
}

/// Corrects the hashes of all records, up to one that reaches beyond the end.
static inline void Bytes_Rehash(Bytes bytes)
{
    size_t at = sizeof(qcFileHeader);
    for (uint64_t number = 0; at + sizeof(qcRecordHead) + sizeof(uint64_t) <= bytes.size; number++)
    {
        qcRecordHead head;
        memcpy(&head, bytes.data + at, sizeof head);
        if (head.size > bytes.size - at - sizeof head - sizeof(uint64_t))
            return;
        size_t hashed = sizeof head + (size_t)head.size;
        uint64_t hash = qcXxh64(bytes.data + at, hashed, number);
        memcpy(bytes.data + at + hashed, &hash, sizeof hash);
        at += hashed + sizeof hash;
    }
}

/// The head of a record, counted from 0, and its first byte; kind 0: there are fewer.
static inline qcRecordHead Bytes_FindRecord(Bytes bytes, uint32_t number, size_t* at)
{
    qcRecordHead head = {0};
    *at = sizeof(qcFileHeader);
    for (uint32_t i = 0; *at < bytes.size; i++)
    {
        memcpy(&head, bytes.data + *at, sizeof head);
        if (i == number)
            return head;
        *at += sizeof head + (size_t)head.size + sizeof(uint64_t);
    }
    return (qcRecordHead){0};
}

/// Reads a file to its end. Returns the number of operations; the status is that of the call that failed.
static inline uint64_t CountOperations(const char* path, qcStatus* status)
{
    qcRecording* recording = NULL;
    const qcOperation* operation;
    uint64_t count = 0;
    *status = qcRecording_Open(path, &recording);
    while (*status == qc_statusOk)
    {
        *status = qcRecording_Next(recording, &operation);
        if (*status == qc_statusOk && operation->kind == qc_operationEnd)
            break;
        count += *status == qc_statusOk;
    }
    qcRecording_Close(recording);
    return count;
}

#endif
