// What the live window shows: a demo's world, with names, colours, settings, statistics and stage times.
#ifndef QC_DEMOS_VIEW_VIEWED_SCENE_H
#define QC_DEMOS_VIEW_VIEWED_SCENE_H

#include "common/bullet/step_costs.h"

#include "quickcullide/bullet_debug_draw.h"

#include <btBulletDynamicsCommon.h>

#include <functional>
#include <string>
#include <vector>

/// A value that a panel shows and changes while the simulation runs.
struct qcViewSetting
{
    std::string label;
    std::vector<std::string> choices; ///< the value is an index in it; empty: the value is a number
    double lowest = 0, highest = 1;   ///< of a number
    const char* format = "%.3f";      ///< of a number, with its unit
    std::function<double()> get;
    /// Returns a message if the value can't be set, which keeps the old one; otherwise an empty string.
    std::function<std::string(double)> set;
};

struct qcViewStatistic
{
    std::string label, value;
};

/// Linear RGB of the two sides of an object's triangles.
struct qcViewColors
{
    float front[3], back[3];
};

/// Where the camera is at first. Zeros: it sees all objects.
struct qcViewPlace
{
    btVector3 eye{0, 0, 0}, target{0, 0, 0};
};

class qcViewedScene
{
  public:
    virtual ~qcViewedScene() = default;

    /// The title of the window.
    virtual const char* Title() const = 0;
    /// The present world: Restart and settings may make another one.
    virtual btDiscreteDynamicsWorld& World() = 0;
    virtual double StepSeconds() const = 0;
    /// One step. False with a message: the simulation can't go on until it is restarted.
    virtual bool Step(std::string* message) = 0;
    /// Back to the beginning, with the present settings.
    virtual void Restart() = 0;
    /// Adds the world's contact classes.
    virtual void AddTo(qcDebugDraw* drawing) = 0;

    /// Those of the last step.
    virtual qcStepCosts Costs() const = 0;
    /// Those of the last step.
    virtual std::vector<qcViewStatistic> Statistics() const
    {
        return {};
    }
    /// Read once, and again after the world has changed.
    virtual std::vector<qcViewSetting> Settings()
    {
        return {};
    }
    /// Empty: a name made of its type and number.
    virtual std::string NameOf(const btCollisionObject*) const
    {
        return {};
    }
    /// False: colours by number.
    virtual bool ColorsOf(const btCollisionObject*, qcViewColors*) const
    {
        return false;
    }
    virtual qcViewPlace Place() const
    {
        return {};
    }
};

#endif
