// Sweep over the triangles of the PCS, and the rules that turn overlapping boxes into candidates.
#include "sweep/candidates.h"

#include "base/status.h"

#include <string.h>

qcStatus qcCandidates_Begin(qcCandidates* candidates, uint32_t threads)
{
    QC_TRY(qcWorkerResults_Begin(&candidates->sinks, threads, sizeof(qcCandidateBuffer), "candidates"));
    for (size_t i = 0; i < candidates->sinks.count; i++)
    {
        qcCandidateBuffer* sink = &QC_AT(qcCandidateBuffer, candidates->sinks, i);
        sink->keys.count = sink->neighbourKeys.count = 0;
        sink->neighbours = sink->setPairs = 0;
    }
    return qc_statusOk;
}

void qcCandidates_Offer(const qcCandidateRules* rules, qcCandidateBuffer* sink, uint32_t bodyA, uint32_t rankA,
                        uint32_t bodyB, uint32_t rankB)
{
    const qcStepTriangles* t = rules->triangles;
    uint8_t a = QC_AT(uint8_t, t->pcs, rankA), b = QC_AT(uint8_t, t->pcs, rankB);
    bool self = bodyA == bodyB;
    unsigned setA = self ? qcStepTriangles_SelfSet(a) : qcStepTriangles_InterSet(a);
    unsigned setB = self ? qcStepTriangles_SelfSet(b) : qcStepTriangles_InterSet(b);
    if (setA == qc_setBfv || setB == qc_setBfv)
        return; // one of them takes part for the sake of others
    qcArray* keys = &sink->keys;
    if (self)
    {
        uint32_t first = qcStepTriangles_First(t, bodyA);
        if (qcBody_AreNeighbours(qcStepTriangles_Body(t, bodyA), rankA - first, rankB - first))
        {
            sink->neighbours += !rules->testNeighbours;
            if (!rules->testNeighbours && !rules->listNeighbours)
                return;
            if (!rules->testNeighbours)
                keys = &sink->neighbourKeys;
        }
    }
    else if (qcBodyPair_Classify(t, bodyA, bodyB) != qc_verdictYes)
        return; // counted once, as a pair of bodies
    if (!qcVisibilitySet_MayCollide(setA, setB))
    {
        sink->setPairs++;
        return;
    }
    if (!qcWorkerResult_IsOk(&sink->result))
        return;
    qcStatus status = qcArray_Reserve(keys, keys->count + 1, sizeof(uint64_t), "candidate pairs");
    if (qcWorkerResult_Add(&sink->result, status))
        QC_AT(uint64_t, *keys, keys->count++) = qcStepTriangles_Key(rankA, rankB);
}

qcStatus qcCandidates_End(qcCandidates* candidates, qcProfile* profile)
{
    QC_TRY(qcWorkerResults_End(&candidates->sinks, sizeof(qcCandidateBuffer)));
    size_t total = 0, neighbours = 0;
    for (size_t i = 0; i < candidates->sinks.count; i++)
    {
        const qcCandidateBuffer* sink = &QC_AT(qcCandidateBuffer, candidates->sinks, i);
        total += sink->keys.count;
        neighbours += sink->neighbourKeys.count;
        profile->skippedNeighbours += sink->neighbours;
        profile->skippedSetCandidates += sink->setPairs;
    }
    candidates->keys.count = candidates->neighbourKeys.count = candidates->sure.count = 0;
    QC_TRY(qcArray_Reserve(&candidates->keys, total, sizeof(uint64_t), "candidate pairs"));
    QC_TRY(qcArray_Reserve(&candidates->neighbourKeys, neighbours, sizeof(uint64_t), "candidate pairs"));
    for (size_t i = 0; i < candidates->sinks.count; i++)
    {
        const qcCandidateBuffer* sink = &QC_AT(qcCandidateBuffer, candidates->sinks, i);
        QC_TRY(qcArray_Append(&candidates->keys, &sink->keys, sizeof(uint64_t), "candidate pairs"));
        QC_TRY(qcArray_Append(&candidates->neighbourKeys, &sink->neighbourKeys, sizeof(uint64_t), "candidate pairs"));
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
    qcCandidates_Offer(search->rules, &QC_AT(qcCandidateBuffer, search->candidates->sinks, worker), a->body, a->item,
                       b->body, b->item);
}

qcStatus qcCandidates_Sweep(qcCandidates* candidates, const qcCandidateRules* rules, qcProfile* profile)
{
    const qcStepTriangles* t = rules->triangles;
    QC_TRY(qcCandidates_Begin(candidates, rules->threads));
    size_t most = 0;
    for (uint32_t body = 0; body < t->bodyCount; body++)
        most += rules->elsewhere[body] ? 0 : qcStepTriangles_Body(t, body)->triangleCount;
    if (most == 0)
    {
        // Bodies are swept this way when they are new: what that took is not needed again.
        if (candidates->boxes.capacity != 0)
        {
            qcCandidates_Free(candidates);
            QC_TRY(qcCandidates_Begin(candidates, rules->threads));
        }
        return qcCandidates_End(candidates, profile);
    }
    QC_TRY(qcArray_Resize(&candidates->boxes, most, sizeof(qcSweepBox), "boxes of triangles"));
    qcSweepFrame frame = {{0.0, 0.0, 0.0}, rules->margin};
    uint32_t count = 0;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(t, body);
        uint32_t first = qcStepTriangles_First(t, body);
        for (uint32_t i = 0; i < b->triangleCount && !rules->elsewhere[body]; i++)
        {
            if (QC_AT(uint8_t, t->pcs, first + i) == 0)
                continue;
            double lower[3], upper[3];
            qcBody_GetTriangleBox(b, i, lower, upper);
            // Any origin is right; one in the scene keeps what single precision can tell apart.
            if (count == 0)
                memcpy(frame.origin, lower, sizeof frame.origin);
            QC_AT(qcSweepBox, candidates->boxes, count++) = qcSweepFrame_Map(&frame, lower, upper, body, first + i);
        }
    }
    Search search = {rules, candidates};
    QC_TRY(qcSweep_FindPairs(&candidates->sweep, candidates->boxes.data, count, rules->threads, OfferBoxes, &search));
    return qcCandidates_End(candidates, profile);
}

/// Appends items that begin with the key of a pair, but for those that the filter leaves out.
static qcStatus AppendMeeting(qcArray* array, const qcStepTriangles* t, const qcArray* items, size_t itemSize)
{
    size_t kept = array->count;
    QC_TRY(qcArray_Append(array, items, itemSize, "candidate pairs"));
    if (t->filter == NULL)
        return qc_statusOk;
    char* data = array->data;
    for (size_t i = kept; i < array->count; i++)
    {
        uint64_t key;
        memcpy(&key, data + i * itemSize, sizeof key);
        uint32_t a = qcStepTriangles_BodyOf(t, (uint32_t)(key >> 32)), b = qcStepTriangles_BodyOf(t, (uint32_t)key);
        if (a == b || qcBodyPair_Classify(t, a, b) == qc_verdictYes)
            memmove(data + itemSize * kept++, data + i * itemSize, itemSize);
    }
    array->count = kept;
    return qc_statusOk;
}

qcStatus qcCandidates_Add(qcCandidates* candidates, const qcStepTriangles* triangles, const qcPairKeys* keys)
{
    QC_TRY(AppendMeeting(&candidates->keys, triangles, keys->keys, sizeof(uint64_t)));
    QC_TRY(AppendMeeting(&candidates->neighbourKeys, triangles, keys->contactKeys, sizeof(uint64_t)));
    return AppendMeeting(&candidates->sure, triangles, keys->classified, sizeof(qcSortItem));
}

void qcCandidates_Free(qcCandidates* candidates)
{
    for (size_t i = 0; i < candidates->sinks.count; i++)
    {
        qcArray_Free(&QC_AT(qcCandidateBuffer, candidates->sinks, i).keys);
        qcArray_Free(&QC_AT(qcCandidateBuffer, candidates->sinks, i).neighbourKeys);
    }
    qcSweep_Free(&candidates->sweep);
    qcArray_Free(&candidates->boxes);
    qcArray_Free(&candidates->rows);
    qcArray_Free(&candidates->ranks);
    qcArray_Free(&candidates->sinks);
    qcArray_Free(&candidates->keys);
    qcArray_Free(&candidates->neighbourKeys);
    qcArray_Free(&candidates->sure);
}
