// The instruction sets that kernels are compiled for, and which of them are run.
#ifndef QC_BASE_CPU_FEATURES_H
#define QC_BASE_CPU_FEATURES_H

#include <stdbool.h>

/// Ascending: each includes the previous ones.
typedef enum qcInstructionSet
{
    qc_instructionsScalar, ///< the compiler's default
    qc_instructionsAvx2,   ///< with FMA
    qc_instructionsAvx512  ///< F, BW and VL
} qcInstructionSet;

/// True if this machine supports the set and kernels for it were compiled.
bool qcInstructionSet_IsAvailable(qcInstructionSet set);

/// The best available set up to `max`, limited by the environment variable QC_KERNELS (plain, avx2, avx512).
qcInstructionSet qcInstructionSet_Choose(qcInstructionSet max);

#endif
