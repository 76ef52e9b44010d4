// CSV and closing table of the cloth demo.
#include "cloth/report.h"

#include "common/bullet/query_report.h"
#include "common/output_file.h"

#include <algorithm>

namespace
{
void WriteHeading(FILE* stream)
{
    std::fprintf(stream, "self_collision,step,seconds,step_ms,method,device,detect_ms,cull_ms,sweep_ms,exact_ms,"
                         "contact_ms,respond_ms,contacts,penetrating_before,rounds,planes,zone_nodes,exempt,"
                         "unproven,manifolds,penetrating_after");
    qcWriteQueryHeading(stream);
    std::fprintf(stream, "\n");
}

void WriteRows(FILE* stream, const qcClothRun& run, double stepSeconds)
{
    for (size_t i = 0; i < run.steps.size(); i++)
    {
        const qcClothStep& step = run.steps[i];
        const qcSoftBodyStatistics& s = step.statistics;
        std::fprintf(stream, "%s,%zu,%.4f,%.3f,%s,%s,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%d,%d,%d,%d,%d,%d,%d,%d,%zu",
                     run.selfCollision ? "with" : "without", i + 1, double(i + 1) * stepSeconds, step.costs.Total(),
                     qcMethod_Name(s.method), s.device, s.detectMs, s.cullMs, s.sweepMs, s.exactMs, s.contactMs,
                     s.respondMs, s.contacts, s.penetrating, s.rounds, s.planes, s.zoneNodes, s.exempt, s.unproven,
                     step.manifolds, step.Penetrating());
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

void PrintTwo(const char* label, double with, double without, int digits)
{
    std::printf("  %-46s %12.*f %12.*f\n", label, digits, with, digits, without);
}

/// A count of each step: mean and max, with self-collision and without.
template <typename Value>
void PrintMeanAndMax(const char* label, const qcClothRun& with, const qcClothRun& without, Value value)
{
    std::printf("  %-46s %8.1f %8.0f %8.1f %8.0f\n", label, Mean(with, value), Largest(with, value),
                Mean(without, value), Largest(without, value));
}

/// What kept surfaces apart where contacts did not suffice.
void PrintFilter(const qcClothRun& with, const qcClothRun& without)
{
    std::printf("\n  %-46s %17s %17s\n", "What kept surfaces from passing, in a step:", "self-collision on", "off");
    std::printf("  %-46s %8s %8s %8s %8s\n", "", "mean", "max", "mean", "max");
    PrintMeanAndMax("planes (pairs pushed apart)", with, without,
                    [](const qcClothStep& s) { return s.statistics.planes; });
    PrintMeanAndMax("nodes in zones (moved as one)", with, without,
                    [](const qcClothStep& s) { return s.statistics.zoneNodes; });
    PrintMeanAndMax("exempt pairs (tangled)", with, without, [](const qcClothStep& s) { return s.statistics.exempt; });
    PrintMeanAndMax("unproven pairs", with, without, [](const qcClothStep& s) { return s.statistics.unproven; });
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

bool qcWriteClothCsv(const std::string& path, const qcClothRun& with, const qcClothRun& without, double stepSeconds,
                     std::string* message)
{
    qcOutput output;
    qcMessage failure;
    if (!qcOutput_Open(path.c_str(), &output, &failure))
    {
        *message = failure.text;
        return false;
    }
    WriteHeading(output.stream);
    WriteRows(output.stream, with, stepSeconds);
    WriteRows(output.stream, without, stepSeconds);
    if (qcOutput_Commit(&output, &failure))
        return true;
    *message = failure.text;
    return false;
}

void qcPrintClothTable(const qcClothRun& with, const qcClothRun& without, size_t triangles, qcMethod method,
                       const qcDetectDef& request, const qcDeviceInfo& device)
{
    auto contacts = [](const qcClothStep& s) { return s.statistics.contacts; };
    auto penetrating = [](const qcClothStep& s) { return s.Penetrating(); };

    std::printf("\nCloth over a table: %zu triangles, %zu steps\n\n", triangles, with.steps.size());
    PrintLoop(with, method, device);
    qcPrintStepCosts("self-collision; mean milliseconds of a step:",
                     {{"on", qcMeanCosts(with.steps.begin(), with.steps.end())},
                      {"off", qcMeanCosts(without.steps.begin(), without.steps.end())}});
    std::printf("\n");
    PrintTwo("self-contacts in a step, mean", Mean(with, contacts), Mean(without, contacts), 0);
    PrintTwo("self-contacts in a step, max", Largest(with, contacts), Largest(without, contacts), 0);
    PrintTwo("self-penetrating pairs after a step, max", Largest(with, penetrating), Largest(without, penetrating), 0);
    PrintTwo("self-penetrating pairs at the end", double(with.steps.empty() ? 0 : with.steps.back().Penetrating()),
             double(without.steps.empty() ? 0 : without.steps.back().Penetrating()), 0);
    PrintFilter(with, without);

    qcPrintQuerySettings(
        request, uint32_t(Largest(with, [](const qcClothStep& s) { return s.results[qc_queryQuick].resolution; })),
        device);
    if (device.kind == qc_deviceNone)
        return;
    PrintCompared("with self-collision", with);
    PrintCompared("without", without);
}
