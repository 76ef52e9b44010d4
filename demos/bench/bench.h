// The benchmarks of qc-bench.
#ifndef QC_DEMOS_BENCH_BENCH_H
#define QC_DEMOS_BENCH_BENCH_H

#include "common/exit_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Run time against error. `arguments[0]` is "qc-bench accuracy"; ends the program after --help and on a mistake.
qcExitStatus qcBench_RunAccuracy(int argumentCount, char** arguments);
/// This library's sweep beside other libraries; likewise.
qcExitStatus qcBench_RunPeers(int argumentCount, char** arguments);
/// Time and memory against size; likewise.
qcExitStatus qcBench_RunScaling(int argumentCount, char** arguments);
/// layers on a GL device beside sweep; likewise.
qcExitStatus qcBench_RunGpu(int argumentCount, char** arguments);
/// qcBroadphase beside Bullet's own; likewise. Only where Bullet was found (QC_HAS_BULLET).
qcExitStatus qcBench_RunBroadphase(int argumentCount, char** arguments);
/// Soft bodies beside Bullet alone; likewise. Only where Bullet was found.
qcExitStatus qcBench_RunSoft(int argumentCount, char** arguments);

#ifdef __cplusplus
}
#endif

#endif
