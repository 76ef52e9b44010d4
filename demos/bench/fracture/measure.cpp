// A run of the fracture demo's world, measured.
#include "bench/fracture/measure.h"

#include "common/interrupt.h"
#include "common/progress.h"

#include <algorithm>

namespace
{
constexpr size_t s_firstSteps = 40;
constexpr size_t s_depthEvery = 8;
constexpr double s_restEnergy = 10; // of 30 t of stone, J
constexpr size_t s_maxFall = 1000;  // steps until the break

/// The pieces as bodies of a scene of its own.
class DepthMeter
{
  public:
    ~DepthMeter()
    {
        qcScene_Destroy(m_scene);
    }

    /// The depth of the deepest point, and the number of pairs that penetrate. False: qcLastMessage has the reason.
    bool Measure(const std::vector<std::unique_ptr<qcFractureBody>>& bodies, double* depth, size_t* pairs)
    {
        qcSceneDef sceneDef = qcDefaultSceneDef();
        qcStatus status = m_scene == nullptr ? qcScene_Create(&sceneDef, &m_scene) : qc_statusOk;
        for (size_t i = 0; i < bodies.size() && status == qc_statusOk; i++)
        {
            if (i == m_ids.size())
            {
                m_ids.emplace_back();
                status = bodies[i]->AddTo(m_scene, &m_ids.back());
            }
            qcTransform transform = bodies[i]->Place();
            if (status == qc_statusOk)
                status = qcScene_SetTransform(m_scene, m_ids[i], &transform);
        }
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.manifolds = true;
        def.threads = 1;
        const qcResult* result = nullptr;
        if (status == qc_statusOk)
            status = qcScene_Detect(m_scene, &def, &result);
        if (status != qc_statusOk)
            return false;
        *pairs = result->pairCount;
        *depth = 0;
        for (size_t i = 0; i < result->manifoldPointCount; i++)
            *depth = std::max(*depth, -result->manifoldPoints[i].distance);
        return true;
    }

  private:
    qcScene* m_scene = nullptr;
    std::vector<qcBodyId> m_ids;
};

void TakeBreak(const qcFractureStep& step, const qcBreak& broken, qcFractureRow* row)
{
    row->pieces = broken.pieces;
    row->breakMs = step.costs.Total();
    row->cutMs = broken.sitesMs + broken.splitMs;
    row->bodiesMs = broken.bodiesMs;
    row->solverMs = step.costs.ms[qc_costRigid];
    for (qcStepCost cost : {qc_costBoxes, qc_costPairs, qc_costGather, qc_costAhead, qc_costCull, qc_costSweep,
                            qc_costExact, qc_costPoints, qc_costOther, qc_costManifolds})
        row->detectionMs += step.costs.ms[cost];
}

/// Takes a step after the break.
void TakeStep(const qcFractureStep& step, qcFractureRow* row)
{
    row->steps++;
    double ms = step.costs.Total();
    (row->steps <= s_firstSteps ? row->firstMs : row->laterMs) += ms;
    row->longestMs = std::max(row->longestMs, ms);
    row->points += step.points;
    row->energy = step.energy;
    row->awake = step.awake;
    if (step.energy >= s_restEnergy)
        row->restSeconds = -1;
    else if (row->restSeconds < 0)
        row->restSeconds = double(row->steps) * qcFractureWorld::stepSeconds;
}

/// Turns sums into means.
void Finish(size_t depthCount, qcFractureRow* row)
{
    size_t first = std::min(row->steps, s_firstSteps);
    row->firstMs /= double(std::max<size_t>(first, 1));
    row->laterMs /= double(std::max<size_t>(row->steps - first, 1));
    row->points /= double(std::max<size_t>(row->steps, 1));
    row->meanDepth /= double(std::max<size_t>(depthCount, 1));
}
} // namespace

bool qcMeasureFracture(const qcFractureModel& model, const qcFractureRequest& request, uint32_t steps,
                       qcFractureRow* row, std::string* message)
{
    qcFractureWorld world(model, request, nullptr);
    DepthMeter meter;
    size_t depthCount = 0;
    *row = qcFractureRow();
    row->hulls = request.hulls;
    row->seed = request.seed;
    row->restSeconds = -1;
    qcProgress_Begin(steps, request.hulls ? "convex hulls" : "meshes");
    bool isOk = true;
    for (size_t fall = 0; isOk && row->steps < steps && fall < s_maxFall && qcInterrupt_Signal() == 0;)
    {
        qcFractureStep step;
        isOk = world.Step(&step, message);
        if (step.breaks)
            TakeBreak(step, world.Break(), row);
        else if (world.Break().happened)
            TakeStep(step, row);
        else
            fall++;
        if (world.Break().happened)
            row->underFloor = std::max(row->underFloor, -double(step.lowest));
        double depth = 0;
        if (!isOk || row->steps == 0 || (row->steps % s_depthEvery != 0 && row->steps != steps))
            continue;
        isOk = meter.Measure(world.Bodies(), &depth, &row->penetrating);
        if (!isOk)
            *message = qcLastMessage();
        row->deepest = std::max(row->deepest, depth);
        row->meanDepth += depth;
        depthCount++;
        qcProgress_Update(row->steps);
    }
    qcProgress_End();
    Finish(depthCount, row);
    return isOk;
}
