// Loops on several threads, each with memory of its own.
#ifndef QC_GLUE_FRACTURE_PARALLEL_SCRATCH_H
#define QC_GLUE_FRACTURE_PARALLEL_SCRATCH_H

#include "fracture/scratch.h"

#include <functional>

/// Calls function(index, scratch) once for each index below `count`, by qcForEach. No two calls at the same time have
/// the same scratch.
void qcForEachInParallel(size_t count, const std::function<void(size_t index, qcClipScratch* scratch)>& function);

#endif
