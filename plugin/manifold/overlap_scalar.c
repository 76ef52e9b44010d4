// Kernels of the projected overlap and of distances in plain C, for any processor: the compiler splits the vectors.
#include "manifold/pair_distance.inl.h"

QC_INLINE unsigned MaskBits(Mask mask)
{
    return (unsigned)((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4));
}

const qcOverlapKernels qcOverlapKernels_scalar = {FindOverlap, FindDistances};
