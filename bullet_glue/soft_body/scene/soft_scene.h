// Soft bodies, and the meshes near them, as bodies of a qcScene: it reads node positions in Bullet's own precision.
#ifndef QC_GLUE_SOFT_BODY_SCENE_SOFT_SCENE_H
#define QC_GLUE_SOFT_BODY_SCENE_SOFT_SCENE_H

#include "soft_body/scene/rigid_meshes.h"
#include "soft_body/scene/topology.h"

#include "quickcullide/bullet_soft_body.h"

#include <map>
#include <utility>
#include <vector>

/// A soft body that the scene knows. The same address may be another body later: what the broadphase numbers anew when
/// a body is added tells them apart.
struct qcSceneSoftBody
{
    btSoftBody* body = nullptr;
    int uniqueId = 0; ///< unique id of its broadphase proxy
    qcBodyId id{};
    qcSoftTopology topology; ///< as given to the scene
    qcSoftBodySettings settings;
    btScalar thickness = 0;        ///< settings.thickness, or what stands for its zero
    bool moves = true;             ///< false: Bullet does not simulate it at present, and neither do contacts
    bool startsAtEnd = false;      ///< all as it was at the end of the step before
    std::vector<btVector3> start;  ///< node positions at the start of the step
    std::vector<btVector3> solved; ///< as Bullet left them
    /// Where contacts have them by now. Bullet's own nodes, which are large, are written when all is done.
    std::vector<btVector3> places;
    /// What untangling moved places by in this step, without velocity; empty if there was nothing to do.
    std::vector<btVector3> shifts;
    std::vector<bool> held; ///< nodes that contacts don't move; empty if there are none
    bool inContact = false; ///< some contact of this step may have moved it

    int NodeCount() const
    {
        return body->m_nodes.size();
    }
    size_t NumberOf(const btSoftBody::Node* node) const
    {
        return size_t(node - &body->m_nodes[0]);
    }
    /// How far a node goes in the step, what untangling moved it by left out.
    btVector3 MotionOf(size_t node, const btVector3& from) const
    {
        return places[node] - from - (shifts.empty() ? btVector3(0, 0, 0) : shifts[node]);
    }
    /// function(node number) for each that contacts moved.
    template <typename Function> void ForEachMoved(Function function) const
    {
        for (size_t i = 0; i < places.size(); i++)
            if (places[i] != solved[i])
                function(int(i));
    }
    /// 0: contacts don't move the node.
    btScalar InverseMass(uint32_t node) const
    {
        bool pinned = !moves || (!held.empty() && held[node]);
        return pinned ? btScalar(0) : body->m_nodes[int(node)].m_im;
    }
    bool MeetsRigidBodies() const
    {
        return (body->m_cfg.collisions & btSoftBody::fCollision::RVSmask) != 0;
    }
};

class qcSoftBodyScene
{
  public:
    /// `device` may be null; it must outlive the scene.
    explicit qcSoftBodyScene(qcDevice* device) : m_device(device)
    {
    }
    ~qcSoftBodyScene();
    qcSoftBodyScene(const qcSoftBodyScene&) = delete;
    qcSoftBodyScene& operator=(const qcSoftBodyScene&) = delete;

    /// Makes the scene's soft bodies those of the array, and notes where they start this step: at this member of their
    /// nodes.
    qcStatus Synchronize(const btAlignedObjectArray<btSoftBody*>& bodies, btVector3 btSoftBody::Node::*start);
    /// Notes where Bullet left the nodes, and makes the scene's meshes those near its soft bodies, between the start of
    /// the step and there.
    qcStatus TakeSolved(btScalar timeStep);
    /// Gives the scene the places of nodes and meshes.
    qcStatus UpdatePlaces();
    /// Gives the scene the positions of the start of the step.
    qcStatus PlaceAtStart();
    /// True if all bodies, and the meshes near them, are where the step before left them, and nothing else changed that
    /// decides which of their triangles can meet. After TakeSolved.
    bool StartsWhereItEnded() const;
    /// The corners of a triangle at the start of the step.
    void StartOf(uint32_t slot, uint32_t triangle, double corners[9]);
    /// Runs the line of data.
    qcStatus Detect(btScalar contactMargin, bool segments, const qcResult** result);

    /// The body of a slot, or null.
    qcSceneSoftBody* Find(uint32_t slot);
    std::vector<qcSceneSoftBody>& Bodies()
    {
        return m_bodies;
    }

    void SetSettings(const btSoftBody* body, const qcSoftBodySettings& settings);
    qcSoftBodySettings GetSettings(const btSoftBody* body) const;
    /// The largest distance at which two of the bodies push each other.
    btScalar Reach() const;

    qcSoftBodyMeshes meshes;
    unsigned threads = 0;
    qcMethod method = qc_methodAuto;

  private:
    struct Setting
    {
        int uniqueId; ///< -1: given before the body was added
        qcSoftBodySettings settings;
    };

    qcStatus Add(btSoftBody* body);
    qcStatus SetVertices(std::vector<btVector3> qcSceneSoftBody::*positions);
    void DropGone(const btAlignedObjectArray<btSoftBody*>& bodies);
    void TakeSettings(qcSceneSoftBody& known);

    qcDevice* m_device;
    qcScene* m_scene = nullptr;
    std::vector<qcSceneSoftBody> m_bodies;
    std::vector<size_t> m_bodyOfSlot;
    std::map<const btSoftBody*, Setting> m_settings;
};

#endif
