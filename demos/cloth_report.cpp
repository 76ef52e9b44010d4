// CSV and closing table of the cloth demo.
#include "cloth_report.h"

extern "C" {
#include "output_file.h"
}

#include <algorithm>
#include <cinttypes>

namespace
{
void WriteRows(FILE* stream, const qcClothRun& run, double stepSeconds)
{
    for (size_t i = 0; i < run.steps.size(); i++)
    {
        const qcClothStep& step = run.steps[i];
        const qcSoftBodyStatistics& s = step.statistics;
        std::fprintf(stream, "%s,%zu,%.4f,%.3f,%.3f,%.3f,%.3f,%.3f,%.3f,%d,%d,%d,%d,%d,%zu",
                     run.selfCollision ? "with" : "without", i + 1, double(i + 1) * stepSeconds, step.stepMs,
                     s.detectMs, s.sweepMs, s.exactMs, s.contactMs, s.respondMs, s.contacts, s.penetrating, s.rounds,
                     s.frozenNodes, step.manifolds, step.penetrating);
        const qcClothComparison& c = step.comparison;
        if (step.compared)
            std::fprintf(stream, ",%" PRIu32 ",%" PRIu32 ",%zu,%zu,%.3f,%.3f\n", c.cullide.pcs, c.quick.pcs,
                         c.cullide.pairs, c.quick.pairs, c.cullide.ms, c.quick.ms);
        else
            std::fprintf(stream, ",,,,,,\n");
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

/// Sums over the steps that were compared.
struct Compared
{
    size_t steps = 0, exactPairs = 0;
    uint32_t resolution = 0;
    double cullidePcs = 0, quickPcs = 0, cullideMs = 0, quickMs = 0;
    size_t cullidePairs = 0, quickPairs = 0;
};

Compared Sum(const qcClothRun& run)
{
    Compared sum;
    for (const qcClothStep& step : run.steps)
    {
        if (!step.compared)
            continue;
        sum.steps++;
        sum.exactPairs += step.penetrating;
        sum.resolution = step.comparison.quick.resolution;
        sum.cullidePcs += step.comparison.cullide.pcs;
        sum.quickPcs += step.comparison.quick.pcs;
        sum.cullideMs += step.comparison.cullide.ms;
        sum.quickMs += step.comparison.quick.ms;
        sum.cullidePairs += step.comparison.cullide.pairs;
        sum.quickPairs += step.comparison.quick.pairs;
    }
    return sum;
}

void PrintTwo(const char* label, double with, double without, int digits)
{
    std::printf("  %-46s %12.*f %12.*f\n", label, digits, with, digits, without);
}

void PrintCompared(const char* label, const qcClothRun& run)
{
    Compared sum = Sum(run);
    double n = sum.steps != 0 ? double(sum.steps) : 1;
    std::printf("  %s (%zu frames)\n", label, sum.steps);
    std::printf("    %-10s %14s %14s %10s %10s\n", "", "PCS, mean", "ms, mean", "found", "missed");
    std::printf("    %-10s %14.0f %14.0f %10zu %10zu\n", "cullide", sum.cullidePcs / n, sum.cullideMs / n,
                sum.cullidePairs, sum.exactPairs - sum.cullidePairs);
    std::printf("    %-10s %14.0f %14.0f %10zu %10zu\n", "quick", sum.quickPcs / n, sum.quickMs / n, sum.quickPairs,
                sum.exactPairs - sum.quickPairs);
    std::printf("    %-10s %14s %14s %10zu %10d\n", "exact", "", "", sum.exactPairs, 0);
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
    std::fprintf(output.stream,
                 "self_collision,step,seconds,step_ms,detect_ms,sweep_ms,exact_ms,contact_ms,respond_ms,contacts,"
                 "penetrating_before,rounds,"
                 "frozen_nodes,manifolds,penetrating_after,pcs_cullide,pcs_quick,pairs_cullide,pairs_quick,"
                 "cullide_ms,quick_ms\n");
    WriteRows(output.stream, with, stepSeconds);
    WriteRows(output.stream, without, stepSeconds);
    if (qcOutput_Commit(&output, &failure))
        return true;
    *message = failure.text;
    return false;
}

void qcPrintClothTable(const qcClothRun& with, const qcClothRun& without, size_t triangles, const qcDetectDef& request,
                       const qcDeviceInfo& device)
{
    auto detect = [](const qcClothStep& s) { return s.statistics.detectMs; };
    auto sweep = [](const qcClothStep& s) { return s.statistics.sweepMs; };
    auto exact = [](const qcClothStep& s) { return s.statistics.exactMs; };
    auto contact = [](const qcClothStep& s) { return s.statistics.contactMs; };
    auto respond = [](const qcClothStep& s) { return s.statistics.respondMs; };
    auto rest = [](const qcClothStep& s) { return s.stepMs - s.statistics.detectMs - s.statistics.respondMs; };
    auto contacts = [](const qcClothStep& s) { return s.statistics.contacts; };
    auto penetrating = [](const qcClothStep& s) { return s.penetrating; };
    auto frozen = [](const qcClothStep& s) { return s.statistics.frozenNodes; };

    std::printf("\nCloth over a table: %zu triangles, %zu steps\n\n", triangles, with.steps.size());
    std::printf("  %-46s %12s %12s\n", "self-collision:", "on", "off");
    PrintTwo("Bullet's own step, ms, mean", Mean(with, rest), Mean(without, rest), 2);
    PrintTwo("detection, ms, mean", Mean(with, detect), Mean(without, detect), 2);
    PrintTwo("  of it: sweep", Mean(with, sweep), Mean(without, sweep), 2);
    PrintTwo("  of it: exact test", Mean(with, exact), Mean(without, exact), 2);
    PrintTwo("  of it: contacts", Mean(with, contact), Mean(without, contact), 2);
    PrintTwo("response, ms, mean", Mean(with, respond), Mean(without, respond), 2);
    PrintTwo("self-contacts in a step, mean", Mean(with, contacts), Mean(without, contacts), 0);
    PrintTwo("self-contacts in a step, most", Largest(with, contacts), Largest(without, contacts), 0);
    PrintTwo("self-penetrating pairs after a step, most", Largest(with, penetrating), Largest(without, penetrating), 0);
    PrintTwo("self-penetrating pairs at the end", double(with.steps.empty() ? 0 : with.steps.back().penetrating),
             double(without.steps.empty() ? 0 : without.steps.back().penetrating), 0);
    PrintTwo("nodes put back to the start of a step, in all", Mean(with, frozen) * double(with.steps.size()),
             Mean(without, frozen) * double(without.steps.size()), 0);

    if (device.kind == qc_deviceNone)
    {
        std::printf("\n  No GL on this machine: cullide and quick were not asked.\n");
        return;
    }
    const uint32_t resolution = Sum(with).resolution;
    std::printf("\nThe paper's methods on the same frames: views %s, %u x %u pixels, ", request.views, resolution,
                resolution);
    if (request.iterations == 0)
        std::printf("until nothing changes");
    else
        std::printf("%u round%s", request.iterations, request.iterations == 1 ? "" : "s");
    std::printf("; %s (%s)\n\n", device.name, device.renderer);
    PrintCompared("with self-collision", with);
    PrintCompared("without", without);
}
