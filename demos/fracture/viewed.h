// The breaking body in the live window.
#ifndef QC_DEMOS_FRACTURE_VIEWED_H
#define QC_DEMOS_FRACTURE_VIEWED_H

#include "fracture/world.h"
#include "view/settings.h"

class qcViewedFracture : public qcViewedScene
{
  public:
    /// The model and the device must outlive this object.
    qcViewedFracture(const qcFractureModel& model, const qcFractureRequest& request, qcDevice* device);

    const char* Title() const override
    {
        return "A body breaks";
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world->Bullet();
    }
    double StepSeconds() const override
    {
        return qcFractureWorld::stepSeconds;
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

    const qcFractureModel& m_model;
    qcFractureRequest m_request;
    qcViewDevices m_devices;
    qcFractureStep m_step;
    double m_margin = 0;                      ///< of all meshes
    std::unique_ptr<qcFractureWorld> m_world; ///< ends before the devices
};

#endif
