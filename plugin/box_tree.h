// A dynamic tree of axis-aligned boxes: nodes in one pool, bounded height, no allocation while it changes.
// After Bittner, Hapala, Havran: Fast insertion-based optimization of BVHs, 2013; Catto: Dynamic BVHs, GDC 2019.
#ifndef QC_PLUGIN_BOX_TREE_H
#define QC_PLUGIN_BOX_TREE_H

#include "memory.h"

#define QC_NO_NODE UINT32_MAX

static inline double qcLower(double a, double b)
{
    return a < b ? a : b;
}

static inline double qcUpper(double a, double b)
{
    return a > b ? a : b;
}

static inline bool qcBounds_Contain(const double lower[3], const double upper[3], const double innerLower[3],
                                    const double innerUpper[3])
{
    bool inside = true;
    for (int k = 0; k < 3; k++)
        inside = inside && lower[k] <= innerLower[k] && innerUpper[k] <= upper[k];
    return inside;
}

enum
{
    /// Heights of siblings differ by this much at most. More lets big boxes stay near the root, less bounds the height.
    qc_treeSlack = 4,
    /// Room for a depth-first walk that holds one node a level. A tree of height h has at least N(h) leaves, where
    /// N(h) = N(h - 1) + N(h - 1 - qc_treeSlack), N(h <= qc_treeSlack) = h + 1: 2^31 leaves are reached at height 75.
    qc_treeStack = 96
};

/// One cache line.
typedef struct qcTreeNode
{
    double lower[3], upper[3];
    uint32_t parent;   ///< a free node: the next free one
    uint32_t child[2]; ///< a leaf: its id, and QC_NO_NODE
    uint32_t height;   ///< 0: a leaf
} qcTreeNode;

/// All zero is not an empty tree: call qcBoxTree_Clear first.
typedef struct qcBoxTree
{
    qcArray nodes;
    uint32_t root, firstFree;
} qcBoxTree;

/// Makes room for `leafCount` leaves in all; inserting up to that many cannot fail.
qcStatus qcBoxTree_Reserve(qcBoxTree* tree, uint32_t leafCount);
/// Empties the tree, keeps the memory.
void qcBoxTree_Clear(qcBoxTree* tree);
void qcBoxTree_Free(qcBoxTree* tree);

/// Adds a leaf and returns its node, which stays the leaf's until it is removed. O(log n).
/// lower <= upper; infinities allowed.
uint32_t qcBoxTree_Insert(qcBoxTree* tree, const double lower[3], const double upper[3], uint32_t id);
void qcBoxTree_Remove(qcBoxTree* tree, uint32_t leaf);
void qcBoxTree_Move(qcBoxTree* tree, uint32_t leaf, const double lower[3], const double upper[3]);

static inline const qcTreeNode* qcBoxTree_Node(const qcBoxTree* tree, uint32_t node)
{
    return &QC_AT(qcTreeNode, tree->nodes, node);
}

#endif
