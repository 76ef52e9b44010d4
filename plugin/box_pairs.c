// The overlapping pairs of moved boxes. Pairs of leaves that meet are kept (see qcNeighbours) until one of the two
// leaves changes, so that the tree is only asked for boxes that left their leaves. Fat boxes: Catto, Box2D.
//
// Why no pair is missed: a leaf contains its box, so boxes that meet have leaves that meet. Such a pair of leaves is
// found when the younger of the two states of the leaves is new, and is then kept, unless both boxes are still: then it
// is reported at once, and one of them looks again when it first moves.
#include "box_set.h"

#include "sort.h"
#include "status.h"

/// A pair as one number, whose order is the order of the pairs; the fewer digits, the faster it is sorted.
static uint64_t PairKey(const qcBoxes* set, uint32_t a, uint32_t b)
{
    return (a < b ? a : b) * (uint64_t)set->boxes.count + (a < b ? b : a);
}

static qcStatus PushPair(qcBoxes* set, uint32_t a, uint32_t b)
{
    QC_TRY(qcArray_Reserve(&set->found, set->found.count + 1, sizeof(qcSortItem), "pairs of boxes"));
    QC_AT(qcSortItem, set->found, set->found.count++) =
        (qcSortItem){PairKey(set, a, b), a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a};
    return qc_statusOk;
}

/// Two leaves meet, one of them restless.
static qcStatus MeetLeaves(qcBoxes* set, uint32_t a, uint32_t b)
{
    const qcBox *x = &QC_AT(qcBox, set->boxes, a), *y = &QC_AT(qcBox, set->boxes, b);
    if (!x->still || !y->still)
        return qcNeighbours_Join(&set->neighbours, a, b);
    // Not kept: scenery costs nothing once its pairs are known.
    return qcBounds_Meet(x->lower, x->upper, y->lower, y->upper) ? PushPair(set, a, b) : qc_statusOk;
}

/// Flags the leaves of the restless and all nodes above them, or takes the flags away.
static void FlagRestless(qcBoxes* set, uint8_t flag)
{
    uint8_t* flags = set->flags.data;
    for (size_t i = 0; i < set->movers.count; i++)
    {
        const qcBox* box = &QC_AT(qcBox, set->boxes, QC_AT(uint32_t, set->movers, i));
        uint32_t node = box->restless ? box->leaf : QC_NO_NODE;
        for (; node != QC_NO_NODE && flags[node] != flag; node = qcBoxTree_Node(&set->tree, node)->parent)
            flags[node] = flag;
    }
}

typedef struct NodePair
{
    uint32_t a, b;
} NodePair;

/// Whether two nodes meet and one of them has a restless leaf.
static bool MayMeet(const qcBoxes* set, NodePair pair)
{
    const qcTreeNode *a = qcBoxTree_Node(&set->tree, pair.a), *b = qcBoxTree_Node(&set->tree, pair.b);
    const uint8_t* flags = set->flags.data;
    return qcBounds_Meet(a->lower, a->upper, b->lower, b->upper) & (flags[pair.a] | flags[pair.b]);
}

/// The node, if it is a leaf, or its children.
static uint32_t Unfold(const qcTreeNode* node, uint32_t self, uint32_t below[2])
{
    if (node->height == 0)
    {
        below[0] = self;
        return 1;
    }
    below[0] = node->child[0];
    below[1] = node->child[1];
    return 2;
}

/// Meets the leaves below two nodes that are not above each other.
static qcStatus MeetBelow(qcBoxes* set, NodePair start)
{
    // A step takes one pair and leaves four at most, which are one level down; one more is written in vain.
    NodePair stack[3 * qc_treeStack + 1];
    uint32_t count = 0;
    stack[count] = start;
    count += MayMeet(set, start);
    while (count > 0)
    {
        NodePair pair = stack[--count];
        const qcTreeNode *a = qcBoxTree_Node(&set->tree, pair.a), *b = qcBoxTree_Node(&set->tree, pair.b);
        if (a->height == 0 && b->height == 0)
        {
            QC_TRY(MeetLeaves(set, a->child[0], b->child[0]));
            continue;
        }
        uint32_t belowA[2], belowB[2], countA = Unfold(a, pair.a, belowA), countB = Unfold(b, pair.b, belowB);
        for (uint32_t i = 0; i < countA; i++)
            for (uint32_t j = 0; j < countB; j++)
            {
                // Written without a branch: whether two nodes meet is as good as random.
                stack[count] = (NodePair){belowA[i], belowB[j]};
                count += MayMeet(set, stack[count]);
            }
    }
    return qc_statusOk;
}

/// Every pair is found at the node where the paths of its two leaves part.
static qcStatus MeetAll(qcBoxes* set)
{
    const uint8_t* flags = set->flags.data;
    uint32_t stack[qc_treeStack], count = 0;
    if (set->tree.root != QC_NO_NODE)
        stack[count++] = set->tree.root;
    while (count > 0)
    {
        uint32_t at = stack[--count];
        const qcTreeNode* node = qcBoxTree_Node(&set->tree, at);
        if (!flags[at] || node->height == 0)
            continue;
        QC_TRY(MeetBelow(set, (NodePair){node->child[0], node->child[1]}));
        stack[count++] = node->child[0];
        stack[count++] = node->child[1];
    }
    return qc_statusOk;
}

/// Brings the neighbours of the restless up to date. When it fails, they stay restless.
static qcStatus FindNeighbours(qcBoxes* set)
{
    for (size_t i = 0; i < set->movers.count; i++)
    {
        uint32_t id = QC_AT(uint32_t, set->movers, i);
        if (QC_AT(qcBox, set->boxes, id).restless)
            qcNeighbours_Part(&set->neighbours, id);
    }
    FlagRestless(set, 1);
    qcStatus status = MeetAll(set);
    FlagRestless(set, 0);
    return status;
}

/// Keeps the pair if the boxes meet and one has moved.
static qcStatus MeetBoxes(qcBoxes* set, uint32_t a, uint32_t b)
{
    const qcBox *x = &QC_AT(qcBox, set->boxes, a), *y = &QC_AT(qcBox, set->boxes, b);
    if ((x->mover & y->mover) == QC_NO_NODE || !qcBounds_Meet(x->lower, x->upper, y->lower, y->upper))
        return qc_statusOk;
    return PushPair(set, a, b);
}

static qcStatus FindPairs(qcBoxes* set)
{
    const qcEdgeEnd* ends = set->neighbours.ends.data;
    if (set->movers.count > set->boxes.count / 4)
    {
        // Most pairs are asked for: in memory order, not in the order of lists.
        for (size_t end = 0; end < set->neighbours.ends.count; end += 2)
            if (ends[end].other != QC_NO_EDGE)
                QC_TRY(MeetBoxes(set, ends[end].other, ends[end + 1].other));
        return qc_statusOk;
    }
    for (size_t i = 0; i < set->movers.count; i++)
    {
        uint32_t id = QC_AT(uint32_t, set->movers, i);
        for (uint32_t end = QC_AT(uint32_t, set->neighbours.first, id); end != QC_NO_EDGE; end = ends[end].next)
        {
            // A pair of two movers is the lower one's.
            uint32_t other = ends[end].other;
            if (id < other || QC_AT(qcBox, set->boxes, other).mover == QC_NO_NODE)
                QC_TRY(MeetBoxes(set, id, other));
        }
    }
    return qc_statusOk;
}

qcStatus qcBoxes_FindMovedPairs(qcBoxes* boxes, const qcBoxPair** pairs, size_t* count)
{
    if (boxes == NULL || pairs == NULL || count == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_FindMovedPairs: boxes, pairs or count is null");
    boxes->found.count = 0;
    QC_TRY(FindNeighbours(boxes));
    QC_TRY(FindPairs(boxes));
    QC_TRY(qcSort_Items(boxes->found.data, boxes->found.count, &boxes->scratch));
    QC_TRY(qcArray_Resize(&boxes->pairs, boxes->found.count, sizeof(qcBoxPair), "pairs of boxes"));
    for (size_t i = 0; i < boxes->found.count; i++)
    {
        uint64_t pair = QC_AT(qcSortItem, boxes->found, i).value;
        QC_AT(qcBoxPair, boxes->pairs, i) = (qcBoxPair){(uint32_t)(pair >> 32), (uint32_t)pair};
    }
    for (size_t i = 0; i < boxes->movers.count; i++)
    {
        qcBox* box = &QC_AT(qcBox, boxes->boxes, QC_AT(uint32_t, boxes->movers, i));
        box->mover = QC_NO_NODE;
        box->restless = false;
    }
    boxes->movers.count = 0;
    *pairs = boxes->pairs.data;
    *count = boxes->pairs.count;
    return qc_statusOk;
}
