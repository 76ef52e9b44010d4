// Loops on several threads, each with memory of its own.
#include "fracture/parallel_scratch.h"

#include "common/parallel_loop.h"

#include <algorithm>
#include <vector>

void qcForEachInParallel(size_t count, const std::function<void(size_t index, qcClipScratch* scratch)>& function)
{
    const uint32_t workers = uint32_t(std::min(count, size_t(qcWorkersOf(0))));
    std::vector<qcClipScratch> scratch(workers);
    qcForEach(workers, count, 1, [&](size_t index, uint32_t worker) { function(index, &scratch[worker]); });
}
