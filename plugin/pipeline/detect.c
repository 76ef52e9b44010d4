// plan, cull bodies, sweep bodies, cull triangles, sweep triangles, exact tests, contacts, manifolds, in this order.
// Quick-CULLIDE, VR 2005, section 4.2, for the image methods; the others leave the cull stages out.
#include "pipeline/detect.h"

#include "base/clock.h"
#include "base/parallel_for.h"
#include "base/status.h"
#include "gl/buffers/vertex_snapshot.h"
#include "scene/feature_owners.h"

#include <string.h>

enum
{
    // A step with so many triangles takes about 20 times as long as waking a thread.
    qc_minThreadedTriangles = 16384,
    // Where a GPU does the rest, the loops before it copy positions: of so many triangles in 0.1 ms.
    qc_minThreadedOnGpu = 131072
};

/// Returns the milliseconds since *last, and sets *last to now.
static double Lap(double* last)
{
    double now = qcClock_Now(), ms = now - *last;
    *last = now;
    return ms;
}

static qcPlan MakePlan(const qcDetectDef* def, qcDevice* device)
{
    qcDeviceInfo info = {.kind = qc_deviceNone, .name = "none"};
    if (device != NULL)
        qcDevice_GetInfo(device, &info);
    const qcPlanInput input = {def->method,  def->resolution,    info.kind != qc_deviceNone,
                               info.compute, info.maxResolution, def->motion};
    return qcPlan_Make(&input);
}

static void ReportPlan(const qcPlan* plan, qcProfile* profile)
{
    profile->method = plan->method;
    profile->fallback = plan->fallback;
    profile->resolution = plan->resolution;
    profile->device = "none";
    if (plan->fallback != NULL)
        qcLog("%s", plan->fallback);
}

/// Names the device in the profile if it had a share in the result.
static void ReportDevice(const qcStep* step, qcProfile* profile)
{
    if (!step->plan.useImage && profile->partsOnDevice == 0)
        return;
    qcDeviceInfo info = {.name = "none"};
    qcDevice_GetInfo(step->device, &info);
    profile->device = info.name;
    profile->softwareDevice = info.software;
}

/// Threads for the loops up to the sweep, or to a GPU's work. `auto` will likely choose as before.
static uint32_t ThreadsOfLoops(const qcStep* step, const qcPlanHistory* history, uint32_t triangles)
{
    qcDeviceInfo info = {.software = true};
    bool isOnDevice = step->plan.method == qc_methodLayers || (step->plan.method == qc_methodAuto && history->onDevice);
    if (isOnDevice && step->device != NULL)
        qcDevice_GetInfo(step->device, &info);
    return triangles < (info.software ? qc_minThreadedTriangles : qc_minThreadedOnGpu) ? 1 : step->threads;
}

/// Numbers the step's bodies and triangles; finds the owners of features for contacts; wakes threads.
static qcStatus BeginStep(const qcStep* step, const qcPlanHistory* history, qcBodies* bodies,
                          qcStepTriangles* triangles, qcPcs* pcs, qcProfile* profile)
{
    for (size_t slot = 0; slot < bodies->slots.count && step->def->contactMargin != 0.0; slot++)
        QC_TRY(qcBody_FindFeatureOwners(&QC_AT(qcBody, bodies->slots, slot)));
    triangles->filter = step->def->pairFilter;
    triangles->filterContext = step->def->pairFilterContext;
    triangles->motion = step->def->motion;
    triangles->maxPairs = step->def->maxPairs != 0 ? step->def->maxPairs : UINT64_MAX;
    QC_TRY(qcStepTriangles_Number(triangles, bodies));
    bodies->threads = ThreadsOfLoops(step, history, triangles->count);
    qcParallel_Wake(bodies->threads);
    QC_TRY(qcPcs_Reset(triangles->bodyCount, triangles->count, pcs));
    profile->bodies = triangles->bodyCount;
    profile->triangles = triangles->count;
    return qc_statusOk;
}

static qcStatus CullBodies(const qcStep* step, const qcStepTriangles* triangles, qcImageCull* cull, qcPcs* pcs,
                           qcProfile* profile)
{
    cull->records.count = 0;
    if (step->plan.useImage)
    {
        const qcImageCullJob job = {step->device, &step->plan, step->def};
        QC_TRY(qcImageCull_Bodies(&job, triangles, cull, pcs));
    }
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        profile->objectPcs += QC_AT(uint8_t, pcs->bodySets, body) != qc_setBfv &&
                              qcStepTriangles_Body(triangles, body)->triangleCount != 0;
    return qc_statusOk;
}

static qcStatus SweepBodies(const qcStep* step, const qcStepTriangles* triangles, const qcPcs* pcs, qcBodyPairs* pairs,
                            qcProfile* profile)
{
    if (step->plan.method == qc_methodBrute)
        return qcBodyPairs_FindBrute(triangles, pcs, step->queryDistance, pairs, profile);
    return qcBodyPairs_Find(triangles, pcs, step->queryDistance, pairs, profile);
}

static qcStatus BuildManifolds(const qcStep* step, const qcStepTriangles* triangles, const qcNarrowphase* narrowphase,
                               qcAllManifolds* manifolds)
{
    size_t count = step->def->manifolds ? narrowphase->pairs.count : 0;
    qcManifoldInput input = {.pairs = narrowphase->pairs.data,
                             .count = count,
                             .margin = step->def->margin,
                             .spacing = step->def->spacing,
                             .unoriented = step->def->unoriented};
    if (step->def->proximities)
    {
        input.proximities = narrowphase->proximities.data;
        input.features = narrowphase->closestFeatures.data;
    }
    return qcAllManifolds_Build(manifolds, triangles, &input, step->threads);
}

static void ReportPasses(const qcArray* records, qcProfile* profile)
{
    for (size_t i = 0; i < records->count; i++)
    {
        profile->queries += QC_AT(qcPassRecord, *records, i).queries;
        profile->rendered += QC_AT(qcPassRecord, *records, i).rendered;
    }
    profile->passes = records->data;
    profile->passCount = records->count;
}

static qcResult MakeResult(const qcDetector* d, const qcDetectDef* def, const qcProfile* profile)
{
    const qcNarrowphase* n = &d->narrowphase;
    return (qcResult){.pairs = n->pairs.data,
                      .pairCount = n->pairs.count,
                      .segments = def->segments ? n->segments.data : NULL,
                      .proximities = def->proximities ? n->proximities.data : NULL,
                      .pcs = d->pcsReport.triangles.data,
                      .pcsCount = d->pcsReport.triangles.count,
                      .pcsSets = def->sets && d->pcsReport.sets.count != 0 ? d->pcsReport.sets.data : NULL,
                      .candidates = def->candidates ? d->pcsReport.pairs.data : NULL,
                      .candidateCount = d->pcsReport.pairs.count,
                      .contacts = n->contacts.data,
                      .contactCount = n->contacts.count,
                      .manifolds = d->manifolds.manifolds.data,
                      .manifoldCount = d->manifolds.manifolds.count,
                      .manifoldPoints = d->manifolds.points.data,
                      .manifoldPointCount = d->manifolds.points.count,
                      .profile = *profile};
}

static void Enter(const qcStep* step, const char* stage)
{
    if (step->def->enterStage != NULL)
        step->def->enterStage(stage);
}

/// Ends the stage, whether it succeeded or not. Returns `status`.
static qcStatus Leave(const qcStep* step, qcStatus status)
{
    if (step->def->leaveStage != NULL)
        step->def->leaveStage();
    return status;
}

/// Positions that were lost with a device are no longer anywhere.
static qcStatus CheckVertexBuffers(const qcBodies* bodies)
{
    for (uint32_t slot = 0; slot < bodies->slots.count; slot++)
        QC_TRY(qcVertexSnapshot_CheckAlive(QC_AT(qcBody, bodies->slots, slot).snapshot, slot));
    return qc_statusOk;
}

static qcStatus RunStages(const qcStep* step, qcBodies* bodies, double start, qcDetector* d)
{
    qcProfile profile = {0};
    double lap = start;
    ReportPlan(&step->plan, &profile);
    QC_TRY(CheckVertexBuffers(bodies));
    if (!qcVertexBuffers_SufficeFor(step))
        QC_TRY(qcVertexBuffers_CompleteAll(bodies, &profile.readBackBytes));
    qcIslandRouting* routing = &d->triangleStage.routing;
    QC_TRY(BeginStep(step, &routing->history, bodies, &d->triangles, &d->pcs, &profile));
    const qcStepTriangles* triangles = &d->triangles;
    profile.planMs = Lap(&lap);
    Enter(step, "qcScene cull bodies");
    QC_TRY(Leave(step, CullBodies(step, triangles, &d->imageCull, &d->pcs, &profile)));
    profile.cullObjectsMs = Lap(&lap);
    Enter(step, "qcScene sweep bodies");
    QC_TRY(Leave(step, SweepBodies(step, triangles, &d->pcs, &d->bodyPairs, &profile)));
    profile.sweepObjectsMs = Lap(&lap);

    double planned = profile.planMs;
    Enter(step, "qcScene cull triangles");
    QC_TRY(Leave(
        step, qcMethodStage_Cull(step, triangles, &d->bodyPairs, &d->triangleStage, &d->imageCull, &d->pcs, &profile)));
    double calibrationMs = profile.planMs - planned;
    profile.cullTrianglesMs = Lap(&lap) - calibrationMs;
    Enter(step, "qcScene sweep triangles");
    QC_TRY(Leave(step, qcMethodStage_Sweep(step, triangles, &d->bodyPairs, &d->pcs, &d->triangleStage, &profile)));
    profile.sweepTrianglesMs = Lap(&lap);
    ReportDevice(step, &profile);

    const qcCandidates* candidates = &d->triangleStage.candidates;
    QC_TRY(qcPcsReport_Fill(triangles, &d->pcs, candidates, step->plan.useImage, step->def, &d->pcsReport));
    QC_TRY(qcVertexBuffers_Gather(step, triangles, candidates, &d->vertexBuffers, &profile));
    if (qcVertexBuffers_SufficeFor(step))
        QC_TRY(qcVertexBuffers_KeepFloats(step, triangles, routing, profile.followedTriangles != 0, bodies));
    Enter(step, "qcScene exact");
    QC_TRY(Leave(step, qcNarrowphase_Run(triangles, candidates, step->def, step->threads, &d->narrowphase, &profile)));
    Lap(&lap);
    // Waking threads counts, too: for a GPU fewer are woken. So do exact tests: of more or fewer candidates.
    qcPlanHistory_Add(&routing->history, profile.partsOnDevice != 0, routing->plannedTriangles,
                      lap - start - calibrationMs - profile.contactMs);
    Enter(step, "qcScene manifolds");
    QC_TRY(Leave(step, BuildManifolds(step, triangles, &d->narrowphase, &d->manifolds)));
    profile.manifoldMs = Lap(&lap);
    profile.totalMs = lap - start;
    ReportPasses(&d->imageCull.records, &profile);
    d->result = MakeResult(d, step->def, &profile);
    return qc_statusOk;
}

/// Whether both requests have the same result. By field: padding has no meaning.
static bool IsSameRequest(const qcDetectDef* a, const qcDetectDef* b)
{
    return a->pairFilter == NULL && b->pairFilter == NULL && a->method == b->method && a->margin == b->margin &&
           a->touching == b->touching && a->neighbours == b->neighbours && a->segments == b->segments &&
           a->proximities == b->proximities && a->manifolds == b->manifolds && a->contactMargin == b->contactMargin &&
           a->nearestContacts == b->nearestContacts && a->layerColumns == b->layerColumns &&
           a->layerDepthAxis == b->layerDepthAxis && strncmp(a->views, b->views, 4) == 0 &&
           a->resolution == b->resolution && a->iterations == b->iterations && a->backToFront == b->backToFront &&
           a->secondPassFromBack == b->secondPassFromBack && a->reliable == b->reliable && a->motion == b->motion &&
           a->candidates == b->candidates && a->spacing == b->spacing && a->unoriented == b->unoriented &&
           a->sets == b->sets && a->maxPairs == b->maxPairs;
}

static void Reuse(qcProfile* profile)
{
    profile->reused = true;
    profile->planMs = profile->cullObjectsMs = profile->sweepObjectsMs = profile->cullTrianglesMs = 0.0;
    profile->sweepTrianglesMs = profile->exactMs = profile->contactMs = profile->manifoldMs = 0.0;
    profile->totalMs = 0.0;
    profile->readBackBytes = 0;
    profile->layerTimes = NULL;
    profile->layerTimeCount = 0;
}

qcStatus qcDetector_Run(const qcDetectDef* def, qcDevice* device, qcMeasureCosts* measureCosts, qcBodies* bodies,
                        qcDetector* detector)
{
    if (detector->valid && detector->revision == bodies->revision && IsSameRequest(&detector->def, def))
    {
        Reuse(&detector->result.profile);
        return qc_statusOk;
    }
    double start = qcClock_Now(), contactDistance = qcContactDistance(def->contactMargin);
    const qcStep step = {.def = def,
                         .device = device,
                         .measureCosts = measureCosts,
                         .plan = MakePlan(def, device),
                         .threads = qcParallel_Threads(def->threads),
                         .queryDistance = def->margin > contactDistance ? def->margin : contactDistance};
    detector->valid = false;
    QC_TRY(RunStages(&step, bodies, start, detector));
    detector->valid = true;
    detector->revision = bodies->revision;
    detector->def = *def;
    return qc_statusOk;
}

void qcDetector_Free(qcDetector* detector)
{
    qcStepTriangles_Free(&detector->triangles);
    qcPcs_Free(&detector->pcs);
    qcImageCull_Free(&detector->imageCull);
    qcBodyPairs_Free(&detector->bodyPairs);
    qcMethodStage_Free(&detector->triangleStage);
    qcVertexBuffers_Free(&detector->vertexBuffers);
    qcNarrowphase_Free(&detector->narrowphase);
    qcAllManifolds_Free(&detector->manifolds);
    qcPcsReport_Free(&detector->pcsReport);
}
