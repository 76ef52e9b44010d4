// Which kernels for what triangles have in common this machine runs.
#include "manifold_sight.h"

#include <stdlib.h>
#include <string.h>

/// All that this machine runs: the i-th, or null.
static const qcSightKernels* Nth(size_t i)
{
    const qcSightKernels* known[3] = {&qcSightKernels_plain};
    size_t count = 1;
#ifdef QC_KERNELS_X86
    if (__builtin_cpu_supports("avx2"))
        known[count++] = &qcSightKernels_avx2;
#endif
    return i < count ? known[i] : NULL;
}

const qcSightKernels* qcSightKernels_Get(void)
{
    const char* wished = getenv("QC_KERNELS");
    const qcSightKernels *best = NULL, *kernels;
    for (size_t i = 0; (kernels = Nth(i)) != NULL; i++)
    {
        best = kernels;
        if (wished != NULL && strcmp(wished, kernels->name) == 0)
            break;
    }
    return best;
}
