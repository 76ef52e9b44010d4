// qcBroadphase in each kind of Bullet world: the pairs of every step compared with brute force, while bodies and cloth
// fall, and while callbacks of all kinds create and destroy bodies.
#include "bullet/broadphase/watched_broadphase.h"
#include "bullet/broadphase/world_kinds.h"

namespace
{
/// Boxes over a floor, and a cloth where the kind of world has one.
void FillWorld(qcWorld& world)
{
    world.AddBody(0, btVector3(0, -1, 0), world.Make<btBoxShape>(btVector3(20, 1, 20)));
    btCollisionShape* box = world.Make<btBoxShape>(btVector3(btScalar(0.4), btScalar(0.3), btScalar(0.5)));
    qcRandom random = {12};
    for (int i = 0; i < 30; i++)
    {
        btRigidBody* body = world.AddBody(1, qcRandomPoint(&random, 4) + btVector3(-2, 1, -2), box);
        body->setLinearVelocity(qcRandomPoint(&random, 2) - btVector3(1, 3, 1));
    }
    world.AddCloth(btVector3(0, 3, 0));
}
} // namespace

START_TEST(every_kind_of_world_holds_the_pairs_of_brute_force_in_each_step)
{
    for (int kind = 0; kind < qc_worldKindCount; kind++)
    {
        auto* broadphase = new qcWatchedBroadphase;
        qcWorld world{qcWorldKind(kind), broadphase};
        FillWorld(world);
        const bool takesCloth = kind >= int(qcWorldKind::softRigid);
        ck_assert_uint_eq(world.objects.size(), takesCloth ? 32 : 31);
        const btBroadphaseProxy* last = world.objects.back()->getBroadphaseHandle();
        const btScalar lastHeight = last->m_aabbMin.y();
        size_t metByLast = 0;
        for (int step = 0; step < 200; step++)
        {
            world.Step();
            for (const qcIdPair& pair : qcPairsIn(world.world->getPairCache()))
                metByLast += pair.first == last->m_uniqueId || pair.second == last->m_uniqueId;
        }
        if (broadphase->comparisons < 200 || broadphase->pairs < 2000 || metByLast < 20)
            ck_abort_msg("%s: %zu steps, %zu pairs, %zu of the last object", qcWorldKindNames[kind],
                         broadphase->comparisons, broadphase->pairs, metByLast);
        ck_assert(last->m_aabbMin.y() < lastHeight);
        if (kind != int(qcWorldKind::collision))
            ck_assert_int_gt(world.dispatcher->getNumManifolds(), 20);
    }
}
END_TEST

namespace
{
/// Creates and destroys bodies in callbacks.
struct Chaos
{
    qcWorld* world;
    btCollisionShape* shape;
    qcRandom random = {77};
    int additions = 0, removals = 0;
    bool busy = false;

    void Strike(const btCollisionObject* spareA = nullptr, const btCollisionObject* spareB = nullptr)
    {
        // New bodies are filtered, and the filter calls this function again.
        if (busy)
            return;
        busy = true;
        if (world->objects.size() < 60)
        {
            btRigidBody* body = world->AddBody(1, qcRandomPoint(&random, 4) + btVector3(-2, 1, -2), shape);
            body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
            additions++;
        }
        btCollisionObject* doomed =
            world->objects[1 + qcRandom_Below(&random, uint32_t(world->objects.size() - 1))].get();
        // Bodies that are about to be added have no proxy yet.
        if (doomed != spareA && doomed != spareB && btRigidBody::upcast(doomed) != nullptr &&
            doomed->getBroadphaseHandle() != nullptr && world->objects.size() > 20)
        {
            world->Remove(doomed);
            removals++;
        }
        busy = false;
    }
};

/// The callback in which bodies are created and destroyed.
enum Moment
{
    beforeTick,
    afterTick,
    action,
    filter,
    contactAdded,
    momentCount
};

Chaos* s_chaos;
int s_contactsAdded;

void Tick(btDynamicsWorld*, btScalar)
{
    s_chaos->Strike();
}

bool ContactAdded(btManifoldPoint&, const btCollisionObjectWrapper* a, int, int, const btCollisionObjectWrapper* b, int,
                  int)
{
    // Bullet's algorithm still uses these two.
    if (s_contactsAdded++ % 20 == 0)
        s_chaos->Strike(a->getCollisionObject(), b->getCollisionObject());
    return false;
}

/// In mid-step, after the solver, where Bullet's fracture world makes its pieces.
struct Action : btActionInterface
{
    void updateAction(btCollisionWorld*, btScalar) override
    {
        s_chaos->Strike();
    }
    void debugDraw(btIDebugDraw*) override
    {
    }
};

/// Accepts the pairs that groups and masks accept.
struct Filter : btOverlapFilterCallback
{
    mutable int calls = 0;

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        if (++calls % 50 == 0)
            s_chaos->Strike(static_cast<btCollisionObject*>(a->m_clientObject),
                            static_cast<btCollisionObject*>(b->m_clientObject));
        return (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
               (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0;
    }
};

void RunWith(qcWorldKind kind, Moment moment)
{
    auto* broadphase = new qcWatchedBroadphase;
    qcWorld world(kind, broadphase);
    FillWorld(world);
    Chaos chaos;
    chaos.world = &world;
    chaos.shape = world.shapes[1].get();
    s_chaos = &chaos;
    Action act;
    Filter ask;
    s_contactsAdded = 0;
    for (const auto& object : world.objects)
        object->setCollisionFlags(object->getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    // Sorted traversal keeps indices of pairs that a removal makes invalid.
    world.world->getDispatchInfo().m_deterministicOverlappingPairs = false;
    if (moment == filter)
        world.world->getPairCache()->setOverlapFilterCallback(&ask);
    gContactAddedCallback = moment == contactAdded ? ContactAdded : nullptr;
    if (moment == action)
        world.dynamics->addAction(&act);
    if (moment <= afterTick)
        world.dynamics->setInternalTickCallback(Tick, nullptr, moment == beforeTick);
    for (int step = 0; step < 120; step++)
        world.Step();
    gContactAddedCallback = nullptr;
    world.world->getPairCache()->setOverlapFilterCallback(nullptr);
    if (chaos.additions < 20 || chaos.removals < 20 || broadphase->pairs < 1000)
        ck_abort_msg("%s, callback %d: %d additions, %d removals, %zu pairs", qcWorldKindNames[int(kind)], int(moment),
                     chaos.additions, chaos.removals, broadphase->pairs);
}
} // namespace

START_TEST(bodies_may_be_created_and_destroyed_in_callbacks_of_every_kind_of_world)
{
    for (int kind = 0; kind < qc_worldKindCount; kind++)
        for (int moment = 0; moment < momentCount; moment++)
        {
            // A btCollisionWorld has no ticks and no actions.
            if (kind == int(qcWorldKind::collision) && moment <= action)
                continue;
            // The Mt world's dispatcher goes through an array of pairs that must stay as it is.
            if (kind == int(qcWorldKind::discreteMt) && moment == contactAdded)
                continue;
            RunWith(qcWorldKind(kind), Moment(moment));
        }
}
END_TEST

QC_RUN_TESTS("broadphase in kinds of worlds", every_kind_of_world_holds_the_pairs_of_brute_force_in_each_step,
             bodies_may_be_created_and_destroyed_in_callbacks_of_every_kind_of_world)
