// A Bullet world of a scene, with one kind of shape.
#ifndef QC_DEMOS_BENCH_PILES_WORLD_H
#define QC_DEMOS_BENCH_PILES_WORLD_H

#include "bench/piles/scenes.h"

#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/ConstraintSolver/btSequentialImpulseConstraintSolver.h>
#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

enum class qcPilesContestant
{
    ours,    ///< qcMeshShape
    gimpact, ///< btGImpactMeshShape
    hull,    ///< btConvexHullShape
};

/// A world that measures the time of its collision detection.
class qcPilesBulletWorld : public btDiscreteDynamicsWorld
{
  public:
    using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;
    void performDiscreteCollisionDetection() override;
    /// The library's limits of motion are an action, which runs between this and the next function.
    void integrateTransforms(btScalar timeStep) override;
    void updateActivationState(btScalar timeStep) override;

    double detectionMs = 0; ///< since the last reset

  private:
    double m_integratedMs = 0; ///< the end of integrateTransforms
};

/// The state of a world after a step.
struct qcPilesState
{
    int points = 0;   ///< in Bullet's manifolds
    double speed = 0; ///< of the fastest body, its turning included; m/s
};

class qcPilesWorld
{
  public:
    static constexpr btScalar stepSeconds = btScalar(1.0 / 60), margin = btScalar(0.01), mass = 10;

    /// `threads`: of the library's queries.
    qcPilesWorld(const qcPilesSetup& setup, qcPilesContestant contestant, unsigned threads);
    ~qcPilesWorld();
    qcPilesWorld(const qcPilesWorld&) = delete;
    qcPilesWorld& operator=(const qcPilesWorld&) = delete;

    /// Returns the milliseconds that it took; `detectionMs` receives those of collision detection.
    double Step(double* detectionMs);
    /// All bodies sleep from now on.
    void Sleep();
    qcPilesState State() const;
    /// A status other than qc_statusOk: a query of the library failed in a step.
    qcStatus Status() const
    {
        return m_status;
    }
    const std::vector<std::unique_ptr<btRigidBody>>& Bodies() const
    {
        return m_bodies;
    }

  private:
    std::unique_ptr<btCollisionShape> MakeShape(const qcTriangles& model, qcPilesContestant contestant);
    void AddBin(btScalar half);

    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    qcBroadphase m_broadphase;
    btSequentialImpulseConstraintSolver m_solver;
    qcMeshContact m_contact;
    qcPilesBulletWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
    btStaticPlaneShape m_plane{btVector3(0, 1, 0), 0};
    btRigidBody m_ground{0, nullptr, &m_plane};
    qcTriangles m_binTriangles;
    std::vector<std::unique_ptr<btTriangleIndexVertexArray>> m_arrays; ///< of Bullet's shapes
    std::unique_ptr<btBvhTriangleMeshShape> m_binShape;
    std::unique_ptr<btRigidBody> m_bin;
    std::vector<std::unique_ptr<btCollisionShape>> m_shapes;
    std::vector<std::unique_ptr<btRigidBody>> m_bodies;
    qcStatus m_status = qc_statusOk;
};

#endif
