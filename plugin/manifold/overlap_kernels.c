// Which kernels for what triangles have in common this machine runs.
#include "manifold/overlap_kernels.h"

#include "base/cpu_features.h"

static const qcOverlapKernels* const s_known[] = {
    &qcOverlapKernels_scalar,
#ifdef QC_KERNELS_X86
    &qcOverlapKernels_avx2,
#endif
};

const qcOverlapKernels* qcOverlapKernels_Get(void)
{
    return s_known[qcInstructionSet_Choose(qc_instructionsAvx2)];
}
