// The bodies of a demo, queried by several methods side by side: the paper's, and those that never miss.
#ifndef QC_DEMOS_COMMON_BULLET_QUERY_COMPARISON_H
#define QC_DEMOS_COMMON_BULLET_QUERY_COMPARISON_H

#include "quickcullide/quickcullide.h"

#include <array>
#include <initializer_list>
#include <string>
#include <vector>

/// The queries, in the order of the table.
enum qcComparedQuery
{
    qc_queryCullide,
    qc_queryQuick,
    qc_queryQuickSorted,
    qc_queryQuickSortedBack,
    qc_querySweep,
    qc_queryAuto,
    qc_queryLayers,
    qc_queryCount
};

struct qcComparedQueryDef
{
    const char* label;  ///< in the table
    const char* column; ///< prefix of its columns in a CSV
    qcMethod method;
    bool backToFront, secondPassFromBack;
    bool neverMisses;
};

extern const std::array<qcComparedQueryDef, qc_queryCount> qcComparedQueries;

/// The result of one query on one state of the bodies.
struct qcQueryResult
{
    uint32_t pcs = 0; ///< triangles in the potentially colliding set
    double ms = 0;
    uint32_t resolution = 0; ///< pixels on a side; 0 without sampling
    bool ran = false;        ///< false: all else is 0
    bool byDevice = false;   ///< part of it ran on the device
    bool counted = false;    ///< `missed` is known
    /// Penetrating pairs that the query found, confirmed by the exact test, and pairs that only other queries found.
    size_t found = 0, missed = 0;
};

using qcQueryResults = std::array<qcQueryResult, qc_queryCount>;

/// Holds any number of bodies, rigid or deforming, and one scene for each query: no query reuses data of another. In
/// each step of a simulation: change the bodies, call RunEachStep; in steps to be compared also RunSampled, or Run for
/// single queries, and CountMissed. Functions that return bool return false with a Message() when a call failed.
class qcQueryComparison
{
  public:
    /// `request`: views, resolution and rounds of the sampled methods, threads of all. The device may be null.
    qcQueryComparison(qcDevice* device, const qcDetectDef& request);
    ~qcQueryComparison();
    qcQueryComparison(const qcQueryComparison&) = delete;
    qcQueryComparison& operator=(const qcQueryComparison&) = delete;

    /// Adds a body; all data is copied. `id` names it in this class only.
    bool Add(const qcBodyDef& def, qcBodyId* id);
    /// Removes a body. Results of queries that ran before still name its slot.
    bool Remove(qcBodyId id);
    /// Moves a rigid body.
    bool SetTransform(qcBodyId id, const qcTransform& transform);
    /// New positions of a deforming body: three floats for each vertex.
    bool SetVertices(qcBodyId id, const std::vector<float>& positions);
    bool SetActivity(qcBodyId id, qcActivity activity);
    /// Removes all bodies and begins anew.
    void Clear();

    /// Runs the methods that run in each step once: shaders are compiled and the planner is calibrated before the first
    /// step. Call it with bodies added.
    bool Warm();
    /// Records the bodies, all their changes and each run of `sweep` in a file, until Clear: a recording for `qc-bench
    /// paper`, which takes the views from it. Call it after Warm.
    bool Record(const std::string& path);
    /// Fills all of the result but `missed`.
    bool Run(qcComparedQuery query, qcQueryResult* result);
    /// Runs sweep, auto and layers. In each step, as in a simulation: their data persist from query to query, and a
    /// body that has moved far costs more time.
    bool RunEachStep(qcQueryResults* results);
    /// Runs the sampled methods: cullide and the three kinds of quick. Slow without a GPU.
    bool RunSampled(qcQueryResults* results);
    /// Fills `missed` for the queries that have run since the last change of a body: the pairs that another one of them
    /// found and this one did not. Also false if a method that never misses has missed.
    bool CountMissed(qcQueryResults* results);

    /// A flag for each triangle of a body: it is in the PCS of the last run of this query. Made on each call.
    std::vector<uint8_t> Marked(qcComparedQuery query, qcBodyId id) const;
    const std::string& Message() const
    {
        return m_message;
    }

  private:
    /// The present state of a body, for scenes that have not run since it changed.
    struct Body
    {
        qcBodyId id{}; ///< the same in all scenes; generation 0: the slot is free
        uint32_t triangleCount = 0, vertexCount = 0;
        uint64_t changed = 0; ///< number of its last change of geometry
        std::vector<float> positions;
        qcTransform transform{};
        bool deforming = false;
    };

    struct Queried
    {
        qcScene* scene = nullptr;
        uint64_t updated = 0;           ///< number of the last change that the scene has
        std::vector<qcPair> pairs;      ///< sorted
        std::vector<qcTriangleRef> pcs; ///< sorted
    };

    bool Fail(const std::string& message);
    bool Check(qcStatus status);
    bool CreateScenes();
    Body* Find(qcBodyId id);
    bool UpdateScene(Queried* queried);
    bool RunAll(std::initializer_list<qcComparedQuery> queries, qcQueryResults* results);

    qcDevice* m_device;
    qcDetectDef m_request;
    std::array<Queried, qc_queryCount> m_queried;
    std::vector<Body> m_bodies; ///< by slot
    uint64_t m_changes = 0;     ///< changes of all bodies so far
    std::string m_message;
};

#endif
