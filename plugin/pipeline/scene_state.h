// A scene, and the checks that its entry points share.
#ifndef QC_PIPELINE_SCENE_STATE_H
#define QC_PIPELINE_SCENE_STATE_H

#include "base/background.h"
#include "pipeline/detect.h"
#include "recording/scene_recorder.h"

/// A detection that was begun. Its job writes `status` and `message`; the caller's thread all else.
typedef struct qcPendingDetection
{
    bool isPending;
    qcDetectDef def;
    qcBackground* background; ///< created by the first qcScene_DetectBegin
    qcStatus status;
    char message[512]; ///< if the status is not ok
} qcPendingDetection;

struct qcScene
{
    qcDevice* device;
    qcBodies bodies;
    qcDetector detector;
    qcPendingDetection pending;
    qcSceneRecorder* recorder; ///< null: the scene is not recorded
};

qcStatus qcCheckPointer(const void* pointer, const char* function, const char* argument);
/// qc_statusBadInput: the scene is null or has a pending detection.
qcStatus qcScene_CheckIdle(const qcScene* scene, const char* function);
/// Ends a pending detection, if there is one, and frees its thread.
void qcScene_DropDetection(qcScene* scene);

#endif
