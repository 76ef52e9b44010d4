// The plan of a step: a pure function of the request and of the device's features. It affects cost; methods that miss
// nothing give the same pairs under any plan.
#ifndef QC_PLAN_PLAN_H
#define QC_PLAN_PLAN_H

#include "plan/plan_history.h"
#include "quickcullide/scene.h"

typedef struct qcPlanInput
{
    qcMethod method;     ///< requested
    uint32_t resolution; ///< requested
    bool haveGl, haveCompute;
    uint32_t maxResolution; ///< of the device
    bool motion;            ///< pairs over a motion: the sweep and brute force only
} qcPlanInput;

typedef struct qcPlan
{
    qcMethod method;      ///< never qc_methodAuto
    bool useImage;        ///< visibility culling at object and triangle level
    bool useLayers;       ///< candidates from the device
    bool chooseIslands;   ///< candidates of some islands from the device: those for which it is faster
    uint32_t resolution;  ///< 0 without an image
    const char* fallback; ///< why another method than the requested one runs, or null
} qcPlan;

qcPlan qcPlan_Make(const qcPlanInput* input);

//  ---- `auto`: which islands go to the device ---------------------------------------------------------------------

/// An island: bodies whose AABBs are connected by overlaps, and overlap no other body.
typedef struct qcPlanItem
{
    uint32_t triangles;
    double lower[3], upper[3]; ///< their AABB
    double finest;             ///< about the length of the triangles of its finest body
    bool onDevice;             ///< the result of qcPlan_ChooseIslands
} qcPlanItem;

/// False for so few triangles that the sweep ends before a device could start: no calibration pays.
bool qcPlan_IsWorthADevice(const qcPlanItem* islands, size_t count);

/// Chooses for each island. `triangles` receives the count of triangles in islands that the device can take.
void qcPlan_ChooseIslands(const qcPlanCosts* costs, qcPlanHistory* history, qcPlanItem* islands, size_t count,
                          double* triangles);

#endif
