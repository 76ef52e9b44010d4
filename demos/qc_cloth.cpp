// qc-cloth, the main demo: the paper's cloth scene in Bullet, with our broadphase and our self-collision, and again
// without self-collision; pictures, a CSV, a table.
#include "cloth_measure.h"
#include "cloth_picture.h"
#include "cloth_report.h"
#include "cloth_world.h"

extern "C" {
#include "option_values.h"
#include "progress.h"
}

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <sys/stat.h>

namespace
{
enum Exit
{
    exit_done = 0,
    exit_output = 1,
    exit_usage = 2,
    exit_device = 4
};

struct Options
{
    std::string out = "out/cloth";
    unsigned triangles = 20000, steps = 360;
    unsigned frameEvery = 10;  ///< steps from frame to frame; 120 steps a second: 12 frames
    unsigned compareEvery = 4; ///< frames from one on which cullide is asked to the next
    qcDeviceKind device = qc_deviceAuto;
    qcDetectDef request = qcDefaultDetectDef();
};

enum OptionKey
{
    // Beyond every character: no option has a short name.
    key_out = 256,
    key_triangles,
    key_steps,
    key_frameEvery,
    key_compareEvery,
    key_device,
    key_views,
    key_resolution,
    key_iterations,
    key_threads
};

error_t ReadOption(int key, char* text, argp_state* state)
{
    auto* options = static_cast<Options*>(state->input);
    switch (key)
    {
        case key_out: options->out = text; return 0;
        case key_triangles: options->triangles = qcOption_ReadNumber(state, "--triangles", text, 2, 2000000); return 0;
        case key_steps: options->steps = qcOption_ReadNumber(state, "--steps", text, 1, 1000000); return 0;
        case key_frameEvery:
            options->frameEvery = qcOption_ReadNumber(state, "--frame-every", text, 1, 1000000);
            return 0;
        case key_compareEvery:
            options->compareEvery = qcOption_ReadNumber(state, "--compare-every", text, 1, 1000000);
            return 0;
        case key_device:
            options->device = qcDeviceKind(qcOption_ReadWord(state, "--device", text, qcDeviceWords));
            return 0;
        case key_views: qcOption_ReadViews(state, "--views", text, options->request.views); return 0;
        case key_resolution:
            options->request.resolution = qcOption_ReadNumber(state, "--resolution", text, 1, 4096);
            return 0;
        case key_iterations:
            options->request.iterations = qcOption_ReadNumber(state, "--iterations", text, 0, UINT32_MAX);
            return 0;
        case key_threads: options->request.threads = qcOption_ReadNumber(state, "--threads", text, 0, 1024); return 0;
        case ARGP_KEY_ARG: argp_error(state, "'%s' is not expected", text); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

const argp_option s_options[] = {
    {"out", key_out, "FOLDER", 0, "Where frames and cloth.csv go; out/cloth by default, made if it is missing", 1},
    {"triangles", key_triangles, "N", 0, "Triangles of the cloth, at least; 20000 by default", 1},
    {"steps", key_steps, "N", 0, "Steps of 1/120 s; 360 by default", 1},
    {"frame-every", key_frameEvery, "N", 0, "Steps from frame to frame; 10 by default", 1},
    {"compare-every", key_compareEvery, "N", 0, "Frames from one on which cullide is asked to the next; 4 by default",
     1},
    {"threads", key_threads, "N", 0, "Threads of the collision queries; 0, the default: one per core", 1},
    {nullptr, 0, nullptr, 0, "For the pictures, and for quick and cullide:", 2},
    {"device", key_device, "DEVICE", 0, "auto (the default), egl, osmesa, surfaceless, or none (no pictures then)", 2},
    {"views", key_views, "LETTERS", 0, "Axes to look along; xz by default, as in the paper", 2},
    {"resolution", key_resolution, "N", 0, "Pixels on a side, 1..4096; 4096 by default", 2},
    {"iterations", key_iterations, "N", 0, "Rounds over the views; 2 by default, 0: until nothing changes", 2},
    {nullptr, 0, nullptr, 0, nullptr, 0}};

const char s_help[] =
    "A cloth falls over a round table and folds on itself: twice, with and without self-collision.\v"
    "Exit status: 0 done; 1 output could not be written, or a query failed; 2 a mistake on the command "
    "line; 4 the device does not work here.";

bool MakeFolder(const std::string& path)
{
    for (size_t slash = path.find('/', 1); slash != std::string::npos; slash = path.find('/', slash + 1))
        mkdir(path.substr(0, slash).c_str(), 0777);
    if (mkdir(path.c_str(), 0777) == 0 || errno == EEXIST)
        return true;
    std::fprintf(stderr, "qc-cloth: can't make the folder %s: %s\n", path.c_str(), std::strerror(errno));
    return false;
}

class Demo
{
  public:
    Demo(const Options& options, qcDevice* device, const qcDeviceInfo& info)
        : m_options(options), m_device(device), m_info(info), m_measure(device, options.request)
    {
    }

    /// Simulates once. False with a message on standard error.
    bool Simulate(bool selfCollision, qcClothRun* run, size_t* triangles);

  private:
    bool Look(qcClothWorld& world, size_t step, qcClothRun* run);
    bool Fail(const std::string& message);

    const Options& m_options;
    qcDevice* m_device;
    qcDeviceInfo m_info;
    qcClothMeasure m_measure;
    qcClothPicture m_picture;
};

bool Demo::Fail(const std::string& message)
{
    qcProgress_End();
    std::fprintf(stderr, "qc-cloth: %s\n", message.c_str());
    return false;
}

/// The frame of a step: asks the paper's methods, draws.
bool Demo::Look(qcClothWorld& world, size_t step, qcClothRun* run)
{
    qcClothStep& measured = run->steps.back();
    if (!m_measure.Update(world.Positions(), world.Indices()) || !m_measure.CountPenetrating(&measured.penetrating))
        return Fail(m_measure.Message());
    bool isLast = step == m_options.steps;
    if (m_info.kind == qc_deviceNone || (step % m_options.frameEvery != 0 && !isLast))
        return true;
    size_t frame = (step - 1) / m_options.frameEvery;
    measured.compared = frame % m_options.compareEvery == m_options.compareEvery - 1 || isLast;
    // Without self-collision only the frames for the table and the last picture are of use.
    if (!run->selfCollision && !measured.compared)
        return true;
    qcClothComparison& comparison = measured.comparison;
    if (!m_measure.Ask(qc_methodQuick, &comparison.quick) ||
        (measured.compared && !m_measure.Ask(qc_methodCullide, &comparison.cullide)))
        return Fail(m_measure.Message());
    std::string message;
    char name[64];
    if (run->selfCollision)
    {
        std::snprintf(name, sizeof name, "/frame_%04zu.png", frame);
        if (!m_picture.Write(m_device, world.Positions(), world.Indices(), comparison.quick.marked,
                             m_options.out + name, &message))
            return Fail(message);
    }
    if (measured.compared)
    {
        std::snprintf(name, sizeof name, "/%s_cullide_%04zu.png", run->selfCollision ? "with" : "without", frame);
        if (!m_picture.Write(m_device, world.Positions(), world.Indices(), comparison.cullide.marked,
                             m_options.out + name, &message))
            return Fail(message);
    }
    return true;
}

bool Demo::Simulate(bool selfCollision, qcClothRun* run, size_t* triangles)
{
    run->selfCollision = selfCollision;
    qcClothWorld world(m_options.triangles, selfCollision, m_options.request.threads);
    *triangles = world.Indices().size() / 3;
    qcProgress_Begin(m_options.steps, selfCollision ? "cloth with self-collision" : "cloth without self-collision");
    for (size_t step = 1; step <= m_options.steps; step++)
    {
        qcClothStep measured;
        measured.stepMs = world.Step();
        measured.statistics = world.Statistics();
        measured.manifolds = world.ManifoldCount();
        run->steps.push_back(measured);
        if (measured.statistics.status != qc_statusOk)
            return Fail(std::string("step ") + std::to_string(step) + ": " + qcLastMessage());
        if (!Look(world, step, run))
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
        return exit_output;
    std::string message;
    if (!qcWriteClothCsv(options.out + "/cloth.csv", with, without, qcClothWorld::stepSeconds, &message))
    {
        std::fprintf(stderr, "qc-cloth: %s\n", message.c_str());
        return exit_output;
    }
    qcPrintClothTable(with, without, triangles, options.request, info);
    return exit_done;
}
} // namespace

int main(int argumentCount, char** arguments)
{
    Options options;
    std::memcpy(options.request.views, "xz", 3);
    options.request.iterations = 2;
    const argp parser = {s_options, ReadOption, nullptr, s_help, nullptr, nullptr, nullptr};
    argp_err_exit_status = exit_usage;
    argp_parse(&parser, argumentCount, arguments, 0, nullptr, &options);
    if (!MakeFolder(options.out))
        return exit_output;

    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = options.device;
    qcDevice* device = nullptr;
    if (qcDevice_Create(&def, &device) != qc_statusOk)
    {
        std::fprintf(stderr, "qc-cloth: %s\n", qcLastMessage());
        return exit_device;
    }
    int status = Run(options, device);
    qcDevice_Destroy(device);
    return status;
}
