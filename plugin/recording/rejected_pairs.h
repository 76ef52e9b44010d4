// The pairs of bodies that a caller's filter rejects during a detection: a set, filled by several threads.
#ifndef QC_RECORDING_REJECTED_PAIRS_H
#define QC_RECORDING_REJECTED_PAIRS_H

#include "quickcullide/scene.h"

#include <pthread.h>

typedef struct qcRejectedPairs
{
    qcPairFilter filter; ///< the caller's
    void* context;
    pthread_mutex_t mutex;
    uint64_t* keys; ///< open addressing; UINT64_MAX: free. Capacity is a power of two.
    size_t count, capacity;
    bool outOfMemory; ///< some pairs are missing
} qcRejectedPairs;

void qcRejectedPairs_Init(qcRejectedPairs* pairs);
void qcRejectedPairs_Free(qcRejectedPairs* pairs);
/// Empties the set and takes the filter.
void qcRejectedPairs_Start(qcRejectedPairs* pairs, qcPairFilter filter, void* context);
/// A qcPairFilter; the context is the set.
bool qcRejectedPairs_Filter(void* pairs, uint32_t slotA, uint32_t slotB);
/// Sorts the keys to the front, as they are written; the set then has to be started again.
void qcRejectedPairs_Sort(qcRejectedPairs* pairs);

/// The key of a pair, in either order.
static inline uint64_t qcRejectedPair_Key(uint32_t slotA, uint32_t slotB)
{
    return slotA < slotB ? (uint64_t)slotA << 32 | slotB : (uint64_t)slotB << 32 | slotA;
}

#endif
