// The tables of box kernels, one for each instruction set.
#include "broadphase/box_kernels.h"

#include "base/cpu_features.h"

static const qcKernelTables s_tables = {{
    &qcBoxKernels_scalar,
#ifdef QC_KERNELS_X86
    &qcBoxKernels_avx2,
#endif
}};

const qcBoxKernels* qcBoxKernels_Get(void)
{
    return qcKernelTables_Choose(&s_tables);
}

const qcBoxKernels* qcBoxKernels_Nth(size_t i)
{
    return qcKernelTables_Nth(&s_tables, i);
}
