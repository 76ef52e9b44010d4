// plan, cull objects, sweep objects, cull triangles, sweep triangles, exact, contacts, manifolds: the line that data
// travels.
// Quick-CULLIDE, VR 2005, section 4.2, for the image methods; the others leave the cull stages out.
#include "pipeline/detect.h"

#include "pipeline/calibrate.h"
#include "base/clock.h"
#include "narrowphase/feature_contacts.h"
#include "base/status.h"

#include <stdio.h>
#include <string.h>

typedef struct Step
{
    qcDetector* detector;
    qcBodies* bodies;
    qcDevice* device;
    const qcDetectDef* def;
    qcPlan plan;
    uint32_t threads;
    qcProfile profile;
    double clock;
} Step;

/// Milliseconds since the last lap.
static double Lap(Step* step)
{
    double now = qcClock_Now(), ms = now - step->clock;
    step->clock = now;
    return ms;
}

/// The device has a share in the answer.
static void UseDevice(Step* step)
{
    qcDeviceInfo info = {.name = "none"};
    qcDevice_GetInfo(step->device, &info);
    step->profile.device = info.name;
    step->profile.softwareDevice = info.software;
}

static void Plan(Step* step)
{
    qcDeviceInfo info = {.kind = qc_deviceNone, .name = "none"};
    if (step->device != NULL)
        qcDevice_GetInfo(step->device, &info);
    qcPlanInput input = {step->def->method, step->def->resolution, info.kind != qc_deviceNone, info.compute,
                         info.maxResolution};
    step->plan = qcPlan_Make(&input);
    step->profile.method = step->plan.method;
    step->profile.fallback = step->plan.fallback;
    step->profile.resolution = step->plan.resolution;
    step->profile.device = "none";
    if (step->plan.useImage)
        UseDevice(step);
    if (step->plan.fallback != NULL)
        qcLog("%s", step->plan.fallback);
}

static qcStatus FindOwners(Step* step)
{
    if (step->def->contactMargin == 0.0)
        return qc_statusOk;
    for (size_t slot = 0; slot < step->bodies->slots.count; slot++)
        QC_TRY(qcBody_FindOwners(&QC_AT(qcBody, step->bodies->slots, slot), &step->detector->narrow.scratch));
    return qc_statusOk;
}

/// How far apart boxes may be whose triangles count. Boxes are compared as lower > upper + reach: rounding is monotone,
/// so that two boxes no further apart than the reach are never parted by it.
static double Reach(const qcDetectDef* def)
{
    double contacts = qcContactDistance(def->contactMargin);
    return def->margin > contacts ? def->margin : contacts;
}

static qcStatus CullAndSweepObjects(Step* step)
{
    qcDetector* d = step->detector;
    d->cull.records.count = 0;
    if (step->plan.useImage)
        QC_TRY(qcCull_Objects(&d->cull, &d->triangles, step->device, &step->plan, step->def));
    for (uint32_t body = 0; body < d->triangles.bodyCount; body++)
        step->profile.objectPcs += QC_AT(uint8_t, d->triangles.bodySet, body) != qc_setBfv &&
                                   qcStepTriangles_Body(&d->triangles, body)->triangleCount != 0;
    step->profile.cullObjectsMs = Lap(step);

    double margin = Reach(step->def);
    bool brute = step->plan.method == qc_methodBrute;
    if (brute)
        QC_TRY(qcBodyPairs_FindPairsBrute(&d->objects, &d->triangles, margin, &step->profile));
    else
        QC_TRY(qcBodyPairs_FindPairs(&d->objects, &d->triangles, margin, &step->profile));
    step->profile.sweepObjectsMs = Lap(step);
    return qc_statusOk;
}

/// The paper's methods sweep what their own culling leaves; brute force sweeps nothing.
static bool SweepsSurfaces(const Step* step)
{
    return !step->plan.useImage && step->plan.method != qc_methodBrute;
}

/// Which bodies the device answers for: all that take part, or those of the parts that the planner sends there.
static qcStatus ChooseParts(Step* step)
{
    qcDetector* d = step->detector;
    uint32_t bodyCount = d->triangles.bodyCount;
    QC_TRY(qcArray_Resize(&d->onDevice, bodyCount, 1, "parts of the scene"));
    d->plannedTriangles = 0.0;
    if (bodyCount != 0)
        memset(d->onDevice.data, 0, bodyCount);
    if (SweepsSurfaces(step) || step->plan.useLayers || step->plan.chooseIslands)
        QC_TRY(qcIslands_Find(&d->parts, &d->triangles, &d->objects));
    if (!step->plan.useLayers && !step->plan.chooseIslands)
        return qc_statusOk;
    qcPlanItem* parts = d->parts.parts.data;
    size_t count = d->parts.parts.count;
    step->profile.parts = (uint32_t)count;
    if (step->plan.useLayers)
        for (size_t i = 0; i < count; i++)
            parts[i].onDevice = true;
    else if (qcPlan_IsWorthADevice(parts, count))
    {
        qcPlanCosts costs = qcCalibrate(step->device, step->threads);
        qcPlan_ChooseIslands(&costs, &d->history, parts, count, &d->plannedTriangles);
        // Calibration is no part of the step's cost.
        step->profile.planMs += Lap(step);
    }
    for (size_t i = 0; i < count; i++)
        step->profile.partsOnDevice += parts[i].onDevice;
    for (uint32_t body = 0; body < bodyCount; body++)
    {
        uint32_t part = QC_AT(uint32_t, d->parts.partOf, body);
        QC_AT(uint8_t, d->onDevice, body) = part != QC_NO_ISLAND && parts[part].onDevice;
    }
    return qc_statusOk;
}

/// The device from bodies to candidates. What it can't do, the sweep does.
static qcStatus CullLayers(Step* step)
{
    qcDetector* d = step->detector;
    d->layersKeys.count = d->layersContactKeys.count = d->layersSure.count = 0;
    if (step->profile.partsOnDevice == 0)
        return qc_statusOk;
    qcCullLayersJob job = {.device = step->device,
                           .triangles = &d->triangles,
                           .bodies = d->onDevice.data,
                           .meetings = d->objects.pairs.data,
                           .meetingCount = d->objects.pairs.count,
                           .reach = Reach(step->def),
                           .nearest = step->def->margin,
                           .testNeighbours = step->def->neighbours,
                           .listKnown = step->def->contactMargin > 0.0,
                           .columns = step->def->layerColumns,
                           .depthAxis = step->def->layerDepthAxis,
                           .timed = step->def->layerTimes,
                           .threads = step->threads};
    const qcPairKeys keys = {&d->layersKeys, &d->layersContactKeys, &d->layersSure};
    qcStatus status = qcCullLayers_Run(&d->cullLayers, &job, &keys, &step->profile);
    if (status == qc_statusOk)
    {
        UseDevice(step);
        step->profile.method = qc_methodLayers;
        return qc_statusOk;
    }
    if (status != qc_statusDevice && status != qc_statusDeviceLost)
        return status;
    snprintf(d->fallback, sizeof d->fallback, "%s: sweep answered on the CPU", qcLastMessage());
    qcLog("%s", d->fallback);
    memset(d->onDevice.data, 0, d->onDevice.count);
    step->profile.partsOnDevice = 0;
    step->profile.method = qc_methodSweep;
    step->profile.fallback = d->fallback;
    return qc_statusOk;
}

/// Contacts are looked for between neighbours, too: a list apart from the others.
static bool ListsNeighbours(const Step* step)
{
    return step->def->contactMargin > 0.0 && !step->def->neighbours;
}

static qcBvhCandidatesJob SurfacesJob(const Step* step)
{
    qcDetector* d = step->detector;
    return (qcBvhCandidatesJob){.triangles = &d->triangles,
                                .objects = &d->objects,
                                .bodies = d->onSurfaces.data,
                                .neighbourBodies = d->neighboursOnSurfaces.data,
                                .margin = Reach(step->def),
                                .nearest = step->def->margin,
                                .contactMargin = step->def->contactMargin,
                                .testNeighbours = step->def->neighbours,
                                .listNeighbours = step->def->contactMargin > 0.0,
                                .threads = step->threads,
                                .candidates = &d->candidates};
}

/// Bodies whose surfaces are swept: all of a part of the scene, or none. And those that the device answers for, but for
/// their neighbours.
static qcStatus PrepareSurfaces(Step* step)
{
    qcDetector* d = step->detector;
    uint32_t bodyCount = d->triangles.bodyCount;
    qcArray* flags[] = {&d->onSurfaces, &d->neighboursOnSurfaces, &d->elsewhere};
    for (int i = 0; i < 3; i++)
        QC_TRY(qcArray_Resize(flags[i], bodyCount, 1, "parts of the scene"));
    uint8_t *onSurfaces = d->onSurfaces.data, *neighbours = d->neighboursOnSurfaces.data, *either = d->elsewhere.data;
    const uint8_t* onDevice = d->onDevice.data;
    for (uint32_t body = 0; body < bodyCount; body++)
    {
        onSurfaces[body] = SweepsSurfaces(step) && !onDevice[body];
        neighbours[body] = onDevice[body] && ListsNeighbours(step) &&
                           qcBody_HasSelfCollision(qcStepTriangles_Body(&d->triangles, body));
    }
    // What meets nothing needs no surface.
    if (SweepsSurfaces(step))
        qcIslands_Unite(&d->parts, onSurfaces);
    for (uint32_t body = 0; body < bodyCount; body++)
        either[body] = onSurfaces[body] || neighbours[body];
    qcBvhCandidatesJob job = SurfacesJob(step);
    if (SweepsSurfaces(step))
        QC_TRY(qcBvhCandidates_Prepare(&d->surfaces, &job, either));
    for (uint32_t body = 0; body < bodyCount; body++)
    {
        onSurfaces[body] = onSurfaces[body] && either[body];
        neighbours[body] = neighbours[body] && either[body];
    }
    if (SweepsSurfaces(step))
        qcIslands_Unite(&d->parts, onSurfaces);
    for (uint32_t body = 0; body < bodyCount; body++)
        either[body] = onDevice[body] || onSurfaces[body];
    return qc_statusOk;
}

/// Neighbours, all of them, of bodies that the device answers for and that have no surface yet.
static qcStatus ListNeighbours(Step* step)
{
    qcDetector* d = step->detector;
    for (uint32_t body = 0; ListsNeighbours(step) && body < d->triangles.bodyCount; body++)
        if (QC_AT(uint8_t, d->onDevice, body) && !QC_AT(uint8_t, d->neighboursOnSurfaces, body) &&
            qcBody_HasSelfCollision(qcStepTriangles_Body(&d->triangles, body)))
            QC_TRY(qcCullLayers_ListNeighbours(&d->cullLayers, &d->triangles, body, &d->layersContactKeys));
    return qc_statusOk;
}

static qcStatus SweepSurfaces(Step* step)
{
    qcBvhCandidatesJob job = SurfacesJob(step);
    return qcBvhCandidates_Run(&step->detector->surfaces, &job, &step->profile);
}

static qcStatus SweepTriangles(Step* step)
{
    qcDetector* d = step->detector;
    qcCandidateRules rules = {.triangles = &d->triangles,
                              .elsewhere = d->elsewhere.data,
                              .margin = Reach(step->def),
                              .testNeighbours = step->def->neighbours,
                              .listNeighbours = step->def->contactMargin > 0.0,
                              .threads = step->threads};
    if (step->plan.method == qc_methodBrute)
        QC_TRY(qcCandidates_Brute(&d->candidates, &rules, &step->profile));
    else
        QC_TRY(qcCandidates_Sweep(&d->candidates, &rules, &step->profile));
    QC_TRY(SweepSurfaces(step));
    QC_TRY(ListNeighbours(step));
    const qcPairKeys keys = {&d->layersKeys, &d->layersContactKeys, &d->layersSure};
    return qcCandidates_Add(&d->candidates, &d->triangles, &keys);
}

static uint32_t CountMarked(const uint8_t* marks, uint32_t count)
{
    uint32_t marked = 0;
    for (uint32_t i = 0; i < count; i++)
        marked += marks[i] != 0;
    return marked;
}

static qcStatus CullAndSweepTriangles(Step* step)
{
    qcDetector* d = step->detector;
    QC_TRY(ChooseParts(step));
    QC_TRY(CullLayers(step));
    QC_TRY(PrepareSurfaces(step));
    // The paper culls whole objects at the sub-object level; brute force leaves out nothing.
    bool wholeBodies = step->plan.useImage || step->plan.method == qc_methodBrute;
    QC_TRY(qcBodyPairs_MarkTriangles(&d->objects, &d->triangles, Reach(step->def), wholeBodies, d->elsewhere.data,
                                     &step->profile));
    if (step->plan.useImage)
        QC_TRY(qcCull_Triangles(&d->cull, &d->triangles, step->device, &step->plan, step->def));
    step->profile.trianglePcs += CountMarked(d->triangles.pcs.data, d->triangles.count);
    step->profile.cullTrianglesMs = Lap(step);
    QC_TRY(SweepTriangles(step));
    step->profile.sweepTrianglesMs = Lap(step);
    qcPlanHistory_Add(&d->history, step->profile.partsOnDevice != 0, d->plannedTriangles,
                      step->profile.cullTrianglesMs + step->profile.sweepTrianglesMs);
    return qc_statusOk;
}

static void Mark(uint64_t* marks, uint32_t rank)
{
    marks[rank / 64] |= UINT64_C(1) << rank % 64;
}

/// The PCS: what culling left, for the image methods, otherwise what is in a candidate pair. A bit a triangle: of most
/// scenes most are not marked.
static void MarkPcs(const Step* step, uint64_t* marks)
{
    const qcDetector* d = step->detector;
    for (uint32_t rank = 0; step->plan.useImage && rank < d->triangles.count; rank++)
        if (QC_AT(uint8_t, d->triangles.pcs, rank) != 0)
            Mark(marks, rank);
    const uint64_t* keys = d->candidates.keys.data;
    for (size_t i = 0; !step->plan.useImage && i < d->candidates.keys.count; i++)
    {
        Mark(marks, (uint32_t)(keys[i] >> 32));
        Mark(marks, (uint32_t)keys[i]);
    }
    const qcSortItem* sure = d->candidates.sure.data;
    for (size_t i = 0; i < d->candidates.sure.count; i++)
    {
        Mark(marks, (uint32_t)(sure[i].key >> 32));
        Mark(marks, (uint32_t)sure[i].key);
    }
}

/// The PCS as the result reports it.
static qcStatus CollectPcs(Step* step)
{
    qcDetector* d = step->detector;
    const qcStepTriangles* t = &d->triangles;
    size_t words = ((size_t)t->count + 63) / 64, count = 0, at = 0;
    QC_TRY(qcArray_Resize(&d->marks, words, sizeof(uint64_t), "the PCS"));
    uint64_t* marks = d->marks.data;
    if (words != 0)
        memset(marks, 0, words * sizeof *marks);
    MarkPcs(step, marks);
    for (size_t w = 0; w < words; w++)
        count += marks[w] != 0 ? (size_t)__builtin_popcountll(marks[w]) : 0;
    QC_TRY(qcArray_Resize(&d->pcs, count, sizeof(qcTriangleRef), "the PCS"));
    uint32_t body = 0;
    for (size_t w = 0; w < words; w++)
        for (uint64_t left = marks[w]; left != 0; left &= left - 1)
        {
            uint32_t rank = (uint32_t)(64 * w) + (uint32_t)__builtin_ctzll(left);
            while (rank >= qcStepTriangles_First(t, body + 1))
                body++;
            QC_AT(qcTriangleRef, d->pcs, at++) =
                (qcTriangleRef){qcStepTriangles_Slot(t, body), rank - qcStepTriangles_First(t, body)};
        }
    return qc_statusOk;
}

static qcStatus BuildManifolds(Step* step)
{
    qcDetector* d = step->detector;
    step->clock = qcClock_Now();
    size_t count = step->def->manifolds ? d->narrow.pairs.count : 0;
    qcManifoldInput input = {d->narrow.pairs.data, NULL, NULL, count, step->def->margin};
    if (step->def->proximities)
    {
        input.proximities = d->narrow.proximities.data;
        input.feet = d->narrow.feet.data;
    }
    QC_TRY(qcAllManifolds_Build(&d->manifolds, &d->triangles, &input, step->threads));
    step->profile.manifoldMs = Lap(step);
    return qc_statusOk;
}

static void FillResult(Step* step)
{
    qcDetector* d = step->detector;
    const qcArray* records = &d->cull.records;
    qcProfile* profile = &step->profile;
    for (size_t i = 0; i < records->count; i++)
    {
        profile->queries += QC_AT(qcPassRecord, *records, i).queries;
        profile->rendered += QC_AT(qcPassRecord, *records, i).rendered;
    }
    profile->passes = records->data;
    profile->passCount = records->count;
    d->result = (qcResult){.pairs = d->narrow.pairs.data,
                           .pairCount = d->narrow.pairs.count,
                           .segments = step->def->segments ? d->narrow.segments.data : NULL,
                           .proximities = step->def->proximities ? d->narrow.proximities.data : NULL,
                           .pcs = d->pcs.data,
                           .pcsCount = d->pcs.count,
                           .contacts = d->narrow.contacts.data,
                           .contactCount = d->narrow.contacts.count,
                           .manifolds = d->manifolds.manifolds.data,
                           .manifoldCount = d->manifolds.manifolds.count,
                           .manifoldPoints = d->manifolds.points.data,
                           .manifoldPointCount = d->manifolds.points.count,
                           .profile = *profile};
}

static qcStatus RunStages(Step* step)
{
    qcDetector* d = step->detector;
    double start = step->clock = qcClock_Now();
    Plan(step);
    QC_TRY(FindOwners(step));
    d->triangles.filter = step->def->pairFilter;
    d->triangles.filterContext = step->def->pairFilterContext;
    QC_TRY(qcStepTriangles_Number(&d->triangles, step->bodies));
    step->profile.bodies = d->triangles.bodyCount;
    step->profile.triangles = d->triangles.count;
    step->profile.planMs = Lap(step);
    QC_TRY(CullAndSweepObjects(step));
    QC_TRY(CullAndSweepTriangles(step));
    QC_TRY(CollectPcs(step));
    QC_TRY(qcNarrowphase_Run(&d->narrow, &d->triangles, &d->candidates, step->def, step->threads, &step->profile));
    QC_TRY(BuildManifolds(step));
    step->profile.totalMs = qcClock_Now() - start;
    FillResult(step);
    return qc_statusOk;
}

/// Would the same question be asked again? Fields, not bytes: padding has no meaning.
static bool IsSameQuestion(const qcDetectDef* a, const qcDetectDef* b)
{
    return a->pairFilter == NULL && b->pairFilter == NULL && a->method == b->method && a->margin == b->margin &&
           a->touching == b->touching && a->neighbours == b->neighbours && a->segments == b->segments &&
           a->proximities == b->proximities && a->manifolds == b->manifolds && a->contactMargin == b->contactMargin &&
           a->nearestContacts == b->nearestContacts && a->layerColumns == b->layerColumns &&
           a->layerDepthAxis == b->layerDepthAxis && strncmp(a->views, b->views, 4) == 0 &&
           a->resolution == b->resolution && a->iterations == b->iterations && a->backToFront == b->backToFront &&
           a->secondPassFromBack == b->secondPassFromBack && a->reliable == b->reliable;
}

static void Reuse(qcProfile* profile)
{
    profile->reused = true;
    profile->planMs = profile->cullObjectsMs = profile->sweepObjectsMs = profile->cullTrianglesMs = 0.0;
    profile->sweepTrianglesMs = profile->exactMs = profile->contactMs = profile->manifoldMs = 0.0;
    profile->totalMs = 0.0;
    profile->layerTimes = NULL;
    profile->layerTimeCount = 0;
}

qcStatus qcDetector_Run(qcDetector* detector, qcBodies* bodies, qcDevice* device, const qcDetectDef* def)
{
    if (detector->valid && detector->revision == bodies->revision && IsSameQuestion(&detector->def, def))
    {
        Reuse(&detector->result.profile);
        return qc_statusOk;
    }
    Step step = {.detector = detector,
                 .bodies = bodies,
                 .device = device,
                 .def = def,
                 .threads = qcParallel_Threads(def->threads)};
    detector->valid = false;
    QC_TRY(RunStages(&step));
    detector->valid = true;
    detector->revision = bodies->revision;
    detector->def = *def;
    return qc_statusOk;
}

void qcDetector_Free(qcDetector* detector)
{
    qcStepTriangles_Free(&detector->triangles);
    qcCull_Free(&detector->cull);
    qcCullLayers_Free(&detector->cullLayers);
    qcBodyPairs_Free(&detector->objects);
    qcIslands_Free(&detector->parts);
    qcBvhCandidates_Free(&detector->surfaces);
    qcArray_Free(&detector->onDevice);
    qcArray_Free(&detector->onSurfaces);
    qcArray_Free(&detector->elsewhere);
    qcArray_Free(&detector->neighboursOnSurfaces);
    qcArray_Free(&detector->layersKeys);
    qcArray_Free(&detector->layersContactKeys);
    qcArray_Free(&detector->layersSure);
    qcCandidates_Free(&detector->candidates);
    qcNarrowphase_Free(&detector->narrow);
    qcAllManifolds_Free(&detector->manifolds);
    qcArray_Free(&detector->pcs);
    qcArray_Free(&detector->marks);
}
