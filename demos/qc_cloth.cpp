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
    unsigned compareEvery = 4; ///< frames from one on which all methods are asked to the next
    qcMethod method = qc_methodLayers;
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
    key_method,
    key_device,
    key_views,
    key_resolution,
    key_iterations,
    key_threads
};

// Those that never miss, but for brute force, which would take minutes a step.
const qcWord s_methods[] = {
    {"layers", qc_methodLayers}, {"auto", qc_methodAuto}, {"sweep", qc_methodSweep}, {nullptr, 0}};

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
        case key_method: options->method = qcMethod(qcOption_ReadWord(state, "--method", text, s_methods)); return 0;
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
    {"compare-every", key_compareEvery, "N", 0,
     "Frames from one on which all methods are compared to the next; 4 by default", 1},
    {"method", key_method, "METHOD", 0,
     "What finds the self-collisions: layers (the default: image space, on the device), sweep (object space, on the "
     "CPU) or auto (the planner chooses between the two). The simulation is the same",
     1},
    {"device", key_device, "DEVICE", 0,
     "What draws: auto (the default: a GPU where there is one, otherwise OSMesa), egl, osmesa, surfaceless, or none "
     "(no "
     "pictures then, and layers falls back on sweep)",
     1},
    {"threads", key_threads, "N", 0, "Threads of the collision queries; 0, the default: one per core", 1},
    {nullptr, 0, nullptr, 0, "For quick and cullide:", 2},
    {"views", key_views, "LETTERS", 0, "Axes to look along; xz by default, as in the paper", 2},
    {"resolution", key_resolution, "N", 0, "Pixels on a side, 1..4096; 4096 by default", 2},
    {"iterations", key_iterations, "N", 0, "Rounds over the views; 2 by default, 0: until nothing changes", 2},
    {nullptr, 0, nullptr, 0, nullptr, 0}};

const char s_help[] =
    "A cloth falls over a round table and folds on itself: twice, with and without self-collision.\v"
    "Exit status: 0 done; 1 output could not be written, a query failed, or a method that never misses missed; 2 a "
    "mistake on the command line; 4 the device does not work here.";

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
    bool Ask(qcClothQuestion question, qcClothStep* measured);
    bool Draw(qcClothWorld& world, const char* prefix, size_t frame);
    bool Compare(size_t step, qcClothStep* measured);
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

bool Demo::Ask(qcClothQuestion question, qcClothStep* measured)
{
    return m_measure.Ask(question, &measured->answers[question]) || Fail(m_measure.Message());
}

/// The cloth, and the PCS that was asked last.
bool Demo::Draw(qcClothWorld& world, const char* prefix, size_t frame)
{
    char name[64];
    std::snprintf(name, sizeof name, "/%s_%04zu.png", prefix, frame);
    std::string message;
    return m_picture.Write(m_device, world.Positions(), world.Indices(), m_measure.Marked(), m_options.out + name,
                           &message) ||
           Fail(message);
}

/// Asks all that are left, and holds them against each other.
bool Demo::Compare(size_t step, qcClothStep* measured)
{
    for (qcClothQuestion question : {qc_clothQuickSorted, qc_clothQuickSortedBack, qc_clothAuto, qc_clothLayers})
        if (!Ask(question, measured))
            return false;
    m_measure.Judge(&measured->answers);
    for (size_t i = 0; i < measured->answers.size(); i++)
    {
        const qcClothAnswer& answer = measured->answers[i];
        if (qcClothQuestions[i].neverMisses && answer.missed != 0)
            return Fail("step " + std::to_string(step) + ": " + qcClothQuestions[i].label + " missed " +
                        std::to_string(answer.missed) + " of " + std::to_string(answer.found + answer.missed) +
                        " pairs");
    }
    return true;
}

/// The frame of a step: asks the other methods, draws.
bool Demo::Look(qcClothWorld& world, size_t step, qcClothRun* run)
{
    qcClothStep& measured = run->steps.back();
    if (!m_measure.Update(world.Positions()))
        return Fail(m_measure.Message());
    if (!Ask(qc_clothSweep, &measured))
        return false;
    bool isLast = step == m_options.steps;
    if (m_info.kind == qc_deviceNone || (step % m_options.frameEvery != 0 && !isLast))
        return true;
    size_t frame = (step - 1) / m_options.frameEvery;
    measured.compared = frame % m_options.compareEvery == m_options.compareEvery - 1 || isLast;
    // Without self-collision only the frames for the table and the last picture are of use.
    if (!run->selfCollision && !measured.compared)
        return true;
    if (!Ask(qc_clothQuick, &measured) || (run->selfCollision && !Draw(world, "frame", frame)))
        return false;
    if (!measured.compared)
        return true;
    return Ask(qc_clothCullide, &measured) &&
           Draw(world, run->selfCollision ? "with_cullide" : "without_cullide", frame) && Compare(step, &measured);
}

bool Demo::Simulate(bool selfCollision, qcClothRun* run, size_t* triangles)
{
    run->selfCollision = selfCollision;
    qcClothWorld world(m_options.triangles, selfCollision, m_device, m_options.method, m_options.request.threads);
    *triangles = world.Indices().size() / 3;
    if (!m_measure.Begin(world.Positions(), world.Indices()))
        return Fail(m_measure.Message());
    qcProgress_Begin(m_options.steps, selfCollision ? "cloth with self-collision" : "cloth without self-collision");
    for (size_t step = 1; step <= m_options.steps; step++)
    {
        qcClothStep measured;
        measured.stepMs = world.Step();
        measured.statistics = world.Statistics();
        measured.manifolds = world.ManifoldCount();
        if (measured.statistics.fallback != nullptr)
            run->fallback = measured.statistics.fallback;
        // It ends with the solver.
        measured.statistics.fallback = nullptr;
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
    qcPrintClothTable(with, without, triangles, options.method, options.request, info);
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
