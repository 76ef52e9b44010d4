// qc-cloth, the main demo: the paper's cloth scene in Bullet with this library's broadphase and self-collision, and
// again without self-collision; pictures, a CSV, a table.
#include "cloth/picture.h"
#include "cloth/report.h"
#include "cloth/world.h"
#include "common/bullet/demo_options.h"
#include "common/bullet/query_comparison.h"

#include "common/interrupt.h"
#include "common/progress.h"

#include <cstdio>
#include <cstring>

namespace
{
struct Options
{
    // 120 steps a second: 12 frames.
    qcDemoOptions common = {"out/cloth", 360, 10, qc_methodLayers, qc_deviceAuto, 0};
    uint32_t triangles = 20000;
    uint32_t compareEvery = 4; ///< frames from one on which all methods run to the next
    const char* record = nullptr;
    qcDetectDef request = qcDefaultDetectDef();
};

const char s_help[] =
    "A cloth falls over a round table and folds on itself: twice, with and without self-collision.\v"
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

    /// Simulates once. False with a message on standard error.
    bool Simulate(bool selfCollision, qcClothRun* run, size_t* triangles);

  private:
    bool MeasureStep(qcClothWorld& world, size_t step, qcClothRun* run);
    bool Begin(qcClothWorld& world, bool selfCollision);
    bool Draw(qcClothWorld& world, qcComparedQuery query, const char* prefix, size_t frame);

    const Options& m_options;
    qcDevice* m_device;
    qcDeviceInfo m_info;
    qcQueryComparison m_comparison;
    qcBodyId m_cloth{};
    qcClothPicture m_picture;
};

/// A file for each run: "cloth.qcr", "cloth_without.qcr".
std::string RecordingPath(const std::string& path, bool selfCollision)
{
    if (selfCollision)
        return path;
    size_t dot = path.find_last_of("./");
    bool hasEnding = dot != std::string::npos && path[dot] == '.';
    return hasEnding ? path.substr(0, dot) + "_without" + path.substr(dot) : path + "_without";
}

/// Starts comparing a new cloth.
bool Demo::Begin(qcClothWorld& world, bool selfCollision)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = world.Positions().data();
    def.vertexCount = uint32_t(world.Positions().size() / 3);
    def.indices = world.Indices().data();
    def.triangleCount = uint32_t(world.Indices().size() / 3);
    def.deforming = true;
    m_comparison.Clear();
    bool begun = m_comparison.Add(def, &m_cloth) && m_comparison.Warm();
    if (begun && m_options.record != nullptr)
        begun = m_comparison.Record(RecordingPath(m_options.record, selfCollision));
    return begun || qcDemo_Fail(m_comparison.Message());
}

/// The cloth, and the PCS of a query.
bool Demo::Draw(qcClothWorld& world, qcComparedQuery query, const char* prefix, size_t frame)
{
    char name[64];
    std::snprintf(name, sizeof name, "/%s_%04zu.png", prefix, frame);
    std::string message;
    return m_picture.Write(m_device, world.Positions(), world.Indices(), m_comparison.Marked(query, m_cloth),
                           std::string(m_options.common.out) + name, &message) ||
           qcDemo_Fail(message);
}

/// Measures the frame of a step: runs the other methods and draws.
bool Demo::MeasureStep(qcClothWorld& world, size_t step, qcClothRun* run)
{
    qcClothStep& measured = run->steps.back();
    if (!m_comparison.SetVertices(m_cloth, world.Positions()) || !m_comparison.RunEachStep(&measured.results))
        return qcDemo_Fail(m_comparison.Message());
    bool isLast = step == m_options.common.steps;
    if (m_info.kind == qc_deviceNone || (step % m_options.common.frameEvery != 0 && !isLast))
        return true;
    size_t frame = (step - 1) / m_options.common.frameEvery;
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

bool Demo::Simulate(bool selfCollision, qcClothRun* run, size_t* triangles)
{
    run->selfCollision = selfCollision;
    qcClothWorld world(m_options.triangles, selfCollision, m_device, m_options.common.method, m_options.common.threads);
    *triangles = world.Indices().size() / 3;
    if (!Begin(world, selfCollision))
        return false;
    qcProgress_Begin(m_options.common.steps,
                     selfCollision ? "cloth with self-collision" : "cloth without self-collision");
    for (size_t step = 1; step <= m_options.common.steps && qcInterrupt_Signal() == 0; step++)
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
        if (!MeasureStep(world, step, run))
            return false;
        qcProgress_Update(step);
    }
    qcProgress_End();
    return true;
}

int Run(const Options& options, qcDevice* device)
{
    qcDeviceInfo info;
    qcDevice_GetInfo(device, &info);
    Demo demo(options, device, info);
    qcClothRun with, without;
    size_t triangles = 0;
    if (!demo.Simulate(true, &with, &triangles) || !demo.Simulate(false, &without, &triangles))
        return qc_exitFailed;
    std::string message;
    if (!qcWriteClothCsv(std::string(options.common.out) + "/cloth.csv", with, without, qcClothWorld::stepSeconds,
                         &message))
    {
        qcDemo_Fail(message);
        return qc_exitFailed;
    }
    qcPrintClothTable(with, without, triangles, options.common.method, options.request, info);
    return qcInterrupt_Signal() == 0 ? qc_exitDone : qc_exitSignal + qcInterrupt_Signal();
}
} // namespace

int main(int argumentCount, char** arguments)
{
    Options options;
    std::memcpy(options.request.views, "xz", 3);
    options.request.iterations = 2;
    const std::vector<qcOption> rows = {
        {1, "triangles", "N", "Triangles of the cloth, at least; %s by default",
         qcOption_Number(&options.triangles, 2, 2000000)},
        {1, "compare-every", "N", "Frames from one on which all methods are compared to the next; %s by default",
         qcOption_Number(&options.compareEvery, 1, 1000000)},
        {1, "record", "FILE",
         "Record each step's cloth for \"qc-bench paper\" in FILE; without self-collision in FILE_without",
         qcOption_Text(&options.record)},
        {2, nullptr, nullptr, "For quick and cullide:", {}},
        {2, "views", "LETTERS", "Axes to look along; xz by default, as in the paper",
         qcOption_Views(&options.request.views)},
        {2, "resolution", "N", "Pixels on a side, 1..4096; 4096 by default",
         qcOption_Number(&options.request.resolution, 1, 4096)},
        {2, "iterations", "N", "Rounds over the views; %s by default, 0: until nothing changes",
         qcOption_Number(&options.request.iterations, 0, UINT32_MAX)}};
    qcDevice* device = nullptr;
    int status = qcDemo_Begin(rows, s_help, argumentCount, arguments, &options.common, &device);
    if (status != qc_exitDone)
        return status;
    options.request.threads = options.common.threads;
    status = Run(options, device);
    qcDevice_Destroy(device);
    return status;
}
