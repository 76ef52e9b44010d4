// The live window of a demo: --view.
#ifndef QC_DEMOS_VIEW_VIEW_H
#define QC_DEMOS_VIEW_VIEW_H

#include "common/options.h"

#include <vector>

class qcViewedScene;

/// How triangles are coloured.
enum qcViewMarks
{
    qc_marksNone,
    qc_marksPcs,   ///< red: PCS of the simulation's own queries
    qc_marksQuick, ///< red: PCS of Quick-CULLIDE
    qc_marksSets   ///< FFV, SFV and NFV of Quick-CULLIDE
};

struct qcViewOptions
{
    bool on = false;
    const char* screenshot = nullptr; ///< a PNG file of the last frame; null: the window stays open
    uint32_t frames = 120;            ///< to the screenshot; one step each
    qcViewMarks marks = qc_marksNone; ///< at first
    int modes = 0;                    ///< at first; bits of qcDebugDrawMode

    /// True if the window opens: an option for what it shows, or for its picture, opens it too.
    bool Opens() const
    {
        return on || screenshot != nullptr || marks != qc_marksNone || modes != 0;
    }
};

/// Appends the options of the window to a command line. `options` must outlive the parsing.
void qcView_AddOptions(std::vector<qcOption>* rows, qcViewOptions* options);

/// Opens the window and runs the scene until the window is closed. `device` runs Quick-CULLIDE for the sets; without GL
/// there are none. Returns the program's exit status, after a message if it isn't qc_exitDone.
int qcView_Run(qcViewedScene* scene, const qcViewOptions& options, qcDevice* device);

#endif
