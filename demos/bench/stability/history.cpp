// Collects the state of each step, and judges the run.
#include "bench/stability/history.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <unistd.h>

namespace
{
constexpr uint32_t s_rows = 500;
// Heights in metres: what a scene at rest may gain is less than lifting it by a millimetre.
constexpr double s_maxLift = 1e-3, s_gravity = 9.81;
// Growth of the library's memory, which follows the number of contacts, and of the process.
constexpr double s_bytesFactor = 1.1, s_residentFactor = 1.02;
constexpr size_t s_bytesSlack = 64 * 1024, s_residentSlack = 1024 * 1024;

/// Bytes; 0 where /proc is missing.
size_t ResidentBytes()
{
    FILE* stream = std::fopen("/proc/self/statm", "r");
    unsigned long total = 0, resident = 0;
    if (stream == nullptr)
        return 0;
    if (std::fscanf(stream, "%lu %lu", &total, &resident) != 2)
        resident = 0;
    std::fclose(stream);
    return resident * size_t(sysconf(_SC_PAGESIZE));
}

template <class... Values> std::string Text(const char* format, Values... values)
{
    char text[256];
    std::snprintf(text, sizeof text, format, values...);
    return text;
}
} // namespace

qcStabilityHistory::qcStabilityHistory(const qcStabilitySceneDef& def, uint32_t steps)
    : m_def(def), m_steps(steps), m_interval(std::max(1u, steps / s_rows)),
      m_settledStep(uint32_t(std::lround(def.settledSeconds / def.stepSeconds)))
{
}

bool qcStabilityHistory::Take(qcStabilityScene& scene, double ms, std::string* message)
{
    qcWorldMeasure now = qcMeasureWorld(scene.World());
    m_taken++;
    if (m_isFinite && !std::isfinite(now.energy))
    {
        m_isFinite = false;
        m_notFiniteStep = m_taken;
    }
    if (m_taken == 1)
    {
        m_first = now;
        m_lowestEver = now.energy;
    }
    bool isSettled = m_taken >= m_settledStep;
    m_lowestEver = std::min(m_lowestEver, now.energy);
    m_lowest = m_taken <= m_settledStep ? now.energy : std::min(m_lowest, now.energy);
    if (isSettled)
        m_growth = std::max(m_growth, now.energy - m_lowest);
    m_deepest[isSettled] = std::max(m_deepest[isSettled], now.depth);

    now.contacts = std::max(now.contacts, m_row.world.contacts);
    now.depth = std::max(now.depth, m_row.world.depth);
    m_row.world = now;
    if (scene.SoftStatistics() != nullptr)
        m_row.remaining = std::max(m_row.remaining, scene.SoftStatistics()->remaining);
    m_sumMs += ms;
    if (m_taken % m_interval != 0 && m_taken != m_steps)
        return true;

    uint32_t before = m_rows.empty() ? 0 : m_rows.back().step;
    m_row.step = m_taken;
    m_row.ms = m_sumMs / (m_taken - before);
    m_row.bytes = qcGetByteCount();
    m_row.resident = ResidentBytes();
    m_row.support = qcMeasureSupport(scene.World());
    // A scene whose positions are not finite can't be queried.
    if (m_isFinite && !qcCountPenetrating(scene.World(), m_def.selfCollision, &m_row.pairs))
    {
        *message = qcLastMessage();
        return false;
    }
    m_rows.push_back(m_row);
    m_row = qcStabilityRow();
    m_sumMs = 0;
    return true;
}

double qcStabilityHistory::Lift() const
{
    return IsSettled() && m_first.mass > 0 ? m_growth / (m_first.mass * s_gravity) : 0;
}

qcStabilityHistory::Memory qcStabilityHistory::Compare(size_t qcStabilityRow::*member) const
{
    Memory memory;
    size_t count = m_rows.size();
    for (size_t i = count / 4; i < count; i++)
    {
        if (i < count / 2)
            memory.early = std::max(memory.early, m_rows[i].*member);
        else if (i >= count - count / 4)
            memory.late = std::max(memory.late, m_rows[i].*member);
    }
    return memory;
}

qcStabilityHistory::Memory qcStabilityHistory::Bytes() const
{
    return Compare(&qcStabilityRow::bytes);
}

qcStabilityHistory::Memory qcStabilityHistory::Resident() const
{
    return Compare(&qcStabilityRow::resident);
}

std::vector<std::string> qcStabilityHistory::Complaints() const
{
    std::vector<std::string> complaints;
    if (!m_isFinite)
        complaints.push_back(Text("the energy is not finite from step %u on", m_notFiniteStep));
    else if (m_def.driven == nullptr && Lift() > s_maxLift)
        complaints.push_back(Text("energy grew by %.3g J, enough to lift the scene by %.3g mm (at most %.0f)", m_growth,
                                  1e3 * Lift(), 1e3 * s_maxLift));
    if (!m_rows.empty() && m_rows.back().pairs.all > 0)
        complaints.push_back(Text("%zu pairs of triangles penetrate at the end", m_rows.back().pairs.all));
    for (const qcStabilityRow& row : m_rows)
        if (row.remaining >= 0 && row.pairs.soft > size_t(row.remaining))
        {
            complaints.push_back(Text("step %u: %zu pairs of soft bodies penetrate, the library reports %d", row.step,
                                      row.pairs.soft, row.remaining));
            break;
        }
    Memory bytes = Bytes(), resident = Resident();
    if (double(bytes.late) > s_bytesFactor * double(bytes.early) + double(s_bytesSlack))
        complaints.push_back(Text("the library's memory grew from %zu to %zu bytes", bytes.early, bytes.late));
    if (double(resident.late) > s_residentFactor * double(resident.early) + double(s_residentSlack))
        complaints.push_back(Text("the process grew from %zu to %zu bytes", resident.early, resident.late));
    return complaints;
}
