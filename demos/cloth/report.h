// Reports of the cloth demo: a row a step as CSV, and the closing table.
#ifndef QC_DEMOS_CLOTH_REPORT_H
#define QC_DEMOS_CLOTH_REPORT_H

#include "common/bullet/query_comparison.h"
#include "common/bullet/step_costs.h"

#include "quickcullide/bullet_soft_body.h"

#include <string>
#include <vector>

struct qcClothStep
{
    qcStepCosts costs;
    int manifolds = 0;
    qcSoftBodyStatistics statistics;
    qcQueryResults results;
    bool compared = false; ///< false: only the methods that run in each step have results

    /// Pairs at the end of the step, by the exact test.
    size_t Penetrating() const
    {
        return results[qc_querySweep].found;
    }
};

/// One act of a simulation.
struct qcClothRun
{
    bool selfCollision = false;
    bool isPulled = false; ///< the second act
    size_t triangles = 0;
    std::string fallback; ///< reason why another method than the requested one ran, the last time; empty if none did
    std::vector<qcClothStep> steps;
};

/// A column of the report for each run.
using qcClothRuns = std::vector<const qcClothRun*>;

/// Writes all runs. False with a message.
bool qcWriteClothCsv(const std::string& path, const qcClothRuns& runs, double stepSeconds, std::string* message);

/// Prints the closing table to standard output. `method`: requested by the simulation; `request`: the settings of the
/// sampled methods; `device`: where they ran.
void qcPrintClothTable(const qcClothRuns& runs, qcMethod method, const qcDetectDef& request,
                       const qcDeviceInfo& device);

#endif
