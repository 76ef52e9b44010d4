// The planner.
#include "plan.h"

#include <stddef.h>

qcPlan qcPlan_Make(const qcPlanInput* input)
{
    qcPlan plan = {.method = input->method};
    switch (input->method)
    {
        case qc_methodAuto:
            // Of the methods that never miss, sweep is the one that is there on every machine.
            plan.method = qc_methodSweep;
            break;
        case qc_methodCullide:
        case qc_methodQuick:
            if (!input->haveGl)
            {
                plan.method = qc_methodSweep;
                plan.fallback = "no GL on this device: sweep answered on the CPU";
                break;
            }
            plan.useImage = true;
            plan.resolution = input->resolution < input->maxResolution ? input->resolution : input->maxResolution;
            break;
        case qc_methodLayers:
            plan.useLayers = input->haveCompute;
            if (!plan.useLayers)
            {
                plan.method = qc_methodSweep;
                plan.fallback = "no compute shaders on this device: sweep answered on the CPU";
            }
            break;
        case qc_methodBrute:
        case qc_methodSweep: break;
    }
    return plan;
}

const char* qcMethod_Name(qcMethod method)
{
    static const char* const s_names[] = {"auto", "brute", "cullide", "quick", "sweep", "layers"};
    return (unsigned)method < 6 ? s_names[method] : "unknown method";
}
