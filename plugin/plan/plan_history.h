// Measured costs of one scene's queries by either method. `auto` starts from the costs of the device, which were
// measured on another mesh, and continues with these.
#ifndef QC_PLAN_PLAN_HISTORY_H
#define QC_PLAN_PLAN_HISTORY_H

#include "plan/costs.h"

#include <stdbool.h>
#include <stdint.h>

enum
{
    /// Queries whose mean is the cost of a method. Several, since a step of a host may consist of different queries.
    qc_recentQueries = 8,
    /// Queries of a trial: the first ones build data that the later ones reuse.
    qc_trialQueries = qc_recentQueries + 2,
    /// Queries between trials: initially and at most. Trials at five times the cost then add 8 %.
    qc_firstTrialGap = 512,
    qc_maxTrialGap = 8192
};

/// Milliseconds per triangle of the last queries by one method.
typedef struct qcCostRecord
{
    double perTriangle[qc_recentQueries];
    uint32_t count; ///< all queries so far, a ring buffer's position
} qcCostRecord;

/// All zero before the first query.
typedef struct qcPlanHistory
{
    qcCostRecord sweep, layers;
    uint32_t queries;   ///< so far
    uint32_t nextTrial; ///< number of the query at which the other method may be tried
    uint32_t trialGap;  ///< 0: there was no trial yet
    uint32_t trialLeft; ///< remaining queries of a trial
    bool onDevice;      ///< the current method
} qcPlanHistory;

/// True if the next query, with this count of triangles, is to run by `layers`. Depends on its arguments alone.
bool qcPlanHistory_Choose(qcPlanHistory* history, const qcPlanCosts* costs, double triangles);
/// Adds the milliseconds of a query, of the stages in which the methods differ.
void qcPlanHistory_Add(qcPlanHistory* history, bool onDevice, double triangles, double ms);

#endif
