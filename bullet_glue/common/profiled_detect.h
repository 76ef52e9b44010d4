// The default query, with its stages as profile zones of Bullet's.
#ifndef QC_GLUE_COMMON_PROFILED_DETECT_H
#define QC_GLUE_COMMON_PROFILED_DETECT_H

#include "quickcullide/scene.h"

#include <LinearMath/btQuickprof.h>

inline qcDetectDef qcProfiledDetectDef()
{
    qcDetectDef def = qcDefaultDetectDef();
    def.enterStage = btGetCurrentEnterProfileZoneFunc();
    def.leaveStage = btGetCurrentLeaveProfileZoneFunc();
    return def;
}

#endif
