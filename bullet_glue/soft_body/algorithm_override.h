// Takes the pairs of a soft body and a qcMeshShape from Bullet.
#ifndef QC_GLUE_SOFT_BODY_ALGORITHM_OVERRIDE_H
#define QC_GLUE_SOFT_BODY_ALGORITHM_OVERRIDE_H

#include <memory>

class btDispatcher;

/// While it lives, and from its first Register on, algorithms that a dispatcher makes for such pairs do nothing, with
/// compounds of such meshes too.
class qcSoftMeshTakeOver
{
  public:
    qcSoftMeshTakeOver();
    ~qcSoftMeshTakeOver();

    /// Null, and a dispatcher that makes no algorithms, are allowed. Another one than before: that one gets its own
    /// algorithms back.
    void Register(btDispatcher* dispatcher);

  private:
    struct Create;
    std::unique_ptr<Create> m_create, m_swappedCreate;
    btDispatcher* m_dispatcher = nullptr;
};

#endif
