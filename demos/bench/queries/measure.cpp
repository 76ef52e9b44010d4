// Rounds of queries on both shapes in turns.
#include "bench/queries/measure.h"

#include "common/median.h"
#include "common/stopwatch.h"
#include "quickcullide/bullet_broadphase.h"
#include "quickcullide/bullet_mesh.h"
#include "quickcullide/bullet_positions.h"
#include "quickcullide/bullet_queries.h"

#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <cmath>

namespace queries
{
namespace
{
constexpr int s_minRounds = 5;
/// Hits nearer to each other are the same: Bullet's conservative advancement stops within a millimetre.
constexpr double s_same = 1e-3;

/// What a query found.
struct Answer
{
    btScalar fraction = 1; ///< of the way to the closest hit
    uint32_t hits = 0;
};

struct CountTriangles : btTriangleCallback
{
    void processTriangle(btVector3*, int, int) override
    {
        count++;
    }
    uint32_t count = 0;
};

struct CountPoints : btCollisionWorld::ContactResultCallback
{
    btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                             const btCollisionObjectWrapper*, int, int) override
    {
        count++;
        return 0;
    }
    uint32_t count = 0;
};

/// A static object in a world of its own.
class World
{
  public:
    explicit World(btConcaveShape* shape) : m_shape(shape)
    {
        m_shape->setMargin(btScalar(0.01));
        m_object.setCollisionShape(m_shape);
        m_world.addCollisionObject(&m_object);
        m_probe.setCollisionShape(&m_box);
    }
    ~World()
    {
        m_world.removeCollisionObject(&m_object);
    }

    Answer Ask(const Case& kind, const Query& query)
    {
        Answer answer;
        switch (kind.kind)
        {
            case Kind::closestRay:
            {
                btCollisionWorld::ClosestRayResultCallback result(query.from, query.to);
                m_world.rayTest(query.from, query.to, result);
                answer.fraction = result.m_closestHitFraction;
                answer.hits = result.hasHit();
                break;
            }
            case Kind::allRays:
            {
                btCollisionWorld::AllHitsRayResultCallback result(query.from, query.to);
                m_world.rayTest(query.from, query.to, result);
                answer.hits = uint32_t(result.m_hitFractions.size());
                break;
            }
            case Kind::sphere: return Sweep(m_sphere, query);
            case Kind::box: return Sweep(m_box, query);
            case Kind::capsule: return Sweep(m_capsule, query);
            case Kind::contact:
            {
                CountPoints points;
                m_probe.getWorldTransform().setOrigin((query.from + query.to) / 2);
                m_world.contactTest(&m_probe, points);
                answer.hits = points.count;
                break;
            }
            case Kind::aabb:
            {
                CountTriangles triangles;
                m_shape->processAllTriangles(&triangles, query.from, query.to);
                answer.hits = triangles.count;
                break;
            }
        }
        return answer;
    }

  private:
    Answer Sweep(const btConvexShape& shape, const Query& query)
    {
        btTransform from(btQuaternion(btVector3(1, 2, 3).normalized(), btScalar(0.7)), query.from), to(from);
        to.setOrigin(query.to);
        btCollisionWorld::ClosestConvexResultCallback result(query.from, query.to);
        m_world.convexSweepTest(&shape, from, to, result);
        Answer answer;
        answer.fraction = result.m_closestHitFraction;
        answer.hits = result.hasHit();
        return answer;
    }

    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    btDbvtBroadphase m_broadphase;
    btCollisionWorld m_world{&m_dispatcher, &m_broadphase, &m_configuration};
    btConcaveShape* m_shape;
    btCollisionObject m_object, m_probe;
    btSphereShape m_sphere{btScalar(0.3)};
    btBoxShape m_box{btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3))};
    btCapsuleShape m_capsule{btScalar(0.2), btScalar(0.6)};
};

/// A static object behind a qcBroadphase, and queries in batches.
class BatchWorld
{
  public:
    BatchWorld(btConcaveShape* shape, const Case& kind, const std::vector<Query>& asked)
        : m_kind(kind), m_rays(asked.size()), m_sweeps(asked.size())
    {
        m_object.setCollisionShape(shape);
        m_world.addCollisionObject(&m_object);
        for (size_t i = 0; i < asked.size(); i++)
        {
            m_rays[i].from = asked[i].from;
            m_rays[i].to = asked[i].to;
            m_sweeps[i].from.setOrigin(asked[i].from);
            m_sweeps[i].to.setOrigin(asked[i].to);
        }
    }
    ~BatchWorld()
    {
        m_world.removeCollisionObject(&m_object);
    }

    /// Milliseconds of one batch, or of batches of one if `threads` is 0.
    double Cast(uint32_t threads, std::vector<qcCastHit>* hits) const
    {
        qcCastDef def;
        def.threads = threads;
        size_t count = m_rays.size(), size = threads == 0 ? 1 : count;
        double start = qcStopwatch_NowMs();
        for (size_t i = 0; i < count; i += size)
            if (m_kind.kind == Kind::sphere)
                qcCastShape(&m_world, &m_sphere, &m_sweeps[i], size, &(*hits)[i], def);
            else
                qcCastRays(&m_world, &m_rays[i], size, &(*hits)[i], def);
        return qcStopwatch_NowMs() - start;
    }

  private:
    const Case& m_kind;
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    qcBroadphase m_broadphase;
    btCollisionWorld m_world{&m_dispatcher, &m_broadphase, &m_configuration};
    btCollisionObject m_object;
    btSphereShape m_sphere{btScalar(0.3)};
    std::vector<qcRay> m_rays;
    std::vector<qcSweep> m_sweeps;
};

bool AreSame(const std::vector<qcCastHit>& a, const std::vector<qcCastHit>& b)
{
    return std::equal(a.begin(), a.end(), b.begin(),
                      [](const qcCastHit& x, const qcCastHit& y) {
                          return x.object == y.object && x.fraction == y.fraction && x.triangle == y.triangle &&
                                 x.normal == y.normal;
                      });
}

void Compare(const Answer& ours, const Answer& bullet, const Case& kind, Row* row)
{
    double apart = (double(ours.fraction) - double(bullet.fraction)) * kind.length;
    // Bullet's boxes are wider by the error of their 16 bits.
    bool fewer = kind.kind == Kind::aabb ? ours.hits > bullet.hits : ours.hits < bullet.hits;
    bool equal = kind.kind == Kind::aabb || ours.hits == bullet.hits;
    row->differ += fewer || !equal || std::fabs(apart) > s_same;
    row->lost += fewer || apart > s_same;
    row->hits += ours.hits;
}
} // namespace

struct Comparison::Implementation
{
    explicit Implementation(const Mesh& from) : mesh(from)
    {
        double start = qcStopwatch_NowMs();
        uint32_t vertices = uint32_t(mesh.points.size()), triangles = uint32_t(mesh.indices.size() / 3);
        ours.reset(new qcMeshShape(mesh.points.data(), qcBulletPositions, sizeof(btVector3), vertices,
                                   mesh.indices.data(), triangles));
        CountTriangles count;
        ours->processAllTriangles(&count, mesh.points[0], mesh.points[0]);
        oursMs = qcStopwatch_NowMs() - start;
        start = qcStopwatch_NowMs();
        part.m_numTriangles = int(triangles);
        part.m_triangleIndexBase = reinterpret_cast<const unsigned char*>(mesh.indices.data());
        part.m_triangleIndexStride = 3 * sizeof(uint32_t);
        part.m_numVertices = int(vertices);
        part.m_vertexBase = reinterpret_cast<const unsigned char*>(mesh.points.data());
        part.m_vertexStride = sizeof(btVector3);
        array.addIndexedMesh(part);
        bullets.reset(new btBvhTriangleMeshShape(&array, true));
        bulletMs = qcStopwatch_NowMs() - start;
        worlds[0].reset(new World(ours.get()));
        worlds[1].reset(new World(bullets.get()));
    }

    /// The queries of a case; those that hit are left out of one for misses.
    std::vector<Query> Choose(const Case& kind, uint32_t count)
    {
        std::vector<Query> chosen = MakeQueries(mesh, kind, kind.misses ? 4 * count : count);
        if (kind.misses)
            chosen.erase(std::remove_if(chosen.begin(), chosen.end(),
                                        [&](const Query& query) { return worlds[1]->Ask(kind, query).hits > 0; }),
                         chosen.end());
        if (chosen.size() > count)
            chosen.resize(count);
        return chosen;
    }

    /// Microseconds a query.
    double Run(World* world, const Case& kind, const std::vector<Query>& asked, std::vector<Answer>* answers)
    {
        double start = qcStopwatch_NowMs();
        for (size_t i = 0; i < asked.size(); i++)
            (*answers)[i] = world->Ask(kind, asked[i]);
        return 1000 * (qcStopwatch_NowMs() - start) / double(asked.size());
    }

    const Mesh& mesh;
    std::unique_ptr<qcMeshShape> ours;
    btIndexedMesh part;
    btTriangleIndexVertexArray array;
    std::unique_ptr<btBvhTriangleMeshShape> bullets;
    std::unique_ptr<World> worlds[2]; ///< of ours, of Bullet's
    double oursMs, bulletMs;
};

Comparison::Comparison(const Mesh& mesh) : m_implementation(new Implementation(mesh))
{
}

Comparison::~Comparison() = default;

double Comparison::oursBuildMs() const
{
    return m_implementation->oursMs;
}

double Comparison::bulletBuildMs() const
{
    return m_implementation->bulletMs;
}

Row Comparison::Measure(const Case& kind, double budgetMs)
{
    Implementation& my = *m_implementation;
    // A few queries first: they tell how many fit.
    std::vector<Query> asked = my.Choose(kind, 32);
    std::vector<Answer> answers[2];
    for (std::vector<Answer>& answer : answers)
        answer.resize(asked.size());
    Row row = {};
    if (asked.empty())
        return row;
    double probe =
        my.Run(my.worlds[0].get(), kind, asked, &answers[0]) + my.Run(my.worlds[1].get(), kind, asked, &answers[1]);
    double fit = 1000 * budgetMs / (2 * s_minRounds * probe);
    asked = my.Choose(kind, uint32_t(std::min(std::max(fit, 16.0), 5000.0)));
    for (std::vector<Answer>& answer : answers)
        answer.resize(asked.size());
    std::vector<double> times[2], ratios;
    double start = qcStopwatch_NowMs();
    for (int round = 0; round < s_minRounds || qcStopwatch_NowMs() - start < budgetMs; round++)
    {
        double time[2];
        for (int turn = 0; turn < 2; turn++)
        {
            int side = (turn + round) % 2;
            time[side] = my.Run(my.worlds[side].get(), kind, asked, &answers[side]);
            times[side].push_back(time[side]);
        }
        ratios.push_back(time[0] / time[1]);
    }
    row.queries = uint32_t(asked.size());
    row.ours = qcMedianOf(times[0]);
    row.bullet = qcMedianOf(times[1]);
    row.ratio = qcMedianOf(ratios);
    for (size_t i = 0; i < asked.size(); i++)
        Compare(answers[0][i], answers[1][i], kind, &row);
    row.hits /= double(asked.size());
    return row;
}

BatchRow Comparison::MeasureBatch(const Case& kind, const std::vector<uint32_t>& threads, double budgetMs)
{
    Implementation& my = *m_implementation;
    std::vector<Query> asked = my.Choose(kind, 2048);
    BatchWorld world(my.ours.get(), kind, asked);
    BatchRow row = {uint32_t(asked.size()), 0, {}, true};
    std::vector<qcCastHit> expected(asked.size()), hits(asked.size());
    std::vector<std::vector<double>> times(threads.size() + 1);
    double start = qcStopwatch_NowMs();
    for (int round = 0; round < s_minRounds || qcStopwatch_NowMs() - start < budgetMs; round++)
    {
        times[0].push_back(world.Cast(0, &expected));
        for (size_t i = 0; i < threads.size(); i++)
        {
            times[i + 1].push_back(world.Cast(threads[i], &hits));
            row.same = row.same && AreSame(hits, expected);
        }
    }
    row.single = 1000 * qcMedianOf(times[0]) / double(asked.size());
    for (size_t i = 0; i < threads.size(); i++)
        row.batch.push_back(1000 * qcMedianOf(times[i + 1]) / double(asked.size()));
    return row;
}
} // namespace queries
