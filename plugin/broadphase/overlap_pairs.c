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
    // Room for pairs that is made at once: growing in parts took a fiftieth of the first search of 160 000 boxes.
    qc_pairsOfNewBox = 2,
    // Edges of one box that are compared together.
    qc_edgeBlock = 32
};

/// The pairs that a search reports.
typedef enum Report
{
    MOVED,  ///< overlapping pairs with a moved box
    CHANGED ///< pairs whose overlap began or ended
} Report;

/// A pair as one number, whose order is by the lower id, then by the other.
static inline uint64_t PairKey(uint32_t a, uint32_t b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static qcStatus ReservePairs(qcArray* list, size_t more)
{
    return qcArray_Reserve(list, list->count + more, sizeof(uint64_t), "pairs of boxes");
}

static qcStatus PushPair(qcArray* list, uint32_t a, uint32_t b)
{
    QC_TRY(ReservePairs(list, 1));
    QC_AT(uint64_t, *list, list->count++) = PairKey(a, b);
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
    // No edge: pairs of stationary boxes cost nothing once they are reported. Unless the history is lost or the origin
    // moved, one of the two boxes is new.
    bool reported = (report == CHANGED && set->historyLost) || (x->movedIndex & y->movedIndex) != QC_NOT_MOVED;
    return reported && qcBoxes_Overlap(set, a, b) ? PushPair(&set->began, a, b) : qc_statusOk;
}

/// The hits in one tree.
typedef struct HitRange
{
    const uint32_t* ids;
    const uint8_t* tight;
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
        ranges->range[ranges->count++] = (HitRange){tree->ids.data, tree->tight.data, first, count};
    }
}

/// These lanes in all rows of a hit.
static inline uint64_t Columns(uint8_t lanes)
{
    return lanes * 0x0101010101010101u;
}

/// All lanes of these rows of a hit.
static inline uint64_t Rows(uint8_t rows)
{
    // Bit i in byte i; the sum carries it into bit 7 of the byte.
    uint64_t bits = Columns(rows) & 0x8040201008040201u;
    return ((bits + 0x7f7f7f7f7f7f7f7fu) >> 7 & 0x0101010101010101u) * 0xff;
}

/// Reports the hits between tight boxes as begun, and removes them from the hits: such boxes overlap and get no edge.
/// In a search after many boxes were added nearly all hits are of this kind, and no box is read by its id.
static qcStatus ReportTightHits(qcBoxes* set, const qcBoxTree* tree, uint32_t octet, const HitRanges* ranges)
{
    qcOctetHit* hits = set->hits.data;
    const uint32_t* ids = &QC_AT(uint32_t, tree->ids, (size_t)qc_lanes * octet);
    const uint64_t rows = Rows(QC_AT(uint8_t, tree->tight, octet));
    for (uint32_t r = 0; r < ranges->count; r++)
    {
        const HitRange* range = &ranges->range[r];
        for (size_t i = range->first; i < range->end; i++)
        {
            QC_TRY(ReservePairs(&set->began, (size_t)qc_lanes * qc_lanes));
            uint64_t* pairs = set->began.data;
            size_t count = set->began.count;
            const uint32_t* found = &range->ids[(size_t)qc_lanes * hits[i].octet];
            uint64_t tight = hits[i].lanes & rows & Columns(range->tight[hits[i].octet]);
            hits[i].lanes &= ~tight;
            for (; tight != 0; tight &= tight - 1)
            {
                uint32_t bit = (uint32_t)__builtin_ctzll(tight);
                pairs[count++] = PairKey(ids[bit / qc_lanes], found[bit % qc_lanes]);
            }
            set->began.count = count;
        }
    }
    return qc_statusOk;
}

/// The lanes of all hits: a row without any has no hit.
static uint64_t LanesWithHits(const qcBoxes* set, const HitRanges* ranges)
{
    const qcOctetHit* hits = set->hits.data;
    uint64_t lanes = 0;
    for (size_t i = 0; ranges->count != 0 && i < ranges->range[ranges->count - 1].end; i++)
        lanes |= hits[i].lanes;
    return lanes;
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
            QC_TRY(PushPair(&set->ended, id, other));
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
    QC_TRY(ReservePairs(&set->began, qc_pairsOfNewBox * (size_t)set->staleCount));
    // With an origin no box is tight.
    const bool tightHits = report == CHANGED && !set->originMoved;
    for (uint32_t octet = 0; octet < tree->laneCount / qc_lanes; octet++)
    {
        FindOctetOverlaps(set, dynamic, octet, &ranges);
        if (tightHits)
            QC_TRY(ReportTightHits(set, tree, octet, &ranges));
        for (uint64_t rows = LanesWithHits(set, &ranges), row = 0; rows != 0; rows >>= qc_lanes, row++)
            if ((rows & 0xff) != 0)
                QC_TRY(AddHits(set, report, ids[(size_t)qc_lanes * octet + row], (uint32_t)row, &ranges));
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
    return PushPair(overlap ? &set->began : &set->ended, a, b);
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

/// Whether a pass over all boxes or edges takes less time than one over those of moved boxes: it reads memory in order.
static bool MovedMany(const qcBoxes* set)
{
    return set->movedBoxes.count > set->boxes.count / 4;
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
    if (set->historyLost || MovedMany(set))
        return ReportAllPairs(set, report);
    for (size_t i = 0; i < set->movedBoxes.count; i++)
        QC_TRY(ReportPairsOf(set, report, QC_AT(qcMovedBox, set->movedBoxes, i).id));
    return qc_statusOk;
}

/// Sorts keys of pairs, and replaces each by its pair: fresh memory for the pairs would take longer than the sort.
static qcStatus SortPairs(qcBoxes* set, qcArray* keys)
{
    // Builds of trees, whose scratch this is, are over.
    QC_TRY(qcSort_Keys(keys->data, keys->count, &set->forest.items));
    for (size_t i = 0; i < keys->count; i++)
    {
        uint64_t key = QC_AT(uint64_t, *keys, i);
        QC_AT(qcBoxPair, *keys, i) = (qcBoxPair){(uint32_t)(key >> 32), (uint32_t)key};
    }
    return qc_statusOk;
}

/// Ends the interval in which boxes moved.
static void Settle(qcBoxes* set)
{
    const bool all = MovedMany(set) || set->originMoved;
    for (size_t i = 0; i < (all ? set->boxes.count : set->movedBoxes.count); i++)
    {
        qcBox* box = qcBoxes_Box(set, all ? (uint32_t)i : QC_AT(qcMovedBox, set->movedBoxes, i).id);
        box->movedIndex = QC_NOT_MOVED;
        box->state = qc_boxInTree;
    }
    set->movedBoxes.count = 0;
    set->insertedCount = 0;
    set->staleCount = 0;
    set->originMoved = false;
}

__attribute__((noinline)) static qcStatus SearchInMode(qcBoxes* set, Report report)
{
    set->began.count = 0;
    set->ended.count = 0;
    set->profile = (qcBoxProfile){.moved = set->movedBoxes.count};
    QC_TRY(UpdateGraph(set, report));
    QC_TRY(ReportPairs(set, report));
    QC_TRY(SortPairs(set, &set->began));
    QC_TRY(SortPairs(set, &set->ended));
    set->profile.sorted = set->forest.sortedCount;
    set->forest.sortedCount = 0;
    Settle(set);
    return qc_statusOk;
}

/// Leaves the pairs in `began` and `ended`. A failed search loses the history.
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
    *pairs = boxes->began.data;
    *count = boxes->began.count;
    return qc_statusOk;
}

qcStatus qcBoxes_FindChangedPairs(qcBoxes* boxes, qcBoxChanges* changes)
{
    if (boxes == NULL || changes == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_FindChangedPairs: boxes or changes is null");
    bool all = boxes->historyLost;
    QC_TRY(Search(boxes, CHANGED));
    *changes = (qcBoxChanges){.began = boxes->began.data,
                              .beganCount = boxes->began.count,
                              .ended = boxes->ended.data,
                              .endedCount = boxes->ended.count,
                              .all = all};
    return qc_statusOk;
}

qcBoxProfile qcBoxes_GetProfile(const qcBoxes* boxes)
{
    return boxes != NULL ? boxes->profile : (qcBoxProfile){0};
}
