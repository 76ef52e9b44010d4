/// @file
/// A set of moving boxes: overlapping pairs, box queries, rays, swept boxes. The core of a broadphase.
///
/// Cost follows what moved: a move is O(log n) amortised, finding pairs O(moved * log n + found). That holds at any
/// distance from zero while most boxes lie within a million times their edges of each other; beyond, boxes are culled
/// in coarse floats first, and up to all pairs may be compared. Results are exact in any case.
///
/// Thread-safety: functions that take a const set may run on several threads at once while no other function runs.
#ifndef QUICKCULLIDE_BOXES_H
#define QUICKCULLIDE_BOXES_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

/// A set of boxes.
typedef struct qcBoxes qcBoxes;

/// Makes an empty set. Destroy it with qcBoxes_Destroy. qc_statusOutOfMemory.
QC_API qcStatus qcBoxes_Create(qcBoxes** boxes);
/// Frees the set. Null is allowed.
QC_API void qcBoxes_Destroy(qcBoxes* boxes);
/// Removes every box, keeps memory for later boxes. The order of later results is that of a new set. O(1).
QC_API void qcBoxes_Clear(qcBoxes* boxes);

/// Adds a closed box. The id is valid until the box is removed. Ids are reused, the lowest first. O(log n).
/// qc_statusBadInput: not lower <= upper in every axis, as with NaN; infinite bounds are allowed. qc_statusOutOfMemory.
QC_API qcStatus qcBoxes_Add(qcBoxes* boxes, const double lower[3], const double upper[3], void* userData, uint32_t* id);
/// Removes a box. Its id may be reused. O(log n + its pairs). qc_statusBadInput: there is no box with this id.
QC_API qcStatus qcBoxes_Remove(qcBoxes* boxes, uint32_t id);
/// Moves a box, O(log n) amortised. A box whose bounds change counts as moved; equal bounds cost nothing.
/// qc_statusBadInput: there is no box with this id, or its bounds are refused as by qcBoxes_Add.
QC_API qcStatus qcBoxes_Move(qcBoxes* boxes, uint32_t id, const double lower[3], const double upper[3]);
/// The number of boxes. O(1).
QC_API uint32_t qcBoxes_GetCount(const qcBoxes* boxes);
/// The pointer given to qcBoxes_Add; null if there is no box with this id. O(1).
QC_API void* qcBoxes_GetUserData(const qcBoxes* boxes, uint32_t id);
/// The bounds of a box; zeros if there is no box with this id. O(1).
QC_API void qcBoxes_GetBounds(const qcBoxes* boxes, uint32_t id, double lower[3], double upper[3]);
/// The smallest box around all boxes; zeros for an empty set. O(n).
QC_API void qcBoxes_GetTotalBounds(const qcBoxes* boxes, double lower[3], double upper[3]);

/// A pair of boxes, a < b.
typedef struct qcBoxPair
{
    uint32_t a; ///< the lower id
    uint32_t b; ///< the higher id
} qcBoxPair;

/// All overlapping pairs of which at least one box was added or moved since the last call, each once, sorted by a, then
/// b. Boxes are closed and exactly as given. `pairs` belongs to the set and is valid until the next call that changes
/// the set or searches for pairs. O(moved * log n + found). qc_statusOutOfMemory: the boxes still count as moved.
QC_API qcStatus qcBoxes_FindMovedPairs(qcBoxes* boxes, const qcBoxPair** pairs, size_t* count);

/// Pairs that changed since the last search for pairs, by either function.
typedef struct qcBoxChanges
{
    const qcBoxPair* began; ///< new pairs, sorted by a, then b; valid until the set changes or is searched again
    const qcBoxPair* ended; ///< pairs that no longer overlap; sorted and valid likewise
    size_t beganCount;      ///< number of new pairs
    size_t endedCount;      ///< number of ended pairs
    /// Memory ran out in the last search or since, so the pairs before it are unknown. `began` then holds all pairs
    /// that overlap, `ended` none.
    bool all;
} qcBoxChanges;

/// The pairs that overlap now and did not at the last search, and the pairs that did and no longer do. Pairs of a
/// removed box are not reported; a new box with a reused id starts without pairs.
/// O(n log n + pairs) if all boxes moved, O(1) if none did. qc_statusOutOfMemory: the next search reports all pairs
/// (qcBoxChanges::all).
QC_API qcStatus qcBoxes_FindChangedPairs(qcBoxes* boxes, qcBoxChanges* changes);

/// The work of the last search for pairs. All zeros if no box moved.
typedef struct qcBoxProfile
{
    size_t moved;    ///< boxes added or moved since the previous search
    size_t sought;   ///< boxes among these that searched the tree; after a small move the known pairs suffice
    size_t compared; ///< pairs of nearby boxes that were compared
    size_t sorted;   ///< boxes sorted into the trees, in this search or when they were added or moved
} qcBoxProfile;

/// The work of the last search for pairs. O(1).
QC_API qcBoxProfile qcBoxes_GetProfile(const qcBoxes* boxes);

/// Receives one box of a query, in the caller's floating-point modes. Returns false to stop the query. Must
/// not throw.
typedef bool qcBoxFunction(uint32_t id, void* userData, void* context);

/// Visits every box that overlaps the closed box. Bounds that are NaN count as unbounded. O(log n + found), typically.
QC_API void qcBoxes_QueryBox(const qcBoxes* boxes, const double lower[3], const double upper[3],
                             qcBoxFunction* function, void* context);

/// Visits every box that overlaps box `id` now and did not at the last search for pairs. An unknown id visits nothing.
/// Where memory ran out since that search, it visits all that overlap. The next search reuses the result. O(log n + its
/// pairs), typically.
QC_API void qcBoxes_QueryBegun(qcBoxes* boxes, uint32_t id, qcBoxFunction* function, void* context);

/// Visits every box that a moving box touches on its way from `from` to `to`. `castLower` and `castUpper` are the
/// moving box's extents relative to the moving point; zeros cast a ray. No such box is missed; others near the way may
/// be visited too. An axis with a coordinate that is NaN is unbounded. Nearer boxes come first, as far as the tree can
/// order them. O(log n + boxes near the way), typically.
///
/// `fraction`: the part of the way that is searched, from 0 to 1; null: all of it. The callback may lower it to
/// shorten the rest of the search.
QC_API void qcBoxes_CastBox(const qcBoxes* boxes, const double from[3], const double to[3], const double castLower[3],
                            const double castUpper[3], const double* fraction, qcBoxFunction* function, void* context);

#ifdef __cplusplus
}
#endif

#endif
