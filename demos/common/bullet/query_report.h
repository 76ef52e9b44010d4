// Reports of compared queries: columns of a CSV, and the closing table of a demo.
#ifndef QC_DEMOS_COMMON_BULLET_QUERY_REPORT_H
#define QC_DEMOS_COMMON_BULLET_QUERY_REPORT_H

#include "common/bullet/query_comparison.h"

#include <cstdio>
#include <vector>

/// The columns' names, each after a comma: the end of a heading.
void qcWriteQueryHeading(FILE* stream);
/// The columns of one step: the end of a row. Columns of queries that did not run are empty.
void qcWriteQueryColumns(FILE* stream, const qcQueryResults& results);

/// Prints what the rows of the tables have in common: device, views, resolution, rounds. `resolution`: of the sampled
/// methods' results; 0: there are none. Prints why there is no table then, and if the device is of kind none.
void qcPrintQuerySettings(const qcDetectDef& request, uint32_t resolution, const qcDeviceInfo& device);
/// Prints mean sizes, median times (a few delays by other processes would dominate their mean) and sums over frames
/// whose missed pairs were counted, a row for each query that ran. Without frames it prints nothing.
void qcPrintQueryTable(const char* label, const std::vector<const qcQueryResults*>& frames);

#endif
