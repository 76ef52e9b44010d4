// Options that the Bullet demos share.
#include "common/bullet/demo_options.h"

#include "common/files.h"
#include "common/interrupt.h"
#include "common/progress.h"

#include <cerrno>
#include <cstdio>

namespace
{
// Methods that never miss, without brute force, which would take minutes a step.
const qcWord s_methods[] = {
    {"layers", qc_methodLayers}, {"auto", qc_methodAuto}, {"sweep", qc_methodSweep}, {nullptr, 0}};

void Parse(std::vector<qcOption> rows, const char* help, int argumentCount, char** arguments, qcDemoOptions* options)
{
    const qcOption shared[] = {
        {1, "out", "FOLDER", "Where frames and a CSV go, made if it is missing; %s by default",
         qcOption_Folder(&options->out)},
        {1, "steps", "N", "Steps of the simulation; %s by default", qcOption_Number(&options->steps, 1, 1000000)},
        {1, "frame-every", "N", "Steps from frame to frame; %s by default",
         qcOption_Number(&options->frameEvery, 1, 1000000)},
        {1, "method", "METHOD",
         "What finds the collisions: layers (on the GL device), sweep (on the CPU) or auto (the planner chooses "
         "between the two). The simulation is the same; %s by default",
         qcOption_Method(&options->method, s_methods)},
        {1, "device", "DEVICE",
         "What draws: auto (the default: a GPU where there is one, otherwise OSMesa), egl, osmesa, surfaceless, or "
         "none (no pictures then, and layers falls back on sweep)",
         qcOption_Device(&options->device)},
        {1, "threads", "N", "Threads of the collision queries; 0, the default: one per core",
         qcOption_Number(&options->threads, 0, 1024)},
        {}};
    rows.insert(rows.end(), std::begin(shared), std::end(shared));
    qcCommandLine line = {rows.data(), help, nullptr, nullptr, 0, nullptr, nullptr};
    qcCommandLine_Parse(&line, argumentCount, arguments);
}
} // namespace

void qcDemo_AddSampledOptions(std::vector<qcOption>* rows, const char* viewsHelp, qcDetectDef* request)
{
    const qcOption sampled[] = {{2, nullptr, nullptr, "For quick and cullide:", {}},
                                {2, "views", "LETTERS", viewsHelp, qcOption_Views(&request->views)},
                                {2, "resolution", "N", "Pixels on a side, 1..4096; 4096 by default",
                                 qcOption_Number(&request->resolution, 1, 4096)},
                                {2, "iterations", "N", "Rounds over the views; %s by default, 0: until nothing changes",
                                 qcOption_Number(&request->iterations, 0, UINT32_MAX)}};
    rows->insert(rows->end(), std::begin(sampled), std::end(sampled));
}

int qcDemo_Begin(const std::vector<qcOption>& rows, const char* help, int argumentCount, char** arguments,
                 qcDemoOptions* options, qcDevice** device)
{
    Parse(rows, help, argumentCount, arguments, options);
    qcInterrupt_Watch();
    qcMessage message;
    if (!qcFiles_MakeFolder(options->out, &message))
    {
        qcDemo_Fail(message.text);
        return qc_exitFailed;
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
