// Filters are compared where the broadphase reads them: Bullet's users write them into proxies.
#include "broadphase/broadphase_recorder.h"

#include <algorithm>
#include <new>

namespace
{
uint32_t IdOf(const btBroadphaseProxy* proxy)
{
    return uint32_t(proxy->m_uniqueId);
}

void Store(const btVector3& v, double* numbers)
{
    for (int k = 0; k < 3; k++)
        numbers[k] = double(v[k]);
}

qcBoxPair PairOf(const btBroadphaseProxy* a, const btBroadphaseProxy* b)
{
    return {std::min(IdOf(a), IdOf(b)), std::max(IdOf(a), IdOf(b))};
}

void Sort(std::vector<qcBoxPair>& pairs)
{
    std::sort(pairs.begin(), pairs.end(),
              [](const qcBoxPair& x, const qcBoxPair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
}

/// Runs code that allocates. False: out of memory.
template <class Code> bool Try(Code code)
{
    try
    {
        code();
        return true;
    }
    catch (const std::bad_alloc&)
    {
        return false;
    }
}
} // namespace

qcBroadphaseRecorder::qcBroadphaseRecorder()
{
    qcBoxRecorder_Open(nullptr, sizeof(btScalar), &m_recorder);
}

qcBroadphaseRecorder::~qcBroadphaseRecorder()
{
    qcBoxRecorder_Close(m_recorder);
}

qcStatus qcBroadphaseRecorder::Start(const char* path, const qcProxySet& proxies)
{
    qcStatus status = qcBoxRecorder_Close(m_recorder);
    m_recorder = nullptr;
    m_proxies.clear();
    if (path == nullptr)
        return status;
    status = qcBoxRecorder_Open(path, sizeof(btScalar), &m_recorder);
    for (int i = 0; i < proxies.GetCount() && IsOn(); i++)
        AddWithFilter(proxies.At(i), proxies.FilterAt(i));
    return status;
}

void qcBroadphaseRecorder::Stop()
{
    qcBoxRecorder_Close(m_recorder);
    m_recorder = nullptr;
    m_proxies.clear();
}

//  ---- changes ---------------------------------------------------------------------------------------

void qcBroadphaseRecorder::AddWithFilter(const qcProxy* proxy, uint64_t filter)
{
    double bounds[6];
    Store(proxy->m_aabbMin, bounds);
    Store(proxy->m_aabbMax, bounds + 3);
    if (!Try([&] { m_proxies[IdOf(proxy)] = {filter, m_search}; }))
    {
        Stop();
        return;
    }
    qcBoxRecorder_Add(m_recorder, IdOf(proxy), bounds, uint32_t(filter), uint32_t(filter >> 32));
}

void qcBroadphaseRecorder::Add(const qcProxy* proxy)
{
    AddWithFilter(proxy, qcFilterOf(proxy));
}

void qcBroadphaseRecorder::Remove(const qcProxy* proxy)
{
    m_proxies.erase(IdOf(proxy));
    qcBoxRecorder_Remove(m_recorder, IdOf(proxy));
}

void qcBroadphaseRecorder::CompareFilter(const qcProxy* proxy, uint64_t filter)
{
    auto recorded = m_proxies.find(IdOf(proxy));
    if (recorded == m_proxies.end() || recorded->second.filter == filter)
        return;
    recorded->second.filter = filter;
    qcBoxRecorder_SetFilter(m_recorder, IdOf(proxy), uint32_t(filter), uint32_t(filter >> 32));
}

void qcBroadphaseRecorder::Move(const qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                                bool isIterating)
{
    // The broadphase may read the filter here, and no more in this step: a replay has to find it.
    if (!isIterating)
        CompareFilter(proxy, qcFilterOf(proxy));
    if (!isIterating && qcAreSame(aabbMin, proxy->m_aabbMin) && qcAreSame(aabbMax, proxy->m_aabbMax))
        return;
    double bounds[6];
    Store(aabbMin, bounds);
    Store(aabbMax, bounds + 3);
    qcBoxRecorder_Move(m_recorder, IdOf(proxy), bounds);
}

void qcBroadphaseRecorder::Reset()
{
    qcBoxRecorder_Reset(m_recorder);
}

//  ---- queries ---------------------------------------------------------------------------------------

void qcBroadphaseRecorder::BeginPairs()
{
    qcBoxRecorder_Begin(m_recorder);
    m_search++;
}

void qcBroadphaseRecorder::BeginQuery()
{
    qcBoxRecorder_Begin(m_recorder);
}

/// The filters that the search has used. Proxies that a callback created meanwhile are recorded behind it.
void qcBroadphaseRecorder::FindChangedFilters(const qcProxySet& proxies)
{
    for (int i = 0; i < proxies.GetCount(); i++)
    {
        const qcProxy* proxy = proxies.At(i);
        auto recorded = m_proxies.find(IdOf(proxy));
        if (recorded != m_proxies.end() && recorded->second.search < m_search)
            CompareFilter(proxy, proxies.FilterAt(i));
    }
}

void qcBroadphaseRecorder::EndPairs(const qcPairCacheSync& sync)
{
    if (!IsOn())
        return;
    FindChangedFilters(sync.GetProxies());
    std::vector<qcBoxPair> pairs, rejected;
    auto collect = [&]
    {
        const btBroadphasePair* cached = sync.GetCache()->getOverlappingPairArrayPtr();
        for (int i = 0; i < sync.GetCache()->getNumOverlappingPairs(); i++)
            pairs.push_back(PairOf(cached[i].m_pProxy0, cached[i].m_pProxy1));
        sync.VisitRejected([&](const qcProxy* a, const qcProxy* b) { rejected.push_back(PairOf(a, b)); });
    };
    if (!Try(collect))
    {
        Stop();
        return;
    }
    Sort(pairs);
    Sort(rejected);
    qcBoxRecorder_EndPairs(m_recorder, pairs.data(), pairs.size(), sync.HasFilterCallback(), rejected.data(),
                           rejected.size());
}

void qcBroadphaseRecorder::Reported::Add(uint32_t id, double lambda)
{
    if (Try([&] { lambdas.push_back(lambda); }) && !Try([&] { ids.push_back(id); }))
        lambdas.pop_back();
}

void qcBroadphaseRecorder::EndQuery(const btVector3& aabbMin, const btVector3& aabbMax, Reported& reported)
{
    if (!IsOn())
        return;
    double bounds[6];
    Store(aabbMin, bounds);
    Store(aabbMax, bounds + 3);
    std::sort(reported.ids.begin(), reported.ids.end());
    qcBoxRecorder_EndQuery(m_recorder, bounds, reported.ids.data(), reported.ids.size());
}

qcBoxCast qcBoxCastOf(const btVector3& rayFrom, const btVector3& rayTo, const btBroadphaseRayCallback& callback,
                      const btVector3& aabbMin, const btVector3& aabbMax)
{
    qcBoxCast cast;
    Store(rayFrom, cast.from);
    Store(rayTo, cast.to);
    Store(aabbMin, cast.bounds);
    Store(aabbMax, cast.bounds + 3);
    Store(callback.m_rayDirectionInverse, cast.directionInverse);
    cast.lambda = double(callback.m_lambda_max);
    return cast;
}

void qcBroadphaseRecorder::EndCast(const qcBoxCast& cast, const Reported& reported)
{
    if (IsOn())
        qcBoxRecorder_EndCast(m_recorder, &cast, reported.ids.data(), reported.lambdas.data(), reported.ids.size());
}
