// What a contestant's steps measured.
#ifndef QC_DEMOS_BENCH_PILES_MEASURE_H
#define QC_DEMOS_BENCH_PILES_MEASURE_H

#include "bench/piles/world.h"

#include <string>

/// Sums over the steps of a phase.
struct qcPilesPhase
{
    uint32_t steps = 0;
    double ms = 0, detectionMs = 0, points = 0;

    double Mean(double sum) const
    {
        return steps > 0 ? sum / steps : 0;
    }

    void Add(const qcPilesPhase& other)
    {
        steps += other.steps;
        ms += other.ms;
        detectionMs += other.detectionMs;
        points += other.points;
    }
};

/// Phases of a run.
enum qcPilesPhaseName
{
    qc_pilesFalling,  ///< the first third of the steps
    qc_pilesSettling, ///< the second
    qc_pilesRest,     ///< the last, no body sleeps
    qc_pilesAsleep,   ///< after these, all bodies sleep
    qc_pilesPhaseCount
};

/// Where the bodies of one start end.
struct qcPilesEnd
{
    double restSeconds = -1; ///< from here on no body is faster than 0.1 m/s; below 0: never
    double drift = 0;        ///< the longest way that a body's origin makes in the phase at rest, from end to end; m
};

struct qcPilesFigures
{
    const qcPilesSceneDef* scene = nullptr;
    qcPilesContestant contestant = qcPilesContestant::ours;
    size_t bodies = 0, triangles = 0;
    qcPilesPhase phases[qc_pilesPhaseCount]; ///< of all starts
    double longestMs = 0;
    /// Of the meshes' triangles, without margins, in each other and in the bin: the deepest point of an exact query's
    /// manifolds, each eighth step; m.
    double deepest = 0;
    double underGround = 0;          ///< depth of the lowest vertex under the ground, a plane, in the same steps; m
    size_t penetrating = 0;          ///< pairs of triangles, at the last of these queries
    std::vector<qcPilesEnd> ends{1}; ///< by start

    /// Adds those of other starts of this scene and contestant.
    void Add(const qcPilesFigures& other);
    /// Starts in which some body never comes to rest.
    size_t RestlessStarts() const;
    /// When the last of the other starts comes to rest; below 0: there is none.
    double RestSeconds() const;
    /// The mean of the starts.
    double Drift() const;
};

/// The exact depths of a scene's meshes, by a scene of the benchmark's own.
class qcPilesDepth
{
  public:
    explicit qcPilesDepth(const qcPilesSetup& setup);
    ~qcPilesDepth();
    qcPilesDepth(const qcPilesDepth&) = delete;
    qcPilesDepth& operator=(const qcPilesDepth&) = delete;

    /// Updates the depths and the penetrating pairs. False: the reason is in qcLastMessage.
    bool Measure(const qcPilesWorld& world, qcPilesFigures* figures);

  private:
    qcStatus AddMesh(const qcTriangles& mesh, bool isFixed, qcBodyId* id);

    const qcPilesSetup& m_setup;
    qcScene* m_scene = nullptr;
    std::vector<qcBodyId> m_ids;
    qcStatus m_status;
};

/// A contestant in a scene.
class qcPilesRun
{
  public:
    /// `steps`: without those asleep.
    qcPilesRun(const qcPilesSceneDef& def, const qcPilesSetup& setup, qcPilesContestant contestant, uint32_t steps,
               unsigned threads);

    /// Steps once, and measures. False with a message: a query failed.
    bool Step(std::string* message);
    /// Steps of the whole run.
    uint32_t Steps() const
    {
        return m_steps + asleepSteps;
    }
    const qcPilesFigures& Figures() const
    {
        return m_figures;
    }

    static constexpr uint32_t asleepSteps = 60;

  private:
    qcPilesPhaseName PhaseOf(uint32_t step) const;
    void TakePlaces(uint32_t step);

    uint32_t m_steps, m_taken = 0;
    qcPilesWorld m_world;
    qcPilesDepth m_depth;
    qcPilesFigures m_figures;
    std::vector<btVector3> m_places; ///< at the beginning of the phase at rest
};

#endif
