// A scene as operations: what a recording that starts late begins with.
#ifndef QC_RECORDING_SNAPSHOT_H
#define QC_RECORDING_SNAPSHOT_H

#include "recording/scene_recorder.h"

/// Records operations that make the bodies in an empty scene, in their slots. Free slots are taken by empty bodies that
/// are removed at the end.
void qcSnapshot_Write(qcSceneRecorder* recorder, const qcBodies* bodies);

#endif
