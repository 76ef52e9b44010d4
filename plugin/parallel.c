// Loops over threads, by OpenMP; without it, one after another.
#include "parallel.h"

#ifdef _OPENMP
#include <omp.h>
#endif

uint32_t qcParallel_Threads(uint32_t requested)
{
#ifdef _OPENMP
    uint32_t threads = requested != 0 ? requested : (uint32_t)omp_get_num_procs();
    return threads < qc_maxWorkers ? threads : qc_maxWorkers;
#else
    (void)requested;
    return 1;
#endif
}

void qcParallel_For(uint32_t threads, size_t count, size_t least, qcParallelFunction* function, void* context)
{
#ifdef _OPENMP
    if (threads > 1 && count >= least)
    {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
        for (size_t i = 0; i < count; i++)
            function(context, i, (uint32_t)omp_get_thread_num());
        return;
    }
#endif
    (void)threads;
    (void)least;
    for (size_t i = 0; i < count; i++)
        function(context, i, 0);
}

void qcParallel_Rest(void)
{
#ifdef _OPENMP
    // Refused inside a parallel region of the caller's, whose threads aren't ours to stop.
    (void)omp_pause_resource(omp_pause_soft, omp_get_initial_device());
#endif
}
