// The controls of the live window, with Dear ImGui.
#ifndef QC_DEMOS_VIEW_PANELS_H
#define QC_DEMOS_VIEW_PANELS_H

#include "view/culling.h"
#include "view/view.h"
#include "view/viewed_scene.h"

#include <deque>

/// What the controls show and change.
struct qcViewState
{
    bool paused = false;
    bool stepOnce = false, restart = false; ///< requests; the loop clears them
    bool finished = false;                  ///< a step failed
    uint64_t steps = 0;                     ///< since the beginning
    qcViewMarks marks = qc_marksNone;
    int modes = 0;             ///< bits of qcDebugDrawMode
    qcViewRequest request;     ///< of Quick-CULLIDE
    bool hasGl = false;        ///< Quick-CULLIDE can run
    std::string message;       ///< of the last failure
    size_t changedSetting = 0; ///< index + 1 of a setting to be changed to `newValue`; 0: none
    double newValue = 0;
    double framesASecond = 0;

    const btCollisionObject* picked = nullptr;
    int pickedId = 0; ///< of its proxy
};

/// Costs of steps, for the bars.
class qcViewCosts
{
  public:
    void Add(const qcStepCosts& costs);
    void Clear();
    /// Mean of the last steps; later ones weigh more.
    const qcStepCosts& Mean() const
    {
        return m_mean;
    }
    /// Total milliseconds of each of the last steps.
    const std::deque<float>& Totals() const
    {
        return m_totals;
    }

  private:
    qcStepCosts m_mean;
    std::deque<float> m_totals;
};

/// Colours and font. Call it once, after the context was made.
void qcStylePanels();

struct qcViewPanelInput
{
    qcViewedScene* scene;
    const std::vector<qcViewSetting>* settings;
    const qcViewCosts* costs;
    const qcViewSets* sets;
    const std::vector<qcViewSurface>* surfaces;
};

/// Draws the panels, and applies what the user does to the state.
void qcDrawPanels(const qcViewPanelInput& input, qcViewState* state);

/// The demo's name of an object, or one made of its type and number.
std::string qcNameOf(const qcViewedScene& scene, const qcViewSurface& surface);

/// Linear RGB of a set.
btVector3 qcColorOfSet(qcVisibilitySet set);

#endif
