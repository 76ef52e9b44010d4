// qc-bench piles: meshes that fall on each other and come to rest, by this library's shape and by two of Bullet's own.
#include "bench/piles/report.h"

#include "bench/bench.h"
#include "common/files.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/progress.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace
{
struct Contestant
{
    const char* name;
    qcPilesContestant contestant;
};

const Contestant s_contestants[] = {
    {"mesh", qcPilesContestant::ours}, {"gimpact", qcPilesContestant::gimpact}, {"hull", qcPilesContestant::hull}};

struct Options
{
    std::vector<const qcPilesSceneDef*> scenes;
    std::vector<qcPilesContestant> contestants;
    uint32_t steps = 0, threads = 1, seed = 7, starts = 1;
    const char* out = "out/bench";
};

void TakeScene(const struct argp_state* state, const char* text, void* context)
{
    const qcPilesSceneDef* scene = qcFindPilesScene(text);
    std::string known;
    for (const qcPilesSceneDef& each : qcPilesScenes())
        known += std::string(known.empty() ? "" : ", ") + each.name;
    if (scene == nullptr)
        argp_error(state, "--scene: there is no scene '%s', only: %s", text, known.c_str());
    static_cast<Options*>(context)->scenes.push_back(scene);
}

void TakeContestant(const struct argp_state* state, const char* text, void* context)
{
    for (const Contestant& each : s_contestants)
        if (std::strcmp(each.name, text) == 0)
        {
            static_cast<Options*>(context)->contestants.push_back(each.contestant);
            return;
        }
    argp_error(state, "--shape: there is no shape '%s', only: mesh, gimpact, hull", text);
}

/// Runs the contestants step by step in turn, so that all have the same machine. False with a message.
bool RunStart(const Options& options, const qcPilesSceneDef& def, uint32_t seed, std::vector<qcPilesFigures>* figures,
              qcMessage* message)
{
    qcPilesSetup setup;
    def.make(seed, &setup);
    std::vector<std::unique_ptr<qcPilesRun>> runs;
    uint32_t steps = options.steps != 0 ? options.steps : def.steps;
    for (qcPilesContestant contestant : options.contestants)
        if ((def.hulls || contestant != qcPilesContestant::hull) &&
            (def.gimpact || contestant != qcPilesContestant::gimpact))
            runs.emplace_back(new qcPilesRun(def, setup, contestant, steps, options.threads));
    steps += qcPilesRun::asleepSteps;
    qcProgress_Begin(steps, def.name);
    bool isOk = true;
    for (uint32_t step = 0; step < steps && isOk && qcInterrupt_Signal() == 0; step++)
    {
        for (size_t i = 0; i < runs.size() && isOk; i++)
        {
            std::string reason;
            qcPilesRun& run = *runs[(i + step) % runs.size()];
            isOk = run.Step(&reason);
            if (!isOk)
                qcMessage_Fail(message, "%s, %s, step %u: %s", def.name, qcPilesName(run.Figures().contestant),
                               unsigned(step + 1), reason.c_str());
        }
        qcProgress_Update(step + 1);
    }
    qcProgress_End();
    for (const auto& run : runs)
        figures->push_back(run->Figures());
    return isOk;
}

/// Runs all starts of a scene. False with a message.
bool RunScene(const Options& options, const qcPilesSceneDef& def, std::vector<qcPilesFigures>* figures,
              qcMessage* message)
{
    for (uint32_t start = 0; start < options.starts && qcInterrupt_Signal() == 0; start++)
    {
        std::vector<qcPilesFigures> found;
        if (!RunStart(options, def, options.seed + start, &found, message))
            return false;
        if (start == 0)
            *figures = found;
        else
            for (size_t i = 0; i < found.size(); i++)
                (*figures)[i].Add(found[i]);
    }
    return true;
}

qcExitStatus Run(const Options& options, qcMessage* message)
{
    qcInterrupt_Watch();
    if (!qcFiles_Check(options.out, "piles.csv", message))
        return qc_exitFailed;
    std::vector<qcPilesFigures> rows;
    qcPrintPilesHead(options.threads);
    for (const qcPilesSceneDef* scene : options.scenes)
    {
        std::vector<qcPilesFigures> figures;
        if (!RunScene(options, *scene, &figures, message))
            return qc_exitFailed;
        // A scene that was cut short has no means to compare.
        if (qcInterrupt_Signal() != 0)
            break;
        qcPrintPiles(figures);
        rows.insert(rows.end(), figures.begin(), figures.end());
    }
    qcPrintPilesEnd();
    if (!qcWritePilesCsv(options.out, options.threads, rows, message))
        return qc_exitFailed;
    return qcInterrupt_ExitStatus();
}

/// The scenes, for --help.
std::string Help()
{
    std::string help = "Meshes that fall on each other and come to rest, as qcMeshShape, btGImpactMeshShape and "
                       "btConvexHullShape, step by step in turn: time, contact points, exact depth, rest.\n\n";
    for (const qcPilesSceneDef& scene : qcPilesScenes())
        help +=
            std::string("  ") + scene.name + std::string(12 - std::string(scene.name).size(), ' ') + scene.title + "\n";
    return help + "\vExit status: 0 done; 1 a query failed, or output could not be written; 2 a mistake on the command "
                  "line; 130 ended by Ctrl-C.";
}
} // namespace

extern "C" qcExitStatus qcBench_RunPiles(int argumentCount, char** arguments)
{
    Options options;
    const qcOption table[] = {
        {1, "scene", "NAME,...", "Which scenes; all by default", qcOption_Texts(TakeScene, &options)},
        {1, "shape", "NAME,...", "Which shapes: mesh, gimpact, hull; all by default",
         qcOption_Texts(TakeContestant, &options)},
        {1, "steps", "N", "Steps of each scene, a third each falling, settling and at rest; 900 by default",
         qcOption_Number(&options.steps, 4, 1000000)},
        {1, "seed", "N", "Other starts, each a little different; %s by default",
         qcOption_Number(&options.seed, 1, 1000000)},
        {1, "starts", "N", "How many starts, from that seed on; %s by default",
         qcOption_Number(&options.starts, 1, 10000)},
        {1, "threads", "N", "Threads of qcMeshContact, 0: one per core; %s by default",
         qcOption_Number(&options.threads, 0, 1024)},
        {2, "out", "FOLDER", "Where piles.csv goes; %s by default, made if it is missing",
         qcOption_Folder(&options.out)},
        {}};
    std::string help = Help();
    qcCommandLine line = {table, help.c_str(), nullptr, nullptr, 0, nullptr, nullptr};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    if (options.scenes.empty())
        for (const qcPilesSceneDef& scene : qcPilesScenes())
            options.scenes.push_back(&scene);
    if (options.contestants.empty())
        for (const Contestant& each : s_contestants)
            options.contestants.push_back(each.contestant);
    qcMessage message;
    qcExitStatus status = Run(options, &message);
    if (status == qc_exitFailed)
        std::fprintf(stderr, "%s: %s\n", arguments[0], message.text);
    return status;
}
