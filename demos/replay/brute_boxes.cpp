// The oracle: no tree, no cache, no order.
#include "replay/box_replay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace
{
struct Box
{
    std::array<double, 6> bounds;
    uint32_t group, mask;
};

/// TestAabbAgainstAabb2, where a comparison with NaN is false.
bool Overlap(const double* a, const double* b)
{
    for (int k = 0; k < 3; k++)
        if (a[k] > b[k + 3] || a[k + 3] < b[k])
            return false;
    return true;
}

bool IsLess(const qcBoxPair& x, const qcBoxPair& y)
{
    return x.a != y.a ? x.a < y.a : x.b < y.b;
}

/// The fraction of the path that a cast must search; negative: the recording leaves it open.
double SearchedFraction(const qcBoxOperation& operation)
{
    const qcBoxCast& cast = operation.cast;
    double last = operation.count != 0 ? operation.lambdas[operation.count - 1] : cast.lambda;
    if (!(last < cast.lambda))
        return 1.0;
    // The callback's own path has to be that from start to end.
    for (int k = 0; k < 3; k++)
    {
        double along = cast.to[k] - cast.from[k];
        double own = std::fabs(cast.directionInverse[k]) >= 1e18 ? 0.0 : cast.lambda / cast.directionInverse[k];
        if (!(std::fabs(along - own) <= 1e-3 * cast.lambda))
            return -1.0;
    }
    return 0.999 * last / cast.lambda;
}

/// Whether the moving box hits `bounds`, both a little smaller than they are.
bool Hits(const qcBoxCast& cast, const double* bounds, double fraction)
{
    double enter = 0.0, leave = fraction;
    for (int k = 0; k < 3; k++)
    {
        double lower = bounds[k] - cast.bounds[k + 3] - cast.from[k],
               upper = bounds[k + 3] - cast.bounds[k] - cast.from[k];
        double along = cast.to[k] - cast.from[k],
               slack = 1e-5 * (std::fabs(lower) + std::fabs(upper) + std::fabs(along));
        lower += slack;
        upper -= slack;
        if (!(lower <= upper))
            return false;
        if (along == 0.0)
        {
            if (lower > 0.0 || upper < 0.0)
                return false;
            continue;
        }
        double a = lower / along, b = upper / along;
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter <= leave;
}

class BruteBoxReplay : public qcBoxReplay
{
  public:
    void Add(uint32_t id, const double* bounds, uint32_t group, uint32_t mask) override
    {
        Box& box = m_boxes[id];
        std::copy(bounds, bounds + 6, box.bounds.begin());
        box.group = group;
        box.mask = mask;
    }
    void Remove(uint32_t id) override
    {
        m_boxes.erase(id);
    }
    void Move(uint32_t id, const double* bounds) override
    {
        std::copy(bounds, bounds + 6, m_boxes[id].bounds.begin());
    }
    void SetFilter(uint32_t id, uint32_t group, uint32_t mask) override
    {
        m_boxes[id].group = group;
        m_boxes[id].mask = mask;
    }
    void Reset() override
    {
        m_boxes.clear();
    }

    std::vector<qcBoxPair> FindPairs(const qcBoxOperation& search) override
    {
        const qcBoxPair *rejected = search.rejected, *end = rejected + search.rejectedCount;
        std::vector<qcBoxPair> pairs;
        for (auto a = m_boxes.begin(); a != m_boxes.end(); ++a)
            for (auto b = std::next(a); b != m_boxes.end(); ++b)
            {
                const qcBoxPair pair = {a->first, b->first};
                const Box &x = a->second, &y = b->second;
                if (Overlap(x.bounds.data(), y.bounds.data()) &&
                    (search.hasCallback ? !std::binary_search(rejected, end, pair, IsLess)
                                        : (x.group & y.mask) != 0 && (y.group & x.mask) != 0))
                    pairs.push_back(pair);
            }
        return pairs;
    }

    std::vector<uint32_t> Query(const double* bounds) override
    {
        std::vector<uint32_t> ids;
        for (const auto& [id, box] : m_boxes)
            if (Overlap(box.bounds.data(), bounds))
                ids.push_back(id);
        return ids;
    }

    std::vector<uint32_t> Cast(const qcBoxOperation& cast) override
    {
        double fraction = SearchedFraction(cast);
        std::vector<uint32_t> ids;
        for (const auto& [id, box] : m_boxes)
            if (fraction >= 0.0 && Hits(cast.cast, box.bounds.data(), fraction))
                ids.push_back(id);
        return ids;
    }

  private:
    std::map<uint32_t, Box> m_boxes; ///< ordered by id, so that pairs are sorted
};
} // namespace

std::unique_ptr<qcBoxReplay> qcMakeBruteBoxReplay()
{
    return std::make_unique<BruteBoxReplay>();
}
