// A proxy of qcBroadphase, its state, and the memory that proxies lie in.
#ifndef QC_GLUE_BROADPHASE_PROXY_H
#define QC_GLUE_BROADPHASE_PROXY_H

#include "quickcullide/boxes.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>
#include <LinearMath/btAabbUtil2.h>

constexpr uint32_t qc_noBox = UINT32_MAX;

struct qcProxyState;

/// The part of a proxy that Bullet reads, with all that setAabb needs for an unchanged box. One cache line with float
/// scalars.
struct qcProxy : btBroadphaseProxy
{
    using btBroadphaseProxy::btBroadphaseProxy;

    qcProxyState& state() const;
};

/// The part of a proxy that only the broadphase reads.
struct qcProxyState
{
    uint32_t box = qc_noBox;
    int index = -1;              ///< position in the list of all proxies; negative: not listed yet
    long long queryInterval = 0; ///< number of the interval in which all its pairs were last queried again
    bool invalidAabb = false;    ///< bounds are NaN or inverted: its overlaps are not those of its box in the set
    bool addedPairs = false;     ///< one of its pairs is in the list of pairs added before the search
    bool pending = false;        ///< changes are applied at the end of the last iteration
    bool destroyed = false;      ///< freed at the end of the last iteration
    bool moves = false;          ///< its box becomes pendingMin, pendingMax at the end of the last iteration
    qcProxy* nextPending = nullptr;
    btVector3 pendingMin, pendingMax;
};

/// The memory of one proxy.
union qcProxySlot
{
    qcProxySlot() : nextFree(nullptr)
    {
    }
    ~qcProxySlot() = delete;

    qcProxy proxy;
    qcProxySlot* nextFree;
};

constexpr size_t qc_proxyBlockSize = 16384;

/// A block of proxies, side by side: each step reads the filters of all. When they were scattered, that took a third of
/// a step that moves 10 of 1000 boxes (beside other broadphases that fill the processor's cache). States are stored
/// apart from the proxies, which saves a twentieth.
struct alignas(qc_proxyBlockSize) qcProxyBlock
{
    static constexpr size_t c_slotCount = (qc_proxyBlockSize - 64) / (sizeof(qcProxySlot) + sizeof(qcProxyState));

    alignas(64) unsigned char slots[c_slotCount * sizeof(qcProxySlot)];
    alignas(qcProxyState) unsigned char states[c_slotCount * sizeof(qcProxyState)];
    qcProxyBlock* next; ///< next allocation; used in the first block of each allocation
};

inline qcProxyState& qcProxy::state() const
{
    uintptr_t address = reinterpret_cast<uintptr_t>(this), within = address % qc_proxyBlockSize;
    qcProxyBlock* block = reinterpret_cast<qcProxyBlock*>(address - within);
    return reinterpret_cast<qcProxyState*>(block->states)[within / sizeof(qcProxySlot)];
}

template <class Box> inline bool qcOverlap(const Box* a, const Box* b)
{
    return TestAabbAgainstAabb2(a->m_aabbMin, a->m_aabbMax, b->m_aabbMin, b->m_aabbMax);
}

/// True for a box that reaches to Bullet's largest number on all sides.
inline bool qcHoldsWorld(const btVector3& aabbMin, const btVector3& aabbMax)
{
    bool holds = true;
    for (int i = 0; i < 3; i++)
        holds = holds && aabbMin[i] <= -BT_LARGE_FLOAT && aabbMax[i] >= BT_LARGE_FLOAT;
    return holds;
}

/// Group and mask packed into one number, for a single comparison.
inline uint64_t qcFilterOf(const btBroadphaseProxy* proxy)
{
    return uint64_t(uint32_t(proxy->m_collisionFilterMask)) << 32 | uint32_t(proxy->m_collisionFilterGroup);
}

#endif
