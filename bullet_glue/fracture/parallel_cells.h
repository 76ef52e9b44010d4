// Loops over cells on the threads that the library's loops use.
#ifndef QC_GLUE_FRACTURE_PARALLEL_CELLS_H
#define QC_GLUE_FRACTURE_PARALLEL_CELLS_H

#include "fracture/scratch.h"

#include <functional>

/// Calls function(index, scratch) once for each index below `count`, by qcForEach. No two calls at the same time have
/// the same scratch.
void qcForEachInParallel(size_t count, const std::function<void(size_t index, qcClipScratch* scratch)>& function);

#endif
