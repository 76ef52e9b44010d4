// qc-leaves: the paper's third scene in Bullet: deforming leaves fall from a tree and collide with each other, its
// branches and the ground; pictures, a CSV, a table.
#include "common/bullet/demo_options.h"
#include "common/bullet/query_comparison.h"
#include "leaves/picture.h"
#include "leaves/report.h"
#include "leaves/viewed.h"
#include "leaves/world.h"
#include "view/view.h"

#include "common/interrupt.h"
#include "common/progress.h"

#include <cstdio>
#include <cstring>

namespace
{
// Contact leaves no pair that penetrates. The methods are compared on the state that they would get in a simulation
// whose contact is resolved after its collisions are found, 30 times a second.
constexpr double s_secondsAhead = 1.0 / 30;

struct Options
{
    // 120 steps a second: 12 frames.
    qcDemoOptions common = {"out/leaves", 780, 10, qc_methodAuto, qc_deviceAuto, 0};
    qcLeavesRequest world;
    uint32_t pcsEvery = 3;      ///< frames from one on which quick runs to the next; its PCS is drawn until then
    uint32_t compareEvery = 26; ///< frames from one on which all methods run to the next
    const char* record = nullptr;
    qcDetectDef request = qcDefaultDetectDef();
    qcViewOptions view;
};

const char s_help[] =
    "Leaves let go of a tree in gusts of wind, bend, collide with each other and the branches, and pile up.\v"
    "Ctrl-C ends it with a table of what was done.\n\n"
    "Exit status: 0 done; 1 output could not be written, a query failed, or a method that never misses missed; 2 a "
    "mistake on the command line; 4 the device does not work here; 130 ended by Ctrl-C.";

class Demo
{
  public:
    Demo(const Options& options, qcDevice* device, const qcDeviceInfo& info)
        : m_options(options), m_device(device), m_info(info), m_world(options.world, device),
          m_comparison(device, options.request), m_picture(m_world)
    {
    }

    /// False with a message on standard error.
    bool Simulate(qcLeavesRun* run);

  private:
    bool Begin(qcLeavesRun* run);
    void FindPcs();
    bool Compare(size_t frame, bool isLast, qcLeavesStep* measured);
    bool Draw(size_t frame);

    const Options& m_options;
    qcDevice* m_device;
    qcDeviceInfo m_info;
    qcLeavesWorld m_world;
    qcQueryComparison m_comparison;
    qcLeavesPicture m_picture;
    qcBodyId m_tree{};
    std::vector<qcBodyId> m_leaves;
    qcLeavesMarks m_pcs; ///< of quick, the last time
};

/// Adds the tree and the leaves to the comparison.
bool Demo::Begin(qcLeavesRun* run)
{
    if (m_world.LeafCount() == 0)
        return qcDemo_Fail(std::string("no leaf has grown: ") + qcLastMessage());
    const qcTree& tree = m_world.Tree();
    qcBodyDef def = qcDefaultBodyDef();
    def.selfCollision = false;
    def.positions = tree.vertices.data();
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btVector3);
    def.vertexCount = uint32_t(tree.vertices.size());
    def.indices = tree.indices.data();
    def.triangleCount = uint32_t(tree.indices.size() / 3);
    def.activity = qc_activityStatic;
    bool added = m_comparison.Add(def, &m_tree);
    run->leaves = m_world.LeafCount();
    run->requestedLeaves = m_options.world.leaves;
    run->treeTriangles = def.triangleCount;
    def.positionType = qc_positionF32;
    def.positionStride = 0;
    def.indices = m_world.LeafIndices().data();
    def.triangleCount = uint32_t(m_world.LeafIndices().size() / 3);
    def.activity = qc_activityMoving;
    def.deforming = true;
    m_leaves.resize(m_world.LeafCount());
    for (size_t i = 0; i < m_leaves.size() && added; i++)
    {
        std::vector<float> positions;
        m_world.AppendPositions(i, s_secondsAhead, &positions);
        def.positions = positions.data();
        def.vertexCount = uint32_t(positions.size() / 3);
        added = m_comparison.Add(def, &m_leaves[i]);
    }
    run->triangles = m_leaves.size() * def.triangleCount;
    bool begun = added && m_comparison.Warm() && (m_options.record == nullptr || m_comparison.Record(m_options.record));
    return begun || qcDemo_Fail(m_comparison.Message());
}

void Demo::FindPcs()
{
    m_pcs.tree = m_comparison.Marked(qc_queryQuick, m_tree);
    m_pcs.leaves.clear();
    for (qcBodyId leaf : m_leaves)
        m_pcs.leaves.push_back(m_comparison.Marked(qc_queryQuick, leaf));
}

/// Runs the methods on the leaves where they would be without contact.
bool Demo::Compare(size_t frame, bool isLast, qcLeavesStep* measured)
{
    bool done = true;
    std::vector<float> positions;
    for (size_t i = 0; i < m_leaves.size() && done; i++)
    {
        positions.clear();
        m_world.AppendPositions(i, s_secondsAhead, &positions);
        done = m_comparison.SetVertices(m_leaves[i], positions);
    }
    done = done && m_comparison.RunEachStep(&measured->results);
    bool isCompared = frame % m_options.compareEvery == m_options.compareEvery - 1 || isLast;
    bool hasDevice = m_info.kind != qc_deviceNone;
    if (isCompared && hasDevice)
        done = done && m_comparison.RunSampled(&measured->results) && m_comparison.CountMissed(&measured->results);
    else if (frame % m_options.pcsEvery == 0 && hasDevice)
        done = done && m_comparison.Run(qc_queryQuick, &measured->results[qc_queryQuick]);
    if (done && measured->results[qc_queryQuick].ran)
        FindPcs();
    return done || qcDemo_Fail(m_comparison.Message());
}

bool Demo::Draw(size_t frame)
{
    char name[64];
    std::snprintf(name, sizeof name, "/frame_%04zu.png", frame);
    std::string message;
    return m_picture.Write(m_device, m_world, m_pcs, std::string(m_options.common.out) + name, &message) ||
           qcDemo_Fail(message);
}

bool Demo::Simulate(qcLeavesRun* run)
{
    if (!Begin(run))
        return false;
    qcProgress_Begin(m_options.common.steps, "leaves fall");
    for (size_t step = 1; step <= m_options.common.steps && qcInterrupt_Signal() == 0; step++)
    {
        qcLeavesStep measured;
        measured.costs = m_world.Step();
        measured.statistics = m_world.Statistics();
        measured.hanging = m_world.HangingCount();
        measured.energy = m_world.KineticEnergy();
        measured.lowest = m_world.Lowest();
        if (measured.statistics.fallback != nullptr)
            run->fallback = measured.statistics.fallback;
        // The solver owns the text, which is invalid after the solver's end.
        measured.statistics.fallback = nullptr;
        if (measured.statistics.status != qc_statusOk)
            return qcDemo_Fail(std::string("step ") + std::to_string(step) + ": " + qcLastMessage());
        bool isLast = step == m_options.common.steps;
        size_t frame = (step - 1) / m_options.common.frameEvery;
        bool isFrame = step % m_options.common.frameEvery == 0 || isLast;
        if (isFrame && !(Compare(frame, isLast, &measured) && (m_info.kind == qc_deviceNone || Draw(frame))))
            return false;
        run->steps.push_back(measured);
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
    qcLeavesRun run;
    if (!demo.Simulate(&run))
        return qc_exitFailed;
    std::string message;
    if (!qcWriteLeavesCsv(std::string(options.common.out) + "/leaves.csv", run, &message))
    {
        qcDemo_Fail(message);
        return qc_exitFailed;
    }
    qcPrintLeavesTable(run, options.common.method, options.request, info);
    return qcInterrupt_ExitStatus();
}

int View(const Options& options, qcDevice* device)
{
    qcViewedLeaves scene(options.world, device);
    return qcView_Run(&scene, options.view, device);
}
} // namespace

int main(int argumentCount, char** arguments)
{
    Options options;
    std::memcpy(options.request.views, "xz", 3);
    options.request.iterations = 2;
    std::vector<qcOption> rows = {
        {1, "leaves", "N", "Leaves, at most: one grows where there is room; %s by default",
         qcOption_Number(&options.world.leaves, 1, 10000)},
        {1, "seed", "N", "Of the tree, its leaves and when they let go; %s by default",
         qcOption_Number(&options.world.seed, 0, UINT32_MAX)},
        {1, "pcs-every", "N",
         "Frames from one on which quick runs to the next, its PCS in red until then; %s by default",
         qcOption_Number(&options.pcsEvery, 1, 1000000)},
        {1, "compare-every", "N", "Frames from one on which all methods are compared to the next; %s by default",
         qcOption_Number(&options.compareEvery, 1, 1000000)},
        {1, "record", "FILE", "Record the bodies of each frame for \"qc-bench paper\" in FILE",
         qcOption_Text(&options.record)}};
    qcDemo_AddSampledOptions(&rows, "Axes to look along; xz by default, as in the paper's cloth", &options.request);
    qcView_AddOptions(&rows, &options.view);
    qcDevice* device = nullptr;
    int status = qcDemo_Begin(rows, s_help, argumentCount, arguments, &options.common, &device);
    if (status != qc_exitDone)
        return status;
    options.request.threads = options.world.threads = options.common.threads;
    options.world.method = options.common.method;
    status = options.view.Opens() ? View(options, device) : Run(options, device);
    qcDevice_Destroy(device);
    return status;
}
