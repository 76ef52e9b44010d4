// Soft bodies as bodies of a qcScene: the scene reads node positions in place and in Bullet's own precision.
#ifndef QC_BULLET_GLUE_SOFT_BODY_SCENE_H
#define QC_BULLET_GLUE_SOFT_BODY_SCENE_H

#include "quickcullide/bullet_soft_body.h"

#include <map>
#include <utility>
#include <vector>

/// A soft body that the scene knows.
struct qcSceneSoftBody
{
    btSoftBody* body = nullptr;
    qcBodyId id{};
    int nodeCount = 0, faceCount = 0; ///< as given to the scene: a change means a new topology
    qcSoftBodySettings settings;
    btScalar thickness = 0;       ///< settings.thickness, or what stands for its zero
    std::vector<btVector3> start; ///< node positions at the start of the step
    std::vector<char> touched;    ///< nodes that were moved this step
};

class qcSoftBodyScene
{
  public:
    qcSoftBodyScene();
    ~qcSoftBodyScene();
    qcSoftBodyScene(const qcSoftBodyScene&) = delete;
    qcSoftBodyScene& operator=(const qcSoftBodyScene&) = delete;

    /// Makes the scene's bodies those of the array; settings stay with bodies that stay.
    qcStatus Synchronize(const btAlignedObjectArray<btSoftBody*>& bodies);
    /// Gives the scene the nodes' present positions.
    qcStatus UpdateVertices();
    /// Runs the line of data.
    qcStatus Detect(btScalar contactMargin, const qcResult** result);

    /// The body of a slot, or null.
    qcSceneSoftBody* Find(uint32_t slot);
    qcSceneSoftBody* Find(const btSoftBody* body);
    std::vector<qcSceneSoftBody>& Bodies()
    {
        return m_bodies;
    }

    qcSoftBodySettings& Settings(const btSoftBody* body)
    {
        return m_settings[body];
    }
    /// The largest thickness of all bodies.
    btScalar Thickness() const;

    unsigned threads = 0;

  private:
    qcStatus Add(btSoftBody* body);

    qcScene* m_scene = nullptr;
    std::vector<qcSceneSoftBody> m_bodies;
    std::vector<size_t> m_bodyOfSlot;
    std::map<const btSoftBody*, qcSoftBodySettings> m_settings;
};

#endif
