// Options that the demos of Bullet share.
#include "common/bullet/demo_options.h"

extern "C" {
#include "common/files.h"
#include "common/interrupt.h"
#include "common/option_values.h"
#include "common/progress.h"
}

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace
{
enum OptionKey
{
    // Beyond every character: no option has a short name.
    key_out = 256,
    key_steps,
    key_frameEvery,
    key_method,
    key_device,
    key_threads
};

// Those that never miss, but for brute force, which would take minutes a step.
const qcWord s_methods[] = {
    {"layers", qc_methodLayers}, {"auto", qc_methodAuto}, {"sweep", qc_methodSweep}, {nullptr, 0}};

error_t ReadOption(int key, char* text, argp_state* state)
{
    auto* options = static_cast<qcDemoOptions*>(state->input);
    switch (key)
    {
        case key_out: options->out = qcOption_ReadFolder(state, "--out", text); return 0;
        case key_steps: options->steps = qcOption_ReadNumber(state, "--steps", text, 1, 1000000); return 0;
        case key_frameEvery:
            options->frameEvery = qcOption_ReadNumber(state, "--frame-every", text, 1, 1000000);
            return 0;
        case key_method: options->method = qcMethod(qcOption_ReadWord(state, "--method", text, s_methods)); return 0;
        case key_device:
            options->device = qcDeviceKind(qcOption_ReadWord(state, "--device", text, qcDeviceWords));
            return 0;
        case key_threads: options->threads = qcOption_ReadNumber(state, "--threads", text, 0, 1024); return 0;
        case ARGP_KEY_ARG: argp_error(state, "'%s' is not expected", text); return 0;
        default: return ARGP_ERR_UNKNOWN;
    }
}

/// Ends the text of an option with the demo's own default.
char* AddDefault(int key, const char* text, void* input)
{
    const auto* options = static_cast<const qcDemoOptions*>(input);
    std::string ending;
    if (options != nullptr && key == key_out)
        ending = options->out;
    else if (options != nullptr && key == key_steps)
        ending = std::to_string(options->steps);
    else if (options != nullptr && key == key_frameEvery)
        ending = std::to_string(options->frameEvery);
    else if (options != nullptr && key == key_method)
        ending = qcMethod_Name(options->method);
    if (ending.empty())
        return const_cast<char*>(text);
    // argp frees it.
    return strdup((std::string(text) + "; " + ending + " by default").c_str());
}

const argp_option s_options[] = {
    {"out", key_out, "FOLDER", 0, "Where frames and a CSV go, made if it is missing", 1},
    {"steps", key_steps, "N", 0, "Steps of the simulation", 1},
    {"frame-every", key_frameEvery, "N", 0, "Steps from frame to frame", 1},
    {"method", key_method, "METHOD", 0,
     "What finds the collisions: layers (image space, on the device), sweep (object space, on the CPU) or auto (the "
     "planner chooses between the two). The simulation is the same",
     1},
    {"device", key_device, "DEVICE", 0,
     "What draws: auto (the default: a GPU where there is one, otherwise OSMesa), egl, osmesa, surfaceless, or none "
     "(no pictures then, and layers falls back on sweep)",
     1},
    {"threads", key_threads, "N", 0, "Threads of the collision queries; 0, the default: one per core", 1},
    {nullptr, 0, nullptr, 0, nullptr, 0}};
} // namespace

const argp qcDemoArgp = {s_options, ReadOption, nullptr, nullptr, nullptr, AddDefault, nullptr};

int qcDemo_Begin(const argp* parser, int argumentCount, char** arguments, void* input, const qcDemoOptions* options,
                 qcDevice** device)
{
    argp_err_exit_status = qc_exitUsage;
    argp_parse(parser, argumentCount, arguments, 0, nullptr, input);
    qcInterrupt_Watch();
    qcMessage message;
    if (!qcBenchFiles_MakeFolder(options->out.c_str(), &message))
    {
        qcDemo_Fail(message.text);
        return qc_exitOutput;
    }
    qcDeviceDef def = qcDefaultDeviceDef();
    def.kind = options->device;
    if (qcDevice_Create(&def, device) == qc_statusOk)
        return qc_exitDone;
    qcDemo_Fail(qcLastMessage());
    return qc_exitDevice;
}

bool qcDemo_Fail(const std::string& message)
{
    qcProgress_End();
    std::fprintf(stderr, "%s: %s\n", program_invocation_short_name, message.c_str());
    return false;
}
