// Static trees merged by size. After Bentley, Saxe: Decomposable searching problems I: static-to-dynamic
// transformation, 1980.
//
// Cost: a box changes its tree when the new one is more than one and a half times as large, or when half of its tree's
// boxes are removed, so an inserted box takes part in O(log n) builds.
#include "broadphase/bvh_forest.h"

#include "broadphase/bvh_build_order.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

//  ---- lanes -----------------------------------------------------------------------------------------

static void SetLane(qcOctet* octet, uint32_t lane, const qcFloatBox* box)
{
    for (int k = 0; k < 3; k++)
    {
        octet->lower[k][lane] = box->lower[k];
        octet->upper[k][lane] = box->upper[k];
    }
}

static void ClearLane(qcOctet* octet, uint32_t lane)
{
    SetLane(octet, lane, &(qcFloatBox){{NAN, NAN, NAN}, {NAN, NAN, NAN}});
}

static void Append(qcForest* forest, uint32_t id, const qcFloatBox* box)
{
    uint32_t at = (uint32_t)forest->listIds.count++, lane = at % qc_lanes;
    qcOctet* octet = &QC_AT(qcOctet, forest->listOctets, at / qc_lanes);
    for (uint32_t i = 0; lane == 0 && i < qc_lanes; i++)
        ClearLane(octet, i);
    SetLane(octet, lane, box);
    QC_AT(uint32_t, forest->listIds, at) = id;
    qcLeafPosition* position = &QC_AT(qcLeafPosition, forest->positions, id);
    position->tree = qc_inList;
    position->lane = at;
}

/// Removes a box from the list; the last box takes its position.
static void RemoveFromList(qcForest* forest, uint32_t at)
{
    uint32_t last = (uint32_t)--forest->listIds.count, moved = QC_AT(uint32_t, forest->listIds, last);
    SetLane(&QC_AT(qcOctet, forest->listOctets, at / qc_lanes), at % qc_lanes,
            &QC_AT(qcFloatBox, forest->boxes, moved));
    QC_AT(uint32_t, forest->listIds, at) = moved;
    QC_AT(qcLeafPosition, forest->positions, moved).lane = at;
    ClearLane(&QC_AT(qcOctet, forest->listOctets, last / qc_lanes), last % qc_lanes);
}

static void DropTrees(qcForest* forest, uint64_t trees)
{
    forest->staticTrees &= ~trees;
    forest->dynamicTrees &= ~trees;
}

static void RemoveFromTree(qcForest* forest, uint32_t id)
{
    qcLeafPosition position = QC_AT(qcLeafPosition, forest->positions, id);
    if (position.tree == qc_inList)
    {
        RemoveFromList(forest, position.lane);
        return;
    }
    qcBoxTree* tree = &forest->trees[position.tree];
    ClearLane(&QC_AT(qcOctet, tree->octets, position.lane / qc_lanes), position.lane % qc_lanes);
    QC_AT(uint32_t, tree->ids, position.lane) = QC_NO_BOX;
    if (--tree->boxCount == 0)
        DropTrees(forest, (uint64_t)1 << position.tree);
}

//  ---- trees -----------------------------------------------------------------------------------------

/// The trees and the list that a new tree is built of.
typedef struct Sources
{
    uint64_t trees;
    bool list;
    size_t boxCount;
} Sources;

static void AddSource(const qcForest* forest, Sources* sources, uint32_t tree)
{
    sources->trees |= (uint64_t)1 << tree;
    sources->boxCount += forest->trees[tree].boxCount;
}

static qcStatus CollectItems(qcForest* forest, const Sources* sources)
{
    QC_TRY(qcArray_Reserve(&forest->items, sources->boxCount, sizeof(qcBoxItem), "boxes in order"));
    qcBoxItem* items = forest->items.data;
    size_t count = 0;
    for (uint64_t trees = sources->trees; trees != 0;)
    {
        const qcBoxTree* tree = &forest->trees[qcForest_NextTree(&trees)];
        for (uint32_t lane = 0; lane < tree->laneCount; lane++)
        {
            uint32_t id = QC_AT(uint32_t, tree->ids, lane);
            uint32_t later =
                lane + qc_fetchAhead < tree->laneCount ? QC_AT(uint32_t, tree->ids, lane + qc_fetchAhead) : QC_NO_BOX;
            if (later != QC_NO_BOX)
                __builtin_prefetch(&QC_AT(qcFloatBox, forest->boxes, later));
            if (id != QC_NO_BOX)
                items[count++] = qcBoxItem_Make(&QC_AT(qcFloatBox, forest->boxes, id), id);
        }
    }
    for (size_t i = 0; sources->list && i < forest->listIds.count; i++)
    {
        uint32_t id = QC_AT(uint32_t, forest->listIds, i);
        items[count++] = qcBoxItem_Make(&QC_AT(qcFloatBox, forest->boxes, id), id);
    }
    return qc_statusOk;
}

/// Sets the first octet of each level for a tree over `boxCount` boxes; returns the number of octets.
static size_t LayOut(qcOctetTree* shape, size_t boxCount)
{
    size_t octets = 0, level = boxCount;
    shape->levelCount = 0;
    do
    {
        level = (level + qc_lanes - 1) / qc_lanes;
        shape->first[shape->levelCount++] = (uint32_t)octets;
        octets += level;
    } while (level > 1);
    return octets;
}

/// Whether source `number` can hold the new tree without growing. A source must not grow: if that fails, the source is
/// still needed.
static bool HasRoom(const qcForest* forest, const Sources* sources, uint32_t number, size_t octets)
{
    const qcBoxTree* tree = &forest->trees[number];
    return tree->octets.capacity >= octets * sizeof(qcOctet) &&
           tree->ids.capacity >= (sources->boxCount + qc_lanes) * sizeof(uint32_t) &&
           tree->tight.capacity >= sources->boxCount / qc_lanes + 1;
}

/// The unused tree whose capacity fits best, or else the one with the largest capacity; qc_inNoTree: all are in use.
static uint32_t FindUnusedTree(const qcForest* forest, const Sources* sources, size_t octets)
{
    uint32_t best = qc_inNoTree;
    uint64_t used = forest->staticTrees | forest->dynamicTrees, unallocated = ~(forest->allocatedTrees | used);
    size_t needed = octets * sizeof(qcOctet);
    for (uint64_t trees = (forest->allocatedTrees & ~used) | sources->trees; trees != 0;)
    {
        uint32_t t = qcForest_NextTree(&trees);
        if ((used >> t & 1) != 0 && !HasRoom(forest, sources, t, octets))
            continue;
        size_t room = forest->trees[t].octets.capacity;
        size_t bestRoom = best != qc_inNoTree ? forest->trees[best].octets.capacity : 0;
        bool better = bestRoom >= needed ? room >= needed && room < bestRoom : room > bestRoom;
        if (best == qc_inNoTree || better)
            best = t;
    }
    return best == qc_inNoTree && unallocated != 0 ? qcForest_NextTree(&unallocated) : best;
}

/// Fills a level: each lane bounds one octet of the level below.
static void FillLevel(qcOctet* level, const qcOctet* below, size_t belowCount)
{
    for (size_t i = 0; i < belowCount; i++)
    {
        uint32_t lane = i % qc_lanes;
        for (uint32_t j = 0; lane == 0 && j < qc_lanes; j++)
            ClearLane(&level[i / qc_lanes], j);
        qcFloatBox around = qcOctet_Around(&below[i]);
        SetLane(&level[i / qc_lanes], lane, &around);
    }
}

static void FillTree(qcForest* forest, uint32_t number, size_t count)
{
    qcBoxTree* tree = &forest->trees[number];
    const qcBoxItem* items = forest->items.data;
    qcOctet* octets = tree->octets.data;
    size_t leaves = (count + qc_lanes - 1) / qc_lanes;
    uint8_t* tight = tree->tight.data;
    memset(tight, 0, leaves);
    for (size_t i = 0; i < leaves * qc_lanes; i++)
    {
        uint32_t id = i < count ? items[i].id : QC_NO_BOX;
        if (i + qc_fetchAhead < count)
        {
            __builtin_prefetch(&QC_AT(qcFloatBox, forest->boxes, items[i + qc_fetchAhead].id));
            __builtin_prefetch(&QC_AT(qcLeafPosition, forest->positions, items[i + qc_fetchAhead].id), 1);
        }
        QC_AT(uint32_t, tree->ids, i) = id;
        if (id == QC_NO_BOX)
        {
            ClearLane(&octets[i / qc_lanes], i % qc_lanes);
            continue;
        }
        qcLeafPosition* position = &QC_AT(qcLeafPosition, forest->positions, id);
        SetLane(&octets[i / qc_lanes], i % qc_lanes, &QC_AT(qcFloatBox, forest->boxes, id));
        position->tree = (uint8_t)number;
        position->lane = (uint32_t)i;
        tight[i / qc_lanes] |= (uint8_t)(position->tight << i % qc_lanes);
    }
    for (uint32_t level = 1; level < tree->shape.levelCount; level++)
        FillLevel(octets + tree->shape.first[level], octets + tree->shape.first[level - 1],
                  tree->shape.first[level] - tree->shape.first[level - 1]);
    tree->laneCount = (uint32_t)(leaves * qc_lanes);
    tree->boxCount = (uint32_t)count;
    tree->shape.octets = octets;
}

/// Builds one tree of the sources, which are dropped. On failure nothing changes.
static qcStatus BuildTree(qcForest* forest, const Sources* sources, bool dynamic, uint32_t* number)
{
    qcOctetTree shape;
    size_t octets = LayOut(&shape, sources->boxCount);
    QC_TRY(CollectItems(forest, sources));
    *number = FindUnusedTree(forest, sources, octets);
    if (*number == qc_inNoTree)
        return qcFailMemory(SIZE_MAX, "trees of boxes that could not be merged");
    qcBoxTree* tree = &forest->trees[*number];
    forest->allocatedTrees |= (uint64_t)1 << *number;
    QC_TRY(qcArray_Reserve(&tree->octets, octets, sizeof(qcOctet), "a tree of boxes"));
    QC_TRY(qcArray_Reserve(&tree->ids, sources->boxCount + qc_lanes, sizeof(uint32_t), "ids in a tree of boxes"));
    QC_TRY(qcArray_Reserve(&tree->tight, sources->boxCount / qc_lanes + 1, 1, "tight boxes in a tree"));
    DropTrees(forest, sources->trees);
    if (sources->list)
        forest->listIds.count = 0;
    qcBuildOrder_Arrange(forest->items.data, sources->boxCount, forest->boxes.data);
    tree->shape = shape;
    *(dynamic ? &forest->dynamicTrees : &forest->staticTrees) |= (uint64_t)1 << *number;
    FillTree(forest, *number, sources->boxCount);
    forest->sortedCount += sources->boxCount;
    return qc_statusOk;
}

/// Adds trees to the sources until each remaining tree has more than twice as many lanes as the sources have boxes.
/// With `halfEmpty`, trees that lost half of their boxes are added too.
static void AddSmallTrees(const qcForest* forest, Sources* sources, uint64_t trees, bool halfEmpty)
{
    for (bool more = true; more;)
    {
        more = false;
        for (uint64_t rest = trees & ~sources->trees; rest != 0;)
        {
            uint32_t t = qcForest_NextTree(&rest);
            const qcBoxTree* tree = &forest->trees[t];
            if (tree->laneCount > 2 * sources->boxCount && !(halfEmpty && tree->boxCount < tree->laneCount / 2))
                continue;
            AddSource(forest, sources, t);
            more = true;
        }
    }
}

/// Builds a tree of the list when it is long: a query visits all of the list.
static void ShortenList(qcForest* forest)
{
    size_t length = forest->listIds.count;
    if (length < 128 || length < forest->boxCount / 8)
        return;
    Sources sources = {.list = true, .boxCount = length};
    AddSmallTrees(forest, &sources, forest->dynamicTrees, false);
    uint32_t number;
    // If memory runs out, the list stays as it is.
    (void)BuildTree(forest, &sources, true, &number);
}

//  ---- the forest ------------------------------------------------------------------------------------

qcStatus qcForest_Reserve(qcForest* forest, size_t idCount)
{
    size_t previous = forest->positions.count;
    if (forest->kernels == NULL)
        forest->kernels = qcBoxKernels_Get();
    if (idCount <= previous)
        return qc_statusOk;
    QC_TRY(qcArray_Reserve(&forest->boxes, idCount, sizeof(qcFloatBox), "boxes in floats"));
    QC_TRY(qcArray_Reserve(&forest->listOctets, idCount / qc_lanes + 1, sizeof(qcOctet), "new boxes"));
    QC_TRY(qcArray_Reserve(&forest->listIds, idCount, sizeof(uint32_t), "ids of new boxes"));
    QC_TRY(qcArray_Resize(&forest->positions, idCount, sizeof(qcLeafPosition), "leaf positions of boxes"));
    forest->boxes.count = idCount;
    forest->listOctets.count = idCount / qc_lanes + 1;
    for (size_t id = previous; id < idCount; id++)
        QC_AT(qcLeafPosition, forest->positions, id).tree = qc_inNoTree;
    return qc_statusOk;
}

static void FreeTrees(qcForest* forest)
{
    for (uint32_t t = 0; t < qc_forestTrees; t++)
    {
        qcArray_Free(&forest->trees[t].octets);
        qcArray_Free(&forest->trees[t].ids);
        qcArray_Free(&forest->trees[t].tight);
    }
    forest->allocatedTrees = 0;
}

void qcForest_Clear(qcForest* forest)
{
    DropTrees(forest, UINT64_MAX);
    // Which tree is built next depends on the memory that trees have, and the order of pairs on it.
    FreeTrees(forest);
    forest->positions.count = 0;
    forest->listIds.count = 0;
    forest->boxCount = 0;
}

void qcForest_Free(qcForest* forest)
{
    FreeTrees(forest);
    qcArray_Free(&forest->boxes);
    qcArray_Free(&forest->positions);
    qcArray_Free(&forest->listOctets);
    qcArray_Free(&forest->listIds);
    qcArray_Free(&forest->items);
    *forest = (qcForest){.kernels = forest->kernels};
}

void qcForest_Insert(qcForest* forest, uint32_t id, const qcFloatBox* box, bool tight)
{
    qcLeafPosition* position = &QC_AT(qcLeafPosition, forest->positions, id);
    position->tight = tight;
    QC_AT(qcFloatBox, forest->boxes, id) = *box;
    if (position->tree == qc_inList)
    {
        SetLane(&QC_AT(qcOctet, forest->listOctets, position->lane / qc_lanes), position->lane % qc_lanes, box);
        return;
    }
    if (position->tree == qc_inNoTree)
        forest->boxCount++;
    else
        RemoveFromTree(forest, id);
    Append(forest, id, box);
    ShortenList(forest);
}

void qcForest_Remove(qcForest* forest, uint32_t id)
{
    RemoveFromTree(forest, id);
    QC_AT(qcLeafPosition, forest->positions, id).tree = qc_inNoTree;
    forest->boxCount--;
}

qcStatus qcForest_MergeDynamic(qcForest* forest, uint32_t* tree)
{
    Sources sources = {.list = true, .boxCount = forest->listIds.count};
    *tree = qc_inNoTree;
    for (uint64_t trees = forest->dynamicTrees; trees != 0;)
    {
        *tree = qcForest_NextTree(&trees);
        AddSource(forest, &sources, *tree);
    }
    bool one = (forest->dynamicTrees & (forest->dynamicTrees - 1)) == 0;
    return one && forest->listIds.count == 0 ? qc_statusOk : BuildTree(forest, &sources, true, tree);
}

void qcForest_Promote(qcForest* forest)
{
    Sources sources = {.list = forest->listIds.count != 0, .boxCount = forest->listIds.count};
    if (forest->dynamicTrees == 0 && !sources.list)
        return;
    for (uint64_t trees = forest->dynamicTrees; trees != 0;)
        AddSource(forest, &sources, qcForest_NextTree(&trees));
    forest->staticTrees |= forest->dynamicTrees;
    forest->dynamicTrees = 0;
    AddSmallTrees(forest, &sources, forest->staticTrees, true);
    uint32_t number;
    if (sources.list || (sources.trees & (sources.trees - 1)) != 0)
        (void)BuildTree(forest, &sources, false, &number);
}

void qcForest_Demote(qcForest* forest)
{
    forest->dynamicTrees |= forest->staticTrees;
    forest->staticTrees = 0;
}
