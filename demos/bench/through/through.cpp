// qc-bench through: scenes in which bodies are thrown at each other so fast that they could pass through each other,
// judged by exact tests within each step, beside version 0.2.0.
#include "bench/through/film.h"
#include "bench/through/measure.h"
#include "bench/through/motion_query.h"
#include "bench/through/report.h"

#include "bench/bench.h"
#include "common/interrupt.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/progress.h"

#include <cstdio>
#include <cstring>
#include <string>

namespace
{
constexpr uint32_t s_runs = 10, s_quickRuns = 1;
constexpr uint32_t s_triangles = 1000000, s_quickTriangles = 20000; ///< of the motion query
constexpr int s_pictures = 4, s_quickPictures = 1;                  ///< of the film, a step
const char s_motionQuery[] = "motion-query", s_film[] = "film";

enum Worlds
{
    s_classic,
    s_deformable,
    s_implicit,
    s_both
};

const qcWord s_hzWords[] = {{"60", 60}, {"240", 240}, {"all", 0}, {nullptr, 0}};
const qcWord s_worldWords[] = {
    {"classic", s_classic}, {"deformable", s_deformable}, {"implicit", s_implicit}, {"both", s_both}, {nullptr, 0}};

struct Options
{
    std::vector<const qcThroughScene*> scenes;
    bool motionQuery = false, film = false; ///< named as scenes
    int worlds = s_both;
    int hz = 0;
    uint32_t runs = 0;
    uint32_t firstRun = 0, threads = 0;
    bool quick = false, discrete = false, brute = false, steps = false;
    const char *csv = nullptr, *frames = nullptr, *record = nullptr;
};

void TakeScene(const struct argp_state* state, const char* text, void* context)
{
    auto* options = static_cast<Options*>(context);
    const qcThroughScene* scene = qcFindThroughScene(text);
    if (scene != nullptr)
        options->scenes.push_back(scene);
    else if (std::strcmp(text, s_motionQuery) == 0)
        options->motionQuery = true;
    else if (std::strcmp(text, s_film) == 0)
        options->film = true;
    else
    {
        std::string known;
        for (const qcThroughScene& each : qcThroughScenes())
            known += std::string(each.name) + ", ";
        argp_error(state, "--scene: there is no scene '%s', only: %s%s, %s", text, known.c_str(), s_motionQuery,
                   s_film);
    }
}

void TakeWorld(const struct argp_state* state, const char* text, void* context)
{
    *static_cast<int*>(context) = qcOption_ReadWord(state, "--world", text, s_worldWords);
}

void TakeHz(const struct argp_state* state, const char* text, void* context)
{
    *static_cast<int*>(context) = qcOption_ReadWord(state, "--hz", text, s_hzWords);
}

void CheckTogether(const struct argp_state* state, void* context)
{
    const auto* options = static_cast<const Options*>(context);
    if (options->film && options->frames == nullptr && options->record == nullptr)
        argp_error(state, "--scene: film needs --frames FOLDER, where it is drawn");
}

/// True if the options select this row.
bool IsSelected(const Options& options, const qcThroughScene& scene, qcThroughKind kind, int hz)
{
    static const int worlds[] = {s_classic, s_deformable, s_implicit};
    if ((hz == 240 && !scene.isFast) || (options.hz != 0 && options.hz != hz))
        return false;
    if (kind == qc_throughRigid || !scene.isSoft)
        return (kind == qc_throughRigid) != scene.isSoft;
    return options.worlds == worlds[kind] || (options.worlds == s_both && kind != qc_throughImplicit);
}

std::vector<qcThroughDef> DefsOf(const Options& options)
{
    std::vector<qcThroughDef> defs;
    for (const qcThroughScene* scene : options.scenes)
        for (int hz : {60, 240})
            for (qcThroughKind kind : {qc_throughClassic, qc_throughDeformable, qc_throughImplicit, qc_throughRigid})
                if (IsSelected(options, *scene, kind, hz))
                    defs.push_back({scene, kind, hz, int(options.runs), int(options.firstRun), !options.discrete,
                                    options.brute, options.steps, options.threads});
    return defs;
}

bool MeasureAll(const Options& options, std::vector<qcThroughRow>* rows, qcMessage* message)
{
    qcPrintThroughHead();
    for (const qcThroughDef& def : DefsOf(options))
    {
        qcProgress_Begin(0, def.scene->name);
        qcThroughRow row;
        bool measured = qcMeasureThrough(def, &row);
        qcProgress_End();
        if (!measured)
            return qcMessage_Fail(message, "%s: %s", def.scene->name, qcLastMessage());
        if (row.runs == 0 || qcInterrupt_Signal() != 0)
            break;
        qcPrintThroughRow(row);
        rows->push_back(row);
    }
    qcPrintThroughEnd(*rows);
    return true;
}

qcExitStatus Run(const Options& options, qcMessage* message)
{
    qcInterrupt_Watch();
    if (options.csv != nullptr && !qcOutput_Check(options.csv, message))
        return qc_exitFailed;
    std::vector<qcThroughRow> rows;
    if (!options.scenes.empty() && !MeasureAll(options, &rows, message))
        return qc_exitFailed;
    uint32_t triangles = options.quick ? s_quickTriangles : s_triangles;
    if (options.motionQuery && qcInterrupt_Signal() == 0 && !qcMeasureMotionQuery(triangles, message))
        return qc_exitFailed;
    if (options.record != nullptr && !qcRecordThroughFilm(options.record, message))
        return qc_exitFailed;
    if (options.csv != nullptr && !qcWriteThroughCsv(options.csv, rows, message))
        return qc_exitFailed;
    if (options.frames != nullptr && qcInterrupt_Signal() == 0)
    {
        size_t pictures = 0;
        qcExitStatus drawn =
            qcDrawThroughFilm(options.frames, options.quick ? s_quickPictures : s_pictures, &pictures, message);
        if (drawn != qc_exitDone)
            return drawn;
        std::printf("%zu pictures: %s\n", pictures, options.frames);
    }
    return qcInterrupt_ExitStatus();
}

const char s_help[] =
    "Bodies that are thrown, dropped, wrung and crushed, so fast that they could pass through each other in a step. In "
    "each step the pairs of triangles without a common vertex that penetrate are counted, by exact tests, at its end "
    "and at 16 times inside it, on straight lines between the stored positions; pairs that penetrate at its start are "
    "counted apart (tangled). \"Uncertified\" are pairs disjoint at the start that the library's motion query, run on "
    "these positions by the "
    "benchmark, does not prove apart. Each run starts with other small displacements. Bullet's own shapes are judged "
    "by triangles inside of them, at 9/10 of their size.\v"
    "Exit status: as for qc-bench.";
} // namespace

extern "C" qcExitStatus qcBench_RunThrough(int argumentCount, char** arguments)
{
    Options options;
    const qcOption table[] = {
        {1, "scene", "NAME,...",
         "Which scenes; motion-query: the time of the library's query; film: only the film, with --frames; all by "
         "default",
         qcOption_Texts(TakeScene, &options)},
        {1, "world", "WORLD",
         "classic (qcSoftBodySolver), deformable (qcDeformableWorld), both, the default, or implicit: deformable with "
         "stiff springs, where Bullet's implicit integration throws nodes about",
         qcOption_Texts(TakeWorld, &options.worlds)},
        {1, "hz", "N", "Only rows with this many steps a second: 60, 240, or all, the default",
         qcOption_Texts(TakeHz, &options.hz)},
        {1, "runs", "N", "Runs of each scene; 10 by default, 1 with --quick", qcOption_Number(&options.runs, 1, 1000)},
        {1, "first-run", "N", "Number of the first run, to repeat a later one; %s by default",
         qcOption_Number(&options.firstRun, 0, 1000000)},
        {1, "threads", "N", "Threads of the library's queries; 0, the default: one per core",
         qcOption_Number(&options.threads, 0, 1024)},
        {1, "discrete", nullptr, "Soft bodies without qcSoftBodySettings::continuous",
         qcOption_Flag(&options.discrete, true)},
        {1, "quick", nullptr, "One run of each scene, and the motion query on 20 K triangles only",
         qcOption_Flag(&options.quick, true)},
        {1, "brute", nullptr, "Count by testing every pair of triangles, which takes long",
         qcOption_Flag(&options.brute, true)},
        {1, "steps", nullptr, "Print each step on standard error", qcOption_Flag(&options.steps, true)},
        {2, "csv", "FILE", "Write the rows to this file", qcOption_Text(&options.csv)},
        {2, "frames", "FOLDER",
         "Draw the film into this folder, made if it is missing: a cloth thrown at 20 m/s at 60 Hz, by 0.2.0 (left) "
         "and "
         "by this version",
         qcOption_Folder(&options.frames)},
        {2, "record", "FILE", "Write the film's positions to this file, for before_film.txt",
         qcOption_Text(&options.record)},
        {}};
    qcCommandLine line = {table, s_help, nullptr, nullptr, 0, CheckTogether, &options};
    qcCommandLine_Parse(&line, argumentCount, arguments);
    if (options.runs == 0)
        options.runs = options.quick ? s_quickRuns : s_runs;
    bool all = options.scenes.empty() && !options.motionQuery && !options.film;
    options.motionQuery = options.motionQuery || all;
    if (all)
        for (const qcThroughScene& scene : qcThroughScenes())
            options.scenes.push_back(&scene);
    qcMessage message;
    qcExitStatus status = Run(options, &message);
    if (status == qc_exitFailed || status == qc_exitDevice)
        std::fprintf(stderr, "%s: %s\n", arguments[0], message.text);
    return status;
}
