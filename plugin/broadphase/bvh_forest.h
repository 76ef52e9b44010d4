// A BVH with insertion and removal: a few complete 8-ary trees, each more than twice as large as the next. A tree is
// never refitted; removal clears a lane. Inserted boxes gather in a list, which is built into a tree together with the
// trees that are not much larger. After Bentley, Saxe: Decomposable searching problems I, 1980.
//
// Boxes that stay end up in the largest tree and are not touched again; boxes that move often share small trees.
#ifndef QC_BROADPHASE_BVH_FOREST_H
#define QC_BROADPHASE_BVH_FOREST_H

#include "broadphase/box_kernels.h"
#include "base/memory.h"

#define QC_NO_BOX UINT32_MAX

enum
{
    // Among the static trees each has more than twice the lanes of the next, and so among the dynamic ones: at most 31
    // of each, unless memory ran out when they were to be merged.
    qc_forestTrees = 64
};

typedef struct qcBoxTree
{
    qcArray octets; ///< qcOctet
    qcArray ids;    ///< uint32_t, by lane of level 0, or QC_NO_BOX
    qcArray tight;  ///< uint8_t, by octet of level 0: a bit for each lane with a tight box
    qcOctetTree shape;
    uint32_t laneCount; ///< lanes of level 0
    uint32_t boxCount;  ///< boxes not removed since it was built
} qcBoxTree;

typedef struct qcLeafPosition
{
    uint8_t tree;  ///< or qc_inList, qc_inNoTree
    bool tight;    ///< of the box in the forest
    uint32_t lane; ///< of level 0, or index in the list
} qcLeafPosition;

enum
{
    qc_inList = qc_forestTrees,
    qc_inNoTree
};

/// All zero is an empty forest without kernels. Dynamic boxes are those inserted since the last qcForest_Promote, in
/// the list or in a dynamic tree; all others are static.
typedef struct qcForest
{
    const qcBoxKernels* kernels;
    qcBoxTree trees[qc_forestTrees];
    uint64_t staticTrees, dynamicTrees; ///< a bit for each tree in use
    uint64_t allocatedTrees;            ///< a bit for each tree that has memory, in use or not
    qcArray boxes;                      ///< qcFloatBox, by id
    qcArray positions;                  ///< qcLeafPosition, by id
    qcArray listOctets;                 ///< qcOctet; listIds.count of their lanes are filled
    qcArray listIds;                    ///< uint32_t
    qcArray items;                      ///< qcBoxItem, scratch
    uint32_t boxCount;
    size_t sortedCount; ///< boxes of all tree builds since the last search, added up
} qcForest;

/// Makes room for ids below `idCount`; inserting and removing these cannot fail.
qcStatus qcForest_Reserve(qcForest* forest, size_t idCount);
/// Removes all boxes and frees the trees, so that those built afterwards are the ones that a new forest would have.
void qcForest_Clear(qcForest* forest);
void qcForest_Free(qcForest* forest);

/// Inserts a box, or replaces it. lower <= upper, infinities allowed. `tight`: it is the caller's box itself, not one
/// around it. The box is dynamic until qcForest_Promote.
void qcForest_Insert(qcForest* forest, uint32_t id, const qcFloatBox* box, bool tight);
void qcForest_Remove(qcForest* forest, uint32_t id);

/// Merges all dynamic boxes into one tree; `*tree` is its number, or qc_inNoTree if there are none.
qcStatus qcForest_MergeDynamic(qcForest* forest, uint32_t* tree);
/// Makes all boxes static, merging dynamic trees with static ones that are not much larger. If memory runs out, trees
/// stay unmerged and boxes of the list stay there, dynamic.
void qcForest_Promote(qcForest* forest);
/// Makes all boxes dynamic.
void qcForest_Demote(qcForest* forest);

/// Whether a box of the forest was inserted since qcForest_Promote.
static inline bool qcForest_IsDynamic(const qcForest* forest, uint32_t id)
{
    uint32_t tree = QC_AT(qcLeafPosition, forest->positions, id).tree;
    return tree == qc_inList || (forest->dynamicTrees >> tree & 1) != 0;
}

/// Removes the lowest tree from a nonempty set of bits, and returns it.
static inline uint32_t qcForest_NextTree(uint64_t* trees)
{
    uint32_t tree = (uint32_t)__builtin_ctzll(*trees);
    *trees &= *trees - 1;
    return tree;
}

/// Makes the smallest box of floats that contains a box. Returns whether it equals the box.
static inline bool qcFloatBox_Enclose(qcFloatBox* box, const double lower[3], const double upper[3])
{
    bool around = true, inside = true;
    for (int k = 0; k < 3; k++)
    {
        box->lower[k] = (float)lower[k];
        box->upper[k] = (float)upper[k];
        around = around & ((double)box->lower[k] <= lower[k]) & ((double)box->upper[k] >= upper[k]);
        inside = inside & ((double)box->lower[k] >= lower[k]) & ((double)box->upper[k] <= upper[k]);
    }
    // The cast rounds to nearest; a bound that moved inwards takes one step outwards. A double beyond all floats
    // becomes infinite.
    for (int k = 0; k < 3 && !around; k++)
    {
        if ((double)box->lower[k] > lower[k])
            box->lower[k] = nextafterf(box->lower[k], -INFINITY);
        if ((double)box->upper[k] < upper[k])
            box->upper[k] = nextafterf(box->upper[k], INFINITY);
    }
    return around & inside;
}

#endif
