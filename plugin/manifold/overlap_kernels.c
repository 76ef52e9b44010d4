// The tables of overlap kernels, one for each instruction set.
#include "manifold/overlap_kernels.h"

#include "base/cpu_features.h"

static const qcKernelTables s_tables = {{
    &qcOverlapKernels_scalar,
#ifdef QC_KERNELS_X86
    &qcOverlapKernels_avx2,
#endif
}};

const qcOverlapKernels* qcOverlapKernels_Get(void)
{
    return qcKernelTables_Choose(&s_tables);
}
