// A Bullet world of convex bodies on hills of triangles.
#ifndef QC_DEMOS_BENCH_TERRAIN_WORLD_H
#define QC_DEMOS_BENCH_TERRAIN_WORLD_H

#include "bench/through/shapes.h"

#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

enum qcTerrainKind
{
    qc_terrainBalls,
    qc_terrainBoxes,
    qc_terrainCapsules,
    qc_terrainHulls,     ///< of 30 points
    qc_terrainCompounds, ///< of a box and a ball
    qc_terrainKinds
};

/// "balls".
const char* qcTerrainName(qcTerrainKind kind);

/// What both contestants begin with.
struct qcTerrainSetup
{
    qcTerrainKind kind = qc_terrainBalls;
    uint32_t cells = 40;   ///< along an edge of the hills, two triangles each
    uint32_t bodies = 200; ///< 0.4 m wide, 1 kg, at random places
    btVector3 velocity;    ///< at the start; turned about the vertical axis at random
    btScalar height = 0;   ///< above the hills
};

class qcTerrainWorld
{
  public:
    static constexpr btScalar stepSeconds = btScalar(1.0 / 60), halfSide = 30;

    /// `ours`: the hills are a qcMeshShape, with qcMeshContact and qcBroadphase; otherwise a btBvhTriangleMeshShape.
    qcTerrainWorld(const qcTerrainSetup& setup, bool ours);
    ~qcTerrainWorld();
    qcTerrainWorld(const qcTerrainWorld&) = delete;
    qcTerrainWorld& operator=(const qcTerrainWorld&) = delete;

    /// Returns the milliseconds that it took.
    double Step();
    /// Milliseconds of the last step's limits; 0 for Bullet.
    double LimitMs() const
    {
        return m_ours ? m_contact.getStatistics().limitMs : 0;
    }
    /// Bodies under the hills.
    size_t CountBelow() const;
    /// A status other than qc_statusOk: a query of the library failed in a step.
    qcStatus Status() const
    {
        return m_status;
    }

  private:
    void MakeShape(qcTerrainKind kind);

    const bool m_ours;
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    btSequentialImpulseConstraintSolver m_solver;
    qcMeshContact m_contact;
    std::unique_ptr<btBroadphaseInterface> m_broadphase;
    std::unique_ptr<btDiscreteDynamicsWorld> m_world;
    qcTriangles m_hills;
    std::unique_ptr<btTriangleIndexVertexArray> m_array;
    std::vector<std::unique_ptr<btCollisionShape>> m_shapes; ///< the last one is the bodies'
    std::unique_ptr<btCollisionShape> m_hillsShape;
    std::unique_ptr<btRigidBody> m_ground;
    std::vector<std::unique_ptr<btRigidBody>> m_bodies;
    qcStatus m_status = qc_statusOk;
};

#endif
