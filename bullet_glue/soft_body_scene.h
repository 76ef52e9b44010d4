// Soft bodies as bodies of a qcScene: the scene reads node positions in place and in Bullet's own precision.
#ifndef QC_BULLET_GLUE_SOFT_BODY_SCENE_H
#define QC_BULLET_GLUE_SOFT_BODY_SCENE_H

#include "quickcullide/bullet_soft_body.h"

#include <map>
#include <utility>
#include <vector>

/// A soft body that the scene knows. The same address may be another body later: what the broadphase numbers anew when
/// a body is added tells them apart.
struct qcSceneSoftBody
{
    btSoftBody* body = nullptr;
    int addition = 0; ///< unique id of its broadphase proxy
    qcBodyId id{};
    std::vector<uint32_t> indices; ///< as given to the scene: other faces mean a new topology
    qcSoftBodySettings settings;
    btScalar halfEdge = 0;        ///< half the mean length of the edges when the scene got it
    btScalar thickness = 0;       ///< settings.thickness, or what stands for its zero
    bool moves = true;            ///< false: Bullet does not simulate it at present, and neither do contacts
    std::vector<btVector3> start; ///< node positions at the start of the step

    int NodeCount() const
    {
        return body->m_nodes.size();
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

    /// Makes the scene's bodies those of the array, and notes where they start this step.
    qcStatus Synchronize(const btAlignedObjectArray<btSoftBody*>& bodies);
    /// Gives the scene the nodes' present positions.
    qcStatus UpdateVertices();
    /// Runs the line of data.
    qcStatus Detect(btScalar contactMargin, const qcResult** result);

    /// The body of a slot, or null.
    qcSceneSoftBody* Find(uint32_t slot);
    std::vector<qcSceneSoftBody>& Bodies()
    {
        return m_bodies;
    }

    void SetSettings(const btSoftBody* body, const qcSoftBodySettings& settings);
    qcSoftBodySettings GetSettings(const btSoftBody* body) const;
    /// The largest thickness of all bodies.
    btScalar Thickness() const;

    unsigned threads = 0;
    qcMethod method = qc_methodAuto;

  private:
    struct Setting
    {
        int addition; ///< -1: given before the body was added
        qcSoftBodySettings settings;
    };

    qcStatus Add(btSoftBody* body);
    void DropGone(const btAlignedObjectArray<btSoftBody*>& bodies);
    void TakeSettings(qcSceneSoftBody& known);

    qcDevice* m_device;
    qcScene* m_scene = nullptr;
    std::vector<qcSceneSoftBody> m_bodies;
    std::vector<size_t> m_bodyOfSlot;
    std::map<const btSoftBody*, Setting> m_settings;
};

#endif
