// Kernels of the projected overlap in plain C, for any processor: the compiler splits the vectors.
#define QC_MASK_BITS(mask) ((unsigned)(((mask)[0] & 1) | ((mask)[1] & 2) | ((mask)[2] & 4)))

#include "manifold/overlap_kernels.inl.h"

const qcOverlapKernels qcOverlapKernels_scalar = {FindOverlap};
