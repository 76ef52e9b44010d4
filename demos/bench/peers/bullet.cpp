// Bullet's btDbvt: a tree a body, a leaf a triangle, the tree of the first frame fitted to new boxes from the leaves
// up, as btSoftBody does it, then collideTT. Building the tree anew costs tens of times as much.
#include "bench/peers/common.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

namespace
{

const qcPeerMethod s_methods[] = {{"bullet-dbvt", false}};

class Dbvt : btDbvt::ICollide
{
  public:
    Dbvt(const qcPeerTask& task, uint32_t, const qcPeerPose* poses)
        : m_task(task), m_poses(poses), m_trees(task.bodyCount)
    {
        for (uint32_t i = 0; i < task.bodyCount; ++i)
            Build(m_trees[i], task.bodies[i], poses[i]);
    }

    qcPeerAnswer Step(const qcPeerPose* poses)
    {
        m_poses = poses;
        m_lanes.Clear();
        for (uint32_t i = 0; i < m_trees.size(); ++i)
            Fit(m_trees[i], m_task.bodies[i], poses[i]);
        for (m_bodyA = 0; m_bodyA < m_trees.size(); ++m_bodyA)
        {
            for (m_bodyB = m_task.self ? m_bodyA : m_bodyA + 1; m_bodyB < m_trees.size(); ++m_bodyB)
                m_trees[m_bodyA].tree.collideTT(m_trees[m_bodyA].tree.m_root, m_trees[m_bodyB].tree.m_root, *this);
        }
        return m_lanes.Join();
    }

    void Process(const btDbvtNode* a, const btDbvtNode* b) override
    {
        qcPeerLanes_Test(m_lanes, m_task, m_poses, m_bodyA, uint32_t(a->dataAsInt), m_bodyB, uint32_t(b->dataAsInt));
    }

  private:
    struct Tree
    {
        btDbvt tree;
        std::vector<btDbvtNode*> leaves; ///< by triangle
        std::vector<btDbvtNode*> inner;  ///< parents before their children
    };

    static btDbvtVolume FindVolume(const qcPeerBody& body, const qcPeerPose& pose, uint32_t triangle)
    {
        qcPeerBox box = qcPeerBox_Find(body, pose, triangle);
        return btDbvtVolume::FromMM(btVector3(box.lower[0], box.lower[1], box.lower[2]),
                                    btVector3(box.upper[0], box.upper[1], box.upper[2]));
    }

    static void Build(Tree& tree, const qcPeerBody& body, const qcPeerPose& pose)
    {
        tree.leaves.resize(body.triangleCount);
        for (uint32_t i = 0; i < body.triangleCount; ++i)
        {
            tree.leaves[i] = tree.tree.insert(FindVolume(body, pose, i), nullptr);
            tree.leaves[i]->dataAsInt = int(i);
        }
        tree.tree.optimizeTopDown();
        if (tree.tree.m_root != nullptr && tree.tree.m_root->isinternal())
            tree.inner.push_back(tree.tree.m_root);
        for (std::size_t i = 0; i < tree.inner.size(); ++i)
        {
            for (btDbvtNode* child : tree.inner[i]->childs)
            {
                if (child->isinternal())
                    tree.inner.push_back(child);
            }
        }
    }

    static void Fit(Tree& tree, const qcPeerBody& body, const qcPeerPose& pose)
    {
        for (uint32_t i = 0; i < body.triangleCount; ++i)
            tree.leaves[i]->volume = FindVolume(body, pose, i);
        for (std::size_t i = tree.inner.size(); i-- > 0;)
        {
            btDbvtNode* node = tree.inner[i];
            Merge(node->childs[0]->volume, node->childs[1]->volume, node->volume);
        }
    }

    const qcPeerTask& m_task;
    const qcPeerPose* m_poses;
    std::vector<Tree> m_trees;
    uint32_t m_bodyA = 0, m_bodyB = 0; ///< whose trees collide at the moment
    qcPeerLanes m_lanes;
};

} // namespace

extern "C" __attribute__((visibility("default"))) const qcPeerLibrary* qcPeer_GetLibrary()
{
    static const qcPeerLibrary library = {"Bullet " QC_BULLET_VERSION, s_methods,         1,
                                          qcPeer_Open<Dbvt>,           qcPeer_Step<Dbvt>, qcPeer_Close<Dbvt>};
    return &library;
}
