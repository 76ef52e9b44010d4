// Contact of meshes, and qcBroadphase, in Bullet's Mt world and on threads: contacts are those of the plain world.
//
// A Bullet without BT_THREADSAFE, like Debian's, runs the loops of the Mt classes on the calling thread; it still
// collects and numbers manifolds in their way, after all pairs are dispatched. So threads come from the test's own
// dispatcher, which locks what Bullet doesn't.
#include "quickcullide/bullet.h"

#include "bullet/mesh/mesh_models.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcherMt.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolverMt.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorldMt.h>
#include <LinearMath/btThreads.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
/// Null if Bullet has no threads.
btITaskScheduler* s_scheduler = nullptr;

void SetScheduler()
{
    if (s_scheduler == nullptr)
        s_scheduler = btCreateDefaultTaskScheduler();
    btSetTaskScheduler(s_scheduler != nullptr ? s_scheduler : btGetSequentialTaskScheduler());
}

/// Dispatches pairs on threads, whatever Bullet was built with. Shared data is locked.
class Threaded : public btCollisionDispatcher
{
  public:
    using btCollisionDispatcher::btCollisionDispatcher;

    void dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info, btDispatcher*) override
    {
        std::atomic<int> next{0};
        auto work = [&]
        {
            for (int i; (i = next++) < cache->getNumOverlappingPairs();)
                getNearCallback()(cache->getOverlappingPairArrayPtr()[i], *this, info);
        };
        std::vector<std::thread> threads;
        for (int i = 0; i < 4; i++)
            threads.emplace_back(work);
        for (std::thread& thread : threads)
            thread.join();
    }

    btPersistentManifold* getNewManifold(const btCollisionObject* a, const btCollisionObject* b) override
    {
        std::lock_guard<std::mutex> lock(m_mutex);
        return btCollisionDispatcher::getNewManifold(a, b);
    }

    void releaseManifold(btPersistentManifold* manifold) override
    {
        std::lock_guard<std::mutex> lock(m_mutex);
        btCollisionDispatcher::releaseManifold(manifold);
    }

    void* allocateCollisionAlgorithm(int size) override
    {
        std::lock_guard<std::mutex> lock(m_mutex);
        return btCollisionDispatcher::allocateCollisionAlgorithm(size);
    }

    void freeCollisionAlgorithm(void* algorithm) override
    {
        std::lock_guard<std::mutex> lock(m_mutex);
        btCollisionDispatcher::freeCollisionAlgorithm(algorithm);
    }

  private:
    std::mutex m_mutex;
};

/// Sorts manifolds by bodies and points. Solvers take them in the dispatcher's order, which follows from when they were
/// created and released and differs between dispatchers.
template <class Base> class Sorted : public Base
{
  public:
    using Base::Base;

    void dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info,
                                   btDispatcher* dispatcher) override
    {
        Base::dispatchAllCollisionPairs(cache, info, dispatcher);
        std::vector<std::pair<std::array<double, 6>, btPersistentManifold*>> manifolds;
        for (int i = 0; i < this->m_manifoldsPtr.size(); i++)
        {
            btPersistentManifold* manifold = this->m_manifoldsPtr[i];
            ck_assert(manifold->m_index1a == i);
            btVector3 point(0, 0, 0);
            if (manifold->getNumContacts() > 0)
                point = manifold->getContactPoint(0).m_localPointA;
            manifolds.push_back(
                {{double(manifold->getBody0()->getUserIndex()), double(manifold->getBody1()->getUserIndex()),
                  double(manifold->getNumContacts()), double(point.x()), double(point.y()), double(point.z())},
                 manifold});
        }
        auto isBefore = [](const auto& a, const auto& b) { return a.first < b.first; };
        std::stable_sort(manifolds.begin(), manifolds.end(), isBefore);
        for (int i = 0; i < this->m_manifoldsPtr.size(); i++)
        {
            this->m_manifoldsPtr[i] = manifolds[size_t(i)].second;
            this->m_manifoldsPtr[i]->m_index1a = i;
        }
    }
};

enum class Kind
{
    plain,
    dispatcher, ///< Bullet's Mt dispatcher in a plain world
    mt,
    threaded
};

/// Meshes, boxes and a compound of two meshes that fall on a mesh.
class World
{
  public:
    explicit World(Kind kind)
    {
        if (kind == Kind::mt)
        {
            SetScheduler();
            m_dispatcher = std::make_unique<Sorted<btCollisionDispatcherMt>>(&m_configuration, 4);
            m_pool = std::make_unique<btConstraintSolverPoolMt>(btGetTaskScheduler()->getMaxNumThreads());
            m_solver = std::make_unique<btSequentialImpulseConstraintSolverMt>();
            world = std::make_unique<btDiscreteDynamicsWorldMt>(m_dispatcher.get(), &m_broadphase,
                                                                static_cast<btConstraintSolverPoolMt*>(m_pool.get()),
                                                                m_solver.get(), &m_configuration);
        }
        else
        {
            if (kind == Kind::dispatcher)
            {
                SetScheduler();
                m_dispatcher = std::make_unique<Sorted<btCollisionDispatcherMt>>(&m_configuration, 4);
            }
            else if (kind == Kind::plain)
                m_dispatcher = std::make_unique<Sorted<btCollisionDispatcher>>(&m_configuration);
            else
                m_dispatcher = std::make_unique<Sorted<Threaded>>(&m_configuration);
            m_solver = std::make_unique<btSequentialImpulseConstraintSolver>();
            world = std::make_unique<btDiscreteDynamicsWorld>(m_dispatcher.get(), &m_broadphase, m_solver.get(),
                                                              &m_configuration);
        }
        contact.addTo(world.get());
        contact.setThreadCount(1);
        world->getDispatchInfo().m_timeStep = btScalar(1.0 / 60);
        m_shapes.push_back(qcFloorModel(4, 8).MakeShape());
        m_shapes.push_back(qcBoxModel(btVector3(btScalar(0.4), btScalar(0.3), btScalar(0.5)), 2).MakeShape());
        m_shapes.push_back(qcTorusModel(0.4, 0.15, 10, 5).MakeShape());
        auto pair = std::make_unique<btCompoundShape>();
        for (int x = -1; x <= 1; x += 2)
            pair->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.35) * btScalar(x), 0, 0)),
                                m_shapes[2].get());
        m_shapes.push_back(std::move(pair));
        m_shapes.push_back(std::make_unique<btBoxShape>(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3))));
        Add(0, 0, btVector3(0, 0, 0));
        for (int i = 0; i < 12; i++)
            Add(1 + size_t(i) % 4, 1,
                btVector3(btScalar(0.9) * btScalar(i % 2), btScalar(0.6 + 0.8 * (i / 4)),
                          btScalar(1.1) * btScalar(i / 2 % 2)));
    }

    ~World()
    {
        for (auto& body : bodies)
            world->removeRigidBody(body.get());
    }

    void Step()
    {
        world->stepSimulation(btScalar(1.0 / 60), 0);
        ck_assert_int_eq(contact.getStatistics().status, qc_statusOk);
    }

    bool AreWhere(const World& other) const
    {
        auto isThere = [](const auto& a, const auto& b) { return a->getWorldTransform() == b->getWorldTransform(); };
        return std::equal(bodies.begin(), bodies.end(), other.bodies.begin(), other.bodies.end(), isThere);
    }

    /// Moves all bodies to their places in another world, and finds their contacts.
    void Follow(const World& other)
    {
        for (size_t i = 0; i < bodies.size(); i++)
        {
            bodies[i]->setWorldTransform(other.bodies[i]->getWorldTransform());
            bodies[i]->setInterpolationWorldTransform(other.bodies[i]->getInterpolationWorldTransform());
            bodies[i]->setLinearVelocity(other.bodies[i]->getLinearVelocity());
            bodies[i]->setAngularVelocity(other.bodies[i]->getAngularVelocity());
            bodies[i]->forceActivationState(other.bodies[i]->getActivationState());
        }
        world->performDiscreteCollisionDetection();
        ck_assert_int_eq(contact.getStatistics().status, qc_statusOk);
    }

    using Point = std::array<btScalar, 7>;
    using Contacts = std::map<std::pair<int, int>, std::vector<Point>>;

    /// By the indices of the bodies, over all manifolds of a pair; points sorted.
    Contacts AllContacts() const
    {
        Contacts contacts;
        for (int m = 0; m < m_dispatcher->getNumManifolds(); m++)
        {
            const btPersistentManifold* manifold = m_dispatcher->getManifoldByIndexInternal(m);
            std::pair<int, int> pair(manifold->getBody0()->getUserIndex(), manifold->getBody1()->getUserIndex());
            for (int i = 0; i < manifold->getNumContacts(); i++)
            {
                const btManifoldPoint& p = manifold->getContactPoint(i);
                const btVector3 &a = p.getPositionWorldOnA(), &n = p.m_normalWorldOnB;
                contacts[pair].push_back({a.x(), a.y(), a.z(), n.x(), n.y(), n.z(), p.getDistance()});
            }
        }
        for (auto& [pair, points] : contacts)
            std::sort(points.begin(), points.end());
        return contacts;
    }

    qcMeshContact contact;
    std::unique_ptr<btDiscreteDynamicsWorld> world;
    std::vector<std::unique_ptr<btRigidBody>> bodies;

  private:
    void Add(size_t shape, btScalar mass, const btVector3& at)
    {
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            m_shapes[shape]->calculateLocalInertia(mass, inertia);
        bodies.push_back(std::make_unique<btRigidBody>(mass, nullptr, m_shapes[shape].get(), inertia));
        btRigidBody* body = bodies.back().get();
        body->setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
        body->setInterpolationWorldTransform(body->getWorldTransform());
        body->setUserIndex(int(bodies.size()));
        world->addRigidBody(body);
    }

    btDefaultCollisionConfiguration m_configuration;
    std::unique_ptr<btCollisionDispatcher> m_dispatcher;
    qcBroadphase m_broadphase;
    std::unique_ptr<btConstraintSolver> m_pool, m_solver;
    std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
};

START_TEST(contacts_on_several_threads_and_in_an_mt_world_are_those_of_a_plain_one)
{
    World leading(Kind::plain), plain(Kind::plain), dispatcher(Kind::dispatcher), mt(Kind::mt),
        threaded(Kind::threaded);
    size_t points = 0, most = 0;
    for (int step = 0; step < 60; step++)
    {
        plain.Follow(leading);
        World::Contacts expected = plain.AllContacts();
        for (World* other : {&dispatcher, &mt, &threaded})
        {
            other->Follow(leading);
            ck_assert(other->AllContacts() == expected);
            ck_assert_uint_eq(other->contact.getStatistics().batches, plain.contact.getStatistics().batches);
        }
        most = std::max(most, expected.size());
        for (const auto& [pair, found] : expected)
            points += found.size();
        leading.Step();
    }
    ck_assert_uint_gt(most, 10);
    ck_assert_uint_gt(points, 1500);
}
END_TEST

START_TEST(a_pile_falls_with_any_dispatcher_as_with_the_plain_one)
{
    World plain(Kind::plain), dispatcher(Kind::dispatcher), threaded(Kind::threaded);
    for (int step = 0; step < 60; step++)
    {
        plain.Step();
        for (World* other : {&dispatcher, &threaded})
        {
            other->Step();
            ck_assert(other->AreWhere(plain));
        }
    }
    ck_assert_int_gt(plain.contact.getStatistics().manifolds, 5);
}
END_TEST

START_TEST(a_pile_in_an_mt_world_comes_to_rest)
{
    World mt(Kind::mt);
    for (int step = 0; step < 180; step++)
        mt.Step();
    for (const auto& body : mt.bodies)
    {
        ck_assert(body->getWorldTransform().getOrigin().y() > btScalar(-0.01));
        ck_assert(body->getWorldTransform().getOrigin().y() < 4);
        ck_assert(body->getLinearVelocity().length() < btScalar(0.3));
    }
}
END_TEST

/// A job system whose waiting threads take other tasks, on one thread: a loop of the library first processes pairs that
/// the dispatcher has not yet got to.
struct Helping : btITaskScheduler
{
    std::function<bool()> takeOther;
    int taken = 0;

    Helping() : btITaskScheduler("helping")
    {
    }
    int getMaxNumThreads() const override
    {
        return 2;
    }
    int getNumThreads() const override
    {
        return 2;
    }
    void setNumThreads(int /*count*/) override
    {
    }
    void parallelFor(int begin, int end, int /*grain*/, const btIParallelForBody& body) override
    {
        while (takeOther && takeOther())
            taken++;
        body.forLoop(begin, end);
    }
    btScalar parallelSum(int /*begin*/, int /*end*/, int /*grain*/, const btIParallelSumBody& /*body*/) override
    {
        return 0;
    }
};

/// Dispatches pairs as tasks of a job system.
struct TaskDispatcher : btCollisionDispatcher
{
    Helping* scheduler;

    TaskDispatcher(btCollisionConfiguration* configuration, Helping* helping)
        : btCollisionDispatcher(configuration), scheduler(helping)
    {
    }

    void dispatchAllCollisionPairs(btOverlappingPairCache* cache, const btDispatcherInfo& info, btDispatcher*) override
    {
        int next = 0;
        scheduler->takeOther = [&]
        {
            const int pair = next++;
            if (pair < cache->getNumOverlappingPairs())
                getNearCallback()(cache->getOverlappingPairArrayPtr()[pair], *this, info);
            return pair < cache->getNumOverlappingPairs();
        };
        while (scheduler->takeOther())
            continue;
        scheduler->takeOther = nullptr;
    }
};

START_TEST(threads_that_wait_for_a_query_may_process_other_pairs)
{
    Helping scheduler;
    ck_assert_int_eq(qcSetTaskScheduler(&scheduler), qc_statusOk);
    {
        btDefaultCollisionConfiguration configuration;
        TaskDispatcher dispatcher(&configuration, &scheduler);
        qcBroadphase broadphase;
        btSequentialImpulseConstraintSolver solver;
        qcMeshContact contact;
        btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
        contact.addTo(&world);
        const std::unique_ptr<qcMeshShape> floor = qcFloorModel(9, 20).MakeShape();
        const std::unique_ptr<qcMeshShape> crate =
            qcBoxModel(btVector3(btScalar(0.4), btScalar(0.4), btScalar(0.4)), 2).MakeShape();
        btSphereShape ball(btScalar(0.4));
        std::vector<std::unique_ptr<btRigidBody>> bodies;
        auto add = [&](btCollisionShape* shape, btScalar mass, const btVector3& at)
        {
            btVector3 inertia(0, 0, 0);
            if (mass > 0)
                shape->calculateLocalInertia(mass, inertia);
            bodies.push_back(std::make_unique<btRigidBody>(mass, nullptr, shape, inertia));
            bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), at));
            world.addRigidBody(bodies.back().get());
        };
        add(floor.get(), 0, btVector3(0, 0, 0));
        for (int i = 0; i < 100; i++)
            add(i % 5 == 0 ? static_cast<btCollisionShape*>(&ball) : crate.get(), 1,
                btVector3(btScalar(i % 10) - btScalar(4.5), btScalar(0.45), btScalar(i / 10) - btScalar(4.5)));
        for (int step = 0; step < 60; step++)
        {
            world.stepSimulation(btScalar(1.0 / 60), 0);
            ck_assert_int_eq(contact.getStatistics().status, qc_statusOk);
        }
        ck_assert_int_gt(scheduler.taken, 10);
        for (size_t i = 1; i < bodies.size(); i++)
            ck_assert_double_gt(double(bodies[i]->getWorldTransform().getOrigin().y()), 0.35);
        for (const auto& body : bodies)
            world.removeRigidBody(body.get());
    }
    ck_assert_int_eq(qcSetTaskScheduler(nullptr), qc_statusOk);
}
END_TEST

START_TEST(an_mt_world_moves_twice_in_the_same_way)
{
    World first(Kind::mt), second(Kind::mt);
    for (int step = 0; step < 60; step++)
    {
        first.Step();
        second.Step();
        ck_assert(first.AreWhere(second));
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("meshes on threads", contacts_on_several_threads_and_in_an_mt_world_are_those_of_a_plain_one,
             a_pile_falls_with_any_dispatcher_as_with_the_plain_one, a_pile_in_an_mt_world_comes_to_rest,
             threads_that_wait_for_a_query_may_process_other_pairs, an_mt_world_moves_twice_in_the_same_way)
