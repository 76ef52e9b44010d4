// The table of `qc-bench through`, with the rows of version 0.2.0 beside it, and its CSV.
#ifndef QC_DEMOS_BENCH_THROUGH_REPORT_H
#define QC_DEMOS_BENCH_THROUGH_REPORT_H

#include "bench/through/measure.h"
#include "common/message.h"

/// The rows of a CSV that qcWriteThroughCsv has written; lines that begin with '#' are left out.
std::vector<qcThroughRow> qcReadThroughCsv(const char* text);
/// The rows that version 0.2.0 made: before.csv, which is part of the program.
const std::vector<qcThroughRow>& qcThroughRowsBefore();

void qcPrintThroughHead();
/// A line: where 0.2.0 has such a row too, "its figure > the present one".
void qcPrintThroughRow(const qcThroughRow& row);
/// "N of M rows without a penetrating pair", and where energy grew.
void qcPrintThroughEnd(const std::vector<qcThroughRow>& rows);
/// True if no row has a penetrating pair (of a crushed cloth: none that was not reported) or a failed step.
bool qcIsThroughFree(const qcThroughRow& row);

bool qcWriteThroughCsv(const char* path, const std::vector<qcThroughRow>& rows, qcMessage* message);

#endif
