// Pairs of surfaces with themselves that were found within a margin, kept for a step that asks for less of it after few
// vertices have moved: what they make up for is the motion. (Verlet: Computer "Experiments" on Classical Fluids, 1967:
// lists of neighbours that outlive a step.)
#ifndef QC_SWEEP_BVH_VERLET_LIST_H
#define QC_SWEEP_BVH_VERLET_LIST_H

#include "base/worker_results.h"
#include "sweep/bvh/bvh_pairs.h"

/// What one worker found.
typedef struct qcVerletWorker
{
    qcWorkerResult result;
    qcArray pairs; ///< of qcSlotPair
    qcArray runs;  ///< of KeptRun: whose they are, and what was known of them
} qcVerletWorker;

/// Those of one step.
typedef struct qcVerletList
{
    qcArray sinks; ///< of qcVerletWorker
} qcVerletList;

/// What was kept is forgotten.
qcStatus qcVerletList_Begin(qcVerletList* kept, uint32_t threads);
/// Keeps all that were found of the surface of a slot.
void qcVerletList_Add(qcVerletList* kept, uint32_t slot, const qcClassifiedPairs* found, uint32_t worker);
/// Fails if a worker has.
qcStatus qcVerletList_Check(const qcVerletList* kept);

/// The job's pairs: all those of a surface with itself. It follows its body (sweep/bvh/partial_refit.h) from where its
/// pairs within surface->keptMargin were kept, and vertices that moved by more than half of what the job's margin is
/// less than that are marked as far. O(pairs kept + triangles).
void qcVerletList_Find(const qcVerletList* kept, uint32_t slot, const qcBvhPairsJob* job, uint32_t worker);
void qcVerletList_Free(qcVerletList* kept);

#endif
