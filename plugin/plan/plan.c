// The planner.
#include "plan/plan.h"

#include <math.h>
#include <stddef.h>

enum
{
    // On software GL a round trip takes as long as the sweep of about this many triangles.
    qc_fewTriangles = 512
};

// Levels of the image (gl/layers.h) over a triangle, below which boxes no longer tell triangles apart.
static const double s_levels = 32767.0, s_levelsPerTriangle = 4.0;

qcPlan qcPlan_Make(const qcPlanInput* input)
{
    qcPlan plan = {.method = input->method};
    switch (input->method)
    {
        case qc_methodAuto:
            // Of the methods that never miss, sweep is the one that is there on every machine.
            plan.method = qc_methodSweep;
            plan.chooseParts = input->haveCompute;
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

bool qcPlan_IsWorthADevice(const qcPlanItem* parts, size_t count)
{
    uint64_t triangles = 0;
    for (size_t i = 0; i < count; i++)
        triangles += parts[i].triangles;
    return triangles >= qc_fewTriangles;
}

static double Widest(const double lower[3], const double upper[3])
{
    return fmax(upper[0] - lower[0], fmax(upper[1] - lower[1], upper[2] - lower[2]));
}

void qcPlan_ChooseParts(const qcPlanCosts* costs, qcPlanHistory* history, qcPlanItem* parts, size_t count,
                        double* triangles)
{
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
        {
            lower[axis] = fmin(lower[axis], parts[i].lower[axis]);
            upper[axis] = fmax(upper[axis], parts[i].upper[axis]);
        }
    // All parts on the device share one image: a part that is too small in it stays away.
    double widest = Widest(lower, upper);
    *triangles = 0.0;
    for (size_t i = 0; i < count; i++)
    {
        double across = s_levels * Widest(parts[i].lower, parts[i].upper) / widest;
        parts[i].onDevice = across >= s_levelsPerTriangle * sqrt(parts[i].triangles);
        *triangles += parts[i].onDevice ? parts[i].triangles : 0.0;
    }
    // One trip for all that is left, or none.
    bool pays = *triangles > 0.0 && qcPlanHistory_Choose(history, costs, *triangles);
    for (size_t i = 0; i < count; i++)
        parts[i].onDevice = parts[i].onDevice && pays;
}

const char* qcMethod_Name(qcMethod method)
{
    static const char* const s_names[] = {"auto", "brute", "cullide", "quick", "sweep", "layers"};
    return (unsigned)method < 6 ? s_names[method] : "unknown method";
}
