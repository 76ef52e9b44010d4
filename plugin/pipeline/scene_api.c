// The scene's entry points but for detections. Arguments are checked here; stages trust them.
#include "pipeline/scene_api.h"

#include "base/definition.h"
#include "base/float_mode.h"
#include "base/status.h"
#include "gl/buffers/device_buffer.h"
#include "pipeline/scene_state.h"
#include "quickcullide/recording.h"

/// Records an operation, NAME and its arguments, if the scene is recorded.
#define RECORD(scene, NAME, ...)                                                                                       \
    do                                                                                                                 \
    {                                                                                                                  \
        if ((scene)->recorder != NULL)                                                                                 \
            qcSceneRecorder_##NAME((scene)->recorder, __VA_ARGS__);                                                    \
    } while (0)

qcStatus qcScene_CreateUnrecorded(const qcSceneDef* given, qcScene** scene)
{
    QC_TRY(qcCheckPointer(given, "qcScene_Create", "def"));
    QC_TRY(qcCheckPointer(scene, "qcScene_Create", "scene"));
    qcSceneDef def = qcDefaultSceneDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT("qcScene_Create", qcSceneDef, device), &def));
    qcScene* created = qcAllocateZeroed(sizeof(qcScene));
    if (created == NULL)
        return qcFailMemory(sizeof(qcScene), "a scene");
    created->device = def.device;
    *scene = created;
    return qc_statusOk;
}

qcStatus qcScene_Create(const qcSceneDef* def, qcScene** scene)
{
    QC_TRY(qcScene_CreateUnrecorded(def, scene));
    (*scene)->recorder = qcSceneRecorder_OpenFromEnvironment((*scene)->device);
    return qc_statusOk;
}

/// All positions in double, in the default floating-point environment.
__attribute__((noinline)) static qcStatus CompletePositions(qcScene* scene)
{
    uint64_t bytes = 0;
    return qcVertexBuffers_CompleteAll(&scene->bodies, &bytes);
}

qcStatus qcScene_Record(qcScene* scene, const char* path)
{
    QC_TRY(qcScene_CheckIdle(scene, "qcScene_Record"));
    if (path != NULL)
    {
        qcFloatMode mode = qcFloatMode_Begin();
        qcStatus completed = CompletePositions(scene);
        qcFloatMode_End(mode);
        QC_TRY(completed);
    }
    qcStatus status = qcSceneRecorder_Close(scene->recorder);
    scene->recorder = NULL;
    return path == NULL ? status : qcSceneRecorder_Open(path, scene->device, &scene->bodies, &scene->recorder);
}

void qcScene_Destroy(qcScene* scene)
{
    if (scene == NULL)
        return;
    qcScene_DropDetection(scene);
    qcSceneRecorder_Close(scene->recorder);
    for (size_t slot = 0; slot < scene->bodies.slots.count; slot++)
        qcVertexBuffers_Release(&QC_AT(qcBody, scene->bodies.slots, slot));
    qcDetector_Free(&scene->detector);
    qcBodies_Free(&scene->bodies);
    qcFree(scene, sizeof *scene);
}

qcStatus qcScene_AddBody(qcScene* scene, const qcBodyDef* given, qcBodyId* id)
{
    QC_TRY(qcScene_CheckIdle(scene, "qcScene_AddBody"));
    QC_TRY(qcCheckPointer(given, "qcScene_AddBody", "def"));
    QC_TRY(qcCheckPointer(id, "qcScene_AddBody", "id"));
    qcBodyDef def = qcDefaultBodyDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT("qcScene_AddBody", qcBodyDef, positions), &def));
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = qcBodies_Add(&scene->bodies, &def, id);
    qcFloatMode_End(mode);
    if (status == qc_statusOk)
        RECORD(scene, AddBody, id->slot, &def);
    return status;
}

/// The body, or null with a status in *status.
static qcBody* Find(qcScene* scene, qcBodyId id, const char* function, qcStatus* status)
{
    *status = qcScene_CheckIdle(scene, function);
    if (*status != qc_statusOk)
        return NULL;
    qcBody* body = qcBodies_Find(&scene->bodies, id, function);
    *status = body != NULL ? qc_statusOk : qc_statusBadInput;
    return body;
}

qcStatus qcScene_RemoveBody(qcScene* scene, qcBodyId id)
{
    qcStatus status;
    qcBody* body = Find(scene, id, "qcScene_RemoveBody", &status);
    if (body == NULL)
        return status;
    qcVertexBuffers_Release(body);
    qcBodies_Remove(&scene->bodies, id);
    RECORD(scene, RemoveBody, id.slot);
    // In a replay, where no slot is used up, an empty body keeps others out.
    const qcBodyDef empty = qcDefaultBodyDef();
    if (!qcBody_IsFree(body))
        RECORD(scene, AddBody, id.slot, &empty);
    return status;
}

qcStatus qcScene_SetTransform(qcScene* scene, qcBodyId id, const qcTransform* transform)
{
    qcStatus status;
    const qcBody* body = Find(scene, id, "qcScene_SetTransform", &status);
    if (body == NULL)
        return status;
    QC_TRY(qcCheckPointer(transform, "qcScene_SetTransform", "transform"));
    if (body->deforming)
        return qcFail(qc_statusBadInput, "qcScene_SetTransform: body %u is deforming; give it vertices", id.slot);
    qcFloatMode mode = qcFloatMode_Begin();
    status = qcBodies_SetTransform(&scene->bodies, id.slot, transform);
    qcFloatMode_End(mode);
    if (status == qc_statusOk)
        RECORD(scene, SetTransform, id.slot, transform);
    return status;
}

qcStatus qcScene_SetVertices(qcScene* scene, qcBodyId id, const void* positions, qcPositionType type, size_t stride)
{
    qcStatus status;
    qcBody* body = Find(scene, id, "qcScene_SetVertices", &status);
    if (body == NULL)
        return status;
    if (!body->deforming)
        return qcFail(qc_statusBadInput, "qcScene_SetVertices: body %u is rigid; give it a transform", id.slot);
    qcFloatMode mode = qcFloatMode_Begin();
    status = qcBodies_SetVertices(&scene->bodies, id.slot, positions, type, stride);
    qcFloatMode_End(mode);
    if (status != qc_statusOk)
        return status;
    qcVertexBuffers_Leave(body);
    RECORD(scene, SetVertices, id.slot, positions, type, stride, body->vertexCount);
    return status;
}

/// A recording has the positions as those of qcScene_SetVertices, and stops where they can't be read back.
static void RecordVertexBuffer(qcScene* scene, const qcBody* body, uint32_t slot)
{
    if (scene->recorder == NULL)
        return;
    uint64_t bytes = 0;
    qcStatus status = qcVertexBuffers_Complete(body, slot, &bytes);
    if (status == qc_statusOk)
        qcSceneRecorder_SetVertices(scene->recorder, slot, body->world, qc_positionF64, 0, body->vertexCount);
    else
        qcSceneRecorder_Stop(scene->recorder, status);
}

qcStatus qcScene_SetVertexBuffer(qcScene* scene, qcBodyId id, const qcVertexBufferDef* def)
{
    qcStatus status;
    const qcBody* body = Find(scene, id, "qcScene_SetVertexBuffer", &status);
    if (body == NULL)
        return status;
    QC_TRY(qcCheckPointer(def, "qcScene_SetVertexBuffer", "def"));
    if (!body->deforming)
        return qcFail(qc_statusBadInput, "qcScene_SetVertexBuffer: body %u is rigid; give it a transform", id.slot);
    qcFloatMode mode = qcFloatMode_Begin();
    status = qcVertexBuffers_Set(&scene->bodies, id.slot, scene->device, def);
    if (status == qc_statusOk)
        RecordVertexBuffer(scene, body, id.slot);
    qcFloatMode_End(mode);
    return status;
}

qcStatus qcScene_SetActivity(qcScene* scene, qcBodyId id, qcActivity activity)
{
    qcStatus status;
    qcBody* body = Find(scene, id, "qcScene_SetActivity", &status);
    if (body == NULL)
        return status;
    if (activity != qc_activityMoving && activity != qc_activitySleeping && activity != qc_activityStatic)
        return qcFail(qc_statusBadInput, "qcScene_SetActivity: body %u: unknown activity %d", id.slot, (int)activity);
    scene->bodies.revision += body->activity != activity;
    body->activity = activity;
    RECORD(scene, SetActivity, id.slot, activity);
    return qc_statusOk;
}

qcStatus qcScene_SetFilter(qcScene* scene, qcBodyId id, uint32_t group, uint32_t mask)
{
    qcStatus status;
    qcBody* body = Find(scene, id, "qcScene_SetFilter", &status);
    if (body == NULL)
        return status;
    scene->bodies.revision += body->group != group || body->mask != mask;
    body->group = group;
    body->mask = mask;
    RECORD(scene, SetFilter, id.slot, group, mask);
    return qc_statusOk;
}

qcStatus qcScene_SetSelfCollision(qcScene* scene, qcBodyId id, bool selfCollision)
{
    qcStatus status;
    qcBody* body = Find(scene, id, "qcScene_SetSelfCollision", &status);
    if (body == NULL)
        return status;
    scene->bodies.revision += body->selfCollision != selfCollision;
    body->selfCollision = selfCollision;
    RECORD(scene, SetSelfCollision, id.slot, selfCollision);
    return qc_statusOk;
}

__attribute__((noinline)) static qcStatus MarkStart(qcScene* scene)
{
    QC_TRY(CompletePositions(scene));
    return qcBodies_MarkStart(&scene->bodies);
}

qcStatus qcScene_MarkStart(qcScene* scene)
{
    QC_TRY(qcScene_CheckIdle(scene, "qcScene_MarkStart"));
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = MarkStart(scene);
    qcFloatMode_End(mode);
    QC_TRY(status);
    if (scene->recorder != NULL)
        qcSceneRecorder_MarkStart(scene->recorder);
    return qc_statusOk;
}

bool qcScene_IsValid(const qcScene* scene, qcBodyId id)
{
    if (scene == NULL || id.slot >= scene->bodies.slots.count || (id.generation & 1) == 0)
        return false;
    return QC_AT(qcBody, scene->bodies.slots, id.slot).generation == id.generation;
}

uint32_t qcScene_GetBodyCount(const qcScene* scene)
{
    return scene != NULL ? scene->bodies.count : 0;
}

__attribute__((noinline)) static qcStatus SetMargin(qcScene* scene, qcBodyId id, double margin)
{
    qcStatus status;
    qcBody* body = Find(scene, id, "qcScene_SetMargin", &status);
    if (body == NULL)
        return status;
    if (!(margin >= 0.0))
        return qcFail(qc_statusBadInput, "qcScene_SetMargin: body %u: the margin is %g; it must be 0 or more", id.slot,
                      margin);
    scene->bodies.revision += body->margin != margin;
    body->margin = margin;
    RECORD(scene, SetMargin, id.slot, margin);
    return qc_statusOk;
}

qcStatus qcScene_SetMargin(qcScene* scene, qcBodyId id, double margin)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = SetMargin(scene, id, margin);
    qcFloatMode_End(mode);
    return status;
}

qcStatus qcScene_WritePairs(qcScene* scene, const qcPairBufferDef* given)
{
    const char* function = "qcScene_WritePairs";
    QC_TRY(qcScene_CheckIdle(scene, function));
    QC_TRY(qcCheckPointer(given, function, "def"));
    qcPairBufferDef def = qcDefaultPairBufferDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT(function, qcPairBufferDef, capacity), &def));
    QC_TRY(qcDeviceBuffer_Check(def.buffer, scene->device, function));
    const qcResult* result = &scene->detector.result;
    if (!scene->detector.valid)
        return qcFail(qc_statusBadInput, "%s: there is no result", function);
    if (result->pairCount > def.capacity)
        return qcFail(qc_statusBadInput, "%s: there are %zu pairs; def->capacity is %u", function, result->pairCount,
                      def.capacity);
    if (def.offset % 4 != 0)
        return qcFail(qc_statusBadInput, "%s: def->offset is %llu; it must be a multiple of 4", function,
                      (unsigned long long)def.offset);
    _Static_assert(sizeof(qcPair) == 20, "five words, as the header says");
    const qcBufferRange room = {def.buffer, def.offset, 4 + sizeof(qcPair) * (uint64_t)def.capacity};
    return qcDeviceBuffer_Write(&room, result->pairs, result->pairCount, function);
}
