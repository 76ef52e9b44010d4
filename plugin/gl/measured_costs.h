// The measured costs of both methods, by number of threads: a device keeps them for all scenes that use it.
#ifndef QC_GL_MEASURED_COSTS_H
#define QC_GL_MEASURED_COSTS_H

#include "plan/costs.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

enum
{
    qc_maxCosts = 8 ///< numbers of threads; further ones replace the last
};

/// Any thread may call its functions, but for Init and Destroy.
typedef struct qcMeasuredCosts
{
    pthread_mutex_t mutex;
    struct
    {
        uint32_t threads; ///< 0: none
        qcPlanCosts costs;
    } items[qc_maxCosts];
} qcMeasuredCosts;

void qcMeasuredCosts_Init(qcMeasuredCosts* measured);
void qcMeasuredCosts_Destroy(qcMeasuredCosts* measured);
/// Forgets all costs.
void qcMeasuredCosts_Clear(qcMeasuredCosts* measured);
/// False: there are none for this number of threads.
bool qcMeasuredCosts_Find(qcMeasuredCosts* measured, uint32_t threads, qcPlanCosts* costs);
void qcMeasuredCosts_Keep(qcMeasuredCosts* measured, uint32_t threads, const qcPlanCosts* costs);

#endif
