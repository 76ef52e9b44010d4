// Loops over cells by qcParallelFor.
#include "fracture/parallel_cells.h"

#include "quickcullide/base.h"

#include <exception>

namespace
{
struct Worker
{
    qcClipScratch scratch;
    std::exception_ptr exception; ///< ends this worker's calls
};

struct Loop
{
    const std::function<void(size_t, qcClipScratch*)>& function;
    std::vector<Worker> workers;
};

/// Catches what the function throws: the loop's own code is C.
void CallOne(size_t index, uint32_t number, void* context)
{
    auto* loop = static_cast<Loop*>(context);
    Worker& worker = loop->workers[number];
    if (worker.exception)
        return;
    try
    {
        loop->function(index, &worker.scratch);
    }
    catch (...)
    {
        worker.exception = std::current_exception();
    }
}
} // namespace

void qcForEachInParallel(size_t count, const std::function<void(size_t index, qcClipScratch* scratch)>& function)
{
    if (count == 0)
        return;
    uint32_t workers = uint32_t(std::min(count, size_t(qcGetWorkerCount())));
    Loop loop{function, std::vector<Worker>(workers)};
    qcParallelFor(workers, count, CallOne, &loop);
    for (const Worker& worker : loop.workers)
        if (worker.exception)
            std::rethrow_exception(worker.exception);
}
