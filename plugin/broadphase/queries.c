// Box queries and total bounds of a set of boxes.
#include "broadphase/box_query.h"

#include "base/scalar.h"

#include <math.h>

__attribute__((noinline)) static void GetTotalBounds(const qcBoxes* boxes, double lower[3], double upper[3])
{
    bool any = qcBoxes_GetCount(boxes) > 0;
    for (int k = 0; k < 3; k++)
    {
        lower[k] = any ? INFINITY : 0.0;
        upper[k] = any ? -INFINITY : 0.0;
    }
    for (size_t id = 0; any && id < boxes->boxes.count; id++)
    {
        if (!qcBoxes_Box(boxes, (uint32_t)id)->alive)
            continue;
        qcBounds bounds = qcBoxes_Bounds(boxes, (uint32_t)id);
        for (int k = 0; k < 3; k++)
        {
            lower[k] = qcMin(lower[k], bounds.lower[k]);
            upper[k] = qcMax(upper[k], bounds.upper[k]);
        }
    }
}

void qcBoxes_GetTotalBounds(const qcBoxes* boxes, double lower[3], double upper[3])
{
    qcFloatMode mode = qcFloatMode_Begin();
    GetTotalBounds(boxes, lower, upper);
    qcFloatMode_End(mode);
}

//  ---- boxes that overlap a box -----------------------------------------------------------------------

__attribute__((noinline)) static void QueryBox(const qcBoxes* boxes, const double lower[3], const double upper[3],
                                               qcHostFunction* host)
{
    qcBoxQuery query = qcBoxQuery_Make(boxes, lower, upper, qcHostFunction_Call, host);
    qcBoxQuery_Run(&query, qc_dynamicBoxes | qc_staticBoxes);
}

void qcBoxes_QueryBox(const qcBoxes* boxes, const double lower[3], const double upper[3], qcBoxFunction* function,
                      void* context)
{
    if (qcBoxes_GetCount(boxes) == 0)
        return;
    qcHostFunction host = {function, context, qcFloatMode_Begin()};
    QueryBox(boxes, lower, upper, &host);
    qcFloatMode_End(host.mode);
}

//  ---- overlaps that began ---------------------------------------------------------------------------

typedef struct BegunQuery
{
    const qcBoxes* set;
    uint32_t id;
    qcHostFunction* host;
} BegunQuery;

/// Calls the host's function for a box that is not the query's own and did not overlap it at the last search.
static bool VisitBegun(uint32_t id, void* userData, void* context)
{
    const BegunQuery* begun = context;
    if (id == begun->id || qcBoxes_OverlappedBefore(begun->set, id, begun->id))
        return true;
    return qcHostFunction_Call(id, userData, begun->host);
}

typedef struct Candidates
{
    uint32_t ids[32], count;
} Candidates;

/// Collects neighbours of a box, from an end of its edge list on, that may overlap it and did not at the last search.
/// Returns the end to continue from.
static uint32_t CollectCandidates(const qcBoxes* set, uint32_t id, uint32_t end, Candidates* candidates)
{
    const qcEdge* edges = set->overlaps.edges.data;
    const qcBox *boxes = set->boxes.data, *box = &boxes[id];
    uint32_t count = 0;
    // Without branches: whether two boxes overlap, and overlapped, is unpredictable.
    for (; end != QC_NO_EDGE && count < 32; end = qcOverlapGraph_NextEnd(&set->overlaps, end))
    {
        const qcEdge* edge = &edges[end / 2];
        uint32_t other = edge->box[1 - end % 2] & ~QC_EDGE_MARK;
        candidates->ids[count] = other;
        count +=
            ((edge->box[0] & QC_EDGE_MARK) == 0) & qcBox_OverlapsFloats(box, boxes[other].lower, boxes[other].upper);
    }
    candidates->count = count;
    return end;
}

/// Visits neighbours in the overlap graph, with or without the dynamic ones. Returns false if the function stops the
/// query.
static bool VisitGraph(BegunQuery* begun, bool withDynamic)
{
    const qcBoxes* set = begun->set;
    Candidates candidates;
    for (uint32_t end = qcOverlapGraph_FirstEnd(&set->overlaps, begun->id); end != QC_NO_EDGE;)
    {
        end = CollectCandidates(set, begun->id, end, &candidates);
        // The common case.
        if (candidates.count == 0)
            continue;
        qcBoxQuery query = qcBoxQuery_MakeFor(set, begun->id, VisitBegun, begun);
        // NOLINTBEGIN(clang-analyzer-core.CallAndMessage): the ids below the count are set.
        for (uint32_t i = 0; i < candidates.count; i++)
            if ((withDynamic || !qcForest_IsDynamic(&set->forest, candidates.ids[i])) &&
                !qcBoxQuery_Test(&query, candidates.ids[i]))
                return false;
        // NOLINTEND(clang-analyzer-core.CallAndMessage)
    }
    return true;
}

__attribute__((noinline)) static void QueryBegun(qcBoxes* boxes, uint32_t id, qcHostFunction* host)
{
    qcBoxes_CommitPairs(boxes, id);
    BegunQuery begun = {boxes, id, host};
    const qcBox* box = qcBoxes_Box(boxes, id);
    // The graph has no edges between two stationary boxes.
    bool known = !box->stationary && !boxes->historyLost && box->state != qc_boxPairsStale;
    // Boxes inserted after this one's overlaps were found may overlap it too.
    bool othersInserted = boxes->insertedCount != (box->state != qc_boxInTree);
    if (known && (!VisitGraph(&begun, !othersInserted) || !othersInserted))
        return;
    qcBoxQuery query = qcBoxQuery_MakeFor(boxes, id, VisitBegun, &begun);
    qcBoxQuery_Run(&query, known ? qc_dynamicBoxes : qc_dynamicBoxes | qc_staticBoxes);
}

void qcBoxes_QueryBegun(qcBoxes* boxes, uint32_t id, qcBoxFunction* function, void* context)
{
    if (boxes == NULL || id >= boxes->boxes.count || !qcBoxes_Box(boxes, id)->alive)
        return;
    qcHostFunction host = {function, context, qcFloatMode_Begin()};
    QueryBegun(boxes, id, &host);
    qcFloatMode_End(host.mode);
}
