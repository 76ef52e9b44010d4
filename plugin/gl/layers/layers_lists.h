// The lists that the kernels of `layers` fill: room for them on the device, the counters of the last run, and how many
// items the next run is expected to have.
#ifndef QC_GL_LAYERS_LAYERS_LISTS_H
#define QC_GL_LAYERS_LAYERS_LISTS_H

#include "gl/layers/layers_buffers.h"

typedef enum qcLayersList
{
    qc_listEntries,   ///< for the image
    qc_listNodePairs, ///< for pairs, and all that follow
    qc_listTrianglePairs,
    qc_listSurvivors, ///< of the pairs' tests
    qc_layersListCount
} qcLayersList;

/// A counter as the kernels define it (common.glsl), on a cache line of its own.
typedef struct qcLayersCounter
{
    uint32_t count, unused[15];
} qcLayersCounter;

typedef struct qcLayersCounters
{
    qcLayersCounter lists[qc_layersListCount], skippedNodes, stopped, overflow, finished, unordered;
} qcLayersCounters;
_Static_assert(sizeof(qcLayersCounters) == qc_counterWords * sizeof(uint32_t), "the counters of the kernels");

typedef struct qcLayersLists
{
    bool imageOnly;
    qcLayersCounters counters;         ///< of the last run
    uint32_t room[qc_layersListCount]; ///< elements of its buffer that a list has: buckets may need a larger one
    uint32_t bucketCount, bucketShift; ///< of the step; 0 buckets: pairs stay in no order
} qcLayersLists;

/// The number of items that a list holds.
uint32_t qcLayersLists_Capacity(const qcLayersLists* lists, qcLayersList list);
/// The number of items that the last run had.
static inline uint32_t qcLayersLists_Count(const qcLayersLists* lists, qcLayersList list)
{
    return lists->counters.lists[list].count;
}

/// Chooses the buckets of a step with that many triangles, for about as many pairs as in the last run.
void qcLayersLists_ChooseBuckets(qcLayersLists* lists, uint32_t triangleCount);
/// Pairs of nodes that a workgroup takes at a time.
uint32_t qcLayersLists_NodePairsOfGroup(const qcLayersLists* lists);
/// Workgroups that go through a list, `share` items at a time: once each if there are as many as expected. Any number
/// gets to the end.
uint64_t qcLayersLists_GroupCount(const qcLayersLists* lists, qcLayersList list, uint32_t share);

/// Makes room for the lists of a step of `nodes` nodes, and for its buckets. qc_statusDevice: the device's buffers
/// can't hold them.
qcStatus qcLayersLists_Reserve(const struct qcGlFunctions* gl, qcLayersLists* lists, qcLayersBuffers* buffers,
                               size_t nodes);
/// Makes room for the lists that overflowed in the last run; `*grown`: some did. qc_statusDevice: a list has more items
/// than the kernels can count, or than the device's buffers hold.
qcStatus qcLayersLists_Grow(const struct qcGlFunctions* gl, qcLayersLists* lists, qcLayersBuffers* buffers,
                            bool* grown);

#endif
