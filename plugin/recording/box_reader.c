// Numbers of either size are handed out as doubles.
#include "recording/box_reader.h"

#include "base/status.h"

#include <string.h>

qcStatus qcBoxReader_Open(qcBoxReader* reader, const qcRecord* record)
{
    uint32_t words[2];
    QC_TRY(qcRecord_TakeAll(record, words, sizeof words));
    if (words[0] != sizeof(float) && words[0] != sizeof(double))
        return qcFail(qc_statusFile, "its numbers have %u bytes", words[0]);
    reader->scalarSize = words[0];
    return qc_statusOk;
}

/// The next numbers, behind those that reader->numbers has.
static qcStatus TakeNumbers(qcBoxReader* reader, qcRecordData* data, uint64_t count)
{
    const char* from = qcRecordData_Take(data, reader->scalarSize * count);
    if (from == NULL)
        return qc_statusFile;
    size_t before = reader->numbers.count;
    QC_TRY(qcArray_Resize(&reader->numbers, before + count, sizeof(double), "recorded numbers"));
    double* numbers = &QC_AT(double, reader->numbers, before);
    for (size_t i = 0; i < count; i++)
    {
        float single;
        if (reader->scalarSize == sizeof single)
        {
            memcpy(&single, from + sizeof single * i, sizeof single);
            numbers[i] = (double)single;
        }
        else
            memcpy(&numbers[i], from + sizeof(double) * i, sizeof(double));
    }
    return qc_statusOk;
}

static qcStatus TakeIds(qcRecordData* data, qcBoxOperation* operation)
{
    qcBoxesRecord record;
    QC_TRY(qcRecordData_TakeInto(data, &record, sizeof record));
    operation->count = record.count;
    operation->isDisturbed = record.isDisturbed != 0;
    operation->ids = qcRecordData_Take(data, sizeof(uint32_t) * (uint64_t)record.count);
    return operation->ids != NULL ? qc_statusOk : qc_statusFile;
}

static qcStatus ReadMoves(qcBoxReader* reader, qcRecordData* data, qcBoxOperation* operation)
{
    QC_TRY(TakeIds(data, operation));
    QC_TRY(TakeNumbers(reader, data, 6 * (uint64_t)operation->count));
    operation->bounds = reader->numbers.data;
    return qc_statusOk;
}

static qcStatus ReadPairs(qcRecordData* data, qcBoxOperation* operation)
{
    qcPairsRecord record;
    QC_TRY(qcRecordData_TakeInto(data, &record, sizeof record));
    operation->hasCallback = record.hasCallback != 0;
    operation->isDisturbed = record.isDisturbed != 0;
    operation->pairCount = record.pairCount;
    operation->pairHash = record.pairHash;
    operation->rejectedCount = (size_t)(data->left / sizeof(qcBoxPair));
    operation->rejected = qcRecordData_Take(data, data->left);
    return qc_statusOk;
}

static qcStatus ReadQuery(qcBoxReader* reader, qcRecordData* data, qcBoxOperation* operation)
{
    QC_TRY(TakeIds(data, operation));
    QC_TRY(TakeNumbers(reader, data, 6));
    operation->bounds = reader->numbers.data;
    return qc_statusOk;
}

static qcStatus ReadCast(qcBoxReader* reader, qcRecordData* data, qcBoxOperation* operation)
{
    enum
    {
        numbers = sizeof operation->cast / sizeof(double)
    };
    QC_TRY(TakeIds(data, operation));
    QC_TRY(TakeNumbers(reader, data, numbers));
    QC_TRY(TakeNumbers(reader, data, operation->count));
    memcpy(&operation->cast, reader->numbers.data, sizeof operation->cast);
    operation->lambdas = (const double*)reader->numbers.data + numbers;
    return qc_statusOk;
}

/// A new box, or another filter.
static qcStatus ReadBox(qcBoxReader* reader, qcRecordData* data, bool isNew, qcBoxOperation* operation)
{
    qcBoxRecord record;
    QC_TRY(qcRecordData_TakeInto(data, &record, sizeof record));
    operation->group = record.group;
    operation->mask = record.mask;
    if (!isNew)
        return qc_statusOk;
    QC_TRY(TakeNumbers(reader, data, 6));
    operation->bounds = reader->numbers.data;
    return qc_statusOk;
}

qcStatus qcBoxReader_Read(qcBoxReader* reader, const qcRecord* record, qcBoxOperation* operation)
{
    qcRecordData data = qcRecordData_Of(record);
    reader->numbers.count = 0;
    reader->id = record->head.slot;
    operation->ids = &reader->id;
    operation->count = 1;
    switch (record->head.kind)
    {
        case qc_operationAddBox: QC_TRY(ReadBox(reader, &data, true, operation)); break;
        case qc_operationSetBoxFilter: QC_TRY(ReadBox(reader, &data, false, operation)); break;
        case qc_operationMoveBoxes: QC_TRY(ReadMoves(reader, &data, operation)); break;
        case qc_operationFindPairs: QC_TRY(ReadPairs(&data, operation)); break;
        case qc_operationQueryBox: QC_TRY(ReadQuery(reader, &data, operation)); break;
        case qc_operationCastBox: QC_TRY(ReadCast(reader, &data, operation)); break;
        default: break; // remove, reset: no data
    }
    return qcRecordData_CheckDone(&data);
}

void qcBoxReader_Free(qcBoxReader* reader)
{
    qcArray_Free(&reader->numbers);
}
