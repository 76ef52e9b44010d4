// qc-breaking: the paper's second scene. A bunny falls on a dragon again and again, and each time a part of the dragon
// breaks off; pictures, a CSV, a table.
#include "breaking/comparison.h"
#include "breaking/picture.h"
#include "breaking/report.h"
#include "breaking/viewed.h"
#include "breaking/world.h"
#include "view/view.h"
#include "common/bullet/demo_options.h"

#include "common/files.h"
#include "common/interrupt.h"
#include "common/mesh_io/bunny_path.h"
#include "common/progress.h"
#include "common/stopwatch.h"

#include <cstdio>
#include <cstring>
#include <ctime>

namespace
{
struct Options
{
    // 120 steps a second: 10 frames. Four drops.
    qcDemoOptions common = {"out/breaking", 640, 12, qc_methodAuto, qc_deviceAuto, 0};
    qcBreakingModelDef model;
    const char* dragon = "";
    const char* bunny = QC_BUNNY_PATH;
    const char* record = nullptr;
    uint32_t compareEvery = 26; ///< frames from one on which all methods run to the next
    qcDetectDef request = qcDefaultDetectDef();
    qcViewOptions view;
};

const char s_help[] =
    "The Stanford bunny falls on the Stanford dragon again and again. The dragon was cut into pieces when it was "
    "loaded; "
    "each impact breaks the bonds between pieces near it, and what has lost the ground falls.\v"
    "Ctrl-C ends it with a table of what was done.\n\n"
    "Exit status: 0 done; 1 output could not be written, a query failed, or a method that never misses "
    "missed; 2 a mistake on the command line; 3 a mesh can't be read or cut; 4 the device does not "
    "work here; 130 ended by Ctrl-C.";

double ProcessorMs()
{
    return 1000.0 * double(std::clock()) / CLOCKS_PER_SEC;
}

class Demo
{
  public:
    Demo(const Options& options, const qcBreakingModel& model, qcDevice* device)
        : m_options(options), m_device(device), m_world(model, options.common.method, options.common.threads, device),
          m_comparison(m_world, device, options.request)
    {
        qcDevice_GetInfo(device, &m_info);
    }

    /// False with a message on standard error.
    bool Simulate(qcBreakingRun* run);

  private:
    bool Step(qcBreakingRun* run);
    bool Draw(const char* prefix, size_t frame, const qcBreakingMarks& marks);
    bool Frame(size_t frame, bool isLast, qcQueryResults* results);

    const Options& m_options;
    qcDevice* m_device;
    qcDeviceInfo m_info;
    qcBreakingWorld m_world;
    qcBreakingComparison m_comparison;
    qcBreakingPicture m_picture;
};

bool Demo::Step(qcBreakingRun* run)
{
    qcBreakingRow row;
    std::string message;
    double start = ProcessorMs();
    bool done = m_world.Step(&row.step, &message);
    row.cpuMs = ProcessorMs() - start;
    row.drops = m_world.Drops();
    if (row.step.fallback != nullptr)
        run->fallback = row.step.fallback;
    row.step.fallback = nullptr; // the world owns the text
    run->rows.push_back(row);
    return done || qcDemo_Fail("step " + std::to_string(run->rows.size()) + ": " + message);
}

bool Demo::Draw(const char* prefix, size_t frame, const qcBreakingMarks& marks)
{
    char name[64];
    std::snprintf(name, sizeof name, "/%s_%04zu.png", prefix, frame);
    std::string message;
    return m_picture.Write(m_device, m_world, marks, m_options.common.out + std::string(name), &message) ||
           qcDemo_Fail(message);
}

/// Compares the methods on the present state, and draws it with what is near to another body in red; where all methods
/// are compared, also with the PCS of the paper's. Without a device it is only recorded.
bool Demo::Frame(size_t frame, bool isLast, qcQueryResults* results)
{
    bool hasDevice = m_info.kind != qc_deviceNone;
    bool comparesAll = hasDevice && (frame % m_options.compareEvery == m_options.compareEvery - 1 || isLast);
    if (!m_comparison.Run(comparesAll, results))
        return qcDemo_Fail(m_comparison.Message());
    if (!hasDevice)
        return true;
    return Draw("frame", frame, m_comparison.NearMarks()) &&
           (!comparesAll || (Draw("quick", frame, m_comparison.Marks(qc_queryQuick)) &&
                             Draw("cullide", frame, m_comparison.Marks(qc_queryCullide))));
}

bool Demo::Simulate(qcBreakingRun* run)
{
    bool compares = m_info.kind != qc_deviceNone || m_options.record != nullptr;
    if (compares && !m_comparison.Begin(m_options.record))
        return qcDemo_Fail(m_comparison.Message());
    qcProgress_Begin(m_options.common.steps, "a bunny breaks a dragon");
    for (size_t step = 1; step <= m_options.common.steps && qcInterrupt_Signal() == 0; step++)
    {
        if (!Step(run))
            return false;
        bool isLast = step == m_options.common.steps, isFrame = step % m_options.common.frameEvery == 0 || isLast;
        if (compares && isFrame && !Frame((step - 1) / m_options.common.frameEvery, isLast, &run->rows.back().results))
            return false;
        qcProgress_Update(step);
    }
    qcProgress_End();
    return qcCountPenetrating(m_world, &run->penetratingPairs) || qcDemo_Fail(qcLastMessage());
}

/// Reads and cuts the models. Without their files the stand-ins are used, unless a file was named.
bool LoadModel(const Options& options, qcBreakingModel* model, qcBreakingRun* run)
{
    double start = qcStopwatch_NowMs();
    qcBreakingModelDef def = options.model;
    def.dragon = options.dragon;
    def.bunny = options.bunny;
    if (def.bunny == QC_BUNNY_PATH && !qcFiles_IsThere(QC_BUNNY_PATH))
        def.bunny.clear();
    std::string message;
    if (!qcMakeBreakingModel(def, model, &message))
        return qcDemo_Fail(message);
    run->knotStandsIn = def.dragon.empty();
    run->ballStandsIn = def.bunny.empty();
    run->dragonTriangles = model->dragonTriangles;
    run->bunnyTriangles = model->bunny.shape->getTriangleCount();
    run->pieces = model->shapes.size();
    for (const auto& shape : model->shapes)
        run->pieceTriangles += shape->getTriangleCount();
    run->bonds = model->fracture.bonds.size();
    run->loadMs = qcStopwatch_NowMs() - start;
    return true;
}

int Run(const Options& options, qcDevice* device)
{
    qcBreakingModel model;
    qcBreakingRun run;
    std::string message;
    if (!LoadModel(options, &model, &run))
        return qc_exitBadInput;
    Demo demo(options, model, device);
    if (!demo.Simulate(&run))
        return qc_exitFailed;
    if (!qcWriteBreakingCsv(std::string(options.common.out) + "/breaking.csv", run, &message))
    {
        qcDemo_Fail(message);
        return qc_exitFailed;
    }
    qcDeviceInfo info;
    qcDevice_GetInfo(device, &info);
    qcPrintBreakingTable(run, options.request, info);
    return qcInterrupt_ExitStatus();
}

int View(const Options& options, qcDevice* device)
{
    qcBreakingModel model;
    qcBreakingRun run;
    if (!LoadModel(options, &model, &run))
        return qc_exitBadInput;
    qcViewedBreaking scene(model, options.common.method, options.common.threads, device);
    return qcView_Run(&scene, options.view, device);
}
} // namespace

int main(int argumentCount, char** arguments)
{
    Options options;
    std::memcpy(options.request.views, "xyz", 4);
    options.request.iterations = 1;
    std::vector<qcOption> rows = {
        {1, "dragon", "FILE",
         "What breaks: a closed mesh, PLY or OBJ; a knot by default. \"demos/run.sh breaking\" fetches the dragon",
         qcOption_Text(&options.dragon)},
        {1, "bunny", "FILE", "What falls: a closed mesh; the bunny of the package glmark2-data by default",
         qcOption_Text(&options.bunny)},
        {1, "triangles", "N", "The dragon is made coarser until it has about as many; %s by default",
         qcOption_Number(&options.model.dragonTriangles, 1000, 10000000)},
        {1, "bunny-triangles", "N", "The bunny is made coarser until it has about as many; %s by default",
         qcOption_Number(&options.model.bunnyTriangles, 100, 10000000)},
        {1, "pieces", "N", "Voronoi cells of the dragon, each with a piece or more; %s by default",
         qcOption_Number(&options.model.cells, 1, 100000)},
        {1, "seed", "N", "Where the cells are; %s by default", qcOption_Number(&options.model.seed, 0, UINT32_MAX)},
        {1, "compare-every", "N", "Frames from one on which all methods are compared to the next; %s by default",
         qcOption_Number(&options.compareEvery, 1, 1000000)},
        {1, "record", "FILE", "Record the bodies of each frame for \"qc-bench paper\"",
         qcOption_Text(&options.record)}};
    qcDemo_AddSampledOptions(&rows, "Axes to look along; xyz by default, as in the paper", &options.request);
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
