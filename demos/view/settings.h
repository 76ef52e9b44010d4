// Settings that most scenes have.
#ifndef QC_DEMOS_VIEW_SETTINGS_H
#define QC_DEMOS_VIEW_SETTINGS_H

#include "view/viewed_scene.h"

#include "quickcullide/bullet_soft_body.h"

#include <array>

/// `set` can't fail.
qcViewSetting qcNumberSetting(const char* label, double lowest, double highest, const char* format,
                              std::function<double()> get, std::function<void(double)> set);
qcViewSetting qcFlagSetting(const char* label, std::function<bool()> get, std::function<void(bool)> set);
/// Methods that never miss, but for brute force.
qcViewSetting qcMethodSetting(std::function<qcMethod()> get, std::function<void(qcMethod)> set);

/// The devices of this machine, opened when they are first chosen.
class qcViewDevices
{
  public:
    /// `first` is used at the beginning, and not closed.
    explicit qcViewDevices(qcDevice* first);
    ~qcViewDevices();
    qcViewDevices(const qcViewDevices&) = delete;
    qcViewDevices& operator=(const qcViewDevices&) = delete;

    qcDevice* Present() const
    {
        return m_present;
    }
    /// `changed` runs after another device was chosen. What uses a device must end before this object.
    qcViewSetting Setting(std::function<void()> changed);

  private:
    std::string Choose(qcDeviceKind kind);

    qcDevice *m_first, *m_present;
    std::array<qcDevice*, qc_deviceNone + 1> m_opened{};
};

/// What the statistics of soft bodies say.
std::vector<qcViewStatistic> qcSoftStatistics(const qcSoftBodyStatistics& statistics);

#endif
