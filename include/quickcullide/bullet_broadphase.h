// The broadphase of a Bullet world, in the place of btDbvtBroadphase:
//
//     qcBroadphase broadphase;
//     btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
//
// Cost follows what moved: a proxy whose box is the same as before costs a comparison and a look at its filter, a step
// in which nothing moved nothing else.
#ifndef QUICKCULLIDE_BULLET_BROADPHASE_H
#define QUICKCULLIDE_BULLET_BROADPHASE_H

#include "base.h"

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>

class btIDebugDraw;

/// After each calculateOverlappingPairs the pair cache holds exactly the pairs whose boxes overlap (closed, as
/// TestAabbAgainstAabb2 says) and whose filters agree. Pairs that no longer do are removed with the dispatcher, which
/// destroys their algorithms and manifolds. Pairs come in an order that depends on the calls made and on nothing else.
///
/// Filters may change at any time: groups and masks are looked at in each step, when the boxes are set or else when
/// pairs are calculated; what changes between the two is seen in the next step. While there is a filter callback it is
/// asked about every overlapping pair in each step. A pair cache of your own that overrides needsBroadphaseCollision
/// without having a filter callback is asked when two begin to overlap, or a group or mask has changed.
///
/// Bounds that are NaN count as unbounded, so the object meets everything rather than nothing.
///
/// Out of memory: proxies that find no room in the set are compared with every other one until there is room again;
/// nothing is missed. A proxy that cannot be allocated itself is null: Bullet then holds an object that collides with
/// nothing. getStatus tells. (Memory that Bullet's pair cache cannot get is Bullet's affair.)
///
/// Profile zones (BT_PROFILE), within Bullet's "calculateOverlappingPairs": "qcBroadphase search" finds what changed
/// between boxes, "qcBroadphase pairs" brings the cache up to date. A step in which nothing moved has neither.
///
/// Thread-safety: rayTest and aabbTest may run on several threads at once while nothing else does. The rest belongs to
/// one thread. Callbacks of all kinds may create, move and destroy proxies; what they change while a query,
/// destroyProxy or calculateOverlappingPairs runs takes effect at its end, except that a destroyed proxy is not seen
/// again. Only a ghost-pair callback must not destroy any: Bullet's pair caches call it in the midst of a change.
class QC_API qcBroadphase : public btBroadphaseInterface
{
  public:
    /// Null: makes a btHashedOverlappingPairCache and owns it. Any other pair cache must outlive the broadphase.
    explicit qcBroadphase(btOverlappingPairCache* pairCache = nullptr);
    /// Frees the proxies that are left; their pairs stay in the cache if it is not owned.
    ~qcBroadphase() override;
    qcBroadphase(const qcBroadphase&) = delete;
    qcBroadphase& operator=(const qcBroadphase&) = delete;

    /// O(log n). Its pairs are in the cache after the next calculateOverlappingPairs; see setAabb.
    btBroadphaseProxy* createProxy(const btVector3& aabbMin, const btVector3& aabbMax, int shapeType, void* userPtr,
                                   int collisionFilterGroup, int collisionFilterMask,
                                   btDispatcher* dispatcher) override;
    /// Removes the proxy's pairs at once. O(pairs in the cache), as with any of Bullet's broadphases. Null is allowed.
    void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
    /// The same box again costs nothing; otherwise O(log n). The first boxes that change after a step find their new
    /// pairs at once, since a character controller or a sensor moved by hand reads them before the next step.
    void setAabb(btBroadphaseProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                 btDispatcher* dispatcher) override;
    void getAabb(btBroadphaseProxy* proxy, btVector3& aabbMin, btVector3& aabbMax) const override;

    /// Reports every proxy whose box is met on the way from `rayFrom` to `rayTo` by a box of the given extents, nearer
    /// ones first as far as the tree can tell, and few others. The way goes on beyond `rayTo`, or another way, where
    /// the callback's m_rayDirectionInverse and m_lambda_max say so. The callback may lower its m_lambda_max to shorten
    /// what is left of the way. What `process` returns is ignored, as by Bullet's broadphases.
    void rayTest(const btVector3& rayFrom, const btVector3& rayTo, btBroadphaseRayCallback& rayCallback,
                 const btVector3& aabbMin = btVector3(0, 0, 0), const btVector3& aabbMax = btVector3(0, 0, 0)) override;
    /// Reports every proxy whose box meets the given one. What `process` returns is ignored.
    void aabbTest(const btVector3& aabbMin, const btVector3& aabbMax, btBroadphaseAabbCallback& callback) override;

    /// O(moved log n + pairs). Does nothing when called by a callback of its own.
    void calculateOverlappingPairs(btDispatcher* dispatcher) override;

    btOverlappingPairCache* getOverlappingPairCache() override;
    const btOverlappingPairCache* getOverlappingPairCache() const override;

    /// The smallest box around all proxies; zeros when there are none.
    void getBroadphaseAabb(btVector3& aabbMin, btVector3& aabbMax) const override;
    /// When there are no proxies, unique ids start again and the same calls give the same results as on a new
    /// broadphase.
    void resetPool(btDispatcher* dispatcher) override;
    /// Prints the numbers of proxies and pairs.
    void printStats() override;
    /// Draws the box of each proxy in the drawer's colour of AABBs, and a line between the middles of the boxes of each
    /// pair in the cache in its colour of contact points. Bounds that are not finite are left out. For any debug mode:
    /// call it after debugDrawWorld, which draws AABBs of shapes and not these. Changes nothing.
    void debugDraw(btIDebugDraw* drawer) const;

    /// qc_statusOutOfMemory after an allocation failed, until a calculateOverlappingPairs finds room for everything.
    qcStatus getStatus() const;

  private:
    struct Data;
    Data* m_data;
};

#endif
