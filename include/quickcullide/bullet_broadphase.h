/// @file
/// A broadphase for any Bullet world, in place of btDbvtBroadphase:
///
///     qcBroadphase broadphase;
///     btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
///
/// Cost follows what moved: a proxy whose box is set but did not change costs one comparison and one read of its
/// filter, one whose box is not set costs nothing.
#ifndef QUICKCULLIDE_BULLET_BROADPHASE_H
#define QUICKCULLIDE_BULLET_BROADPHASE_H

#include "base.h"

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>

class btIDebugDraw;

/// A drop-in for btDbvtBroadphase.
///
/// Pairs: after each calculateOverlappingPairs the pair cache holds exactly the pairs whose closed boxes overlap
/// (TestAabbAgainstAabb2) and whose filters agree. Other pairs are removed with the dispatcher, which destroys their
/// algorithms and manifolds. The order of pairs depends only on the calls made, not on addresses, threads or time.
/// Pairs that the application itself adds to the cache or removes from it are put right in the next call if the number
/// of pairs is another one then.
///
/// Filters: groups and masks may change at any time. They are read once a step when the object's box is set; a change
/// after that takes effect in the next step. Each step also reads 4096 filters of objects whose boxes are not set, such
/// as sleeping ones in a world with setForceUpdateAllAabbs(false), in turn: with more such objects a change takes
/// effect within (their number / 4096) steps, or at once if the present box is set again. A filter callback is called
/// for every overlapping pair in every step. A pair cache of your own that overrides needsBroadphaseCollision and has
/// no filter callback is queried when a pair begins to overlap or a group or mask has changed.
///
/// Bounds that are NaN count as unbounded: the object then overlaps everything.
///
/// Out of memory: proxies that don't fit into the set are compared with every other proxy until there is memory again;
/// no pair is missed. If a proxy itself can't be allocated, createProxy returns null, and Bullet then holds an object
/// that collides with nothing. See getStatus. Failed allocations in Bullet's pair cache are not handled.
///
/// Profile zones (BT_PROFILE), within Bullet's "calculateOverlappingPairs": "qcBroadphase search" finds changed pairs,
/// "qcBroadphase pairs" updates the cache. A step in which nothing moved has neither.
///
/// Thread-safety: rayTest and aabbTest may run on several threads at once while nothing else does. All other functions
/// belong to one thread. Callbacks may create, move and destroy proxies. Such a change takes effect at the end of the
/// running query, destroyProxy or calculateOverlappingPairs, but a destroyed proxy is not reported again. Only a
/// ghost-pair callback must not destroy proxies, since Bullet's pair caches call it in the middle of a change.
class QC_API qcBroadphase : public btBroadphaseInterface
{
  public:
    /// Null: creates and owns a btHashedOverlappingPairCache. Any other pair cache must outlive the broadphase.
    explicit qcBroadphase(btOverlappingPairCache* pairCache = nullptr);
    /// Frees the remaining proxies. Their pairs stay in the cache unless it is owned.
    ~qcBroadphase() override;
    qcBroadphase(const qcBroadphase&) = delete;
    qcBroadphase& operator=(const qcBroadphase&) = delete;

    /// Adds a proxy, O(log n). Its pairs are in the cache after the next calculateOverlappingPairs; see also setAabb.
    /// Null: out of memory.
    btBroadphaseProxy* createProxy(const btVector3& aabbMin, const btVector3& aabbMax, int shapeType, void* userPtr,
                                   int collisionFilterGroup, int collisionFilterMask,
                                   btDispatcher* dispatcher) override;
    /// Removes a proxy and its pairs. O(pairs in the cache), as in Bullet's broadphases. Null is allowed.
    void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override;
    /// Moves a proxy, O(log n); an unchanged box costs nothing. The first boxes that change after a step find their new
    /// pairs at once, for character controllers and sensors that are moved by hand and read before the next step.
    void setAabb(btBroadphaseProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                 btDispatcher* dispatcher) override;
    /// The proxy's box, as it was set. O(1).
    void getAabb(btBroadphaseProxy* proxy, btVector3& aabbMin, btVector3& aabbMax) const override;

    /// Reports every proxy whose box is touched by a box of the given extents that moves from `rayFrom` to `rayTo`, and
    /// few others; nearer ones first, as far as the tree can order them. The callback's m_rayDirectionInverse and
    /// m_lambda_max may describe another way, which is then followed. The callback may lower m_lambda_max to shorten
    /// the rest of the search. The return value of `process` is ignored, as in Bullet's broadphases.
    void rayTest(const btVector3& rayFrom, const btVector3& rayTo, btBroadphaseRayCallback& rayCallback,
                 const btVector3& aabbMin = btVector3(0, 0, 0), const btVector3& aabbMax = btVector3(0, 0, 0)) override;
    /// Reports every proxy whose box overlaps the given one. The return value of `process` is ignored.
    void aabbTest(const btVector3& aabbMin, const btVector3& aabbMax, btBroadphaseAabbCallback& callback) override;

    /// Updates the pair cache. O(moved log n + pairs). Does nothing when one of its own callbacks calls it.
    void calculateOverlappingPairs(btDispatcher* dispatcher) override;

    /// The pair cache, given or owned.
    btOverlappingPairCache* getOverlappingPairCache() override;
    /// The pair cache, given or owned.
    const btOverlappingPairCache* getOverlappingPairCache() const override;

    /// The smallest box around all proxies; zeros if there are none.
    void getBroadphaseAabb(btVector3& aabbMin, btVector3& aabbMax) const override;
    /// If there are no proxies, the same calls then give the same pairs in the same order as on a new broadphase.
    /// Unique ids go on: an object that is added again counts as a new one, which has not moved from its last place.
    /// With proxies nothing happens.
    void resetPool(btDispatcher* dispatcher) override;
    /// Prints the numbers of proxies and pairs.
    void printStats() override;
    /// Draws the box of each proxy in the drawer's colour of AABBs, and a line between the centres of each pair in the
    /// cache in its colour of contact points. Boxes that are not finite are left out. Call it after debugDrawWorld,
    /// which draws the AABBs of shapes and not these. The drawer's debug mode is ignored. Changes nothing.
    void debugDraw(btIDebugDraw* drawer) const;

    /// Records all calls from now on, and the pairs and boxes that are found, in a new file for qc-replay; it begins
    /// with the present proxies. Null ends the recording. Failures are those of qcScene_Record (recording.h), and so is
    /// QC_RECORD, which records every broadphase from its creation. Filter callbacks are recorded by the pairs that
    /// they reject; a pair cache that filters otherwise is not. qc_statusBadInput: called by a callback of the
    /// broadphase.
    qcStatus record(const char* path);

    /// qc_statusOutOfMemory from a failed allocation until a calculateOverlappingPairs has found memory for everything.
    qcStatus getStatus() const;

  private:
    struct Data;
    Data* m_data;
};

#endif
