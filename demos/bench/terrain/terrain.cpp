// qc-bench terrain: convex bodies on hills of triangles, on this library's shape and on Bullet's.
#include "bench/terrain/world.h"

#include "bench/bench.h"
#include "common/files.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/progress.h"

#include <algorithm>
#include <cstdio>

namespace
{
struct Options
{
    bool kinds[qc_terrainKinds] = {};
    uint32_t bodies = 200, steps = 240;
    const char* out = "out/bench";
};

/// How bodies begin.
struct Start
{
    const char* name;
    btVector3 velocity;
    btScalar height;
};

const Start s_starts[] = {{"rolling", btVector3(4, 0, 0), btScalar(0.3)}, {"thrown", btVector3(30, -60, 0), 10}};
const uint32_t s_cells[] = {40, 200};

struct Row
{
    double ms[2] = {}, limitMs = 0; ///< means; Bullet's first
    size_t below[2] = {};
};

const char s_help[] =
    "Convex bodies of 0.4 m that roll over hills of triangles at 4 m/s, or are thrown at them at 67 m/s: qcMeshShape "
    "with qcMeshContact and qcBroadphase beside btBvhTriangleMeshShape with btDbvtBroadphase, step by step in turn, "
    "one thread.\v"
    "Milliseconds: mean of a step. Limits: what keeps bodies from passing the hills, part of ours. Below: bodies under "
    "the hills at the end. Exit status: as for qc-bench; 1 too if a query failed.";

/// Both step by step in turn. False with a message.
bool Measure(const Options& options, const qcTerrainSetup& setup, Row* row, qcMessage* message)
{
    qcTerrainWorld bullets(setup, false), ours(setup, true);
    qcTerrainWorld* const worlds[] = {&bullets, &ours};
    for (uint32_t step = 0; step < options.steps && qcInterrupt_Signal() == 0; step++)
    {
        for (uint32_t i = 0; i < 2; i++)
        {
            const uint32_t which = (i + step) % 2;
            row->ms[which] += worlds[which]->Step() / options.steps;
        }
        row->limitMs += ours.LimitMs() / options.steps;
        if (ours.Status() != qc_statusOk)
            return qcMessage_Fail(message, "%s, step %u: %s", qcTerrainName(setup.kind), unsigned(step + 1),
                                  qcStatus_Name(ours.Status()));
    }
    for (int i = 0; i < 2; i++)
        row->below[i] = worlds[i]->CountBelow();
    return true;
}

bool MeasureAll(const Options& options, FILE* stream, qcMessage* message)
{
    std::printf("%u bodies, %u steps\n\n%-10s %-8s %9s %10s %10s %7s %10s   %s\n", unsigned(options.bodies),
                unsigned(options.steps), "bodies", "start", "triangles", "Bullet, ms", "ours, ms", "ratio",
                "limits, ms", "below: Bullet, ours");
    for (int kind = 0; kind < qc_terrainKinds; kind++)
        for (const Start& start : s_starts)
            for (uint32_t cells : s_cells)
            {
                if (!options.kinds[kind])
                    continue;
                qcTerrainSetup setup;
                setup.kind = qcTerrainKind(kind);
                setup.cells = cells;
                setup.bodies = options.bodies;
                setup.velocity = start.velocity;
                setup.height = start.height;
                Row row;
                if (!Measure(options, setup, &row, message))
                    return false;
                // What was cut short has no means to compare.
                if (qcInterrupt_Signal() != 0)
                    return true;
                const unsigned triangles = 2 * cells * cells;
                std::printf("%-10s %-8s %9u %10.3f %10.3f %7.2f %10.3f   %13zu, %4zu\n", qcTerrainName(setup.kind),
                            start.name, triangles, row.ms[0], row.ms[1], row.ms[1] / row.ms[0], row.limitMs,
                            row.below[0], row.below[1]);
                std::fflush(stdout);
                std::fprintf(stream, "%s,%s,%u,%u,%.5g,%.5g,%.5g,%zu,%zu\n", qcTerrainName(setup.kind), start.name,
                             triangles, unsigned(options.bodies), row.ms[0], row.ms[1], row.limitMs, row.below[0],
                             row.below[1]);
            }
    return true;
}

qcExitStatus Run(const Options& options, qcMessage* message)
{
    qcInterrupt_Watch();
    qcOutput output;
    if (!qcFiles_Check(options.out, "terrain.csv", message) ||
        !qcFiles_Open(options.out, "terrain.csv", &output, message))
        return qc_exitFailed;
    std::fputs("bodies,start,triangles,count,bullet ms,ours ms,limits ms,bullet below,ours below\n", output.stream);
    if (!MeasureAll(options, output.stream, message))
    {
        qcOutput_Abort(&output);
        return qc_exitFailed;
    }
    if (!qcOutput_Commit(&output, message))
        return qc_exitFailed;
    return qcInterrupt_ExitStatus();
}
} // namespace

extern "C" qcExitStatus qcBench_RunTerrain(int argumentCount, char** arguments)
{
    Options options;
    qcWord words[qc_terrainKinds + 1] = {};
    for (int kind = 0; kind < qc_terrainKinds; kind++)
        words[kind] = {qcTerrainName(qcTerrainKind(kind)), kind};
    const qcOption table[] = {
        {1, "kinds", "LIST", "Of balls, boxes, capsules, hulls, compounds; all by default",
         qcOption_Marks(options.kinds, qc_terrainKinds, words)},
        {1, "bodies", "N", "How many there are; %s by default", qcOption_Number(&options.bodies, 1, 100000)},
        {1, "steps", "N", "Steps of each row, of a sixtieth of a second; %s by default",
         qcOption_Number(&options.steps, 1, 1000000)},
        {2, "out", "FOLDER", "Where terrain.csv goes; %s by default, made if it is missing",
         qcOption_Folder(&options.out)},
        {}};
    qcCommandLine line = {table, s_help, nullptr, nullptr, 0, nullptr, nullptr};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    qcMessage message;
    qcExitStatus status = Run(options, &message);
    if (status == qc_exitFailed)
        std::fprintf(stderr, "%s: %s\n", arguments[0], message.text);
    return status;
}
