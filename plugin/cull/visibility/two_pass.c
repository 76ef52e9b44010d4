// Two-pass visibility culling. CULLIDE (Govindaraju, Redon, Lin, Manocha, 2003) as in section 3.1 of Quick-CULLIDE
// (VR 2005), self-collision of its section 3.2, sets and lemmas of its section 4.1.
// Proof for any draw order, for a second pass from the back, and for `reliable`:
// plugin/docs/proofs/two_pass_culling.md.
#include "cull/visibility/two_pass.h"

#include "base/status.h"

#include <string.h>

enum
{
    qc_setCount = qc_setNfv + 1
};

typedef struct Pass
{
    const qcCullJob* job;
    qcVisibility* visibility;
    qcCullScratch* scratch;
    qcVisibilitySet* sets;
    qcArray* records;
} Pass;

/// The steps of a pass, as they are added; there is room.
typedef struct Steps
{
    const qcCullPrimitive* primitives;
    const uint32_t* order;
    const qcVisibilitySet* sets;
    bool tests[qc_setCount], renders[qc_setCount]; ///< by set, whether the pass does so
    qcVisibilityStep* steps;
    uint32_t* stepOf;
    size_t count;
} Steps;

static inline void AddStep(Steps* s, uint32_t index, bool test, bool render)
{
    const qcCullPrimitive* primitive = &s->primitives[index];
    s->steps[s->count] = (qcVisibilityStep){primitive->firstTriangle, primitive->triangleCount, test, render};
    s->stepOf[s->count] = index;
    s->count += test || render;
}

/// Adds the steps of one group: tests precede renders, so that it does not hide itself.
static inline void AddGroup(Steps* s, uint32_t first, uint32_t end)
{
    bool alone = end == first + 1;
    for (uint32_t at = first; at < end; at++)
    {
        qcVisibilitySet set = s->sets[s->order[at]];
        AddStep(s, s->order[at], s->tests[set], alone && s->renders[set]);
    }
    for (uint32_t at = first; at < end && !alone; at++)
        AddStep(s, s->order[at], false, s->renders[s->sets[s->order[at]]]);
}

static uint32_t GroupAt(const Pass* p, uint32_t at)
{
    return p->job->primitives[QC_AT(uint32_t, p->scratch->order.primitives, at)].group;
}

/// The end of the group that begins here, in the order.
static uint32_t FindGroupEnd(const Pass* p, uint32_t first)
{
    uint32_t end = first + 1;
    // Within one body each triangle is a group.
    if (p->job->level == qc_levelSelf)
        return end;
    for (uint32_t group = GroupAt(p, first); end < p->job->primitiveCount && GroupAt(p, end) == group;)
        end++;
    return end;
}

/// The beginning of the group that ends here.
static uint32_t FindGroupBegin(const Pass* p, uint32_t end)
{
    uint32_t first = end - 1;
    if (p->job->level == qc_levelSelf)
        return first;
    for (uint32_t group = GroupAt(p, first); first > 0 && GroupAt(p, first - 1) == group;)
        first--;
    return first;
}

/// First pass: in order; second pass: groups in reverse order.
static qcStatus AddSteps(const Pass* p, int pass)
{
    const qcCullJob* job = p->job;
    qcCullScratch* scratch = p->scratch;
    // A step more: one that does nothing is written and not counted.
    size_t room = (size_t)2 * job->primitiveCount + 1;
    QC_TRY(qcArray_Reserve(&scratch->steps, room, sizeof(qcVisibilityStep), "visibility steps"));
    QC_TRY(qcArray_Reserve(&scratch->stepOf, room, sizeof(uint32_t), "visibility steps"));
    Steps s = {.primitives = job->primitives,
               .order = scratch->order.primitives.data,
               .sets = p->sets,
               .steps = scratch->steps.data,
               .stepOf = scratch->stepOf.data};
    for (int set = 0; set < qc_setCount; set++)
    {
        s.tests[set] = qcVisibilitySet_IsTested((qcVisibilitySet)set, pass, job->quick);
        s.renders[set] = qcVisibilitySet_IsRendered((qcVisibilitySet)set, pass, job->quick);
    }
    for (uint32_t first = 0, end; pass == 1 && first < job->primitiveCount; first = end)
    {
        end = FindGroupEnd(p, first);
        AddGroup(&s, first, end);
    }
    for (uint32_t end = job->primitiveCount, first; pass == 2 && end > 0; end = first)
    {
        first = FindGroupBegin(p, end);
        AddGroup(&s, first, end);
    }
    scratch->steps.count = scratch->stepOf.count = s.count;
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

/// Moves the primitives that are fully visible to their next sets. Returns whether that is progress.
static bool TakeResults(const Pass* p, int pass)
{
    const qcCullScratch* scratch = p->scratch;
    const qcVisibilityStep* steps = scratch->steps.data;
    const uint32_t* stepOf = scratch->stepOf.data;
    const uint8_t* visible = scratch->visible.data;
    qcVisibilitySet next[qc_setCount];
    for (int set = 0; set < qc_setCount; set++)
        next[set] = qcVisibilitySet_After((qcVisibilitySet)set, pass, true);
    bool changed = false;
    for (size_t i = 0; i < scratch->steps.count; i++)
    {
        if (!steps[i].test || !visible[i])
            continue;
        qcVisibilitySet *set = &p->sets[stepOf[i]], after = next[*set];
        // CULLIDE resets the sets for each view: only a pruned primitive is progress there.
        changed = changed || (after != *set && (p->job->quick || after == qc_setBfv));
        *set = after;
    }
    return changed;
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
    if (TakeResults(p, pass))
        *changed = true;
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

static qcStatus RunViews(void* context)
{
    const Pass* p = context;
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
    qcVisibilityDef def = {.device = job->device,
                           .corners = job->corners,
                           .triangleCount = job->triangleCount,
                           .resolution = job->resolution,
                           .dilated = job->reliable,
                           .dilation = {job->growth[0], job->growth[1], job->growth[2]}};
    QC_TRY(qcVisibility_Prepare(&def, &scratch->visibility));
    Pass p = {job, scratch->visibility, scratch, sets, records};
    qcStatus status = qcVisibility_Run(scratch->visibility, RunViews, &p);
    if (status != qc_statusOk)
    {
        qcVisibility_Destroy(scratch->visibility);
        scratch->visibility = NULL;
    }
    return status;
}

void qcCullScratch_Free(qcCullScratch* scratch)
{
    qcArray_Free(&scratch->steps);
    qcArray_Free(&scratch->visible);
    qcArray_Free(&scratch->stepOf);
    qcArray_Free(&scratch->setsOfViews);
    qcVisibility_Destroy(scratch->visibility);
    qcCullOrder_Free(&scratch->order);
}
