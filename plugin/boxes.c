// Moving boxes over a tree of fattened boxes: a box that moves a little costs nothing in the tree. The answers come from
// the exact bounds. Fat boxes: Catto, Box2D. Slabs: Kay, Kajiya: Ray tracing complex scenes, 1986.
//
// Why a cast never misses. A box of the set, [lower, upper], is met on the way from p to q when p + t (q - p) is in
// [L, U] = [lower - castUpper, upper - castLower] for a t in [0, fraction].
// - The box around the whole way: sums and comparisons only, rounding is monotone, so what meets stays meeting.
// - The slabs: with u = 2^-53, the rounding errors of L - p are within 3 u (|lower| + |castUpper| + |p|); planes are moved
//   outwards by 4 u of that. What is left is relative: within 5 u of t, hence of 1 where it matters. So entry and exit,
//   each within 5 u, are compared with a tolerance of 16 u.
// - A slab is left out where it says nothing: a direction that is zero, or too small or too large for its inverse.
// - NaN (of infinities that cancel) fails every comparison, and every comparison is written so that failing it keeps
//   the box.
#include "quickcullide/boxes.h"

#include "box_neighbours.h"
#include "box_tree.h"
#include "memory.h"
#include "sort.h"
#include "status.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef struct Box
{
    double lower[3], upper[3];
    uint32_t leaf;  ///< QC_NO_NODE: the id is free
    uint32_t mover; ///< place in the list of moved boxes, or QC_NO_NODE
    bool restless;  ///< a mover whose leaf is new or changed: its neighbours are not known
    bool still;     ///< has not moved since it was added
} Box;

struct qcBoxes
{
    qcBoxTree tree;
    qcNeighbours neighbours; ///< pairs of leaves that meet, unless both boxes are still, or one is restless
    qcArray boxes;           ///< Box, by id
    qcArray userData;        ///< void*, by id
    qcArray freeIds; ///< uint32_t, a heap with the lowest id on top
    qcArray movers;  ///< uint32_t, ids added or moved since the last search for pairs
    qcArray found;   ///< qcSortItem, a pair as a key
    qcArray flags;   ///< uint8_t, by node; all zero between two calls
    qcArray scratch;
    qcArray pairs; ///< qcBoxPair
};

static const Box* GetBox(const qcBoxes* set, uint32_t id)
{
    if (set == NULL || id >= set->boxes.count || QC_AT(Box, set->boxes, id).leaf == QC_NO_NODE)
        return NULL;
    return &QC_AT(Box, set->boxes, id);
}

static qcStatus CheckBounds(const char* where, const double lower[3], const double upper[3])
{
    if (lower == NULL || upper == NULL)
        return qcFail(qc_statusBadInput, "%s: lower or upper is null", where);
    for (int k = 0; k < 3; k++)
        if (!(lower[k] <= upper[k]))
            return qcFail(qc_statusBadInput, "%s: lower[%d] = %g is not at most upper[%d] = %g", where, k, lower[k], k,
                          upper[k]);
    return qc_statusOk;
}

//  ---- ids, lowest first -----------------------------------------------------------------------------

static void PushFreeId(qcBoxes* set, uint32_t id)
{
    uint32_t* heap = set->freeIds.data;
    size_t i = set->freeIds.count++;
    for (; i > 0 && heap[(i - 1) / 2] > id; i = (i - 1) / 2)
        heap[i] = heap[(i - 1) / 2];
    heap[i] = id;
}

static uint32_t PopFreeId(qcBoxes* set)
{
    uint32_t* heap = set->freeIds.data;
    uint32_t lowest = heap[0], last = heap[--set->freeIds.count];
    size_t i = 0, child;
    while ((child = 2 * i + 1) < set->freeIds.count)
    {
        child += child + 1 < set->freeIds.count && heap[child + 1] < heap[child];
        if (heap[child] >= last)
            break;
        heap[i] = heap[child];
        i = child;
    }
    heap[i] = last;
    return lowest;
}

//  ---- movers ----------------------------------------------------------------------------------------

static void MarkMoved(qcBoxes* set, uint32_t id)
{
    Box* box = &QC_AT(Box, set->boxes, id);
    if (box->mover != QC_NO_NODE)
        return;
    box->mover = (uint32_t)set->movers.count;
    QC_AT(uint32_t, set->movers, set->movers.count++) = id;
}

static void UnmarkMoved(qcBoxes* set, uint32_t id)
{
    Box* box = &QC_AT(Box, set->boxes, id);
    if (box->mover == QC_NO_NODE)
        return;
    uint32_t last = QC_AT(uint32_t, set->movers, --set->movers.count);
    QC_AT(uint32_t, set->movers, box->mover) = last;
    QC_AT(Box, set->boxes, last).mover = box->mover;
    box->mover = QC_NO_NODE;
}

//  ---- fat boxes -------------------------------------------------------------------------------------

static double Lower(double a, double b)
{
    return a < b ? a : b;
}

static double Upper(double a, double b)
{
    return a > b ? a : b;
}

/// The longest edge, or 0 when it is infinite: what fattening is measured by.
static double LongestEdge(const double lower[3], const double upper[3])
{
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = Upper(longest, upper[k] - lower[k]);
    return longest <= DBL_MAX / 8.0 ? longest : 0.0;
}

/// The leaf still holds the box, and not too loosely.
static bool LeafFits(const qcTreeNode* leaf, const double lower[3], const double upper[3])
{
    double longest = LongestEdge(lower, upper);
    for (int k = 0; k < 3; k++)
    {
        if (lower[k] < leaf->lower[k] || upper[k] > leaf->upper[k])
            return false;
        // Twice what FattenBounds adds at most.
        if (upper[k] - lower[k] + 5.0 * longest < leaf->upper[k] - leaf->lower[k])
            return false;
    }
    return true;
}

/// Room for jitter on all sides, and for a number of steps like the last one where a side moves outwards.
static void FattenBounds(const Box* old, const double lower[3], const double upper[3], double steps, double fatLower[3],
                         double fatUpper[3])
{
    double longest = LongestEdge(lower, upper);
    for (int k = 0; k < 3; k++)
    {
        // A fiftieth of the edge: more makes queries slower than it saves moves (bench boxes).
        double margin = Lower(0.02 * (upper[k] - lower[k]), longest);
        // A jump longer than the box says nothing about the next step.
        double down = Lower(steps * (old->lower[k] - lower[k]), longest);
        double up = Lower(steps * (upper[k] - old->upper[k]), longest);
        fatLower[k] = Lower(lower[k], lower[k] - Upper(down, 0.0) - margin);
        fatUpper[k] = Upper(upper[k], upper[k] + Upper(up, 0.0) + margin);
    }
}

/// How many steps ahead a leaf is made: 5 to 12, eight on average (bench boxes). It differs from box to box so that
/// boxes which set out together don't all leave their leaves in the same step.
static double StepsAhead(uint32_t id)
{
    return 5.0 + (double)(id * 2654435769u >> 29);
}

//  ---- the set ---------------------------------------------------------------------------------------

qcStatus qcBoxes_Create(qcBoxes** boxes)
{
    if (boxes == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Create: boxes is null");
    qcBoxes* set = qcAllocateZeroed(sizeof *set);
    if (set == NULL)
        return qcFailMemory(sizeof *set, "a set of boxes");
    qcBoxTree_Clear(&set->tree);
    qcNeighbours_Clear(&set->neighbours);
    *boxes = set;
    return qc_statusOk;
}

void qcBoxes_Destroy(qcBoxes* boxes)
{
    if (boxes == NULL)
        return;
    qcBoxTree_Free(&boxes->tree);
    qcNeighbours_Free(&boxes->neighbours);
    qcArray_Free(&boxes->boxes);
    qcArray_Free(&boxes->userData);
    qcArray_Free(&boxes->freeIds);
    qcArray_Free(&boxes->movers);
    qcArray_Free(&boxes->flags);
    qcArray_Free(&boxes->found);
    qcArray_Free(&boxes->scratch);
    qcArray_Free(&boxes->pairs);
    qcFree(boxes, sizeof *boxes);
}

void qcBoxes_Clear(qcBoxes* boxes)
{
    if (boxes == NULL)
        return;
    qcBoxTree_Clear(&boxes->tree);
    qcNeighbours_Clear(&boxes->neighbours);
    boxes->boxes.count = 0;
    boxes->freeIds.count = 0;
    boxes->movers.count = 0;
}

/// Room for one more box in every list that a box may come to be in, so that only adding can run out of memory.
static qcStatus ReserveOneMore(qcBoxes* set)
{
    size_t count = set->boxes.count + (set->freeIds.count == 0);
    if (count > UINT32_MAX / 2)
        return qcFailMemory(SIZE_MAX, "more than 2^31 boxes");
    QC_TRY(qcArray_Reserve(&set->boxes, count, sizeof(Box), "boxes"));
    QC_TRY(qcArray_Reserve(&set->userData, count, sizeof(void*), "user data of boxes"));
    QC_TRY(qcNeighbours_Reserve(&set->neighbours, count));
    QC_TRY(qcArray_Reserve(&set->freeIds, count, sizeof(uint32_t), "free ids of boxes"));
    QC_TRY(qcArray_Reserve(&set->movers, count, sizeof(uint32_t), "moved boxes"));
    QC_TRY(qcBoxTree_Reserve(&set->tree, (uint32_t)count));
    size_t flagged = set->flags.count;
    QC_TRY(qcArray_Resize(&set->flags, 2 * count, 1, "flags of nodes"));
    memset(&QC_AT(uint8_t, set->flags, flagged), 0, set->flags.count - flagged);
    return qc_statusOk;
}

qcStatus qcBoxes_Add(qcBoxes* boxes, const double lower[3], const double upper[3], void* userData, uint32_t* id)
{
    if (boxes == NULL || id == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Add: boxes or id is null");
    QC_TRY(CheckBounds("qcBoxes_Add", lower, upper));
    QC_TRY(ReserveOneMore(boxes));
    *id = boxes->freeIds.count != 0 ? PopFreeId(boxes) : (uint32_t)boxes->boxes.count++;
    Box* box = &QC_AT(Box, boxes->boxes, *id);
    memcpy(box->lower, lower, sizeof box->lower);
    memcpy(box->upper, upper, sizeof box->upper);
    QC_AT(void*, boxes->userData, *id) = userData;
    // Not fattened: most boxes never move.
    box->leaf = qcBoxTree_Insert(&boxes->tree, lower, upper, *id);
    box->mover = QC_NO_NODE;
    box->restless = true;
    box->still = true;
    MarkMoved(boxes, *id);
    return qc_statusOk;
}

qcStatus qcBoxes_Remove(qcBoxes* boxes, uint32_t id)
{
    if (GetBox(boxes, id) == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Remove: there is no box %u", id);
    UnmarkMoved(boxes, id);
    qcNeighbours_Part(&boxes->neighbours, id);
    qcBoxTree_Remove(&boxes->tree, QC_AT(Box, boxes->boxes, id).leaf);
    QC_AT(Box, boxes->boxes, id).leaf = QC_NO_NODE;
    PushFreeId(boxes, id);
    return qc_statusOk;
}

qcStatus qcBoxes_Move(qcBoxes* boxes, uint32_t id, const double lower[3], const double upper[3])
{
    if (GetBox(boxes, id) == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Move: there is no box %u", id);
    QC_TRY(CheckBounds("qcBoxes_Move", lower, upper));
    Box* box = &QC_AT(Box, boxes->boxes, id);
    bool same = true;
    for (int k = 0; k < 3; k++)
        same = same && box->lower[k] == lower[k] && box->upper[k] == upper[k];
    if (same)
        return qc_statusOk;
    if (!LeafFits(qcBoxTree_Node(&boxes->tree, box->leaf), lower, upper))
    {
        double fatLower[3], fatUpper[3];
        FattenBounds(box, lower, upper, StepsAhead(id), fatLower, fatUpper);
        qcBoxTree_Move(&boxes->tree, box->leaf, fatLower, fatUpper);
        box->restless = true;
        box->still = false;
    }
    memcpy(box->lower, lower, sizeof box->lower);
    memcpy(box->upper, upper, sizeof box->upper);
    MarkMoved(boxes, id);
    return qc_statusOk;
}

uint32_t qcBoxes_GetCount(const qcBoxes* boxes)
{
    return boxes == NULL ? 0 : (uint32_t)(boxes->boxes.count - boxes->freeIds.count);
}

void* qcBoxes_GetUserData(const qcBoxes* boxes, uint32_t id)
{
    return GetBox(boxes, id) == NULL ? NULL : QC_AT(void*, boxes->userData, id);
}

void qcBoxes_GetBounds(const qcBoxes* boxes, uint32_t id, double lower[3], double upper[3])
{
    const Box* box = GetBox(boxes, id);
    for (int k = 0; k < 3; k++)
    {
        lower[k] = box == NULL ? 0.0 : box->lower[k];
        upper[k] = box == NULL ? 0.0 : box->upper[k];
    }
}

static bool Contains(const double lower[3], const double upper[3], const double innerLower[3],
                     const double innerUpper[3])
{
    bool inside = true;
    for (int k = 0; k < 3; k++)
        inside = inside && lower[k] <= innerLower[k] && innerUpper[k] <= upper[k];
    return inside;
}

void qcBoxes_GetTotalBounds(const qcBoxes* boxes, double lower[3], double upper[3])
{
    uint32_t stack[qc_treeStack], count = 0;
    bool any = boxes != NULL && boxes->tree.root != QC_NO_NODE;
    for (int k = 0; k < 3; k++)
    {
        lower[k] = any ? INFINITY : 0.0;
        upper[k] = any ? -INFINITY : 0.0;
    }
    if (any)
        stack[count++] = boxes->tree.root;
    while (count > 0)
    {
        const qcTreeNode* node = qcBoxTree_Node(&boxes->tree, stack[--count]);
        if (Contains(lower, upper, node->lower, node->upper))
            continue;
        if (node->height != 0)
        {
            stack[count++] = node->child[0];
            stack[count++] = node->child[1];
            continue;
        }
        const Box* box = &QC_AT(Box, boxes->boxes, node->child[0]);
        for (int k = 0; k < 3; k++)
        {
            lower[k] = Lower(lower[k], box->lower[k]);
            upper[k] = Upper(upper[k], box->upper[k]);
        }
    }
}

//  ---- queries ---------------------------------------------------------------------------------------

/// Closed boxes; a NaN counts as unbounded.
static bool Meets(const double lowerA[3], const double upperA[3], const double lowerB[3], const double upperB[3])
{
    // One branch instead of six: which one turns a pair away is as good as random.
    return !((lowerA[0] > upperB[0]) | (upperA[0] < lowerB[0]) | (lowerA[1] > upperB[1]) | (upperA[1] < lowerB[1]) |
             (lowerA[2] > upperB[2]) | (upperA[2] < lowerB[2]));
}

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
    const Box *x = &QC_AT(Box, set->boxes, a), *y = &QC_AT(Box, set->boxes, b);
    if (!x->still || !y->still)
        return qcNeighbours_Join(&set->neighbours, a, b);
    // Not kept: scenery costs nothing once its pairs are known.
    return Meets(x->lower, x->upper, y->lower, y->upper) ? PushPair(set, a, b) : qc_statusOk;
}

/// Flags the leaves of the movers and all nodes above them, or takes the flags away.
static void FlagMovers(qcBoxes* set, uint8_t flag)
{
    uint8_t* flags = set->flags.data;
    for (size_t i = 0; i < set->movers.count; i++)
    {
        const Box* box = &QC_AT(Box, set->boxes, QC_AT(uint32_t, set->movers, i));
        uint32_t node = box->restless ? box->leaf : QC_NO_NODE;
        for (; node != QC_NO_NODE && flags[node] != flag; node = qcBoxTree_Node(&set->tree, node)->parent)
            flags[node] = flag;
    }
}

typedef struct NodePair
{
    uint32_t a, b;
} NodePair;

/// Pairs of boxes below two nodes that are not above each other, one of them a mover.
static qcStatus MeetBelow(qcBoxes* set, NodePair start)
{
    const uint8_t* flags = set->flags.data;
    // A step takes one pair and leaves four at most, one level down in both trees.
    NodePair stack[3 * qc_treeStack + 1];
    uint32_t count = 0;
    stack[count++] = start;
    while (count > 0)
    {
        NodePair pair = stack[--count];
        const qcTreeNode *a = qcBoxTree_Node(&set->tree, pair.a), *b = qcBoxTree_Node(&set->tree, pair.b);
        if (a->height == 0 && b->height == 0)
        {
            QC_TRY(MeetLeaves(set, a->child[0], b->child[0]));
            continue;
        }
        uint32_t below[2][2] = {{pair.a, pair.a}, {pair.b, pair.b}};
        int many[2] = {1, 1};
        if (a->height != 0)
        {
            below[0][0] = a->child[0];
            below[0][1] = a->child[1];
            many[0] = 2;
        }
        if (b->height != 0)
        {
            below[1][0] = b->child[0];
            below[1][1] = b->child[1];
            many[1] = 2;
        }
        for (int i = 0; i < many[0]; i++)
            for (int j = 0; j < many[1]; j++)
            {
                const qcTreeNode *x = qcBoxTree_Node(&set->tree, below[0][i]), *y = qcBoxTree_Node(&set->tree, below[1][j]);
                // Pushed without a branch: whether two nodes meet is as good as random.
                stack[count] = (NodePair){below[0][i], below[1][j]};
                count += Meets(x->lower, x->upper, y->lower, y->upper) & (flags[below[0][i]] | flags[below[1][j]]);
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
        if (QC_AT(Box, set->boxes, id).restless)
            qcNeighbours_Part(&set->neighbours, id);
    }
    FlagMovers(set, 1);
    qcStatus status = MeetAll(set);
    FlagMovers(set, 0);
    return status;
}

/// Keeps the pair if the boxes meet and one has moved.
static qcStatus MeetBoxes(qcBoxes* set, uint32_t a, uint32_t b)
{
    const Box *x = &QC_AT(Box, set->boxes, a), *y = &QC_AT(Box, set->boxes, b);
    bool moved = (x->mover & y->mover) != QC_NO_NODE;
    return moved & Meets(x->lower, x->upper, y->lower, y->upper) ? PushPair(set, a, b) : qc_statusOk;
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
            if (id < other || QC_AT(Box, set->boxes, other).mover == QC_NO_NODE)
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
        Box* box = &QC_AT(Box, boxes->boxes, QC_AT(uint32_t, boxes->movers, i));
        box->mover = QC_NO_NODE;
        box->restless = false;
    }
    boxes->movers.count = 0;
    *pairs = boxes->pairs.data;
    *count = boxes->pairs.count;
    return qc_statusOk;
}

void qcBoxes_QueryBox(const qcBoxes* boxes, const double lower[3], const double upper[3], qcBoxFunction* function,
                      void* context)
{
    uint32_t stack[qc_treeStack], count = 0;
    if (boxes != NULL && boxes->tree.root != QC_NO_NODE)
        stack[count++] = boxes->tree.root;
    while (count > 0)
    {
        const qcTreeNode* node = qcBoxTree_Node(&boxes->tree, stack[--count]);
        if (!Meets(node->lower, node->upper, lower, upper))
            continue;
        if (node->height != 0)
        {
            stack[count++] = node->child[0];
            stack[count++] = node->child[1];
            continue;
        }
        const Box* box = &QC_AT(Box, boxes->boxes, node->child[0]);
        if (Meets(box->lower, box->upper, lower, upper) && !function(node->child[0], QC_AT(void*, boxes->userData, node->child[0]), context))
            return;
    }
}

//  ---- casts -----------------------------------------------------------------------------------------

/// 16 u (see the file's head).
#define QC_CAST_TOLERANCE 0x1p-49

typedef struct Cast
{
    double from[3], castLower[3], castUpper[3];
    double wayLower[3], wayUpper[3]; ///< the box around the whole way
    double inverse[3];               ///< of the direction; 0: no slab in this axis
    double reach[3];                 ///< |from| + the larger cast extent
    const double* fraction;
} Cast;

/// NaN when one of them is: then no comparison turns a box away.
static double LowerOrNan(double a, double b)
{
    return a < b ? a : b <= a ? b : NAN;
}

static double UpperOrNan(double a, double b)
{
    return a > b ? a : b >= a ? b : NAN;
}

static Cast PrepareCast(const double from[3], const double to[3], const double castLower[3], const double castUpper[3],
                        const double* fraction)
{
    static const double wholeWay = 1.0;
    Cast cast = {.fraction = fraction != NULL ? fraction : &wholeWay};
    for (int k = 0; k < 3; k++)
    {
        cast.from[k] = from[k];
        cast.castLower[k] = castLower[k];
        cast.castUpper[k] = castUpper[k];
        cast.wayLower[k] = LowerOrNan(from[k], to[k]) + castLower[k];
        cast.wayUpper[k] = UpperOrNan(from[k], to[k]) + castUpper[k];
        double direction = to[k] - from[k], length = fabs(direction);
        cast.inverse[k] = length >= DBL_MIN && length <= 0x1p1021 ? 1.0 / direction : 0.0;
        cast.reach[k] = fabs(from[k]) + Upper(fabs(castLower[k]), fabs(castUpper[k]));
    }
    return cast;
}

/// `*entry`: where on the way, as a fraction, the box is met at the earliest.
static bool CastMeets(const Cast* cast, const double lower[3], const double upper[3], double* entry)
{
    double enter = 0.0, leave = *cast->fraction;
    for (int k = 0; k < 3; k++)
    {
        if (lower[k] > cast->wayUpper[k] || upper[k] < cast->wayLower[k])
            return false;
        double inverse = cast->inverse[k];
        if (inverse == 0.0)
            continue;
        double low = lower[k] - cast->castUpper[k] - cast->from[k] - 0x1p-51 * (fabs(lower[k]) + cast->reach[k]);
        double high = upper[k] - cast->castLower[k] - cast->from[k] + 0x1p-51 * (fabs(upper[k]) + cast->reach[k]);
        double near = (inverse > 0.0 ? low : high) * inverse, far = (inverse > 0.0 ? high : low) * inverse;
        if (near > enter)
            enter = near;
        if (far < leave)
            leave = far;
    }
    *entry = enter;
    return !(enter > leave + QC_CAST_TOLERANCE);
}

typedef struct CastStop
{
    uint32_t node;
    double entry;
} CastStop;

void qcBoxes_CastBox(const qcBoxes* boxes, const double from[3], const double to[3], const double castLower[3],
                     const double castUpper[3], const double* fraction, qcBoxFunction* function, void* context)
{
    Cast cast = PrepareCast(from, to, castLower, castUpper, fraction);
    CastStop stack[qc_treeStack];
    uint32_t count = 0;
    if (boxes != NULL && boxes->tree.root != QC_NO_NODE)
        stack[count++] = (CastStop){boxes->tree.root, 0.0};
    while (count > 0)
    {
        CastStop stop = stack[--count];
        // The fraction may have been lowered since.
        if (stop.entry > *cast.fraction + QC_CAST_TOLERANCE)
            continue;
        const qcTreeNode* node = qcBoxTree_Node(&boxes->tree, stop.node);
        if (node->height == 0)
        {
            const Box* box = &QC_AT(Box, boxes->boxes, node->child[0]);
            if (CastMeets(&cast, box->lower, box->upper, &stop.entry) &&
                !function(node->child[0], QC_AT(void*, boxes->userData, node->child[0]), context))
                return;
            continue;
        }
        CastStop hit[2];
        int hits = 0;
        for (int i = 0; i < 2; i++)
        {
            const qcTreeNode* child = qcBoxTree_Node(&boxes->tree, node->child[i]);
            hit[hits].node = node->child[i];
            hits += CastMeets(&cast, child->lower, child->upper, &hit[hits].entry);
        }
        if (hits == 2 && hit[0].entry < hit[1].entry)
        {
            CastStop nearer = hit[0];
            hit[0] = hit[1];
            hit[1] = nearer;
        }
        for (int i = 0; i < hits; i++)
            stack[count++] = hit[i];
    }
}
