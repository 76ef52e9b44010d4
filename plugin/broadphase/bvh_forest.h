// A set of boxes that is asked often and changes a little: a few complete trees of eight, each more than twice as large
// as the next, that are never changed but for boxes taken out. What is put in gathers in a list, which becomes a tree
// together with the trees that are not much larger. After Bentley, Saxe: Decomposable searching problems I, 1980.
//
// Boxes that stay end up in the largest tree and are not looked at again; those that move a lot share small ones.
#ifndef QC_BROADPHASE_BVH_FOREST_H
#define QC_BROADPHASE_BVH_FOREST_H

#include "broadphase/box_kernels.h"
#include "base/memory.h"

#define QC_NO_BOX UINT32_MAX

enum
{
    // Among the old trees each has more than twice the room of the next, and so among the young: 31 of either at most,
    // unless there was no memory to join them.
    qc_forestTrees = 64
};

typedef struct qcBoxTree
{
    qcArray octets; ///< qcOctet
    qcArray ids;    ///< uint32_t, by lane of level 0, or QC_NO_BOX
    qcOctetTree shape;
    uint32_t laneCount; ///< of level 0, when it was made
    uint32_t boxCount;  ///< that are left
} qcBoxTree;

typedef struct qcBoxPlace
{
    uint32_t tree; ///< or one of the following
    uint32_t lane;
} qcBoxPlace;

enum
{
    qc_inList = qc_forestTrees,
    qc_inNoTree
};

/// All zero is an empty forest without kernels.
typedef struct qcForest
{
    const qcBoxKernels* kernels;
    qcBoxTree trees[qc_forestTrees];
    uint64_t old, young; ///< a bit for each tree there is; young: its boxes were put in since qcForest_Age
    uint64_t roomy;      ///< a bit for each tree that there was: others have no memory
    qcArray boxes;       ///< qcFloatBox, by id
    qcArray places;      ///< qcBoxPlace, by id
    qcArray listOctets;  ///< qcOctet; their count is that of boxes in the list
    qcArray listIds;     ///< uint32_t
    qcArray items;       ///< qcBoxItem
    uint32_t boxCount;
    size_t sortedCount; ///< boxes that trees were made of, in all
} qcForest;

/// Makes room for ids below `idCount`; taking boxes in and out, up to that many, cannot fail.
qcStatus qcForest_Reserve(qcForest* forest, size_t idCount);
/// Empties the forest, keeps the memory.
void qcForest_Clear(qcForest* forest);
void qcForest_Free(qcForest* forest);

/// Puts a box in, or another one in its place. lower <= upper, infinities allowed. It is young until qcForest_Age.
void qcForest_Put(qcForest* forest, uint32_t id, const qcFloatBox* box);
void qcForest_Remove(qcForest* forest, uint32_t id);

/// Brings all young boxes into one tree; `*tree` is its number, or qc_inNoTree if there are none.
qcStatus qcForest_GatherYoung(qcForest* forest, uint32_t* tree);
/// All boxes are old now, in trees that are joined with those that are not much larger. Without memory they stay apart,
/// and what is in the list stays there, young.
void qcForest_Age(qcForest* forest);
/// Makes all boxes young.
void qcForest_Rejuvenate(qcForest* forest);

/// Whether a box that is in the forest was put there since qcForest_Age.
static inline bool qcForest_IsYoung(const qcForest* forest, uint32_t id)
{
    uint32_t tree = QC_AT(qcBoxPlace, forest->places, id).tree;
    return tree == qc_inList || (forest->young >> tree & 1) != 0;
}

/// Takes the lowest of some trees, given as bits; there is one.
static inline uint32_t qcForest_NextTree(uint64_t* trees)
{
    uint32_t tree = (uint32_t)__builtin_ctzll(*trees);
    *trees &= *trees - 1;
    return tree;
}

/// Makes the smallest box of floats around a box. Returns whether it is the box itself.
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
    // To the nearest, then outwards if that was inwards. A double beyond all floats becomes infinite.
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
