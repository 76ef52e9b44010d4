// CSV and closing table of the fracture demo.
#include "fracture/report.h"

#include "common/bullet/written_file.h"

#include <algorithm>

namespace
{
constexpr size_t s_energyRows = 8;

double Seconds(size_t index)
{
    return double(index + 1) * qcFractureWorld::stepSeconds;
}

void WriteRows(FILE* stream, const qcFractureRun& run)
{
    std::fprintf(stream,
                 "step,seconds,step_ms,boxes_ms,pairs_ms,gather_ms,ahead_ms,cull_ms,sweep_ms,exact_ms,points_ms,"
                 "other_query_ms,manifolds_ms,solver_ms,break_ms,rest_ms,method,bodies,awake,pairs,points,"
                 "penetration_mm,lowest_mm,kinetic_j\n");
    for (size_t i = 0; i < run.steps.size(); i++)
    {
        const qcFractureStep& step = run.steps[i];
        std::fprintf(stream, "%zu,%.4f,%.3f", i + 1, Seconds(i), step.costs.Total());
        for (qcStepCost cost :
             {qc_costBoxes, qc_costPairs, qc_costGather, qc_costAhead, qc_costCull, qc_costSweep, qc_costExact,
              qc_costPoints, qc_costOther, qc_costManifolds, qc_costRigid, qc_costBreak, qc_costRest})
            std::fprintf(stream, ",%.3f", step.costs.ms[cost]);
        std::fprintf(stream, ",%s,%zu,%zu,%d,%d,%.4f,%.3f,%.6g\n", qcMethod_Name(step.method), step.bodies, step.awake,
                     step.pairs, step.points, 1000 * double(step.penetration), 1000 * double(step.lowest), step.energy);
    }
}

void PrintMomentum(const char* label, const btVector3& before, const btVector3& after)
{
    std::printf("  %-28s %9.3f %9.3f %9.3f   %9.3f %9.3f %9.3f   %8.1e\n", label, double(before.x()),
                double(before.y()), double(before.z()), double(after.x()), double(after.y()), double(after.z()),
                double((after - before).length() / std::max(before.length(), btScalar(1e-9))));
}

void PrintBreak(const qcFractureRun& run, size_t step)
{
    const qcBreak& broken = run.broken;
    std::printf(
        "  It broke in step %zu, after %.2f s, at %.1f m/s: %zu pieces, %zu triangles; lost %.1e of its volume\n\n",
        step + 1, Seconds(step), double(broken.speed), broken.pieces, broken.triangles, double(broken.lostVolume));
    std::printf("  The break, ms: choosing cells %.1f, cutting %.1f, making bodies %.1f; the step %.1f\n\n",
                broken.sitesMs, broken.splitMs, broken.bodiesMs, run.steps[step].costs.Total());
    std::printf("  %-28s %-29s   %-29s   %8s\n", "", "before (x, y, z)", "after (x, y, z)", "relative");
    PrintMomentum("momentum, kg m/s", broken.before.linear, broken.after.linear);
    PrintMomentum("angular momentum, kg m2/s", broken.before.angular, broken.after.angular);
    std::printf("\n");
}

void PrintCourse(const qcFractureRun& run)
{
    std::printf("  %9s %12s %10s %9s %9s %15s %11s\n", "time, s", "kinetic, J", "awake", "pairs", "points",
                "penetration, mm", "lowest, mm");
    size_t count = run.steps.size(), last = count;
    for (size_t row = 1; row <= s_energyRows; row++)
    {
        size_t i = row * count / s_energyRows;
        if (i == 0 || i - 1 == last)
            continue;
        last = i - 1;
        const qcFractureStep& step = run.steps[last];
        std::printf("  %9.3f %12.4g %10zu %9d %9d %15.2f %11.2f\n", Seconds(last), step.energy, step.awake, step.pairs,
                    step.points, 1000 * double(step.penetration), 1000 * double(step.lowest));
    }
    std::printf("\n");
}
} // namespace

bool qcWriteFractureCsv(const std::string& path, const qcFractureRun& run, std::string* message)
{
    return qcWriteFile(
        path, [&run](std::FILE* stream) { WriteRows(stream, run); }, message);
}

void qcPrintFractureTable(const qcFractureRun& run, const qcDeviceInfo& device)
{
    const std::vector<qcFractureStep>& steps = run.steps;
    size_t count = steps.size();
    auto found = std::find_if(steps.begin(), steps.end(), [](const qcFractureStep& step) { return step.breaks; });
    auto breaking = size_t(found - steps.begin());
    std::printf("\nA body of %u triangles and %.0f kg falls and breaks: %zu steps of 1/%.0f s\n\n", run.triangles,
                double(run.mass), count, 1 / qcFractureWorld::stepSeconds);
    auto byDevice = size_t(std::count_if(steps.begin(), steps.end(),
                                         [](const qcFractureStep& step) { return step.method == qc_methodLayers; }));
    std::printf("  Contact of meshes: on the %s", byDevice != 0 ? device.name : "CPU");
    if (byDevice != 0)
        std::printf(" in %zu of %zu steps", byDevice, count);
    std::printf("%s%s%s\n", run.fallback.empty() ? "" : " (", run.fallback.c_str(), run.fallback.empty() ? "" : ")");
    if (count == 0)
        return;
    if (breaking < count)
        PrintBreak(run, breaking);
    else
        std::printf("  It did not break in these steps\n\n");

    auto longest = size_t(std::max_element(steps.begin(), steps.end(),
                                           [](const qcFractureStep& a, const qcFractureStep& b)
                                           { return a.costs.Total() < b.costs.Total(); }) -
                          steps.begin());
    std::vector<std::pair<std::string, qcStepCosts>> columns = {{"mean", qcMeanCosts(steps.begin(), steps.end())}};
    if (breaking < count)
        columns.push_back({"the break", steps[breaking].costs});
    if (breaking + 1 < count)
        columns.push_back({"mean after", qcMeanCosts(found + 1, steps.end())});
    columns.push_back({"longest", steps[longest].costs});
    qcPrintStepCosts("milliseconds of a step", columns);
    std::printf("  %-46s %12zu\n\n", "number of the longest step", longest + 1);
    PrintCourse(run);

    btScalar deepest = 0, lowest = BT_LARGE_FLOAT;
    int pairs = 0;
    for (const qcFractureStep& step : steps)
    {
        deepest = std::max(deepest, step.penetration);
        lowest = std::min(lowest, step.lowest);
        pairs = std::max(pairs, step.pairs);
    }
    std::printf("  %-46s %12d\n", "pairs of boxes, most", pairs);
    std::printf("  %-46s %12.2f\n", "deepest penetration (shells, floor), mm", 1000 * double(deepest));
    std::printf("  %-46s %12.2f\n", "lowest point above the floor, ever, mm", 1000 * double(lowest));
    std::printf("  %-46s %12zu\n", "penetrating triangles of two pieces at the end", run.penetratingPairs);
}
