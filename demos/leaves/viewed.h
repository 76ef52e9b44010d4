// The leaves in the live window.
#ifndef QC_DEMOS_LEAVES_VIEWED_H
#define QC_DEMOS_LEAVES_VIEWED_H

#include "leaves/world.h"
#include "view/settings.h"

class qcViewedLeaves : public qcViewedScene
{
  public:
    qcViewedLeaves(const qcLeavesRequest& request, qcDevice* device);

    const char* Title() const override
    {
        return "Leaves fall from a tree";
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world->Bullet();
    }
    double StepSeconds() const override
    {
        return qcLeavesWorld::stepSeconds;
    }
    bool Step(std::string* message) override;
    void Restart() override
    {
        MakeWorld();
    }
    void AddTo(qcDebugDraw* drawing) override
    {
        drawing->add(&m_world->SoftSolver());
    }
    qcStepCosts Costs() const override
    {
        return m_costs;
    }
    std::vector<qcViewStatistic> Statistics() const override;
    std::vector<qcViewSetting> Settings() override;
    bool ColorsOf(const btCollisionObject* object, qcViewColors* colors) const override;
    qcViewPlace Place() const override;

  private:
    void MakeWorld();

    qcLeavesRequest m_request;
    qcViewDevices m_devices;
    qcStepCosts m_costs;
    std::unique_ptr<qcLeavesWorld> m_world; ///< ends before the devices
};

#endif
