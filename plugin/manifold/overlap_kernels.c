// The tables of overlap kernels, one for each instruction set.
#include "manifold/overlap_kernels.h"

#include "base/cpu_features.h"

static const void* const s_tables[] = {
    &qcOverlapKernels_scalar,
#ifdef QC_KERNELS_X86
    &qcOverlapKernels_avx2,
#endif
};

enum
{
    qc_tableCount = sizeof s_tables / sizeof s_tables[0]
};

const qcOverlapKernels* qcOverlapKernels_Get(void)
{
    return qcKernelTables_Choose(s_tables, qc_tableCount);
}
