// Replays a recording, and compares the hashes of its results.
#ifndef QC_TESTS_SUPPORT_REPLAY_H
#define QC_TESTS_SUPPORT_REPLAY_H

#include "support/scenes.h"

typedef struct Replay
{
    size_t operations, detections, filtered, motions;
    bool isComplete;
} Replay;

/// Brute force proves fewer pairs apart over a motion than the sweep does: these results are not compared with it.
static inline void CheckDetection(const qcOperation* operation, qcScene* scene, qcMethod method, uint32_t threads)
{
    ck_assert(operation->hasResult);
    ck_assert_int_eq(operation->resultStatus, qc_statusOk);
    qcDetectDef def = operation->detect;
    def.method = method;
    def.threads = threads;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    qcResultHash hash = qcResult_Hash(result);
    if (!def.motion || method != qc_methodBrute)
        ck_assert_msg(memcmp(&hash, &operation->resultHash, sizeof hash) == 0,
                      "detection in operation %llu by %s: %zu pairs, recorded %llu",
                      (unsigned long long)operation->number, qcMethod_Name(method), result->pairCount,
                      (unsigned long long)operation->resultHash.pairCount);
}

/// All operations of a file, each detection by the given method.
static inline Replay ReplayFile(const char* path, qcDevice* device, qcMethod method, uint32_t threads)
{
    qcRecording* recording = NULL;
    CHECK_OK(qcRecording_Open(path, &recording));
    qcScene* scene = qcMakeScene(device);
    const qcOperation* operation;
    Replay replay = {0};
    for (;; replay.operations++)
    {
        CHECK_OK(qcRecording_Next(recording, &operation));
        ck_assert_uint_eq(operation->number, replay.operations);
        if (operation->kind == qc_operationEnd)
            break;
        if (operation->kind != qc_operationDetect)
        {
            CHECK_OK(qcOperation_Apply(operation, scene, NULL));
            continue;
        }
        CheckDetection(operation, scene, method, threads);
        replay.detections++;
        replay.filtered += operation->rejectedPairCount != 0;
        replay.motions += operation->detect.motion;
    }
    replay.isComplete = operation->isComplete;
    qcScene_Destroy(scene);
    qcRecording_Close(recording);
    return replay;
}

#endif
