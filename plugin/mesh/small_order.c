// The tables of kernels that put few triangles in order, one for each instruction set.
#include "mesh/small_order.h"

#include "base/cpu_features.h"

static const qcKernelTables s_tables = {{
    &qcOrderKernels_scalar,
#ifdef QC_KERNELS_X86
    &qcOrderKernels_avx2,
    &qcOrderKernels_avx512,
#endif
}};

const qcOrderKernels* qcOrderKernels_Get(void)
{
    return qcKernelTables_Choose(&s_tables);
}

const qcOrderKernels* qcOrderKernels_Nth(size_t i)
{
    return qcKernelTables_Nth(&s_tables, i);
}
