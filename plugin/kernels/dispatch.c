// Which kernels this machine runs.
#include "kernels/triangle_kernels.h"

#include "base/cpu_features.h"

static const qcSurfaceKernels* const s_known[] = {
    &qcSurfaceKernels_plain,
#ifdef QC_KERNELS_X86
    &qcSurfaceKernels_avx2,
    &qcSurfaceKernels_avx512,
#endif
};

const qcSurfaceKernels* qcSurfaceKernels_Nth(size_t i)
{
    return i <= qc_instructionsAvx512 && qcInstructionSet_IsThere((qcInstructionSet)i) ? s_known[i] : NULL;
}

const qcSurfaceKernels* qcSurfaceKernels_Get(void)
{
    return s_known[qcInstructionSet_Choose(qc_instructionsAvx512)];
}
