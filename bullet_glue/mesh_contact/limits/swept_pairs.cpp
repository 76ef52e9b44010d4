// The pairs of objects whose motions in a step may meet.
#include "mesh_contact/limits/swept_pairs.h"

#include "mesh_contact/limits/box_sweep.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <LinearMath/btAabbUtil2.h>

#include <utility>

namespace
{
/// True if the application has left a pair out of this step's contact, by a near callback or a dispatcher of its own:
/// one that overlaps and was not asleep has no algorithm.
bool IsLeftOut(btCollisionWorld* world, const qcSweptObject& a, const qcSweptObject& b)
{
    if (!a.wasActive && !b.wasActive)
        return false;
    const btBroadphasePair* pair =
        world->getPairCache()->findPair(a.object->getBroadphaseHandle(), b.object->getBroadphaseHandle());
    return pair != nullptr && pair->m_algorithm == nullptr;
}

/// True if Bullet would make contact between the two.
bool Collide(btCollisionWorld* world, const qcSweptObject& a, const qcSweptObject& b)
{
    if (!(a.IsFree() || b.IsFree() || a.isHeld || b.isHeld) || !a.hasMesh || !b.hasMesh)
        return false;
    if (a.owner != nullptr && a.owner == b.owner)
        return false;
    btBroadphaseProxy *proxyA = a.object->getBroadphaseHandle(), *proxyB = b.object->getBroadphaseHandle();
    if (proxyA == nullptr || proxyB == nullptr)
        return false;
    btOverlapFilterCallback* filter = world->getPairCache()->getOverlapFilterCallback();
    bool agree = filter != nullptr ? filter->needBroadphaseCollision(proxyA, proxyB)
                                   : (proxyA->m_collisionFilterGroup & proxyB->m_collisionFilterMask) != 0 &&
                                         (proxyB->m_collisionFilterGroup & proxyA->m_collisionFilterMask) != 0;
    return agree && a.object->checkCollideWith(b.object) && b.object->checkCollideWith(a.object) &&
           world->getDispatcher()->needsResponse(a.object, b.object) && !IsLeftOut(world, a, b);
}
} // namespace

void qcFindSweptPairs(btCollisionWorld* world, const std::vector<qcSweptObject*>& objects,
                      std::vector<qcSweptPair>* pairs)
{
    pairs->clear();
    auto add = [world, pairs](qcSweptObject* a, qcSweptObject* b)
    {
        if (a->number > b->number)
            std::swap(a, b);
        if (!(a->isUnmoved && b->isUnmoved) && TestAabbAgainstAabb2(a->lower, a->upper, b->lower, b->upper) &&
            Collide(world, *a, *b))
        {
            a->isPaired = b->isPaired = true;
            pairs->emplace_back(a, b);
        }
    };
    qcSweepBoxes(objects, add);
}
