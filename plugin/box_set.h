// A set of boxes from the inside: what boxes.c keeps up to date, box_pairs.c and box_queries.c read.
#ifndef QC_PLUGIN_BOX_SET_H
#define QC_PLUGIN_BOX_SET_H

#include "quickcullide/boxes.h"

#include "box_forest.h"
#include "box_neighbours.h"
#include "memory.h"

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

/// What is looked at for each pair: half a cache line.
typedef struct qcBox
{
    float lower[3]; ///< these and the upper ones: a box of floats around the box
    uint32_t mover; ///< place in the list of moved boxes, or QC_NO_MOVER
    float upper[3];
    bool alive; ///< otherwise the id is free
    bool young; ///< was put into the forest since the last search
    bool still; ///< has not moved since it was added; the forest holds the box itself, not a larger one
    bool exact; ///< the floats are the box; otherwise see qcBoxes.bounds
} qcBox;

/// A box that was added or moved since the last search for pairs.
typedef struct qcMover
{
    uint32_t id;
    bool added;
    qcBounds before; ///< at the last search, if it was there
} qcMover;

struct qcBoxes
{
    /// A box that contains each box, so that a box that moves a little changes nothing here. Where it does, the box is
    /// young there, and its neighbours are not known.
    qcForest forest;
    /// All pairs of boxes of the forest that meet, but those of two still boxes and those of young ones. The mark: the
    /// boxes themselves met at the last search.
    qcNeighbours neighbours;
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

static inline qcBounds qcBoxes_Bounds(const qcBoxes* set, uint32_t id)
{
    const qcBox* box = qcBoxes_Box(set, id);
    if (!box->exact)
        return QC_AT(qcBounds, set->bounds, id);
    return (qcBounds){{(double)box->lower[0], (double)box->lower[1], (double)box->lower[2]},
                      {(double)box->upper[0], (double)box->upper[1], (double)box->upper[2]}};
}

/// Whether two boxes overlap now.
static inline bool qcBoxes_Meet(const qcBoxes* set, uint32_t a, uint32_t b)
{
    const qcBox *x = qcBoxes_Box(set, a), *y = qcBoxes_Box(set, b);
    bool meet = (x->lower[0] <= y->upper[0]) & (x->upper[0] >= y->lower[0]) & (x->lower[1] <= y->upper[1]) &
                (x->upper[1] >= y->lower[1]) & (x->lower[2] <= y->upper[2]) & (x->upper[2] >= y->lower[2]);
    if (!meet || (x->exact & y->exact))
        return meet;
    qcBounds boundsA = qcBoxes_Bounds(set, a), boundsB = qcBoxes_Bounds(set, b);
    return qcBounds_Meet(&boundsA, &boundsB);
}

/// Whether two boxes overlapped at the last search.
bool qcBoxes_Met(const qcBoxes* set, uint32_t a, uint32_t b);

/// A box begins to move: keeps its pairs with boxes that are still.
void qcBoxes_KeepStillPairs(qcBoxes* set, uint32_t id);

#endif
