// CSV and closing table of the leaves demo.
#include "leaves/report.h"

#include "common/bullet/query_report.h"
#include "common/bullet/written_file.h"
#include "leaves/world.h"

#include <algorithm>
#include <cmath>

namespace
{
void WriteRows(FILE* stream, const qcLeavesRun& run)
{
    std::fprintf(stream, "step,seconds,step_ms,hanging,kinetic_j,lowest_mm,method,device,detect_ms,respond_ms,contacts,"
                         "penetrating_before,rounds,planes,zone_nodes,exempt,unproven,penetrating_after");
    qcWriteQueryHeading(stream);
    std::fprintf(stream, "\n");
    for (size_t i = 0; i < run.steps.size(); i++)
    {
        const qcLeavesStep& step = run.steps[i];
        const qcSoftBodyStatistics& s = step.statistics;
        std::fprintf(stream, "%zu,%.4f,%.3f,%zu,%.5f,%.3f,%s,%s,%.3f,%.3f,%d,%d,%d,%d,%d,%d,%d,%d", i + 1,
                     double(i + 1) * qcLeavesWorld::stepSeconds, step.costs.Total(), step.hanging, step.energy,
                     1000 * step.lowest, qcMethod_Name(s.method), s.device, s.detectMs, s.respondMs, s.contacts,
                     s.penetrating, s.rounds, s.planes, s.zoneNodes, s.exempt, s.unproven, s.remaining);
        qcWriteQueryColumns(stream, step.results);
        std::fprintf(stream, "\n");
    }
}

template <typename Value> void PrintMeanAndMax(const char* label, const qcLeavesRun& run, Value value)
{
    double sum = 0, largest = 0;
    for (const qcLeavesStep& step : run.steps)
    {
        sum += double(value(step));
        largest = std::max(largest, double(value(step)));
    }
    std::printf("  %-46s %12.1f %12.0f\n", label, sum / double(std::max(run.steps.size(), size_t(1))), largest);
}

void PrintContact(const qcLeavesRun& run)
{
    std::printf("\n  %-46s %12s %12s\n", "In a step:", "mean", "max");
    PrintMeanAndMax("contacts", run, [](const qcLeavesStep& s) { return s.statistics.contacts; });
    PrintMeanAndMax("pairs that penetrated before contact", run,
                    [](const qcLeavesStep& s) { return s.statistics.penetrating; });
    PrintMeanAndMax("pairs that penetrate after it", run, [](const qcLeavesStep& s) { return s.statistics.remaining; });
    PrintMeanAndMax("planes (pairs pushed apart)", run, [](const qcLeavesStep& s) { return s.statistics.planes; });
    PrintMeanAndMax("nodes in zones (moved as one)", run, [](const qcLeavesStep& s) { return s.statistics.zoneNodes; });
    PrintMeanAndMax("unproven pairs", run, [](const qcLeavesStep& s) { return s.statistics.unproven; });
}

void PrintCourse(const qcLeavesRun& run)
{
    double energy = 0, lowest = HUGE_VAL;
    for (const qcLeavesStep& step : run.steps)
    {
        energy = std::max(energy, step.energy);
        lowest = std::min(lowest, step.lowest);
    }
    std::printf("\n  %-46s %12.3f J\n", "kinetic energy, max", energy);
    std::printf("  %-46s %12.3f J\n", "kinetic energy at the end", run.steps.empty() ? 0 : run.steps.back().energy);
    std::printf("  %-46s %12.2f mm above the ground\n", "lowest vertex of a leaf", 1000 * lowest);
    std::printf("  %-46s %12zu\n", "leaves that still hang on the tree",
                run.steps.empty() ? run.leaves : run.steps.back().hanging);
}
} // namespace

bool qcWriteLeavesCsv(const std::string& path, const qcLeavesRun& run, std::string* message)
{
    return qcWriteFile(
        path, [&run](std::FILE* stream) { WriteRows(stream, run); }, message);
}

void qcPrintLeavesTable(const qcLeavesRun& run, qcMethod method, const qcDetectDef& request, const qcDeviceInfo& device)
{
    std::printf("\nLeaves fall from a tree: %zu leaves of %zu triangles in all, a tree of %zu, %zu steps\n\n",
                run.leaves, run.triangles, run.treeTriangles, run.steps.size());
    if (run.leaves < run.requestedLeaves)
        std::printf("  There was no room for more leaves: %zu were requested.\n", run.requestedLeaves);
    auto byDevice = std::count_if(run.steps.begin(), run.steps.end(),
                                  [](const qcLeavesStep& step) { return step.statistics.method == qc_methodLayers; });
    std::printf("  Collisions by %s: on the device in %zu of %zu steps, otherwise on the CPU\n", qcMethod_Name(method),
                size_t(byDevice), run.steps.size());
    if (!run.fallback.empty())
        std::printf("  (%s)\n", run.fallback.c_str());
    std::printf("\n");
    qcPrintStepCosts("mean milliseconds of a step:", {{"", qcMeanCosts(run.steps.begin(), run.steps.end())}});
    PrintContact(run);
    PrintCourse(run);
    std::vector<const qcQueryResults*> compared;
    uint32_t resolution = 0;
    for (const qcLeavesStep& step : run.steps)
        if (step.results[qc_queryQuick].counted)
        {
            compared.push_back(&step.results);
            resolution = step.results[qc_queryQuick].resolution;
        }
    qcPrintQuerySettings(request, resolution, device);
    qcPrintQueryTable("leaves and tree", compared);
}
