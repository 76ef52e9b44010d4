// Sets each stage's flags of bodies, island by island.
#include "pipeline/island_routing.h"

#include "base/clock.h"
#include "base/status.h"

#include <string.h>

enum
{
    // The BVH of a body takes 4 KB at least. The boxes of so few triangles are as quickly found by a sweep.
    qc_maxSweptTriangles = 8
};

/// Marks islands for the device. `start`: when the stage began.
static void MarkIslands(const qcStep* step, const qcStepTriangles* triangles, double start, qcIslandRouting* routing,
                        qcProfile* profile)
{
    qcPlanItem* islands = routing->islands.items.data;
    size_t count = routing->islands.items.count;
    profile->parts = (uint32_t)count;
    if (step->plan.useLayers)
        for (size_t i = 0; i < count; i++)
            islands[i].onDevice = true;
    else if (qcPlan_IsWorthADevice(islands, count))
    {
        qcPlanCosts costs = step->measureCosts(step->device, step->threads);
        qcIslands_FindFinest(&routing->islands, triangles);
        qcPlan_ChooseIslands(&costs, &routing->history, islands, count, &routing->plannedTriangles);
        // A calibration is no part of the methods' costs.
        profile->planMs += qcClock_Now() - start;
    }
    for (size_t i = 0; i < count; i++)
        profile->partsOnDevice += islands[i].onDevice;
}

qcStatus qcIslandRouting_ChooseDevice(const qcStep* step, const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                                      qcIslandRouting* routing, qcProfile* profile)
{
    double start = qcClock_Now();
    uint32_t bodyCount = triangles->bodyCount;
    qcArray* flags[] = {&routing->onDevice, &routing->onBvhs, &routing->handledElsewhere, &routing->neighboursOnBvhs};
    for (int i = 0; i < 4; i++)
        QC_TRY(qcArray_Resize(flags[i], bodyCount, 1, "islands"));
    routing->plannedTriangles = 0.0;
    qcIslandRouting_LeaveDevice(routing);
    if (qcStep_UsesBvhs(step) || step->plan.useLayers || step->plan.chooseIslands)
        QC_TRY(qcIslands_Find(triangles, pairs, &routing->islands));
    if (!step->plan.useLayers && !step->plan.chooseIslands)
        return qc_statusOk;
    MarkIslands(step, triangles, start, routing, profile);
    for (uint32_t body = 0; body < bodyCount; body++)
    {
        uint32_t island = QC_AT(uint32_t, routing->islands.islandOf, body);
        QC_AT(uint8_t, routing->onDevice, body) =
            island != QC_NO_ISLAND && QC_AT(qcPlanItem, routing->islands.items, island).onDevice;
    }
    return qc_statusOk;
}

void qcIslandRouting_LeaveDevice(qcIslandRouting* routing)
{
    if (routing->onDevice.count != 0)
        memset(routing->onDevice.data, 0, routing->onDevice.count);
}

qcStatus qcIslandRouting_PrepareBvhs(const qcStep* step, const qcBvhCandidatesJob* job, qcBvhCandidates* bvhs,
                                     qcIslandRouting* routing)
{
    const qcStepTriangles* triangles = job->triangles;
    uint32_t bodyCount = triangles->bodyCount;
    uint8_t *onBvhs = routing->onBvhs.data, *neighbours = routing->neighboursOnBvhs.data;
    uint8_t* either = routing->handledElsewhere.data;
    const uint8_t* onDevice = routing->onDevice.data;
    for (uint32_t body = 0; body < bodyCount; body++)
    {
        onBvhs[body] = qcStep_UsesBvhs(step) && !onDevice[body];
        neighbours[body] = onDevice[body] && qcStep_ListsNeighbours(step) &&
                           qcBody_HasSelfCollision(qcStepTriangles_Body(triangles, body));
    }
    if (qcStep_UsesBvhs(step))
    {
        // Bodies without an island need no BVH.
        qcIslands_KeepWhole(&routing->islands, onBvhs);
        qcIslands_LeaveSmall(&routing->islands, triangles, qc_maxSweptTriangles, onBvhs);
        for (uint32_t body = 0; body < bodyCount; body++)
            either[body] = onBvhs[body] || neighbours[body];
        QC_TRY(qcBvhCandidates_Prepare(job, bvhs, either));
        for (uint32_t body = 0; body < bodyCount; body++)
        {
            onBvhs[body] = onBvhs[body] && either[body];
            neighbours[body] = neighbours[body] && either[body];
        }
        qcIslands_KeepWhole(&routing->islands, onBvhs);
    }
    for (uint32_t body = 0; body < bodyCount; body++)
        either[body] = onDevice[body] || onBvhs[body];
    return qc_statusOk;
}

void qcIslandRouting_Free(qcIslandRouting* routing)
{
    qcIslands_Free(&routing->islands);
    qcArray_Free(&routing->onDevice);
    qcArray_Free(&routing->onBvhs);
    qcArray_Free(&routing->handledElsewhere);
    qcArray_Free(&routing->neighboursOnBvhs);
}
