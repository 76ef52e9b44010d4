// Penetrating pairs of triangles at exact times of a step, counted by a scene of its own, independently of the world's
// contact.
//
// Vertices move along straight lines from the stored positions at the start of a step to those at its end. The pairs
// are exact for the positions (1 - t) X + t Y rounded to double: at the times used, k/32, the products have no
// rounding, and for floats the sum has none either unless X and Y differ by more than a factor of 2^24.
#ifndef QC_DEMOS_BENCH_THROUGH_ORACLE_H
#define QC_DEMOS_BENCH_THROUGH_ORACLE_H

#include "bench/through/world.h"

#include <array>
#include <vector>

/// Pairs without a common vertex that penetrate in a step. A pair that penetrates at the start of the step counts as
/// tangled only.
struct qcThroughPairs
{
    size_t ends = 0;    ///< at the end of the step
    size_t inside = 0;  ///< at t = 1/32, 3/32 .. 31/32: a pair counts once a time
    size_t tangled = 0; ///< at the start of the step
    size_t atEnd = 0;   ///< at the end of the step, those of its start included
    /// Disjoint at the start, and not proven apart until the end by the library's motion query, which the oracle runs
    /// on its own positions; 0 where the library has no such query.
    size_t uncertified = 0;
    /// A pair that penetrates inside the step or at its end: body, triangle, body, triangle; bodies in the order in
    /// which they were added to the world.
    std::array<uint32_t, 4> example{};
};

class qcThroughOracle
{
  public:
    static constexpr int samples = 16;

    /// `brute`: every pair is tested; otherwise `sweep` finds the candidates, which is exact too, and much faster.
    qcThroughOracle(const qcThroughWorld& world, bool brute);
    ~qcThroughOracle();
    qcThroughOracle(const qcThroughOracle&) = delete;
    qcThroughOracle& operator=(const qcThroughOracle&) = delete;

    /// The pairs of the step that has led to the world's present positions. False: the reason is in qcLastMessage.
    bool Step(qcThroughPairs* pairs);

  private:
    using Pair = std::array<uint32_t, 4>;

    struct Body
    {
        const qcThroughBody* body;
        qcBodyId id{};
        std::vector<double> start, end, now;
    };

    void Read(const qcThroughBody& body, std::vector<double>* positions) const;
    bool Move(int time);
    bool Detect(std::vector<Pair>* pairs);
    bool CountUncertified(qcThroughPairs* pairs);

    qcScene* m_scene = nullptr;
    qcDetectDef m_def;
    std::vector<Body> m_bodies;
    std::vector<Pair> m_tangled; ///< at the start of the step, sorted
    bool m_isOk = true;
};

#endif
