// qc-breaking: the paper's second scene. A bunny falls on a dragon again and again, and each time a part of the dragon
// breaks off.
#include "breaking/picture.h"
#include "breaking/world.h"
#include "common/bullet/demo_options.h"

#include "common/files.h"
#include "common/interrupt.h"
#include "common/mesh_io/bunny_path.h"
#include "common/progress.h"
#include "common/stopwatch.h"

#include <cstdio>
#include <ctime>

namespace
{
struct Options
{
    qcDemoOptions common = {"out/breaking", 600, 6, qc_methodAuto, qc_deviceAuto, 0};
    qcBreakingModelDef model;
    const char* dragon = "build/models/dragon_vrip.ply";
    const char* bunny = QC_BUNNY_PATH;
};
const char s_help[] = "x\vy";
int Run(Options& options, qcDevice* device)
{
    qcBreakingModel model;
    std::string message;
    double start = qcStopwatch_NowMs();
    options.model.dragon = options.dragon;
    options.model.bunny = options.bunny;
    if (!qcMakeBreakingModel(options.model, &model, &message))
    {
        qcDemo_Fail(message);
        return 1;
    }
    size_t triangles = 0;
    for (auto& s : model.shapes)
        triangles += s->getTriangleCount();
    std::printf("# model %.0f ms, %zu pieces, %zu triangles of pieces, dragon %u, bunny %u vol %g; bonds %zu\n",
                qcStopwatch_NowMs() - start, model.shapes.size(), triangles, model.dragonTriangles,
                model.bunny.shape->getTriangleCount(), model.bunny.volume, model.fracture.bonds.size());
    start = qcStopwatch_NowMs();
    qcBreakingWorld world(model, options.common.method, options.common.threads, device);
    std::printf("# world %.0f ms\n", qcStopwatch_NowMs() - start);
    qcBreakingPicture picture;
    double drawn = 0;
    for (size_t step = 1; step <= options.common.steps && qcInterrupt_Signal() == 0; step++)
    {
        qcBreakingStep m;
        std::clock_t c0 = std::clock();
        if (!world.Step(&m, &message))
        {
            qcDemo_Fail(message);
            return 1;
        }
        auto& c = m.costs.ms;
        double cpu = double(std::clock() - c0) / CLOCKS_PER_SEC * 1000;
        std::printf("%zu drops %zu ms %.1f new %zu loose %zu bonds %zu bodies %zu awake %zu pairs %d points %d pen "
                    "%.1f lim %d unp %d | gather %.1f ahead %.1f sweep %.1f exact %.1f points %.1f other %.1f manif "
                    "%.1f rigid %.1f break %.1f rest %.1f pairs %.1f boxes %.1f cpu %.1f\n",
                    step, world.Drops(), m.costs.Total(), m.newPieces, m.loosePieces, m.brokenBonds, m.bodies, m.awake,
                    m.pairs, m.points, 1000 * double(m.penetration), m.limited, m.unproven, c[qc_costGather],
                    c[qc_costAhead], c[qc_costSweep], c[qc_costExact], c[qc_costPoints], c[qc_costOther],
                    c[qc_costManifolds], c[qc_costRigid], c[qc_costBreak], c[qc_costRest], c[qc_costPairs],
                    c[qc_costBoxes], cpu);
        std::fflush(stdout);
        if (step % options.common.frameEvery == 0)
        {
            char name[64];
            std::snprintf(name, sizeof name, "/frame_%04zu.png", (step - 1) / options.common.frameEvery);
            double t = qcStopwatch_NowMs();
            qcBreakingMarks marks;
            if (!picture.Write(device, world, marks, std::string(options.common.out) + name, &message))
            {
                qcDemo_Fail(message);
                return 1;
            }
            drawn += qcStopwatch_NowMs() - t;
        }
    }
    std::printf("# drawing %.0f ms\n", drawn);
    return 0;
}
} // namespace

int main(int argumentCount, char** arguments)
{
    Options options;
    const std::vector<qcOption> rows = {
        {1, "dragon", "FILE", "x", qcOption_Text(&options.dragon)},
        {1, "bunny", "FILE", "x", qcOption_Text(&options.bunny)},
        {1, "cells", "N", "x", qcOption_Number(&options.model.cells, 1, 100000)},
        {1, "drops", "N", "x", qcOption_Number(&options.model.drops, 1, 100000)},
        {1, "triangles", "N", "x", qcOption_Number(&options.model.dragonTriangles, 1, 10000000)},
        {1, "seed", "N", "x", qcOption_Number(&options.model.seed, 0, 100000)}};
    qcDevice* device = nullptr;
    int status = qcDemo_Begin(rows, s_help, argumentCount, arguments, &options.common, &device);
    if (status != qc_exitDone)
        return status;
    status = Run(options, device);
    qcDevice_Destroy(device);
    return status;
}
