// Loops over functions that may throw.
#include "common/parallel_loop.h"
#include "quickcullide/base.h"

#include <atomic>
#include <stdexcept>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr uint32_t s_workers = 4;

START_TEST(each_index_is_called_once_by_a_worker_that_runs_one_call_at_a_time)
{
    for (size_t block : {1u, 7u, 64u})
        for (size_t count : {0u, 1u, 6u, 7u, 8u, 1000u})
        {
            std::vector<std::atomic<int>> calls(count), running(s_workers);
            std::atomic<int> overlaps{0};
            qcForEach(s_workers, count, block,
                      [&](size_t i, uint32_t worker)
                      {
                          overlaps += worker >= s_workers || running[worker]++ != 0;
                          calls[i]++;
                          running[worker]--;
                      });
            ck_assert_int_eq(overlaps, 0);
            for (const std::atomic<int>& some : calls)
                ck_assert_int_eq(some, 1);
        }
}
END_TEST

START_TEST(what_a_call_throws_is_thrown_when_all_have_returned)
{
    for (uint32_t workers : {1u, s_workers})
    {
        std::atomic<int> running{0}, thrown{0};
        bool isCaught = false;
        try
        {
            qcForEach(workers, 1000, 3,
                      [&](size_t i, uint32_t)
                      {
                          running++;
                          if (i == 500)
                              thrown++;
                          running--;
                          if (i == 500)
                              throw std::runtime_error("500");
                      });
        }
        catch (const std::runtime_error& error)
        {
            isCaught = error.what() == std::string("500");
        }
        ck_assert(isCaught);
        ck_assert_int_eq(thrown, 1);
        ck_assert_int_eq(running, 0);
    }
    // Loops work on after that.
    std::atomic<int> calls{0};
    qcForEach(s_workers, 100, 1, [&](size_t, uint32_t) { calls++; });
    ck_assert_int_eq(calls, 100);
}
END_TEST

START_TEST(no_number_of_threads_is_one_a_core)
{
    ck_assert_uint_eq(qcWorkersOf(0), qcGetWorkerCount());
    ck_assert_uint_eq(qcWorkersOf(3), 3);
    ck_assert_uint_eq(qcWorkersOf(100000), 256);
}
END_TEST
} // namespace

QC_RUN_TESTS("parallel loop", each_index_is_called_once_by_a_worker_that_runs_one_call_at_a_time,
             what_a_call_throws_is_thrown_when_all_have_returned, no_number_of_threads_is_one_a_core)
