// What the queries of one scene cost by either method: `auto` starts from costs that were measured once per device on
// another mesh, and goes on from what it sees.
#ifndef QC_PLAN_PLAN_HISTORY_H
#define QC_PLAN_PLAN_HISTORY_H

#include "plan/costs.h"

#include <stdbool.h>
#include <stdint.h>

enum
{
    /// Queries whose mean is the cost of a method: some, since a step of a host may be of several different ones.
    qc_recentQueries = 8,
    /// Queries of a trial: the first ones build what the later ones use.
    qc_trialQueries = qc_recentQueries + 2,
    /// Queries from one trial to the next: at first, and at most. A trial at five times the cost is then 8 % of them.
    qc_firstTrialGap = 512,
    qc_lastTrialGap = 8192
};

/// Milliseconds for each triangle, of the last queries by one method.
typedef struct qcCostRecord
{
    double perTriangle[qc_recentQueries];
    uint32_t count; ///< of all queries so far
} qcCostRecord;

/// All zero before the first query.
typedef struct qcPlanHistory
{
    qcCostRecord sweep, layers;
    uint32_t queries;   ///< so far
    uint32_t nextTrial; ///< number of the query at which the other method may be tried
    uint32_t trialGap;  ///< 0: there was no trial yet
    uint32_t trialLeft; ///< queries left of a trial
    bool onDevice;      ///< the method at present
} qcPlanHistory;

/// Should the next query, of so many triangles, be answered by `layers`? Depends on its arguments alone.
bool qcPlanHistory_Choose(qcPlanHistory* history, const qcPlanCosts* costs, double triangles);
/// Adds what a query took: the stages in which the methods differ.
void qcPlanHistory_Add(qcPlanHistory* history, bool onDevice, double triangles, double ms);

#endif
