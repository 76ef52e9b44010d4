// The bunny and the breaking dragon in the live window.
#ifndef QC_DEMOS_BREAKING_VIEWED_H
#define QC_DEMOS_BREAKING_VIEWED_H

#include "breaking/world.h"
#include "view/settings.h"

class qcViewedBreaking : public qcViewedScene
{
  public:
    /// The model and the device must outlive this object.
    qcViewedBreaking(const qcBreakingModel& model, qcMethod method, uint32_t threads, qcDevice* device);

    const char* Title() const override
    {
        return "A bunny falls on a dragon";
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world->Bullet();
    }
    double StepSeconds() const override
    {
        return qcBreakingWorld::stepSeconds;
    }
    bool Step(std::string* message) override;
    void Restart() override
    {
        MakeWorld();
    }
    void AddTo(qcDebugDraw* drawing) override
    {
        drawing->add(&m_world->MeshContact());
    }
    qcStepCosts Costs() const override
    {
        return m_step.costs;
    }
    std::vector<qcViewStatistic> Statistics() const override;
    std::vector<qcViewSetting> Settings() override;
    qcViewPlace Place() const override;

  private:
    void MakeWorld();

    const qcBreakingModel& m_model;
    qcMethod m_method;
    uint32_t m_threads;
    qcViewDevices m_devices;
    qcBreakingStep m_step;
    std::unique_ptr<qcBreakingWorld> m_world; ///< ends before the devices
};

#endif
