// Records the calls of a broadphase (quickcullide/recording.h). Proxies are named by their unique ids.
#ifndef QC_GLUE_BROADPHASE_BROADPHASE_RECORDER_H
#define QC_GLUE_BROADPHASE_BROADPHASE_RECORDER_H

#include "broadphase/pair_cache_sync.h"

#include "quickcullide/recording.h"

#include <unordered_map>
#include <vector>

/// Without memory the recording ends, and the broadphase goes on.
class qcBroadphaseRecorder
{
  public:
    /// Recorded if QC_RECORD is set.
    qcBroadphaseRecorder();
    qcBroadphaseRecorder(const qcBroadphaseRecorder&) = delete;
    qcBroadphaseRecorder& operator=(const qcBroadphaseRecorder&) = delete;
    ~qcBroadphaseRecorder();

    /// Ends the recording that runs, and begins one with the present proxies unless `path` is null.
    qcStatus Start(const char* path, const qcProxySet& proxies);
    bool IsOn() const
    {
        return m_recorder != nullptr;
    }

    //  While it is on:
    void Add(const qcProxy* proxy);
    void Remove(const qcProxy* proxy);
    /// A box is set. A box that stays as it is counts only while an iteration runs: other moves of it may be pending.
    void Move(const qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax, bool isIterating);
    void Reset();
    /// A search for pairs. Its end does nothing if the recording has ended meanwhile; likewise below.
    void BeginPairs();
    void EndPairs(const qcPairCacheSync& sync);

    /// What a query reports: a list of its own for each, since queries run on several threads.
    struct Reported
    {
        std::vector<uint32_t> ids;
        std::vector<double> lambdas; ///< of casts

        /// Without memory the box is left out.
        void Add(uint32_t id, double lambda = 0.0);
    };
    /// A query, on any thread.
    void BeginQuery();
    void EndQuery(const btVector3& aabbMin, const btVector3& aabbMax, Reported& reported);
    void EndCast(const qcBoxCast& cast, const Reported& reported);

  private:
    void AddWithFilter(const qcProxy* proxy, uint64_t filter);
    void CompareFilter(const qcProxy* proxy, uint64_t filter);
    void FindChangedFilters(const qcProxySet& proxies);
    void Stop();

    struct Recorded
    {
        uint64_t filter;
        uint64_t search; ///< the last one that had begun when the proxy was added
    };

    qcBoxRecorder* m_recorder = nullptr;
    std::unordered_map<uint32_t, Recorded> m_proxies; ///< by unique id
    uint64_t m_search = 0;                            ///< number of the search that runs, or ran last
};

/// The cast that a call of rayTest describes, before it runs.
qcBoxCast qcBoxCastOf(const btVector3& rayFrom, const btVector3& rayTo, const btBroadphaseRayCallback& callback,
                      const btVector3& aabbMin, const btVector3& aabbMax);

#endif
