// Sweep and prune over the boxes of bodies, and the triangles inside the overlaps.
//
// Rounding: a margin is added to upper ends only, so that lower(A) <= upper(B) + margin, true in real numbers, stays
// true when the sum is rounded (see sweep.c).
#include "objects.h"

#include "status.h"

qcMeeting qcObjects_Meet(const qcTriangles* triangles, uint32_t a, uint32_t b)
{
    const qcBody *p = qcTriangles_Body(triangles, a), *q = qcTriangles_Body(triangles, b);
    if (p->activity != qc_activityMoving && q->activity != qc_activityMoving)
        return qc_meetingAtRest;
    if ((p->group & q->mask) == 0 || (q->group & p->mask) == 0)
        return qc_meetingFiltered;
    if (!qcVisibilitySet_MayCollide(QC_AT(uint8_t, triangles->bodySet, a), QC_AT(uint8_t, triangles->bodySet, b)))
        return qc_meetingSameSet;
    return qc_meetingYes;
}

bool qcObjects_MeetsItself(const qcTriangles* triangles, uint32_t body)
{
    const qcBody* b = qcTriangles_Body(triangles, body);
    return b->selfCollision && b->activity == qc_activityMoving && b->triangleCount > 1;
}

typedef struct Search
{
    const qcTriangles* triangles;
    qcArray* pairs;
    qcProfile* profile;
    qcStatus status;
} Search;

static void OfferPair(void* context, const qcSweepBox* x, const qcSweepBox* y, uint32_t worker)
{
    (void)worker;
    Search* search = context;
    uint32_t a = x->body < y->body ? x->body : y->body, b = x->body < y->body ? y->body : x->body;
    switch (qcObjects_Meet(search->triangles, a, b))
    {
        case qc_meetingAtRest: search->profile->skippedStaticPairs++; return;
        case qc_meetingFiltered: search->profile->skippedFilteredPairs++; return;
        case qc_meetingSameSet: search->profile->skippedSetPairs++; return;
        case qc_meetingYes: break;
    }
    if (search->status != qc_statusOk)
        return;
    search->status = qcArray_Reserve(search->pairs, search->pairs->count + 1, sizeof(qcBodyPair), "pairs of bodies");
    if (search->status == qc_statusOk)
        QC_AT(qcBodyPair, *search->pairs, search->pairs->count++) = (qcBodyPair){a, b};
}

qcStatus qcObjects_FindPairs(qcObjects* objects, const qcTriangles* triangles, double margin, qcProfile* profile)
{
    objects->pairs.count = 0;
    QC_TRY(qcArray_Resize(&objects->boxes, triangles->bodyCount, sizeof(qcSweepBox), "boxes of bodies"));
    qcSweepFrame frame = {{0.0, 0.0, 0.0}, margin};
    uint32_t count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        const qcBody* b = qcTriangles_Body(triangles, body);
        if (b->triangleCount == 0 || QC_AT(uint8_t, triangles->bodySet, body) == qc_setBfv)
            continue;
        if (count == 0)
            for (int axis = 0; axis < 3; axis++)
                frame.origin[axis] = b->lower[axis];
        QC_AT(qcSweepBox, objects->boxes, count++) = qcSweepFrame_Map(&frame, b->lower, b->upper, body, body);
    }
    Search search = {triangles, &objects->pairs, profile, qc_statusOk};
    // One thread: the counters are shared, and bodies are few beside triangles.
    QC_TRY(qcSweep_FindPairs(&objects->sweep, objects->boxes.data, count, 1, OfferPair, &search));
    profile->bodyPairs = objects->pairs.count;
    return search.status;
}

/// Triangles of `body` near the box of `other`.
static void MarkNear(qcTriangles* triangles, uint32_t body, const qcBody* other, double margin)
{
    const qcBody* b = qcTriangles_Body(triangles, body);
    uint8_t* pcs = &QC_AT(uint8_t, triangles->pcs, qcTriangles_First(triangles, body));
    for (uint32_t t = 0; t < b->triangleCount; t++)
    {
        if (qcTriangles_InterSet(pcs[t]) != qc_setBfv)
            continue;
        double lower[3], upper[3];
        qcBody_GetTriangleBox(b, t, lower, upper);
        bool near = true;
        for (int axis = 0; axis < 3; axis++)
            near = near && lower[axis] <= other->upper[axis] + margin && other->lower[axis] <= upper[axis] + margin;
        if (near)
            pcs[t] |= qcTriangles_Pcs(qc_setNfv, qc_setBfv);
    }
}

static void MarkAll(qcTriangles* triangles, uint32_t body, uint8_t mark)
{
    for (uint32_t r = qcTriangles_First(triangles, body); r < qcTriangles_First(triangles, body + 1); r++)
        QC_AT(uint8_t, triangles->pcs, r) |= mark;
}

void qcObjects_MarkTriangles(const qcObjects* objects, qcTriangles* triangles, double margin, bool wholeBodies,
                             qcProfile* profile)
{
    for (size_t i = 0; i < objects->pairs.count; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, objects->pairs, i);
        if (wholeBodies)
        {
            MarkAll(triangles, pair.a, qcTriangles_Pcs(qc_setNfv, qc_setBfv));
            MarkAll(triangles, pair.b, qcTriangles_Pcs(qc_setNfv, qc_setBfv));
            continue;
        }
        MarkNear(triangles, pair.a, qcTriangles_Body(triangles, pair.b), margin);
        MarkNear(triangles, pair.b, qcTriangles_Body(triangles, pair.a), margin);
    }
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        bool self = qcObjects_MeetsItself(triangles, body);
        if (self)
            MarkAll(triangles, body, qcTriangles_Pcs(qc_setBfv, qc_setNfv));
        profile->selfBodies += self;
        uint32_t skipped = 0;
        for (uint32_t r = qcTriangles_First(triangles, body); r < qcTriangles_First(triangles, body + 1); r++)
            skipped += QC_AT(uint8_t, triangles->pcs, r) == 0;
        bool whole = skipped == qcTriangles_Body(triangles, body)->triangleCount;
        profile->skippedBodies += whole;
        profile->skippedTriangles += whole ? 0 : skipped;
    }
}

void qcObjects_Free(qcObjects* objects)
{
    qcSweep_Free(&objects->sweep);
    qcArray_Free(&objects->boxes);
    qcArray_Free(&objects->pairs);
}
