// What anchors add to the velocities of the rigid bodies that hang on them, in contact of the classic world.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_ANCHOR_PULLS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_ANCHOR_PULLS_H

#include "soft_body/response/position_constraints.h"

/// Bullet moves rigid bodies before it solves anchors, so what these add to velocities moves a body in the next step
/// only. A contact that stops the motion of this step would stop it a second time: a load that a rope holds, and that
/// touches something, would swing ever faster. So a load in contact has that motion in this step already.
class qcAnchorPulls
{
  public:
    /// Call it before and after Bullet solves the anchors.
    void Begin(const btAlignedObjectArray<btSoftBody*>& bodies);
    void End(btScalar timeStep);
    /// Moves the bodies of these constraints by what anchors have added to their velocities, each once in a step. The
    /// motion gives no velocity.
    void Move(const std::vector<qcSoftConstraint>& constraints);

  private:
    struct Load
    {
        const btRigidBody* body;
        qcRigidDisplacement by; ///< between Begin and End: the velocities before
    };

    std::vector<Load> m_loads; ///< that have not been moved in this step
};

#endif
