// qc-bench fracture: a mesh falls on a floor and breaks; its pieces collide as meshes, and beside that as convex hulls.
#include "bench/fracture/report.h"

#include "bench/bench.h"
#include "common/files.h"
#include "common/interrupt.h"
#include "common/mesh_io/bunny_path.h"
#include "common/options.h"

#include <cstdio>

namespace
{
constexpr uint32_t s_steps = 1200, s_quickSteps = 120;
constexpr btScalar s_extent = 4; // longest edge of the body's box, m

struct Options
{
    const char* mesh = QC_BUNNY_PATH;
    uint32_t triangles = 5000, pieces = 200, firstSeed = 1, seeds = 5, steps = 0, threads = 1;
    bool quick = false, precut = false;
    const char* out = "out/bench";
};

/// Runs the library's loops on the calling thread.
void RunSerial(uint32_t count, qcTask* task, void* taskContext, void*)
{
    for (uint32_t i = 0; i < count; i++)
        task(i, taskContext);
}

bool MeasureAll(const Options& options, const qcFractureModel& model, std::vector<qcFractureRow>* rows,
                qcMessage* message)
{
    qcPrintFractureHead();
    for (uint32_t i = 0; i < options.seeds; i++)
        for (bool hulls : {false, true})
        {
            qcFractureRequest request;
            request.pieces = options.pieces;
            request.seed = options.firstSeed + i;
            request.method = qc_methodSweep;
            request.threads = options.threads;
            request.precut = options.precut;
            request.hulls = hulls;
            qcFractureRow row;
            std::string reason;
            if (!qcMeasureFracture(model, request, options.steps, &row, &reason))
                return qcMessage_Fail(message, "seed %u: %s", request.seed, reason.c_str());
            if (qcInterrupt_Signal() != 0 && row.steps == 0)
                return true;
            qcPrintFractureRow(row);
            std::fflush(stdout);
            rows->push_back(row);
        }
    return true;
}

qcExitStatus Run(const Options& options, qcMessage* message)
{
    qcInterrupt_Watch();
    if (!qcFiles_Check(options.out, "fracture.csv", message))
        return qc_exitFailed;
    qcFractureModel model;
    std::string reason;
    if (!qcReadFractureModel(options.mesh, options.triangles, s_extent, &model, &reason))
    {
        qcMessage_Fail(message, "%s", reason.c_str());
        return qc_exitBadInput;
    }
    std::vector<qcFractureRow> rows;
    if (!MeasureAll(options, model, &rows, message))
        return qc_exitFailed;
    qcPrintFractureEnd();
    if (!qcWriteFractureRows(options.out, rows, message))
        return qc_exitFailed;
    return qcInterrupt_ExitStatus();
}

const char s_help[] =
    "A bunny of 4 m falls on a floor and breaks in the midst of a step. Its pieces collide as meshes, and in a second "
    "run as convex hulls, by Bullet alone: time of the step in which it breaks and of the steps after it, depth by "
    "exact tests, and rest."
    "\v1200 steps of 1/240 s after the break by default, 120 with --quick; qcStackingSolver, 30 iterations.\n\n"
    "Exit status: 0 done; 1 the mesh could not be broken, output could not be written, or a query failed; 2 a mistake "
    "on the command line; 3 the mesh can't be read; 130 ended by Ctrl-C.";
} // namespace

extern "C" qcExitStatus qcBench_RunFracture(int argumentCount, char** arguments)
{
    Options options;
    const qcOption table[] = {
        {1, "mesh", "FILE", "What breaks: a closed mesh, PLY or OBJ; the bunny of the package glmark2-data by default",
         qcOption_Text(&options.mesh)},
        {1, "triangles", "N", "The mesh is made coarser until it has about as many; %s by default",
         qcOption_Number(&options.triangles, 100, 10000000)},
        {1, "pieces", "N", "Voronoi cells, each with a piece or more; %s by default",
         qcOption_Number(&options.pieces, 1, 10000)},
        {1, "first-seed", "N", "The first of the seeds; %s by default",
         qcOption_Number(&options.firstSeed, 0, 1000000)},
        {1, "seeds", "N", "Runs with one seed each; %s by default", qcOption_Number(&options.seeds, 1, 1000)},
        {1, "steps", "N", "Steps after the break", qcOption_Number(&options.steps, 1, 10000000)},
        {1, "quick", nullptr, "Fewer steps", qcOption_Flag(&options.quick, true)},
        {1, "precut", nullptr, "The pieces are cut before the fall", qcOption_Flag(&options.precut, true)},
        {1, "threads", "N", "%s by default; 0: one per core", qcOption_Number(&options.threads, 0, 256)},
        {2, "out", "FOLDER", "Where fracture.csv goes; out/bench by default, made if it is missing",
         qcOption_Folder(&options.out)},
        {}};
    qcCommandLine line = {table, s_help, nullptr, nullptr, 0, nullptr, nullptr};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    if (options.steps == 0)
        options.steps = options.quick ? s_quickSteps : s_steps;
    // Cutting has no number of threads of its own.
    if (options.threads == 1)
        qcSetParallelFor(RunSerial, 1, nullptr);
    qcMessage message;
    qcExitStatus status = Run(options, &message);
    qcSetParallelFor(nullptr, 0, nullptr);
    if (status == qc_exitFailed || status == qc_exitBadInput)
        std::fprintf(stderr, "%s: %s\n", arguments[0], message.text);
    return status;
}
