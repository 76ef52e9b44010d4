// Records become operations: sizes, numbers and bodies are checked here. What a scene checks itself (finite positions,
// a definition of a detection) is left to it.
#include "quickcullide/recording.h"

#include "base/status.h"
#include "recording/box_reader.h"
#include "recording/recorded_bodies.h"
#include "recording/rejected_pairs.h"

#include <stdlib.h>
#include <string.h>

/// The pairs of bodies that a recorded filter rejected.
typedef struct RejectedList
{
    const uint64_t* keys;
    size_t count;
} RejectedList;

struct qcRecording
{
    qcRecordReader reader;
    qcRecord firstRecord, record, result;
    qcBoxReader boxes;
    bool isPending;    ///< `result` was read behind a detection, and is the next record, or its failure
    bool pendingAtEnd; ///< it is the end of the file
    qcStatus pendingStatus;
    qcRecordedBodies bodies;
    RejectedList rejected;
    uint64_t operationCount;
    qcOperation operation;
    qcStatus failure; ///< of an earlier call; no operation can be read any more
    char message[512];
};

const char* qcOperationKind_Name(qcOperationKind kind)
{
    switch (kind)
    {
        case qc_operationEnd: return "end";
        case qc_operationAddBody: return "add body";
        case qc_operationRemoveBody: return "remove body";
        case qc_operationSetTransform: return "set transform";
        case qc_operationSetVertices: return "set vertices";
        case qc_operationSetActivity: return "set activity";
        case qc_operationSetFilter: return "set filter";
        case qc_operationSetSelfCollision: return "set self-collision";
        case qc_operationSetMargin: return "set margin";
        case qc_operationMarkStart: return "mark start";
        case qc_operationDetect: return "detect";
        case qc_operationAddBox: return "add box";
        case qc_operationRemoveBox: return "remove box";
        case qc_operationMoveBoxes: return "move boxes";
        case qc_operationSetBoxFilter: return "set filter of box";
        case qc_operationResetBoxes: return "reset boxes";
        case qc_operationFindPairs: return "find pairs";
        case qc_operationQueryBox: return "query box";
        case qc_operationCastBox: return "cast box";
    }
    return "unknown operation";
}

//  ---- bodies ------------------------------------------------------------------------------------------------------

static qcStatus TakePositions(qcRecordData* data, uint32_t vertexCount, qcPositionType type, const void** positions)
{
    *positions = qcRecordData_Take(data, (type == qc_positionF64 ? 3 * sizeof(double) : 3 * sizeof(float)) *
                                             (uint64_t)vertexCount);
    return *positions != NULL ? qc_statusOk : qc_statusFile;
}

/// The indices of a body: those that follow, or those of an earlier body.
static qcStatus TakeIndices(qcRecordedBodies* bodies, qcRecordData* data, const qcBodyRecord* record,
                            const uint32_t** indices)
{
    size_t count = bodies->indexSets.count;
    bool isNew = (record->flags & qc_bodyNewIndices) != 0;
    if (isNew)
    {
        const uint32_t* taken = qcRecordData_Take(data, 3 * sizeof(uint32_t) * (uint64_t)record->triangleCount);
        if (taken == NULL)
            return qc_statusFile;
        QC_TRY(qcRecordedBodies_AddIndices(bodies, taken, record->triangleCount));
    }
    if (isNew ? record->indexSet != count : record->indexSet >= count)
        return qcFail(qc_statusFile, "it names the indices %u of %zu", record->indexSet, count);
    const qcIndexSet* set = &QC_AT(qcIndexSet, bodies->indexSets, record->indexSet);
    if (set->triangleCount != record->triangleCount)
        return qcFail(qc_statusFile, "it has %u triangles, but its indices are those of %u", record->triangleCount,
                      set->triangleCount);
    if (set->vertexCount > record->vertexCount)
        return qcFail(qc_statusFile, "index %llu is out of range: there are %u vertices",
                      (unsigned long long)set->vertexCount - 1, record->vertexCount);
    *indices = set->indices;
    return qc_statusOk;
}

static qcStatus StartHistory(qcRecordedBody* body, const void* positions, qcPositionType type)
{
    if (qcPositionHistory_Start(&body->positions, positions, type, 0, body->vertexCount))
        return qc_statusOk;
    return qcFailMemory(6 * sizeof(double) * body->vertexCount, "recorded positions");
}

static qcStatus ReadAddBody(qcRecording* recording, qcOperation* operation)
{
    qcRecordData data = qcRecordData_Of(&recording->record);
    qcBodyRecord record;
    QC_TRY(qcRecordData_TakeInto(&data, &record, sizeof record));
    if ((record.flags & ~(uint32_t)qc_bodyFlags) != 0)
        return qcFail(qc_statusFile, "unknown flags 0x%x", record.flags);
    qcBodyDef* def = &operation->body;
    *def = qcDefaultBodyDef();
    def->positionType = (record.flags & qc_bodyDoubles) != 0 ? qc_positionF64 : qc_positionF32;
    QC_TRY(TakePositions(&data, record.vertexCount, def->positionType, &def->positions));
    QC_TRY(TakeIndices(&recording->bodies, &data, &record, &def->indices));
    QC_TRY(qcRecordData_CheckDone(&data));
    def->vertexCount = record.vertexCount;
    def->triangleCount = record.triangleCount;
    def->deforming = (record.flags & qc_bodyDeforming) != 0;
    def->selfCollision = (record.flags & qc_bodySelfCollision) != 0;
    memcpy(def->transform.linear, record.transform, sizeof def->transform.linear);
    memcpy(def->transform.translation, record.transform + 9, sizeof def->transform.translation);
    def->activity = (qcActivity)record.activity;
    def->group = record.group;
    def->mask = record.mask;
    def->owner = record.owner;
    def->margin = record.margin;
    uint32_t slot = recording->record.head.slot;
    QC_TRY(qcRecordedBodies_Add(&recording->bodies, slot, def->deforming, def->vertexCount));
    qcRecordedBody* body = &QC_AT(qcRecordedBody, recording->bodies.slots, slot);
    operation->id = (qcBodyId){slot, body->generation};
    return def->deforming ? StartHistory(body, def->positions, def->positionType) : qc_statusOk;
}

/// Positions that are coded as differences.
static qcStatus Unpack(qcRecordedBody* body, qcRecordData* data, qcOperation* operation)
{
    qcPositionHistory* history = &body->positions;
    if (history->type != operation->positionType)
        return qcFail(qc_statusFile, "its positions are differences to positions of another type");
    size_t size = qcPositions_Decode(history, (const unsigned char*)data->at, data->left);
    if (body->vertexCount != 0 && size == 0)
        return qcFail(qc_statusFile, "its positions are damaged");
    qcRecordData_Take(data, size);
    operation->positions = history->last;
    return qcRecordData_CheckDone(data);
}

static qcStatus ReadSetVertices(const qcRecording* recording, qcRecordedBody* body, qcOperation* operation)
{
    qcRecordData data = qcRecordData_Of(&recording->record);
    qcVerticesRecord record;
    QC_TRY(qcRecordData_TakeInto(&data, &record, sizeof record));
    if (!body->deforming)
        return qcFail(qc_statusFile, "body %u is rigid", recording->record.head.slot);
    if (record.vertexCount != body->vertexCount)
        return qcFail(qc_statusFile, "body %u has %u vertices, not %u", recording->record.head.slot, body->vertexCount,
                      record.vertexCount);
    if (record.coding > qc_codingPackedF64)
        return qcFail(qc_statusFile, "unknown coding %u", record.coding);
    bool isPacked = record.coding >= qc_codingPackedF32;
    operation->vertexCount = record.vertexCount;
    operation->positionType = record.coding % 2 == qc_codingF64 ? qc_positionF64 : qc_positionF32;
    if (isPacked)
        return Unpack(body, &data, operation);
    QC_TRY(TakePositions(&data, record.vertexCount, operation->positionType, &operation->positions));
    QC_TRY(StartHistory(body, operation->positions, operation->positionType));
    return qcRecordData_CheckDone(&data);
}

/// An operation on a body that is there.
static qcStatus ReadChange(qcRecording* recording, qcOperation* operation)
{
    const qcRecord* record = &recording->record;
    uint32_t slot = record->head.slot;
    qcRecordedBody* body;
    QC_TRY(qcRecordedBodies_Find(&recording->bodies, slot, &body));
    operation->id = (qcBodyId){slot, body->generation};
    qcWordsRecord words = {{0}};
    switch (operation->kind)
    {
        case qc_operationSetTransform:
            if (body->deforming)
                return qcFail(qc_statusFile, "body %u is deforming", slot);
            return qcRecord_TakeAll(record, &operation->transform, sizeof operation->transform);
        case qc_operationSetVertices: return ReadSetVertices(recording, body, operation);
        case qc_operationSetMargin: return qcRecord_TakeAll(record, &operation->margin, sizeof operation->margin);
        case qc_operationRemoveBody:
            QC_TRY(qcRecord_TakeAll(record, NULL, 0));
            return qcRecordedBodies_Remove(&recording->bodies, slot);
        default: break;
    }
    QC_TRY(qcRecord_TakeAll(record, &words, sizeof words));
    if (operation->kind == qc_operationSetActivity)
        operation->activity = (qcActivity)words.words[0];
    if (operation->kind == qc_operationSetSelfCollision)
        operation->selfCollision = words.words[0] != 0;
    if (operation->kind == qc_operationSetFilter)
    {
        operation->group = words.words[0];
        operation->mask = words.words[1];
    }
    return qc_statusOk;
}

//  ---- detections --------------------------------------------------------------------------------------------------

static bool FilterRecorded(void* context, uint32_t slotA, uint32_t slotB)
{
    const RejectedList* list = context;
    uint64_t key = qcRejectedPair_Key(slotA, slotB);
    size_t lower = 0, upper = list->count;
    while (lower < upper)
    {
        size_t middle = lower + (upper - lower) / 2;
        if (list->keys[middle] < key)
            lower = middle + 1;
        else
            upper = middle;
    }
    return lower == list->count || list->keys[lower] != key;
}

static qcStatus ReadDef(qcRecording* recording, qcDetectDef* def)
{
    qcDetectRecord record;
    qcRecordData data = qcRecordData_Of(&recording->record);
    QC_TRY(qcRecordData_TakeInto(&data, &record, sizeof record));
    if ((record.flags & ~(uint32_t)qc_detectFlags) != 0)
        return qcFail(qc_statusFile, "unknown flags 0x%x", record.flags);
    *def = qcDefaultDetectDef();
    if ((record.flags & qc_detectHasSpacing) != 0)
        QC_TRY(qcRecordData_TakeInto(&data, &def->spacing, sizeof def->spacing));
    if ((record.flags & qc_detectHasMaxPairs) != 0)
        QC_TRY(qcRecordData_TakeInto(&data, &def->maxPairs, sizeof def->maxPairs));
    QC_TRY(qcRecordData_CheckDone(&data));
    def->unoriented = (record.flags & qc_detectUnoriented) != 0;
    def->method = (qcMethod)record.method;
    def->margin = record.margin;
    def->touching = (record.flags & qc_detectTouching) != 0;
    def->neighbours = (record.flags & qc_detectNeighbours) != 0;
    def->segments = (record.flags & qc_detectSegments) != 0;
    def->proximities = (record.flags & qc_detectProximities) != 0;
    def->manifolds = (record.flags & qc_detectManifolds) != 0;
    def->contactMargin = record.contactMargin;
    def->nearestContacts = (record.flags & qc_detectNearestContacts) != 0;
    def->pairFilter = (record.flags & qc_detectHasFilter) != 0 ? FilterRecorded : NULL;
    def->pairFilterContext = def->pairFilter != NULL ? &recording->rejected : NULL;
    def->threads = record.threads;
    def->layerColumns = record.layerColumns;
    def->layerDepthAxis = (char)record.layerDepthAxis;
    def->layerTimes = (record.flags & qc_detectLayerTimes) != 0;
    memcpy(def->views, record.views, sizeof def->views);
    def->resolution = record.resolution;
    def->iterations = record.iterations;
    def->backToFront = (record.flags & qc_detectBackToFront) != 0;
    def->secondPassFromBack = (record.flags & qc_detectSecondPassFromBack) != 0;
    def->reliable = (record.flags & qc_detectReliable) != 0;
    def->motion = (record.flags & qc_detectMotion) != 0;
    return qc_statusOk;
}

static qcStatus ReadResult(qcRecording* recording, qcOperation* operation)
{
    qcRecordData data = qcRecordData_Of(&recording->result);
    qcResultRecord record;
    QC_TRY(qcRecordData_TakeInto(&data, &record, sizeof record));
    recording->rejected = (RejectedList){(const uint64_t*)(const void*)data.at, (size_t)(data.left / sizeof(uint64_t))};
    operation->rejectedPairCount = recording->rejected.count;
    operation->hasResult = true;
    operation->resultStatus = (qcStatus)record.status;
    memcpy(&operation->resultHash, record.hashes, sizeof operation->resultHash);
    return qc_statusOk;
}

static void Fail(qcRecording* recording, uint64_t byteOffset, qcStatus status)
{
    char reason[256];
    snprintf(reason, sizeof reason, "%s", qcLastMessage());
    snprintf(recording->message, sizeof recording->message, "%.200s: operation %llu at byte %llu: %s",
             (const char*)recording->reader.path.data, (unsigned long long)recording->operationCount,
             (unsigned long long)byteOffset, reason);
    recording->failure = status;
}

static qcStatus ReadDetect(qcRecording* recording, qcOperation* operation)
{
    recording->rejected = (RejectedList){0};
    QC_TRY(ReadDef(recording, &operation->detect));
    recording->pendingStatus = qcRecordReader_Next(&recording->reader, &recording->result, &recording->pendingAtEnd);
    recording->isPending = recording->pendingStatus != qc_statusOk || recording->pendingAtEnd ||
                           recording->result.head.kind != qc_recordResult;
    if (!recording->isPending)
        return ReadResult(recording, operation);
    // The detection itself is whole: the failure is that of the next call.
    if (recording->pendingStatus != qc_statusOk)
        snprintf(recording->message, sizeof recording->message, "%s", qcLastMessage());
    return qc_statusOk;
}

//  ---- operations --------------------------------------------------------------------------------------------------

/// The next record, unless it was read already.
static qcStatus NextRecord(qcRecording* recording, bool* atEnd)
{
    if (!recording->isPending)
        return qcRecordReader_Next(&recording->reader, &recording->record, atEnd);
    qcRecord swapped = recording->record;
    recording->record = recording->result;
    recording->result = swapped;
    recording->isPending = false;
    *atEnd = recording->pendingAtEnd;
    if (recording->pendingStatus != qc_statusOk)
        return qcFail(recording->pendingStatus, "%s", recording->message);
    return qc_statusOk;
}

static qcStatus ReadOperation(qcRecording* recording, qcOperation* operation)
{
    bool atEnd = false;
    QC_TRY(NextRecord(recording, &atEnd));
    operation->byteOffset = recording->record.byteOffset;
    uint32_t kind = recording->record.head.kind;
    if (!atEnd && kind == qc_recordEnd && !qcRecordReader_IsAtEnd(&recording->reader))
        return qcFail(qc_statusFile, "there are bytes behind the end of the recording");
    if (atEnd || kind == qc_recordEnd)
    {
        operation->isComplete = !atEnd;
        return qc_statusOk;
    }
    operation->kind = (qcOperationKind)kind;
    bool isBoxes = kind >= qc_operationAddBox && kind <= qc_operationCastBox;
    if (isBoxes && recording->boxes.scalarSize != 0)
        return qcBoxReader_Read(&recording->boxes, &recording->record, &operation->boxes);
    if (recording->boxes.scalarSize != 0)
        return qcFail(qc_statusFile, "unknown operation %u of a broadphase", kind);
    switch (operation->kind)
    {
        case qc_operationAddBody: return ReadAddBody(recording, operation);
        case qc_operationRemoveBody:
        case qc_operationSetTransform:
        case qc_operationSetVertices:
        case qc_operationSetActivity:
        case qc_operationSetFilter:
        case qc_operationSetSelfCollision:
        case qc_operationSetMargin: return ReadChange(recording, operation);
        case qc_operationMarkStart: return qcRecord_TakeAll(&recording->record, NULL, 0);
        case qc_operationDetect: return ReadDetect(recording, operation);
        default: return qcFail(qc_statusFile, "unknown operation %u", kind);
    }
}

/// The first record: the device of a scene, or the numbers of a broadphase.
static qcStatus ReadFirst(qcRecording* recording)
{
    bool atEnd = false;
    qcRecord* record = &recording->firstRecord;
    QC_TRY(qcRecordReader_Next(&recording->reader, record, &atEnd));
    if (atEnd)
        return qcFail(qc_statusFile, "the file ends before it");
    if (record->head.kind == qc_recordBoxes)
        return qcBoxReader_Open(&recording->boxes, record);
    qcRecordData data = qcRecordData_Of(record);
    if (record->head.kind != qc_recordDevice || data.left == 0 || data.at[data.left - 1] != 0)
        return qcFail(qc_statusFile, "it does not name a device");
    return qc_statusOk;
}

qcStatus qcRecording_Open(const char* path, qcRecording** recording)
{
    if (recording != NULL)
        *recording = NULL;
    if (path == NULL || recording == NULL)
        return qcFail(qc_statusBadInput, "qcRecording_Open: %s is null", path == NULL ? "path" : "recording");
    qcRecording* opened = qcAllocateZeroed(sizeof *opened);
    if (opened == NULL)
        return qcFailMemory(sizeof *opened, "a recording");
    qcStatus status = qcRecordReader_Open(&opened->reader, path);
    if (status == qc_statusOk)
    {
        status = ReadFirst(opened);
        if (status != qc_statusOk)
            Fail(opened, opened->firstRecord.byteOffset, status);
    }
    if (status == qc_statusOk)
        *recording = opened;
    else
    {
        if (opened->failure != qc_statusOk)
            qcFail(status, "%s", opened->message);
        qcRecording_Close(opened);
    }
    return status;
}

void qcRecording_Close(qcRecording* recording)
{
    if (recording == NULL)
        return;
    qcRecordReader_Close(&recording->reader);
    qcArray_Free(&recording->firstRecord.data);
    qcArray_Free(&recording->record.data);
    qcArray_Free(&recording->result.data);
    qcRecordedBodies_Free(&recording->bodies);
    qcBoxReader_Free(&recording->boxes);
    qcFree(recording, sizeof *recording);
}

qcRecordingInfo qcRecording_GetInfo(const qcRecording* recording)
{
    if (recording == NULL)
        return (qcRecordingInfo){.device = "none"};
    bool isScene = recording->boxes.scalarSize == 0;
    return (qcRecordingInfo){.formatVersion = recording->reader.header.formatVersion,
                             .libraryVersion = recording->reader.header.libraryVersion,
                             .boxScalarSize = recording->boxes.scalarSize,
                             .device = isScene ? qcRecordData_Of(&recording->firstRecord).at : "none"};
}

qcStatus qcRecording_Next(qcRecording* recording, const qcOperation** operation)
{
    if (recording == NULL || operation == NULL)
        return qcFail(qc_statusBadInput, "qcRecording_Next: %s is null", recording == NULL ? "recording" : "operation");
    bool isEnd = recording->operationCount != 0 && recording->operation.kind == qc_operationEnd;
    if (recording->failure == qc_statusOk && !isEnd)
    {
        recording->operation = (qcOperation){.number = recording->operationCount};
        qcStatus status = ReadOperation(recording, &recording->operation);
        if (status != qc_statusOk)
            Fail(recording, recording->record.byteOffset, status);
        recording->operationCount++;
    }
    if (recording->failure != qc_statusOk)
        return qcFail(recording->failure, "%s", recording->message);
    *operation = &recording->operation;
    return qc_statusOk;
}
