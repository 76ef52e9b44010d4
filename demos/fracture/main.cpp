// qc-fracture: a bunny falls on a floor and breaks in the midst of a step into hundreds of pieces, which collide and
// come to rest; pictures, a CSV, a table.
#include "common/bullet/demo_options.h"
#include "fracture/picture.h"
#include "fracture/pieces.h"
#include "fracture/report.h"
#include "fracture/viewed.h"
#include "fracture/world.h"
#include "view/view.h"

#include "common/files.h"
#include "common/mesh_io/bunny_path.h"
#include "common/interrupt.h"
#include "common/output_file.h"
#include "common/progress.h"

#include <cstdio>

namespace
{
constexpr btScalar s_extent = 4; // longest edge of the body's box, m

struct Options
{
    // 240 steps a second: 24 frames.
    qcDemoOptions common = {"out/fracture", 720, 10, qc_methodAuto, qc_deviceAuto, 0};
    const char* mesh = QC_BUNNY_PATH;
    uint32_t triangles = 5000;
    qcFractureRequest request;
    const char* load = nullptr;
    qcViewOptions view;
};

const char s_help[] =
    "A bunny of 4 m falls on a floor, breaks on its first hard impact, and its pieces come to rest.\v"
    "Ctrl-C ends it with a table of what was done.\n\n"
    "Exit status: 0 done; 1 nothing broke that was to be saved, output could not be written, or a query failed; 2 a "
    "mistake on the command line; 3 the mesh or its pieces can't be read; 4 the device does not work here; 130 ended "
    "by Ctrl-C.";

/// Pairs of triangles of two pieces that penetrate, by the exact test.
bool CountPenetrating(const std::vector<std::unique_ptr<qcFractureBody>>& bodies, size_t* pairs)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    qcStatus status = qcScene_Create(&sceneDef, &scene);
    for (size_t i = 0; i < bodies.size() && status == qc_statusOk; i++)
    {
        qcBodyId id;
        status = bodies[i]->AddTo(scene, &id);
    }
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result = nullptr;
    if (status == qc_statusOk)
        status = qcScene_Detect(scene, &def, &result);
    if (status == qc_statusOk)
        *pairs = result->pairCount;
    qcScene_Destroy(scene);
    return status == qc_statusOk || qcDemo_Fail(qcLastMessage());
}

bool Draw(const Options& options, qcDevice* device, const qcFractureWorld& world, size_t frame,
          qcFracturePicture* picture)
{
    char name[64];
    std::snprintf(name, sizeof name, "/frame_%04zu.png", frame);
    std::string message;
    return picture->Write(device, world.Bodies(), std::string(options.common.out) + name, &message) ||
           qcDemo_Fail(message);
}

/// False with a message on standard error.
bool Simulate(const Options& options, qcDevice* device, const qcDeviceInfo& info, const qcFractureModel& model,
              qcFractureRun* run)
{
    qcFractureWorld world(model, options.request, device);
    run->triangles = world.Bodies().front()->shape.getTriangleCount();
    run->mass = world.Bodies().front()->body.getMass();
    qcFracturePicture picture;
    qcProgress_Begin(options.common.steps, "a bunny falls and breaks");
    for (size_t step = 1; step <= options.common.steps && qcInterrupt_Signal() == 0; step++)
    {
        qcFractureStep measured;
        std::string message;
        if (!world.Step(&measured, &message))
            return qcDemo_Fail("step " + std::to_string(step) + ": " + message);
        if (measured.fallback != nullptr)
            run->fallback = measured.fallback;
        measured.fallback = nullptr; // the world owns the text
        run->steps.push_back(measured);
        bool isFrame = step % options.common.frameEvery == 0 || step == options.common.steps;
        if (info.kind != qc_deviceNone && isFrame &&
            !Draw(options, device, world, (step - 1) / options.common.frameEvery, &picture))
            return false;
        qcProgress_Update(step);
    }
    qcProgress_End();
    run->broken = world.Break();
    return CountPenetrating(world.Bodies(), &run->penetratingPairs);
}

/// Reads the mesh and, into `pieces`, its pieces if they are in a file.
bool ReadModel(Options* given, qcFractureModel* model, qcFracture* pieces)
{
    const Options& options = *given;
    std::string message;
    if (std::string(options.mesh) == QC_BUNNY_PATH && !qcFiles_IsThere(QC_BUNNY_PATH))
        return qcDemo_Fail(std::string(options.mesh) +
                           " is not there; the package glmark2-data has it, or name another mesh with --mesh");
    bool read = qcReadFractureModel(options.mesh, options.triangles, s_extent, model, &message);
    if (read && options.load != nullptr)
    {
        read = qcLoadPieces(options.load, model->indices.size() / 3, pieces, &message);
        given->request.loaded = pieces;
    }
    return read || qcDemo_Fail(message);
}

int Run(Options options, qcDevice* device)
{
    qcFractureModel model;
    qcFracture pieces;
    qcFractureRun run;
    qcDeviceInfo info;
    qcDevice_GetInfo(device, &info);
    if (!ReadModel(&options, &model, &pieces))
        return qc_exitBadInput;
    if (!Simulate(options, device, info, model, &run))
        return qc_exitFailed;
    std::string message;
    if (!qcWriteFractureCsv(std::string(options.common.out) + "/fracture.csv", run, &message))
    {
        qcDemo_Fail(message);
        return qc_exitFailed;
    }
    qcPrintFractureTable(run, info);
    if (options.request.save != nullptr && !options.request.precut && !run.broken.happened)
    {
        qcDemo_Fail("nothing broke, and " + std::string(options.request.save) + " was not written");
        return qc_exitFailed;
    }
    return qcInterrupt_ExitStatus();
}

int View(Options options, qcDevice* device)
{
    qcFractureModel model;
    qcFracture pieces;
    if (!ReadModel(&options, &model, &pieces))
        return qc_exitBadInput;
    qcViewedFracture scene(model, options.request, device);
    return qcView_Run(&scene, options.view, device);
}

/// Whether the pieces can be saved: found before the mesh is read, and the body falls.
int CheckSave(const Options& options)
{
    if (options.request.save == nullptr)
        return qc_exitDone;
    if (options.load != nullptr)
    {
        qcDemo_Fail("--save: nothing is cut with --load");
        return qc_exitUsage;
    }
    qcMessage message;
    if (qcOutput_Check(options.request.save, &message))
        return qc_exitDone;
    qcDemo_Fail(message.text);
    return qc_exitFailed;
}
} // namespace

int main(int argumentCount, char** arguments)
{
    Options options;
    std::vector<qcOption> rows = {
        {1, "mesh", "FILE", "What breaks: a closed mesh, PLY or OBJ; the bunny of the package glmark2-data by default",
         qcOption_Text(&options.mesh)},
        {1, "triangles", "N", "The mesh is made coarser until it has about as many; %s by default",
         qcOption_Number(&options.triangles, 100, 10000000)},
        {1, "save", "FILE", "The pieces go to a file when they are cut; not with --load",
         qcOption_Text(&options.request.save)},
        {1, "load", "FILE",
         "The pieces come from a file of --save, made of the same --mesh with the same --triangles; there is nothing "
         "to cut then, and --pieces and --seed have no effect",
         qcOption_Text(&options.load)},
        {1, "pieces", "N", "Voronoi cells, each with a piece or more; %s by default",
         qcOption_Number(&options.request.pieces, 1, 10000)},
        {1, "seed", "N", "Where the cells are; %s by default", qcOption_Number(&options.request.seed, 0, UINT32_MAX)},
        {1, "precut", nullptr, "The pieces are cut when the mesh is loaded; by default when it breaks",
         qcOption_Flag(&options.request.precut, true)}};
    qcView_AddOptions(&rows, &options.view);
    qcDevice* device = nullptr;
    int status = qcDemo_Begin(rows, s_help, argumentCount, arguments, &options.common, &device);
    if (status != qc_exitDone)
        return status;
    options.request.method = options.common.method;
    options.request.threads = options.common.threads;
    status = CheckSave(options);
    if (status == qc_exitDone)
        status = options.view.Opens() ? View(options, device) : Run(options, device);
    qcDevice_Destroy(device);
    return status;
}
