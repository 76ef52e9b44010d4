// Where workers put the pairs of triangles that they find: each its own, in the end put together.
#ifndef QC_KERNELS_PAIR_BUFFER_H
#define QC_KERNELS_PAIR_BUFFER_H

#include "base/radix_sort.h"
#include "base/worker_results.h"
#include "kernels/pair_filter.h"
#include "quickcullide/scene.h"

/// What one worker found.
typedef struct qcPairBuffer
{
    qcWorkerResult result;
    qcArray keys;        ///< uint64_t: lower rank << 32 | higher rank
    qcArray contactKeys; ///< uint64_t: for contacts: neighbours, and pairs whose relation is known
    qcArray sure;        ///< of qcSortItem: key and relation, of pairs that need no other test
} qcPairBuffer;

/// Pairs of all workers; as in a sink.
typedef struct qcPairKeys
{
    qcArray *keys, *contactKeys, *sure;
} qcPairKeys;

typedef uint64_t qcPairKeyFunction(const void* context, qcSlotPair pair);

/// Empties the sinks (of qcPairBuffer) of as many workers.
qcStatus qcPairBuffers_Begin(qcArray* sinks, uint32_t threads);
/// What is known needs no exact test; with `listKnown`, it is among the contact keys, too: who asks for contacts makes
/// them of all that is near. False: the sink has failed, and nothing more is wanted.
bool qcPairBuffer_Add(qcPairBuffer* sink, const qcClassifiedPairs* found, bool listKnown, qcPairKeyFunction* keyOf,
                      const void* context);
/// Adds neighbours to the contact keys.
void qcPairBuffer_AddNeighbours(qcPairBuffer* sink, const qcSlotPair* pairs, size_t count, qcPairKeyFunction* keyOf,
                                const void* context);
/// Adds what all have; fails if one has.
qcStatus qcPairBuffers_End(const qcArray* sinks, const qcPairKeys* keys);
void qcPairBuffers_Free(qcArray* sinks);

#endif
