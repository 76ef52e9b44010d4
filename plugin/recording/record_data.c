// Sizes are compared with what is there before anything is read.
#include "recording/record_data.h"

#include "base/status.h"

#include <string.h>

qcRecordData qcRecordData_Of(const qcRecord* record)
{
    return (qcRecordData){(const char*)record->data.data + sizeof(qcRecordHead), record->head.size};
}

const void* qcRecordData_Take(qcRecordData* data, uint64_t size)
{
    uint64_t padded = size + (8 - size % 8) % 8;
    if (padded > data->left)
    {
        qcFail(qc_statusFile, "its data is too short");
        return NULL;
    }
    data->at += padded;
    data->left -= padded;
    return data->at - padded;
}

qcStatus qcRecordData_TakeInto(qcRecordData* data, void* to, size_t size)
{
    const void* from = qcRecordData_Take(data, size);
    if (from == NULL)
        return qc_statusFile;
    if (size != 0)
        memcpy(to, from, size);
    return qc_statusOk;
}

qcStatus qcRecordData_CheckDone(const qcRecordData* data)
{
    return data->left == 0 ? qc_statusOk : qcFail(qc_statusFile, "its data is too long");
}

qcStatus qcRecord_TakeAll(const qcRecord* record, void* to, size_t size)
{
    qcRecordData data = qcRecordData_Of(record);
    QC_TRY(qcRecordData_TakeInto(&data, to, size));
    return qcRecordData_CheckDone(&data);
}
