// Settings that most scenes have.
#include "view/settings.h"

namespace
{
constexpr qcMethod s_methods[] = {qc_methodAuto, qc_methodSweep, qc_methodLayers};
const char* const s_deviceNames[] = {"egl (GPU)", "osmesa", "surfaceless", "none (CPU)"};
} // namespace

qcViewSetting qcNumberSetting(const char* label, double lowest, double highest, const char* format,
                              std::function<double()> get, std::function<void(double)> set)
{
    qcViewSetting setting;
    setting.label = label;
    setting.lowest = lowest;
    setting.highest = highest;
    setting.format = format;
    setting.get = std::move(get);
    setting.set = [set = std::move(set)](double value)
    {
        set(value);
        return std::string();
    };
    return setting;
}

qcViewSetting qcFlagSetting(const char* label, std::function<bool()> get, std::function<void(bool)> set)
{
    qcViewSetting setting = qcNumberSetting(
        label, 0, 1, "%.0f", [get = std::move(get)] { return double(get()); },
        [set = std::move(set)](double value) { set(value > 0.5); });
    setting.choices = {"off", "on"};
    return setting;
}

qcViewSetting qcMethodSetting(std::function<qcMethod()> get, std::function<void(qcMethod)> set)
{
    qcViewSetting setting = qcNumberSetting(
        "method", 0, 2, "%.0f",
        [get = std::move(get)]
        {
            size_t i = 0;
            while (i + 1 < std::size(s_methods) && s_methods[i] != get())
                i++;
            return double(i);
        },
        [set = std::move(set)](double value) { set(s_methods[size_t(value)]); });
    for (qcMethod method : s_methods)
        setting.choices.push_back(qcMethod_Name(method));
    return setting;
}

qcViewDevices::qcViewDevices(qcDevice* first) : m_first(first), m_present(first)
{
}

qcViewDevices::~qcViewDevices()
{
    for (qcDevice* device : m_opened)
        qcDevice_Destroy(device);
}

/// Returns a message if the device does not open.
std::string qcViewDevices::Choose(qcDeviceKind kind)
{
    qcDeviceInfo info;
    qcDevice*& opened = m_opened[kind];
    qcDevice_GetInfo(m_first, &info);
    if (info.kind != kind && opened == nullptr)
    {
        qcDeviceDef def = qcDefaultDeviceDef();
        def.kind = kind;
        if (qcDevice_Create(&def, &opened) != qc_statusOk)
            return qcLastMessage();
    }
    m_present = info.kind == kind ? m_first : opened;
    return {};
}

qcViewSetting qcViewDevices::Setting(std::function<void()> changed)
{
    qcViewSetting setting;
    setting.label = "device";
    setting.choices.assign(std::begin(s_deviceNames), std::end(s_deviceNames));
    setting.get = [this]
    {
        qcDeviceInfo info;
        qcDevice_GetInfo(m_present, &info);
        return double(info.kind - qc_deviceEgl);
    };
    setting.set = [this, changed = std::move(changed)](double value)
    {
        std::string message = Choose(qcDeviceKind(int(value) + qc_deviceEgl));
        if (message.empty())
            changed();
        return message;
    };
    return setting;
}

std::vector<qcViewStatistic> qcSoftStatistics(const qcSoftBodyStatistics& s)
{
    std::string by = qcMethod_Name(s.method);
    if (s.method == qc_methodLayers)
        by += std::string(" on ") + s.device;
    return {{"queries by", by},
            {"contacts", std::to_string(s.contacts)},
            {"rounds", std::to_string(s.rounds)},
            {"planes, nodes in zones", std::to_string(s.planes) + ", " + std::to_string(s.zoneNodes)},
            {"penetrating at the end", std::to_string(s.remaining)},
            {"unproven", std::to_string(s.unproven)}};
}
