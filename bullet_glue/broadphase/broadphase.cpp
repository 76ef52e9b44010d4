// The proxies of a Bullet world as a qcBoxes, and the questions to it.
//
// Boxes: a proxy's box in the set has NaN bounds opened to infinity and inverted ones put in order. It then meets
// every box that TestAabbAgainstAabb2 lets the proxy meet: a comparison with NaN is never true there, and two boxes of
// which one is inverted overlap there only if the other one holds it. So the set's answer is filtered by
// TestAabbAgainstAabb2.
#include "broadphase/proxy.h"

#include "common/object_key.h"

#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <new>

namespace
{
/// Returns false if the bounds are NaN or inverted somewhere.
bool Order(const btVector3& aabbMin, const btVector3& aabbMax, double lower[3], double upper[3])
{
    bool ordered = true;
    for (int k = 0; k < 3; k++)
    {
        lower[k] = double(aabbMin[k]);
        upper[k] = double(aabbMax[k]);
        ordered = ordered && lower[k] <= upper[k];
    }
    for (int k = 0; k < 3 && !ordered; k++)
    {
        if (std::isnan(lower[k]))
            lower[k] = -std::numeric_limits<double>::infinity();
        if (std::isnan(upper[k]))
            upper[k] = std::numeric_limits<double>::infinity();
        if (lower[k] > upper[k])
            std::swap(lower[k], upper[k]);
    }
    return ordered;
}

bool IsFinite(const btVector3& point)
{
    return std::isfinite(point.x()) && std::isfinite(point.y()) && std::isfinite(point.z());
}

/// What rayTest is asked for: from here to there, with these extents.
struct Way
{
    double from[3], to[3], castLower[3], castUpper[3];
};

/// Bullet's tree goes along the callback's direction to its largest lambda and ignores rayTo; others do the reverse.
/// The longer of the two ways, swept by the largest difference between the two, contains both.
Way MakeWay(const btVector3& rayFrom, const btVector3& rayTo, const btBroadphaseRayCallback& callback,
            const btVector3& aabbMin, const btVector3& aabbMax)
{
    Way way;
    double far[3], near[3], farLength = 0, nearLength = 0, along = 0;
    for (int k = 0; k < 3; k++)
    {
        way.from[k] = double(rayFrom[k]);
        way.to[k] = double(rayTo[k]);
        way.castLower[k] = double(aabbMin[k]);
        way.castUpper[k] = double(aabbMax[k]);
        double inverse = double(callback.m_rayDirectionInverse[k]);
        double direction = std::fabs(inverse) >= double(BT_LARGE_FLOAT) ? 0.0 : 1.0 / inverse;
        near[k] = way.to[k] - way.from[k];
        far[k] = direction * double(callback.m_lambda_max);
        nearLength += near[k] * near[k];
        farLength += far[k] * far[k];
    }
    if (!std::isfinite(farLength) || !std::isfinite(nearLength))
        return way;
    if (nearLength > farLength)
    {
        std::swap(near, far);
        std::swap(nearLength, farLength);
    }
    for (int k = 0; k < 3; k++)
        along += near[k] * far[k];
    double share = farLength > 0 ? std::min(std::max(along / farLength, 0.0), 1.0) : 0.0;
    for (int k = 0; k < 3; k++)
    {
        // The second term is for the rounding of the first, and of the new end.
        double apart = std::fabs(near[k] - share * far[k]) +
                       1e-15 * (std::fabs(way.from[k]) + std::fabs(near[k]) + std::fabs(far[k]));
        way.to[k] = way.from[k] + far[k];
        way.castLower[k] -= apart;
        way.castUpper[k] += apart;
    }
    return way;
}
} // namespace

//  ---- proxies ---------------------------------------------------------------------------------------

/// Half as much again. Returns false if there is no memory.
bool qcBroadphase::MakeRoom()
{
    const int perBlock = int(Block::c_roomCount), blockCount = 1 + m_roomCount / perBlock / 2;
    const int roomCount = m_roomCount + blockCount * perBlock;
    Block* blocks = static_cast<Block*>(btAlignedAlloc(sizeof(Block) * size_t(blockCount), alignof(Block)));
    Listed* proxies = static_cast<Listed*>(btAlignedAlloc(sizeof(Listed) * size_t(roomCount), alignof(Listed)));
    if (blocks == nullptr || proxies == nullptr)
    {
        btAlignedFree(blocks);
        btAlignedFree(proxies);
        return false;
    }
    std::copy(m_proxies, m_proxies + m_proxyCount, proxies);
    btAlignedFree(m_proxies);
    m_proxies = proxies;
    blocks->next = m_blocks;
    m_blocks = blocks;
    m_roomCount = roomCount;
    // The first one on top, so that proxies which are made one after the other lie that way.
    for (int i = blockCount * perBlock; i-- > 0;)
    {
        Room* room = new (blocks[i / perBlock].rooms + sizeof(Room) * size_t(i % perBlock)) Room;
        room->next = m_rooms;
        m_rooms = room;
    }
    return true;
}

/// Puts a proxy into the list and into the set, if there is room.
void qcBroadphase::List(Proxy* proxy)
{
    proxy->state().place = m_proxyCount;
    m_proxies[m_proxyCount++] = {proxy, FilterOf(proxy)};
    m_outsideCount++;
    m_anythingTouched = true;
    AddBox(proxy);
}

void qcBroadphase::AddBox(Proxy* proxy)
{
    double lower[3], upper[3];
    SetOdd(proxy, !Order(proxy->m_aabbMin, proxy->m_aabbMax, lower, upper));
    qcStatus status = m_boxes != nullptr ? qc_statusOk : qcBoxes_Create(&m_boxes);
    if (status == qc_statusOk)
        status = qcBoxes_Add(m_boxes, lower, upper, proxy, &proxy->state().box);
    if (status == qc_statusOk)
        m_outsideCount--;
    else
        m_status = status;
}

void qcBroadphase::SetOdd(Proxy* proxy, bool odd)
{
    m_oddCount += int(odd) - int(proxy->state().odd);
    proxy->state().odd = odd;
}

void qcBroadphase::Free(Proxy* proxy)
{
    if (proxy->state().place >= 0)
    {
        m_lookedCount = std::min(m_lookedCount, proxy->state().place);
        m_proxies[proxy->state().place] = m_proxies[--m_proxyCount];
        m_proxies[proxy->state().place].proxy->state().place = proxy->state().place;
        SetOdd(proxy, false);
        if (proxy->state().box == qc_noBox)
            m_outsideCount--;
        else
            qcBoxes_Remove(m_boxes, proxy->state().box);
    }
    if (proxy->state().addedPairs)
        RemoveFrom(m_addedPairs, proxy);
    RemoveFrom(m_rejected, proxy);
    Room* room = new (proxy) Room;
    room->next = m_rooms;
    m_rooms = room;
}

void qcBroadphase::Seek(Proxy* proxy)
{
    m_anythingTouched = m_anythingSought = true;
    proxy->state().sought = m_interval;
}

void qcBroadphase::MoveProxy(Proxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax)
{
    m_anythingTouched = true;
    double lower[3], upper[3];
    proxy->m_aabbMin = aabbMin;
    proxy->m_aabbMax = aabbMax;
    bool odd = !Order(aabbMin, aabbMax, lower, upper);
    // The box in the set may be the same as before, and other proxies overlap nevertheless.
    if (odd || proxy->state().odd)
    {
        Seek(proxy);
        SetOdd(proxy, odd);
    }
    if (proxy->state().box != qc_noBox)
        qcBoxes_Move(m_boxes, proxy->state().box, lower, upper);
}

void qcBroadphase::Pend(Proxy* proxy)
{
    if (proxy->state().pending)
        return;
    proxy->state().pending = true;
    proxy->state().nextPending = m_pending;
    m_pending = proxy;
}

void qcBroadphase::ApplyPending()
{
    while (m_pending != nullptr)
    {
        Proxy* proxy = m_pending;
        m_pending = proxy->state().nextPending;
        proxy->state().pending = false;
        if (proxy->state().destroyed)
        {
            Free(proxy);
            continue;
        }
        if (proxy->state().place < 0)
            List(proxy);
        if (proxy->state().moves)
            MoveProxy(proxy, proxy->state().wantedMin, proxy->state().wantedMax);
        proxy->state().moves = false;
    }
}

qcBroadphase::qcBroadphase(btOverlappingPairCache* pairCache)
    : m_pairCache(pairCache), m_ownsPairCache(pairCache == nullptr), m_pairsAtOnce(qc_pairsAtOnce)
{
    if (m_ownsPairCache)
        m_pairCache = new (btAlignedAlloc(sizeof(btHashedOverlappingPairCache), 16)) btHashedOverlappingPairCache();
    m_knownPairCount = m_pairCache->getNumOverlappingPairs();
}

qcBroadphase::~qcBroadphase()
{
    while (m_proxyCount > 0)
        Free(m_proxies[m_proxyCount - 1].proxy);
    btAlignedFree(m_proxies);
    while (m_blocks != nullptr)
    {
        Block* block = m_blocks;
        m_blocks = block->next;
        btAlignedFree(block);
    }
    qcBoxes_Destroy(m_boxes);
    if (m_ownsPairCache)
    {
        m_pairCache->~btOverlappingPairCache();
        btAlignedFree(m_pairCache);
    }
}

btBroadphaseProxy* qcBroadphase::createProxy(const btVector3& aabbMin, const btVector3& aabbMax, int /*shapeType*/,
                                             void* userPtr, int collisionFilterGroup, int collisionFilterMask,
                                             btDispatcher* /*dispatcher*/)
{
    if (m_rooms == nullptr && !MakeRoom())
    {
        m_status = qc_statusOutOfMemory;
        return nullptr;
    }
    Room* room = m_rooms;
    m_rooms = room->next;
    Proxy* proxy = new (room) Proxy(aabbMin, aabbMax, userPtr, collisionFilterGroup, collisionFilterMask);
    new (&proxy->state()) State;
    proxy->m_uniqueId = ++m_lastUniqueId;
    if (m_walks > 0)
    {
        Pend(proxy);
        return proxy;
    }
    List(proxy);
    AddPairsNow(proxy);
    return proxy;
}

void qcBroadphase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher)
{
    Proxy* mine = static_cast<Proxy*>(proxy);
    if (mine == nullptr || mine->state().destroyed)
        return;
    {
        // A ghost-pair callback may create and move others: their pairs have to wait until the cache is whole again.
        Walk walk(*this);
        int before = m_pairCache->getNumOverlappingPairs();
        // Not later: a ghost-pair callback looks at the object, which its owner is about to delete.
        m_pairCache->removeOverlappingPairsContainingProxy(mine, dispatcher);
        m_knownPairCount += m_pairCache->getNumOverlappingPairs() - before;
    }
    m_destroyCount++;
    if (m_walks == 0)
    {
        Free(mine);
        return;
    }
    mine->state().destroyed = true;
    Pend(mine);
}

void qcBroadphase::setAabb(btBroadphaseProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                           btDispatcher* /*dispatcher*/)
{
    Proxy* mine = static_cast<Proxy*>(proxy);
    if (mine == nullptr)
        return;
    if (m_walks > 0)
    {
        mine->state().moves = true;
        mine->state().wantedMin = aabbMin;
        mine->state().wantedMax = aabbMax;
        Pend(mine);
        return;
    }
    // A world sets all boxes in the order in which the objects came, which is that of the list: then the filter can be
    // looked at here, where the proxy is at hand. Who sets them once more may have changed filters in between.
    bool next = m_lookedCount < m_proxyCount && m_proxies[m_lookedCount].proxy == mine;
    if (!next && mine->state().place < m_lookedCount)
    {
        m_lookedCount = 0;
        next = mine->state().place == 0;
    }
    if (next)
        LookAt(m_proxies[m_lookedCount++]);
    if (qcAreSame(aabbMin, mine->m_aabbMin) && qcAreSame(aabbMax, mine->m_aabbMax))
        return;
    MoveProxy(mine, aabbMin, aabbMax);
    AddPairsNow(mine);
}

void qcBroadphase::getAabb(btBroadphaseProxy* proxy, btVector3& aabbMin, btVector3& aabbMax) const
{
    aabbMin = proxy->m_aabbMin;
    aabbMax = proxy->m_aabbMax;
}

//  ---- queries ---------------------------------------------------------------------------------------

void qcBroadphase::aabbTest(const btVector3& aabbMin, const btVector3& aabbMax, btBroadphaseAabbCallback& callback)
{
    Walk walk(*this);
    VisitBox(aabbMin, aabbMax, [&](Proxy* proxy) { callback.process(proxy); });
}

void qcBroadphase::rayTest(const btVector3& rayFrom, const btVector3& rayTo, btBroadphaseRayCallback& rayCallback,
                           const btVector3& aabbMin, const btVector3& aabbMax)
{
    Walk walk(*this);
    struct Cast
    {
        btBroadphaseRayCallback* callback;
        btScalar lambda;
        double fraction;
    } cast = {&rayCallback, rayCallback.m_lambda_max, 1.0};
    auto function = [](uint32_t, void* userData, void* context)
    {
        Cast* cast = static_cast<Cast*>(context);
        if (!static_cast<Proxy*>(userData)->state().destroyed)
            cast->callback->process(static_cast<Proxy*>(userData));
        if (cast->callback->m_lambda_max < cast->lambda)
            cast->fraction = double(cast->callback->m_lambda_max) / double(cast->lambda);
        return true;
    };
    Way way = MakeWay(rayFrom, rayTo, rayCallback, aabbMin, aabbMax);
    qcBoxes_CastBox(m_boxes, way.from, way.to, way.castLower, way.castUpper, &cast.fraction, function, &cast);
    for (int i = 0; m_outsideCount > 0 && i < m_proxyCount; i++)
        if (m_proxies[i].proxy->state().box == qc_noBox && !m_proxies[i].proxy->state().destroyed)
            rayCallback.process(m_proxies[i].proxy);
}

//  ---- the rest --------------------------------------------------------------------------------------

btOverlappingPairCache* qcBroadphase::getOverlappingPairCache()
{
    return m_pairCache;
}

const btOverlappingPairCache* qcBroadphase::getOverlappingPairCache() const
{
    return m_pairCache;
}

void qcBroadphase::getBroadphaseAabb(btVector3& aabbMin, btVector3& aabbMax) const
{
    double lower[3], upper[3];
    qcBoxes_GetTotalBounds(m_boxes, lower, upper);
    bool any = qcBoxes_GetCount(m_boxes) > 0;
    for (int i = 0; m_outsideCount > 0 && i < m_proxyCount; i++)
    {
        double proxyLower[3], proxyUpper[3];
        const Proxy* proxy = m_proxies[i].proxy;
        if (proxy->state().box != qc_noBox)
            continue;
        Order(proxy->m_aabbMin, proxy->m_aabbMax, proxyLower, proxyUpper);
        for (int k = 0; k < 3; k++)
        {
            lower[k] = any ? std::min(lower[k], proxyLower[k]) : proxyLower[k];
            upper[k] = any ? std::max(upper[k], proxyUpper[k]) : proxyUpper[k];
        }
        any = true;
    }
    aabbMin.setValue(btScalar(lower[0]), btScalar(lower[1]), btScalar(lower[2]));
    aabbMax.setValue(btScalar(upper[0]), btScalar(upper[1]), btScalar(upper[2]));
}

void qcBroadphase::resetPool(btDispatcher* /*dispatcher*/)
{
    if (m_proxyCount > 0 || m_walks > 0)
        return;
    qcBoxes_Clear(m_boxes);
    m_lastUniqueId = 0;
    m_pairsAtOnce = qc_pairsAtOnce;
}

void qcBroadphase::printStats()
{
    std::printf("qcBroadphase: %d proxies, %d of them outside of the set; %d pairs\n", m_proxyCount, m_outsideCount,
                m_pairCache->getNumOverlappingPairs());
}

void qcBroadphase::debugDraw(btIDebugDraw* drawer) const
{
    auto middleOf = [](const btBroadphaseProxy* proxy) { return (proxy->m_aabbMin + proxy->m_aabbMax) / 2; };
    btIDebugDraw::DefaultColors colors = drawer->getDefaultColors();
    for (int i = 0; i < m_proxyCount; i++)
    {
        const Proxy* proxy = m_proxies[i].proxy;
        if (IsFinite(proxy->m_aabbMin) && IsFinite(proxy->m_aabbMax))
            drawer->drawAabb(proxy->m_aabbMin, proxy->m_aabbMax, colors.m_aabb);
    }
    const btBroadphasePair* pairs = m_pairCache->getOverlappingPairArrayPtr();
    for (int i = 0; i < m_pairCache->getNumOverlappingPairs(); i++)
    {
        btVector3 from = middleOf(pairs[i].m_pProxy0), to = middleOf(pairs[i].m_pProxy1);
        if (IsFinite(from) && IsFinite(to))
            drawer->drawLine(from, to, colors.m_contactPoint);
    }
    drawer->flushLines();
}

qcStatus qcBroadphase::getStatus() const
{
    return m_status;
}
