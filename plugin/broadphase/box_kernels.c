// Selects the box kernels that this machine runs.
#include "broadphase/box_kernels.h"

#include "base/cpu_features.h"

static const qcBoxKernels* const s_known[] = {
    &qcBoxKernels_scalar,
#ifdef QC_KERNELS_X86
    &qcBoxKernels_avx2,
#endif
};

const qcBoxKernels* qcBoxKernels_Nth(size_t i)
{
    return i <= qc_instructionsAvx2 && qcInstructionSet_IsAvailable((qcInstructionSet)i) ? s_known[i] : NULL;
}

const qcBoxKernels* qcBoxKernels_Get(void)
{
    return s_known[qcInstructionSet_Choose(qc_instructionsAvx2)];
}
