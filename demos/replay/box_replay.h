// What replays the operations of a broadphase. Boxes have the recording's ids.
#ifndef QC_DEMOS_REPLAY_BOX_REPLAY_H
#define QC_DEMOS_REPLAY_BOX_REPLAY_H

#include <quickcullide/recording.h>

#include <memory>
#include <vector>

class qcBoxReplay
{
  public:
    virtual ~qcBoxReplay() = default;
    virtual void Add(uint32_t id, const double* bounds, uint32_t group, uint32_t mask) = 0;
    virtual void Remove(uint32_t id) = 0;
    virtual void Move(uint32_t id, const double* bounds) = 0;
    virtual void SetFilter(uint32_t id, uint32_t group, uint32_t mask) = 0;
    virtual void Reset() = 0;
    /// All pairs that overlap and whose filters agree, sorted.
    virtual std::vector<qcBoxPair> FindPairs(const qcBoxOperation& search) = 0;
    /// The boxes that overlap the query's, sorted.
    virtual std::vector<uint32_t> Query(const double* bounds) = 0;
    /// The boxes that a cast reports, in this order, if the callback shortens it as recorded.
    virtual std::vector<uint32_t> Cast(const qcBoxOperation& cast) = 0;
};

/// Every pair of boxes is compared, as TestAabbAgainstAabb2 does. A cast reports boxes that are hit for certain.
std::unique_ptr<qcBoxReplay> qcMakeBruteBoxReplay();
/// A qcBroadphase, with numbers of `scalarSize` bytes. Null: this program has none of that kind.
std::unique_ptr<qcBoxReplay> qcMakeBroadphaseReplay(uint32_t scalarSize);

#endif
