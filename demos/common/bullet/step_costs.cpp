// Bullet calls back when it enters a profile zone and when it leaves one; zones that stand for a cost are timed.
#include "common/bullet/step_costs.h"

#include "common/stopwatch.h"

#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace
{
constexpr struct
{
    const char* zone;
    qcStepCost cost;
} s_zones[] = {
    {"updateAabbs", qc_costBoxes},
    {"calculateOverlappingPairs", qc_costPairs},
    {"dispatchAllCollisionPairs", qc_costManifolds},
    {"calculateSimulationIslands", qc_costRigid},
    {"solveConstraints", qc_costRigid},
    {"PSolve_Links", qc_costSoft},
    {"PSolve_Anchors", qc_costSoft},
    {"PSolve_RContacts", qc_costSoft},
    {"PSolve_SContacts", qc_costSoft},
    {"VSolve_Links", qc_costSoft},
};

constexpr const char* s_labels[qc_costCount] = {
    "Bullet: boxes, handed to the broadphase",
    "qcBroadphase: pairs of boxes",
    "glue: geometry gathered, bookkeeping",
    "queries: impact sampling of fast bodies",
    "query: culling",
    "query: sweep",
    "query: exact test",
    "query: contact points",
    "query: planning, and the rest of it",
    "manifolds filled, by the glue and by Bullet",
    "glue: response of soft bodies",
    "Bullet: islands, constraints of rigid bodies",
    "Bullet: constraints of soft bodies",
    "a body is broken into pieces",
    "Bullet: all else",
};

struct Zone
{
    int cost;     ///< index of the cost; -1: none
    double start; ///< -1: included in the enclosing zone
};

std::vector<Zone> s_stack;
qcStepCosts s_costs;

void Enter(const char* name)
{
    if (!s_stack.empty() && s_stack.back().cost >= 0)
    {
        s_stack.push_back({s_stack.back().cost, -1});
        return;
    }
    auto found = std::find_if(std::begin(s_zones), std::end(s_zones),
                              [&](const auto& known) { return std::strcmp(known.zone, name) == 0; });
    if (found != std::end(s_zones))
        s_stack.push_back({found->cost, qcStopwatch_NowMs()});
    else
        s_stack.push_back({-1, -1});
}

void Leave()
{
    // A zone that was entered before timing began.
    if (s_stack.empty())
        return;
    Zone zone = s_stack.back();
    s_stack.pop_back();
    if (zone.start >= 0)
        s_costs.ms[size_t(zone.cost)] += qcStopwatch_NowMs() - zone.start;
}

void PrintRow(const char* label, const std::vector<double>& values, int digits)
{
    std::printf("  %-46s", label);
    for (double value : values)
        std::printf(" %12.*f", digits, value);
    std::printf("\n");
}
} // namespace

double qcStepCosts::Total() const
{
    double sum = 0;
    for (double part : ms)
        sum += part;
    return sum;
}

void qcStepCosts::Move(qcStepCost from, qcStepCost to, double part)
{
    ms[from] -= part;
    ms[to] += part;
}

void qcStepCosts::MoveQuery(const qcMeshContactStatistics& query)
{
    Move(qc_costManifolds, qc_costGather, query.gatherMs);
    Move(qc_costManifolds, qc_costAhead, query.aheadMs);
    Move(qc_costManifolds, qc_costCull, query.cullMs);
    Move(qc_costManifolds, qc_costSweep, query.sweepMs);
    Move(qc_costManifolds, qc_costExact, query.exactMs);
    Move(qc_costManifolds, qc_costPoints, query.manifoldMs);
    Move(qc_costManifolds, qc_costOther,
         query.detectMs - query.cullMs - query.sweepMs - query.exactMs - query.manifoldMs);
}

void qcStepCosts::MoveSoft(const qcSoftBodyStatistics& statistics)
{
    double stages = statistics.cullMs + statistics.sweepMs + statistics.exactMs + statistics.contactMs;
    Move(qc_costRest, qc_costGather, statistics.gatherMs);
    Move(qc_costRest, qc_costCull, statistics.cullMs);
    Move(qc_costRest, qc_costSweep, statistics.sweepMs);
    Move(qc_costRest, qc_costExact, statistics.exactMs);
    Move(qc_costRest, qc_costPoints, statistics.contactMs);
    Move(qc_costRest, qc_costOther, statistics.detectMs - stages);
    Move(qc_costRest, qc_costRespond, statistics.respondMs);
}

void qcStepCosts::Add(const qcStepCosts& other, double weight)
{
    for (size_t i = 0; i < ms.size(); i++)
        ms[i] += weight * other.ms[i];
}

qcStepCosts qcTimeStep(btDynamicsWorld* world, double seconds)
{
    btEnterProfileZoneFunc* enter = btGetCurrentEnterProfileZoneFunc();
    btLeaveProfileZoneFunc* leave = btGetCurrentLeaveProfileZoneFunc();
    btSetCustomEnterProfileZoneFunc(Enter);
    btSetCustomLeaveProfileZoneFunc(Leave);
    s_stack.clear();
    s_costs = qcStepCosts();
    double start = qcStopwatch_NowMs();
    world->stepSimulation(btScalar(seconds), 0);
    s_costs.ms[qc_costRest] = qcStopwatch_NowMs() - start - s_costs.Total();
    btSetCustomEnterProfileZoneFunc(enter);
    btSetCustomLeaveProfileZoneFunc(leave);
    return s_costs;
}

const char* qcStepCostLabel(qcStepCost cost)
{
    return s_labels[cost];
}

void qcPrintStepCosts(const char* heading, const std::vector<std::pair<std::string, qcStepCosts>>& columns)
{
    std::printf("  %-46s", heading);
    for (const auto& column : columns)
        std::printf(" %12s", column.first.c_str());
    std::printf("\n");
    std::vector<double> values(columns.size());
    for (size_t i = 0; i < qc_costCount; i++)
    {
        for (size_t k = 0; k < columns.size(); k++)
            values[k] = columns[k].second.ms[i];
        if (std::any_of(values.begin(), values.end(), [](double value) { return value != 0; }))
            PrintRow(s_labels[i], values, 2);
    }
    for (size_t k = 0; k < columns.size(); k++)
        values[k] = columns[k].second.Total();
    PrintRow("the whole step", values, 2);
    for (size_t k = 0; k < columns.size(); k++)
        values[k] = values[k] > 0 ? 100 * columns[k].second.ms[qc_costGather] / values[k] : 0;
    PrintRow("gathering, % of the step", values, 1);
}
