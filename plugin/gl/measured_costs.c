// A short list behind a mutex.
#include "gl/measured_costs.h"

#include <string.h>

void qcMeasuredCosts_Init(qcMeasuredCosts* measured)
{
    memset(measured->items, 0, sizeof measured->items);
    pthread_mutex_init(&measured->mutex, NULL);
}

void qcMeasuredCosts_Destroy(qcMeasuredCosts* measured)
{
    pthread_mutex_destroy(&measured->mutex);
}

void qcMeasuredCosts_Clear(qcMeasuredCosts* measured)
{
    pthread_mutex_lock(&measured->mutex);
    memset(measured->items, 0, sizeof measured->items);
    pthread_mutex_unlock(&measured->mutex);
}

bool qcMeasuredCosts_Find(qcMeasuredCosts* measured, uint32_t threads, qcPlanCosts* costs)
{
    bool found = false;
    pthread_mutex_lock(&measured->mutex);
    for (int i = 0; i < qc_maxCosts && !found; i++)
    {
        found = measured->items[i].threads == threads;
        if (found)
            *costs = measured->items[i].costs;
    }
    pthread_mutex_unlock(&measured->mutex);
    return found;
}

void qcMeasuredCosts_Keep(qcMeasuredCosts* measured, uint32_t threads, const qcPlanCosts* costs)
{
    pthread_mutex_lock(&measured->mutex);
    int i = 0;
    while (i < qc_maxCosts - 1 && measured->items[i].threads != 0 && measured->items[i].threads != threads)
        i++;
    measured->items[i].threads = threads;
    measured->items[i].costs = *costs;
    pthread_mutex_unlock(&measured->mutex);
}
