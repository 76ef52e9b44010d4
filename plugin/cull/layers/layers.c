// Which bodies take part, where they can meet, and what the device's answer means.
#include "cull/layers/layers.h"

#include "base/clock.h"
#include "gl/device.h"
#include "cull/layers/grid_resolution.h"
#include "base/status.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Step
{
    qcCullLayers* cull;
    const qcCullLayersJob* job;
    qcLayersView view;
    double started;
} Step;

static double Now(const qcCullLayersJob* job)
{
    return job->timed ? qcClock_Now() : 0.0;
}

static void IncludeBox(double lower[3], double upper[3], const qcBody* body)
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = body->lower[axis] < lower[axis] ? body->lower[axis] : lower[axis];
        upper[axis] = body->upper[axis] > upper[axis] ? body->upper[axis] : upper[axis];
    }
}

/// Bodies with a partner, or that meet themselves; and the view that holds them. False: none.
static bool FindParticipants(Step* step)
{
    const qcStepTriangles* t = step->job->triangles;
    uint8_t *takesPart = step->cull->takesPart.data, *self = step->cull->meetsItself.data;
    for (uint32_t body = 0; body < t->bodyCount; body++)
        takesPart[body] = self[body] =
            step->job->bodies[body] && qcBody_HasSelfCollision(qcStepTriangles_Body(t, body));
    for (size_t i = 0; i < 2 * step->job->meetingCount; i++)
        takesPart[step->job->meetings[i]] = step->job->bodies[step->job->meetings[i]];
    step->view = (qcLayersView){.lower = {DBL_MAX, DBL_MAX, DBL_MAX},
                                .upper = {-DBL_MAX, -DBL_MAX, -DBL_MAX},
                                .reach = step->job->reach,
                                .depthAxis = step->job->depthAxis};
    bool any = false;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(t, body);
        QC_AT(uint32_t, step->cull->numberOf, qcStepTriangles_Slot(t, body)) = body;
        if (!takesPart[body])
            continue;
        any = true;
        IncludeBox(step->view.lower, step->view.upper, b);
        step->view.transforms = step->view.transforms || !b->deforming;
    }
    return any;
}

/// A body that meets itself has interest in all of itself; another only in the boxes of its partners, taken together.
static qcStatus FindInterests(Step* step)
{
    qcCullLayers* cull = step->cull;
    const qcStepTriangles* t = step->job->triangles;
    QC_TRY(qcArray_Resize(&cull->partners, t->bodyCount, sizeof(qcLayersView), "interests of bodies"));
    qcLayersView* around = cull->partners.data;
    for (uint32_t body = 0; body < t->bodyCount; body++)
        around[body] = (qcLayersView){.lower = {DBL_MAX, DBL_MAX, DBL_MAX}, .upper = {-DBL_MAX, -DBL_MAX, -DBL_MAX}};
    for (size_t i = 0; i < step->job->meetingCount; i++)
    {
        uint32_t a = step->job->meetings[2 * i], b = step->job->meetings[2 * i + 1];
        IncludeBox(around[a].lower, around[a].upper, qcStepTriangles_Body(t, b));
        IncludeBox(around[b].lower, around[b].upper, qcStepTriangles_Body(t, a));
    }
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        bool all = QC_AT(uint8_t, cull->meetsItself, body) || !QC_AT(uint8_t, cull->takesPart, body);
        qcLayersFrame_MapBox(&cull->frame, all ? step->view.lower : around[body].lower,
                             all ? step->view.upper : around[body].upper,
                             &QC_AT(uint32_t, cull->interests, 4 * (size_t)body));
    }
    return qc_statusOk;
}

/// Does the device make the image only? Where GL is the processor itself, its vectors do the rest better. The
/// environment's QC_LAYERS_REFINE (device, processor) says who is to do it.
static bool LeavesImage(qcDevice* device)
{
    const char* wished = getenv("QC_LAYERS_REFINE");
    qcDeviceInfo info = {.software = false};
    qcDevice_GetInfo(device, &info);
    return wished != NULL && strcmp(wished, "device") == 0      ? false
           : wished != NULL && strcmp(wished, "processor") == 0 ? true
                                                                : info.software;
}

static qcStatus OpenDevice(qcCullLayers* cull, qcDevice* device)
{
    if (qcLayers_IsAlive(cull->layers))
        return qc_statusOk;
    qcLayers_Destroy(cull->layers);
    cull->layers = NULL;
    qcLayersBodies_Forget(&cull->bodies);
    cull->bodies.imageOnly = LeavesImage(device);
    return qcLayers_Create(device, cull->bodies.imageOnly, &cull->layers);
}

/// Pairs of triangles: from places on the device to ranks of the step.
static qcStatus MapPairs(const Step* step, const qcLayersAnswer* answer, qcArray* keys)
{
    const qcCullLayers* cull = step->cull;
    const qcStepTriangles* t = step->job->triangles;
    size_t at = keys->count;
    QC_TRY(qcArray_Resize(keys, at + answer->pairCount, sizeof(uint64_t), "candidates"));
    for (size_t i = 0; i < answer->pairCount; i++)
    {
        uint32_t rank[2];
        for (int side = 0; side < 2; side++)
        {
            uint32_t slot, triangle = qcLayersBodies_TriangleAt(&cull->bodies, answer->pairs[2 * i + side], &slot);
            rank[side] = qcStepTriangles_First(t, QC_AT(uint32_t, cull->numberOf, slot)) + triangle;
        }
        QC_AT(uint64_t, *keys, at + i) = qcStepTriangles_Key(rank[0], rank[1]);
    }
    return qc_statusOk;
}

static void FillProfile(const Step* step, const qcLayersStep* device, const qcLayersAnswer* answer, qcProfile* profile)
{
    const qcStepTriangles* t = step->job->triangles;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        profile->selfBodies += QC_AT(uint8_t, step->cull->meetsItself, body);
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
}

static const char* const s_partNames[qc_layersPartCount] = {
    "prepare",       "hand-over",      "upload", "vertices", "boxes",   "clear",     "nodes", "node pairs",
    "cluster pairs", "triangle pairs", "filter", "counters", "results", "hand-back", "refine"};

/// `handed` and `answered`: when the device's thread got the step, and gave it back.
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

/// In the frame, rounded down; below 0 where bodies have margins of their own: pairs that are near are then found by
/// the exact test.
static float FindMargin(const Step* step)
{
    const qcStepTriangles* t = step->job->triangles;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(t, body);
        if (QC_AT(uint8_t, step->cull->takesPart, body) &&
            qcBody_PairMargin(b, b, step->job->nearest) != step->job->nearest)
            return -1.0f;
    }
    return nextafterf((float)(step->job->nearest * step->cull->frame.unit), 0.0f);
}

static qcStatus Refine(Step* step, const qcLayersStep* device, qcLayersAnswer* answer, const qcPairKeys* keys)
{
    qcCullLayers* cull = step->cull;
    qcLayersRefineJob job = {.bodies = &cull->bodies,
                             .triangles = step->job->triangles,
                             .numberOf = cull->numberOf.data,
                             .image = &answer->image,
                             .pointError = cull->frame.pointError,
                             .reach = cull->frame.reach,
                             .margin = FindMargin(step),
                             .testNeighbours = step->job->testNeighbours,
                             .listKnown = step->job->listKnown,
                             .threads = step->job->threads};
    memcpy(job.cellsLog2, device->cellsLog2, sizeof job.cellsLog2);
    return qcLayersRefine_Run(&cull->refine, &job, keys, &answer->trianglePairs);
}

/// Fails without trying the device where its last failures are too recent.
static qcStatus CheckFailures(qcCullLayersFailures* failures, qcDevice* device)
{
    if (failures->generation != qcDevice_GetGeneration(device))
        *failures = (qcCullLayersFailures){.generation = qcDevice_GetGeneration(device)};
    if (failures->waiting == 0)
        return qc_statusOk;
    failures->waiting--;
    return qcFail(qc_statusDevice, "%s (next attempt in %u steps)", failures->reason, failures->waiting + 1);
}

/// A failure costs an upload and the kernels. After a single one the next step tries again, since the scene may have
/// changed; then 1, 3, 7 steps are left out, at last 127: less than a hundredth of the steps fail twice.
static void NoteFailure(qcCullLayersFailures* failures)
{
    snprintf(failures->reason, sizeof failures->reason, "%s", qcLastMessage());
    failures->waiting = (1u << (failures->count < 7 ? failures->count : 7)) - 1;
    failures->count++;
}

static qcStatus TryDevice(Step* step, const qcPairKeys* keys, qcProfile* profile)
{
    qcCullLayers* cull = step->cull;
    const qcCullLayersJob* job = step->job;
    QC_TRY(OpenDevice(cull, job->device));
    QC_TRY(FindInterests(step));
    QC_TRY(qcLayersBodies_Prepare(&cull->bodies, job->triangles, &cull->frame, cull->takesPart.data,
                                  cull->interests.data, cull->meetsItself.data, job->threads));
    qcLayersStep device = {.pointError = cull->frame.pointError,
                           .reach = cull->frame.reach,
                           .testNeighbours = job->testNeighbours,
                           .timed = job->timed};
    qcLayersBodies_FillStep(&cull->bodies, &device);
    qcLayersImage_Choose(&cull->bodies, job->triangles, &cull->frame, cull->numberOf.data, job->columns,
                         device.cellsLog2);
    memcpy(device.scale, cull->frame.scale, sizeof device.scale);
    memcpy(device.slack, cull->frame.slack, sizeof device.slack);
    qcLayersAnswer answer;
    double handed = Now(job);
    QC_TRY(qcLayers_Run(cull->layers, &device, &answer));
    double answered = Now(job);
    QC_TRY(cull->bodies.imageOnly ? Refine(step, &device, &answer, keys) : MapPairs(step, &answer, keys->keys));
    FillProfile(step, &device, &answer, profile);
    FillTimes(step, &answer, handed, answered, profile);
    return qc_statusOk;
}

static qcStatus RunOnDevice(Step* step, const qcPairKeys* keys, qcProfile* profile)
{
    qcCullLayers* cull = step->cull;
    if (!qcLayersFrame_Fit(&cull->frame, &step->view))
        return qcFail(qc_statusDevice, "layers: the scene is too large for a frame");
    QC_TRY(CheckFailures(&cull->failures, step->job->device));
    qcStatus status = TryDevice(step, keys, profile);
    if (status == qc_statusOk)
        cull->failures.count = 0;
    else if (status == qc_statusDevice)
        NoteFailure(&cull->failures);
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

qcStatus qcCullLayers_Run(qcCullLayers* cull, const qcCullLayersJob* job, const qcPairKeys* keys, qcProfile* profile)
{
    const qcStepTriangles* t = job->triangles;
    double started = Now(job);
    QC_TRY(qcArray_Resize(&cull->takesPart, t->bodyCount, 1, "bodies that take part"));
    QC_TRY(qcArray_Resize(&cull->meetsItself, t->bodyCount, 1, "bodies that take part"));
    QC_TRY(qcArray_Resize(&cull->interests, 4 * (size_t)t->bodyCount, sizeof(uint32_t), "interests of bodies"));
    QC_TRY(qcArray_Resize(&cull->numberOf, t->bodies->slots.count, sizeof(uint32_t), "bodies that take part"));
    Step step = {.cull = cull, .job = job, .started = started};
    if (!FindParticipants(&step))
        return qc_statusOk;
    qcStatus status = RunOnDevice(&step, keys, profile);
    if (status != qc_statusOk)
    {
        // What the device holds is unknown: the next attempt uploads everything.
        qcLayers_Destroy(cull->layers);
        cull->layers = NULL;
    }
    return status;
}

qcStatus qcCullLayers_ListNeighbours(const qcCullLayers* cull, const qcStepTriangles* triangles, uint32_t body,
                                     qcArray* keys)
{
    const qcClusters* clusters = qcLayersBodies_Clusters(&cull->bodies, qcStepTriangles_Slot(triangles, body));
    const uint32_t* links = clusters->firstLink.data;
    QC_TRY(qcArray_Reserve(keys, keys->count + clusters->neighbourCount, sizeof(uint64_t), "neighbours"));
    for (uint32_t node = 0; node < clusters->nodeCount; node++)
        for (uint32_t link = links[node]; link < links[node + 1]; link++)
            ListNeighboursOf(clusters, qcStepTriangles_First(triangles, body), node, link, keys);
    return qc_statusOk;
}

void qcCullLayers_Free(qcCullLayers* cull)
{
    qcLayers_Destroy(cull->layers);
    qcLayersBodies_Free(&cull->bodies);
    qcLayersRefine_Free(&cull->refine);
    qcArray_Free(&cull->takesPart);
    qcArray_Free(&cull->meetsItself);
    qcArray_Free(&cull->interests);
    qcArray_Free(&cull->partners);
    qcArray_Free(&cull->numberOf);
}
