// One record an operation: see format.h.
#include "recording/scene_recorder.h"

#include "base/status.h"
#include "quickcullide/recording.h"
#include "recording/format.h"
#include "recording/position_coding.h"
#include "recording/record_writer.h"
#include "recording/rejected_pairs.h"
#include "recording/snapshot.h"
#include "quickcullide/hash.h"

#include <assert.h>
#include <string.h>

/// The indices of a body, written once.
typedef struct IndexSet
{
    uint64_t hash;
    uint32_t triangleCount;
} IndexSet;

struct qcSceneRecorder
{
    qcRecordWriter writer;
    qcBytes indexSets; ///< of IndexSet, in the order in which they were written
    qcBytes histories; ///< of qcPositionHistory, by slot; empty for rigid bodies
    qcRejectedPairs rejected;
    bool hasFilter; ///< of the detection that runs
};

//  ---- the file ----------------------------------------------------------------------------------------------------

/// A recorder that owns the open file; on failure it is closed.
static qcStatus Start(qcRecordWriter* writer, qcDevice* device, qcSceneRecorder** recorder)
{
    qcSceneRecorder* opened = qcAllocateZeroed(sizeof *opened);
    if (opened == NULL)
    {
        qcRecordWriter_Close(writer);
        return qcFailMemory(sizeof *opened, "a recording");
    }
    opened->writer = *writer;
    qcRejectedPairs_Init(&opened->rejected);
    qcDeviceInfo info = {.kind = qc_deviceNone};
    if (device != NULL)
        qcDevice_GetInfo(device, &info);
    const char* name = info.kind == qc_deviceNone ? "none" : info.renderer;
    qcRecordWriter_Begin(&opened->writer, qc_recordDevice, 0);
    qcRecordWriter_Put(&opened->writer, name, strlen(name) + 1);
    qcRecordWriter_End(&opened->writer);
    qcRecordWriter_Flush(&opened->writer);
    *recorder = opened;
    return qc_statusOk;
}

static qcPositionHistory* HistoriesOf(const qcSceneRecorder* recorder)
{
    return (qcPositionHistory*)(void*)recorder->histories.data;
}

static void Free(qcSceneRecorder* recorder)
{
    qcPositionHistory* histories = HistoriesOf(recorder);
    for (size_t i = 0; i < recorder->histories.count / sizeof *histories; i++)
        qcPositionHistory_Free(&histories[i]);
    qcBytes_Free(&recorder->histories);
    qcBytes_Free(&recorder->indexSets);
    qcRejectedPairs_Free(&recorder->rejected);
    qcFree(recorder, sizeof *recorder);
}

qcStatus qcSceneRecorder_Open(const char* path, qcDevice* device, const qcBodies* bodies, qcSceneRecorder** recorder)
{
    qcRecordWriter writer;
    qcSceneRecorder* opened = NULL;
    QC_TRY(qcRecordWriter_Open(&writer, path, NULL));
    QC_TRY(Start(&writer, device, &opened));
    assert(opened != NULL);
    qcSnapshot_Write(opened, bodies);
    // A full disk shows at once.
    qcRecordWriter_Flush(&opened->writer);
    if (opened->writer.status == qc_statusOk)
    {
        *recorder = opened;
        return qc_statusOk;
    }
    qcStatus status = qcRecordWriter_Close(&opened->writer);
    Free(opened);
    return status;
}

qcSceneRecorder* qcSceneRecorder_OpenFromEnvironment(qcDevice* device)
{
    qcRecordWriter writer;
    if (!qcRecordWriter_OpenFromEnvironment(&writer))
        return NULL;
    qcSceneRecorder* recorder = NULL;
    if (Start(&writer, device, &recorder) != qc_statusOk)
        qcLog("%s", qcLastMessage());
    return recorder;
}

void qcSceneRecorder_Stop(qcSceneRecorder* recorder, qcStatus status)
{
    qcRecordWriter_Stop(&recorder->writer, status, "%s", qcLastMessage());
}

qcStatus qcSceneRecorder_Close(qcSceneRecorder* recorder)
{
    if (recorder == NULL)
        return qc_statusOk;
    qcRecordWriter_Begin(&recorder->writer, qc_recordEnd, 0);
    qcRecordWriter_End(&recorder->writer);
    qcStatus status = qcRecordWriter_Close(&recorder->writer);
    Free(recorder);
    return status;
}

//  ---- bodies ------------------------------------------------------------------------------------------------------

/// Positions, tightly packed.
static void PutPositions(qcRecordWriter* writer, const void* positions, qcPositionType type, size_t stride,
                         uint32_t count)
{
    size_t size = type == qc_positionF64 ? 3 * sizeof(double) : 3 * sizeof(float);
    if (stride == 0 || stride == size)
        qcRecordWriter_Put(writer, positions, size * count);
    else
    {
        unsigned char* room = count != 0 ? qcRecordWriter_Extend(writer, size * count) : NULL;
        for (uint32_t v = 0; v < count && room != NULL; v++)
            memcpy(room + size * v, (const unsigned char*)positions + stride * v, size);
    }
    qcRecordWriter_Pad(writer);
}

/// The number of the body's indices among those that were written; *isNew if they weren't.
static uint32_t FindIndexSet(qcSceneRecorder* recorder, const qcBodyDef* def, bool* isNew)
{
    IndexSet set = {qcXxh64(def->indices, 3 * sizeof(uint32_t) * def->triangleCount, 0), def->triangleCount};
    const IndexSet* sets = (const IndexSet*)recorder->indexSets.data;
    size_t count = recorder->indexSets.count / sizeof set, i = 0;
    while (i < count && (sets[i].hash != set.hash || sets[i].triangleCount != set.triangleCount))
        i++;
    *isNew = i == count;
    if (!*isNew)
        return (uint32_t)i;
    void* room = qcBytes_Extend(&recorder->indexSets, sizeof set);
    if (room == NULL)
        qcRecordWriter_Stop(&recorder->writer, qc_statusOutOfMemory, "out of memory: the list of indices");
    else
        memcpy(room, &set, sizeof set);
    return (uint32_t)i;
}

/// The history of a slot; null: out of memory, recording has stopped.
static qcPositionHistory* HistoryOf(qcSceneRecorder* recorder, uint32_t slot)
{
    size_t end = (slot + (size_t)1) * sizeof(qcPositionHistory), count = recorder->histories.count;
    void* room = end > count ? qcBytes_Extend(&recorder->histories, end - count) : recorder->histories.data;
    if (room == NULL)
    {
        qcRecordWriter_Stop(&recorder->writer, qc_statusOutOfMemory, "out of memory: the list of bodies");
        return NULL;
    }
    if (end > count)
        memset(room, 0, end - count);
    return HistoriesOf(recorder) + slot;
}

/// Positions to which the next ones are compared.
static void StartHistory(qcSceneRecorder* recorder, uint32_t slot, const void* positions, qcPositionType type,
                         size_t stride, uint32_t count)
{
    qcPositionHistory* history = HistoryOf(recorder, slot);
    if (history != NULL && !qcPositionHistory_Start(history, positions, type, stride, count))
        qcRecordWriter_Stop(&recorder->writer, qc_statusOutOfMemory, "out of memory: positions of body %u", slot);
}

void qcSceneRecorder_AddBody(qcSceneRecorder* recorder, uint32_t slot, const qcBodyDef* def)
{
    qcRecordWriter* writer = &recorder->writer;
    if (writer->file == NULL)
        return;
    bool isNew;
    qcBodyRecord record = {.activity = (uint32_t)def->activity,
                           .group = def->group,
                           .mask = def->mask,
                           .owner = def->owner,
                           .indexSet = FindIndexSet(recorder, def, &isNew),
                           .vertexCount = def->vertexCount,
                           .triangleCount = def->triangleCount,
                           .margin = def->margin};
    record.flags = (def->deforming ? qc_bodyDeforming : 0) | (def->selfCollision ? qc_bodySelfCollision : 0) |
                   (def->positionType == qc_positionF64 ? qc_bodyDoubles : 0) | (isNew ? qc_bodyNewIndices : 0);
    memcpy(record.transform, def->transform.linear, sizeof def->transform.linear);
    memcpy(record.transform + 9, def->transform.translation, sizeof def->transform.translation);
    qcRecordWriter_Begin(writer, qc_operationAddBody, slot);
    qcRecordWriter_Put(writer, &record, sizeof record);
    PutPositions(writer, def->positions, def->positionType, def->positionStride, def->vertexCount);
    if (isNew)
        qcRecordWriter_Put(writer, def->indices, 3 * sizeof(uint32_t) * def->triangleCount);
    qcRecordWriter_End(writer);
    if (def->deforming)
        StartHistory(recorder, slot, def->positions, def->positionType, def->positionStride, def->vertexCount);
}

/// A record with a few bytes of data, or none.
static void PutRecord(qcSceneRecorder* recorder, qcOperationKind kind, uint32_t slot, const void* data, size_t size)
{
    qcRecordWriter_Begin(&recorder->writer, kind, slot);
    qcRecordWriter_Put(&recorder->writer, data, size);
    qcRecordWriter_End(&recorder->writer);
}

void qcSceneRecorder_RemoveBody(qcSceneRecorder* recorder, uint32_t slot)
{
    PutRecord(recorder, qc_operationRemoveBody, slot, NULL, 0);
}

void qcSceneRecorder_SetTransform(qcSceneRecorder* recorder, uint32_t slot, const qcTransform* transform)
{
    PutRecord(recorder, qc_operationSetTransform, slot, transform, sizeof *transform);
}

void qcSceneRecorder_SetVertices(qcSceneRecorder* recorder, uint32_t slot, const void* positions, qcPositionType type,
                                 size_t stride, uint32_t count)
{
    qcRecordWriter* writer = &recorder->writer;
    qcPositionHistory* history = writer->file != NULL ? HistoryOf(recorder, slot) : NULL;
    if (history == NULL)
        return;
    bool isPacked = history->last != NULL && history->type == type && history->vertexCount == count;
    qcVerticesRecord record = {type == qc_positionF64 ? qc_codingF64 : qc_codingF32, count};
    record.coding += isPacked ? (uint32_t)qc_codingPackedF32 : 0;
    qcRecordWriter_Begin(writer, qc_operationSetVertices, slot);
    qcRecordWriter_Put(writer, &record, sizeof record);
    if (!isPacked)
    {
        PutPositions(writer, positions, type, stride, count);
        StartHistory(recorder, slot, positions, type, stride, count);
    }
    else
    {
        size_t maxSize = qcPositions_MaxSize(history);
        unsigned char* room = qcRecordWriter_Extend(writer, maxSize);
        if (room != NULL)
            writer->buffer.count -= maxSize - qcPositions_Encode(history, positions, stride, room);
    }
    qcRecordWriter_End(writer);
}

void qcSceneRecorder_SetActivity(qcSceneRecorder* recorder, uint32_t slot, qcActivity activity)
{
    const qcWordsRecord record = {{(uint32_t)activity, 0}};
    PutRecord(recorder, qc_operationSetActivity, slot, &record, sizeof record);
}

void qcSceneRecorder_SetFilter(qcSceneRecorder* recorder, uint32_t slot, uint32_t group, uint32_t mask)
{
    const qcWordsRecord record = {{group, mask}};
    PutRecord(recorder, qc_operationSetFilter, slot, &record, sizeof record);
}

void qcSceneRecorder_SetSelfCollision(qcSceneRecorder* recorder, uint32_t slot, bool selfCollision)
{
    const qcWordsRecord record = {{selfCollision, 0}};
    PutRecord(recorder, qc_operationSetSelfCollision, slot, &record, sizeof record);
}

void qcSceneRecorder_SetMargin(qcSceneRecorder* recorder, uint32_t slot, double margin)
{
    PutRecord(recorder, qc_operationSetMargin, slot, &margin, sizeof margin);
}

void qcSceneRecorder_MarkStart(qcSceneRecorder* recorder)
{
    PutRecord(recorder, qc_operationMarkStart, 0, NULL, 0);
}

//  ---- detections --------------------------------------------------------------------------------------------------

static uint32_t FlagsOf(const qcDetectDef* def)
{
    return (def->touching ? qc_detectTouching : 0) | (def->neighbours ? qc_detectNeighbours : 0) |
           (def->segments ? qc_detectSegments : 0) | (def->proximities ? qc_detectProximities : 0) |
           (def->manifolds ? qc_detectManifolds : 0) | (def->nearestContacts ? qc_detectNearestContacts : 0) |
           (def->layerTimes ? qc_detectLayerTimes : 0) | (def->backToFront ? qc_detectBackToFront : 0) |
           (def->secondPassFromBack ? qc_detectSecondPassFromBack : 0) | (def->reliable ? qc_detectReliable : 0) |
           (def->motion ? qc_detectMotion : 0) | (def->pairFilter != NULL ? qc_detectHasFilter : 0) |
           (def->spacing > 0.0 ? qc_detectHasSpacing : 0) | (def->unoriented ? qc_detectUnoriented : 0) |
           (def->maxPairs != 0 ? qc_detectHasMaxPairs : 0);
}

void qcSceneRecorder_BeginDetect(qcSceneRecorder* recorder, qcDetectDef* def)
{
    if (recorder->writer.file == NULL)
        return;
    qcDetectRecord record = {.method = (uint32_t)def->method,
                             .flags = FlagsOf(def),
                             .threads = def->threads,
                             .layerColumns = def->layerColumns,
                             .layerDepthAxis = (unsigned char)def->layerDepthAxis,
                             .resolution = def->resolution,
                             .iterations = def->iterations,
                             .margin = def->margin,
                             .contactMargin = def->contactMargin};
    memcpy(record.views, def->views, sizeof record.views);
    qcRecordWriter_Begin(&recorder->writer, qc_operationDetect, 0);
    qcRecordWriter_Put(&recorder->writer, &record, sizeof record);
    if (def->spacing > 0.0)
        qcRecordWriter_Put(&recorder->writer, &def->spacing, sizeof def->spacing);
    if (def->maxPairs != 0)
        qcRecordWriter_Put(&recorder->writer, &def->maxPairs, sizeof def->maxPairs);
    qcRecordWriter_End(&recorder->writer);
    qcRecordWriter_Flush(&recorder->writer);
    recorder->hasFilter = def->pairFilter != NULL;
    if (!recorder->hasFilter)
        return;
    qcRejectedPairs_Start(&recorder->rejected, def->pairFilter, def->pairFilterContext);
    def->pairFilter = qcRejectedPairs_Filter;
    def->pairFilterContext = &recorder->rejected;
}

void qcSceneRecorder_EndDetect(qcSceneRecorder* recorder, qcStatus status, const qcResult* result)
{
    qcRecordWriter* writer = &recorder->writer;
    if (writer->file == NULL)
        return;
    qcResultRecord record = {.status = (uint32_t)status};
    static_assert(sizeof(qcResultHash) == sizeof record.hashes, "all fields are written");
    if (status == qc_statusOk)
    {
        qcResultHash hash = qcResult_Hash(result);
        memcpy(record.hashes, &hash, sizeof hash);
    }
    qcRecordWriter_Begin(writer, qc_recordResult, 0);
    qcRecordWriter_Put(writer, &record, sizeof record);
    if (recorder->hasFilter)
    {
        qcRejectedPairs_Sort(&recorder->rejected);
        qcRecordWriter_Put(writer, recorder->rejected.keys, recorder->rejected.count * sizeof(uint64_t));
        if (recorder->rejected.outOfMemory)
            qcRecordWriter_Stop(writer, qc_statusOutOfMemory, "out of memory: the pairs that a filter rejected");
    }
    qcRecordWriter_End(writer);
}
