// The data of a record, taken piece by piece.
#ifndef QC_RECORDING_RECORD_DATA_H
#define QC_RECORDING_RECORD_DATA_H

#include "recording/record_reader.h"

/// What is left of a record's data.
typedef struct qcRecordData
{
    const char* at;
    uint64_t left;
} qcRecordData;

qcRecordData qcRecordData_Of(const qcRecord* record);
/// The next bytes; the zeros that pad them are skipped. Null, with a message, if there are fewer.
const void* qcRecordData_Take(qcRecordData* data, uint64_t size);
/// Copies the next bytes. qc_statusFile: there are fewer.
qcStatus qcRecordData_TakeInto(qcRecordData* data, void* to, size_t size);
/// qc_statusFile: something is left.
qcStatus qcRecordData_CheckDone(const qcRecordData* data);
/// A record that is nothing but these bytes.
qcStatus qcRecord_TakeAll(const qcRecord* record, void* to, size_t size);

#endif
