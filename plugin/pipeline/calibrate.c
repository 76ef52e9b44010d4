// Times a folded sheet at two sizes through both methods, by the public API.
#include "pipeline/calibrate.h"

#include "base/clock.h"
#include "base/memory.h"
#include "gl/device.h"
#include "pipeline/scene_api.h"

#include <math.h>

enum
{
    // Triangles: 2 * 16^2 and 2 * 64^2. Smaller ones measure overhead alone; larger ones take milliseconds each.
    qc_smallSheet = 16,
    qc_largeSheet = 64,
    qc_minSteps = 4 ///< of a period
};

// Steps are repeated for periods of so many milliseconds, until one of them has no faster step than those before by
// more than 5 %, or the time is over.
static const double s_period = 2.0, s_maxTime = 60.0, s_maxRatio = 0.95;
// A GPU raises its clocks only after some time of work: its first measurement takes no less than this.
static const double s_gpuWarmUp = 40.0;

typedef struct Sheet
{
    uint32_t side;
    float positions[(qc_largeSheet + 1) * (qc_largeSheet + 1)][3];
    uint32_t indices[2 * qc_largeSheet * qc_largeSheet][3];
} Sheet;

/// A sheet folded into four layers that lie close and cross a little, one triangle in 45, like a cloth. With many
/// crossings both methods would spend their time on the exact test and look alike.
static void MakeSheet(Sheet* sheet, uint32_t side)
{
    const float pi = 3.14159265f;
    sheet->side = side;
    for (uint32_t y = 0, v = 0; y <= side; y++)
        for (uint32_t x = 0; x <= side; x++, v++)
        {
            float u = (float)x / (float)side, w = (float)y / (float)side;
            sheet->positions[v][0] = fabsf(fmodf(4.0f * u, 2.0f) - 1.0f);
            sheet->positions[v][1] = 4.0f * w;
            sheet->positions[v][2] = 0.2f * u + 0.02f * sinf(7.0f * pi * u) * sinf(5.0f * pi * w);
        }
    for (uint32_t y = 0, t = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++)
        {
            uint32_t a = y * (side + 1) + x, b = a + side + 1;
            const uint32_t corners[2][3] = {{a, a + 1, b}, {a + 1, b + 1, b}};
            for (int k = 0; k < 2; k++, t++)
                for (int c = 0; c < 3; c++)
                    sheet->indices[t][c] = corners[k][c];
        }
}

/// One step with new positions. False: it failed, or another method ran in its place.
static bool RunStep(qcScene* scene, qcBodyId body, const Sheet* sheet, const qcDetectDef* def)
{
    const qcResult* result;
    return qcScene_SetVertices(scene, body, sheet->positions, qc_positionF32, 0) == qc_statusOk &&
           qcScene_Detect(scene, def, &result) == qc_statusOk && result->profile.method == def->method;
}

/// Milliseconds of the fastest step of a method, after no less than `warmUp` milliseconds; infinity if it fails.
static double Measure(qcScene* scene, qcBodyId body, const Sheet* sheet, qcMethod method, uint32_t threads,
                      double warmUp)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.threads = threads;
    // The first step allocates memory and compiles kernels: its time is left out.
    if (!RunStep(scene, body, sheet, &def))
        return INFINITY;
    double begin = qcClock_Now(), now = begin, fastest = INFINITY;
    for (bool isSteady = false; !isSteady && now - begin < s_maxTime;)
    {
        double periodBegin = now, periodFastest = INFINITY;
        for (int step = 0; step < qc_minSteps || now - periodBegin < s_period; step++)
        {
            double start = now;
            if (!RunStep(scene, body, sheet, &def))
                return INFINITY;
            now = qcClock_Now();
            periodFastest = fmin(periodFastest, now - start);
        }
        isSteady = now - begin >= warmUp && periodFastest >= s_maxRatio * fastest;
        fastest = fmin(fastest, periodFastest);
    }
    return fastest;
}

/// Times both methods on a sheet of this size.
static void MeasureSheet(qcDevice* device, Sheet* sheet, uint32_t side, uint32_t threads, double* sweep, double* layers)
{
    *sweep = *layers = INFINITY;
    MakeSheet(sheet, side);
    qcSceneDef sceneDef = qcDefaultSceneDef();
    sceneDef.device = device;
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = sheet->positions;
    def.vertexCount = (side + 1) * (side + 1);
    def.indices = sheet->indices[0];
    def.triangleCount = 2 * side * side;
    def.deforming = true;
    qcScene* scene = NULL;
    qcBodyId body;
    if (qcScene_CreateUnrecorded(&sceneDef, &scene) != qc_statusOk ||
        qcScene_AddBody(scene, &def, &body) != qc_statusOk)
    {
        qcScene_Destroy(scene);
        return;
    }
    qcDeviceInfo info = {.software = true};
    qcDevice_GetInfo(device, &info);
    *layers = Measure(scene, body, sheet, qc_methodLayers, threads, info.software ? 0.0 : s_gpuWarmUp);
    *sweep = Measure(scene, body, sheet, qc_methodSweep, threads, 0.0);
    qcScene_Destroy(scene);
}

static const double s_smallCount = 2.0 * qc_smallSheet * qc_smallSheet;
static const double s_largeCount = 2.0 * qc_largeSheet * qc_largeSheet;

/// The slope of the line through both measurements; not below 0.
static double FitPerTriangle(double small, double large)
{
    return fmax((large - small) / (s_largeCount - s_smallCount), 0.0);
}

qcPlanCosts qcCalibrate(qcDevice* device, uint32_t threads)
{
    qcPlanCosts costs;
    if (qcDevice_FindCosts(device, threads, &costs))
        return costs;
    costs = (qcPlanCosts){.layersFixed = INFINITY, .layersPerTriangle = INFINITY};
    Sheet* sheet = qcAllocate(sizeof *sheet);
    if (sheet == NULL)
        return costs;
    double sweep[2], layers[2];
    MeasureSheet(device, sheet, qc_smallSheet, threads, &sweep[0], &layers[0]);
    MeasureSheet(device, sheet, qc_largeSheet, threads, &sweep[1], &layers[1]);
    qcFree(sheet, sizeof *sheet);
    costs.sweepPerTriangle = FitPerTriangle(sweep[0], sweep[1]);
    if (isfinite(layers[0]) && isfinite(layers[1]))
    {
        costs.layersPerTriangle = FitPerTriangle(layers[0], layers[1]);
        costs.layersFixed = fmax(layers[0] - costs.layersPerTriangle * s_smallCount, 0.0);
    }
    qcDevice_KeepCosts(device, threads, &costs);
    return costs;
}
