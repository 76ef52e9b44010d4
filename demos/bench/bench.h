// The benchmarks of qc-bench. Each function ends the program after --help and on a mistake. `arguments[0]` is
// "qc-bench" and the benchmark's name.
#ifndef QC_DEMOS_BENCH_BENCH_H
#define QC_DEMOS_BENCH_BENCH_H

#include "common/exit_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Run time against error.
qcExitStatus qcBench_RunAccuracy(int argumentCount, char** arguments);
/// This library's sweep beside other libraries.
qcExitStatus qcBench_RunPeers(int argumentCount, char** arguments);
/// The first steps of new meshes.
qcExitStatus qcBench_RunFirst(int argumentCount, char** arguments);
/// Time and memory against size.
qcExitStatus qcBench_RunScaling(int argumentCount, char** arguments);
/// layers on a GL device beside sweep.
qcExitStatus qcBench_RunGpu(int argumentCount, char** arguments);
/// The paper's scenes from recordings: its tables, figures and factors.
qcExitStatus qcBench_RunPaper(int argumentCount, char** arguments);
/// qcBroadphase beside Bullet's own. Only where Bullet was found (QC_HAS_BULLET).
qcExitStatus qcBench_RunBroadphase(int argumentCount, char** arguments);
/// Rays, sweeps and boxes on qcMeshShape beside Bullet's BVH shape. Only where Bullet was found.
qcExitStatus qcBench_RunQueries(int argumentCount, char** arguments);
/// Convex bodies on hills of triangles beside Bullet alone. Only where Bullet was found.
qcExitStatus qcBench_RunTerrain(int argumentCount, char** arguments);
/// Soft bodies beside Bullet alone. Only where Bullet was found.
qcExitStatus qcBench_RunSoft(int argumentCount, char** arguments);
/// Fast bodies, judged within each step, beside version 0.2.0. Only where Bullet was found.
qcExitStatus qcBench_RunThrough(int argumentCount, char** arguments);
/// Long runs of scenes that come to rest. Only where Bullet was found.
qcExitStatus qcBench_RunStability(int argumentCount, char** arguments);
/// Piles of meshes beside Bullet's own shapes. Only where Bullet was found.
qcExitStatus qcBench_RunPiles(int argumentCount, char** arguments);
/// A mesh that breaks, beside convex hulls. Only where Bullet and CGAL were found (QC_HAS_FRACTURE).
qcExitStatus qcBench_RunFracture(int argumentCount, char** arguments);

#ifdef __cplusplus
}
#endif

#endif
