// Kernels for what triangles have in common, in plain C: any processor. Vectors are the compiler's.
#include "manifold/overlap_kernels.inl.h"

QC_INLINE unsigned BitsOf(Marks marks)
{
    return (unsigned)((marks[0] & 1) | (marks[1] & 2) | (marks[2] & 4));
}

const qcOverlapKernels qcOverlapKernels_scalar = {FindCommonPart};
