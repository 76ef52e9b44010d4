// A set of moving boxes over a tree of fattened boxes, so that a box that moves a little costs nothing in the tree.
// Fat boxes: Catto, Box2D.
#include "box_set.h"

#include "status.h"

#include <float.h>
#include <string.h>

static const qcBox* GetBox(const qcBoxes* set, uint32_t id)
{
    if (set == NULL || id >= set->boxes.count || QC_AT(qcBox, set->boxes, id).leaf == QC_NO_NODE)
        return NULL;
    return &QC_AT(qcBox, set->boxes, id);
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
    qcBox* box = &QC_AT(qcBox, set->boxes, id);
    if (box->mover != QC_NO_NODE)
        return;
    box->mover = (uint32_t)set->movers.count;
    QC_AT(uint32_t, set->movers, set->movers.count++) = id;
}

static void UnmarkMoved(qcBoxes* set, uint32_t id)
{
    qcBox* box = &QC_AT(qcBox, set->boxes, id);
    if (box->mover == QC_NO_NODE)
        return;
    uint32_t last = QC_AT(uint32_t, set->movers, --set->movers.count);
    QC_AT(uint32_t, set->movers, box->mover) = last;
    QC_AT(qcBox, set->boxes, last).mover = box->mover;
    box->mover = QC_NO_NODE;
}

//  ---- fat boxes -------------------------------------------------------------------------------------

/// The longest edge, or 0 when it is infinite: what fattening is measured by.
static double LongestEdge(const double lower[3], const double upper[3])
{
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = qcUpper(longest, upper[k] - lower[k]);
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
        // More than twice what FattenBounds adds at most.
        if (upper[k] - lower[k] + 5.0 * longest < leaf->upper[k] - leaf->lower[k])
            return false;
    }
    return true;
}

/// Room for jitter on all sides, and for a number of steps like the last one where a side moves outwards.
static void FattenBounds(const qcBox* old, const double lower[3], const double upper[3], double steps,
                         double fatLower[3], double fatUpper[3])
{
    double longest = LongestEdge(lower, upper);
    for (int k = 0; k < 3; k++)
    {
        // A fiftieth of the edge. With 10 000 boxes that move a fifteenth of theirs, a tenth costs a quarter more time.
        double margin = qcLower(0.02 * (upper[k] - lower[k]), longest);
        // At most the box's length: a jump says nothing about the next step.
        double down = qcLower(steps * (old->lower[k] - lower[k]), longest);
        double up = qcLower(steps * (upper[k] - old->upper[k]), longest);
        fatLower[k] = qcLower(lower[k], lower[k] - qcUpper(down, 0.0) - margin);
        fatUpper[k] = qcUpper(upper[k], upper[k] + qcUpper(up, 0.0) + margin);
    }
}

/// How many steps ahead a leaf is made: 5 to 12. On the scene above, 4 for all cost a sixth more time than 8 or 12. It
/// differs from box to box so that boxes which set out together don't all leave their leaves in the same step.
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
    QC_TRY(qcArray_Reserve(&set->boxes, count, sizeof(qcBox), "boxes"));
    QC_TRY(qcArray_Resize(&set->userData, count, sizeof(void*), "user data of boxes"));
    QC_TRY(qcNeighbours_Reserve(&set->neighbours, count));
    QC_TRY(qcArray_Reserve(&set->freeIds, count, sizeof(uint32_t), "free ids of boxes"));
    QC_TRY(qcArray_Reserve(&set->movers, count, sizeof(uint32_t), "moved boxes"));
    QC_TRY(qcBoxTree_Reserve(&set->tree, (uint32_t)count));
    size_t flagged = set->flags.count;
    if (flagged >= 2 * count)
        return qc_statusOk;
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
    qcBox* box = &QC_AT(qcBox, boxes->boxes, *id);
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
    qcBoxTree_Remove(&boxes->tree, QC_AT(qcBox, boxes->boxes, id).leaf);
    QC_AT(qcBox, boxes->boxes, id).leaf = QC_NO_NODE;
    PushFreeId(boxes, id);
    return qc_statusOk;
}

qcStatus qcBoxes_Move(qcBoxes* boxes, uint32_t id, const double lower[3], const double upper[3])
{
    if (GetBox(boxes, id) == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Move: there is no box %u", id);
    QC_TRY(CheckBounds("qcBoxes_Move", lower, upper));
    qcBox* box = &QC_AT(qcBox, boxes->boxes, id);
    bool same = true;
    for (int k = 0; k < 3; k++)
        same = same && box->lower[k] == lower[k] && box->upper[k] == upper[k];
    if (same)
        return qc_statusOk;
    // A still box may have still neighbours, which are not kept: it has to look for them.
    if (box->still || !LeafFits(qcBoxTree_Node(&boxes->tree, box->leaf), lower, upper))
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
    const qcBox* box = GetBox(boxes, id);
    for (int k = 0; k < 3; k++)
    {
        lower[k] = box == NULL ? 0.0 : box->lower[k];
        upper[k] = box == NULL ? 0.0 : box->upper[k];
    }
}
