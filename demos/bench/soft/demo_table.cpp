// Each scene three times in turn, step by step: a machine that is busy for a while slows all of them. The median of the
// steps counts.
#include "bench/soft/demo_table.h"
#include "bench/soft/demo_scenes.h"

#include "common/files.h"
#include "common/interrupt.h"
#include "common/output_file.h"
#include "common/median.h"
#include "common/stopwatch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace
{
constexpr int s_sides = 3; ///< of qcDemoContact

struct DemoRow
{
    const char* scene;
    size_t nodes;
    double ms[s_sides];
    double pairs[s_sides]; ///< that penetrate at the end; NaN: not countable
};

DemoRow Measure(const qcDemoSceneDef& def, uint32_t steps)
{
    std::array<std::unique_ptr<qcDemoScene>, s_sides> scenes;
    std::vector<double> times[s_sides];
    for (int side = 0; side < s_sides; side++)
        scenes[size_t(side)].reset(new qcDemoScene(qcDemoContact(side), def.isDeformable, def.make));
    for (uint32_t step = 0; step < steps; step++)
        for (int side = 0; side < s_sides; side++)
        {
            double start = qcStopwatch_NowMs();
            scenes[size_t(side)]->Step();
            times[side].push_back(qcStopwatch_NowMs() - start);
        }
    DemoRow row = {def.name, scenes[0]->NodeCount(), {}, {}};
    for (int side = 0; side < s_sides; side++)
    {
        row.ms[side] = qcMedianOf(times[side]);
        size_t pairs = scenes[size_t(side)]->CountTangled();
        row.pairs[side] = pairs == SIZE_MAX ? NAN : double(pairs);
    }
    return row;
}

void PrintHead()
{
    std::printf("\nSmall scenes; like Bullet: without contact within a body, Bullet's own contact with rigid bodies\n"
                "%-27s %6s %8s %8s %6s %8s %6s  %s\n",
                "", "nodes", "Bullet", "ours", "", "like", "", "penetrating pairs at the end");
    std::printf("%-27s %6s %8s %8s %6s %8s %6s  %s\n", "", "", "ms", "ms", "ratio", "Bullet", "ratio",
                "Bullet, ours, like Bullet");
}

void PrintRow(const DemoRow& row)
{
    std::printf("%-27s %6zu %8.3f %8.3f %6.2f %8.3f %6.2f  %.0f, %.0f, %.0f\n", row.scene, row.nodes, row.ms[0],
                row.ms[1], row.ms[1] / row.ms[0], row.ms[2], row.ms[2] / row.ms[0], row.pairs[0], row.pairs[1],
                row.pairs[2]);
    std::fflush(stdout);
}
} // namespace

bool qcDemoTable_Run(const char* folder, uint32_t steps, qcMessage* message)
{
    qcOutput output;
    if (!qcFiles_Open(folder, "soft_demos.csv", &output, message))
        return false;
    std::fputs("scene,nodes,bullet_ms,ms,ratio,like_bullet_ms,like_bullet_ratio,bullet_pairs,pairs,like_bullet_pairs\n",
               output.stream);
    PrintHead();
    for (const qcDemoSceneDef& def : qcDemoScenes())
    {
        if (qcInterrupt_Signal() != 0)
            break;
        DemoRow row = Measure(def, steps);
        PrintRow(row);
        qcFiles_WriteQuoted(output.stream, row.scene);
        std::fprintf(output.stream, ",%zu,%.6g,%.6g,%.6g,%.6g,%.6g,%.0f,%.0f,%.0f\n", row.nodes, row.ms[0], row.ms[1],
                     row.ms[1] / row.ms[0], row.ms[2], row.ms[2] / row.ms[0], row.pairs[0], row.pairs[1], row.pairs[2]);
    }
    return qcOutput_Commit(&output, message);
}
