// Pairs of triangles of two leaf nodes, collected in a queue and filtered together.
#ifndef QC_SWEEP_BVH_LEAF_PAIRS_H
#define QC_SWEEP_BVH_LEAF_PAIRS_H

#include "sweep/bvh/bvh_search.h"

/// The pairs that one worker has found and not yet reported.
typedef struct qcPairQueue
{
    const qcBvhSearch* search;
    qcSlotPair *pairs, *end;
    qcPlaneCache* planes;
    qcBox8 transformed;      ///< the boxes of a leaf node's clusters in the lattice of the other BVH
    uint64_t transformedKey; ///< its search and its number; UINT64_MAX: none
    uint32_t worker;
    bool isOpen; ///< false: the job's function has stopped the search
} qcPairQueue;

/// Filters and reports the pairs in the queue.
void qcPairQueue_Flush(qcPairQueue* queue);

/// Adds the pairs of two leaf nodes of the queue's search.
void qcPairQueue_AddNodes(qcPairQueue* queue, qcNodePair nodes);

/// Adds those of some of the clusters of two leaf nodes, of two bodies. `clusters`: bit i + 8 j.
void qcPairQueue_AddClusters(qcPairQueue* queue, qcNodePair nodes, uint64_t clusters);

/// Marks leaf nodes as visited.
void qcBvhPairsJob_MarkVisited(const qcBvhPairsJob* job, qcNodePair nodes);

#endif
