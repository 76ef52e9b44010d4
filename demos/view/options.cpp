// Options of the live window.
#include "view/view.h"

#include "quickcullide/bullet_debug_draw.h"

namespace
{
constexpr int s_firstMarks = 1000;

const qcWord s_words[] = {{"pcs", s_firstMarks + qc_marksPcs},
                          {"quick", s_firstMarks + qc_marksQuick},
                          {"sets", s_firstMarks + qc_marksSets},
                          {"candidates", qc_drawCandidates},
                          {"contacts", qc_drawContacts},
                          {"manifolds", qc_drawManifolds},
                          {"boxes", qc_drawBoxes},
                          {"planes", qc_drawPlanes},
                          {nullptr, 0}};

void TakeShown(const struct argp_state* state, const char* text, void* context)
{
    auto* options = static_cast<qcViewOptions*>(context);
    int value = qcOption_ReadWord(state, "--view-show", text, s_words);
    if (value >= s_firstMarks)
        options->marks = qcViewMarks(value - s_firstMarks);
    else
        options->modes |= value;
}
} // namespace

void qcView_AddOptions(std::vector<qcOption>* rows, qcViewOptions* options)
{
    rows->insert(
        rows->end(),
        {{9,
          nullptr,
          nullptr,
          "A live window in place of files, opened by --view, --view-show or --view-screenshot:",
          {}},
         {9, "view", nullptr, "Open a window: orbit, pause, pick, show what the culling does, change settings",
          qcOption_Flag(&options->on, true)},
         {9, "view-show", "WHAT",
          "Shown at first, words with commas between: pcs, quick or sets (colours of triangles), candidates, contacts, "
          "manifolds, boxes, planes",
          qcOption_Texts(TakeShown, options)},
         {9, "view-screenshot", "FILE", "Write a picture of the window, PNG, after --view-frames frames, and end",
          qcOption_Text(&options->screenshot)},
         {9, "view-frames", "N", "Frames to the screenshot, a step each; %s by default",
          qcOption_Number(&options->frames, 1, 1000000)}});
}
