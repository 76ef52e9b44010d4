// Loops by qcParallelFor over functions that may throw.
#ifndef QC_GLUE_COMMON_PARALLEL_LOOP_H
#define QC_GLUE_COMMON_PARALLEL_LOOP_H

#include <cstddef>
#include <cstdint>
#include <functional>

/// Threads that qcForEach runs on; `threads`: 0: one per core, or the number given to qcSetParallelFor.
uint32_t qcWorkersOf(unsigned threads);

/// Calls function(index, worker) once for each index below `count`, on up to `workers` threads that take `block` calls
/// at a time, and returns when all have returned. No two calls at the same time have the same worker, a number below
/// `workers`. Once a call has thrown, its worker makes no further ones, and the exception is thrown at the end.
void qcForEach(uint32_t workers, size_t count, size_t block,
               const std::function<void(size_t index, uint32_t worker)>& function);

#endif
