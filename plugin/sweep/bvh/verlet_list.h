// The Verlet list (cached neighbour list) of self-colliding bodies: pairs that were found within a margin, reused in
// steps with a smaller margin after few vertices have moved. The difference of the margins allows for the motion.
// (Verlet: Computer "Experiments" on Classical Fluids, 1967.)
#ifndef QC_SWEEP_BVH_VERLET_LIST_H
#define QC_SWEEP_BVH_VERLET_LIST_H

#include "base/worker_results.h"
#include "sweep/bvh/bvh_pairs.h"

/// The pairs that one worker found.
typedef struct qcVerletWorker
{
    qcWorkerResult result;
    qcArray pairs; ///< of qcSlotPair
    qcArray runs;  ///< of PairRun: which body has them, and how many are classified
} qcVerletWorker;

/// The pairs of all bodies, as one step found them.
typedef struct qcVerletList
{
    qcArray workers; ///< of qcVerletWorker
} qcVerletList;

/// Empties the list.
qcStatus qcVerletList_Begin(qcVerletList* list, uint32_t threads);
/// Adds pairs of the body with this slot.
void qcVerletList_Add(qcVerletList* list, uint32_t slot, const qcClassifiedPairs* found, uint32_t worker);
/// Fails if a worker has failed.
qcStatus qcVerletList_Check(const qcVerletList* list);

/// Finds the job's pairs: all those of a body with itself. Its BVH has been refitted by qcBodyBvh_PartialRefit, with a
/// `maxMotion` of half the difference of the reference's margin and the job's query distance. O(pairs in the list +
/// triangles).
void qcVerletList_Find(const qcVerletList* list, uint32_t slot, const qcBvhPairsJob* job, uint32_t worker);
void qcVerletList_Free(qcVerletList* list);

#endif
