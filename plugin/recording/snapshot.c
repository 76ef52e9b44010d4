// First the bodies that have a start, at their start, and empty ones for all other slots; then the start is marked;
// then the bodies without one are added, in ascending order, each to the slot that was freed for it; last all move to
// the present.
#include "recording/snapshot.h"

/// Adds a body at its start, if it has one and differs, otherwise at its present.
static void Add(qcSceneRecorder* recorder, const qcBody* body, uint32_t slot)
{
    const qcBodyStart* start = &body->start;
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = !body->deforming ? body->local : start->differs ? start->world : body->world;
    def.positionType = qc_positionF64;
    def.vertexCount = body->vertexCount;
    def.indices = body->indices;
    def.triangleCount = body->triangleCount;
    def.deforming = body->deforming;
    def.transform = start->differs ? start->transform : body->transform;
    def.activity = body->activity;
    def.group = body->group;
    def.mask = body->mask;
    def.owner = body->owner;
    def.selfCollision = body->selfCollision;
    def.margin = body->margin;
    qcSceneRecorder_AddBody(recorder, slot, &def);
}

/// From its start to its present.
static void Move(qcSceneRecorder* recorder, const qcBody* body, uint32_t slot)
{
    if (body->deforming)
        qcSceneRecorder_SetVertices(recorder, slot, body->world, qc_positionF64, 0, body->vertexCount);
    else
        qcSceneRecorder_SetTransform(recorder, slot, &body->transform);
}

void qcSnapshot_Write(qcSceneRecorder* recorder, const qcBodies* bodies)
{
    const qcBodyDef empty = qcDefaultBodyDef();
    const qcBody* slots = bodies->slots.data;
    uint32_t count = (uint32_t)bodies->slots.count;
    bool anyMarked = false;
    for (uint32_t i = 0; i < count; i++)
        anyMarked |= qcBody_IsUsed(&slots[i]) && slots[i].start.isMarked;
    for (uint32_t i = 0; i < count; i++)
        if (qcBody_IsUsed(&slots[i]) && slots[i].start.isMarked == anyMarked)
            Add(recorder, &slots[i], i);
        else
            qcSceneRecorder_AddBody(recorder, i, &empty);
    if (anyMarked)
        qcSceneRecorder_MarkStart(recorder);
    for (uint32_t i = 0; i < count; i++)
        if (qcBody_IsUsed(&slots[i]) && slots[i].start.isMarked != anyMarked)
        {
            qcSceneRecorder_RemoveBody(recorder, i);
            Add(recorder, &slots[i], i);
        }
    for (uint32_t i = 0; i < count; i++)
        if (qcBody_IsFree(&slots[i]))
            qcSceneRecorder_RemoveBody(recorder, i);
        else if (slots[i].start.differs)
            Move(recorder, &slots[i], i);
}
