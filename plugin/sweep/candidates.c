// Sweep and prune over the triangles of the PCS, and the rules that turn overlapping boxes into candidates.
#include "sweep/candidates.h"

#include "base/status.h"

#include <string.h>

qcStatus qcCandidates_Begin(qcCandidates* candidates, uint32_t threads)
{
    QC_TRY(qcWorkerResults_Begin(&candidates->buffers, threads, sizeof(qcCandidateBuffer), "candidates"));
    for (size_t i = 0; i < candidates->buffers.count; i++)
    {
        qcCandidateBuffer* buffer = &QC_AT(qcCandidateBuffer, candidates->buffers, i);
        buffer->keys.count = buffer->contactKeys.count = 0;
        buffer->neighbourPairs = buffer->setPairs = 0;
    }
    return qc_statusOk;
}

void qcCandidates_Offer(const qcCandidateRules* rules, uint32_t bodyA, uint32_t triangleA, uint32_t bodyB,
                        uint32_t triangleB, qcCandidateBuffer* buffer)
{
    const qcStepTriangles* t = rules->triangles;
    uint8_t a = QC_AT(uint8_t, rules->pcs->triangleSets, triangleA);
    uint8_t b = QC_AT(uint8_t, rules->pcs->triangleSets, triangleB);
    bool self = bodyA == bodyB;
    unsigned setA = self ? qcPcs_SelfSet(a) : qcPcs_InterSet(a);
    unsigned setB = self ? qcPcs_SelfSet(b) : qcPcs_InterSet(b);
    if (setA == qc_setBfv || setB == qc_setBfv)
        return; // the triangle is in the PCS against other partners only
    qcArray* keys = &buffer->keys;
    if (self)
    {
        uint32_t first = qcStepTriangles_First(t, bodyA);
        if (qcBody_AreNeighbours(qcStepTriangles_Body(t, bodyA), triangleA - first, triangleB - first))
        {
            buffer->neighbourPairs += !rules->testNeighbours;
            if (!rules->testNeighbours && !rules->listNeighbours)
                return;
            if (!rules->testNeighbours)
                keys = &buffer->contactKeys;
        }
    }
    else if (qcBodyPair_Classify(t, rules->pcs, bodyA, bodyB) != qc_pairTest)
        return; // counted in the profile as a skipped body pair
    if (!qcVisibilitySet_MayCollide(setA, setB))
    {
        buffer->setPairs++;
        return;
    }
    if (!qcWorkerResult_IsOk(&buffer->result))
        return;
    qcStatus status = qcRelatedPair_CheckCount(keys->count + 1, t->maxPairs);
    if (status == qc_statusOk)
        status = qcArray_Reserve(keys, keys->count + 1, sizeof(uint64_t), "candidate pairs");
    if (qcWorkerResult_Add(&buffer->result, status))
        QC_AT(uint64_t, *keys, keys->count++) = qcStepTriangles_Key(triangleA, triangleB);
}

qcStatus qcCandidates_End(qcCandidates* candidates, qcProfile* profile)
{
    QC_TRY(qcWorkerResults_End(&candidates->buffers, sizeof(qcCandidateBuffer)));
    size_t total = 0, contactCount = 0;
    for (size_t i = 0; i < candidates->buffers.count; i++)
    {
        const qcCandidateBuffer* buffer = &QC_AT(qcCandidateBuffer, candidates->buffers, i);
        total += buffer->keys.count;
        contactCount += buffer->contactKeys.count;
        profile->skippedNeighbours += buffer->neighbourPairs;
        profile->skippedSetCandidates += buffer->setPairs;
    }
    candidates->keys.count = candidates->contactKeys.count = candidates->classified.count = 0;
    QC_TRY(qcArray_Reserve(&candidates->keys, total, sizeof(uint64_t), "candidate pairs"));
    QC_TRY(qcArray_Reserve(&candidates->contactKeys, contactCount, sizeof(uint64_t), "candidate pairs"));
    for (size_t i = 0; i < candidates->buffers.count; i++)
    {
        const qcCandidateBuffer* buffer = &QC_AT(qcCandidateBuffer, candidates->buffers, i);
        QC_TRY(qcArray_Append(&candidates->keys, &buffer->keys, sizeof(uint64_t), "candidate pairs"));
        QC_TRY(qcArray_Append(&candidates->contactKeys, &buffer->contactKeys, sizeof(uint64_t), "candidate pairs"));
    }
    return qc_statusOk;
}

typedef struct Search
{
    const qcCandidateRules* rules;
    qcCandidates* candidates;
} Search;

static void OfferBoxes(void* context, const qcSweepBox* a, const qcSweepBox* b, uint32_t worker)
{
    const Search* search = context;
    qcCandidates_Offer(search->rules, a->body, a->item, b->body, b->item,
                       &QC_AT(qcCandidateBuffer, search->candidates->buffers, worker));
}

/// A frame around the median triangle of `triangleCount` in all.
static qcSweepFrame MakeFrame(const qcCandidateRules* rules, size_t triangleCount)
{
    const qcStepTriangles* t = rules->triangles;
    qcSweepFrame frame = {.margin = rules->queryDistance};
    double corners[qc_originCorners][3], upper[3];
    uint32_t count = 0;
    const size_t step = triangleCount / qc_originCorners + 1;
    size_t first = 0, next = 0;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        size_t end = first + (rules->handledElsewhere[body] ? 0 : qcStepTriangles_Body(t, body)->triangleCount);
        for (; next < end; next += step)
            qcStepTriangles_GetTriangleBox(t, body, (uint32_t)(next - first), corners[count++], upper);
        first = end;
    }
    qcSweepFrame_SetOrigin(&frame, corners, count);
    return frame;
}

/// The boxes of the triangles of the PCS, for which there is room.
static uint32_t FillBoxes(const qcCandidateRules* rules, const qcSweepFrame* frame, qcSweepBox* boxes)
{
    const qcStepTriangles* t = rules->triangles;
    uint32_t count = 0;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(t, body);
        uint32_t first = qcStepTriangles_First(t, body);
        for (uint32_t i = 0; i < b->triangleCount && !rules->handledElsewhere[body]; i++)
        {
            if (QC_AT(uint8_t, rules->pcs->triangleSets, first + i) == 0)
                continue;
            double lower[3], upper[3];
            qcStepTriangles_GetTriangleBox(t, body, i, lower, upper);
            boxes[count++] = qcSweepFrame_Map(frame, lower, upper, body, first + i);
        }
    }
    return count;
}

qcStatus qcCandidates_Sweep(const qcCandidateRules* rules, qcCandidates* candidates, qcProfile* profile)
{
    const qcStepTriangles* t = rules->triangles;
    QC_TRY(qcCandidates_Begin(candidates, rules->threads));
    size_t maxCount = 0;
    for (uint32_t body = 0; body < t->bodyCount; body++)
        maxCount += rules->handledElsewhere[body] ? 0 : qcStepTriangles_Body(t, body)->triangleCount;
    if (maxCount == 0)
    {
        // Bodies are swept in this way in their first step only: the memory is given back.
        if (candidates->boxes.capacity != 0)
        {
            qcCandidates_Free(candidates);
            QC_TRY(qcCandidates_Begin(candidates, rules->threads));
        }
        return qcCandidates_End(candidates, profile);
    }
    QC_TRY(qcArray_Resize(&candidates->boxes, maxCount, sizeof(qcSweepBox), "boxes of triangles"));
    const qcSweepFrame frame = MakeFrame(rules, maxCount);
    uint32_t count = FillBoxes(rules, &frame, candidates->boxes.data);
    Search search = {rules, candidates};
    QC_TRY(qcSweep_FindPairs(&candidates->sweep, candidates->boxes.data, count, rules->threads, OfferBoxes, &search));
    return qcCandidates_End(candidates, profile);
}

/// Appends pairs, given by their keys or as qcRelatedPair_Make, without those that the step's filter leaves out. Where
/// there are no others the lists swap places.
static qcStatus TakeFiltered(const qcStepTriangles* t, const qcPcs* pcs, qcArray* pairs, bool related, qcArray* array)
{
    size_t kept = array->count;
    if (kept == 0 && t->filter == NULL)
    {
        qcArray empty = *array;
        *array = *pairs;
        *pairs = empty;
        return qc_statusOk;
    }
    QC_TRY(qcArray_Append(array, pairs, sizeof(uint64_t), "candidate pairs"));
    if (t->filter == NULL)
        return qc_statusOk;
    for (size_t i = kept; i < array->count; i++)
    {
        uint64_t pair = QC_AT(uint64_t, *array, i), key = related ? qcRelatedPair_Key(pair) : pair;
        uint32_t a = qcStepTriangles_BodyOf(t, (uint32_t)(key >> 32)), b = qcStepTriangles_BodyOf(t, (uint32_t)key);
        if (a == b || qcBodyPair_Classify(t, pcs, a, b) == qc_pairTest)
            QC_AT(uint64_t, *array, kept++) = pair;
    }
    array->count = kept;
    return qc_statusOk;
}

qcStatus qcCandidates_Take(const qcStepTriangles* triangles, const qcPcs* pcs, const qcPairKeys* keys,
                           qcCandidates* candidates)
{
    QC_TRY(TakeFiltered(triangles, pcs, keys->keys, false, &candidates->keys));
    QC_TRY(TakeFiltered(triangles, pcs, keys->contactKeys, false, &candidates->contactKeys));
    QC_TRY(TakeFiltered(triangles, pcs, keys->classified, true, &candidates->classified));
    QC_TRY(qcRelatedPair_CheckCount(candidates->keys.count + candidates->classified.count, triangles->maxPairs));
    return qcRelatedPair_CheckCount(candidates->contactKeys.count, triangles->maxPairs);
}

void qcCandidates_Free(qcCandidates* candidates)
{
    for (size_t i = 0; i < candidates->buffers.count; i++)
    {
        qcArray_Free(&QC_AT(qcCandidateBuffer, candidates->buffers, i).keys);
        qcArray_Free(&QC_AT(qcCandidateBuffer, candidates->buffers, i).contactKeys);
    }
    qcSweep_Free(&candidates->sweep);
    qcArray_Free(&candidates->boxes);
    qcArray_Free(&candidates->rows);
    qcArray_Free(&candidates->rowOwner);
    qcArray_Free(&candidates->buffers);
    qcArray_Free(&candidates->keys);
    qcArray_Free(&candidates->contactKeys);
    qcArray_Free(&candidates->classified);
}
