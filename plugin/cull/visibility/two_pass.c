// Two-pass visibility culling. CULLIDE (Govindaraju, Redon, Lin, Manocha, 2003) as in section 3.1 of Quick-CULLIDE
// (VR 2005), self-collision of its section 3.2, sets and lemmas of its section 4.1.
// Proof for any draw order, for a second pass from the back, and for `reliable`:
// plugin/docs/proofs/two_pass_culling.md.
#include "cull/visibility/two_pass.h"

#include "gl/visibility/occlusion_queries.h"
#include "base/status.h"

#include <string.h>

typedef struct Pass
{
    const qcCullJob* job;
    qcVisibility* visibility;
    qcCullScratch* scratch;
    qcVisibilitySet* sets;
    qcArray* records;
} Pass;

static qcStatus AddStep(qcCullScratch* scratch, const qcCullPrimitive* primitive, uint32_t index, bool test,
                        bool render)
{
    QC_TRY(qcArray_Reserve(&scratch->steps, scratch->steps.count + 1, sizeof(qcVisibilityStep), "visibility steps"));
    QC_TRY(qcArray_Reserve(&scratch->stepOf, scratch->stepOf.count + 1, sizeof(uint32_t), "visibility steps"));
    qcVisibilityStep step = {primitive->firstTriangle, primitive->triangleCount, test, render};
    QC_AT(qcVisibilityStep, scratch->steps, scratch->steps.count++) = step;
    QC_AT(uint32_t, scratch->stepOf, scratch->stepOf.count++) = index;
    return qc_statusOk;
}

/// The steps of one group: tests precede renders, so that it does not hide itself.
static qcStatus AddGroup(const Pass* p, int pass, uint32_t first, uint32_t end)
{
    const qcCullJob* job = p->job;
    for (int round = 0; round < 2; round++)
        for (uint32_t at = first; at < end; at++)
        {
            uint32_t i = QC_AT(uint32_t, p->scratch->order.primitives, at);
            bool test = qcVisibilitySet_IsTested(p->sets[i], pass, job->quick);
            bool render = qcVisibilitySet_IsRendered(p->sets[i], pass, job->quick);
            bool alone = end == first + 1;
            if (!alone)
            {
                test = test && round == 0;
                render = render && round == 1;
            }
            if ((test || render) && !(alone && round == 1))
                QC_TRY(AddStep(p->scratch, &job->primitives[i], i, test, render));
        }
    return qc_statusOk;
}

static uint32_t GroupAt(const Pass* p, uint32_t at)
{
    return p->job->primitives[QC_AT(uint32_t, p->scratch->order.primitives, at)].group;
}

/// First pass: in order; second pass: groups in reverse order.
static qcStatus AddSteps(const Pass* p, int pass)
{
    const qcCullJob* job = p->job;
    p->scratch->steps.count = 0;
    p->scratch->stepOf.count = 0;
    if (pass == 1)
    {
        for (uint32_t first = 0, end; first < job->primitiveCount; first = end)
        {
            for (end = first + 1; end < job->primitiveCount && GroupAt(p, end) == GroupAt(p, first);)
                end++;
            QC_TRY(AddGroup(p, pass, first, end));
        }
        return qc_statusOk;
    }
    for (uint32_t end = job->primitiveCount, first; end > 0; end = first)
    {
        for (first = end - 1; first > 0 && GroupAt(p, first - 1) == GroupAt(p, end - 1);)
            first--;
        QC_TRY(AddGroup(p, pass, first, end));
    }
    return qc_statusOk;
}

static qcStatus AddRecord(const Pass* p, char axis, uint32_t iteration, int pass)
{
    const qcCullJob* job = p->job;
    uint32_t size[4] = {0, 0, 0, 0};
    for (uint32_t i = 0; i < job->primitiveCount; i++)
        size[p->sets[i]]++;
    uint32_t queries = 0, rendered = 0;
    for (size_t i = 0; i < p->scratch->steps.count; i++)
    {
        queries += QC_AT(qcVisibilityStep, p->scratch->steps, i).test;
        rendered += QC_AT(qcVisibilityStep, p->scratch->steps, i).render;
    }
    QC_TRY(qcArray_Reserve(p->records, p->records->count + 1, sizeof(qcPassRecord), "pass records"));
    QC_AT(qcPassRecord, *p->records, p->records->count++) =
        (qcPassRecord){.level = job->level,
                       .body = job->body,
                       .axis = axis,
                       .iteration = iteration,
                       .pass = (uint32_t)pass,
                       .queries = queries,
                       .rendered = rendered,
                       .bfv = size[qc_setBfv],
                       .ffv = size[qc_setFfv],
                       .sfv = size[qc_setSfv],
                       .nfv = size[qc_setNfv],
                       .pcs = size[qc_setFfv] + size[qc_setSfv] + size[qc_setNfv]};
    return qc_statusOk;
}

static qcStatus RunPass(const Pass* p, char axis, uint32_t iteration, int pass, bool* changed)
{
    const qcCullJob* job = p->job;
    QC_TRY(AddSteps(p, pass));
    qcCullScratch* scratch = p->scratch;
    uint32_t stepCount = (uint32_t)scratch->steps.count;
    bool anyTest = false;
    for (uint32_t i = 0; i < stepCount && !anyTest; i++)
        anyTest = QC_AT(qcVisibilityStep, scratch->steps, i).test;
    if (!anyTest)
        return qc_statusOk; // without a test there is nothing to draw for
    QC_TRY(qcArray_Resize(&scratch->visible, stepCount, 1, "visibility results"));
    qcVisibilityPass setup = {.axis = axis - 'x',
                              .compare = job->level == qc_levelSelf ? qc_compareGreater : qc_compareGreaterEqual,
                              .fromBack = job->secondPassFromBack && pass == 2};
    QC_TRY(qcVisibility_RunPass(p->visibility, &setup, scratch->steps.data, stepCount, scratch->visible.data));
    for (uint32_t i = 0; i < stepCount; i++)
    {
        if (!QC_AT(qcVisibilityStep, scratch->steps, i).test)
            continue;
        qcVisibilitySet* set = &p->sets[QC_AT(uint32_t, scratch->stepOf, i)];
        qcVisibilitySet after = qcVisibilitySet_After(*set, pass, QC_AT(uint8_t, scratch->visible, i) != 0);
        // CULLIDE resets the sets for each view: only a pruned primitive is progress there.
        *changed = *changed || (after != *set && (job->quick || after == qc_setBfv));
        *set = after;
    }
    return AddRecord(p, axis, iteration, pass);
}

/// Whether each view has its own FFV and SFV, which are not passed from view to view.
static bool HasSetsOfViews(const qcCullJob* job)
{
    return job->quick && job->backToFront;
}

/// Resets the sets with which each view's next round begins: view after view.
static qcStatus ResetViews(const Pass* p)
{
    size_t count = HasSetsOfViews(p->job) ? strlen(p->job->views) * p->job->primitiveCount : 0;
    QC_TRY(qcArray_Resize(&p->scratch->setsOfViews, count, sizeof(qcVisibilitySet), "visibility sets"));
    for (size_t i = 0; i < count; i++)
        QC_AT(qcVisibilitySet, p->scratch->setsOfViews, i) = qc_setNfv;
    return qc_statusOk;
}

/// Prepares the order and the sets of a view for its two passes.
static qcStatus BeginView(const Pass* p, const char* axis)
{
    const qcCullJob* job = p->job;
    if (!job->backToFront)
        return qc_statusOk;
    for (uint32_t i = 0; HasSetsOfViews(job) && i < job->primitiveCount; i++)
        if (p->sets[i] != qc_setBfv)
            p->sets[i] =
                QC_AT(qcVisibilitySet, p->scratch->setsOfViews, (size_t)(axis - job->views) * job->primitiveCount + i);
    return qcCullOrder_BackToFront(&p->scratch->order, job->primitives, job->primitiveCount, job->corners, *axis - 'x');
}

static void EndView(const Pass* p, const char* axis)
{
    const qcCullJob* job = p->job;
    for (uint32_t i = 0; i < job->primitiveCount; i++)
    {
        p->sets[i] = qcVisibilitySet_NextView(p->sets[i], job->quick);
        if (HasSetsOfViews(job))
            QC_AT(qcVisibilitySet, p->scratch->setsOfViews, (size_t)(axis - job->views) * job->primitiveCount + i) =
                p->sets[i];
    }
}

static qcStatus RunViews(const Pass* p)
{
    const qcCullJob* job = p->job;
    QC_TRY(qcCullOrder_ByNumber(&p->scratch->order, job->primitiveCount));
    QC_TRY(ResetViews(p));
    for (uint32_t iteration = 1; job->iterations == 0 || iteration <= job->iterations; iteration++)
    {
        bool changed = false;
        for (const char* axis = job->views; *axis != 0; axis++)
        {
            QC_TRY(BeginView(p, axis));
            for (int pass = 1; pass <= 2; pass++)
                QC_TRY(RunPass(p, *axis, iteration, pass, &changed));
            EndView(p, axis);
        }
        // After a round without a change the next one would repeat it.
        if (!changed)
            break;
    }
    return qc_statusOk;
}

qcStatus qcCullVisibility_Run(const qcCullJob* job, qcCullScratch* scratch, qcVisibilitySet* sets, qcArray* records)
{
    Pass p = {job, NULL, scratch, sets, records};
    qcVisibilityDef def = {.device = job->device,
                           .corners = job->corners,
                           .triangleCount = job->triangleCount,
                           .resolution = job->resolution,
                           .dilated = job->reliable,
                           .dilation = {job->growth[0], job->growth[1], job->growth[2]}};
    QC_TRY(qcVisibility_Create(&def, &p.visibility));
    qcStatus status = RunViews(&p);
    qcVisibility_Destroy(p.visibility);
    return status;
}

void qcCullScratch_Free(qcCullScratch* scratch)
{
    qcArray_Free(&scratch->steps);
    qcArray_Free(&scratch->visible);
    qcArray_Free(&scratch->stepOf);
    qcArray_Free(&scratch->setsOfViews);
    qcCullOrder_Free(&scratch->order);
}
