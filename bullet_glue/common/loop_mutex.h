// A mutex that is held while a loop runs on a task scheduler. A scheduler may run other tasks on a thread that waits
// for its loop, as those of TBB and of most job systems do: such a task can't wait for the mutex.
#ifndef QC_GLUE_COMMON_LOOP_MUTEX_H
#define QC_GLUE_COMMON_LOOP_MUTEX_H

#include <atomic>
#include <mutex>
#include <thread>

/// For std::lock_guard and std::unique_lock.
class qcLoopMutex
{
  public:
    void lock()
    {
        m_mutex.lock();
        m_holder.store(std::this_thread::get_id(), std::memory_order_relaxed);
    }
    void unlock()
    {
        m_holder.store(std::thread::id(), std::memory_order_relaxed);
        m_mutex.unlock();
    }
    /// Whether this thread holds it: the caller is a task that runs while the holder waits.
    bool IsHeldHere() const
    {
        return m_holder.load(std::memory_order_relaxed) == std::this_thread::get_id();
    }

  private:
    std::mutex m_mutex;
    std::atomic<std::thread::id> m_holder{std::thread::id()};
};

#endif
