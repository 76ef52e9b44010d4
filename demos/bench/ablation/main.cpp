// qc-ablation: a table of the scenes with all stages of manifolds, and with each one switched off. It compiles the core
// with these switches, which the library does not have.
#include "bench/ablation/ablation.h"

#include "common/options.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace
{
const char s_help[] =
    "Runs each scene with all stages of manifolds, then with each stage switched off.\v"
    "Exit status: 0 done; 1 output could not be written; 2 a mistake on the command line; 130 ended by Ctrl-C.";

const char* const s_stages[] = {
    "",
    "separatingPlane",
    "neighbourCost",
    "localMinimum",
    "propagation",
    "orientation",
    "outwardNormals",
    "minimumTranslation",
    "fallbackPoints",
    "merge",
    "coplanarReduction",
};

constexpr size_t s_stageCount = sizeof s_stages / sizeof s_stages[0];

/// Adds a run to the means and maxima.
void Add(const qcAblationResult& run, unsigned runs, qcAblationResult* sum)
{
    sum->ms += run.ms / runs;
    sum->points += run.points / runs;
    sum->depth = std::max(sum->depth, run.depth);
    sum->penetration = std::max(sum->penetration, run.penetration);
    sum->speed = run.speed < 0 ? -1 : std::max(sum->speed, 0.0) + run.speed / runs;
}

void PrintRow(const char* scene, const char* stage, const qcAblationResult& result)
{
    std::printf("%-16s %-20s %8.3f %8.1f", scene, *stage == 0 ? "(all stages)" : stage, result.ms, result.points);
    if (result.depth >= 0)
        std::printf(" %12.3f %12s %12s\n", result.depth, "", "");
    else
        std::printf(" %12s %12.2f %12.3f\n", "", result.penetration, result.speed);
    std::fflush(stdout);
}

/// All stages of one seed in turn, so that disturbances of the machine affect all stages equally.
void PrintScene(const qcAblationScene& scene)
{
    qcAblationResult results[s_stageCount];
    for (unsigned seed = 1; seed <= scene.runs; seed++)
        for (size_t i = 0; i < s_stageCount; i++)
            Add(scene.run(seed, s_stages[i]), scene.runs, &results[i]);
    for (size_t i = 0; i < s_stageCount; i++)
        PrintRow(scene.name, s_stages[i], results[i]);
}
} // namespace

void qcSwitchOff(const char* stage)
{
    setenv("QC_MANIFOLD_OFF", stage, 1);
}

int main(int argumentCount, char** arguments)
{
    uint32_t steps = 360;
    const qcOption rows[] = {{1, "steps", "N", "Length of a simulation in steps of 1/60 s, at least 61; %s by default",
                              qcOption_Number(&steps, 61, 1000000)},
                             {}};
    qcCommandLine line = {rows, s_help, nullptr, nullptr, 0, nullptr, nullptr};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    std::printf("%-16s %-20s %8s %8s %12s %12s %12s\n", "scene", "switched off", "ms", "points", "depth/true",
                "overlap mm", "speed mm/s");
    using namespace std::placeholders;
    const qcAblationScene scenes[] = {
        {"box in tiles", 4, qcRunSunkBox},
        {"displaced cells", 8, qcRunDisplacedCells},
        {"pile of boxes", 3, std::bind(qcRunBoxPile, _1, _2, steps)},
        {"pile of tori", 3, std::bind(qcRunTorusPile, _1, _2, steps)},
        {"fracture", 3, std::bind(qcRunFracture, _1, _2, steps)},
    };
    for (const qcAblationScene& scene : scenes)
        PrintScene(scene);
    return 0;
}
