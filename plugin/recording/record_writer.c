// Records are put together in a buffer, which is written when it is large, and before each detection.
#include "recording/record_writer.h"

#include "base/memory.h"
#include "base/status.h"
#include "recording/format.h"
#include "quickcullide/hash.h"

#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum
{
    // Bytes: a write of this size costs more than the system call around it.
    qc_flushSize = 1 << 16
};

//  ---- bytes -------------------------------------------------------------------------------------------------------

void* qcBytes_Extend(qcBytes* bytes, size_t size)
{
    if (size > SIZE_MAX / 4 - bytes->count)
        return NULL;
    if (bytes->count + size > bytes->capacity)
    {
        size_t capacity = 2 * (bytes->count + size) + 64;
        unsigned char* data = qcAllocate(capacity);
        if (data == NULL)
            return NULL;
        if (bytes->count != 0)
            memcpy(data, bytes->data, bytes->count);
        qcFree(bytes->data, bytes->capacity);
        bytes->data = data;
        bytes->capacity = capacity;
    }
    bytes->count += size;
    return bytes->data + bytes->count - size;
}

void qcBytes_Free(qcBytes* bytes)
{
    qcFree(bytes->data, bytes->capacity);
    *bytes = (qcBytes){0};
}

//  ---- the file ----------------------------------------------------------------------------------------------------

static void CloseFile(qcRecordWriter* writer)
{
    if (writer->file != NULL)
        fclose(writer->file);
    writer->file = NULL;
    qcBytes_Free(&writer->buffer);
}

void qcRecordWriter_Stop(qcRecordWriter* writer, qcStatus status, const char* format, ...)
{
    if (writer->file == NULL)
        return;
    va_list arguments;
    va_start(arguments, format);
    int length = snprintf(writer->message, sizeof writer->message, "the recording %s stopped: ", writer->path.data);
    if (length > 0 && (size_t)length < sizeof writer->message)
        vsnprintf(writer->message + length, sizeof writer->message - (size_t)length, format, arguments);
    va_end(arguments);
    writer->status = status;
    CloseFile(writer);
    qcLog("%s", writer->message);
}

void qcRecordWriter_Flush(qcRecordWriter* writer)
{
    size_t size = writer->recordStart;
    if (writer->file == NULL || size == 0)
        return;
    // A child of fork() has the same file: what both write would be mixed.
    if ((long)getpid() != writer->process)
    {
        CloseFile(writer);
        return;
    }
    if (fwrite(writer->buffer.data, 1, size, writer->file) != size)
    {
        qcRecordWriter_Stop(writer, qc_statusFile, "behind byte %llu: %s", (unsigned long long)writer->byteCount,
                            strerror(errno));
        return;
    }
    writer->byteCount += size;
    writer->buffer.count = writer->recordStart = 0;
}

static qcStatus OpenFile(qcRecordWriter* writer, const char* path, bool* exists)
{
    writer->file = fopen(path, exists != NULL ? "wbxe" : "wbe");
    if (writer->file == NULL)
    {
        if (exists != NULL)
            *exists = errno == EEXIST;
        return qcFail(qc_statusFile, "the recording %s can't be created: %s", path, strerror(errno));
    }
    // The writer has a buffer of its own.
    setvbuf(writer->file, NULL, _IONBF, 0);
    writer->process = (long)getpid();
    size_t length = strlen(path) + 1;
    void *copy = qcBytes_Extend(&writer->path, length), *header = qcBytes_Extend(&writer->buffer, sizeof(qcFileHeader));
    if (copy == NULL || header == NULL)
        return qcFailMemory(length + sizeof(qcFileHeader), "a recording");
    memcpy(copy, path, length);
    qcFileHeader bytes = {
        .magic = QC_RECORDING_MAGIC, .formatVersion = qc_recordingVersion, .libraryVersion = qcVersion()};
    bytes.hash = qcXxh64(&bytes, offsetof(qcFileHeader, hash), 0);
    memcpy(header, &bytes, sizeof bytes);
    writer->recordStart = writer->buffer.count;
    return qc_statusOk;
}

qcStatus qcRecordWriter_Open(qcRecordWriter* writer, const char* path, bool* exists)
{
    *writer = (qcRecordWriter){0};
    if (__BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__)
        return qcFail(qc_statusFile, "recordings need a little-endian machine");
    qcStatus status = OpenFile(writer, path, exists);
    if (status != qc_statusOk)
    {
        CloseFile(writer);
        qcBytes_Free(&writer->path);
    }
    return status;
}

bool qcRecordWriter_OpenFromEnvironment(qcRecordWriter* writer)
{
    const char* prefix = getenv("QC_RECORD");
    if (prefix == NULL || prefix[0] == 0)
        return false;
    char path[4096];
    bool exists = true;
    for (uint32_t number = 1; exists; number++)
    {
        int length = snprintf(path, sizeof path, "%s.%u.qcr", prefix, number);
        exists = false;
        if (length < 0 || (size_t)length >= sizeof path)
            qcFail(qc_statusFile, "QC_RECORD is longer than a path may be");
        else if (qcRecordWriter_Open(writer, path, &exists) == qc_statusOk)
            return true;
    }
    if (qcHasLog())
        qcLog("%s", qcLastMessage());
    else
        fprintf(stderr, "quickcullide: %s\n", qcLastMessage());
    return false;
}

qcStatus qcRecordWriter_Close(qcRecordWriter* writer)
{
    qcRecordWriter_Flush(writer);
    // Some file systems report a full disk here only.
    if (writer->file != NULL && (long)getpid() == writer->process)
    {
        FILE* file = writer->file;
        writer->file = NULL;
        if (fclose(file) != 0)
        {
            writer->status = qc_statusFile;
            snprintf(writer->message, sizeof writer->message, "the recording %s can't be closed: %s", writer->path.data,
                     strerror(errno));
            qcLog("%s", writer->message);
        }
    }
    CloseFile(writer);
    qcBytes_Free(&writer->path);
    return writer->status == qc_statusOk ? qc_statusOk : qcFail(writer->status, "%s", writer->message);
}

//  ---- records -----------------------------------------------------------------------------------------------------

void* qcRecordWriter_Extend(qcRecordWriter* writer, size_t size)
{
    if (writer->file == NULL)
        return NULL;
    void* room = qcBytes_Extend(&writer->buffer, size);
    if (room == NULL)
        qcRecordWriter_Stop(writer, qc_statusOutOfMemory, "out of memory: %zu bytes for a record", size);
    return room;
}

void qcRecordWriter_Put(qcRecordWriter* writer, const void* data, size_t size)
{
    void* room = size != 0 ? qcRecordWriter_Extend(writer, size) : NULL;
    if (room != NULL)
        memcpy(room, data, size);
}

void qcRecordWriter_Pad(qcRecordWriter* writer)
{
    static const char zeros[8];
    qcRecordWriter_Put(writer, zeros, (8 - (writer->buffer.count - writer->recordStart) % 8) % 8);
}

void qcRecordWriter_Begin(qcRecordWriter* writer, uint32_t kind, uint32_t slot)
{
    const qcRecordHead head = {kind, slot, 0};
    qcRecordWriter_Put(writer, &head, sizeof head);
}

void qcRecordWriter_End(qcRecordWriter* writer)
{
    qcRecordWriter_Pad(writer);
    if (writer->file == NULL)
        return;
    unsigned char* record = writer->buffer.data + writer->recordStart;
    size_t size = writer->buffer.count - writer->recordStart;
    uint64_t dataSize = size - sizeof(qcRecordHead);
    memcpy(record + offsetof(qcRecordHead, size), &dataSize, sizeof dataSize);
    uint64_t hash = qcXxh64(record, size, writer->recordCount);
    qcRecordWriter_Put(writer, &hash, sizeof hash);
    if (writer->file == NULL)
        return;
    writer->recordCount++;
    writer->recordStart = writer->buffer.count;
    if (writer->recordStart >= qc_flushSize)
        qcRecordWriter_Flush(writer);
}
