// Internals of a set of boxes: the state that boxes.c maintains and the searches and queries read.
#ifndef QC_BROADPHASE_BOX_SET_H
#define QC_BROADPHASE_BOX_SET_H

#include "quickcullide/boxes.h"

#include "base/memory.h"
#include "broadphase/box_origin.h"
#include "broadphase/bvh_forest.h"
#include "broadphase/overlap_graph.h"

#define QC_NOT_MOVED UINT32_MAX

/// State of a box in the BVH forest.
typedef enum qcBoxState
{
    qc_boxInTree,     ///< unchanged since the last search
    qc_boxPairsKnown, ///< inserted since; its overlaps are in the graph
    qc_boxPairsStale  ///< inserted since; its overlaps are unknown
} qcBoxState;

/// The data read for each tested pair: half a cache line.
typedef struct qcBox
{
    float lower[3];      ///< with `upper`: a box of floats that contains the box minus the origin
    uint32_t movedIndex; ///< index in the list of moved boxes, or QC_NOT_MOVED
    float upper[3];
    bool alive;      ///< false: the id is free
    uint8_t state;   ///< qcBoxState
    bool stationary; ///< not moved since it was added; the forest holds the box itself, not an enlarged one
    bool exact;      ///< the floats equal the box, and there is no origin; otherwise see qcBoxes.bounds
} qcBox;

/// A box that was added or moved since the last search for pairs.
typedef struct qcMovedBox
{
    uint32_t id;
    bool added; ///< since the last search; otherwise `box` and `bounds` are those of the last search
    qcBox box;
    qcBounds bounds; ///< set where the floats are not exact
} qcMovedBox;

struct qcBoxes
{
    /// Enlarged (fat) AABBs, so that small moves leave the forest unchanged. A box that leaves its fat AABB is inserted
    /// anew and is dynamic until the next search.
    qcForest forest;
    /// All pairs whose AABBs in the forest overlap, except pairs of two stationary boxes and of stale boxes; pairs of
    /// dynamic boxes may be outdated. QC_EDGE_MARK: the boxes themselves overlapped at the last search.
    qcOverlapGraph overlaps;
    qcArray boxes;          ///< qcBox, by id
    qcArray bounds;         ///< qcBounds, by id, set where the floats are not exact
    qcArray userData;       ///< void*, by id; null where there is no box
    qcArray freeIds;        ///< uint32_t, a heap with the lowest id on top
    qcArray movedBoxes;     ///< qcMovedBox
    qcArray hits;           ///< qcOctetHit
    qcArray visitMarks;     ///< uint32_t, by id
    uint32_t lastMark;      ///< the visit mark used last
    qcArray began, ended;   ///< qcBoxPair; during a search a key of 64 bits each
    qcBoxProfile profile;   ///< of the last search
    uint32_t insertedCount; ///< boxes that are not qc_boxInTree
    uint32_t staleCount;    ///< boxes that are qc_boxPairsStale
    bool historyLost;       ///< a search failed: the overlaps of the last search are unknown
    qcBoxOrigin origin;     ///< of the floats of all boxes
    uint32_t coarseCount;   ///< coarse boxes that were inserted into the forest since the origin was last chosen
    bool originMoved;       ///< since the last search: all boxes are dynamic
};

static inline qcBox* qcBoxes_Box(const qcBoxes* set, uint32_t id)
{
    return &QC_AT(qcBox, set->boxes, id);
}

/// The bounds of a box whose floats are exact.
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

static inline bool qcBox_OverlapsFloats(const qcBox* a, const float lower[3], const float upper[3])
{
    return (a->lower[0] <= upper[0]) & (a->upper[0] >= lower[0]) & (a->lower[1] <= upper[1]) &
           (a->upper[1] >= lower[1]) & (a->lower[2] <= upper[2]) & (a->upper[2] >= lower[2]);
}

/// Whether two boxes overlap. Bounds are read only where the floats are not exact.
static inline bool qcBox_Overlap(const qcBox* a, const qcBounds* boundsA, const qcBox* b, const qcBounds* boundsB)
{
    bool overlap = qcBox_OverlapsFloats(a, b->lower, b->upper);
    // The predictable branch first: the result of the comparison is unpredictable.
    if (a->exact & b->exact)
        return overlap;
    if (!overlap)
        return false;
    qcBounds x = a->exact ? qcBox_Bounds(a) : *boundsA, y = b->exact ? qcBox_Bounds(b) : *boundsB;
    return qcBounds_Overlap(&x, &y);
}

/// Whether two boxes overlap now.
static inline bool qcBoxes_Overlap(const qcBoxes* set, uint32_t a, uint32_t b)
{
    const qcBounds* bounds = set->bounds.data;
    return qcBox_Overlap(qcBoxes_Box(set, a), &bounds[a], qcBoxes_Box(set, b), &bounds[b]);
}

/// Whether two boxes overlapped at the last search.
bool qcBoxes_OverlappedBefore(const qcBoxes* set, uint32_t a, uint32_t b);

/// Gives all boxes that share an edge with a box a new visit mark, and returns it.
uint32_t qcBoxes_MarkNeighbours(qcBoxes* set, uint32_t id);

/// Adds the overlaps of a box that is qc_boxPairsStale to the graph. The box stays stale if it is stationary, or if
/// memory runs out.
void qcBoxes_CommitPairs(qcBoxes* set, uint32_t id);

/// Adds the pairs of a box with stationary boxes to the graph, before the box moves for the first time.
void qcBoxes_CommitStationaryPairs(qcBoxes* set, uint32_t id);

#endif
