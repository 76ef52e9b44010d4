// The sweep over triangles by BVHs: of each body with itself, and of both bodies of each pair.
#ifndef QC_SWEEP_BVH_CANDIDATES_H
#define QC_SWEEP_BVH_CANDIDATES_H

#include "kernels/pair_buffer.h"
#include "sweep/bvh/neighbour_pairs.h"
#include "sweep/bvh/verlet_list.h"
#include "sweep/candidates.h"

/// A queued BVH build or refit.
typedef struct qcRefitTask
{
    uint32_t body;
    bool upToDate;
    //  A build's: see sweep/copied_orders.h.
    uint32_t order; ///< the body whose cluster order is taken over if it suits; the same body: none
    bool isCopied;  ///< others may take over the order, which has to be that of all triangles
    bool waits;     ///< the order is made in this step
} qcRefitTask;

/// BVHs of the bodies, and scratch; retained between steps.
typedef struct qcBvhCandidates
{
    const qcTriangleKernels* kernels; ///< chosen at first use
    qcArray bvhs;                     ///< qcBodyBvh*, by slot; null: the body has had no BVH so far
    qcVerletList verletList;
    //  Of the step.
    qcArray partlyRefitted; ///< uint8_t, by body: only the moved vertices were refitted
    uint64_t refittedTriangles, partlyRefittedTriangles;
    //  Scratch.
    qcArray tasks;        ///< of qcRefitTask
    qcArray keys;         ///< of qcSortItem: bodies by qcBvhCopy_KeyOf
    qcArray sorted;       ///< for sorting them
    qcArray results;      ///< of qcWorkerResult, one a worker
    qcArray refitScratch; ///< of qcBvhScratch, one a worker
    qcBvhPairs pairs;
    qcArray jobs;         ///< of qcBvhPairsJob
    qcArray sides;        ///< of PairSides: of each job
    qcArray buffers;      ///< of qcPairBuffer
    qcArray visited;      ///< uint8_t, by leaf node, of bodies without self-collision
    qcArray firstVisited; ///< size_t, by body: index of its first leaf node in `visited`, or SIZE_MAX
} qcBvhCandidates;

typedef struct qcBvhCandidatesJob
{
    const qcStepTriangles* triangles;
    const qcBodyPairs* pairs;
    const uint8_t* bodies;         ///< by body: a flag, equal for both bodies of a pair; set: pairs are found here
    const uint8_t* neighboursOnly; ///< by body: a flag; set: only neighbours are found here. Never both
    double queryDistance;          ///< no less than the distance of any pair
    double margin;                 ///< qcDetectDef::margin: pairs proven no further apart are classified near
    double contactMargin;          ///< pairs within its qcContactDistance are candidates too
    bool testNeighbours;           ///< triangles of one body that share a vertex are candidates too
    bool listNeighbours;           ///< without testNeighbours: they are listed in contactKeys
    uint32_t threads;
} qcBvhCandidatesJob;

/// Builds or refits the BVHs of the flagged bodies. Clears the flag of a body whose coordinates no 16-bit lattice can
/// hold.
qcStatus qcBvhCandidates_Prepare(const qcBvhCandidatesJob* job, qcBvhCandidates* sweep, uint8_t* flags);

/// Adds pairs to the candidates, with neighbours listed also classified ones to contactKeys. All bodies of the job are
/// prepared.
qcStatus qcBvhCandidates_Run(const qcBvhCandidatesJob* job, qcBvhCandidates* sweep, qcCandidates* candidates,
                             qcProfile* profile);
void qcBvhCandidates_Free(qcBvhCandidates* sweep);

/// Frees the BVH of a slot, if there is one.
void qcBvhCandidates_Delete(qcBvhCandidates* sweep, uint32_t slot);

/// Null: the body of the slot has had no BVH so far.
static inline qcBodyBvh* qcBvhCandidates_At(const qcBvhCandidates* sweep, uint32_t slot)
{
    return QC_AT(qcBodyBvh*, sweep->bvhs, slot);
}

/// The distance within which pairs of two bodies are candidates, by the sum of both bodies' margins.
double qcBvhCandidates_DistanceWithin(const qcBvhCandidatesJob* job, double margins);

/// The distance within which pairs of two bodies, or of one, are candidates.
double qcBvhCandidates_PairDistance(const qcBvhCandidatesJob* job, const qcBody* a, const qcBody* b);

#endif
