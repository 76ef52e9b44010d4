// What a long run measured: rows for the plot, and the figures that are judged.
#ifndef QC_DEMOS_BENCH_STABILITY_HISTORY_H
#define QC_DEMOS_BENCH_STABILITY_HISTORY_H

#include "bench/stability/scenes.h"
#include "bench/stability/world_measure.h"
#include "bench/stability/world_support.h"

#include <string>
#include <vector>

/// The state at the end of a step, and maxima of the steps since the row before.
struct qcStabilityRow
{
    uint32_t step = 0;
    qcWorldMeasure world; ///< `contacts` and `depth`: maxima
    double ms = 0;        ///< mean of a step
    /// Pairs that penetrate at the end of a step, by the library's statistics: maximum; -1: no soft bodies.
    int remaining = -1;
    qcPenetratingPairs pairs; ///< by the exact test
    qcWorldSupport support;
    size_t bytes = 0;    ///< held by the library
    size_t resident = 0; ///< of the process, bytes
};

class qcStabilityHistory
{
  public:
    /// `steps`: of the whole run; five hundred rows are kept.
    qcStabilityHistory(const qcStabilitySceneDef& def, uint32_t steps);

    /// Takes the scene's state after its next step, which took `ms`. False with a message: a query failed.
    bool Take(qcStabilityScene& scene, double ms, std::string* message);

    /// Each reason why the run is not stable; none: it is.
    std::vector<std::string> Complaints() const;

    const qcStabilitySceneDef& Def() const
    {
        return m_def;
    }
    const std::vector<qcStabilityRow>& Rows() const
    {
        return m_rows;
    }
    uint32_t Steps() const
    {
        return m_taken;
    }
    double Seconds(uint32_t step) const
    {
        return step * m_def.stepSeconds;
    }
    /// From this step on the scene is at rest.
    uint32_t SettledStep() const
    {
        return m_settledStep;
    }
    /// False: the run ended before its energy at rest could be judged.
    bool IsSettled() const
    {
        return m_taken > m_settledStep;
    }
    /// Energy given off from the first step to the lowest state, J.
    double Released() const
    {
        return m_first.energy - m_lowestEver;
    }
    /// The largest rise of energy above a state since the scene settled, J; and the height by which it would lift the
    /// whole scene, m.
    double Growth() const
    {
        return m_growth;
    }
    double Lift() const;
    double DeepestEver() const
    {
        return m_deepest[0] > m_deepest[1] ? m_deepest[0] : m_deepest[1];
    }
    double DeepestSettled() const
    {
        return m_deepest[1];
    }

    /// Memory in the second and in the last quarter of the run, maxima, bytes.
    struct Memory
    {
        size_t early = 0, late = 0;
    };
    Memory Bytes() const;
    Memory Resident() const;

  private:
    Memory Compare(size_t qcStabilityRow::*member) const;

    const qcStabilitySceneDef& m_def;
    uint32_t m_steps, m_interval, m_settledStep, m_taken = 0;
    bool m_isFinite = true;
    uint32_t m_notFiniteStep = 0;
    qcWorldMeasure m_first;
    double m_lowestEver = 0;
    double m_lowest = 0; ///< energy since the scene settled
    double m_growth = 0;
    double m_deepest[2] = {0, 0}; ///< before the scene settled, and since
    double m_sumMs = 0;
    qcStabilityRow m_row; ///< the next
    std::vector<qcStabilityRow> m_rows;
};

#endif
