// Operations are applied through the public functions.
#include "quickcullide/recording.h"

#include "base/status.h"

#include <stdio.h>

static qcStatus AddBody(const qcOperation* operation, qcScene* scene)
{
    qcBodyId id;
    QC_TRY(qcScene_AddBody(scene, &operation->body, &id));
    if (id.slot == operation->id.slot && id.generation == operation->id.generation)
        return qc_statusOk;
    qcScene_RemoveBody(scene, id);
    return qcFail(qc_statusBadInput, "the scene has had other operations: its next body is %u, generation %u", id.slot,
                  id.generation);
}

static qcStatus Apply(const qcOperation* o, qcScene* scene, const qcResult** result)
{
    const qcResult* unused;
    switch (o->kind)
    {
        case qc_operationEnd: return qc_statusOk;
        case qc_operationAddBody: return AddBody(o, scene);
        case qc_operationRemoveBody: return qcScene_RemoveBody(scene, o->id);
        case qc_operationSetTransform: return qcScene_SetTransform(scene, o->id, &o->transform);
        case qc_operationSetVertices: return qcScene_SetVertices(scene, o->id, o->positions, o->positionType, 0);
        case qc_operationSetActivity: return qcScene_SetActivity(scene, o->id, o->activity);
        case qc_operationSetFilter: return qcScene_SetFilter(scene, o->id, o->group, o->mask);
        case qc_operationSetSelfCollision: return qcScene_SetSelfCollision(scene, o->id, o->selfCollision);
        case qc_operationSetMargin: return qcScene_SetMargin(scene, o->id, o->margin);
        case qc_operationMarkStart: return qcScene_MarkStart(scene);
        case qc_operationDetect: return qcScene_Detect(scene, &o->detect, result != NULL ? result : &unused);
    }
    return qcFail(qc_statusBadInput, "unknown operation %d", (int)o->kind);
}

qcStatus qcOperation_Apply(const qcOperation* operation, qcScene* scene, const qcResult** result)
{
    if (operation == NULL)
        return qcFail(qc_statusBadInput, "qcOperation_Apply: operation is null");
    qcStatus status = Apply(operation, scene, result);
    if (status == qc_statusOk)
        return status;
    char reason[400];
    snprintf(reason, sizeof reason, "%s", qcLastMessage());
    return qcFail(status, "operation %llu at byte %llu (%s): %s", (unsigned long long)operation->number,
                  (unsigned long long)operation->byteOffset, qcOperationKind_Name(operation->kind), reason);
}
