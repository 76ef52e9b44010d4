// The pairs that the device found, as keys of candidates.
#ifndef QC_CULL_LAYERS_DEVICE_PAIRS_H
#define QC_CULL_LAYERS_DEVICE_PAIRS_H

#include "kernels/pair_buffer.h"

typedef struct qcDevicePairs
{
    const uint32_t* pairs; ///< two triangles of the step each, qcLayersAnswer::pairs
    size_t count;
    bool listClassified; ///< pairs that surely intersect are among the contact keys, too
    uint32_t threads;
} qcDevicePairs;

/// Adds the keys. Pairs that surely intersect need no exact test: they are classified. `scratch` is memory to reuse.
qcStatus qcDevicePairs_Take(const qcDevicePairs* pairs, qcArray* scratch, const qcPairKeys* keys);

#endif
