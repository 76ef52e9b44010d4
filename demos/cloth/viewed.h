// The cloth in the live window.
#ifndef QC_DEMOS_CLOTH_VIEWED_H
#define QC_DEMOS_CLOTH_VIEWED_H

#include "cloth/world.h"
#include "view/settings.h"

#include <memory>

class qcViewedCloth : public qcViewedScene
{
  public:
    qcViewedCloth(unsigned triangleCount, qcDevice* device, qcMethod method, unsigned threads);

    const char* Title() const override
    {
        return "Cloth over a table";
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world->Bullet();
    }
    double StepSeconds() const override
    {
        return qcClothWorld::stepSeconds;
    }
    bool Step(std::string* message) override;
    void Restart() override;
    void AddTo(qcDebugDraw* drawing) override
    {
        drawing->add(&m_world->SoftSolver());
    }
    qcStepCosts Costs() const override
    {
        return m_costs;
    }
    std::vector<qcViewStatistic> Statistics() const override
    {
        return qcSoftStatistics(m_world->Statistics());
    }
    std::vector<qcViewSetting> Settings() override;
    std::string NameOf(const btCollisionObject* object) const override;
    bool ColorsOf(const btCollisionObject* object, qcViewColors* colors) const override;
    qcViewPlace Place() const override;

  private:
    void Apply();
    void ChangeDevice();

    unsigned m_triangleCount, m_threads;
    qcMethod m_method;
    qcViewDevices m_devices;
    qcSoftBodySettings m_settings;
    btScalar m_margin = 0;   ///< of cloth and table
    bool m_isPulled = false; ///< the second act has begun
    qcStepCosts m_costs;
    std::unique_ptr<qcClothWorld> m_world; ///< ends before the devices
};

#endif
