// Which new bodies may take over the cluster order of a copy of theirs, so that only one of many copies is put in
// order.
#ifndef QC_SWEEP_COPIED_ORDERS_H
#define QC_SWEEP_COPIED_ORDERS_H

#include "sweep/bvh_candidates.h"

/// Fills `order`, `isCopied` and `waits` of the tasks of bodies without a BVH: by a body that has one, or by the first
/// of several that are built in this step. O(bodies + tasks log tasks), nothing if all bodies have a BVH.
qcStatus qcCopiedOrders_Find(const qcStepTriangles* triangles, qcBvhCandidates* sweep);

#endif
