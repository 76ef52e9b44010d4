// The sweep over triangles by the surfaces of bodies: each with itself, and the two of each pair of bodies.
#ifndef QC_SWEEP_BVH_CANDIDATES_H
#define QC_SWEEP_BVH_CANDIDATES_H

#include "sweep/candidates.h"
#include "sweep/bvh/verlet_list.h"
#include "kernels/pair_buffer.h"
#include "sweep/bvh/neighbour_pairs.h"

/// A body of the step whose surface has something missing or isn't where the body is.
typedef struct qcRefitTask
{
    uint32_t body;
    bool fits;
} qcRefitTask;

/// Memory that the stage keeps between steps.
typedef struct qcBvhCandidates
{
    const qcTriangleKernels* kernels; ///< chosen at first use
    qcArray bvhs;                     ///< of qcBodyBvh, by slot
    qcArray seen;                     ///< uint32_t, by slot: generation of the body that the last step saw there
    qcArray orders;                   ///< of qcRefitTask
    qcArray results;                  ///< of qcWorkerResult, one a worker
    qcArray scratches;                ///< of qcBvhScratch, one a worker
    qcBvhPairs pairs;
    qcVerletList kept;
    qcArray followed;         ///< uint8_t, by body of the step: its surface only followed it
    qcArray jobs;             ///< of qcBvhPairsJob
    qcArray sides;            ///< of PairOfSurfaces: of each job
    qcArray sinks;            ///< of qcPairBuffer
    qcArray reached;          ///< uint8_t, by node, of bodies that are not tested with themselves
    qcArray firstReached;     ///< size_t, by body of the step: where its nodes begin, or SIZE_MAX
    uint64_t fittedTriangles; ///< in this step
    uint64_t followedTriangles;
} qcBvhCandidates;

typedef struct qcBvhCandidatesJob
{
    const qcStepTriangles* triangles;
    const qcBodyPairs* objects;
    const uint8_t* bodies;          ///< by body of the step: whether it is asked about. Whoever meets it is too.
    const uint8_t* neighbourBodies; ///< by body of the step: asked about its neighbours alone; never one of the above
    double margin;                  ///< with which surfaces are fitted: no less than any pair needs
    double nearest;                 ///< pairs that are no further apart, as far as their bodies' margins go, are near
    double contactMargin;           ///< pairs within its qcContactDistance are candidates, too
    bool testNeighbours;            ///< triangles of one body that share a vertex are candidates too
    bool listNeighbours;            ///< and otherwise a list of their own
    uint32_t threads;
    qcCandidates* candidates; ///< what is found is added there
} qcBvhCandidatesJob;

/// Makes surfaces of the bodies whose flag in `wanted` is set, for the job, and clears the flags of those that have
/// none this time: large ones that meet themselves and are new, whose topology may not live for another step, unless
/// neighbours are listed, and what no lattice can hold.
qcStatus qcBvhCandidates_Prepare(qcBvhCandidates* sweep, const qcBvhCandidatesJob* job, uint8_t* wanted);

/// Adds pairs to the keys, or to those that are sure; where neighbours are listed, pairs whose relation is known are
/// among these too. All bodies that are asked about are prepared.
qcStatus qcBvhCandidates_Run(qcBvhCandidates* sweep, const qcBvhCandidatesJob* job, qcProfile* profile);
void qcBvhCandidates_Free(qcBvhCandidates* sweep);

#endif
