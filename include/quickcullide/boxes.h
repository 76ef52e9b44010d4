// A set of moving boxes: overlapping pairs, rays, swept boxes. What a broadphase is made of.
//
// Cost follows what moved: a move is O(log n), counted over many, finding pairs O(moved * log n + found).
// Thread-safety: the const functions may be called from several threads at once while no other
// function runs.
#ifndef QUICKCULLIDE_BOXES_H
#define QUICKCULLIDE_BOXES_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct qcBoxes qcBoxes;

QC_API qcStatus qcBoxes_Create(qcBoxes** boxes);
/// Null is allowed.
QC_API void qcBoxes_Destroy(qcBoxes* boxes);
/// Removes every box, keeps the memory.
QC_API void qcBoxes_Clear(qcBoxes* boxes);

/// Adds a closed box, lower <= upper in every axis, infinities allowed, NaN not (qc_statusBadInput).
/// The id is valid until the box is removed; ids are reused, lowest first.
QC_API qcStatus qcBoxes_Add(qcBoxes* boxes, const double lower[3], const double upper[3], void* userData, uint32_t* id);
QC_API qcStatus qcBoxes_Remove(qcBoxes* boxes, uint32_t id);
/// Moves a box. The same bounds again cost nothing. A box with changed bounds counts as moved.
QC_API qcStatus qcBoxes_Move(qcBoxes* boxes, uint32_t id, const double lower[3], const double upper[3]);
QC_API uint32_t qcBoxes_GetCount(const qcBoxes* boxes);
QC_API void* qcBoxes_GetUserData(const qcBoxes* boxes, uint32_t id);
QC_API void qcBoxes_GetBounds(const qcBoxes* boxes, uint32_t id, double lower[3], double upper[3]);
/// The smallest box around all boxes; an empty set gives zeros.
QC_API void qcBoxes_GetTotalBounds(const qcBoxes* boxes, double lower[3], double upper[3]);

/// A pair of ids, a < b.
typedef struct qcBoxPair
{
    uint32_t a, b;
} qcBoxPair;

/// All overlapping pairs (closed boxes, exactly the bounds given) of which at least one box was added or
/// moved since the last call, each once, sorted by a, then b. `pairs` is owned by the set and valid until
/// the next call on it that is not const.
QC_API qcStatus qcBoxes_FindMovedPairs(qcBoxes* boxes, const qcBoxPair** pairs, size_t* count);

/// What changed since the last search for pairs, by either function.
typedef struct qcBoxChanges
{
    const qcBoxPair *began, *ended; ///< sorted by a, then b; valid until the next call on the set that is not const
    size_t beganCount, endedCount;
    /// Memory ran out in the last search: what overlapped before it is not known any more. `began` holds all pairs that
    /// overlap, `ended` none.
    bool all;
} qcBoxChanges;

/// The pairs that overlap now and did not at the last search, and the pairs that did and no longer do. Pairs of a box
/// that was removed since are not reported; a new box with an old id has no past.
/// O(n log n + pairs) where everything moves, and nothing where nothing does.
QC_API qcStatus qcBoxes_FindChangedPairs(qcBoxes* boxes, qcBoxChanges* changes);

/// What the last search for pairs did. Where nothing moved, all are 0.
typedef struct qcBoxProfile
{
    size_t moved;    ///< boxes added or moved since the search before
    size_t sought;   ///< of these, boxes that looked for neighbours: a small move does not
    size_t compared; ///< pairs of boxes near each other that were compared
    size_t sorted;   ///< boxes, moved or not, that were put in order for that, now or when they were added or moved
} qcBoxProfile;

QC_API qcBoxProfile qcBoxes_GetProfile(const qcBoxes* boxes);

/// Called for a box, in the floating-point modes of the caller; returns false to stop the query.
typedef bool qcBoxFunction(uint32_t id, void* userData, void* context);

/// Visits every box that meets the closed box.
QC_API void qcBoxes_QueryBox(const qcBoxes* boxes, const double lower[3], const double upper[3],
                             qcBoxFunction* function, void* context);

/// Visits every box that overlaps this one and did not at the last search for pairs. There is nothing to visit for an
/// id that has no box. What it finds on the way is work that the next search need not do.
QC_API void qcBoxes_QueryBegun(qcBoxes* boxes, uint32_t id, qcBoxFunction* function, void* context);

/// Visits every box that a box of the given extents (relative to the moving point; zeros for a ray) meets
/// on its way from `from` to `to`. Never misses; boxes beyond may be visited too. Nearer boxes first, as far as
/// the tree can tell. `*fraction` (1: the whole way) may be lowered by the function to shorten the rest of
/// the way; null: the whole way.
QC_API void qcBoxes_CastBox(const qcBoxes* boxes, const double from[3], const double to[3], const double castLower[3],
                            const double castUpper[3], const double* fraction, qcBoxFunction* function, void* context);

#ifdef __cplusplus
}
#endif

#endif
