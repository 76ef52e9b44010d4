// The table and the CSV of `qc-bench piles`.
#ifndef QC_DEMOS_BENCH_PILES_REPORT_H
#define QC_DEMOS_BENCH_PILES_REPORT_H

#include "bench/piles/measure.h"
#include "common/message.h"

/// "qcMeshShape", "btGImpactMeshShape", "btConvexHullShape".
const char* qcPilesName(qcPilesContestant contestant);

void qcPrintPilesHead(unsigned threads);
/// The rows of a scene.
void qcPrintPiles(const std::vector<qcPilesFigures>& scene);
/// What the columns are.
void qcPrintPilesEnd();

/// Writes piles.csv into the folder.
bool qcWritePilesCsv(const char* folder, unsigned threads, const std::vector<qcPilesFigures>& rows, qcMessage* message);

#endif
