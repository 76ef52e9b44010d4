// The tables of triangle kernels, one for each instruction set.
#include "kernels/triangle_kernels.h"

#include "base/cpu_features.h"

static const qcKernelTables s_tables = {{
    &qcTriangleKernels_scalar,
#ifdef QC_KERNELS_X86
    &qcTriangleKernels_avx2,
    &qcTriangleKernels_avx512,
#endif
}};

const qcTriangleKernels* qcTriangleKernels_Get(void)
{
    return qcKernelTables_Choose(&s_tables);
}

const qcTriangleKernels* qcTriangleKernels_Nth(size_t i)
{
    return qcKernelTables_Nth(&s_tables, i);
}
