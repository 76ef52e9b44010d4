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
    qc_instructionsAvx512, ///< F, BW and VL
    qc_instructionSetCount
} qcInstructionSet;

/// The tables of a room's kernels.
typedef struct qcKernelTables
{
    const void* of[qc_instructionSetCount]; ///< null: none is compiled for the set; the scalar one is never null
} qcKernelTables;

/// The table of the best instruction set that this CPU has, or of the lesser one that the environment's QC_KERNELS
/// names (plain, avx2, avx512).
const void* qcKernelTables_Choose(const qcKernelTables* tables);

/// The table of instruction set `i`, or null if there is none or this CPU doesn't run it: for tests that run all.
const void* qcKernelTables_Nth(const qcKernelTables* tables, size_t i);

#endif
