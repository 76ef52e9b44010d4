// The table and the CSV of `qc-bench fracture`.
#ifndef QC_DEMOS_BENCH_FRACTURE_REPORT_H
#define QC_DEMOS_BENCH_FRACTURE_REPORT_H

#include "bench/fracture/measure.h"
#include "common/message.h"

void qcPrintFractureHead();
void qcPrintFractureRow(const qcFractureRow& row);
/// What the columns are.
void qcPrintFractureEnd();

/// Writes fracture.csv into the folder.
bool qcWriteFractureRows(const char* folder, const std::vector<qcFractureRow>& rows, qcMessage* message);

#endif
