// A set of boxes from the inside: what boxes.c keeps up to date, broadphase/overlap_pairs.c and broadphase/queries.c
// read.
#ifndef QC_BROADPHASE_BOX_SET_H
#define QC_BROADPHASE_BOX_SET_H

#include "quickcullide/boxes.h"

#include "broadphase/bvh_forest.h"
#include "broadphase/overlap_graph.h"
#include "base/memory.h"

#define QC_NO_MOVER UINT32_MAX

static inline double qcLower(double a, double b)
{
    return a < b ? a : b;
}

static inline double qcUpper(double a, double b)
{
    return a > b ? a : b;
}

typedef struct qcBounds
{
    double lower[3], upper[3];
} qcBounds;

/// In the forest.
typedef enum qcBoxState
{
    qc_boxInTree,     ///< since the last search or longer
    qc_boxPairsKnown, ///< put there since, and has found its neighbours
    qc_boxPairsStale  ///< put there since, and has not
} qcBoxState;

/// What is looked at for each pair: half a cache line.
typedef struct qcBox
{
    float lower[3]; ///< these and the upper ones: a box of floats around the box
    uint32_t mover; ///< place in the list of moved boxes, or QC_NO_MOVER
    float upper[3];
    bool alive; ///< otherwise the id is free
    uint8_t at; ///< qcBoxState
    bool still; ///< has not moved since it was added; the forest holds the box itself, not a larger one
    bool exact; ///< the floats are the box; otherwise see qcBoxes.bounds
} qcBox;

/// A box that was added or moved since the last search for pairs.
typedef struct qcMover
{
    uint32_t id;
    bool added;
    //  At the last search, if it was there.
    qcBox box;
    qcBounds bounds; ///< where floats are not exact
} qcMover;

struct qcBoxes
{
    /// A box that contains each box, so that a box that moves a little changes nothing here. Where it does, the box is
    /// young there.
    qcForest forest;
    /// All pairs of boxes of the forest that meet, but those of two still boxes and those of lost ones; and pairs that
    /// no longer do, of young ones. The mark: the boxes themselves met at the last search.
    qcOverlapGraph neighbours;
    qcArray boxes;                 ///< qcBox, by id
    qcArray bounds;                ///< qcBounds, by id, where floats are not exact
    qcArray userData;              ///< void*, by id
    qcArray freeIds;               ///< uint32_t, a heap with the lowest id on top
    qcArray movers;                ///< qcMover
    qcArray hits;                  ///< qcOctetHit
    qcArray stamps;                ///< uint32_t, by id
    uint32_t stamp;                ///< the last one that was used
    qcArray began, ended, scratch; ///< qcSortItem
    qcArray pairs;                 ///< qcBoxPair
    qcBoxProfile profile;          ///< of the last search
    uint32_t putCount, lostCount;  ///< boxes that are not qc_boxInTree; that are qc_boxPairsStale
    bool forgotten;                ///< a search failed: what was known of the last one is lost
};

static inline bool qcBounds_Meet(const qcBounds* a, const qcBounds* b)
{
    // One branch instead of six: which one turns a pair away is as good as random.
    return (a->lower[0] <= b->upper[0]) & (a->upper[0] >= b->lower[0]) & (a->lower[1] <= b->upper[1]) &
           (a->upper[1] >= b->lower[1]) & (a->lower[2] <= b->upper[2]) & (a->upper[2] >= b->lower[2]);
}

static inline qcBox* qcBoxes_Box(const qcBoxes* set, uint32_t id)
{
    return &QC_AT(qcBox, set->boxes, id);
}

/// If its floats are exact.
static inline qcBounds qcBox_Bounds(const qcBox* box)
{
    return (qcBounds){{(double)box->lower[0], (double)box->lower[1], (double)box->lower[2]},
                      {(double)box->upper[0], (double)box->upper[1], (double)box->upper[2]}};
}

static inline qcBounds qcBoxes_Bounds(const qcBoxes* set, uint32_t id)
{
    const qcBox* box = qcBoxes_Box(set, id);
    return box->exact ? qcBox_Bounds(box) : QC_AT(qcBounds, set->bounds, id);
}

static inline bool qcBox_MeetsFloats(const qcBox* a, const float lower[3], const float upper[3])
{
    return (a->lower[0] <= upper[0]) & (a->upper[0] >= lower[0]) & (a->lower[1] <= upper[1]) &
           (a->upper[1] >= lower[1]) & (a->lower[2] <= upper[2]) & (a->upper[2] >= lower[2]);
}

/// Bounds are looked at only where floats are not exact.
static inline bool qcBox_Meet(const qcBox* a, const qcBounds* boundsA, const qcBox* b, const qcBounds* boundsB)
{
    bool meet = qcBox_MeetsFloats(a, b->lower, b->upper);
    // First what can be foreseen: whether they meet cannot.
    if (a->exact & b->exact)
        return meet;
    if (!meet)
        return false;
    qcBounds x = a->exact ? qcBox_Bounds(a) : *boundsA, y = b->exact ? qcBox_Bounds(b) : *boundsB;
    return qcBounds_Meet(&x, &y);
}

/// Whether two boxes overlap now.
static inline bool qcBoxes_Meet(const qcBoxes* set, uint32_t a, uint32_t b)
{
    const qcBounds* bounds = set->bounds.data;
    return qcBox_Meet(qcBoxes_Box(set, a), &bounds[a], qcBoxes_Box(set, b), &bounds[b]);
}

/// Whether two boxes overlapped at the last search.
bool qcBoxes_Met(const qcBoxes* set, uint32_t a, uint32_t b);

/// Marks the neighbours that are kept of a box: their stamps are what is returned.
uint32_t qcBoxes_StampNeighbours(qcBoxes* set, uint32_t id);

/// Looks for the neighbours of a box that is qc_boxPairsStale before the search does. It stays lost if it is still, or
/// if there is no memory.
void qcBoxes_Settle(qcBoxes* set, uint32_t id);

/// A box begins to move: keeps its pairs with boxes that are still.
void qcBoxes_KeepStillPairs(qcBoxes* set, uint32_t id);

#endif
