// CSV and closing table of the breaking demo.
#include "breaking/report.h"

#include "common/bullet/query_report.h"

#include "common/bullet/written_file.h"
#include "common/stopwatch.h"

#include <algorithm>
#include <iterator>

namespace
{
constexpr size_t s_neighbours = 8;  // on each side of a step
constexpr double s_spike = 3;       // times the median of its neighbours
constexpr double s_shortestMs = 10; // spikes of shorter steps are noise

void WriteRows(FILE* stream, const qcBreakingRun& run)
{
    std::fprintf(stream, "step,seconds,step_ms,cpu_ms,boxes_ms,pairs_ms,gather_ms,ahead_ms,cull_ms,sweep_ms,exact_ms,"
                         "points_ms,other_query_ms,manifolds_ms,solver_ms,break_ms,rest_ms,method,drops,new_pieces,"
                         "loose_pieces,broken_bonds,bodies,resting,pairs,points,penetration_mm,limited,unproven");
    qcWriteQueryHeading(stream);
    std::fprintf(stream, "\n");
    for (size_t i = 0; i < run.rows.size(); i++)
    {
        const qcBreakingRow& row = run.rows[i];
        const qcBreakingStep& step = row.step;
        std::fprintf(stream, "%zu,%.4f,%.3f,%.3f", i + 1, double(i + 1) * qcBreakingWorld::stepSeconds,
                     step.costs.Total(), row.cpuMs);
        for (qcStepCost cost :
             {qc_costBoxes, qc_costPairs, qc_costGather, qc_costAhead, qc_costCull, qc_costSweep, qc_costExact,
              qc_costPoints, qc_costOther, qc_costManifolds, qc_costRigid, qc_costBreak, qc_costRest})
            std::fprintf(stream, ",%.3f", step.costs.ms[cost]);
        std::fprintf(stream, ",%s,%zu,%zu,%zu,%zu,%zu,%zu,%d,%d,%.3f,%d,%d", qcMethod_Name(step.method), row.drops,
                     step.newPieces, step.loosePieces, step.brokenBonds, step.bodies, step.resting, step.pairs,
                     step.points, 1000 * double(step.penetration), step.limited, step.unproven);
        qcWriteQueryColumns(stream, row.results);
        std::fprintf(stream, "\n");
    }
}

/// The median of the values around one, without it.
double MedianAround(const std::vector<double>& values, size_t index)
{
    std::vector<double> around;
    size_t begin = index > s_neighbours ? index - s_neighbours : 0;
    for (size_t i = begin; i < values.size() && i <= index + s_neighbours; i++)
        if (i != index)
            around.push_back(values[i]);
    return qcStopwatch_Median(around.data(), around.size());
}

/// Steps slower than their neighbours: all, and those with new pieces; the largest factor of the latter.
void PrintSpikes(const char* label, const qcBreakingRun& run, const std::vector<double>& values)
{
    size_t count = 0, breaking = 0;
    double worst = 0;
    for (size_t i = 0; i < values.size(); i++)
    {
        double factor = values[i] / std::max(MedianAround(values, i), 1e-9);
        bool isSpike = factor > s_spike && values[i] > s_shortestMs;
        count += isSpike;
        breaking += isSpike && run.rows[i].step.newPieces > 0;
        if (run.rows[i].step.newPieces > 0)
            worst = std::max(worst, factor);
    }
    std::printf("  %-46s %12zu %12zu %11.1fx\n", label, count, breaking, worst);
}

void PrintCourse(const qcBreakingRun& run)
{
    std::printf("  %5s %8s %12s %10s %12s %10s %12s %12s\n", "drop", "time, s", "new bodies", "all loose",
                "broken bonds", "at rest", "ms, mean", "ms, longest");
    for (size_t begin = 0, end = 0; begin < run.rows.size(); begin = end)
    {
        double sum = 0, longest = 0;
        size_t made = 0;
        for (end = begin; end < run.rows.size() && run.rows[end].drops == run.rows[begin].drops; end++)
        {
            sum += run.rows[end].step.costs.Total();
            longest = std::max(longest, run.rows[end].step.costs.Total());
            made += run.rows[end].step.newPieces;
        }
        const qcBreakingStep& last = run.rows[end - 1].step;
        std::printf("  %5zu %8.2f %12zu %10zu %12zu %10zu %12.1f %12.1f\n", run.rows[begin].drops,
                    double(begin) * qcBreakingWorld::stepSeconds, made, last.loosePieces, last.brokenBonds,
                    last.resting, sum / double(end - begin), longest);
    }
    std::printf("\n");
}

void PrintCosts(const qcBreakingRun& run)
{
    std::vector<qcBreakingStep> steps, breaking;
    for (const qcBreakingRow& row : run.rows)
    {
        steps.push_back(row.step);
        if (row.step.newPieces > 0)
            breaking.push_back(row.step);
    }
    std::vector<std::pair<std::string, qcStepCosts>> columns = {{"mean", qcMeanCosts(steps.begin(), steps.end())}};
    if (!breaking.empty())
        columns.push_back({"mean of breaks", qcMeanCosts(breaking.begin(), breaking.end())});
    qcPrintStepCosts("milliseconds of a step", columns);
    std::printf("\n");
}

void PrintMaxima(const qcBreakingRun& run)
{
    btScalar deepest = 0;
    int unproven = 0, pairs = 0;
    for (const qcBreakingRow& row : run.rows)
    {
        deepest = std::max(deepest, row.step.penetration);
        unproven += row.step.unproven;
        pairs = std::max(pairs, row.step.pairs);
    }
    std::printf("  %-46s %12d\n", "pairs of boxes, most", pairs);
    std::printf("  %-46s %12.1f\n", "deepest contact point, shells included, mm", 1000 * double(deepest));
    std::printf("  %-46s %12d\n", "pairs that could not be kept apart, sum", unproven);
    std::printf("  %-46s %12zu\n\n", "penetrating triangles of two bodies at the end", run.penetratingPairs);
}
} // namespace

bool qcWriteBreakingCsv(const std::string& path, const qcBreakingRun& run, std::string* message)
{
    return qcWriteFile(
        path, [&run](std::FILE* stream) { WriteRows(stream, run); }, message);
}

void qcPrintBreakingTable(const qcBreakingRun& run, const qcDetectDef& request, const qcDeviceInfo& device)
{
    std::printf("\nA bunny of %u triangles falls on a dragon of %u triangles: %zu steps of 1/%.0f s\n",
                run.bunnyTriangles, run.dragonTriangles, run.rows.size(), 1 / qcBreakingWorld::stepSeconds);
    if (run.knotStandsIn)
        std::printf("  (a knot stands in for the dragon: --dragon names no file)\n");
    if (run.ballStandsIn)
        std::printf("  (a ball stands in for the bunny: its file was not there)\n");
    std::printf("  Cut in advance into %zu pieces of %zu triangles with %zu bonds, in %.1f s\n", run.pieces,
                run.pieceTriangles, run.bonds, run.loadMs / 1000);
    if (!run.fallback.empty())
        std::printf("  (%s)\n", run.fallback.c_str());
    std::printf("\n");
    if (run.rows.empty())
        return;
    PrintCourse(run);
    PrintCosts(run);
    std::printf("  %-46s %12s %12s %12s\n", "steps slower than 3 times the median around them", "all", "of breaks",
                "worst break");
    std::vector<double> wall, cpu;
    for (const qcBreakingRow& row : run.rows)
    {
        wall.push_back(row.step.costs.Total());
        cpu.push_back(row.cpuMs);
    }
    PrintSpikes("by the clock", run, wall);
    PrintSpikes("by processor time, all threads", run, cpu);
    std::printf("\n");
    PrintMaxima(run);
    uint32_t resolution = 0;
    std::vector<const qcQueryResults*> frames;
    for (const qcBreakingRow& row : run.rows)
        if (row.results[qc_querySweep].counted)
        {
            frames.push_back(&row.results);
            resolution = std::max(resolution, row.results[qc_queryQuick].resolution);
        }
    qcPrintQuerySettings(request, resolution, device);
    qcPrintQueryTable("The bunny and all pieces", frames);
}
