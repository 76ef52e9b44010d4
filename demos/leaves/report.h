// Reports of the leaves demo: a row a step as CSV, and the closing table.
#ifndef QC_DEMOS_LEAVES_REPORT_H
#define QC_DEMOS_LEAVES_REPORT_H

#include "common/bullet/query_comparison.h"
#include "common/bullet/step_costs.h"

#include <string>
#include <vector>

struct qcLeavesStep
{
    qcStepCosts costs;
    qcSoftBodyStatistics statistics;
    size_t hanging = 0;     ///< leaves on the tree
    double energy = 0;      ///< kinetic, J
    double lowest = 0;      ///< height of the lowest vertex of a leaf, m
    qcQueryResults results; ///< of a frame
};

struct qcLeavesRun
{
    size_t leaves = 0, requestedLeaves = 0, triangles = 0, treeTriangles = 0;
    std::string fallback; ///< reason why another method than the requested one ran, the last time; empty if none did
    std::vector<qcLeavesStep> steps;
};

/// False with a message.
bool qcWriteLeavesCsv(const std::string& path, const qcLeavesRun& run, std::string* message);

/// Prints the closing table to standard output. `method`: requested by the simulation; `request`: the settings of the
/// sampled methods; `device`: where they ran.
void qcPrintLeavesTable(const qcLeavesRun& run, qcMethod method, const qcDetectDef& request,
                        const qcDeviceInfo& device);

#endif
