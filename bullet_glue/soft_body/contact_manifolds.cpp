// Contacts of soft bodies as Bullet manifolds.
//
// They live from the end of one step to the beginning of the next, and are gone before collision detection: the
// rigid-body solver never gets a body that was removed in between.
#include "soft_body/contact_manifolds.h"

#include "common/live_objects.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <iterator>

bool qcContactManifolds::BodyPair::IsLive(qcLiveObjects* liveObjects) const
{
    return liveObjects->Contains(a, uniqueIdA) && liveObjects->Contains(b, uniqueIdB);
}

qcContactManifolds::~qcContactManifolds()
{
    Release();
}

void qcContactManifolds::Release()
{
    for (Published& published : m_manifolds)
    {
        btPersistentManifold* manifold = published.manifold;
        for (int i = 0; i < manifold->getNumContacts(); i++)
            manifold->clearUserCache(manifold->getContactPoint(i));
        // With points, Bullet would call gContactEndedCallback, which may read the bodies: they may be deleted, or
        // still in contact.
        manifold->setNumContacts(0);
        published.dispatcher->releaseManifold(manifold);
    }
    m_manifolds.clear();
    m_broadphase = nullptr;
}

/// Adds a pair to those of this step. False: the pair is listed already.
bool qcContactManifolds::Insert(const BodyPair& pair)
{
    auto at = std::lower_bound(m_pairs.begin(), m_pairs.end(), pair);
    if (at != m_pairs.end() && !(pair < *at))
        return false;
    m_pairs.insert(at, pair);
    return true;
}

/// The last manifold if it belongs to these bodies and has room, else a new one; null: the dispatcher has none left.
btPersistentManifold* qcContactManifolds::NextManifold(btDispatcher* dispatcher, const BodyPair& pair)
{
    if (!m_manifolds.empty())
    {
        btPersistentManifold* last = m_manifolds.back().manifold;
        if (last->getBody0() == pair.a && last->getBody1() == pair.b && last->getNumContacts() < MANIFOLD_CACHE_SIZE)
            return last;
    }
    btPersistentManifold* manifold = dispatcher->getNewManifold(pair.a, pair.b);
    if (manifold == nullptr)
        return nullptr;
    bool starts = Insert(pair) && !std::binary_search(m_previousPairs.begin(), m_previousPairs.end(), pair);
    m_manifolds.push_back({dispatcher, manifold, pair, starts});
    return manifold;
}

/// True for two sleeping bodies: the scene's result has no pairs of theirs, in contact or not.
bool qcContactManifolds::AreAtRest(qcSoftBodyScene& scene, const BodyPair& pair)
{
    auto isAtRest = [&](const btCollisionObject* object, int uniqueId)
    {
        auto isSoft = [&](const qcSceneSoftBody& soft)
        { return soft.body == object && soft.uniqueId == uniqueId && !soft.moves; };
        auto isRigid = [&](const std::unique_ptr<qcSceneRigid>& rigid)
        { return rigid->object == object && rigid->uniqueId == uniqueId && rigid->activity != qc_activityMoving; };
        const auto& softs = scene.Bodies();
        const auto& rigids = scene.meshes.Rigids();
        return std::any_of(softs.begin(), softs.end(), isSoft) || std::any_of(rigids.begin(), rigids.end(), isRigid);
    };
    return isAtRest(pair.a, pair.uniqueIdA) && isAtRest(pair.b, pair.uniqueIdB);
}

/// The bodies of a contact. Swaps its points if its second soft body was added before the first.
qcContactManifolds::BodyPair qcContactManifolds::PairOf(qcSoftContactView* view)
{
    const qcSceneSoftBody &a = *view->a, *b = view->b;
    if (b == nullptr)
        return {a.body, view->rigid->object, a.uniqueId, view->rigid->uniqueId};
    if (a.uniqueId <= b->uniqueId)
        return {a.body, b->body, a.uniqueId, b->uniqueId};
    std::swap(view->onA, view->onB);
    view->normal = -view->normal;
    return {b->body, a.body, b->uniqueId, a.uniqueId};
}

void qcContactManifolds::Publish(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& contacts)
{
    BT_PROFILE("qcSoftBodyContact manifolds");
    m_broadphase = scene.Bodies().empty() ? nullptr : scene.Bodies()[0].body->getWorldInfo()->m_broadphase;
    m_pairs.clear();
    for (size_t index : contacts)
    {
        qcSoftContactView view;
        qcViewContact(scene, result.contacts[index], &view);
        BodyPair pair = PairOf(&view);
        btDispatcher* dispatcher = view.a->body->getWorldInfo()->m_dispatcher;
        btPersistentManifold* manifold = dispatcher != nullptr ? NextManifold(dispatcher, pair) : nullptr;
        if (manifold == nullptr)
            continue;
        btManifoldPoint point(pair.a->getWorldTransform().invXform(view.onA),
                              pair.b->getWorldTransform().invXform(view.onB), view.normal,
                              view.distance - view.thickness);
        point.m_positionWorldOnA = view.onA;
        point.m_positionWorldOnB = view.onB;
        point.m_combinedFriction = view.friction;
        manifold->addManifoldPoint(point);
    }
    // Two bodies that fell asleep in contact stay in contact until one wakes.
    for (const BodyPair& pair : m_previousPairs)
        if (!std::binary_search(m_pairs.begin(), m_pairs.end(), pair) && AreAtRest(scene, pair))
            Insert(pair);
}

void qcContactManifolds::DispatchStarts(qcLiveObjects* liveObjects) const
{
    for (const Published& published : m_manifolds)
        if (published.starts && gContactStartedCallback != nullptr && published.pair.IsLive(liveObjects))
        {
            gContactStartedCallback(published.manifold);
            liveObjects->Invalidate();
        }
}

void qcContactManifolds::DispatchPoints(qcLiveObjects* liveObjects) const
{
    for (const Published& published : m_manifolds)
    {
        btPersistentManifold* manifold = published.manifold;
        if (gContactProcessedCallback == nullptr || !published.pair.IsLive(liveObjects))
            continue;
        auto *a = const_cast<btCollisionObject*>(published.pair.a),
             *b = const_cast<btCollisionObject*>(published.pair.b);
        for (int i = 0; i < manifold->getNumContacts(); i++)
            gContactProcessedCallback(manifold->getContactPoint(i), a, b);
    }
}

void qcContactManifolds::DispatchEnds(const std::vector<BodyPair>& ended, qcLiveObjects* liveObjects)
{
    for (const BodyPair& pair : ended)
        if (gContactEndedCallback != nullptr && pair.IsLive(liveObjects))
        {
            btPersistentManifold manifold(pair.a, pair.b, 0, 0, 0);
            btPersistentManifold* pointer = &manifold;
            gContactEndedCallback(pointer);
            liveObjects->Invalidate();
        }
}

void qcContactManifolds::DispatchCallbacks()
{
    std::vector<BodyPair> ended;
    std::set_difference(m_previousPairs.begin(), m_previousPairs.end(), m_pairs.begin(), m_pairs.end(),
                        std::back_inserter(ended));
    m_previousPairs = m_pairs;
    if (m_broadphase == nullptr)
        return;
    qcLiveObjects liveObjects(m_broadphase);
    DispatchStarts(&liveObjects);
    DispatchPoints(&liveObjects);
    DispatchEnds(ended, &liveObjects);
}
