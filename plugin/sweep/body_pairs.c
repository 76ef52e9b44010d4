// Sweep and prune over the boxes of bodies, and the triangles inside the overlaps.
//
// Rounding: a margin is added to upper ends only, so that lower(A) <= upper(B) + margin, true in real numbers, stays
// true when the sum is rounded (see sweep/sweep_and_prune.c).
#include "sweep/body_pairs.h"

#include "base/status.h"

#include <string.h>

enum
{
    // Looking at all triangles for one partner takes about a fifth of sweeping them: with more partners the sweep alone
    // sorts them out (500 K triangles of a grid under 1 to 400 spheres).
    qc_mostPartners = 4
};

qcPairVerdict qcBodyPair_Classify(const qcStepTriangles* triangles, uint32_t a, uint32_t b)
{
    const qcBody *p = qcStepTriangles_Body(triangles, a), *q = qcStepTriangles_Body(triangles, b);
    if (p->activity != qc_activityMoving && q->activity != qc_activityMoving)
        return qc_verdictAtRest;
    if ((p->group & q->mask) == 0 || (q->group & p->mask) == 0 || (p->owner != 0 && p->owner == q->owner))
        return qc_verdictFiltered;
    if (triangles->filter != NULL && !triangles->filter(triangles->filterContext, qcStepTriangles_Slot(triangles, a),
                                                        qcStepTriangles_Slot(triangles, b)))
        return qc_verdictFiltered;
    if (!qcVisibilitySet_MayCollide(QC_AT(uint8_t, triangles->bodySet, a), QC_AT(uint8_t, triangles->bodySet, b)))
        return qc_verdictSameSet;
    return qc_verdictYes;
}

typedef struct Search
{
    const qcStepTriangles* triangles;
    qcArray* pairs;
    qcProfile* profile;
    qcStatus status;
} Search;

/// Two bodies, a < b, whose boxes overlap.
static void OfferPair(Search* search, uint32_t a, uint32_t b)
{
    switch (qcBodyPair_Classify(search->triangles, a, b))
    {
        case qc_verdictAtRest: search->profile->skippedStaticPairs++; return;
        case qc_verdictFiltered: search->profile->skippedFilteredPairs++; return;
        case qc_verdictSameSet: search->profile->skippedSetPairs++; return;
        case qc_verdictYes: break;
    }
    if (search->status != qc_statusOk)
        return;
    search->status = qcArray_Reserve(search->pairs, search->pairs->count + 1, sizeof(qcBodyPair), "pairs of bodies");
    if (search->status == qc_statusOk)
        QC_AT(qcBodyPair, *search->pairs, search->pairs->count++) = (qcBodyPair){a, b};
}

static void OfferBoxes(void* context, const qcSweepBox* x, const qcSweepBox* y, uint32_t worker)
{
    (void)worker;
    OfferPair(context, x->body < y->body ? x->body : y->body, x->body < y->body ? y->body : x->body);
}

/// Something to collide with?
static bool IsPresent(const qcStepTriangles* triangles, uint32_t body)
{
    return qcStepTriangles_Body(triangles, body)->triangleCount != 0 &&
           QC_AT(uint8_t, triangles->bodySet, body) != qc_setBfv;
}

qcStatus qcBodyPairs_FindPairs(qcBodyPairs* objects, const qcStepTriangles* triangles, double margin,
                               qcProfile* profile)
{
    objects->pairs.count = 0;
    QC_TRY(qcArray_Resize(&objects->boxes, triangles->bodyCount, sizeof(qcSweepBox), "boxes of bodies"));
    qcSweepFrame frame = {{0.0, 0.0, 0.0}, margin};
    uint32_t count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        if (!IsPresent(triangles, body))
            continue;
        const qcBody* b = qcStepTriangles_Body(triangles, body);
        if (count == 0)
            for (int axis = 0; axis < 3; axis++)
                frame.origin[axis] = b->lower[axis];
        QC_AT(qcSweepBox, objects->boxes, count++) = qcSweepFrame_Map(&frame, b->lower, b->upper, body, body);
    }
    Search search = {triangles, &objects->pairs, profile, qc_statusOk};
    // One thread: the counters are shared, and bodies are few beside triangles.
    QC_TRY(qcSweep_FindPairs(&objects->sweep, objects->boxes.data, count, 1, OfferBoxes, &search));
    profile->bodyPairs = objects->pairs.count;
    return search.status;
}

static bool AreNear(const double lowerA[3], const double upperA[3], const double lowerB[3], const double upperB[3],
                    double margin)
{
    bool near = true;
    for (int axis = 0; axis < 3; axis++)
        near = near && lowerA[axis] <= upperB[axis] + margin && lowerB[axis] <= upperA[axis] + margin;
    return near;
}

qcStatus qcBodyPairs_FindPairsBrute(qcBodyPairs* objects, const qcStepTriangles* triangles, double margin,
                                    qcProfile* profile)
{
    objects->pairs.count = 0;
    Search search = {triangles, &objects->pairs, profile, qc_statusOk};
    for (uint32_t a = 0; a < triangles->bodyCount; a++)
        for (uint32_t b = a + 1; b < triangles->bodyCount && IsPresent(triangles, a); b++)
        {
            const qcBody *p = qcStepTriangles_Body(triangles, a), *q = qcStepTriangles_Body(triangles, b);
            if (IsPresent(triangles, b) && AreNear(p->lower, p->upper, q->lower, q->upper, margin))
                OfferPair(&search, a, b);
        }
    profile->bodyPairs = objects->pairs.count;
    return search.status;
}

/// Triangles of `body` near the box of `other`.
static void MarkNear(qcStepTriangles* triangles, uint32_t body, const qcBody* other, double margin)
{
    const qcBody* b = qcStepTriangles_Body(triangles, body);
    uint8_t* pcs = &QC_AT(uint8_t, triangles->pcs, qcStepTriangles_First(triangles, body));
    for (uint32_t t = 0; t < b->triangleCount; t++)
    {
        if (qcStepTriangles_InterSet(pcs[t]) != qc_setBfv)
            continue;
        double lower[3], upper[3];
        qcBody_GetTriangleBox(b, t, lower, upper);
        if (AreNear(lower, upper, other->lower, other->upper, margin))
            pcs[t] |= qcStepTriangles_Pcs(qc_setNfv, qc_setBfv);
    }
}

static void MarkAll(qcStepTriangles* triangles, uint32_t body, uint8_t mark)
{
    for (uint32_t r = qcStepTriangles_First(triangles, body); r < qcStepTriangles_First(triangles, body + 1); r++)
        QC_AT(uint8_t, triangles->pcs, r) |= mark;
}

/// Marks the triangles of a body that take part for the sake of one partner.
static void MarkFor(const qcBodyPairs* objects, qcStepTriangles* triangles, uint32_t body, uint32_t partner,
                    double margin)
{
    if (QC_AT(uint32_t, objects->partners, body) <= qc_mostPartners)
        MarkNear(triangles, body, qcStepTriangles_Body(triangles, partner), margin);
}

qcStatus qcBodyPairs_MarkTriangles(qcBodyPairs* objects, qcStepTriangles* triangles, double margin, bool wholeBodies,
                                   const uint8_t* elsewhere, qcProfile* profile)
{
    QC_TRY(qcArray_Resize(&objects->partners, triangles->bodyCount, sizeof(uint32_t), "pairs of bodies"));
    if (triangles->bodyCount != 0)
        memset(objects->partners.data, 0, triangles->bodyCount * sizeof(uint32_t));
    for (size_t i = 0; i < objects->pairs.count; i++)
    {
        QC_AT(uint32_t, objects->partners, QC_AT(qcBodyPair, objects->pairs, i).a)++;
        QC_AT(uint32_t, objects->partners, QC_AT(qcBodyPair, objects->pairs, i).b)++;
    }
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        uint32_t partners = QC_AT(uint32_t, objects->partners, body);
        if ((elsewhere == NULL || !elsewhere[body]) && (partners > qc_mostPartners || (partners > 0 && wholeBodies)))
            MarkAll(triangles, body, qcStepTriangles_Pcs(qc_setNfv, qc_setBfv));
    }
    for (size_t i = 0; i < objects->pairs.count && !wholeBodies; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, objects->pairs, i);
        if (elsewhere != NULL && elsewhere[pair.a])
            continue;
        MarkFor(objects, triangles, pair.a, pair.b, margin);
        MarkFor(objects, triangles, pair.b, pair.a, margin);
    }
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        if (elsewhere != NULL && elsewhere[body])
            continue;
        bool self = qcBody_HasSelfCollision(qcStepTriangles_Body(triangles, body));
        if (self)
            MarkAll(triangles, body, qcStepTriangles_Pcs(qc_setBfv, qc_setNfv));
        profile->selfBodies += self;
        uint32_t skipped = 0;
        for (uint32_t r = qcStepTriangles_First(triangles, body); r < qcStepTriangles_First(triangles, body + 1); r++)
            skipped += QC_AT(uint8_t, triangles->pcs, r) == 0;
        bool whole = skipped == qcStepTriangles_Body(triangles, body)->triangleCount;
        profile->skippedBodies += whole;
        profile->skippedTriangles += whole ? 0 : skipped;
    }
    return qc_statusOk;
}

void qcBodyPairs_Free(qcBodyPairs* objects)
{
    qcSweep_Free(&objects->sweep);
    qcArray_Free(&objects->boxes);
    qcArray_Free(&objects->pairs);
    qcArray_Free(&objects->partners);
}
