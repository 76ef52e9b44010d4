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
// A method that takes this many times its estimate: the estimate of the other one is as doubtful. `breaking` of the
// bench's paper on an H200: layers 2.3 times its estimate, sweep 0.3 times.
static const double s_doubtfulRatio = 2.0;

/// The calibrated cost of a query by one method, in milliseconds: fixed + perTriangle * triangles.
typedef struct Estimate
{
    double fixed, perTriangle;
} Estimate;

static double EstimateMs(const Estimate* estimate, double triangles)
{
    return estimate->fixed + estimate->perTriangle * triangles;
}

/// A query's milliseconds as if it had had this count of triangles: the error of the estimate is taken to be a factor.
static double ScaledMs(const qcCostRecord* record, uint32_t at, const Estimate* estimate, double triangles)
{
    double then = EstimateMs(estimate, record->triangles[at]), now = EstimateMs(estimate, triangles);
    bool isUsable = then > 0.0 && isfinite(then);
    return record->ms[at] * (isUsable ? now / then : triangles / record->triangles[at]);
}

/// Milliseconds of a query: the median of the recent ones (other processes delay some); of a few the cheapest one; the
/// estimate before any counts. Where a step has two queries, the middle two costs are one of either.
static double Cost(const qcCostRecord* record, const Estimate* estimate, double triangles)
{
    uint32_t first = record->count < qc_trialQueries ? qc_buildingQueries : record->count - qc_recentQueries;
    if (record->count <= first)
        return EstimateMs(estimate, triangles);
    double sorted[qc_recentQueries];
    uint32_t count = 0;
    for (uint32_t i = first; i < record->count; i++, count++)
    {
        double cost = ScaledMs(record, i % qc_recentQueries, estimate, triangles);
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
static bool IsTimeForTrial(qcPlanHistory* history, uint32_t query, double sweep, double layers, double sweepEstimate,
                           double layersEstimate)
{
    bool isDoubtful =
        history->onDevice ? layers > s_doubtfulRatio * layersEstimate : sweep > s_doubtfulRatio * sweepEstimate;
    uint32_t first = isDoubtful ? qc_earlyTrial : qc_firstTrial;
    if (query < (history->nextTrial == 0 ? first : history->nextTrial))
        return false;
    // The estimate, not an old measurement: the scene may have changed.
    if (!(history->onDevice ? sweepEstimate < s_maxSweepRatio * layers : layersEstimate < s_maxLayersRatio * sweep))
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
    const Estimate bySweep = {0.0, costs->sweepPerTriangle}, byLayers = {costs->layersFixed, costs->layersPerTriangle};
    double sweep = Cost(&history->sweep, &bySweep, triangles), layers = Cost(&history->layers, &byLayers, triangles);
    double current = history->onDevice ? layers : sweep, other = history->onDevice ? sweep : layers;
    const qcCostRecord* record = history->onDevice ? &history->layers : &history->sweep;
    if (query == 0)
        history->onDevice = layers < sweep;
    else if (history->trialLeft > 0)
        JudgeTrial(history, query, current, other);
    else if (record->count >= qc_lostQueries)
    {
        history->regret = other < s_maxSwitchRatio * current ? history->regret + (current - other) / other : 0.0;
        if (history->regret > s_maxRegret ||
            IsTimeForTrial(history, query, sweep, layers, EstimateMs(&bySweep, triangles),
                           EstimateMs(&byLayers, triangles)))
            StartTrial(history);
    }
    return history->onDevice;
}

void qcPlanHistory_Add(qcPlanHistory* history, bool onDevice, double triangles, double ms)
{
    qcCostRecord* record = onDevice ? &history->layers : &history->sweep;
    if (triangles <= 0.0)
        return;
    uint32_t at = record->count++ % qc_recentQueries;
    record->ms[at] = ms;
    record->triangles[at] = triangles;
}
