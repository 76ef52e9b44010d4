// What a step needs: a pure function of the request and of what the device can do. It changes cost, never the answer
// of a method that does not miss.
#ifndef QC_PLAN_PLAN_H
#define QC_PLAN_PLAN_H

#include "plan/plan_history.h"
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
    bool chooseParts;     ///< on the device those parts of the scene for which that pays
    uint32_t resolution;  ///< 0 without an image
    const char* fallback; ///< why another method than the one asked for, or null
} qcPlan;

qcPlan qcPlan_Make(const qcPlanInput* input);

//  ---- `auto`: which parts of the scene go to the device ---------------------------------------------------------

/// Bodies that can meet each other, directly or by way of others, and no other body.
typedef struct qcPlanItem
{
    uint32_t triangles;
    double lower[3], upper[3]; ///< around them
    bool onDevice;             ///< the answer
} qcPlanItem;

/// Below this many triangles the sweep ends before a device has begun: not worth a calibration.
bool qcPlan_IsWorthADevice(const qcPlanItem* parts, size_t count);

/// Chooses for each part. `triangles` receives how many the choice was about: those of parts that the device could
/// take.
void qcPlan_ChooseParts(const qcPlanCosts* costs, qcPlanHistory* history, qcPlanItem* parts, size_t count,
                        double* triangles);

#endif
