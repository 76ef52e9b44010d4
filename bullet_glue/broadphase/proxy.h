// A proxy of qcBroadphase, its state, and the memory that proxies lie in.
#ifndef QC_GLUE_BROADPHASE_PROXY_H
#define QC_GLUE_BROADPHASE_PROXY_H

#include "quickcullide/boxes.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>
#include <LinearMath/btAabbUtil2.h>

constexpr uint32_t qc_noBox = UINT32_MAX;

struct qcProxyState;

/// What Bullet sees, and all that a box that stays needs: with floats, one cache line.
struct qcProxy : btBroadphaseProxy
{
    using btBroadphaseProxy::btBroadphaseProxy;

    qcProxyState& state() const;
};

/// What only the broadphase reads of a proxy.
struct qcProxyState
{
    uint32_t box = qc_noBox;
    int index = -1;              ///< in the list of all proxies; negative: not listed yet
    long long queryInterval = 0; ///< the interval in which all its pairs were last queried again
    bool invalidAabb = false;    ///< bounds are NaN or inverted: its overlaps are not those of its box in the set
    bool addedPairs = false;     ///< is in the list of pairs that were added before the search
    bool pending = false;        ///< changes are applied at the end of the last iteration
    bool destroyed = false;      ///< freed at the end of the last iteration
    bool moves = false;          ///< to pendingMin, pendingMax at the end of the last iteration
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

/// Proxies lie side by side, since each step reads the filters of all: in a step that moves 10 of 1000 boxes, beside
/// other broadphases that fill the processor's cache, that took a third of the time when they were scattered. States
/// lie apart from what Bullet reads: a twentieth of the time.
struct alignas(qc_proxyBlockSize) qcProxyBlock
{
    static constexpr size_t c_slotCount = (qc_proxyBlockSize - 64) / (sizeof(qcProxySlot) + sizeof(qcProxyState));

    alignas(64) unsigned char slots[c_slotCount * sizeof(qcProxySlot)];
    alignas(qcProxyState) unsigned char states[c_slotCount * sizeof(qcProxyState)];
    qcProxyBlock* next; ///< of the blocks that begin an allocation
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

/// Group and mask in one number, which is compared at once.
inline uint64_t qcFilterOf(const btBroadphaseProxy* proxy)
{
    return uint64_t(uint32_t(proxy->m_collisionFilterMask)) << 32 | uint32_t(proxy->m_collisionFilterGroup);
}

#endif
