// The calls of a broadphase. Moves are collected: one record has all between two other operations.
#include "base/memory.h"
#include "base/status.h"
#include "quickcullide/recording.h"
#include "recording/format.h"
#include "recording/record_writer.h"
#include "quickcullide/hash.h"

#include <pthread.h>
#include <string.h>

struct qcBoxRecorder
{
    qcRecordWriter writer;
    pthread_mutex_t mutex;
    uint32_t scalarSize;
    uint32_t openCount;            ///< queries and searches that run
    bool isDisturbed;              ///< a box has changed meanwhile
    qcBytes movedIds, movedBounds; ///< moves that are not written yet
    qcBytes deferred;              ///< operations during a query: a head and data each
    qcBytes data;                  ///< of the operation that is put together
};

//  ---- data --------------------------------------------------------------------------------------------------------

static void Append(qcBoxRecorder* recorder, qcBytes* bytes, const void* data, size_t size)
{
    if (recorder->writer.file == NULL || size == 0)
        return;
    void* room = qcBytes_Extend(bytes, size);
    if (room != NULL)
        memcpy(room, data, size);
    else
        qcRecordWriter_Stop(&recorder->writer, qc_statusOutOfMemory, "out of memory: %zu bytes for a record", size);
}

static void Pad(qcBoxRecorder* recorder, qcBytes* bytes)
{
    static const char zeros[8];
    Append(recorder, bytes, zeros, (8 - bytes->count % 8) % 8);
}

/// Numbers in the broadphase's own type: it has made doubles of them.
static void AppendNumbers(qcBoxRecorder* recorder, qcBytes* bytes, const double* numbers, size_t count)
{
    if (recorder->scalarSize == sizeof(double))
    {
        Append(recorder, bytes, numbers, count * sizeof *numbers);
        return;
    }
    for (size_t i = 0; i < count; i++)
    {
        float number = (float)numbers[i];
        Append(recorder, bytes, &number, sizeof number);
    }
}

//  ---- records -----------------------------------------------------------------------------------------------------

static void WriteMoves(qcBoxRecorder* recorder)
{
    qcRecordWriter* writer = &recorder->writer;
    const qcBoxesRecord record = {(uint32_t)(recorder->movedIds.count / sizeof(uint32_t)), 0};
    if (record.count == 0)
        return;
    qcRecordWriter_Begin(writer, qc_operationMoveBoxes, 0);
    qcRecordWriter_Put(writer, &record, sizeof record);
    qcRecordWriter_Put(writer, recorder->movedIds.data, recorder->movedIds.count);
    qcRecordWriter_Pad(writer);
    qcRecordWriter_Put(writer, recorder->movedBounds.data, recorder->movedBounds.count);
    qcRecordWriter_End(writer);
    recorder->movedIds.count = recorder->movedBounds.count = 0;
}

/// Writes recorder->data as an operation, and empties it.
static void Write(qcBoxRecorder* recorder, uint32_t kind, uint32_t id)
{
    WriteMoves(recorder);
    qcRecordWriter_Begin(&recorder->writer, kind, id);
    qcRecordWriter_Put(&recorder->writer, recorder->data.data, recorder->data.count);
    qcRecordWriter_End(&recorder->writer);
    recorder->data.count = 0;
}

/// A change of the boxes: written now, or behind the query that runs.
static void Change(qcBoxRecorder* recorder, uint32_t kind, uint32_t id)
{
    if (recorder->openCount == 0)
    {
        Write(recorder, kind, id);
        return;
    }
    Pad(recorder, &recorder->data);
    const qcRecordHead head = {kind, id, recorder->data.count};
    Append(recorder, &recorder->deferred, &head, sizeof head);
    Append(recorder, &recorder->deferred, recorder->data.data, recorder->data.count);
    recorder->data.count = 0;
    recorder->isDisturbed = true;
}

/// A query or search ends: its record, then the changes during it.
static void End(qcBoxRecorder* recorder, uint32_t kind)
{
    Write(recorder, kind, 0);
    if (recorder->openCount == 0 || --recorder->openCount != 0)
        return;
    recorder->isDisturbed = false;
    for (size_t at = 0; at < recorder->deferred.count && recorder->writer.file != NULL;)
    {
        qcRecordHead head;
        memcpy(&head, recorder->deferred.data + at, sizeof head);
        qcRecordWriter_Begin(&recorder->writer, head.kind, head.slot);
        qcRecordWriter_Put(&recorder->writer, recorder->deferred.data + at + sizeof head, (size_t)head.size);
        qcRecordWriter_End(&recorder->writer);
        at += sizeof head + (size_t)head.size;
    }
    recorder->deferred.count = 0;
}

//  ---- the file ----------------------------------------------------------------------------------------------------

qcStatus qcBoxRecorder_Open(const char* path, uint32_t scalarSize, qcBoxRecorder** recorder)
{
    if (recorder == NULL || (scalarSize != sizeof(float) && scalarSize != sizeof(double)))
        return qcFail(qc_statusBadInput, "qcBoxRecorder_Open: %s",
                      recorder == NULL ? "recorder is null" : "scalarSize is neither 4 nor 8");
    qcRecordWriter writer;
    *recorder = NULL;
    if (path != NULL)
        QC_TRY(qcRecordWriter_Open(&writer, path, NULL));
    else if (!qcRecordWriter_OpenFromEnvironment(&writer))
        return qc_statusOk;
    qcBoxRecorder* opened = qcAllocateZeroed(sizeof *opened);
    if (opened == NULL)
    {
        qcRecordWriter_Close(&writer);
        return qcFailMemory(sizeof *opened, "a recording");
    }
    opened->writer = writer;
    opened->scalarSize = scalarSize;
    pthread_mutex_init(&opened->mutex, NULL);
    const uint32_t words[2] = {scalarSize, 0};
    qcRecordWriter_Begin(&opened->writer, qc_recordBoxes, 0);
    qcRecordWriter_Put(&opened->writer, words, sizeof words);
    qcRecordWriter_End(&opened->writer);
    qcRecordWriter_Flush(&opened->writer);
    *recorder = opened;
    return qc_statusOk;
}

qcStatus qcBoxRecorder_Close(qcBoxRecorder* recorder)
{
    if (recorder == NULL)
        return qc_statusOk;
    recorder->data.count = 0;
    Write(recorder, qc_recordEnd, 0);
    qcStatus status = qcRecordWriter_Close(&recorder->writer);
    pthread_mutex_destroy(&recorder->mutex);
    qcBytes_Free(&recorder->movedIds);
    qcBytes_Free(&recorder->movedBounds);
    qcBytes_Free(&recorder->deferred);
    qcBytes_Free(&recorder->data);
    qcFree(recorder, sizeof *recorder);
    return status;
}

//  ---- changes -----------------------------------------------------------------------------------------------------

void qcBoxRecorder_Add(qcBoxRecorder* recorder, uint32_t id, const double bounds[6], uint32_t group, uint32_t mask)
{
    pthread_mutex_lock(&recorder->mutex);
    const qcBoxRecord record = {group, mask};
    Append(recorder, &recorder->data, &record, sizeof record);
    AppendNumbers(recorder, &recorder->data, bounds, 6);
    Change(recorder, qc_operationAddBox, id);
    pthread_mutex_unlock(&recorder->mutex);
}

void qcBoxRecorder_Remove(qcBoxRecorder* recorder, uint32_t id)
{
    pthread_mutex_lock(&recorder->mutex);
    Change(recorder, qc_operationRemoveBox, id);
    pthread_mutex_unlock(&recorder->mutex);
}

void qcBoxRecorder_Move(qcBoxRecorder* recorder, uint32_t id, const double bounds[6])
{
    pthread_mutex_lock(&recorder->mutex);
    if (recorder->openCount == 0)
    {
        Append(recorder, &recorder->movedIds, &id, sizeof id);
        AppendNumbers(recorder, &recorder->movedBounds, bounds, 6);
    }
    else
    {
        const qcBoxesRecord record = {1, 0};
        const uint32_t ids[2] = {id, 0};
        Append(recorder, &recorder->data, &record, sizeof record);
        Append(recorder, &recorder->data, ids, sizeof ids);
        AppendNumbers(recorder, &recorder->data, bounds, 6);
        Change(recorder, qc_operationMoveBoxes, 0);
    }
    pthread_mutex_unlock(&recorder->mutex);
}

void qcBoxRecorder_SetFilter(qcBoxRecorder* recorder, uint32_t id, uint32_t group, uint32_t mask)
{
    pthread_mutex_lock(&recorder->mutex);
    const qcBoxRecord record = {group, mask};
    Append(recorder, &recorder->data, &record, sizeof record);
    Write(recorder, qc_operationSetBoxFilter, id);
    pthread_mutex_unlock(&recorder->mutex);
}

void qcBoxRecorder_Reset(qcBoxRecorder* recorder)
{
    pthread_mutex_lock(&recorder->mutex);
    Change(recorder, qc_operationResetBoxes, 0);
    pthread_mutex_unlock(&recorder->mutex);
}

//  ---- queries -----------------------------------------------------------------------------------------------------

void qcBoxRecorder_Begin(qcBoxRecorder* recorder)
{
    pthread_mutex_lock(&recorder->mutex);
    recorder->openCount++;
    pthread_mutex_unlock(&recorder->mutex);
}

uint64_t qcBoxPairs_Hash(const qcBoxPair* pairs, size_t count)
{
    return qcXxh64(pairs, count * sizeof *pairs, 0);
}

void qcBoxRecorder_EndPairs(qcBoxRecorder* recorder, const qcBoxPair* pairs, size_t pairCount, bool hasCallback,
                            const qcBoxPair* rejected, size_t rejectedCount)
{
    pthread_mutex_lock(&recorder->mutex);
    const qcPairsRecord record = {hasCallback, recorder->isDisturbed, pairCount, qcBoxPairs_Hash(pairs, pairCount)};
    Append(recorder, &recorder->data, &record, sizeof record);
    Append(recorder, &recorder->data, rejected, rejectedCount * sizeof *rejected);
    End(recorder, qc_operationFindPairs);
    qcRecordWriter_Flush(&recorder->writer);
    pthread_mutex_unlock(&recorder->mutex);
}

/// The boxes that a query reported.
static void AppendIds(qcBoxRecorder* recorder, const uint32_t* ids, size_t count)
{
    const qcBoxesRecord record = {(uint32_t)count, recorder->isDisturbed};
    Append(recorder, &recorder->data, &record, sizeof record);
    Append(recorder, &recorder->data, ids, count * sizeof *ids);
    Pad(recorder, &recorder->data);
}

void qcBoxRecorder_EndQuery(qcBoxRecorder* recorder, const double bounds[6], const uint32_t* ids, size_t count)
{
    pthread_mutex_lock(&recorder->mutex);
    AppendIds(recorder, ids, count);
    AppendNumbers(recorder, &recorder->data, bounds, 6);
    End(recorder, qc_operationQueryBox);
    pthread_mutex_unlock(&recorder->mutex);
}

void qcBoxRecorder_EndCast(qcBoxRecorder* recorder, const qcBoxCast* cast, const uint32_t* ids, const double* lambdas,
                           size_t count)
{
    pthread_mutex_lock(&recorder->mutex);
    AppendIds(recorder, ids, count);
    AppendNumbers(recorder, &recorder->data, (const double*)(const void*)cast, sizeof *cast / sizeof(double));
    AppendNumbers(recorder, &recorder->data, lambdas, count);
    End(recorder, qc_operationCastBox);
    pthread_mutex_unlock(&recorder->mutex);
}
