// A set of boxes from the inside: what boxes.c keeps up to date, box_pairs.c and box_queries.c read.
#ifndef QC_PLUGIN_BOX_SET_H
#define QC_PLUGIN_BOX_SET_H

#include "quickcullide/boxes.h"

#include "box_neighbours.h"
#include "box_tree.h"
#include "memory.h"

typedef struct qcBox
{
    double lower[3], upper[3];
    uint32_t leaf;  ///< a node that contains the box; QC_NO_NODE: the id is free
    uint32_t mover; ///< place in the list of moved boxes, or QC_NO_NODE
    bool restless;  ///< a mover whose leaf is new or changed: its neighbours are not known
    bool still;     ///< has not moved since it was added; its leaf is the box itself
} qcBox;

struct qcBoxes
{
    qcBoxTree tree;
    qcNeighbours neighbours; ///< all pairs of leaves that meet, but those of two still boxes and those of restless ones
    qcArray boxes;           ///< qcBox, by id
    qcArray userData;        ///< void*, by id
    qcArray freeIds;         ///< uint32_t, a heap with the lowest id on top
    qcArray movers;          ///< uint32_t, ids added or moved since the last search for pairs
    qcArray flags;           ///< uint8_t, by node; all zero between two searches
    qcArray found, scratch;  ///< qcSortItem
    qcArray pairs;           ///< qcBoxPair
};

/// Closed boxes; a NaN counts as unbounded.
static inline bool qcBounds_Meet(const double lowerA[3], const double upperA[3], const double lowerB[3],
                                 const double upperB[3])
{
    // One branch instead of six: which one turns a pair away is as good as random.
    return !((lowerA[0] > upperB[0]) | (upperA[0] < lowerB[0]) | (lowerA[1] > upperB[1]) | (upperA[1] < lowerB[1]) |
             (lowerA[2] > upperB[2]) | (upperA[2] < lowerB[2]));
}

#endif
