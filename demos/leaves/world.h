// The paper's third scene in Bullet: leaves let go of a tree one after another, and bend and collide as they fall.
// Govindaraju, Lin, Manocha: Quick-CULLIDE, VR 2005, section 5, objects undergoing non-rigid motion, and figure 6.
#ifndef QC_DEMOS_LEAVES_WORLD_H
#define QC_DEMOS_LEAVES_WORLD_H

#include "common/bullet/step_costs.h"
#include "leaves/tree.h"

#include "quickcullide/bullet.h"

#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <memory>
#include <vector>

struct qcLeavesRequest
{
    uint32_t leaves = 384; ///< at most: a leaf grows only where there is room
    uint32_t seed = 1;     ///< of the tree, its leaves and the wind
    qcMethod method = qc_methodAuto;
    uint32_t threads = 0;
};

class qcLeavesWorld
{
  public:
    /// `device` may be null; it must outlive the world.
    qcLeavesWorld(const qcLeavesRequest& request, qcDevice* device);
    ~qcLeavesWorld();
    qcLeavesWorld(const qcLeavesWorld&) = delete;
    qcLeavesWorld& operator=(const qcLeavesWorld&) = delete;

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
    const qcTree& Tree() const
    {
        return m_tree;
    }
    size_t LeafCount() const
    {
        return m_leaves.size();
    }
    /// Appends the positions that a leaf has after `seconds` if nothing stops it, three floats a vertex. 0: the present
    /// ones.
    void AppendPositions(size_t leaf, double seconds, std::vector<float>* positions) const;
    /// Those of each leaf.
    const std::vector<uint32_t>& LeafIndices() const
    {
        return m_leafIndices;
    }
    size_t HangingCount() const;  ///< leaves that are still on the tree
    double KineticEnergy() const; ///< joules
    double Lowest() const;        ///< height of the lowest vertex of a leaf, metres

  private:
    struct Leaf
    {
        btSoftBody* body;
        double letsGo; ///< time, seconds
        bool hangs;
    };

    void AddTree();
    void AddLeaf(const struct qcLeafMesh& mesh, double letsGo);
    void LetGo(Leaf* leaf);
    btVector3 Wind(const btVector3& place) const;

    qcLeavesRequest m_request;
    btSoftBodyRigidBodyCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher;
    qcBroadphase m_broadphase;
    btSequentialImpulseConstraintSolver m_solver;
    qcSoftBodySolver m_softSolver;
    btSoftRigidDynamicsWorld m_world;
    qcTree m_tree;
    std::unique_ptr<qcMeshShape> m_treeShape;
    std::unique_ptr<btRigidBody> m_treeBody;
    btStaticPlaneShape m_groundShape;
    btRigidBody m_ground;
    std::vector<Leaf> m_leaves;
    std::vector<uint32_t> m_leafIndices;
    double m_seconds = 0;
};

#endif
