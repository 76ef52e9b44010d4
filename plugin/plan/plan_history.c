// What the queries of one scene cost by either method.
#include "plan/plan_history.h"

#include <math.h>

// A trial is worth while if the other method's estimate is within this factor of what the present one takes. The sweep
// follows small motions at a fraction of its calibrated cost; `layers` does not.
static const double s_sweepHope = 4.0, s_layersHope = 1.5;
// Against going back and forth between methods that cost the same.
static const double s_better = 0.95;

/// Mean of the last queries but for the most expensive one; the estimate if there were not enough.
static double Cost(const qcCostRecord* record, double estimate)
{
    if (record->count < qc_recentQueries)
        return estimate;
    double sum = 0.0, most = 0.0;
    for (int i = 0; i < qc_recentQueries; i++)
    {
        sum += record->perTriangle[i];
        most = fmax(most, record->perTriangle[i]);
    }
    return (sum - most) / (qc_recentQueries - 1);
}

static void StartTrial(qcPlanHistory* history)
{
    history->trialLeft = qc_trialQueries;
    history->trialGap = history->trialGap == 0 ? qc_firstTrialGap : history->trialGap;
    history->nextTrial = history->queries + history->trialGap;
    history->trialGap = history->trialGap < qc_lastTrialGap ? 2 * history->trialGap : qc_lastTrialGap;
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
    else if (history->onDevice ? sweep < s_better * layers : layers < s_better * sweep)
        history->onDevice = !history->onDevice;
    if (query >= history->nextTrial + qc_recentQueries)
    {
        // An old observation gives way to the estimate: the scene may have changed.
        bool hope =
            history->onDevice ? costs->sweepPerTriangle < s_sweepHope * layers : layersEstimate < s_layersHope * sweep;
        if (hope)
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
