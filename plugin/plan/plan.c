// The planner.
#include "plan/plan.h"

#include "base/aabb.h"

#include <stddef.h>

enum
{
    // On software GL a round trip takes as long as the sweep of about this many triangles.
    qc_fewTriangles = 512
};

// Grid levels of the device (gl/layers) over a scene, and over a triangle; with fewer, boxes of neighbouring triangles
// coincide.
static const double s_levels = 32767.0, s_levelsPerTriangle = 4.0;

static const char s_noGl[] = "no GL device: sweep answered on the CPU";

qcPlan qcPlan_Make(const qcPlanInput* input)
{
    qcPlan plan = {.method = input->method};
    switch (input->method)
    {
        case qc_methodAuto:
            // Sweep misses nothing and runs on every machine.
            plan.method = qc_methodSweep;
            plan.chooseIslands = input->haveCompute && !input->motion;
            break;
        case qc_methodCullide:
        case qc_methodQuick:
            if (!input->haveGl)
            {
                plan.method = qc_methodSweep;
                plan.fallback = s_noGl;
                break;
            }
            plan.useImage = true;
            plan.resolution = input->resolution < input->maxResolution ? input->resolution : input->maxResolution;
            break;
        case qc_methodLayers:
            plan.useLayers = input->haveCompute && !input->motion;
            if (!plan.useLayers)
            {
                plan.method = qc_methodSweep;
                plan.fallback = input->motion   ? "layers has no motion: sweep answered on the CPU"
                                : input->haveGl ? "no compute shaders on this device: sweep answered on the CPU"
                                                : s_noGl;
            }
            break;
        case qc_methodBrute:
        case qc_methodSweep: break;
    }
    return plan;
}

bool qcPlan_IsWorthADevice(const qcPlanItem* islands, size_t count)
{
    uint64_t triangles = 0;
    for (size_t i = 0; i < count; i++)
        triangles += islands[i].triangles;
    return triangles >= qc_fewTriangles;
}

void qcPlan_ChooseIslands(const qcPlanCosts* costs, qcPlanHistory* history, qcPlanItem* islands, size_t count,
                          double* triangles)
{
    double lower[3], upper[3];
    qcBounds_Clear(lower, upper);
    for (size_t i = 0; i < count; i++)
        qcBounds_IncludeBox(islands[i].lower, islands[i].upper, lower, upper);
    // All islands on the device share one grid: an island whose triangles are too small in it stays on the CPU.
    double widest = qcBounds_Widest(lower, upper);
    *triangles = 0.0;
    for (size_t i = 0; i < count; i++)
    {
        islands[i].onDevice = s_levels * islands[i].finest / widest >= s_levelsPerTriangle;
        *triangles += islands[i].onDevice ? islands[i].triangles : 0.0;
    }
    // All other islands go to the device in one transfer, or none does.
    bool pays = *triangles > 0.0 && qcPlanHistory_Choose(history, costs, *triangles);
    for (size_t i = 0; i < count; i++)
        islands[i].onDevice = islands[i].onDevice && pays;
}

const char* qcMethod_Name(qcMethod method)
{
    static const char* const s_names[] = {"auto", "brute", "cullide", "quick", "sweep", "layers"};
    return (unsigned)method < 6 ? s_names[method] : "unknown method";
}
