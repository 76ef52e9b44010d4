// Groups the new bodies by their keys (sweep/bvh/bvh_copy.h).
#include "sweep/copied_orders.h"

#include "base/radix_sort.h"
#include "base/status.h"
#include "sweep/bvh/bvh_copy.h"

/// Tasks with one key, in the list of keys.
typedef struct Group
{
    size_t first, end;
} Group;

static qcRefitTask* TaskOf(const qcBvhCandidates* sweep, size_t item)
{
    return &QC_AT(qcRefitTask, sweep->tasks, QC_AT(qcSortItem, sweep->keys, item).value);
}

/// Lists the tasks of bodies without a BVH by key, those with the same one in order. `counts`: a bit for each number of
/// triangles, modulo 64.
static qcStatus ListKeys(const qcStepTriangles* triangles, qcBvhCandidates* sweep, uint64_t* counts)
{
    sweep->keys.count = 0;
    *counts = 0;
    for (size_t i = 0; i < sweep->tasks.count; i++)
    {
        uint32_t number = QC_AT(qcRefitTask, sweep->tasks, i).body;
        if (qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, number))->bvh.generation != 0)
            continue;
        const qcBody* body = qcStepTriangles_Body(triangles, number);
        size_t at = sweep->keys.count;
        QC_TRY(qcArray_Resize(&sweep->keys, at + 1, sizeof(qcSortItem), "BVHs"));
        QC_AT(qcSortItem, sweep->keys, at) = (qcSortItem){qcBvhCopy_KeyOf(body), i};
        *counts |= UINT64_C(1) << body->triangleCount % 64;
    }
    if (sweep->keys.count == 0)
        return qc_statusOk;
    return qcSort_Items(sweep->keys.data, sweep->keys.count, &sweep->sorted);
}

/// The tasks from `first` on that have its key.
static Group GroupFrom(const qcBvhCandidates* sweep, size_t first)
{
    const qcSortItem* keys = sweep->keys.data;
    Group group = {first, first + 1};
    while (group.end < sweep->keys.count && keys[group.end].key == keys[first].key)
        group.end++;
    return group;
}

/// Empty: there is none.
static Group FindGroup(const qcBvhCandidates* sweep, uint64_t key)
{
    const qcSortItem* keys = sweep->keys.data;
    size_t first = 0, end = sweep->keys.count;
    while (first < end)
    {
        size_t middle = first + (end - first) / 2;
        if (keys[middle].key < key)
            first = middle + 1;
        else
            end = middle;
    }
    if (first == sweep->keys.count || keys[first].key != key)
        return (Group){0, 0};
    return GroupFrom(sweep, first);
}

/// Whether the order of a body's BVH may be taken over.
static bool HasWholeOrder(const qcBodyBvh* bvh, const qcBody* body)
{
    return bvh != NULL && bvh->bvh.generation == body->generation && bvh->bvh.region == NULL &&
           !qcTriangleBvh_HasGrown(&bvh->bvh);
}

/// Lets groups take over the order of a body that has a BVH.
static void CopyOld(const qcStepTriangles* triangles, uint64_t counts, qcBvhCandidates* sweep)
{
    size_t left = sweep->keys.count;
    for (uint32_t number = 0; number < triangles->bodyCount && left != 0; number++)
    {
        const qcBody* body = qcStepTriangles_Body(triangles, number);
        if ((counts >> body->triangleCount % 64 & 1) == 0 ||
            !HasWholeOrder(qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, number)), body))
            continue;
        Group group = FindGroup(sweep, qcBvhCopy_KeyOf(body));
        if (group.first == group.end || TaskOf(sweep, group.first)->order != TaskOf(sweep, group.first)->body)
            continue;
        for (size_t i = group.first; i < group.end; i++)
            TaskOf(sweep, i)->order = number;
        left -= group.end - group.first;
    }
}

/// Lets the others take over the order of the first of their group.
static void CopyNew(qcBvhCandidates* sweep)
{
    for (Group group = {0, 0}; group.end < sweep->keys.count;)
    {
        group = GroupFrom(sweep, group.end);
        qcRefitTask* first = TaskOf(sweep, group.first);
        if (first->order != first->body)
            continue;
        first->isCopied = group.end - group.first > 1;
        for (size_t i = group.first + 1; i < group.end; i++)
        {
            TaskOf(sweep, i)->order = first->body;
            TaskOf(sweep, i)->waits = true;
        }
    }
}

qcStatus qcCopiedOrders_Find(const qcStepTriangles* triangles, qcBvhCandidates* sweep)
{
    uint64_t counts;
    QC_TRY(ListKeys(triangles, sweep, &counts));
    CopyOld(triangles, counts, sweep);
    CopyNew(sweep);
    return qc_statusOk;
}
