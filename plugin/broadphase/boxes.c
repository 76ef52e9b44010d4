// A set of moving boxes over a forest of fattened boxes, so that a box that moves a little costs nothing there.
// Fat boxes: Catto, Box2D.
#include "broadphase/box_set.h"

#include "base/float_mode.h"
#include "base/status.h"

#include <float.h>
#include <string.h>

static qcBox* GetBox(const qcBoxes* set, uint32_t id)
{
    if (set == NULL || id >= set->boxes.count || !qcBoxes_Box(set, id)->alive)
        return NULL;
    return qcBoxes_Box(set, id);
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

/// To be called before the box changes.
static void MarkMoved(qcBoxes* set, uint32_t id, bool added)
{
    qcBox* box = qcBoxes_Box(set, id);
    if (box->mover != QC_NO_MOVER)
        return;
    qcMover* mover = &QC_AT(qcMover, set->movers, set->movers.count);
    mover->id = id;
    mover->added = added;
    mover->box = *box;
    if (!box->exact)
        mover->bounds = QC_AT(qcBounds, set->bounds, id);
    box->mover = (uint32_t)set->movers.count++;
}

static void UnmarkMoved(qcBoxes* set, uint32_t id)
{
    qcBox* box = qcBoxes_Box(set, id);
    if (box->mover == QC_NO_MOVER)
        return;
    qcMover last = QC_AT(qcMover, set->movers, --set->movers.count);
    QC_AT(qcMover, set->movers, box->mover) = last;
    qcBoxes_Box(set, last.id)->mover = box->mover;
    box->mover = QC_NO_MOVER;
}

//  ---- fat boxes -------------------------------------------------------------------------------------

/// The longest edge, or 0 when it is infinite: what fattening is measured by.
static double LongestEdge(const qcBounds* bounds)
{
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = qcUpper(longest, bounds->upper[k] - bounds->lower[k]);
    return longest <= DBL_MAX / 8.0 ? longest : 0.0;
}

/// The fat box still holds the box, given by the floats around it, and not too loosely.
static bool Fits(const qcFloatBox* fat, const qcFloatBox* box)
{
    // What floats hold is in a box of floats if these are, and not otherwise.
    bool fits = true;
    float longest = 0.0f, loosest = 0.0f;
    for (int k = 0; k < 3; k++)
    {
        float edge = box->upper[k] - box->lower[k], loose = fat->upper[k] - fat->lower[k] - edge;
        fits = fits & (box->lower[k] >= fat->lower[k]) & (box->upper[k] <= fat->upper[k]);
        longest = edge > longest ? edge : longest;
        loosest = loose > loosest ? loose : loosest;
    }
    // Five edges: more than twice what Fatten adds at most. To a box without end it adds nothing.
    return fits & !(loosest > (longest < INFINITY ? 5.0f * longest : 0.0f));
}

/// Room for jitter on all sides, and for a number of steps like the last one where a side moves outwards.
static qcFloatBox Fatten(const qcBounds* old, const qcBounds* bounds, double steps)
{
    qcBounds fat;
    double longest = LongestEdge(bounds);
    for (int k = 0; k < 3; k++)
    {
        double lower = bounds->lower[k], upper = bounds->upper[k];
        // A fiftieth of the edge, for jitter. With 10 000 boxes that move a fifteenth of theirs, a twentieth costs a
        // tenth more time, none a few percent less.
        double margin = qcLower(0.02 * (upper - lower), longest);
        // At most the box's length: a jump says nothing about the next step.
        double down = qcLower(steps * (old->lower[k] - lower), longest);
        double up = qcLower(steps * (upper - old->upper[k]), longest);
        fat.lower[k] = qcLower(lower, lower - qcUpper(down, 0.0) - margin);
        fat.upper[k] = qcUpper(upper, upper + qcUpper(up, 0.0) + margin);
    }
    qcFloatBox box;
    (void)qcFloatBox_Enclose(&box, fat.lower, fat.upper);
    return box;
}

/// How many steps ahead a fat box is made: 10 to 25. With 5 to 12, a step that moves 10 of 1000 boxes takes a tenth
/// more time, one that moves a tenth of 10 000 a tenth less, and where all move it is the same. It differs from box to
/// box so that boxes which set out together don't all leave their fat boxes in the same step.
static double StepsAhead(uint32_t id)
{
    return 10.0 + (double)(id * 2654435769u >> 28);
}

//  ---- the set ---------------------------------------------------------------------------------------

qcStatus qcBoxes_Create(qcBoxes** boxes)
{
    if (boxes == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Create: boxes is null");
    qcBoxes* set = qcAllocateZeroed(sizeof *set);
    if (set == NULL)
        return qcFailMemory(sizeof *set, "a set of boxes");
    qcOverlapGraph_Clear(&set->neighbours);
    *boxes = set;
    return qc_statusOk;
}

void qcBoxes_Destroy(qcBoxes* boxes)
{
    if (boxes == NULL)
        return;
    qcForest_Free(&boxes->forest);
    qcOverlapGraph_Free(&boxes->neighbours);
    qcArray_Free(&boxes->boxes);
    qcArray_Free(&boxes->bounds);
    qcArray_Free(&boxes->userData);
    qcArray_Free(&boxes->freeIds);
    qcArray_Free(&boxes->movers);
    qcArray_Free(&boxes->hits);
    qcArray_Free(&boxes->stamps);
    qcArray_Free(&boxes->began);
    qcArray_Free(&boxes->ended);
    qcArray_Free(&boxes->scratch);
    qcArray_Free(&boxes->pairs);
    qcFree(boxes, sizeof *boxes);
}

void qcBoxes_Clear(qcBoxes* boxes)
{
    if (boxes == NULL)
        return;
    qcForest_Clear(&boxes->forest);
    qcOverlapGraph_Clear(&boxes->neighbours);
    boxes->boxes.count = 0;
    boxes->stamps.count = 0;
    boxes->stamp = 0;
    boxes->freeIds.count = 0;
    boxes->movers.count = 0;
    boxes->putCount = 0;
    boxes->lostCount = 0;
    boxes->forgotten = false;
}

/// Room for one more box in every list that a box may come to be in, so that only adding can run out of memory.
static qcStatus ReserveOneMore(qcBoxes* set)
{
    size_t count = set->boxes.count + (set->freeIds.count == 0);
    if (count > QC_EDGE_MARK)
        return qcFailMemory(SIZE_MAX, "more than 2^31 boxes");
    QC_TRY(qcArray_Reserve(&set->boxes, count, sizeof(qcBox), "boxes"));
    QC_TRY(qcArray_Resize(&set->bounds, count, sizeof(qcBounds), "bounds of boxes"));
    QC_TRY(qcArray_Resize(&set->userData, count, sizeof(void*), "user data of boxes"));
    QC_TRY(qcArray_GrowZeroed(&set->stamps, count, sizeof(uint32_t), "stamps of boxes"));
    QC_TRY(qcForest_Reserve(&set->forest, count));
    QC_TRY(qcOverlapGraph_Reserve(&set->neighbours, count));
    QC_TRY(qcArray_Reserve(&set->freeIds, count, sizeof(uint32_t), "free ids of boxes"));
    return qcArray_Reserve(&set->movers, count, sizeof(qcMover), "moved boxes");
}

static bool IsSame(const qcBoxes* set, uint32_t id, const double lower[3], const double upper[3],
                   const qcFloatBox* around, bool exact)
{
    const qcBox* box = qcBoxes_Box(set, id);
    const qcBounds* old = &QC_AT(qcBounds, set->bounds, id);
    bool same = box->exact == exact;
    for (int k = 0; k < 3 && same; k++)
        same = around->lower[k] == box->lower[k] && around->upper[k] == box->upper[k];
    for (int k = 0; k < 3 && same && !exact; k++)
        same = lower[k] == old->lower[k] && upper[k] == old->upper[k];
    return same;
}

static qcBounds MakeBounds(const double lower[3], const double upper[3])
{
    return (qcBounds){{lower[0], lower[1], lower[2]}, {upper[0], upper[1], upper[2]}};
}

static void StoreBounds(qcBoxes* set, uint32_t id, const double lower[3], const double upper[3],
                        const qcFloatBox* around, bool exact)
{
    qcBox* box = qcBoxes_Box(set, id);
    memcpy(box->lower, around->lower, sizeof box->lower);
    memcpy(box->upper, around->upper, sizeof box->upper);
    box->exact = exact;
    if (!exact)
        QC_AT(qcBounds, set->bounds, id) = MakeBounds(lower, upper);
}

__attribute__((noinline)) static qcStatus Add(qcBoxes* boxes, const double lower[3], const double upper[3],
                                              void* userData, uint32_t* id)
{
    if (boxes == NULL || id == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Add: boxes or id is null");
    QC_TRY(CheckBounds("qcBoxes_Add", lower, upper));
    QC_TRY(ReserveOneMore(boxes));
    *id = boxes->freeIds.count != 0 ? PopFreeId(boxes) : (uint32_t)boxes->boxes.count++;
    qcFloatBox around;
    bool exact = qcFloatBox_Enclose(&around, lower, upper);
    *qcBoxes_Box(boxes, *id) = (qcBox){.mover = QC_NO_MOVER, .alive = true, .at = qc_boxPairsStale, .still = true};
    boxes->putCount++;
    boxes->lostCount++;
    StoreBounds(boxes, *id, lower, upper, &around, exact);
    MarkMoved(boxes, *id, true);
    QC_AT(void*, boxes->userData, *id) = userData;
    // Not fattened: most boxes never move.
    qcForest_Put(&boxes->forest, *id, &around);
    return qc_statusOk;
}

qcStatus qcBoxes_Add(qcBoxes* boxes, const double lower[3], const double upper[3], void* userData, uint32_t* id)
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = Add(boxes, lower, upper, userData, id);
    qcFloatMode_End(mode);
    return status;
}

qcStatus qcBoxes_Remove(qcBoxes* boxes, uint32_t id)
{
    if (GetBox(boxes, id) == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Remove: there is no box %u", id);
    UnmarkMoved(boxes, id);
    boxes->putCount -= qcBoxes_Box(boxes, id)->at != qc_boxInTree;
    boxes->lostCount -= qcBoxes_Box(boxes, id)->at == qc_boxPairsStale;
    qcOverlapGraph_Part(&boxes->neighbours, id);
    qcForest_Remove(&boxes->forest, id);
    qcBoxes_Box(boxes, id)->alive = false;
    PushFreeId(boxes, id);
    return qc_statusOk;
}

/// Pairs of still boxes are not kept: when the first of the two moves, the search must know that they overlapped.
static void BeginToMove(qcBoxes* set, uint32_t id)
{
    qcBox* box = qcBoxes_Box(set, id);
    box->still = false;
    if (!QC_AT(qcMover, set->movers, box->mover).added)
        qcBoxes_KeepStillPairs(set, id);
}

__attribute__((noinline)) static qcStatus Move(qcBoxes* boxes, uint32_t id, const double lower[3],
                                               const double upper[3])
{
    qcBox* box = GetBox(boxes, id);
    if (box == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Move: there is no box %u", id);
    QC_TRY(CheckBounds("qcBoxes_Move", lower, upper));
    qcFloatBox around;
    bool exact = qcFloatBox_Enclose(&around, lower, upper);
    if (IsSame(boxes, id, lower, upper, &around, exact))
        return qc_statusOk;
    MarkMoved(boxes, id, false);
    bool wasStill = box->still;
    // A still box may have still neighbours, which are not kept: it has to look for them.
    if (wasStill)
        BeginToMove(boxes, id);
    if (wasStill || !Fits(&QC_AT(qcFloatBox, boxes->forest.boxes, id), &around))
    {
        qcBounds old = qcBoxes_Bounds(boxes, id), bounds = MakeBounds(lower, upper);
        qcFloatBox fat = Fatten(&old, &bounds, StepsAhead(id));
        qcForest_Put(&boxes->forest, id, &fat);
        boxes->putCount += box->at == qc_boxInTree;
        boxes->lostCount += box->at != qc_boxPairsStale;
        box->at = qc_boxPairsStale;
    }
    StoreBounds(boxes, id, lower, upper, &around, exact);
    return qc_statusOk;
}

qcStatus qcBoxes_Move(qcBoxes* boxes, uint32_t id, const double lower[3], const double upper[3])
{
    qcFloatMode mode = qcFloatMode_Begin();
    qcStatus status = Move(boxes, id, lower, upper);
    qcFloatMode_End(mode);
    return status;
}

uint32_t qcBoxes_GetCount(const qcBoxes* boxes)
{
    return boxes == NULL ? 0 : (uint32_t)(boxes->boxes.count - boxes->freeIds.count);
}

void* qcBoxes_GetUserData(const qcBoxes* boxes, uint32_t id)
{
    const qcBox* box = GetBox(boxes, id);
    return box == NULL ? NULL : QC_AT(void*, boxes->userData, id);
}

__attribute__((noinline)) static void GetBounds(const qcBoxes* boxes, uint32_t id, double lower[3], double upper[3])
{
    qcBounds bounds = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    if (GetBox(boxes, id) != NULL)
        bounds = qcBoxes_Bounds(boxes, id);
    memcpy(lower, bounds.lower, sizeof bounds.lower);
    memcpy(upper, bounds.upper, sizeof bounds.upper);
}

void qcBoxes_GetBounds(const qcBoxes* boxes, uint32_t id, double lower[3], double upper[3])
{
    qcFloatMode mode = qcFloatMode_Begin();
    GetBounds(boxes, id, lower, upper);
    qcFloatMode_End(mode);
}
