// Which kernels for what triangles have in common this machine runs.
#include "manifold/overlap_kernels.h"

#include "base/cpu_features.h"

static const qcSightKernels* const s_known[] = {
    &qcSightKernels_plain,
#ifdef QC_KERNELS_X86
    &qcSightKernels_avx2,
#endif
};

const qcSightKernels* qcSightKernels_Get(void)
{
    return s_known[qcInstructionSet_Choose(qc_instructionsAvx2)];
}
