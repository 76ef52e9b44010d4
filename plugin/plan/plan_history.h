// Measured costs of one scene's queries by either method. `auto` starts from the costs of the device, which were
// measured on another mesh, and continues with these.
#ifndef QC_PLAN_PLAN_HISTORY_H
#define QC_PLAN_PLAN_HISTORY_H

#include "plan/costs.h"

#include <stdbool.h>
#include <stdint.h>

enum
{
    /// Queries whose median is the cost of a method. Several, since a step of a host may consist of different queries.
    qc_recentQueries = 8,
    /// First queries of a method, which build data that the later ones reuse. They don't count as costs.
    qc_buildingQueries = 2,
    /// Queries of a trial, unless the first ones show that it is lost.
    qc_trialQueries = qc_buildingQueries + qc_recentQueries,
    /// Queries after which a trial may be lost: more than one counts, since other processes delay some.
    qc_lostQueries = qc_buildingQueries + 3,
    /// Number of the first query at which a trial may start. A method's first query takes as long as some ten others
    /// (cloth of 20 K triangles): a short run has no trial, and in a longer one it adds less than 10 %.
    qc_firstTrial = 128,
    /// Likewise, where the calibration does not describe the scene: a method takes many times its estimate.
    qc_earlyTrial = 16,
    /// Queries from a switch to a trial of the previous method.
    qc_confirmGap = 32,
    /// Queries between trials: initially and at most.
    qc_firstTrialGap = 512,
    qc_maxTrialGap = 8192
};

/// The last queries by one method.
typedef struct qcCostRecord
{
    double ms[qc_recentQueries], triangles[qc_recentQueries];
    uint32_t count; ///< queries since the first one or the start of the last trial; a ring buffer's position
} qcCostRecord;

/// All zero before the first query.
typedef struct qcPlanHistory
{
    qcCostRecord sweep, layers;
    uint32_t queries;   ///< so far
    uint32_t nextTrial; ///< number of the query at which the other method may be tried; 0: there was no trial yet
    uint32_t trialGap;  ///< from nextTrial to the one after it
    uint32_t trialLeft; ///< remaining queries of a trial
    bool onDevice;      ///< the current method
    /// Excess cost of the successive queries at which the other method's last cost was lower, in queries of its.
    double regret;
} qcPlanHistory;

/// True if the next query, with this count of triangles, is to run by `layers`. Depends on its arguments alone.
bool qcPlanHistory_Choose(qcPlanHistory* history, const qcPlanCosts* costs, double triangles);
/// Adds the milliseconds of a query, up to its exact tests; what is equal for all methods may be left out.
void qcPlanHistory_Add(qcPlanHistory* history, bool onDevice, double triangles, double ms);

#endif
