// Two-pass visibility culling. CULLIDE (Govindaraju, Redon, Lin, Manocha, 2003) as told in section 3.1 of Quick-CULLIDE
// (VR 2005), self-collision of its section 3.2, sets and lemmas of its section 4.1.
//
// This method has image precision: what falls between samples is lost, as in the paper. What it prunes from the samples
// is sound: a primitive is tested against a subset of what the lemmas ask for, never less.
#include "cull_visibility.h"

#include "gl/visibility.h"
#include "status.h"

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

/// The steps of one group: all its tests come before its renders, so that it does not hide itself.
static qcStatus AddGroup(const Pass* p, int pass, uint32_t first, uint32_t end)
{
    const qcCullJob* job = p->job;
    for (int round = 0; round < 2; round++)
        for (uint32_t i = first; i < end; i++)
        {
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
            for (end = first + 1;
                 end < job->primitiveCount && job->primitives[end].group == job->primitives[first].group;)
                end++;
            QC_TRY(AddGroup(p, pass, first, end));
        }
        return qc_statusOk;
    }
    for (uint32_t end = job->primitiveCount, first; end > 0; end = first)
    {
        for (first = end - 1; first > 0 && job->primitives[first - 1].group == job->primitives[end - 1].group;)
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
        return qc_statusOk; // nobody asks, so nothing needs to be drawn
    QC_TRY(qcArray_Resize(&scratch->visible, stepCount, 1, "visibility results"));
    QC_TRY(qcVisibility_RunPass(p->visibility, axis - 'x',
                                job->level == qc_levelSelf ? qc_compareGreater : qc_compareGreaterEqual,
                                scratch->steps.data, stepCount, scratch->visible.data));
    for (uint32_t i = 0; i < stepCount; i++)
    {
        if (!QC_AT(qcVisibilityStep, scratch->steps, i).test)
            continue;
        qcVisibilitySet* set = &p->sets[QC_AT(uint32_t, scratch->stepOf, i)];
        qcVisibilitySet after = qcVisibilitySet_After(*set, pass, QC_AT(uint8_t, scratch->visible, i) != 0);
        // CULLIDE starts each view afresh, so only a pruned primitive is progress there.
        *changed = *changed || (after != *set && (job->quick || after == qc_setBfv));
        *set = after;
    }
    return AddRecord(p, axis, iteration, pass);
}

static qcStatus RunViews(const Pass* p)
{
    const qcCullJob* job = p->job;
    for (uint32_t iteration = 1; job->iterations == 0 || iteration <= job->iterations; iteration++)
    {
        bool changed = false;
        for (const char* axis = job->views; *axis != 0; axis++)
        {
            for (int pass = 1; pass <= 2; pass++)
                QC_TRY(RunPass(p, *axis, iteration, pass, &changed));
            for (uint32_t i = 0; i < job->primitiveCount; i++)
                p->sets[i] = qcVisibilitySet_NextView(p->sets[i], job->quick);
        }
        // A round that changes nothing is the last that could: the next would see the same.
        if (!changed)
            break;
    }
    return qc_statusOk;
}

qcStatus qcCullVisibility_Run(const qcCullJob* job, qcCullScratch* scratch, qcVisibilitySet* sets, qcArray* records)
{
    Pass p = {job, NULL, scratch, sets, records};
    QC_TRY(qcVisibility_Create(job->device, job->corners, job->triangleCount, job->resolution, &p.visibility));
    qcStatus status = RunViews(&p);
    qcVisibility_Destroy(p.visibility);
    return status;
}

void qcCullScratch_Free(qcCullScratch* scratch)
{
    qcArray_Free(&scratch->steps);
    qcArray_Free(&scratch->visible);
    qcArray_Free(&scratch->stepOf);
}
