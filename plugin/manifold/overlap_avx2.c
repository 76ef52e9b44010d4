// Kernels of the projected overlap and of distances for x86-64 with AVX2.
#include "manifold/pair_distance.inl.h"

#include <immintrin.h>

QC_INLINE unsigned MaskBits(Mask mask)
{
    return (unsigned)_mm256_movemask_pd((__m256d)mask) & 7u;
}

const qcOverlapKernels qcOverlapKernels_avx2 = {FindOverlap, FindDistances};
