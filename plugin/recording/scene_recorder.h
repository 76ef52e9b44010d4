// Writes the operations of one scene. Each function is called after the operation has succeeded, but for a detection,
// which is in the file before it starts: a crash in it can be replayed.
#ifndef QC_RECORDING_SCENE_RECORDER_H
#define QC_RECORDING_SCENE_RECORDER_H

#include "quickcullide/scene.h"
#include "scene/bodies.h"

/// Null stands for no recording in Close only.
typedef struct qcSceneRecorder qcSceneRecorder;

/// Creates the file and writes the bodies that are there.
qcStatus qcSceneRecorder_Open(const char* path, qcDevice* device, const qcBodies* bodies, qcSceneRecorder** recorder);
/// A recorder as QC_RECORD names it, for a new scene; null if the variable is not set or the file can't be created,
/// which is reported.
qcSceneRecorder* qcSceneRecorder_OpenFromEnvironment(qcDevice* device);
/// Ends the recording, with the reason qcLastMessage; the file closes.
void qcSceneRecorder_Stop(qcSceneRecorder* recorder, qcStatus status);
/// Closes the file; the first failure since it was opened.
qcStatus qcSceneRecorder_Close(qcSceneRecorder* recorder);

void qcSceneRecorder_AddBody(qcSceneRecorder* recorder, uint32_t slot, const qcBodyDef* def);
void qcSceneRecorder_RemoveBody(qcSceneRecorder* recorder, uint32_t slot);
void qcSceneRecorder_SetTransform(qcSceneRecorder* recorder, uint32_t slot, const qcTransform* transform);
/// `count`: the body's vertices.
void qcSceneRecorder_SetVertices(qcSceneRecorder* recorder, uint32_t slot, const void* positions, qcPositionType type,
                                 size_t stride, uint32_t count);
void qcSceneRecorder_SetActivity(qcSceneRecorder* recorder, uint32_t slot, qcActivity activity);
void qcSceneRecorder_SetFilter(qcSceneRecorder* recorder, uint32_t slot, uint32_t group, uint32_t mask);
void qcSceneRecorder_SetSelfCollision(qcSceneRecorder* recorder, uint32_t slot, bool selfCollision);
void qcSceneRecorder_SetMargin(qcSceneRecorder* recorder, uint32_t slot, double margin);
void qcSceneRecorder_MarkStart(qcSceneRecorder* recorder);

/// Writes the definition and replaces its filter by one that calls it and collects the pairs that it rejects. `def`
/// must stay where it is until EndDetect.
void qcSceneRecorder_BeginDetect(qcSceneRecorder* recorder, qcDetectDef* def);
/// `result` is read if the status is ok.
void qcSceneRecorder_EndDetect(qcSceneRecorder* recorder, qcStatus status, const qcResult* result);

#endif
