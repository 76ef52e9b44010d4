// Kernels for what triangles have in common, for x86-64 with AVX2.
#include "manifold/overlap_kernels.inl.h"

#include <immintrin.h>

QC_INLINE unsigned BitsOf(Marks marks)
{
    return (unsigned)_mm256_movemask_pd((__m256d)marks) & 7u;
}

const qcOverlapKernels qcOverlapKernels_avx2 = {FindCommonPart};
