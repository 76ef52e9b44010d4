// Instruction sets of the processor.
#include "base/cpu_features.h"

#include <stdlib.h>
#include <string.h>

bool qcInstructionSet_IsAvailable(qcInstructionSet set)
{
#ifdef QC_KERNELS_X86
    if (set == qc_instructionsAvx2)
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (set == qc_instructionsAvx512)
        return qcInstructionSet_IsAvailable(qc_instructionsAvx2) && __builtin_cpu_supports("avx512f") &&
               __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
#endif
    return set == qc_instructionsScalar;
}

qcInstructionSet qcInstructionSet_Choose(qcInstructionSet max)
{
    static const char* const s_names[] = {"plain", "avx2", "avx512"};
    const char* limit = getenv("QC_KERNELS");
    qcInstructionSet set = qc_instructionsScalar;
    while (set < max && qcInstructionSet_IsAvailable(set + 1) && (limit == NULL || strcmp(limit, s_names[set]) != 0))
        set++;
    return set;
}
