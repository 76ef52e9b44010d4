// The scenes of the benchmarks, by name: bodies of triangles in world space.
#ifndef QC_DEMOS_BENCH_SCENES_SCENES_H
#define QC_DEMOS_BENCH_SCENES_SCENES_H

#include "common/mesh_io/bunny_path.h"
#include "common/mesh_io/mesh_file.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct qcBenchScene
{
    qcMesh* bodies;
    uint32_t bodyCount;
    uint32_t triangleCount; ///< of all bodies
    double extent;          ///< the longest edge of the box around all bodies
} qcBenchScene;

/// Models that are read from files.
typedef struct qcBenchModels
{
    const char* bunny;
    const char* dragon; ///< or null
} qcBenchModels;

/// True, with a message that explains how to get it: the bunny of the package is not there, and no other was named.
bool qcBenchModels_LackBunny(const qcBenchModels* models, qcMessage* message);

typedef enum qcBenchMade
{
    qc_benchMade,
    qc_benchSkipped, ///< a model is missing; the message explains how to get it
    qc_benchFailed   ///< a model that is there or was named can't be read, or out of memory
} qcBenchMade;

enum
{
    qc_benchSceneCount = 12
};

/// "cloth-20k"; `index` below qc_benchSceneCount.
const char* qcBenchScene_Name(int index);
/// "folded cloth", for a heading.
const char* qcBenchScene_Title(int index);
/// Marks the scene of that name, or all scenes whose names begin with it and a hyphen ("sheets"). False: there is none.
bool qcBenchScene_Mark(const char* name, bool marks[qc_benchSceneCount]);

/// Makes a scene; empty unless it was made. Deterministic to the bit.
qcBenchMade qcBenchScene_Make(int index, const qcBenchModels* models, qcBenchScene* scene, qcMessage* message);
void qcBenchScene_Free(qcBenchScene* scene);

#ifdef __cplusplus
}
#endif

#endif
