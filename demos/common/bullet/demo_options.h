// Options that the demos of Bullet share, and how such a demo begins and ends.
#ifndef QC_DEMOS_COMMON_BULLET_DEMO_OPTIONS_H
#define QC_DEMOS_COMMON_BULLET_DEMO_OPTIONS_H

#include "quickcullide/quickcullide.h"

#include <argp.h>

#include <string>

enum qcDemoExit
{
    qc_exitDone = 0,
    qc_exitOutput = 1,
    qc_exitUsage = 2,
    qc_exitDevice = 4,
    qc_exitSignal = 128 ///< and the number of the signal
};

struct qcDemoOptions
{
    std::string out;
    unsigned steps;
    unsigned frameEvery; ///< steps from frame to frame
    qcMethod method;
    qcDeviceKind device = qc_deviceAuto;
    uint32_t threads = 0;
};

enum
{
    /// First key of the options that a demo has of its own.
    qc_demoFirstKey = 512
};

/// For argp's children; its input, state->child_inputs[0], is a qcDemoOptions with the demo's defaults.
extern const argp qcDemoArgp;

/// Parses the command line, with `input` for the demo's own parser; makes the folder, opens the device, keeps Ctrl-C.
/// Otherwise a message on standard error that begins with the program's name, and an exit status.
int qcDemo_Begin(const argp* parser, int argumentCount, char** arguments, void* input, const qcDemoOptions* options,
                 qcDevice** device);

/// A message on standard error, after the line of progress has been ended. Returns false.
bool qcDemo_Fail(const std::string& message);

#endif
