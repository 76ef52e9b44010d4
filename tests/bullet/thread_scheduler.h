// A task scheduler of the host's own, for a Bullet that is built without threads.
#ifndef QC_TESTS_BULLET_THREAD_SCHEDULER_H
#define QC_TESTS_BULLET_THREAD_SCHEDULER_H

#include <LinearMath/btThreads.h>

#include <algorithm>
#include <thread>
#include <vector>

/// Starts a thread for each run of `grainSize` iterations, and counts its loops.
class qcThreadScheduler : public btITaskScheduler
{
  public:
    explicit qcThreadScheduler(int threads) : btITaskScheduler("test"), m_threads(threads)
    {
    }

    int getMaxNumThreads() const override
    {
        return m_threads;
    }

    int getNumThreads() const override
    {
        return m_threads;
    }

    void setNumThreads(int threads) override
    {
        m_threads = threads;
    }

    void parallelFor(int begin, int end, int grainSize, const btIParallelForBody& body) override
    {
        loops++;
        maxIterations = std::max(maxIterations, end - begin);
        std::vector<std::thread> threads;
        for (int i = begin; i < end; i += grainSize)
            threads.emplace_back([&body, i, end, grainSize] { body.forLoop(i, std::min(i + grainSize, end)); });
        started += int(threads.size());
        for (std::thread& thread : threads)
            thread.join();
    }

    btScalar parallelSum(int begin, int end, int, const btIParallelSumBody& body) override
    {
        return body.sumLoop(begin, end);
    }

    int loops = 0;
    int started = 0;       ///< threads
    int maxIterations = 0; ///< of a loop

  private:
    int m_threads;
};

#endif
