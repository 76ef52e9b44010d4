// The rigid objects whose contacts with soft bodies may hold from the previous step.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_PRESENT_OBJECTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_PRESENT_OBJECTS_H

#include "common/live_objects.h"
#include "soft_body/scene/soft_scene.h"

class qcPresentObjects
{
  public:
    /// Takes the objects whose pairs with soft bodies Bullet has dispatched in this step from the scene.
    explicit qcPresentObjects(qcSoftBodyScene& scene);
    /// True if the object has been dispatched, is still in the world, and contacts with it push the soft body away.
    /// Reads nothing of an object that is gone. Queries about one soft body belong together.
    bool Contains(const qcSceneSoftBody& soft, const qcObjectKey& object);

  private:
    std::vector<qcObjectKey> m_dispatched;
    const qcSceneSoftBody* m_soft = nullptr;
    qcLiveObjects m_near{nullptr}; ///< near m_soft
};

#endif
