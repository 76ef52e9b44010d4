// Slots are taken as in a scene: the lowest free one first.
#include "recording/recorded_bodies.h"

#include "base/status.h"

#include <assert.h>
#include <string.h>

qcStatus qcRecordedBodies_Add(qcRecordedBodies* bodies, uint32_t slot, bool deforming, uint32_t vertexCount)
{
    uint32_t free = bodies->lowestFree;
    while (free < bodies->slots.count && (QC_AT(qcRecordedBody, bodies->slots, free).generation & 1) != 0)
        free++;
    if (slot != free)
        return qcFail(qc_statusFile, "body %u is added, but the next free slot is %u", slot, free);
    if (free == bodies->slots.count)
        QC_TRY(qcArray_GrowZeroed(&bodies->slots, (size_t)free + 1, sizeof(qcRecordedBody), "the recorded bodies"));
    qcRecordedBody* body = &QC_AT(qcRecordedBody, bodies->slots, slot);
    body->generation++;
    body->deforming = deforming;
    body->vertexCount = vertexCount;
    bodies->lowestFree = slot + 1;
    return qc_statusOk;
}

qcStatus qcRecordedBodies_Find(const qcRecordedBodies* bodies, uint32_t slot, qcRecordedBody** body)
{
    if (slot >= bodies->slots.count || (QC_AT(qcRecordedBody, bodies->slots, slot).generation & 1) == 0)
        return qcFail(qc_statusFile, "body %u is not there", slot);
    *body = &QC_AT(qcRecordedBody, bodies->slots, slot);
    return qc_statusOk;
}

qcStatus qcRecordedBodies_Remove(qcRecordedBodies* bodies, uint32_t slot)
{
    qcRecordedBody* body = NULL;
    QC_TRY(qcRecordedBodies_Find(bodies, slot, &body));
    assert(body != NULL);
    qcPositionHistory_Free(&body->positions);
    body->generation++;
    if (slot < bodies->lowestFree)
        bodies->lowestFree = slot;
    return qc_statusOk;
}

qcStatus qcRecordedBodies_AddIndices(qcRecordedBodies* bodies, const uint32_t* indices, uint32_t triangleCount)
{
    size_t count = bodies->indexSets.count, bytes = 3 * sizeof(uint32_t) * triangleCount;
    QC_TRY(qcArray_Reserve(&bodies->indexSets, count + 1, sizeof(qcIndexSet), "the recorded indices"));
    qcIndexSet set = {qcAllocate(bytes), triangleCount, 0};
    if (bytes != 0 && set.indices == NULL)
        return qcFailMemory(bytes, "recorded indices");
    if (bytes != 0)
        memcpy(set.indices, indices, bytes);
    for (size_t i = 0; i < 3 * (size_t)triangleCount; i++)
        set.vertexCount = set.indices[i] >= set.vertexCount ? (uint64_t)set.indices[i] + 1 : set.vertexCount;
    QC_AT(qcIndexSet, bodies->indexSets, count) = set;
    bodies->indexSets.count = count + 1;
    return qc_statusOk;
}

void qcRecordedBodies_Free(qcRecordedBodies* bodies)
{
    for (size_t i = 0; i < bodies->indexSets.count; i++)
    {
        qcIndexSet* set = &QC_AT(qcIndexSet, bodies->indexSets, i);
        qcFree(set->indices, 3 * sizeof(uint32_t) * set->triangleCount);
    }
    for (size_t i = 0; i < bodies->slots.count; i++)
        qcPositionHistory_Free(&QC_AT(qcRecordedBody, bodies->slots, i).positions);
    qcArray_Free(&bodies->indexSets);
    qcArray_Free(&bodies->slots);
}
