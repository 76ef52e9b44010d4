// CSV and closing table of the cloth demo.
#include "cloth/report.h"

#include "common/bullet/query_report.h"
#include "common/bullet/written_file.h"

#include <algorithm>

namespace
{
void WriteHeading(FILE* stream)
{
    std::fprintf(stream, "self_collision,step,seconds,step_ms,method,device,detect_ms,cull_ms,sweep_ms,exact_ms,"
                         "contact_ms,respond_ms,contacts,penetrating_before,rounds,planes,zone_nodes,exempt,"
                         "unproven,manifolds,penetrating_after,remaining,act");
    qcWriteQueryHeading(stream);
    std::fprintf(stream, "\n");
}

void WriteRows(FILE* stream, const qcClothRun& run, double stepSeconds)
{
    for (size_t i = 0; i < run.steps.size(); i++)
    {
        const qcClothStep& step = run.steps[i];
        const qcSoftBodyStatistics& s = step.statistics;
        std::fprintf(stream, "%s,%zu,%.4f,%.3f,%s,%s,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%d,%d,%d,%d,%d,%d,%d,%d,%zu,%d,%d",
                     run.selfCollision ? "with" : "without", i + 1, double(i + 1) * stepSeconds, step.costs.Total(),
                     qcMethod_Name(s.method), s.device, s.detectMs, s.cullMs, s.sweepMs, s.exactMs, s.contactMs,
                     s.respondMs, s.contacts, s.penetrating, s.rounds, s.planes, s.zoneNodes, s.exempt, s.unproven,
                     step.manifolds, step.Penetrating(), s.remaining, run.isPulled ? 2 : 1);
        qcWriteQueryColumns(stream, step.results);
        std::fprintf(stream, "\n");
    }
}

template <typename Value> double Mean(const qcClothRun& run, Value value)
{
    double sum = 0;
    for (const qcClothStep& step : run.steps)
        sum += double(value(step));
    return run.steps.empty() ? 0 : sum / double(run.steps.size());
}

template <typename Value> double Largest(const qcClothRun& run, Value value)
{
    double largest = 0;
    for (const qcClothStep& step : run.steps)
        largest = std::max(largest, double(value(step)));
    return largest;
}

const char* Label(const qcClothRun& run)
{
    return run.isPulled ? "pulled away" : run.selfCollision ? "on" : "off";
}

/// A number of each run.
template <typename Value> void PrintRow(const char* label, const qcClothRuns& runs, Value value)
{
    std::printf("  %-46s", label);
    for (const qcClothRun* run : runs)
        std::printf(" %12.0f", double(value(*run)));
    std::printf("\n");
}

/// A count of each step: mean and max.
template <typename Value> void PrintMeanAndMax(const char* label, const qcClothRuns& runs, Value value)
{
    std::printf("  %-46s", label);
    for (const qcClothRun* run : runs)
        std::printf(" %8.1f %8.0f", Mean(*run, value), Largest(*run, value));
    std::printf("\n");
}

/// What kept surfaces apart where contacts did not suffice, and what it left.
void PrintFilter(const qcClothRuns& runs)
{
    std::printf("\n  %-46s", "What kept surfaces from passing, in a step:");
    for (const qcClothRun* run : runs)
        std::printf(" %17s", Label(*run));
    std::printf("\n  %-46s", "");
    for (size_t i = 0; i < runs.size(); i++)
        std::printf(" %8s %8s", "mean", "max");
    std::printf("\n");
    PrintMeanAndMax("planes (pairs pushed apart)", runs, [](const qcClothStep& s) { return s.statistics.planes; });
    PrintMeanAndMax("nodes in zones (moved as one)", runs, [](const qcClothStep& s) { return s.statistics.zoneNodes; });
    PrintMeanAndMax("exempt pairs (tangled)", runs, [](const qcClothStep& s) { return s.statistics.exempt; });
    PrintMeanAndMax("unproven pairs", runs, [](const qcClothStep& s) { return s.statistics.unproven; });
    PrintMeanAndMax("remaining (penetrating, with table and floor)", runs,
                    [](const qcClothStep& s) { return s.statistics.remaining; });
}

void PrintCompared(const char* label, const qcClothRun& run)
{
    std::vector<const qcQueryResults*> frames;
    for (const qcClothStep& step : run.steps)
        if (step.compared)
            frames.push_back(&step.results);
    qcPrintQueryTable(label, frames);
}

/// The method that the simulation requested, and where it ran.
void PrintLoop(const qcClothRun& run, qcMethod method, const qcDeviceInfo& device)
{
    size_t byDevice = 0;
    for (const qcClothStep& step : run.steps)
        byDevice += step.statistics.method == qc_methodLayers;
    std::printf("  Self-collisions by %s: ", qcMethod_Name(method));
    if (byDevice != 0)
        std::printf("on %s (%s) in %zu of %zu steps\n", device.name, device.renderer, byDevice, run.steps.size());
    else
        std::printf("on the CPU\n");
    if (!run.fallback.empty())
        std::printf("  (%s)\n", run.fallback.c_str());
    std::printf("\n");
}
} // namespace

bool qcWriteClothCsv(const std::string& path, const qcClothRuns& runs, double stepSeconds, std::string* message)
{
    auto write = [&](std::FILE* stream)
    {
        WriteHeading(stream);
        for (const qcClothRun* run : runs)
            WriteRows(stream, *run, stepSeconds);
    };
    return qcWriteFile(path, write, message);
}

void qcPrintClothTable(const qcClothRuns& runs, qcMethod method, const qcDetectDef& request, const qcDeviceInfo& device)
{
    auto contacts = [](const qcClothStep& s) { return s.statistics.contacts; };
    auto penetrating = [](const qcClothStep& s) { return s.Penetrating(); };
    const qcClothRun& first = *runs.front();

    std::printf("\nCloth over a table: %zu triangles; steps:", first.triangles);
    for (const qcClothRun* run : runs)
        std::printf(" %zu (%s)", run->steps.size(), Label(*run));
    std::printf("\n\n");
    PrintLoop(first, method, device);
    std::vector<std::pair<std::string, qcStepCosts>> costs;
    for (const qcClothRun* run : runs)
        costs.emplace_back(Label(*run), qcMeanCosts(run->steps.begin(), run->steps.end()));
    qcPrintStepCosts("self-collision; mean milliseconds of a step:", costs);
    std::printf("\n");
    PrintRow("self-contacts in a step, mean", runs, [&](const qcClothRun& run) { return Mean(run, contacts); });
    PrintRow("self-contacts in a step, max", runs, [&](const qcClothRun& run) { return Largest(run, contacts); });
    PrintRow("self-penetrating pairs after a step, max", runs,
             [&](const qcClothRun& run) { return Largest(run, penetrating); });
    PrintRow("self-penetrating pairs at the end", runs,
             [](const qcClothRun& run) { return run.steps.empty() ? 0 : run.steps.back().Penetrating(); });
    PrintFilter(runs);

    qcPrintQuerySettings(request,
                         uint32_t(Largest(first, [](const qcClothStep& s)
                                          { return s.compared ? s.results[qc_queryQuick].resolution : 0; })),
                         device);
    if (device.kind == qc_deviceNone)
        return;
    for (const qcClothRun* run : runs)
        PrintCompared(run->isPulled ? "pulled away" : run->selfCollision ? "with self-collision" : "without", *run);
}
