// Kernels of the projected overlap for x86-64 with AVX2.
#include <immintrin.h>

#define QC_MASK_BITS(mask) ((unsigned)_mm256_movemask_pd((__m256d)(mask)) & 7u)

#include "manifold/overlap_kernels.inl.h"

const qcOverlapKernels qcOverlapKernels_avx2 = {FindOverlap};
