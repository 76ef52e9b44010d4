// What links and anchors add to the velocities of bodies that are worked apart, in the classic world.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_TANGLED_LINKS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_TANGLED_LINKS_H

#include "soft_body/scene/soft_scene.h"

/// Untangling moves nodes without velocity and so strains links. Bullet brings these back within a step or few, with
/// the velocities to match: short steps would throw cloth that comes apart, and shake what can't.
class qcTangledLinks
{
  public:
    /// Reads where the nodes are before Bullet solves links.
    void Begin(qcSoftBodyScene& scene);
    /// Leaves a body, of what links have added to its velocities, the largest share that adds no kinetic energy. Call
    /// it after the scene's ReadSolved.
    void LimitVelocities(qcSoftBodyScene& scene) const;

  private:
    std::vector<std::vector<btVector3>> m_predicted; ///< by body of the scene; empty: it was not untangled lately
};

#endif
