// qc-bench stability: long runs of scenes that come to rest. What a body at rest must not do is measured in every
// step: gain energy, sink into another, penetrate, or take more memory.
#include "bench/stability/report.h"

#include "bench/bench.h"
#include "bench/stability/jitter.h"
#include "common/files.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/progress.h"
#include "common/stopwatch.h"

#include <cstdio>
#ifdef __linux__
#include <sys/prctl.h>
#endif

namespace
{
constexpr uint32_t s_steps = 10000, s_quickSteps = 1500;

struct Options
{
    std::vector<const qcStabilitySceneDef*> scenes;
    uint32_t steps = 0;
    uint32_t jitter = 0; ///< seed; 0: none
    bool quick = false, full = false;
    const char* out = "out/bench";
};

void TakeScene(const struct argp_state* state, const char* text, void* context)
{
    const qcStabilitySceneDef* scene = qcFindStabilityScene(text);
    std::string known;
    for (const qcStabilitySceneDef& each : qcStabilityScenes())
        known += std::string(known.empty() ? "" : ", ") + each.name;
    if (scene == nullptr)
        argp_error(state, "--scene: there is no scene '%s', only: %s", text, known.c_str());
    static_cast<Options*>(context)->scenes.push_back(scene);
}

/// False with a message.
bool RunScene(const Options& options, qcStabilityHistory* history, qcMessage* message)
{
    std::unique_ptr<qcStabilityScene> scene = history->Def().make(options.full);
    if (options.jitter != 0 && history->Def().driven == nullptr)
        qcJitterStart(&scene->World(), history->Def().shift, history->Def().turn, options.jitter);
    qcProgress_Begin(options.steps, history->Def().name);
    bool isOk = true;
    for (uint32_t step = 1; step <= options.steps && isOk && qcInterrupt_Signal() == 0; step++)
    {
        std::string reason;
        double start = qcStopwatch_NowMs();
        isOk = scene->Step(&reason);
        double ms = qcStopwatch_NowMs() - start;
        isOk = isOk && history->Take(*scene, ms, &reason);
        // After each step: it may have added bodies.
        if (isOk)
            qcKeepAwake(&scene->World());
        if (!isOk)
            qcMessage_Fail(message, "%s, step %u: %s", history->Def().name, unsigned(step), reason.c_str());
        qcProgress_Update(step);
    }
    qcProgress_End();
    return isOk;
}

qcExitStatus Run(const Options& options, qcMessage* message)
{
    qcInterrupt_Watch();
    if (!qcFiles_Check(options.out, "stability.csv", message))
        return qc_exitFailed;
    std::vector<qcStabilityHistory> histories;
    qcPrintStabilityHead();
    for (const qcStabilitySceneDef* scene : options.scenes)
    {
        histories.emplace_back(*scene, options.steps);
        if (!RunScene(options, &histories.back(), message))
            return qc_exitFailed;
        if (histories.back().Rows().empty())
            histories.pop_back();
        else
            qcPrintStabilityRow(histories.back());
        if (qcInterrupt_Signal() != 0)
            break;
    }
    qcPrintStabilityEnd(histories);
    if (!qcWriteStabilityCsv(options.out, histories, message) || !qcPlotStability(options.out, histories, message))
        return qc_exitFailed;
    if (qcInterrupt_Signal() != 0)
        return qcInterrupt_ExitStatus();
    for (const qcStabilityHistory& history : histories)
        if (!history.Complaints().empty())
            return qcExitStatus(qcMessage_Fail(message, "%s is not stable", history.Def().name) + qc_exitFailed);
    return qc_exitDone;
}

/// The kernel backs an array with a huge page when it has time to: the process would grow by 2 MiB, whatever it uses.
void UseSmallPages()
{
#ifdef __linux__
    (void)prctl(PR_SET_THP_DISABLE, 1, 0, 0, 0);
#endif
}

/// The scenes, for --help.
std::string Help()
{
    std::string help =
        "Long runs of scenes that come to rest: energy, deepest penetration, pairs of triangles that penetrate, "
        "contacts, memory and time, in a table, a CSV and a picture of each scene. No body may sleep.\n\n";
    // Lines fit 79 columns: argp would break longer ones without indenting.
    for (const qcStabilitySceneDef& scene : qcStabilityScenes())
        help += std::string("  ") + scene.name + std::string(12 - std::string(scene.name).size(), ' ') + scene.title +
                "\n" + std::string(14, ' ') + scene.size + "; --full: " + scene.fullSize + "\n";
    return help + "\vA scene fails if its energy is not finite or grows after it has come to rest by more than lifts "
                  "it a millimetre; if pairs penetrate at the end, or penetrate without being reported; if memory "
                  "grows from the second to the last quarter of the run.\n\n"
                  "Exit status: 0 all scenes are stable; 1 one is not, or output could not be written; 2 a mistake on "
                  "the command line; 130 ended by Ctrl-C.";
}
} // namespace

extern "C" qcExitStatus qcBench_RunStability(int argumentCount, char** arguments)
{
    Options options;
    const qcOption table[] = {
        {1, "scene", "NAME,...", "Which scenes; all by default", qcOption_Texts(TakeScene, &options)},
        {1, "steps", "N", "Steps of each scene; 10000 by default, 1500 with --quick",
         qcOption_Number(&options.steps, 4, 100000000)},
        {1, "jitter", "SEED", "Moves and turns each body a little at the start, at random; none that a crane carries",
         qcOption_Number(&options.jitter, 1, 1000000)},
        {1, "quick", nullptr, "Fewer steps", qcOption_Flag(&options.quick, true)},
        {1, "full", nullptr, "Scenes in the size of the demos, which take hours", qcOption_Flag(&options.full, true)},
        {2, "out", "FOLDER",
         "Where stability.csv, stability.gp and the pictures go; out/bench by default, made if it is missing",
         qcOption_Folder(&options.out)},
        {}};
    std::string help = Help();
    qcCommandLine line = {table, help.c_str(), nullptr, nullptr, 0, nullptr, nullptr};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    if (options.steps == 0)
        options.steps = options.quick ? s_quickSteps : s_steps;
    if (options.scenes.empty())
        for (const qcStabilitySceneDef& scene : qcStabilityScenes())
            options.scenes.push_back(&scene);
    qcMessage message;
    UseSmallPages();
    qcExitStatus status = Run(options, &message);
    if (status == qc_exitFailed)
        std::fprintf(stderr, "%s: %s\n", arguments[0], message.text);
    return status;
}
