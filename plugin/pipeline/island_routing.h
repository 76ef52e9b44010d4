// Which islands are processed by `layers` on the device, and which bodies by BVHs on the CPU.
#ifndef QC_PIPELINE_ISLAND_ROUTING_H
#define QC_PIPELINE_ISLAND_ROUTING_H

#include "pipeline/step.h"
#include "sweep/bvh_candidates.h"
#include "sweep/islands.h"

typedef struct qcIslandRouting
{
    qcIslands islands;
    qcPlanHistory history;   ///< of the scene's steps
    double plannedTriangles; ///< triangles of islands for which the planner chose a method; 0: it did not choose
    //  uint8_t, by body of the step: flags. All bodies of an island have the same.
    qcArray onDevice;         ///< its triangle pairs come from the device
    qcArray onBvhs;           ///< its triangle pairs come from BVHs
    qcArray handledElsewhere; ///< either: sweep and prune leaves it out
    qcArray neighboursOnBvhs; ///< on the device, but its neighbours come from its BVH
} qcIslandRouting;

/// Finds the islands and sends some to the device: all for `layers`, those for which it pays for `auto`. Measures the
/// device's costs on first need; that time counts as planMs.
qcStatus qcIslandRouting_ChooseDevice(const qcStep* step, const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                                      qcIslandRouting* routing, qcProfile* profile);

/// After a device failure: all islands go to the CPU.
void qcIslandRouting_LeaveDevice(qcIslandRouting* routing);

/// Chooses the bodies for BVHs, and builds or refits these. An island with a body that has no BVH yet goes to sweep and
/// prune as a whole.
qcStatus qcIslandRouting_PrepareBvhs(const qcStep* step, const qcBvhCandidatesJob* job, qcBvhCandidates* bvhs,
                                     qcIslandRouting* routing);
void qcIslandRouting_Free(qcIslandRouting* routing);

#endif
