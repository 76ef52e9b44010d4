// Queries on qcMeshShape and on btBvhTriangleMeshShape in turns, with their results compared.
#ifndef QC_DEMOS_BENCH_QUERIES_MEASURE_H
#define QC_DEMOS_BENCH_QUERIES_MEASURE_H

#include "bench/queries/cases.h"

#include <memory>

namespace queries
{
struct Row
{
    uint32_t queries;    ///< in one round
    double ours, bullet; ///< microseconds a query, medians of the rounds
    double ratio;        ///< median of the rounds' ratios, ours / Bullet's
    double hits;         ///< hits, contact points or triangles a query, by ours
    /// Queries in which only one shape is hit, the hits are a millimetre or more apart, or their numbers differ.
    uint32_t differ;
    uint32_t lost; ///< queries among these in which ours has no hit, a hit behind Bullet's, or fewer
};

/// One kind of query in batches (qcCastRays, qcCastShape) in a world with a qcBroadphase. Microseconds a query.
struct BatchRow
{
    uint32_t queries;          ///< in a batch
    double single;             ///< one call for each
    std::vector<double> batch; ///< for each number of threads
    bool same;                 ///< hits of all batches are those of single calls
};

/// One mesh as both shapes, each in a collision world of its own.
class Comparison
{
  public:
    explicit Comparison(const Mesh& mesh);
    ~Comparison();

    double oursBuildMs() const; ///< creation and first query
    double bulletBuildMs() const;
    Row Measure(const Case& kind, double budgetMs);
    /// Only rays and spheres. `threads`: the numbers of threads to measure, in turns.
    BatchRow MeasureBatch(const Case& kind, const std::vector<uint32_t>& threads, double budgetMs);

  private:
    struct Implementation;
    std::unique_ptr<Implementation> m_implementation;
};
} // namespace queries

#endif
