// Options that the Bullet demos share, and how such a demo begins and fails.
#ifndef QC_DEMOS_COMMON_BULLET_DEMO_OPTIONS_H
#define QC_DEMOS_COMMON_BULLET_DEMO_OPTIONS_H

#include "common/exit_status.h"
#include "common/options.h"
#include "quickcullide/quickcullide.h"

#include <string>
#include <vector>

struct qcDemoOptions
{
    const char* out;
    uint32_t steps;
    uint32_t frameEvery; ///< steps from frame to frame
    qcMethod method;
    qcDeviceKind device = qc_deviceAuto;
    uint32_t threads = 0;
};

/// Appends the options of quick and cullide: views, resolution, rounds. `viewsHelp` is the help of the views, and
/// outlives the rows.
void qcDemo_AddSampledOptions(std::vector<qcOption>* rows, const char* viewsHelp, qcDetectDef* request);

/// Parses the command line: the shared options, which hold the demo's defaults, and the demo's own rows (groups 1 and
/// up). Then makes the folder, opens the device and starts watching for Ctrl-C. On failure it prints a message that
/// begins with the program's name and returns another exit status than qc_exitDone.
int qcDemo_Begin(const std::vector<qcOption>& rows, const char* help, int argumentCount, char** arguments,
                 qcDemoOptions* options, qcDevice** device);

/// Prints a message on standard error, after the line of progress has been ended. Returns false.
bool qcDemo_Fail(const std::string& message);

#endif
