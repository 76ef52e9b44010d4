// Jobs for the methods, and the fallback after a device failure.
#include "pipeline/method_stage.h"

#include "base/status.h"
#include "pipeline/vertex_buffers.h"

#include <stdio.h>

static qcPairKeys LayersKeys(qcMethodStage* stage)
{
    return (qcPairKeys){&stage->layersKeys, &stage->layersContactKeys, &stage->layersClassified};
}

/// Sends the device's islands to the CPU after a failure, whose message is in qcLastMessage.
static void FallBack(qcMethodStage* stage, qcProfile* profile)
{
    snprintf(stage->fallback, sizeof stage->fallback, "%s: sweep answered on the CPU", qcLastMessage());
    qcLog("%s", stage->fallback);
    qcIslandRouting_LeaveDevice(&stage->routing);
    profile->partsOnDevice = 0;
    profile->method = qc_methodSweep;
    profile->fallback = stage->fallback;
}

/// Runs the islands on the device, from bodies to candidates.
static qcStatus RunLayers(const qcStep* step, const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                          qcMethodStage* stage, qcProfile* profile)
{
    stage->layersKeys.count = stage->layersContactKeys.count = stage->layersClassified.count = 0;
    if (profile->partsOnDevice == 0)
        return qc_statusOk;
    const qcCullLayersJob job = {.device = step->device,
                                 .triangles = triangles,
                                 .bodies = stage->routing.onDevice.data,
                                 .bodyPairs = pairs->pairs.data,
                                 .bodyPairCount = pairs->pairs.count,
                                 .queryDistance = step->queryDistance,
                                 .margin = step->def->margin,
                                 .testNeighbours = step->def->neighbours,
                                 .listClassified = step->def->contactMargin > 0.0,
                                 .columns = step->def->layerColumns,
                                 .depthAxis = step->def->layerDepthAxis,
                                 .timed = step->def->layerTimes,
                                 .threads = step->threads};
    const qcPairKeys keys = LayersKeys(stage);
    qcStatus status = qcCullLayers_Run(&job, &stage->layers, &keys, profile);
    if (status == qc_statusOk)
    {
        profile->method = qc_methodLayers;
        return qc_statusOk;
    }
    if (status != qc_statusDevice && status != qc_statusDeviceLost)
        return status;
    FallBack(stage, profile);
    return qc_statusOk;
}

static qcBvhCandidatesJob BvhJob(const qcStep* step, const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                                 const qcIslandRouting* routing)
{
    return (qcBvhCandidatesJob){.triangles = triangles,
                                .pairs = pairs,
                                .bodies = routing->onBvhs.data,
                                .neighboursOnly = routing->neighboursOnBvhs.data,
                                .queryDistance = step->queryDistance,
                                .margin = step->def->margin,
                                .contactMargin = step->def->contactMargin,
                                .testNeighbours = step->def->neighbours,
                                .listNeighbours = step->def->contactMargin > 0.0,
                                .threads = step->threads};
}

/// The sets of triangles of bodies that are handled elsewhere are undefined: they don't count.
static uint32_t CountInPcs(const qcStepTriangles* triangles, const uint8_t* handledElsewhere, const qcPcs* pcs)
{
    uint32_t count = 0;
    const uint8_t* sets = pcs->triangleSets.data;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        uint32_t end = handledElsewhere[body] ? 0 : qcStepTriangles_First(triangles, body + 1);
        for (uint32_t i = qcStepTriangles_First(triangles, body); i < end; i++)
            count += sets[i] != 0;
    }
    return count;
}

qcStatus qcMethodStage_Cull(const qcStep* step, const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                            qcMethodStage* stage, qcImageCull* imageCull, qcPcs* pcs, qcProfile* profile)
{
    qcIslandRouting* routing = &stage->routing;
    QC_TRY(qcIslandRouting_ChooseDevice(step, triangles, pairs, routing, profile));
    QC_TRY(RunLayers(step, triangles, pairs, stage, profile));
    QC_TRY(qcVertexBuffers_CompleteOthers(step, triangles, routing->onDevice.data, &profile->readBackBytes));
    const qcBvhCandidatesJob bvhJob = BvhJob(step, triangles, pairs, routing);
    QC_TRY(qcIslandRouting_PrepareBvhs(step, &bvhJob, &stage->bvhs, routing));
    qcVertexBuffers_LeaveFloats(triangles, pairs, routing->handledElsewhere.data);
    // The paper culls whole bodies at the sub-object level; brute force leaves out nothing.
    bool wholeBodies = step->plan.useImage || step->plan.method == qc_methodBrute;
    qcBodyPairs_MarkTriangles(pairs, triangles, step->queryDistance, wholeBodies, routing->handledElsewhere.data, pcs,
                              profile);
    if (step->plan.useImage)
    {
        const qcImageCullJob job = {step->device, &step->plan, step->def};
        QC_TRY(qcImageCull_Triangles(&job, triangles, imageCull, pcs));
    }
    profile->trianglePcs += CountInPcs(triangles, routing->handledElsewhere.data, pcs);
    return qc_statusOk;
}

/// Lists all neighbours of bodies on the device that have no BVH yet.
static qcStatus ListNeighbours(const qcStep* step, const qcStepTriangles* triangles, qcMethodStage* stage)
{
    for (uint32_t body = 0; qcStep_ListsNeighbours(step) && body < triangles->bodyCount; body++)
        if (QC_AT(uint8_t, stage->routing.onDevice, body) && !QC_AT(uint8_t, stage->routing.neighboursOnBvhs, body) &&
            qcBody_HasSelfCollision(qcStepTriangles_Body(triangles, body)))
            QC_TRY(qcCullLayers_ListNeighbours(&stage->layers, triangles, body, &stage->layersContactKeys));
    return qc_statusOk;
}

qcStatus qcMethodStage_Sweep(const qcStep* step, const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                             const qcPcs* pcs, qcMethodStage* stage, qcProfile* profile)
{
    const qcCandidateRules rules = {.triangles = triangles,
                                    .pcs = pcs,
                                    .handledElsewhere = stage->routing.handledElsewhere.data,
                                    .queryDistance = step->queryDistance,
                                    .testNeighbours = step->def->neighbours,
                                    .listNeighbours = step->def->contactMargin > 0.0,
                                    .threads = step->threads};
    if (step->plan.method == qc_methodBrute)
        QC_TRY(qcCandidates_Brute(&rules, &stage->candidates, profile));
    else
        QC_TRY(qcCandidates_Sweep(&rules, &stage->candidates, profile));
    const qcBvhCandidatesJob bvhJob = BvhJob(step, triangles, pairs, &stage->routing);
    QC_TRY(qcBvhCandidates_Run(&bvhJob, &stage->bvhs, &stage->candidates, profile));
    QC_TRY(ListNeighbours(step, triangles, stage));
    const qcPairKeys keys = LayersKeys(stage);
    return qcCandidates_Take(triangles, pcs, &keys, &stage->candidates);
}

void qcMethodStage_Free(qcMethodStage* stage)
{
    qcCandidates_Free(&stage->candidates);
    qcIslandRouting_Free(&stage->routing);
    qcCullLayers_Free(&stage->layers);
    qcArray_Free(&stage->layersKeys);
    qcArray_Free(&stage->layersContactKeys);
    qcArray_Free(&stage->layersClassified);
    qcBvhCandidates_Free(&stage->bvhs);
}
