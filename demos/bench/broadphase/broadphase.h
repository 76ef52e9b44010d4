// `qc-bench broadphase`: qcBroadphase beside Bullet's own, each with its pair cache, in the same frames.
#ifndef QC_DEMOS_BENCH_BROADPHASE_BROADPHASE_H
#define QC_DEMOS_BENCH_BROADPHASE_BROADPHASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum
{
    qc_maxBroadphases = 5
};

/// Broadphases that are measured in turns on one scene.
typedef struct qcBroadphaseScene
{
    uint32_t boxes, percent; ///< number of boxes; percentage of them that moves
    bool setsAll;    ///< setAabb is called for all boxes, as a world does by default; false: for moved boxes only
    uint32_t frames; ///< max number of frames
} qcBroadphaseScene;

/// One broadphase in a scene. Times are milliseconds, and medians unless named otherwise.
typedef struct qcBroadphaseRow
{
    const char* name;
    double createMs, firstMs;     ///< all proxies, once; the first calculateOverlappingPairs
    double setMs, findMs;         ///< setAabb; calculateOverlappingPairs
    double frameMs, minMs, maxMs; ///< both together
    size_t held;                  ///< pairs in the cache after the last frame
    size_t overlapping;           ///< pairs among `held` whose boxes overlap
} qcBroadphaseRow;

typedef struct qcBroadphaseResult
{
    qcBroadphaseRow rows[qc_maxBroadphases]; ///< ours first
    uint32_t count;
    size_t expected; ///< overlapping pairs after the last frame, counted without a broadphase
    uint32_t frames;
} qcBroadphaseResult;

/// False: out of memory.
bool qcBroadphase_Measure(const qcBroadphaseScene* scene, qcBroadphaseResult* result);

#ifdef __cplusplus
}
#endif

#endif
