// What a step needs: a pure function of the request and of what the device can do. It changes cost, never the answer
// of a method that does not miss.
#ifndef QC_PLUGIN_PLAN_H
#define QC_PLUGIN_PLAN_H

#include "quickcullide/scene.h"

typedef struct qcPlanInput
{
    qcMethod method;     ///< asked for
    uint32_t resolution; ///< asked for
    bool haveGl, haveCompute;
    uint32_t maxResolution; ///< of the device
} qcPlanInput;

typedef struct qcPlan
{
    qcMethod method;      ///< never qc_methodAuto
    bool useImage;        ///< visibility culling at object and triangle level
    bool useLayers;       ///< culling to candidates on the device
    uint32_t resolution;  ///< 0 without an image
    const char* fallback; ///< why another method than the one asked for, or null
} qcPlan;

qcPlan qcPlan_Make(const qcPlanInput* input);

#endif
