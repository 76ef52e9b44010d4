// Replaces Bullet's collision algorithms for pairs of a soft body and a qcMeshShape.
#ifndef QC_GLUE_SOFT_BODY_ALGORITHM_OVERRIDE_H
#define QC_GLUE_SOFT_BODY_ALGORITHM_OVERRIDE_H

#include <memory>

class btDispatcher;

/// From the first Register until its end, algorithms that the dispatcher creates for such pairs do nothing, for
/// children of compounds, too.
class qcAlgorithmOverride
{
  public:
    qcAlgorithmOverride();
    ~qcAlgorithmOverride();

    /// Overrides the algorithms of this dispatcher; the previous one gets its own back. Null, and a dispatcher without
    /// algorithms, are allowed.
    void Register(btDispatcher* dispatcher);

  private:
    struct CreateFunc;
    std::unique_ptr<CreateFunc> m_createFunc, m_swappedCreateFunc;
    btDispatcher* m_dispatcher = nullptr;
};

#endif
