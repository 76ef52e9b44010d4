// Per-thread buffers for pairs of triangles. Each worker fills its own; at the end they are appended to one list.
#ifndef QC_KERNELS_PAIR_BUFFER_H
#define QC_KERNELS_PAIR_BUFFER_H

#include "base/related_pair.h"
#include "base/worker_results.h"
#include "kernels/pair_filter.h"
#include "quickcullide/scene.h"

/// The pairs that one worker found. The key of a pair: lower global triangle index << 32 | higher one.
typedef struct qcPairBuffer
{
    qcWorkerResult result;
    uint64_t maxPairs;
    qcArray keys;        ///< uint64_t: pairs that need the exact test
    qcArray contactKeys; ///< uint64_t: pairs needed for contacts only: neighbours, and classified ones
    qcArray classified;  ///< uint64_t, as qcRelatedPair_Make: pairs that need no exact test
} qcPairBuffer;

/// The pairs of all workers, as in qcPairBuffer.
typedef struct qcPairKeys
{
    qcArray *keys, *contactKeys, *classified;
} qcPairKeys;

/// Writes the keys of pairs.
typedef void qcPairKeysFunction(const void* context, const qcSlotPair* pairs, size_t count, uint64_t* keys);

/// Empties the buffers (of qcPairBuffer), one for each thread. A buffer that would hold more than `maxPairs` fails.
qcStatus qcPairBuffers_Begin(qcArray* buffers, uint32_t threads, uint64_t maxPairs);
/// Adds undecided pairs to `keys`, near and intersecting ones to `classified`. With `listClassified` all classified
/// pairs, separate ones too, are also added to `contactKeys`. False: the buffer has failed; `result` has the reason.
bool qcPairBuffer_Add(qcPairBuffer* buffer, const qcClassifiedPairs* found, bool listClassified,
                      qcPairKeysFunction* keysOf, const void* context);
/// Adds pairs of neighbours to `contactKeys`.
void qcPairBuffer_AddNeighbours(qcPairBuffer* buffer, const qcSlotPair* pairs, size_t count, qcPairKeysFunction* keysOf,
                                const void* context);
/// Appends all buffers to `keys`. Fails if one of them has failed.
qcStatus qcPairBuffers_End(const qcArray* buffers, const qcPairKeys* keys);
void qcPairBuffers_Free(qcArray* buffers);

#endif
