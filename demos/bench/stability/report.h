// The table, the CSV and the pictures of `qc-bench stability`.
#ifndef QC_DEMOS_BENCH_STABILITY_REPORT_H
#define QC_DEMOS_BENCH_STABILITY_REPORT_H

#include "bench/stability/history.h"
#include "common/message.h"

#include <vector>

void qcPrintStabilityHead();
/// A row of the table, with the verdict.
void qcPrintStabilityRow(const qcStabilityHistory& history);
/// What the columns are, and each complaint.
void qcPrintStabilityEnd(const std::vector<qcStabilityHistory>& histories);

/// Writes stability.csv into the folder.
bool qcWriteStabilityCsv(const char* folder, const std::vector<qcStabilityHistory>& histories, qcMessage* message);
/// Writes stability.gp and runs gnuplot: a picture for each scene.
bool qcPlotStability(const char* folder, const std::vector<qcStabilityHistory>& histories, qcMessage* message);

#endif
