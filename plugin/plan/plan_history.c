// Measured costs of queries, and trials of the other method.
#include "plan/plan_history.h"

#include <math.h>

// A trial starts if the other method's estimate is below this factor times the current cost. With small motions the
// sweep takes a fraction of its calibrated cost; `layers` does not.
static const double s_maxSweepRatio = 4.0, s_maxLayersRatio = 1.5;
// A switch requires this ratio of costs, so that methods of equal cost don't alternate.
static const double s_maxSwitchRatio = 0.95;

/// Mean of the recent queries without the most expensive one, or the estimate if there are too few.
static double Cost(const qcCostRecord* record, double estimate)
{
    if (record->count < qc_recentQueries)
        return estimate;
    double sum = 0.0, max = 0.0;
    for (int i = 0; i < qc_recentQueries; i++)
    {
        sum += record->perTriangle[i];
        max = fmax(max, record->perTriangle[i]);
    }
    return (sum - max) / (qc_recentQueries - 1);
}

static void StartTrial(qcPlanHistory* history)
{
    history->trialLeft = qc_trialQueries;
    history->trialGap = history->trialGap == 0 ? qc_firstTrialGap : history->trialGap;
    history->nextTrial = history->queries + history->trialGap;
    history->trialGap = history->trialGap < qc_maxTrialGap ? 2 * history->trialGap : qc_maxTrialGap;
    history->onDevice = !history->onDevice;
}

bool qcPlanHistory_Choose(qcPlanHistory* history, const qcPlanCosts* costs, double triangles)
{
    uint32_t query = history->queries++;
    if (history->trialLeft > 0)
    {
        history->trialLeft--;
        if (history->trialLeft > 0)
            return history->onDevice;
    }
    double layersEstimate = costs->layersFixed / triangles + costs->layersPerTriangle;
    double sweep = Cost(&history->sweep, costs->sweepPerTriangle), layers = Cost(&history->layers, layersEstimate);
    if (query == 0)
        history->onDevice = layers < sweep;
    else if (history->onDevice ? sweep < s_maxSwitchRatio * layers : layers < s_maxSwitchRatio * sweep)
        history->onDevice = !history->onDevice;
    if (query >= history->nextTrial + qc_recentQueries)
    {
        // The estimate, not an old measurement: the scene may have changed.
        bool worthTrial = history->onDevice ? costs->sweepPerTriangle < s_maxSweepRatio * layers
                                            : layersEstimate < s_maxLayersRatio * sweep;
        if (worthTrial)
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
