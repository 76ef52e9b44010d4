// The pairs that the device found, as candidates.
#ifndef QC_CULL_LAYERS_DEVICE_PAIRS_H
#define QC_CULL_LAYERS_DEVICE_PAIRS_H

#include "kernels/pair_buffer.h"

typedef struct qcDevicePairs
{
    const uint32_t (*pairs)[2]; ///< qcLayersAnswer::pairs
    size_t count;
    bool listClassified; ///< pairs that surely intersect are among the contact keys, too
    uint32_t threads;
} qcDevicePairs;

/// Adds the pairs, in their order. Those that surely intersect need no exact test: they are classified. `scratch` is
/// memory to reuse.
qcStatus qcDevicePairs_Take(const qcDevicePairs* pairs, qcArray* scratch, const qcPairKeys* keys);

#endif
