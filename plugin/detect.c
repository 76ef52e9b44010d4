// plan, cull objects, sweep objects, cull triangles, sweep triangles, exact, contacts: the line that data travels.
// Quick-CULLIDE, VR 2005, section 4.2, for the image methods; the others leave the cull stages out.
#include "detect.h"

#include "clock.h"
#include "contact.h"
#include "status.h"

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

static void Plan(Step* step)
{
    qcDeviceInfo info = {.kind = qc_deviceNone, .name = "none"};
    if (step->device != NULL)
        qcDevice_GetInfo(step->device, &info);
    qcPlanInput input = {step->def->method, step->def->resolution, info.kind != qc_deviceNone, info.maxResolution};
    step->plan = qcPlan_Make(&input);
    step->profile.method = step->plan.method;
    step->profile.fallback = step->plan.fallback;
    step->profile.resolution = step->plan.resolution;
    step->profile.device = step->plan.useImage ? info.name : "none";
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

static qcStatus CullAndSweepObjects(Step* step)
{
    qcDetector* d = step->detector;
    d->cull.records.count = 0;
    if (step->plan.useImage)
        QC_TRY(qcCull_Objects(&d->cull, &d->triangles, step->device, &step->plan, step->def));
    for (uint32_t body = 0; body < d->triangles.bodyCount; body++)
        step->profile.objectPcs += QC_AT(uint8_t, d->triangles.bodySet, body) != qc_setBfv &&
                                   qcTriangles_Body(&d->triangles, body)->triangleCount != 0;
    step->profile.cullObjectsMs = Lap(step);

    double margin = qcContact_Reach(step->def->contactMargin);
    bool brute = step->plan.method == qc_methodBrute;
    if (brute)
        QC_TRY(qcObjects_FindPairsBrute(&d->objects, &d->triangles, margin, &step->profile));
    else
        QC_TRY(qcObjects_FindPairs(&d->objects, &d->triangles, margin, &step->profile));
    // The paper culls whole objects at the sub-object level; brute force leaves out nothing.
    bool wholeBodies = step->plan.useImage || brute;
    QC_TRY(qcObjects_MarkTriangles(&d->objects, &d->triangles, margin, wholeBodies, &step->profile));
    step->profile.sweepObjectsMs = Lap(step);
    return qc_statusOk;
}

static qcStatus CullAndSweepTriangles(Step* step)
{
    qcDetector* d = step->detector;
    if (step->plan.useImage)
        QC_TRY(qcCull_Triangles(&d->cull, &d->triangles, step->device, &step->plan, step->def));
    for (uint32_t r = 0; r < d->triangles.count; r++)
        step->profile.trianglePcs += QC_AT(uint8_t, d->triangles.pcs, r) != 0;
    step->profile.cullTrianglesMs = Lap(step);

    double margin = qcContact_Reach(step->def->contactMargin);
    qcCandidateRules rules = {.triangles = &d->triangles,
                              .margin = margin,
                              .testNeighbours = step->def->neighbours,
                              .listNeighbours = margin > 0.0,
                              .threads = step->threads};
    if (step->plan.method == qc_methodBrute)
        QC_TRY(qcCandidates_Brute(&d->candidates, &rules, &step->profile));
    else
        QC_TRY(qcCandidates_Sweep(&d->candidates, &rules, &step->profile));
    step->profile.sweepTrianglesMs = Lap(step);
    return qc_statusOk;
}

/// The PCS as the result reports it: for the image methods what culling left, otherwise what is in a candidate pair.
static qcStatus CollectPcs(Step* step)
{
    qcDetector* d = step->detector;
    const qcTriangles* t = &d->triangles;
    QC_TRY(qcArray_Resize(&d->marks, t->count, 1, "the PCS"));
    uint8_t* marks = d->marks.data;
    for (uint32_t r = 0; r < t->count; r++)
        marks[r] = step->plan.useImage && QC_AT(uint8_t, t->pcs, r) != 0;
    if (!step->plan.useImage)
        for (size_t i = 0; i < d->candidates.keys.count; i++)
        {
            uint64_t key = QC_AT(uint64_t, d->candidates.keys, i);
            marks[key >> 32] = marks[(uint32_t)key] = 1;
        }
    size_t count = 0;
    for (uint32_t r = 0; r < t->count; r++)
        count += marks[r];
    QC_TRY(qcArray_Resize(&d->pcs, count, sizeof(qcTriangleRef), "the PCS"));
    size_t at = 0;
    for (uint32_t r = 0; r < t->count; r++)
    {
        if (!marks[r])
            continue;
        uint32_t body = qcTriangles_BodyOf(t, r);
        QC_AT(qcTriangleRef, d->pcs, at++) = (qcTriangleRef){qcTriangles_Slot(t, body), r - qcTriangles_First(t, body)};
    }
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
                           .pcs = d->pcs.data,
                           .pcsCount = d->pcs.count,
                           .contacts = d->narrow.contacts.data,
                           .contactCount = d->narrow.contacts.count,
                           .profile = *profile};
}

static qcStatus RunStages(Step* step)
{
    qcDetector* d = step->detector;
    double start = step->clock = qcClock_Now();
    Plan(step);
    QC_TRY(FindOwners(step));
    QC_TRY(qcTriangles_Number(&d->triangles, step->bodies));
    step->profile.bodies = d->triangles.bodyCount;
    step->profile.triangles = d->triangles.count;
    step->profile.planMs = Lap(step);
    QC_TRY(CullAndSweepObjects(step));
    QC_TRY(CullAndSweepTriangles(step));
    QC_TRY(CollectPcs(step));
    QC_TRY(qcNarrow_Run(&d->narrow, &d->triangles, &d->candidates, step->def, step->threads, &step->profile));
    step->profile.totalMs = qcClock_Now() - start;
    FillResult(step);
    return qc_statusOk;
}

/// Would the same question be asked again? Fields, not bytes: padding has no meaning.
static bool IsSameQuestion(const qcDetectDef* a, const qcDetectDef* b)
{
    return a->method == b->method && a->margin == b->margin && a->touching == b->touching &&
           a->neighbours == b->neighbours && a->segments == b->segments && a->proximities == b->proximities &&
           a->manifolds == b->manifolds && a->contactMargin == b->contactMargin && a->layerColumns == b->layerColumns &&
           strncmp(a->layerViews, b->layerViews, 4) == 0 && strncmp(a->views, b->views, 4) == 0 &&
           a->resolution == b->resolution && a->iterations == b->iterations && a->backToFront == b->backToFront &&
           a->secondPassFromBack == b->secondPassFromBack && a->reliable == b->reliable;
}

static void Reuse(qcProfile* profile)
{
    profile->reused = true;
    profile->planMs = profile->cullObjectsMs = profile->sweepObjectsMs = profile->cullTrianglesMs = 0.0;
    profile->sweepTrianglesMs = profile->exactMs = profile->contactMs = profile->totalMs = 0.0;
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
    qcTriangles_Free(&detector->triangles);
    qcCull_Free(&detector->cull);
    qcObjects_Free(&detector->objects);
    qcCandidates_Free(&detector->candidates);
    qcNarrow_Free(&detector->narrow);
    qcArray_Free(&detector->pcs);
    qcArray_Free(&detector->marks);
}
