// Selects the bodies that take part, runs the device's step, and converts its pairs to candidate keys.
#include "cull/layers/layers.h"

#include "base/aabb.h"
#include "base/clock.h"
#include "base/related_pair.h"
#include "base/status.h"
#include "cull/layers/device_pairs.h"
#include "gl/device.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Step
{
    qcCullLayers* cull;
    const qcCullLayersJob* job;
    qcGridBounds bounds;
    double started;
} Step;

static double Now(const qcCullLayersJob* job)
{
    return job->timed ? qcClock_Now() : 0.0;
}

/// Flags bodies with a partner or with self-collision, and finds their bounds. False: there are none.
static bool FindParticipants(Step* step)
{
    const qcStepTriangles* t = step->job->triangles;
    uint8_t *takesPart = step->cull->takesPart.data, *self = step->cull->hasSelfPairs.data;
    for (uint32_t body = 0; body < t->bodyCount; body++)
        takesPart[body] = self[body] =
            step->job->bodies[body] && qcBody_HasSelfCollision(qcStepTriangles_Body(t, body));
    for (size_t i = 0; i < step->job->bodyPairCount; i++)
        for (int side = 0; side < 2; side++)
        {
            uint32_t body = step->job->bodyPairs[i][side];
            takesPart[body] = step->job->bodies[body];
        }
    step->bounds = (qcGridBounds){.queryDistance = step->job->queryDistance, .depthAxis = step->job->depthAxis};
    qcBounds_Clear(step->bounds.lower, step->bounds.upper);
    bool any = false;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(t, body);
        QC_AT(uint32_t, step->cull->bodyOf, qcStepTriangles_Slot(t, body)) = body;
        if (!takesPart[body])
            continue;
        any = true;
        qcBounds_IncludeBox(b->lower, b->upper, step->bounds.lower, step->bounds.upper);
        step->bounds.transforms = step->bounds.transforms || !b->deforming;
    }
    return any;
}

/// The AABB of each body's partners; for a body with self-collision the bounds of all bodies.
static qcStatus FindPartnerBoxes(const Step* step)
{
    qcCullLayers* cull = step->cull;
    const qcStepTriangles* t = step->job->triangles;
    QC_TRY(qcArray_Resize(&cull->partners, t->bodyCount, sizeof(qcBounds), "boxes of partners"));
    qcBounds* around = cull->partners.data;
    for (uint32_t body = 0; body < t->bodyCount; body++)
        qcBounds_Clear(around[body].lower, around[body].upper);
    for (size_t i = 0; i < step->job->bodyPairCount; i++)
    {
        uint32_t a = step->job->bodyPairs[i][0], b = step->job->bodyPairs[i][1];
        const qcBody *bodyA = qcStepTriangles_Body(t, a), *bodyB = qcStepTriangles_Body(t, b);
        qcBounds_IncludeBox(bodyB->lower, bodyB->upper, around[a].lower, around[a].upper);
        qcBounds_IncludeBox(bodyA->lower, bodyA->upper, around[b].lower, around[b].upper);
    }
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        bool all = QC_AT(uint8_t, cull->hasSelfPairs, body) || !QC_AT(uint8_t, cull->takesPart, body);
        qcGridFrame_MapBox(&cull->frame, all ? step->bounds.lower : around[body].lower,
                           all ? step->bounds.upper : around[body].upper,
                           &QC_AT(uint32_t, cull->partnerBoxes, 4 * (size_t)body));
    }
    return qc_statusOk;
}

/// Whether the device makes the image alone: with software GL the CPU kernels refine it faster. The environment
/// variable QC_LAYERS_REFINE (device, processor) decides otherwise.
static bool RefinesOnCpu(qcDevice* device)
{
    const char* choice = getenv("QC_LAYERS_REFINE");
    if (choice != NULL && strcmp(choice, "device") == 0)
        return false;
    if (choice != NULL && strcmp(choice, "processor") == 0)
        return true;
    qcDeviceInfo info = {.software = false};
    qcDevice_GetInfo(device, &info);
    return info.software;
}

static qcStatus OpenDevice(qcCullLayers* cull, qcDevice* device)
{
    if (qcLayers_IsAlive(cull->layers))
        return qc_statusOk;
    qcLayers_Destroy(cull->layers);
    cull->layers = NULL;
    qcGpuResidency_Forget(&cull->residency);
    cull->residency.imageOnly = RefinesOnCpu(device);
    QC_TRY(qcLayers_Create(device, cull->residency.imageOnly, &cull->layers));
    cull->residency.sharesVertices = qcLayers_SharesVertices(cull->layers);
    return qc_statusOk;
}

static qcStatus TakePairs(const Step* step, const qcLayersAnswer* answer, const qcPairKeys* keys)
{
    const qcDevicePairs pairs = {answer->pairs, answer->pairCount, step->job->listClassified, step->job->threads};
    return qcDevicePairs_Take(&pairs, &step->cull->sureBefore, keys);
}

static void FillProfile(const Step* step, const qcLayersStep* device, const qcLayersAnswer* answer, qcProfile* profile)
{
    const qcStepTriangles* t = step->job->triangles;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        profile->selfBodies += QC_AT(uint8_t, step->cull->hasSelfPairs, body);
        if (QC_AT(uint8_t, step->cull->takesPart, body))
            profile->trianglePcs += qcStepTriangles_Body(t, body)->triangleCount;
    }
    profile->skippedTriangles += (uint32_t)(answer->skippedNodes * qc_nodeSize);
    if (answer->entries != 0)
    {
        profile->columns = 1u << device->cellsLog2[0];
        profile->rows = 1u << device->cellsLog2[1];
        profile->slices = 1u << device->cellsLog2[2];
    }
    profile->fragments = answer->entries;
    profile->listPairs = answer->trianglePairs;
    profile->reruns = answer->reruns;
    profile->uploadedBytes = answer->uploadedBytes;
    profile->deviceBytes = answer->deviceBytes;
    profile->deviceCalls = answer->glCalls;
    profile->deviceWaits = answer->waits;
}

static const char* const s_partNames[qc_layersPartCount] = {
    "prepare",        "hand-over",  "upload", "vertices", "boxes",  "nodes",     "node pairs",
    "triangle pairs", "pair tests", "order",  "wait",     "timers", "hand-back", "refine"};

/// `handed`, `answered`: when the step went to the device's thread and came back.
static void FillTimes(const Step* step, const qcLayersAnswer* answer, double handed, double answered,
                      qcProfile* profile)
{
    qcLayerTime* times = step->cull->times;
    if (!step->job->timed)
        return;
    for (int part = 0; part < qc_layersPartCount; part++)
        times[part] = (qcLayerTime){s_partNames[part], answer->threadMs[part], answer->deviceMs[part]};
    times[qc_partPrepare].threadMs = handed - step->started;
    times[qc_partRefine].threadMs = qcClock_Now() - answered;
    profile->layerTimes = times;
    profile->layerTimeCount = qc_layersPartCount;
}

/// The margin in the frame, rounded down, for the classification of near pairs. Below 0 if bodies have margins of their
/// own: then there is none, and the exact test finds them.
static float FindMargin(const Step* step)
{
    const qcStepTriangles* t = step->job->triangles;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(t, body);
        if (QC_AT(uint8_t, step->cull->takesPart, body) &&
            qcBody_PairMargin(b, b, step->job->margin) != step->job->margin)
            return -1.0f;
    }
    return nextafterf((float)(step->job->margin * step->cull->frame.unit), 0.0f);
}

static qcStatus Refine(Step* step, const qcLayersStep* device, qcLayersAnswer* answer, const qcPairKeys* keys)
{
    qcCullLayers* cull = step->cull;
    qcCpuRefineJob job = {.residency = &cull->residency,
                          .triangles = step->job->triangles,
                          .bodyOf = cull->bodyOf.data,
                          .image = &answer->image,
                          .pointError = cull->frame.pointError,
                          .queryDistance = cull->frame.queryDistance,
                          .margin = FindMargin(step),
                          .testNeighbours = step->job->testNeighbours,
                          .listClassified = step->job->listClassified,
                          .threads = step->job->threads};
    memcpy(job.cellsLog2, device->cellsLog2, sizeof job.cellsLog2);
    return qcCpuRefine_Run(&job, &cull->refine, keys, &answer->trianglePairs);
}

static uint64_t CountTriangles(const Step* step)
{
    const qcStepTriangles* t = step->job->triangles;
    uint64_t count = 0;
    for (uint32_t body = 0; body < t->bodyCount; body++)
        count += QC_AT(uint8_t, step->cull->takesPart, body) ? qcStepTriangles_Body(t, body)->triangleCount : 0;
    return count;
}

/// Fails without an attempt while the device is paused after failures.
static qcStatus CheckFailures(const Step* step)
{
    qcCullLayersFailures* failures = &step->cull->failures;
    uint32_t generation = qcDevice_GetGeneration(step->job->device);
    if (failures->generation != generation)
        *failures = (qcCullLayersFailures){.generation = generation};
    if (failures->waiting == 0)
        return qc_statusOk;
    uint64_t triangles = CountTriangles(step);
    if (2 * triangles <= failures->minTriangles || triangles >= 2 * failures->maxTriangles)
        return qc_statusOk;
    failures->waiting--;
    return qcFail(qc_statusDevice, "%s (next attempt in %u steps)", failures->reason, failures->waiting + 1);
}

/// Sets the number of steps without an attempt. A failure costs an upload and the kernels. After the first failure the
/// next step tries again, since the scene may have changed; further ones in a row pause the device for 1, 3, 7, ... up
/// to 127 steps. In the long run less than one step in a hundred fails on the device.
static void CountFailure(const Step* step)
{
    qcCullLayersFailures* failures = &step->cull->failures;
    uint64_t triangles = CountTriangles(step);
    failures->minTriangles =
        failures->count > 0 && failures->minTriangles < triangles ? failures->minTriangles : triangles;
    failures->maxTriangles =
        failures->count > 0 && failures->maxTriangles > triangles ? failures->maxTriangles : triangles;
    snprintf(failures->reason, sizeof failures->reason, "%s", qcLastMessage());
    failures->waiting = (1u << (failures->count < 7 ? failures->count : 7)) - 1;
    failures->count++;
}

static qcStatus TryDevice(Step* step, const qcPairKeys* keys, qcProfile* profile)
{
    qcCullLayers* cull = step->cull;
    const qcCullLayersJob* job = step->job;
    QC_TRY(OpenDevice(cull, job->device));
    QC_TRY(FindPartnerBoxes(step));
    const qcResidencyJob residencyJob = {.triangles = job->triangles,
                                         .frame = &cull->frame,
                                         .takesPart = cull->takesPart.data,
                                         .hasSelfPairs = cull->hasSelfPairs.data,
                                         .partnerBoxes = cull->partnerBoxes.data,
                                         .threads = job->threads};
    QC_TRY(qcGpuResidency_Prepare(&residencyJob, &cull->residency));
    qcLayersStep device = {
        .triangleCount = job->triangles->count, .testNeighbours = job->testNeighbours, .timed = job->timed};
    qcGpuResidency_FillStep(&cull->residency, &cull->frame, &device);
    if (cull->residency.imageOnly)
        qcGridResolution_Choose(&cull->residency, job->triangles, &cull->frame, cull->bodyOf.data, job->columns,
                                &cull->gridSamples, device.cellsLog2);
    qcLayersMemory memory;
    QC_TRY(qcLayers_Open(cull->layers, &device, &memory));
    qcGpuResidency_WriteVertices(&residencyJob, &cull->residency, &memory);
    qcLayersAnswer answer;
    device.started = Now(job);
    QC_TRY(qcLayers_Run(cull->layers, &device, &answer));
    double answered = Now(job);
    QC_TRY(cull->residency.imageOnly ? Refine(step, &device, &answer, keys) : TakePairs(step, &answer, keys));
    FillProfile(step, &device, &answer, profile);
    FillTimes(step, &answer, device.started, answered, profile);
    return qc_statusOk;
}

static qcStatus RunOnDevice(Step* step, const qcPairKeys* keys, qcProfile* profile)
{
    qcCullLayers* cull = step->cull;
    if (!qcGridFrame_Fit(&cull->frame, &step->bounds))
        return qcFail(qc_statusDevice, "layers: the scene is too large for a frame");
    QC_TRY(CheckFailures(step));
    QC_TRY(qcDevice_Hold(step->job->device, "layers"));
    qcStatus status = TryDevice(step, keys, profile);
    qcDevice_Release(step->job->device);
    if (status == qc_statusOk)
        cull->failures.count = cull->failures.waiting = 0;
    else if (status == qc_statusDevice)
        CountFailure(step);
    return status;
}

static void ListNeighboursOf(const qcClusters* clusters, uint32_t first, uint32_t node, uint32_t link, qcArray* keys)
{
    const uint32_t* triangles = clusters->triangles.data;
    qcSlotPair pairs[qc_nodeSize * qc_nodeSize];
    const qcSlotPair* end = qcClusters_FindNeighbours(clusters, node, link, pairs);
    for (const qcSlotPair* pair = pairs; pair < end; pair++)
        QC_AT(uint64_t, *keys, keys->count++) =
            qcStepTriangles_Key(first + triangles[pair->a], first + triangles[pair->b]);
}

qcStatus qcCullLayers_Run(const qcCullLayersJob* job, qcCullLayers* cull, const qcPairKeys* keys, qcProfile* profile)
{
    const qcStepTriangles* t = job->triangles;
    double started = Now(job);
    QC_TRY(qcArray_Resize(&cull->takesPart, t->bodyCount, 1, "bodies that take part"));
    QC_TRY(qcArray_Resize(&cull->hasSelfPairs, t->bodyCount, 1, "bodies that take part"));
    QC_TRY(qcArray_Resize(&cull->partnerBoxes, 4 * (size_t)t->bodyCount, sizeof(uint32_t), "boxes of partners"));
    QC_TRY(qcArray_Resize(&cull->bodyOf, t->bodies->slots.count, sizeof(uint32_t), "bodies that take part"));
    Step step = {.cull = cull, .job = job, .started = started};
    if (!FindParticipants(&step))
        return qc_statusOk;
    qcStatus status = RunOnDevice(&step, keys, profile);
    if (status != qc_statusOk)
    {
        // The device's contents are undefined: the next attempt uploads everything.
        qcLayers_Destroy(cull->layers);
        cull->layers = NULL;
    }
    return status;
}

qcStatus qcCullLayers_ListNeighbours(const qcCullLayers* cull, const qcStepTriangles* triangles, uint32_t body,
                                     qcArray* keys)
{
    const qcClusters* clusters = qcGpuResidency_Clusters(&cull->residency, qcStepTriangles_Slot(triangles, body));
    const uint32_t* links = clusters->firstLink.data;
    QC_TRY(qcRelatedPair_CheckCount(keys->count + clusters->neighbourCount, triangles->maxPairs));
    QC_TRY(qcArray_Reserve(keys, keys->count + clusters->neighbourCount, sizeof(uint64_t), "neighbours"));
    for (uint32_t node = 0; node < clusters->nodeCount; node++)
        for (uint32_t link = links[node]; link < links[node + 1]; link++)
            ListNeighboursOf(clusters, qcStepTriangles_First(triangles, body), node, link, keys);
    return qc_statusOk;
}

void qcCullLayers_Free(qcCullLayers* cull)
{
    qcLayers_Destroy(cull->layers);
    qcGpuResidency_Free(&cull->residency);
    qcCpuRefine_Free(&cull->refine);
    qcArray_Free(&cull->takesPart);
    qcArray_Free(&cull->hasSelfPairs);
    qcArray_Free(&cull->partnerBoxes);
    qcArray_Free(&cull->partners);
    qcArray_Free(&cull->bodyOf);
    qcArray_Free(&cull->sureBefore);
}
