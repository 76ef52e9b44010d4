// Loops by qcParallelFor over functions that may throw.
#include "common/parallel_loop.h"

#include "quickcullide/base.h"

#include <algorithm>
#include <exception>
#include <vector>

namespace
{
struct ThrowingLoop
{
    const std::function<void(size_t, uint32_t)>& function;
    size_t count, block;
    std::vector<std::exception_ptr> thrown; ///< by worker

    void Run(size_t index, uint32_t worker) const
    {
        for (size_t i = index * block; i < std::min((index + 1) * block, count); i++)
            function(i, worker);
    }
};

/// Catches what the function throws: the loop's own code is C.
void RunBlock(size_t index, uint32_t worker, void* context)
{
    auto* loop = static_cast<ThrowingLoop*>(context);
    if (loop->thrown[worker])
        return;
    try
    {
        loop->Run(index, worker);
    }
    catch (...)
    {
        loop->thrown[worker] = std::current_exception();
    }
}
} // namespace

uint32_t qcWorkersOf(unsigned threads)
{
    constexpr unsigned maxThreads = 256; // see qcSetParallelFor
    return threads > 0 ? uint32_t(std::min(threads, maxThreads)) : qcGetWorkerCount();
}

void qcForEach(uint32_t workers, size_t count, size_t block,
               const std::function<void(size_t index, uint32_t worker)>& function)
{
    ThrowingLoop loop{function, count, block, std::vector<std::exception_ptr>(workers)};
    qcParallelFor(workers, (count + block - 1) / block, RunBlock, &loop);
    for (const std::exception_ptr& exception : loop.thrown)
        if (exception)
            std::rethrow_exception(exception);
}
