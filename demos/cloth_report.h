// What the cloth demo measured: a row a step as CSV, and the closing table.
#ifndef QC_DEMOS_CLOTH_REPORT_H
#define QC_DEMOS_CLOTH_REPORT_H

#include "cloth_measure.h"
#include "quickcullide/bullet_soft_body.h"

#include <string>
#include <vector>

/// The image methods on the cloth of one step.
struct qcClothComparison
{
    qcClothAnswer cullide, quick;
};

struct qcClothStep
{
    double stepMs = 0;
    size_t penetrating = 0; ///< exactly, at the end of the step
    int manifolds = 0;
    qcSoftBodyStatistics statistics;
    bool compared = false; ///< `comparison` is filled
    qcClothComparison comparison;
};

/// One simulation from start to end.
struct qcClothRun
{
    bool selfCollision = false;
    std::vector<qcClothStep> steps;
};

/// Writes both runs. False with a message.
bool qcWriteClothCsv(const std::string& path, const qcClothRun& with, const qcClothRun& without, double stepSeconds,
                     std::string* message);

/// Prints the closing table to standard output. `request`: how the image methods were asked; `device`: on what.
void qcPrintClothTable(const qcClothRun& with, const qcClothRun& without, size_t triangles, const qcDetectDef& request,
                       const qcDeviceInfo& device);

#endif
