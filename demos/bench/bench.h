// What the benchmarks of qc-bench share: how they end, and the list of them.
#ifndef QC_DEMOS_BENCH_BENCH_H
#define QC_DEMOS_BENCH_BENCH_H

/// Exit statuses, part of what the tool promises.
typedef enum qcBenchExit
{
    qc_benchDone = 0,
    qc_benchBroken = 1, ///< output could not be written, out of memory, or a method broke its promise
    qc_benchUsage = 2,
    qc_benchBadModel = 3,
    qc_benchDevice = 4,
    qc_benchNoPeers = 5 ///< no peer library was found when this was built
} qcBenchExit;

/// Run time against error. `arguments[0]` is "qc-bench accuracy"; ends the program after --help and on a mistake.
qcBenchExit qcBench_RunAccuracy(int argumentCount, char** arguments);
/// Ours beside other libraries, in the same way.
qcBenchExit qcBench_RunPeers(int argumentCount, char** arguments);
/// Time and memory against size, in the same way.
qcBenchExit qcBench_RunScaling(int argumentCount, char** arguments);
/// layers on a GL device beside sweep, in the same way.
qcBenchExit qcBench_RunGpu(int argumentCount, char** arguments);
/// qcBroadphase beside Bullet's own, in the same way; only where Bullet was found (QC_HAS_BULLET).
qcBenchExit qcBench_RunBroadphase(int argumentCount, char** arguments);
/// Soft bodies beside Bullet alone, in the same way, and where Bullet was found.
qcBenchExit qcBench_RunSoft(int argumentCount, char** arguments);

#endif
