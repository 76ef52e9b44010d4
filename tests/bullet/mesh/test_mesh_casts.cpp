// Rays and convex casts through qcMeshShape, one by one and in batches, compared with Bullet's algorithms on every
// triangle.
#include "quickcullide/bullet.h"

#include "bullet/mesh/soup_model.h"
#include "bullet/thread_scheduler.h"

#include <BulletCollision/Gimpact/btGImpactShape.h>
#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <limits>
#include <map>
#include <mutex>
#include <set>
#include <thread>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
btVector3 PointBetween(qcRandom* random, double low, double high)
{
    double x = qcRandom_Uniform(random, low, high), y = qcRandom_Uniform(random, low, high);
    return btVector3(btScalar(x), btScalar(y), btScalar(qcRandom_Uniform(random, low, high)));
}

btQuaternion RandomTurn(qcRandom* random)
{
    return btQuaternion(PointBetween(random, -1, 1).normalized(), btScalar(qcRandom_Uniform(random, 0, 6)));
}

struct Hit
{
    btScalar fraction;
    btVector3 normal;
};

using Hits = std::map<int, Hit>; ///< by triangle

/// Bullet's own cast against each triangle that it receives.
struct CastOfAll : btTriangleConvexcastCallback
{
    using btTriangleConvexcastCallback::btTriangleConvexcastCallback;
    Hits hits;

    btScalar reportHit(const btVector3& normal, const btVector3&, btScalar fraction, int, int triangle) override
    {
        hits[triangle] = {fraction, normal};
        return 1;
    }
};

/// A sweep's result that keeps all hits, and returns what a callback may return.
struct AllResults : btCollisionWorld::ConvexResultCallback
{
    explicit AllResults(btScalar returned) : result(returned)
    {
    }

    btScalar addSingleResult(btCollisionWorld::LocalConvexResult& hit, bool) override
    {
        hits[hit.m_localShapeInfo->m_triangleIndex] = {hit.m_hitFraction, hit.m_hitNormalLocal};
        return result;
    }

    btScalar result;
    Hits hits;
};

/// A mesh in a world of its own.
struct MeshWorld
{
    qcModel model;
    std::unique_ptr<qcMeshShape> shape;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    std::unique_ptr<btBroadphaseInterface> broadphase;
    btCollisionWorld world;
    btCollisionObject object;

    explicit MeshWorld(const qcModel& given, btScalar margin = 0, btBroadphaseInterface* phase = new qcBroadphase)
        : model(given), shape(model.MakeShape(margin)), broadphase(phase), world(&dispatcher, phase, &configuration)
    {
        object.setCollisionShape(shape.get());
        object.setWorldTransform(btTransform(btQuaternion(btVector3(1, 2, 3).normalized(), btScalar(0.7)),
                                             btVector3(btScalar(0.3), btScalar(-0.2), btScalar(0.5))));
        world.addCollisionObject(&object);
    }
    ~MeshWorld()
    {
        world.removeCollisionObject(&object);
    }

    /// Bullet's cast against every triangle.
    Hits CastBrute(const btConvexShape& cast, const qcSweep& sweep, btScalar allowed = 0) const
    {
        CastOfAll all(&cast, sweep.from, sweep.to, object.getWorldTransform(), shape->getMargin());
        all.m_allowedPenetration = allowed;
        for (uint32_t t = 0; t < model.TriangleCount(); t++)
        {
            btVector3 corners[3] = {model.Corner(t, 0), model.Corner(t, 1), model.Corner(t, 2)};
            all.processTriangle(corners, 0, int(t));
        }
        return all.hits;
    }
};

/// Shapes of each kind, of some tenths.
struct Shapes
{
    btBoxShape box{btVector3(btScalar(0.1), btScalar(0.2), btScalar(0.15))};
    btSphereShape sphere{btScalar(0.2)};
    btCapsuleShape capsule{btScalar(0.1), btScalar(0.3)};
    btCylinderShapeZ cylinder{btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.25))};
    btConeShape cone{btScalar(0.15), btScalar(0.4)};
    btConvexHullShape hull;
    btTransform turned{btQuaternion(btVector3(0, 1, 0), 1), btVector3(btScalar(0.2), 0, 0)};

    Shapes()
    {
        qcRandom random = {11};
        for (int i = 0; i < 20; i++)
            hull.addPoint(PointBetween(&random, -0.2, 0.3));
    }

    const btConvexShape& operator[](int i) const
    {
        const btConvexShape* const all[] = {&box, &sphere, &capsule, &cylinder, &cone, &hull};
        return *all[i % 6];
    }
};

qcSweep RandomSweep(qcRandom* random, int i)
{
    qcSweep sweep;
    sweep.from = btTransform(RandomTurn(random), PointBetween(random, -1.5, 1.5));
    sweep.to = sweep.from;
    if (i % 4 == 0)
        sweep.to.setRotation(RandomTurn(random));
    sweep.to.setOrigin(i % 7 == 0 ? sweep.from.getOrigin() : PointBetween(random, -1.5, 1.5));
    if (i % 5 == 0) // along an axis
        sweep.to.setOrigin(sweep.from.getOrigin() + btVector3(i % 2 == 0 ? 2 : -2, 0, 0));
    return sweep;
}

std::vector<qcModel> Models()
{
    return {qcSphereModel(0.5, 3), qcFloorModel(1, 12), qcModelOf(qcSoup_MakeDegenerate(4, 300, 0.3, 0.2))};
}

START_TEST(the_closest_hit_of_a_sweep_is_that_of_all_triangles_to_the_bit)
{
    Shapes shapes;
    qcRandom random = {1};
    int hitCount = 0;
    for (const qcModel& model : Models())
        for (btScalar margin : {btScalar(0), btScalar(0.03)})
        {
            MeshWorld mesh(model, margin);
            for (int i = 0; i < 120; i++)
            {
                qcSweep sweep = RandomSweep(&random, i);
                btScalar allowed = i % 3 == 0 ? btScalar(0.02) : btScalar(0);
                Hits brute = mesh.CastBrute(shapes[i], sweep, allowed);
                btCollisionWorld::ClosestConvexResultCallback closest(sweep.from.getOrigin(), sweep.to.getOrigin());
                mesh.world.convexSweepTest(&shapes[i], sweep.from, sweep.to, closest, allowed);
                btScalar least = 1;
                for (const auto& hit : brute)
                    least = std::min(least, hit.second.fraction);
                ck_assert(closest.m_closestHitFraction == least);
                if (least == 1)
                    continue;
                hitCount++;
                ck_assert(std::any_of(brute.begin(), brute.end(),
                                      [&](const Hits::value_type& hit) {
                                          return hit.second.fraction == least &&
                                                 (hit.second.normal - closest.m_hitNormalWorld).length() < 1e-5;
                                      }));
            }
        }
    ck_assert_int_gt(hitCount, 150);
}
END_TEST

START_TEST(a_sweep_that_collects_all_hits_gets_those_of_all_triangles)
{
    Shapes shapes;
    qcRandom random = {2};
    size_t hitCount = 0;
    for (const qcModel& model : Models())
    {
        MeshWorld mesh(model);
        for (int i = 0; i < 120; i++)
        {
            qcSweep sweep = RandomSweep(&random, i);
            Hits brute = mesh.CastBrute(shapes[i], sweep);
            // Bullet ignores what the callback returns; 1 and 0 are usual.
            AllResults all(btScalar(i % 2));
            mesh.world.convexSweepTest(&shapes[i], sweep.from, sweep.to, all);
            ck_assert_uint_eq(all.hits.size(), brute.size());
            for (const auto& hit : brute)
                ck_assert(all.hits.count(hit.first) == 1 && all.hits[hit.first].fraction == hit.second.fraction);
            hitCount += brute.size();
        }
    }
    ck_assert_uint_gt(hitCount, 1000);
}
END_TEST

START_TEST(a_cast_of_ones_own_receives_each_triangle_that_it_hits)
{
    struct Own : CastOfAll
    {
        using CastOfAll::CastOfAll;
        int received = 0;

        void processTriangle(btVector3* corners, int part, int triangle) override
        {
            received++;
            CastOfAll::processTriangle(corners, part, triangle);
        }
    };
    Shapes shapes;
    qcRandom random = {3};
    int received = 0;
    MeshWorld mesh(qcSphereModel(0.5, 3));
    for (int i = 0; i < 120; i++)
    {
        qcSweep sweep = RandomSweep(&random, i);
        Own own(&shapes[i], sweep.from, sweep.to, mesh.object.getWorldTransform(), 0);
        btVector3 far(10, 10, 10);
        mesh.shape->processAllTriangles(&own, -far, far);
        ck_assert_uint_eq(own.hits.size(), mesh.CastBrute(shapes[i], sweep).size());
        received += own.received;
    }
    ck_assert_int_gt(received, 0);
    ck_assert_int_lt(received, 120 * int(mesh.model.TriangleCount()) / 4); // the others are proven not to be hit
}
END_TEST

/// Rays from inside a closed surface to a point of it and on by half the way.
START_TEST(no_ray_slips_through_an_edge_or_a_vertex)
{
    qcRandom random = {4};
    for (const qcModel& model :
         {qcSphereModel(0.5, 4), qcBoxModel(btVector3(1, 1, 1), 8), qcTorusModel(1, 0.4, 60, 40)})
    {
        MeshWorld mesh(model);
        bool torus = model.TriangleCount() == 60 * 40 * 2;
        btTransform place = mesh.object.getWorldTransform();
        for (int i = 0; i < 4000; i++)
        {
            uint32_t t = uint32_t(qcRandom_Uniform(&random, 0, model.TriangleCount()));
            btVector3 a = model.Corner(t, 0), b = model.Corner(t, 1);
            btVector3 target = i % 4 == 0 ? a : a.lerp(b, btScalar(qcRandom_Uniform(&random, 0, 1)));
            // The torus lies around the y axis: inside is the middle of its tube.
            btVector3 middle = torus ? btVector3(target.x(), 0, target.z()).normalized() : btVector3(0, 0, 0);
            btVector3 from = place * (middle + PointBetween(&random, -0.05, 0.05)), to = place * target;
            to += (to - from) * btScalar(0.5);
            btCollisionWorld::ClosestRayResultCallback hit(from, to);
            mesh.world.rayTest(from, to, hit);
            ck_assert_msg(hit.hasHit(), "ray %d", i);
            ck_assert_double_le(double(hit.m_closestHitFraction), 0.668);
        }
    }
}
END_TEST

START_TEST(rays_hit_each_triangle_that_bullets_test_of_it_hits)
{
    struct All : btTriangleRaycastCallback
    {
        using btTriangleRaycastCallback::btTriangleRaycastCallback;
        Hits hits;

        btScalar reportHit(const btVector3& normal, btScalar fraction, int, int triangle) override
        {
            hits[triangle] = {fraction, normal};
            return 1;
        }
    };
    qcRandom random = {5};
    size_t hitCount = 0;
    for (const qcModel& model : Models())
        for (double scale : {1e-3, 1.0, 1e4})
        {
            MeshWorld mesh(model);
            mesh.shape->setLocalScaling(btVector3(1, 1, 1) * btScalar(scale));
            const btVector3* points = mesh.shape->getVertices();
            for (int i = 0; i < 300; i++)
            {
                btVector3 from = PointBetween(&random, -2, 2), to = PointBetween(&random, -2, 2);
                if (i % 3 == 0)
                    from = PointBetween(&random, -20, 20);
                if (i % 5 == 0) // along an axis, through vertices
                    from = to = model.Corner(uint32_t(i) % model.TriangleCount(), 0);
                if (i % 5 == 0)
                {
                    from[i % 3] -= 1;
                    to[i % 3] += 1;
                }
                from *= btScalar(scale);
                to *= btScalar(scale);
                All ours(from, to), brute(from, to);
                btVector3 lower = from, upper = from;
                lower.setMin(to);
                upper.setMax(to);
                mesh.shape->processAllTriangles(&ours, lower, upper);
                for (uint32_t t = 0; t < model.TriangleCount(); t++)
                {
                    const uint32_t* index = &model.indices[3 * size_t(t)];
                    btVector3 corners[3] = {points[index[0]], points[index[1]], points[index[2]]};
                    brute.processTriangle(corners, 0, int(t));
                }
                for (const auto& hit : brute.hits)
                    ck_assert_msg(ours.hits.count(hit.first) == 1 &&
                                      ours.hits[hit.first].fraction == hit.second.fraction,
                                  "ray %d at scale %g: triangle %d", i, scale, hit.first);
                ck_assert_uint_eq(ours.hits.size(), brute.hits.size());
                hitCount += brute.hits.size();
            }
        }
    ck_assert_uint_gt(hitCount, 500);
}
END_TEST

//  ---- batches -------------------------------------------------------------------------------------

void CheckSame(const qcCastHit& a, const qcCastHit& b)
{
    ck_assert(a.object == b.object && a.fraction == b.fraction && a.normal == b.normal && a.point == b.point);
    ck_assert(a.part == b.part && a.triangle == b.triangle);
}

START_TEST(a_batch_of_rays_has_the_hits_of_single_rays_on_any_number_of_threads)
{
    MeshWorld mesh(qcSphereModel(0.5, 4)), other(qcSphereModel(0.5, 4), 0, new btDbvtBroadphase);
    qcRandom random = {6};
    std::vector<qcRay> rays(1001);
    for (qcRay& ray : rays)
        ray = {PointBetween(&random, -2, 2), PointBetween(&random, -1, 1)};
    std::vector<qcCastHit> hits(rays.size()), expected(rays.size());
    int hitCount = 0;
    for (size_t i = 0; i < rays.size(); i++)
    {
        btCollisionWorld::ClosestRayResultCallback closest(rays[i].from, rays[i].to);
        mesh.world.rayTest(rays[i].from, rays[i].to, closest);
        ck_assert(qcCastRays(&mesh.world, &rays[i], 1, &expected[i]) == qc_statusOk);
        ck_assert(expected[i].fraction == closest.m_closestHitFraction);
        ck_assert(expected[i].object == closest.m_collisionObject);
        if (!closest.hasHit())
            continue;
        hitCount++;
        ck_assert((expected[i].normal - closest.m_hitNormalWorld).length() == 0);
        ck_assert((expected[i].point - closest.m_hitPointWorld).length() == 0);
        ck_assert(expected[i].triangle >= 0 && expected[i].part == 0);
    }
    ck_assert_int_gt(hitCount, 150);
    qcThreadScheduler scheduler(4);
    for (int own = 0; own < 2; own++)
    {
        if (own == 1)
            ck_assert(qcSetTaskScheduler(&scheduler) == qc_statusOk);
        for (unsigned threads : {0u, 1u, 2u, 3u})
        {
            qcCastDef def;
            def.threads = threads;
            ck_assert(qcCastRays(&mesh.world, rays.data(), rays.size(), hits.data(), def) == qc_statusOk);
            for (size_t i = 0; i < rays.size(); i++)
                CheckSame(hits[i], expected[i]);
        }
    }
    qcSetTaskScheduler(nullptr);
    // With Bullet's broadphase, on one thread.
    ck_assert(qcCastRays(&other.world, rays.data(), rays.size(), hits.data()) == qc_statusOk);
    for (size_t i = 0; i < rays.size(); i++)
        ck_assert(hits[i].fraction == expected[i].fraction && hits[i].triangle == expected[i].triangle);
}
END_TEST

/// A ball that notes which threads cast at it. In a call that is not among the first, which the caller of a loop may
/// make alone, a thread waits for a second one, up to some time.
struct NotingBall : btSphereShape
{
    explicit NotingBall(std::chrono::milliseconds given) : btSphereShape(btScalar(0.5)), wait(given)
    {
    }
    btVector3 localGetSupportingVertexWithoutMargin(const btVector3& direction) const override
    {
        std::unique_lock<std::mutex> lock(mutex);
        threads.insert(std::this_thread::get_id());
        second.notify_all();
        if (++calls == 1000)
            second.wait_for(lock, wait, [this] { return threads.size() > 1; });
        return btSphereShape::localGetSupportingVertexWithoutMargin(direction);
    }

    mutable std::mutex mutex;
    mutable std::condition_variable second;
    mutable std::set<std::thread::id> threads;
    mutable int calls = 0;
    const std::chrono::milliseconds wait;
};

/// Whether a batch of rays at a ball in a world takes several threads, if it `should`; its hits are those of one
/// thread.
bool TakesThreads(btCollisionWorld* world, bool should)
{
    NotingBall ball(std::chrono::milliseconds(should ? 10000 : 200));
    btCollisionObject object;
    object.setCollisionShape(&ball);
    world->addCollisionObject(&object);
    qcRandom random = {21};
    std::vector<qcRay> rays(4000);
    for (qcRay& ray : rays)
        ray = {PointBetween(&random, -2, 2), PointBetween(&random, -0.3, 0.3)};
    std::vector<qcCastHit> hits(rays.size()), expected(rays.size());
    qcCastDef def, single;
    def.threads = 4;
    single.threads = 1;
    ck_assert(qcCastRays(world, rays.data(), rays.size(), hits.data(), def) == qc_statusOk);
    const bool takes = ball.threads.size() > 1;
    ck_assert(qcCastRays(world, rays.data(), rays.size(), expected.data(), single) == qc_statusOk);
    for (size_t i = 0; i < rays.size(); i++)
        CheckSame(hits[i], expected[i]);
    world->removeCollisionObject(&object);
    return takes;
}

START_TEST(a_batch_takes_one_thread_where_bullets_tests_are_not_for_several)
{
    qcThreadScheduler scheduler(4);
    ck_assert(qcSetTaskScheduler(&scheduler) == qc_statusOk);
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btSequentialImpulseConstraintSolver solver;
    qcBroadphase broadphase;
    btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    ck_assert(TakesThreads(&world, true));
    // Bullet counts the readers of such a mesh, not atomically.
    btTriangleMesh triangles;
    triangles.addTriangle(btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 1, 0));
    btGImpactMeshShape mesh(&triangles);
    mesh.updateBound();
    btCompoundShape compound;
    compound.addChildShape(btTransform::getIdentity(), &mesh);
    for (btCollisionShape* shape : {static_cast<btCollisionShape*>(&mesh), static_cast<btCollisionShape*>(&compound)})
    {
        btCollisionObject object;
        object.setCollisionShape(shape);
        world.addCollisionObject(&object);
        ck_assert(!TakesThreads(&world, false));
        world.removeCollisionObject(&object);
    }
    // The first ray at a soft body builds its tree of faces.
    std::unique_ptr<btSoftBody> cloth(btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 0, -1),
                                                                     btVector3(1, 0, -1), btVector3(-1, 0, 1),
                                                                     btVector3(1, 0, 1), 8, 8, 0, true));
    world.addSoftBody(cloth.get());
    ck_assert(!TakesThreads(&world, false));
    ck_assert(TakesThreads(&world, true));
    world.removeSoftBody(cloth.get());
    qcSetTaskScheduler(nullptr);
}
END_TEST

START_TEST(a_batch_of_sweeps_has_the_hits_of_single_sweeps)
{
    MeshWorld mesh(qcSphereModel(0.5, 3));
    Shapes shapes;
    qcRandom random = {7};
    std::vector<qcSweep> sweeps(200);
    for (size_t i = 0; i < sweeps.size(); i++)
        sweeps[i] = RandomSweep(&random, int(i));
    std::vector<qcCastHit> hits(sweeps.size());
    for (unsigned threads : {1u, 2u})
    {
        qcCastDef def;
        def.threads = threads;
        ck_assert(qcCastShape(&mesh.world, &shapes.box, sweeps.data(), sweeps.size(), hits.data(), def) == qc_statusOk);
        for (size_t i = 0; i < sweeps.size(); i++)
        {
            const qcSweep& sweep = sweeps[i];
            btCollisionWorld::ClosestConvexResultCallback closest(sweep.from.getOrigin(), sweep.to.getOrigin());
            mesh.world.convexSweepTest(&shapes.box, sweep.from, sweep.to, closest);
            ck_assert(hits[i].fraction == closest.m_closestHitFraction);
            ck_assert(hits[i].object == closest.m_hitCollisionObject);
            if (!closest.hasHit())
                continue;
            ck_assert((hits[i].normal - closest.m_hitNormalWorld).length() == 0);
            ck_assert((hits[i].point - closest.m_hitPointWorld).length() == 0);
        }
    }
}
END_TEST

START_TEST(filters_of_a_batch_are_those_of_single_calls)
{
    MeshWorld mesh(qcSphereModel(0.5, 2));
    btVector3 center = mesh.object.getWorldTransform().getOrigin();
    qcRay ray = {center - btVector3(5, 0, 0), center + btVector3(5, 0, 0)};
    qcSweep sweep;
    sweep.from.setOrigin(ray.from);
    sweep.to.setOrigin(ray.to);
    btSphereShape ball(btScalar(0.1));
    qcCastHit hit;
    qcCastDef def;
    ck_assert(qcCastRays(&mesh.world, &ray, 1, &hit, def) == qc_statusOk && hit.object == &mesh.object);
    ck_assert_double_eq_tol(double(hit.fraction), 0.45, 0.01);
    ck_assert(qcCastShape(&mesh.world, &ball, &sweep, 1, &hit, def) == qc_statusOk && hit.object == &mesh.object);
    def.mask = btBroadphaseProxy::CharacterFilter;
    ck_assert(qcCastRays(&mesh.world, &ray, 1, &hit, def) == qc_statusOk && hit.object == nullptr);
    ck_assert(hit.fraction == 1 && hit.triangle == -1);
    ck_assert(qcCastShape(&mesh.world, &ball, &sweep, 1, &hit, def) == qc_statusOk && hit.object == nullptr);
    def = qcCastDef();
    def.rayFlags = btTriangleRaycastCallback::kF_FilterBackfaces;
    ck_assert(qcCastRays(&mesh.world, &ray, 1, &hit, def) == qc_statusOk && hit.object == &mesh.object);
    ray.from = center; // the surface from inside
    ck_assert(qcCastRays(&mesh.world, &ray, 1, &hit, def) == qc_statusOk && hit.object == nullptr);
}
END_TEST

START_TEST(bad_input_of_a_batch_is_refused_and_nothing_is_written)
{
    MeshWorld mesh(qcSphereModel(0.5, 2));
    std::vector<qcRay> rays(40);
    std::vector<qcCastHit> hits(40);
    for (qcCastHit& hit : hits)
        hit.triangle = 77;
    rays[33].to[1] = std::numeric_limits<btScalar>::quiet_NaN();
    ck_assert(qcCastRays(&mesh.world, rays.data(), 40, hits.data()) == qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcCastRays: a coordinate of query 33 is not finite");
    ck_assert(qcCastRays(nullptr, rays.data(), 33, hits.data()) == qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcCastRays: world is null");
    ck_assert(qcCastRays(&mesh.world, nullptr, 33, hits.data()) == qc_statusBadInput);
    ck_assert(qcCastRays(&mesh.world, rays.data(), 33, nullptr) == qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcCastRays: hits is null");
    ck_assert(qcCastRays(&mesh.world, nullptr, 0, nullptr) == qc_statusOk);
    btSphereShape ball(1);
    std::vector<qcSweep> sweeps(2);
    ck_assert(qcCastShape(&mesh.world, nullptr, sweeps.data(), 2, hits.data()) == qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcCastShape: shape is null");
    sweeps[1].to.getBasis()[2][0] = std::numeric_limits<btScalar>::infinity();
    ck_assert(qcCastShape(&mesh.world, &ball, sweeps.data(), 2, hits.data()) == qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcCastShape: a coordinate of query 1 is not finite");
    for (const qcCastHit& hit : hits)
        ck_assert_int_eq(hit.triangle, 77);
}
END_TEST
} // namespace

QC_RUN_TESTS("mesh_casts", the_closest_hit_of_a_sweep_is_that_of_all_triangles_to_the_bit,
             a_sweep_that_collects_all_hits_gets_those_of_all_triangles,
             a_cast_of_ones_own_receives_each_triangle_that_it_hits, no_ray_slips_through_an_edge_or_a_vertex,
             rays_hit_each_triangle_that_bullets_test_of_it_hits,
             a_batch_of_rays_has_the_hits_of_single_rays_on_any_number_of_threads,
             a_batch_takes_one_thread_where_bullets_tests_are_not_for_several,
             a_batch_of_sweeps_has_the_hits_of_single_sweeps, filters_of_a_batch_are_those_of_single_calls,
             bad_input_of_a_batch_is_refused_and_nothing_is_written)
