// Entry points of a scene for the library itself.
#ifndef QC_PIPELINE_SCENE_API_H
#define QC_PIPELINE_SCENE_API_H

#include "quickcullide/scene.h"

/// qcScene_Create, but QC_RECORD has no effect: for measurements of the library's own.
qcStatus qcScene_CreateUnrecorded(const qcSceneDef* def, qcScene** scene);

#endif
