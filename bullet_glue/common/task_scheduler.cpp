// Loops of the core through Bullet's btITaskScheduler. One iteration of its parallelFor is one task of the core.
#include "quickcullide/bullet_threads.h"

namespace
{
class Loop : public btIParallelForBody
{
  public:
    Loop(qcTask* task, void* taskContext) : m_task(task), m_taskContext(taskContext)
    {
    }

    void forLoop(int begin, int end) const override
    {
        for (int i = begin; i < end; i++)
            m_task(uint32_t(i), m_taskContext);
    }

  private:
    qcTask* m_task;
    void* m_taskContext;
};

void ParallelFor(uint32_t count, qcTask* task, void* taskContext, void* scheduler)
{
    static_cast<btITaskScheduler*>(scheduler)->parallelFor(0, int(count), 1, Loop(task, taskContext));
}
} // namespace

qcStatus qcSetTaskScheduler(btITaskScheduler* scheduler)
{
    if (scheduler == nullptr)
        return qcSetParallelFor(nullptr, 0, nullptr);
    int threads = scheduler->getNumThreads();
    return qcSetParallelFor(ParallelFor, threads > 0 ? uint32_t(threads) : 0, scheduler);
}
