// Which kernels for boxes this machine runs.
#include "box_kernels.h"

#include <stdlib.h>
#include <string.h>

const qcBoxKernels* qcBoxKernels_Nth(size_t i)
{
    const qcBoxKernels* known[3] = {&qcBoxKernels_plain};
    size_t count = 1;
#ifdef QC_KERNELS_X86
    if (__builtin_cpu_supports("avx2"))
        known[count++] = &qcBoxKernels_avx2;
#endif
    return i < count ? known[i] : NULL;
}

const qcBoxKernels* qcBoxKernels_Get(void)
{
    const char* wished = getenv("QC_KERNELS");
    const qcBoxKernels *best = NULL, *kernels;
    for (size_t i = 0; (kernels = qcBoxKernels_Nth(i)) != NULL; i++)
    {
        best = kernels;
        if (wished != NULL && strcmp(wished, kernels->name) == 0)
            break;
    }
    return best;
}
