// Replaces Bullet's collision algorithms for pairs of a soft and a rigid body that qcSoftBodyContact answers.
#ifndef QC_GLUE_SOFT_BODY_ALGORITHM_OVERRIDE_H
#define QC_GLUE_SOFT_BODY_ALGORITHM_OVERRIDE_H

#include <memory>
#include <vector>

class btDispatcher;
class qcSoftBodyScene;

/// From the first Register until its end, algorithms that the dispatcher creates for such pairs do nothing, for
/// children of compounds, too. Other pairs of a soft and a rigid body keep Bullet's.
class qcAlgorithmOverride
{
  public:
    /// `scene` has the settings of soft bodies, and receives its liveObjects.
    explicit qcAlgorithmOverride(qcSoftBodyScene& scene);
    ~qcAlgorithmOverride();

    /// Overrides the algorithms of this dispatcher; the previous one gets its own back. Null, and a dispatcher without
    /// algorithms, are allowed.
    void Register(btDispatcher* dispatcher);

  private:
    struct CreateFunc;
    class Gate;

    std::vector<std::unique_ptr<CreateFunc>> m_createFuncs; ///< by shape type; soft body first, then second
    btDispatcher* m_dispatcher = nullptr;
};

#endif
