// The overlapping pairs of moved boxes, and the pairs that changed. The overlap graph keeps pairs whose fat AABBs
// overlap, so the forest is searched only for boxes that left their fat AABB. Fat AABBs: Catto, Box2D. Proof that no
// pair is missed: plugin/docs/proofs/overlap_graph.md.
#include "broadphase/box_set.h"

#include "base/float_mode.h"
#include "base/radix_sort.h"
#include "base/status.h"

enum
{
    // Two octets.
    qc_shortList = 16,
    // Edges of one box that are compared together.
    qc_edgeBlock = 32
};

/// The pairs that a search reports.
typedef enum Report
{
    MOVED,  ///< overlapping pairs with a moved box
    CHANGED ///< pairs whose overlap began or ended
} Report;

/// A pair's sort key: orders pairs by a, then b, in as few digits as possible.
static uint64_t PairKey(const qcBoxes* set, uint32_t a, uint32_t b)
{
    return (a < b ? a : b) * (uint64_t)set->boxes.count + (a < b ? b : a);
}

static qcStatus PushPair(qcBoxes* set, qcArray* list, uint32_t a, uint32_t b)
{
    QC_TRY(qcArray_Reserve(list, list->count + 1, sizeof(qcSortItem), "pairs of boxes"));
    QC_AT(qcSortItem, *list, list->count++) =
        (qcSortItem){PairKey(set, a, b), a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a};
    return qc_statusOk;
}

//  ---- the overlap graph -----------------------------------------------------------------------------

/// Adds an edge for two boxes whose AABBs in the forest overlap; one of them is dynamic. A pair of stationary boxes
/// gets no edge and is reported at once.
static qcStatus AddOverlap(qcBoxes* set, Report report, uint32_t a, uint32_t b)
{
    const qcBox *x = qcBoxes_Box(set, a), *y = qcBoxes_Box(set, b);
    if (!x->stationary || !y->stationary)
        return qcOverlapGraph_AddEdge(&set->overlaps, a, b, false);
    // No edge: pairs of stationary boxes cost nothing once they are reported. Unless the history is lost, one of the
    // two boxes is new.
    bool reported = report == CHANGED || (x->movedIndex & y->movedIndex) != QC_NOT_MOVED;
    return reported && qcBoxes_Overlap(set, a, b) ? PushPair(set, &set->began, a, b) : qc_statusOk;
}

/// The hits in one tree.
typedef struct HitRange
{
    const uint32_t* ids;
    size_t first, end; ///< in qcBoxes.hits
} HitRange;

typedef struct HitRanges
{
    HitRange range[qc_forestTrees];
    uint32_t count;
} HitRanges;

/// Finds the boxes of the whole forest that overlap an octet of the dynamic tree.
static void FindOctetOverlaps(qcBoxes* set, uint32_t dynamic, uint32_t octet, HitRanges* ranges)
{
    // Lane above row: each pair within an octet once.
    static const uint64_t triangle = 0x0080c0e0f0f8fcfe;
    const qcForest* forest = &set->forest;
    const qcOctet* query = &forest->trees[dynamic].shape.octets[octet];
    qcOctetHit* hits = set->hits.data;
    size_t count = 0;
    ranges->count = 0;
    for (uint64_t trees = forest->staticTrees | forest->dynamicTrees; trees != 0;)
    {
        uint32_t t = qcForest_NextTree(&trees);
        const qcBoxTree* tree = &forest->trees[t];
        size_t first = count;
        count += forest->kernels->findOverlaps(query, &tree->shape, t == dynamic ? octet : 0, hits + first);
        for (size_t i = first; t == dynamic && i < count; i++)
            hits[i].lanes &= hits[i].octet == octet ? triangle : UINT64_MAX;
        ranges->range[ranges->count++] = (HitRange){tree->ids.data, first, count};
    }
}

/// Adds the hits in one row of a query octet, except those with an edge.
static qcStatus AddHits(qcBoxes* set, Report report, uint32_t id, uint32_t row, const HitRanges* ranges)
{
    const qcOctetHit* hits = set->hits.data;
    const uint32_t* marks = set->visitMarks.data;
    const uint32_t mark = qcBoxes_MarkNeighbours(set, id);
    for (uint32_t r = 0; r < ranges->count; r++)
        for (size_t i = ranges->range[r].first; i < ranges->range[r].end; i++)
            for (uint32_t lanes = hits[i].lanes >> qc_lanes * row & 0xff; lanes != 0; lanes &= lanes - 1)
            {
                uint32_t lane = (uint32_t)__builtin_ctz(lanes);
                uint32_t found = ranges->range[r].ids[qc_lanes * hits[i].octet + lane];
                if (marks[found] != mark)
                    QC_TRY(AddOverlap(set, report, id, found));
            }
    return qc_statusOk;
}

/// Removes the edges of a dynamic box to boxes that its AABB in the forest no longer overlaps.
static qcStatus RemoveOutdatedEdges(qcBoxes* set, Report report, uint32_t id)
{
    const qcFloatBox *boxes = set->forest.boxes.data, *box = &boxes[id];
    uint32_t end = qcOverlapGraph_FirstEnd(&set->overlaps, id);
    while (end != QC_NO_EDGE)
    {
        uint32_t other = qcOverlapGraph_Other(&set->overlaps, end), edge = end / 2;
        end = qcOverlapGraph_NextEnd(&set->overlaps, end);
        if (qcFloatBox_Overlap(box, &boxes[other]))
            continue;
        if (report == CHANGED && (qcOverlapGraph_Edge(&set->overlaps, edge)->box[0] & QC_EDGE_MARK) != 0)
            QC_TRY(PushPair(set, &set->ended, id, other));
        qcOverlapGraph_RemoveEdge(&set->overlaps, edge);
    }
    return qc_statusOk;
}

/// Adds the overlaps of all dynamic boxes.
static qcStatus FindDynamicOverlaps(qcBoxes* set, Report report)
{
    uint32_t dynamic;
    HitRanges ranges;
    ranges.count = 0;
    QC_TRY(qcForest_MergeDynamic(&set->forest, &dynamic));
    if (dynamic == qc_inNoTree)
        return qc_statusOk;
    const qcBoxTree* tree = &set->forest.trees[dynamic];
    const uint32_t* ids = tree->ids.data;
    size_t room = 0;
    for (uint64_t trees = set->forest.staticTrees | set->forest.dynamicTrees; trees != 0;)
        room += set->forest.trees[qcForest_NextTree(&trees)].laneCount / qc_lanes + 1;
    QC_TRY(qcArray_Reserve(&set->hits, room, sizeof(qcOctetHit), "overlaps of boxes"));
    for (uint32_t lane = 0; lane < tree->laneCount; lane++)
    {
        if (lane % qc_lanes == 0)
            FindOctetOverlaps(set, dynamic, lane / qc_lanes, &ranges);
        if (ids[lane] != QC_NO_BOX)
            QC_TRY(AddHits(set, report, ids[lane], lane % qc_lanes, &ranges));
    }
    return qc_statusOk;
}

/// Brings the edges of dynamic boxes up to date.
static qcStatus UpdateGraph(qcBoxes* set, Report report)
{
    if (set->historyLost)
    {
        qcOverlapGraph_RemoveAllEdges(&set->overlaps);
        qcForest_Demote(&set->forest);
        set->profile.sought = qcBoxes_GetCount(set);
    }
    // Fewer than an octet: single queries are faster.
    bool few = set->staleCount < qc_lanes;
    for (size_t i = 0; i < set->movedBoxes.count && !set->historyLost; i++)
    {
        uint32_t id = QC_AT(qcMovedBox, set->movedBoxes, i).id;
        if (qcBoxes_Box(set, id)->state == qc_boxInTree)
            continue;
        set->profile.sought++;
        QC_TRY(RemoveOutdatedEdges(set, report, id));
        if (few)
            qcBoxes_CommitPairs(set, id);
    }
    // One stale box makes a search of all dynamic boxes necessary: it may have been inserted after the overlaps of
    // others were committed.
    if (set->historyLost || set->staleCount != 0)
        QC_TRY(FindDynamicOverlaps(set, report));
    // A few boxes that move in each step stay in the list: it needs no build, and is short to query. None of them is
    // stationary: a stationary one would have been stale, and would be in a tree now.
    if (set->forest.dynamicTrees != 0 || set->forest.listIds.count > qc_shortList)
        qcForest_Promote(&set->forest);
    return qc_statusOk;
}

//  ---- pairs -----------------------------------------------------------------------------------------

/// Updates the mark of an edge with a moved box, or of any edge after a loss of history, and reports the pair if
/// `report` includes it.
static inline qcStatus ReportOverlap(qcBoxes* set, Report report, qcEdge* edge, bool moved)
{
    uint32_t a = edge->box[0] & ~QC_EDGE_MARK, b = edge->box[1];
    bool overlap = qcBoxes_Overlap(set, a, b), overlapped = (edge->box[0] & QC_EDGE_MARK) != 0;
    if (overlap != overlapped)
        edge->box[0] = overlap ? a | QC_EDGE_MARK : a;
    if (report == MOVED ? !(moved && overlap) : overlap == overlapped)
        return qc_statusOk;
    return PushPair(set, overlap ? &set->began : &set->ended, a, b);
}

/// Reports the pairs of one moved box. A pair of two moved boxes is reported for the lower id.
static qcStatus ReportPairsOf(qcBoxes* set, Report report, uint32_t id)
{
    qcEdge* edges = set->overlaps.edges.data;
    const qcBox *boxes = set->boxes.data, *box = &boxes[id];
    uint32_t found[qc_edgeBlock], end = qcOverlapGraph_FirstEnd(&set->overlaps, id);
    while (end != QC_NO_EDGE)
    {
        // Without branches up to the few edges to update: whether boxes overlap is unpredictable.
        uint32_t count = 0, compared = 0;
        for (; end != QC_NO_EDGE && count < qc_edgeBlock; end = qcOverlapGraph_NextEnd(&set->overlaps, end))
        {
            const qcEdge* edge = &edges[end / 2];
            uint32_t other = edge->box[1 - end % 2] & ~QC_EDGE_MARK;
            bool counts = (id < other) | (boxes[other].movedIndex == QC_NOT_MOVED);
            bool overlap = qcBox_OverlapsFloats(box, boxes[other].lower, boxes[other].upper);
            bool overlapped = (edge->box[0] & QC_EDGE_MARK) != 0;
            bool undecided = (report == MOVED) | !(box->exact & boxes[other].exact);
            found[count] = end / 2;
            count += counts & ((overlap != overlapped) | (overlap & undecided));
            compared += counts;
        }
        set->profile.compared += compared;
        for (uint32_t i = 0; i < count; i++)
            QC_TRY(ReportOverlap(set, report, &edges[found[i]], true));
    }
    return qc_statusOk;
}

/// Reports pairs in memory order of the edges instead of list order.
static qcStatus ReportAllPairs(qcBoxes* set, Report report)
{
    qcEdge* edges = set->overlaps.edges.data;
    for (size_t i = 0; i < set->overlaps.edges.count; i++)
    {
        uint32_t a = edges[i].box[0] & ~QC_EDGE_MARK, b = edges[i].box[1];
        if (b == QC_NO_EDGE)
            continue;
        bool moved = (qcBoxes_Box(set, a)->movedIndex & qcBoxes_Box(set, b)->movedIndex) != QC_NOT_MOVED;
        if (!moved && !set->historyLost)
            continue;
        set->profile.compared++;
        QC_TRY(ReportOverlap(set, report, &edges[i], moved));
    }
    return qc_statusOk;
}

static qcStatus ReportPairs(qcBoxes* set, Report report)
{
    if (set->historyLost || set->movedBoxes.count > set->boxes.count / 4)
        return ReportAllPairs(set, report);
    for (size_t i = 0; i < set->movedBoxes.count; i++)
        QC_TRY(ReportPairsOf(set, report, QC_AT(qcMovedBox, set->movedBoxes, i).id));
    return qc_statusOk;
}

static void StoreSorted(const qcArray* items, qcBoxPair* pairs)
{
    for (size_t i = 0; i < items->count; i++)
    {
        uint64_t pair = QC_AT(qcSortItem, *items, i).value;
        pairs[i] = (qcBoxPair){(uint32_t)(pair >> 32), (uint32_t)pair};
    }
}

__attribute__((noinline)) static qcStatus SearchInMode(qcBoxes* set, Report report)
{
    set->began.count = 0;
    set->ended.count = 0;
    set->profile = (qcBoxProfile){.moved = set->movedBoxes.count};
    QC_TRY(UpdateGraph(set, report));
    QC_TRY(ReportPairs(set, report));
    QC_TRY(qcSort_Items(set->began.data, set->began.count, &set->scratch));
    QC_TRY(qcSort_Items(set->ended.data, set->ended.count, &set->scratch));
    QC_TRY(qcArray_Resize(&set->pairs, set->began.count + set->ended.count, sizeof(qcBoxPair), "pairs of boxes"));
    set->profile.sorted = set->forest.sortedCount;
    set->forest.sortedCount = 0;
    StoreSorted(&set->began, set->pairs.data);
    if (set->ended.count != 0)
        StoreSorted(&set->ended, &QC_AT(qcBoxPair, set->pairs, set->began.count));
    for (size_t i = 0; i < set->movedBoxes.count; i++)
    {
        qcBox* box = qcBoxes_Box(set, QC_AT(qcMovedBox, set->movedBoxes, i).id);
        box->movedIndex = QC_NOT_MOVED;
        box->state = qc_boxInTree;
    }
    set->movedBoxes.count = 0;
    set->insertedCount = 0;
    set->staleCount = 0;
    return qc_statusOk;
}

/// Leaves in `pairs` those that began, then those that ended. A failed search loses the history.
static qcStatus Search(qcBoxes* set, Report report)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = SearchInMode(set, report);
    qcFloatMode_End(mode);
    set->historyLost = status != qc_statusOk;
    return status;
}

qcStatus qcBoxes_FindMovedPairs(qcBoxes* boxes, const qcBoxPair** pairs, size_t* count)
{
    if (boxes == NULL || pairs == NULL || count == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_FindMovedPairs: boxes, pairs or count is null");
    QC_TRY(Search(boxes, MOVED));
    *pairs = boxes->pairs.data;
    *count = boxes->pairs.count;
    return qc_statusOk;
}

qcStatus qcBoxes_FindChangedPairs(qcBoxes* boxes, qcBoxChanges* changes)
{
    if (boxes == NULL || changes == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_FindChangedPairs: boxes or changes is null");
    bool all = boxes->historyLost;
    QC_TRY(Search(boxes, CHANGED));
    const qcBoxPair* pairs = boxes->pairs.data;
    *changes = (qcBoxChanges){.began = pairs, .beganCount = boxes->began.count, .endedCount = boxes->ended.count};
    changes->ended = pairs != NULL ? pairs + boxes->began.count : NULL;
    changes->all = all;
    return qc_statusOk;
}

qcBoxProfile qcBoxes_GetProfile(const qcBoxes* boxes)
{
    return boxes != NULL ? boxes->profile : (qcBoxProfile){0};
}
