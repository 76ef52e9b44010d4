// Contacts of soft bodies as Bullet manifolds.
//
// They live from the end of one step to the beginning of the next: before the next collision detection they are gone,
// so the rigid-body solver never sees a body that was removed in between.
#include "soft_body/contact_manifolds.h"

#include "common/live_objects.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <iterator>

bool qcManifolds::Meeting::IsPresent(qcLiveObjects* liveObjects) const
{
    return liveObjects->Contains(a, uniqueIdA) && liveObjects->Contains(b, uniqueIdB);
}

qcManifolds::~qcManifolds()
{
    Release();
}

void qcManifolds::Release()
{
    for (Published& published : m_manifolds)
    {
        btPersistentManifold* manifold = published.manifold;
        for (int i = 0; i < manifold->getNumContacts(); i++)
            manifold->clearUserCache(manifold->getContactPoint(i));
        // Bullet tells gContactEndedCallback of a manifold with points, which would look at its bodies: they may be
        // gone, or still in contact.
        manifold->setNumContacts(0);
        published.dispatcher->releaseManifold(manifold);
    }
    m_manifolds.clear();
    m_broadphase = nullptr;
}

/// False if it is there already.
bool qcManifolds::Insert(const Meeting& meeting)
{
    auto at = std::lower_bound(m_meetings.begin(), m_meetings.end(), meeting);
    if (at != m_meetings.end() && !(meeting < *at))
        return false;
    m_meetings.insert(at, meeting);
    return true;
}

/// The last manifold if it is of these bodies and has room, else a new one.
btPersistentManifold* qcManifolds::Next(btDispatcher* dispatcher, const Meeting& meeting)
{
    if (!m_manifolds.empty())
    {
        btPersistentManifold* last = m_manifolds.back().manifold;
        if (last->getBody0() == meeting.a && last->getBody1() == meeting.b &&
            last->getNumContacts() < MANIFOLD_CACHE_SIZE)
            return last;
    }
    btPersistentManifold* manifold = dispatcher->getNewManifold(meeting.a, meeting.b);
    if (manifold == nullptr)
        return nullptr;
    bool starts = Insert(meeting) && !std::binary_search(m_before.begin(), m_before.end(), meeting);
    m_manifolds.push_back({dispatcher, manifold, meeting, starts});
    return manifold;
}

/// Of such a pair the scene reports nothing, in contact or not.
bool qcManifolds::AreAtRest(qcSoftBodyScene& scene, const Meeting& meeting)
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
    return isAtRest(meeting.a, meeting.uniqueIdA) && isAtRest(meeting.b, meeting.uniqueIdB);
}

void qcManifolds::Publish(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& contacts)
{
    BT_PROFILE("qcSoftBodyContact manifolds");
    m_broadphase = scene.Bodies().empty() ? nullptr : scene.Bodies()[0].body->getWorldInfo()->m_broadphase;
    m_meetings.clear();
    for (size_t index : contacts)
    {
        qcSoftTouch touch;
        qcReadTouch(scene, result.contacts[index], &touch);
        Meeting meeting{touch.a->body, touch.rigid != nullptr ? touch.rigid->object : touch.b->body, touch.a->uniqueId,
                        touch.rigid != nullptr ? touch.rigid->uniqueId : touch.b->uniqueId};
        // A contact of two soft bodies names either first.
        if (touch.rigid == nullptr && meeting.uniqueIdB < meeting.uniqueIdA)
        {
            std::swap(meeting.a, meeting.b);
            std::swap(meeting.uniqueIdA, meeting.uniqueIdB);
            std::swap(touch.onA, touch.onB);
            touch.normal = -touch.normal;
        }
        btDispatcher* dispatcher = touch.a->body->getWorldInfo()->m_dispatcher;
        btPersistentManifold* manifold = dispatcher != nullptr ? Next(dispatcher, meeting) : nullptr;
        if (manifold == nullptr)
            continue;
        btManifoldPoint point(meeting.a->getWorldTransform().invXform(touch.onA),
                              meeting.b->getWorldTransform().invXform(touch.onB), touch.normal,
                              touch.distance - touch.thickness);
        point.m_positionWorldOnA = touch.onA;
        point.m_positionWorldOnB = touch.onB;
        point.m_combinedFriction = touch.friction;
        manifold->addManifoldPoint(point);
    }
    // What was in contact when both went to sleep is so until one wakes.
    for (const Meeting& meeting : m_before)
        if (!std::binary_search(m_meetings.begin(), m_meetings.end(), meeting) && AreAtRest(scene, meeting))
            Insert(meeting);
}

void qcManifolds::TellStarts(qcLiveObjects* liveObjects)
{
    for (const Published& published : m_manifolds)
        if (published.starts && gContactStartedCallback != nullptr && published.meeting.IsPresent(liveObjects))
        {
            gContactStartedCallback(published.manifold);
            liveObjects->Invalidate();
        }
}

void qcManifolds::TellPoints(qcLiveObjects* liveObjects)
{
    for (const Published& published : m_manifolds)
    {
        btPersistentManifold* manifold = published.manifold;
        if (gContactProcessedCallback == nullptr || !published.meeting.IsPresent(liveObjects))
            continue;
        auto *a = const_cast<btCollisionObject*>(published.meeting.a),
             *b = const_cast<btCollisionObject*>(published.meeting.b);
        for (int i = 0; i < manifold->getNumContacts(); i++)
            gContactProcessedCallback(manifold->getContactPoint(i), a, b);
    }
}

void qcManifolds::TellEnds(const std::vector<Meeting>& ended, qcLiveObjects* liveObjects)
{
    for (const Meeting& meeting : ended)
        if (gContactEndedCallback != nullptr && meeting.IsPresent(liveObjects))
        {
            btPersistentManifold manifold(meeting.a, meeting.b, 0, 0, 0);
            btPersistentManifold* told = &manifold;
            gContactEndedCallback(told);
            liveObjects->Invalidate();
        }
}

void qcManifolds::Tell()
{
    std::vector<Meeting> ended;
    std::set_difference(m_before.begin(), m_before.end(), m_meetings.begin(), m_meetings.end(),
                        std::back_inserter(ended));
    m_before = m_meetings;
    if (m_broadphase == nullptr)
        return;
    qcLiveObjects liveObjects(m_broadphase);
    TellStarts(&liveObjects);
    TellPoints(&liveObjects);
    TellEnds(ended, &liveObjects);
}
