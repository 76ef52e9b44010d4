// Reports of the fracture demo: a row a step as CSV, and the closing table.
#ifndef QC_DEMOS_FRACTURE_REPORT_H
#define QC_DEMOS_FRACTURE_REPORT_H

#include "fracture/world.h"

#include <string>
#include <vector>

struct qcFractureRun
{
    uint32_t triangles = 0; ///< of the whole body
    btScalar mass = 0;      ///< kg
    std::string fallback;   ///< reason why another method than the requested one ran, the last time; empty if none did
    std::vector<qcFractureStep> steps;
    qcBreak broken;
    size_t penetratingPairs = 0; ///< pairs of triangles of two pieces at the end, by the exact test
};

/// False with a message.
bool qcWriteFractureCsv(const std::string& path, const qcFractureRun& run, std::string* message);

/// Prints the closing table to standard output.
void qcPrintFractureTable(const qcFractureRun& run, const qcDeviceInfo& device);

#endif
