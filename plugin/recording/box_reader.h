// Records of a broadphase become operations. Whether a box is there is left to the replay, whose ids they are.
#ifndef QC_RECORDING_BOX_READER_H
#define QC_RECORDING_BOX_READER_H

#include "quickcullide/recording.h"
#include "recording/record_data.h"

typedef struct qcBoxReader
{
    uint32_t scalarSize; ///< 4 or 8; 0: the recording is none of a broadphase
    uint32_t id;
    qcArray numbers; ///< of doubles: bounds and lambdas of the operation
} qcBoxReader;

/// Reads the first record of a recording of a broadphase.
qcStatus qcBoxReader_Open(qcBoxReader* reader, const qcRecord* record);
/// The operation's arrays are valid until the next call, and as long as the record.
qcStatus qcBoxReader_Read(qcBoxReader* reader, const qcRecord* record, qcBoxOperation* operation);
void qcBoxReader_Free(qcBoxReader* reader);

#endif
