// Which kernels this machine runs.
#include "surface_kernels.h"

#include <stdlib.h>
#include <string.h>

const qcSurfaceKernels* qcSurfaceKernels_Nth(size_t i)
{
    const qcSurfaceKernels* known[4] = {&qcSurfaceKernels_plain};
    size_t count = 1;
#ifdef QC_KERNELS_X86
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        known[count++] = &qcSurfaceKernels_avx2;
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl"))
        known[count++] = &qcSurfaceKernels_avx512;
#endif
    return i < count ? known[i] : NULL;
}

const qcSurfaceKernels* qcSurfaceKernels_Get(void)
{
    const char* wished = getenv("QC_KERNELS");
    const qcSurfaceKernels *best = NULL, *kernels;
    for (size_t i = 0; (kernels = qcSurfaceKernels_Nth(i)) != NULL; i++)
    {
        best = kernels;
        if (wished != NULL && strcmp(wished, kernels->name) == 0)
            break;
    }
    return best;
}
