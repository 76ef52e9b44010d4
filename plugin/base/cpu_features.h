// The instruction sets that kernels are compiled for, and the choice among them at run time. A room that has kernels
// compiles one table of functions for each set, and lists its tables in the order of qcInstructionSet.
#ifndef QC_BASE_CPU_FEATURES_H
#define QC_BASE_CPU_FEATURES_H

#include <stddef.h>

/// Each includes the ones above it.
typedef enum qcInstructionSet
{
    qc_instructionsScalar, ///< the compiler's default
    qc_instructionsAvx2,   ///< with FMA
    qc_instructionsAvx512  ///< F, BW and VL
} qcInstructionSet;

/// The table of the best instruction set that this CPU has, or of the lesser one that the environment's QC_KERNELS
/// names (plain, avx2, avx512). tables[0] is the scalar one; `count` is at least 1.
const void* qcKernelTables_Choose(const void* const* tables, size_t count);

/// tables[i], or null if there is none or this CPU doesn't run it: for tests that run all of them.
const void* qcKernelTables_Nth(const void* const* tables, size_t count, size_t i);

#endif
