// qc-cloth, the main demo: the paper's cloth scene in Bullet with this library's broadphase and self-collision; a
// second act, in which the cloth is pulled off the table; the first again without self-collision; pictures, a CSV, a
// table.
#include "cloth/picture.h"
#include "cloth/report.h"
#include "cloth/viewed.h"
#include "cloth/world.h"
#include "common/bullet/demo_options.h"
#include "common/bullet/query_comparison.h"
#include "view/view.h"

#include "common/interrupt.h"
#include "common/progress.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace
{
struct Options
{
    // 120 steps a second: 12 frames.
    qcDemoOptions common = {"out/cloth", 360, 10, qc_methodLayers, qc_deviceAuto, 0};
    uint32_t triangles = 20000;
    uint32_t pullSteps = 240;
    uint32_t compareEvery = 12; ///< frames from one on which all methods run to the next
    const char* record = nullptr;
    qcDetectDef request = qcDefaultDetectDef();
    qcViewOptions view;
};

const char s_help[] =
    "A cloth falls over a round table and folds on itself; then it is pulled off the table. The first act again "
    "without self-collision.\v"
    "Ctrl-C ends it with a table of what was done.\n\n"
    "Exit status: 0 done; 1 output could not be written, a query failed, or a method that never misses missed; 2 a "
    "mistake on the command line; 4 the device does not work here; 130 ended by Ctrl-C.";

class Demo
{
  public:
    Demo(const Options& options, qcDevice* device, const qcDeviceInfo& info)
        : m_options(options), m_device(device), m_info(info), m_comparison(device, options.request)
    {
    }

    /// Simulates once; `pulled`, if not null, is the second act. False with a message on standard error.
    bool Simulate(qcClothRun* run, qcClothRun* pulled);

  private:
    bool RunAct(qcClothWorld& world, size_t steps, const char* label, qcClothRun* run);
    bool MeasureStep(qcClothWorld& world, size_t step, bool isLast, qcClothRun* run);
    bool Begin(qcClothWorld& world, const std::string& recording);
    bool Draw(qcClothWorld& world, qcComparedQuery query, const char* prefix, size_t frame);

    const Options& m_options;
    qcDevice* m_device;
    qcDeviceInfo m_info;
    qcQueryComparison m_comparison;
    qcBodyId m_cloth{};
    qcClothPicture m_picture;
    size_t m_frames = 0; ///< of this simulation
};

/// A file for each run: "cloth.qcr", "cloth_without.qcr".
std::string RecordingPath(const char* given, bool selfCollision)
{
    std::string path = given == nullptr ? "" : given;
    if (selfCollision || path.empty())
        return path;
    size_t dot = path.find_last_of("./");
    bool hasEnding = dot != std::string::npos && path[dot] == '.';
    return hasEnding ? path.substr(0, dot) + "_without" + path.substr(dot) : path + "_without";
}

/// Starts comparing a new cloth. `recording`: path, or empty.
bool Demo::Begin(qcClothWorld& world, const std::string& recording)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = world.Positions().data();
    def.vertexCount = uint32_t(world.Positions().size() / 3);
    def.indices = world.Indices().data();
    def.triangleCount = uint32_t(world.Indices().size() / 3);
    def.deforming = true;
    m_comparison.Clear();
    bool begun = m_comparison.Add(def, &m_cloth) && m_comparison.Warm();
    if (begun && !recording.empty())
        begun = m_comparison.Record(recording);
    return begun || qcDemo_Fail(m_comparison.Message());
}

/// The cloth, and the PCS of a query.
bool Demo::Draw(qcClothWorld& world, qcComparedQuery query, const char* prefix, size_t frame)
{
    char name[64];
    std::snprintf(name, sizeof name, "/%s_%04zu.png", prefix, frame);
    std::string message;
    btVector3 grip = world.Grip();
    m_picture.SetGrip(world.IsHeld() ? &grip : nullptr);
    return m_picture.Write(m_device, world.Positions(), world.Indices(), m_comparison.Marked(query, m_cloth),
                           std::string(m_options.common.out) + name, &message) ||
           qcDemo_Fail(message);
}

/// Measures the frame of a step: runs the other methods and draws.
bool Demo::MeasureStep(qcClothWorld& world, size_t step, bool isLast, qcClothRun* run)
{
    qcClothStep& measured = run->steps.back();
    if (!m_comparison.SetVertices(m_cloth, world.Positions()) || !m_comparison.RunEachStep(&measured.results))
        return qcDemo_Fail(m_comparison.Message());
    if (m_info.kind == qc_deviceNone || (step % m_options.common.frameEvery != 0 && !isLast))
        return true;
    size_t frame = m_frames++;
    measured.compared = frame % m_options.compareEvery == m_options.compareEvery - 1 || isLast;
    // Without self-collision only frames for the table and the last picture are used.
    if (!run->selfCollision && !measured.compared)
        return true;
    if (!(measured.compared ? m_comparison.RunSampled(&measured.results) && m_comparison.CountMissed(&measured.results)
                            : m_comparison.Run(qc_queryQuick, &measured.results[qc_queryQuick])))
        return qcDemo_Fail("step " + std::to_string(step) + ": " + m_comparison.Message());
    if (run->selfCollision && !Draw(world, qc_queryQuick, "frame", frame))
        return false;
    return !measured.compared ||
           Draw(world, qc_queryCullide, run->selfCollision ? "with_cullide" : "without_cullide", frame);
}

bool Demo::RunAct(qcClothWorld& world, size_t steps, const char* label, qcClothRun* run)
{
    qcProgress_Begin(steps, label);
    for (size_t step = 1; step <= steps && qcInterrupt_Signal() == 0; step++)
    {
        qcClothStep measured;
        measured.costs = world.Step();
        measured.statistics = world.Statistics();
        measured.manifolds = world.ManifoldCount();
        if (measured.statistics.fallback != nullptr)
            run->fallback = measured.statistics.fallback;
        // The solver owns the text, which is invalid after the solver's end.
        measured.statistics.fallback = nullptr;
        run->steps.push_back(measured);
        if (measured.statistics.status != qc_statusOk)
            return qcDemo_Fail(std::string("step ") + std::to_string(step) + ": " + qcLastMessage());
        if (run->isPulled)
            m_picture.Follow(std::min(float(step) * float(qcClothWorld::stepSeconds) / 1.2f, 1.0f));
        if (!MeasureStep(world, step, step == steps, run))
            return false;
        qcProgress_Update(step);
    }
    qcProgress_End();
    return true;
}

bool Demo::Simulate(qcClothRun* run, qcClothRun* pulled)
{
    qcClothWorld world(m_options.triangles, run->selfCollision, m_device, m_options.common.method,
                       m_options.common.threads);
    run->triangles = world.Indices().size() / 3;
    m_frames = 0;
    m_picture.Follow(0);
    if (!Begin(world, RecordingPath(m_options.record, run->selfCollision)) ||
        !RunAct(world, m_options.common.steps,
                run->selfCollision ? "cloth with self-collision" : "cloth without self-collision", run))
        return false;
    if (pulled == nullptr || m_options.pullSteps == 0 || qcInterrupt_Signal() != 0)
        return true;
    world.PullAway();
    // A recording holds the paper's scene: the first act.
    return Begin(world, "") && RunAct(world, m_options.pullSteps, "cloth pulled away", pulled);
}

int Run(const Options& options, qcDevice* device)
{
    qcDeviceInfo info;
    qcDevice_GetInfo(device, &info);
    Demo demo(options, device, info);
    qcClothRun with, pulled, without;
    with.selfCollision = pulled.selfCollision = pulled.isPulled = true;
    if (!demo.Simulate(&with, &pulled) || !demo.Simulate(&without, nullptr))
        return qc_exitFailed;
    std::vector<const qcClothRun*> runs = {&with};
    // An act that Ctrl-C left out has no rows.
    for (const qcClothRun* run : {&without, &pulled})
        if (!run->steps.empty())
            runs.push_back(run);
    std::string message;
    if (!qcWriteClothCsv(std::string(options.common.out) + "/cloth.csv", runs, qcClothWorld::stepSeconds, &message))
    {
        qcDemo_Fail(message);
        return qc_exitFailed;
    }
    qcPrintClothTable(runs, options.common.method, options.request, info);
    return qcInterrupt_ExitStatus();
}

int View(const Options& options, qcDevice* device)
{
    qcViewedCloth cloth(options.triangles, device, options.common.method, options.common.threads);
    return qcView_Run(&cloth, options.view, device);
}
} // namespace

int main(int argumentCount, char** arguments)
{
    Options options;
    std::memcpy(options.request.views, "xz", 3);
    options.request.iterations = 2;
    std::vector<qcOption> rows = {
        {1, "triangles", "N", "Triangles of the cloth, at least; %s by default",
         qcOption_Number(&options.triangles, 2, 2000000)},
        {1, "pull-steps", "N", "Steps of the second act; %s by default, 0 leaves it out",
         qcOption_Number(&options.pullSteps, 0, 1000000)},
        {1, "compare-every", "N", "Frames from one on which all methods are compared to the next; %s by default",
         qcOption_Number(&options.compareEvery, 1, 1000000)},
        {1, "record", "FILE",
         "Record each step's cloth for \"qc-bench paper\"; for cloth.qcr, without self-collision in cloth_without.qcr",
         qcOption_Text(&options.record)}};
    qcDemo_AddSampledOptions(&rows, "Axes to look along; xz by default, as in the paper", &options.request);
    qcView_AddOptions(&rows, &options.view);
    qcDevice* device = nullptr;
    int status = qcDemo_Begin(rows, s_help, argumentCount, arguments, &options.common, &device);
    if (status != qc_exitDone)
        return status;
    options.request.threads = options.common.threads;
    status = options.view.Opens() ? View(options, device) : Run(options, device);
    qcDevice_Destroy(device);
    return status;
}
