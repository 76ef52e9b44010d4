// The paper's first scene in Bullet: a cloth falls over a round table and folds on itself; then it is pulled away.
// Govindaraju, Lin, Manocha: Quick-CULLIDE, VR 2005, section 5, cloth simulation, and figure 4.
#ifndef QC_DEMOS_CLOTH_WORLD_H
#define QC_DEMOS_CLOTH_WORLD_H

#include "common/bullet/step_costs.h"

#include "quickcullide/bullet.h"

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <vector>

/// The table: a round top on a leg, standing on the floor y = 0. Metres.
struct qcClothTable
{
    static constexpr float radius = 0.32f, height = 0.80f, thickness = 0.09f;
};

class qcClothWorld
{
  public:
    /// A square cloth of 2 m with at least `triangleCount` triangles. `device`, `method` and `threads` find its
    /// self-collisions; the device, which may be null, must outlive the world.
    qcClothWorld(unsigned triangleCount, bool selfCollision, qcDevice* device, qcMethod method, unsigned threads);
    ~qcClothWorld();
    qcClothWorld(const qcClothWorld&) = delete;
    qcClothWorld& operator=(const qcClothWorld&) = delete;

    /// The second act: a bar takes hold of an edge of the cloth and pulls the cloth off the table. It lets go after
    /// `pullSeconds`.
    void PullAway();
    static constexpr double pullSeconds = 1.5;

    /// One step of `stepSeconds`.
    qcStepCosts Step();
    static constexpr double stepSeconds = 1.0 / 120;

    const qcSoftBodyStatistics& Statistics() const
    {
        return m_softSolver.getStatistics();
    }
    btSoftRigidDynamicsWorld& Bullet()
    {
        return m_world;
    }
    qcSoftBodySolver& SoftSolver()
    {
        return m_softSolver;
    }
    btSoftBody& Cloth()
    {
        return *m_cloth;
    }
    btRigidBody& Table()
    {
        return m_table;
    }
    int ManifoldCount() const
    {
        return m_dispatcher.getNumManifolds();
    }
    /// Middle of the bar; meaningless before PullAway.
    btVector3 Grip() const
    {
        return m_grip.getWorldTransform().getOrigin();
    }
    bool IsHeld() const
    {
        return m_pulled >= 0 && m_pulled <= pullSeconds;
    }
    /// Half of the bar's width, and of its length, along z.
    static constexpr float gripHalf = 0.012f, gripHalfLength = 0.25f;
    /// Present positions, three floats a vertex.
    const std::vector<float>& Positions();
    const std::vector<uint32_t>& Indices() const
    {
        return m_indices;
    }

  private:
    void AddCloth(unsigned triangleCount, bool selfCollision);
    void MoveGrip();

    btSoftBodyRigidBodyCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher;
    qcBroadphase m_broadphase;
    btSequentialImpulseConstraintSolver m_solver;
    qcSoftBodySolver m_softSolver;
    btSoftRigidDynamicsWorld m_world;
    btCylinderShape m_tableShape;
    btStaticPlaneShape m_floorShape;
    btRigidBody m_table, m_floor;
    btBoxShape m_gripShape;
    btDefaultMotionState m_gripMotion;
    btRigidBody m_grip;    ///< kinematic: the bar of the second act
    btVector3 m_gripStart; ///< where it took hold
    double m_pulled = -1;  ///< seconds of the second act; -1: it has not begun
    int m_side = 0;        ///< edges of the cloth along a side
    btSoftBody* m_cloth = nullptr;
    std::vector<float> m_positions;
    std::vector<uint32_t> m_indices;
};

#endif
