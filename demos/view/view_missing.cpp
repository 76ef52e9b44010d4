// In place of the live window where its libraries are missing.
#include "view/view.h"

#include "common/exit_status.h"

#include <cerrno>
#include <cstdio>

int qcView_Run(qcViewedScene*, const qcViewOptions&, qcDevice*)
{
    std::fprintf(stderr,
                 "%s: --view: this program was built without a window; install libglfw3-dev and libimgui-dev, then "
                 "build it again\n",
                 program_invocation_short_name);
    return qc_exitFailed;
}
