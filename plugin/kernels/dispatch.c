// Which kernels this machine runs.
#include "kernels/triangle_kernels.h"

#include "base/cpu_features.h"

static const qcTriangleKernels* const s_known[] = {
    &qcTriangleKernels_scalar,
#ifdef QC_KERNELS_X86
    &qcTriangleKernels_avx2,
    &qcTriangleKernels_avx512,
#endif
};

const qcTriangleKernels* qcTriangleKernels_Nth(size_t i)
{
    return i <= qc_instructionsAvx512 && qcInstructionSet_IsAvailable((qcInstructionSet)i) ? s_known[i] : NULL;
}

const qcTriangleKernels* qcTriangleKernels_Get(void)
{
    return s_known[qcInstructionSet_Choose(qc_instructionsAvx512)];
}
