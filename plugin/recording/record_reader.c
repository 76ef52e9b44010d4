// A head whose size is damaged would lead anywhere, so the data is read in pieces, and the hash decides.
#include "recording/record_reader.h"

#include "base/status.h"
#include "quickcullide/hash.h"

#include <errno.h>
#include <string.h>

enum
{
    // Bytes read at once into memory that grows.
    qc_pieceSize = 1 << 20
};

/// Reads `size` bytes. qc_statusFile: there are fewer.
static qcStatus Read(qcRecordReader* reader, void* data, size_t size)
{
    size_t count = fread(data, 1, size, reader->file);
    reader->byteCount += count;
    if (count == size)
        return qc_statusOk;
    if (ferror(reader->file))
        return qcFail(qc_statusFile, "it can't be read: %s", strerror(errno));
    return qcFail(qc_statusFile, "the file ends within it, at byte %llu", (unsigned long long)reader->byteCount);
}

static qcStatus ReadHeader(qcRecordReader* reader, const char* path)
{
    qcFileHeader* header = &reader->header;
    size_t size = fread(header, 1, sizeof *header, reader->file);
    reader->byteCount = size;
    if (ferror(reader->file))
        return qcFail(qc_statusFile, "%s can't be read: %s", path, strerror(errno));
    if (size < sizeof header->magic || memcmp(header->magic, QC_RECORDING_MAGIC, sizeof header->magic) != 0)
        return qcFail(qc_statusFile, "%s is no recording", path);
    if (size < sizeof *header)
        return qcFail(qc_statusFile, "%s: the file ends within its header, at byte %zu", path, size);
    if (header->hash != qcXxh64(header, offsetof(qcFileHeader, hash), 0))
        return qcFail(qc_statusFile, "%s: the header, bytes 0 to 23, is damaged", path);
    if (header->formatVersion != qc_recordingVersion)
        return qcFail(qc_statusFile, "%s: the format is version %u; this library (%d.%d.%d) reads version %d", path,
                      header->formatVersion, QC_VERSION_MAJOR, QC_VERSION_MINOR, QC_VERSION_PATCH, qc_recordingVersion);
    return qc_statusOk;
}

qcStatus qcRecordReader_Open(qcRecordReader* reader, const char* path)
{
    *reader = (qcRecordReader){0};
    if (__BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__)
        return qcFail(qc_statusFile, "recordings need a little-endian machine");
    reader->file = fopen(path, "rbe");
    if (reader->file == NULL)
        return qcFail(qc_statusFile, "%s can't be opened: %s", path, strerror(errno));
    qcStatus status = qcArray_Resize(&reader->path, strlen(path) + 1, 1, "a path");
    if (status == qc_statusOk)
    {
        memcpy(reader->path.data, path, reader->path.count);
        status = ReadHeader(reader, path);
    }
    if (status != qc_statusOk)
        qcRecordReader_Close(reader);
    return status;
}

qcStatus qcRecordReader_Next(qcRecordReader* reader, qcRecord* record, bool* atEnd)
{
    record->byteOffset = reader->byteCount;
    record->data.count = 0;
    int first = getc(reader->file);
    *atEnd = first == EOF && !ferror(reader->file);
    if (*atEnd)
        return qc_statusOk;
    ungetc(first, reader->file);
    qcRecordHead* head = &record->head;
    QC_TRY(Read(reader, head, sizeof *head));
    // The head lies before the data, so that both are hashed at once.
    QC_TRY(qcArray_Resize(&record->data, sizeof *head, 1, "a record"));
    memcpy(record->data.data, head, sizeof *head);
    for (uint64_t left = head->size; left > 0;)
    {
        size_t piece = left < qc_pieceSize ? (size_t)left : qc_pieceSize, before = record->data.count;
        QC_TRY(qcArray_Resize(&record->data, before + piece, 1, "a record"));
        QC_TRY(Read(reader, (char*)record->data.data + before, piece));
        left -= piece;
    }
    uint64_t hash;
    QC_TRY(Read(reader, &hash, sizeof hash));
    if (hash != qcXxh64(record->data.data, record->data.count, reader->recordCount))
        return qcFail(qc_statusFile, "it is damaged: its hash differs");
    reader->recordCount++;
    return qc_statusOk;
}

bool qcRecordReader_IsAtEnd(qcRecordReader* reader)
{
    int next = getc(reader->file);
    if (next != EOF)
        ungetc(next, reader->file);
    return next == EOF;
}

void qcRecordReader_Close(qcRecordReader* reader)
{
    if (reader->file != NULL)
        fclose(reader->file);
    qcArray_Free(&reader->path);
    *reader = (qcRecordReader){0};
}
