// Measured costs of queries, and trials of the other method.
#include "plan/plan_history.h"

#include <math.h>

// A trial starts if the other method's estimate is below this factor times the current cost. With small motions the
// sweep takes a fraction of its calibrated cost; `layers` does not.
static const double s_maxSweepRatio = 4.0, s_maxLayersRatio = 1.5;
// A switch, and a trial out of turn, require this ratio of costs, so that methods of equal cost don't alternate.
static const double s_maxSwitchRatio = 0.95;
// A trial out of turn starts when the queries since the other method became cheaper have cost this many of its queries
// more: a few queries if it is many times as fast, many if it is a little faster. A trial that is lost costs about
// five.
static const double s_maxRegret = 8.0;
// A trial is lost when even its cheapest query costs this many times the other method's median.
// With one query less it takes a ratio that delays hardly explain.
static const double s_lostRatio = 1.25, s_clearlyLostRatio = 2.0;
// A method that was this many times as expensive before a switch is not tried again soon.
static const double s_clearRatio = 4.0;

/// Median of the recent queries (other processes delay some); of a few queries the cheapest one; the estimate before
/// any counts. Where a step has two queries, the middle two costs are one of either.
static double Cost(const qcCostRecord* record, double estimate)
{
    uint32_t first = record->count < qc_trialQueries ? qc_buildingQueries : record->count - qc_recentQueries;
    if (record->count <= first)
        return estimate;
    double sorted[qc_recentQueries];
    uint32_t count = 0;
    for (uint32_t i = first; i < record->count; i++, count++)
    {
        double cost = record->perTriangle[i % qc_recentQueries];
        uint32_t place = count;
        for (; place > 0 && sorted[place - 1] > cost; place--)
            sorted[place] = sorted[place - 1];
        sorted[place] = cost;
    }
    return count < qc_recentQueries ? sorted[0]
                                    : (sorted[qc_recentQueries / 2 - 1] + sorted[qc_recentQueries / 2]) / 2.0;
}

/// Runs the other method for some queries.
static void StartTrial(qcPlanHistory* history)
{
    history->onDevice = !history->onDevice;
    history->trialLeft = qc_trialQueries;
    history->regret = 0.0;
    // Costs of long ago are no costs of this trial.
    (history->onDevice ? &history->layers : &history->sweep)->count = 0;
}

/// Whether the scheduled trial is to start now, which schedules the next one.
static bool IsTimeForTrial(qcPlanHistory* history, uint32_t query, double sweep, double layers,
                           const qcPlanCosts* costs, double layersEstimate)
{
    if (query < (history->nextTrial == 0 ? qc_firstTrial : history->nextTrial))
        return false;
    // The estimate, not an old measurement: the scene may have changed.
    if (!(history->onDevice ? costs->sweepPerTriangle < s_maxSweepRatio * layers
                            : layersEstimate < s_maxLayersRatio * sweep))
        return false;
    history->trialGap = history->trialGap == 0 ? qc_firstTrialGap : history->trialGap;
    history->nextTrial = query + history->trialGap;
    history->trialGap = history->trialGap < qc_maxTrialGap ? 2 * history->trialGap : qc_maxTrialGap;
    return true;
}

/// Ends a trial after its last query, or as soon as it is lost.
static void JudgeTrial(qcPlanHistory* history, uint32_t query, double tried, double other)
{
    history->trialLeft--;
    const qcCostRecord* record = history->onDevice ? &history->layers : &history->sweep;
    bool isLost = (record->count >= qc_lostQueries && tried > s_lostRatio * other) ||
                  (record->count >= qc_lostQueries - 1 && tried > s_clearlyLostRatio * other);
    if (!isLost && history->trialLeft > 0)
        return;
    history->trialLeft = 0;
    if (isLost || tried >= s_maxSwitchRatio * other)
        history->onDevice = !history->onDevice;
    else // most of the other method's recent queries may have been delayed
        history->nextTrial =
            query + (other < s_clearRatio * tried ? (uint32_t)qc_confirmGap : (uint32_t)qc_firstTrialGap);
}

bool qcPlanHistory_Choose(qcPlanHistory* history, const qcPlanCosts* costs, double triangles)
{
    uint32_t query = history->queries++;
    double layersEstimate = costs->layersFixed / triangles + costs->layersPerTriangle;
    double sweep = Cost(&history->sweep, costs->sweepPerTriangle), layers = Cost(&history->layers, layersEstimate);
    double current = history->onDevice ? layers : sweep, other = history->onDevice ? sweep : layers;
    const qcCostRecord* record = history->onDevice ? &history->layers : &history->sweep;
    if (query == 0)
        history->onDevice = layers < sweep;
    else if (history->trialLeft > 0)
        JudgeTrial(history, query, current, other);
    else if (record->count >= qc_lostQueries)
    {
        history->regret = other < s_maxSwitchRatio * current ? history->regret + (current - other) / other : 0.0;
        if (history->regret > s_maxRegret || IsTimeForTrial(history, query, sweep, layers, costs, layersEstimate))
            StartTrial(history);
    }
    return history->onDevice;
}

void qcPlanHistory_Add(qcPlanHistory* history, bool onDevice, double triangles, double ms)
{
    qcCostRecord* record = onDevice ? &history->layers : &history->sweep;
    if (triangles > 0.0)
        record->perTriangle[record->count++ % qc_recentQueries] = ms / triangles;
}
