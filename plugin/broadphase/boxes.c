// A set of moving boxes over a BVH forest of fat AABBs: a small move leaves the forest unchanged. Fat AABBs: Catto,
// Box2D.
#include "broadphase/box_set.h"

#include "base/float_mode.h"
#include "base/scalar.h"
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

//  ---- moved boxes -----------------------------------------------------------------------------------

/// Lists a box as moved, with its present bounds. Call it before the box changes.
static void MarkMoved(qcBoxes* set, uint32_t id, bool added)
{
    qcBox* box = qcBoxes_Box(set, id);
    if (box->movedIndex != QC_NOT_MOVED)
        return;
    qcMovedBox* moved = &QC_AT(qcMovedBox, set->movedBoxes, set->movedBoxes.count);
    moved->id = id;
    moved->added = added;
    moved->box = *box;
    if (!box->exact)
        moved->bounds = QC_AT(qcBounds, set->bounds, id);
    box->movedIndex = (uint32_t)set->movedBoxes.count++;
}

static void UnmarkMoved(qcBoxes* set, uint32_t id)
{
    qcBox* box = qcBoxes_Box(set, id);
    if (box->movedIndex == QC_NOT_MOVED)
        return;
    qcMovedBox last = QC_AT(qcMovedBox, set->movedBoxes, --set->movedBoxes.count);
    QC_AT(qcMovedBox, set->movedBoxes, box->movedIndex) = last;
    qcBoxes_Box(set, last.id)->movedIndex = box->movedIndex;
    box->movedIndex = QC_NOT_MOVED;
}

//  ---- fat AABBs -------------------------------------------------------------------------------------

/// The longest edge, or 0 when it is infinite: the scale of the enlargement.
static double LongestEdge(const qcBounds* bounds)
{
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = qcMax(longest, bounds->upper[k] - bounds->lower[k]);
    return longest <= DBL_MAX / 8.0 ? longest : 0.0;
}

/// Whether the fat AABB contains the box, given as floats, and is not much larger. A box lies in a box of floats if and
/// only if its smallest enclosing box of floats does; with an origin it may lie in one that its floats exceed.
static bool Fits(const qcFloatBox* fat, const qcFloatBox* box)
{
    bool fits = true;
    float longest = 0.0f, loosest = 0.0f;
    for (int k = 0; k < 3; k++)
    {
        float edge = box->upper[k] - box->lower[k], loose = fat->upper[k] - fat->lower[k] - edge;
        fits = fits & (box->lower[k] >= fat->lower[k]) & (box->upper[k] <= fat->upper[k]);
        longest = edge > longest ? edge : longest;
        loosest = loose > loosest ? loose : loosest;
    }
    // Five edges: more than twice the maximum that Fatten adds. It adds nothing to an infinite box.
    return fits & !(loosest > (longest < INFINITY ? 5.0f * longest : 0.0f));
}

/// Enlarges a box: on all sides by a margin for jitter, and where a side moves outwards by `steps` steps as long as the
/// last one.
static qcFloatBox Fatten(const qcBoxOrigin* origin, const qcBounds* previous, const qcBounds* bounds, double steps)
{
    qcBounds fat;
    double longest = LongestEdge(bounds);
    for (int k = 0; k < 3; k++)
    {
        double lower = bounds->lower[k], upper = bounds->upper[k];
        // A fiftieth of the edge, for jitter. With 10 000 boxes that move by a fifteenth of their edge, a margin of a
        // twentieth takes a tenth more time, and no margin takes a few percent less.
        double margin = qcMin(0.02 * (upper - lower), longest);
        // At most the longest edge: a jump doesn't predict the next step.
        double down = qcMin(steps * (previous->lower[k] - lower), longest);
        double up = qcMin(steps * (upper - previous->upper[k]), longest);
        fat.lower[k] = qcMin(lower, lower - qcMax(down, 0.0) - margin);
        fat.upper[k] = qcMax(upper, upper + qcMax(up, 0.0) + margin);
    }
    qcFloatBox box;
    (void)qcBoxOrigin_Enclose(origin, &box, fat.lower, fat.upper);
    return box;
}

/// Number of steps that a fat AABB covers: 10 to 25. With 5 to 12, a step that moves 10 of 1000 boxes takes a tenth
/// more time, one that moves a tenth of 10 000 a tenth less, and one that moves all the same. The number varies by box,
/// so that boxes which start together don't all leave their fat AABBs in the same step.
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
    qcOverlapGraph_Clear(&set->overlaps);
    *boxes = set;
    return qc_statusOk;
}

void qcBoxes_Destroy(qcBoxes* boxes)
{
    if (boxes == NULL)
        return;
    qcForest_Free(&boxes->forest);
    qcOverlapGraph_Free(&boxes->overlaps);
    qcArray_Free(&boxes->boxes);
    qcArray_Free(&boxes->bounds);
    qcArray_Free(&boxes->userData);
    qcArray_Free(&boxes->freeIds);
    qcArray_Free(&boxes->movedBoxes);
    qcArray_Free(&boxes->hits);
    qcArray_Free(&boxes->visitMarks);
    qcArray_Free(&boxes->began);
    qcArray_Free(&boxes->ended);
    qcFree(boxes, sizeof *boxes);
}

void qcBoxes_Clear(qcBoxes* boxes)
{
    if (boxes == NULL)
        return;
    qcForest_Clear(&boxes->forest);
    qcOverlapGraph_Clear(&boxes->overlaps);
    boxes->boxes.count = 0;
    boxes->visitMarks.count = 0;
    boxes->lastMark = 0;
    boxes->freeIds.count = 0;
    boxes->movedBoxes.count = 0;
    boxes->insertedCount = 0;
    boxes->staleCount = 0;
    boxes->historyLost = false;
    boxes->origin = (qcBoxOrigin){.isSet = false};
    boxes->coarseCount = 0;
    boxes->originMoved = false;
}

/// Reserves room for one more box in every list, so that only adding a box can run out of memory.
static qcStatus ReserveOneMore(qcBoxes* set)
{
    size_t count = set->boxes.count + (set->freeIds.count == 0);
    if (count > QC_EDGE_MARK)
        return qcFailMemory(SIZE_MAX, "more than 2^31 boxes");
    QC_TRY(qcArray_Reserve(&set->boxes, count, sizeof(qcBox), "boxes"));
    QC_TRY(qcArray_Resize(&set->bounds, count, sizeof(qcBounds), "bounds of boxes"));
    QC_TRY(qcArray_Resize(&set->userData, count, sizeof(void*), "user data of boxes"));
    QC_TRY(qcArray_GrowZeroed(&set->visitMarks, count, sizeof(uint32_t), "visit marks of boxes"));
    QC_TRY(qcForest_Reserve(&set->forest, count));
    QC_TRY(qcOverlapGraph_Reserve(&set->overlaps, count));
    QC_TRY(qcArray_Reserve(&set->freeIds, count, sizeof(uint32_t), "free ids of boxes"));
    return qcArray_Reserve(&set->movedBoxes, count, sizeof(qcMovedBox), "moved boxes");
}

/// New bounds of a box.
typedef struct Extent
{
    const double *lower, *upper;
    qcFloatBox floats; ///< contains the bounds minus the origin
    bool exact;        ///< the floats equal the bounds
} Extent;

static inline Extent MakeExtent(const qcBoxes* set, const double lower[3], const double upper[3])
{
    Extent extent;
    extent.lower = lower;
    extent.upper = upper;
    extent.exact = qcBoxOrigin_Enclose(&set->origin, &extent.floats, lower, upper);
    return extent;
}

static bool IsSame(const qcBoxes* set, uint32_t id, const Extent* extent)
{
    const qcBox* box = qcBoxes_Box(set, id);
    const qcBounds* old = &QC_AT(qcBounds, set->bounds, id);
    bool same = box->exact == extent->exact;
    for (int k = 0; k < 3 && same; k++)
        same = extent->floats.lower[k] == box->lower[k] && extent->floats.upper[k] == box->upper[k];
    for (int k = 0; k < 3 && same && !extent->exact; k++)
        same = extent->lower[k] == old->lower[k] && extent->upper[k] == old->upper[k];
    return same;
}

static inline qcBounds MakeBounds(const Extent* extent)
{
    const double *l = extent->lower, *u = extent->upper;
    return (qcBounds){{l[0], l[1], l[2]}, {u[0], u[1], u[2]}};
}

static inline void SetFloats(qcBox* box, const Extent* extent)
{
    memcpy(box->lower, extent->floats.lower, sizeof box->lower);
    memcpy(box->upper, extent->floats.upper, sizeof box->upper);
    box->exact = extent->exact;
}

static void StoreExtent(qcBoxes* set, uint32_t id, const Extent* extent)
{
    SetFloats(qcBoxes_Box(set, id), extent);
    if (!extent->exact)
        QC_AT(qcBounds, set->bounds, id) = MakeBounds(extent);
}

//  ---- the origin ------------------------------------------------------------------------------------

/// Makes the floats of a box anew from its bounds, and inserts it anew.
static void RenewBox(qcBoxes* set, uint32_t id)
{
    qcBox* box = qcBoxes_Box(set, id);
    qcBounds bounds = QC_AT(qcBounds, set->bounds, id);
    Extent extent = MakeExtent(set, bounds.lower, bounds.upper);
    StoreExtent(set, id, &extent);
    qcFloatBox fat = box->stationary ? extent.floats : Fatten(&set->origin, &bounds, &bounds, 0.0);
    qcForest_Insert(&set->forest, id, &fat, box->stationary && box->exact);
    box->state = qc_boxPairsStale;
}

/// Moves the origin. Edges of the graph stay, as marks of the last search; all boxes become stale.
static void SetOrigin(qcBoxes* set, const qcBoxOrigin* origin)
{
    // Bounds are read from exact floats while these are relative to zero.
    for (size_t id = 0; id < set->boxes.count; id++)
        QC_AT(qcBounds, set->bounds, id) = qcBoxes_Bounds(set, (uint32_t)id);
    set->origin = *origin;
    for (size_t i = 0; i < set->movedBoxes.count; i++)
    {
        qcMovedBox* moved = &QC_AT(qcMovedBox, set->movedBoxes, i);
        if (moved->added)
            continue;
        if (moved->box.exact)
            moved->bounds = qcBox_Bounds(&moved->box);
        Extent extent = MakeExtent(set, moved->bounds.lower, moved->bounds.upper);
        SetFloats(&moved->box, &extent);
    }
    for (size_t id = 0; id < set->boxes.count; id++)
        if (qcBoxes_Box(set, (uint32_t)id)->alive)
            RenewBox(set, (uint32_t)id);
    set->insertedCount = set->staleCount = qcBoxes_GetCount(set);
    set->originMoved = true;
}

__attribute__((cold, noinline)) static void ChooseOrigin(qcBoxes* set)
{
    qcBounds sample[qc_originSample];
    uint32_t count = 0;
    for (size_t i = 0; i < qc_originSample; i++)
    {
        uint32_t id = (uint32_t)(i * set->boxes.count / qc_originSample);
        if (qcBoxes_Box(set, id)->alive)
            sample[count++] = qcBoxes_Bounds(set, id);
    }
    qcBoxOrigin origin = set->origin;
    if (qcBoxOrigin_Choose(&origin, sample, count))
        SetOrigin(set, &origin);
    set->coarseCount = 0;
}

/// Counts a box that was inserted into the forest if it is coarse. Chooses an origin after as many as half of the
/// boxes: inserting all boxes anew is then O(1) insertions for each.
static inline void CountCoarse(qcBoxes* set, const Extent* extent)
{
    if (extent->exact || !qcFloatBox_IsCoarse(&extent->floats, extent->lower, extent->upper))
        return;
    // Few boxes are found fast anywhere.
    if (++set->coarseCount >= qc_originSample && set->coarseCount >= qcBoxes_GetCount(set) / 2)
        ChooseOrigin(set);
}

//  ---- boxes -----------------------------------------------------------------------------------------

__attribute__((noinline)) static qcStatus Add(qcBoxes* boxes, const double lower[3], const double upper[3],
                                              void* userData, uint32_t* id)
{
    if (boxes == NULL || id == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Add: boxes or id is null");
    QC_TRY(CheckBounds("qcBoxes_Add", lower, upper));
    QC_TRY(ReserveOneMore(boxes));
    *id = boxes->freeIds.count != 0 ? PopFreeId(boxes) : (uint32_t)boxes->boxes.count++;
    Extent extent = MakeExtent(boxes, lower, upper);
    *qcBoxes_Box(boxes, *id) =
        (qcBox){.movedIndex = QC_NOT_MOVED, .alive = true, .state = qc_boxPairsStale, .stationary = true};
    boxes->insertedCount++;
    boxes->staleCount++;
    StoreExtent(boxes, *id, &extent);
    MarkMoved(boxes, *id, true);
    QC_AT(void*, boxes->userData, *id) = userData;
    // Not enlarged: most boxes never move.
    qcForest_Insert(&boxes->forest, *id, &extent.floats, extent.exact);
    CountCoarse(boxes, &extent);
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
    boxes->insertedCount -= qcBoxes_Box(boxes, id)->state != qc_boxInTree;
    boxes->staleCount -= qcBoxes_Box(boxes, id)->state == qc_boxPairsStale;
    qcOverlapGraph_RemoveEdgesOf(&boxes->overlaps, id);
    qcForest_Remove(&boxes->forest, id);
    qcBoxes_Box(boxes, id)->alive = false;
    QC_AT(void*, boxes->userData, id) = NULL;
    PushFreeId(boxes, id);
    return qc_statusOk;
}

/// Called when a stationary box moves. The graph has no edges between stationary boxes: the box's overlaps with these
/// at the last search are added first, so that the next search can report their end.
static void EndStationary(qcBoxes* set, uint32_t id)
{
    qcBox* box = qcBoxes_Box(set, id);
    box->stationary = false;
    if (!QC_AT(qcMovedBox, set->movedBoxes, box->movedIndex).added)
        qcBoxes_CommitStationaryPairs(set, id);
}

__attribute__((noinline)) static qcStatus Move(qcBoxes* boxes, uint32_t id, const double lower[3],
                                               const double upper[3])
{
    qcBox* box = GetBox(boxes, id);
    if (box == NULL)
        return qcFail(qc_statusBadInput, "qcBoxes_Move: there is no box %u", id);
    QC_TRY(CheckBounds("qcBoxes_Move", lower, upper));
    Extent extent = MakeExtent(boxes, lower, upper);
    if (IsSame(boxes, id, &extent))
        return qc_statusOk;
    MarkMoved(boxes, id, false);
    bool wasStationary = box->stationary;
    if (wasStationary)
        EndStationary(boxes, id);
    bool insert = wasStationary || !Fits(&QC_AT(qcFloatBox, boxes->forest.boxes, id), &extent.floats);
    if (insert)
    {
        qcBounds previous = qcBoxes_Bounds(boxes, id), bounds = MakeBounds(&extent);
        qcFloatBox fat = Fatten(&boxes->origin, &previous, &bounds, StepsAhead(id));
        qcForest_Insert(&boxes->forest, id, &fat, false);
        boxes->insertedCount += box->state == qc_boxInTree;
        boxes->staleCount += box->state != qc_boxPairsStale;
        box->state = qc_boxPairsStale;
    }
    StoreExtent(boxes, id, &extent);
    if (insert)
        CountCoarse(boxes, &extent);
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
    return boxes == NULL || id >= boxes->boxes.count ? NULL : QC_AT(void*, boxes->userData, id);
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
