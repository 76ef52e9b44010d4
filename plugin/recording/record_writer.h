// Writes the records of a file. A failure ends the writing, and nothing else: no function here reports through
// qcLastMessage but Open and Close, since the call that is recorded has succeeded.
#ifndef QC_RECORDING_RECORD_WRITER_H
#define QC_RECORDING_RECORD_WRITER_H

#include "quickcullide/base.h"

#include <stdio.h>

/// Bytes that grow without a message: a block of the counted heap.
typedef struct qcBytes
{
    unsigned char* data;
    size_t count, capacity;
} qcBytes;

/// Appends `size` bytes, not cleared. Null: out of memory, nothing has changed.
void* qcBytes_Extend(qcBytes* bytes, size_t size);
void qcBytes_Free(qcBytes* bytes);

typedef struct qcRecordWriter
{
    FILE* file; ///< null: nothing is written any more
    qcBytes path;
    qcBytes buffer;
    size_t recordStart; ///< of the open record in the buffer
    uint64_t recordCount;
    uint64_t byteCount; ///< written to the file
    long process;       ///< that opened the file
    qcStatus status;    ///< why writing has stopped; qc_statusOk: it has not
    char message[400];
} qcRecordWriter;

/// Creates the file and writes its header. Replaces an old file, or fails if there is one: *exists (may be null, which
/// means to replace) is then set.
qcStatus qcRecordWriter_Open(qcRecordWriter* writer, const char* path, bool* exists);
void qcRecordWriter_Begin(qcRecordWriter* writer, uint32_t kind, uint32_t slot);
void qcRecordWriter_Put(qcRecordWriter* writer, const void* data, size_t size);
/// Room for `size` bytes, to be filled before the next call. Null: writing has stopped.
void* qcRecordWriter_Extend(qcRecordWriter* writer, size_t size);
/// Zeros up to a multiple of 8 bytes.
void qcRecordWriter_Pad(qcRecordWriter* writer);
void qcRecordWriter_End(qcRecordWriter* writer);
/// Hands complete records to the operating system: they survive a crash of the program.
void qcRecordWriter_Flush(qcRecordWriter* writer);
/// Writing stops, with a line in the log.
__attribute__((format(printf, 3, 4))) void qcRecordWriter_Stop(qcRecordWriter* writer, qcStatus status,
                                                               const char* format, ...);
/// Closes the file and frees everything. The status of the first failure, with its message.
qcStatus qcRecordWriter_Close(qcRecordWriter* writer);

#endif
