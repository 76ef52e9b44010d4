// Sorts keys on several threads.
#ifndef QC_BASE_PARALLEL_SORT_H
#define QC_BASE_PARALLEL_SORT_H

#include "base/memory.h"

/// The result of qcSort_Keys. O(count); few keys, or few leading bits, are sorted on the calling thread. `scratch` is
/// memory to reuse.
qcStatus qcParallelSort_Keys(uint32_t threads, uint64_t* keys, size_t count, qcArray* scratch);

#endif
