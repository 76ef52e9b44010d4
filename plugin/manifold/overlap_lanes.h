// Lanes of corners or edges, as vectors of the compiler's.
#ifndef QC_MANIFOLD_OVERLAP_LANES_H
#define QC_MANIFOLD_OVERLAP_LANES_H

#include "manifold/overlap_kernels.h"

#define QC_INLINE static inline __attribute__((always_inline))

typedef double Lanes __attribute__((vector_size(8 * qc_overlapLanes)));
typedef int64_t Marks __attribute__((vector_size(8 * qc_overlapLanes)));

#endif
