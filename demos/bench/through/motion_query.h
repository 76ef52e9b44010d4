// The time of the motion query beside the plain one.
#ifndef QC_DEMOS_BENCH_THROUGH_MOTION_QUERY_H
#define QC_DEMOS_BENCH_THROUGH_MOTION_QUERY_H

#include "common/message.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Runs both queries in turns on the frames of folded cloths in motion, of up to `maxTriangles` triangles, with one
/// thread and with all, and prints medians and their ratio. On Ctrl-C it ends before its time.
bool qcMeasureMotionQuery(uint32_t maxTriangles, qcMessage* message);

#ifdef __cplusplus
}
#endif

#endif
