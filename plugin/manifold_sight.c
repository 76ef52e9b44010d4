// Which kernels for what triangles have in common this machine runs.
#include "manifold_sight.h"

#include "instruction_set.h"

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
