// The instruction sets that kernels are compiled for, and which of them are run.
#ifndef QC_BASE_CPU_FEATURES_H
#define QC_BASE_CPU_FEATURES_H

#include <stdbool.h>

/// Each has those before it.
typedef enum qcInstructionSet
{
    qc_instructionsScalar, ///< what the compiler takes by default
    qc_instructionsAvx2,   ///< with FMA
    qc_instructionsAvx512  ///< F, BW and VL
} qcInstructionSet;

/// Does this machine run it, and has it been compiled?
bool qcInstructionSet_IsAvailable(qcInstructionSet set);

/// The best up to `most` that is there; or a lesser one that the environment's QC_KERNELS names (plain, avx2, avx512).
qcInstructionSet qcInstructionSet_Choose(qcInstructionSet most);

#endif
