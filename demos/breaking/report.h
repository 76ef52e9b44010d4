// CSV and closing table of the breaking demo.
#ifndef QC_DEMOS_BREAKING_REPORT_H
#define QC_DEMOS_BREAKING_REPORT_H

#include "breaking/world.h"
#include "common/bullet/query_comparison.h"

/// A step and what was measured in it.
struct qcBreakingRow
{
    qcBreakingStep step;
    double cpuMs = 0; ///< of the step, on all threads of the process
    size_t drops = 0; ///< so far
    qcQueryResults results;
};

struct qcBreakingRun
{
    std::vector<qcBreakingRow> rows;
    uint32_t dragonTriangles = 0, bunnyTriangles = 0;
    size_t pieces = 0, pieceTriangles = 0, bonds = 0; ///< of the dragon
    double loadMs = 0;                                ///< reading, cutting, trees
    size_t penetratingPairs = 0;                      ///< of triangles of two bodies, at the end
    bool knotStandsIn = false, ballStandsIn = false;  ///< for the dragon, for the bunny
    std::string fallback;                             ///< why another method than the requested one ran, or empty
};

/// False with a message.
bool qcWriteBreakingCsv(const std::string& path, const qcBreakingRun& run, std::string* message);

void qcPrintBreakingTable(const qcBreakingRun& run, const qcDetectDef& request, const qcDeviceInfo& device);

#endif
