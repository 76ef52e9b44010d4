// Sweep and prune over the boxes of bodies, and the triangles inside the overlaps.
//
// Rounding: the query distance is added to upper ends only, so that lower(A) <= upper(B) + distance, true in real
// numbers, stays true when the sum is rounded. Proof: plugin/docs/proofs/sweep_and_prune.md.
#include "sweep/body_pairs.h"

#include "base/aabb.h"
#include "base/status.h"

#include <string.h>

enum
{
    // Comparing all triangles with one partner's box takes about a fifth of sweeping them. With more partners the sweep
    // alone is quicker (500 K triangles of a grid under 1 to 400 spheres).
    qc_maxPartners = 4
};

qcPairVerdict qcBodyPair_Classify(const qcStepTriangles* triangles, const qcPcs* pcs, uint32_t a, uint32_t b)
{
    const qcBody *p = qcStepTriangles_Body(triangles, a), *q = qcStepTriangles_Body(triangles, b);
    if (p->activity != qc_activityMoving && q->activity != qc_activityMoving)
        return qc_pairAtRest;
    if ((p->group & q->mask) == 0 || (q->group & p->mask) == 0 || (p->owner != 0 && p->owner == q->owner))
        return qc_pairFiltered;
    if (triangles->filter != NULL && !triangles->filter(triangles->filterContext, qcStepTriangles_Slot(triangles, a),
                                                        qcStepTriangles_Slot(triangles, b)))
        return qc_pairFiltered;
    if (!qcVisibilitySet_MayCollide(QC_AT(uint8_t, pcs->bodySets, a), QC_AT(uint8_t, pcs->bodySets, b)))
        return qc_pairSameSet;
    return qc_pairTest;
}

typedef struct Search
{
    const qcStepTriangles* triangles;
    const qcPcs* pcs;
    qcArray* pairs;
    qcProfile* profile;
    qcStatus status;
} Search;

/// Adds two bodies, a < b, whose boxes overlap.
static void OfferPair(Search* search, uint32_t a, uint32_t b)
{
    switch (qcBodyPair_Classify(search->triangles, search->pcs, a, b))
    {
        case qc_pairAtRest: search->profile->skippedStaticPairs++; return;
        case qc_pairFiltered: search->profile->skippedFilteredPairs++; return;
        case qc_pairSameSet: search->profile->skippedSetPairs++; return;
        case qc_pairTest: break;
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

/// Whether the body has triangles and was not culled.
static bool IsPresent(const qcStepTriangles* triangles, const qcPcs* pcs, uint32_t body)
{
    return qcStepTriangles_Body(triangles, body)->triangleCount != 0 &&
           QC_AT(uint8_t, pcs->bodySets, body) != qc_setBfv;
}

static qcStatus CountPartners(uint32_t bodyCount, qcBodyPairs* pairs)
{
    QC_TRY(qcArray_Resize(&pairs->partnerCounts, bodyCount, sizeof(uint32_t), "pairs of bodies"));
    if (bodyCount != 0)
        memset(pairs->partnerCounts.data, 0, bodyCount * sizeof(uint32_t));
    for (size_t i = 0; i < pairs->pairs.count; i++)
    {
        QC_AT(uint32_t, pairs->partnerCounts, QC_AT(qcBodyPair, pairs->pairs, i).a)++;
        QC_AT(uint32_t, pairs->partnerCounts, QC_AT(qcBodyPair, pairs->pairs, i).b)++;
    }
    return qc_statusOk;
}

/// A frame around the median body.
static qcSweepFrame MakeFrame(const qcStepTriangles* triangles, const qcPcs* pcs, double queryDistance)
{
    qcSweepFrame frame = {.margin = queryDistance};
    double corners[qc_originCorners][3], upper[3];
    uint32_t count = 0;
    for (uint32_t part = 0, body = 0; part < qc_originCorners; part++)
    {
        // The first body of each part of the bodies.
        uint32_t end = (uint32_t)((uint64_t)(part + 1) * triangles->bodyCount / qc_originCorners);
        while (body < end && !IsPresent(triangles, pcs, body))
            body++;
        if (body < end)
            qcStepTriangles_GetBodyBox(triangles, body, corners[count++], upper);
        body = end;
    }
    qcSweepFrame_SetOrigin(&frame, corners, count);
    return frame;
}

qcStatus qcBodyPairs_Find(const qcStepTriangles* triangles, const qcPcs* pcs, double queryDistance, qcBodyPairs* pairs,
                          qcProfile* profile)
{
    pairs->pairs.count = 0;
    QC_TRY(qcArray_Resize(&pairs->boxes, triangles->bodyCount, sizeof(qcSweepBox), "boxes of bodies"));
    const qcSweepFrame frame = MakeFrame(triangles, pcs, queryDistance);
    uint32_t count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        if (!IsPresent(triangles, pcs, body))
            continue;
        double lower[3], upper[3];
        qcStepTriangles_GetBodyBox(triangles, body, lower, upper);
        QC_AT(qcSweepBox, pairs->boxes, count++) = qcSweepFrame_Map(&frame, lower, upper, body, body);
    }
    Search search = {triangles, pcs, &pairs->pairs, profile, qc_statusOk};
    // One thread: the counters are shared, and bodies are few beside triangles.
    QC_TRY(qcSweep_FindPairs(&pairs->sweep, pairs->boxes.data, count, 1, OfferBoxes, &search));
    QC_TRY(search.status);
    profile->bodyPairs = pairs->pairs.count;
    return CountPartners(triangles->bodyCount, pairs);
}

qcStatus qcBodyPairs_FindBrute(const qcStepTriangles* triangles, const qcPcs* pcs, double queryDistance,
                               qcBodyPairs* pairs, qcProfile* profile)
{
    pairs->pairs.count = 0;
    Search search = {triangles, pcs, &pairs->pairs, profile, qc_statusOk};
    for (uint32_t a = 0; a < triangles->bodyCount; a++)
        for (uint32_t b = a + 1; b < triangles->bodyCount && IsPresent(triangles, pcs, a); b++)
        {
            double lowerA[3], upperA[3], lowerB[3], upperB[3];
            qcStepTriangles_GetBodyBox(triangles, a, lowerA, upperA);
            qcStepTriangles_GetBodyBox(triangles, b, lowerB, upperB);
            if (IsPresent(triangles, pcs, b) && qcBounds_AreNear(lowerA, upperA, lowerB, upperB, queryDistance))
                OfferPair(&search, a, b);
        }
    QC_TRY(search.status);
    profile->bodyPairs = pairs->pairs.count;
    return CountPartners(triangles->bodyCount, pairs);
}

/// Marks the triangles of `body` whose boxes come within the distance of the box of `partner`.
static void MarkNear(const qcStepTriangles* triangles, uint32_t body, uint32_t partner, double distance, qcPcs* pcs)
{
    const qcBody* b = qcStepTriangles_Body(triangles, body);
    double partnerLower[3], partnerUpper[3];
    qcStepTriangles_GetBodyBox(triangles, partner, partnerLower, partnerUpper);
    uint8_t* sets = &QC_AT(uint8_t, pcs->triangleSets, qcStepTriangles_First(triangles, body));
    for (uint32_t t = 0; t < b->triangleCount; t++)
    {
        if (qcPcs_InterSet(sets[t]) != qc_setBfv)
            continue;
        double lower[3], upper[3];
        qcStepTriangles_GetTriangleBox(triangles, body, t, lower, upper);
        if (qcBounds_AreNear(lower, upper, partnerLower, partnerUpper, distance))
            sets[t] |= qcPcs_Pack(qc_setNfv, qc_setBfv);
    }
}

static void MarkAll(const qcStepTriangles* triangles, uint32_t body, uint8_t mark, qcPcs* pcs)
{
    for (uint32_t t = qcStepTriangles_First(triangles, body); t < qcStepTriangles_First(triangles, body + 1); t++)
        QC_AT(uint8_t, pcs->triangleSets, t) |= mark;
}

static void MarkAgainstPartners(const qcBodyPairs* pairs, const qcStepTriangles* triangles, double queryDistance,
                                bool wholeBodies, const uint8_t* handledElsewhere, qcPcs* pcs)
{
    const uint32_t* partners = pairs->partnerCounts.data;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (!handledElsewhere[body] && (partners[body] > qc_maxPartners || (partners[body] > 0 && wholeBodies)))
            MarkAll(triangles, body, qcPcs_Pack(qc_setNfv, qc_setBfv), pcs);
    for (size_t i = 0; i < pairs->pairs.count && !wholeBodies; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, pairs->pairs, i);
        if (handledElsewhere[pair.a])
            continue;
        if (partners[pair.a] <= qc_maxPartners)
            MarkNear(triangles, pair.a, pair.b, queryDistance, pcs);
        if (partners[pair.b] <= qc_maxPartners)
            MarkNear(triangles, pair.b, pair.a, queryDistance, pcs);
    }
}

void qcBodyPairs_MarkTriangles(const qcBodyPairs* pairs, const qcStepTriangles* triangles, double queryDistance,
                               bool wholeBodies, uint8_t* handledElsewhere, qcPcs* pcs, qcProfile* profile)
{
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (!handledElsewhere[body])
            qcPcs_ResetTriangles(qcStepTriangles_First(triangles, body), qcStepTriangles_First(triangles, body + 1),
                                 pcs);
    MarkAgainstPartners(pairs, triangles, queryDistance, wholeBodies, handledElsewhere, pcs);
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        if (handledElsewhere[body])
            continue;
        bool self = qcBody_HasSelfCollision(qcStepTriangles_Body(triangles, body));
        if (!self && QC_AT(uint32_t, pairs->partnerCounts, body) == 0)
        {
            handledElsewhere[body] = 1;
            profile->skippedBodies++;
            continue;
        }
        if (self)
            MarkAll(triangles, body, qcPcs_Pack(qc_setBfv, qc_setNfv), pcs);
        profile->selfBodies += self;
        uint32_t skipped = 0;
        for (uint32_t t = qcStepTriangles_First(triangles, body); t < qcStepTriangles_First(triangles, body + 1); t++)
            skipped += QC_AT(uint8_t, pcs->triangleSets, t) == 0;
        bool whole = skipped == qcStepTriangles_Body(triangles, body)->triangleCount;
        profile->skippedBodies += whole;
        profile->skippedTriangles += whole ? 0 : skipped;
    }
}

void qcBodyPairs_Free(qcBodyPairs* pairs)
{
    qcSweep_Free(&pairs->sweep);
    qcArray_Free(&pairs->boxes);
    qcArray_Free(&pairs->pairs);
    qcArray_Free(&pairs->partnerCounts);
}
