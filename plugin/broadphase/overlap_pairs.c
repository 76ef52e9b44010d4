// The overlapping pairs of moved boxes. Pairs of boxes of the forest that meet are kept (see qcOverlapGraph) until one
// of the two changes, so that the forest is only asked for boxes that left their place in it. Fat boxes: Catto, Box2D.
//
// Why no pair is missed: the forest's box contains the box itself, so boxes that meet have boxes there that meet. Such
// a pair is found when the one of the two that was put there last looks for its neighbours, in the search or before it
// (qcBoxes_Settle), and is then kept, unless both boxes are still: then it is reported at once, and one of them looks
// again when it first moves.
//
// What changed: each pair that is kept is marked if it overlapped at the last search. A pair that was not kept then and
// overlapped is one of two still boxes; if one has moved since, it was marked when that began to move.
#include "broadphase/box_set.h"

#include "base/float_mode.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <string.h>

enum
{
    // Two octets.
    qc_shortList = 16
};

typedef enum Wanted
{
    MOVED,  ///< pairs that overlap, one of the two moved
    CHANGED ///< pairs that began or ended to overlap
} Wanted;

/// A pair as one number, whose order is the order of the pairs; the fewer digits, the faster it is sorted.
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

/// The box at the last search, or null if it was not there.
static const qcBox* GetBefore(const qcBoxes* set, uint32_t id, const qcBounds** bounds)
{
    uint32_t number = qcBoxes_Box(set, id)->mover;
    const qcMover* mover = number != QC_NO_MOVER ? &QC_AT(qcMover, set->movers, number) : NULL;
    *bounds = mover != NULL ? &mover->bounds : &QC_AT(qcBounds, set->bounds, id);
    if (mover == NULL)
        return qcBoxes_Box(set, id);
    return mover->added ? NULL : &mover->box;
}

bool qcBoxes_Met(const qcBoxes* set, uint32_t a, uint32_t b)
{
    const qcBounds *boundsA, *boundsB;
    const qcBox *x = GetBefore(set, a, &boundsA), *y = GetBefore(set, b, &boundsB);
    return !set->forgotten && x != NULL && y != NULL && qcBox_Meet(x, boundsA, y, boundsB);
}

//  ---- neighbours ------------------------------------------------------------------------------------

/// The forest's boxes of two boxes meet, one of them young, and the pair is not kept.
static qcStatus MeetInForest(qcBoxes* set, Wanted wanted, uint32_t a, uint32_t b)
{
    const qcBox *x = qcBoxes_Box(set, a), *y = qcBoxes_Box(set, b);
    if (!x->still || !y->still)
        return qcOverlapGraph_Join(&set->neighbours, a, b, false);
    // Not kept: scenery costs nothing once its pairs are known. Unless all is forgotten, one of the two is new.
    bool asked = wanted == CHANGED || (x->mover & y->mover) != QC_NO_MOVER;
    return asked && qcBoxes_Meet(set, a, b) ? PushPair(set, &set->began, a, b) : qc_statusOk;
}

/// Where the boxes of one tree lie in the list of hits.
typedef struct HitRange
{
    const uint32_t* ids;
    size_t first, end;
} HitRange;

typedef struct HitRanges
{
    HitRange range[qc_forestTrees];
    uint32_t count;
} HitRanges;

/// What in the whole forest meets an octet of the young tree.
static void SeekOctet(qcBoxes* set, uint32_t young, uint32_t octet, HitRanges* ranges)
{
    // Rows and columns of the same octet: each pair once.
    static const uint64_t above = 0x0080c0e0f0f8fcfe;
    const qcForest* forest = &set->forest;
    const qcOctet* sought = &forest->trees[young].shape.octets[octet];
    qcOctetHit* hits = set->hits.data;
    size_t count = 0;
    ranges->count = 0;
    for (uint64_t trees = forest->old | forest->young; trees != 0;)
    {
        uint32_t t = qcForest_NextTree(&trees);
        const qcBoxTree* tree = &forest->trees[t];
        size_t first = count;
        count += forest->kernels->seek(sought, &tree->shape, t == young ? octet : 0, hits + first);
        for (size_t i = first; t == young && i < count; i++)
            hits[i].lanes &= hits[i].octet == octet ? above : UINT64_MAX;
        ranges->range[ranges->count++] = (HitRange){tree->ids.data, first, count};
    }
}

static qcStatus MeetHits(qcBoxes* set, Wanted wanted, uint32_t id, uint32_t row, const HitRanges* ranges)
{
    const qcOctetHit* hits = set->hits.data;
    const uint32_t* stamps = set->stamps.data;
    const uint32_t stamp = qcBoxes_StampNeighbours(set, id);
    for (uint32_t r = 0; r < ranges->count; r++)
        for (size_t i = ranges->range[r].first; i < ranges->range[r].end; i++)
            for (uint32_t lanes = hits[i].lanes >> qc_lanes * row & 0xff; lanes != 0; lanes &= lanes - 1)
            {
                uint32_t lane = (uint32_t)__builtin_ctz(lanes);
                uint32_t found = ranges->range[r].ids[qc_lanes * hits[i].octet + lane];
                if (stamps[found] != stamp)
                    QC_TRY(MeetInForest(set, wanted, id, found));
            }
    return qc_statusOk;
}

/// Parts a young box from neighbours that it has left in the forest.
static qcStatus LeaveNeighbours(qcBoxes* set, Wanted wanted, uint32_t id)
{
    const qcFloatBox *boxes = set->forest.boxes.data, *box = &boxes[id];
    uint32_t end = qcOverlapGraph_First(&set->neighbours, id);
    while (end != QC_NO_EDGE)
    {
        uint32_t other = qcOverlapGraph_Other(&set->neighbours, end), edge = end / 2;
        end = qcOverlapGraph_Next(&set->neighbours, end);
        if (qcFloatBox_Meet(box, &boxes[other]))
            continue;
        if (wanted == CHANGED && (qcOverlapGraph_Edge(&set->neighbours, edge)->box[0] & QC_EDGE_MARK) != 0)
            QC_TRY(PushPair(set, &set->ended, id, other));
        qcOverlapGraph_Cut(&set->neighbours, edge);
    }
    return qc_statusOk;
}

/// Looks for the neighbours of the young.
static qcStatus SeekNeighbours(qcBoxes* set, Wanted wanted)
{
    uint32_t young;
    HitRanges ranges;
    ranges.count = 0;
    QC_TRY(qcForest_GatherYoung(&set->forest, &young));
    if (young == qc_inNoTree)
        return qc_statusOk;
    const qcBoxTree* tree = &set->forest.trees[young];
    const uint32_t* ids = tree->ids.data;
    size_t room = 0;
    for (uint64_t trees = set->forest.old | set->forest.young; trees != 0;)
        room += set->forest.trees[qcForest_NextTree(&trees)].laneCount / qc_lanes + 1;
    QC_TRY(qcArray_Reserve(&set->hits, room, sizeof(qcOctetHit), "boxes that meet"));
    for (uint32_t lane = 0; lane < tree->laneCount; lane++)
    {
        if (lane % qc_lanes == 0)
            SeekOctet(set, young, lane / qc_lanes, &ranges);
        if (ids[lane] != QC_NO_BOX)
            QC_TRY(MeetHits(set, wanted, ids[lane], lane % qc_lanes, &ranges));
    }
    return qc_statusOk;
}

/// Brings the neighbours of the young up to date.
static qcStatus FindNeighbours(qcBoxes* set, Wanted wanted)
{
    if (set->forgotten)
    {
        qcOverlapGraph_PartAll(&set->neighbours);
        qcForest_Rejuvenate(&set->forest);
        set->profile.sought = qcBoxes_GetCount(set);
    }
    // Fewer than an octet: one by one is quicker.
    bool few = set->lostCount < qc_lanes;
    for (size_t i = 0; i < set->movers.count && !set->forgotten; i++)
    {
        uint32_t id = QC_AT(qcMover, set->movers, i).id;
        if (qcBoxes_Box(set, id)->at == qc_boxInTree)
            continue;
        set->profile.sought++;
        QC_TRY(LeaveNeighbours(set, wanted, id));
        if (few)
            qcBoxes_Settle(set, id);
    }
    // All that are young if one is lost: it may have come after one that has found its neighbours.
    if (set->forgotten || set->lostCount != 0)
        QC_TRY(SeekNeighbours(set, wanted));
    // A few that move on and on are best left in the list: nothing to put in order, and little to look through. None of
    // them is still, or it would have been lost, and be in a tree now.
    if (set->forest.young != 0 || set->forest.listIds.count > qc_shortList)
        qcForest_Age(&set->forest);
    return qc_statusOk;
}

//  ---- pairs -----------------------------------------------------------------------------------------

/// Reports what is wanted of a pair that is kept, of which one has moved or all is forgotten, and marks it.
static inline qcStatus MeetBoxes(qcBoxes* set, Wanted wanted, qcEdge* edge, bool moved)
{
    uint32_t a = edge->box[0] & ~QC_EDGE_MARK, b = edge->box[1];
    bool meet = qcBoxes_Meet(set, a, b), met = (edge->box[0] & QC_EDGE_MARK) != 0;
    if (meet != met)
        edge->box[0] = meet ? a | QC_EDGE_MARK : a;
    if (wanted == MOVED ? !(moved && meet) : meet == met)
        return qc_statusOk;
    return PushPair(set, meet ? &set->began : &set->ended, a, b);
}

/// The pairs of one box that has moved; a pair of two such is the lower one's.
static qcStatus FindPairsOf(qcBoxes* set, Wanted wanted, uint32_t id)
{
    enum
    {
        most = 32
    };
    qcEdge* edges = set->neighbours.edges.data;
    const qcBox *boxes = set->boxes.data, *box = &boxes[id];
    uint32_t found[most], end = qcOverlapGraph_First(&set->neighbours, id);
    while (end != QC_NO_EDGE)
    {
        // Without branches, apart from the few that there is something to do for: whether boxes meet cannot be
        // foreseen.
        uint32_t count = 0, compared = 0;
        for (; end != QC_NO_EDGE && count < most; end = qcOverlapGraph_Next(&set->neighbours, end))
        {
            const qcEdge* edge = &edges[end / 2];
            uint32_t other = edge->box[1 - end % 2] & ~QC_EDGE_MARK;
            bool counts = (id < other) | (boxes[other].mover == QC_NO_MOVER);
            bool meet = qcBox_MeetsFloats(box, boxes[other].lower, boxes[other].upper);
            bool met = (edge->box[0] & QC_EDGE_MARK) != 0;
            bool unsure = (wanted == MOVED) | !(box->exact & boxes[other].exact);
            found[count] = end / 2;
            count += counts & ((meet != met) | (meet & unsure));
            compared += counts;
        }
        set->profile.compared += compared;
        for (uint32_t i = 0; i < count; i++)
            QC_TRY(MeetBoxes(set, wanted, &edges[found[i]], true));
    }
    return qc_statusOk;
}

/// In memory order and not in the order of lists.
static qcStatus FindPairsOfAll(qcBoxes* set, Wanted wanted)
{
    qcEdge* edges = set->neighbours.edges.data;
    for (size_t i = 0; i < set->neighbours.edges.count; i++)
    {
        uint32_t a = edges[i].box[0] & ~QC_EDGE_MARK, b = edges[i].box[1];
        if (b == QC_NO_EDGE)
            continue;
        bool moved = (qcBoxes_Box(set, a)->mover & qcBoxes_Box(set, b)->mover) != QC_NO_MOVER;
        if (!moved && !set->forgotten)
            continue;
        set->profile.compared++;
        QC_TRY(MeetBoxes(set, wanted, &edges[i], moved));
    }
    return qc_statusOk;
}

static qcStatus FindPairs(qcBoxes* set, Wanted wanted)
{
    if (set->forgotten || set->movers.count > set->boxes.count / 4)
        return FindPairsOfAll(set, wanted);
    for (size_t i = 0; i < set->movers.count; i++)
        QC_TRY(FindPairsOf(set, wanted, QC_AT(qcMover, set->movers, i).id));
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

__attribute__((noinline)) static qcStatus SearchInMode(qcBoxes* set, Wanted wanted)
{
    set->began.count = 0;
    set->ended.count = 0;
    set->profile = (qcBoxProfile){.moved = set->movers.count};
    QC_TRY(FindNeighbours(set, wanted));
    QC_TRY(FindPairs(set, wanted));
    QC_TRY(qcSort_Items(set->began.data, set->began.count, &set->scratch));
    QC_TRY(qcSort_Items(set->ended.data, set->ended.count, &set->scratch));
    QC_TRY(qcArray_Resize(&set->pairs, set->began.count + set->ended.count, sizeof(qcBoxPair), "pairs of boxes"));
    set->profile.sorted = set->forest.sortedCount;
    set->forest.sortedCount = 0;
    StoreSorted(&set->began, set->pairs.data);
    if (set->ended.count != 0)
        StoreSorted(&set->ended, &QC_AT(qcBoxPair, set->pairs, set->began.count));
    for (size_t i = 0; i < set->movers.count; i++)
    {
        qcBox* box = qcBoxes_Box(set, QC_AT(qcMover, set->movers, i).id);
        box->mover = QC_NO_MOVER;
        box->at = qc_boxInTree;
    }
    set->movers.count = 0;
    set->putCount = 0;
    set->lostCount = 0;
    return qc_statusOk;
}

/// Leaves in `pairs` those that began, then those that ended.
static qcStatus Search(qcBoxes* set, Wanted wanted)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = SearchInMode(set, wanted);
    qcFloatMode_End(mode);
    set->forgotten = status != qc_statusOk;
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
    bool all = boxes->forgotten;
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
