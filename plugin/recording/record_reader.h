// Reads the records of a file one by one and checks their hashes. Nothing in a file is trusted: memory grows with what
// has been read, not with what a number in the file announces.
#ifndef QC_RECORDING_RECORD_READER_H
#define QC_RECORDING_RECORD_READER_H

#include "base/memory.h"
#include "recording/format.h"

#include <stdio.h>

typedef struct qcRecord
{
    qcRecordHead head;
    uint64_t byteOffset; ///< of the head in the file
    qcArray data;        ///< of bytes: the head, then the data, aligned to 16
} qcRecord;

typedef struct qcRecordReader
{
    FILE* file;
    qcArray path; ///< for messages
    uint64_t recordCount, byteCount;
    qcFileHeader header;
} qcRecordReader;

/// Opens the file and checks its header. qc_statusFile: the message names what is wrong.
qcStatus qcRecordReader_Open(qcRecordReader* reader, const char* path);
/// Reads the next record over `record`. *atEnd: there is none, and nothing is read. qc_statusFile: the record is
/// damaged, or the file ends within it; the message is the reason without the place.
qcStatus qcRecordReader_Next(qcRecordReader* reader, qcRecord* record, bool* atEnd);
/// False: there are bytes behind the records that were read.
bool qcRecordReader_IsAtEnd(qcRecordReader* reader);
void qcRecordReader_Close(qcRecordReader* reader);

#endif
