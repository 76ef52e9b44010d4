// Detects the instruction sets of this CPU and chooses a table of kernels.
#include "base/cpu_features.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static bool IsAvailable(size_t set)
{
#ifdef QC_KERNELS_X86
    if (set == qc_instructionsAvx2)
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (set == qc_instructionsAvx512)
        return IsAvailable(qc_instructionsAvx2) && __builtin_cpu_supports("avx512f") &&
               __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
               __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
#endif
    return set == qc_instructionsScalar;
}

const void* qcKernelTables_Nth(const qcKernelTables* tables, size_t i)
{
    return i < qc_instructionSetCount && IsAvailable(i) ? tables->of[i] : NULL;
}

const void* qcKernelTables_Choose(const qcKernelTables* tables)
{
    static const char* const s_names[qc_instructionSetCount] = {"plain", "avx2", "avx512"};
    const char* requested = getenv("QC_KERNELS");
    size_t set = qc_instructionsScalar;
    while (qcKernelTables_Nth(tables, set + 1) != NULL && (requested == NULL || strcmp(requested, s_names[set]) != 0))
        set++;
    return tables->of[set];
}
