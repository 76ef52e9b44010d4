// The cost of a step in each demo scene: Bullet alone, and this library.
#ifndef QC_DEMOS_BENCH_SOFT_DEMO_TABLE_H
#define QC_DEMOS_BENCH_SOFT_DEMO_TABLE_H

#include "common/message.h"

#include <cstdint>

/// Prints the table and writes soft_demos.csv into the folder.
bool qcDemoTable_Run(const char* folder, uint32_t steps, qcMessage* message);

#endif
