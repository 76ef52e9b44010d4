// A Bullet world of convex bodies on hills of triangles.
#include "bench/terrain/world.h"

#include "common/stopwatch.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <random>

namespace
{
constexpr btScalar s_half = btScalar(0.2); // of a body
constexpr btScalar s_below = btScalar(0.5);

/// Hills of 3 m.
btScalar HeightAt(btScalar x, btScalar z)
{
    return btScalar(1.5) * btSin(btScalar(0.3) * x) * btCos(btScalar(0.27) * z);
}

qcTriangles MakeHills(uint32_t cells)
{
    qcTriangles hills = qcMakeFloor(qcTerrainWorld::halfSide, int(cells));
    for (size_t i = 0; i < hills.positions.size(); i += 3)
        hills.positions[i + 1] = HeightAt(hills.positions[i], hills.positions[i + 2]);
    return hills;
}

class Random
{
  public:
    btScalar Number(double lower, double upper)
    {
        return btScalar(std::uniform_real_distribution<double>(lower, upper)(m_engine));
    }

  private:
    std::minstd_rand m_engine{7};
};
} // namespace

const char* qcTerrainName(qcTerrainKind kind)
{
    static const char* const names[qc_terrainKinds] = {"balls", "boxes", "capsules", "hulls", "compounds"};
    return names[kind];
}

/// Appends the bodies' shape, after its parts.
void qcTerrainWorld::MakeShape(qcTerrainKind kind)
{
    Random random;
    auto* hull = kind == qc_terrainHulls ? new btConvexHullShape : nullptr;
    for (int i = 0; hull != nullptr && i < 30; i++)
    {
        const btVector3 point(random.Number(-1, 1), random.Number(-1, 1), random.Number(-1, 1));
        hull->addPoint(point.normalized() * s_half);
    }
    auto* compound = kind == qc_terrainCompounds ? new btCompoundShape : nullptr;
    if (compound != nullptr)
    {
        m_shapes.emplace_back(new btBoxShape(btVector3(s_half / 2, s_half, s_half)));
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(-s_half / 2, 0, 0)),
                                m_shapes.back().get());
        m_shapes.emplace_back(new btSphereShape(s_half));
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(s_half / 2, 0, 0)),
                                m_shapes.back().get());
    }
    switch (kind)
    {
        case qc_terrainBalls: m_shapes.emplace_back(new btSphereShape(s_half)); break;
        case qc_terrainBoxes: m_shapes.emplace_back(new btBoxShape(btVector3(s_half, s_half, s_half))); break;
        case qc_terrainCapsules: m_shapes.emplace_back(new btCapsuleShape(s_half, 2 * s_half)); break;
        case qc_terrainHulls: m_shapes.emplace_back(hull); break;
        default: m_shapes.emplace_back(compound);
    }
}

qcTerrainWorld::qcTerrainWorld(const qcTerrainSetup& setup, bool ours) : m_ours(ours), m_hills(MakeHills(setup.cells))
{
    if (ours)
        m_broadphase.reset(new qcBroadphase);
    else
        m_broadphase.reset(new btDbvtBroadphase);
    m_world.reset(new btDiscreteDynamicsWorld(&m_dispatcher, m_broadphase.get(), &m_solver, &m_configuration));
    m_contact.setThreadCount(1);
    if (ours)
    {
        m_contact.addTo(m_world.get());
        m_hillsShape = m_hills.MakeShape();
    }
    else
    {
        m_array = m_hills.MakeArray();
        m_hillsShape.reset(new btBvhTriangleMeshShape(m_array.get(), true));
    }
    m_ground.reset(new btRigidBody(0, nullptr, m_hillsShape.get()));
    m_world->addRigidBody(m_ground.get());
    MakeShape(setup.kind);
    btVector3 inertia;
    m_shapes.back()->calculateLocalInertia(1, inertia);
    Random random;
    for (uint32_t i = 0; i < setup.bodies; i++)
    {
        btTransform place = btTransform::getIdentity();
        const btScalar x = random.Number(-25, 25), z = random.Number(-25, 25);
        place.setOrigin(btVector3(x, HeightAt(x, z) + setup.height, z));
        m_bodies.emplace_back(new btRigidBody(1, nullptr, m_shapes.back().get(), inertia));
        btRigidBody& body = *m_bodies.back();
        body.setWorldTransform(place);
        body.setLinearVelocity(setup.velocity.rotate(btVector3(0, 1, 0), random.Number(0, 2 * SIMD_PI)));
        body.setActivationState(DISABLE_DEACTIVATION);
        m_world->addRigidBody(&body);
    }
}

qcTerrainWorld::~qcTerrainWorld()
{
    for (const auto& body : m_bodies)
        m_world->removeRigidBody(body.get());
    m_world->removeRigidBody(m_ground.get());
}

double qcTerrainWorld::Step()
{
    double start = qcStopwatch_NowMs();
    m_world->stepSimulation(stepSeconds, 0);
    double ms = qcStopwatch_NowMs() - start;
    if (m_ours && m_contact.getStatistics().status != qc_statusOk)
        m_status = m_contact.getStatistics().status;
    return ms;
}

size_t qcTerrainWorld::CountBelow() const
{
    size_t count = 0;
    for (const auto& body : m_bodies)
    {
        const btVector3& place = body->getWorldTransform().getOrigin();
        const bool isInside = btFabs(place.x()) < halfSide && btFabs(place.z()) < halfSide;
        count += isInside && place.y() < HeightAt(place.x(), place.z()) - s_below;
    }
    return count;
}
